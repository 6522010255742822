!> What a run needs to go on, declared once: the fields of the restart part of a results file, when
!! they are there, and where a state keeps them. results_state makes, writes and overwrites them,
!! state_reader reads them, doc/fields.py lists them in the manual.
module state_fields
  use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
  use kinds, only: wp
  use friction_laws, only: slip_path
  use contact_types, only: pair_t
  use contact_parameters, only: has_multipliers
  use model_types, only: model_t
  use rigid_paths, only: count_rigid
  use bulk_memory, only: memory_shape
  use result_types, only: saved_state_t, pair_history_t
  use result_fields, only: field_t, over_one, over_nodes, over_points, over_bodies, &
    over_apex_slopes, over_node_slopes, over_contact_nodes, over_memory
  use hdf5_data, only: stored_real, stored_integer
  implicit none
  private
  public :: fields_of_state, fields_of_pair, is_mark, is_optional, in_use, is_kept, forget_unused, &
    address_of, real_component, integer_component

  !> When a field is there (doc/theory, "Contact initiation", "Nonlinear bulk").
  integer, parameter :: part_always = 0 !! always
  integer, parameter :: part_mark = 1 !! always
  integer, parameter :: part_scene = 2 !! always
  integer, parameter :: part_before = 3 !! where first touches are foreseen
  integer, parameter :: part_rigid = 4 !! with `RIGId` bodies that have a point
  integer, parameter :: part_condensed = 5 !! with the condensed form
  integer, parameter :: part_factor = 6 !! with factors of a bulk that is not linear
  integer, parameter :: part_path = 7 !! always; older files lack it
  integer, parameter :: part_state_multiplier = 8 !! with `AUGMent`
  integer, parameter :: part_cells = 9 !! with `SEGMent` and `MORTar`
  integer, parameter :: part_slopes = 10 !! with `SENSitivity`
  integer, parameter :: part_memory = 11 !! with laws of `SOLId` that remember (none so far)
  integer, parameter :: part_mortar = 12 !! with `MORTar`

  !> Fields of a state as a whole.
  type(field_t), parameter :: fields_of_state(*) = [ &
    field_t('step', stored_integer, 1, over_one, '1', &
    'number of the output time; 0 or below: not complete', part_mark), &
    field_t('time', stored_real, 1, over_one, 'time', 'its time', part_always), &
    field_t('increment', stored_real, 1, over_one, 'time', 'increment size to go on with', &
    part_always), &
    field_t('checksum', stored_integer, 2, over_one, '1', 'sum over all numbers of the state', &
    part_mark), &
    field_t('displacement', stored_real, 3, over_nodes, 'length', &
    'displacement of all node numbers from 1', part_always), &
    field_t('reaction', stored_real, 3, over_nodes, 'force', &
    'force of the supports on all node numbers from 1', part_always), &
    field_t('span_before', stored_real, 1, over_one, 'time', &
    'length of the increment that ended here; 0 or empty if it is not needed', part_before), &
    field_t('displacement_before', stored_real, 3, over_nodes, 'length', &
    'displacement at its start; empty if it is not needed', part_before), &
    field_t('factor_wear', stored_real, 2, over_one, '1', &
    'applications of the factors of a nonlinear bulk so far, tangents in a row that were '// &
    'not positive definite; empty with other solvers', part_factor), &
    field_t('factor_displacement', stored_real, 3, over_nodes, 'length', &
    'displacement at which they were made; empty if they are those of the bodies at rest', &
    part_factor), &
    field_t('scene', stored_integer, 4, over_one, '1', &
    'sums over what its balance rests on (loads, supports, materials, pairs) and its time', &
    part_scene), &
    field_t('residual', stored_real, 1, over_one, '1', &
    'residual over the force scale when it was accepted', part_scene), &
    field_t('rigid', stored_real, 6, over_bodies, 'length, radian', &
    'free translation and rotation vector of the points of rigid bodies', part_rigid), &
    field_t('memory', stored_real, 1, over_memory, 'of each', &
    'what the points of the elements remember, element after element, point after point', &
    part_memory), &
    field_t('candidate', stored_integer, 1, over_nodes, '1', &
    'nodes that the condensed solver holds for contact; empty if it was not in use', &
    part_condensed), &
    field_t('contact_force', stored_real, 3, over_nodes, 'force', &
    'contact forces of the condensed solver; empty if it was not in use', part_condensed), &
    field_t('slope_mark', stored_integer, 2, over_one, '1', &
    'sum over the names of the parameters of derivatives', part_slopes), &
    field_t('tip_slope', stored_real, 2, over_apex_slopes, '1/parameter', &
    'derivatives of the apexes, parameter after parameter', part_slopes), &
    field_t('place_slope', stored_real, 3, over_node_slopes, 'length/parameter', &
    'derivatives of the displacements, parameter after parameter', part_slopes), &
    field_t('force_slope', stored_real, 3, over_node_slopes, 'force/parameter', &
    'derivatives of the contact forces, parameter after parameter', part_slopes), &
    field_t('slope_late', stored_integer, 1, over_contact_nodes, '1', &
    '1, 2, 4 added up: directions in which a displacement still lacks what contact does', &
    part_slopes)]

  !> Fields of each contact pair.
  type(field_t), parameter :: fields_of_pair(*) = [ &
    field_t('host', stored_integer, 1, over_points, '1', &
    'facet of the pair that holds the apex, from 1, 0 for none', part_always), &
    field_t('status', stored_integer, 1, over_points, '1', '-1 off, 0 open, 1 stick, 2 slip', &
    part_always), &
    field_t('tip', stored_real, 2, over_points, '1', '(xi, eta) of the apex in its facet', &
    part_always), &
    field_t('dissipation', stored_real, 1, over_points, 'force length', &
    'work that friction has taken up to now', part_always), &
    field_t('coupled', stored_integer, 1, over_points, '1', &
    'target when the pattern of the matrix was built, 0 for none', part_always), &
    field_t(slip_path%name, stored_real, 1, over_points, slip_path%unit, slip_path%description, &
    part_path), &
    field_t('frictional_slip', stored_real, 3, over_points, 'length', &
    'this path with its directions', part_path), &
    field_t('multiplier', stored_real, 3, over_points, 'force', &
    'force without a gap, along a1, e x a1 and e of the facet', part_state_multiplier), &
    field_t('slave', stored_integer, 1, over_points, '1', &
    'slave facet of the point, from 1, 0 while it is not in use', part_cells), &
    field_t('weight', stored_real, 3, over_points, '1', &
    'where in the slave facet: linear shape functions of its corners', part_cells), &
    field_t('area', stored_real, 1, over_points, 'length^2', 'reference area of the point', &
    part_cells), &
    field_t('place', stored_real, 2, over_points, '1', &
    '(xi, eta) of the point in its target when its cell was made', part_cells), &
    field_t('node', stored_integer, 1, over_points, '1', &
    'multipliers, as many as there are, from the first place on: slave node, 0 for none', &
    part_mortar), &
    field_t('face', stored_integer, 1, over_points, '1', 'their faces of the master', &
    part_mortar), &
    field_t('node_status', stored_integer, 1, over_points, '1', 'their status', part_mortar), &
    field_t('node_axis', stored_real, 3, over_points, '1', 'p1 of their frames', part_mortar), &
    field_t('node_normal', stored_real, 3, over_points, '1', 'normals of these', part_mortar), &
    field_t('node_force', stored_real, 3, over_points, 'force', 'their forces', part_mortar), &
    field_t('node_path', stored_real, 1, over_points, 'length', &
    'path that they have slipped since closure', part_mortar), &
    field_t('node_way', stored_real, 3, over_points, 'length', 'this path with its directions', &
    part_mortar), &
    field_t('node_dissipation', stored_real, 1, over_points, 'force length', &
    'work that their friction has taken', part_mortar)]

  !> Whether a deck or one of its pairs has use for a field.
  interface in_use
    module procedure used_by_deck
    module procedure used_by_pair
  end interface in_use

