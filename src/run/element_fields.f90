!> Stresses and strains of the elements at an end time, a few elements at a time: of their states
!! only what is wanted is kept.
module element_fields
  use kinds, only: wp
  use solid_types, only: n_solid_state, state_stress, state_strain
  use system_types, only: system_t, state_t
  use audit_types, only: audit_t
  use model_types, only: model_t
  use body_fields, only: fields_of_bodies, n_body_fields
  use results_file, only: fields_due
  use ranks, only: this_rank
  use bulk_assembly, only: recover_bulk
  use nodal_dilatation, only: add_nodal_pressure
  use field_audit, only: audit_fields
  implicit none
  private
  public :: recover_fields, find_element_fields

  !> Elements at a time.
  integer, parameter :: portion = 4096

contains

  !> Fields of the elements where they are due, for the audit at the last end time, too.
  subroutine recover_fields(model, system, state, last, stress, strain, audit)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! elements
    type(state_t), intent(in) :: state !! the converged state
    logical, intent(in) :: last !! it is the last end time
    real(wp), allocatable, intent(inout) :: stress(:, :) !! (6, elements) if it is to be written
    real(wp), allocatable, intent(inout) :: strain(:, :) !! (6, elements) likewise
    type(audit_t), intent(inout) :: audit !! looks at them
    logical :: due(n_body_fields)

    due = model%output%field .and. fields_of_bodies%of_elements .and. &
      fields_due(model%output, state%step)
    if (.not. (any(due) .or. last)) return
    if (allocated(stress)) deallocate (stress)
    if (allocated(strain)) deallocate (strain)
    if (this_rank() > 0) due = .false.
    if (any(due .and. fields_of_bodies%word == 'stress')) allocate (stress(6, system%bulk%n))
    if (any(due .and. fields_of_bodies%word == 'strain')) allocate (strain(6, system%bulk%n))
    call find_element_fields(system, model%mesh%x, state%u, stress, strain, audit)
  end subroutine recover_fields

  !> What is asked for, of all elements; their strains and rotations to the audit.
  subroutine find_element_fields(system, x, u, stress, strain, audit)
    type(system_t), intent(in) :: system !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), allocatable, intent(inout), optional :: stress(:, :) !! (6, elements) if allocated
    real(wp), allocatable, intent(inout), optional :: strain(:, :) !! (6, elements) if allocated
    type(audit_t), intent(inout), optional :: audit !! gets values, worst, verdicts
    real(wp) :: state(n_solid_state, min(portion, system%bulk%n))
    integer :: first, last

    do first = 1, system%bulk%n, portion
      last = min(first + portion - 1, system%bulk%n)
      associate (some => state(:, :last - first + 1))
        call recover_bulk(system%bulk, x, u, first, some)
        if (present(audit)) call audit_fields(system%bulk, first, some, audit)
        if (is_wanted(stress)) stress(:, first:last) = some(state_stress, :)
        if (is_wanted(strain)) strain(:, first:last) = some(state_strain, :)
      end associate
    end do
    if (is_wanted(stress)) call add_nodal_pressure(x, u, system, stress)
  end subroutine find_element_fields

  !> A field is there to be filled.
  pure logical function is_wanted(field)
    real(wp), allocatable, intent(in), optional :: field(:, :) !! (components, elements)

    is_wanted = .false.
    if (present(field)) is_wanted = allocated(field)
  end function is_wanted
end module element_fields
