!> The order of a body's candidates: along the longest side of the box around them, so that those
!! near each other have numbers near each other (doc/theory, "Static condensation").
module candidate_queue
  use kinds, only: wp
  use key_sorting, only: sort_columns
  implicit none
  private
  public :: queue_candidates

  !> Slices of that side.
  integer, parameter :: slices = 65536

contains

  !> Places of the candidates in their order; within a slice in that of their nodes.
  pure subroutine queue_candidates(x, candidate, queue)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: candidate(:) !! (nodes) candidates of the body
    integer, intent(out) :: queue(:) !! (nodes) place of each candidate, 0 for other nodes
    integer, allocatable :: node(:), order(:)
    real(wp) :: low(3), side(3)
    integer :: i, k

    queue = 0
    node = pack([(i, i=1, size(queue))], candidate)
    if (size(node) == 0) return
    low = minval(x(:, node), 2)
    side = maxval(x(:, node), 2) - low
    k = maxloc(side, 1)
    call sort_columns(reshape(int((slices - 1)*((x(k, node) - low(k))/max(side(k), &
      tiny(1.0_wp)))), [1, size(node)]), order)
    queue(node(order)) = [(i, i=1, size(node))]
  end subroutine queue_candidates
end module candidate_queue
