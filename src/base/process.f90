!> The process as the system sees it: its memory, and its end with an exit code and without a word
!! (Fortran's stop prints to standard error).
module process
  use, intrinsic :: iso_c_binding, only: c_int, c_char, c_null_char, c_funptr, c_funloc, c_ptr, &
    c_null_ptr, c_associated, c_loc
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use errors, only: exit_resources
  use libc, only: c_fopen, c_fileno, c_fclose
  use signals, only: last_words
  implicit none
  private
  public :: end_process, catch_lack_of_memory, open_standard_files, &
    wait_passively, start_again, set_variable

  !> Exit code of Fortran's runtime when the system refuses something, memory for the most part.
  integer(c_int), parameter :: runtime_refused = 1_c_int
  !> What is said then, and what to do.
  character(*, c_char), parameter :: no_memory = 'error: out of memory'
  character(*, c_char), parameter :: memory_remedy &
    = new_line('a')//'  use a coarser mesh, a machine '// &
    'with more memory, or a higher limit (ulimit -v); what has been written is valid'

  !> Whether the program ends by itself: the runtime calls no procedure of ours when it gives up.
  logical :: ended = .false.

  interface
    !> C's exit.
    subroutine c_exit(status) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status !! exit code
    end subroutine c_exit

    !> glibc's on_exit: calls a procedure with the exit code when the program ends.
    integer(c_int) function c_on_exit(handler, argument) bind(c, name='on_exit')
      import :: c_int, c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: handler !! the procedure
      type(c_ptr), value :: argument !! its second argument
    end function c_on_exit

    !> C's _exit.
    subroutine c_end_now(status) bind(c, name='_exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status !! exit code
    end subroutine c_end_now

    !> C's setenv.
    integer(c_int) function c_setenv(name, value, overwrite) bind(c, name='setenv')
      import :: c_int, c_char
      implicit none
      character(kind=c_char), intent(in) :: name(*) !! closed by a null character
      character(kind=c_char), intent(in) :: value(*) !! closed by a null character
      integer(c_int), value :: overwrite !! 0: what is set stays
    end function c_setenv

    !> C's execv: another program in this process; returns where that failed.
    integer(c_int) function c_execv(path, arguments) bind(c, name='execv')
      import :: c_int, c_char, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*) !! closed by a null character
      type(c_ptr), intent(in) :: arguments(*) !! closed by a null pointer
    end function c_execv
  end interface

contains

  !> Threads that wait shall look a few times and sleep then: to spin takes the processor of a busy
  !! machine from those that are waited for, to wake up takes as long as many a region has to do.
  !! Unless the user has said what they do.
  subroutine wait_passively(again)
    logical, intent(inout) :: again !! gets true if the program has to start anew for it
    character(*), parameter :: policy = 'OMP_WAIT_POLICY', looks = '2000'
    integer :: status
    logical :: set

    call get_environment_variable(policy, status=status)
    if (status == 0) return
    call set_variable('GOMP_SPINCOUNT', looks, set)
    call set_variable(policy, 'PASSIVE', set)
    again = again .or. set
  end subroutine wait_passively

  !> Libraries read variables before the first statement of the program: it starts itself once more
  !! with what has been set, in the same process. Returns only where that fails.
  subroutine start_again()
    character(kind=c_char), allocatable, target :: text(:)
    character(:), allocatable :: word
    type(c_ptr), allocatable :: arguments(:)
    integer :: i, k, n, length, filled
    integer(c_int) :: ignored

    n = command_argument_count()
    filled = 0
    do i = 0, n
      call get_command_argument(i, length=length)
      filled = filled + length + 1
    end do
    allocate (text(filled), arguments(0:n + 1))
    text = c_null_char
    arguments(n + 1) = c_null_ptr
    filled = 0
    do i = 0, n
      call get_command_argument(i, length=length)
      allocate (character(length) :: word)
      call get_command_argument(i, word)
      do k = 1, length
        text(filled + k) = word(k:k)
      end do
      arguments(i) = c_loc(text(filled + 1))
      filled = filled + length + 1
      deallocate (word)
    end do
    ignored = c_execv('/proc/self/exe'//c_null_char, arguments)
  end subroutine start_again

  !> Sets an environment variable that a library asks for; what the user has set stays.
  subroutine set_variable(name, value, done)
    character(*), intent(in) :: name !! of the variable
    character(*), intent(in) :: value !! its text
    logical, intent(out) :: done !! it is set

    done = c_setenv(name//c_null_char, value//c_null_char, 0_c_int) == 0_c_int
  end subroutine set_variable

  !> Opens /dev/null in place of standard input, output and error where they are closed: a file of
  !! the run must not get their numbers.
  subroutine open_standard_files()
    integer(c_int), parameter :: last_standard = 2_c_int
    type(c_ptr) :: stream
    integer(c_int) :: ignored

    do
      stream = c_fopen('/dev/null'//c_null_char, 'r+'//c_null_char)
      if (.not. c_associated(stream)) return
      if (c_fileno(stream) <= last_standard) cycle
      ignored = c_fclose(stream)
      return
    end do
  end subroutine open_standard_files

  !> Flushes standard output and standard error, and ends.
  subroutine end_process(code, at_once)
    integer, intent(in) :: code !! exit code
    logical, intent(in), optional :: at_once !! without what libraries do at the end
    integer :: status
    logical :: now

    ended = .true.
    flush (output_unit, iostat=status)
    if (status == 0) flush (error_unit, iostat=status)
    ! nobody reads any more: the runtime must not try again
    now = status /= 0
    if (present(at_once)) now = now .or. at_once
    if (now) call c_end_now(int(code, c_int))
    call c_exit(int(code, c_int))
  end subroutine end_process

  !> From now on the program ends with exit code 3 where the runtime finds no memory.
  subroutine catch_lack_of_memory()
    integer(c_int) :: ignored

    ignored = c_on_exit(c_funloc(mend_exit_code), c_null_ptr)
  end subroutine catch_lack_of_memory

  !> At the end of the program: Fortran's runtime ends with 1 when an allocation of its own fails.
  subroutine mend_exit_code(status, argument) bind(c)
    integer(c_int), value :: status !! exit code
    type(c_ptr), value :: argument !! not used

    if (ended .or. status /= runtime_refused) return
    if (storage_size(argument) == 0) return
    call last_words(no_memory//' in a procedure of the runtime'//memory_remedy)
    call c_end_now(int(exit_resources, c_int))
  end subroutine mend_exit_code

  !> Called by the code that gfortran makes of ALLOCATE, in place of its runtime's procedure, where
  !! the memory does not suffice: says where, and ends with exit code 3.
  subroutine refuse_allocation(place, message) bind(c, name='_gfortran_os_error_at')
    character(kind=c_char), intent(in) :: place(*) !! In file 'x.f90', around line n
    character(kind=c_char), intent(in) :: message(*) !! what was refused; more arguments follow
    integer, parameter :: longest_name = 200
    character(longest_name, c_char) :: text
    integer :: n

    n = 0
    do while (n < longest_name)
      if (place(n + 1) == c_null_char) exit
      n = n + 1
      text(n:n) = place(n)
    end do
    if (message(1) /= c_null_char) call last_words(no_memory//': '//text(:n)//memory_remedy)
    call c_end_now(int(exit_resources, c_int))
  end subroutine refuse_allocation
end module process
