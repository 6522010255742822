!> Rows of the keyword table: contact.
module contact_keywords
  use friction_laws, only: cone_laws, law_signature, law_summary, friction_words
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_word, explain
  implicit none
  private
  public :: add_contact_keywords

contains

  !> Contact pairs.
  subroutine add_contact_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    integer :: i

    call add_command(t, table_mesh, 'CONTact', '', 'contact pairs')
    call add_word(t, 'PAIR', 'p:number [w:name]', 'starts a pair')
    call add_word(t, 'NTOS', 'w:slave w:master', 'nodes of a set or surface against a surface')
    call add_word(t, 'GTOS', 'w:slave w:master SEGMent | w:slave w:master [p:points]', &
                  'quadrature points of the facets of a surface against a surface')
    call add_word(t, 'MORTar', 'w:slave w:master', &
                  'multipliers at the nodes of a surface against a surface')
    call add_word(t, 'PENAlty', 'AREA q:epsilon | AUTO [q:factor] | q:epsilon', &
                  'per slave point, per area, or from the stiffness')
    call add_word(t, 'FRICtion', friction_words, 'friction law')
    call add_word(t, 'DIREction', directions('')//' | '//directions('MATErial '), &
                  'principal axis of mu1')
    call add_word(t, 'SLIP', 'COLLinear | TENSor | ASSOciated', 'direction of slip')
    call add_word(t, 'AUGMent', '[q:tol] [p:max]', 'augmented Lagrangian')
    do i = 1, size(cone_laws)
      call add_word(t, trim(cone_laws(i)%keyword), law_signature(cone_laws(i)), &
        law_summary(cone_laws(i)))
    end do
    call add_word(t, 'SHRInk', 'n:table', 'takes up an overlap of the start step by step')
    call add_word(t, 'SEARch', 'q:radius', 'radius in which a facet is looked for')
    call add_word(t, 'ADJUst', '[q:tolerance]', 'moves slave nodes next to the master onto it')
    call add_word(t, 'SMOOth', '', 'continuous normals over the master facets')
    call explain(t, 'GTOS: points in each facet: 1, 3 (the default), 6, 7, 12, 27, 48, 75 or 108.')
    call explain(t, 'SEGMent: points on the intersections of slave and master facets.')
    call explain(t, 'MORTar: no penalty, the force of each slave node is an unknown.')
    call explain(t, 'PENAlty: force per length and slave point; AREA: pressure per length; AUTO')
    call explain(t, '(the default): from the elements next to the pair. DIREction: a vector,')
    call explain(t, 'projected on the facet (default 1 0 0); ANGLe turns it by phi degrees about')
    call explain(t, 'the outward normal; MATErial: fixed in the facet and convected with it.')
    call explain(t, 'CIRCumferential: around the axis through a point x along a, as a lathe leaves')
    call explain(t, 'it; RADIal: away from that axis; FIELd: a vector for each facet, from the')
    call explain(t, '$ElementData of that name in a Gmsh file.')
    call explain(t, 'AUGMent: multipliers take over from the penalty until penetration and elastic')
    call explain(t, 'slip are below tol facet sizes and contact forces stay to tol of the largest')
    call explain(t, '(default 1e-6), within max updates (25; GTOS: 50).')
    call explain(t, 'SHRInk: what overlaps at the start counts in proportion to the table.')
    call explain(t, 'ADJUst: with a gap or penetration at the start of at most tolerance (default:')
    call explain(t, 'chordal deviation of the facets there, at least 1e-3, at most 1/20 of the')
    call explain(t, 'slave''s facet); elements keep their shape.')
    call explain(t, 'Example:')
    call explain(t, '  CONTact')
    call explain(t, '    PAIR 1 sliding')
    call explain(t, '      NTOS  lower_face  plate')
    call explain(t, '      PENAlty 1e4')
    call explain(t, '      FRICtion ELLIptic mu1 mu2')
    call explain(t, '      DIREction ANGLe phi 1 0 0')
    call add_command(t, table_mesh, 'PAIR', 'p:number [w:name]', &
                     'continues CONTact after a blank line with another pair')
  end subroutine add_contact_keywords

  !> What may follow DIREction or its prefix, with and without ANGLe.
  pure function directions(prefix) result(t)
    character(*), intent(in) :: prefix !! nothing, or a word and a blank
    character(:), allocatable :: t
    character(*), parameter :: axis = ' r:x r:y r:z r:a1 r:a2 r:a3'
    character(*), parameter :: turn = 'ANGLe r:phi '

    t = prefix//'r:v1 r:v2 r:v3 | '//prefix//turn//'r:v1 r:v2 r:v3'// &
      ' | '//prefix//'CIRCumferential'//axis//' | '//prefix//turn//'CIRCumferential'//axis// &
      ' | '//prefix//'RADIal'//axis//' | '//prefix//turn//'RADIal'//axis// &
      ' | '//prefix//'FIELd w:name | '//prefix//turn//'FIELd w:name'
  end function directions
end module contact_keywords
