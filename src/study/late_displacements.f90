!> Derivatives of the displacements of candidates that contact does not touch: what its forces do to
!! them is found when somebody asks (doc/theory, "Sensitivities along the path").
module late_displacements
  use kinds, only: wp
  use condensed_types, only: condensed_body_t, condensed_t
  use sensitivity_types, only: sensitivity_t
  use touched_candidates, only: subtract_beside
  implicit none
  private
  public :: complete_nodes

contains

  !> Completes the displacements of some nodes. Candidates may have been numbered anew since.
  subroutine complete_nodes(condensed, wanted, s)
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    logical, intent(in) :: wanted(:) !! (nodes) these
    type(sensitivity_t), intent(inout) :: s !! force given; gets du
    integer :: b

    if (.not. allocated(s%answers%late)) return
    if (.not. any(s%answers%late .and. spread(wanted, 1, 3))) return
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%m > 0) call complete_body(body, condensed%node(body%first + 1:body%first &
          + body%m), condensed%direction(body%first + 1:body%first + body%m), wanted, s)
      end associate
    end do
  end subroutine complete_nodes

  !> The same for one body.
  subroutine complete_body(body, node, direction, wanted, s)
    type(condensed_body_t), intent(in) :: body !! its compliance
    integer, intent(in) :: node(:) !! (candidates) their nodes
    integer, intent(in) :: direction(:) !! (candidates) their directions
    logical, intent(in) :: wanted(:) !! (nodes) these
    type(sensitivity_t), intent(inout) :: s !! force given; gets du
    integer, allocatable :: rows(:), others(:)
    real(wp), allocatable :: f(:, :), u(:, :)
    logical :: late(size(node)), pushed(size(node))
    integer :: i

    do i = 1, size(node)
      late(i) = wanted(node(i)) .and. s%answers%late(direction(i), node(i))
      pushed(i) = any(abs(s%force(direction(i), node(i), :)) > 0.0_wp)
    end do
    others = pack([(i, i=1, size(node))], late)
    if (size(others) == 0) return
    rows = pack([(i, i=1, size(node))], pushed)
    allocate (f(size(s%slopes), size(rows)), u(size(s%slopes), size(others)))
    do i = 1, size(rows)
      f(:, i) = s%force(direction(rows(i)), node(rows(i)), :)
    end do
    do i = 1, size(others)
      u(:, i) = s%du(direction(others(i)), node(others(i)), :)
    end do
    if (size(rows) > 0) call subtract_beside(body, rows, f, others, u)
    do i = 1, size(others)
      s%du(direction(others(i)), node(others(i)), :) = u(:, i)
      s%answers%late(direction(others(i)), node(others(i))) = .false.
    end do
  end subroutine complete_body
end module late_displacements
