!> Stresses and strains of the elements at an end time, a few elements at a time: of their states
!! only what is wanted is kept.
module element_fields
  use kinds, only: wp
  use solid_types, only: n_solid_state, state_stress, state_strain
  use system_types, only: system_t
  use audit_types, only: audit_t
  use bulk_assembly, only: recover_bulk
  use nodal_dilatation, only: add_nodal_pressure
  use field_audit, only: audit_fields
  implicit none
  private
  public :: find_element_fields

  !> Elements at a time.
  integer, parameter :: portion = 4096

contains

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
