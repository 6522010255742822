!> Whether contact could carry the loads on bodies that it alone holds, taken as rigid (doc/theory,
!! "Static admissibility", eq. (9.10)): said of a solve that has failed.
module statics
  use kinds, only: wp
  use vectors, only: cross
  use lapack_interface, only: dgelsy
  use rigid_joints, only: joint_t, assembly_t, find_parts, find_joints, keep_nearest, loads_on, &
    wrench
  use model_types, only: model_t
  use system_types, only: system_t
  implicit none
  private
  public :: verdict_t, judge_statics
  public :: judge_at_rest, close_by
  public :: statics_unknown, statics_carried, statics_slides, statics_turns, statics_tips, &
    statics_lifts

  !> What statics says: nothing, that contact can carry the loads, or how a body gets away.
  integer, parameter :: statics_unknown = 0
  integer, parameter :: statics_carried = 1
  integer, parameter :: statics_slides = 2
  integer, parameter :: statics_turns = 3
  integer, parameter :: statics_tips = 4
  integer, parameter :: statics_lifts = 5

  !> Loads are carried if no more than this share of them is left over.
  real(wp), parameter :: carried_share = 1.0e-6_wp
  !> A rest above this share, with no contact that would lessen it, is not carried.
  real(wp), parameter :: surely = 1.0e-4_wp
  !> A contact lessens the rest if its force does more than this along it.
  real(wp), parameter :: helps = 1.0e-9_wp
  !> Forces depend on each other whose least combination is below this share of the largest.
  real(wp), parameter :: dependent_force = 1.0e-11_wp
  !> A body touches what is no farther than this share of the longest facet.
  real(wp), parameter :: close_by = 1.0e-3_wp
  !> Most contact forces that are tried one after the other.
  integer, parameter :: most_forces_tried = 400
  !> So much friction is as good as any.
  real(wp), parameter :: any_friction = 1.0e3_wp
  !> What statics says of a system.
  type :: verdict_t
    integer :: kind = statics_unknown !! one of the constants above
    integer :: body = 0 !! the body that moves most
    real(wp) :: motion(6) = 0.0_wp !! how: velocity of its middle, rotation times its size
    real(wp) :: friction = 0.0_wp !! share of the friction that carries the loads, 0 if none does
    integer :: next = statics_unknown !! if carried: how it would get away with less friction
    real(wp) :: apart = huge(1.0_wp) !! if not carried: how far the body that moves most is from
    !! what it may touch, over the longest facet there
    logical :: here = .false. !! it has been asked of what touches now, not of all that may touch
  end type verdict_t

