!> Rows of the keyword table: solution commands.
module batch_keywords
  use linear_solver, only: solver_words, solver_list
  use solution_settings, only: n_settings, settings_of_deck, setting_signature
  use keyword_types, only: keyword_table_t, table_batch, add_command, explain
  implicit none
  private
  public :: add_solution_keywords, add_report_keywords

contains

  !> Commands that solve.
  subroutine add_solution_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: iteration = '| LINE [1:solve] [r:v] | - [1:solve]'
    integer :: k

    call add_command(t, table_batch, 'DT', '- q:v', 'time increment')
    call explain(t, 'Example: DT,,0.1')
    call add_command(t, table_batch, 'STEP', '- p:n', 'n increments, each iterated and cut')
    call explain(t, 'Increments of DT with line search; a failed one is cut and grown again. The')
    call explain(t, 'n output times are always hit, and only they are written to tables.')
    call explain(t, 'Example: STEP,,25')
    do k = 1, n_settings
      if (settings_of_deck(k)%summary /= '') call add_command(t, table_batch, &
        trim(settings_of_deck(k)%command), setting_signature(settings_of_deck(k)%command), &
        trim(settings_of_deck(k)%summary))
      call explain(t, trim(settings_of_deck(k)%help))
    end do
    call add_command(t, table_batch, 'PROPortional', '| - [p:n]', &
                     'proportional load whose table follows END')
    call explain(t, 'FEAP''s form. Tables after END, in the order of the PROP commands, parted by')
    call explain(t, 'blank lines: 1 k tmin tmax a0 a1 a2 a3 a4 or 2 k with records of t p.')
    call add_command(t, table_batch, 'TIME', '| - [q:tmax]', 'next time, t + DT')
    call add_command(t, table_batch, 'LOOP', '- p:n | w:label p:n', 'repeats up to NEXT')
    call explain(t, 'Example:')
    call explain(t, '  LOOP,,10')
    call explain(t, '    TANG,,1')
    call explain(t, '  NEXT')
    call add_command(t, table_batch, 'NEXT', '| w:label', 'end of a LOOP')
    call add_command(t, table_batch, 'TANG', iteration, 'forms the tangent and solves')
    call explain(t, 'One Newton iteration with line search (LINE asks for what it does anyway).')
    call explain(t, 'Whether the tangent is unsymmetric is found out. In a deck with SOLV, TANG')
    call explain(t, 'without the 1 leaves the iteration to it. Example: TANG,,1')
    call add_command(t, table_batch, 'UTAN', iteration, 'the same as TANG')
    call add_command(t, table_batch, 'SOLVer', '| LINE [r:v] | '//solver_list(' | ', ' | '), &
                     'one iteration; or the linear solver')
    call explain(t, 'SOLV, SOLV,LINE: one Newton iteration with line search, with the tangent at')
    call explain(t, 'the present state, behind TANG and FORM. With a word: the linear solver.')
    do k = lbound(solver_words, 1), ubound(solver_words, 1)
      call explain(t, '  '//solver_words(k)%word//'  '//trim(solver_words(k)%use))
    end do
    call explain(t, 'What cannot hold falls back and says so in the log. --solver on the command')
    call explain(t, 'line comes first.')
    call add_command(t, table_batch, 'FORM', '| -', 'forms the residual and tells its norm')
    call explain(t, 'Example:')
    call explain(t, '  LOOP,,20')
    call explain(t, '    TANG')
    call explain(t, '    FORM')
    call explain(t, '    SOLV')
    call explain(t, '  NEXT')
    call add_command(t, table_batch, 'AUGMent', '', 'one update of the multipliers of AUGMent')
    call explain(t, 'For increments of TIME and TANG (STEP does it by itself). Where the gaps are')
    call explain(t, 'within the tolerance of AUGMent, it does nothing. Example:')
    call explain(t, '  LOOP,,20')
    call explain(t, '    LOOP,,30')
    call explain(t, '      TANG,,1')
    call explain(t, '    NEXT')
    call explain(t, '    AUGMent')
    call explain(t, '  NEXT')
    call add_command(t, table_batch, 'BACK', '| - [q:dt]', &
                     'gives up the increment that TIME has begun')
    call explain(t, 'Time, displacements and contact history are those of the last output time;')
    call explain(t, 'dt is the new DT. Only increments of TIME that nothing has accepted yet.')
  end subroutine add_solution_keywords

  !> Commands that report, and the end.
  subroutine add_report_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_batch, 'DISPlacement', '| ALL | - [p:n1] [p:n2] [p:n3]', &
                     'prints displacements of nodes n1 to n2 in steps of n3')
    call add_command(t, table_batch, 'REACtion', '| ALL | - [p:n1] [p:n2] [p:n3]', &
                     'prints reactions of nodes n1 to n2 in steps of n3')
    call add_command(t, table_batch, 'STREss', '| ALL | NODE [p:n1] [p:n2] [p:n3] '// &
                     '| - [p:n1] [p:n2] [p:n3]', 'prints stresses of elements or at nodes')
    call explain(t, 'Cauchy stress xx yy zz xy yz zx and that of von Mises, of elements n1 to n2')
    call explain(t, 'in steps of n3 (means), or with NODE at nodes (means of the elements there).')
    call add_command(t, table_batch, 'SAVE', '| w:name', 'keeps the present state in a file')
    call explain(t, 'The file is x.name.h5 for the deck x.inp, without a name x.save.h5. REST,name')
    call explain(t, 'goes back to it; mfec y.inp --restart x.name.h5 goes on from it.')
    call add_command(t, table_batch, 'RESTart', '| f:saved [p:step]', 'goes back to a state')
    call explain(t, 'REST,name takes the state that SAVE,name has kept; REST,run.vtkhdf the last')
    call explain(t, 'of a results file, REST,run.vtkhdf,K that of its step K; the file is looked')
    call explain(t, 'for from the working directory. Displacements, contact history and time are')
    call explain(t, 'those of the state; step numbers go on.')
    call explain(t, 'Example: SAVE,pressed ... REST,pressed')
    call add_command(t, table_batch, 'CHECk', '| UNIQue', 'prints what the mesh is like')
    call explain(t, 'Nodes, elements, volumes and the worst shape. CHECk,UNIQue: whether')
    call explain(t, 'the output time has other answers beside its own (Coulomb friction may): how')
    call explain(t, 'much friction it bears, and what second starts find.')
    call add_command(t, table_batch, 'END', '', 'ends the solution commands')
    call add_command(t, table_batch, 'STOP', '', 'ends the deck (optional)')
    call add_command(t, table_batch, 'INCLude', 'f:file', 'reads on in another file')
  end subroutine add_report_keywords
end module batch_keywords
