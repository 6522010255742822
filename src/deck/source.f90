!> The text of all files a deck consists of, kept as read so that errors can show their lines.
module source
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_long, c_null_char, c_ptr, c_size_t
  use libc, only: c_fopen, c_fread, c_fclose
  use file_identity, only: file_identity_t, identify, obstacle_of, kind_none, kind_file, kind_pipe
  implicit none
  private
  public :: source_t, source_file_t, add_file, add_text, source_line, file_name, beside

  !> One file with the places where its lines start and end.
  type :: source_file_t
    character(:), allocatable :: name !! path, as it can be opened
    character(:), allocatable :: text !! all its bytes
    integer, allocatable :: first(:) !! first character of each line
    integer, allocatable :: last(:) !! last character of each line, without its line end
    integer :: lines = 0 !! number of lines
    logical :: piped = .false. !! it came through a pipe: it cannot be read again
    ! A text that has been put together of several files:
    integer, allocatable :: piece_start(:) !! (pieces) first character of each piece
    integer, allocatable :: piece_file(:) !! (pieces) number of its file
    integer, allocatable :: piece_at(:) !! (pieces) character of that file where it begins
  end type source_file_t

  !> The main file (number 1) and what it includes, in the order they were opened.
  type :: source_t
    type(source_file_t), allocatable :: files(:) !! may be larger than count
    integer :: count = 0 !! number of files
  end type source_t

