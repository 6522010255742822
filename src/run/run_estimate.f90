!> What a run will take, before it starts (doc/manual, "What a run will take"): the analysis of each
!! body's matrix tells memory and operations of the factors; what is kept for a node, an element or
!! a point, and how often an increment solves, was measured.
module run_estimate
  use kinds, only: wp
  use text, only: to_text
  use json_lines, only: item, print_record
  use memory, only: memory_text
  use lapack_interface, only: dpotrf
  use contact_points, only: count_points
  use back_ends, only: solver_reduced, solver_umfpack
  use solver_choice, only: foresee_choice
  use candidates, only: foresee_candidates, dense_share
  use condensed_bodies, only: foresee_body
  use condensed_types, only: condensed_t
  use system_building, only: fill_system
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  use terminal, only: terminal_t, print_line
  implicit none
  private
  public :: estimate_t, estimate_run, tell_estimate

  !> What is foreseen.
  type :: estimate_t
    logical :: condensed = .false. !! the bulk is factorised once, then contact forces alone
    integer :: unknowns = 0 !! free degrees of freedom
    integer :: interface = 0 !! of them those at which contact may act
    real(wp) :: factor = 0.0_wp !! memory of the factors [byte]
    real(wp) :: operator = 0.0_wp !! memory of the contact operator [byte]
    real(wp) :: memory = 0.0_wp !! of the run, at its largest [byte]
    real(wp) :: results = 0.0_wp !! size of the results files [byte]
    real(wp) :: once = 0.0_wp !! products and sums before the first increment
    real(wp) :: increment = 0.0_wp !! products and sums of an increment
    integer :: end_times = 0 !! increments, if none is cut
    real(wp) :: rate = 0.0_wp !! products and sums that this machine does on one thread [1/s]
  end type estimate_t

