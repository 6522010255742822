!> Stress and strain at nodes from those inside the elements around: superconvergent patch recovery
!! (doc/theory, "Nodal stress").
!!
!! Around each corner a polynomial is fitted to the values at points of the elements (samples), in
!! each material for itself; it gives the values at the corner and, with that of the other end, in
!! the middles of edges.
module recovery
  use kinds, only: wp
  use cells, only: shapes, kind_of
  use cell_geometry, only: cell_volume, cell_middle
  use mesh_types, only: mesh_t
  use facets, only: node_elements
  use element_lists, only: bulk_list_t
  use element_types, only: routine_none
  use solid_types, only: most_points
  use solid_shapes, only: sample_places
  use patch_fits, only: recovery_t, patch_t, begin_patches, fit_patch, find_weights, find_terms, &
    solve_terms, most_terms
  implicit none
  private
  public :: recovery_t, prepare_recovery, recover_at_nodes

contains

  !> Lists samples and neighbours, and the weights of four nodes.
  subroutine prepare_recovery(recovery, mesh, bulk, single)
    type(recovery_t), intent(out) :: recovery !! gets all of it
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(bulk_list_t), intent(in) :: bulk !! its elements
    logical, intent(in) :: single !! one sample an element, what is even in it
    real(wp) :: places(3, most_points)
    integer :: e, n, most

    associate (elements => mesh%elements)
      most = merge(1, most_points, single .or. all(bulk%nel == 4))
      allocate (recovery%first(elements + 1), recovery%volume(elements))
      recovery%ten = bulk%nel > 4
      allocate (recovery%place(3, most*elements))
      recovery%first(1) = 1
      recovery%volume = 0.0_wp
      do e = 1, elements
        n = 0
        if (bulk%routine(e) /= routine_none) then
          recovery%volume(e) = abs(cell_volume(mesh%x, mesh%ix(:, e)))
          if (single) then
            n = 1
            places(:, 1) = cell_middle(mesh%x, mesh%ix(:, e))
          else
            call sample_places(bulk%nel(e), mesh%x(:, mesh%ix(:bulk%nel(e), e)), n, places)
          end if
        end if
        recovery%first(e + 1) = recovery%first(e) + n
        recovery%place(:, recovery%first(e):recovery%first(e + 1) - 1) = places(:, :n)
      end do
      recovery%place = recovery%place(:, :recovery%first(elements + 1) - 1)
    end associate
    call node_elements(mesh, recovery%first(2:) > recovery%first(:mesh%elements), recovery%begin, &
      recovery%around)
    call find_rows(recovery, mesh)
  end subroutine prepare_recovery

  !> Weights of the samples at corners of elements of four nodes.
  subroutine find_rows(recovery, mesh)
    type(recovery_t), intent(inout) :: recovery !! gets row, column, weight
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(patch_t) :: patch
    real(wp) :: whole, share
    real(wp), allocatable :: weight(:)
    integer :: v, i, material, n

    allocate (recovery%row(mesh%nodes + 1), recovery%column(1024), recovery%weight(1024))
    call begin_patches(patch, recovery)
    n = 0
    do v = 1, mesh%nodes
      recovery%row(v) = n + 1
      associate (mine => recovery%around(recovery%begin(v):recovery%begin(v + 1) - 1))
        if (any(recovery%ten(mine))) cycle
        whole = sum(recovery%volume(mine))
        do i = 1, size(mine)
          material = mesh%material(mine(i))
          if (any(mesh%material(mine(:i - 1)) == material)) cycle
          call fit_patch(recovery, mesh, v, material, patch)
          call find_weights(patch, weight)
          share = sum(recovery%volume(patch%list(:patch%own)))/whole
          call append_row(recovery, patch%sample(:patch%samples), share*weight, n)
        end do
      end associate
    end do
    recovery%row(mesh%nodes + 1) = n + 1
    recovery%column = recovery%column(:n)
    recovery%weight = recovery%weight(:n)
  end subroutine find_rows

  !> Lengthens the row of a node.
  pure subroutine append_row(recovery, samples, weights, n)
    type(recovery_t), intent(inout) :: recovery !! gets columns, weights
    integer, intent(in) :: samples(:) !! samples
    real(wp), intent(in) :: weights(:) !! their weights
    integer, intent(inout) :: n !! columns so far
    integer, allocatable :: longer(:)
    real(wp), allocatable :: heavier(:)

    if (n + size(samples) > size(recovery%column)) then
      allocate (longer(2*(n + size(samples))), heavier(2*(n + size(samples))))
      longer(:n) = recovery%column(:n)
      heavier(:n) = recovery%weight(:n)
      call move_alloc(longer, recovery%column)
      call move_alloc(heavier, recovery%weight)
    end if
    recovery%column(n + 1:n + size(samples)) = samples
    recovery%weight(n + 1:n + size(samples)) = weights
    n = n + size(samples)
  end subroutine append_row

  !> Values at nodes from those of the samples; zero where no element with samples is. Where
  !! materials meet, the mean of theirs by their volumes around the node.
  subroutine recover_at_nodes(recovery, mesh, samples, values)
    type(recovery_t), intent(in) :: recovery !! prepared
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(in), contiguous :: samples(:, :) !! (components, samples) their values
    real(wp), intent(out) :: values(:, :) !! (components, nodes) those of the nodes
    type(patch_t) :: patch
    real(wp), allocatable :: share(:)
    integer :: v, i, material

    allocate (share(mesh%nodes), source=0.0_wp)
    call begin_patches(patch, recovery)
    values = 0.0_wp
    do v = 1, mesh%nodes
      if (recovery%row(v + 1) > recovery%row(v)) then
        do i = 1, size(values, 1), 6
          call weigh(recovery, v, samples, i, values(i:, v))
        end do
        cycle
      end if
      associate (mine => recovery%around(recovery%begin(v):recovery%begin(v + 1) - 1))
        do i = 1, size(mine)
          material = mesh%material(mine(i))
          if (any(mesh%material(mine(:i - 1)) == material)) cycle
          call fit_patch(recovery, mesh, v, material, patch)
          call spread_patch(recovery, mesh, v, patch, samples, values, share)
        end do
      end associate
    end do
    do v = 1, mesh%nodes
      if (share(v) > 0.0_wp) values(:, v) = values(:, v)/share(v)
    end do
  end subroutine recover_at_nodes

  !> The weighted sum of the samples of a corner, of six components at most: their number known,
  !! the compiler keeps the sums in registers.
  pure subroutine weigh(recovery, v, samples, first, values)
    type(recovery_t), intent(in) :: recovery !! rows of weights
    integer, intent(in) :: v !! the corner
    real(wp), intent(in), contiguous :: samples(:, :) !! (components, samples) their values
    integer, intent(in) :: first !! the first of the components
    real(wp), intent(inout) :: values(:) !! these components get the sum
    real(wp) :: total(6)
    integer :: k, i, n

    n = min(6, size(values))
    total = 0.0_wp
    if (n == 6) then
      do k = recovery%row(v), recovery%row(v + 1) - 1
        do i = 1, 6
          total(i) = total(i) + recovery%weight(k)*samples(first - 1 + i, recovery%column(k))
        end do
      end do
    else
      do k = recovery%row(v), recovery%row(v + 1) - 1
        do i = 1, n
          total(i) = total(i) + recovery%weight(k)*samples(first - 1 + i, recovery%column(k))
        end do
      end do
    end if
    values(:n) = total(:n)
  end subroutine weigh

  !> Adds what a patch says of its corner and of the middles of the edges there, by the volumes of
  !! the elements around.
  subroutine spread_patch(recovery, mesh, v, patch, samples, values, share)
    type(recovery_t), intent(in) :: recovery !! prepared
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: v !! the corner
    type(patch_t), intent(in) :: patch !! fitted around it
    real(wp), intent(in) :: samples(:, :) !! (components, samples) values
    real(wp), intent(inout) :: values(:, :) !! (components, nodes) sums of values times volumes
    real(wp), intent(inout) :: share(:) !! (nodes) sums of volumes
    real(wp) :: c(most_terms, size(samples, 1)), b(most_terms)
    integer :: s, i, k, m, shape

    c = 0.0_wp
    do s = 1, patch%samples
      do k = 1, size(samples, 1)
        c(:patch%terms, k) = c(:patch%terms, k) + patch%b(:patch%terms, s) &
          *samples(k, patch%sample(s))
      end do
    end do
    do k = 1, size(samples, 1)
      call solve_terms(patch, c(:, k))
    end do
    do i = 1, patch%own
      associate (e => patch%list(i), volume => recovery%volume(patch%list(i)))
        values(:, v) = values(:, v) + volume*c(1, :)
        share(v) = share(v) + volume
        if (.not. recovery%ten(e)) cycle
        shape = kind_of(mesh%ix(:, e))
        do m = shapes(shape)%corners + 1, shapes(shape)%nodes
          if (all(mesh%ix(shapes(shape)%ends(:, m), e) /= v)) cycle
          associate (n => mesh%ix(m, e))
            call find_terms((mesh%x(:, n) - patch%origin)/patch%size, patch%terms, b)
            values(:, n) = values(:, n) + volume*matmul(b(:patch%terms), c(:patch%terms, :))
            share(n) = share(n) + volume
          end associate
        end do
      end associate
    end do
  end subroutine spread_patch
end module recovery
