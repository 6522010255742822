!> Derivatives as a part of the state that a run goes on from (doc/theory, "Sensitivities along the
!! path").
module kept_slopes
  use, intrinsic :: iso_fortran_env, only: int64
  use errors, only: error_t, raise, exit_deck
  use checksums, only: block_sum
  use model_types, only: model_t
  use linear_answers, only: answers_t
  use lever_sums, only: contact_nodes
  use sensitivity_start, only: remember_points
  use sensitivity_types, only: sensitivity_t
  use system_types, only: state_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: announce_slopes, keep_slopes, resume_slopes

contains

  !> Says how many derivatives states have.
  subroutine announce_slopes(points, s, model)
    integer, intent(in) :: points !! contact points of all pairs
    type(sensitivity_t), intent(in) :: s !! parameters
    type(model_t), intent(inout) :: model !! gets slopes of its output

    associate (nodes => size(contact_nodes(model)), n => size(s%slopes))
      model%output%slopes = [points*n, nodes*n, nodes]
    end associate
  end subroutine announce_slopes

  !> A sum over the names of the parameters.
  pure function mark_of(s) result(mark)
    type(sensitivity_t), intent(in) :: s !! parameters
    integer :: mark(2)
    integer(int64) :: sum
    integer :: j

    sum = 0_int64
    do j = 1, size(s%slopes)
      sum = ieor(sum, block_sum(s%slopes(j)%name, [j]))
    end do
    mark = transfer(sum, mark)
  end function mark_of

  !> The derivatives to the state that they belong to.
  subroutine keep_slopes(model, s, state)
    type(model_t), intent(in) :: model !! pairs
    type(sensitivity_t), intent(in) :: s !! derivatives at the last state
    type(state_t), intent(inout) :: state !! gets slopes
    integer :: k, j, n

    associate (nodes => contact_nodes(model), slopes => state%slopes)
      n = size(nodes)
      slopes%mark = mark_of(s)
      slopes%apex = reshape(s%dtip, [2, size(s%dtip, 2)*size(s%dtip, 3)])
      slopes%place = reshape(s%du(:, nodes, :), [3, n*size(s%slopes)])
      slopes%force = reshape(s%force(:, nodes, :), [3, n*size(s%slopes)])
      if (.not. allocated(slopes%late)) allocate (slopes%late(n))
      slopes%late = 0
      if (.not. allocated(s%answers%late)) return
      do k = 1, n
        do j = 1, 3
          if (s%answers%late(j, nodes(k))) slopes%late(k) = slopes%late(k) + 2**(j - 1)
        end do
      end do
    end associate
  end subroutine keep_slopes

  !> Goes on from the derivatives of a state.
  subroutine resume_slopes(path, model, place, state, s, error)
    character(*), intent(in) :: path !! the file that the state is from
    type(model_t), intent(in) :: model !! pairs with their history
    type(contact_places_t), intent(in) :: place !! where each pair begins
    type(state_t), intent(in) :: state !! with its slopes
    type(sensitivity_t), intent(inout) :: s !! parameters given; gets its state
    type(error_t), allocatable, intent(out) :: error !! not the derivatives of this deck
    type(answers_t) :: none
    integer :: j, n
    logical :: fits

    if (.not. allocated(state%slopes%apex)) then
      call raise(error, exit_deck, 'error: the state in '//path//' holds no derivatives, and '// &
        'SENSitivity wants those of the whole path'//new_line('a')// &
        '  give the run that writes it the same SENSitivity (or --sens), or leave it out here')
      return
    end if
    n = size(s%slopes)
    associate (slopes => state%slopes, nodes => contact_nodes(model))
      fits = all(slopes%mark == mark_of(s)) .and. size(slopes%apex, 2) == size(s%dtip, 2)*n &
        .and. size(slopes%late) == size(nodes)
      if (.not. fits) then
        call raise(error, exit_deck, 'error: the state in '//path//' holds derivatives by '// &
          'other parameters than SENSitivity asks for here'//new_line('a')// &
          '  ask for the same ones in the same order as the run that wrote it')
        return
      end if
      s%dtip = reshape(slopes%apex, shape(s%dtip))
      s%du(:, nodes, :) = reshape(slopes%place, [3, size(nodes), n])
      s%force(:, nodes, :) = reshape(slopes%force, [3, size(nodes), n])
      s%answers = none
      allocate (s%answers%late(3, size(s%du, 2)), source=.false.)
      do j = 1, 3
        s%answers%late(j, nodes) = btest(slopes%late, j - 1)
      end do
    end associate
    call remember_points(model, place, s)
  end subroutine resume_slopes
end module kept_slopes
