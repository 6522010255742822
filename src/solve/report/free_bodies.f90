!> Motions of bodies that nothing resists although forces are in balance (doc/theory, "Floating
!! bodies").
module free_bodies
  use kinds, only: wp
  use vectors, only: cross
  use text, only: to_text, count_noun
  use model_types, only: model_t
  use monitors, only: monitor_t
  use supports, only: free_motions, model_extent
  use contact_report, only: closed_points
  use held_bodies, only: fixing_reaction
  use diagnosis, only: body_name, named_motion, is_held
  use system_types, only: form_t, system_t
  use system_parts, only: bulk_answer_t
  implicit none
  private
  public :: tell_free_bodies, sort_motions

contains

  !> Tells once of each body under load that a converged state leaves motions that nothing resists:
  !! its place is one of many, unless the deck holds it.
  subroutine tell_free_bodies(model, system, form, monitor)
    type(model_t), intent(in) :: model !! mesh, HOLD
    type(system_t), intent(in) :: system !! converged
    type(form_t), intent(in) :: form !! its kind, right
    class(monitor_t), intent(inout) :: monitor !! hears of it once
    character(:), allocatable :: name, what
    real(wp) :: motions(6, 6)
    integer :: b, k, n, pivot(6)

    if (.not. allocated(monitor%told)) allocate (monitor%told(system%body%bodies), source=.false.)
    if (allocated(system%body%fixed)) call tell_fixed(model, system, form%inner, monitor)
    if (.not. any(system%body%floating)) return
    do b = 1, system%body%bodies
      if (.not. system%body%floating(b) .or. monitor%told(b)) cycle
      call free_motions(model%mesh%x, system, b, .true., .true., n, motions)
      if (n == 0 .or. closed_points(system, b) == 0) cycle
      monitor%told(b) = .true.
      call sort_motions(motions(:, :n), pivot(:n))
      name = body_name(model, system, b)
      what = ''
      do k = 1, n
        if (is_held(model, system, b)) call monitor%event('  HOLD: '//name//' can '// &
          named_motion(pivot(k))//' without resistance and is held; the reaction of that is '// &
          to_text(reaction_along(model%mesh%x, system, form, b, motions(:, k), pivot(k)), 3))
        if (k > 1) what = what//merge(' and', ',   ', k == n)
        what = trim(what)//' '//named_motion(pivot(k))
      end do
      if (.not. is_held(model, system, b)) call monitor%warning(name//' can'//what// &
        ' without resistance: the forces are in balance, but its place is not unique; '// &
        'restrain it with BOUNdary, give the pair FRICtion, or write HOLD and its region')
    end do
  end subroutine tell_free_bodies

  !> Tells once of each body that HOLD stops at fixings, where no pair can hold it.
  subroutine tell_fixed(model, system, inner, monitor)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! converged
    type(bulk_answer_t), intent(in) :: inner !! forces of the bulk
    class(monitor_t), intent(inout) :: monitor !! hears of it once
    integer :: b, n

    do b = 1, system%body%bodies
      n = count(system%body%fixed .and. spread(system%body%node_body == b, 1, 3))
      if (n == 0 .or. monitor%told(b)) cycle
      monitor%told(b) = .true.
      call monitor%event('  HOLD: '//body_name(model, system, b)//' has '//count_noun(n, &
        'rigid motion')//' without resistance and is held; the reaction of that is '// &
        to_text(fixing_reaction(system, inner, b), 3))
    end do
  end subroutine tell_fixed

  !> Motions that span the same, each of which has a component 1 where the others have none: three
  !! free motions in a plane are two translations and a turn, whatever the null space begins with.
  pure subroutine sort_motions(motions, pivot)
    real(wp), intent(inout) :: motions(:, :) !! (6, n) independent; translation, rotation times size
    integer, intent(out) :: pivot(:) !! (n) number of that component, ascending
    integer :: column, other, place(2)
    real(wp) :: swap(6)
    logical :: open(6, size(pivot))

    open = .true.
    do column = 1, size(pivot)
      open(:, :column - 1) = .false.
      place = maxloc(abs(motions), open)
      pivot(column) = place(1)
      open(place(1), :) = .false.
      swap = motions(:, place(2))/motions(place(1), place(2))
      motions(:, place(2)) = motions(:, column)
      motions(:, column) = swap
      do other = 1, size(pivot)
        if (other /= column) motions(:, other) = motions(:, other) - motions(place(1), other)*swap
      end do
    end do
    do column = 1, size(pivot)
      place(1) = column - 1 + minloc(pivot(column:), 1)
      swap = motions(:, place(1))
      motions(:, place(1)) = motions(:, column)
      motions(:, column) = swap
      pivot([column, place(1)]) = pivot([place(1), column])
    end do
  end subroutine sort_motions

  !> What has to hold a body along a motion: what is left of its forces, which converged to zero.
  real(wp) function reaction_along(x, system, form, body, motion, pivot) result(reaction)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! converged
    type(form_t), intent(in) :: form !! its kind, right
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: motion(6) !! translation, rotation times the model's size
    integer, intent(in) :: pivot !! its component that is 1: a force, or from 4 on a moment
    real(wp) :: center(3), size_x, push(3)
    integer :: i, k, b

    call model_extent(x, center, size_x)
    if (associated(form%kind%floating_resultant)) then
      associate (modes => system%body%motions(body))
        push = motion(1:3) + cross(motion(4:6), modes%center - center)/size_x
        reaction = -dot_product([push, modes%size/size_x*motion(4:6)], &
          form%kind%floating_resultant(system, form, body))
      end associate
    else
      reaction = 0.0_wp
      do i = 1, size(system%body%node_body)
        if (system%body%node_body(i) /= body) cycle
        push = motion(1:3) + cross(motion(4:6), x(:, i) - center)/size_x
        do k = 1, 3
          if (system%equation(k, i) > 0) reaction = reaction - push(k)*form%right( &
            system%equation(k, i))
        end do
      end do
      if (allocated(system%tools%rigid)) then
        do b = 1, size(system%tools%rigid)
          if (system%tools%rigid(b)%body == body) reaction = reaction - work_on_point(b)
        end do
      end if
    end if
    if (pivot > 3) reaction = size_x*reaction

  contains

    !> What is left of the forces on the point of a rigid body, times the motion there.
    real(wp) function work_on_point(b) result(work)
      integer, intent(in) :: b !! the rigid body
      real(wp) :: moved(6)

      associate (rigid => system%tools%rigid(b))
        moved = [motion(1:3) + cross(motion(4:6), rigid%point - center)/size_x, &
          motion(4:6)*rigid%length/size_x]
        work = dot_product(moved(rigid%unknown), form%right(rigid%first + 1:rigid%first &
          + size(rigid%unknown)))
      end associate
    end function work_on_point
  end function reaction_along
end module free_bodies
