!> Whether the answer of an end time may have others beside it: how much friction each contact point
!! bears alone, the sign of the tangent, and second starts (doc/theory, "Other answers").
module answers_audit
  use kinds, only: wp
  use element_types, only: status_open, status_slip, routine_none
  use element_parameters, only: d03_law, d03_area
  use friction_laws, only: any_acts
  use linear_solver, only: factor_sign
  use condensed_types, only: condensed_t
  use coulomb_answers, only: coulomb_t, answer_t, tangent_sign, friction_borne, point_borne
  use answer_starts, only: second_answers
  use answer_places, only: place_t, list_places, coupling_of, carried, slip_of
  use model_types, only: model_t
  use system_types, only: form_t, system_t, state_t
  use element_lists, only: element_list_t
  use audit_types, only: audit_t, other_answers_t, verdict_ok, verdict_warning, check_answers
  implicit none
  private
  public :: judge_answers

  !> Statuses are looked at where a point bears less than so many times its friction: in each of 74
  !! random systems with several answers, out of 3,600, one bore less than 2.5 times of it.
  real(wp), parameter :: critical_share = 1.0_wp/3.0_wp
  !> Closed points that are looked at in each end time; those that are more, in the last, and in
  !! every so many where a point bears less than its friction: they cost as much as an iteration.
  integer, parameter :: few_points = 20, every_step = 10
  !> Closed points whose statuses are looked at; points of second starts; points that are tried.
  integer, parameter :: most_closed_points = 300, most_searched = 64, most_tried = 32
  !> A closed point whose pressure gives way by less than this share of the model's size is one that
  !! just touches: its status is round-off, and it counts as open.
  real(wp), parameter :: least_way = 1.0e-12_wp
  !> Products of all second starts: about 5 s; and those of a start, over the cube of its unknowns.
  real(wp), parameter :: most_work = 1.0e10_wp, of_start = 120.0_wp

