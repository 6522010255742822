!> The linear system of the last increment once more, for many right-hand sides at once
!! (doc/theory, "Sensitivities along the path", eq. (14.2)).
module linear_answers
  use kinds, only: wp
  use block_solves, only: solve_block
  use back_ends, only: solver_done
  use condensed_types, only: condensed_t, contact_tangent_t
  use touched_candidates, only: touched_t, gather_touched, add_product, subtract_leading, &
    subtract_product, subtract_products
  use condensed_direction, only: answer
  use contact_tangent, only: form_element_matrices, factorise_tangent, form_rest, apply_rest
  use contact_sums, only: add_leading, take_shares
  use block_gmres, only: block_gmres_t, begin_block, add_images, block_shares, lengths
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: answers_t, prepare_answers, answer_all

  !> What the last answers have left for the next ones.
  type :: answers_t
    type(touched_t) :: touched !! candidates and their compliances
    type(block_gmres_t) :: iteration !! room of GMRES
    real(wp), allocatable :: share_left(:) !! (columns) what is left of each force, over the force
    logical, allocatable :: late(:, :) !! (3, nodes) displacements that lack what contact does
  end type answers_t

  !> Steps of GMRES with all columns.
  integer, parameter :: most_block_steps = 40
  !> A factor serves again if no more than this share of the elements have changed their status.
  integer, parameter :: changes_share = 20
  !> What is left of a force, over the force, where columns are solved for one by one.
  real(wp), parameter :: accuracy = 1.0e-13_wp
  !> Iterations with blocks.
  integer, parameter :: most_blocked_iterations = 200

