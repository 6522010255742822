!> The friction cone on a facet of six nodes: projection, gap, stick or slip, new apex (doc/theory,
!! "Six-node facets"). Element 6 makes forces and tangent of it.
module facet_cone
  use kinds, only: wp
  use element_types, only: element_t
  use slave_points, only: positions
  use contact_cone, only: leave_open
  use quadratic_facet, only: facet_shapes_t, facet_shapes, projection_t, project_quadratic, &
    facet_bent
  use smooth_patch, only: patch_frame, dual_frame
  use patch_cone, only: cone_t, place_shift, principal_axes, map_trial, solve_ways
  implicit none
  private
  public :: facet_cone_t, place_on_facet, place_axes, along_facet

  !> A step of the new apex below this is its last; and the most steps.
  real(wp), parameter :: last_step = 1.0e-9_wp
  integer, parameter :: most_steps = 30
  !> The new apex is not looked for where the facet is steeper than this against the projection.
  real(wp), parameter :: least_determinant = 0.05_wp

  !> The facet, and the cone on it.
  type, extends(cone_t) :: facet_cone_t
    integer :: shape = facet_bent !! flat, bent or round
    real(wp) :: x(3, 6) = 0.0_wp !! nodes seen from corner 3 [length]
    real(wp) :: s(3) = 0.0_wp !! slave point, likewise [length]
    type(projection_t) :: at !! its projection
  end type facet_cone_t

contains

  !> Projection, gap, and stick or slip; `found` is false where the facet gives no answer.
  pure subroutine place_on_facet(d, e, c, found)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(inout) :: e !! gets status, h2, slip
    type(facet_cone_t), intent(inout) :: c !! shape given; gets all else
    logical, intent(out) :: found !! the facet has an answer
    real(wp) :: x(3, 7)

    x = positions(e, 6)
    c%s = x(:, 1)
    c%x = x(:, 2:7)
    c%f = patch_frame(c%x(:, 1:3))
    c%dual = dual_frame(c%f)
    c%slave = c%s + (e%xl(:, e%slaves + 3) + e%ul(:, e%slaves + 3))
    c%at = project_quadratic(c%x, c%s, c%shape)
    found = c%at%found
    c%xi = c%at%xi
    c%n = c%at%normal
    c%g_n = c%at%gap
    if (.not. found) then
      call leave_open(c%contact_cone_t, e)
      return
    end if
    call place_shift(e%shift, e%offset, c%cone_t)
    c%g = gap_to(c, e%h1)
    if (c%h_n <= 0.0_wp) then
      call place_axes(d, c)
      call map_trial(d, c, e)
      if (c%back%slip) call find_apex(c, found)
      e%h2 = c%apex
    else
      call leave_open(c%contact_cone_t, e)
    end if
  end subroutine place_on_facet

  !> Principal axes of friction. A lay that is carried with the facet goes with the tangents at the
  !! projection.
  pure subroutine place_axes(d, c)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(facet_cone_t), intent(inout) :: c !! gets all of the axes
    real(wp) :: corners(3, 3)

    corners = c%f
    c%f(:, 1:2) = c%at%t
    call principal_axes(d, c%cone_t)
    c%f = corners
  end subroutine place_axes

  !> x_S - x_m at a place of the facet, with the shift.
  pure function gap_to(c, xi) result(g)
    type(facet_cone_t), intent(in) :: c !! facet and slave point
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: g(3)
    type(facet_shapes_t) :: s

    s = facet_shapes(xi, c%shape, c%x)
    g = c%s - matmul(c%x, s%n) + c%k
  end function gap_to

  !> The place from which the gap has the tangential part s' (Newton's method).
  pure subroutine find_apex(c, found)
    type(facet_cone_t), intent(inout) :: c !! gets apex, g_new
    logical, intent(out) :: found !! there is one
    real(wp) :: m(2, 2), det, det_flat, step(2, 1)
    integer :: i

    m = matmul(transpose(c%p), c%f(:, 1:2))
    det_flat = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
    c%apex = c%xi
    found = .false.
    do i = 1, most_steps
      m = apex_matrix(c)
      det = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
      if (.not. det > least_determinant*abs(det_flat)) exit
      step = solve_ways(m, reshape(matmul(gap_to(c, c%apex), c%p) - c%back%s, [2, 1]))
      c%apex = c%apex + step(:, 1)
      if (maxval(abs(step)) > last_step) cycle
      found = .true.
      exit
    end do
    c%g_new = gap_to(c, c%apex)
  end subroutine find_apex

  !> p_i . t_j at the apex.
  pure function apex_matrix(c) result(m)
    type(facet_cone_t), intent(in) :: c !! cone with its apex
    real(wp) :: m(2, 2)
    type(facet_shapes_t) :: s

    s = facet_shapes(c%apex, c%shape, c%x)
    m = matmul(transpose(c%p), matmul(c%x, s%d))
  end function apex_matrix

  !> Ways of the apex in (xi, eta) whose components along the axes of friction are given.
  pure function along_facet(c, way) result(dtip)
    type(facet_cone_t), intent(in) :: c !! cone with its apex
    real(wp), intent(in) :: way(:, :) !! (2, any) along p1 and p2
    real(wp) :: dtip(2, size(way, 2))

    dtip = solve_ways(apex_matrix(c), way)
  end function along_facet
end module facet_cone
