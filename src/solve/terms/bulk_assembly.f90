!> The bulk: forces, tangent and states of its elements, element by element.
module bulk_assembly
  use kinds, only: wp
  use element_types, only: task_tangent, task_residual, task_stress, task_reach, routine_none, &
    routine_finite
  use solid_types, only: solid_t, d_youngs_modulus, d_poissons_ratio, d_mean
  use law_linear, only: lame
  use law_neohooke, only: neohooke_point
  use tetrahedra_at_once, only: points_at_once, tetrahedra_t, deform_tetrahedra, &
    strain_tetrahedra, form_tangents, is_reach_far
  use element_lists, only: bulk_list_t, threads_of
  use element_parts, only: part_nodes, elements_of_part
  use elmlib, only: solid_routine
  use block_matrix, only: block_matrix_t, find_column
  implicit none
  private
  public :: assemble_bulk, recover_bulk, recover_points, find_bulk_reach, remember_bulk, &
    scatter_column

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
    integer :: part(size(x, 2)), parts, p
    integer, allocatable :: turned(:)
    real(wp), allocatable :: energies(:)

    parts = threads_of(list%n)
    call part_nodes(x, parts, part)
    allocate (energies(parts), turned(parts))
    !$omp parallel do schedule(static, 1) default(none) &
    !$omp& shared(list, x, u, part, parts, r, energies, turned, a) if(parts > 1)
    do p = 1, parts
      call assemble_part(list, x, u, part, p, r, energies(p), turned(p), a)
    end do
    !$omp end parallel do
    energy = sum(energies)
    inverted = minval(turned)
    if (inverted > list%n) inverted = 0
  end subroutine assemble_bulk

  !> What one part of the nodes gets of the elements that reach it.
  subroutine assemble_part(list, x, u, part, mine, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: part(:) !! (nodes) their parts
    integer, intent(in) :: mine !! the part
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(out) :: energy !! of elements whose first node is of the part [force length]
    integer, intent(out) :: inverted !! first element turned inside out, or one more than there are
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    type(solid_t) :: e
    type(tetrahedra_t) :: group
    integer, allocatable :: which(:)
    integer :: first, last, k, task

    task = task_residual
    if (present(a)) task = task_tangent
    energy = 0.0_wp
    inverted = list%n + 1
    call elements_of_part(list, part, mine, which)
    do first = 1, size(which), points_at_once
      last = min(first + points_at_once - 1, size(which))
      if (are_alike(list, which(first:last))) then
        call compute_alike(list, task, x, u, which(first:last), group)
        do k = first, last
          call add_alike(list, which(k), k - first + 1, group, part, mine, r, energy, inverted, a)
        end do
      else
        do k = first, last
          call gather(list, which(k), x, u, e)
          call solid_routine(list%routine(which(k)), task, list%d(:, list%set(which(k))), e)
          call add_each(list, which(k), e, part, mine, r, energy, inverted, a)
        end do
      end if
      if (inverted <= list%n) return
    end do
  end subroutine assemble_part

  !> Adds what an element has computed.
  pure subroutine add_each(list, k, e, part, mine, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    type(solid_t), intent(in) :: e !! its local data
    integer, intent(in) :: part(:) !! (nodes) their parts
    integer, intent(in) :: mine !! the part that gets it
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(inout) :: energy !! strain energy [force length]
    integer, intent(inout) :: inverted !! first element turned inside out
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    integer :: i, place(size(e%ix))

    if (e%inverted) inverted = min(inverted, k)
    if (part(e%ix(1)) == mine) energy = energy + e%energy
    do i = 1, e%nel
      if (part(e%ix(i)) == mine) r(:, e%ix(i)) = r(:, e%ix(i)) + e%r(3*i - 2:3*i)
    end do
    if (.not. present(a)) return
    do i = 1, e%nel
      if (part(e%ix(i)) /= mine) cycle
      if (allocated(list%block)) then
        place(:e%nel) = list%block(:e%nel, i, k)
      else
        call find_column(a, e%ix(:e%nel), e%ix(i), place(:e%nel))
      end if
      call scatter_column(place(:e%nel), e%s(:, 3*i - 2:3*i), a)
    end do
  end subroutine add_each

  !> The same of one that has been computed with others.
  pure subroutine add_alike(list, k, n, group, part, mine, r, energy, inverted, a)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    integer, intent(in) :: n !! its place among the others
    type(tetrahedra_t), intent(in) :: group !! these
    integer, intent(in) :: part(:) !! (nodes) their parts
    integer, intent(in) :: mine !! the part that gets it
    real(wp), intent(inout) :: r(:, :) !! (3, nodes) internal force [force]
    real(wp), intent(inout) :: energy !! strain energy [force length]
    integer, intent(inout) :: inverted !! first element turned inside out
    type(block_matrix_t), intent(inout), optional :: a !! gets the tangent
    integer :: i, j

    if (.not. group%j(n) > 0.0_wp) inverted = min(inverted, k)
    if (part(list%ix(1, k)) == mine) energy = energy + group%energy(n)
    do i = 1, 4
      associate (node => list%ix(i, k))
        if (part(node) == mine) r(:, node) = r(:, node) + group%r(n, :, i)
      end associate
    end do
    if (.not. present(a)) return
    do j = 1, 4
      if (part(list%ix(j, k)) /= mine) cycle
      do i = 1, 4
        associate (place => list%block(i, j, k))
          a%val(:, :, place) = a%val(:, :, place) + group%s(:, :, i, j, n)
        end associate
      end do
    end do
  end subroutine add_alike

  !> So many elements as are computed at once have four nodes and one neo-Hookean material without
  !! a mean dilatation.
  pure logical function are_alike(list, which) result(alike)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: which(:) !! some of them

    alike = size(which) == points_at_once
    if (alike) alike = list%routine(which(1)) == routine_finite
    if (.not. alike) return
    associate (set => list%set(which(1)))
      alike = associated(list%law(set)%point, neohooke_point) .and. &
        list%d(d_mean, set) <= 0.0_wp .and. all(list%set(which) == set) .and. &
        all(list%nel(which) == 4) .and. all(list%routine(which) == routine_finite)
    end associate
  end function are_alike

  !> Computes elements that are alike.
  pure subroutine compute_alike(list, task, x, u, which, group)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: task !! what they are told
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: which(:) !! these
    type(tetrahedra_t), intent(inout) :: group !! computed
    real(wp) :: lambda, g

    associate (d => list%d(:, list%set(which(1))))
      call lame(d(d_youngs_modulus), d(d_poissons_ratio), lambda, g)
    end associate
    call gather_alike(list, which, x, u, group)
    call deform_tetrahedra(group)
    call strain_tetrahedra(lambda, g, group)
    if (task == task_tangent) call form_tangents(lambda, g, group)
  end subroutine compute_alike

  !> Positions and displacements of elements that are alike.
  pure subroutine gather_alike(list, which, x, u, group)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: which(:) !! these
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(tetrahedra_t), intent(inout) :: group !! gets x, u
    integer :: i, a

    do i = 1, points_at_once
      do a = 1, 4
        associate (node => list%ix(a, which(i)))
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
    real(wp) :: no_points(0, 0)
    integer :: no_place(0)

    call recover_points(list, x, u, first, state, no_place, no_points, no_points)
  end subroutine recover_bulk

  !> States of some elements, and of the points of those that have several.
  subroutine recover_points(list, x, u, first, state, place, points, even)
    type(bulk_list_t), intent(in) :: list !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: first !! the first of them
    real(wp), intent(out) :: state(:, :) !! (n_solid_state, some) states, zero where there is none
    integer, intent(in) :: place(:) !! (n + 1) first point of each element in the list of all
    !! points, (0) if their values are not wanted
    real(wp), intent(inout) :: points(:, :) !! (n_sample, all points) gets those of the elements
    !! with several
    real(wp), intent(inout) :: even(:, :) !! (2, n) gets what is even in these
    type(solid_t) :: e
    integer :: k, i
    logical :: pays

    pays = threads_of(size(state, 2)) > 1
    state = 0.0_wp
    !$omp parallel do schedule(static) default(none) private(k, e) &
    !$omp& shared(list, x, u, first, state, place, points, even) if(pays)
    do i = 1, size(state, 2)
      k = first + i - 1
      if (list%routine(k) == routine_none) cycle
      call gather(list, k, x, u, e)
      call solid_routine(list%routine(k), task_stress, list%d(:, list%set(k)), e)
      state(:, i) = e%state
      if (size(place) == 0 .or. e%nel == 4) cycle
      points(:, place(k):place(k + 1) - 1) = e%points(:, :place(k + 1) - place(k))
      even(:, k) = e%even
    end do
    !$omp end parallel do
  end subroutine recover_points

  !> How far the bulk can go along a way before an element is turned inside out.
  subroutine find_bulk_reach(list, x, u, du, reach, worst)
    type(bulk_list_t), intent(in) :: list !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) way on from there [length]
    real(wp), intent(out) :: reach !! share of the way, huge if nothing stops it
    integer, intent(out) :: worst !! the element, 0 if nothing stops it
    type(solid_t) :: e
    logical :: far(points_at_once)
    integer :: which(points_at_once), first, last, k, i

    reach = huge(1.0_wp)
    worst = 0
    do first = 1, list%n, points_at_once
      last = min(first + points_at_once - 1, list%n)
      far = .false.
      which = [(k, k=first, first + points_at_once - 1)]
      if (are_alike(list, which(:last - first + 1))) call reach_alike(list, which, x, u, du, far)
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
  pure subroutine reach_alike(list, which, x, u, du, far)
    type(bulk_list_t), intent(in) :: list !! elements
    integer, intent(in) :: which(:) !! these
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) way on from there [length]
    logical, intent(out) :: far(points_at_once) !! it is so
    type(tetrahedra_t) :: group
    real(wp) :: way(points_at_once, 3, 4)
    integer :: i, a

    call gather_alike(list, which, x, u, group)
    do i = 1, points_at_once
      do a = 1, 4
        way(i, :, a) = du(:, list%ix(a, which(i)))
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
    integer :: i, points

    e%point => list%law(list%set(k))%point
    e%finite = list%law(list%set(k))%finite
    e%nel = list%nel(k)
    e%ix(1:e%nel) = list%ix(1:e%nel, k)
    do i = 1, e%nel
      e%xl(:, i) = x(:, e%ix(i))
      e%ul(:, i) = u(:, e%ix(i))
    end do
    if (.not. allocated(list%memory)) return
    points = size(list%memory, 2)
    e%old(:size(list%memory, 1), :points) = list%memory(:, :, k)
  end subroutine gather

  !> What the points of all elements remember of displacements that have been accepted.
  subroutine remember_bulk(list, x, u)
    type(bulk_list_t), intent(inout) :: list !! elements; gets memory
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(solid_t) :: e
    integer :: k

    if (.not. allocated(list%memory)) return
    do k = 1, list%n
      if (list%routine(k) /= routine_finite) cycle
      call gather(list, k, x, u, e)
      call solid_routine(list%routine(k), task_residual, list%d(:, list%set(k)), e)
      list%memory(:, :, k) = e%new(:size(list%memory, 1), :size(list%memory, 2))
    end do
  end subroutine remember_bulk

  !> Adds a column of blocks of an element matrix.
  pure subroutine scatter_column(place, s, a)
    integer, intent(in) :: place(:) !! (nodes) places in a
    real(wp), intent(in) :: s(:, :) !! (dofs, 3) the column [force/length]
    type(block_matrix_t), intent(inout) :: a !! takes it
    integer :: i

    do i = 1, size(place)
      associate (val => a%val(:, :, place(i)))
        val = val + s(3*i - 2:3*i, :)
      end associate
    end do
  end subroutine scatter_column
end module bulk_assembly
