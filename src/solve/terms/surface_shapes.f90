!> The shape of smooth surfaces while a system is solved (doc/theory, "Surface smoothing").
module surface_shapes
  use kinds, only: wp
  use element_types, only: routine_none, routine_smooth
  use element_parameters, only: d04_patch, n_parameters
  use element_lists, only: element_list_t
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_lift
  use smooth_normals, only: renew_patches
  use model_types, only: model_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: bend_surfaces

contains

  !> Bends smooth surfaces as the nodes of the iterate lie, under the contact elements as they are
  !! (doc/theory, "Surface smoothing").
  subroutine bend_surfaces(model, place, u, contact)
    type(model_t), intent(inout) :: model !! pairs: patches
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(element_list_t), intent(inout) :: contact !! gets patches
    integer :: k, p

    do k = 1, size(model%pairs)
      if (.not. model%pairs(k)%smooth) cycle
      call renew_patches(model%pairs(k), model%mesh%x, u)
      do p = 1, count_points(model%pairs(k))
        call bend_point(model%pairs(k), p, place%first_point(k) + p - 1, contact)
      end do
    end do
  end subroutine bend_surfaces

  !> The patches of one contact element, under it and where its point is lifted.
  pure subroutine bend_point(pair, p, element, list)
    type(pair_t), intent(in) :: pair !! the pair with its patches
    integer, intent(in) :: p !! the point
    integer, intent(in) :: element !! its place in the list
    type(element_list_t), intent(inout) :: list !! gets d, lift

    if (list%routine(element) == routine_none) return
    if (list%routine(element) == routine_smooth) list%d(d04_patch:n_parameters, element) = &
      pair%surface%patch(:, pair%history%new(p)%target)
    if (pair%points%n_slaves > 1) list%lift(element) = point_lift(pair, p)
  end subroutine bend_point
end module surface_shapes
