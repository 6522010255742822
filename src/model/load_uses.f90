!> Proportional loads that nothing uses: a slip of the pen, as a rule.
module load_uses
  use text, only: to_text
  use deck_types, only: deck_t, location_t
  use records, only: item_integer
  use diagnostics, only: diagnostics_t, report_warning
  use model_types, only: model_t
  implicit none
  private
  public :: warn_of_unused_loads

contains

  !> Warns of the tables whose number nothing names. What has no number takes the sum of all.
  subroutine warn_of_unused_loads(deck, model, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! all that may use a table
    type(diagnostics_t), intent(inout) :: diagnostics !! gets warnings
    integer, allocatable :: named(:)
    integer :: k

    allocate (named, source=named_tables(model))
    if (any(named == 0)) return
    do k = 1, size(model%tables)
      if (any(named == model%tables(k)%number)) cycle
      call report_warning(diagnostics, place_of(deck, model%tables(k)%number), &
        'proportional load '//to_text(model%tables(k)%number)//' is used by nothing: no '// &
        'record ends with its number, and FPROportional does not give it')
    end do
  end subroutine warn_of_unused_loads

  !> The numbers of tables that loads, motions and pairs name; 0 where one takes the sum of all.
  pure function named_tables(model) result(named)
    type(model_t), intent(in) :: model !! all that may use a table
    integer, allocatable :: named(:)
    integer :: k, i

    associate (conditions => model%conditions)
      named = [pack(conditions%loads%table, [(conditions%loads(k)%displacement%n + &
        conditions%loads(k)%force%n > 0, k=1, size(conditions%loads))]), &
        [(conditions%pressures(k)%table, k=1, size(conditions%pressures))], &
        [([(conditions%rigid(k)%motions(i)%table, i=1, size(conditions%rigid(k)%motions)), &
        (conditions%rigid(k)%loads(i)%table, i=1, size(conditions%rigid(k)%loads))], &
        k=1, size(conditions%rigid))], &
        [(model%pairs(k)%shrinking%shrink, k=1, size(model%pairs))]]
    end associate
  end function named_tables

  !> Where a deck defines a table.
  pure type(location_t) function place_of(deck, number) result(at)
    type(deck_t), intent(in) :: deck !! the deck
    integer, intent(in) :: number !! of the table
    integer :: i

    do i = 1, size(deck%batch)
      if (deck%batch(i)%command == 'prop') at = deck%batch(i)%head%at
    end do
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'prop') cycle
      if (item_integer(deck%mesh(i)%head, 2) == number) at = deck%mesh(i)%head%at
    end do
  end function place_of
end module load_uses
