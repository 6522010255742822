!> Parts of the discrete system: loads, bodies, the matrix as a whole, positions, what the bulk
!! answers, rigid bodies with a point, places of the contact elements, scales.
module system_parts
  use kinds, only: wp
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: linear_solver_t, solver_auto, solver_unknown
  use rigid_motions, only: motions_t
  use rigid_types, only: rigid_t
  implicit none
  private
  public :: outer_t, bodies_t, whole_form_t, positions_t, bulk_answer_t, rigid_part_t, &
    contact_places_t, scales_t, wish_t

  !> What acts on the bodies from outside.
  type :: outer_t
    real(wp), allocatable :: spring(:, :) !! (3, nodes) springs to ground, if there are any; zero
    !! where restrained [force/length]
    integer, allocatable :: pressed(:, :) !! (6, facets) nodes of facets whose pressure follows,
    !! zeros behind the last; not allocated if there are none
    integer, allocatable :: pressed_by(:) !! (facets) place in pressure
    real(wp), allocatable :: pressure(:) !! at the end of the increment [force/length^2]
    real(wp), allocatable :: external(:, :) !! (3, nodes) applied forces [force]
  end type outer_t

  !> The connected bodies, and what holds them.
  type :: bodies_t
    integer, allocatable :: node_body(:) !! (nodes) connected body, 0 for none
    integer :: bodies = 0 !! number of bodies
    type(motions_t), allocatable :: motions(:) !! (bodies) rigid motions that supports leave;
    !! springs hold some of them, but beside multipliers these count as well
    logical, allocatable :: fixed(:, :) !! (3, nodes) HOLD stops it, if there are such bodies
    logical, allocatable :: floating(:) !! (bodies) supports alone do not hold it
    logical, allocatable :: regularised(:) !! (bodies) held by soft springs in this iteration
    logical :: settled = .false. !! the last full step has left nearly all points as they were
    real(wp) :: damping = 0.0_wp !! stiffness against rigid motions of floating bodies, 0 without
    !! pseudo-time [force/length]
    real(wp), allocatable :: damped_from(:, :) !! (3, nodes) where its force is measured from: where
    !! the step of pseudo-time began [length]
    real(wp), allocatable :: damped_way(:) !! (unknowns) way of rigid bodies since then [length]
  end type bodies_t

  !> The system as one sparse matrix, and its solver.
  type :: whole_form_t
    type(block_matrix_t) :: bulk_matrix !! tangent of the bulk
    type(block_matrix_t) :: matrix !! tangent of bulk and contact
    logical :: apart = .false. !! matrix has contact's share alone
    logical :: given = .false. !! the solver has the values of bulk_matrix, which keeps its graph
    type(block_matrix_t) :: restrained !! of these restrained rows and columns
    integer, allocatable :: bulk_place(:) !! place of each bulk block in matrix
    type(csc_matrix_t) :: csc !! its free part
    logical :: symmetric = .false. !! its values are symmetric
    type(linear_solver_t) :: solver !! its factor
    integer :: forced = solver_unknown !! what --solver asks for, unknown if it does not
    integer :: asked = solver_auto !! what --solver or SOLVer asks for
    logical :: declined = .false. !! AUTO has found no way with the condensed form to this end time
    integer :: choice = solver_unknown !! what is taken, unknown before the next increment
  end type whole_form_t

  !> Where the nodes are, were and start.
  type :: positions_t
    real(wp), allocatable :: left(:, :) !! (3, nodes) start without predictor [length]
    real(wp), allocatable :: carried(:, :) !! (3, nodes) start with predictor [length]
    real(wp), allocatable :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), allocatable :: x_now(:, :) !! (3, nodes) positions of the iterate [length]
    real(wp), allocatable :: x_ahead(:, :) !! (3, nodes) with the bodies carried rigidly [length]
    real(wp), allocatable :: x_alone(:, :) !! (3, nodes) the same without what contact carries,
    !! where that is not the same [length]
  end type positions_t

  !> What the bulk answers to the displacements of the iterate.
  type :: bulk_answer_t
    real(wp), allocatable :: bulk_force(:, :) !! (3, nodes) internal force of the bulk [force]
    logical :: linearised = .false. !! the bulk answers by its tangent at the last state
    logical :: known = .false. !! bulk_force is that of u for the next residual
    real(wp), allocatable :: rows(:, :, :) !! (3, 3, nodes) sums of |K| along the rows of each node,
    !! undeformed, where the bulk is not linear [force/length]
    real(wp), allocatable :: bulk_start(:, :) !! (3, nodes) its force there [force]
    real(wp), allocatable :: u_start(:, :) !! (3, nodes) displacements there [length]
    real(wp) :: bulk_energy = 0.0_wp !! strain energy of a bulk that is not linear [force length]
    integer :: inverted = 0 !! element that was, or would be, turned inside out
  end type bulk_answer_t

  !> Rigid bodies with a point, and their unknowns beside those of the nodes.
  type :: rigid_part_t
    type(rigid_t), allocatable :: rigid(:) !! rigid bodies with a point, if there are any
    logical :: ahead = .false. !! they start with the predictor
    integer, allocatable :: carried_by(:) !! (nodes) rigid body whose unknowns move each, 0 for none
    integer :: unknowns = 0 !! of all rigid bodies
  end type rigid_part_t

  !> Which contact elements are whose, and what facets they lie on.
  type :: contact_places_t
    integer, allocatable :: first_point(:) !! (pairs+1) where each pair begins in contact
    integer, allocatable :: targets(:) !! (contact elements) facet of its pair, 0 while idle
    integer, allocatable :: coupled_targets(:) !! the same when the pattern was built last
    logical :: begun = .false. !! elements and residual are those of the start of an increment
    logical :: coupled = .false. !! so are the nodes that they couple
  end type contact_places_t

  !> What forces and displacements are measured against.
  type :: scales_t
    real(wp) :: given_forces = 0.0_wp !! norm of the loads and of the last state's reactions [force]
    real(wp) :: seen_forces = 0.0_wp !! smallest norm of forces in the increment, 0: none [force]
    real(wp) :: bound = huge(1.0_wp) !! no displacement can be larger [length]
    real(wp) :: stroke = 0.0_wp !! largest prescribed motion of the increment [length]
    real(wp) :: stiffest = 0.0_wp !! largest entry of the bulk's matrix [force/length]
    real(wp) :: facet_size = 0.0_wp !! mean size of the master facets [length]
    real(wp) :: round_off = 0.0_wp !! norm of the residual's round-off [force]
  end type scales_t

  !> What is asked of a direction.
  type :: wish_t
    real(wp) :: share = 0.0_wp !! of the residual that the last iteration has left, 0: none so far
    real(wp) :: wanted = 0.0_wp !! residual over forces that would have converged
    logical :: indefinite = .false. !! a symmetric matrix was not positive definite before
  end type wish_t
end module system_parts
