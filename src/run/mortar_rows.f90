!> What is written of pairs with multipliers: forces at their points, so that these add up to the
!! multipliers, and sums over slave nodes (doc/theory, "Mortar contact", eq. (7.13)).
module mortar_rows
  use kinds, only: wp
  use element_types, only: status_open, status_stick, status_slip
  use contact_types, only: pair_t
  use model_types, only: model_t
  use system_types, only: system_t
  use result_types, only: contact_row_t
  implicit none
  private
  public :: fill_mortar_points, sum_multipliers

contains

  !> Forces of the points of all such pairs, from those of the multipliers around them.
  pure subroutine fill_mortar_points(model, system, point_state)
    type(model_t), intent(in) :: model !! pairs, settled
    type(system_t), intent(in) :: system !! where the points of each pair are
    real(wp), intent(inout) :: point_state(:, :) !! (n_element_stress, points) of elmt03
    real(wp) :: f(3)
    integer :: k, p, i

    do k = 1, size(model%pairs)
      if (.not. allocated(model%pairs(k)%nodes%owner)) cycle
      associate (nodes => model%pairs(k)%nodes)
        do p = 1, size(nodes%owner, 2)
          f = 0.0_wp
          do i = 1, 3
            if (nodes%owner(i, p) > 0) f = f + nodes%share(i, p)*nodes%force(:, nodes%owner(i, p))
          end do
          associate (point => point_state(:, system%place%first_point(k) + p - 1))
            point(1:3) = -f
            point(5:6) = 0.0_wp
            point(13) = dot_product(f, point(10:12))
            point(14) = norm2(f - point(13)*point(10:12))
          end associate
        end do
      end associate
    end do
  end subroutine fill_mortar_points

  !> Puts sums over multipliers in the place of sums over points: numbers of nodes, normal and
  !! tangential forces, largest weighted penetration.
  pure subroutine sum_multipliers(pair, row)
    type(pair_t), intent(in) :: pair !! settled
    type(contact_row_t), intent(inout) :: row !! forces and moments given; gets the rest
    real(wp) :: normal
    integer :: i

    row%stick = 0
    row%slip = 0
    row%normal = 0.0_wp
    row%tangential = 0.0_wp
    row%max_penetration = 0.0_wp
    row%max_elastic_slip = 0.0_wp
    row%max_criterion = -huge(1.0_wp)
    do i = 1, pair%nodes%n
      associate (z => pair%nodes%force(:, i), n => pair%nodes%frame(:, 3, i))
        if (pair%nodes%status(i) <= status_open) cycle
        if (pair%nodes%status(i) == status_stick) row%stick = row%stick + 1
        if (pair%nodes%status(i) == status_slip) row%slip = row%slip + 1
        normal = dot_product(z, n)
        row%normal = row%normal + normal
        row%tangential = row%tangential + norm2(z - normal*n)
        row%max_penetration = max(row%max_penetration, -pair%nodes%gap(3, i))
        row%max_criterion = max(row%max_criterion, pair%nodes%criterion(i))
      end associate
    end do
    row%active = row%stick + row%slip
    if (row%active == 0) row%max_criterion = 0.0_wp
    row%lumped = row%tangential
  end subroutine sum_multipliers
end module mortar_rows
