!> Rows of the keyword table: derivatives and studies.
module study_keywords
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_data, explain
  implicit none
  private
  public :: add_study_keywords

contains

  !> Derivatives along the run.
  subroutine add_study_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'SENSitivity', '', 'derivatives of reactions along the run')
    call add_data(t, 'w:young MATErial p:number | w:load p:number | w:way w:set d:direction '// &
      '| w:parameter...')
    call explain(t, 'A record names parameters: mu1, mu2, mu, phi (by radian), slip (the m of the')
    call explain(t, 'slip rule) or penalty, of all pairs or, with PAIR name at its end, of one;')
    call explain(t, 'the modulus of a material, the amplitude of a load, the way of a set;')
    call explain(t, 'or parameters of the deck that go into friction, the angle of the lay, the')
    call explain(t, 'penalty, Young''s modulus, displacements, forces or proportional loads.')
    call explain(t, 'The table x.sen has a row for each end time, set or pair, and parameter.')
    call explain(t, 'Example:')
    call explain(t, '  SENSitivity')
    call explain(t, '    mu1 mu2 phi PAIR sliding')
    call explain(t, '    young MATErial 2')
    call explain(t, '    depth')
  end subroutine add_study_keywords
end module study_keywords
