!> The discrete system: equations, element lists, matrices, and the state that is solved for. In
!! more than 400 lines, since interfaces of procedures stand where the types do that they take.
module system_types
  use kinds, only: wp
  use costs, only: cost_t
  use element_lists, only: bulk_list_t, volume_list_t, element_list_t
  use condensed_types, only: condensed_t, center_t
  use touch_types, only: touch_t
  use softening_state, only: softening_t
  use multiplier_types, only: multiplier_motion_t
  use rigid_types, only: border_t
  use system_parts, only: outer_t, bodies_t, whole_form_t, positions_t, bulk_answer_t, &
    rigid_part_t, contact_places_t, scales_t, wish_t
  use slope_state, only: kept_slopes_t
  use model_types, only: model_t
  implicit none
  private
  public :: system_t, state_t, form_t, form_kind_t, terms_t

  !> The state at the last converged time.
  type :: state_t
    real(wp) :: time = 0.0_wp !! time
    real(wp) :: began = 0.0_wp !! when the increment began that ended then
    integer :: step = 0 !! end times so far
    logical :: whole = .true. !! displacements inside and reactions are those of its time
    real(wp), allocatable :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), allocatable :: reaction(:, :) !! (3, nodes) force of the supports [force]
    real(wp), allocatable :: rigid(:, :) !! (6, rigid bodies) free translation and rotation vector
    !! of their points [length, radian]
    type(kept_slopes_t) :: slopes !! derivatives that go on from here, if they are asked for
  end type state_t

  !> What acts on the bodies and between them. Newton's method knows no more of it than this:
  !! elements, laws and fields of multipliers stand behind these procedures (term_choice).
  type :: terms_t
    procedure(term_forces), pointer, nopass :: contact_forces => null() !! of contact elements
    procedure(term_share), pointer, nopass :: step_share => null() !! that the bulk can go
    procedure(term_bend), pointer, nopass :: bend_surfaces => null() !! that are smooth
    procedure(term_add), pointer, nopass :: add_multipliers => null() !! to a direction
    procedure(term_fit), pointer, nopass :: multipliers_fit => null() !! the forces
  end type terms_t

  !> Everything that is built once from a model.
  type :: system_t
    integer, allocatable :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    integer :: equations = 0 !! free degrees of freedom
    type(bulk_list_t) :: bulk !! bulk elements
    type(volume_list_t) :: volumes !! volumes of nodes, with SOLId NODAl
    type(element_list_t) :: contact !! contact elements, one a point
    real(wp), allocatable :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    real(wp), allocatable :: contact_force(:, :) !! (3, nodes) internal force of contact [force]
    type(terms_t), allocatable :: terms !! what its elements do; allocatable as kind of form_t is
    type(touch_t) :: touch !! first touches of the increment
    type(softening_t), allocatable :: softening(:) !! (pairs) if some law softens
    type(multiplier_motion_t) :: motion !! multipliers that come along with the iteration
    type(outer_t) :: loads !! loads and springs
    type(bodies_t) :: body !! connected bodies
    type(positions_t) :: position !! positions of the nodes
    type(rigid_part_t) :: tools !! rigid bodies with a point
    type(contact_places_t) :: place !! where the contact elements are
    type(scales_t) :: scale !! forces and lengths to compare with
    integer :: spared = 0 !! end times of the run at which they are not
    logical :: whole_factors = .false. !! a study asks the factors after the run: none is shrunk
    logical :: slopes_due = .false. !! derivatives ask for the factor of an increment's last tangent
  end type system_t

  !> How the linearised system is held: as one sparse matrix (full_form), condensed to the forces of
  !! contact (condensed_form), or with the factors of an earlier state before the true tangent
  !! (reused_form). Newton's method, step length and convergence know no more of it than this:
  !! whatever differs from one form to another is a procedure or a fact here. A procedure that is
  !! null has nothing to do in that form.
  type :: form_kind_t
    character(8) :: name = '' !! in the log: its own, or that of the back end with its factor
    logical :: knows_inside = .true. !! displacements and forces of all nodes are the iterate's
    logical :: has_energy = .true. !! a symmetric tangent is that of an energy along the direction
    logical :: inexact = .false. !! a direction is found by iteration and leaves a share
    logical :: iterates_cheaply = .false. !! one more iteration costs next to nothing
    logical :: near = .false. !! reused factors were made at nearly this state: they alone give the
    !! directions, and the bulk answers to a jump as it is
    ! the start of an increment
    procedure(form_begin), pointer, nopass :: begin => null() !! loads without contact
    procedure(form_starts), pointer, nopass :: place_starts => null() !! as far as it knows better
    procedure(form_act), pointer, nopass :: restart => null() !! at the start, targets chosen
    procedure(form_forget), pointer, nopass :: begin_anew => null() !! the other start after a stall
    procedure(form_foresee), pointer, nopass :: foresee => null() !! what a start leaves
    procedure(form_doubt), pointer, nopass :: doubt_start => null() !! once it has been chosen
    procedure(form_take), pointer, nopass :: start_rubbing => null() !! friction at first touches
    procedure(form_act), pointer, nopass :: couple => null() !! contact elements have other nodes
    procedure(form_couple_saved), pointer, nopass :: couple_as_saved => null() !! of a saved state
    ! residual and steps
    procedure(form_bulk), pointer, nopass :: find_bulk_force => null() !! of the bulk at u
    procedure(form_bulk), pointer, nopass :: try_bulk_force => null() !! of the bulk at the trial
    procedure(form_gather), pointer, nopass :: gather => null() !! right-hand side
    procedure(form_place), pointer, nopass :: place_trial => null() !! at u + length du
    procedure(form_length), pointer, nopass :: take_trial => null() !! moves the iterate there
    procedure(form_note), pointer, nopass :: note_moved => null() !! u was moved by no iteration
    procedure(form_move), pointer, nopass :: renew => null() !! what iterations carry on
    ! directions
    procedure(form_direct), pointer, nopass :: find_direction => null() !! tangent, factor, solution
    procedure(form_repeat), pointer, nopass :: repeat_direction => null() !! with the factor at hand
    procedure(form_may), pointer, nopass :: may_repeat => null() !! after an iteration
    procedure(form_ask), pointer, nopass :: repeats_by_iteration => null() !! at a tangent's cost
    procedure(form_ask), pointer, nopass :: repeats_if_promising => null() !! not after poor steps
    procedure(form_judge), pointer, nopass :: judge_step => null() !! factors may be too old
    procedure(form_left), pointer, nopass :: note_repeated => null() !! a step with them
    procedure(form_next), pointer, nopass :: next_length => null() !! of the trial's direction
    procedure(form_next), pointer, nopass :: next_energy => null() !! the same on the residual
    procedure(form_answer), pointer, nopass :: answer => null() !! displacements by forces
    procedure(form_push), pointer, nopass :: push => null() !! the direction with further forces
    ! measures
    procedure(form_number), pointer, nopass :: residual_norm => null() !! [force]
    procedure(form_number), pointer, nopass :: largest_resultant => null() !! on floating bodies
    procedure(form_number), pointer, nopass :: damping_norm => null() !! of its force
    procedure(form_number), pointer, nopass :: direction_norm => null() !! [length]
    procedure(form_number), pointer, nopass :: direction_work => null() !! of the residual
    procedure(form_own), pointer, nopass :: defect_energy => null() !! of a start off balance
    procedure(form_terms), pointer, nopass :: sum_terms => null() !! of the residual, for round-off
    procedure(form_worst), pointer, nopass :: find_worst => null() !! dof with the largest residual
    procedure(form_resultant), pointer, nopass :: floating_resultant => null() !! of the residual
    procedure(form_mask), pointer, nopass :: placed_nodes => null() !! whose u is the iterate's
    ! the end of an increment, and steps of pseudo-time
    procedure(form_move), pointer, nopass :: refresh => null() !! candidates no iteration moves
    procedure(form_act), pointer, nopass :: recover => null() !! all nodes, forces of the bulk
    procedure(form_accept), pointer, nopass :: accept => null() !! the iterate becomes the state
    procedure(form_center), pointer, nopass :: note_center => null() !! a step begins here
    procedure(form_center), pointer, nopass :: return_to_center => null() !! back to where it began
    procedure(form_forget), pointer, nopass :: forget_damping => null() !! there is none any more
  end type form_kind_t

  !> The linearised system in its form: what it keeps, is asked for and finds.
  type :: form_t
    type(form_kind_t), allocatable :: kind !! allocatable: gfortran 12 fails on the type itself
    type(wish_t) :: wish !! what is asked of the next direction
    type(whole_form_t) :: whole !! the matrix as a whole
    type(border_t) :: border !! what the unknowns of rigid bodies add to it
    type(condensed_t) :: condensed !! what the condensed form and that of reused factors keep
    real(wp), allocatable :: right(:) !! (equations+unknowns) right-hand side [force]
    real(wp), allocatable :: solution(:) !! (equations+unknowns) solution [length]
    real(wp), allocatable :: next(:) !! (equations+unknowns) direction of a trial [length]
    real(wp), allocatable :: du(:, :) !! (3, nodes) direction of the iteration [length]
    real(wp), allocatable :: bulk_change(:, :) !! (3, nodes) K du of a linear bulk, else 0 [force]
    real(wp), allocatable :: trial(:, :) !! (3, nodes) displacements of a trial [length]
    type(bulk_answer_t) :: inner !! what the bulk answers to the iterate, as far as it is asked
    type(cost_t) :: costs !! what the run has cost
  end type form_t

  abstract interface
    !> The internal force of all contact elements.
    subroutine term_forces(list, x, u, r)
      import :: element_list_t, wp
      implicit none
      type(element_list_t), intent(inout) :: list !! elements; gets h2 and status
      real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
      real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
      real(wp), intent(inout) :: r(:, :) !! (3, nodes) those of the last time given [force]
    end subroutine term_forces

    !> The share of a direction on which no bulk element is turned inside out.
    subroutine term_share(x, bulk, u, inner, du, share)
      import :: bulk_list_t, bulk_answer_t, wp
      implicit none
      real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
      type(bulk_list_t), intent(in) :: bulk !! bulk elements
      real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
      type(bulk_answer_t), intent(inout) :: inner !! gets inverted if the share is short
      real(wp), intent(in) :: du(:, :) !! (3, nodes) direction [length]
      real(wp), intent(out) :: share !! at most 1; 0: the first step cannot be taken
    end subroutine term_share

    !> Bends smooth surfaces as the nodes of the iterate lie.
    subroutine term_bend(model, place, u, contact)
      import :: model_t, contact_places_t, element_list_t, wp
      implicit none
      type(model_t), intent(inout) :: model !! pairs: patches
      type(contact_places_t), intent(in) :: place !! where the contact elements are
      real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
      type(element_list_t), intent(inout) :: contact !! gets patches
    end subroutine term_bend

    !> Adds to a direction with fixed multipliers the way that these go, and what it does to it.
    subroutine term_add(model, system, form, anew)
      import :: model_t, system_t, form_t
      implicit none
      type(model_t), intent(in) :: model !! pairs
      type(system_t), intent(inout) :: system !! direction found; gets motion
      type(form_t), intent(inout) :: form !! gets du
      logical, intent(in) :: anew !! the derivatives of the forces belong to a new tangent
    end subroutine term_add

    !> No pair has multipliers that differ much from its forces.
    logical function term_fit(model, system)
      import :: model_t, system_t
      implicit none
      type(model_t), intent(in) :: model !! pairs
      type(system_t), intent(in) :: system !! contact elements, u, motion
    end function term_fit

    !> An increment begins: what its loads do without contact.
    subroutine form_begin(model, system, form, state, time, foretold)
      import :: model_t, system_t, form_t, state_t, wp
      implicit none
      type(model_t), intent(in) :: model !! loads
      type(system_t), intent(in) :: system !! the iterate
      type(form_t), intent(inout) :: form !! what it keeps of the loads
      type(state_t), intent(in) :: state !! last converged state
      real(wp), intent(in) :: time !! end of the increment
      logical, intent(out) :: foretold !! contact forces of its end are foretold
    end subroutine form_begin

    !> Its two starts: where contact forces of the last state, or foretold ones, put the bodies.
    subroutine form_starts(form, body, position)
      import :: form_t, bodies_t, positions_t
      implicit none
      type(form_t), intent(inout) :: form !! the forces
      type(bodies_t), intent(in) :: body !! connected bodies
      type(positions_t), intent(inout) :: position !! left and carried given; both are completed
    end subroutine form_starts

    !> restart: contact elements at the start; couple: their nodes are others; recover: all nodes,
    !! the bulk's forces.
    subroutine form_act(system, form)
      import :: system_t, form_t
      implicit none
      type(system_t), intent(inout) :: system !! the iterate
      type(form_t), intent(inout) :: form !! what goes with it
    end subroutine form_act

    !> refresh: nodes that no iteration moves, as far as contact may touch them; renew: what has
    !! been carried on from iteration to iteration, the residual is due again.
    subroutine form_move(form, u)
      import :: form_t, wp
      implicit none
      type(form_t), intent(inout) :: form !! what goes with the iterate
      real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
    end subroutine form_move

    !> u has been moved by a rigid motion, or to where foretold forces put it.
    subroutine form_note(system, form)
      import :: system_t, form_t
      implicit none
      type(system_t), intent(in) :: system !! the iterate
      type(form_t), intent(inout) :: form !! what goes with it
    end subroutine form_note

    !> note_center: a step of pseudo-time begins here; return_to_center: back there, with other
    !! damping.
    subroutine form_center(form, damping, center)
      import :: form_t, center_t, wp
      implicit none
      type(form_t), intent(inout) :: form !! what goes with the iterate
      real(wp), intent(in) :: damping !! against rigid motions [force/length]
      type(center_t), intent(inout) :: center !! what it returns to
    end subroutine form_center

    !> begin_anew: the other start after a stall; forget_damping: there is none any more.
    subroutine form_forget(form)
      import :: form_t
      implicit none
      type(form_t), intent(inout) :: form !! forgets what it knows of that
    end subroutine form_forget

    !> A residual that the start without the predictor leaves at least, where that costs little.
    subroutine form_foresee(system, form, known, norm)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! u is that start
      type(form_t), intent(inout) :: form !! may find that state
      logical, intent(out) :: known !! there is such a number
      real(wp), intent(out) :: norm !! the residual [force]
    end subroutine form_foresee

    !> The start that has been chosen is too far away for what the form takes it for.
    subroutine form_doubt(system, form, x, doubtful)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! u is the start
      type(form_t), intent(inout) :: form !! may forget that its factors are near
      real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
      logical, intent(out) :: doubtful !! another choice is due
    end subroutine form_doubt

    !> start_rubbing: u is in balance with the friction that was foretold.
    subroutine form_take(form, body, u, taken)
      import :: form_t, bodies_t, wp
      implicit none
      type(form_t), intent(inout) :: form !! the forces
      type(bodies_t), intent(in) :: body !! connected bodies
      real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
      logical, intent(out) :: taken !! it is
    end subroutine form_take

    !> The contact elements of a saved state: the order of elimination is that of its run.
    subroutine form_couple_saved(model, system, form, targets)
      import :: model_t, system_t, form_t
      implicit none
      type(model_t), intent(in) :: model !! pairs
      type(system_t), intent(inout) :: system !! gets contact elements, pattern
      type(form_t), intent(inout) :: form !! gets the pattern
      integer, intent(in) :: targets(:) !! (contact elements) facets when the pattern was built
    end subroutine form_couple_saved

    !> Internal forces of the bulk at u, or at the trial, as far as the residual wants them.
    subroutine form_bulk(system, form, x)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the iterate
      type(form_t), intent(inout) :: form !! its matrix
      real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    end subroutine form_bulk

    !> Puts the trial at u + length du.
    subroutine form_place(system, form, length)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! u given
      type(form_t), intent(inout) :: form !! du given; gets trial
      real(wp), intent(in) :: length !! share of du
    end subroutine form_place

    !> Moves the iterate to u + length du.
    subroutine form_length(form, length, u, tools)
      import :: form_t, rigid_part_t, wp
      implicit none
      type(form_t), intent(inout) :: form !! the trial
      real(wp), intent(in) :: length !! share of du
      real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
      type(rigid_part_t), intent(inout) :: tools !! rigid bodies, which go with it
    end subroutine form_length

    !> Right-hand side: forces out of balance.
    subroutine form_gather(system, form, length, tried)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! forces given
      type(form_t), intent(inout) :: form !! gets right
      real(wp), intent(in) :: length !! share of the direction
      logical, intent(in) :: tried !! forces are those of the trial
    end subroutine form_gather

    !> Tangent, factor, direction.
    subroutine form_direct(system, form, x, outcome)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(inout) :: system !! forces, tangents of contact
      type(form_t), intent(inout) :: form !! right, wish given; gets solution, du
      real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
      integer, intent(out) :: outcome !! one of the outcomes of back_ends
    end subroutine form_direct

    !> The direction that the factor at hand gives for the present residual.
    subroutine form_repeat(system, form, found)
      import :: system_t, form_t
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(inout) :: form !! right given; gets solution, du
      logical, intent(out) :: found !! there is one
    end subroutine form_repeat

    !> After an iteration its tangent may serve for more steps.
    pure logical function form_may(system, form, start, linearised)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(in) :: form !! its tangent
      real(wp), intent(in) :: start !! residual before that iteration [force]
      logical, intent(in) :: linearised !! its tangent was the bulk's of the last state
    end function form_may

    !> repeats_by_iteration: a direction by the factor at hand costs about as much as a new tangent;
    !! repeats_while_promising: it is tried again while each leaves little alone.
    pure logical function form_ask(form)
      import :: form_t
      implicit none
      type(form_t), intent(in) :: form !! its tangent at hand
    end function form_ask

    !> What a step has left is judged, by a form whose factors may be too old.
    subroutine form_judge(system, form, start, length)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(inout) :: form !! residual after the step
      real(wp), intent(in) :: start !! norm of the residual before it [force]
      real(wp), intent(in) :: length !! share of its direction that it went
    end subroutine form_judge

    !> The same after a step with the factor at hand.
    subroutine form_left(form, left)
      import :: form_t, wp
      implicit none
      type(form_t), intent(inout) :: form !! its memory of it
      real(wp), intent(in) :: left !! share of the residual that it has left
    end subroutine form_left

    !> residual_norm, largest_resultant (of a floating body), damping_norm [force]; direction_norm
    !! [length]; direction_work (of the residual on the direction) [force length].
    pure real(wp) function form_number(system, form)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(in) :: form !! residual and direction
    end function form_number

    !> Energy of the change of force on what displacements lack [force length].
    pure real(wp) function form_own(form)
      import :: form_t, wp
      implicit none
      type(form_t), intent(in) :: form !! direction given
    end function form_own

    !> Of the direction that the factor at hand gives for the residual of the trial: its length, or
    !! the work of the residual on it.
    real(wp) function form_next(system, form)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(inout) :: form !! right of the trial given; next is used
    end function form_next

    !> Norm of the terms that the residual sums, but for those of contact.
    subroutine form_terms(system, form, terms)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! u given
      type(form_t), intent(inout) :: form !! trial is used
      real(wp), intent(out) :: terms !! [force]
    end subroutine form_terms

    !> The node and dof with the largest residual, 0 if no dof is free.
    pure subroutine form_worst(system, form, node, dof, value)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! its equations
      type(form_t), intent(in) :: form !! right given
      integer, intent(out) :: node, dof !! where
      real(wp), intent(out) :: value !! the residual there [force]
    end subroutine form_worst

    !> Resultant of the residual on a floating body: force, and moment over the size of its motions;
    !! null: it is the sum over its nodes.
    pure function form_resultant(system, form, body) result(force)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! its bodies
      type(form_t), intent(in) :: form !! right given
      integer, intent(in) :: body !! the body
      real(wp) :: force(6)
    end function form_resultant

    !> The nodes whose displacement is that of the iterate; null: all.
    pure subroutine form_mask(form, placed)
      import :: form_t
      implicit none
      type(form_t), intent(in) :: form !! which nodes it follows
      logical, intent(out) :: placed(:) !! (nodes)
    end subroutine form_mask

    !> Displacements that forces bring by themselves, with the tangent at hand.
    subroutine form_answer(system, form, force, du)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(inout) :: form !! tangent at hand; next is used
      real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
      real(wp), intent(out) :: du(:, :) !! (3, nodes) [length]
    end subroutine form_answer

    !> The direction becomes that of the residual with forces that come beside it.
    subroutine form_push(system, form, force)
      import :: system_t, form_t, wp
      implicit none
      type(system_t), intent(in) :: system !! the problem
      type(form_t), intent(inout) :: form !! tangent at hand; gets solution, du
      real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    end subroutine form_push

    !> The iterate has converged: displacements that are wanted of it, and what the form keeps.
    subroutine form_accept(model, system, form, inside_due, known, whole)
      import :: model_t, system_t, form_t
      implicit none
      type(model_t), intent(in) :: model !! output requests
      type(system_t), intent(inout) :: system !! converged
      type(form_t), intent(inout) :: form !! what it keeps from state to state
      logical, intent(in) :: inside_due !! displacements inside are asked for
      logical, intent(in) :: known !! they are known
      logical, intent(out) :: whole !! they are those of the state; else sums stand in for them
    end subroutine form_accept
  end interface
end module system_types
