!> Finds the word a user probably meant.
module hints
  use text, only: string_t, lower, append_string
  implicit none
  private
  public :: word_list_t, add_candidate, is_listed, nearest_word, did_you_mean

  !> Words to choose from.
  type :: word_list_t
    type(string_t), allocatable :: words(:) !! may be larger than count
    integer :: count = 0 !! number of words
  end type word_list_t

contains

  !> Adds a word to choose from.
  subroutine add_candidate(list, word)
    type(word_list_t), intent(inout) :: list !! the list to extend
    character(*), intent(in) :: word !! as it is to be shown

    call append_string(list%words, list%count, word)
  end subroutine add_candidate

  !> A word is among the candidates.
  pure logical function is_listed(list, word) result(listed)
    type(word_list_t), intent(in) :: list !! the list
    character(*), intent(in) :: word !! may be in it
    integer :: i

    listed = .false.
    do i = 1, list%count
      listed = listed .or. list%words(i)%s == word
    end do
  end function is_listed

  !> The candidate nearest to `word`; empty if none is near. Keywords (in which the first four
  !> letters stand out as capitals) may be cut short.
  function nearest_word(list, word) result(hint)
    type(word_list_t), intent(in) :: list !! words to choose from
    character(*), intent(in) :: word !! what the user wrote
    character(:), allocatable :: hint
    integer :: i, distance, best

    hint = ''
    if (len(word) > 40) return
    best = allowed(len(word)) + 1
    do i = 1, list%count
      distance = difference(word, list%words(i)%s)
      if (distance < best) then
        best = distance
        hint = list%words(i)%s
      end if
    end do
  end function nearest_word

  !> Errors allowed in a word of n letters.
  pure integer function allowed(n)
    integer, intent(in) :: n !! its length

    allowed = min(2, max(1, n - 4))
    if (n > 8) allowed = n/3
    if (n < 2) allowed = 0
  end function allowed

  !> How far a word is from a candidate, or from as many of its first letters.
  pure integer function difference(word, candidate) result(d)
    character(*), intent(in) :: word !! what the user wrote
    character(*), intent(in) :: candidate !! what might be meant
    integer :: n

    d = alignment_distance(lower(word), lower(candidate))
    n = len(word)
    if (n < 4 .or. n >= len(candidate)) return
    if (is_abbreviated(candidate)) d = min(d, alignment_distance(lower(word), &
                                                                 lower(candidate(:n))))
  end function difference

  !> Insertions, deletions, replacements and swaps of neighbours that turn `a` into `b`.
  pure integer function alignment_distance(a, b) result(d)
    character(*), intent(in) :: a !! first word
    character(*), intent(in) :: b !! second word
    integer :: table(-1:len(a), -1:len(b)), i, j

    table = len(a) + len(b)
    table(0:, 0) = [(i, i=0, len(a))]
    table(0, 0:) = [(j, j=0, len(b))]
    do j = 1, len(b)
      do i = 1, len(a)
        table(i, j) = min(table(i - 1, j) + 1, table(i, j - 1) + 1, &
                          table(i - 1, j - 1) + merge(0, 1, a(i:i) == b(j:j)))
        if (swapped(a, i, b, j)) table(i, j) = min(table(i, j), table(i - 2, j - 2) + 1)
      end do
    end do
    d = table(len(a), len(b))
  end function alignment_distance

  !> Whether the characters up to a(i) are those up to b(j) in opposite order.
  pure logical function swapped(a, i, b, j)
    character(*), intent(in) :: a !! first word
    integer, intent(in) :: i !! place in it
    character(*), intent(in) :: b !! second word
    integer, intent(in) :: j !! place in it

    swapped = i > 1 .and. j > 1
    if (swapped) swapped = a(i:i) == b(j - 1:j - 1) .and. a(i - 1:i - 1) == b(j:j)
  end function swapped

  !> Whether a word is written as keywords are: COORdinates.
  pure logical function is_abbreviated(word)
    character(*), intent(in) :: word !! more than four letters

    is_abbreviated = verify(word(:4), 'ABCDEFGHIJKLMNOPQRSTUVWXYZ') == 0
  end function is_abbreviated

  !> "did you mean 'x'?" for the nearest candidate, else `otherwise`.
  function did_you_mean(list, word, otherwise) result(t)
    type(word_list_t), intent(in) :: list !! words to choose from
    character(*), intent(in) :: word !! what the user wrote
    character(*), intent(in) :: otherwise !! advice if nothing is near
    character(:), allocatable :: t, hint

    hint = nearest_word(list, word)
    t = otherwise
    if (len(hint) > 0) t = 'did you mean '''//hint//'''?'
  end function did_you_mean
end module hints
