!> Rows of the keyword table: derivatives and studies.
module study_keywords
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_data, add_word, explain
  implicit none
  private
  public :: add_study_keywords

contains

  !> Derivatives along the run, and many runs.
  subroutine add_study_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'SENSitivity', '', 'derivatives of reactions along the run')
    call add_data(t, 'w:young MATErial p:number | w:load p:number | w:way w:set d:direction '// &
      '| w:parameter...')
    call explain(t, 'A record names parameters: mu1, mu2, mu, phi (by radian), slip (the m of the')
    call explain(t, 'slip rule) or penalty, of all pairs or, with PAIR name at its end, of one;')
    call explain(t, 'the modulus of a material, the amplitude of a load, the motion of a set;')
    call explain(t, 'or parameters of the deck that go into friction, the angle of the lay, the')
    call explain(t, 'penalty, Young''s modulus, displacements, forces or proportional loads.')
    call explain(t, 'The table x.sen has a row for each output time, set or pair, and parameter.')
    call explain(t, 'Example:')
    call explain(t, '  SENSitivity')
    call explain(t, '    mu1 mu2 phi PAIR sliding')
    call explain(t, '    young MATErial 2')
    call explain(t, '    depth')
    call add_command(t, table_mesh, 'STUDy', 'w:name c:grid,list,chain | w:name', &
                     'many variants of the run on shared factors')
    call add_word(t, 'FROM', 'z:time FORCE | z:time', 'variants are one run up to this time')
    call add_word(t, 'SLIP', 'c:collinear,tensor,associated...', 'the slip rule of all pairs')
    call add_data(t, 'w:parameter r:from TO r:to BY r:step | w:parameter r:value...')
    call explain(t, 'A record is a parameter of the deck with its values; slip: the rule of')
    call explain(t, 'all pairs. GRID (the default): all values with all; LIST: side by side;')
    call explain(t, 'CHAIN: the same, solved in this order. One row a variant in x.study;')
    call explain(t, '--vary does the same on the command line.')
    call explain(t, 'FROM wants that no parameter acts before that time; FORCE does not ask.')
    call explain(t, 'Example:')
    call explain(t, '  STUDy friction')
    call explain(t, '    m2  0.02 TO 0.10 BY 0.01')
    call explain(t, '    phi 0 30 45 90')
  end subroutine add_study_keywords
end module study_keywords
