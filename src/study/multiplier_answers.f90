!> The linear system of an increment that has been accepted, with multipliers that are the forces of
!! their points (doc/theory, "Sensitivities along the path").
module multiplier_answers
  use kinds, only: wp
  use model_types, only: model_t
  use block_gmres, only: block_gmres_t, begin_block, add_images, block_shares, lengths
  use increment_elements, only: work_t
  use multiplier_slopes, only: shifts_wanted, shifts_answered, forces_of_shifts, take_shifts
  use increment_answers, only: solve_all, answer_forces
  use full_answers, only: solve_full, answer_full
  use sensitivity_types, only: sensitivity_t
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: solve_increment, rest_candidates

  !> What may be left of the shifts of a parameter, over these.
  real(wp), parameter :: multiplier_residue = 1.0e-13_wp
  !> Steps of GMRES with all columns; and how often what is left is solved for once more.
  integer, parameter :: most_block_steps = 40, most_corrections = 4

contains

  !> Displacements and shifts for all parameters.
  subroutine solve_increment(model, system, form, time, s, work, trouble)
    type(model_t), intent(in) :: model !! reference positions, loads
    type(system_t), intent(inout) :: system !! its tangent and factor
    type(form_t), intent(inout) :: form !! gets border, condensed, matrix
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(inout) :: s !! du at supports given; gets it elsewhere
    type(work_t), intent(inout) :: work !! elements, causes; gets shifts
    character(:), allocatable, intent(inout) :: trouble !! not solved
    real(wp), allocatable :: lack(:, :, :), shifts(:, :, :), wanted(:, :, :)
    real(wp) :: floor(size(s%slopes))
    integer :: turn
    logical :: arrived

    call solve_once(.false.)
    if (work%shifted%n == 0) return
    allocate (shifts(3, work%shifted%n, size(s%slopes)), source=0.0_wp)
    do turn = 1, most_corrections
      if (len(trouble) > 0) return
      wanted = shifts_wanted(work, s%du)
      lack = wanted - shifts
      floor = multiplier_residue*lengths(columns_of(wanted))
      if (all(lengths(columns_of(lack)) <= 10.0_wp*floor)) return
      call close_lack(system, form, s, work, floor, lack, arrived)
      if (.not. arrived) trouble = 'the multipliers of contact find no answer'
      shifts = shifts + lack
      call take_shifts(shifts, work)
      call rest_candidates(form%condensed, s)
      call solve_once(.true.)
    end do

  contains

    !> Displacements for the present shifts.
    subroutine solve_once(again)
      logical, intent(in) :: again !! with the same tangent

      if (s%full) then
        call solve_full(model, system, form, time, s, work, again, trouble)
      else
        call solve_all(model, system, form, time, s, work, trouble)
      end if
    end subroutine solve_once
  end subroutine solve_increment

  !> A block of shifts as a matrix.
  pure function columns_of(shifts) result(columns)
    real(wp), intent(in) :: shifts(:, :, :) !! (3, n, columns)
    real(wp) :: columns(3*size(shifts, 2), size(shifts, 3))

    columns = reshape(shifts, shape(columns))
  end function columns_of

  !> Shifts whose forces ask for what is lacking: GMRES with all parameters together.
  subroutine close_lack(system, form, s, work, floor, lack, arrived)
    type(system_t), intent(in) :: system !! its tangent and factor
    type(form_t), intent(inout) :: form !! gets border, condensed, matrix
    type(sensitivity_t), intent(inout) :: s !! room of the answers
    type(work_t), intent(in) :: work !! elements
    real(wp), intent(in) :: floor(:) !! (parameters) what may be left [length]
    real(wp), intent(inout) :: lack(:, :, :) !! (3, n, parameters) in: what is lacking; out: the
    !! shifts [length]
    logical, intent(out) :: arrived !! all of them
    type(block_gmres_t) :: iteration
    real(wp), allocatable :: base(:, :, :), force(:, :, :), du(:, :, :), image(:, :, :)
    integer :: columns, n

    n = size(lack, 2)
    arrived = .true.
    call begin_block(columns_of(lack), floor, most_block_steps*size(lack, 3), iteration)
    do while (iteration%m > iteration%n .and. arrived)
      columns = iteration%m - iteration%n
      base = reshape(iteration%base(:, iteration%n + 1:iteration%m), [3, n, columns])
      allocate (force(3, size(s%du, 2), columns), du(3, size(s%du, 2), columns))
      call forces_of_shifts(system%contact, work, base, force)
      if (s%full) then
        call answer_full(system, form, force, du, arrived)
      else
        call answer_forces(form%condensed, s, force, du, arrived)
      end if
      image = base - shifts_answered(work, base, du)
      call add_images(columns_of(image), iteration)
      deallocate (force, du)
    end do
    arrived = arrived .and. all(iteration%rest <= iteration%floor)
    lack = reshape(matmul(iteration%base(:, :iteration%n), block_shares(iteration)), shape(lack))
  end subroutine close_lack

  !> Candidates rest until they are solved for.
  subroutine rest_candidates(condensed, s)
    type(condensed_t), intent(in) :: condensed !! condensed, or not
    type(sensitivity_t), intent(inout) :: s !! gets du
    integer :: i

    do i = 1, condensed%n
      s%du(condensed%direction(i), condensed%node(i), :) = 0.0_wp
    end do
  end subroutine rest_candidates
end module multiplier_answers
