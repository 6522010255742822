!> Multipliers of the points of slave facets as a field with a vector at each slave node, so that
!! there are no more conditions than nodes that can meet them (doc/theory, "Multiplier fields", eqs.
!! (7.9), (7.10)).
!!
!! A vector of the field goes with the normal of the master: it is turned from the mean normal
!! around its node to that of each point. Where faces of the master meet at an angle a node has one
!! vector for each of them.
module multiplier_field
  use kinds, only: wp, pi
  use vectors, only: identity, cross, dyad, product_of
  use contact_types, only: pair_t
  use contact_points, only: corner_weights, count_points
  implicit none
  private
  public :: multiplier_field_t, node_hold_t, make_field, gather_forces, spread_field, project_forces

  !> Points whose normals have a smaller cosine with the first one's lie on another face.
  real(wp), parameter :: same_face = 0.9_wp
  !> Faces around a node that get a vector of their own.
  integer, parameter :: most_faces = 4
  !> The residual of a projection, over its right-hand side.
  real(wp), parameter :: projection_tolerance = 1.0e-14_wp
  !> Iterations of a projection: the scaled mass matrix of linear triangles has a condition number
  !! of 4, so about 35 are enough.
  integer, parameter :: most_field_iterations = 200
  !> Nothing slips along a tangent if no motion that is left has a larger share of it than this: it
  !! would meet a hundredth of the compliance. Facets of a joint that is held across its plane tilt
  !! by thousandths.
  real(wp), parameter :: least_motion = 0.1_wp
  !> Room for the neighbours of a vector to begin with.
  integer, parameter :: first_neighbours = 16

  !> Which motions the supports leave neither to a slave node nor to the master there.
  type :: node_hold_t
    logical :: along(3) = .false. !! held along these axes
    real(wp) :: inside = -huge(1.0_wp) !! least shape function of the node in the facet looked at
  end type node_hold_t

  !> The vectors of a field and the points that they belong to.
  type :: multiplier_field_t
    integer :: n = 0 !! number of vectors
    integer, allocatable :: vector(:, :) !! (3, points) the vectors a point is made of, or 0
    real(wp), allocatable :: normal(:, :) !! (3, n) mean normal of their points
    real(wp), allocatable :: point_normal(:, :) !! (3, points) normals of the points
    real(wp), allocatable :: stiffness(:) !! (n) sum of N_i and the penalty [force/length]
    real(wp), allocatable :: kept(:, :, :) !! (3, 3, n) projector on its directions
    real(wp), allocatable :: share(:, :, :, :) !! (3, 3, 3, points) N_i R_i of each point's vectors
    integer, allocatable :: neighbours(:) !! (n) vectors that share points with each, itself as well
    integer, allocatable :: neighbour(:, :) !! (room, n) these
    real(wp), allocatable :: mass(:, :, :, :) !! (3, 3, room, n) their blocks of the mass matrix
    real(wp), allocatable :: diagonal(:) !! (n) of the mass matrix, without the turns
  end type multiplier_field_t

