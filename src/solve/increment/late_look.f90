!> The condensed form watches the nodes that contact was foreseen to touch. Where bodies bend or fly
!! farther than their supports carry them, others touch: what has converged is looked at once more
!! when the displacements of all nodes are known (doc/theory, "Static condensation").
module late_look
  use kinds, only: wp
  use model_types, only: model_t
  use contact_types, only: pair_t, point_history_t
  use contact_points, only: count_points
  use contact_apexes, only: touches
  use contact_targets, only: follow_apexes
  use contact_system, only: load_contact
  use condensed_types, only: seen_t, condensed_t
  use linear_sums, only: can_do_without
  use loads, only: load_factors
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use system_parts, only: positions_t
  use text, only: count_noun
  implicit none
  private
  public :: look_inside, has_flown

  !> A body that contact alone holds has flown, and a node has strayed, if it has moved by more than
  !! this share of a facet.
  real(wp), parameter :: far_share = 0.5_wp

contains

  !> A body that contact alone holds has moved so far in this increment that its nodes that are not
  !! watched cannot stand for themselves where they were.
  pure logical function has_flown(model, system, form) result(flown)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! candidates at their place
    type(form_t), intent(in) :: form !! condensed, its kind
    integer :: i

    flown = .false.
    if (form%kind%knows_inside .or. form%condensed%surface_only) return
    if (.not. any(system%body%floating)) return
    do i = 1, size(form%condensed%candidate)
      if (.not. form%condensed%candidate(i)) cycle
      if (.not. system%body%floating(system%body%node_body(i))) cycle
      flown = norm2(model%mesh%x(:, i) + system%u(:, i) - system%position%x_old(:, i)) &
        > far_share*system%scale%facet_size
      if (flown) return
    end do
  end function has_flown

  !> Finds the displacements of all nodes, if they are due or may be far from where they were seen
  !! last, and the points that touch although the condensed form has not watched one of their nodes;
  !! with these it is extended.
  subroutine look_inside(model, system, form, state, settings, monitor, known, missed)
    type(model_t), intent(inout) :: model !! pairs: targets of the points, if some are missed
    type(system_t), intent(inout) :: system !! converged; u of all nodes, condensed may grow
    type(form_t), intent(inout) :: form !! its kind given; gets condensed
    type(state_t), intent(in) :: state !! last converged state
    type(settings_t), intent(in) :: settings !! what is due; how far an apex may lie outside
    class(monitor_t), intent(inout) :: monitor !! hears of missed points
    logical, intent(out) :: known !! the displacements inside are known now
    logical, intent(out) :: missed !! it is to be solved once more
    logical :: watched(size(system%u, 2)), strayed
    integer :: k, n

    missed = .false.
    known = .false.
    if (form%kind%knows_inside .or. form%condensed%surface_only) return
    if (.not. settings%inside_due) then
      if (can_do_without(model, system, form%condensed)) then
        call form%kind%refresh(form, system%u)
        call follow_nodes(model, system, form%condensed, state, strayed)
        if (.not. strayed) return
      end if
    end if
    known = .true.
    call form%kind%recover(system, form)
    call see(form%condensed%outer%factors, system%u, form%condensed%outer%seen)
    system%position%x_now = model%mesh%x + system%u
    watched = form%condensed%candidate .or. .not. any(system%equation > 0, 1)
    n = 0
    do k = 1, size(model%pairs)
      call count_missed(model%pairs(k), system%position, settings%extrapolation, watched, n)
    end do
    missed = n > 0
    if (.not. missed) return
    call monitor%detail('  '//count_noun(n, 'contact point')//' touched where nobody foresaw '// &
      'it: once more with their nodes')
    call load_contact(model, system)
    call form%kind%couple(system, form)
  end subroutine look_inside

  !> All nodes have been seen; no body has been carried since.
  pure subroutine see(factors, u, seen)
    real(wp), intent(in) :: factors(:) !! (loads) of the loads
    real(wp), intent(in) :: u(:, :) !! (3, nodes) their displacements [length]
    type(seen_t), intent(inout) :: seen !! is filled

    seen%factors = factors
    seen%u = u
    seen%carried = u
    seen%carried = 0.0_wp
  end subroutine see

  !> Nodes may have strayed from where they were seen last, other than by the rigid ways that were
  !! foreseen: candidates have, or the loads alone would take another node there.
  subroutine follow_nodes(model, system, condensed, state, strayed)
    type(model_t), intent(in) :: model !! loads, mesh
    type(system_t), intent(in) :: system !! converged
    type(condensed_t), intent(inout) :: condensed !! gets carried of seen
    type(state_t), intent(in) :: state !! last converged state
    logical, intent(out) :: strayed !! by more than a share of a facet
    real(wp) :: way(3, size(system%u, 2)), squared
    integer :: i, k

    associate (outer => condensed%outer, seen => condensed%outer%seen)
      if (.not. allocated(seen%u)) call see(load_factors(model, state%time), state%u, seen)
      seen%carried = seen%carried + system%position%x_ahead - model%mesh%x - state%u
      way = -seen%carried
      do k = 1, size(outer%factors)
        way = way + (outer%factors(k) - seen%factors(k))*outer%influence(:, :, k)
      end do
      strayed = .false.
      do i = 1, size(way, 2)
        if (condensed%candidate(i)) way(:, i) = system%u(:, i) - seen%u(:, i) - seen%carried(:, i)
        squared = 0.0_wp
        do k = 1, 3
          if (system%equation(k, i) > 0) squared = squared + way(k, i)**2
        end do
        strayed = squared > (far_share*system%scale%facet_size)**2
        if (strayed) return
      end do
    end associate
  end subroutine follow_nodes

  !> Counts the points of a pair that touch and have a node that was not watched. If there are none
  !! the pair stays as it was.
  subroutine count_missed(pair, position, tolerance, watched, n)
    type(pair_t), intent(inout) :: pair !! the pair; its working points may change
    type(positions_t), intent(in) :: position !! positions
    real(wp), intent(in) :: tolerance !! how far an apex may lie outside its target
    logical, intent(in) :: watched(:) !! (nodes) of the condensed form, or prescribed
    integer, intent(inout) :: n !! grows by them
    type(point_history_t) :: before
    integer :: p, changes, found

    if (are_watched(watched, pair%surface%facets) .and. are_watched(watched, &
      pair%points%point_nodes)) return
    before = pair%history
    changes = 0
    call follow_apexes(pair, position%x_old, position%x_now, tolerance, changes)
    found = 0
    do p = 1, count_points(pair)
      associate (target => pair%history%new(p)%target)
        if (target == 0) cycle
        if (all(watched(pair%points%point_nodes(:, p))) .and. &
          all(watched(pair%surface%facets(:, target)))) cycle
        if (touches(pair, position%x_now, p, target)) found = found + 1
      end associate
    end do
    n = n + found
    if (found == 0) pair%history = before
  end subroutine count_missed

  !> All of some nodes are watched.
  pure logical function are_watched(watched, nodes)
    logical, intent(in) :: watched(:) !! (nodes)
    integer, intent(in) :: nodes(:, :) !! their numbers
    integer :: k

    are_watched = .false.
    do k = 1, size(nodes, 2)
      if (.not. all(watched(nodes(:, k)))) return
    end do
    are_watched = .true.
  end function are_watched
end module late_look
