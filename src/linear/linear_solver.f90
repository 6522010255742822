!> The one linear solver that Newton and the line search call: the back end that the matrix at hand
!! and the user allow, CHOLMOD for symmetric matrices, UMFPACK for unsymmetric ones; or PETSc for
!! all of them, if the program has it.
module linear_solver
  use kinds, only: wp
  use memory, only: memory_left
  use threads, only: count_threads
  use blas_info, only: set_blas_threads
  use text, only: lower, to_text
  use costs, only: cost_t
  use csc_matrix, only: csc_matrix_t
  use block_matrix, only: block_matrix_t
  use back_ends, only: linear_solver_t, nodal_back_end_t, nodes_t, solver_words_t, n_back_ends, &
    solver_unknown, solver_auto, solver_umfpack, solver_cholmod, solver_petsc, solver_reduced, &
    solver_done, solver_out_of_memory, solver_not_definite, solver_singular, solver_failed
  use engines, only: back_end_words, has_engine, start_engine, engine_name
  use ranks, only: count_ranks
  use parallel, only: any_rank
  implicit none
  private
  public :: factorise_matrix, solve_system, start_pattern, solver_name, free_solver, solver_of, &
    solver_list, take_choice, describe_matrix, has_bulk, multiply_taken, rest_solver, refusal, &
    factor_sign, solver_words

  !> What SOLVer and --solver ask for.
  type(solver_words_t), parameter :: solver_words(0:solver_reduced) = [ &
    solver_words_t('AUTO', 'what the model needs (the default); the log says which', ''), &
    back_end_words, solver_words_t('REDUced', 'works on the contact forces', &
    'REDUced, one symmetric factor a body and dense systems of the contact forces')]

  !> From this size on a factor is worth several threads of the BLAS [byte].
  real(wp), parameter :: bytes_for_threads = 5.0e7_wp