contains

  !> Element matrices at the converged state, and a factor: the last one of the increment, or anew.
  subroutine prepare_answers(system, form, x, anew, outcome)
    type(system_t), intent(inout) :: system !! tangent of condensed
    type(form_t), intent(inout) :: form !! its kind given; gets condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: anew !! a new factor in any case
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    logical :: serves

    outcome = solver_done
    call form_element_matrices(system, form, x)
    associate (tangent => form%condensed%tangent)
      serves = allocated(tangent%status) .and. .not. anew
      if (serves) serves = changes_share*count(tangent%status /= system%contact%status) <= &
        tangent%elements
      if (serves) then
        tangent%fresh = .false.
      else
        call factorise_tangent(system, form, x, outcome)
      end if
      if (outcome == solver_done) call form_rest(system%contact, form%condensed)
    end associate
  end subroutine prepare_answers

  !> Forces f = c + k u of contact and displacements u = w - C f, for each column.
  subroutine answer_all(condensed, c, u, arrived, late, course)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor or blocks
    real(wp), intent(inout) :: c(:, :) !! (candidates, columns) forces at fixed candidates; gets
    !! all forces [force]
    real(wp), intent(inout) :: u(:, :) !! (candidates, columns) displacements without contact; gets
    !! those with it, but where it is late [length]
    logical, intent(out) :: arrived !! all of them
    logical, intent(out) :: late(:) !! (candidates) u is still that without contact
    type(answers_t), intent(inout) :: course !! of the last answers
    real(wp), allocatable :: b(:, :), y(:, :), f(:, :), t(:, :)

    late = .not. condensed%tangent%parts%iterated
    if (condensed%tangent%parts%iterated) then
      b = u(condensed%alive%live, :)
      call subtract_product(condensed%bodies, c(condensed%alive%live, :), b)
      allocate (y, mold=b)
      call answer_by_turns(condensed, b, y, arrived)
      c(condensed%alive%live, :) = c(condensed%alive%live, :) + y
      if (arrived) call subtract_products(condensed%bodies, c, u)
    else
      call gather_touched(condensed, course%touched)
      associate (rows => course%touched%rows)
        b = transpose(u(rows, :))
        f = transpose(c(rows, :))
        call add_product(condensed%bodies, course%touched, -f, b)
        allocate (y, t, mold=b)
        call answer_block(condensed, b, course, y, t, arrived)
        f = f + y
        c(rows, :) = transpose(f)
        u(rows, :) = transpose(t)
        late(rows) = .false.
      end associate
    end if
  end subroutine answer_all

  !> Column after column where blocks take the place of the factor.
  subroutine answer_by_turns(condensed, b, y, arrived)
    type(condensed_t), intent(inout) :: condensed !! tangent with its blocks
    real(wp), intent(in) :: b(:, :) !! (live, columns) displacements without the answer [length]
    real(wp), intent(out) :: y(:, :) !! (live, columns) answers of contact [force]
    logical, intent(out) :: arrived !! all of them
    real(wp) :: push(condensed%rigid%modes), t(size(b, 1)), floor
    integer :: j
    logical :: there

    arrived = .true.
    push = 0.0_wp
    do j = 1, size(b, 2)
      call take_scale(condensed, b(:, j), floor)
      call answer(condensed, b(:, j), push, floor, most_blocked_iterations, y(:, j), t, there)
      arrived = arrived .and. there
    end do
  end subroutine answer_by_turns

  !> The force that is left at last: from what contact would make of the displacement alone.
  subroutine take_scale(condensed, b, floor)
    type(condensed_t), intent(in) :: condensed !! tangent with its columns
    real(wp), intent(in) :: b(:) !! (live) displacement [length]
    real(wp), intent(out) :: floor !! the force [force]
    real(wp) :: z(condensed%tangent%rank), y(size(b))

    y = 0.0_wp
    call take_shares(condensed%tangent, b, z)
    call add_leading(condensed%tangent, z, y)
    floor = max(accuracy*1.0e-2_wp*norm2(y), tiny(1.0_wp))
  end subroutine take_scale

  !> GMRES on the rest of the element matrices, as `condensed_direction` has it, for all columns
  !! together: products with matrices are made for all at once, and each column finds its answer
  !! among the directions of all.
  subroutine answer_block(condensed, b, course, y, t, arrived)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, compliances
    real(wp), intent(in) :: b(:, :) !! (columns, rows) displacements [length]
    type(answers_t), intent(inout) :: course !! rows, their compliance; room is used again
    real(wp), intent(out) :: y(:, :) !! (columns, rows) [force]
    real(wp), intent(out) :: t(:, :) !! (columns, rows) displacements with the answer [length]
    logical, intent(out) :: arrived !! all columns
    real(wp), allocatable :: shares(:, :), z(:, :), r(:, :), x(:, :), product(:, :), share(:, :)
    real(wp), allocatable :: first(:, :)

    associate (tangent => condensed%tangent, touched => course%touched, iteration => &
      course%iteration, columns => size(b, 1), n => size(b, 2), most => most_block_steps*size(b, 1))
      allocate (z(tangent%rank, columns), r(columns, n), shares(tangent%rank, most), product(n, &
        most))
      t = b
      call answer_leading_block(condensed, touched, t, z)
      call apply_rest_block(tangent, touched, t, r)
      y = 0.0_wp
      call add_leading_block(tangent, touched, z, y)
      ! what moves along a sliding surface has its forces in the rest
      first = transpose(y + r)
      call begin_block(transpose(r), course%share_left*lengths(first), most, iteration)
      do while (iteration%m > iteration%n)
        associate (old => iteration%n + 1, new => iteration%m)
          x = transpose(iteration%base(:, old:new))
          call answer_push(condensed, touched, x, shares(:, old:new), product(:, old:new))
          call add_images(transpose(x), iteration)
        end associate
      end do
      arrived = all(iteration%rest <= iteration%floor)
      share = block_shares(iteration)
      y = transpose(matmul(iteration%base(:, :iteration%n), share))
      z = z - matmul(shares(:, :iteration%n), share)
      call add_leading_block(tangent, touched, z, y)
      t = t - transpose(matmul(product(:, :iteration%n), share))
    end associate
  end subroutine answer_block

  !> What forces x of the rest become: the displacements that they make, answered by the leading
  !! part, push the rest once more.
  subroutine answer_push(condensed, touched, x, z, product)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, compliances
    type(touched_t), intent(in) :: touched !! rows and their compliance
    real(wp), intent(inout) :: x(:, :) !! (columns, rows) grow by the push [force]
    real(wp), intent(out) :: z(:, :) !! (rank, columns) the leading part is U z
    real(wp), intent(out) :: product(:, :) !! (rows, columns) displacements, answered [length]
    real(wp) :: t(size(x, 1), size(x, 2)), r(size(x, 1), size(x, 2))

    t = 0.0_wp
    call add_product(condensed%bodies, touched, x, t)
    call answer_leading_block(condensed, touched, t, z)
    call apply_rest_block(condensed%tangent, touched, t, r)
    product = transpose(t)
    x = x + r
  end subroutine answer_push

  !> What displacements d become when the leading part of contact answers them.
  subroutine answer_leading_block(condensed, touched, d, z)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, compliances
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(inout) :: d(:, :) !! (columns, rows) in and out [length]
    real(wp), intent(out) :: z(:, :) !! (rank, columns) the forces are U z
    real(wp), allocatable :: force(:, :)
    integer :: k

    associate (tangent => condensed%tangent, n => condensed%tangent%rank, columns => size(d, 1))
      if (n == 0) return
      if (tangent%whole) then
        do k = 1, columns
          call take_shares(tangent, d(k, :), z(:, k))
        end do
      else
        call take_shares_block(tangent, touched%place, d, z)
      end if
      call solve_block(n, columns, size(tangent%small, 1), tangent%small, tangent%pivot, z)
      if (tangent%whole) then
        allocate (force(columns, size(d, 2)), source=0.0_wp)
        call add_leading_block(tangent, touched, z, force)
        call add_product(condensed%bodies, touched, -force, d)
      else
        call subtract_leading(touched, tangent%cu, z, d)
      end if
    end associate
  end subroutine answer_leading_block

  !> z = V^T d for all columns.
  pure subroutine take_shares_block(tangent, place, d, z)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    integer, intent(in) :: place(:) !! (live) place of the candidates in d
    real(wp), intent(in) :: d(:, :) !! (columns, rows) [length]
    real(wp), intent(out) :: z(:, :) !! (rank, columns)
    real(wp) :: total(size(d, 1))
    integer :: j, i

    do j = 1, tangent%rank
      total = 0.0_wp
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) total = total + tangent%v(i, j)*d(:, place(dofs(i)))
        end do
      end associate
      z(j, :) = total
    end do
  end subroutine take_shares_block

  !> Adds U z to y for all columns.
  pure subroutine add_leading_block(tangent, touched, z, y)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(in) :: z(:, :) !! (rank, columns)
    real(wp), intent(inout) :: y(:, :) !! (columns, rows) [force]
    integer :: i, j

    if (tangent%whole) then
      do j = 1, size(y, 1)
        call add_leading(tangent, z(:, j), y(j, :))
      end do
      return
    end if
    do j = 1, tangent%rank
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) y(:, touched%place(dofs(i))) = y(:, touched%place(dofs(i))) &
            + tangent%u(i, j)*z(j, :)
        end do
      end associate
    end do
  end subroutine add_leading_block

  !> y = k' x with the rest of the element matrices.
  subroutine apply_rest_block(tangent, touched, x, y)
    type(contact_tangent_t), intent(in) :: tangent !! rest of the element matrices
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(in) :: x(:, :) !! (columns, rows) [length]
    real(wp), intent(out) :: y(:, :) !! (columns, rows) [force]
    integer :: e, k

    if (tangent%whole) then
      do k = 1, size(x, 1)
        call apply_rest(tangent, x(k, :), y(k, :))
      end do
      return
    end if
    y = 0.0_wp
    do e = 1, tangent%resting
      associate (element => tangent%element(e))
        call add_element_block(size(tangent%dofs, 1), size(x, 1), tangent%dofs(:, element), &
          tangent%s(:, :, element), touched%place, x, y)
      end associate
    end do
  end subroutine apply_rest_block

  !> Adds what the matrix of an element does.
  pure subroutine add_element_block(n, columns, dofs, s, place, x, y)
    integer, intent(in) :: n !! degrees of freedom of an element
    integer, intent(in) :: columns !! of displacements
    integer, intent(in) :: dofs(n) !! live candidates, 0 for none
    real(wp), intent(in) :: s(n, n) !! its matrix
    integer, intent(in) :: place(:) !! (live) place of the candidates in x
    real(wp), intent(in) :: x(:, :) !! (columns, rows) [length]
    real(wp), intent(inout) :: y(:, :) !! (columns, rows) grow [force]
    real(wp) :: near(n, columns), far(n)
    integer :: i, k, j

    near = 0.0_wp
    do k = 1, n
      if (dofs(k) > 0) near(k, :) = x(:, place(dofs(k)))
    end do
    do j = 1, columns
      far = 0.0_wp
      do k = 1, n
        far = far + s(:, k)*near(k, j)
      end do
      near(:, j) = far
    end do
    do i = 1, n
      if (dofs(i) > 0) y(:, place(dofs(i))) = y(:, place(dofs(i))) + near(i, :)
    end do
  end subroutine add_element_block
end module linear_answers
