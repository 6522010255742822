!> Parts of a set of places, halved across their longest sides (doc/theory, "Contact operator of low
!! rank").
module part_halving
  use kinds, only: wp
  implicit none
  private
  public :: halve_parts, split_part

contains

  !> Halves a part across its longest side until it has few.
  pure recursive subroutine halve_parts(place, most, first, last, order, ends, parts)
    real(wp), intent(in) :: place(:, :) !! (3, all) [length]
    integer, intent(in) :: most !! of a part
    integer, intent(in) :: first, last !! the part in order
    integer, intent(inout) :: order(:) !! (all) is sorted
    integer, intent(inout) :: ends(:) !! where finished parts end in order
    integer, intent(inout) :: parts !! finished parts
    integer :: split

    split = last
    if (last - first + 1 > most) call split_part(place, first, last, order, split)
    if (split == last) then
      parts = parts + 1
      ends(parts) = last
    else
      call halve_parts(place, most, first, split, order, ends, parts)
      call halve_parts(place, most, split + 1, last, order, ends, parts)
    end if
  end subroutine halve_parts

  !> Sorts a part into two across its longest side.
  pure subroutine split_part(place, first, last, order, split)
    real(wp), intent(in) :: place(:, :) !! (3, all) [length]
    integer, intent(in) :: first, last !! the part in order
    integer, intent(inout) :: order(:) !! (all) is sorted
    integer, intent(out) :: split !! the last of the first half; last where there are no halves
    real(wp) :: low(3), high(3), middle
    integer :: axis

    associate (mine => order(first:last))
      low = minval(place(:, mine), 2)
      high = maxval(place(:, mine), 2)
      axis = maxloc(high - low, 1)
      middle = 0.5_wp*(low(axis) + high(axis))
      split = first - 1 + count(place(axis, mine) <= middle)
      if (split < last) order(first:last) = [pack(mine, place(axis, mine) <= middle), &
        pack(mine, place(axis, mine) > middle)]
    end associate
  end subroutine split_part
end module part_halving
