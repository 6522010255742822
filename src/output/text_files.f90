!> Text files that are complete after each flush and that say so when they cannot be written. Of the
!! processes of a run the first writes them.
module text_files
  use, intrinsic :: iso_c_binding, only: c_associated, c_null_char, c_null_ptr, c_ptr, c_int, &
    c_size_t
  use errors, only: error_t, raise, exit_resources
  use ranks, only: this_rank
  use libc, only: c_fopen, c_fwrite, c_fflush, c_fclose, c_mkdir, c_rename, c_realpath, &
    path_limit, c_fileno, c_flock, read_errno
  implicit none
  private
  public :: text_file_t, create_text_file, create_locked_file, write_line, flush_text_file, &
    close_text_file, &
    make_folder, rename_file, remove_file, real_path

  !> A text file open for writing.
  type :: text_file_t
    type(c_ptr) :: stream = c_null_ptr !! C stream, null while closed
    type(c_ptr) :: lock = c_null_ptr !! C stream that holds the lock, null for none
    character(:), allocatable :: path !! name of the file
  end type text_file_t

contains

  !> Creates a file, or empties the one that is there.
  subroutine create_text_file(file, path, error)
    type(text_file_t), intent(out) :: file !! the file, open
    character(*), intent(in) :: path !! its name
    type(error_t), allocatable, intent(inout) :: error !! no permission, no such folder
    character(200) :: reason
    integer :: unit, status

    if (allocated(error)) return
    file%path = trim(path)
    if (this_rank() > 0) file%path = '/dev/null'
    reason = ''
    open (newunit=unit, file=file%path, action='write', status='unknown', iostat=status, &
      iomsg=reason)
    if (status == 0) then
      close (unit)
      file%stream = c_fopen(file%path//c_null_char, 'w'//c_null_char)
    end if
    if (.not. c_associated(file%stream)) then
      call raise(error, exit_resources, 'error: cannot create the file '//file%path//': '// &
        trim(reason)//new_line('a')// &
        '  Is the folder there, and may you write to it? --out DIR names another one.')
    end if
  end subroutine create_text_file

  !> Creates a file that no other process may create as long as it is open; one that another process
  !! holds is left as it is. Where the system cannot lock, it is created without.
  subroutine create_locked_file(file, path, error)
    type(text_file_t), intent(out) :: file !! the file, open
    character(*), intent(in) :: path !! its name
    type(error_t), allocatable, intent(out) :: error !! no permission, or another process has it
    integer(c_int), parameter :: alone = 6_c_int, would_wait = 11_c_int
    integer(c_int) :: status, number
    type(c_ptr) :: stream

    stream = c_null_ptr
    if (this_rank() == 0) stream = c_fopen(trim(path)//c_null_char, 'a'//c_null_char)
    status = 0_c_int
    if (c_associated(stream)) then
      status = c_flock(c_fileno(stream), alone)
      call read_errno(number)
      if (status /= 0_c_int .and. number == would_wait) then
        status = c_fclose(stream)
        call raise(error, exit_resources, 'error: another run is writing to '//trim(path)// &
          new_line('a')//'  wait for its end, or let this one write elsewhere: --out DIR')
        return
      end if
    end if
    call create_text_file(file, path, error)
    if (allocated(error)) then
      if (c_associated(stream)) status = c_fclose(stream)
      return
    end if
    file%lock = stream
  end subroutine create_locked_file

  !> Adds one line; blanks at its end are dropped.
  subroutine write_line(file, line, error)
    type(text_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: line !! text without line end; may hold several lines
    type(error_t), allocatable, intent(inout) :: error !! disk full
    integer(c_size_t) :: length

    if (allocated(error)) return
    length = len_trim(line, kind=c_size_t) + 1_c_size_t
    if (c_fwrite(trim(line)//new_line('a'), 1_c_size_t, length, file%stream) < length) then
      call raise_write_error(file, error)
    end if
  end subroutine write_line

  !> Hands everything written so far to the system, so that it outlives a killed run.
  subroutine flush_text_file(file, error)
    type(text_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! disk full

    if (allocated(error)) return
    if (c_fflush(file%stream) /= 0_c_int) call raise_write_error(file, error)
  end subroutine flush_text_file

  !> Closes the file; a file that is not open is left alone.
  subroutine close_text_file(file, error)
    type(text_file_t), intent(inout) :: file !! the file
    type(error_t), allocatable, intent(inout) :: error !! disk full; one that came before
    !! stays

    if (.not. c_associated(file%stream)) return
    if (c_fclose(file%stream) /= 0_c_int) call raise_write_error(file, error)
    file%stream = c_null_ptr
    if (.not. c_associated(file%lock)) return
    if (c_fclose(file%lock) /= 0_c_int) call raise_write_error(file, error)
    file%lock = c_null_ptr
  end subroutine close_text_file

  !> Makes a folder and those above it; folders that are there are left alone.
  subroutine make_folder(path, error)
    character(*), intent(in) :: path !! folder
    type(error_t), allocatable, intent(out) :: error !! no permission
    integer(c_int), parameter :: mode = int(o'777', c_int)
    integer(c_int) :: status
    logical :: there
    integer :: i

    status = 0_c_int
    do i = 2, len_trim(path)
      if (path(i:i) == '/') status = c_mkdir(path(:i - 1)//c_null_char, mode)
    end do
    status = c_mkdir(trim(path)//c_null_char, mode)
    if (status == 0_c_int) return
    inquire (file=trim(path)//'/.', exist=there)
    if (.not. there) then
      call raise(error, exit_resources, 'error: cannot make the folder '//trim(path)// &
        new_line('a')//'  Is there a file of that name, and may you write to the folder above it?')
    end if
  end subroutine make_folder

  !> Gives a file a new name; a file that has that name is replaced in one go.
  subroutine rename_file(old, new, error)
    character(*), intent(in) :: old !! its name
    character(*), intent(in) :: new !! its new name
    type(error_t), allocatable, intent(out) :: error !! no permission

    if (this_rank() > 0) return
    if (c_rename(trim(old)//c_null_char, trim(new)//c_null_char) == 0_c_int) return
    call raise(error, exit_resources, 'error: cannot rename the file '//trim(old)//' to '// &
      trim(new)//new_line('a')//'  Is there a folder of that name, and may you write to it?')
  end subroutine rename_file

  !> Removes a file, if it is there and that is allowed.
  subroutine remove_file(path)
    character(*), intent(in) :: path !! the file
    integer :: unit, status

    if (this_rank() > 0) return
    open (newunit=unit, file=path, status='old', iostat=status)
    if (status /= 0) return
    close (unit, status='delete')
  end subroutine remove_file

  !> The path of a file or folder without links and dots; empty if there is none.
  function real_path(path) result(real)
    character(*), intent(in) :: path !! any path to it
    character(:), allocatable :: real
    character(path_limit) :: buffer

    buffer = ''
    real = ''
    if (.not. c_associated(c_realpath(trim(path)//c_null_char, buffer))) return
    real = buffer(:index(buffer, c_null_char) - 1)
  end function real_path

  !> The error of a write that the system refused.
  subroutine raise_write_error(file, error)
    type(text_file_t), intent(in) :: file !! the file
    type(error_t), allocatable, intent(inout) :: error !! filled, unless one came before

    if (.not. allocated(error)) call raise(error, exit_resources, 'error: cannot write to '// &
      file%path//new_line('a')//'  The disk may be full. What stands in the file is valid up '// &
      'to the last whole line.')
  end subroutine raise_write_error
end module text_files
