!> How deep below a facet of the master a point still counts as below it: nearly as deep as the
!! body behind the facet is thick. What is deeper lies behind the body (doc/theory, "Undetected
!! penetration").
module facet_depths
  use kinds, only: wp
  use threads, only: worth_threads
  use vectors, only: cross
  use mesh_types, only: mesh_t
  use bodies, only: find_bodies
  use facets, only: facet_table_t
  use contact_types, only: pair_t
  use contact_points, only: longest_facet
  use facet_geometry, only: facet_normal
  use facet_tree, only: facet_tree_t, build_tree, facets_near
  implicit none
  private
  public :: body_facets_t, measure_depths

  !> The exterior facets of the mesh, for rays.
  type :: body_facets_t
    type(facet_tree_t) :: tree !! over the facets
    integer, allocatable :: body(:) !! (elements) body of each
  end type body_facets_t

  !> Where rays through the body start: in the middle of the facet and nearer to its corners.
  integer, parameter :: n_rays = 4
  real(wp), parameter :: starts(3, n_rays) = reshape([1.0_wp, 1.0_wp, 1.0_wp, 2.5_wp, 0.25_wp, &
    0.25_wp, 0.25_wp, 2.5_wp, 0.25_wp, 0.25_wp, 0.25_wp, 2.5_wp]/3.0_wp, [3, n_rays])
  !> A ray that passes an edge by less, in shape functions, meets the facet.
  real(wp), parameter :: edge_slack = 1.0e-6_wp
  !> Of the thickness; the rest is for a body that is squeezed while its opposite face lies there.
  real(wp), parameter :: share = 0.9_wp
  !> A ray leaves through a facet if the cosine with its normal is larger; else it runs along it.
  real(wp), parameter :: least_leaving_cosine = 1.0e-6_wp
  !> What is nearer than this share of a ray is the facet itself.
  real(wp), parameter :: own_facet_share = 1.0e-9_wp
  !> Multiplications and additions for a facet, at least.
  real(wp), parameter :: of_facet = 1000.0_wp

contains

  !> Measures the depths of the master of a pair; none are kept where all bodies are thicker
  !! than the search radius.
  subroutine measure_depths(mesh, exterior, outside, pair)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: exterior !! its exterior facets
    type(body_facets_t), intent(inout) :: outside !! the same for rays; made where it is not
    type(pair_t), intent(inout) :: pair !! with its master; gets depths
    real(wp) :: depth(size(pair%surface%facets, 2)), radius
    integer, allocatable :: body_of_node(:)
    integer :: bodies, s, strips

    if (exterior%count == 0 .or. all(pair%surface%facet_elements == 0)) return
    if (.not. allocated(outside%body)) then
      call build_tree(outside%tree, exterior%corners, mesh%x)
      call find_bodies(mesh, outside%body, body_of_node, bodies)
    end if
    radius = pair%search_radius
    if (radius <= 0.0_wp) radius = longest_facet(pair, mesh%x)
    depth = radius
    strips = worth_threads(of_facet*real(size(depth), wp))
    !$omp parallel do schedule(static, 1) default(none) &
    !$omp& shared(mesh, exterior, outside, pair, radius, strips, depth) if(strips > 1)
    do s = 1, strips
      call measure_strip(mesh%x, exterior, outside, pair, radius, s, strips, depth)
    end do
    !$omp end parallel do
    if (any(depth < radius)) pair%surface%depth = depth
  end subroutine measure_depths

  !> The same for every so many facets from one on.
  subroutine measure_strip(x, exterior, outside, pair, radius, first, strips, depth)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(body_facets_t), intent(in) :: outside !! the same for rays
    type(pair_t), intent(in) :: pair !! with its master
    real(wp), intent(in) :: radius !! depths are at most this [length]
    integer, intent(in) :: first !! the first facet
    integer, intent(in) :: strips !! facets to the next one
    real(wp), intent(inout) :: depth(:) !! (facets) gets those of facets that have a body [length]
    integer :: near(exterior%count), f

    do f = first, size(depth), strips
      if (pair%surface%facet_elements(f) == 0) cycle
      depth(f) = depth_below(exterior, x, outside, pair%surface%facet_elements(f), &
        x(:, pair%surface%facets(:, f)), radius, near)
    end do
  end subroutine measure_strip

  !> Nearly the whole way through the body below a facet, along the longest of some rays.
  real(wp) function depth_below(exterior, x, outside, element, corner, radius, near) result(depth)
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(body_facets_t), intent(in) :: outside !! the same for rays
    integer, intent(in) :: element !! behind the facet
    real(wp), intent(in) :: corner(3, 3) !! corners of the facet [length]
    real(wp), intent(in) :: radius !! the depth is at most this [length]
    integer, intent(inout) :: near(:) !! room for facets
    real(wp) :: ray(3), middle(3), start(3, n_rays), first(n_rays), reach
    integer :: r, k, n

    ray = -(radius/share)*facet_normal(corner)
    middle = sum(corner, 2)/3.0_wp
    reach = 0.5_wp*norm2(ray) + maxval(norm2(corner - spread(middle, 2, 3), 1))
    call facets_near(outside%tree, middle + 0.5_wp*ray, reach, near, n)
    do r = 1, n_rays
      start(:, r) = matmul(corner, starts(:, r))
    end do
    first = 1.0_wp
    do k = 1, n
      if (outside%body(exterior%elements(near(k))) /= outside%body(element)) cycle
      associate (node => exterior%corners(:, near(k)))
        call shorten(x(:, node(1)), x(:, node(2)), x(:, node(3)), start, ray, first)
      end associate
    end do
    depth = maxval(first)*radius
  end function depth_below

  !> The shares of parallel rays after which they leave a body through a facet, where those are less
  !! than the ones so far.
  pure subroutine shorten(x1, x2, x3, start, ray, first)
    real(wp), intent(in) :: x1(3) !! corners of the facet, counter-clockwise from outside [length]
    real(wp), intent(in) :: x2(3) !! the second [length]
    real(wp), intent(in) :: x3(3) !! the third [length]
    real(wp), intent(in) :: start(3, n_rays) !! of the rays [length]
    real(wp), intent(in) :: ray(3) !! from there to their ends [length]
    real(wp), intent(inout) :: first(n_rays) !! shares; 1 for a ray that does not leave
    real(wp) :: a(3), b(3), normal(3), away(3), q(3), volume, xi, eta, s
    integer :: r

    a = x2 - x1
    b = x3 - x1
    normal = cross(a, b)
    volume = dot_product(ray, normal)
    if (volume <= least_leaving_cosine*norm2(ray)*norm2(normal)) return
    do r = 1, n_rays
      away = start(:, r) - x1
      q = cross(ray, away)
      xi = dot_product(b, q)/volume
      eta = -dot_product(a, q)/volume
      if (min(xi, eta, 1.0_wp - xi - eta) < -edge_slack) cycle
      s = -dot_product(away, normal)/volume
      if (s > own_facet_share) first(r) = min(first(r), s)
    end do
  end subroutine shorten
end module facet_depths
