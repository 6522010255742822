!> The factor of a matrix that only precedes an iteration: made in single precision, where it stays
!! near (doc/theory, "Nonlinear bulk").
module coarse_factor
  use kinds, only: wp, sp, long
  use costs, only: cost_t, begin_cost, end_cost, cost_symmetric_factor
  use lapack_interface, only: dtrsv
  use ordered_blocks, only: ordered_blocks_t, multiply_ordered, largest_entry
  use supernodes, only: supernodes_t, supernodes_of, values_before, place_last, invert_blocks, &
    reduce_single, complete_single
  use single_factor, only: factorise_single
  use cholmod_solver, only: cholmod_t, forget_half
  implicit none
  private
  public :: factorise_coarsely

contains

  !> Factorises a lower triangle in single precision alone, if its entries are numbers there and its
  !! answers are true to a share: half the work, and half the memory of each substitution. That is
  !! asked of the answer to an answer, in which soft motions stand out.
  subroutine factorise_coarsely(solver, a, share, block, costs, done)
    type(cholmod_t), intent(inout) :: solver !! analysed; gets half
    type(ordered_blocks_t), intent(in) :: a !! in the order of elimination
    real(wp), intent(in) :: share !! most of an answer that may be wrong
    real(wp), intent(out), contiguous :: block(:, :) !! (m, m) L22 of the last ones; zero above
    type(cost_t), intent(inout) :: costs !! cost table
    logical, intent(out) :: done !! there is a factor that is near enough
    type(supernodes_t) :: nodes
    real(wp) :: x(size(a%node)), right(size(a%node)), rest(size(a%node))
    integer(long) :: skipped

    done = largest_entry(a) < sqrt(real(huge(1.0_sp), wp))
    if (.not. done) return
    nodes = supernodes_of(solver%factor)
    call begin_cost(costs, cost_symmetric_factor)
    call factorise_single(nodes, a, solver%half, done)
    if (done) then
      skipped = values_before(nodes, size(block, 1))
      call place_last(nodes, real(solver%half(skipped + 1:), wp), skipped, block)
      call invert_blocks(nodes, size(block, 1), solver%half)
      x = 1.0_wp
      call solve_coarsely(nodes, solver%half, block, x)
      right = x/max(norm2(x), tiny(1.0_wp))
      x = right
      call solve_coarsely(nodes, solver%half, block, x)
      rest = right - multiply_ordered(a, x)
      call solve_coarsely(nodes, solver%half, block, rest)
      done = norm2(rest) <= share*norm2(x)
      if (.not. done) call forget_half(solver)
    end if
    call end_cost(costs, cost_symmetric_factor)
  end subroutine factorise_coarsely

  !> x = (L L^T)^-1 x with all unknowns.
  subroutine solve_coarsely(nodes, half, block, x)
    type(supernodes_t), intent(in) :: nodes !! of the factor
    real(sp), intent(in), contiguous :: half(:) !! its values, but for the last columns
    real(wp), intent(in), contiguous :: block(:, :) !! (m, m) these
    real(wp), intent(inout), contiguous :: x(:) !! (n) right-hand side; solution
    integer :: m, first

    m = size(block, 1)
    first = size(x) - m + 1
    call reduce_single(nodes, half, m, x)
    if (m > 0) then
      call dtrsv('L', 'N', 'N', m, block, m, x(first:), 1)
      call dtrsv('L', 'T', 'N', m, block, m, x(first:), 1)
    end if
    call complete_single(nodes, half, m, x)
  end subroutine solve_coarsely
end module coarse_factor
