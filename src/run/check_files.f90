!> What --check writes: the bodies with their sets, and both sides of each pair with first gaps and
!! lay, to be looked at before the first solve. The names are those of a run with `.check` in
!! between, so that a check never replaces results.
module check_files
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: cost_t
  use model_types, only: model_t, state_none
  use result_types, only: origin_t, frame_t
  use results_file, only: results_t, create_results, append_picture, close_results
  use results_contact, only: contact_file_t, create_contact_file, append_contact_frame, &
    close_contact_file
  use frame_fields, only: fill_first_frame
  use results_names, only: bodies_ending, contact_ending
  use text_files, only: make_folder
  implicit none
  private
  public :: write_check_files

contains

  !> Writes the files of a sound deck at rest.
  subroutine write_check_files(base, folder, model, origin, error)
    character(*), intent(in) :: base !! path without extension
    character(*), intent(in) :: folder !! folder to make first, empty for none
    type(model_t), intent(inout) :: model !! the problem, its pairs with their first targets
    type(origin_t), intent(in) :: origin !! what makes them
    type(error_t), allocatable, intent(out) :: error !! file trouble
    type(results_t) :: results
    type(contact_file_t) :: surfaces
    type(frame_t) :: frame
    type(cost_t) :: costs

    call fill_first_frame(model, frame)
    call ask_for_little(model)
    if (len(folder) > 0) call make_folder(folder, error)
    if (allocated(error)) return
    call create_results(results, base//'.check'//bodies_ending, model, 0, origin, error)
    call append_picture(results, 0.0_wp, frame, error)
    call close_results(results, costs, error)
    if (size(model%pairs) == 0) return
    call create_contact_file(surfaces, base//'.check'//contact_ending, model, 1, error)
    call append_contact_frame(surfaces, model, 0.0_wp, frame, error)
    call close_contact_file(surfaces, error)
  end subroutine write_check_files

  !> Nothing has been solved: there are no fields of the bodies.
  subroutine ask_for_little(model)
    type(model_t), intent(inout) :: model !! its output request is changed

    associate (output => model%output)
      output%field = .false.
      output%contact = .false.
      output%state = state_none
      deallocate (output%reactions)
      allocate (output%reactions(0))
    end associate
  end subroutine ask_for_little
end module check_files
