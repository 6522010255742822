!> The Newton direction of the condensed form: (I + C k) du = d + C r with the element matrices k
!! (doc/theory, "Condensed contact").
module condensed_direction
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_contact_tangent, cost_dense_factor, cost_solve
  use element_types, only: task_tangent, max_dofs, status_open
  use elmlib, only: routine_none
  use lapack_interface, only: dgetrf, dgetrs, dgemv
  use low_rank, only: peel
  use assembly, only: assemble
  use umfpack_solver, only: solver_done, solver_singular
  use condensed_types, only: condensed_t, contact_tangent_t
  use condensed_system, only: gather_condensed, apply_compliance
  use system_types, only: system_t
  implicit none
  private
  public :: form_condensed_tangent, find_condensed_direction, next_condensed_length, &
    defect_energy

  !> Element matrix entries times compliance that are left to the iteration.
  real(wp), parameter :: negligible = 0.03_wp
  !> Columns that an element matrix may have.
  integer, parameter :: most_columns = 6
  !> Iterations of GMRES, the accuracies of a direction, and that of its length.
  integer, parameter :: most_vectors = 40
  real(wp), parameter :: finest = 1.0e-10_wp, coarsest = 1.0e-6_wp, length_accuracy = 1.0e-3_wp

contains

  !> Element matrices at u, and the factor of their leading part.
  subroutine form_condensed_tangent(system, x, outcome)
    type(system_t), intent(inout) :: system !! gets tangent of condensed, right
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! done or singular
    integer :: info

    outcome = solver_done
    call begin_cost(system%costs, cost_contact_tangent)
    associate (condensed => system%condensed, tangent => system%condensed%tangent)
      if (.not. allocated(tangent%s)) allocate (tangent%s(max_dofs, max_dofs, system%contact%n))
      system%contact_force = 0.0_wp
      call assemble(system%contact, task_tangent, x, system%u, system%contact_force, s=tangent%s)
      call gather_condensed(system, 0.0_wp)
      call list_elements(system, tangent)
      call peel_elements(condensed, tangent)
      call end_cost(system%costs, cost_contact_tangent)
      call begin_cost(system%costs, cost_dense_factor)
      call form_small(condensed, tangent)
      if (tangent%rank > 0) then
        call dgetrf(tangent%rank, tangent%rank, tangent%small, size(tangent%small, 1), &
          tangent%pivot, info)
        if (info /= 0) outcome = solver_singular
      end if
    end associate
    call end_cost(system%costs, cost_dense_factor)
  end subroutine form_condensed_tangent

  !> Lists the closed elements and the live candidates they act on.
  subroutine list_elements(system, tangent)
    type(system_t), intent(in) :: system !! contact elements, condensed
    type(contact_tangent_t), intent(inout) :: tangent !! gets element, dofs; s loses dead rows
    integer :: k, a, i, n

    if (.not. allocated(tangent%element)) then
      allocate (tangent%element(system%contact%n), tangent%dofs(max_dofs, system%contact%n))
    end if
    tangent%elements = 0
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      if (system%contact%status(k) <= status_open) cycle
      tangent%elements = tangent%elements + 1
      associate (e => tangent%elements)
        tangent%element(e) = k
        tangent%dofs(:, e) = 0
        do a = 1, system%contact%nel(k)
          do i = 1, 3
            n = system%condensed%place(i, system%contact%ix(a, k))
            if (n > 0) n = system%condensed%live_place(n)
            tangent%dofs(3*(a - 1) + i, e) = n
          end do
        end do
        do i = 1, max_dofs
          if (tangent%dofs(i, e) > 0) cycle
          tangent%s(i, :, k) = 0.0_wp
          tangent%s(:, i, k) = 0.0_wp
        end do
      end associate
    end do
  end subroutine list_elements

  !> Takes the leading columns of each element matrix.
  subroutine peel_elements(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! gets rank, owner, u, v
    real(wp) :: weight(max_dofs), root(condensed%n_live)
    integer :: e, i, b, rank

    if (.not. allocated(tangent%owner)) then
      allocate (tangent%owner(most_columns*size(tangent%element)), &
        tangent%u(max_dofs, most_columns*size(tangent%element)), &
        tangent%v(max_dofs, most_columns*size(tangent%element)))
    end if
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        do i = 1, body%n_live
          root(body%first_live + i) = sqrt(body%live(i, i))
        end do
      end associate
    end do
    tangent%rank = 0
    do e = 1, tangent%elements
      weight = 0.0_wp
      do i = 1, max_dofs
        if (tangent%dofs(i, e) > 0) weight(i) = root(tangent%dofs(i, e))
      end do
      associate (n => tangent%rank)
        call peel(tangent%s(:, :, tangent%element(e)), weight, negligible, &
          tangent%u(:, n + 1:n + most_columns), tangent%v(:, n + 1:n + most_columns), rank)
        tangent%owner(n + 1:n + rank) = e
        n = n + rank
      end associate
    end do
  end subroutine peel_elements

  !> C U and I + V^T C U.
  subroutine form_small(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! gets cu, small, pivot
    integer :: j, k, i, room
    real(wp) :: total

    room = 0
    if (allocated(tangent%small)) then
      room = size(tangent%small, 1)
      if (size(tangent%cu, 1) /= condensed%n_live) room = 0
    end if
    if (room < tangent%rank) then
      if (allocated(tangent%small)) deallocate (tangent%small, tangent%cu, tangent%pivot)
      room = min(size(tangent%owner), tangent%rank + tangent%rank/4)
      allocate (tangent%small(room, room), tangent%cu(condensed%n_live, room), &
        tangent%pivot(room))
    end if
    do j = 1, tangent%rank
      call add_columns(condensed, tangent%dofs(:, tangent%owner(j)), tangent%u(:, j), &
        tangent%cu(:, j))
    end do
    do j = 1, tangent%rank
      do k = 1, tangent%rank
        total = 0.0_wp
        associate (dofs => tangent%dofs(:, tangent%owner(k)))
          do i = 1, max_dofs
            if (dofs(i) > 0) total = total + tangent%v(i, k)*tangent%cu(dofs(i), j)
          end do
        end associate
        tangent%small(k, j) = total
      end do
      tangent%small(j, j) = tangent%small(j, j) + 1.0_wp
    end do
  end subroutine form_small

  !> y = C u for a u that few degrees of freedom have.
  subroutine add_columns(condensed, dofs, u, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    integer, intent(in) :: dofs(:) !! (max_dofs) live candidates, 0 for none
    real(wp), intent(in) :: u(:) !! (max_dofs) values
    real(wp), intent(out) :: y(:) !! (n_live) C u
    integer :: b, i

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        y(body%first_live + 1:body%first_live + body%n_live) = 0.0_wp
        do i = 1, size(dofs)
          if (dofs(i) <= body%first_live .or. dofs(i) > body%first_live + body%n_live) cycle
          y(body%first_live + 1:body%first_live + body%n_live) = &
            y(body%first_live + 1:body%first_live + body%n_live) &
            + u(i)*body%live(:, dofs(i) - body%first_live)
        end do
      end associate
    end do
  end subroutine add_columns

  !> y = k x with the element matrices.
  subroutine apply_tangent(tangent, x, y)
    type(contact_tangent_t), intent(in) :: tangent !! element matrices
    real(wp), intent(in) :: x(:) !! (live) [length]
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp) :: local(max_dofs), force(max_dofs)
    integer :: e, i

    y = 0.0_wp
    do e = 1, tangent%elements
      associate (dofs => tangent%dofs(:, e))
        local = 0.0_wp
        do i = 1, max_dofs
          if (dofs(i) > 0) local(i) = x(dofs(i))
        end do
        force = matmul(tangent%s(:, :, tangent%element(e)), local)
        do i = 1, max_dofs
          if (dofs(i) > 0) y(dofs(i)) = y(dofs(i)) + force(i)
        end do
      end associate
    end do
  end subroutine apply_tangent

  !> y = (I + U V^T C)^-1 f and C y.
  subroutine precondition(condensed, f, y, cy)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor
    real(wp), intent(in) :: f(:) !! (live) [force]
    real(wp), intent(out) :: y(:), cy(:) !! (live) the force and its displacement
    real(wp) :: z(max(1, condensed%tangent%rank))
    integer :: j, i, info

    associate (tangent => condensed%tangent)
      y = f
      cy = 0.0_wp
      call apply_compliance(condensed, f, cy)
      if (tangent%rank == 0) return
      do j = 1, tangent%rank
        z(j) = 0.0_wp
        associate (dofs => tangent%dofs(:, tangent%owner(j)))
          do i = 1, max_dofs
            if (dofs(i) > 0) z(j) = z(j) + tangent%v(i, j)*cy(dofs(i))
          end do
        end associate
      end do
      call dgetrs('N', tangent%rank, 1, tangent%small, size(tangent%small, 1), tangent%pivot, z, &
        tangent%rank, info)
      call dgemv('N', size(f), tangent%rank, -1.0_wp, tangent%cu, size(f), z, 1, 1.0_wp, cy, 1)
      do j = 1, tangent%rank
        associate (dofs => tangent%dofs(:, tangent%owner(j)))
          do i = 1, max_dofs
            if (dofs(i) > 0) y(dofs(i)) = y(dofs(i)) - tangent%u(i, j)*z(j)
          end do
        end associate
      end do
    end associate
  end subroutine precondition

  !> Contact force y = k (b - C y) that answers the displacement b, by GMRES with the factor on
  !! its right.
  subroutine answer(condensed, b, accuracy, floor, y, cy)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: accuracy !! relative residual to arrive at
    real(wp), intent(in) :: floor !! or this residual [force]
    real(wp), intent(out) :: y(:), cy(:) !! (live) the force and its displacement
    real(wp), allocatable :: base(:, :), trial(:, :), moved(:, :)
    real(wp) :: h(most_vectors + 1, most_vectors), g(most_vectors + 1), first
    real(wp) :: cosine(most_vectors), sine(most_vectors), held
    integer :: j, i, n

    n = size(b)
    allocate (base(n, most_vectors + 1), trial(n, most_vectors), moved(n, most_vectors))
    y = 0.0_wp
    cy = 0.0_wp
    call apply_tangent(condensed%tangent, b, base(:, 1))
    first = norm2(base(:, 1))
    if (first <= floor) return
    base(:, 1) = base(:, 1)/first
    h = 0.0_wp
    g = 0.0_wp
    g(1) = first
    do j = 1, most_vectors
      call precondition(condensed, base(:, j), trial(:, j), moved(:, j))
      call apply_tangent(condensed%tangent, moved(:, j), base(:, j + 1))
      base(:, j + 1) = base(:, j + 1) + trial(:, j)
      do i = 1, j
        h(i, j) = dot_product(base(:, i), base(:, j + 1))
        base(:, j + 1) = base(:, j + 1) - h(i, j)*base(:, i)
      end do
      h(j + 1, j) = norm2(base(:, j + 1))
      if (h(j + 1, j) > 0.0_wp) base(:, j + 1) = base(:, j + 1)/h(j + 1, j)
      do i = 1, j - 1
        held = h(i, j)
        h(i, j) = cosine(i)*held + sine(i)*h(i + 1, j)
        h(i + 1, j) = cosine(i)*h(i + 1, j) - sine(i)*held
      end do
      held = hypot(h(j, j), h(j + 1, j))
      if (held <= 0.0_wp) exit
      cosine(j) = h(j, j)/held
      sine(j) = h(j + 1, j)/held
      h(j, j) = held
      g(j + 1) = -sine(j)*g(j)
      g(j) = cosine(j)*g(j)
      if (abs(g(j + 1)) <= max(accuracy*first, floor)) exit
    end do
    j = min(j, most_vectors)
    if (abs(h(j, j)) <= 0.0_wp) j = j - 1
    do i = j, 1, -1
      g(i) = (g(i) - dot_product(h(i, i + 1:j), g(i + 1:j)))/h(i, i)
      y = y + g(i)*trial(:, i)
      cy = cy + g(i)*moved(:, i)
    end do
  end subroutine answer

  !> The direction: displacements of the live candidates and the change of their forces.
  subroutine find_condensed_direction(system)
    type(system_t), intent(inout) :: system !! right given; gets solution, du, force_change
    real(wp), allocatable :: y(:), cy(:)
    real(wp) :: accuracy
    integer :: i

    call begin_cost(system%costs, cost_solve)
    associate (condensed => system%condensed)
      accuracy = coarsest
      if (condensed%norm_before > 0.0_wp) accuracy = min(coarsest, max(finest, &
        1.0e-3_wp*(norm2(condensed%right)/condensed%norm_before)**2))
      condensed%norm_before = norm2(condensed%right)
      allocate (y(condensed%n_live), cy(condensed%n_live))
      call respond(system, 1.0_wp, accuracy, 0.05_wp*system%round_off, y, cy)
      system%solution = 0.0_wp
      condensed%force_change = 0.0_wp
      do i = 1, condensed%n_live
        associate (c => condensed%live(i))
          condensed%force_change(c) = y(i) - condensed%right(i)
          system%du(condensed%direction(c), condensed%node(c)) = condensed%change(i)
          system%solution(system%equation(condensed%direction(c), condensed%node(c))) = &
            condensed%change(i)
        end associate
      end do
    end associate
    call end_cost(system%costs, cost_solve)
  end subroutine find_condensed_direction

  !> change = b - C y for b = share d + C r with the answer y of contact.
  subroutine respond(system, share, accuracy, floor, y, cy)
    type(system_t), intent(inout) :: system !! right given; gets change of condensed
    real(wp), intent(in) :: share !! of the defect
    real(wp), intent(in) :: accuracy !! relative
    real(wp), intent(in) :: floor !! absolute [force]
    real(wp), intent(out) :: y(:), cy(:) !! (live) answer of contact and its displacement
    real(wp), allocatable :: b(:)

    associate (condensed => system%condensed)
      allocate (b(condensed%n_live), source=0.0_wp)
      call apply_compliance(condensed, condensed%right, b)
      b = b + share*condensed%defect(condensed%live)
      call answer(condensed, b, accuracy, floor, y, cy)
      condensed%change = b - cy
    end associate
  end subroutine respond

  !> Work of the change of the forces on the bulk's defect, which a start without equilibrium has.
  pure real(wp) function defect_energy(system) result(energy)
    type(system_t), intent(in) :: system !! direction found

    energy = 0.0_wp
    if (system%condensed%active) energy = abs(dot_product(system%condensed%force_change, &
      system%condensed%defect))
  end function defect_energy

  !> Length of the direction that the present tangent gives for the residual of a trial.
  real(wp) function next_condensed_length(system, length) result(next)
    type(system_t), intent(inout) :: system !! right of the trial given
    real(wp), intent(in) :: length !! the trial's share of the direction
    real(wp), allocatable :: y(:), cy(:)

    call begin_cost(system%costs, cost_solve)
    allocate (y(system%condensed%n_live), cy(system%condensed%n_live))
    call respond(system, 1.0_wp - length, length_accuracy, 0.0_wp, y, cy)
    next = norm2(system%condensed%change)
    call end_cost(system%costs, cost_solve)
  end function next_condensed_length
end module condensed_direction
