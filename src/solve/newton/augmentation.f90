!> Augmented Lagrangian: multipliers take over the contact forces from the penalty, until the gaps
!! that a force needs are closed (doc/theory, "Uzawa iteration", eq. (7.8)).
module augmentation
  use kinds, only: wp
  use text, only: to_text, count_noun
  use element_types, only: task_stress, n_element_stress, status_open
  use model_types, only: model_t
  use contact_types, only: pair_t, forget_moves
  use contact_parameters, only: shifts_gap, has_field
  use contact_points, only: count_points
  use element_lists, only: master_nodes
  use facet_geometry, only: facet_frame, facet_size
  use assembly, only: recover
  use point_forces, only: measure_field
  use monitors, only: monitor_t
  use system_types, only: system_t
  implicit none
  private
  public :: augmentation_t, check_gaps, update_multipliers

  !> A force that changes by less than this many times the round-off of the residual stays.
  real(wp), parameter :: round_off_factor = 8.0_wp
  !> If an update leaves more than this of the change before it, the penalty is raised.
  real(wp), parameter :: fast = 0.03_wp
  !> A raised penalty is tenfold,
  real(wp), parameter :: raise_by = 10.0_wp
  !> and within these multiples of E/h; where that is unknown, the deck's penalty counts as the
  !! lower of them.
  real(wp), parameter :: least_raised = 10.0_wp
  real(wp), parameter :: most_raised = 1.0e4_wp

  !> Multipliers that stand in for a stiff penalty are done when no force changes by more than this
  !! of the largest.
  real(wp), parameter :: softened_tolerance = 1.0e-11_wp

  !> Fields of multipliers are done when no force changes by more than this times the tolerance of
  !! the largest: what is left then is the direction of friction where hardly anything slips.
  real(wp), parameter :: field_factor = 100.0_wp

  !> Joints that stick in a ring may want more closed than forces can do something about. Gaps below
  !! this of a facet,
  real(wp), parameter :: ring_gap = 1.0e-10_wp
  !> which leave this of the change of a force
  real(wp), parameter :: ring_rate = 0.95_wp
  !> in as many updates one after the other, are closed.
  integer, parameter :: ring_updates = 4

  !> How far the multipliers of an increment are.
  type :: augmentation_t
    integer :: updates = 0 !! made so far
    logical :: gentle = .false. !! no penalty is raised
    logical :: closed = .false. !! every pair meets its tolerance
    real(wp), allocatable :: gap(:) !! (pairs) largest gap of a closed point over its facet's size
    real(wp), allocatable :: change(:) !! (pairs) largest difference of force and multiplier [force]
    real(wp), allocatable :: before(:) !! (pairs) the same one update ago, 0 if there is none
    integer, allocatable :: idle(:) !! (pairs) updates on end that leave what the forces lack
    real(wp), allocatable :: force(:) !! (pairs) largest force of a point [force]
    real(wp), allocatable :: stress(:, :) !! (n_element_stress, points) state of the points
    real(wp), allocatable :: multiplier(:, :) !! (3, points) the next one of fields [force]
  end type augmentation_t

