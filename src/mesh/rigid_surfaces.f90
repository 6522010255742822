!> SURFace name PLANe, CYLInder, SPHEre: surfaces that are rigid and exact, with nothing behind them
!! (doc/theory, "Exact tools").
!!
!! They are nodes and facets behind those of the mesh. A plane is made of triangles; of a cylinder
!! or a sphere each corner has an inner node on the axis or at the centre, and the element bends
!! the triangle between them. Facets are as small as the model asks for where it is, and grow far
!! from it: an exact surface has no end that a body could get to.
module rigid_surfaces
  use kinds, only: wp, pi
  use vectors, only: cross
  use errors, only: error_t
  use deck_types, only: data_set_t
  use records, only: is_word, item_count, item_real, item_name
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use mesh_names, only: find_surface
  use mesh_building, only: reserve_nodes, model_box
  implicit none
  private
  public :: is_exact, read_exact_surface

  !> Rows of facets on each side of the model's middle: those of one size, that size over the
  !! model's, and those that double.
  integer, parameter :: even_rows = 12, growing_rows = 6
  real(wp), parameter :: row_size = 0.125_wp
  !> Facets around a cylinder, and how often those of an icosahedron are cut into four.
  integer, parameter :: facets_around = 48, cuts = 2

  !> A surface while it is made.
  type :: draft_t
    integer :: nodes = 0 !! corners
    real(wp), allocatable :: x(:, :) !! (3, nodes or more) corners [length]
    real(wp), allocatable :: inner(:, :) !! (3, nodes or more) what they are round about [length]
    integer, allocatable :: facets(:, :) !! (3, facets) corners, seen from outside
  end type draft_t

