!> Whether each body is in balance, beyond what round-off makes (doc/theory, "Balance", eq. (13.1)).
module balance_audit
  use kinds, only: wp, machine_epsilon
  use vectors, only: norm_of, largest_of
  use cells, only: corners_of
  use solution_settings, only: tol_energy, tol_residual
  use element_types, only: routine_none, routine_finite
  use element_parameters, only: d03_epsilon
  use model_types, only: model_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use condensed_types, only: condensed_t
  use element_lists, only: bulk_list_t, element_list_t
  use audit_types, only: audit_t, verdict_ok, verdict_failed, check_balance
  implicit none
  private
  public :: judge_balance

  !> What a body's balance may lack over the force scale; with AUGMent, whose multipliers converge
  !! by themselves; and over the residual that was asked for.
  real(wp), parameter :: balance_tolerance = 1.0e-8_wp
  real(wp), parameter :: augmented_tolerance = 1.0e-6_wp
  real(wp), parameter :: over_asked = 10.0_wp
  !> The relative residual that goes with an energy tolerance v is this times sqrt(v).
  real(wp), parameter :: residual_share = 1.0e-3_wp
  !> The sums of a body are round-off below this many times the estimate for the residual.
  real(wp), parameter :: sum_noise_factor = 128.0_wp
  !> Round-off beyond this share of the forces is none, unless strains are below the second number.
  real(wp), parameter :: most_round_off = 1.0e-4_wp, no_strain = 1.0e-12_wp
  !> Displacements beyond this many sizes of the model, and beyond what is prescribed, are none.
  real(wp), parameter :: most_sizes = 10.0_wp
  !> A place is rounded off to this many times machine epsilon of how far it is from the origin.
  real(wp), parameter :: edge_noise = 4.0_wp

