!> The lay of the master surface of a pair, as a field over its nodes: to be looked at.
module surface_lay
  use kinds, only: wp
  use vectors, only: cross
  use friction_axes, only: axes_t, find_axes
  use contact_parameters, only: point_parameters
  use element_parameters, only: n_parameters
  use contact_types, only: pair_t
  implicit none
  private
  public :: add_surface_lay

  !> (xi, eta) of the corners.
  real(wp), parameter :: corner_place(2, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
    0.0_wp], [2, 3])

contains

  !> Adds the axis of mu1 at the corners of each master facet; where facets disagree about its sign,
  !! the first one counts. Pairs without a direction of friction add nothing.
  pure subroutine add_surface_lay(pair, x, lay)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(inout) :: lay(:, :) !! (3, nodes) sums of unit vectors
    type(axes_t) :: axes
    real(wp) :: a1(3), a2(3), e(3), d(n_parameters)
    integer :: f, k

    if (abs(pair%friction%mu(1) - pair%friction%mu(2)) <= 0.0_wp .or. &
      size(pair%points%epsilon) == 0) return
    do f = 1, size(pair%surface%facets, 2)
      associate (corners => pair%surface%facets(:, f))
        a1 = x(:, corners(1)) - x(:, corners(3))
        a2 = x(:, corners(2)) - x(:, corners(3))
        e = cross(a1, a2)
        e = e/norm2(e)
        d = point_parameters(pair, 1, f)
        do k = 1, 3
          call find_axes(d, a1, a2, e, corner_place(:, k), x(:, corners(k)), axes)
          associate (mean => lay(:, corners(k)))
            mean = mean + sign(1.0_wp, dot_product(mean, axes%p(:, 1)))*axes%p(:, 1)
          end associate
        end do
      end associate
    end do
  end subroutine add_surface_lay
end module surface_lay
