!> Blocks that wait in memory for their place behind the last ones of data sets: what many end times
!! have is written in one go, for a call of HDF5 costs more than a thousand numbers.
module hdf5_held
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_ptr
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: iso_fortran_env, only: int32, real32
  use hdf5, only: hid_t, h5t_native_integer, h5t_native_real, h5t_native_double
  use kinds, only: wp
  use errors, only: error_t
  use hdf5_io, only: hdf5_file_t, data_set_t, raise_hdf5, find_data_set
  use hdf5_data, only: move_block, words_at, at_end
  implicit none
  private
  public :: hold_block, hold_any, write_held

  !> Keeps a block of whole entries that belongs behind the last one.
  interface hold_block
    module procedure hold_reals
    module procedure hold_real_columns
    module procedure hold_integers
    module procedure hold_integer_columns
  end interface hold_block

contains

  !> Keeps a list of reals in memory.
  subroutine hold_reals(file, path, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(in), target, contiguous :: values(:) !! the numbers
    type(error_t), allocatable, intent(inout) :: error !! no such data set

    call hold_any(file, path, h5t_native_double, c_loc(values), size(values), error)
  end subroutine hold_reals

  !> Keeps columns of reals in memory.
  subroutine hold_real_columns(file, path, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(in), target, contiguous :: values(:, :) !! the numbers
    type(error_t), allocatable, intent(inout) :: error !! no such data set

    call hold_any(file, path, h5t_native_double, c_loc(values), size(values), error)
  end subroutine hold_real_columns

  !> Keeps a list of integers in memory.
  subroutine hold_integers(file, path, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in), target, contiguous :: values(:) !! the numbers
    type(error_t), allocatable, intent(inout) :: error !! no such data set

    call hold_any(file, path, h5t_native_integer, c_loc(values), size(values), error)
  end subroutine hold_integers

  !> Keeps columns of integers in memory.
  subroutine hold_integer_columns(file, path, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in), target, contiguous :: values(:, :) !! the numbers
    type(error_t), allocatable, intent(inout) :: error !! no such data set

    call hold_any(file, path, h5t_native_integer, c_loc(values), size(values), error)
  end subroutine hold_integer_columns

  !> Keeps a block that lies anywhere in memory.
  subroutine hold_any(file, path, type_id, address, n_numbers, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer(hid_t), intent(in) :: type_id !! type in memory
    type(c_ptr), intent(in) :: address !! the numbers
    integer, intent(in) :: n_numbers !! how many
    type(error_t), allocatable, intent(inout) :: error !! no such data set
    real(wp), pointer :: reals(:)
    integer :: place, i

    if (n_numbers == 0 .or. allocated(error)) return
    call find_data_set(file, path, place)
    if (place == 0) then
      call raise_hdf5(error, file, 'writing the data set '//path)
      return
    end if
    associate (set => file%sets(place))
      set%held_type = type_id
      if (set%single .and. type_id == h5t_native_double) then
        set%held_type = h5t_native_real
        call c_f_pointer(address, reals, [n_numbers])
        call make_room(set, n_numbers)
        do i = 1, n_numbers
          set%held(set%n_held + i) = single_word(reals(i))
        end do
        set%n_held = set%n_held + n_numbers
      else
        associate (words => words_at(address, type_id, n_numbers))
          call make_room(set, size(words))
          set%held(set%n_held + 1:set%n_held + size(words)) = words
          set%n_held = set%n_held + size(words)
        end associate
      end if
    end associate
  end subroutine hold_any

  !> Makes room for more words.
  subroutine make_room(set, n)
    type(data_set_t), intent(inout) :: set !! open
    integer, intent(in) :: n !! more that will wait
    integer(int32), allocatable :: longer(:)

    if (.not. allocated(set%held)) allocate (set%held(n))
    if (set%n_held + n <= size(set%held)) return
    allocate (longer(2*(set%n_held + n)))
    longer(:set%n_held) = set%held(:set%n_held)
    call move_alloc(longer, set%held)
  end subroutine make_room

  !> A real with 32 bits, as a word; what is beyond its range becomes the largest.
  elemental integer(int32) function single_word(x) result(word)
    real(wp), intent(in) :: x !! the real
    real(wp), parameter :: largest_single = real(huge(1.0_real32), wp)
    real(wp) :: y

    y = x
    if (.not. ieee_is_nan(x)) y = sign(min(abs(x), largest_single), x)
    word = transfer(real(y, real32), word)
  end function single_word

  !> Writes all that waits in memory.
  subroutine write_held(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(int32), allocatable, target :: words(:)
    character(:), allocatable :: path
    integer :: i, n

    if (allocated(error)) return
    do i = 1, file%n_open
      n = file%sets(i)%n_held
      if (n == 0) cycle
      path = file%sets(i)%path
      call move_alloc(file%sets(i)%held, words)
      file%sets(i)%n_held = 0
      if (file%sets(i)%held_type == h5t_native_double) n = n/2
      call move_block(file, path, file%sets(i)%held_type, c_loc(words), n, at_end, .true., error)
      call move_alloc(words, file%sets(i)%held)
      if (allocated(error)) return
    end do
  end subroutine write_held
end module hdf5_held
