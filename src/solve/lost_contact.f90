!> Whether Newton's iteration has thrown bodies out of the contact that held them. Where all is
!! driven by way, "nothing touches" is in balance, too (doc/theory, "Bodies that contact holds").
module lost_contact
  use kinds, only: wp
  use element_types, only: status_open
  use elmlib, only: routine_none
  use model_types, only: model_t
  use force_scales, only: force_scale
  use system_types, only: system_t
  implicit none
  private
  public :: has_thrown

  !> Contact forces below this share of those of the increment are none.
  real(wp), parameter :: no_force = 1.0e-6_wp
  !> A body that goes farther than this many times what is prescribed, and farther than a facet, has
  !! not gone along.
  real(wp), parameter :: along = 4.0_wp

contains

  !> Contact was closed, is without any force now, and a body that it alone held has flown.
  pure logical function has_thrown(model, system) result(thrown)
    type(model_t), intent(in) :: model !! pairs with their last converged state
    type(system_t), intent(in) :: system !! converged; positions of the last state
    real(wp) :: far
    integer :: k, i

    thrown = .false.
    if (.not. any(system%body%weak)) return
    if (maxval(abs(system%contact_force)) > no_force*force_scale(system)) return
    if (.not. any([(any(model%pairs(k)%history%old%status > status_open), &
      k=1, size(model%pairs))])) return
    far = max(along*system%scale%stroke, system%scale%facet_size)
    associate (list => system%contact)
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do i = 1, list%nel(k)
          associate (node => list%ix(i, k))
            if (system%body%node_body(node) == 0) cycle
            if (.not. system%body%weak(system%body%node_body(node))) cycle
            thrown = norm2(model%mesh%x(:, node) + system%u(:, node) &
              - system%position%x_old(:, node)) > far
            if (thrown) return
          end associate
        end do
      end do
    end associate
  end function has_thrown
end module lost_contact
