!> Steps with the same factor learn from those before them: Broyden's method with the steps alone
!! (doc/theory, "Modified Newton steps", eq. (11.6)).
module secant_steps
  use kinds, only: wp
  use equation_values, only: spread_direction
  use bulk_term, only: form_bulk_change
  use system_types, only: system_t
  implicit none
  private
  public :: secants_t, begin_secants, bend_direction, note_step

  !> Full steps that one factor has led to, each with all that changes along it.
  type :: secants_t
    integer :: n = 0 !! steps
    real(wp), allocatable :: step(:, :) !! (values, most) directions
    real(wp), allocatable :: weight(:) !! (values) squared, of each value in a length
    real(wp), allocatable :: square(:) !! (most) squared lengths of the steps
  end type secants_t

  !> A direction is not stretched beyond this.
  real(wp), parameter :: most_stretch = 5.0_wp

contains

  !> Makes room for the steps of one factor.
  subroutine begin_secants(system, most, secants)
    type(system_t), intent(in) :: system !! direction given
    integer, intent(in) :: most !! steps
    type(secants_t), intent(out) :: secants !! empty

    secants%weight = weights(system)
    allocate (secants%step(size(secants%weight), most), secants%square(most))
  end subroutine begin_secants

  !> Bends the direction of the factor by what the steps so far have shown.
  subroutine bend_direction(secants, system, found)
    type(secants_t), intent(in) :: secants !! steps so far
    type(system_t), intent(inout) :: system !! direction of the factor; out: the bent one
    logical, intent(out) :: found !! there is one
    real(wp) :: z(size(secants%weight)), rest
    integer :: j

    found = .true.
    if (secants%n == 0) return
    z = packed(system)
    do j = 1, secants%n - 1
      z = z + secants%step(:, j + 1)*(sum(secants%weight*secants%step(:, j)*z)/secants%square(j))
    end do
    rest = 1.0_wp - sum(secants%weight*secants%step(:, secants%n)*z)/secants%square(secants%n)
    found = rest*most_stretch >= 1.0_wp
    if (found) call unpack_direction(z/rest, system)
  end subroutine bend_direction

  !> The direction has been gone.
  subroutine note_step(system, secants)
    type(system_t), intent(in) :: system !! its direction
    type(secants_t), intent(inout) :: secants !! one more

    if (secants%n == size(secants%square)) return
    secants%n = secants%n + 1
    secants%step(:, secants%n) = packed(system)
    secants%square(secants%n) = sum(secants%weight*secants%step(:, secants%n)**2)
    if (secants%square(secants%n) <= 0.0_wp) secants%n = secants%n - 1
  end subroutine note_step

  !> All that changes along the direction.
  pure function packed(system) result(values)
    type(system_t), intent(in) :: system !! direction given
    real(wp), allocatable :: values(:)

    if (system%condensed%active) then
      associate (condensed => system%condensed)
        values = [condensed%alive%change, condensed%bulk%force_change(condensed%alive%live)]
        if (condensed%rigid%modes > 0) values = [values, condensed%rigid%alpha_change, &
          condensed%rigid%imbalance_change]
      end associate
    else
      values = system%solution
    end if
    if (system%motion%active) values = [values, system%motion%way]
  end function packed

  !> Squared weights: displacements count, and what multipliers shift.
  pure function weights(system) result(values)
    type(system_t), intent(in) :: system !! direction given
    real(wp), allocatable :: values(:)
    integer :: k

    if (system%condensed%active) then
      associate (n => system%condensed%alive%n_live, modes => system%condensed%rigid%modes)
        allocate (values(2*(n + modes)), source=0.0_wp)
        values(:n) = 1.0_wp
      end associate
    else
      allocate (values(size(system%solution)), source=1.0_wp)
    end if
    if (.not. system%motion%active) return
    values = [values, [(spread(system%motion%scale(k)**2, 1, 3), k=1, system%contact%n)]]
  end function weights

  !> The direction from all that changes along it.
  subroutine unpack_direction(values, system)
    real(wp), intent(in) :: values(:) !! as packed
    type(system_t), intent(inout) :: system !! gets the direction
    integer :: i, n

    if (system%condensed%active) then
      associate (condensed => system%condensed)
        n = condensed%alive%n_live
        condensed%alive%change = values(:n)
        condensed%bulk%force_change(condensed%alive%live) = values(n + 1:2*n)
        do i = 1, n
          associate (c => condensed%alive%live(i))
            system%du(condensed%direction(c), condensed%node(c)) = values(i)
            system%solution(system%equation(condensed%direction(c), condensed%node(c))) = values(i)
          end associate
        end do
        n = 2*n
        if (condensed%rigid%modes > 0) then
          condensed%rigid%alpha_change = values(n + 1:n + condensed%rigid%modes)
          condensed%rigid%imbalance_change = values(n + condensed%rigid%modes + 1: &
            n + 2*condensed%rigid%modes)
        end if
      end associate
    else
      system%solution = values(:size(system%solution))
      call spread_direction(system)
      call form_bulk_change(system)
    end if
    if (system%motion%active) system%motion%way = reshape(values(size(values) - 3* &
      system%contact%n + 1:), [3, system%contact%n])
  end subroutine unpack_direction
end module secant_steps
