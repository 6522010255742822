!> The linear system of the last increment once more, for many right-hand sides at once
!! (doc/theory, "Derivatives along the path").
module linear_answers
  use kinds, only: wp
  use lapack_interface, only: dgetrs
  use back_ends, only: solver_done
  use condensed_types, only: condensed_t, contact_tangent_t
  use condensed_direction, only: answer
  use contact_tangent, only: form_element_matrices, factorise_tangent, form_rest, &
    apply_rest, add_leading, take_shares
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

  !> t = b - C y with y = k t, the answer of contact, for each column of b.
  subroutine answer_all(condensed, b, y, t, arrived, iterations)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor or blocks
    real(wp), intent(in) :: b(:, :) !! (live, columns) displacements without the answer [length]
    real(wp), intent(out) :: y(:, :) !! (live, columns) answers of contact [force]
    real(wp), intent(out) :: t(:, :) !! (live, columns) displacements [length]
    logical, intent(out) :: arrived !! all of them
    integer, intent(inout) :: iterations !! of GMRES: counts on
    real(wp) :: push(condensed%modes), floor
    integer :: j, mine
    logical :: there

    if (.not. condensed%tangent%iterated) then
      call answer_block(condensed, b, y, t, arrived, iterations)
      return
    end if
    arrived = .true.
    push = 0.0_wp
    do j = 1, size(b, 2)
      call take_scale(condensed, b(:, j), floor)
      call answer(condensed, b(:, j), push, floor, most_of_blocks, y(:, j), t(:, j), there, mine)
      iterations = iterations + mine
      arrived = arrived .and. there
    end do
  end subroutine answer_all

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
  subroutine answer_block(condensed, b, y, t, arrived, iterations)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor
    real(wp), intent(in) :: b(:, :) !! (live, columns) displacements [length]
    real(wp), intent(out) :: y(:, :) !! (live, columns) [force]
    real(wp), intent(out) :: t(:, :) !! (live, columns) [length]
    logical, intent(out) :: arrived !! all columns
    integer, intent(inout) :: iterations !! counts on
    type(gmres_t) :: iteration(size(b, 2))
    real(wp), allocatable :: moved(:, :, :), shares(:, :, :), z(:, :), r(:, :), x(:, :), share(:)
    real(wp) :: floor(size(b, 2))
    integer :: j, k, i
    logical :: going(size(b, 2))

    associate (n => size(b, 1), columns => size(b, 2), rank => condensed%tangent%rank)
      allocate (z(rank, columns), r(n, columns), x(n, columns))
      call answer_leading_block(condensed, b, z, t)
      call apply_rest_block(condensed%tangent, t, r)
      do k = 1, columns
        y(:, k) = 0.0_wp
        call add_leading(condensed%tangent, z(:, k), y(:, k))
        floor(k) = accuracy*norm2(y(:, k))
        call begin_gmres(r(:, k), most_vectors, iteration(k))
        going(k) = iteration(k)%rest > floor(k)
      end do
      allocate (moved(n, columns, 0), shares(rank, columns, 0))
      j = 0
      do while (any(going) .and. j < most_vectors)
        j = j + 1
        call widen(moved, j)
        call widen(shares, j)
        do k = 1, columns
          x(:, k) = merge(1.0_wp, 0.0_wp, going(k))*iteration(k)%base(:, iteration(k)%n + 1)
        end do
        call apply_compliance_block(condensed, x, r)
        call answer_leading_block(condensed, r, shares(:, :, j), moved(:, :, j))
        call apply_rest_block(condensed%tangent, moved(:, :, j), r)
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
          t(:, k) = t(:, k) - share(i)*moved(:, k, i)
          z(:, k) = z(:, k) - share(i)*shares(:, k, i)
        end do
        call add_leading(condensed%tangent, z(:, k), y(:, k))
      end do
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
  subroutine answer_leading_block(condensed, d, z, t)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, live compliances
    real(wp), intent(in) :: d(:, :) !! (live, columns) [length]
    real(wp), intent(out) :: z(:, :) !! (rank, columns) the forces are U z
    real(wp), intent(out) :: t(:, :) !! (live, columns) [length]
    real(wp), allocatable :: force(:, :)
    integer :: k, info

    t = d
    associate (tangent => condensed%tangent, n => condensed%tangent%rank)
      if (n == 0) return
      do k = 1, size(d, 2)
        call take_shares(tangent, d(:, k), z(:, k))
      end do
      call dgetrs('N', n, size(d, 2), tangent%small, size(tangent%small, 1), tangent%pivot, z, &
                  n, info)
      if (tangent%whole) then
        allocate (force(size(d, 1), size(d, 2)), source=0.0_wp)
        do k = 1, size(d, 2)
          call add_leading(tangent, z(:, k), force(:, k))
        end do
        call apply_compliance_block(condensed, force, t)
        t = d - t
      else
        t = t - matmul(tangent%cu(:, :n), z)
      end if
    end associate
  end subroutine answer_leading_block

  !> y = C x on the live candidates.
  subroutine apply_compliance_block(condensed, x, y)
    type(condensed_t), intent(in) :: condensed !! live compliances, both triangles
    real(wp), intent(in) :: x(:, :) !! (live, columns) [force]
    real(wp), intent(out) :: y(:, :) !! (live, columns) [length]
    integer :: b

    y = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live == 0) cycle
        associate (first => body%first_live + 1, last => body%first_live + body%n_live)
          y(first:last, :) = matmul(body%live, x(first:last, :))
        end associate
      end associate
    end do
  end subroutine apply_compliance_block

  !> y = k' x with the rest of the element matrices.
  subroutine apply_rest_block(tangent, x, y)
    type(contact_tangent_t), intent(in) :: tangent !! rest of the element matrices
    real(wp), intent(in) :: x(:, :) !! (live, columns) [length]
    real(wp), intent(out) :: y(:, :) !! (live, columns) [force]
    real(wp) :: local(size(tangent%dofs, 1), size(x, 2))
    integer :: e, i, k

    if (tangent%whole) then
      do k = 1, size(x, 2)
        call apply_rest(tangent, x(:, k), y(:, k))
      end do
      return
    end if
    y = 0.0_wp
    do e = 1, tangent%resting
      associate (dofs => tangent%dofs(:, tangent%element(e)))
        local = 0.0_wp
        do i = 1, size(dofs)
          if (dofs(i) > 0) local(i, :) = x(dofs(i), :)
        end do
        local = matmul(tangent%s(:, :, tangent%element(e)), local)
        do i = 1, size(dofs)
          if (dofs(i) > 0) y(dofs(i), :) = y(dofs(i), :) + local(i, :)
        end do
      end associate
    end do
  end subroutine apply_rest_block
end module linear_answers
