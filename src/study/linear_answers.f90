!> The linear system of the last increment once more, for many right-hand sides at once
!! (doc/theory, "Derivatives along the path").
module linear_answers
  use kinds, only: wp
  use lapack_interface, only: dgetrs
  use back_ends, only: solver_done
  use condensed_types, only: condensed_t, contact_tangent_t
  use touched_candidates, only: touched_t, gather_touched, add_product, add_times, &
    subtract_yield, subtract_yield_of_all
  use condensed_direction, only: answer
  use contact_tangent, only: form_element_matrices, factorise_tangent, form_rest, &
    apply_rest
  use contact_sums, only: add_leading, take_shares
  use gmres, only: gmres_t, begin_gmres, add_image, gmres_shares
  use system_types, only: system_t
  implicit none
  private
  public :: prepare_answers, answer_all

  !> Vectors of GMRES for one right-hand side.
  integer, parameter :: most_vectors = 40
  !> A factor serves again if no more than this share of the elements have changed their status.
  integer, parameter :: changes_share = 20
  !> What is left of a force, over the force.
  real(wp), parameter :: accuracy = 1.0e-13_wp
  !> Iterations with blocks.
  integer, parameter :: most_of_blocks = 200

contains

  !> Element matrices at the converged state, and a factor: the last one of the increment, or anew.
  subroutine prepare_answers(system, x, anew, outcome)
    type(system_t), intent(inout) :: system !! tangent of condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: anew !! a new factor in any case
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    logical :: serves

    outcome = solver_done
    call form_element_matrices(system, x)
    associate (tangent => system%condensed%tangent)
      serves = allocated(tangent%status) .and. .not. anew
      if (serves) serves = changes_share*count(tangent%status /= system%contact%status) <= &
        tangent%elements
      if (serves) then
        tangent%fresh = .false.
      else
        call factorise_tangent(system, x, outcome)
      end if
      if (outcome == solver_done) call form_rest(system)
    end associate
  end subroutine prepare_answers

  !> Forces f = c + k u of contact and displacements u = w - C f, for each column.
  subroutine answer_all(condensed, c, u, arrived, iterations)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor or blocks
    real(wp), intent(inout) :: c(:, :) !! (candidates, columns) forces at fixed candidates; gets
    !! all forces [force]
    real(wp), intent(inout) :: u(:, :) !! (candidates, columns) displacements without contact; gets
    !! those with it [length]
    logical, intent(out) :: arrived !! all of them
    integer, intent(inout) :: iterations !! of GMRES: counts on
    type(touched_t) :: touched
    real(wp), allocatable :: b(:, :), y(:, :)

    if (condensed%tangent%parts%iterated) then
      b = u(condensed%alive%live, :)
      call subtract_yield(condensed%bodies, c(condensed%alive%live, :), b)
      allocate (y, mold=b)
      call answer_by_turns(condensed, b, y, arrived, iterations)
      c(condensed%alive%live, :) = c(condensed%alive%live, :) + y
    else
      call gather_touched(condensed, touched)
      associate (rows => condensed%alive%live(touched%rows))
        b = u(rows, :)
        call add_product(touched, -1.0_wp, c(rows, :), b)
        allocate (y, mold=b)
        call answer_block(condensed%tangent, touched, b, y, arrived, iterations)
        c(rows, :) = c(rows, :) + y
      end associate
    end if
    if (arrived) call subtract_yield_of_all(condensed%bodies, c, u)
  end subroutine answer_all

  !> Column after column where blocks take the place of the factor.
  subroutine answer_by_turns(condensed, b, y, arrived, iterations)
    type(condensed_t), intent(inout) :: condensed !! tangent with its blocks
    real(wp), intent(in) :: b(:, :) !! (live, columns) displacements without the answer [length]
    real(wp), intent(out) :: y(:, :) !! (live, columns) answers of contact [force]
    logical, intent(out) :: arrived !! all of them
    integer, intent(inout) :: iterations !! of GMRES: counts on
    real(wp) :: push(condensed%rigid%modes), t(size(b, 1)), floor
    integer :: j
    logical :: there

    arrived = .true.
    push = 0.0_wp
    do j = 1, size(b, 2)
      call take_scale(condensed, b(:, j), floor)
      call answer(condensed, b(:, j), push, floor, most_of_blocks, y(:, j), t, there)
      iterations = iterations + condensed%tangent%course%iterations
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

  !> GMRES on the rest of the element matrices, as `condensed_direction` has it, for all columns in
  !! step: products with matrices are made for all at once.
  subroutine answer_block(tangent, touched, b, y, arrived, iterations)
    type(contact_tangent_t), intent(in) :: tangent !! with its factor
    type(touched_t), intent(in) :: touched !! rows and their compliance
    real(wp), intent(in) :: b(:, :) !! (rows, columns) displacements [length]
    real(wp), intent(out) :: y(:, :) !! (rows, columns) [force]
    logical, intent(out) :: arrived !! all columns
    integer, intent(inout) :: iterations !! counts on
    type(gmres_t) :: iteration(size(b, 2))
    real(wp), allocatable :: shares(:, :, :), z(:, :), r(:, :), x(:, :), t(:, :), share(:)
    real(wp) :: floor(size(b, 2))
    integer :: j, k, i
    logical :: going(size(b, 2))

    associate (n => size(b, 1), columns => size(b, 2))
      allocate (z(tangent%rank, columns), r(n, columns), x(n, columns), t(n, columns))
      call answer_leading_block(tangent, touched, b, z, t)
      call apply_rest_block(tangent, touched, t, r)
      y = 0.0_wp
      call add_leading_block(tangent, touched, z, y)
      do k = 1, columns
        floor(k) = accuracy*norm2(y(:, k))
        call begin_gmres(r(:, k), most_vectors, iteration(k))
        going(k) = iteration(k)%rest > floor(k)
      end do
      allocate (shares(tangent%rank, columns, 0))
      j = 0
      do while (any(going) .and. j < most_vectors)
        j = j + 1
        call widen(shares, j)
        do k = 1, columns
          x(:, k) = merge(1.0_wp, 0.0_wp, going(k))*iteration(k)%base(:, iteration(k)%n + 1)
        end do
        r = 0.0_wp
        call add_product(touched, 1.0_wp, x, r)
        call answer_leading_block(tangent, touched, r, shares(:, :, j), t)
        call apply_rest_block(tangent, touched, t, r)
        do k = 1, columns
          if (.not. going(k)) cycle
          call add_image(r(:, k) + x(:, k), iteration(k))
          going(k) = iteration(k)%rest > floor(k)
        end do
      end do
      iterations = iterations + j
      arrived = .not. any(going)
      do k = 1, columns
        share = gmres_shares(iteration(k))
        y(:, k) = 0.0_wp
        do i = iteration(k)%n, 1, -1
          y(:, k) = y(:, k) + share(i)*iteration(k)%base(:, i)
          z(:, k) = z(:, k) - share(i)*shares(:, k, i)
        end do
      end do
      call add_leading_block(tangent, touched, z, y)
    end associate
  end subroutine answer_block

  !> Room for one vector more of each column.
  subroutine widen(vectors, n)
    real(wp), allocatable, intent(inout) :: vectors(:, :, :) !! (rows, columns, vectors)
    integer, intent(in) :: n !! vectors wanted
    real(wp), allocatable :: more(:, :, :)
    integer :: have

    have = size(vectors, 3)
    if (have >= n) return
    allocate (more(size(vectors, 1), size(vectors, 2), max(n, have + 4)))
    more(:, :, :have) = vectors
    call move_alloc(more, vectors)
  end subroutine widen

  !> What displacements d become when the leading part of contact answers them.
  subroutine answer_leading_block(tangent, touched, d, z, t)
    type(contact_tangent_t), intent(in) :: tangent !! with its factor
    type(touched_t), intent(in) :: touched !! rows, C U
    real(wp), intent(in) :: d(:, :) !! (rows, columns) [length]
    real(wp), intent(out) :: z(:, :) !! (rank, columns) the forces are U z
    real(wp), intent(out) :: t(:, :) !! (rows, columns) [length]
    real(wp) :: force(size(d, 1), size(d, 2)), turned(size(d, 2), size(d, 1))
    integer :: k, info

    t = d
    associate (n => tangent%rank, columns => size(d, 2))
      if (n == 0) return
      if (tangent%whole) then
        do k = 1, columns
          call take_shares(tangent, d(:, k), z(:, k))
        end do
      else
        call take_shares_block(tangent, touched%place, transpose(d), z)
      end if
      call dgetrs('N', n, columns, tangent%small, size(tangent%small, 1), tangent%pivot, z, n, &
        info)
      if (tangent%whole) then
        force = 0.0_wp
        call add_leading_block(tangent, touched, z, force)
        call add_product(touched, -1.0_wp, force, t)
      else
        turned = transpose(t)
        call add_times(columns, n, size(t, 1), -transpose(z), touched%cu, turned)
        t = transpose(turned)
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
  subroutine add_leading_block(tangent, touched, z, y)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(in) :: z(:, :) !! (rank, columns)
    real(wp), intent(inout) :: y(:, :) !! (rows, columns) [force]
    integer :: i, j

    if (tangent%whole) then
      do j = 1, size(y, 2)
        call add_leading(tangent, z(:, j), y(:, j))
      end do
      return
    end if
    do j = 1, tangent%rank
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) y(touched%place(dofs(i)), :) = y(touched%place(dofs(i)), :) &
            + tangent%u(i, j)*z(j, :)
        end do
      end associate
    end do
  end subroutine add_leading_block

  !> y = k' x with the rest of the element matrices.
  subroutine apply_rest_block(tangent, touched, x, y)
    type(contact_tangent_t), intent(in) :: tangent !! rest of the element matrices
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(in) :: x(:, :) !! (rows, columns) [length]
    real(wp), intent(out) :: y(:, :) !! (rows, columns) [force]
    real(wp) :: turned(size(x, 2), size(x, 1)), force(size(x, 2), size(x, 1))
    real(wp) :: local(size(x, 2))
    integer :: e, i, k

    if (tangent%whole) then
      do k = 1, size(x, 2)
        call apply_rest(tangent, x(:, k), y(:, k))
      end do
      return
    end if
    turned = transpose(x)
    force = 0.0_wp
    do e = 1, tangent%resting
      associate (dofs => tangent%dofs(:, tangent%element(e)), s => tangent%s(:, :, &
        tangent%element(e)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) == 0) cycle
          local = 0.0_wp
          do k = 1, size(tangent%dofs, 1)
            if (dofs(k) > 0) local = local + s(i, k)*turned(:, touched%place(dofs(k)))
          end do
          force(:, touched%place(dofs(i))) = force(:, touched%place(dofs(i))) + local
        end do
      end associate
    end do
    y = transpose(force)
  end subroutine apply_rest_block
end module linear_answers
