!> Whether elements of ten nodes have a shape that can be computed with: the Jacobian of a curved
!! element must be positive at its corners and at the points of its integrals, and should be
!! everywhere (doc/theory, "Ten-node tetrahedron").
module curved_checks
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t
  use diagnostics, only: diagnostics_t, report_error, report_note
  use vectors, only: cross
  use cell_geometry, only: point_towards, shares_of_points
  use cells, only: tet10, has_middles
  use mesh_types, only: mesh_t
  use mesh_building, only: element_origin_t
  implicit none
  private
  public :: check_curved, jacobian_bounds

  !> Folded elements of one data set that are reported one by one.
  integer, parameter :: most_errors = 5
  !> Jacobians below this share of the largest at a corner are none.
  real(wp), parameter :: no_jacobian = 1.0e-12_wp

contains

  !> Refuses elements that are folded at a corner or at a point of their integrals, and notes those
  !! that may be folded between.
  subroutine check_curved(deck, origin, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: folded(size(deck%mesh)), doubtful(size(deck%mesh)), first(size(deck%mesh)), e, s
    integer :: corner
    real(wp) :: at_corners(4), least
    character(:), allocatable :: where_folded

    folded = 0
    doubtful = 0
    first = 0
    do e = 1, mesh%elements
      if (.not. has_middles(mesh%ix(:, e))) cycle
      s = origin%set(e)
      call jacobian_bounds(mesh%x(:, mesh%ix(:, e)), at_corners, least)
      corner = minloc(at_corners, 1)
      where_folded = ''
      if (at_corners(corner) <= no_jacobian*maxval(abs(at_corners))) then
        where_folded = 'at its corner '//to_text(mesh%ix(corner, e))
      else if (least <= 0.0_wp) then
        if (least_at_points(mesh%x(:, mesh%ix(:, e))) <= no_jacobian*maxval(abs(at_corners))) &
          where_folded = 'inside'
      end if
      if (len(where_folded) > 0) then
        folded(s) = folded(s) + 1
        if (folded(s) <= most_errors) call report_error(diagnostics, deck%mesh(s)%head%at, &
          'element '//to_text(e)//' of ten nodes is folded '//where_folded, 'move its nodes 5 '// &
          'to 10 towards the middles of their edges, or mesh finer there')
      else if (least <= 0.0_wp) then
        doubtful(s) = doubtful(s) + 1
        if (doubtful(s) == 1) first(s) = e
      end if
    end do
    do s = 1, size(deck%mesh)
      if (doubtful(s) > 0) call report_note(diagnostics, deck%mesh(s)%head%at, &
        count_noun(doubtful(s), 'element')//' of ten nodes may be folded inside, the first is '// &
        'element '//to_text(first(s)))
    end do
  end subroutine check_curved

  !> Jacobian at the corners, and the least of its Bernstein coefficients: it is nowhere less.
  pure subroutine jacobian_bounds(x, at_corners, least)
    real(wp), intent(in) :: x(3, 10) !! positions of the nodes [length]
    real(wp), intent(out) :: at_corners(4) !! det dx/dxi [length^3]
    real(wp), intent(out) :: least !! lower bound [length^3]
    real(wp) :: d(3, 3, 4)
    integer :: a, b, c

    do c = 1, 4
      d(:, :, c) = slopes_at(x, c)
      at_corners(c) = mixed(d(:, :, c), d(:, :, c), d(:, :, c))
    end do
    least = minval(at_corners)
    do a = 1, 4
      do b = 1, 4
        if (b == a) cycle
        least = min(least, (mixed(d(:, :, a), d(:, :, a), d(:, :, b)) + mixed(d(:, :, a), &
          d(:, :, b), d(:, :, a)) + mixed(d(:, :, b), d(:, :, a), d(:, :, a)))/3.0_wp)
        do c = b + 1, 4
          if (c == a .or. b < a) cycle
          least = min(least, all_mixed(d(:, :, a), d(:, :, b), d(:, :, c)))
        end do
      end do
    end do
  end subroutine jacobian_bounds

  !> The least Jacobian at the points of the integrals of a curved element; slopes are linear
  !! between the corners.
  pure real(wp) function least_at_points(x) result(least)
    real(wp), intent(in) :: x(3, 10) !! positions of the nodes [length]
    real(wp) :: d(3, 3), l(4), share(2)
    integer :: i, k, c

    least = huge(1.0_wp)
    share = shares_of_points()
    do i = 1, 4
      do k = 1, 2
        l = point_towards(i, share(k))
        d = 0.0_wp
        do c = 1, 4
          d = d + l(c)*slopes_at(x, c)
        end do
        least = min(least, mixed(d, d, d))
      end do
    end do
  end function least_at_points

  !> dx/dxi at a corner: the slopes of the shape functions of ten nodes there.
  pure function slopes_at(x, c) result(d)
    real(wp), intent(in) :: x(3, 10) !! positions of the nodes [length]
    integer, intent(in) :: c !! the corner
    real(wp) :: d(3, 3), by_l(3, 4)
    integer :: a, m

    ! dx/dL_a at L = corner c: (4 delta_ac - 1) x_a + 4 sum over edges ca of x_ca
    do a = 1, 4
      by_l(:, a) = merge(3.0_wp, -1.0_wp, a == c)*x(:, a)
      do m = 5, 10
        if (a == c) cycle
        if (any(tet10%ends(:, m) == a) .and. any(tet10%ends(:, m) == c)) by_l(:, a) = by_l(:, a) &
          + 4.0_wp*x(:, m)
      end do
    end do
    do a = 1, 3
      d(:, a) = by_l(:, a + 1) - by_l(:, 1)
    end do
  end function slopes_at

  !> Determinant with one column from each of three matrices.
  pure real(wp) function mixed(a, b, c)
    real(wp), intent(in) :: a(3, 3) !! gives column 1
    real(wp), intent(in) :: b(3, 3) !! gives column 2
    real(wp), intent(in) :: c(3, 3) !! gives column 3

    mixed = dot_product(a(:, 1), cross(b(:, 2), c(:, 3)))
  end function mixed

  !> Mean of the six determinants with one column from each of three matrices.
  pure real(wp) function all_mixed(a, b, c)
    real(wp), intent(in) :: a(3, 3) !! a matrix
    real(wp), intent(in) :: b(3, 3) !! another
    real(wp), intent(in) :: c(3, 3) !! another

    all_mixed = (mixed(a, b, c) + mixed(a, c, b) + mixed(b, a, c) + mixed(b, c, a) &
      + mixed(c, a, b) + mixed(c, b, a))/6.0_wp
  end function all_mixed
end module curved_checks
