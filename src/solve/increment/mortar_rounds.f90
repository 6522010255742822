!> What all rounds of an increment with multipliers have in common: weights, cuts of facets, results
!! (doc/theory, "Mortar contact").
module mortar_rounds
  use kinds, only: wp
  use model_types, only: model_t
  use mortar_types, only: mortar_t
  use mortar_points, only: weigh_pair
  use mortar_history, only: take_forces, show_points
  use mortar_unknowns, only: mortar_system_t
  use mortar_newton, only: mortar_result_t
  use mortar_touch, only: place_new
  use element_types, only: routine_none
  use contact_system, only: move_targets, load_contact
  use condensed_system, only: couple_condensed
  use costs, only: cost_t, count_cost, cost_rounds, cost_weighed, cost_dense_factor, &
    cost_modified_newton
  use newton_progress, only: newton_t, outcome_converged, outcome_stalled, outcome_singular
  use monitors, only: monitor_t, iteration_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: most_rounds, law_share, weigh_all, cut_moved, take_result, tell, show_all

  !> Rounds of an increment, with a margin: a wavy master has taken 3.
  integer, parameter :: most_rounds = 20
  !> What the law may lack in balance, over the forces: this share of the root of TOL.
  real(wp), parameter :: law_share = 0.1_wp
  !> Facets are cut anew only after nodes have moved by more than this share of a facet since the
  !! last cut: what is handed over changes by less than a copy of the scene that is turned may.
  real(wp), parameter :: hardly = 1.0e-7_wp

contains

  !> Weights and frames at the present positions; whether the multipliers are those of before.
  subroutine weigh_all(model, system, waits, costs, same)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(in) :: system !! contact elements, positions
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    type(cost_t), intent(inout) :: costs !! cost table
    logical, intent(out), optional :: same !! nothing has come or gone
    type(mortar_t) :: nodes
    logical :: kept
    integer :: k

    if (present(same)) same = .true.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k), first => system%place%first_point(k), &
        last => system%place%first_point(k + 1) - 1)
        call weigh_pair(pair, system%contact%routine(first:last) /= routine_none, &
          system%position%x_now, system%position%x_old, nodes)
        kept = are_same(pair%nodes, nodes)
        if (present(same)) same = same .and. kept
        call place_new(pair, system, k, waits, nodes)
        if (kept) nodes%status = pair%nodes%status
        if (kept .and. allocated(pair%nodes%gap)) then
          nodes%gap = pair%nodes%gap
          nodes%criterion = pair%nodes%criterion
        end if
        pair%nodes = nodes
        call count_cost(costs, cost_weighed, nodes%n)
      end associate
    end do
  end subroutine weigh_all

  !> The multipliers are those of another iterate.
  pure logical function are_same(last, nodes)
    type(mortar_t), intent(in) :: last !! before
    type(mortar_t), intent(in) :: nodes !! now

    are_same = last%n == nodes%n .and. allocated(last%status)
    if (are_same) are_same = all(last%node == nodes%node) .and. all(last%face == nodes%face)
  end function are_same

  !> Cuts facets anew where nodes have moved so far that it matters.
  subroutine cut_moved(model, system, form, settings, cut_at, changes)
    type(model_t), intent(inout) :: model !! pairs: cells
    type(system_t), intent(inout) :: system !! contact elements follow
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    real(wp), intent(inout) :: cut_at(:, :) !! (3, nodes) positions at the last cut [length]
    integer, intent(out) :: changes !! points of facets that have been cut

    changes = 0
    if (maxval(abs(system%position%x_now - cut_at)) <= hardly*system%scale%facet_size) return
    call move_targets(model, system, form%costs, settings%extrapolation, changes)
    cut_at = system%position%x_now
    if (changes == 0) return
    call load_contact(model, system)
    call couple_condensed(system, form)
  end subroutine cut_moved

  !> Hands forces and status to the multipliers of the pairs, and says how the solve ended.
  subroutine take_result(model, unknowns, result, progress, costs)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(mortar_system_t), intent(in) :: unknowns !! which belong to which
    type(mortar_result_t), intent(in) :: result !! of the round
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: k

    progress%solves = max(1, progress%solves + result%steps)
    call count_cost(costs, cost_rounds, 1)
    call count_cost(costs, cost_dense_factor, result%steps)
    call count_cost(costs, cost_modified_newton, result%repeated)
    progress%outcome = outcome_stalled
    if (result%singular) progress%outcome = outcome_singular
    if (result%converged) progress%outcome = outcome_converged
    do k = 1, size(model%pairs)
      associate (own => unknowns%start(k) + 1, end => unknowns%start(k + 1))
        call take_forces(result%force(3*own - 2:3*end), result%gap(3*own - 2:3*end), &
          result%closed(own:end), result%slips(own:end), result%criterion(own:end), &
          model%pairs(k)%nodes)
      end associate
    end do
  end subroutine take_result

  !> Reports a round.
  subroutine tell(time, result, progress, monitor)
    real(wp), intent(in) :: time !! end of the increment
    type(mortar_result_t), intent(in) :: result !! of the round
    type(newton_t), intent(in) :: progress !! solves so far
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(iteration_t) :: report

    report%time = time
    report%number = progress%solves
    report%residual = result%left
    report%relative = result%left/max(maxval([0.0_wp, abs(result%force)]), tiny(1.0_wp))
    report%step_length = 1.0_wp
    report%active = count(result%closed)
    report%slip = count(result%closed .and. result%slips)
    report%stick = report%active - report%slip
    report%solver = 'REDUCED'
    call monitor%iteration(report)
  end subroutine tell

  !> Points show what the multipliers around them do.
  subroutine show_all(model, contact, place)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(element_list_t), intent(inout) :: contact !! contact elements; gets status, slip
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    integer :: k

    do k = 1, size(model%pairs)
      associate (first => place%first_point(k), last => place%first_point(k + 1) - 1)
        call show_points(model%pairs(k), contact%status(first:last), contact%slip(:, first:last))
      end associate
    end do
  end subroutine show_all
end module mortar_rounds
