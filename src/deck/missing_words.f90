!> What was meant by an item that cannot stand where it does: a word is missing before it, it is one
!! half of a number, or a number should stand there.
module missing_words
  use deck_types, only: record_t, item_t, parameter_t, item_word
  use parameter_tree, only: find_parameter
  use numbers, only: is_letter
  use records, only: item_count
  use signatures, only: signature_t, token_t, kind_keyword, kind_name, kind_nothing, &
    kind_positive, kind_count, kind_integer, kind_axis
  implicit none
  private
  public :: with_word, is_value, decimal_comma, counts

contains

  !> The record as it would be right if a word before a number is missing: `FRICtion COULomb mu` for
  !! `FRICtion mu`; of several the first. Otherwise what it takes.
  function with_word(record, first, head, k, signature, alive, otherwise) result(t)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! first item that the signature is about
    character(*), intent(in) :: head !! what such a record begins with
    integer, intent(in) :: k !! number of the item, a number, that cannot stand where it does
    type(signature_t), intent(in) :: signature !! what the record takes
    logical, intent(in) :: alive(:) !! ways still possible before this item
    character(*), intent(in) :: otherwise !! what the record takes
    character(:), allocatable :: t, word
    integer :: i, j

    t = otherwise
    j = k - first + 1
    word = ''
    do i = 1, size(alive)
      if (.not. alive(i)) cycle
      associate (tokens => signature%alternatives(i)%tokens)
        if (size(tokens) /= item_count(record) - first + 2) cycle
        if (tokens(j)%kind /= kind_keyword) cycle
        if (any([kind_keyword, kind_name, kind_nothing] == tokens(j + 1)%kind)) cycle
        word = trim(tokens(j)%label)
        exit
      end associate
    end do
    if (len(word) == 0) return
    t = trim(head)
    do i = first, item_count(record)
      if (i == k) t = t//' '//word
      t = t//' '//record%items(i)%text
    end do
    t = 'did you mean '''//t//'''? '//otherwise
  end function with_word

  !> A token is the number of something.
  pure logical function counts(token)
    type(token_t), intent(in) :: token !! what may stand at a place

    counts = any([kind_positive, kind_count, kind_integer, kind_axis] == token%kind)
  end function counts

  !> Advice where two integers stand to the left and right of a comma, and are one item too many;
  !! empty where not.
  pure function decimal_comma(record, k, line) result(t)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: k !! number of the item that is too many
    character(*), intent(in) :: line !! the line it stands in
    character(:), allocatable :: t
    integer :: i

    t = ''
    do i = 2, k
      if (record%items(i)%at%line /= record%items(k)%at%line) cycle
      associate (left => record%items(i - 1), right => record%items(i))
        if (left%at%line /= right%at%line) cycle
        if (right%at%column /= left%at%column + len(left%text) + 1) cycle
        if (right%at%column > len(line) .or. right%at%column < 2) cycle
        if (line(right%at%column - 1:right%at%column - 1) /= ',') cycle
        if (verify(left%text, '+-0123456789') > 0 .or. verify(right%text, '0123456789') > 0) cycle
        t = '; a comma parts two items: is '//left%text//'.'//right%text//' meant?'
        return
      end associate
    end do
  end function decimal_comma

  !> Whether an item is meant as a number.
  logical function is_value(item, parameters)
    type(item_t), intent(in) :: item !! the item
    type(parameter_t), intent(in) :: parameters(:) !! parameters there are

    is_value = .false.
    if (item%kind /= item_word) return
    is_value = .true.
    if (is_letter(item%text(1:1))) is_value = scan(item%text, '+*/^(') > 0 &
      .or. find_parameter(parameters, item%text) > 0
  end function is_value
end module missing_words
