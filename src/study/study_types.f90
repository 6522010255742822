!> What a study is: parameters, their values, and the variants made of these (doc/manual,
!! "Studies").
module study_types
  use kinds, only: wp
  use deck_types, only: location_t
  implicit none
  private
  public :: study_t, varied_t, study_grid, study_list, study_chain, make_variants

  !> How values are combined: all with all; side by side; the same, in this very order.
  integer, parameter :: study_grid = 1
  integer, parameter :: study_list = 2
  integer, parameter :: study_chain = 3

  !> A parameter and its values.
  type :: varied_t
    character(:), allocatable :: name !! of the parameter, or slip
    type(location_t) :: at !! where it stands
    logical :: rule = .false. !! the slip rule of all pairs with friction
    real(wp), allocatable :: values(:) !! its values
  end type varied_t

  !> A study.
  type :: study_t
    logical :: active = .false. !! there is one
    character(:), allocatable :: name !! its name
    type(location_t) :: at !! where it stands
    integer :: form = study_grid !! one of the forms
    real(wp) :: from = 0.0_wp !! time up to which all variants are the same
    type(location_t) :: from_at !! where it stands
    logical :: forced = .false. !! even where a parameter acts before that
    type(varied_t), allocatable :: varied(:) !! the parameters
    real(wp), allocatable :: variants(:, :) !! (parameters, variants) values
    integer, allocatable :: order(:) !! (variants) in which they are solved
  end type study_t

contains

  !> The variants, the last parameter fastest, and the order in which neighbours follow each other:
  !! a grid is gone through as a snake.
  subroutine make_variants(study)
    type(study_t), intent(inout) :: study !! varied given; gets variants, order
    integer :: n, k, i, p, stride, digit(size(study%varied)), counts(size(study%varied))
    logical :: back

    counts = [(size(study%varied(p)%values), p=1, size(counts))]
    if (study%form == study_grid) then
      n = product(counts)
    else
      n = minval(counts)
    end if
    allocate (study%variants(size(counts), n), study%order(n))
    do k = 1, n
      i = k - 1
      do p = size(counts), 1, -1
        digit(p) = mod(i, counts(p))
        if (study%form == study_grid) then
          i = i/counts(p)
        else
          digit(p) = k - 1
        end if
        study%variants(p, k) = study%varied(p)%values(digit(p) + 1)
      end do
    end do
    study%order = [(k, k=1, n)]
    if (study%form /= study_grid) return
    do k = 1, n
      i = k - 1
      digit = 0
      do p = size(counts), 1, -1
        digit(p) = mod(i, counts(p))
        i = i/counts(p)
      end do
      i = 0
      stride = 0
      do p = 1, size(counts)
        back = mod(stride, 2) == 1
        stride = stride*counts(p) + digit(p)
        if (back) digit(p) = counts(p) - 1 - digit(p)
        i = i*counts(p) + digit(p)
      end do
      study%order(k) = i + 1
    end do
  end subroutine make_variants
end module study_types
