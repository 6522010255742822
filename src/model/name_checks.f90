!> Names that a deck uses, checked where the mesh is not sound: so that one run shows all errors.
module name_checks
  use deck_types, only: deck_t, record_t, item_t, item_word, item_quoted
  use records, only: item_count, item_name, is_word
  use diagnostics, only: diagnostics_t
  use mesh_types, only: mesh_t
  use mesh_names, only: name_exists, find_region
  use node_queries, only: report_unknown_name, report_no_region
  implicit none
  private
  public :: check_names

contains

  !> Reports each name of a condition, a contact pair or an output request that is not defined.
  subroutine check_names(deck, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: mesh !! knows the names
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i, k, j

    do i = 1, size(deck%mesh)
      call check_head(deck%mesh(i)%command, deck%mesh(i)%head, mesh, diagnostics)
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k), command => deck%mesh(i)%command)
          if (item_count(record) == 0) cycle
          select case (command)
          case ('boun', 'disp', 'forc', 'fpro', 'trac', 'pres', 'spri', 'rota')
            call check_name(record%items(1), mesh, diagnostics)
          case ('hold', 'grav')
            call check_region(record%items(item_count(record)), mesh, diagnostics)
          case ('cont', 'pair')
            if (.not. (is_word(record%items(1), 'ntos') .or. is_word(record%items(1), 'gtos'))) &
              cycle
            do j = 2, min(3, item_count(record))
              call check_name(record%items(j), mesh, diagnostics)
            end do
          case ('outp')
            if (.not. is_word(record%items(1), 'reactions')) cycle
            do j = 2, item_count(record)
              call check_name(record%items(j), mesh, diagnostics)
            end do
          case default
            exit
          end select
        end associate
      end do
    end do
  end subroutine check_names

  !> Names behind a command.
  subroutine check_head(command, head, mesh, diagnostics)
    character(4), intent(in) :: command !! first four letters of the command
    type(record_t), intent(in) :: head !! its record
    type(mesh_t), intent(in) :: mesh !! knows the names
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: j

    if (command == 'rigi' .and. item_count(head) > 1) then
      if (.not. name_exists(mesh, item_name(head, 2))) call check_region(head%items(2), mesh, &
        diagnostics)
    else if (command == 'grav' .and. item_count(head) > 1) then
      call check_region(head%items(item_count(head)), mesh, diagnostics)
    else if (command == 'tie ' .and. item_count(head) > 1) then
      if (.not. is_word(head%items(2), 'region')) return
      do j = 3, item_count(head)
        call check_name(head%items(j), mesh, diagnostics)
      end do
    end if
  end subroutine check_head

  !> Reports an item that is a name, but not that of a region.
  subroutine check_region(item, mesh, diagnostics)
    type(item_t), intent(in) :: item !! the item
    type(mesh_t), intent(in) :: mesh !! knows the names
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: index

    if (item%kind /= item_word .and. item%kind /= item_quoted) return
    call find_region(mesh, item%text, index)
    if (index == 0) call report_no_region(mesh, item%at, item%text, diagnostics)
  end subroutine check_region

  !> Reports an item that is a name, but not a known one.
  subroutine check_name(item, mesh, diagnostics)
    type(item_t), intent(in) :: item !! the item
    type(mesh_t), intent(in) :: mesh !! knows the names
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (item%kind /= item_word .and. item%kind /= item_quoted) return
    if (name_exists(mesh, item%text)) return
    call report_unknown_name(mesh, item%at, item%text, diagnostics)
  end subroutine check_name
end module name_checks
