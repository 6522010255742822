!> Anderson's acceleration of an iteration x := g(x) whose error falls slowly (doc/theory,
!! "Multiplier fields", eq. (7.12)).
module acceleration
  use kinds, only: wp
  implicit none
  private
  public :: acceleration_t, accelerate, forget

  !> Differences of iterates that are remembered.
  integer, parameter :: depth = 8
  !> A difference that is all but this share a sum of newer ones says nothing new.
  real(wp), parameter :: least_new = 1.0e-6_wp

  !> What earlier iterates have shown.
  type :: acceleration_t
    integer :: n = 0 !! differences at hand
    logical :: begun = .false. !! there is an iterate before
    real(wp), allocatable :: rest(:) !! (size of x) its g(x) - x
    real(wp), allocatable :: image(:) !! (size of x) its g(x)
    real(wp), allocatable :: rests(:, :) !! (size of x, depth) differences of g(x) - x, newest first
    real(wp), allocatable :: images(:, :) !! (size of x, depth) differences of g(x)
  end type acceleration_t

contains

  !> The next x: that sum of the images so far whose g(x) - x would vanish best if g were linear.
  !! Where the last step has made g(x) - x longer all before is forgotten.
  pure subroutine accelerate(memory, x, image, next)
    type(acceleration_t), intent(inout) :: memory !! learns from this iterate
    real(wp), intent(in) :: x(:) !! the iterate
    real(wp), intent(in) :: image(:) !! (size of x) its g(x)
    real(wp), intent(out) :: next(:) !! (size of x) the next iterate
    real(wp) :: rest(size(x))

    rest = image - x
    if (.not. allocated(memory%rests)) allocate (memory%rests(size(x), depth), &
      memory%images(size(x), depth), source=0.0_wp)
    if (memory%begun) then
      if (norm2(rest) >= norm2(memory%rest)) then
        call forget(memory)
      else
        memory%n = min(memory%n + 1, depth)
        memory%rests(:, 2:) = memory%rests(:, :depth - 1)
        memory%images(:, 2:) = memory%images(:, :depth - 1)
        memory%rests(:, 1) = rest - memory%rest
        memory%images(:, 1) = image - memory%image
      end if
    end if
    memory%rest = rest
    memory%image = image
    memory%begun = .true.
    call combine(memory, next)
  end subroutine accelerate

  !> Forgets all iterates.
  pure subroutine forget(memory)
    type(acceleration_t), intent(inout) :: memory !! begins anew

    memory%n = 0
    memory%begun = .false.
  end subroutine forget

  !> The newest image less its part along the differences: least squares by Gram and Schmidt.
  pure subroutine combine(memory, next)
    type(acceleration_t), intent(in) :: memory !! iterates
    real(wp), intent(out) :: next(:) !! the next iterate
    real(wp) :: q(size(next), depth), images(size(next), depth), rest(size(next)), part, length
    integer :: i, j, n

    n = 0
    rest = memory%rest
    next = memory%image
    do i = 1, memory%n
      q(:, n + 1) = memory%rests(:, i)
      images(:, n + 1) = memory%images(:, i)
      length = norm2(q(:, n + 1))
      do j = 1, n
        part = dot_product(q(:, j), q(:, n + 1))
        q(:, n + 1) = q(:, n + 1) - part*q(:, j)
        images(:, n + 1) = images(:, n + 1) - part*images(:, j)
      end do
      if (norm2(q(:, n + 1)) <= least_new*length) cycle
      n = n + 1
      length = norm2(q(:, n))
      q(:, n) = q(:, n)/length
      images(:, n) = images(:, n)/length
      part = dot_product(q(:, n), rest)
      rest = rest - part*q(:, n)
      next = next - part*images(:, n)
    end do
  end subroutine combine
end module acceleration
