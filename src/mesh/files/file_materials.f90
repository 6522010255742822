!> Materials of elements from mesh files: by the labels of MATErial, else the only one there is.
module file_materials
  use text, only: to_text, lower, in_quotes
  use deck_types, only: deck_t
  use records, only: item_integer, item_name, item_count
  use hints, only: word_list_t, add_candidate, did_you_mean
  use diagnostics, only: diagnostics_t, report_error, error_count
  use mesh_types, only: mesh_t
  use mesh_file_types, only: file_mesh_t, file_group_t, group_cells
  use file_mesh_checks, only: file_place_t, place_in_file
  implicit none
  private
  public :: choose_materials

contains

  !> Gives the elements of a file their materials: that of the MATErial whose label is the name of
  !! a group they are in, else that of the label `name`, else the only one that the deck has. Where
  !! there are several, none is taken unasked.
  subroutine choose_materials(deck, name, place, file, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: name !! the name AS gives, may be empty
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! its elements get their materials
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer :: g, c, default
    logical :: sound

    ! a MATErial that was refused may be the one that is missing
    sound = error_count(diagnostics) == 0
    do c = 1, file%cells
      if (place%element(c) > 0) mesh%material(place%element(c)) = 0
    end do
    do g = 1, file%groups
      if (file%group(g)%kind == group_cells) call label_group(deck, file%group(g), place, mesh, &
        diagnostics)
    end do
    default = labelled(deck, name)
    if (default == 0) default = only_material(deck)
    do g = 1, file%groups
      if (file%group(g)%kind == group_cells .and. default == 0) call refuse_group(deck, &
        file%group(g), place, sound, mesh, diagnostics)
    end do
    do c = 1, file%cells
      if (place%element(c) < 1) cycle
      if (mesh%material(place%element(c)) > 0) cycle
      if (default == 0) then
        if (sound) call report_error(diagnostics, place%at, 'element '// &
          to_text(file%cell_tag(c))//' of this mesh has no material', 'give a MATErial the '// &
          'name of its region as label (MATErial 2 name), or that of MESH file AS name')
        sound = .false.
        default = 1
      end if
      mesh%material(place%element(c)) = default
    end do
  end subroutine choose_materials

  !> Reports a group with elements that have no material, and gives them one to go on with.
  subroutine refuse_group(deck, group, place, sound, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(file_group_t), intent(in) :: group !! the group
    type(file_place_t), intent(in) :: place !! deck numbers
    logical, intent(in) :: sound !! nothing has been wrong so far
    type(mesh_t), intent(inout) :: mesh !! its elements
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(word_list_t) :: labels
    integer :: i, e, bare

    bare = 0
    do i = 1, group%count
      e = place%element(group%members(i))
      if (e == 0) cycle
      if (mesh%material(e) > 0) cycle
      bare = bare + 1
      mesh%material(e) = 1
    end do
    if (bare == 0 .or. .not. sound) return
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      if (item_count(deck%mesh(i)%head) > 2) call add_candidate(labels, &
        item_name(deck%mesh(i)%head, 3))
    end do
    call report_error(diagnostics, place%at, 'region '//group%name//' of this mesh has no '// &
      'material: the deck has several, and none is labelled '//group%name, &
      did_you_mean(labels, group%name, 'write MATErial m '//in_quotes(group%name)//', or MESH '// &
      'file AS the label of the material of all the others'))
  end subroutine refuse_group

  !> Gives the elements of a group the material whose label is its name.
  subroutine label_group(deck, group, place, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(file_group_t), intent(in) :: group !! the group
    type(file_place_t), intent(in) :: place !! deck numbers
    type(mesh_t), intent(inout) :: mesh !! its elements get their materials
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer :: material, i, e

    material = labelled(deck, group%name)
    if (material == 0 .and. allocated(group%material)) material = labelled(deck, group%material)
    if (material == 0) return
    do i = 1, group%count
      e = place%element(group%members(i))
      if (e == 0) cycle
      if (mesh%material(e) > 0 .and. mesh%material(e) /= material) then
        call report_error(diagnostics, place_in_file(diagnostics%source, place%file, group%at), &
          'element '//to_text(e)//' of '//group%name//' has material '// &
          to_text(mesh%material(e))//' by another group and '//to_text(material)//' by this', &
          'an element has one material: change the labels of MATErial')
        return
      end if
      mesh%material(e) = material
    end do
  end subroutine label_group

  !> Number of the material with a label, in either case; 0 if there is none.
  pure integer function labelled(deck, label) result(number)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: label !! the label, not used if empty
    integer :: i

    number = 0
    if (label == '') return
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      if (item_count(deck%mesh(i)%head) < 3) cycle
      if (lower(item_name(deck%mesh(i)%head, 3)) /= lower(label)) cycle
      number = item_integer(deck%mesh(i)%head, 2)
      return
    end do
  end function labelled

  !> Number of the material of a deck that has one; 0 if it has none or several.
  pure integer function only_material(deck) result(number)
    type(deck_t), intent(in) :: deck !! the deck
    integer :: i

    number = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      if (number /= 0 .and. number /= item_integer(deck%mesh(i)%head, 2)) then
        number = 0
        return
      end if
      number = item_integer(deck%mesh(i)%head, 2)
    end do
  end function only_material
end module file_materials
