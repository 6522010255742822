!> What a converged end time hands to the files: plain arrays, whatever solver made them.
module result_types
  use kinds, only: wp
  use contact_types, only: contact_point_t, cell_t
  use mortar_types, only: multiplier_t
  use body_fields, only: n_body_fields
  use point_fields, only: point_fields_t
  use slope_state, only: kept_slopes_t
  implicit none
  private
  public :: origin_t, end_row_t, contact_row_t, frame_t, pair_history_t, saved_state_t, &
    derivative_rows_t, variant_row_t, parameter_length

  !> Longest name of a derivative's parameter (mu1 of a pair, the way of a set).
  integer, parameter :: parameter_length = 48

  !> What made the files of a run.
  type :: origin_t
    character(:), allocatable :: program !! its name and version
    character(:), allocatable :: deck !! the deck as read, includes and all
    character(:), allocatable :: settings !! name of the deck, command line and settings
    character(:), allocatable :: blas !! BLAS the program runs on
    integer :: end_times = 0 !! rows that its commands will write, foreseen
    logical :: derivatives = .false. !! derivatives along the run are asked for
    integer :: varied = 0 !! parameters that a study varies, 0 if there is none
  end type origin_t

  !> The derivatives at one end time, one row a set or pair and parameter.
  type :: derivative_rows_t
    character(parameter_length), allocatable :: quantity(:) !! (rows) name of the set or pair
    character(parameter_length), allocatable :: parameter(:) !! (rows) the parameter
    integer, allocatable :: kinks(:) !! (rows) contact points between two states
    real(wp), allocatable :: values(:, :) !! (4, rows) d1 d2 d3 [force/parameter], range [parameter]
  end type derivative_rows_t

  !> What a variant of a study has come to.
  type :: variant_row_t
    integer :: number = 0 !! of the variant
    real(wp), allocatable :: values(:) !! (parameters) its values
    integer :: code = 0 !! exit code
    integer :: step = 0 !! its last end time
    real(wp), allocatable :: reactions(:, :, :) !! (3, sets, end times), zero behind that [force]
  end type variant_row_t

  !> One row of the contact table: sums over the points of one pair.
  type :: contact_row_t
    integer :: active = 0 !! points in contact
    integer :: stick = 0 !! of these, sticking
    integer :: slip = 0 !! of these, slipping
    real(wp) :: normal = 0.0_wp !! sum of the magnitudes of the normal forces [force]
    real(wp) :: tangential = 0.0_wp !! sum of the magnitudes of the tangential forces [force]
    real(wp) :: force(3) = 0.0_wp !! resultant on the slave side [force]
    real(wp) :: moment(3) = 0.0_wp !! its moment about the origin [force length]
    real(wp) :: max_penetration = 0.0_wp !! deepest penetration [length]
    real(wp) :: max_elastic_slip = 0.0_wp !! longest tangential part of the gap vector [length]
    real(wp) :: max_criterion = 0.0_wp !! largest sqrt(sum (s_i/mu_i)^2) - abs(g_N) [length]
    real(wp) :: lumped = 0.0_wp !! as tangential, of the friction lumped to slave nodes [force]
  end type contact_row_t

  !> The rows of one end time.
  type :: end_row_t
    integer :: step = 0 !! number of the end time
    real(wp) :: time = 0.0_wp !! its time [time]
    real(wp), allocatable :: reactions(:, :) !! (3, sets) sum over the nodes of each set [force]
    type(contact_row_t), allocatable :: pairs(:) !! (pairs) sums over the points of each pair
    real(wp), allocatable :: rigid(:, :) !! (12, rigid bodies) motions and forces of constraints, if
    !! there are such bodies
    type(derivative_rows_t), allocatable :: derivatives !! if they are asked for
  end type end_row_t

  !> Values of one field of the bodies.
  type :: body_values_t
    real(wp), allocatable :: values(:, :) !! (components, nodes or elements)
  end type body_values_t

  !> The fields of one end time; what is not allocated is not written.
  type :: frame_t
    type(body_values_t) :: body(n_body_fields) !! of the bodies, as fields_of_bodies lists them
    real(wp), allocatable :: motion(:, :) !! (3, nodes) displacement, for the contact surfaces
    real(wp) :: began = 0.0_wp !! when the increment began that ends here [time]
    type(point_fields_t), allocatable :: pairs(:) !! contact points of each pair
  end type frame_t

  !> The contact history of one pair.
  type :: pair_history_t
    type(contact_point_t), allocatable :: points(:) !! (points) at the last converged state
    integer, allocatable :: coupled(:) !! (points) target when the matrix pattern was built, 0 idle
    type(cell_t), allocatable :: cells(:) !! (points) of a segmented pair: where they are
    type(multiplier_t), allocatable :: multipliers(:) !! (points) with MORTar: those of its nodes
  end type pair_history_t

  !> What a run needs to go on from an end time.
  type :: saved_state_t
    integer :: step = 0 !! number of the end time
    real(wp) :: time = 0.0_wp !! its time [time]
    real(wp) :: increment = 0.0_wp !! increment size to go on with [time]
    real(wp), allocatable :: displacement(:, :) !! (3, nodes) [length]
    real(wp), allocatable :: reaction(:, :) !! (3, nodes) force of the supports [force]
    real(wp), allocatable :: rigid(:, :) !! (6, rigid bodies) free motions [length, radian]
    real(wp), allocatable :: memory(:) !! what the points of the bulk remember, if a law asks
    type(pair_history_t), allocatable :: pairs(:) !! contact history of each pair
    ! The state before, from which first touches are foreseen
    real(wp) :: span_before = 0.0_wp !! length of the last increment, 0 if not known [time]
    real(wp), allocatable :: displacement_before(:, :) !! (3, nodes) at its start [length]
    ! What it was in balance with
    integer :: scene(4) = 0 !! sums over the scene and over the time, 0 if not known
    real(wp) :: residual = 0.0_wp !! residual over the force scale
    ! Of the condensed form, if it is in use
    real(wp) :: factor_aging(2) = 0.0_wp !! passes that the factors of a nonlinear bulk have cost,
    !! tangents in a row that were not positive definite
    real(wp), allocatable :: factor_displacement(:, :) !! (3, nodes) at which they were made; not
    !! allocated if at rest [length]
    integer, allocatable :: candidate(:) !! (nodes) 1 where contact may touch
    real(wp), allocatable :: contact_force(:, :) !! (3, nodes) contact forces [force]
    type(kept_slopes_t) :: slopes !! derivatives, if they were asked for
    character(:), allocatable :: note !! what its reader has to say of it
  end type saved_state_t
end module result_types
