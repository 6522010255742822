!> Which contact points of a list are closed, stick, slip, turn back; what is expected of them.
module point_status
  use kinds, only: wp
  use element_types, only: status_stick, status_slip
  use element_lists, only: element_list_t
  implicit none
  private
  public :: contact_counts, forget_expected, hold_sticking, turned_back

contains

  !> Numbers of closed, sticking and slipping points of a range of contact elements.
  pure subroutine contact_counts(contact, first, last, active, stick, slip)
    type(element_list_t), intent(in) :: contact !! contact elements
    integer, intent(in) :: first !! first element
    integer, intent(in) :: last !! last element
    integer, intent(out) :: active !! closed
    integer, intent(out) :: stick !! sticking
    integer, intent(out) :: slip !! slipping

    stick = count(contact%status(first:last) == status_stick)
    slip = count(contact%status(first:last) == status_slip)
    active = stick + slip
  end subroutine contact_counts

  !> The tangents to come take each point as it is.
  pure subroutine forget_expected(list)
    type(element_list_t), intent(inout) :: list !! contact elements

    list%keep = 0.0_wp
    list%slide = .false.
  end subroutine forget_expected

  !> Points that stick are held for the next iteration.
  pure subroutine hold_sticking(list)
    type(element_list_t), intent(inout) :: list !! contact elements; gets hold

    list%hold = list%status == status_stick
  end subroutine hold_sticking

  !> Points whose slip has turned back since the iteration before.
  pure function turned_back(list, least) result(turned)
    type(element_list_t), intent(in) :: list !! contact elements: slip, slip_before
    real(wp), intent(in) :: least !! share of its slip now that a point must have slipped before
    logical :: turned(list%n)

    turned = sum(list%slip*list%slip_before, 1) < 0.0_wp .and. &
      norm2(list%slip_before, 1) > least*norm2(list%slip, 1)
  end function turned_back
end module point_status