contains

  !> Whether each body is in balance.
  subroutine judge_balance(model, system, form, state, settings, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! forces as accepted
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(state_t), intent(in) :: state !! the converged state
    type(settings_t), intent(in) :: settings !! tolerances asked for
    type(audit_t), intent(inout) :: audit !! balance given; gets scale, allowed,
    !! lacking, its verdict
    real(wp) :: now, sane, lack, noise, least, allowed, strain(system%body%bodies)
    integer :: b, i
    logical :: failed

    now = norm2([norm_of(system%loads%external), norm_of(state%reaction), &
      norm_of(system%contact_force)])
    sane = sane_share(audit, system%equation, state%u)
    audit%scale = max(norm_of(system%loads%external), audit%sum%force_before)
    if (sane >= 1.0_wp) audit%scale = max(audit%scale, now)
    audit%sum%force_before = audit%scale
    if (sane >= 1.0_wp) audit%sum%force_before = now
    noise = sum_noise_factor*(sane*system%scale%round_off + place_noise(system%contact, &
      audit%fixed%model_size) &
      + machine_epsilon*stiffest(model)*audit%fixed%model_size*sane*largest_of(state%u))
    audit%noise = noise
    ! round-off below what is allowed in any case asks for no strains
    strain = 0.0_wp
    if (noise > tolerance(model, settings)*audit%scale) call find_strains(model%mesh%x, system, &
      form, state, strain)
    audit%worst(check_balance) = 0
    audit%component = 0
    audit%lacking = 0.0_wp
    audit%asked = tolerance(model, settings)*audit%scale
    audit%allowed = audit%asked
    failed = .false.
    do b = 1, system%body%bodies
      least = no_strain*system%scale%stiffest*audit%fixed%model_size
      ! where something is strained its forces are there, whatever stiffer material is about
      if (strain(b) > no_strain) least = min(least, audit%scale*(no_strain/strain(b)))
      allowed = max(tolerance(model, settings)*audit%scale, min(noise, &
        max(most_round_off*audit%scale, least)))
      if (b == 1) audit%allowed = allowed
      do i = 1, 6
        lack = abs(audit%balance(i, b))
        if (i > 3) lack = lack/max(audit%fixed%reach(b), tiny(1.0_wp))
        if (failed .and. lack <= allowed) cycle
        if ((failed .or. lack <= allowed) .and. lack <= audit%lacking) cycle
        failed = .not. lack <= allowed
        audit%lacking = lack
        audit%allowed = allowed
        audit%component = i
        audit%worst(check_balance) = b
      end do
    end do
    audit%value(check_balance) = 0.0_wp
    if (audit%scale > 0.0_wp) audit%value(check_balance) = audit%lacking/audit%scale
    audit%verdict(check_balance) = merge(verdict_ok, verdict_failed, audit%lacking <= audit%allowed)
  end subroutine judge_balance

  !> Largest strain of an edge of each body, beyond what round-off of places makes of it. A body
  !! that loads or contact act on carries what makes the strains of others: it counts as strained as
  !! the most strained one.
  pure subroutine find_strains(x, system, form, state, strain)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! elements, loads, contact forces
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(state_t), intent(in) :: state !! displacements
    real(wp), intent(out) :: strain(:) !! (bodies) largest magnitude, 0 where there is none
    real(wp) :: most, noise
    logical :: loaded(0:size(strain))
    integer :: i, k

    noise = edge_noise*machine_epsilon*(maxval(abs(state%u)) + maxval(abs(x)))
    strain = 0.0_wp
    do k = 1, system%bulk%n
      if (system%bulk%routine(k) == routine_none) cycle
      associate (body => system%body%node_body(system%bulk%ix(1, k)))
        if (body > 0) strain(body) = max(strain(body), element_strain(x, system%bulk, &
          form%condensed, state, k, noise))
      end associate
    end do
    loaded = .false.
    do i = 1, size(system%body%node_body)
      if (any(abs(system%loads%external(:, i)) > 0.0_wp .or. abs(system%contact_force(:, i)) &
        > 0.0_wp)) loaded(system%body%node_body(i)) = .true.
    end do
    most = maxval(strain)
    where (loaded(1:)) strain = most
  end subroutine find_strains

  !> Largest strain of the edges between the corners of an element, Green's where strain is finite.
  !! Where displacements inside are not known those of the candidates of contact are.
  pure real(wp) function element_strain(x, bulk, condensed, state, k, noise) result(strain)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(state_t), intent(in) :: state !! displacements
    integer, intent(in) :: k !! the element
    real(wp), intent(in) :: noise !! round-off of a place [length]
    real(wp) :: edge(3), change(3), squared, longer
    integer :: i, j

    strain = 0.0_wp
    associate (node => corners_of(bulk%ix(:, k)))
      if (.not. state%whole) then
        if (count(condensed%candidate(node)) < 2) return
      end if
      do i = 1, size(node) - 1
        do j = i + 1, size(node)
          if (.not. state%whole) then
            if (.not. all(condensed%candidate(node([i, j])))) cycle
          end if
          edge = x(:, node(j)) - x(:, node(i))
          change = state%u(:, node(j)) - state%u(:, node(i))
          squared = dot_product(edge, edge)
          if (squared <= 0.0_wp) cycle
          longer = dot_product(edge, change)
          if (bulk%routine(k) == routine_finite) longer = longer + 0.5_wp*dot_product( &
            change, change)
          strain = max(strain, (abs(longer) - noise*(sqrt(squared) + norm2(change)))/squared)
        end do
      end do
    end associate
  end function element_strain

  !> Largest Young's modulus of what deforms.
  pure real(wp) function stiffest(model)
    type(model_t), intent(in) :: model !! materials
    integer :: m

    stiffest = 0.0_wp
    do m = 1, size(model%materials)
      if (.not. model%materials(m)%rigid) stiffest = max(stiffest, &
        model%materials(m)%youngs_modulus)
    end do
  end function stiffest

  !> What the round-off of a place within the model makes of a gap, as a force of its penalty.
  pure real(wp) function place_noise(contact, model_size) result(noise)
    type(element_list_t), intent(in) :: contact !! contact elements
    real(wp), intent(in) :: model_size !! diagonal of the box around all nodes [length]
    integer :: k

    noise = 0.0_wp
    do k = 1, contact%n
      if (contact%routine(k) /= routine_none) noise = max(noise, contact%d(d03_epsilon, k))
    end do
    noise = machine_epsilon*model_size*noise
  end function place_noise

  !> What the balance of a body may lack over the force scale.
  pure real(wp) function tolerance(model, settings)
    type(model_t), intent(in) :: model !! pairs
    type(settings_t), intent(in) :: settings !! tolerances asked for
    real(wp) :: asked

    asked = residual_share*sqrt(settings%asked(tol_energy))
    if (settings%asked(tol_residual) > 0.0_wp) asked = settings%asked(tol_residual)
    tolerance = balance_tolerance
    if (any(model%pairs%augmented)) tolerance = augmented_tolerance
    tolerance = max(tolerance, over_asked*asked)
  end function tolerance

  !> 1 where no displacement is larger than most_sizes of the model beyond what is prescribed, else
  !! the share that this would be: a body that has flown away makes no round-off and no scale.
  pure real(wp) function sane_share(audit, equation, u) result(share)
    type(audit_t), intent(in) :: audit !! size of the model
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp) :: most, allowed
    integer :: i, k

    share = 1.0_wp
    most = largest_of(u)
    if (most <= most_sizes*audit%fixed%model_size) return
    allowed = 0.0_wp
    do i = 1, size(u, 2)
      do k = 1, 3
        if (equation(k, i) == 0) allowed = max(allowed, abs(u(k, i)))
      end do
    end do
    allowed = allowed + most_sizes*audit%fixed%model_size
    if (most > allowed) share = allowed/most
  end function sane_share
end module balance_audit
