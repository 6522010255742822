!> The log (.log): what the run is, one line per iteration, one per increment, and what it cost.
!!
!! Nothing is created before the deck has been accepted: the run layer calls `create_log` then. A
!! log that is not open takes every line and drops it.
module run_log
  use, intrinsic :: iso_c_binding, only: c_associated, c_int
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text, range_text, count_noun
  use memory, only: peak_memory
  use signals, only: note_log
  use libc, only: c_fileno
  use costs, only: cost_t, cost_names, n_costs
  use contact_points, only: used_points
  use contact_parameters, only: has_field
  use contact_types, only: pair_t, penalty_nodal, penalty_area, penalty_auto
  use bulk_laws, only: laws
  use monitors, only: iteration_t
  use result_types, only: origin_t
  use friction_laws, only: cone_laws, first_value, acts
  use model_types, only: model_t, material_t
  use text_files, only: text_file_t, create_locked_file, write_line, flush_text_file, &
    close_text_file
  implicit none
  private
  public :: log_brief, log_normal, log_full, log_level
  public :: log_t, log_increment_t, create_log, log_line, log_warning, &
    log_iteration, log_increment, log_cut, log_costs, close_log

  !> How much is logged: no iterations; these; also where each is worst, and all tables of audits.
  integer, parameter :: log_brief = 1, log_normal = 2, log_full = 3

  !> A log open for writing.
  type :: log_t
    type(text_file_t) :: file !! its file
    integer :: level = log_normal !! how much is logged
    integer :: warnings = 0 !! warnings so far
    integer :: iterations = 0 !! iterations so far
    integer :: increments = 0 !! converged increments so far
    integer :: cuts = 0 !! cuts so far
    integer :: free_dofs = 0 !! degrees of freedom that are not prescribed
  end type log_t

  !> What is known after one converged increment.
  type :: log_increment_t
    integer :: step = 0 !! number of the end time it works for
    integer :: increment = 0 !! number of the increment in this step
    real(wp) :: time = 0.0_wp !! time of its end [time]
    real(wp) :: size = 0.0_wp !! its size [time]
    integer :: iterations = 0 !! solves it took
    real(wp) :: residual = 0.0_wp !! norm of the residual at its end [force]
    real(wp) :: seconds = 0.0_wp !! wall-clock time of the increment [s]
  end type log_increment_t

