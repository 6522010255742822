!> Names that a deck uses, checked where the mesh is not sound: so that one run shows all errors.
module name_checks
  use deck_types, only: deck_t, item_t, item_word, item_quoted
  use records, only: item_count, is_word
  use diagnostics, only: diagnostics_t
  use mesh_types, only: mesh_t
  use mesh_names, only: name_exists
  use node_queries, only: report_unknown_name
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
      if (deck%mesh(i)%command == 'rigi' .and. item_count(deck%mesh(i)%head) > 1) &
        call check_name(deck%mesh(i)%head%items(2), mesh, diagnostics)
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k), command => deck%mesh(i)%command)
          if (item_count(record) == 0) cycle
          select case (command)
          case ('boun', 'disp', 'forc', 'fpro', 'hold', 'trac', 'pres', 'spri', 'rota')
            call check_name(record%items(1), mesh, diagnostics)
          case ('grav')
            call check_name(record%items(item_count(record)), mesh, diagnostics)
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
