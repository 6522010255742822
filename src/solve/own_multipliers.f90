!> Multipliers at points of facets, each but that of its own point: the tangent has them go with the
!! displacements, element by element (doc/theory, "A stiff penalty from a soft one").
module own_multipliers
  use kinds, only: wp
  use vectors, only: product_of
  use elmlib, only: routine_none
  use elmt03, only: d03_epsilon
  use assembly, only: answer_of_shift
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use system_types, only: system_t
  implicit none
  private
  public :: goes_by_itself, leave_out, follow_direction, own_way, change_of_forces, forces_of_way, &
    harden_points

contains

  !> A multiplier of the pair is but that of its own point: the tangent has it go with the
  !! displacements, element by element. Those of nodes may stand for penalties of any size, which
  !! leave a tangent no digits.
  pure logical function goes_by_itself(pair) result(yes)
    type(pair_t), intent(in) :: pair !! the pair

    yes = pair%history%softened .and. pair%points%n_slaves > 1
  end function goes_by_itself

  !> Multipliers that go by themselves have no part in the iteration of the others.
  pure subroutine leave_out(system, values)
    type(system_t), intent(in) :: system !! contact elements
    real(wp), intent(inout) :: values(:, :) !! (3, n) gets zeros
    integer :: k

    do k = 1, system%contact%n
      if (system%contact%softening(k) > 0.0_wp) values(:, k) = 0.0_wp
    end do
  end subroutine leave_out

  !> The ways of the multipliers that go by themselves, along the direction.
  subroutine follow_direction(system)
    type(system_t), intent(inout) :: system !! direction found; motion gets way
    real(wp) :: change(3, system%contact%n)
    integer :: k

    do k = 1, system%contact%n
      if (system%contact%softening(k) > 0.0_wp) system%motion%way(:, k) = 0.0_wp
    end do
    change = change_of_forces(system, system%du)
    do k = 1, system%contact%n
      if (system%contact%softening(k) > 0.0_wp) system%motion%way(:, k) = own_way(system, k, &
        system%motion%force(:, k) - system%motion%start(:, k) + change(:, k))
    end do
  end subroutine follow_direction

  !> The way of a multiplier that goes by itself, for a change of its force by other causes.
  pure function own_way(system, k, change) result(way)
    type(system_t), intent(in) :: system !! motion
    integer, intent(in) :: k !! the contact element
    real(wp), intent(in) :: change(3) !! [force]
    real(wp) :: way(3), column(3, 1)

    column(:, 1) = change
    column = answer_of_shift(system%motion%scale(k)*system%motion%by_shift(:, :, k), column)
    way = column(:, 1)
  end function own_way

  !> Change of the forces of the points by displacements and by the way of the multipliers.
  function change_of_forces(system, du) result(change)
    type(system_t), intent(in) :: system !! contact elements, motion
    real(wp), intent(in) :: du(:, :) !! (3, nodes) [length]
    real(wp) :: change(3, system%contact%n), total(3)
    integer :: k, a, i

    change = 0.0_wp
    associate (motion => system%motion, list => system%contact)
      do k = 1, list%n
        if (motion%scale(k) <= 0.0_wp) cycle
        total = motion%scale(k)*product_of(motion%by_shift(:, :, k), motion%way(:, k))
        do a = 1, list%nel(k)
          do i = 1, 3
            total = total + motion%by_place(:, 3*a - 3 + i, k)*du(i, list%ix(a, k))
          end do
        end do
        change(:, k) = total
      end do
    end associate
  end function change_of_forces

  !> What the way of the multipliers adds to the nodal forces of contact.
  function forces_of_way(system) result(force)
    type(system_t), intent(in) :: system !! contact elements, motion
    real(wp) :: force(3, size(system%u, 2)), way(3)
    integer :: k, a, i

    force = 0.0_wp
    associate (motion => system%motion, list => system%contact)
      do k = 1, list%n
        if (motion%scale(k) <= 0.0_wp) cycle
        way = motion%scale(k)*motion%way(:, k)
        do a = 1, list%nel(k)
          associate (node => list%ix(a, k))
            do i = 1, 3
              force(i, node) = force(i, node) + dot_product(way, motion%of_nodes(:, 3*a - 3 + i, k))
            end do
          end associate
        end do
      end do
    end associate
  end function forces_of_way

  !> Points of facets whose stiff penalty stood behind a soft one and a multiplier have it
  !! themselves
  !! in what has been accepted: derivatives and results need know no multipliers. With nodes, whose
  !! penalty may be of any size, it would leave the force no digits.
  subroutine harden_points(model, system)
    type(model_t), intent(inout) :: model !! pairs: raise, softened
    type(system_t), intent(inout) :: system !! contact elements as accepted
    integer :: k, p, element

    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (.not. pair%history%softened .or. pair%points%n_slaves == 1) cycle
        do p = 1, count_points(pair)
          element = system%place%first_point(k) + p - 1
          if (system%contact%routine(element) == routine_none) cycle
          system%contact%d(d03_epsilon, element) = pair%points%epsilon(p)
          system%contact%shift(:, element) = 0.0_wp
        end do
        pair%history%softened = .false.
        pair%history%raise = 1.0_wp
      end associate
    end do
  end subroutine harden_points
end module own_multipliers
