!> What is prescribed of rigid bodies with a point at a time (doc/theory, "Rigid bodies").
module rigid_paths
  use kinds, only: wp
  use model_types, only: model_t, point_load_t
  use loads, only: load_factor
  implicit none
  private
  public :: count_rigid, motion_at, load_at

contains

  !> Number of rigid bodies with a point.
  pure integer function count_rigid(model) result(n)
    type(model_t), intent(in) :: model !! the problem

    n = 0
    if (allocated(model%conditions%rigid)) n = size(model%conditions%rigid)
  end function count_rigid

  !> Prescribed translation and rotation vector of a body; zero where they are free.
  pure function motion_at(model, body, time) result(motion)
    type(model_t), intent(in) :: model !! rigid bodies, tables
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: time !! the time
    real(wp) :: motion(6)

    motion = sum_at(model, model%conditions%rigid(body)%motions, time)
  end function motion_at

  !> Force and moment on the point of a body.
  pure function load_at(model, body, time) result(load)
    type(model_t), intent(in) :: model !! rigid bodies, tables
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: time !! the time
    real(wp) :: load(6)

    load = sum_at(model, model%conditions%rigid(body)%loads, time)
  end function load_at

  !> Sum of motions or loads, each times its table.
  pure function sum_at(model, list, time) result(total)
    type(model_t), intent(in) :: model !! tables
    type(point_load_t), intent(in) :: list(:) !! motions or loads
    real(wp), intent(in) :: time !! the time
    real(wp) :: total(6)
    integer :: k

    total = 0.0_wp
    do k = 1, size(list)
      total = total + load_factor(model%tables, list(k)%table, time)*list(k)%value
    end do
  end function sum_at
end module rigid_paths
