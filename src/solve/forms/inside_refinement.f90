!> Displacements inside a body whose factor is kept in single precision: conjugate gradients that
!! the factor precedes (doc/theory, "Static condensation").
module inside_refinement
  use kinds, only: wp
  use costs, only: cost_t
  use block_matrix, only: block_matrix_t, multiply_some
  use half_solves, only: solve_inside
  use condensed_types, only: condensed_body_t
  implicit none
  private
  public :: settle_inside

  !> Iterations at most; two are usual, and a factor that has lost much takes a few more.
  integer, parameter :: most_refinements = 60
  !> What is left of the displacements inside that are not right, over their norm.
  real(wp), parameter :: exact_share = 1.0e-13_wp

contains

  !> Brings the inside of a body into balance with the displacements of its candidates, where no
  !! forces act but those of K u.
  subroutine settle_inside(blocks, body, u, costs)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    type(condensed_body_t), intent(in) :: body !! its factor is in single precision
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) [length]; inside the body nearly in balance
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), dimension(size(body%node) - body%m) :: rest, way, pulled, answer
    real(wp) :: field(3, size(u, 2)), force(3, size(u, 2)), product, before, length
    logical :: inside(size(u, 2))
    integer :: iteration

    inside = .false.
    inside(body%node(:size(rest))) = .true.
    force = 0.0_wp
    call multiply_some(blocks, inside, u, force)
    rest = -gathered(body, force, size(rest))
    length = norm2(gathered(body, u, size(rest)))
    way = 0.0_wp
    product = 1.0_wp
    do iteration = 1, most_refinements
      before = norm2(rest)
      if (before <= 0.0_wp) exit
      call answer_inside(body, rest, answer, costs)
      way = answer + dot_product(rest, answer)/product*way
      product = dot_product(rest, answer)
      field = 0.0_wp
      call scatter(body, way, field)
      call multiply_some(blocks, inside, field, force)
      pulled = gathered(body, force, size(rest))
      associate (alpha => product/max(dot_product(way, pulled), tiny(1.0_wp)))
        rest = rest - alpha*pulled
        call scatter(body, alpha*way, field)
      end associate
      u = u + field
      if (norm2(field)*min(1.0_wp, norm2(rest)/before) <= exact_share*length) exit
    end do
  end subroutine settle_inside

  !> What the factor answers to forces inside while the candidates stay.
  subroutine answer_inside(body, forces, answer, costs)
    type(condensed_body_t), intent(in) :: body !! its factor
    real(wp), intent(in) :: forces(:) !! (inside) [force]
    real(wp), intent(out) :: answer(:) !! (inside) [length]
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp) :: x(size(body%node)), scale

    scale = norm2(forces)
    x = 0.0_wp
    x(:size(forces)) = forces/scale
    call solve_inside(body%solver, body%m, x, costs)
    answer = scale*x(:size(forces))
  end subroutine answer_inside

  !> Values of a field at the first equations of a body.
  pure function gathered(body, field, n) result(values)
    type(condensed_body_t), intent(in) :: body !! where its equations belong
    real(wp), intent(in) :: field(:, :) !! (3, nodes)
    integer, intent(in) :: n !! how many
    real(wp) :: values(n)
    integer :: i

    do i = 1, n
      values(i) = field(body%direction(i), body%node(i))
    end do
  end function gathered

  !> Puts values at the first equations of a body into a field.
  pure subroutine scatter(body, values, field)
    type(condensed_body_t), intent(in) :: body !! where its equations belong
    real(wp), intent(in) :: values(:) !! (inside)
    real(wp), intent(inout) :: field(:, :) !! (3, nodes) elsewhere it stays
    integer :: i

    do i = 1, size(values)
      field(body%direction(i), body%node(i)) = values(i)
    end do
  end subroutine scatter
end module inside_refinement
