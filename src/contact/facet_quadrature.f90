!> Quadrature on triangles: the points of a slave facet (doc/theory, "Quadrature points", eq.
!! (6.2)).
module facet_quadrature
  use kinds, only: wp
  use text, only: to_text
  implicit none
  private
  public :: has_rule, list_rules, make_rule

  !> Numbers of points of the symmetric rules, of degree 1, 2, 4, 5 and 6.
  integer, parameter :: symmetric_rules(5) = [1, 3, 6, 7, 12]
  !> Further rules cut the facet into n^2 equal triangles with three points each: n from 3 on.
  integer, parameter :: least_cut = 3
  !> The finest of them.
  integer, parameter :: most_cut = 6
  !> Points of the rule of degree 2, which the others are built on as well.
  integer, parameter :: cell_points = 3

contains

  !> There is a rule with this number of points.
  pure logical function has_rule(points)
    integer, intent(in) :: points !! points of a facet

    has_rule = any(symmetric_rules == points) .or. cut_of(points) > 0
  end function has_rule

  !> The n of a rule of 3 n^2 points, 0 if there is none.
  pure integer function cut_of(points) result(n)
    integer, intent(in) :: points !! points of a facet

    do n = most_cut, least_cut, -1
      if (points == cell_points*n**2) return
    end do
    n = 0
  end function cut_of

  !> The numbers of points that can be asked for, in words.
  pure function list_rules() result(t)
    character(:), allocatable :: t
    integer :: i

    t = ''
    do i = 1, size(symmetric_rules)
      t = t//to_text(symmetric_rules(i))//', '
    end do
    do i = least_cut, most_cut - 1
      t = t//to_text(cell_points*i**2)//', '
    end do
    t(len(t) - 1:) = ' o'
    t = t//'r '//to_text(cell_points*most_cut**2)
  end function list_rules

  !> Shape functions at the points of a rule, and shares of the area, which sum up to 1.
  pure subroutine make_rule(points, shapes, shares)
    integer, intent(in) :: points !! points of a facet, of a rule that there is
    real(wp), intent(out) :: shapes(3, points) !! shape functions of the corners
    real(wp), intent(out) :: shares(points) !! of the area

    select case (points)
    case (1)
      shapes = 1.0_wp/3.0_wp
      shares = 1.0_wp
    case (3)
      call take_three(1.0_wp/6.0_wp, 1.0_wp/3.0_wp, shapes, shares)
    case (6)
      call degree_four(shapes, shares)
    case (7)
      call degree_five(shapes, shares)
    case (12)
      call degree_six(shapes, shares)
    case default
      call cut_facet(cut_of(points), shapes, shares)
    end select
  end subroutine make_rule

  !> Three points with two equal shape functions a.
  pure subroutine take_three(a, share, shapes, shares)
    real(wp), intent(in) :: a !! the two
    real(wp), intent(in) :: share !! of the area, each
    real(wp), intent(out) :: shapes(3, 3) !! shape functions
    real(wp), intent(out) :: shares(3) !! share, three times
    integer :: i

    shapes = a
    do i = 1, 3
      shapes(i, i) = 1.0_wp - 2.0_wp*a
    end do
    shares = share
  end subroutine take_three

  !> Six points, exact for polynomials of degree 4; both orbits in closed form.
  pure subroutine degree_four(shapes, shares)
    real(wp), intent(out) :: shapes(3, 6) !! shape functions
    real(wp), intent(out) :: shares(6) !! shares of the area
    real(wp) :: root, middle, half, share

    root = sqrt(10.0_wp)
    middle = (8.0_wp - root)/18.0_wp
    half = sqrt(38.0_wp - 44.0_wp*sqrt(0.4_wp))/18.0_wp
    share = sqrt(213125.0_wp - 53320.0_wp*root)/3720.0_wp
    call take_three(middle + half, 1.0_wp/6.0_wp + share, shapes(:, 1:3), shares(1:3))
    call take_three(middle - half, 1.0_wp/6.0_wp - share, shapes(:, 4:6), shares(4:6))
  end subroutine degree_four

  !> Seven points, exact for polynomials of degree 5, in closed form.
  pure subroutine degree_five(shapes, shares)
    real(wp), intent(out) :: shapes(3, 7) !! shape functions
    real(wp), intent(out) :: shares(7) !! shares of the area
    real(wp) :: root

    root = sqrt(15.0_wp)
    call take_three((6.0_wp - root)/21.0_wp, (155.0_wp - root)/1200.0_wp, shapes(:, 1:3), &
      shares(1:3))
    call take_three((6.0_wp + root)/21.0_wp, (155.0_wp + root)/1200.0_wp, shapes(:, 4:6), &
      shares(4:6))
    shapes(:, 7) = 1.0_wp/3.0_wp
    shares(7) = 9.0_wp/40.0_wp
  end subroutine degree_five

  !> Twelve points, exact for polynomials of degree 6: orbits that solve the moment equations.
  pure subroutine degree_six(shapes, shares)
    real(wp), intent(out) :: shapes(3, 12) !! shape functions
    real(wp), intent(out) :: shares(12) !! shares of the area
    real(wp), parameter :: b = 0.053145049844816947353_wp, c = 0.310352451033784405417_wp
    real(wp) :: n(3)
    integer :: i

    call take_three(0.249286745170910421292_wp, 0.116786275726379366025_wp, shapes(:, 1:3), &
      shares(1:3))
    call take_three(0.063089014491502228340_wp, 0.050844906370206816921_wp, shapes(:, 4:6), &
      shares(4:6))
    n = [b, c, 1.0_wp - b - c]
    do i = 1, 3
      shapes(:, 6 + i) = cshift(n, i)
      shapes(:, 9 + i) = cshift(n([2, 1, 3]), i)
    end do
    shares(7:12) = 0.082851075618373575193_wp
  end subroutine degree_six

  !> Three points on each of n^2 equal triangles.
  pure subroutine cut_facet(n, shapes, shares)
    integer, intent(in) :: n !! triangles along an edge
    real(wp), intent(out) :: shapes(:, :) !! (3, 3 n^2) shape functions
    real(wp), intent(out) :: shares(:) !! (3 n^2) shares of the area
    real(wp) :: cell(3, cell_points), corner(3)
    integer :: i, j, k, last

    call take_three(1.0_wp/6.0_wp, 1.0_wp/3.0_wp, cell, shares(1:cell_points))
    shares = 1.0_wp/real(size(shares), wp)
    last = 0
    do j = 0, n - 1
      do i = 0, n - 1 - j
        corner = real([i, j, n - 1 - i - j], wp)
        do k = 1, cell_points
          shapes(:, last + k) = (corner + cell(:, k))/real(n, wp)
        end do
        last = last + cell_points
        if (i + j > n - 2) cycle
        ! the triangle upside down between this one and its neighbours
        do k = 1, cell_points
          shapes(:, last + k) = (corner + [1.0_wp, 1.0_wp, 0.0_wp] - cell(:, k))/real(n, wp)
        end do
        last = last + cell_points
      end do
    end do
  end subroutine cut_facet
end module facet_quadrature