contains

  !> Whether a SURFace data set is one of these.
  pure logical function is_exact(set)
    type(data_set_t), intent(in) :: set !! the data set

    is_exact = .false.
    if (set%command /= 'surf' .or. item_count(set%head) < 7) return
    is_exact = is_word(set%head%items(3), 'plan') .or. is_word(set%head%items(3), 'cyli') .or. &
      is_word(set%head%items(3), 'sphe')
  end function is_exact

  !> Adds the nodes and facets of one surface behind the mesh.
  subroutine read_exact_surface(set, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(inout) :: mesh !! nodes of all others given; gets those of the surface
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(draft_t) :: draft
    real(wp) :: v(7), low(3), high(3), size_of_model
    integer :: i, n, index

    n = item_count(set%head) - 3
    if (.not. set%complete .or. n > 7) return
    v = 0.0_wp
    v(:n) = [(item_real(set%head, 3 + i), i=1, n)]
    call find_surface(mesh, item_name(set%head, 2), index)
    if (index == 0) return
    call check_numbers(set, v(:n), diagnostics, good=i)
    if (i == 0) return
    call model_box(mesh, low, high)
    if (any(low > high)) return
    size_of_model = norm2(high - low)
    select case (n)
    case (4)
      call make_sphere(v(1:3), v(4), draft)
    case (6)
      call make_plane(v(1:3), v(4:6)/norm2(v(4:6)), 0.5_wp*(low + high), size_of_model, draft)
    case default
      call make_cylinder(v(1:3), v(4:6)/norm2(v(4:6)), v(7), 0.5_wp*(low + high), size_of_model, &
        draft)
    end select
    call place_surface(set, draft, index, mesh, diagnostics)
  end subroutine read_exact_surface

  !> A direction is longer than zero, and so is a radius.
  subroutine check_numbers(set, v, diagnostics, good)
    type(data_set_t), intent(in) :: set !! the data set
    real(wp), intent(in) :: v(:) !! its numbers
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer, intent(out) :: good !! 1 if there is nothing wrong, else 0

    good = 0
    if (size(v) > 4) then
      if (.not. norm2(v(4:6)) > 0.0_wp) then
        call report_error(diagnostics, set%head%items(7)%at, 'the direction is 0 0 0', &
          'give the outward normal of a plane, the axis of a cylinder')
        return
      end if
    end if
    if (size(v) /= 6) then
      if (.not. abs(v(size(v))) > 0.0_wp) then
        call report_error(diagnostics, set%head%items(3 + size(v))%at, 'the radius is 0', &
          'give a positive one for a pin or a ball, a negative one for a bore')
        return
      end if
    end if
    good = 1
  end subroutine check_numbers

  !> Places of the rows of facets on both sides of 0 [length].
  pure function rows(size_of_model) result(places)
    real(wp), intent(in) :: size_of_model !! [length]
    real(wp) :: places(-even_rows - growing_rows:even_rows + growing_rows)
    real(wp) :: step
    integer :: k

    step = row_size*size_of_model
    places(0) = 0.0_wp
    do k = 1, even_rows + growing_rows
      if (k > even_rows) step = 2.0_wp*step
      places(k) = places(k - 1) + step
      places(-k) = -places(k)
    end do
  end function rows

  !> Two unit vectors with e1 x e2 = n.
  pure subroutine cross_axes(n, e)
    real(wp), intent(in) :: n(3) !! unit vector
    real(wp), intent(out) :: e(3, 2) !! e1, e2

    e(:, 1) = 0.0_wp
    e(minloc(abs(n), 1), 1) = 1.0_wp
    e(:, 1) = e(:, 1) - dot_product(e(:, 1), n)*n
    e(:, 1) = e(:, 1)/norm2(e(:, 1))
    e(:, 2) = cross(n, e(:, 1))
  end subroutine cross_axes

  !> A plane through a point.
  pure subroutine make_plane(point, normal, middle, size_of_model, draft)
    real(wp), intent(in) :: point(3) !! [length]
    real(wp), intent(in) :: normal(3) !! outward unit normal
    real(wp), intent(in) :: middle(3) !! of the model [length]
    real(wp), intent(in) :: size_of_model !! [length]
    type(draft_t), intent(out) :: draft !! the surface
    real(wp), allocatable :: places(:)
    real(wp) :: e(3, 2), foot(3)
    integer :: i, j, n

    call cross_axes(normal, e)
    foot = middle - dot_product(middle - point, normal)*normal
    places = rows(size_of_model)
    n = size(places)
    draft%nodes = n**2
    allocate (draft%x(3, n**2))
    do j = 1, n
      do i = 1, n
        draft%x(:, n*(j - 1) + i) = foot + places(i)*e(:, 1) + places(j)*e(:, 2)
      end do
    end do
    draft%facets = grid(n, n, .false.)
  end subroutine make_plane

  !> Triangles of a grid of n by m nodes, the third corner of each a right one; seen from the side
  !! that first direction x second direction shows to.
  pure function grid(n, m, closed) result(facets)
    integer, intent(in) :: n !! nodes along the first direction
    integer, intent(in) :: m !! along the second
    logical, intent(in) :: closed !! the first direction comes round to its beginning
    integer, allocatable :: facets(:, :)
    integer :: i, j, a, b, c, d, k

    allocate (facets(3, 2*merge(n, n - 1, closed)*(m - 1)))
    k = 0
    do j = 1, m - 1
      do i = 1, merge(n, n - 1, closed)
        a = n*(j - 1) + i
        b = n*(j - 1) + 1 + mod(i, n)
        c = b + n
        d = a + n
        facets(:, k + 1) = [c, a, b]
        facets(:, k + 2) = [a, c, d]
        k = k + 2
      end do
    end do
  end function grid

  !> A cylinder about an axis.
  pure subroutine make_cylinder(point, axis, radius, middle, size_of_model, draft)
    real(wp), intent(in) :: point(3) !! on the axis [length]
    real(wp), intent(in) :: axis(3) !! unit vector
    real(wp), intent(in) :: radius !! negative for a bore [length]
    real(wp), intent(in) :: middle(3) !! of the model [length]
    real(wp), intent(in) :: size_of_model !! [length]
    type(draft_t), intent(out) :: draft !! the surface
    real(wp), allocatable :: places(:)
    real(wp) :: e(3, 2), foot(3), angle
    integer :: i, j, n

    call cross_axes(axis, e)
    foot = point + dot_product(middle - point, axis)*axis
    places = rows(size_of_model)
    draft%nodes = facets_around*size(places)
    allocate (draft%x(3, draft%nodes), draft%inner(3, draft%nodes))
    do j = 1, size(places)
      do i = 1, facets_around
        n = facets_around*(j - 1) + i
        angle = 2.0_wp*pi*real(i - 1, wp)/real(facets_around, wp)
        draft%inner(:, n) = foot + places(j)*axis
        draft%x(:, n) = draft%inner(:, n) + abs(radius)*matmul(e, [cos(angle), sin(angle)])
      end do
    end do
    draft%facets = grid(facets_around, size(places), .true.)
    if (radius < 0.0_wp) draft%facets = draft%facets([2, 1, 3], :)
  end subroutine make_cylinder

  !> A sphere: an icosahedron whose triangles are cut into four, and those again.
  pure subroutine make_sphere(center, radius, draft)
    real(wp), intent(in) :: center(3) !! [length]
    real(wp), intent(in) :: radius !! negative for a hollow [length]
    type(draft_t), intent(out) :: draft !! the surface
    integer, parameter :: first(3, 20) = reshape([1, 2, 3, 1, 3, 4, 1, 4, 5, 1, 5, 6, 1, 6, 2, &
      2, 7, 3, 3, 8, 4, 4, 9, 5, 5, 10, 6, 6, 11, 2, 7, 8, 3, 8, 9, 4, 9, 10, 5, 10, 11, 6, &
      11, 7, 2, 12, 8, 7, 12, 9, 8, 12, 10, 9, 12, 11, 10, 12, 7, 11], [3, 20])
    real(wp) :: angle
    integer :: i

    draft%nodes = 12
    allocate (draft%x(3, 10*4**cuts + 2))
    draft%x(:, 1) = [0.0_wp, 0.0_wp, 1.0_wp]
    draft%x(:, 12) = -draft%x(:, 1)
    do i = 0, 4
      angle = 0.4_wp*pi*real(i, wp)
      draft%x(:, 2 + i) = [2.0_wp*cos(angle), 2.0_wp*sin(angle), 1.0_wp]/sqrt(5.0_wp)
      angle = angle + 0.2_wp*pi
      draft%x(:, 7 + i) = [2.0_wp*cos(angle), 2.0_wp*sin(angle), -1.0_wp]/sqrt(5.0_wp)
    end do
    draft%facets = first
    do i = 1, cuts
      call cut_in_four(draft)
    end do
    draft%inner = spread(center, 2, draft%nodes)
    draft%x = draft%inner + abs(radius)*draft%x
    if (radius < 0.0_wp) draft%facets = draft%facets([2, 1, 3], :)
  end subroutine make_sphere

  !> Cuts each triangle on the unit sphere into four.
  pure subroutine cut_in_four(draft)
    type(draft_t), intent(inout) :: draft !! corners and facets; gets more
    integer, allocatable :: facets(:, :), middle(:, :)
    integer :: f, k, a, b, m(3)

    allocate (facets(3, 4*size(draft%facets, 2)))
    allocate (middle(draft%nodes, draft%nodes), source=0)
    do f = 1, size(draft%facets, 2)
      do k = 1, 3
        a = draft%facets(k, f)
        b = draft%facets(1 + mod(k, 3), f)
        if (middle(a, b) == 0) then
          draft%nodes = draft%nodes + 1
          draft%x(:, draft%nodes) = draft%x(:, a) + draft%x(:, b)
          draft%x(:, draft%nodes) = draft%x(:, draft%nodes)/norm2(draft%x(:, draft%nodes))
          middle(a, b) = draft%nodes
          middle(b, a) = draft%nodes
        end if
        m(k) = middle(a, b)
      end do
      associate (c => draft%facets(:, f))
        facets(:, 4*f - 3) = [c(1), m(1), m(3)]
        facets(:, 4*f - 2) = [m(1), c(2), m(2)]
        facets(:, 4*f - 1) = [m(3), m(2), c(3)]
        facets(:, 4*f) = m
      end associate
    end do
    call move_alloc(facets, draft%facets)
  end subroutine cut_in_four

  !> Puts a surface behind the nodes of the mesh.
  subroutine place_surface(set, draft, index, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! its data set
    type(draft_t), intent(in) :: draft !! the surface
    integer, intent(in) :: index !! of the surface among those of the mesh
    type(mesh_t), intent(inout) :: mesh !! gets the nodes and facets
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(error_t), allocatable :: error
    integer :: first, last

    first = mesh%nodes
    last = first + draft%nodes
    if (allocated(draft%inner)) last = last + draft%nodes
    call reserve_nodes(mesh, last, error)
    if (allocated(error)) then
      call report_error(diagnostics, set%head%at, error%message, 'make the mesh coarser')
      return
    end if
    mesh%exact_nodes = mesh%exact_nodes + last - first
    mesh%defined(first + 1:last) = .true.
    mesh%x(:, first + 1:first + draft%nodes) = draft%x(:, :draft%nodes)
    associate (surface => mesh%surfaces(index))
      surface%facets = first + draft%facets
      surface%elements = spread(0, 1, size(draft%facets, 2))
      surface%alone = .true.
      surface%exact = .true.
      if (allocated(draft%inner)) surface%inner = surface%facets + draft%nodes
    end associate
    if (allocated(draft%inner)) mesh%x(:, first + draft%nodes + 1:last) = &
      draft%inner(:, :draft%nodes)
  end subroutine place_surface
end module rigid_surfaces
