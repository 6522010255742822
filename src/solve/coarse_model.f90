!> A coarse model of the bodies: each moves and strains as a whole, u = A + B X, 12 motions a body
!! (doc/theory, "A coarse start").
module coarse_model
  use kinds, only: wp
  use bulk_products, only: multiply_bulk
  use element_lists, only: element_list_t
  use system_types, only: system_t
  implicit none
  private
  public :: coarse_model_t, build_coarse, project_field, project_elements, expand_motions

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
      if (coarse%first(i) < 0) cycle
      associate (to => motions(coarse%first(i) + 1:coarse%first(i) + n_motions))
        to = to + motions_of(coarse, i, force(:, i))
      end associate
    end do
  end subroutine project_field

  !> Adds the stiffness of contact elements against the motions.
  pure subroutine project_elements(coarse, list, s, a)
    type(coarse_model_t), intent(in) :: coarse !! the model
    type(element_list_t), intent(in) :: list !! contact elements
    real(wp), intent(in) :: s(:, :, :) !! (dofs, dofs, elements) their matrices
    real(wp), intent(inout) :: a(:, :) !! (n, n) stiffness
    integer :: k, i, j, e, p, to
    real(wp) :: column(3)

    do k = 1, list%n
      if (maxval(abs(s(:, :, k))) <= 0.0_wp) cycle
      do j = 1, list%nel(k)
        if (coarse%first(list%ix(j, k)) < 0) cycle
        do e = 1, 3
          if (.not. coarse%free(e, list%ix(j, k))) cycle
          do i = 1, list%nel(k)
            if (coarse%first(list%ix(i, k)) < 0) cycle
            column = s(3*i - 2:3*i, 3*j - 3 + e, k)
            do p = 1, n_functions
              to = coarse%first(list%ix(j, k)) + (e - 1)*n_functions + p
              call add_motions(coarse, list%ix(i, k), coarse%value(p, list%ix(j, k))*column, &
                a(:, to))
            end do
          end do
        end do
      end do
    end do
  end subroutine project_elements

  !> Adds what a force at a node does.
  pure subroutine add_motions(coarse, node, force, motions)
    type(coarse_model_t), intent(in) :: coarse !! the model
    integer, intent(in) :: node !! the node
    real(wp), intent(in) :: force(3) !! [force]
    real(wp), intent(inout) :: motions(:) !! (n) [force]

    associate (to => motions(coarse%first(node) + 1:coarse%first(node) + n_motions))
      to = to + motions_of(coarse, node, force)
    end associate
  end subroutine add_motions

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
