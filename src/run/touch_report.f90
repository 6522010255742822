!> Pairs that touch nowhere in a whole run: a wrong sign, or a wrong side, as a rule.
module touch_report
  use element_types, only: status_open
  use model_types, only: model_t
  use run_context, only: context_t
  implicit none
  private
  public :: keep_touches, tell_untouched

contains

  !> Notes which pairs are in contact at an end time.
  pure subroutine keep_touches(model, touched)
    type(model_t), intent(in) :: model !! its pairs, their history committed
    logical, allocatable, intent(inout) :: touched(:) !! (pairs)
    integer :: k

    if (.not. allocated(touched)) allocate (touched(size(model%pairs)), source=.false.)
    do k = 1, size(touched)
      touched(k) = touched(k) .or. any(model%pairs(k)%history%old%status > status_open)
    end do
  end subroutine keep_touches

  !> Warns of the pairs that were not in contact at any end time.
  subroutine tell_untouched(context)
    type(context_t), target, intent(inout) :: context !! the run at its end
    integer :: k

    if (.not. allocated(context%touched)) return
    do k = 1, size(context%touched)
      if (context%touched(k)) cycle
      call context%monitor%warning('pair '//context%model%pairs(k)%name// &
        ' was in contact at no output time of this run: does its slave move towards the outer '// &
        'side of its master, and far enough?')
    end do
  end subroutine tell_untouched
end module touch_report
