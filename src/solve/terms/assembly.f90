!> The assembly loop of contact: gather, element routine, scatter.
module assembly
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: element_t, task_tangent, task_stick_tangent, task_residual, &
    task_shift_tangent, task_stick_shift_tangent, n_element_stress, status_stick, status_slip, &
    routine_none
  use element_lists, only: element_list_t, batch_size, threads_of
  use elmlib, only: element_routine
  use element_parameters, only: n_parameters, d03_mu
  use block_matrix, only: block_matrix_t
  use bulk_assembly, only: scatter_column
  implicit none
  private
  public :: assemble, contact_forces, recover, shift_derivatives

  !> A point that carries the friction of its cone but for this share is on it.
  real(wp), parameter :: on_cone = 1.0e-6_wp

contains

  !> The internal force of all elements, and with task_tangent their matrices, added to a or handed
  !! out one by one.
  subroutine assemble(list, task, x, u, r, a, s, skew)
    type(element_list_t), intent(inout) :: list !! elements; gets h2 and status
    integer, intent(in) :: task !! task_tangent or task_residual
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force; what it was the last time, if
    !! the list knows where that acted [force]
    type(block_matrix_t), intent(inout), optional :: a !! matrix of task_tangent
    real(wp), intent(inout), optional :: s(:, :, :) !! (dofs, dofs, n) matrices of the elements
    real(wp), intent(out), optional :: skew !! largest |s - s^T|/|s| of what is added to a
    type(element_t), allocatable :: elements(:)
    integer :: first, k, i, batch

    batch = batch_size(list%n)
    allocate (elements(batch))
    if (task == task_tangent) call give_room(3*size(list%ix, 1), elements)
    if (present(skew)) skew = 0.0_wp
    call clear_forces(list, r)
    do first = 1, list%n, batch
      call compute(list, task, x, u, first, elements)
      do k = first, min(first + batch - 1, list%n)
        if (list%routine(k) == routine_none) cycle
        associate (e => elements(k - first + 1))
          do i = 1, e%nel
            associate (node => e%ix(i))
              r(1, node) = r(1, node) + e%r(3*i - 2)
              r(2, node) = r(2, node) + e%r(3*i - 1)
              r(3, node) = r(3, node) + e%r(3*i)
            end associate
          end do
          if (task == task_tangent .and. present(a)) then
            if (present(skew)) skew = max(skew, asymmetry(e))
            do i = 1, e%nel
              call scatter_column(list%block(:e%nel, i, k), e%s(:, 3*i - 2:3*i), a)
            end do
          end if
          if (task == task_tangent .and. present(s)) s(:, :, k) = e%s(:size(s, 1), :size(s, 2))
        end associate
      end do
    end do
  end subroutine assemble

  !> The internal force of all elements.
  subroutine contact_forces(list, x, u, r)
    type(element_list_t), intent(inout) :: list !! elements; gets h2 and status
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) as assemble takes it [force]

    call assemble(list, task_residual, x, u, r)
  end subroutine contact_forces

  !> Takes the forces of the last time away, and notes where the next ones will act. Where elements
  !! are many beside the nodes that is not noted.
  pure subroutine clear_forces(list, r)
    type(element_list_t), intent(inout) :: list !! elements; gets reached
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) gets zeros [force]
    integer :: k, n

    if (allocated(list%reached)) then
      r(:, list%reached) = 0.0_wp
    else
      r = 0.0_wp
    end if
    n = sum(list%nel, list%routine /= routine_none)
    if (n > size(r, 2)) then
      if (allocated(list%reached)) deallocate (list%reached)
      return
    end if
    if (allocated(list%reached)) then
      if (size(list%reached) /= n) deallocate (list%reached)
    end if
    if (.not. allocated(list%reached)) allocate (list%reached(n))
    n = 0
    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      list%reached(n + 1:n + list%nel(k)) = list%ix(:list%nel(k), k)
      n = n + list%nel(k)
    end do
  end subroutine clear_forces

  !> Room for matrices no larger than those of the elements of a list.
  pure subroutine give_room(dofs, elements)
    integer, intent(in) :: dofs !! most degrees of freedom of an element
    type(element_t), intent(inout) :: elements(:) !! get s
    integer :: k

    do k = 1, size(elements)
      allocate (elements(k)%s(dofs, dofs), source=0.0_wp)
    end do
  end subroutine give_room

  !> Computes a batch of elements, each by itself.
  subroutine compute(list, task, x, u, first, elements)
    type(element_list_t), intent(inout) :: list !! elements; gets h2, status and slip
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of the batch
    type(element_t), intent(inout) :: elements(:) !! local data of each
    integer :: k, last

    last = min(first + size(elements) - 1, list%n)
    if (threads_of(list%n) > 1) then
      !$omp parallel do default(none) private(k) shared(list, task, x, u, first, last, elements)
      do k = first, last
        call compute_one(list, task, x, u, k, elements(k - first + 1))
      end do
      !$omp end parallel do
    else
      do k = first, last
        call compute_one(list, task, x, u, k, elements(k - first + 1))
      end do
    end if
  end subroutine compute

  !> Computes one element, unless it is idle.
  subroutine compute_one(list, task, x, u, k, e)
    type(element_list_t), intent(inout) :: list !! elements; gets h2, status and slip
    integer, intent(in) :: task !! what it is told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: k !! the element
    type(element_t), intent(inout) :: e !! its local data

    if (list%routine(k) == routine_none) return
    call gather(list, k, x, u, e)
    if (task == task_tangent) then
      call compute_tangent(list, k, e)
    else
      call element_routine(list%routine(k), task, list%d(:, k), e)
    end if
    list%h2(:, k) = e%h2
    list%path2(k) = e%path2
    list%status(k) = e%status
    list%slip(:, k) = e%slip
  end subroutine compute_one

  !> Matrix and force of one element. A contact point may be taken for one that sticks, is closed or
  !! slips (doc/theory, "Predicted active set").
  subroutine compute_tangent(list, k, e)
    type(element_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    type(element_t), intent(inout) :: e !! local data; gets r, s

    if (list%hold(k)) then
      call element_routine(list%routine(k), task_stick_tangent, list%d(:, k), e)
      return
    end if
    e%shift(3) = e%shift(3) + list%keep(k)
    call element_routine(list%routine(k), task_tangent, list%d(:, k), e)
    if (list%slide(k) .and. e%status == status_stick) call take_slip(list, k, e)
    if (abs(list%keep(k)) > 0.0_wp) call move_back(list%keep(k), e)
  end subroutine compute_tangent

  !> Force of a contact point in the frame of its facet and its derivatives, the point taken as
  !! compute_tangent takes it.
  subroutine shift_derivatives(list, k, x, u, e)
    type(element_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(element_t), intent(inout) :: e !! gets s, stress (element_types, task_shift_tangent)
    real(wp) :: d(n_parameters)
    logical :: on_its_cone

    call gather(list, k, x, u, e)
    d = list%d(:, k)
    if (list%hold(k)) then
      call element_routine(list%routine(k), task_stick_shift_tangent, d, e)
      return
    end if
    e%shift(3) = e%shift(3) + list%keep(k)
    call element_routine(list%routine(k), task_shift_tangent, d, e)
    on_its_cone = list%slide(k) .and. e%status == status_stick
    if (on_its_cone) then
      d(d03_mu:d03_mu + 1) = (1.0_wp - on_cone)*d(d03_mu:d03_mu + 1)
      call element_routine(list%routine(k), task_shift_tangent, d, e)
    end if
    if (abs(list%keep(k)) > 0.0_wp) e%stress(1:3) = e%stress(1:3) &
      - matmul(e%s(1:3, 1:3*e%slaves), slave_motion(list%keep(k), e))
  end subroutine shift_derivatives

  !> The matrix of slip for a point that sticks, if it is on its cone, where both are derivatives.
  subroutine take_slip(list, k, e)
    type(element_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    type(element_t), intent(inout) :: e !! r and s in stick; gets s
    type(element_t) :: slipping
    real(wp) :: d(n_parameters)

    d = list%d(:, k)
    d(d03_mu:d03_mu + 1) = (1.0_wp - on_cone)*d(d03_mu:d03_mu + 1)
    slipping = e
    call element_routine(list%routine(k), task_tangent, d, slipping)
    if (slipping%status == status_slip) e%s = slipping%s
  end subroutine take_slip

  !> Force of a contact point at its place from that at a shifted gap, to first order: as if it had
  !! been moved by the shift, and were moved back.
  pure subroutine move_back(shift, e)
    real(wp), intent(in) :: shift !! along the facet's normal [length]
    type(element_t), intent(inout) :: e !! r and s at the shifted gap; gets r
    real(wp) :: motion(3*e%slaves)

    motion = slave_motion(shift, e)
    e%r(1:3*e%nel) = e%r(1:3*e%nel) - matmul(e%s(1:3*e%nel, 1:3*e%slaves), motion)
  end subroutine move_back

  !> The slave nodes of a contact point moved along its facet's normal.
  pure function slave_motion(way, e) result(motion)
    real(wp), intent(in) :: way !! along the facet's normal [length]
    type(element_t), intent(in) :: e !! local data
    real(wp) :: motion(3*e%slaves)
    real(wp) :: x(3, 3), normal(3)
    integer :: n

    n = e%slaves
    x = e%xl(:, n + 1:n + 3) + e%ul(:, n + 1:n + 3)
    normal = cross(x(:, 1) - x(:, 3), x(:, 2) - x(:, 3))
    motion = reshape(spread(way*normal/norm2(normal), 2, n), [3*n])
  end function slave_motion

  !> Largest difference of an element's matrix from its transpose over its largest entry.
  pure real(wp) function asymmetry(e)
    type(element_t), intent(in) :: e !! local data with its matrix
    real(wp) :: difference
    integer :: i, j

    difference = 0.0_wp
    do j = 2, 3*e%nel
      do i = 1, j - 1
        difference = max(difference, abs(e%s(i, j) - e%s(j, i)))
      end do
    end do
    asymmetry = difference
    if (difference > 0.0_wp) asymmetry = difference/maxval(abs(e%s(1:3*e%nel, 1:3*e%nel)))
  end function asymmetry

  !> Result of task_stress for all elements.
  subroutine recover(list, task, x, u, stress)
    type(element_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! task_stress
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(out) :: stress(:, :) !! (n_element_stress, n) results
    type(element_t) :: e
    integer :: k

    do k = 1, list%n
      stress(1:n_element_stress, k) = 0.0_wp
      if (list%routine(k) == routine_none) cycle
      call gather(list, k, x, u, e)
      call element_routine(list%routine(k), task, list%d(:, k), e)
      stress(1:n_element_stress, k) = e%stress
    end do
  end subroutine recover

  !> Local data of one element.
  subroutine gather(list, k, x, u, e)
    type(element_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(element_t), intent(inout) :: e !! local data
    integer :: i

    e%number = k
    e%nel = list%nel(k)
    e%slaves = list%slaves(k)
    if (e%slaves > 1) then
      e%weight(:e%slaves) = list%weight(:e%slaves, k)
      e%lift = list%lift(k)
    end if
    e%ix(1:e%nel) = list%ix(1:e%nel, k)
    do i = 1, e%nel
      e%xl(:, i) = x(:, e%ix(i))
      e%ul(:, i) = u(:, e%ix(i))
    end do
    e%h1 = list%h1(:, k)
    e%path1 = list%path1(k)
    e%shift = list%shift(:, k)
    e%offset = list%offset(k)
  end subroutine gather
end module assembly
