!> Rows of the keyword table: loads on volumes, surfaces and bodies.
module load_keywords
  use keyword_types, only: keyword_table_t, table_mesh, add_command, add_data, add_word, &
    explain
  implicit none
  private
  public :: add_load_keywords

contains

  !> Distributed loads, and what holds bodies.
  subroutine add_load_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: acceleration = 'r:g1 r:g2 r:g3 n:table IN w:region '// &
      '| r:g1 r:g2 r:g3 IN w:region | r:g1 r:g2 r:g3 [n:table]'
    character(*), parameter :: which = &
      'table: number of the PROPortional table, 0 (the default) for the sum of all.'

    call add_command(t, table_mesh, 'TRACtion', '', 'dead traction on surfaces')
    call add_data(t, 'w:surface r:t1 r:t2 r:t3 [n:table]')
    call explain(t, 'Force per reference area, constant in direction. Tractions add.')
    call explain(t, which)
    call explain(t, 'Example:')
    call explain(t, '  TRACtion')
    call explain(t, '    flank  0 0.5 0')
    call add_command(t, table_mesh, 'PRESsure', '', 'pressure on surfaces')
    call add_data(t, 'w:surface r:p [n:table]')
    call explain(t, 'Positive inwards; follows the facets of regions of finite strain. They add.')
    call explain(t, which)
    call explain(t, 'Example:')
    call explain(t, '  PRESsure')
    call explain(t, '    lid  2.5  1')
    call add_rigid_keywords(t)
    call add_command(t, table_mesh, 'HOLD', '', 'regions whose free rigid motions are held')
    call add_data(t, 'w:region')
    call explain(t, 'A body that only contact holds, and that slides or spins without resistance,')
    call explain(t, 'has no unique place: a warning names the motion. HOLD keeps such motions of a')
    call explain(t, 'region where they are, which the log notes; a load along them: exit code 2.')
    call add_command(t, table_mesh, 'ROTAtion', '', 'nodes that turn about an axis')
    call add_data(t, 'w:set r:x1 r:x2 r:x3 r:a1 r:a2 r:a3 r:angle [n:table]')
    call explain(t, 'Nodes of a set, region or surface turn about the axis through x along a, by')
    call explain(t, 'the angle [degree] times the table, any angle. They are restrained by it;')
    call explain(t, 'DISPlacement adds. Beyond 1 degree a region of small strain turns as a whole.')
    call explain(t, which)
    call explain(t, 'Example:')
    call explain(t, '  ROTAtion')
    call explain(t, '    disc  0 0 0  0 0 1  360  2')
    call add_command(t, table_mesh, 'SPRIng', '', 'springs to ground')
    call add_data(t, 'w:set z:k1 z:k2 z:k3')
    call explain(t, 'Force per length on each node of a set, region or surface, in the three')
    call explain(t, 'directions. Springs add; their forces count as reactions of their nodes.')
    call explain(t, 'Example:')
    call explain(t, '  SPRIng')
    call explain(t, '    back  50 0 0')
    call add_command(t, table_mesh, 'GRAVity', '| '//acceleration, 'weight of regions')
    call add_data(t, acceleration)
    call explain(t, 'An acceleration; each material needs its DENSity. On all regions,')
    call explain(t, 'or one. In the head, or in records below it.')
    call explain(t, which)
    call explain(t, 'Example: GRAVity 0 0 -9.81')
  end subroutine add_load_keywords

  !> Rigid bodies with a point.
  subroutine add_rigid_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(:), allocatable :: moves
    character(*), parameter :: move(2) = [character(6) :: ' r:d', ' FREE']
    integer :: i, j, k

    call add_command(t, table_mesh, 'RIGId', 'w:region [w:name]', 'a rigid body with a point')
    moves = ''
    do k = 1, 2
      do j = 1, 2
        do i = 1, 2
          moves = moves//trim(move(i))//trim(move(j))//trim(move(k))//' [n:table] |'
        end do
      end do
    end do
    call add_word(t, 'POINt', 'r:x1 r:x2 r:x3', 'its point (default: the centroid)')
    call add_word(t, 'MOVE', moves(:len(moves) - 2), 'prescribed translation of the point')
    call add_word(t, 'TURN', 'FREE | r:a1 r:a2 r:a3 r:angle [n:table]', &
                  'prescribed rotation about the point [degree]')
    call add_word(t, 'LOAD', 'r:f1 r:f2 r:f3 r:m1 r:m2 r:m3 [n:table]', &
                  'force and moment on the point, dead')
    call explain(t, 'A region of MATErial RIGId moves as one body with six unknowns; what no MOVE')
    call explain(t, 'and no TURN prescribes is free. Records of MOVE and of LOAD add, each with')
    call explain(t, 'its table; FREE in a place of MOVE leaves that direction free. One TURN.')
    call explain(t, 'Its motion and the forces of its constraints: table x.rig.')
    call explain(t, 'Example:')
    call explain(t, '  RIGId cylinder roller')
    call explain(t, '    POINt 0 0 1')
    call explain(t, '    MOVE  0 0 FREE')
    call explain(t, '    TURN  0 1 0 360  2')
    call explain(t, '    LOAD  0 0 -50  0 0 0  1')
  end subroutine add_rigid_keywords
end module load_keywords
