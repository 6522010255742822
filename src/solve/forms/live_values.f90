!> Values of the iterate at the live candidates, the only ones that an iteration of the condensed
!! form moves: what belongs to all nodes or equations is read and written there alone.
module live_values
  use kinds, only: wp
  use condensed_types, only: condensed_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: clear_values, gather_condensed, take_condensed, begin_trials, try_live, take_live, &
    live_direction_norm, live_direction_work

contains

  !> Other candidates are live: residual and direction are zero elsewhere.
  subroutine clear_values(form)
    type(form_t), intent(inout) :: form !! right and solution become zero

    form%right = 0.0_wp
    form%solution = 0.0_wp
  end subroutine clear_values

  !> Residual of the live candidates: what the bulk bears less what the elements give.
  subroutine gather_condensed(system, form, length)
    type(system_t), intent(in) :: system !! contact_force given
    type(form_t), intent(inout) :: form !! gets right
    real(wp), intent(in) :: length !! share of the direction
    integer :: i

    associate (condensed => form%condensed)
      condensed%bulk%defect_share = 1.0_wp - length
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          condensed%alive%right(i) = condensed%bulk%force(c) + &
            length*condensed%bulk%force_change(c) &
            - system%contact_force(condensed%direction(c), condensed%node(c))
          form%right(system%equation(condensed%direction(c), condensed%node(c))) = &
            condensed%alive%right(i)
        end associate
      end do
    end associate
  end subroutine gather_condensed

  !> Moves forces and defects along the direction.
  subroutine take_condensed(condensed, length)
    type(condensed_t), intent(inout) :: condensed !! force and defect are moved
    real(wp), intent(in) :: length !! share of the direction

    condensed%bulk%force = condensed%bulk%force + length*condensed%bulk%force_change
    condensed%bulk%defect = (1.0_wp - length)*condensed%bulk%defect
    condensed%bulk%defect_norm = (1.0_wp - length)*condensed%bulk%defect_norm
    condensed%bulk%defect_share = 1.0_wp
    if (condensed%rigid%modes == 0) return
    condensed%rigid%alpha = condensed%rigid%alpha + length*condensed%rigid%alpha_change
    condensed%rigid%imbalance = condensed%rigid%imbalance + length*condensed%rigid%imbalance_change
  end subroutine take_condensed

  !> A direction has been found: its trials begin where the iterate is.
  subroutine begin_trials(u, trial)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    real(wp), intent(inout) :: trial(:, :) !! (3, nodes) displacements of the trial [length]

    trial = u
  end subroutine begin_trials

  !> A trial along the direction.
  subroutine try_live(system, form, length)
    type(system_t), intent(in) :: system !! u, du given; trial is that of other nodes before
    type(form_t), intent(inout) :: form !! condensed, du given; gets trial
    real(wp), intent(in) :: length !! share of du
    integer :: i

    associate (condensed => form%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          associate (k => condensed%direction(c), node => condensed%node(c))
            form%trial(k, node) = system%u(k, node) + length*form%du(k, node)
          end associate
        end associate
      end do
    end associate
  end subroutine try_live

  !> Moves the iterate to the trial.
  subroutine take_live(u, form)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(form_t), intent(in) :: form !! condensed, trial
    integer :: i

    associate (condensed => form%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          u(condensed%direction(c), condensed%node(c)) = &
            form%trial(condensed%direction(c), condensed%node(c))
        end associate
      end do
    end associate
  end subroutine take_live

  !> Norm of the direction.
  pure real(wp) function live_direction_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! solution given
    type(form_t), intent(in) :: form !! condensed, du, solution

    norm = norm2(live_solution(form))
    if (system%tools%unknowns > 0) norm = hypot(norm, norm2(form%solution(system%equations + 1:)))
  end function live_direction_norm

  !> Work of the residual on the direction.
  pure real(wp) function live_direction_work(system, form) result(work)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right and solution given

    work = dot_product(form%condensed%alive%right, live_solution(form))
    if (system%tools%unknowns > 0) work = work + dot_product( &
      form%right(system%equations + 1:), form%solution(system%equations + 1:))
  end function live_direction_work

  !> The direction at the live candidates.
  pure function live_solution(form) result(values)
    type(form_t), intent(in) :: form !! du given
    real(wp) :: values(form%condensed%alive%n_live)
    integer :: i

    associate (condensed => form%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          values(i) = form%du(condensed%direction(c), condensed%node(c))
        end associate
      end do
    end associate
  end function live_solution
end module live_values