contains

  !> Judges an end time.
  subroutine judge_answers(model, system, form, state, point_state, last, wanted, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, compliance
    type(form_t), intent(in) :: form !! condensed, its kind, matrix
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    logical, intent(in) :: last !! it is the last end time
    logical, intent(in) :: wanted !! second starts are asked for
    type(audit_t), intent(inout) :: audit !! gets answers, value, worst, verdict
    type(place_t), allocatable :: places(:)
    integer :: before
    logical :: due

    before = audit%answers%sign
    audit%answers = other_answers_t()
    audit%verdict(check_answers) = verdict_ok
    audit%worst(check_answers) = 0
    audit%value(check_answers) = -1.0_wp
    call find_obstacle(model, system%contact, form, audit%answers)
    if (len(audit%answers%unknown) > 0) return
    if (.not. form%kind%knows_inside) then
      call list_places(model, system, form, point_state, places)
      call find_weakest(system%contact, form, point_state, places, audit)
      due = audit%answers%point_share > critical_share .and. count(places%closed) <= few_points
      due = due .or. audit%answers%point_share > 1.0_wp .and. mod(audit%step, every_step) == 0
      if (due .or. last .or. wanted) call look_at_statuses(model, system, form, state, &
        point_state, places, last .or. before >= 0, wanted, audit%answers)
      audit%value(check_answers) = max(audit%answers%point_share, audit%answers%share)
    else
      audit%answers%sign = factor_sign(form%whole%solver)
      if (audit%answers%sign == 0) audit%answers%unknown = 'this solver does not tell the sign '// &
        'of a determinant'
    end if
    if (audit%answers%sign < 0 .and. .not. audit%unstable) audit%told(check_answers) = .false.
    audit%unstable = audit%unstable .or. audit%answers%sign < 0
    if (audit%answers%sign < 0 .or. audit%answers%point_share > 1.0_wp) &
      audit%verdict(check_answers) = verdict_warning
  end subroutine judge_answers

  !> Why nothing can be said, if that is so.
  subroutine find_obstacle(model, contact, form, answers)
    type(model_t), intent(in) :: model !! pairs
    type(element_list_t), intent(in) :: contact !! contact elements
    type(form_t), intent(in) :: form !! condensed, its kind
    type(other_answers_t), intent(inout) :: answers !! gets unknown
    logical :: takes_part(contact%n)
    integer :: k

    answers%unknown = ''
    takes_part = contact%routine /= routine_none
    if (size(model%pairs) == 0) then
      answers%unknown = 'no contact'
    else if (.not. any([(any(model%pairs(k)%friction%mu > 0.0_wp), k=1, size(model%pairs))])) then
      answers%unknown = 'no friction'
    else if (any(model%pairs%mortar)) then
      answers%unknown = 'contact is by multipliers at nodes'
    else if (.not. any(takes_part)) then
      answers%unknown = 'nothing is near'
    else if (any([(takes_part(k) .and. any_acts(contact%d(d03_law:d03_area - 1, k)), &
      k=1, size(takes_part))])) then
      answers%unknown = 'a law changes the cone'
    else if (form%kind%knows_inside) then
      if (form%kind%inexact) answers%unknown = 'the bulk is not linear'
    else if (any([(count(model%pairs(k)%friction%mu > 0.0_wp) == 1, k=1, size(model%pairs))])) then
      answers%unknown = 'friction along one axis alone'
    else if (form%condensed%points%n > 0) then
      answers%unknown = 'a rigid body moves with contact'
    else if (any(form%condensed%bodies%tree%used .and. form%condensed%bodies%m > 0)) then
      answers%unknown = 'contact is so large that its compliance is no matrix'
    else if (.not. is_at_hand(form%condensed)) then
      answers%unknown = 'the compliance of contact is not at hand'
    end if
  end subroutine find_obstacle

  !> The compliances of the bodies with candidates are at hand.
  pure logical function is_at_hand(condensed) result(there)
    type(condensed_t), intent(in) :: condensed !! bodies
    integer :: b

    there = allocated(condensed%place)
    do b = 1, size(condensed%bodies)
      if (condensed%bodies(b)%m > 0) there = there .and. associated(condensed%bodies(b)%compliance)
    end do
  end function is_at_hand

  !> The point whose friction is the most of what it bears alone. Of bodies that nothing but contact
  !! holds one point alone says nothing: they count as rigid.
  subroutine find_weakest(contact, form, point_state, places, audit)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(form_t), intent(in) :: form !! what the condensed form keeps
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(place_t), intent(inout) :: places(:) !! the points; gets closed
    type(audit_t), intent(inout) :: audit !! gets point_share, point, worst
    real(wp) :: w(3, 3), share
    logical :: moves
    integer :: b, p

    moves = any([(form%condensed%bodies(b)%motions%n > 0, b=1, size(form%condensed%bodies))])
    do p = 1, size(places)
      w = coupling_of(form%condensed, places(p), places(p), .false.)
      places(p)%closed = contact%status(places(p)%element) > status_open .and. &
        point_state(13, places(p)%element)*w(1, 1) > least_way*audit%fixed%model_size
      if (moves) w = coupling_of(form%condensed, places(p), places(p), .true.)
      share = point_borne(w(:, 1), places(p)%mu)
      if (share <= audit%answers%point_share) cycle
      audit%answers%point_share = share
      audit%worst(check_answers) = places(p)%pair
      audit%answers%point = places(p)%point
    end do
  end subroutine find_weakest

  !> Sign of the tangent, the friction that the statuses bear, and second starts: where the sign is
  !! negative, or where they are asked for.
  subroutine look_at_statuses(model, system, form, state, point_state, places, may_search, wanted, &
    answers)
    type(model_t), intent(in) :: model !! positions
    type(system_t), intent(in) :: system !! contact elements, compliance
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(place_t), intent(in) :: places(:) !! the points
    logical, intent(in) :: may_search !! second starts may follow
    logical, intent(in) :: wanted !! they do
    type(other_answers_t), intent(inout) :: answers !! gets sign, share, others
    type(place_t), allocatable :: closed(:)
    type(coulomb_t) :: problem
    type(answer_t) :: answer

    closed = pack(places, places%closed)
    answers%closed = size(closed)
    answers%too_many = size(closed) > most_closed_points
    if (answers%too_many) return
    if (size(closed) > 0) then
      call set_problem(model, system, form, state, point_state, closed, problem, answer)
      answers%sign = tangent_sign(problem, answer)
      answers%share = friction_borne(problem, answer)
    else
      answers%sign = 1
      answers%share = 0.0_wp
    end if
    if (.not. (wanted .or. answers%sign < 0 .and. may_search)) return
    answers%searched = size(places) <= most_searched
    if (.not. answers%searched) return
    call set_problem(model, system, form, state, point_state, places, problem, answer)
    call search(problem, answer, answers)
  end subroutine look_at_statuses

  !> The increment at some points, linearised at its answer (eq. (13.6)).
  subroutine set_problem(model, system, form, state, point_state, places, problem, answer)
    type(model_t), intent(in) :: model !! positions
    type(system_t), intent(in) :: system !! contact elements, compliance
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(place_t), intent(in) :: places(:) !! the points
    type(coulomb_t), intent(out) :: problem !! the increment
    type(answer_t), intent(out) :: answer !! what the run has found
    real(wp) :: against(2), w(3, 3)
    integer :: p, q, n

    n = size(places)
    problem%points = n
    problem%motions = form%condensed%rigid%modes
    allocate (problem%w(3*n, 3*n), problem%r(3*n, problem%motions), problem%mu(2, n))
    allocate (answer%lambda(3*n), answer%gap(3*n), answer%way(2, n), source=0.0_wp)
    allocate (answer%alpha(problem%motions), source=0.0_wp)
    problem%rule = places%rule
    answer%status = merge(system%contact%status(places%element), status_open, places%closed)
    do q = 1, n
      problem%mu(:, q) = places(q)%mu
      do p = q, n
        w = coupling_of(form%condensed, places(p), places(q), .false.)
        problem%w(3*p - 2:3*p, 3*q - 2:3*q) = w
        problem%w(3*q - 2:3*q, 3*p - 2:3*p) = transpose(w)
      end do
      problem%r(3*q - 2:3*q, :) = carried(form%condensed, places(q), problem%motions)
      associate (force => answer%lambda(3*q - 2:3*q), e => places(q)%element)
        if (answer%status(q) == status_open) then
          answer%gap(3*q - 2) = point_state(4, e)
          cycle
        end if
        force = -matmul(point_state(1:3, e), places(q)%frame)
        if (answer%status(q) /= status_slip) cycle
        if (any(problem%mu(:, q) <= 0.0_wp)) cycle
        answer%way(:, q) = force(2:)/norm2(force(2:)/problem%mu(:, q))
        against = answer%way(:, q)*(minval(problem%mu(:, q))/problem%mu(:, q))**problem%rule(q)
        against = against/norm2(against)
        answer%gap(3*q - 1:3*q) = against*min(0.0_wp, dot_product(against, &
          matmul(slip_of(model%mesh%x(:, :size(state%u, 2)) + state%u, system, e), &
          places(q)%frame(:, 2:))))
      end associate
    end do
    problem%b = answer%gap - matmul(problem%w, answer%lambda)
    problem%push = matmul(answer%lambda, problem%r)
  end subroutine set_problem

  !> Second starts at the points that bear least.
  subroutine search(problem, answer, found)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! what the run has found
    type(other_answers_t), intent(inout) :: found !! gets others
    type(answer_t), allocatable :: answers(:)
    real(wp) :: share(problem%points)
    integer :: p, k, most, tried(min(problem%points, most_tried))

    share = [(point_borne(problem%w(3*p - 2:3*p, 3*p - 2), problem%mu(:, p)), p=1, problem%points)]
    do k = 1, size(tried)
      tried(k) = maxloc(share, 1)
      share(tried(k)) = -1.0_wp
    end do
    most = max(1, int(min(real(size(tried), wp), most_work/(of_start*size(problem%b)**3))))
    allocate (answers(1))
    answers(1) = answer
    call second_answers(problem, tried(:most), answers)
    found%tried = most
    allocate (found%others(4, size(answers) - 1))
    do k = 2, size(answers)
      associate (status => answers(k)%status, lambda => answers(k)%lambda)
        found%others(:, k - 1) = [real(count(status > status_open), wp), real(count(status == &
          status_slip), wp), sum(lambda(1::3)), sum(hypot(lambda(2::3), lambda(3::3)))]
      end associate
    end do
  end subroutine search
end module answers_audit
