!> Pairs whose slave starts behind its master, deeper than contact is looked for there: nothing
!! would press, and nothing would be said (doc/theory, "Undetected penetration").
module behind_checks
  use kinds, only: wp
  use text, only: to_text, count_noun
  use diagnostics, only: diagnostics_t, report_error, report_warning
  use mesh_types, only: mesh_t
  use facets, only: facet_table_t
  use contact_types, only: pair_t
  use contact_points, only: longest_facet
  use facet_geometry, only: facet_normal, project_on_facet, barycentric
  use facet_tree, only: facet_tree_t, build_tree, nearest_facet
  use tool_slaves, only: slave_t, add_slave
  implicit none
  private
  public :: check_behind

  !> Two facets look at each other if the cosine of their normals is below (120 degrees).
  real(wp), parameter :: facing_away_cosine = -0.5_wp

contains

  !> Reports a pair whose slave lies behind its master, and no part of it before it.
  subroutine check_behind(mesh, exterior, pair, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: exterior !! its exterior facets
    type(pair_t), intent(in) :: pair !! with its master and the depths
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(slave_t), allocatable :: slaves(:)
    character(:), allocatable :: t
    real(wp) :: deepest, reach
    integer :: ahead, behind

    if (pair%surface%exact .or. size(pair%surface%facets, 2) == 0) return
    allocate (slaves(0))
    call add_slave(pair%slave, exterior, mesh, slaves)
    if (size(slaves) == 0) return
    reach = pair%search_radius
    if (reach <= 0.0_wp) reach = longest_facet(pair, mesh%x)
    call look(mesh%x, slaves(1), pair, reach, ahead, behind, deepest)
    if (behind == 0) return
    t = 'pair '//pair%name//': '//count_noun(behind, 'facet')//' of the slave '//pair%slave// &
      ' start behind the master '//pair%master//', as deep as '//to_text(deepest, 4)// &
      ', where nothing is looked for: they carry nothing'
    if (ahead > 0) then
      call report_warning(diagnostics, pair%slave_at, t//'; SEARch is '//to_text(reach, 4)// &
        ', and nothing is found deeper than the body of the master is thick')
    else
      call report_error(diagnostics, pair%slave_at, t, 'move the bodies so that the outer side '// &
        'of the slave is before that of the master; for an overlap that is meant write SEARch '// &
        'and a radius above it (now '//to_text(reach, 4)// &
        '), less deep than the body of the master is thick')
    end if
  end subroutine check_behind

  !> Counts the slave facets that look at a facet of the master from before it (or so little behind
  !! that contact is found), and those that are too deep behind it.
  subroutine look(x, slave, pair, reach, ahead, behind, deepest)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(slave_t), intent(in) :: slave !! the slave's facets
    type(pair_t), intent(in) :: pair !! with its master and the depths
    real(wp), intent(in) :: reach !! how far contact is looked for [length]
    integer, intent(out) :: ahead !! facets before the master
    integer, intent(out) :: behind !! facets too deep behind it
    real(wp), intent(out) :: deepest !! how deep [length]
    type(facet_tree_t) :: tree
    real(wp) :: distance, gap, xi(2), depth
    integer :: i, f

    ahead = 0
    behind = 0
    deepest = 0.0_wp
    call build_tree(tree, pair%surface%facets, x)
    do i = 1, size(slave%area)
      call nearest_facet(tree, pair%surface%facets, x, slave%x(:, i), f, distance)
      ! the way to a facet of its own body leads through that
      if (allocated(pair%surface%body)) then
        if (pair%surface%body(f) == slave%body(i)) cycle
      end if
      associate (corner => x(:, pair%surface%facets(:, f)))
        if (dot_product(slave%normal(:, i), facet_normal(corner)) > facing_away_cosine) cycle
        call project_on_facet(corner, slave%x(:, i), xi, gap)
      end associate
      depth = reach
      if (allocated(pair%surface%depth)) depth = min(depth, pair%surface%depth(f))
      if (gap >= -depth) then
        ahead = ahead + 1
      else if (minval(barycentric(xi)) >= 0.0_wp) then
        behind = behind + 1
        deepest = max(deepest, -gap)
      end if
    end do
  end subroutine look
end module behind_checks
