!> Strain and rotation of the elements: how far small strain is left (doc/theory, "Strain and
!! rotation").
module field_audit
  use kinds, only: wp, pi
  use lapack_interface, only: dsyev
  use element_types, only: routine_none, routine_finite
  use element_lists, only: bulk_list_t
  use solid_types, only: state_strain, state_rotation
  use audit_types, only: audit_t, verdict_ok, verdict_warning, check_strain, check_rotation
  implicit none
  private
  public :: audit_fields, most_rotation

  !> Strain, and rotation of an element or of a body [degree], beyond which small strain is left.
  real(wp), parameter :: most_strain = 0.03_wp
  real(wp), parameter :: most_rotation = 2.0_wp

contains

  !> Largest principal strain and largest rotation of an element: those of some elements against
  !! the values so far, which begin with the first element.
  subroutine audit_fields(bulk, first, state, audit)
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    integer, intent(in) :: first !! the first of these elements
    real(wp), intent(in) :: state(:, :) !! (n_solid_state, some) their states
    type(audit_t), intent(inout) :: audit !! gets values, worst, verdicts
    integer, parameter :: strain_checks(2) = [check_strain, check_rotation]
    real(wp) :: largest, turn
    integer :: i, k

    if (first == 1) audit%worst(strain_checks) = 0
    if (first == 1) audit%value(strain_checks) = 0.0_wp
    largest = audit%value(check_strain)
    turn = (audit%value(check_rotation)*pi/180.0_wp)**2
    do i = 1, size(state, 2)
      k = first + i - 1
      if (any(bulk%routine(k) == [routine_none, routine_finite])) cycle
      ! no principal strain is larger than the norm: few elements are worth their eigenvalues
      associate (strain => state(state_strain, i), turned => state(state_rotation, i))
        if (norm_squared(strain) > largest**2) then
          associate (principal => principal_strain(strain))
            if (principal > largest) audit%worst(check_strain) = k
            largest = max(largest, principal)
          end associate
        end if
        associate (squared => dot_product(turned, turned))
          if (squared > turn) audit%worst(check_rotation) = k
          turn = max(turn, squared)
        end associate
      end associate
    end do
    audit%value(strain_checks) = [largest, sqrt(turn)*180.0_wp/pi]
    audit%verdict(strain_checks) = merge(verdict_warning, verdict_ok, &
      audit%value(strain_checks) > [most_strain, most_rotation])
    audit%fields_known = .true.
  end subroutine audit_fields

  !> Square of the norm of a strain.
  pure real(wp) function norm_squared(strain)
    real(wp), intent(in) :: strain(6) !! xx yy zz xy yz zx, shear half of gamma

    norm_squared = dot_product(strain(1:3), strain(1:3)) + 2.0_wp*dot_product(strain(4:6), &
      strain(4:6))
  end function norm_squared

  !> Largest magnitude of a principal strain.
  real(wp) function principal_strain(strain) result(largest)
    real(wp), intent(in) :: strain(6) !! xx yy zz xy yz zx, shear half of gamma
    real(wp) :: a(3, 3), values(3), work(20)
    integer :: info

    a = reshape(strain([1, 4, 6, 4, 2, 5, 6, 5, 3]), [3, 3])
    call dsyev('N', 'U', 3, a, 3, values, work, size(work), info)
    largest = norm2(strain([1, 2, 3, 4, 5, 6, 4, 5, 6]))
    if (info == 0) largest = maxval(abs(values))
  end function principal_strain
end module field_audit
