!> What SHRInk of a pair asks for.
module overlap_checks
  use text, only: to_text
  use diagnostics, only: diagnostics_t, report_error
  use contact_types, only: pair_t
  use model_types, only: model_t
  use loads, only: has_load
  implicit none
  private
  public :: check_shrink

contains

  !> SHRInk wants a table, and goes neither with multipliers nor with gaps that are closed.
  subroutine check_shrink(model, pair, diagnostics)
    type(model_t), intent(in) :: model !! tables
    type(pair_t), intent(in) :: pair !! the pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (.not. has_load(model%tables, pair%shrinking%shrink)) then
      call report_error(diagnostics, pair%shrinking%shrink_at, 'proportional load '// &
        to_text(pair%shrinking%shrink)//' has no table', 'define it with PROPortional '// &
        to_text(pair%shrinking%shrink)//', or write 0 for the sum of all tables')
    else if (pair%augmented) then
      call report_error(diagnostics, pair%shrinking%shrink_at, 'SHRInk does not go with AUGMent', &
        'leave AUGMent out; a penalty of AUTO 100 leaves little of the overlap')
    else if (pair%fit%adjusted) then
      call report_error(diagnostics, pair%shrinking%shrink_at, &
        'SHRInk does not go with ADJUst, which '// &
        'takes the overlap away', 'leave one of them out')
    end if
  end subroutine check_shrink
end module overlap_checks
