!> What the multipliers of a pair are weighed with: dual functions on the slave facets, rows of
!! weighted gaps, frames (doc/theory, "Mortar contact", eqs. (7.13), (7.14)).
!!
!! Eq. (7.13): `add_point` adds to the sums, `keep_covered` divides by W_i; the gaps that the rows
!! give at any positions are those of `find_gaps` of mortar_unknowns.
module mortar_weights
  use kinds, only: wp
  use contact_types, only: pair_t
  use mortar_types, only: mortar_t
  use mortar_functions, only: dual_functions, hat_functions, frame_of
  use contact_overlap, only: withheld_gap
  use contact_points, only: count_points
  use mortar_under, only: under_t, look_under, most_masters
  use slave_places, only: is_bent, slave_nodes
  implicit none
  private
  public :: weigh_nodes

  !> A node of which less than this share is covered has no multiplier.
  real(wp), parameter :: least_cover = 1.0e-4_wp
  !> A node none of whose points is nearer to the master than this share of its width has no
  !! multiplier either: each round looks anew.
  real(wp), parameter :: far_away = 0.25_wp
  !> Nodes of a slave facet that a point has weights at.
  integer, parameter :: most_slaves = 6

  !> Entries of the rows before they are sorted.
  type :: entries_t
    integer :: n = 0 !! how many
    logical :: again = .false. !! the next ones are added to those that stand there
    integer, allocatable :: row(:) !! multiplier
    integer, allocatable :: column(:) !! node
    real(wp), allocatable :: now(:) !! weight
    real(wp), allocatable :: before(:) !! weight at the apexes
  end type entries_t

