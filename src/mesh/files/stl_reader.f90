!> STL: triangles alone, each with its own three corners, as text or as bytes.
module stl_reader
  use, intrinsic :: iso_fortran_env, only: int32, int64, real32
  use kinds, only: wp
  use text, only: to_text, lower
  use file_cursor, only: cursor_t, start_cursor, fail, read_line, read_real
  use mesh_file_types, only: file_mesh_t, start_file_mesh, add_node, add_cell
  implicit none
  private
  public :: is_stl, read_stl

  !> Bytes of the head of a binary file, of its count, and of a triangle.
  integer, parameter :: head_bytes = 80, count_bytes = 4, triangle_bytes = 50

contains

  !> The file holds triangles for a printer, by its name or its first word.
  pure logical function is_stl(path, text)
    character(*), intent(in) :: path !! its path
    character(*), intent(in) :: text !! what it holds

    is_stl = index(lower(path), '.stl', back=.true.) == max(1, len(path) - 3) .and. &
      index(text(:min(1, len(text))), '$') == 0
    is_stl = is_stl .or. index(text(:min(6, len(text))), 'solid ') == 1 .or. is_binary(text)
  end function is_stl

  !> Reads a file of either kind.
  subroutine read_stl(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(out) :: file !! its triangles
    type(cursor_t), intent(out) :: cursor !! what is wrong with it

    call start_file_mesh(len(text), file)
    call start_cursor(text, cursor)
    if (is_binary(text)) then
      call read_bytes(text, file, cursor)
    else
      call read_words(text, file, cursor)
    end if
    if (cursor%failed .or. file%cells > 0) return
    if (looks_binary(text)) then
      call refuse_length(text, cursor)
    else
      call fail(cursor, 1, 'the file has no triangles', &
        'an STL file has lines of facet, vertex, endfacet, or is binary')
    end if
  end subroutine read_stl

  !> Some byte of the file is none of a text: lines have no zeros and no other signs of control.
  pure logical function looks_binary(text)
    character(*), intent(in) :: text !! the file
    integer :: i

    looks_binary = .false.
    do i = 1, len(text)
      select case (iachar(text(i:i)))
      case (0:8, 14:25, 27:31)
        looks_binary = .true.
        return
      end select
    end do
  end function looks_binary

  !> Reports a binary file that has not the length that its count of triangles asks for.
  subroutine refuse_length(text, cursor)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    character(*), parameter :: stl_remedy = 'is the file complete? write it again'
    character(:), allocatable :: counts
    integer(int64) :: wanted, there

    if (len(text) < head_bytes + count_bytes) then
      call fail(cursor, 1, 'a binary STL file is cut short: it has '//to_text(len(text))// &
        ' bytes, and its head alone takes '//to_text(head_bytes + count_bytes), stl_remedy)
      return
    end if
    wanted = modulo(triangles_of(text), 2_int64**32)
    there = (len(text, int64) - head_bytes - count_bytes)/triangle_bytes
    counts = to_text(real(wanted, wp))//' triangles are announced, and there are bytes for '// &
      to_text(int(there))
    if (wanted == 0 .and. there == 0) then
      call fail(cursor, 1, 'the file has no triangles: its head says 0', stl_remedy)
    else if (wanted > there) then
      call fail(cursor, 1, 'a binary STL file is cut short: '//counts, stl_remedy)
    else
      call fail(cursor, 1, 'a binary STL file is longer than it says: '//counts, stl_remedy)
    end if
  end subroutine refuse_length

  !> A binary file is as long as its count of triangles says.
  pure logical function is_binary(text)
    character(*), intent(in) :: text !! the file

    is_binary = .false.
    if (len(text) < head_bytes + count_bytes) return
    is_binary = triangles_of(text)*triangle_bytes + head_bytes + count_bytes == len(text, int64)
  end function is_binary

  !> The count of triangles of a binary file.
  pure integer(int64) function triangles_of(text) result(n)
    character(*), intent(in) :: text !! the file

    n = int(transfer(text(head_bytes + 1:head_bytes + count_bytes), 0_int32), int64)
  end function triangles_of

  !> Twelve numbers of four bytes a triangle, its normal first, and two bytes.
  subroutine read_bytes(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! gets its triangles
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    real(real32) :: x(12)
    integer :: i, k, at

    do i = 1, int(triangles_of(text))
      at = head_bytes + count_bytes + triangle_bytes*(i - 1) + 1
      x = transfer(text(at:at + 47), x)
      if (.not. all(abs(x(4:)) <= huge(x))) then
        call fail(cursor, 1, 'triangle '//to_text(i)//' has a corner that is not a number', &
          'write the file again')
        return
      end if
      do k = 1, 3
        call add_node(file, 3*(i - 1) + k, real(x(3*k + 1:3*k + 3), wp), at)
      end do
      call add_cell(file, i, [3*i - 2, 3*i - 1, 3*i], 2, 0, at)
    end do
  end subroutine read_bytes

  !> Lines that begin with vertex, three of them a triangle; all other words say nothing more.
  subroutine read_words(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! gets its triangles
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    type(cursor_t) :: here
    integer :: first, last, n, k
    logical :: found
    real(wp) :: x(3)

    n = 0
    do
      call read_line(text, cursor, first, last, found)
      if (cursor%failed .or. .not. found) exit
      if (lower(text(first:min(last, first + 6))) == 'endloop' .and. mod(n, 3) /= 0) then
        call fail(cursor, first, 'a facet of STL has three lines of vertex', &
          'write the file again, as triangles')
        return
      end if
      if (lower(text(first:min(last, first + 5))) /= 'vertex') cycle
      here = cursor
      here%at = first + 6
      here%last = last
      do k = 1, 3
        call read_real(text, here, x(k), 'a coordinate')
      end do
      if (here%failed) then
        if (here%at > last) then
          call fail(cursor, first, 'a vertex of STL has three coordinates', &
            'write the file again, as triangles')
        else
          call fail(cursor, here%fault, here%what, here%remedy)
        end if
        return
      end if
      n = n + 1
      call add_node(file, n, x, first)
      if (mod(n, 3) == 0) call add_cell(file, n/3, [n - 2, n - 1, n], 2, 0, first)
    end do
    if (mod(n, 3) /= 0) call fail(cursor, cursor%last, 'the file ends within a triangle', &
      'is the file complete? write it again')
  end subroutine read_words
end module stl_reader
