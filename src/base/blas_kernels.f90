!> Which kernels OpenBLAS runs on. It knows processors by their model: one that is newer than the
!! library gets kernels of 2004, with which a factorisation takes a third to a half longer. What
!! such a processor can do is asked of the system instead.
module blas_kernels
  use blas_info, only: blas_core
  use process, only: set_variable
  implicit none
  private
  public :: choose_kernels, kernels_for

  !> The variable that OpenBLAS reads before the first statement of a program.
  character(*), parameter :: variable = 'OPENBLAS_CORETYPE'
  !> Kernels without AVX, which OpenBLAS falls back on; each between blanks.
  character(*), parameter :: old_kernels = ' Prescott Core2 Penryn Dunnington Nehalem Athlon '// &
    'Opteron Opteron_SSE3 Barcelona Bobcat Atom Nano '
  !> What the better ones need.
  character(8), parameter :: wide(5) = [character(8) :: 'avx512f', 'avx512dq', 'avx512cd', &
    'avx512bw', 'avx512vl'], medium(2) = [character(8) :: 'avx2', 'fma']

contains

  !> Asks OpenBLAS for better kernels than it has found, if there are; the user's own choice stays.
  subroutine choose_kernels(again)
    logical, intent(inout) :: again !! gets true if the program has to start anew for them
    character(:), allocatable :: kernels
    integer :: status
    logical :: set

    call get_environment_variable(variable, status=status)
    if (status == 0) return
    if (index(old_kernels, ' '//blas_core()//' ') == 0) return
    kernels = kernels_for(blas_core(), processor_flags())
    if (kernels == '') return
    call set_variable(variable, kernels, set)
    again = again .or. set
  end subroutine choose_kernels

  !> The kernels for a processor, '' where those that OpenBLAS has found are as good.
  pure function kernels_for(core, flags) result(kernels)
    character(*), intent(in) :: core !! what OpenBLAS has found
    character(*), intent(in) :: flags !! what the processor can do, between blanks
    character(:), allocatable :: kernels

    kernels = ''
    if (core == '' .or. index(old_kernels, ' '//core//' ') == 0) return
    if (has(flags, medium)) kernels = 'HASWELL'
    if (has(flags, medium) .and. has(flags, wide)) kernels = 'SKYLAKEX'
  end function kernels_for

  !> All of some words stand in the flags.
  pure logical function has(flags, words)
    character(*), intent(in) :: flags !! between blanks
    character(*), intent(in) :: words(:) !! the words
    integer :: i

    has = .true.
    do i = 1, size(words)
      has = has .and. index(flags, ' '//trim(words(i))//' ') > 0
    end do
  end function has

  !> What the first processor can do, as Linux tells it; '' elsewhere.
  function processor_flags() result(flags)
    character(:), allocatable :: flags
    integer, parameter :: longest_vector = 8192
    character(longest_vector) :: line
    integer :: unit, status

    flags = ''
    open (newunit=unit, file='/proc/cpuinfo', action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (line(:5) /= 'flags') cycle
      flags = line(index(line, ':') + 1:len_trim(line))//' '
      exit
    end do
    close (unit, iostat=status)
  end function processor_flags
end module blas_kernels