contains

  !> Reads a file, or a pipe to its end; `problem` says why it could not be read.
  subroutine add_file(source, name, problem)
    type(source_t), intent(inout) :: source !! the source to extend
    character(*), intent(in) :: name !! path of the file
    character(:), allocatable, intent(out) :: problem !! allocated if the file cannot be read
    type(file_identity_t) :: file
    character(:), allocatable :: text
    type(c_ptr) :: stream

    file = identify(name)
    if (file%kind == kind_none) then
      problem = 'there is no such file'
    else if (file%kind == kind_file .or. file%kind == kind_pipe) then
      stream = c_fopen(trim(name)//c_null_char, 'r'//c_null_char)
      if (c_associated(stream)) then
        call read_to_end(stream, file%size, text, problem)
      else
        problem = 'the file cannot be opened'
      end if
    else
      problem = obstacle_of(file)
    end if
    if (allocated(problem)) return
    call take_text(source, name, text)
    source%files(source%count)%piped = file%kind == kind_pipe
  end subroutine add_file

  !> Reads a stream to its end and closes it. A regular file says beforehand what it holds, a pipe
  !! at its end.
  subroutine read_to_end(stream, expected, text, problem)
    type(c_ptr), intent(in) :: stream !! open stream
    integer(c_long), intent(in) :: expected !! bytes of a regular file, 0 where that is not known
    character(:), allocatable, intent(out) :: text !! all its bytes
    character(:), allocatable, intent(inout) :: problem !! allocated if they cannot be read
    integer(c_long), parameter :: first_bytes = 65536, most_source_bytes = huge(1) - 1
    character(:), allocatable :: longer
    integer(c_long) :: room, taken
    integer(c_int) :: ignored

    room = merge(expected, first_bytes, expected > 0)
    taken = 0
    do while (room <= most_source_bytes)
      allocate (character(room) :: longer)
      if (taken > 0) longer(:taken) = text
      call move_alloc(longer, text)
      taken = taken + int(c_fread(text(taken + 1:), 1_c_size_t, int(room - taken, c_size_t), &
        stream), c_long)
      if (taken < room .or. expected > 0) exit
      room = 2*room
    end do
    ignored = c_fclose(stream)
    if (room > most_source_bytes) then
      problem = 'it is larger than 2 GB'
    else if (taken < expected) then
      problem = 'the file cannot be read'
    else if (taken < room) then
      text = text(:taken)
    end if
  end subroutine read_to_end

  !> Adds a text as if it had been read from a file.
  subroutine add_text(source, name, text)
    type(source_t), intent(inout) :: source !! the source to extend
    character(*), intent(in) :: name !! name it is reported under
    character(*), intent(in) :: text !! all its bytes
    character(:), allocatable :: copy

    copy = text
    call take_text(source, name, copy)
  end subroutine add_text

  !> Adds a text without a copy of it.
  subroutine take_text(source, name, text)
    type(source_t), intent(inout) :: source !! the source to extend
    character(*), intent(in) :: name !! name it is reported under
    character(:), allocatable, intent(inout) :: text !! all its bytes; goes
    type(source_file_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(source%files)) allocate (source%files(4))
    if (source%count == size(source%files)) then
      allocate (more(2*source%count))
      do i = 1, source%count
        call move_file(source%files(i), more(i))
      end do
      call move_alloc(more, source%files)
    end if
    source%count = source%count + 1
    source%files(source%count)%name = name
    call move_alloc(text, source%files(source%count)%text)
    call split_lines(source%files(source%count))
  end subroutine take_text

  !> Hands the contents of one file over to another place.
  subroutine move_file(from, to)
    type(source_file_t), intent(inout) :: from !! left empty
    type(source_file_t), intent(inout) :: to !! filled

    call move_alloc(from%name, to%name)
    call move_alloc(from%text, to%text)
    call move_alloc(from%first, to%first)
    call move_alloc(from%last, to%last)
    call move_alloc(from%piece_start, to%piece_start)
    call move_alloc(from%piece_file, to%piece_file)
    call move_alloc(from%piece_at, to%piece_at)
    to%lines = from%lines
    to%piped = from%piped
  end subroutine move_file

  !> Finds the lines; a line ends with LF, CR LF or CR, the last one also without.
  subroutine split_lines(file)
    type(source_file_t), intent(inout) :: file !! its text is known
    integer :: i, n, start

    n = 0
    do i = 1, len(file%text)
      if (file%text(i:i) > achar(13)) cycle ! nearly all of them
      if (ends_line(file%text, i)) n = n + 1
    end do
    if (len(file%text) > 0) then
      if (.not. ends_line(file%text, len(file%text))) n = n + 1
    end if
    allocate (file%first(n), file%last(n))
    file%lines = n
    start = 1
    if (len(file%text) >= 3) then
      if (file%text(:3) == char(239)//char(187)//char(191)) start = 4 ! mark of UTF-8
    end if
    n = 0
    do i = 1, len(file%text)
      if (file%text(i:i) > achar(13)) cycle
      if (ends_line(file%text, i)) call close_line(i - 1)
    end do
    if (n < file%lines) call close_line(len(file%text))

  contains

    !> Notes one line.
    subroutine close_line(last)
      integer, intent(in) :: last !! its last character

      n = n + 1
      file%first(n) = start
      file%last(n) = last
      if (last >= start .and. last < len(file%text)) then
        if (file%text(last:last + 1) == achar(13)//achar(10)) file%last(n) = last - 1
      end if
      start = last + 2
    end subroutine close_line
  end subroutine split_lines

  !> Whether a line ends with this character: LF, or a CR that is not followed by one.
  pure logical function ends_line(text, i) result(ends)
    character(*), intent(in) :: text !! bytes of a file
    integer, intent(in) :: i !! place of the character

    ends = text(i:i) == achar(10)
    if (text(i:i) /= achar(13)) return
    ends = i == len(text)
    if (.not. ends) ends = text(i + 1:i + 1) /= achar(10)
  end function ends_line

  !> One line without its line end; empty where there is none.
  function source_line(source, file, line) result(text)
    type(source_t), intent(in) :: source !! all files
    integer, intent(in) :: file !! number of the file
    integer, intent(in) :: line !! number of the line
    character(:), allocatable :: text

    text = ''
    if (file < 1 .or. file > source%count) return
    if (line < 1 .or. line > source%files(file)%lines) return
    text = source%files(file)%text(source%files(file)%first(line):source%files(file)%last(line))
  end function source_line

  !> Path of a file.
  function file_name(source, file) result(name)
    type(source_t), intent(in) :: source !! all files
    integer, intent(in) :: file !! number of the file
    character(:), allocatable :: name

    name = 'command line'
    if (file >= 1 .and. file <= source%count) name = source%files(file)%name
  end function file_name

  !> The path of a file as it is found from the one that names it: relative to that one's folder, to
  !! the working directory where it has none of its own (`/dev/stdin`).
  function beside(source, file, path) result(full)
    type(source_t), intent(in) :: source !! all files
    integer, intent(in) :: file !! number of the file that names it
    character(*), intent(in) :: path !! as written there
    character(:), allocatable :: full

    full = path
    ! file 0 is the command line
    if (path(1:min(1, len(path))) == '/' .or. file == 0) return
    associate (name => source%files(file)%name)
      if (index(name, '/dev/') /= 1) full = name(:index(name, '/', back=.true.))//path
    end associate
  end function beside
end module source
