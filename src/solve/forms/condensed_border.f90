!> Rigid bodies with a point in the condensed form: their unknowns are a border of contact's tangent
!! (doc/theory, "Condensed rigid bodies", eq. (12.15)).
module condensed_border
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs, dgesvd
  use condensed_types, only: condensed_t
  use rigid_border, only: motion_of, turning_of, hold_of
  use supports, only: unresisted
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: form_points, factorise_points, add_points

contains

  !> Rows, columns and corner of the unknowns, from the element matrices and from what acts on the
  !! nodes of the bodies.
  subroutine form_points(system, form)
    type(system_t), intent(in) :: system !! element matrices of condensed
    type(form_t), intent(inout) :: form !! gets points
    integer :: place(size(system%equation, 2)), b, e, i, live

    associate (points => form%condensed%points, tools => system%tools)
      points%n = tools%unknowns
      points%known = .false.
      if (points%n == 0) return
      live = form%condensed%alive%n_live
      points%columns = reshape([real(wp) ::], [live, points%n], [0.0_wp])
      points%rows = points%columns
      points%corner = reshape([real(wp) ::], [points%n, points%n], [0.0_wp])
      points%asked = spread(0.0_wp, 1, points%n)
      points%change = points%asked
      place = 0
      do b = 1, size(tools%rigid)
        place(tools%rigid(b)%node) = [(i, i=1, size(tools%rigid(b)%node))]
      end do
      do e = 1, form%condensed%tangent%elements
        call add_element(system, form%condensed, place, form%condensed%tangent%element(e))
      end do
      do b = 1, size(tools%rigid)
        associate (first => tools%rigid(b)%first - system%equations + 1, &
          last => tools%rigid(b)%first - system%equations + size(tools%rigid(b)%unknown))
          if (last >= first) points%corner(first:last, first:last) = &
            points%corner(first:last, first:last) + turning_of(system, form, b)
        end associate
      end do
    end associate
  end subroutine form_points

  !> What one contact element adds.
  subroutine add_element(system, condensed, place, element)
    type(system_t), intent(in) :: system !! element matrices of condensed; points grow
    type(condensed_t), intent(inout) :: condensed !! what the condensed form keeps
    integer, intent(in) :: place(:) !! (nodes) which node of its rigid body each is
    integer, intent(in) :: element !! its place in the list
    real(wp), allocatable :: motion(:, :), column(:, :), row(:, :), other(:, :)
    integer :: a, c, body, body_c, first, first_c, i

    associate (list => system%contact, points => condensed%points, dofs => &
      condensed%tangent%dofs(:, element), s => condensed%tangent%s(:, :, element))
      do a = 1, list%nel(element)
        body = system%tools%carried_by(list%ix(a, element))
        if (body == 0) cycle
        motion = motion_of(system, body, place(list%ix(a, element)))
        first = system%tools%rigid(body)%first - system%equations
        column = matmul(s(:, 3*a - 2:3*a), motion)
        row = matmul(transpose(s(3*a - 2:3*a, :)), motion)
        do i = 1, 3*list%nel(element)
          if (dofs(i) == 0) cycle
          associate (columns => points%columns(dofs(i), first + 1:first + size(motion, 2)), &
            rows => points%rows(dofs(i), first + 1:first + size(motion, 2)))
            columns = columns + column(i, :)
            rows = rows + row(i, :)
          end associate
        end do
        do c = 1, list%nel(element)
          body_c = system%tools%carried_by(list%ix(c, element))
          if (body_c == 0) cycle
          other = motion_of(system, body_c, place(list%ix(c, element)))
          first_c = system%tools%rigid(body_c)%first - system%equations
          associate (corner => points%corner(first_c + 1:first_c + size(other, 2), &
            first + 1:first + size(motion, 2)))
            corner = corner + matmul(transpose(other), column(3*c - 2:3*c, :))
          end associate
        end do
      end do
    end associate
  end subroutine add_element

  !> Factorises what the answers to the unknowns leave of the corner. Soft springs hold what contact
  !! hardly resists, and nothing else (doc/theory, "Condensed floating bodies").
  subroutine factorise_points(system, condensed, done)
    type(system_t), intent(in) :: system !! points with their answers; get the factor
    type(condensed_t), intent(inout) :: condensed !! what the condensed form keeps
    logical, intent(out) :: done !! there is one
    real(wp), dimension(condensed%points%n, condensed%points%n) :: a, left, right
    real(wp) :: s(condensed%points%n), hold(condensed%points%n), work(10*condensed%points%n + 64)
    integer :: n, k, rank, info

    associate (points => condensed%points)
      n = points%n
      hold = hold_of(system)
      points%factor = points%corner + matmul(transpose(points%rows), points%way)
      if (system%body%damping > 0.0_wp) then
        do k = 1, n
          points%factor(k, k) = points%factor(k, k) + hold(k)
        end do
      else if (any(hold > 0.0_wp)) then
        a = points%factor
        call dgesvd('A', 'A', n, n, a, n, s, left, n, right, n, work, size(work), info)
        done = info == 0
        if (.not. done) return
        rank = count(s > unresisted*s(1) .and. s > 0.0_wp)
        points%factor = points%factor + matmul(left(:, rank + 1:), matmul(matmul(transpose( &
          left(:, rank + 1:)), spread(hold, 2, n - rank)*transpose(right(rank + 1:, :))), &
          right(rank + 1:, :)))
      end if
      points%pivot = spread(0, 1, n)
      call dgetrf(n, n, points%factor, n, points%pivot, info)
      done = info == 0
      points%known = done
    end associate
  end subroutine factorise_points

  !> The unknowns that belong to an answer of contact which knew nothing of them, and what they add
  !! to it.
  subroutine add_points(condensed, y, t)
    type(condensed_t), intent(inout) :: condensed !! points factorised, asked given; gets change
    real(wp), intent(inout) :: y(:) !! (live) [force]
    real(wp), intent(inout) :: t(:) !! (live) [length]
    real(wp) :: rest(condensed%points%n, 1)
    integer :: info

    associate (points => condensed%points)
      rest(:, 1) = points%asked - matmul(t, points%rows)
      call dgetrs('N', points%n, 1, points%factor, points%n, points%pivot, rest, points%n, info)
      points%change = rest(:, 1)
      y = y + matmul(points%force, points%change)
      t = t + matmul(points%way, points%change)
      if (condensed%rigid%modes > 0) condensed%rigid%alpha_next = condensed%rigid%alpha_next &
        + matmul(points%motion, points%change)
    end associate
  end subroutine add_points
end module condensed_border
