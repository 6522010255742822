!> What small strain cannot mean ends a variant of a study, as it ends a run (doc/theory, "Strain
!! and rotation"). Variants are not audited otherwise.
module variant_limits
  use kinds, only: wp, pi
  use errors, only: error_t, raise, exit_no_convergence
  use model_types, only: model_t
  use body_measures, only: rigid_turns, farthest_turn, has_finite_strain
  use body_volumes, only: find_volumes
  use shape_audit, only: most_swelling
  use audit_types, only: audit_t, verdict_failed, check_turning, check_volume
  use audit_text, only: shape_message
  use condensed_system, only: recover_interior
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: check_shapes

  !> A volume can have changed by too much if nodes of a body have come nearer to each other, or
  !! gone farther apart, by this share of its mean thickness; it takes a third of a tenth.
  real(wp), parameter :: worth_a_look = 0.03_wp

contains

  !> Turns and volumes of the bodies of small strain at an end time. On shared factors only the
  !! candidates of contact are known: displacements inside are found where these have gone far.
  subroutine check_shapes(model, system, form, state, before, error)
    type(model_t), intent(in) :: model !! the variant
    type(system_t), intent(inout) :: system !! as accepted; left as it was
    type(form_t), intent(inout) :: form !! matrix given; gets condensed, du
    type(state_t), intent(in) :: state !! its state
    real(wp), intent(in) :: before !! the last end time that was right
    type(error_t), allocatable, intent(out) :: error !! a body has left small strain
    type(audit_t) :: audit
    logical :: known(size(system%body%node_body)), surface_only
    real(wp), allocatable :: u(:, :), force(:, :)
    real(wp) :: rest(system%body%bodies)

    if (system%body%bodies == 0) return
    audit%time = state%time
    call find_volumes(model%mesh%x, system, rest)
    known = .true.
    surface_only = form%condensed%surface_only
    if (surface_only) known = form%condensed%candidate(:size(known)) .or. &
      all(system%equation == 0, 1)
    call judge_turn(model, system, known, rest, audit)
    if (surface_only) then
      if (may_have_swollen(model, system, known, rest)) then
        u = system%u
        force = form%inner%bulk_force
        form%condensed%surface_only = .false.
        call recover_interior(system, form)
        call judge_volume(model, system, rest, audit)
        form%condensed%surface_only = .true.
        system%u = u
        form%inner%bulk_force = force
      end if
    else
      call judge_volume(model, system, rest, audit)
    end if
    if (any(audit%verdict == verdict_failed)) call raise(error, exit_no_convergence, &
      shape_message(model, system, audit, before))
  end subroutine check_shapes

  !> A body of small strain has turned too far, by its nodes that are known.
  subroutine judge_turn(model, system, known, rest, audit)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! displacements
    logical, intent(in) :: known(:) !! (nodes) whose displacements are known
    real(wp), intent(in) :: rest(:) !! (bodies) volumes that small strain deforms [length^3]
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict of the turning
    real(wp), dimension(3, size(rest)) :: turn, same
    logical :: finite(0:size(rest)), judged(size(rest))
    integer :: b

    finite = has_finite_strain(system)
    judged = abs(rest) > 0.0_wp .and. .not. finite(1:)
    if (.not. any(judged)) return
    call rigid_turns(model%mesh%x, system%u, system%u, system%body%node_body, known, turn, same)
    b = maxloc(norm2(turn, 1), 1, judged)
    if (norm2(turn(:, b)) <= sin(farthest_turn)) return
    audit%worst(check_turning) = b
    audit%value(check_turning) = asin(min(1.0_wp, norm2(turn(:, b))))*180.0_wp/pi
    audit%verdict(check_turning) = verdict_failed
  end subroutine judge_turn

  !> The volume of a body has changed by too much.
  subroutine judge_volume(model, system, rest, audit)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! displacements of all nodes
    real(wp), intent(in) :: rest(:) !! (bodies) volumes that small strain deforms [length^3]
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict of the volume
    real(wp) :: change(size(rest))
    integer :: b

    call find_volumes(model%mesh%x + system%u(:, :model%mesh%nodes), system, change)
    change = change - rest
    where (abs(rest) > 0.0_wp) change = change/rest
    b = maxloc(abs(change), 1)
    if (abs(change(b)) <= most_swelling) return
    audit%worst(check_volume) = b
    audit%value(check_volume) = change(b)
    audit%verdict(check_volume) = verdict_failed
  end subroutine judge_volume

  !> Known nodes of a body have moved against each other by a share of its thickness, that is its
  !! volume over the largest side of the box around it.
  pure logical function may_have_swollen(model, system, known, rest) result(may)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! displacements
    logical, intent(in) :: known(:) !! (nodes) whose displacements are known
    real(wp), intent(in) :: rest(:) !! (bodies) volumes that small strain deforms [length^3]
    real(wp), dimension(3, 0:size(rest)) :: low, high, least, most
    real(wp) :: side(3)
    integer :: i, b

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    least = huge(1.0_wp)
    most = -huge(1.0_wp)
    do i = 1, size(known)
      b = system%body%node_body(i)
      low(:, b) = min(low(:, b), model%mesh%x(:, i))
      high(:, b) = max(high(:, b), model%mesh%x(:, i))
      if (.not. known(i)) cycle
      least(:, b) = min(least(:, b), system%u(:, i))
      most(:, b) = max(most(:, b), system%u(:, i))
    end do
    may = .false.
    do b = 1, size(rest)
      if (abs(rest(b)) <= 0.0_wp) cycle
      side = high(:, b) - low(:, b)
      if (maxval(most(:, b) - least(:, b))*maxval([side(1)*side(2), side(2)*side(3), &
        side(3)*side(1)]) > worth_a_look*abs(rest(b))) may = .true.
    end do
  end function may_have_swollen
end module variant_limits