contains

  !> From now on a choice of the user's or of the program's is followed.
  pure subroutine take_choice(solver, choice)
    type(linear_solver_t), intent(inout) :: solver !! gets alone, by_nodes
    integer, intent(in) :: choice !! one of the solvers, never AUTO

    solver%alone = choice
    if (choice == solver_cholmod .or. choice > n_back_ends) solver%alone = solver_unknown
    solver%by_nodes = choice == solver_petsc
  end subroutine take_choice

  !> Factorises, unless the values are those of the factor at hand. A symmetric matrix that is not
  !! positive definite goes to UMFPACK.
  subroutine factorise_matrix(solver, a, symmetric, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(inout) :: a !! matrix; is marked as unchanged
    logical, intent(in) :: symmetric !! its values are symmetric
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    outcome = solver_done
    if (.not. a%changed .and. solver%holds /= solver_unknown) return
    a%changed = .false.
    solver%indefinite = .false.
    if (solver%alone /= solver_unknown) then
      call factorise_with(solver, solver%alone, a, costs, outcome)
      return
    end if
    if (symmetric) then
      call factorise_with(solver, solver_cholmod, a, costs, outcome)
      if (outcome /= solver_not_definite) return
      solver%indefinite = .true.
    end if
    call factorise_with(solver, solver_umfpack, a, costs, outcome)
  end subroutine factorise_matrix

  !> The factor of one back end, if it fits into the memory; that of another one goes first.
  subroutine factorise_with(solver, choice, a, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer, intent(in) :: choice !! which one
    type(csc_matrix_t), intent(in) :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer :: k, threads

    do k = 1, n_back_ends
      if (k /= choice .and. allocated(solver%engine(k)%is)) call solver%engine(k)%is%drop_factor()
    end do
    solver%holds = solver_unknown
    if (.not. allocated(solver%engine(choice)%is)) &
      call start_engine(choice, solver%engine(choice)%is)
    outcome = solver_done
    associate (engine => solver%engine(choice)%is)
      if (.not. engine%is_analysed()) then
        call engine%analyse(a, costs, outcome)
        if (outcome == solver_done) call ask_for_memory(solver, engine%factor_bytes(), outcome)
        if (any_rank(outcome /= solver_done) .and. outcome == solver_done) &
          outcome = solver_out_of_memory
      end if
      if (outcome /= solver_done) return
      threads = threads_for(engine%factor_bytes())
      if (threads > 1) call set_blas_threads(threads)
      call engine%factorise(a, costs, outcome)
      if (threads > 1) call set_blas_threads(1)
      if (any_rank(outcome == solver_failed)) outcome = solver_failed
    end associate
    if (outcome == solver_done) solver%holds = choice
  end subroutine factorise_with

  !> Hands a back end by nodes the matrix that the next factorise_matrix is about.
  subroutine describe_matrix(solver, matrix, bulk, equation, nodes, costs)
    type(linear_solver_t), intent(inout) :: solver !! handles; takes matrices by nodes
    type(block_matrix_t), intent(in) :: matrix !! tangent of bulk and contact; apart: contact's
    type(block_matrix_t), intent(in) :: bulk !! tangent of the bulk
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(nodes_t), intent(in) :: nodes !! what is known of the nodes
    type(cost_t), intent(inout) :: costs !! cost table

    if (.not. allocated(solver%engine(solver%alone)%is)) &
      call start_engine(solver%alone, solver%engine(solver%alone)%is)
    select type (engine => solver%engine(solver%alone)%is)
    class is (nodal_back_end_t)
      call engine%describe(matrix, bulk, equation, nodes, costs)
    end select
  end subroutine describe_matrix

  !> The back end by nodes keeps the bulk's share of the matrix.
  logical function has_bulk(solver) result(has)
    type(linear_solver_t), intent(in) :: solver !! handles; takes matrices by nodes

    has = .false.
    select type (engine => solver%engine(solver%alone)%is)
    class is (nodal_back_end_t)
      has = engine%has_bulk()
    end select
  end function has_bulk

  !> y = A x, or |A| |x|, with A the share of the bulk between free degrees of freedom.
  subroutine multiply_taken(solver, equation, x, absolute, y)
    type(linear_solver_t), intent(inout) :: solver !! has it
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    logical, intent(in) :: absolute !! |A| |x|
    real(wp), intent(out) :: y(:, :) !! (3, nodes) 0 where restrained

    y = 0.0_wp
    select type (engine => solver%engine(solver%alone)%is)
    class is (nodal_back_end_t)
      call engine%multiply(equation, x, absolute, y)
    end select
  end subroutine multiply_taken

  !> An increment is done: a back end by nodes gives back what the next matrix renews.
  subroutine rest_solver(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles

    if (.not. solver%by_nodes .or. solver%holds == solver_unknown) return
    call solver%engine(solver%holds)%is%drop_factor()
    solver%holds = solver_unknown
  end subroutine rest_solver

  !> Why this program cannot take a solver, and what to do, in two lines; empty if it can.
  function refusal(solver) result(text)
    integer, intent(in) :: solver !! one of the solvers
    character(:), allocatable :: text

    text = ''
    if (solver == solver_petsc .and. .not. has_engine(solver_petsc)) then
      text = 'this program has no PETSc'//new_line('a')// &
        '  build ./mfec-petsc by make PETSC=1 and run that, or leave the choice to AUTO'
    else if (count_ranks() > 1 .and. solver > solver_auto .and. solver /= solver_petsc) then
      text = 'this solver works on one rank, and mpirun has started '//to_text(count_ranks())// &
        new_line('a')//'  use the solver PETSc or AUTO, or run without mpirun'
    end if
  end function refusal

  !> Threads of the BLAS for one factor: all of the program's if it is large, else one.
  integer function threads_for(bytes) result(n)
    real(wp), intent(in) :: bytes !! size of the factor [byte]

    n = 1
    if (bytes > bytes_for_threads) n = count_threads()
  end function threads_for

  !> Compares the memory of a coming factor with what is left, and with what an earlier factor had.
  subroutine ask_for_memory(solver, bytes, outcome)
    type(linear_solver_t), intent(inout) :: solver !! gets granted, or wanted and left
    real(wp), intent(in) :: bytes !! memory of the factor [byte]
    integer, intent(out) :: outcome !! done, or out of memory

    outcome = solver_done
    if (bytes <= solver%granted) return
    solver%left = memory_left() + solver%granted
    if (bytes > solver%left) then
      solver%wanted = bytes
      outcome = solver_out_of_memory
    else
      solver%granted = bytes
    end if
  end subroutine ask_for_memory

  !> x = A^-1 b with the last factor.
  subroutine solve_system(solver, a, b, x, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in) :: a !! the matrix that was factorised
    real(wp), intent(in), contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    outcome = solver_singular
    if (solver%holds == solver_unknown) return
    solver%engine(solver%holds)%is%accuracy = solver%accuracy
    call solver%engine(solver%holds)%is%solve(a, b, x, costs, outcome)
    if (any_rank(outcome == solver_failed)) outcome = solver_failed
  end subroutine solve_system

  !> Sign of the determinant of the matrix factorised last, 0 if that is not known; CHOLMOD has
  !! factors of positive definite ones alone.
  integer function factor_sign(solver) result(s)
    type(linear_solver_t), intent(in) :: solver !! handles

    s = 0
    if (solver%holds == solver_cholmod) s = 1
    if (solver%holds == solver_cholmod .or. solver%holds == solver_unknown) return
    s = solver%engine(solver%holds)%is%determinant_sign()
  end function factor_sign

  !> Drops analyses and factors: the pattern has changed.
  subroutine start_pattern(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer :: k

    do k = 1, n_back_ends
      if (allocated(solver%engine(k)%is)) call solver%engine(k)%is%forget_pattern()
    end do
    solver%holds = solver_unknown
  end subroutine start_pattern

  !> Name of the back end that has the factor.
  pure function solver_name(solver) result(name)
    type(linear_solver_t), intent(in) :: solver !! handles
    character(:), allocatable :: name

    name = 'none'
    if (solver%holds /= solver_unknown) name = engine_name(solver%holds)
  end function solver_name

  !> The solver that a word of SOLVer or --solver means; four letters count.
  pure integer function solver_of(word) result(solver)
    character(*), intent(in) :: word !! what a deck or a user has written
    character(4) :: short, key
    integer :: k

    short = lower(word)
    solver = solver_unknown
    do k = lbound(solver_words, 1), ubound(solver_words, 1)
      key = lower(solver_words(k)%word)
      if (short == key) solver = k
    end do
  end function solver_of

  !> The words of all solvers.
  pure function solver_list(separator, last) result(text)
    character(*), intent(in) :: separator !! between two of them
    character(*), intent(in) :: last !! before the last one
    character(:), allocatable :: text
    integer :: k

    text = 'AUTO'
    do k = solver_auto + 1, solver_reduced
      if (k < solver_reduced) text = text//separator
      if (k == solver_reduced) text = text//last
      text = text//trim(solver_words(k)%word)
    end do
  end function solver_list

  !> Releases everything.
  subroutine free_solver(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer :: k

    do k = 1, n_back_ends
      if (allocated(solver%engine(k)%is)) call solver%engine(k)%is%free()
    end do
    solver%holds = solver_unknown
  end subroutine free_solver
end module linear_solver
