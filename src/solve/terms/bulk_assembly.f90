!> The bulk: forces, tangent and states of its elements, element by element.
module bulk_assembly
  use kinds, only: wp
  use element_types, only: task_tangent, task_residual, task_stress, task_reach
  use solid_types, only: solid_t, d_youngs_modulus, d_poissons_ratio, d_law, d_mean
  use law_linear, only: lame
  use bulk_laws, only: neohooke
  use tetrahedra_at_once, only: at_once, tetrahedra_t, deform_tetrahedra, strain_tetrahedra, &
    form_tangents, is_reach_far
  use element_lists, only: bulk_list_t, batch_size
  use elmlib, only: solid_routine, routine_none, routine_finite
  use block_matrix, only: block_matrix_t, find_blocks
  implicit none
  private
  public :: assemble_bulk, recover_bulk, find_bulk_reach, scatter_block

contains

  !> Adds the internal force of all elements to r and their energy, and their matrices to a if it is
  !! there. An element that is turned inside out has no answer: it is named, and nothing else holds.
  subroutine assemble_bulk(list, x, u, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements; what is not linear is located in a
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(out) :: energy !! strain energy of what is not linear [force length]
    integer, intent(out) :: inverted !! element turned inside out, or 0
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    type(solid_t), allocatable :: elements(:)
    type(tetrahedra_t), allocatable :: groups(:)
    integer :: first, k, task

    task = task_residual
    if (present(a)) task = task_tangent
    allocate (elements(batch_size(list%n)))
    allocate (groups((size(elements) - 1)/at_once + 1))
    energy = 0.0_wp
    inverted = 0
    do first = 1, list%n, size(elements)
      call compute(list, task, x, u, first, elements, groups)
      do k = first, min(first + size(elements) - 1, list%n)
        associate (group => groups((k - first)/at_once + 1))
          if (group%alike) then
            call add_alike(list, k, mod(k - first, at_once) + 1, group, r, energy, inverted, a)
          else
            call add_each(list, k, elements(k - first + 1), r, energy, inverted, a)
          end if
        end associate
      end do
      if (inverted > 0) return
    end do
  end subroutine assemble_bulk

  !> Adds what an element has computed.
  subroutine add_each(list, k, e, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    type(solid_t), intent(in) :: e !! its local data
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(inout) :: energy !! strain energy [force length]
    integer, intent(inout) :: inverted !! first element turned inside out, or 0
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    integer :: i

    if (list%routine(k) == routine_none) return
    if (e%inverted .and. inverted == 0) inverted = k
    energy = energy + e%energy
    do i = 1, e%nel
      r(:, e%ix(i)) = r(:, e%ix(i)) + e%r(3*i - 2:3*i)
    end do
    if (.not. present(a)) return
    if (allocated(list%block)) then
      call scatter_block(list%block(:e%nel, :e%nel, k), e%s, a)
    else
      call scatter_block(find_blocks(a, e%ix(:e%nel)), e%s, a)
    end if
  end subroutine add_each

  !> The same of one that has been computed with others.
  subroutine add_alike(list, k, n, group, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    integer, intent(in) :: n !! its place among the others
    type(tetrahedra_t), intent(in) :: group !! these
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(inout) :: energy !! strain energy [force length]
    integer, intent(inout) :: inverted !! first element turned inside out, or 0
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    integer :: i, j

    if (inverted == 0 .and. .not. group%j(n) > 0.0_wp) inverted = k
    energy = energy + group%energy(n)
    do i = 1, 4
      associate (node => list%ix(i, k))
        r(:, node) = r(:, node) + group%r(n, :, i)
      end associate
    end do
    if (.not. present(a)) return
    do j = 1, 4
      do i = 1, 4
        associate (place => list%block(i, j, k))
          a%val(:, :, place) = a%val(:, :, place) + group%s(:, :, i, j, n)
        end associate
      end do
    end do
  end subroutine add_alike

  !> Computes a batch of elements, each by itself or those that are alike at once.
  subroutine compute(list, task, x, u, first, elements, groups)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of the batch
    type(solid_t), intent(inout) :: elements(:) !! local data of each
    type(tetrahedra_t), intent(inout) :: groups(:) !! those that are alike
    integer :: k, last

    last = min(first + size(elements) - 1, list%n)
    if (last - first < at_once) then
      call compute_some(list, task, x, u, first, elements(:last - first + 1), groups(1))
      return
    end if
    !$omp parallel do default(none) private(k) &
    !$omp& shared(list, task, x, u, first, last, elements, groups)
    do k = first, last, at_once
      call compute_some(list, task, x, u, k, elements(k - first + 1:min(k + at_once - 1, last) &
        - first + 1), groups((k - first)/at_once + 1))
    end do
    !$omp end parallel do
  end subroutine compute

  !> Computes no more elements than there are at once.
  subroutine compute_some(list, task, x, u, first, elements, group)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of these
    type(solid_t), intent(inout) :: elements(:) !! local data of each
    type(tetrahedra_t), intent(inout) :: group !! those that are alike

    group%alike = are_alike(list, first, first + size(elements) - 1)
    if (group%alike) then
      call compute_alike(list, task, x, u, first, group)
    else
      call compute_each(list, task, x, u, first, elements)
    end if
  end subroutine compute_some

  !> Computes elements of any kind.
  subroutine compute_each(list, task, x, u, first, elements)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of these
    type(solid_t), intent(inout) :: elements(:) !! local data of each
    integer :: i, k

    do i = 1, size(elements)
      k = first + i - 1
      if (list%routine(k) == routine_none) cycle
      call gather(list, k, x, u, elements(i))
      call solid_routine(list%routine(k), task, list%d(:, list%set(k)), elements(i))
    end do
  end subroutine compute_each

  !> So many elements as are computed at once have four nodes and one neo-Hookean material without
  !! a mean dilatation.
  pure logical function are_alike(list, first, last) result(alike)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: first, last !! which of them

    alike = last - first + 1 == at_once .and. list%routine(first) == routine_finite
    if (.not. alike) return
    associate (set => list%set(first))
      alike = nint(list%d(d_law, set)) == neohooke .and. list%d(d_mean, set) <= 0.0_wp .and. &
        all(list%set(first:last) == set) .and. all(list%nel(first:last) == 4) .and. &
        all(list%routine(first:last) == routine_finite)
    end associate
  end function are_alike

  !> Computes elements that are alike.
  pure subroutine compute_alike(list, task, x, u, first, group)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! first element of these
    type(tetrahedra_t), intent(inout) :: group !! computed
    real(wp) :: lambda, g

    associate (d => list%d(:, list%set(first)))
      call lame(d(d_youngs_modulus), d(d_poissons_ratio), lambda, g)
    end associate
    call gather_alike(list, first, x, u, group)
    call deform_tetrahedra(group)
    call strain_tetrahedra(lambda, g, group)
    if (task == task_tangent) call form_tangents(lambda, g, group)
  end subroutine compute_alike

  !> Positions and displacements of elements that are alike.
  pure subroutine gather_alike(list, first, x, u, group)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: first !! first element of these
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(tetrahedra_t), intent(inout) :: group !! gets x, u
    integer :: i, a

    do i = 1, at_once
      do a = 1, 4
        associate (node => list%ix(a, first + i - 1))
          group%x(i, :, a) = x(:, node)
          group%u(i, :, a) = u(:, node)
        end associate
      end do
    end do
  end subroutine gather_alike

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
    logical :: far(at_once)
    integer :: first, last, k, i

    reach = huge(1.0_wp)
    worst = 0
    do first = 1, list%n, at_once
      last = min(first + at_once - 1, list%n)
      far = .false.
      if (are_alike(list, first, last)) call reach_alike(list, first, x, u, du, far)
      do k = first, last
        if (far(k - first + 1) .or. list%routine(k) /= routine_finite) cycle
        call gather(list, k, x, u, e)
        do i = 1, e%nel
          e%dul(:, i) = du(:, e%ix(i))
        end do
        call solid_routine(list%routine(k), task_reach, list%d(:, list%set(k)), e)
        if (e%reach >= reach) cycle
        reach = e%reach
        worst = k
      end do
    end do
  end subroutine find_bulk_reach

  !> Which of some elements that are alike a way does not turn inside out by far.
  pure subroutine reach_alike(list, first, x, u, du, far)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: first !! first element of these
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) way on from there [length]
    logical, intent(out) :: far(at_once) !! it is so
    type(tetrahedra_t) :: group
    real(wp) :: way(at_once, 3, 4)
    integer :: i, a

    call gather_alike(list, first, x, u, group)
    do i = 1, at_once
      do a = 1, 4
        way(i, :, a) = du(:, list%ix(a, first + i - 1))
      end do
    end do
    call deform_tetrahedra(group)
    call is_reach_far(group, way, far)
  end subroutine reach_alike

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
