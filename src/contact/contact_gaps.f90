!> The gaps of a pair at the start: what a user should know before the first solve.
module contact_gaps
  use kinds, only: wp
  use text, only: to_text, count_noun
  use contact_types, only: pair_t
  use contact_points, only: used_points, point_position, point_text
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: describe_gaps

  !> Gaps above minus this share of the search radius count as touching, not as penetration.
  real(wp), parameter :: touching = 1.0e-9_wp

contains

  !> One line on the gaps of a pair; `penetrates` if a point that no SHRInk takes up
  !! starts below the surface.
  subroutine describe_gaps(pair, x, line, penetrates)
    type(pair_t), intent(in) :: pair !! the pair with its first targets
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    character(:), allocatable, intent(out) :: line !! the description
    logical, intent(out) :: penetrates !! points start in penetration
    real(wp) :: xi(2), gap, least, largest
    integer :: p, n, over, below, deepest

    n = used_points(pair)
    over = 0
    below = 0
    deepest = 0
    least = huge(1.0_wp)
    largest = -huge(1.0_wp)
    do p = 1, n
      if (pair%history%old(p)%target == 0) cycle
      call project_on_master(pair, pair%history%old(p)%target, x, point_position(pair, p, x), xi, &
        gap)
      over = over + 1
      if (gap < -touching*pair%search_radius) below = below + 1
      if (gap < least) deepest = p
      least = min(least, gap)
      largest = max(largest, gap)
    end do
    penetrates = below > 0
    line = 'pair '//pair%name//' at the start: '//count_noun(n, 'point')//', '//to_text(over) &
      //' over the master'
    if (over > 0) line = line//', gaps '//to_text(least, 4)//' to '//to_text(largest, 4)
    penetrates = penetrates .and. pair%shrinking%shrink < 0
    if (below > 0 .and. pair%shrinking%shrink >= 0) line = line//'; '//count_noun(below, &
      'point')// &
      ' below the surface: SHRInk takes that up'
    if (penetrates) line = line//'; '//count_noun(below, 'point')// &
      ' below the surface, deepest '//point_text(pair, deepest)// &
      ': they are pushed out in the first increment'
  end subroutine describe_gaps
end module contact_gaps
