!> Small questions that the readers of data sets ask of a record.
module records
  use kinds, only: wp
  use text, only: lower
  use deck_types, only: record_t, item_t, location_t, item_word, item_quoted
  implicit none
  private
  public :: item_count, item_integer, item_real, item_name, item_location, is_word, four_letters

contains

  !> Number of items of a record.
  pure integer function item_count(record) result(n)
    type(record_t), intent(in) :: record !! the record

    n = 0
    if (allocated(record%items)) n = size(record%items)
  end function item_count

  !> The value of an item as an integer; 0 if it is empty or missing.
  pure integer function item_integer(record, i) result(value)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! number of the item

    value = 0
    if (i <= item_count(record)) value = nint(record%items(i)%value)
  end function item_integer

  !> The value of an item; 0 if it is empty or missing.
  pure real(wp) function item_real(record, i) result(value)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! number of the item

    value = 0.0_wp
    if (i <= item_count(record)) value = record%items(i)%value
  end function item_real

  !> An item as written (without quotes); empty if it is missing.
  pure function item_name(record, i) result(name)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! number of the item
    character(:), allocatable :: name

    name = ''
    if (i > item_count(record)) return
    if (allocated(record%items(i)%text)) name = record%items(i)%text
  end function item_name

  !> Where an item stands; the place behind the last item if it is missing.
  pure type(location_t) function item_location(record, i) result(at)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! number of the item
    integer :: n

    n = item_count(record)
    at = record%at
    if (i <= n) then
      at = record%items(i)%at
    else if (n > 0) then
      at = record%items(n)%at
      at%column = at%column + len(item_name(record, n)) + 1
      if (record%items(n)%kind == item_quoted) at%column = at%column + 2
    end if
  end function item_location

  !> Whether an item is a given keyword: the first four characters count, in either case.
  pure logical function is_word(item, word)
    type(item_t), intent(in) :: item !! the item
    character(*), intent(in) :: word !! the keyword, any case and length

    is_word = .false.
    if (item%kind == item_word) is_word = four_letters(item%text) == four_letters(word)
  end function is_word

  !> First four characters in lower case.
  pure character(4) function four_letters(word) result(key)
    character(*), intent(in) :: word !! any word

    key = word
    key = lower(key)
  end function four_letters
end module records
