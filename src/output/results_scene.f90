!> What a result has to be judged by without its deck: /scene has laws of the bodies, supports and
!! loads, the group of each pair its law of contact (doc/manual, "The scene"). Nothing of it changes
!! in a run.
module results_scene
  use kinds, only: wp
  use contact_types, only: pair_t
  use cells, only: facet_of, most_facet_nodes
  use contact_points, only: count_points
  use smooth_patch, only: n_patch_values
  use rigid_paths, only: count_rigid
  use model_types, only: model_t, nodal_values_t
  use errors, only: error_t
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, at_end, stored_real, stored_integer
  implicit none
  private
  public :: write_scene, write_pair_scene

  !> Version of this layout: 1 has patches of all facets, and start_tip, offset and lift of all
  !! points at each end time. A reader refuses a higher one.
  integer, parameter :: scene_version = 2
  !> Its group.
  character(*), parameter :: scene_root = '/scene/'

contains

  !> Writes /scene.
  subroutine write_scene(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: m

    call make_group(file, '/scene', error)
    call write_attribute(file, '/scene', 'version', scene_version, error)
    associate (materials => model%materials)
      call write_rows(file, scene_root//'materials', reshape([([real(materials(m)%number, wp), &
        real(materials(m)%law, wp), merge(1.0_wp, merge(2.0_wp, 0.0_wp, materials(m)%nodal), &
        materials(m)%mean), materials(m)%youngs_modulus, materials(m)%poissons_ratio, &
        merge(1.0_wp, 0.0_wp, materials(m)%rigid)], m=1, size(materials))], [6, size(materials)]), &
        'number, law (1 linear, 2 neo-Hooke, 3 Saint-Venant-Kirchhoff), volumetric part (0 '// &
        'everywhere, 1 MEAN, 2 NODAl), E, nu, 1 if rigid', error)
    end associate
    call write_supports(file, model, error)
    call write_tables(file, model, error)
    call write_loads(file, model, error)
    call write_pressures(file, model, error)
    call write_rigid(file, model, error)
  end subroutine write_scene

  !> Writes which degrees of freedom are prescribed, held, or on springs.
  subroutine write_supports(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: bits(model%mesh%nodes)

    bits = matmul([1, 2, 4], merge(1, 0, model%conditions%restrained))
    if (allocated(model%held)) bits = bits + merge(8, 0, model%held)
    call make_series(file, scene_root//'supports', stored_integer, [integer ::], &
      max(1, size(bits)), &
      '1', '1, 2, 4 added up: prescribed directions of each node number from 1; 8: of a region '// &
      'that is held', error)
    call write_block(file, scene_root//'supports', bits, at_end, error)
    if (allocated(model%conditions%spring)) call write_rows(file, scene_root//'springs', &
      model%conditions%spring, 'stiffness to ground of each node number from 1', error)
  end subroutine write_supports

  !> Writes the tables of proportional loads, a corner or a constant a row.
  subroutine write_tables(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: rows(:, :)
    integer :: k, i, n

    allocate (rows(4, sum([(size(model%tables(k)%p), k=1, size(model%tables))])), source=0.0_wp)
    n = 0
    do k = 1, size(model%tables)
      associate (table => model%tables(k))
        do i = 1, size(table%p)
          rows(1:2, n + i) = [real(table%number, wp), merge(1.0_wp, 0.0_wp, table%function_form)]
          if (i <= size(table%t)) rows(3, n + i) = table%t(i)
          rows(4, n + i) = table%p(i)
        end do
        n = n + size(table%p)
      end associate
    end do
    call write_rows(file, scene_root//'tables', rows, &
      'number, 0, time, factor; of a function of FEAP number, 1, tmin and tmax in the first '// &
      'two rows, a0 .. a4', error)
  end subroutine write_tables

  !> Writes loads and what they prescribe where.
  subroutine write_loads(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: displacements(:, :), forces(:, :)
    integer :: k

    allocate (displacements(4, 0), forces(4, 0))
    associate (loads => model%conditions%loads)
      call write_rows(file, scene_root//'loads', reshape([([real(loads(k)%table, wp), &
        real(loads(k)%form, wp), loads(k)%angle], k=1, size(loads))], [3, size(loads)]), &
        'number of the table (0: the sum of all), form (1 its factor, 2 sine, 3 1 - cosine of '// &
        'the angle times it), angle', error)
      do k = 1, size(loads)
        displacements = reshape([displacements, values_of(k, loads(k)%displacement)], &
          [4, size(displacements, 2) + loads(k)%displacement%n])
        forces = reshape([forces, values_of(k, loads(k)%force)], &
          [4, size(forces, 2) + loads(k)%force%n])
      end do
    end associate
    call write_rows(file, scene_root//'displacements', displacements, &
      'load (row of loads), node, direction, displacement at factor 1', error)
    call write_rows(file, scene_root//'forces', forces, &
      'load (row of loads), node, direction, force at factor 1', error)
  end subroutine write_loads

  !> What a load prescribes, a value a row.
  pure function values_of(load, values) result(rows)
    integer, intent(in) :: load !! its number
    type(nodal_values_t), intent(in) :: values !! the values
    real(wp) :: rows(4, values%n)

    if (values%n == 0) return
    rows(1, :) = real(load, wp)
    rows(2, :) = real(values%node(:values%n), wp)
    rows(3, :) = real(values%dof(:values%n), wp)
    rows(4, :) = values%value(:values%n)
  end function values_of

  !> Writes the facets under pressures that follow them.
  subroutine write_pressures(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: rows(:, :)
    integer :: k, f, n

    if (.not. allocated(model%conditions%pressures)) return
    allocate (rows(most_facet_nodes + 2, sum([(size(model%mesh%surfaces(model%conditions &
      %pressures(k)%surface)%facets, 2), k=1, size(model%conditions%pressures))])))
    n = 0
    do k = 1, size(model%conditions%pressures)
      associate (load => model%conditions%pressures(k), &
        faces => model%mesh%surfaces(model%conditions%pressures(k)%surface))
        do f = 1, size(faces%facets, 2)
          n = n + 1
          rows(:, n) = [real(facet_of(model%mesh%ix(:, faces%elements(f)), faces%facets(:, f)), &
            wp), real(load%table, wp), load%value]
        end do
      end associate
    end do
    call write_rows(file, scene_root//'pressures', rows, &
      'nodes of a facet (6, zeros behind the last), number of the table, pressure at factor 1', &
      error)
  end subroutine write_pressures

  !> Writes rigid bodies that have a point: their nodes, and the loads on the point.
  subroutine write_rigid(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: rows(:, :)
    integer :: body(model%mesh%nodes), k, i

    if (count_rigid(model) == 0) return
    body = 0
    allocate (rows(8, 0))
    do k = 1, count_rigid(model)
      associate (rigid => model%conditions%rigid(k))
        body(rigid%nodes) = k
        rows = reshape([rows, [([real(k, wp), real(rigid%loads(i)%table, wp), &
          rigid%loads(i)%value], i=1, size(rigid%loads))]], [8, size(rows, 2) + size(rigid%loads)])
      end associate
    end do
    associate (rigid => model%conditions%rigid)
      call write_rows(file, scene_root//'rigid', reshape([([rigid(k)%point, &
        merge(1.0_wp, 0.0_wp, rigid(k)%free)], k=1, size(rigid))], [9, size(rigid)]), &
        'point at rest (3), 1 for each translation and rotation of it that is free (6)', error)
    end associate
    call write_rows(file, scene_root//'rigid_loads', rows, &
      'rigid body, number of the table, force and moment at factor 1 (6)', error)
    call make_series(file, scene_root//'rigid_body', stored_integer, [integer ::], size(body), &
      '1', &
      'rigid body of each node number from 1, 0 for none', error)
    call write_block(file, scene_root//'rigid_body', body, at_end, error)
  end subroutine write_rigid

  !> Writes the law of a pair into its group; makes room for the patches of smooth surfaces.
  subroutine write_pair_scene(file, pair, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    character(*), intent(in) :: group !! its group
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: law(:)

    allocate (law, source=law_of(pair))
    call write_rows(file, group//'/law', reshape(law, [size(law), 1]), &
      'points of a slave facet (0 nodes, -1 SEGMent, -2 MORTar), 1 SMOOth, 1 AUGMent, '// &
      '1 exact and round, '// &
      'mu1, mu2, slip rule, lay (1 vector, 2 CIRCumferential, 3 RADial, 4 FIELd), vector or '// &
      'axis (3), point of the axis (3), ANGLe in degrees, 1 MATErial, tolerance of AUGMent, '// &
      'kind of penalty (1 value, 2 AREA, 3 AUTO factor, 4 AUTO), its value, penalty over area '// &
      'if SEGMent, DECAy (3), CAP', error)
    if (.not. pair%segmented) call write_rows(file, group//'/epsilon', &
      reshape(pair%points%epsilon, [1, size(pair%points%epsilon)]), 'penalty of each point', error)
    if (allocated(pair%surface%facet_axis)) call write_rows(file, group//'/facet_axis', &
      pair%surface%facet_axis, 'vector of FIELd of each facet', error)
    if (pair%smooth) call make_series(file, group//'/patch', stored_real, [n_patch_values], &
      min(count_points(pair), size(pair%surface%facets, 2)), 'length', &
      'of the facets in host at an output time, in their order, along a1, a2, e: '// &
      'curvatures of the edges facing corners 1, 2, 3, normals at these', error)
    if (pair%segmented .or. pair%mortar) call write_nodes(file, group//'/slave_facets', &
      pair%points%slave_facets, 'corner nodes of the slave facets that cells are cut on', error)
    if (pair%mortar) call write_carriers(file, pair, group, error)
    if (allocated(pair%surface%middles)) call write_nodes(file, group//'/middles', &
      pair%surface%middles, &
      'nodes on the edges 12, 23, 31, or what the corners are round about; 0 for none', error)
  end subroutine write_pair_scene

  !> Writes which slave nodes have handed their dual functions to which, if any.
  subroutine write_carriers(file, pair, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! a pair with multipliers
    character(*), intent(in) :: group !! its group
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, allocatable :: held(:)
    integer :: i

    held = pack([(i, i=1, size(pair%carrier))], pair%carrier /= [(i, i=1, size(pair%carrier))])
    if (size(held) == 0) return
    call write_nodes(file, group//'/carriers', transpose(reshape([held, pair%carrier(held)], &
      [size(held), 2])), 'slave nodes that supports hold, and the node that has the multiplier '// &
      'of each', error)
  end subroutine write_carriers

  !> Writes node numbers of facets.
  subroutine write_nodes(file, path, nodes, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in) :: nodes(:, :) !! (nodes of a facet, facets)
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_series(file, path, stored_integer, [size(nodes, 1)], size(nodes, 2), '1', &
      description, error)
    call write_block(file, path, nodes, at_end, error)
  end subroutine write_nodes

  !> The law of a pair as one row.
  pure function law_of(pair) result(row)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), allocatable :: row(:)
    integer :: points

    points = 0
    if (pair%points%n_slaves > 1) points = pair%facet_points
    if (pair%segmented) points = -1
    if (pair%mortar) points = -2
    row = [real(points, wp), merge(1.0_wp, 0.0_wp, [pair%smooth, pair%augmented, &
      pair%surface%round]), pair%friction%mu, real(pair%friction%slip_rule, wp), &
      real(pair%friction%direction, wp), pair%friction%axis, pair%friction%point, &
      pair%friction%angle, merge(1.0_wp, 0.0_wp, pair%friction%convected), &
      pair%augment_tolerance, real(pair%penalty_kind, wp), pair%penalty, pair%points%density, &
      pair%law]
  end function law_of

  !> Writes a table of reals, if it has rows.
  subroutine write_rows(file, path, rows, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(in) :: rows(:, :) !! (columns, rows)
    character(*), intent(in) :: description !! meaning of the columns
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    if (size(rows) == 0) return
    call make_series(file, path, stored_real, [size(rows, 1)], size(rows, 2), '1', description, &
      error)
    call write_block(file, path, rows, at_end, error)
  end subroutine write_rows
end module results_scene