contains

  !> Rows, weights and frames of the multipliers of a pair with its bodies at x.
  pure subroutine weigh_nodes(pair, used, x, nodes)
    type(pair_t), intent(in) :: pair !! cells, targets and apexes of its points
    logical, intent(in) :: used(:) !! (points) that count
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_t), intent(out) :: nodes !! gets all but forces and history
    type(entries_t) :: entries
    real(wp), allocatable :: normal(:, :), axis(:, :)
    integer, allocatable :: last(:), before(:)
    integer :: most, first, end, f

    most = 3*count(used)
    allocate (nodes%node(most), nodes%face(most), nodes%weight(most), nodes%offset(most))
    allocate (nodes%owner(3, size(used)), source=0)
    allocate (nodes%share(3, size(used)), source=0.0_wp)
    allocate (normal(4, most), axis(3, most), before(most), last(size(x, 2)))
    last = 0
    call make_room(3*(most_slaves + most_masters)*count(used), entries)
    first = 1
    do while (first <= count_points(pair))
      f = pair%history%cells(first)%slave
      if (f == 0) exit
      end = first
      do while (end < count_points(pair))
        if (pair%history%cells(end + 1)%slave /= f) exit
        end = end + 1
      end do
      call weigh_facet(pair, f, first, end, used, x, nodes, normal, axis, last, before, entries)
      first = end + 1
    end do
    call keep_covered(pair, normal, axis, nodes, entries)
    call sort_rows(size(x, 2), entries, nodes)
  end subroutine weigh_nodes

  !> Room for so many entries.
  pure subroutine make_room(most, entries)
    integer, intent(in) :: most !! at most
    type(entries_t), intent(out) :: entries !! empty

    allocate (entries%row(most), entries%column(most), entries%now(most), entries%before(most))
  end subroutine make_room

  !> Adds the shares of the points of one slave facet, part by part and face by face.
  pure subroutine weigh_facet(pair, f, first, last, used, x, nodes, normal, axis, latest, before, &
    entries)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: first, last !! its points
    logical, intent(in) :: used(:) !! (points) that count
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_t), intent(inout) :: nodes !! multipliers, weights, owners
    real(wp), intent(inout) :: normal(:, :) !! (4, multipliers) sums of normals, and least gap
    real(wp), intent(inout) :: axis(:, :) !! (3, multipliers) sums of axes
    integer, intent(inout) :: latest(:) !! (nodes) last multiplier of each node
    integer, intent(inout) :: before(:) !! (multipliers) the one before of the same node
    type(entries_t), intent(inout) :: entries !! entries of the rows
    integer :: point(last - first + 1), corner(3, last - first + 1), own(3), n, p, part, &
      face, target, start
    real(wp) :: hat(3, last - first + 1), psi(3, last - first + 1), area(last - first + 1)
    logical :: left(last - first + 1)

    do p = first, last
      left(p - first + 1) = used(p)
    end do
    do while (any(left))
      n = 0
      part = 0
      face = 0
      do p = first, last
        if (.not. left(p - first + 1)) cycle
        associate (cell => pair%history%cells(p))
          call hat_functions(is_bent(pair, f), cell%weight, own, hat(:, n + 1), part)
          if (face == 0) face = pair%faces(pair%history%new(p)%target)
          if (n > 0) then
            if (any(own /= corner(:, 1)) .or. pair%faces(pair%history%new(p)%target) /= face) cycle
          end if
          n = n + 1
          corner(:, n) = own
          point(n) = p
          area(n) = cell%area
          left(p - first + 1) = .false.
        end associate
      end do
      call dual_functions(hat(:, :n), area(:n), psi(:, :n))
      associate (facet => slave_nodes(pair, f))
        own = facet(corner(:, 1))
        if (allocated(pair%carrier)) own = pair%carrier(own)
      end associate
      call find_multipliers(own, face, nodes, normal, axis, latest, before)
      target = 0
      do p = 1, n
        ! points of one cell have the same nodes
        entries%again = pair%history%new(point(p))%target == target
        target = pair%history%new(point(p))%target
        if (entries%again) entries%n = start
        start = entries%n
        call add_point(pair, point(p), own, hat(:, p), psi(:, p), x, nodes, normal, axis, entries)
      end do
    end do
  end subroutine weigh_facet

  !> The multipliers of three nodes on a face; new ones have no weight yet.
  pure subroutine find_multipliers(own, face, nodes, normal, axis, latest, before)
    integer, intent(inout) :: own(3) !! in: nodes, out: multipliers
    integer, intent(in) :: face !! face of the master
    type(mortar_t), intent(inout) :: nodes !! multipliers
    real(wp), intent(inout) :: normal(:, :) !! (4, multipliers) sums of normals, and least gap
    real(wp), intent(inout) :: axis(:, :) !! (3, multipliers) sums of axes
    integer, intent(inout) :: latest(:) !! (nodes) last multiplier of each node
    integer, intent(inout) :: before(:) !! (multipliers) the one before of the same node
    integer :: k, i

    do k = 1, 3
      i = latest(own(k))
      do while (i > 0)
        if (nodes%face(i) == face) exit
        i = before(i)
      end do
      if (i == 0) then
        nodes%n = nodes%n + 1
        i = nodes%n
        before(i) = latest(own(k))
        latest(own(k)) = i
        nodes%node(i) = own(k)
        nodes%face(i) = face
        nodes%weight(i) = 0.0_wp
        nodes%offset(i) = 0.0_wp
        normal(:, i) = [0.0_wp, 0.0_wp, 0.0_wp, huge(1.0_wp)]
        axis(:, i) = 0.0_wp
      end if
      own(k) = i
    end do
  end subroutine find_multipliers

  !> Adds the shares of one point q: to W_i, S_ia and, with the sign of the gap, P_ij of eq. (7.13).
  pure subroutine add_point(pair, p, own, hat, psi, x, nodes, normal, axis, entries)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: own(3) !! its multipliers
    real(wp), intent(in) :: hat(3) !! their hat functions there
    real(wp), intent(in) :: psi(3) !! their dual functions there
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_t), intent(inout) :: nodes !! weights, offsets, owners
    real(wp), intent(inout) :: normal(:, :) !! (4, multipliers) sums of normals, and least gap
    real(wp), intent(inout) :: axis(:, :) !! (3, multipliers) sums of axes
    type(entries_t), intent(inout) :: entries !! entries of the rows
    type(under_t) :: under
    integer :: k, b
    real(wp) :: weight

    call look_under(pair, p, x, under)
    nodes%owner(:, p) = own
    nodes%share(:, p) = pair%history%cells(p)%area*psi
    do k = 1, 3
      weight = nodes%share(k, p)
      associate (i => own(k), positive => pair%history%cells(p)%area*hat(k))
        nodes%weight(i) = nodes%weight(i) + weight
        nodes%offset(i) = nodes%offset(i) + weight*withheld_gap(pair, p)
        normal(:3, i) = normal(:3, i) + positive*under%normal
        normal(4, i) = min(normal(4, i), under%gap)
        axis(:, i) = axis(:, i) + sign(positive, dot_product(axis(:, i), under%axis))*under%axis
        do b = 1, pair%points%n_slaves
          call add_entry(i, pair%points%point_nodes(b, p), &
            weight*pair%points%point_weights(b, p)*[1.0_wp, 1.0_wp], entries)
        end do
        do b = 1, under%n
          call add_entry(i, under%node(b), -weight*[under%now(b), under%before(b)], entries)
        end do
      end associate
    end do
  end subroutine add_point

  !> One more entry, or more of one.
  pure subroutine add_entry(row, column, value, entries)
    integer, intent(in) :: row !! multiplier
    integer, intent(in) :: column !! node
    real(wp), intent(in) :: value(2) !! at the projection, at the apex
    type(entries_t), intent(inout) :: entries !! grows

    entries%n = entries%n + 1
    associate (e => entries%n)
      if (.not. entries%again) then
        entries%row(e) = row
        entries%column(e) = column
        entries%now(e) = 0.0_wp
        entries%before(e) = 0.0_wp
      end if
      entries%now(e) = entries%now(e) + value(1)
      entries%before(e) = entries%before(e) + value(2)
    end associate
  end subroutine add_entry

  !> Drops what is hardly covered or far away; weights are divided out, means become frames.
  pure subroutine keep_covered(pair, normal, axis, nodes, entries)
    type(pair_t), intent(in) :: pair !! areas of the slave facets
    real(wp), intent(in) :: normal(:, :) !! (4, multipliers) sums of normals, and least gap
    real(wp), intent(in) :: axis(:, :) !! (3, multipliers) sums of axes
    type(mortar_t), intent(inout) :: nodes !! multipliers
    type(entries_t), intent(inout) :: entries !! entries of the rows
    integer :: place(0:nodes%n), i, k, n
    real(wp), allocatable :: area(:)

    area = node_areas(pair, nodes)
    place = 0
    n = 0
    allocate (nodes%frame(3, 3, nodes%n))
    do i = 1, nodes%n
      if (nodes%weight(i) < least_cover*area(i)) cycle
      if (normal(4, i) > far_away*sqrt(area(i))) cycle
      n = n + 1
      place(i) = n
      nodes%node(n) = nodes%node(i)
      nodes%face(n) = nodes%face(i)
      nodes%weight(n) = nodes%weight(i)
      nodes%offset(n) = nodes%offset(i)/nodes%weight(i)
      nodes%frame(:, :, n) = frame_of(normal(:3, i), axis(:, i))
    end do
    nodes%n = n
    nodes%frame = nodes%frame(:, :, :n)
    nodes%node = nodes%node(:n)
    nodes%face = nodes%face(:n)
    nodes%weight = nodes%weight(:n)
    nodes%offset = nodes%offset(:n)
    nodes%compliance = spread(0.0_wp, 1, n)
    nodes%owner = reshape(place([nodes%owner]), shape(nodes%owner))
    do i = 1, size(nodes%owner, 2)
      do k = 1, 3
        if (nodes%owner(k, i) > 0) nodes%share(k, i) = nodes%share(k, i) &
          /nodes%weight(nodes%owner(k, i))
      end do
    end do
    k = 0
    do i = 1, entries%n
      if (place(entries%row(i)) == 0) cycle
      k = k + 1
      entries%row(k) = place(entries%row(i))
      entries%column(k) = entries%column(i)
      entries%now(k) = entries%now(i)/nodes%weight(entries%row(k))
      entries%before(k) = entries%before(i)/nodes%weight(entries%row(k))
    end do
    entries%n = k
  end subroutine keep_covered

  !> Full areas of the nodes of the multipliers.
  pure function node_areas(pair, nodes) result(area)
    type(pair_t), intent(in) :: pair !! areas of the slave facets
    type(mortar_t), intent(in) :: nodes !! multipliers
    real(wp) :: area(nodes%n)
    real(wp), allocatable :: whole(:)
    integer :: f, k
    real(wp), parameter :: of_corners = 1.0_wp/12.0_wp, of_middles = 0.25_wp

    if (nodes%n == 0) return
    allocate (whole(max(maxval(nodes%node(:nodes%n)), maxval(pair%points%point_nodes))), &
      source=0.0_wp)
    do f = 1, size(pair%points%slave_facets, 2)
      associate (facet => slave_nodes(pair, f), size_f => pair%points%slave_area(f))
        do k = 1, 3
          whole(facet(k)) = whole(facet(k)) + size_f*merge(of_corners, 1.0_wp/3.0_wp, &
            is_bent(pair, f))
          if (is_bent(pair, f)) whole(facet(k + 3)) = whole(facet(k + 3)) + size_f*of_middles
        end do
      end associate
    end do
    area = whole(nodes%node(:nodes%n))
  end function node_areas

  !> Rows of weights: entries of one multiplier side by side, those of one node added up, in the
  !! order in which the points have come.
  pure subroutine sort_rows(n_nodes, entries, nodes)
    integer, intent(in) :: n_nodes !! nodes of the mesh
    type(entries_t), intent(in) :: entries !! entries
    type(mortar_t), intent(inout) :: nodes !! gets first, column, now, before
    integer :: start(nodes%n + 1), next(nodes%n), order(entries%n), place(n_nodes), i, k, n

    start = 0
    do k = 1, entries%n
      start(entries%row(k) + 1) = start(entries%row(k) + 1) + 1
    end do
    start(1) = 1
    do i = 1, nodes%n
      start(i + 1) = start(i) + start(i + 1)
    end do
    next = start(:nodes%n)
    do k = 1, entries%n
      order(next(entries%row(k))) = k
      next(entries%row(k)) = next(entries%row(k)) + 1
    end do
    allocate (nodes%first(nodes%n + 1), nodes%column(entries%n), nodes%now(entries%n), &
      nodes%before(entries%n))
    place = 0
    n = 0
    do i = 1, nodes%n
      nodes%first(i) = n + 1
      do k = start(i), start(i + 1) - 1
        associate (e => order(k))
          if (place(entries%column(e)) < nodes%first(i)) then
            n = n + 1
            place(entries%column(e)) = n
            nodes%column(n) = entries%column(e)
            nodes%now(n) = 0.0_wp
            nodes%before(n) = 0.0_wp
          end if
          associate (j => place(entries%column(e)))
            nodes%now(j) = nodes%now(j) + entries%now(e)
            nodes%before(j) = nodes%before(j) + entries%before(e)
          end associate
        end associate
      end do
    end do
    nodes%first(nodes%n + 1) = n + 1
    nodes%column = nodes%column(:n)
    nodes%now = nodes%now(:n)
    nodes%before = nodes%before(:n)
  end subroutine sort_rows
end module mortar_weights
