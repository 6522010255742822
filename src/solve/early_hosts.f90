!> Whether a solve that is still on its way has led tips out of their hosts for good: then the hosts
!! follow at once, not after the last digits (doc/theory, "Target facet").
module early_hosts
  use kinds, only: wp
  use element_types, only: status_open
  use elmlib, only: routine_none
  use model_types, only: model_t
  use contact_points, only: count_points
  use facet_geometry, only: barycentric, corners, altitude
  use system_types, only: system_t
  implicit none
  private
  public :: may_look_early, tips_have_left

  !> What a point and its facet may yet move, over the last step: each step is at most a fifth as
  !! long as the one before, so all that follow are a quarter of it, for the one and the other.
  real(wp), parameter :: still_to_come = 0.5_wp
  !> A tip that is closer to an edge than this, in shape functions, is on neither side of it.
  real(wp), parameter :: on_edge = 1.0e-5_wp

contains

  !> Hosts may be looked at before a solve has converged: not where cells are cut from them, nor
  !! where surfaces take their shape from what has converged.
  pure logical function may_look_early(model) result(may)
    type(model_t), intent(in) :: model !! pairs

    may = size(model%pairs) > 0 .and. .not. (any(model%pairs%smooth) .or. &
      any(model%pairs%segmented))
  end function may_look_early

  !> Tips of closed points lie outside their hosts, and none is so close to an edge that the steps
  !! to come may take it to the other side: what has converged would say the same.
  pure logical function tips_have_left(model, system) result(left)
    type(model_t), intent(in) :: model !! pairs with their hosts
    type(system_t), intent(in) :: system !! residual formed after the step du
    real(wp) :: way
    integer :: k, p, element
    logical :: outside, doubtful

    left = .false.
    way = still_to_come*largest_step(system)
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        element = system%place%first_point(k) + p - 1
        if (system%contact%routine(element) == routine_none .or. &
          system%contact%status(element) <= status_open) cycle
        associate (surface => model%pairs(k)%surface, host => model%pairs(k)%history%new(p)%host)
          call look_at_edges(corners(model%mesh%x, surface%facets(:, host)) + corners(system%u, &
            surface%facets(:, host)), surface%neighbours(:, host) > 0 .and. .not. &
            surface%fold(:, host), system%contact%h2(1:2, element), way, outside, doubtful)
        end associate
        if (doubtful) then
          left = .false.
          return
        end if
        left = left .or. outside
      end do
    end do
  end function tips_have_left

  !> The farthest that the last step has moved a node of a closed point.
  pure real(wp) function largest_step(system) result(way)
    type(system_t), intent(in) :: system !! du, contact elements
    integer :: k

    way = 0.0_wp
    associate (list => system%contact)
      do k = 1, list%n
        if (list%routine(k) == routine_none .or. list%status(k) <= status_open) cycle
        way = max(way, maxval(norm2(system%du(:, list%ix(:list%nel(k), k)), 1)))
      end do
    end associate
  end function largest_step

  !> Where a tip lies beside the edges of its host that lead to other facets.
  pure subroutine look_at_edges(corner, leads, tip, way, outside, doubtful)
    real(wp), intent(in) :: corner(3, 3) !! corners of the host [length]
    logical, intent(in) :: leads(3) !! whether an edge leads to another facet
    real(wp), intent(in) :: tip(2) !! (xi, eta) in the host
    real(wp), intent(in) :: way !! it may yet go [length]
    logical, intent(out) :: outside !! beyond such an edge
    logical, intent(out) :: doubtful !! it may yet cross one
    real(wp) :: n(3), height
    integer :: edge

    outside = .false.
    doubtful = .false.
    n = barycentric(tip)
    do edge = 1, 3
      if (.not. leads(edge)) cycle
      height = altitude(corner, edge)
      outside = outside .or. n(edge) < 0.0_wp
      doubtful = doubtful .or. abs(n(edge))*height <= max(way, on_edge*height)
    end do
  end subroutine look_at_edges
end module early_hosts
