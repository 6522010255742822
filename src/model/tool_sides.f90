!> Which side of a tool of triangles is outside: files often have it wrong, for all facets or for
!! some (doc/theory, "Orientation of tool surfaces", eq. (10.9)).
module tool_sides
  use kinds, only: wp
  use text, only: to_text, count_noun
  use diagnostics, only: diagnostics_t, report_error, report_note
  use deck_types, only: location_t
  use mesh_types, only: mesh_t, surface_t
  use mesh_names, only: find_surface
  use facets, only: facet_table_t
  use facet_orders, only: facet_parts_t, agree_orders
  use facet_geometry, only: facet_normal, project_on_facet
  use facet_tree, only: facet_tree_t, build_tree, nearest_facet
  use cell_geometry, only: facet_vector
  use tool_slaves, only: slave_t, add_slave
  use contact_reader, only: pair_draft_t
  implicit none
  private
  public :: face_tools

  !> Two faces look at each other if the cosine between what one looks along and what it sees is
  !! larger (60 degrees).
  real(wp), parameter :: same_way_cosine = 0.5_wp
  !> A slave facet may lie behind a tool by this share of the height of its element, so that a back
  !! of a body one element thick is not taken for its front.
  real(wp), parameter :: overlap_share = 0.5_wp
  !> A side has the slave if at most this share of what sees the tool is on the other: round-off and
  !! boundaries make less, a slave on both sides more.
  real(wp), parameter :: stray = 0.05_wp
  !> Facets of a part that tell whether it lies in another one, at most.
  integer, parameter :: most_samples = 1000

  !> A part of a tool: its facets and the tree over them.
  type :: part_t
    integer, allocatable :: list(:) !! its facets in the surface
    integer, allocatable :: facets(:, :) !! (3, n) their corners
    type(facet_tree_t) :: tree !! over them
    real(wp) :: low(3) = 0.0_wp !! the box around it [length]
    real(wp) :: high(3) = 0.0_wp !! [length]
    real(wp) :: front = 0.0_wp !! area of slave facets that look at its front [length^2]
    real(wp) :: back = 0.0_wp !! and at its back
    real(wp) :: ahead = 0.0_wp !! share of slave bodies before its front
    real(wp) :: behind = 0.0_wp !! and behind it
    logical :: turn = .false. !! all its facets are to be turned
  end type part_t