contains

  !> Measures what the multipliers still leave to the penalty.
  subroutine check_gaps(model, system, augmentation, monitor)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! converged with the present multipliers
    type(augmentation_t), intent(inout) :: augmentation !! gets gap, change, force, closed
    class(monitor_t), intent(inout) :: monitor !! hears of it
    integer :: k
    logical :: closed

    if (augmentation%updates == 0) call begin(size(model%pairs), system%contact%n, augmentation)
    call recover(system%contact, task_stress, model%mesh%x, system%u, augmentation%stress)
    augmentation%closed = .true.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (.not. shifts_gap(pair)) cycle
        if (has_field(pair)) then
          call measure_facets(model, system, k, augmentation)
        else
          call measure_pair(model, system, k, augmentation)
        end if
        closed = pair%history%softened .or. augmentation%gap(k) <= pair%augment_tolerance
        closed = closed .and. augmentation%change(k) <= &
          max(round_off_factor*system%scale%round_off, augmentation%force(k)*force_tolerance(pair))
        call count_idle(k, augmentation)
        call monitor%detail('  pair '//pair%name//': '//count_noun(augmentation%updates, 'update') &
          //', gap '//to_text(augmentation%gap(k), 3)//' of a facet, force changes by ' &
          //to_text(augmentation%change(k), 3)//' of '//to_text(augmentation%force(k), 3))
        if (has_field(pair) .and. augmentation%force(k) > 0.0_wp) closed = closed .and. &
          pair%history%raise >= 1.0_wp
        if (.not. closed .and. augmentation%idle(k) >= ring_updates) then
          closed = .true.
          call monitor%detail('  pair '//pair%name//': its gaps are closed, and forces that'// &
            ' hold each other in a ring of joints that stick would go on: they stay')
        end if
        augmentation%closed = augmentation%closed .and. closed
      end associate
    end do
  end subroutine check_gaps

  !> Counts updates after which the forces of a pair lack as much as before them.
  pure subroutine count_idle(k, augmentation)
    integer, intent(in) :: k !! the pair
    type(augmentation_t), intent(inout) :: augmentation !! measured; gets idle

    augmentation%idle(k) = augmentation%idle(k) + 1
    if (augmentation%gap(k) > ring_gap .or. augmentation%before(k) <= 0.0_wp .or. &
        augmentation%change(k) < ring_rate*augmentation%before(k)) augmentation%idle(k) = 0
  end subroutine count_idle

  !> How far the forces of a pair may still be on their way, over the largest.
  pure real(wp) function force_tolerance(pair) result(tolerance)
    type(pair_t), intent(in) :: pair !! the pair

    tolerance = pair%augment_tolerance
    if (pair%history%softened) tolerance = softened_tolerance
    if (has_field(pair)) tolerance = field_factor*tolerance
  end function force_tolerance

  !> Room for the measures of an increment.
  pure subroutine begin(pairs, points, augmentation)
    integer, intent(in) :: pairs !! number of pairs
    integer, intent(in) :: points !! number of contact points
    type(augmentation_t), intent(inout) :: augmentation !! gets its arrays

    allocate (augmentation%gap(pairs), augmentation%change(pairs), augmentation%before(pairs), &
              augmentation%force(pairs), source=0.0_wp)
    allocate (augmentation%idle(pairs), source=0)
    allocate (augmentation%stress(n_element_stress, points), &
              augmentation%multiplier(3, points), source=0.0_wp)
  end subroutine begin

  !> Largest gap, force, and difference of force and multiplier of one pair.
  pure subroutine measure_pair(model, system, k, augmentation)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the pair
    type(augmentation_t), intent(inout) :: augmentation !! stress given; gets gap, change, force
    real(wp) :: gap, change, force
    integer :: p, element

    gap = 0.0_wp
    change = 0.0_wp
    force = 0.0_wp
    do p = 1, count_points(model%pairs(k))
      element = system%place%first_point(k) + p - 1
      associate (lambda => model%pairs(k)%history%new(p)%lambda, &
        stress => augmentation%stress(:, element))
        if (system%contact%status(element) <= status_open) then
          change = max(change, norm2(lambda))
        else
          change = max(change, norm2(force_in_facet(model, system, element, stress(1:3)) - lambda))
          force = max(force, norm2(stress(1:3)))
          gap = max(gap, max(abs(stress(4)), stress(5))/facet_size(model%mesh%x(:, &
            master_nodes(system%contact, element))))
        end if
      end associate
    end do
    augmentation%gap(k) = gap
    augmentation%change(k) = change
    augmentation%force(k) = force
  end subroutine measure_pair

  !> The same of a pair whose multipliers are a field, and its next multipliers.
  pure subroutine measure_facets(model, system, k, augmentation)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the pair
    type(augmentation_t), intent(inout) :: augmentation !! stress given; gets gap, change, force

    associate (first => system%place%first_point(k), last => system%place%first_point(k + 1) - 1)
      call measure_field(model, system, k, augmentation%stress(:, first:last), &
        augmentation%multiplier(:, first:last), augmentation%gap(k), augmentation%change(k), &
        augmentation%force(k))
    end associate
  end subroutine measure_facets

  !> A contact force in the frame of its facet.
  pure function force_in_facet(model, system, element, force) result(f)
    type(model_t), intent(in) :: model !! the mesh
    type(system_t), intent(in) :: system !! contact elements and u
    integer, intent(in) :: element !! a contact element
    real(wp), intent(in) :: force(3) !! in global axes [force]
    real(wp) :: f(3)

    associate (nodes => master_nodes(system%contact, element))
      f = matmul(force, facet_frame(model%mesh%x(:, nodes) + system%u(:, nodes)))
    end associate
  end function force_in_facet

  !> The multipliers become the forces; the penalty of a pair that comes along slowly is raised.
  subroutine update_multipliers(model, system, augmentation, monitor)
    type(model_t), intent(inout) :: model !! pairs: multipliers of the working points, raise
    type(system_t), intent(in) :: system !! contact elements
    type(augmentation_t), intent(inout) :: augmentation !! measured; counts on
    class(monitor_t), intent(inout) :: monitor !! hears of a raised penalty
    integer :: k

    do k = 1, size(model%pairs)
      if (shifts_gap(model%pairs(k)) .and. .not. has_field(model%pairs(k))) &
        call take_point_forces(model, system, k, augmentation)
    end do
    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      associate (first => system%place%first_point(k), last => system%place%first_point(k + 1) - 1)
        call give_multipliers(augmentation%multiplier(:, first:last), model%pairs(k))
      end associate
      if (has_field(model%pairs(k))) then
        call use_own_penalty(model%pairs(k))
      else if (.not. augmentation%gentle) then
        call raise_penalty(augmentation%change(k), augmentation%before(k), model%pairs(k), monitor)
      end if
    end do
    augmentation%before = augmentation%change
    augmentation%updates = augmentation%updates + 1
  end subroutine update_multipliers

  !> The next multipliers of a pair without fields: the forces of its points.
  pure subroutine take_point_forces(model, system, k, augmentation)
    type(model_t), intent(in) :: model !! the mesh
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the pair
    type(augmentation_t), intent(inout) :: augmentation !! stress given; gets multiplier
    integer :: element

    do element = system%place%first_point(k), system%place%first_point(k + 1) - 1
      augmentation%multiplier(:, element) = 0.0_wp
      if (system%contact%status(element) > status_open) augmentation%multiplier(:, element) = &
        force_in_facet(model, system, element, augmentation%stress(1:3, element))
    end do
  end subroutine take_point_forces

  !> The multipliers of the points of a pair become these.
  pure subroutine give_multipliers(lambda, pair)
    real(wp), intent(in) :: lambda(:, :) !! (3, points) [force]
    type(pair_t), intent(inout) :: pair !! gets them
    integer :: p

    do p = 1, size(lambda, 2)
      pair%history%new(p)%lambda = lambda(:, p)
    end do
  end subroutine give_multipliers

  !> After the first update the penalty is that of the fields; targets chosen with a softer one may
  !! be left again for those they come from.
  pure subroutine use_own_penalty(pair)
    type(pair_t), intent(inout) :: pair !! gets raise; forgets the targets its points have left

    if (pair%history%raise >= 1.0_wp) return
    pair%history%raise = 1.0_wp
    call forget_moves(pair)
  end subroutine use_own_penalty

  !> Raises the penalty where the last update has left too much of the change before, or is the
  !! first. Targets chosen with a soft penalty may be left again for those they come from.
  subroutine raise_penalty(change, before, pair, monitor)
    real(wp), intent(in) :: change !! largest change of a force [force]
    real(wp), intent(in) :: before !! the same one update ago, 0 if there is none [force]
    type(pair_t), intent(inout) :: pair !! gets raise; forgets the targets its points have left
    class(monitor_t), intent(inout) :: monitor !! hears of it
    real(wp) :: relative, raise

    if (change <= fast*before) return
    relative = pair%points%relative
    if (relative <= 0.0_wp) relative = least_raised
    raise = max(raise_by*pair%history%raise, least_raised/relative)
    raise = min(raise, most_raised/relative)
    if (pair%history%softened) raise = min(raise, 1.0_wp)
    if (raise <= pair%history%raise) return
    pair%history%raise = raise
    call forget_moves(pair)
    call monitor%detail('  pair '//pair%name//': penalty '//to_text(raise, 3)//' times its value')
  end subroutine raise_penalty
end module augmentation