contains

  !> Foresees a run. The condensed form of the system is used for that and dropped.
  subroutine estimate_run(model, system, form, end_times, estimate)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(inout) :: system !! its outline; gets the matrix of the bulk
    type(form_t), intent(inout) :: form !! gets condensed, its kind, matrix
    integer, intent(in) :: end_times !! of the deck
    type(estimate_t), intent(out) :: estimate !! what it will take

    call fill_system(model, system, form)
    allocate (form%condensed%candidate(model%mesh%nodes), source=.false.)
    call foresee_candidates(model, system, form%condensed%candidate)
    where (.not. any(system%equation > 0, 1)) form%condensed%candidate = .false.
    estimate%end_times = end_times
    estimate%unknowns = system%equations
    estimate%interface = count(system%equation > 0 .and. spread(form%condensed%candidate, 1, 3))
    if (foresee_choice(model, system, form) == solver_reduced .and. system%equations > 0) &
      estimate%condensed = form%whole%asked == solver_reduced .or. &
      dense_share(model, system, form%condensed) <= 1.0_wp
    if (.not. estimate%condensed) form%condensed%candidate = .false.
    call add_bodies(model, system, form, estimate)
    form%condensed = condensed_t()
    call foresee_files(model, estimate)
    estimate%rate = measured_rate()
  end subroutine estimate_run

  !> Memory and operations of all bodies.
  subroutine add_bodies(model, system, form, estimate)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! with candidates, if it is condensed
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    type(estimate_t), intent(inout) :: estimate !! gets factor, operator, memory, once, increment
    !> Measured over 20 decks: program and libraries, and what is kept for a node [byte]; linear
    !! solves of an increment (1 to 13); memory and work of an unsymmetric factor with contact over
    !! those of the bodies' symmetric ones; operations of fields, sums and audit for a node, and of
    !! the start.
    real(wp), parameter :: bytes_of_program = 2.6e7_wp, with_contact = 9.0e6_wp, &
      bytes_of_node = 4900.0_wp, mean_solves = 5.0_wp, unsymmetric = 5.0_wp, &
      node_work = 6.0e4_wp, start_work = 3.0e8_wp
    real(wp) :: needed, work, entries, rows
    integer :: b, m

    allocate (form%condensed%bodies(system%body%bodies))
    form%condensed%rigid%x = model%mesh%x
    rows = 0.0_wp
    do b = 1, system%body%bodies
      call foresee_body(system, form, b, needed, work, entries, m)
      estimate%operator = estimate%operator + 8.0_wp*real(m, wp)**2
      estimate%factor = estimate%factor + needed - 8.0_wp*real(m, wp)**2
      estimate%once = estimate%once + work
      estimate%increment = estimate%increment + 4.0_wp*entries
      rows = rows + merge(real(m, wp)**2, 4.0_wp*entries, m > 0)
    end do
    if (estimate%condensed) then
      estimate%increment = estimate%increment + mean_solves*(rows + contact_work(model, estimate))
    else
      if (foresee_choice(model, system, form) == solver_umfpack .or. size(model%pairs) > 0) then
        estimate%factor = unsymmetric*estimate%factor
        estimate%once = unsymmetric*estimate%once
      end if
      estimate%increment = estimate%increment + mean_solves*estimate%once
      estimate%once = 0.0_wp
    end if
    estimate%once = estimate%once + start_work
    estimate%increment = estimate%increment + node_work*real(model%mesh%nodes, wp)
    estimate%memory = bytes_of_program + bytes_of_node*real(model%mesh%nodes, wp) &
      + estimate%factor + estimate%operator
    if (size(model%pairs) > 0) estimate%memory = estimate%memory + with_contact
  end subroutine add_bodies

  !> Products and sums of a dense system of contact forces: three rows a point that may touch.
  pure real(wp) function contact_work(model, estimate) result(work)
    type(model_t), intent(in) :: model !! pairs
    type(estimate_t), intent(in) :: estimate !! interface
    integer :: k, points

    points = 0
    do k = 1, size(model%pairs)
      points = points + count_points(model%pairs(k))/model%pairs(k)%points%slots
    end do
    work = real(min(3*points, estimate%interface), wp)**3/3.0_wp
  end function contact_work

  !> Size of x.vtkhdf and x.contact.vtkhdf.
  subroutine foresee_files(model, estimate)
    type(model_t), intent(in) :: model !! mesh, pairs, what is asked for
    type(estimate_t), intent(inout) :: estimate !! gets results
    !> Numbers of a node, an element, a contact point, a node and a facet of a surface at an end
    !! time; of a node in a state; bytes of a number with its share of tables, and of a file's head.
    real(wp), parameter :: per_node = 12.0_wp, per_element = 6.0_wp, per_point = 22.0_wp, &
      per_corner = 14.0_wp, per_facet = 4.0_wp, per_state = 13.0_wp, &
      bytes_of_number = 8.8_wp, bytes_of_head = 3.5e5_wp
    real(wp) :: nodes, each
    integer :: k, times

    nodes = real(count(model%mesh%defined), wp)
    each = per_node*nodes + per_element*real(count(model%mesh%ix(1, :) > 0), wp)
    if (model%output%contact) then
      do k = 1, size(model%pairs)
        associate (pair => model%pairs(k))
          each = each + per_point*real(count_points(pair), wp)
          each = each + (per_facet + 0.5_wp*per_corner)*real(size(pair%surface%facets, 2), wp)
          if (allocated(pair%points%side%facets)) each = each + &
            (per_facet + 0.5_wp*per_corner)*real(size(pair%points%side%facets, 2), wp)
        end associate
      end do
    end if
    times = estimate%end_times/max(1, model%output%every)
    estimate%results = bytes_of_head*real(merge(2, 1, size(model%pairs) > 0), wp) &
      + bytes_of_number*(each*real(times, wp) &
      + per_state*nodes*real(model%output%kept_states + 1, wp))
  end subroutine foresee_files

  !> Products and sums a second of processor time, by the factor of a dense matrix; the first one
  !! warms the machine.
  real(wp) function measured_rate() result(rate)
    integer, parameter :: rows = 400
    !> Factors of sparse matrices have small dense blocks, which are slower.
    real(wp), parameter :: sparse_share = 0.33_wp
    real(wp), allocatable :: a(:, :)
    real(wp) :: began, ended
    integer :: trial, i, info

    do trial = 1, 2
      allocate (a(rows, rows), source=1.0_wp)
      do i = 1, rows
        a(i, i) = real(2*rows, wp)
      end do
      call cpu_time(began)
      call dpotrf('L', rows, a, rows, info)
      call cpu_time(ended)
      deallocate (a)
    end do
    rate = sparse_share*real(rows, wp)**3/3.0_wp/max(ended - began, 1.0e-6_wp)
  end function measured_rate

  !> Shows it: two lines, or a record for a program.
  subroutine tell_estimate(estimate, terminal)
    type(estimate_t), intent(in) :: estimate !! what a run will take
    type(terminal_t), intent(inout) :: terminal !! standard output
    real(wp) :: seconds, one

    one = estimate%increment/estimate%rate
    seconds = estimate%once/estimate%rate + real(estimate%end_times, wp)*one
    if (terminal%json) call print_record('estimate', item('unknowns', estimate%unknowns)// &
      item('interface_unknowns', estimate%interface)//item('form', &
      trim(merge('condensed', 'full     ', estimate%condensed)))// &
      item('factor_bytes', estimate%factor)//item('operator_bytes', estimate%operator)// &
      item('memory_bytes', estimate%memory)//item('results_bytes', estimate%results)// &
      item('operations_once', estimate%once)//item('operations_increment', estimate%increment)// &
      item('end_times', estimate%end_times)//item('operations_a_second', estimate%rate)// &
      item('seconds_increment', one)//item('seconds', seconds))
    call print_line(terminal, 'memory    about '//memory_text(estimate%memory)//': factors '// &
      memory_text(estimate%factor)//' for '//to_text(estimate%unknowns)//' unknowns, contact '// &
      'operator '//memory_text(estimate%operator)//' for '//to_text(estimate%interface)// &
      ' at contact; results '//memory_text(estimate%results))
    call print_line(terminal, 'time      about '//to_text(seconds, 2)//' s: '// &
      to_text(1.0e-9_wp*estimate%once, 2)//'E9 operations before the first increment and '// &
      to_text(1.0e-9_wp*estimate%increment, 2)//'E9 in each of '//to_text(estimate%end_times)// &
      ', '//to_text(1.0e-9_wp*estimate%rate, 2)//'E9 a second on one thread')
  end subroutine tell_estimate
end module run_estimate
