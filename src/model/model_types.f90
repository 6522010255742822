!> What a problem is: materials, conditions, loads, contact pairs, and what is to be written.
module model_types
  use kinds, only: wp
  use body_fields, only: fields_of_bodies, n_body_fields
  use deck_types, only: location_t
  use text, only: string_t
  use mesh_types, only: mesh_t
  use law_types, only: most_parameters
  use contact_types, only: pair_t
  implicit none
  private
  public :: model_t, material_t, conditions_t, load_t, pressure_t, nodal_values_t, load_table_t, &
    output_request_t, history_request_t, rigid_body_t, point_load_t
  public :: state_all, state_last, state_none, last_states
  public :: form_plain, form_sine, form_versine

  !> How many states are kept for restarts.
  integer, parameter :: state_all = 1
  integer, parameter :: state_last = 2
  integer, parameter :: state_none = 3
  !> States that are kept of STATe LAST without a number, and without STATe. The last is what a run
  !! that was stopped goes on from; those before it, what one goes back to that has gone astray.
  integer, parameter :: last_states = 2, default_states = 4

  !> One material.
  type :: material_t
    integer :: number = 0 !! the deck's material number
    character(:), allocatable :: label !! its label, may be empty
    type(location_t) :: at !! where the deck defines it
    integer :: law = 1 !! number of its law in bulk_laws, of the linear one unless the deck says
    logical :: mean = .false. !! volumetric part on the mean dilatation of an element
    logical :: nodal = .false. !! volumetric part on the dilatation of the nodes
    logical :: mean_asked = .false. !! the deck says whether, or FULL
    real(wp) :: youngs_modulus = 0.0_wp !! E
    real(wp) :: poissons_ratio = 0.0_wp !! nu
    real(wp) :: own(most_parameters) = 0.0_wp !! the law's own parameters
    real(wp) :: density = 0.0_wp !! rho
    logical :: has_density = .false. !! the deck gives it
    logical :: rigid = .false. !! its regions have no degrees of freedom of their own
  end type material_t

  !> Values at some degrees of freedom; those of one that stands twice add.
  type :: nodal_values_t
    integer :: n = 0 !! entries in use
    integer, allocatable :: node(:), dof(:) !! (n or more) where
    real(wp), allocatable :: value(:) !! (n or more) how much
  end type nodal_values_t

  !> The factor of a load, from that of its table: the same, the sine of the angle times it, or one
  !! less the cosine.
  integer, parameter :: form_plain = 1
  integer, parameter :: form_sine = 2
  integer, parameter :: form_versine = 3

  !> A load: prescribed displacements and forces that grow with one factor.
  type :: load_t
    integer :: table = 0 !! number of its table, 0 for the sum of all
    integer :: form = form_plain !! how its factor follows from the table
    real(wp) :: angle = 0.0_wp !! of a rotation, where the table is 1
    type(nodal_values_t) :: displacement !! of restrained degrees of freedom, factor 1 [length]
    type(nodal_values_t) :: force !! on any degree of freedom, factor 1 [force]
  end type load_t

  !> A pressure that follows a surface.
  type :: pressure_t
    integer :: surface = 0 !! index of the surface
    integer :: table = 0 !! number of its table, 0 for the sum of all
    real(wp) :: value = 0.0_wp !! positive inwards, factor 1 [force/length^2]
  end type pressure_t

  !> A motion or a load of the point of a rigid body, times a table.
  type :: point_load_t
    integer :: table = 0 !! number of its table, 0 for the sum of all
    real(wp) :: value(6) = 0.0_wp !! factor 1: translation and rotation vector [length, radian], or
    !! force and moment [force, force length]
  end type point_load_t

  !> A rigid body with a point (RIGId).
  type :: rigid_body_t
    character(:), allocatable :: name !! its name in tables
    type(location_t) :: at !! where the deck defines it
    integer, allocatable :: nodes(:) !! its nodes
    real(wp) :: point(3) = 0.0_wp !! its point at rest [length]
    logical :: free(6) = .true. !! translations and rotations of the point that are unknowns
    type(point_load_t), allocatable :: motions(:) !! prescribed; they add
    type(point_load_t), allocatable :: loads(:) !! on the point; they add
  end type rigid_body_t

  !> What is prescribed at the nodes; the loads of a degree of freedom add.
  type :: conditions_t
    logical, allocatable :: restrained(:, :) !! (3, nodes) displacement is prescribed
    type(load_t), allocatable :: loads(:) !! no two of one table and form
    type(pressure_t), allocatable :: pressures(:) !! that follow their surfaces
    real(wp), allocatable :: spring(:, :) !! (3, nodes) to ground, if there are any [force/length]
    type(rigid_body_t), allocatable :: rigid(:) !! rigid bodies with a point; none is size 0
  end type conditions_t

  !> A proportional load: piecewise linear, or FEAP's type 1 function.
  type :: load_table_t
    integer :: number = 0 !! its number
    logical :: function_form = .false. !! FEAP type 1: a0 + a1 t + a2 sin(a3 (t - tmin))^a4
    real(wp), allocatable :: t(:) !! times; tmin and tmax for the function
    real(wp), allocatable :: p(:) !! factors; a0 .. a4 for the function
  end type load_table_t

  !> A dof whose displacement goes to the history table.
  type :: history_request_t
    integer :: node = 0 !! node number
    integer :: dof = 0 !! 1, 2 or 3
  end type history_request_t

  !> What the OUTPut data set asks for.
  type :: output_request_t
    type(string_t), allocatable :: reactions(:) !! names of sets, in the order of the rows
    logical :: field(n_body_fields) = fields_of_bodies%given !! write these fields of the bodies
    logical :: contact = .true. !! write the contact points
    logical :: all_tables = .false. !! of a study, write a reaction table for each variant
    integer :: every = 1 !! fields and state at each n-th end time
    integer :: state = state_last !! states kept for restarts
    integer :: kept_states = default_states !! how many, of state_last
    integer :: slopes(3) = 0 !! with SENSitivity: derivatives of apexes and of contact nodes in a
    !! state, contact nodes
    integer, allocatable :: points(:) !! indices of the pairs in the table of points
    type(history_request_t), allocatable :: history(:) !! dofs of the history table
  end type output_request_t

  !> The whole problem, as read and checked; nothing in it changes while it is solved but the
  !! history inside its pairs.
  type :: model_t
    character(:), allocatable :: title !! title of the deck
    type(mesh_t) :: mesh !! nodes, elements, sets
    type(material_t), allocatable :: materials(:) !! materials in the order of the deck
    integer, allocatable :: element_material(:) !! (elements) index into materials
    type(conditions_t) :: conditions !! supports and loads
    type(load_table_t), allocatable :: tables(:) !! proportional loads
    type(pair_t), allocatable :: pairs(:) !! contact pairs in the order of the deck
    logical, allocatable :: held(:) !! (nodes) of regions whose free motions are held
    type(output_request_t) :: output !! what is written
    type(string_t), allocatable :: notes(:) !! remarks for the log (reordered elements, ...)
    type(string_t), allocatable :: warnings(:) !! what the deck deserves, for log and terminal
  end type model_t
end module model_types