contains

  !> Turns the facets of rigid masters of triangles so that neighbours agree and the outside is
  !! where the slaves are; what cannot be told is an error.
  subroutine face_tools(drafts, exterior, diagnostics, mesh)
    type(pair_draft_t), intent(in) :: drafts(:) !! the pairs as read
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! its surfaces without elements are turned
    type(slave_t), allocatable :: slaves(:)
    type(location_t) :: at
    integer :: i, k, index

    do k = 1, size(mesh%surfaces)
      if (.not. mesh%surfaces(k)%alone .or. mesh%surfaces(k)%exact) cycle
      allocate (slaves(0))
      do i = 1, size(drafts)
        if (.not. drafts(i)%has_form) cycle
        call find_surface(mesh, drafts(i)%pair%master, index)
        if (index /= k) cycle
        if (size(slaves) == 0) at = drafts(i)%pair%master_at
        call add_slave(drafts(i)%pair%slave, exterior, mesh, slaves)
      end do
      if (size(slaves) > 0) call face_tool(slaves, at, mesh%x, mesh%surfaces(k), diagnostics)
      deallocate (slaves)
    end do
  end subroutine face_tools

  !> Turns what is to be turned of one tool.
  subroutine face_tool(slaves, at, x, surface, diagnostics)
    type(slave_t), intent(in) :: slaves(:) !! what it is paired with
    type(location_t), intent(in) :: at !! where the deck makes it a master
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(surface_t), intent(inout) :: surface !! the tool
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(facet_parts_t) :: parts
    type(part_t), allocatable :: part(:)
    integer :: f, n, p

    call agree_orders(surface%facets, parts)
    if (size(parts%clash, 2) > 0) then
      call report_error(diagnostics, at, 'the surface '//surface%name//' has one side only, '// &
        'like a twisted ribbon: its '//facet_text(x, surface, parts%clash(1, 1))//' and its '// &
        facet_text(x, surface, parts%clash(2, 1))//' cannot look the same way', &
        'take one of them out of the file, or make two surfaces of it')
      return
    end if
    call take_parts(x, surface%facets, parts, part)
    call see_slaves(slaves, x, surface%facets, parts, part)
    call close_parts(slaves, x, at, surface, parts, part, diagnostics)
    do p = 1, parts%count
      if (.not. parts%closed(p)) call open_part(slaves, x, at, surface, parts, part(p), diagnostics)
    end do
    n = 0
    do f = 1, size(parts%of)
      if (part(parts%of(f))%turn) surface%facets(:, f) = surface%facets([2, 1, 3], f)
      if (part(parts%of(f))%turn .neqv. parts%turned(f)) n = n + 1
    end do
    if (n > 0) call report_note(diagnostics, at, 'surface '//surface%name//': '//to_text(n)// &
      ' of '//count_noun(size(parts%of), 'facet')//' turned: the order of their corners in the '// &
      'file has their outside where the slave is not')
  end subroutine face_tool

  !> A facet in words: its number in the surface, its nodes, its place.
  pure function facet_text(x, surface, f) result(t)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(surface_t), intent(in) :: surface !! the tool
    integer, intent(in) :: f !! the facet
    character(:), allocatable :: t
    real(wp) :: middle(3)

    middle = sum(x(:, surface%facets(:, f)), 2)/3.0_wp
    t = 'facet '//to_text(f)//' (nodes '//to_text(surface%facets(1, f))//' '// &
      to_text(surface%facets(2, f))//' '//to_text(surface%facets(3, f))//', about '// &
      to_text(middle(1), 4)//' '//to_text(middle(2), 4)//' '//to_text(middle(3), 4)//')'
  end function facet_text

  !> Facets, tree and box of each part.
  subroutine take_parts(x, facets, parts, part)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: facets(:, :) !! (3, n) corners
    type(facet_parts_t), intent(in) :: parts !! what hangs together
    type(part_t), allocatable, intent(out) :: part(:) !! the parts
    integer :: number(parts%count), f, p, k

    allocate (part(parts%count))
    number = 0
    do f = 1, size(parts%of)
      number(parts%of(f)) = number(parts%of(f)) + 1
    end do
    do p = 1, parts%count
      allocate (part(p)%list(number(p)))
    end do
    number = 0
    do f = 1, size(parts%of)
      p = parts%of(f)
      number(p) = number(p) + 1
      part(p)%list(number(p)) = f
    end do
    do p = 1, parts%count
      part(p)%facets = facets(:, part(p)%list)
      call build_tree(part(p)%tree, part(p)%facets, x)
      part(p)%low = [(minval(x(k, [part(p)%facets])), k=1, 3)]
      part(p)%high = [(maxval(x(k, [part(p)%facets])), k=1, 3)]
    end do
  end subroutine take_parts

  !> Slave facets that look at a part, from its front and from its back: such as see it ahead of
  !! them, touch it, or lie behind it by less than half of their element.
  subroutine see_slaves(slaves, x, facets, parts, part)
    type(slave_t), intent(in) :: slaves(:) !! the slaves
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: facets(:, :) !! (3, n) corners
    type(facet_parts_t), intent(in) :: parts !! what hangs together
    type(part_t), intent(inout) :: part(:) !! get front, back
    type(facet_tree_t) :: tree
    real(wp) :: distance, normal(3), along, cosine
    integer :: i, s, f

    call build_tree(tree, facets, x)
    do s = 1, size(slaves)
      associate (slave => slaves(s))
        do i = 1, size(slave%area)
          call nearest_facet(tree, facets, x, slave%x(:, i), f, distance)
          normal = facet_normal(x(:, facets(:, f)))
          along = dot_product(closest_point(x(:, facets(:, f)), slave%x(:, i)) - slave%x(:, i), &
            slave%normal(:, i))
          if (distance > overlap_share*slave%height(i) .and. along < same_way_cosine*distance) cycle
          cosine = dot_product(slave%normal(:, i), normal)
          associate (seen => part(parts%of(f)))
            if (cosine < -same_way_cosine) seen%front = seen%front + slave%area(i)
            if (cosine > same_way_cosine) seen%back = seen%back + slave%area(i)
          end associate
        end do
      end associate
    end do
  end subroutine see_slaves

  !> The point of a facet that is closest to another point.
  pure function closest_point(corner, y) result(z)
    real(wp), intent(in) :: corner(3, 3) !! corners [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: z(3), xi(2), gap, other(3), s
    integer :: k

    call project_on_facet(corner, y, xi, gap)
    z = y - gap*facet_normal(corner)
    if (min(xi(1), xi(2), 1.0_wp - xi(1) - xi(2)) >= 0.0_wp) return
    z = corner(:, 1)
    do k = 1, 3
      associate (a => corner(:, k), b => corner(:, mod(k, 3) + 1))
        s = dot_product(y - a, b - a)/sum((b - a)**2)
        other = a + min(1.0_wp, max(0.0_wp, s))*(b - a)
      end associate
      if (norm2(y - other) < norm2(y - z)) z = other
    end do
  end function closest_point

  !> Shares of some points before the front of a part and behind it; those beside its boundary count
  !! little.
  subroutine divide(x, part, y, weight, ahead, behind)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(part_t), intent(in) :: part !! the part
    real(wp), intent(in) :: y(:, :) !! (3, n) the points [length]
    real(wp), intent(in) :: weight(:) !! (n) what they count
    real(wp), intent(out) :: ahead !! share before it
    real(wp), intent(out) :: behind !! share behind it
    real(wp) :: distance, height, xi(2), total
    integer :: i, f

    ahead = 0.0_wp
    behind = 0.0_wp
    total = sum(weight)
    do i = 1, size(weight)
      call nearest_facet(part%tree, part%facets, x, y(:, i), f, distance)
      if (distance <= 0.0_wp) cycle
      call project_on_facet(x(:, part%facets(:, f)), y(:, i), xi, height)
      height = weight(i)*height/(distance*total)
      ahead = ahead + max(0.0_wp, height)
      behind = behind + max(0.0_wp, -height)
    end do
  end subroutine divide

  !> Closed parts look outwards, a closed part within another one inwards, and so on; where a slave
  !! lies in what would be the tool, the part is a cavity, and all is the other way round.
  subroutine close_parts(slaves, x, at, surface, parts, part, diagnostics)
    type(slave_t), intent(in) :: slaves(:) !! the slaves
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(location_t), intent(in) :: at !! where the deck makes it a master
    type(surface_t), intent(in) :: surface !! the tool
    type(facet_parts_t), intent(in) :: parts !! what hangs together
    type(part_t), intent(inout) :: part(:) !! get turn
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer :: depth(size(part)), root(size(part)), p, q, s, within(size(slaves))
    logical :: cavity(size(part)), solid(size(part))

    call turn_outwards(x, parts, part)
    depth = 0
    root = [(p, p=1, size(part))]
    do p = 1, size(part)
      do q = 1, size(part)
        if (p == q .or. .not. (parts%closed(p) .and. parts%closed(q))) cycle
        if (.not. lies_in(x, part(p), part(q))) cycle
        depth(p) = depth(p) + 1
        ! the outermost one is the largest
        if (product(part(q)%high - part(q)%low) > product(part(root(p))%high - &
          part(root(p))%low)) root(p) = q
      end do
    end do
    cavity = .false.
    solid = .false.
    do p = 1, size(part)
      if (.not. parts%closed(p) .or. root(p) /= p) cycle
      within = 0
      do q = 1, size(part)
        if (root(q) /= p .or. .not. parts%closed(q)) cycle
        do s = 1, size(slaves)
          if (holds(x, part(q), slaves(s)%inside, slaves(s)%volume)) within(s) = within(s) + 1
        end do
      end do
      cavity(p) = any(mod(within, 2) == 1)
      solid(p) = any(mod(within, 2) == 0)
      if (cavity(p) .and. solid(p)) call report_error(diagnostics, at, 'the surface '// &
        surface%name//' is closed about '//facet_text(x, surface, part(p)%list(1))// &
        ', and has slaves inside and outside', &
        'make two surfaces of it: two files, or two names for MESH AS')
    end do
    do p = 1, size(part)
      if (.not. parts%closed(p)) cycle
      part(p)%turn = part(p)%turn .neqv. (mod(depth(p), 2) == 1 .neqv. cavity(root(p)))
    end do
  end subroutine close_parts

  !> Closed parts look outwards: their volume is positive (divergence theorem).
  subroutine turn_outwards(x, parts, part)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(facet_parts_t), intent(in) :: parts !! what hangs together
    type(part_t), intent(inout) :: part(:) !! get turn, and facets in that order
    real(wp) :: volume, corner(3, 3)
    integer :: p, i

    do p = 1, size(part)
      if (.not. parts%closed(p)) cycle
      volume = 0.0_wp
      do i = 1, size(part(p)%list)
        corner = x(:, part(p)%facets(:, i)) - spread(part(p)%low, 2, 3)
        volume = volume + dot_product(corner(:, 1), facet_vector(corner))
      end do
      part(p)%turn = volume < 0.0_wp
      if (part(p)%turn) part(p)%facets = part(p)%facets([2, 1, 3], :)
    end do
  end subroutine turn_outwards

  !> A closed part lies in another one.
  logical function lies_in(x, inner, outer)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(part_t), intent(in) :: inner !! the one
    type(part_t), intent(in) :: outer !! the other one, outwards
    real(wp), allocatable :: y(:, :), one(:)
    integer :: i, n

    lies_in = .false.
    if (any(inner%low < outer%low) .or. any(inner%high > outer%high)) return
    n = min(most_samples, size(inner%list))
    allocate (y(3, n), one(n))
    one = 1.0_wp
    do i = 1, n
      y(:, i) = sum(x(:, inner%facets(:, i)), 2)/3.0_wp
    end do
    lies_in = holds(x, outer, y, one)
  end function lies_in

  !> Most of some points are within a closed part.
  logical function holds(x, part, y, weight)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(part_t), intent(in) :: part !! the part, outwards
    real(wp), intent(in) :: y(:, :) !! (3, n) the points [length]
    real(wp), intent(in) :: weight(:) !! (n) what they count
    real(wp) :: ahead, behind

    call divide(x, part, y, weight, ahead, behind)
    holds = behind > ahead
  end function holds

  !> An open part looks at the slaves that look at it. If none does, one all of whose facets agree
  !! in the file is left as it is, unless all of the slaves lies behind it.
  subroutine open_part(slaves, x, at, surface, parts, part, diagnostics)
    type(slave_t), intent(in) :: slaves(:) !! the slaves
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(location_t), intent(in) :: at !! where the deck makes it a master
    type(surface_t), intent(in) :: surface !! the tool
    type(facet_parts_t), intent(in) :: parts !! what hangs together
    type(part_t), intent(inout) :: part !! the part; gets turn
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    real(wp) :: ahead, behind
    integer :: s, f

    part%turn = part%back > part%front
    if (min(part%front, part%back) > stray*(part%front + part%back)) then
      call report_error(diagnostics, at, 'the surface '//surface%name//' is open about '// &
        facet_text(x, surface, part%list(1))//', and its slaves look at both of its sides', &
        'give each side a surface of its own (two files, or two names for MESH AS) and a pair')
      return
    end if
    if (part%front + part%back > 0.0_wp) return
    do s = 1, size(slaves)
      call divide(x, part, slaves(s)%inside, slaves(s)%volume, ahead, behind)
      part%ahead = part%ahead + ahead/real(size(slaves), wp)
      part%behind = part%behind + behind/real(size(slaves), wp)
    end do
    part%turn = part%behind > part%ahead
    if (max(part%ahead, part%behind) >= same_way_cosine .and. &
      min(part%ahead, part%behind) <= stray*(part%ahead + part%behind)) return
    part%turn = .false.
    if (all(parts%turned(part%list) .eqv. parts%turned(part%list(1)))) then
      part%turn = parts%turned(part%list(1))
      return
    end if
    f = findloc(parts%turned(part%list), .not. parts%turned(part%list(1)), dim=1)
    call report_error(diagnostics, at, 'of the surface '//surface%name//' '// &
      facet_text(x, surface, part%list(1))//' and '//facet_text(x, surface, part%list(f))// &
      ' look to different sides, and no slave facet tells which is right', &
      'give the corners of all facets counter-clockwise, seen from where the slave is')
  end subroutine open_part
end module tool_sides
