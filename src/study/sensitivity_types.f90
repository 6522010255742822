!> What the derivatives along a run are made of (doc/theory, "Sensitivities along the path").
module sensitivity_types
  use kinds, only: wp
  use text, only: string_t
  use deck_types, only: location_t
  use model_types, only: model_t, load_t, load_table_t
  use linear_answers, only: answers_t
  use lever_sums, only: levers_t
  implicit none
  private
  public :: sensitivity_t, slope_t, tables_t, new_slope, add_slope

  !> The proportional loads of one variant of the deck.
  type :: tables_t
    type(load_table_t), allocatable :: tables(:) !! all of them
    real(wp) :: weight = 0.0_wp !! with which their factors add up to a derivative
  end type tables_t

  !> What a unit of one parameter changes.
  type :: slope_t
    character(:), allocatable :: name !! of the parameter
    type(location_t) :: at !! where the deck asks for it
    real(wp), allocatable :: mu(:, :) !! (2, pairs) coefficients of friction
    real(wp), allocatable :: rule(:) !! (pairs) m of the slip rule
    real(wp), allocatable :: angle(:) !! (pairs) angle of the lay [radian]
    real(wp), allocatable :: penalty(:) !! (pairs) penalty, over itself
    real(wp), allocatable :: modulus(:) !! (materials) Young's modulus, over itself
    real(wp) :: forces = 0.0_wp !! all applied forces, over themselves
    type(load_t), allocatable :: loads(:) !! prescribed values and forces, with their tables
    type(tables_t), allocatable :: variants(:) !! tables whose factors add up to the derivative
    real(wp), allocatable :: stiffness(:) !! (bodies) stiffness, over itself
    real(wp), allocatable :: influence(:, :, :) !! (3, nodes, loads) u of unit loads [length]
  end type slope_t

  !> Euler's sum: derivatives by all penalties, and by all moduli and forces, make the reactions.
  type :: euler_t
    integer :: slope(2) = 0 !! columns that they are multiples of
    real(wp) :: factor(2) = 0.0_wp !! and by what
    real(wp) :: error = 0.0_wp !! of the sum, over the reactions
  end type euler_t

  !> Parameters, and the derivatives of the state by them.
  type :: sensitivity_t
    logical :: active = .false. !! derivatives are asked for
    logical :: started = .false. !! what belongs to the scene has been found
    logical :: full = .false. !! with the matrix of all nodes, not with the condensed form
    integer :: shown = 0 !! parameters in the table; others check them
    type(slope_t), allocatable :: slopes(:) !! (n) what they change
    integer, allocatable :: target(:) !! (points of all pairs) facet at the last state, 0 for none
    integer, allocatable :: status(:) !! (points) at the last state
    real(wp), allocatable :: apex(:, :) !! (2, points) apexes there
    real(wp), allocatable :: dtip(:, :, :) !! (2, points, n) their derivatives
    real(wp), allocatable :: du(:, :, :) !! (3, nodes, n) of displacements, where contact may be
    real(wp), allocatable :: force(:, :, :) !! (3, nodes, n) of contact forces
    type(string_t), allocatable :: sets(:) !! sets of the reaction table
    type(levers_t) :: levers !! of these sets
    real(wp), allocatable :: pushed(:, :, :) !! (3, nodes, loads) u of the applied forces alone
    real(wp), allocatable :: reaction(:, :, :) !! (3, sets, n) derivatives of reactions [force]
    real(wp), allocatable :: contact(:, :, :) !! (3, pairs, n) and of contact sums [force]
    real(wp), allocatable :: total(:, :) !! (3, sets) the reactions themselves [force]
    real(wp), allocatable :: range(:, :) !! (n, pairs) change after which a point changes status
    integer, allocatable :: kinks(:) !! (pairs) points whose status is at its border
    integer :: lost = 0 !! points whose way to their target has not been found again
    integer :: touched = 0 !! points that have touched first within an increment
    type(euler_t) :: euler !! check of all of them
    type(answers_t) :: answers !! what the last ones have left
  end type sensitivity_t
contains

  !> A parameter that changes nothing yet.
  function new_slope(name, model) result(slope)
    character(*), intent(in) :: name !! its name in the table
    type(model_t), intent(in) :: model !! the problem
    type(slope_t) :: slope

    slope%name = name
    associate (pairs => size(model%pairs))
      allocate (slope%mu(2, pairs), slope%rule(pairs), slope%angle(pairs), slope%penalty(pairs), &
        source=0.0_wp)
    end associate
    allocate (slope%modulus(size(model%materials)), source=0.0_wp)
    allocate (slope%loads(0), slope%variants(0))
  end function new_slope

  !> Adds a parameter.
  subroutine add_slope(slope, s)
    type(slope_t), intent(in) :: slope !! what it changes
    type(sensitivity_t), intent(inout) :: s !! gets it
    type(slope_t), allocatable :: longer(:)
    integer :: n

    n = size(s%slopes)
    allocate (longer(n + 1))
    longer(:n) = s%slopes
    longer(n + 1) = slope
    call move_alloc(longer, s%slopes)
  end subroutine add_slope
end module sensitivity_types
