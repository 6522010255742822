!> Bodies that their supports and the normals of contact hold: those that may do without the
!! friction of new points for one pass (doc/theory, "Contact initiation"). Targets tell before it
!! what might hold them, closed points after it what does.
module touch_bodies
  use kinds, only: wp
  use vectors, only: cross
  use lapack_interface, only: dsyev
  use model_types, only: model_t
  use facet_geometry, only: corners, facet_normal
  use springs, only: is_supported
  use element_types, only: status_open
  use element_parameters, only: d03_mu
  use element_lists, only: side_nodes
  use friction_return, only: has_friction
  use contact_points, only: count_points
  use system_types, only: system_t
  implicit none
  private
  public :: find_held, some_drift

  !> Eigenvalues below this share of the largest belong to free motions, and to those that hardly
  !! anything resists: normals that differ by a thousandth.
  real(wp), parameter :: free_tolerance = 1.0e-12_wp, drift_tolerance = 1.0e-6_wp

contains

  !> Marks the bodies that stay without friction; body 0 are nodes that follow their supports.
  subroutine find_held(model, system, held)
    type(model_t), intent(in) :: model !! pairs with the targets of the last converged state
    type(system_t), intent(in) :: system !! bodies and supports
    logical, intent(out) :: held(0:) !! (0:bodies)
    integer :: body

    held = .true.
    do body = 1, system%body%bodies
      if (system%body%floating(body)) held(body) = stays(model, system, body)
    end do
  end subroutine find_held

  !> Supports and normals leave a body no free motion.
  logical function stays(model, system, body)
    type(model_t), intent(in) :: model !! pairs with the targets of the last converged state
    type(system_t), intent(in) :: system !! bodies and supports
    integer, intent(in) :: body !! the body
    real(wp) :: gram(6, 6), center(3), length
    integer :: k, p

    center = 0.5_wp*(maxval(system%position%x_old, 2) + minval(system%position%x_old, 2))
    length = max(maxval(maxval(system%position%x_old, 2) - minval(system%position%x_old, 2)), &
      tiny(1.0_wp))
    gram = 0.0_wp
    call add_supports(system, body, center, length, gram)
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        do p = 1, size(pair%history%old)
          if (pair%history%old(p)%target == 0) cycle
          associate (facet => pair%surface%facets(:, pair%history%old(p)%target))
            if (all(system%body%node_body([facet, pair%points%point_nodes(1, p)]) /= body)) cycle
            call add(facet_normal(corners(system%position%x_old, facet)), &
              (system%position%x_old(:, pair%points%point_nodes(1, p)) - center)/length, gram)
          end associate
        end do
      end associate
    end do
    stays = resists_all(gram, free_tolerance)
  end function stays

  !> After a pass without friction at new points: a body lies on such points, and neither supports
  !! nor what is closed resist all its motions. Where it lies means nothing then.
  logical function some_drift(model, system) result(drift)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! converged; contact elements
    logical :: lies(0:system%body%bodies)
    integer :: k, p, body

    lies = .false.
    do k = 1, size(model%pairs)
      do p = system%place%first_point(k), system%place%first_point(k) + &
        count_points(model%pairs(k)) - 1
        if (system%contact%status(p) <= status_open) cycle
        if (any(has_friction(system%contact%d(d03_mu:d03_mu + 1, p)))) cycle
        if (.not. any(has_friction(model%pairs(k)%friction%mu))) cycle
        lies(system%body%node_body(side_nodes(system%contact, p))) = .true.
      end do
    end do
    drift = .false.
    do body = 1, system%body%bodies
      if (.not. (lies(body) .and. system%body%floating(body))) cycle
      drift = .not. rests(model, system, body)
      if (drift) return
    end do
  end function some_drift

  !> Supports and closed points leave a body no motion: friction resists in all directions.
  logical function rests(model, system, body)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! converged; contact elements
    integer, intent(in) :: body !! the body
    logical :: mine(size(system%body%node_body))
    real(wp) :: gram(6, 6), center(3), length, place(3)
    integer :: k, p, element, i

    mine = system%body%node_body == body
    associate (x => system%position%x_now)
      do i = 1, 3
        center(i) = 0.5_wp*(maxval(x(i, :size(mine)), mine) + minval(x(i, :size(mine)), mine))
      end do
      length = max(maxval(abs(x(:, :size(mine)) - spread(center, 2, size(mine))), spread(mine, 1, &
        3)), tiny(1.0_wp))
      gram = 0.0_wp
      call add_supports(system, body, center, length, gram)
      do k = 1, size(model%pairs)
        do p = 1, count_points(model%pairs(k))
          element = system%place%first_point(k) + p - 1
          if (system%contact%status(element) <= status_open) cycle
          if (all(system%body%node_body(side_nodes(system%contact, element)) /= body)) cycle
          place = (x(:, model%pairs(k)%points%point_nodes(1, p)) - center)/length
          call add(facet_normal(corners(x, model%pairs(k)%surface%facets(:, &
            model%pairs(k)%history%new(p)%target))), place, gram)
          if (.not. any(has_friction(system%contact%d(d03_mu:d03_mu + 1, element)))) cycle
          call add([1.0_wp, 0.0_wp, 0.0_wp], place, gram)
          call add([0.0_wp, 1.0_wp, 0.0_wp], place, gram)
          call add([0.0_wp, 0.0_wp, 1.0_wp], place, gram)
        end do
      end do
    end associate
    rests = resists_all(gram, drift_tolerance)
  end function rests

  !> Adds what the supports of a body resist.
  subroutine add_supports(system, body, center, length, gram)
    type(system_t), intent(in) :: system !! bodies and supports
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: center(3) !! turns are about it [length]
    real(wp), intent(in) :: length !! of a turn of one [length]
    real(wp), intent(inout) :: gram(6, 6) !! what is resisted
    real(wp) :: n(3)
    integer :: i, k

    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= body) cycle
      do k = 1, 3
        n = 0.0_wp
        n(k) = 1.0_wp
        if (is_supported(system, k, i)) call add(n, (system%position%x_old(:, i) - center)/length, &
          gram)
      end do
    end do
  end subroutine add_supports

  !> Adds what resists motion of a place along n.
  pure subroutine add(n, place, gram)
    real(wp), intent(in) :: n(3) !! direction
    real(wp), intent(in) :: place(3) !! from the center, over the length of a turn
    real(wp), intent(inout) :: gram(6, 6) !! what is resisted
    real(wp) :: row(6)

    row = [n, cross(place, n)]
    gram = gram + spread(row, 2, 6)*spread(row, 1, 6)
  end subroutine add

  !> No motion is left that nothing resists.
  logical function resists_all(gram, tolerance) result(all_of_them)
    real(wp), intent(in) :: gram(6, 6) !! what is resisted
    real(wp), intent(in) :: tolerance !! least share of the largest resistance
    real(wp) :: a(6, 6), values(6), work(200)
    integer :: info

    a = gram
    call dsyev('N', 'U', 6, a, 6, values, work, size(work), info)
    all_of_them = info == 0 .and. values(1) > tolerance*max(values(6), 1.0_wp)
  end function resists_all
end module touch_bodies
