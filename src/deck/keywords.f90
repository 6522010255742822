!> THE keyword table: reader, hints and --help know the commands from here and from nowhere else.
module keywords
  use keyword_types, only: keyword_table_t
  use mesh_keywords, only: add_structure_keywords, add_whole_keywords, add_mesh_keywords, &
    add_selection_keywords, add_condition_keywords, add_coordinate_keywords
  use load_keywords, only: add_load_keywords
  use contact_keywords, only: add_contact_keywords
  use study_keywords, only: add_study_keywords
  use batch_keywords, only: add_solution_keywords, add_report_keywords
  use foreign_keywords, only: add_foreign_keywords
  implicit none
  private
  public :: keyword_table

contains

  !> The whole table: mesh commands, then solution commands.
  subroutine keyword_table(table)
    type(keyword_table_t), intent(out) :: table !! the table

    call add_structure_keywords(table)
    call add_whole_keywords(table)
    call add_mesh_keywords(table)
    call add_selection_keywords(table)
    call add_condition_keywords(table)
    call add_coordinate_keywords(table)
    call add_load_keywords(table)
    call add_contact_keywords(table)
    call add_study_keywords(table)
    call add_solution_keywords(table)
    call add_report_keywords(table)
    call add_foreign_keywords(table)
  end subroutine keyword_table
end module keywords
