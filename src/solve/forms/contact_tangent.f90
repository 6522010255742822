!> The tangent of contact in the condensed form: element matrices, their leading part U V^T, and
!! the factor of I + V^T C U (doc/theory, "Contact operator of low rank", eq. (12.7)).
module contact_tangent
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_contact_tangent, cost_dense_factor
  use element_types, only: task_tangent, status_open, routine_none
  use gcr, only: forget_images
  use assembly, only: assemble
  use back_ends, only: solver_done, solver_singular
  use condensed_types, only: condensed_t, contact_tangent_t
  use live_candidates, only: gather_compliance, complete_compliance
  use contact_sums, only: sum_elements, add_whole_rest, peel_nodes, peel_elements
  use supports, only: unheld_bodies
  use contact_blocks, only: form_blocks
  use contact_groups, only: place_elements, peel_groups, list_columns
  use body_turns, only: turn_elements
  use condensed_springs, only: hold_motions
  use condensed_border, only: form_points
  use small_tangent, only: form_double
  use whole_tangent, only: is_better_whole
  use tree_compliance, only: has_trees
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  implicit none
  private
  public :: form_element_matrices, factorise_tangent, form_rest, apply_rest

  !> Element matrix entries times compliance that are left to the iteration.
  real(wp), parameter :: negligible = 0.03_wp
  !> Rows of the whole form over those of the other, at most: there are several of these for each of
  !! them where it is taken.
  integer, parameter :: most_whole = 2

