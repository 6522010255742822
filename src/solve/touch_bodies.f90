!> Bodies that their supports and the normals of contact hold: those that may do without the
!! friction of new points for one pass (doc/theory, "First touch").
module touch_bodies
  use kinds, only: wp
  use vectors, only: cross
  use lapack_interface, only: dsyev
  use model_types, only: model_t
  use facet_geometry, only: corners, facet_normal
  use springs, only: is_supported
  use system_types, only: system_t
  implicit none
  private
  public :: find_held

  !> Eigenvalues below this share of the largest belong to free motions.
  real(wp), parameter :: free_tolerance = 1.0e-12_wp

contains

  !> Marks the bodies that stay without friction; body 0 are nodes that follow their supports.
  subroutine find_held(model, system, held)
    type(model_t), intent(in) :: model !! pairs with the hosts of the last converged state
    type(system_t), intent(in) :: system !! bodies and supports
    logical, intent(out) :: held(0:) !! (0:bodies)
    integer :: body

    held = .true.
    do body = 1, system%body%bodies
      if (system%body%weak(body)) held(body) = stays(model, system, body)
    end do
  end subroutine find_held

  !> Supports and normals leave a body no free motion.
  logical function stays(model, system, body)
    type(model_t), intent(in) :: model !! pairs with the hosts of the last converged state
    type(system_t), intent(in) :: system !! bodies and supports
    integer, intent(in) :: body !! the body
    real(wp) :: gram(6, 6), values(6), work(200), center(3), size_x, n(3)
    integer :: i, k, p, info

    center = 0.5_wp*(maxval(system%position%x_old, 2) + minval(system%position%x_old, 2))
    size_x = max(maxval(maxval(system%position%x_old, 2) - minval(system%position%x_old, 2)), &
      tiny(1.0_wp))
    gram = 0.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= body) cycle
      do k = 1, 3
        n = 0.0_wp
        n(k) = 1.0_wp
        if (is_supported(system, k, i)) call add(n, system%position%x_old(:, i))
      end do
    end do
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        do p = 1, size(pair%history%old)
          if (pair%history%old(p)%host == 0) cycle
          associate (facet => pair%surface%facets(:, pair%history%old(p)%host))
            if (all(system%body%node_body([facet, pair%points%point_nodes(1, p)]) /= body)) cycle
            call add(facet_normal(corners(system%position%x_old, facet)), &
              system%position%x_old(:, pair%points%point_nodes(1, p)))
          end associate
        end do
      end associate
    end do
    call dsyev('N', 'U', 6, gram, 6, values, work, size(work), info)
    stays = info == 0 .and. values(1) > free_tolerance*max(values(6), 1.0_wp)

  contains

    !> Adds what resists motion of the place x along n.
    subroutine add(n, x)
      real(wp), intent(in) :: n(3) !! direction
      real(wp), intent(in) :: x(3) !! the place [length]
      real(wp) :: row(6)

      row = [n, cross((x - center)/size_x, n)]
      gram = gram + spread(row, 2, 6)*spread(row, 1, 6)
    end subroutine add
  end function stays
end module touch_bodies
