!> A coarse model of the bodies: each moves and strains as a whole, u = A + B X, 12 motions a body
!! (doc/theory, "Start", eq. (11.2)).
module coarse_model
  use kinds, only: wp
  use bulk_products, only: multiply_bulk
  use system_types, only: system_t
  implicit none
  private
  public :: coarse_model_t, build_coarse, project_field, project_element, &
    add_force, expand_motions, n_motions

  !> Functions of place of which each direction of a motion is made: 1 and the three coordinates.
  integer, parameter :: n_functions = 4
  !> Motions of a body.
  integer, parameter :: n_motions = 3*n_functions

  !> The motions of all bodies that can move. Motion (function p, direction d) of a body stands at
  !! first + (d - 1) n_functions + p.
  type :: coarse_model_t
    integer :: n = 0 !! motions of all bodies
    integer, allocatable :: first(:) !! (nodes) where the motions of its body begin, -1 for none
    real(wp), allocatable :: value(:, :) !! (n_functions, nodes) the functions, within 1
    logical, allocatable :: free(:, :) !! (3, nodes) it is not prescribed
    real(wp), allocatable :: bulk(:, :) !! (n, n) stiffness of the bodies [force/length]
  end type coarse_model_t

contains

  !> The motions of the bodies and how stiff these are against them.
  subroutine build_coarse(x, system, coarse)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(inout) :: system !! bodies, equations, the bulk's matrix
    type(coarse_model_t), intent(out) :: coarse !! the model
    real(wp) :: u(3, size(x, 2)), pull(3, size(x, 2)), row(n_motions)
    integer :: place(0:system%body%bodies), b, d, p, i, m

    coarse%free = system%equation > 0
    place = -1
    do b = 1, system%body%bodies
      if (.not. any(coarse%free .and. spread(system%body%node_body == b, 1, 3))) cycle
      place(b) = coarse%n
      coarse%n = coarse%n + n_motions
    end do
    coarse%first = place(system%body%node_body)
    call evaluate_functions(x, system%body%node_body, system%body%bodies, coarse%value)
    allocate (coarse%bulk(coarse%n, coarse%n), source=0.0_wp)
    do m = 1, n_motions
      d = (m - 1)/n_functions + 1
      p = m - (d - 1)*n_functions
      u = 0.0_wp
      where (coarse%free(d, :) .and. coarse%first >= 0) u(d, :) = coarse%value(p, :)
      call multiply_bulk(system, u, pull)
      do i = 1, size(x, 2)
        if (coarse%first(i) < 0) cycle
        row = motions_of(coarse, i, pull(:, i))
        associate (to => coarse%bulk(coarse%first(i) + 1:coarse%first(i) + n_motions, &
          coarse%first(i) + m))
          to = to + row
        end associate
      end do
    end do
  end subroutine build_coarse

  !> 1 and the coordinates about the middle of each body, over half its size.
  pure subroutine evaluate_functions(x, node_body, bodies, value)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: node_body(:) !! (nodes) body, 0 for none
    integer, intent(in) :: bodies !! how many there are
    real(wp), allocatable, intent(out) :: value(:, :) !! (n_functions, nodes)
    real(wp) :: low(3, 0:bodies), high(3, 0:bodies), half
    integer :: i

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do i = 1, size(node_body)
      low(:, node_body(i)) = min(low(:, node_body(i)), x(:, i))
      high(:, node_body(i)) = max(high(:, node_body(i)), x(:, i))
    end do
    allocate (value(n_functions, size(node_body)))
    do i = 1, size(node_body)
      associate (a => low(:, node_body(i)), b => high(:, node_body(i)))
        half = max(0.5_wp*maxval(b - a), tiny(1.0_wp))
        value(:, i) = [1.0_wp, (x(:, i) - 0.5_wp*(a + b))/half]
      end associate
    end do
  end subroutine evaluate_functions

  !> What a force at a node does to the motions of its body.
  pure function motions_of(coarse, node, force) result(motions)
    type(coarse_model_t), intent(in) :: coarse !! the model
    integer, intent(in) :: node !! the node
    real(wp), intent(in) :: force(3) !! [force]
    real(wp) :: motions(n_motions)
    integer :: d

    do d = 1, 3
      motions((d - 1)*n_functions + 1:d*n_functions) = merge(force(d), 0.0_wp, &
        coarse%free(d, node))*coarse%value(:, node)
    end do
  end function motions_of

  !> What nodal forces do to the motions.
  pure subroutine project_field(coarse, force, motions)
    type(coarse_model_t), intent(in) :: coarse !! the model
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(out) :: motions(:) !! (n) [force]
    integer :: i

    motions = 0.0_wp
    do i = 1, size(force, 2)
      call add_force(coarse, i, force(:, i), motions)
    end do
  end subroutine project_field

  !> Adds the stiffness of a contact element against the motions.
  pure subroutine project_element(coarse, nodes, s, a)
    type(coarse_model_t), intent(in) :: coarse !! the model
    integer, intent(in) :: nodes(:) !! its nodes
    real(wp), intent(in) :: s(:, :) !! (3 nodes, 3 nodes) its matrix [force/length]
    real(wp), intent(inout) :: a(:, :) !! (n, n) stiffness
    integer :: i, j, e, p, to

    do j = 1, size(nodes)
      if (coarse%first(nodes(j)) < 0) cycle
      do e = 1, 3
        if (.not. coarse%free(e, nodes(j))) cycle
        do p = 1, n_functions
          to = coarse%first(nodes(j)) + (e - 1)*n_functions + p
          do i = 1, size(nodes)
            call add_force(coarse, nodes(i), coarse%value(p, nodes(j))*s(3*i - 2:3*i, &
              3*j - 3 + e), a(:, to))
          end do
        end do
      end do
    end do
  end subroutine project_element

  !> Adds what a force at a node does to the motions.
  pure subroutine add_force(coarse, node, force, motions)
    type(coarse_model_t), intent(in) :: coarse !! the model
    integer, intent(in) :: node !! the node
    real(wp), intent(in) :: force(3) !! [force]
    real(wp), intent(inout) :: motions(:) !! (n) [force]

    if (coarse%first(node) < 0) return
    associate (to => motions(coarse%first(node) + 1:coarse%first(node) + n_motions))
      to = to + motions_of(coarse, node, force)
    end associate
  end subroutine add_force

  !> Displacements of the nodes.
  pure subroutine expand_motions(coarse, motions, u)
    type(coarse_model_t), intent(in) :: coarse !! the model
    real(wp), intent(in) :: motions(:) !! (n) [length]
    real(wp), intent(out) :: u(:, :) !! (3, nodes) [length]
    integer :: i, d, from

    u = 0.0_wp
    do i = 1, size(u, 2)
      if (coarse%first(i) < 0) cycle
      do d = 1, 3
        from = coarse%first(i) + (d - 1)*n_functions
        if (coarse%free(d, i)) u(d, i) = dot_product(motions(from + 1:from + n_functions), &
          coarse%value(:, i))
      end do
    end do
  end subroutine expand_motions
end module coarse_model
