!> The bulk: forces, tangent and states of its elements, element by element.
module bulk_assembly
  use kinds, only: wp
  use element_types, only: task_tangent, task_residual, task_stress, task_reach
  use solid_types, only: solid_t
  use element_lists, only: bulk_list_t, batch_size, on_threads
  use elmlib, only: solid_routine, routine_none, routine_finite
  use block_matrix, only: block_matrix_t
  implicit none
  private
  public :: assemble_bulk, recover_bulk, find_bulk_reach, scatter_block

contains

  !> Adds the internal force of all elements to r and their energy, and their matrices to a if it is
  !! there. An element that is turned inside out has no answer: it is named, and nothing else holds.
  subroutine assemble_bulk(list, x, u, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements, located in a if it is there
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(out) :: energy !! strain energy of what is not linear [force length]
    integer, intent(out) :: inverted !! element turned inside out, or 0
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    type(solid_t), allocatable :: elements(:)
    integer :: first, k, i, task

    task = task_residual
    if (present(a)) task = task_tangent
    allocate (elements(batch_size(list%n)))
    energy = 0.0_wp
    inverted = 0
    do first = 1, list%n, size(elements)
      call compute(list, task, x, u, first, elements)
      do k = first, min(first + size(elements) - 1, list%n)
        if (list%routine(k) == routine_none) cycle
        associate (e => elements(k - first + 1))
          if (e%inverted .and. inverted == 0) inverted = k
          energy = energy + e%energy
          do i = 1, e%nel
            r(:, e%ix(i)) = r(:, e%ix(i)) + e%r(3*i - 2:3*i)
          end do
          if (present(a)) call scatter_block(list%block(:e%nel, :e%nel, k), e%s, a)
        end associate
      end do
      if (inverted > 0) return
    end do
  end subroutine assemble_bulk

  !> Computes a batch of elements, each by itself.
  subroutine compute(list, task, x, u, first, elements)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of the batch
    type(solid_t), intent(inout) :: elements(:) !! local data of each
    integer :: k, last
    logical :: parallel

    last = min(first + size(elements) - 1, list%n)
    parallel = on_threads(list%n)
    !$omp parallel do if(parallel) default(none) private(k) &
    !$omp& shared(list, task, x, u, first, last, elements)
    do k = first, last
      if (list%routine(k) == routine_none) cycle
      associate (e => elements(k - first + 1))
        call gather(list, k, x, u, e)
        call solid_routine(list%routine(k), task, list%d(:, list%set(k)), e)
      end associate
    end do
    !$omp end parallel do
  end subroutine compute

  !> States of some elements (solid_types).
  subroutine recover_bulk(list, x, u, first, state)
    type(bulk_list_t), intent(in) :: list !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! the first of them
    real(wp), intent(out) :: state(:, :) !! (n_solid_state, some) states, zero where there is none
    type(solid_t) :: e
    integer :: k, i

    state = 0.0_wp
    do i = 1, size(state, 2)
      k = first + i - 1
      if (list%routine(k) == routine_none) cycle
      call gather(list, k, x, u, e)
      call solid_routine(list%routine(k), task_stress, list%d(:, list%set(k)), e)
      state(:, i) = e%state
    end do
  end subroutine recover_bulk

  !> How far the bulk can go along a way before an element is turned inside out.
  subroutine find_bulk_reach(list, x, u, du, reach, worst)
    type(bulk_list_t), intent(in) :: list !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) way on from there [length]
    real(wp), intent(out) :: reach !! share of the way, huge if nothing stops it
    integer, intent(out) :: worst !! the element, 0 if nothing stops it
    type(solid_t) :: e
    integer :: k, i

    reach = huge(1.0_wp)
    worst = 0
    do k = 1, list%n
      if (list%routine(k) /= routine_finite) cycle
      call gather(list, k, x, u, e)
      do i = 1, e%nel
        e%dul(:, i) = du(:, e%ix(i))
      end do
      call solid_routine(list%routine(k), task_reach, list%d(:, list%set(k)), e)
      if (e%reach >= reach) cycle
      reach = e%reach
      worst = k
    end do
  end subroutine find_bulk_reach

  !> Local data of one element.
  pure subroutine gather(list, k, x, u, e)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(solid_t), intent(inout) :: e !! local data
    integer :: i

    e%nel = list%nel(k)
    e%ix(1:e%nel) = list%ix(1:e%nel, k)
    do i = 1, e%nel
      e%xl(:, i) = x(:, e%ix(i))
      e%ul(:, i) = u(:, e%ix(i))
    end do
  end subroutine gather

  !> Adds an element matrix block by block.
  pure subroutine scatter_block(place, s, a)
    integer, intent(in) :: place(:, :) !! (nodes, nodes) places in a
    real(wp), intent(in) :: s(:, :) !! the matrix [force/length]
    type(block_matrix_t), intent(inout) :: a !! takes it
    integer :: i, j

    do j = 1, size(place, 2)
      do i = 1, size(place, 1)
        associate (val => a%val(:, :, place(i, j)))
          val = val + s(3*i - 2:3*i, 3*j - 2:3*j)
        end associate
      end do
    end do
  end subroutine scatter_block
end module bulk_assembly