contains

  !> Vectors for all slave nodes of those points that are near the master.
  pure subroutine make_field(pair, near, facing, normal, field, hold)
    type(pair_t), intent(in) :: pair !! the pair
    logical, intent(in) :: near(:) !! (points) there is a master facet
    real(wp), intent(in) :: facing(:, :) !! (3, points) unit normals of the undeformed master, which
                                         !! tell the faces: these stay while an increment is solved
    real(wp), intent(in) :: normal(:, :) !! (3, points) unit normals of the master as it is now
    type(multiplier_field_t), intent(out) :: field !! the field
    type(node_hold_t), intent(in), optional :: hold(:, :) !! (3, points) of slave corners
    real(wp), allocatable :: first_normal(:, :)
    integer, allocatable :: faces(:, :)
    integer :: p, b

    field%point_normal = normal
    allocate (field%vector(3, count_points(pair)), source=0)
    allocate (faces(most_faces, maxval(pair%points%point_nodes)), source=0)
    allocate (first_normal(3, 3*count(near)), source=0.0_wp)
    do p = 1, count_points(pair)
      if (.not. near(p)) cycle
      do b = 1, 3
        call find_vector(faces(:, pair%points%point_nodes(b, p)), facing(:, p), first_normal, &
          field%n, field%vector(b, p))
      end do
    end do
    call sum_up(pair, field)
    allocate (field%kept(3, 3, field%n), source=spread(identity, 3, field%n))
    if (present(hold)) call leave_out(hold, field)
    call form_shares(pair, field)
    call form_mass(pair, field)
  end subroutine make_field

  !> The vector of a node for a normal; a new one if there is none for such a face.
  pure subroutine find_vector(faces, normal, first_normal, n, vector)
    integer, intent(inout) :: faces(:) !! vectors of the node, 0 where there is none
    real(wp), intent(in) :: normal(3) !! of the master
    real(wp), intent(inout) :: first_normal(:, :) !! (3, room) normals that vectors began with
    integer, intent(inout) :: n !! vectors so far
    integer, intent(out) :: vector !! the vector
    real(wp) :: cosine, best
    integer :: k

    best = -2.0_wp
    vector = 0
    do k = 1, size(faces)
      if (faces(k) == 0) exit
      cosine = dot_product(normal, first_normal(:, faces(k)))
      if (cosine <= best) cycle
      best = cosine
      vector = faces(k)
    end do
    if (best > same_face .or. k > size(faces)) return
    n = n + 1
    first_normal(:, n) = normal
    faces(k) = n
    vector = n
  end subroutine find_vector

  !> Mean normals and stiffnesses.
  pure subroutine sum_up(pair, field)
    type(pair_t), intent(in) :: pair !! the pair
    type(multiplier_field_t), intent(inout) :: field !! vector, point_normal given
    real(wp) :: share, weight(3)
    integer :: p, b, i

    allocate (field%normal(3, field%n), field%stiffness(field%n), source=0.0_wp)
    do p = 1, count_points(pair)
      weight = corner_weights(pair, p)
      do b = 1, 3
        i = field%vector(b, p)
        if (i == 0) cycle
        share = weight(b)*pair%points%area(p)
        field%normal(:, i) = field%normal(:, i) + share*field%point_normal(:, p)
        field%stiffness(i) = field%stiffness(i) + weight(b)*pair%points%epsilon(p)
      end do
    end do
    do i = 1, field%n
      field%normal(:, i) = field%normal(:, i)/norm2(field%normal(:, i))
    end do
  end subroutine sum_up

  !> Leaves out the tangents along which neither a slave node nor the master there can move: no
  !! force along them closes anything, so the multiplier would be chance. The facet that holds a
  !! node best tells what moves there.
  pure subroutine leave_out(hold, field)
    type(node_hold_t), intent(in) :: hold(:, :) !! (3, points) of the slave facet's corners
    type(multiplier_field_t), intent(inout) :: field !! vectors, normals; gets kept
    type(node_hold_t) :: best(field%n)
    integer :: p, b, i

    do p = 1, size(hold, 2)
      do b = 1, 3
        i = field%vector(b, p)
        if (i == 0) cycle
        if (hold(b, p)%inside > best(i)%inside) best(i) = hold(b, p)
      end do
    end do
    do i = 1, field%n
      if (any(best(i)%along)) field%kept(:, :, i) = kept_motions(field%normal(:, i), best(i)%along)
    end do
  end subroutine leave_out

  !> Projector on a normal and on those tangents that have a part in the motions that are left.
  pure function kept_motions(normal, held) result(kept)
    real(wp), intent(in) :: normal(3) !! unit vector
    logical, intent(in) :: held(3) !! axes along which nothing moves
    real(wp) :: kept(3, 3)
    real(wp) :: t(3, 2), q(3), angle, way(3)
    integer :: k

    t(:, 1) = cross(normal, identity(:, minloc(abs(normal), 1)))
    t(:, 1) = t(:, 1)/norm2(t(:, 1))
    t(:, 2) = cross(normal, t(:, 1))
    q = [sum(t(:, 1)**2, .not. held), sum(t(:, 2)**2, .not. held), &
      sum(t(:, 1)*t(:, 2), .not. held)]
    angle = 0.5_wp*atan2(2.0_wp*q(3), q(1) - q(2))
    kept = dyad(normal, normal)
    do k = 0, 1
      way = cos(angle + k*0.5_wp*pi)*t(:, 1) + sin(angle + k*0.5_wp*pi)*t(:, 2)
      if (sum(way**2, .not. held) > least_motion**2) kept = kept + dyad(way, way)
    end do
  end function kept_motions

  !> N_i R_i of the vectors of each point.
  pure subroutine form_shares(pair, field)
    type(pair_t), intent(in) :: pair !! the pair
    type(multiplier_field_t), intent(inout) :: field !! vectors and normals given; gets share
    real(wp) :: weight(3)
    integer :: p, b, k

    allocate (field%share(3, 3, 3, size(field%vector, 2)), source=0.0_wp)
    do p = 1, size(field%vector, 2)
      weight = corner_weights(pair, p)
      do b = 1, 3
        if (field%vector(b, p) == 0) cycle
        do k = 1, 3
          field%share(:, k, b, p) = weight(b)*turned(field%normal(:, field%vector(b, p)), &
            field%point_normal(:, p), field%kept(:, k, field%vector(b, p)))
        end do
      end do
    end do
  end subroutine form_shares

  !> The mass matrix sum_q A_q N_i N_j R_iq^T R_jq.
  pure subroutine form_mass(pair, field)
    type(pair_t), intent(in) :: pair !! the pair
    type(multiplier_field_t), intent(inout) :: field !! shares given; gets neighbours, mass
    real(wp) :: weight(3)
    integer :: p, b, c, i, j, place

    allocate (field%neighbours(field%n), source=0)
    allocate (field%neighbour(first_neighbours, field%n), source=0)
    allocate (field%mass(3, 3, first_neighbours, field%n), source=0.0_wp)
    allocate (field%diagonal(field%n), source=0.0_wp)
    do p = 1, size(field%vector, 2)
      if (all(field%vector(:, p) == 0)) cycle
      weight = corner_weights(pair, p)
      do b = 1, 3
        associate (total => field%diagonal(field%vector(b, p)))
          total = total + pair%points%area(p)*weight(b)**2
        end associate
      end do
      do c = 1, 3
        do b = 1, 3
          call find_neighbour(field%vector(b, p), field%vector(c, p), field, place)
          associate (block => field%mass(:, :, place, field%vector(b, p)))
            do j = 1, 3
              do i = 1, 3
                block(i, j) = block(i, j) + pair%points%area(p) &
                  *dot_product(field%share(:, i, b, p), field%share(:, j, c, p))
              end do
            end do
          end associate
        end do
      end do
    end do
  end subroutine form_mass

  !> The place of a vector among the neighbours of another; a new one if need be.
  pure subroutine find_neighbour(i, j, field, place)
    integer, intent(in) :: i !! the vector
    integer, intent(in) :: j !! its neighbour
    type(multiplier_field_t), intent(inout) :: field !! neighbours; room may grow
    integer, intent(out) :: place !! where j stands
    integer, allocatable :: neighbour(:, :)
    real(wp), allocatable :: mass(:, :, :, :)

    do place = 1, field%neighbours(i)
      if (field%neighbour(place, i) == j) return
    end do
    associate (room => size(field%neighbour, 1))
      if (place > room) then
        allocate (neighbour(2*room, field%n), source=0)
        allocate (mass(3, 3, 2*room, field%n), source=0.0_wp)
        neighbour(:room, :) = field%neighbour
        mass(:, :, :room, :) = field%mass
        call move_alloc(neighbour, field%neighbour)
        call move_alloc(mass, field%mass)
      end if
    end associate
    field%neighbours(i) = place
    field%neighbour(place, i) = j
  end subroutine find_neighbour

  !> The mass matrix times vectors.
  pure function mass_times(field, v) result(m)
    type(multiplier_field_t), intent(in) :: field !! its mass
    real(wp), intent(in) :: v(:, :) !! (3, n)
    real(wp) :: m(3, field%n), total(3)
    integer :: i, k

    do i = 1, field%n
      total = 0.0_wp
      do k = 1, field%neighbours(i)
        total = total + product_of(field%mass(:, :, k, i), v(:, field%neighbour(k, i)))
      end do
      m(:, i) = total
    end do
  end function mass_times

  !> A vector turned by the smallest rotation that takes one direction to another.
  pure function turned(from, to, v) result(w)
    real(wp), intent(in) :: from(3) !! unit vector
    real(wp), intent(in) :: to(3) !! unit vector, not opposite to it
    real(wp), intent(in) :: v(3) !! any vector
    real(wp) :: w(3)
    real(wp) :: axis(3), once(3)

    axis = cross(from, to)
    once = cross(axis, v)
    w = v + once + cross(axis, once)/(1.0_wp + dot_product(from, to))
  end function turned

  !> Forces of points at the vectors: b_i = sum_q N_i R_iq^T f_q.
  pure function gather_forces(field, force) result(nodal)
    type(multiplier_field_t), intent(in) :: field !! its field
    real(wp), intent(in) :: force(:, :) !! (3, points) in global axes [force]
    real(wp) :: nodal(3, field%n)
    integer :: p, b, i, k

    nodal = 0.0_wp
    do p = 1, size(force, 2)
      do b = 1, 3
        i = field%vector(b, p)
        if (i == 0) cycle
        do k = 1, 3
          nodal(k, i) = nodal(k, i) + field%share(1, k, b, p)*force(1, p) &
            + field%share(2, k, b, p)*force(2, p) + field%share(3, k, b, p)*force(3, p)
        end do
      end do
    end do
  end function gather_forces

  !> Forces at the points from vectors per area: A_q sum_i N_i R_iq lambda_i.
  pure function spread_field(pair, field, nodal) result(force)
    type(pair_t), intent(in) :: pair !! the pair
    type(multiplier_field_t), intent(in) :: field !! its field
    real(wp), intent(in) :: nodal(:, :) !! (3, n) vectors [force/length^2]
    real(wp) :: force(3, size(field%vector, 2))
    integer :: p, b

    force = 0.0_wp
    do p = 1, size(force, 2)
      do b = 1, 3
        if (field%vector(b, p) == 0) cycle
        force(:, p) = force(:, p) + pair%points%area(p)*product_of(field%share(:, :, b, p), &
          nodal(:, field%vector(b, p)))
      end do
    end do
  end function spread_field

  !> The field that does the same work as the forces of the points with every other field: its
  !! forces at the points. Conjugate gradients with the diagonal of the mass matrix.
  pure subroutine project_forces(pair, field, force, multiplier, share)
    type(pair_t), intent(in) :: pair !! the pair
    type(multiplier_field_t), intent(in) :: field !! its field
    real(wp), intent(in) :: force(:, :) !! (3, points) in global axes [force]
    real(wp), intent(out) :: multiplier(:, :) !! (3, points) those of the field [force]
    real(wp), intent(in), optional :: share !! of the right-hand side, may be left; else next to
    !! nothing
    real(wp), dimension(3, field%n) :: nodal, r, s, m
    real(wp) :: energy, before, wanted, step
    integer :: iteration

    nodal = 0.0_wp
    r = gather_forces(field, force)
    s = scaled(r, field%diagonal)
    energy = sum(r*s)
    wanted = projection_tolerance**2*energy
    if (present(share)) wanted = max(projection_tolerance, share)**2*energy
    do iteration = 1, most_field_iterations
      if (energy <= wanted) exit
      m = mass_times(field, s)
      if (sum(s*m) <= 0.0_wp) exit
      step = energy/sum(s*m)
      nodal = nodal + step*s
      r = r - step*m
      before = energy
      m = scaled(r, field%diagonal)
      energy = sum(r*m)
      s = m + (energy/before)*s
    end do
    multiplier = spread_field(pair, field, nodal)
  end subroutine project_forces

  !> Values over a diagonal.
  pure function scaled(values, diagonal) result(divided)
    real(wp), intent(in) :: values(:, :) !! (3, n) any values
    real(wp), intent(in) :: diagonal(:) !! (n) positive numbers
    real(wp) :: divided(3, size(values, 2))

    divided = values/spread(diagonal, 1, 3)
  end function scaled
end module multiplier_field
