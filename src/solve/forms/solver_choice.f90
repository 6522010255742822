!> The one place that decides how a scene is solved, and says what and why (doc/theory, "Choice of
!! the solver").
module solver_choice
  use kinds, only: wp
  use text, only: count_noun, to_text
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_parameters, only: has_multipliers
  use friction_return, only: has_friction
  use monitors, only: monitor_t
  use ranks, only: count_ranks
  use linear_solver, only: solver_words, take_choice
  use back_ends, only: solver_unknown, solver_auto, solver_cholmod, solver_petsc, solver_reduced
  use bulk_term, only: take_bulk_back
  use form_choice, only: take_form, take_full_form
  use condensed_system, only: start_condensed
  use tree_compliance, only: has_trees
  use system_types, only: form_t, system_t
  use system_parts, only: whole_form_t
  implicit none
  private
  public :: scene_t, ask_for_solver, choose_solver, foresee_choice, decide, decline_condensed, &
    retry_condensed

  !> What of a scene matters to the choice.
  type :: scene_t
    logical :: contact = .false. !! there is a contact point
    logical :: friction = .false. !! one of them with friction
    logical :: linear_bulk = .true. !! the bulk's tangent is constant
    logical :: restrained = .true. !! supports alone hold each body
    logical :: rigid_unknowns = .false. !! a rigid body has free motions
    logical :: bonded = .false. !! elastic elements share nodes of such a body
    logical :: multipliers = .false. !! a pair has multipliers
    logical :: declined = .false. !! its condensed form cannot be had, or would cost more
    logical :: trees = .false. !! the factor of a body stands in for its dense compliance
    integer :: ranks = 1 !! processes that work on it
    integer :: dofs = 0 !! free degrees of freedom
    integer :: contact_dofs = 0 !! of them on surfaces of contact pairs
    real(wp) :: dense_share = 0.0_wp !! estimated cost of dense systems over that of sparse factors,
    !! 0 if it is not known
  end type scene_t

contains

  !> SOLVer: the next increment is solved by what it asks for, unless --solver is there.
  subroutine ask_for_solver(whole, asked)
    type(whole_form_t), intent(inout) :: whole !! gets asked; the choice is open
    integer, intent(in) :: asked !! one of the solvers of linear_solver

    integer :: new

    new = asked
    if (whole%forced /= solver_unknown) new = whole%forced
    if (whole%asked /= new) whole%choice = solver_unknown
    whole%asked = new
  end subroutine ask_for_solver

  !> Decides once for each SOLVer, before an increment, and tells the log.
  subroutine choose_solver(model, system, form, monitor)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets choice
    class(monitor_t), intent(inout) :: monitor !! hears of it
    character(:), allocatable :: reason, obstacle
    type(scene_t) :: scene
    logical :: condensed

    if (form%whole%choice /= solver_unknown) return
    if (any(model%pairs%mortar)) form%whole%asked = solver_reduced
    scene = look_at(model, system, form%whole)
    call decide(scene, form%whole%asked, form%whole%choice, reason)
    call take_bulk_back(model%mesh%x, system, form)
    condensed = form%condensed%active .or. form%condensed%preconditions
    if (form%whole%choice == solver_reduced .and. .not. condensed) then
      call start_condensed(model, system, form, form%whole%asked == solver_auto, obstacle, &
        scene%dense_share)
      call take_form(form)
      if (len(obstacle) > 0) then
        if (index(obstacle, 'would cost') > 0) then
          call monitor%event('  REDUced is not taken, '//obstacle)
        else
          call monitor%warning('REDUced cannot be had, '//obstacle)
        end if
        scene%declined = .true.
      end if
      if (len(obstacle) == 0) scene%trees = has_trees(form%condensed)
      call decide(scene, form%whole%asked, form%whole%choice, reason)
    else if (form%whole%choice /= solver_reduced .and. condensed) then
      call take_full_form(form)
    end if
    call take_choice(form%whole%solver, form%whole%choice)
    call monitor%event(reason)
  end subroutine choose_solver

  !> What will be taken as far as is known before anything is factorised.
  integer function foresee_choice(model, system, form) result(choice)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! built
    type(form_t), intent(in) :: form !! matrix
    integer :: asked
    character(:), allocatable :: reason

    asked = form%whole%forced
    if (asked == solver_unknown) asked = merge(solver_reduced, form%whole%asked, &
      any(model%pairs%mortar))
    call decide(look_at(model, system, form%whole), asked, choice, reason)
  end function foresee_choice

  !> AUTO takes the whole system where the condensed form has found no way (doc/theory, "Choice of
  !! the solver"). A study needs its factors.
  subroutine decline_condensed(whole_factors, whole, declined)
    logical, intent(in) :: whole_factors !! a study asks the factors after the run: none is shrunk
    type(whole_form_t), intent(inout) :: whole !! gets matrix
    logical, intent(out) :: declined !! there is another choice

    declined = whole%asked == solver_auto .and. whole%choice == solver_reduced .and. &
      .not. whole_factors
    if (.not. declined) return
    whole%declined = .true.
    whole%choice = solver_unknown
  end subroutine decline_condensed

  !> The next end time begins: the condensed form may serve again.
  subroutine retry_condensed(whole)
    type(whole_form_t), intent(inout) :: whole !! its choice is open again, if it was declined

    if (.not. whole%declined) return
    whole%declined = .false.
    whole%choice = solver_unknown
  end subroutine retry_condensed

  !> The facts of a scene.
  function look_at(model, system, whole) result(scene)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! equations and bodies
    type(whole_form_t), intent(in) :: whole !! matrix
    type(scene_t) :: scene
    logical :: on_surface(size(system%equation, 2))
    integer :: k

    scene%ranks = count_ranks()
    scene%declined = whole%declined
    scene%contact = system%contact%n > 0
    scene%linear_bulk = system%bulk%linear
    scene%restrained = .not. any(system%body%floating)
    scene%rigid_unknowns = system%tools%unknowns > 0
    if (scene%rigid_unknowns) scene%bonded = is_bonded(system)
    scene%multipliers = any(has_multipliers(model%pairs))
    scene%dofs = system%equations + system%tools%unknowns
    on_surface = .false.
    do k = 1, size(model%pairs)
      if (any(has_friction(model%pairs(k)%friction%mu))) scene%friction = .true.
      call mark_surfaces(model%pairs(k), on_surface)
    end do
    scene%contact_dofs = count(system%equation > 0 .and. spread(on_surface, 1, 3))
  end function look_at

  !> Elastic elements share nodes of a rigid body that is free to move.
  pure logical function is_bonded(system) result(bonded)
    type(system_t), intent(in) :: system !! equations, bodies, rigid bodies
    logical :: mixed(system%body%bodies)
    integer :: i

    mixed = .false.
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) > 0) mixed(system%body%node_body(i)) = &
        mixed(system%body%node_body(i)) .or. any(system%equation(:, i) > 0)
    end do
    bonded = any(mixed(pack(system%body%node_body, system%tools%carried_by > 0)))
  end function is_bonded

  !> Marks the slave nodes of a pair and the corners of its master facets.
  pure subroutine mark_surfaces(pair, on_surface)
    type(pair_t), intent(in) :: pair !! the pair
    logical, intent(inout) :: on_surface(:) !! (nodes)
    integer :: f, p

    do p = 1, size(pair%points%point_nodes, 2)
      on_surface(pair%points%point_nodes(:, p)) = .true.
    end do
    do f = 1, size(pair%surface%facets, 2)
      on_surface(pair%surface%facets(:, f)) = .true.
    end do
  end subroutine mark_surfaces

  !> What is taken for a scene, and the line that says so. A choice that cannot hold falls back to
  !! the next best.
  subroutine decide(scene, asked, choice, reason)
    type(scene_t), intent(in) :: scene !! the facts
    integer, intent(in) :: asked !! what SOLVer or --solver says
    integer, intent(out) :: choice !! one of the solvers, never AUTO
    character(:), allocatable, intent(out) :: reason !! one line
    character(:), allocatable :: obstacle

    reason = ''
    obstacle = obstacle_to_reduced(scene)
    choice = asked
    select case (asked)
    case (solver_auto)
      choice = solver_cholmod
      if (len(obstacle) == 0 .and. .not. scene%declined) choice = solver_reduced
      if (scene%ranks > 1) choice = solver_petsc
    case (solver_reduced)
      if (len(obstacle) > 0 .or. scene%declined) choice = solver_cholmod
      if (len(obstacle) > 0) reason = 'REDUced cannot be had, '//obstacle//'; instead '
    case default
      ! The back ends take every scene.
    end select
    reason = 'solver: '//reason//way_of(scene, choice)//' ('
    if (asked == solver_auto) then
      reason = reason//'AUTO; '
    else if (choice == asked) then
      reason = reason//'asked for; '
    else
      reason = reason//trim(solver_words(asked)%word)//' was asked for; '
    end if
    reason = reason//description(scene)//')'
  end subroutine decide

  !> Why a scene cannot be condensed to its contact forces; empty if it can.
  pure function obstacle_to_reduced(scene) result(obstacle)
    type(scene_t), intent(in) :: scene !! the facts
    character(:), allocatable :: obstacle

    obstacle = ''
    if (.not. scene%contact) then
      obstacle = 'there is no contact'
    else if (scene%rigid_unknowns .and. .not. scene%linear_bulk) then
      obstacle = 'the motion of a rigid body is free, and the bulk is not linear'
    else if (scene%rigid_unknowns .and. scene%multipliers) then
      obstacle = 'the motion of a rigid body is free, and a pair has multipliers'
    else if (scene%bonded) then
      obstacle = 'a rigid body whose motion is free has nodes of an elastic one'
    end if
  end function obstacle_to_reduced

  !> How a choice works on a scene.
  pure function way_of(scene, choice) result(way)
    type(scene_t), intent(in) :: scene !! the facts
    integer, intent(in) :: choice !! one of the solvers
    character(:), allocatable :: way

    way = trim(solver_words(choice)%way)
    select case (choice)
    case (solver_petsc)
      if (.not. scene%contact) way = 'PETSc, conjugate gradients on multigrid'
      if (scene%ranks > 1) way = way//', on '//to_text(scene%ranks)//' ranks'
    case (solver_reduced)
      if (scene%trees) way = way//'; large contact by products with the factors'
      if (.not. scene%linear_bulk) way = way//', with GMRES on the true tangent'
    case (solver_cholmod)
      if (scene%friction) way = way//', and UMFPACK where friction slips'
    end select
  end function way_of

  !> The facts in words.
  function description(scene) result(t)
    type(scene_t), intent(in) :: scene !! the facts
    character(:), allocatable :: t

    t = merge('linear bulk   ', 'nonlinear bulk', scene%linear_bulk)
    t = trim(t)//', '//count_noun(scene%dofs, 'free dof')
    if (scene%rigid_unknowns) t = t//', some of them of a rigid body'
    if (.not. scene%contact) then
      t = t//', no contact'
      return
    end if
    t = t//', contact with'
    if (.not. scene%friction) t = t//'out'
    t = t//' friction, '//to_text(scene%contact_dofs)//' of them on its surfaces'
    if (.not. scene%restrained) t = t//', a body held by contact alone'
    if (scene%dense_share > 0.0_wp) t = t//'; dense systems cost about '// &
      to_text(scene%dense_share, 2)//' of sparse factors'
  end function description
end module solver_choice