contains

  !> A field that is written apart from the others, for it makes the state count.
  pure logical function is_mark(field)
    type(field_t), intent(in) :: field !! of a state

    is_mark = field%part == part_mark
  end function is_mark

  !> A field that a whole state may lack: it had nothing to keep, or an older program wrote it.
  pure logical function is_optional(field)
    type(field_t), intent(in) :: field !! of a state or pair

    is_optional = all(field%part /= [part_always, part_mark, part_cells, part_mortar])
  end function is_optional

  !> Whether a deck has use for a field.
  pure logical function used_by_deck(field, model) result(used)
    type(field_t), intent(in) :: field !! of a state
    type(model_t), intent(in) :: model !! the problem

    used = field%part /= part_rigid .or. count_rigid(model) > 0
    if (field%part == part_slopes) used = model%output%slopes(1) > 0
    if (field%part == part_memory) used = product(memory_shape(model)) > 0
  end function used_by_deck

  !> Whether a pair has use for a field.
  pure logical function used_by_pair(field, pair) result(used)
    type(field_t), intent(in) :: field !! of a pair
    type(pair_t), intent(in) :: pair !! the pair

    select case (field%part)
    case (part_state_multiplier)
      used = has_multipliers(pair)
    case (part_cells)
      used = pair%segmented
    case (part_mortar)
      used = pair%mortar
    case default
      used = .true.
    end select
  end function used_by_pair

  !> Whether a state has something to keep in a field.
  pure logical function is_kept(field, state) result(kept)
    type(field_t), intent(in) :: field !! of a state
    type(saved_state_t), intent(in) :: state !! the state

    select case (field%part)
    case (part_rigid)
      kept = allocated(state%rigid)
    case (part_memory)
      kept = allocated(state%memory)
    case (part_before)
      kept = allocated(state%displacement_before)
    case (part_factor)
      kept = allocated(state%factor_displacement) .or. any(state%factor_aging > 0.0_wp)
    case (part_condensed)
      kept = allocated(state%candidate)
    case (part_slopes)
      kept = allocated(state%slopes%apex)
    case default
      kept = .true.
    end select
  end function is_kept

  !> Drops what is zero because a state with nothing to keep has taken the place of another one.
  pure subroutine forget_unused(state)
    type(saved_state_t), intent(inout) :: state !! read from a file

    if (allocated(state%factor_displacement)) then
      if (all(abs(state%factor_displacement) <= 0.0_wp)) deallocate (state%factor_displacement)
    end if
    if (allocated(state%candidate)) then
      if (all(state%candidate == 0)) deallocate (state%candidate, state%contact_force)
    end if
  end subroutine forget_unused

  !> Where a state keeps a field of its own: one run of numbers. An array that is not there gives a
  !! null, or is made.
  function address_of(state, name, dims, make) result(address)
    type(saved_state_t), pointer, intent(in) :: state !! the state
    character(*), intent(in) :: name !! the field
    integer, intent(in) :: dims(:) !! its dimensions
    logical, intent(in) :: make !! whether to make its array
    type(c_ptr) :: address

    address = c_null_ptr
    select case (name)
    case ('time')
      address = c_loc(state%time)
    case ('increment')
      address = c_loc(state%increment)
    case ('displacement')
      call find_array(state%displacement, dims, make, address)
    case ('reaction')
      call find_array(state%reaction, dims, make, address)
    case ('span_before')
      address = c_loc(state%span_before)
    case ('displacement_before')
      call find_array(state%displacement_before, dims, make, address)
    case ('factor_wear')
      address = c_loc(state%factor_aging)
    case ('factor_displacement')
      call find_array(state%factor_displacement, dims, make, address)
    case ('scene')
      address = c_loc(state%scene)
    case ('residual')
      address = c_loc(state%residual)
    case ('rigid')
      call find_array(state%rigid, dims, make, address)
    case ('memory')
      if (make) allocate (state%memory(dims(1)))
      if (allocated(state%memory)) address = c_loc(state%memory)
    case ('candidate')
      if (make) allocate (state%candidate(dims(1)))
      if (allocated(state%candidate)) address = c_loc(state%candidate)
    case ('contact_force')
      call find_array(state%contact_force, dims, make, address)
    case ('slope_mark')
      address = c_loc(state%slopes%mark)
    case ('tip_slope')
      call find_array(state%slopes%apex, dims, make, address)
    case ('place_slope')
      call find_array(state%slopes%place, dims, make, address)
    case ('force_slope')
      call find_array(state%slopes%force, dims, make, address)
    case ('slope_late')
      if (make) allocate (state%slopes%late(dims(1)))
      if (allocated(state%slopes%late)) address = c_loc(state%slopes%late)
    end select
  end function address_of

  !> Place of an array.
  subroutine find_array(values, dims, make, address)
    real(wp), allocatable, target, intent(inout) :: values(:, :) !! the array
    integer, intent(in) :: dims(:) !! (2) its dimensions
    logical, intent(in) :: make !! whether to make it
    type(c_ptr), intent(inout) :: address !! its place, if it is there

    if (make) allocate (values(dims(1), dims(2)))
    if (allocated(values)) address = c_loc(values)
  end subroutine find_array

  !> One component of a field of reals, where the history of a pair keeps it.
  function real_component(history, name, k) result(values)
    type(pair_history_t), pointer, intent(in) :: history !! the history
    character(*), intent(in) :: name !! the field
    integer, intent(in) :: k !! number of the component
    real(wp), pointer :: values(:) !! (points)

    nullify (values)
    select case (name)
    case ('tip')
      values => history%points%apex(k)
    case ('dissipation')
      values => history%points%dissipation
    case (slip_path%name)
      values => history%points%path
    case ('frictional_slip')
      values => history%points%way(k)
    case ('multiplier')
      values => history%points%lambda(k)
    case ('weight')
      values => history%cells%weight(k)
    case ('area')
      values => history%cells%area
    case ('place')
      values => history%cells%place(k)
    case ('node_axis')
      values => history%multipliers%axis(k)
    case ('node_normal')
      values => history%multipliers%normal(k)
    case ('node_force')
      values => history%multipliers%force(k)
    case ('node_path')
      values => history%multipliers%path
    case ('node_way')
      values => history%multipliers%way(k)
    case ('node_dissipation')
      values => history%multipliers%dissipation
    end select
  end function real_component

  !> The same of a field of integers, which have one component each.
  function integer_component(history, name) result(values)
    type(pair_history_t), pointer, intent(in) :: history !! the history
    character(*), intent(in) :: name !! the field
    integer, pointer :: values(:) !! (points)

    nullify (values)
    select case (name)
    case ('host')
      values => history%points%target
    case ('status')
      values => history%points%status
    case ('coupled')
      values => history%coupled
    case ('slave')
      values => history%cells%slave
    case ('node')
      values => history%multipliers%node
    case ('face')
      values => history%multipliers%face
    case ('node_status')
      values => history%multipliers%status
    end select
  end function integer_component
end module state_fields
