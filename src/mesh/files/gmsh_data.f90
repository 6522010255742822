!> Reads $ElementData of Gmsh files: vectors of elements (a lay, for DIREction FIELd).
module gmsh_data
  use kinds, only: wp
  use text, only: to_text
  use file_cursor, only: cursor_t, fail, read_number, read_real, read_line, find_item
  use mesh_file_types, only: file_mesh_t, add_field, add_vector, add_remark
  implicit none
  private
  public :: read_element_data

contains

  !> $ElementData: tags that give the name and the counts, then element and components; the same in
  !! versions 2.2 and 4.1. Data without a name or of other than 3 components are left out.
  subroutine read_element_data(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! takes the vectors
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    character(:), allocatable :: name
    integer :: components, n, i, k, tag, at
    real(wp) :: unused, v(3)
    logical :: kept

    call read_tags(text, cursor, name, components, n)
    if (cursor%failed) return
    kept = components == 3 .and. len(name) > 0
    if (kept) call add_field(file, name, cursor%head)
    if (.not. kept) call add_remark(file, 'element data '''//name//''' of '// &
      to_text(components)//' components left out')
    do i = 1, n
      if (cursor%failed) exit
      call find_item(text, cursor, at)
      call read_number(text, cursor, tag, 'the tag of an element')
      v = 0.0_wp
      do k = 1, components
        call read_real(text, cursor, unused, 'a component of the data of an element')
        v(min(k, 3)) = unused
      end do
      if (kept .and. .not. cursor%failed) call add_vector(file%field(size(file%field)), tag, v, at)
    end do
  end subroutine read_element_data

  !> String, real and integer tags, each list behind its length; text even in binary files.
  subroutine read_tags(text, cursor, name, components, n)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the tags
    character(:), allocatable, intent(out) :: name !! the first string, without its quotes
    integer, intent(out) :: components !! numbers for each element
    integer, intent(out) :: n !! elements with data
    integer :: i, count, number, first, last
    real(wp) :: unused
    logical :: binary, found

    name = ''
    components = 0
    n = 0
    binary = cursor%binary
    cursor%binary = .false.
    call read_number(text, cursor, count, 'the number of names')
    call read_line(text, cursor, first, last, found)
    do i = 1, count
      if (cursor%failed) exit
      call read_line(text, cursor, first, last, found)
      if (.not. found) call fail(cursor, cursor%last, 'the file ends in $ElementData', &
        'is the file complete? write it again')
      if (i == 1 .and. last > first) name = text(first + 1:last - 1)
    end do
    call read_number(text, cursor, count, 'the number of real tags')
    do i = 1, count
      if (cursor%failed) exit
      call read_real(text, cursor, unused, 'a real tag')
    end do
    call read_number(text, cursor, count, 'the number of integer tags')
    do i = 1, count
      if (cursor%failed) exit
      call read_number(text, cursor, number, 'an integer tag')
      if (i == 2) components = number
      if (i == 3) n = number
    end do
    if (count < 3 .or. components < 1 .or. components > 9 .or. n < 0) call fail(cursor, &
      cursor%head, 'the integer tags of $ElementData are a time step, 1, 3 or 9 components and '// &
      'the number of elements', 'is the file damaged? write it again')
    if (binary) call read_line(text, cursor, first, last, found)
    cursor%binary = binary
  end subroutine read_tags
end module gmsh_data