contains

  !> Whether a body would come to rest near where it is, or, if it might do so at places that do not
  !! touch yet, whether what touches now holds it meanwhile.
  subroutine judge_at_rest(model, system, time, verdict)
    type(model_t), intent(in) :: model !! pairs, loads
    type(system_t), intent(in) :: system !! x_old, bodies
    real(wp), intent(in) :: time !! whose loads are to be carried
    type(verdict_t), intent(out) :: verdict !! what statics says

    call judge_statics(model, system, time, verdict)
    if (verdict%kind <= statics_carried) call judge_statics(model, system, time, verdict, close_by)
  end subroutine judge_at_rest

  !> Looks at the last converged positions and the loads of a time.
  subroutine judge_statics(model, system, time, verdict, within)
    type(model_t), intent(in) :: model !! pairs, loads
    type(system_t), intent(in) :: system !! x_old, bodies
    real(wp), intent(in) :: time !! whose loads are to be carried
    type(verdict_t), intent(out) :: verdict !! what statics says
    real(wp), intent(in), optional :: within !! only the nearest points of a pair may carry, and
    !! those farther by no more than this share of its longest facet
    type(assembly_t) :: parts
    real(wp), allocatable :: loads(:), rest(:)
    integer :: kind

    if (.not. (allocated(system%body%floating) .and. allocated(system%position%x_old))) return
    if (size(model%pairs) == 0) return
    if (.not. any(system%body%floating) .or. system%tools%unknowns > 0) return
    call find_parts(system, parts)
    call find_joints(model, system, parts)
    if (present(within)) then
      verdict%here = .true.
      call keep_nearest(parts, within)
    end if
    loads = loads_on(model, system, time, parts)
    if (norm2(loads) <= 0.0_wp .or. parts%n == 0) return
    loads = loads/norm2(loads)
    allocate (rest(size(loads)))
    call carry(parts, loads, 1.0_wp, rest, verdict%kind)
    if (verdict%kind == statics_carried) call look_ahead(parts, loads, verdict)
    if (verdict%kind /= statics_lifts) return
    call carry(parts, loads, any_friction, rest, kind)
    if (kind == statics_carried) then
      call carry(parts, loads, 1.0_wp, rest, verdict%kind)
      call name_motion(parts, loads, rest, .true., verdict)
      if (any(parts%joints(:parts%n)%mu > 0.0_wp)) then
        call find_friction(parts, loads, 1.0_wp, any_friction, verdict%friction)
      end if
    else if (kind == statics_lifts) then
      call name_motion(parts, loads, rest, .false., verdict)
    else
      verdict%kind = statics_unknown
    end if
    if (verdict%kind > statics_carried) verdict%apart = least_gap(parts, verdict%body)
  end subroutine judge_statics

  !> How far a body is from what it may touch.
  pure real(wp) function least_gap(parts, body) result(least)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    integer, intent(in) :: body !! body of the system
    integer :: i

    least = huge(1.0_wp)
    do i = 1, parts%n
      associate (joint => parts%joints(i))
        if (joint%support .or. .not. any(joint%sides == findloc(parts%body, body, 1))) cycle
        least = min(least, joint%gap)
      end associate
    end do
  end function least_gap

  !> Looks for forces within the friction cones that carry the loads: least squares with
  !! coefficients of one sign, a force at a time (the one that lessens the rest most).
  subroutine carry(parts, loads, friction, rest, kind)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    real(wp), intent(in) :: loads(:) !! loads, their norm is 1
    real(wp), intent(in) :: friction !! factor on all coefficients of friction
    real(wp), intent(out) :: rest(:) !! what is not carried
    integer, intent(out) :: kind !! carried, unknown, or (as lifts) not carried
    real(wp) :: columns(size(loads), size(loads) + 1), amounts(size(loads) + 1), work
    integer :: n, trial

    n = 0
    rest = -loads
    kind = statics_unknown
    do trial = 1, most_forces_tried
      if (norm2(rest) <= carried_share) kind = statics_carried
      if (kind == statics_carried .or. n > size(loads)) return
      call best_force(parts, rest, friction, columns(:, n + 1), work)
      if (work <= helps*norm2(rest)) then
        if (norm2(rest) > surely) kind = statics_lifts
        return
      end if
      n = n + 1
      amounts(n) = 0.0_wp
      call fit(columns, -loads, n, amounts)
      rest = -loads - matmul(columns(:, :n), amounts(:n))
    end do
  end subroutine carry

  !> The contact force that does most work along the rest.
  subroutine best_force(parts, rest, friction, column, most)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    real(wp), intent(in) :: rest(:) !! motion of the bodies
    real(wp), intent(in) :: friction !! factor on all coefficients of friction
    real(wp), intent(out) :: column(:) !! what it is for the bodies
    real(wp), intent(out) :: most !! its work over its size
    real(wp) :: motion(3), along(3), force(3), work
    integer :: j

    most = 0.0_wp
    column = 0.0_wp
    do j = 1, parts%n
      associate (joint => parts%joints(j))
        motion = motion_at(parts, rest, joint, 1) - motion_at(parts, rest, joint, 2)
        along = motion - dot_product(motion, joint%normal)*joint%normal
        force = joint%normal
        if (norm2(along) > 0.0_wp) force = force + friction_of(joint, friction)*along/norm2(along)
        force = force/norm2(force)
        work = dot_product(force, motion)
        if (work <= most) cycle
        most = work
        column = 0.0_wp
        call enter(parts, joint, 1, force, column)
        call enter(parts, joint, 2, -force, column)
      end associate
    end do
  end subroutine best_force

  !> Coefficient of friction of a joint, times a factor.
  pure real(wp) function friction_of(joint, factor) result(mu)
    type(joint_t), intent(in) :: joint !! the joint
    real(wp), intent(in) :: factor !! from `any_friction` on it need have none of its own

    mu = factor*joint%mu
    if (factor >= any_friction) mu = any_friction
    if (joint%support) mu = 0.0_wp
  end function friction_of

  !> Velocity of a side of a joint, zero where supports hold it.
  pure function motion_at(parts, rest, joint, side) result(v)
    type(assembly_t), intent(in) :: parts !! bodies
    real(wp), intent(in) :: rest(:) !! motion of the bodies
    type(joint_t), intent(in) :: joint !! the joint
    integer, intent(in) :: side !! 1 slave, 2 master
    real(wp) :: v(3)
    integer :: k

    v = 0.0_wp
    k = joint%sides(side)
    if (k == 0) return
    v = rest(6*k - 5:6*k - 3) + cross(rest(6*k - 2:6*k), joint%place - parts%center(:, k)) &
      /parts%length(k)
  end function motion_at

  !> Adds a force to what acts on the body of a side.
  pure subroutine enter(parts, joint, side, force, column)
    type(assembly_t), intent(in) :: parts !! bodies
    type(joint_t), intent(in) :: joint !! the joint
    integer, intent(in) :: side !! 1 slave, 2 master
    real(wp), intent(in) :: force(3) !! the force
    real(wp), intent(inout) :: column(:) !! forces and moments on all bodies
    integer :: k

    k = joint%sides(side)
    if (k > 0) column(6*k - 5:6*k) = column(6*k - 5:6*k) + wrench(parts, k, joint%place, force)
  end subroutine enter

  !> Least squares with positive amounts: columns whose amount would be negative are dropped on the
  !! way (Lawson and Hanson's algorithm; the amounts so far are positive, the last one is new).
  subroutine fit(columns, wanted, n, amounts)
    real(wp), intent(inout) :: columns(:, :) !! the first n are in use
    real(wp), intent(in) :: wanted(:) !! what they are to add up to
    integer, intent(inout) :: n !! columns in use
    real(wp), intent(inout) :: amounts(:) !! in: positive; out: positive
    real(wp) :: next(n), share
    integer :: k, kept

    do while (n > 0)
      call least_squares(columns(:, :n), wanted, next(:n))
      if (all(next(:n) > 0.0_wp)) exit
      share = 1.0_wp
      do k = 1, n
        if (next(k) <= 0.0_wp) share = min(share, amounts(k)/max(amounts(k) - next(k), &
          tiny(1.0_wp)))
      end do
      amounts(:n) = amounts(:n) + share*(next(:n) - amounts(:n))
      kept = 0
      do k = 1, n
        if (amounts(k) <= 1.0e-14_wp*maxval(amounts(:n)) .and. next(k) <= 0.0_wp) cycle
        kept = kept + 1
        columns(:, kept) = columns(:, k)
        amounts(kept) = amounts(k)
      end do
      if (kept == n) return
      n = kept
    end do
    amounts(:n) = next(:n)
  end subroutine fit

  !> Least squares of minimum norm: columns that are nearly the same share. Steep friction makes
  !! columns that differ by little, so not by the normal equations.
  subroutine least_squares(columns, wanted, amounts)
    real(wp), intent(in) :: columns(:, :) !! columns of about unit size
    real(wp), intent(in) :: wanted(:) !! what they are to add up to
    real(wp), intent(out) :: amounts(:) !! how much of each
    real(wp) :: a(size(columns, 1), size(columns, 2)), right(max(size(wanted), size(amounts)))
    real(wp) :: work(5*(size(wanted) + size(amounts)))
    integer :: place(size(amounts)), rank, info

    a = columns
    right = 0.0_wp
    right(:size(wanted)) = wanted
    place = 0
    call dgelsy(size(a, 1), size(a, 2), 1, a, size(a, 1), right, size(right), place, &
      dependent_force, rank, work, size(work), info)
    amounts = merge(right(:size(amounts)), 0.0_wp, info == 0)
  end subroutine least_squares

  !> Which body moves most along the rest, and how: a motion in which loads do work and no contact
  !! resists.
  subroutine name_motion(parts, loads, rest, by_friction, verdict)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    real(wp), intent(in) :: loads(:) !! loads on them
    real(wp), intent(in) :: rest(:) !! what is not carried
    logical, intent(in) :: by_friction !! more friction would hold it
    type(verdict_t), intent(inout) :: verdict !! gets kind, body, motion
    real(wp) :: normal(3), most
    integer :: k, body

    body = 1
    most = -1.0_wp
    do k = 1, size(parts%body)
      if (norm2(rest(6*k - 5:6*k)) <= most) cycle
      most = norm2(rest(6*k - 5:6*k))
      body = k
    end do
    verdict%body = parts%body(body)
    verdict%motion = -rest(6*body - 5:6*body)
    normal = mean_normal(parts, body, loads(6*body - 5:6*body - 3))
    associate (moves => verdict%motion(1:3), turns => verdict%motion(4:6))
      if (by_friction) then
        verdict%kind = merge(statics_turns, statics_slides, abs(dot_product(turns, normal)) > &
          norm2(moves - dot_product(moves, normal)*normal))
      else
        verdict%kind = merge(statics_lifts, statics_tips, dot_product(moves, normal) > &
          norm2(turns - dot_product(turns, normal)*normal))
      end if
    end associate
  end subroutine name_motion

  !> Mean direction in which its joints press a body against its load (against all of it, if none
  !! does): a unit vector, or zero.
  pure function mean_normal(parts, body, load) result(n)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    integer, intent(in) :: body !! a floating body
    real(wp), intent(in) :: load(3) !! force on it
    real(wp) :: n(3), whole(3), press(3)
    integer :: j

    n = 0.0_wp
    whole = 0.0_wp
    do j = 1, parts%n
      associate (joint => parts%joints(j))
        if (joint%support .or. all(joint%sides /= body)) cycle
        press = merge(joint%normal, -joint%normal, joint%sides(1) == body)
        whole = whole + press
        if (dot_product(press, load) < 0.0_wp) n = n + press
      end associate
    end do
    if (norm2(n) <= 0.0_wp) n = whole
    n = n/max(norm2(n), tiny(1.0_wp))
  end function mean_normal

  !> How much of the friction the loads need, and what would happen with less of it.
  subroutine look_ahead(parts, loads, verdict)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    real(wp), intent(in) :: loads(:) !! loads, their norm is 1
    type(verdict_t), intent(inout) :: verdict !! carried; gets friction, next, body, motion
    real(wp) :: rest(size(loads))
    integer :: kind

    if (all(parts%joints(:parts%n)%mu <= 0.0_wp)) return
    call find_friction(parts, loads, 1.0_wp/any_friction, 1.0_wp, verdict%friction)
    call carry(parts, loads, 0.98_wp*verdict%friction, rest, kind)
    if (kind /= statics_lifts) return
    call name_motion(parts, loads, rest, .true., verdict)
    verdict%next = verdict%kind
    verdict%kind = statics_carried
  end subroutine look_ahead

  !> The factor on the coefficients of friction from which on they carry the loads.
  subroutine find_friction(parts, loads, least, most, factor)
    type(assembly_t), intent(in) :: parts !! bodies and joints
    real(wp), intent(in) :: loads(:) !! loads, their norm is 1
    real(wp), intent(in) :: least !! too little
    real(wp), intent(in) :: most !! enough
    real(wp), intent(out) :: factor !! the factor
    real(wp) :: low, middle, rest(size(loads))
    integer :: k, kind

    low = least
    factor = most
    do k = 1, 16
      middle = sqrt(low*factor)
      call carry(parts, loads, middle, rest, kind)
      if (kind == statics_carried) then
        factor = middle
      else
        low = middle
      end if
    end do
  end subroutine find_friction
end module statics
