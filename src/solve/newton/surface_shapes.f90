!> The shape of smooth surfaces while a system is solved (doc/theory, "Surface smoothing").
module surface_shapes
  use costs, only: begin_cost, end_cost, cost_search
  use element_types, only: routine_none, routine_smooth
  use element_parameters, only: d04_patch, n_parameters
  use element_lists, only: element_list_t
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_lift
  use smooth_normals, only: renew_patches
  use model_types, only: model_t
  use residuals, only: form_residual
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: follow_shape

contains

  !> Smooth surfaces bend as the nodes of the iterate lie, and the residual with them.
  subroutine follow_shape(model, system, form)
    type(model_t), intent(inout) :: model !! pairs: patches
    type(system_t), intent(inout) :: system !! u and the bulk's force given; residual is formed
    type(form_t), intent(inout) :: form !! its kind answers

    if (.not. any(model%pairs%smooth)) return
    call bend_surfaces(model, system, form)
    system%inner%known = .true.
    call form_residual(system, form, model%mesh%x)
  end subroutine follow_shape

  !> Bends smooth surfaces as the nodes of the iterate lie, under the contact elements as they are
  !! (doc/theory, "Surface smoothing").
  subroutine bend_surfaces(model, system, form)
    type(model_t), intent(inout) :: model !! pairs: patches
    type(system_t), intent(inout) :: system !! u given; gets x_now, patches of contact
    type(form_t), intent(inout) :: form !! its kind answers
    integer :: k, p

    if (associated(form%kind%refresh)) call form%kind%refresh(system, form)
    system%position%x_now = model%mesh%x + system%u
    call begin_cost(system%costs, cost_search)
    do k = 1, size(model%pairs)
      if (.not. model%pairs(k)%smooth) cycle
      call renew_patches(model%pairs(k), model%mesh%x, system%u)
      do p = 1, count_points(model%pairs(k))
        call bend_point(model%pairs(k), p, system%place%first_point(k) + p - 1, system%contact)
      end do
    end do
    call end_cost(system%costs, cost_search)
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