contains

  !> Creates the log and writes what the run is.
  subroutine create_log(log, path, model, origin, free_dofs, error)
    type(log_t), intent(out) :: log !! the log, open
    character(*), intent(in) :: path !! file name
    type(model_t), intent(in) :: model !! the problem, its pairs built
    type(origin_t), intent(in) :: origin !! what makes it
    integer, intent(in) :: free_dofs !! degrees of freedom that are not prescribed
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call create_locked_file(log%file, path, error)
    if (allocated(error)) return
    call note_log(c_fileno(log%file%stream))
    log%free_dofs = free_dofs
    call log_line(log, origin%program//new_line('a')//'title     '//model%title//new_line('a')// &
      'deck      '//origin%settings//new_line('a')//'BLAS      '//origin%blas//new_line('a')// &
      'mesh      '//count_noun(count(model%mesh%defined), 'node')//', '// &
      count_noun(count(model%mesh%ix(1, :) > 0), 'element')//', '// &
      count_noun(free_dofs, 'free dof'), error)
    do i = 1, size(model%materials)
      call log_line(log, 'material  '//material_line(model%materials(i)), error)
    end do
    do i = 1, size(model%pairs)
      call log_line(log, 'pair      '//pair_line(model%pairs(i)), error)
    end do
    do i = 1, size(model%notes)
      call log_line(log, model%notes(i)%s, error)
    end do
    call log_line(log, '', error)
  end subroutine create_log

  !> The level of a word, 0 if it is none.
  pure integer function log_level(word) result(level)
    character(*), intent(in) :: word !! brief, normal or full
    character(6), parameter :: levels(3) = [character(6) :: 'brief', 'normal', 'full']

    do level = size(levels), 1, -1
      if (word == levels(level)) return
    end do
  end function log_level

  !> A material in one line.
  function material_line(material) result(line)
    type(material_t), intent(in) :: material !! the material
    character(:), allocatable :: line
    integer :: k

    line = to_text(material%number)
    if (len_trim(material%label) > 0) line = line//' '//trim(material%label)
    if (material%rigid) then
      line = line//': rigid'
      return
    end if
    line = line//': '//trim(laws(material%law)%words)
    if (material%mean) line = line//', volume by the mean dilatation of each element'
    if (material%nodal) line = line//', volume by the dilatation of the nodes'
    line = line//', E = '//to_text(material%youngs_modulus)//', nu = '// &
      to_text(material%poissons_ratio)
    do k = 1, laws(material%law)%count
      line = line//', '//trim(laws(material%law)%parameters(k)%name)//' = '// &
        to_text(material%own(k))
    end do
  end function material_line

  !> A contact pair in one line, with the penalty that is used.
  function pair_line(pair) result(line)
    type(pair_t), intent(in) :: pair !! the pair
    character(:), allocatable :: line
    character(10), parameter :: rule_words(0:2) = [character(10) :: 'collinear', 'tensor', &
      'associated']

    line = pair%name//': '//pair%slave//' on '//pair%master//', '// &
      count_noun(used_points(pair), 'point')//' against '// &
      count_noun(size(pair%surface%facets, 2), 'facet')//penalty_text(pair)
    if (maxval(pair%friction%mu) > 0.0_wp) then
      line = line//', mu '//to_text(pair%friction%mu(1))//' and '// &
        to_text(pair%friction%mu(2))//', slip '// &
        trim(rule_words(pair%friction%slip_rule))//law_text(pair%law)
    else
      line = line//', frictionless'
    end if
    if (pair%points%n_slaves > 1 .and. .not. pair%mortar) line = line//', GTOS'
    if (pair%augmented) line = line//', AUGMent'
    if (pair%smooth) line = line//', SMOOth'
  end function pair_line

  !> The penalty that is used and where it comes from, or what stands for it.
  function penalty_text(pair) result(t)
    type(pair_t), intent(in) :: pair !! the pair
    character(:), allocatable :: t

    if (pair%mortar) then
      t = ', MORTar'
      return
    end if
    t = ', penalty '
    if (pair%segmented) then
      t = t//to_text(pair%points%density)//' force/length^3 times the area of a point'
    else if (size(pair%points%epsilon) > 0) then
      t = t//range_text(pair%points%epsilon)
    end if
    if (.not. pair%segmented) t = t//' force/length a point'
    t = t//penalty_origin(pair)
  end function penalty_text

  !> The laws that change the cone, with their values.
  function law_text(values) result(t)
    real(wp), intent(in) :: values(:) !! of the pair
    character(:), allocatable :: t
    integer :: i, k

    t = ''
    do k = 1, size(cone_laws)
      if (.not. acts(k, values)) cycle
      t = t//', '//trim(cone_laws(k)%keyword)
      do i = first_value(k), first_value(k + 1) - 1
        t = t//' '//to_text(values(i))
      end do
    end do
  end function law_text

  !> Where the penalty of a pair comes from.
  function penalty_origin(pair) result(text)
    type(pair_t), intent(in) :: pair !! the pair
    character(:), allocatable :: text

    text = ''
    if (has_field(pair) .and. pair%points%relative > 0.0_wp) then
      text = ' (that of AUGMent on slave facets)'
      return
    end if
    select case (pair%penalty_kind)
    case (penalty_nodal)
    case (penalty_area)
      text = ' ('//to_text(pair%penalty)//' times its area)'
    case (penalty_auto)
      text = ' (AUTO, factor '//to_text(pair%penalty)//')'
    case default
      text = ' (AUTO)'
    end select
  end function penalty_origin

  !> Writes one line (or several) and hands it to the system.
  subroutine log_line(log, line, error)
    type(log_t), intent(inout) :: log !! the log
    character(*), intent(in) :: line !! any text
    type(error_t), allocatable, intent(inout) :: error !! disk full

    if (.not. c_associated(log%file%stream)) return
    call write_line(log%file, line, error)
    call flush_text_file(log%file, error)
  end subroutine log_line

  !> Writes a warning and counts it.
  subroutine log_warning(log, message, error)
    type(log_t), intent(inout) :: log !! the log
    character(*), intent(in) :: message !! the warning
    type(error_t), allocatable, intent(inout) :: error !! disk full

    log%warnings = log%warnings + 1
    call log_line(log, 'warning: '//message, error)
  end subroutine log_warning

  !> Writes the line of one iteration.
  subroutine log_iteration(log, step, it, error)
    type(log_t), intent(inout) :: log !! the log
    integer, intent(in) :: step !! number of the end time it works for
    type(iteration_t), intent(in) :: it !! what is known after it
    type(error_t), allocatable, intent(inout) :: error !! disk full
    character(200) :: line

    log%iterations = log%iterations + 1
    if (log%level == log_brief) return
    write (line, '(2a,es12.5,2a,2(a,es12.5),a,f7.4,8a,4x,f9.3,a)') 'step '//padded(step, 5), &
      ' time ', it%time, ' iteration ', padded(it%number, 2), '  Residual norm = ', &
      it%residual, '  Energy convergence test = ', it%energy, '  line search', it%step_length, &
      '  active ', padded(it%active, 5), ' stick ', padded(it%stick, 5), ' slip ', &
      padded(it%slip, 5), '  ', it%solver, it%seconds, ' s'
    call log_line(log, line, error)
  end subroutine log_iteration

  !> Writes the line of one converged increment.
  subroutine log_increment(log, increment, error)
    type(log_t), intent(inout) :: log !! the log
    type(log_increment_t), intent(in) :: increment !! what is known at its end
    type(error_t), allocatable, intent(inout) :: error !! disk full
    character(160) :: line

    log%increments = log%increments + 1
    if (log%level == log_brief) return
    write (line, '(5a,es12.5,a,es12.5,3a,es12.5,a,f9.3,a)') 'step ', padded(increment%step, 5), &
      ' increment ', padded(increment%increment, 4), ' converged: time ', increment%time, &
      ' size ', increment%size, ' solves ', padded(increment%iterations, 2), ' residual ', &
      increment%residual, '  ', increment%seconds, ' s'
    call log_line(log, line, error)
  end subroutine log_increment

  !> A number in so many places, or in as many as it needs.
  pure function padded(n, width) result(text)
    integer, intent(in) :: n !! the number
    integer, intent(in) :: width !! places at least
    character(:), allocatable :: text

    text = to_text(n)
    text = repeat(' ', max(0, width - len(text)))//text
  end function padded

  !> Writes the line of a cut.
  subroutine log_cut(log, step, time, old_size, new_size, reason, error)
    type(log_t), intent(inout) :: log !! the log
    integer, intent(in) :: step !! number of the end time it works for
    real(wp), intent(in) :: time !! time of the last converged increment [time]
    real(wp), intent(in) :: old_size !! increment that failed [time]
    real(wp), intent(in) :: new_size !! increment tried next [time]
    character(*), intent(in) :: reason !! why it failed
    type(error_t), allocatable, intent(inout) :: error !! disk full

    log%cuts = log%cuts + 1
    call log_line(log, 'step '//to_text(step)//' cut: from time '//to_text(time)//', size '// &
      to_text(old_size)//' to '//to_text(new_size)//': '//reason, error)
  end subroutine log_cut

  !> Writes the cost table.
  subroutine log_costs(log, costs, seconds, variant, error)
    type(log_t), intent(inout) :: log !! the log
    type(cost_t), intent(in) :: costs !! counts and seconds
    real(wp), intent(in) :: seconds !! wall-clock time of the whole run [s]
    real(wp), intent(in), optional :: variant(:) !! (n_costs+1) seconds of these and of all, per
    !! variant of a study [s]
    type(error_t), allocatable, intent(inout) :: error !! disk full
    character(80) :: line
    real(wp) :: processor
    character(:), allocatable :: head
    integer :: i

    head = ''
    if (present(variant)) head = '  per variant'
    call log_line(log, new_line('a')//count_noun(log%increments, 'increment')//', '// &
      count_noun(log%iterations, 'iteration')//', '//count_noun(log%cuts, 'cut')//', '// &
      count_noun(log%warnings, 'warning')//new_line('a')//new_line('a')// &
      'cost                                count      seconds'//head, error)
    do i = 1, n_costs
      write (line, '(a,i13,f13.3)') cost_names(i), costs%count(i), costs%seconds(i)
      if (present(variant)) write (line(55:), '(f13.4)') variant(i)
      call log_line(log, line, error)
    end do
    write (line, '(a,t42,f13.3)') 'whole run', seconds
    if (present(variant)) write (line(55:), '(f13.4)') variant(n_costs + 1)
    call log_line(log, line, error)
    call cpu_time(processor)
    write (line, '(a,t42,f13.3)') 'processor time of all threads', processor
    call log_line(log, line, error)
    write (line, '(a,t42,f13.3)') 'peak memory, MB', 1.0e-6_wp*peak_memory()
    call log_line(log, line, error)
    if (log%free_dofs == 0) return
    write (line, '(a,t42,f13.3)') 'memory per free dof, kB', &
      1.0e-3_wp*peak_memory()/real(log%free_dofs, wp)
    call log_line(log, line, error)
  end subroutine log_costs

  !> Closes the log; one that was never created is left alone.
  subroutine close_log(log, error)
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(inout) :: error !! disk full

    call note_log(-1_c_int)
    call close_text_file(log%file, error)
  end subroutine close_log
end module run_log
