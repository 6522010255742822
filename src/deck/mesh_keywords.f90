!> Rows of the keyword table: mesh, supports, loads and what organises a deck.
module mesh_keywords
  use body_fields, only: field_words
  use bulk_laws, only: solid_signature
  use cells, only: shapes
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_data, add_word, explain
  implicit none
  private
  public :: add_structure_keywords, add_whole_keywords, add_mesh_keywords, add_selection_keywords, &
    add_condition_keywords, add_coordinate_keywords

contains

  !> Commands that organise the deck.
  subroutine add_structure_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'PARAmeter', '', 'named numbers for expressions')
    call explain(t, 'Data records: name = expression. Names differ by case and have up to 31')
    call explain(t, 'characters; a parameter may be defined again. --set name=value overrides it.')
    call explain(t, 'A record that begins with a parameter whose first four letters are those of')
    call explain(t, 'a command writes it in parentheses.')
    call explain(t, 'Example:')
    call explain(t, '  PARAmeter')
    call explain(t, '    mu = 0.1')
    call explain(t, '    shear = 210e3/(2*(1 + 0.3))   ! wrong: no blanks inside an expression')
    call explain(t, '    shear = 210e3/(2*(1+0.3))')
    call add_command(t, table_mesh, 'INCLude', 'f:file', 'reads on in another file')
    call explain(t, 'Anywhere, nested up to 9 deep, relative to the file that includes.')
    call explain(t, 'Example: INCLude meshes/plate.inc')
    call add_command(t, table_mesh, 'END', '', 'ends the mesh commands (optional before BATCh)')
    call add_command(t, table_mesh, 'BATCh', '', 'starts the solution commands, up to END')
    call add_command(t, table_mesh, 'MACRo', '', 'the same as BATCh')
    call add_command(t, table_mesh, 'STOP', '', 'ends the deck (optional)')
  end subroutine add_structure_keywords

  !> What holds for the whole mesh.
  subroutine add_whole_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'GLOBal', '', 'what holds for all materials')
    call add_word(t, 'SMALl', '', 'small strain (as without GLOBal)')
    call add_word(t, 'FINIte', '', 'finite strain, as FINIte in each material')
    call add_word(t, 'PLANe', 'a:kind', 'two dimensions', available=.false.)
    call add_word(t, 'AXISymmetric', '', 'two dimensions', available=.false.)
    call add_word(t, 'TEMPerature', 'a:dof', 'temperatures', available=.false.)
    call explain(t, 'A material that says SMALl, FINIte or SOLId with a law goes its own way.')
    call add_command(t, table_mesh, 'TRANsform', '| INCrement', &
                     'turns and moves the coordinates that follow')
    call add_data(t, 'r:t1 r:t2 r:t3')
    call explain(t, 'Three rows of a matrix T, then x0: COORdinates, BLOCk and MESH that follow')
    call explain(t, 'have x = T x + x0. With INCrement it comes on top of the one before.')
    call explain(t, 'Example:')
    call explain(t, '  TRANsform')
    call explain(t, '    cosd(30) -sind(30)  0')
    call explain(t, '    sind(30)  cosd(30)  0')
    call explain(t, '    0         0         1')
    call explain(t, '    10        0         0')
    call add_command(t, table_mesh, 'TIE', '| NODE p:n1 p:n2 | MATErial p:m1 p:m2 '// &
                     '| REGIon w:name1 w:name2 | - d:direction r:coordinate', &
                     'joins nodes of equal coordinates')
    call explain(t, 'All of them; those numbered n1 to n2; of two materials, of two regions (sets,')
    call explain(t, 'surfaces); in a coordinate plane. Never the two sides of a contact pair. The')
    call explain(t, 'lowest number of each place stays, and the others mean the same node.')
    call explain(t, 'Example: TIE,,3,0.5')
  end subroutine add_whole_keywords

  !> Nodes, elements and materials.
  subroutine add_mesh_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(:), allocatable :: signature
    integer :: k

    call add_command(t, table_mesh, 'COORdinates', '', 'coordinates of nodes')
    call add_data(t, 'p:node n:inc r:x1 r:x2 r:x3')
    call explain(t, 'Nodes between two records are generated in steps of the first one''s inc.')
    call explain(t, 'Example:')
    call explain(t, '  COORdinates')
    call explain(t, '    1 1  0.0 0.0 0.0')
    call explain(t, '    5 0  1.0 0.0 0.0')
    call add_command(t, table_mesh, 'ELEMents', '| SPLIt', 'nodes of elements')
    call add_data(t, 'p:element n:inc p:material p:n1 p:n2 p:n3 p:n4 [n:n5...]')
    call explain(t, 'Four corner nodes: linear tetrahedron; ten: quadratic, nodes 5 to 10 in the')
    call explain(t, 'middle of the edges 12, 23, 31, 14, 24, 34. A left-handed one is reordered.')
    call explain(t, 'Elements between two records are generated: node numbers grow by inc.')
    call explain(t, 'SPLIt: bricks of eight nodes; brick e becomes tetrahedra 6 e - 5 to 6 e, cut')
    call explain(t, 'as a cell of BLOCk.')
    call explain(t, 'Example:')
    call explain(t, '  ELEMents')
    call explain(t, '    1 0 1  1 2 3 4')
    call add_command(t, table_mesh, 'BLOCk', '[w:name]', 'a block of cells; its name is a region')
    call add_data(t, 'p:point r:x1 r:x2 r:x3')
    signature = ''
    do k = 1, size(shapes)
      signature = signature//'p:n1 p:n2 p:n3 MATErial p:material '//trim(shapes(k)%name)// &
        ' | p:n1 p:n2 p:n3 '//trim(shapes(k)%name)//' | '
    end do
    call add_word(t, 'CARTesian', signature//'p:n1 p:n2 p:n3 n:node1 n:element1 n:material '// &
                  '11:btype', 'cells along the three edges, material, element type')
    call explain(t, 'Data records: master points 1-4 of the lower face, 5-8 above; if wanted, as')
    call explain(t, 'in FEAP: 9-12 on the edges 15 26 37 48, 13-16 on 12 23 34 41, 17 on the')
    call explain(t, 'lower face, 18-22 likewise above, 23-26 on the faces 1265 2376 3487 4158,')
    call explain(t, '27 inside.')
    call explain(t, 'Example:')
    call explain(t, '  BLOCk cube')
    call explain(t, '    CART 8 8 8  MATErial 1  TET4')
    call explain(t, '    1  0 0 0')
    call explain(t, '    2  1 0 0')
    call explain(t, '    ...')
    call add_command(t, table_mesh, 'MATErial', 'p:number [a:label]', 'a material')
    call add_word(t, 'SOLId', solid_signature(), 'constitutive law')
    call add_word(t, 'ELAStic', 'ISOTropic q:E r:nu | NEOHookean q:E r:nu', &
                  'Young''s modulus and Poisson''s ratio')
    call add_word(t, 'DENSity', 'z:rho', 'density')
    call add_word(t, 'RIGId', '', 'nodes of its regions follow DISPlacement')
    call add_word(t, 'FINIte', '', 'finite strain, for ELAStic NEOHookean')
    call add_word(t, 'PLAStic', '', 'yielding', available=.false.)
    call add_word(t, 'VISCoelastic', '', 'creep, relaxation', available=.false.)
    call add_word(t, 'SMALl', '', 'small strain, where GLOBal says FINIte')
    call explain(t, 'LINEar: small strain (the default). NEOHookean, SVK (Saint-Venant-')
    call explain(t, 'Kirchhoff): finite strain. MEAN: the volumetric part goes with the mean')
    call explain(t, 'dilatation of each element of ten nodes, which keeps it from locking:')
    call explain(t, 'their default from nu 0.45 on (not with SVK); FULL: without. NODAl: with the')
    call explain(t, 'dilatation of the nodes, for elements of four nodes.')
    call explain(t, 'Example:')
    call explain(t, '  MATErial 1 steel')
    call explain(t, '    SOLId LINEar')
    call explain(t, '    ELAStic ISOTropic 210e3 0.3')
    call add_command(t, table_mesh, 'MESH', 'f:file | f:file AS w:name', &
                     'reads a Gmsh or Abaqus mesh')
    call explain(t, 'Gmsh MSH 4.1 or 2.2, text or binary, or an Abaqus/CalculiX .inp mesh; of')
    call explain(t, 'tetrahedra with 4 or 10 nodes. The path is relative to the file that names')
    call explain(t, 'it.')
    call explain(t, 'Nodes (those of tetrahedra) and elements get the numbers behind the highest')
    call explain(t, 'so far, in the order of the file. Physical volumes and ELSETs become regions,')
    call explain(t, 'physical surfaces and SURFACEs surfaces, physical curves and points and NSETs')
    call explain(t, 'sets of the same name; AS names a region of all elements of the file. The')
    call explain(t, 'material of an element is the MATErial whose label is the name of its group')
    call explain(t, '(or of its material in the file), else that of AS, else material 1.')
    call explain(t, '    MESH gear.msh AS gear')
    call explain(t, '    MATErial 2 gear')
  end subroutine add_mesh_keywords

  !> Sets, surfaces and output requests.
  subroutine add_selection_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'SET', 'w:name', 'a named set of nodes')
    call add_word(t, 'PLANe', 'd:direction r:coordinate [z:tol]', 'nodes in a coordinate plane')
    call add_word(t, 'BOX', 'r:x1 r:x2 r:y1 r:y2 r:z1 r:z2', 'nodes in a box, its faces included')
    call add_word(t, 'INSIde', 'w:region', 'nodes of a region')
    call add_word(t, 'NODEs', 'l:node...', 'listed nodes, with TO for ranges')
    call add_word(t, 'OR', 'PLANe d:direction r:coordinate [z:tol] | BOX r:x1 r:x2 r:y1 r:y2 '// &
                  'r:z1 r:z2 | INSIde w:region | NODEs l:node... | ', 'starts an alternative')
    call explain(t, 'Records narrow the set (logical and); OR starts an alternative.')
    call explain(t, 'Example:')
    call explain(t, '  SET top')
    call explain(t, '    PLANe 3 1.5')
    call explain(t, '    INSIde cube')
    call add_command(t, table_mesh, 'SURFace', 'w:name FROM w:set IN w:region '// &
                     '| w:name FROM w:set | w:name PLANe r:x r:y r:z r:nx r:ny r:nz '// &
                     '| w:name CYLInder r:x r:y r:z r:ax r:ay r:az r:r '// &
                     '| w:name SPHEre r:x r:y r:z r:r | w:name', &
                     'a named surface of exterior facets')
    call add_word(t, 'FACEts', 'p:n1 p:n2 p:n3', 'corner nodes of a facet')
    call explain(t, 'FROM: all exterior facets whose corner nodes lie in the set (and region).')
    call explain(t, 'PLANe (a point, the outward normal), CYLInder (a point, the axis, the')
    call explain(t, 'radius) and SPHEre (the centre, the radius) are rigid, exact and without')
    call explain(t, 'end; a negative radius is a bore. They are masters; they rest, or move by')
    call explain(t, 'RIGId or DISPlacement.')
    call explain(t, 'Example: SURFace skin FROM top IN cube')
    call explain(t, 'Example: SURFace floor PLANe 0 0 0  0 0 1')
    call add_command(t, table_mesh, 'OUTPut', '', 'what is written')
    call add_word(t, 'REACtions', 'w:set...', 'sets of the reaction table, in its order')
    call add_word(t, 'FIELds', 'NONE | c:'//field_words()//'...', &
                  'fields of the result file')
    call add_word(t, 'EVERy', 'p:n', 'fields and state at each n-th output time')
    call add_word(t, 'STATe', 'ALL | LAST [p:n] | NONE', 'states kept for a restart')
    call add_word(t, 'TABLes', 'ALL', 'of a study: a reaction table for each variant')
    call add_word(t, 'POINts', 'a:pair...', 'pairs of the table of points')
    call add_word(t, 'HISTory', 'NODE p:node d:dof', 'a dof for the history table')
    call explain(t, 'Without REACtions: every set with a restrained dof.')
    call explain(t, 'Example:')
    call explain(t, '  OUTPut')
    call explain(t, '    REACtions top bottom')
    call explain(t, '    FIELds displacement contact')
    call explain(t, '    EVERy 5')
  end subroutine add_selection_keywords

  !> Supports and loads by node number or set.
  subroutine add_condition_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_command(t, table_mesh, 'BOUNdary', '', 'restraint codes by node or set')
    call add_data(t, 'w:set i:code1 i:code2 i:code3 | p:node n:inc i:code1 i:code2 i:code3')
    call explain(t, 'A code other than 0 restrains the degree of freedom; codes of repeated')
    call explain(t, 'records are combined.')
    call explain(t, 'Example:')
    call explain(t, '  BOUNdary')
    call explain(t, '    bottom  1 1 1')
    call explain(t, '    17 0    0 0 1')
    call add_command(t, table_mesh, 'DISPlacement', '', 'prescribed displacements by node or set')
    call add_data(t, 'w:set r:u1 r:u2 r:u3 [n:table] | p:node n:inc r:u1 r:u2 r:u3 [n:table]')
    call explain(t, 'Values of restrained dofs, times their proportional load; the last one wins.')
    call explain(t, 'Records that end with the number of a table (0: the sum of all) add.')
    call explain(t, 'Example:')
    call explain(t, '  DISPlacement')
    call explain(t, '    top  0 0 -0.01')
    call add_command(t, table_mesh, 'FORCe', '', 'nodal forces by node or set')
    call add_data(t, 'w:set r:f1 r:f2 r:f3 [n:table] | p:node n:inc r:f1 r:f2 r:f3 [n:table]')
    call explain(t, 'Dead forces, times their proportional load; the last one wins.')
    call explain(t, 'Records that end with the number of a table (0: the sum of all) add.')
    call explain(t, 'A set called force is spelt like FORCe: in quotes where it starts a record.')
    call explain(t, 'Example:')
    call explain(t, '  FORCe')
    call explain(t, '    8 0  0 0 -100')
    call add_command(t, table_mesh, 'FPROportional', '', &
                     'proportional load numbers by node or set')
    call add_data(t, 'w:set n:p1 n:p2 n:p3 | p:node n:inc n:p1 n:p2 n:p3')
    call explain(t, 'Number of the PROPortional table of each dof; 0 is the sum of all tables.')
    call explain(t, 'Example:')
    call explain(t, '  FPROportional')
    call explain(t, '    top  2 0 1')
    call add_command(t, table_mesh, 'PROPortional', 'p:number', 'a proportional load')
    call add_data(t, 'r:t r:p')
    call explain(t, 'Piecewise linear in time, held constant outside.')
    call explain(t, 'Example:')
    call explain(t, '  PROPortional 1')
    call explain(t, '    0 0')
    call explain(t, '    1 1')
  end subroutine add_condition_keywords

  !> Supports and loads by coordinates.
  subroutine add_coordinate_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: edge = 'Nodes whose coordinate in the direction has this value.'
    character(*), parameter :: point = 'The node nearest to the point.'

    call add_command(t, table_mesh, 'EBOUndary', '', 'restraint codes by coordinate plane')
    call add_data(t, 'd:direction r:coordinate i:code1 i:code2 i:code3')
    call explain(t, edge)
    call explain(t, 'Example: 3 0.0  1 1 1')
    call add_command(t, table_mesh, 'EDISplacement', '', 'displacements by coordinate plane')
    call add_data(t, 'd:direction r:coordinate r:u1 r:u2 r:u3 [n:table]')
    call explain(t, edge)
    call add_command(t, table_mesh, 'EFORce', '', 'nodal forces by coordinate plane')
    call add_data(t, 'd:direction r:coordinate r:f1 r:f2 r:f3 [n:table]')
    call explain(t, edge)
    call add_command(t, table_mesh, 'EPROportional', '', 'load numbers by coordinate plane')
    call add_data(t, 'd:direction r:coordinate n:p1 n:p2 n:p3')
    call explain(t, edge)
    call add_command(t, table_mesh, 'CBOUndary', '', 'restraint codes by coordinates')
    call add_word(t, 'NODE', 'r:x1 r:x2 r:x3 i:code1 i:code2 i:code3', 'point and codes')
    call explain(t, point)
    call explain(t, 'Example: NODE 0 0 0  1 1 1')
    call add_command(t, table_mesh, 'CDISplacement', '', 'displacements by coordinates')
    call add_word(t, 'NODE', 'r:x1 r:x2 r:x3 r:u1 r:u2 r:u3 [n:table]', &
                  'point and values')
    call explain(t, point)
    call add_command(t, table_mesh, 'CFORce', '', 'nodal forces by coordinates')
    call add_word(t, 'NODE', 'r:x1 r:x2 r:x3 r:f1 r:f2 r:f3 [n:table]', &
                  'point and values')
    call explain(t, point)
    call add_command(t, table_mesh, 'CPROportional', '', 'load numbers by coordinates')
    call add_word(t, 'NODE', 'r:x1 r:x2 r:x3 n:p1 n:p2 n:p3', 'point and numbers')
    call explain(t, point)
  end subroutine add_coordinate_keywords
end module mesh_keywords