contains

  !> Element matrices at u.
  subroutine form_element_matrices(system, form, x)
    type(system_t), intent(inout) :: system !! gets tangent of condensed, right
    type(form_t), intent(inout) :: form !! its kind given; gets condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call begin_cost(form%costs, cost_contact_tangent)
    associate (tangent => form%condensed%tangent)
      if (.not. allocated(tangent%s)) allocate (tangent%s(3*size(system%contact%ix, 1), &
        3*size(system%contact%ix, 1), system%contact%n))
      call assemble(system%contact, task_tangent, x, system%u, system%contact_force, s=tangent%s)
      if (form%condensed%active) then
        call form%kind%gather(system, form, 0.0_wp, .false.)
      else
        call turn_elements(system, form%condensed)
      end if
      call list_elements(system%contact, tangent)
      call form_points(system, form)
      call clear_dead(tangent)
    end associate
    if (any(system%body%floating)) system%body%regularised = unheld_bodies(x, system, form)
    call end_cost(form%costs, cost_contact_tangent)
  end subroutine form_element_matrices

  !> Lists the closed elements.
  subroutine list_elements(contact, tangent)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(contact_tangent_t), intent(inout) :: tangent !! gets element
    integer :: k

    if (.not. allocated(tangent%element)) allocate (tangent%element(contact%n))
    tangent%elements = 0
    do k = 1, contact%n
      if (contact%routine(k) == routine_none) cycle
      if (contact%status(k) <= status_open) cycle
      tangent%elements = tangent%elements + 1
      tangent%element(tangent%elements) = k
    end do
  end subroutine list_elements

  !> Clears what of the matrices of closed elements belongs to no live candidate.
  pure subroutine clear_dead(tangent)
    type(contact_tangent_t), intent(inout) :: tangent !! s loses dead rows
    integer :: e, i

    do e = 1, tangent%elements
      associate (k => tangent%element(e))
        do i = 1, size(tangent%dofs, 1)
          if (tangent%dofs(i, k) > 0) cycle
          tangent%s(i, :, k) = 0.0_wp
          tangent%s(:, i, k) = 0.0_wp
        end do
      end associate
    end do
  end subroutine clear_dead

  !> Factor of the leading part of the element matrices at hand.
  subroutine factorise_tangent(system, form, x, outcome)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets the factor in tangent of condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! done or singular
    integer :: info

    outcome = solver_done
    call begin_cost(form%costs, cost_dense_factor)
    associate (condensed => form%condensed, tangent => form%condensed%tangent)
      call gather_compliance(condensed)
      tangent%modes = condensed%rigid%modes
      tangent%fresh = .true.
      call choose_columns(system, form%condensed, x)
      if (tangent%modes > 0) call hold_motions(system, form%condensed)
      call complete_compliance(condensed)
      if (tangent%parts%iterated) then
        call form_blocks(system, form%condensed, x, outcome)
      else
        call form_double(condensed, tangent, info)
        if (info /= 0) outcome = solver_singular
      end if
      tangent%status = system%contact%status
    end associate
    call end_cost(form%costs, cost_dense_factor)
  end subroutine factorise_tangent

  !> The leading columns of contact: those of its points, of the nodes it touches, or, where both
  !! are many or a compliance is no matrix, for blocks.
  subroutine choose_columns(system, condensed, x)
    type(system_t), intent(in) :: system !! the problem
    type(condensed_t), intent(inout) :: condensed !! gets columns in tangent of condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: place(3, condensed%tangent%elements)
    integer :: many

    associate (tangent => condensed%tangent)
      many = merge(0, tangent%parts%most_dense, has_trees(condensed))
      tangent%whole = is_better_whole(condensed, tangent)
      tangent%parts%grouped = .false.
      if (tangent%whole) then
        call sum_elements(tangent, condensed%alive%n_live, tangent%sum)
        call peel_nodes(condensed, tangent, negligible)
        tangent%parts%grouped = tangent%rank > most_whole*many .and. .not. tangent%parts%dense
        tangent%parts%iterated = tangent%parts%grouped
        if (.not. tangent%parts%grouped) return
        call place_elements(system, condensed, x, place)
        call peel_groups(condensed, tangent, place, negligible)
      else
        call peel_elements(condensed, tangent, negligible)
        tangent%parts%iterated = .not. tangent%parts%dense .and. tangent%rank > many
        if (tangent%parts%iterated) call list_columns(tangent)
      end if
    end associate
  end subroutine choose_columns

  !> What U V^T leaves of the element matrices; the factor may be older than these.
  subroutine form_rest(contact, condensed)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(condensed_t), intent(inout) :: condensed !! its tangent: s becomes the rest
    integer :: k, j

    associate (tangent => condensed%tangent)
      call forget_images(tangent%course%known)
      if (tangent%whole) then
        if (.not. tangent%fresh) call sum_elements(tangent, condensed%alive%n_live, tangent%now)
        return
      end if
      tangent%resting = 0
      do k = 1, contact%n
        if (contact%routine(k) == routine_none) cycle
        if (max(contact%status(k), tangent%status(k)) <= status_open) cycle
        if (contact%status(k) <= status_open) tangent%s(:, :, k) = 0.0_wp
        tangent%resting = tangent%resting + 1
        tangent%element(tangent%resting) = k
      end do
      do j = 1, tangent%rank
        associate (s => tangent%s(:, :, tangent%owner(j)))
          do k = 1, size(tangent%dofs, 1)
            s(:, k) = s(:, k) - tangent%u(:, j)*tangent%v(k, j)
          end do
        end associate
      end do
    end associate
  end subroutine form_rest

  !> y = k' x with the rest of the element matrices.
  subroutine apply_rest(tangent, x, y, shares)
    type(contact_tangent_t), intent(in) :: tangent !! rest of the element matrices
    real(wp), intent(in) :: x(:) !! (live) [length]
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp), intent(in), optional :: shares(:) !! (rank) V^T x, if it is known [length]
    integer :: e

    y = 0.0_wp
    if (tangent%whole) then
      call add_whole_rest(tangent, x, y, shares)
      return
    end if
    do e = 1, tangent%resting
      call add_element(size(tangent%dofs, 1), tangent%dofs(:, tangent%element(e)), &
        tangent%s(:, :, tangent%element(e)), x, y)
    end do
  end subroutine apply_rest

  !> Adds what the matrix of an element does.
  pure subroutine add_element(n, dofs, s, x, y)
    integer, intent(in) :: n !! degrees of freedom of an element
    integer, intent(in) :: dofs(n) !! live candidates, 0 for none
    real(wp), intent(in) :: s(n, n) !! its matrix
    real(wp), intent(in) :: x(:) !! (live)
    real(wp), intent(inout) :: y(:) !! (live) grows
    real(wp) :: force(n)
    integer :: i, j

    force = 0.0_wp
    do j = 1, n
      if (dofs(j) > 0) force = force + s(:, j)*x(dofs(j))
    end do
    do i = 1, n
      if (dofs(i) > 0) y(dofs(i)) = y(dofs(i)) + force(i)
    end do
  end subroutine add_element
end module contact_tangent
