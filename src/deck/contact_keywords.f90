!> Rows of the keyword table: contact.
module contact_keywords
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_word, explain
  implicit none
  private
  public :: add_contact_keywords

contains

  !> Contact pairs.
  subroutine add_contact_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'CONTact', '', 'contact pairs')
    call add_word(t, 'PAIR', 'p:number [w:name]', 'starts a pair')
    call add_word(t, 'NTOS', 'w:slave w:master', 'nodes of a set or surface against a surface')
    call add_word(t, 'GTOS', 'w:slave w:master [p:points]', 'area-weighted points to surface', &
                  available=.false.)
    call add_word(t, 'PENAlty', 'AREA q:epsilon | AUTO [q:factor] | q:epsilon', &
                  'per slave node, per area, or from the stiffness')
    call add_word(t, 'FRICtion', 'NONE | COULomb z:mu | ELLIptic z:mu1 z:mu2', 'friction law')
    call add_word(t, 'DIREction', 'MATErial ANGLe r:phi r:v1 r:v2 r:v3 '// &
                  '| ANGLe r:phi r:v1 r:v2 r:v3 | MATErial r:v1 r:v2 r:v3 | r:v1 r:v2 r:v3 '// &
                  '| ~CIRCumferential r:x... | ~RADIal r:x... '// &
                  '| MATErial ~CIRCumferential r:x... | MATErial ~RADIal r:x...', &
                  'principal axis of mu1')
    call add_word(t, 'SLIP', 'COLLinear | TENSor | ASSOciated', 'direction of slip')
    call add_word(t, 'AUGMent', '[z:tol] [p:max]', 'augmented Lagrangian', available=.false.)
    call add_word(t, 'SEARch', 'q:radius', 'radius in which a facet is looked for')
    call add_word(t, 'SMOOth', '', 'continuous normals over the master facets')
    call explain(t, 'PENAlty: force per length and slave node; AREA: pressure per length; AUTO')
    call explain(t, '(the default): from the elements next to the pair. DIREction: a vector,')
    call explain(t, 'projected on the facet (default 1 0 0); ANGLe turns it by phi degrees about')
    call explain(t, 'the outward normal; MATErial: fixed in the facet and convected with it.')
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
end module contact_keywords
