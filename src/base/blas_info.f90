!> Which BLAS the program really runs on, asked at run time: the linker may have taken another one
!! than the one it was built with, and reference BLAS is 10 to 20 times slower than OpenBLAS.
module blas_info
  use, intrinsic :: iso_c_binding, only: c_ptr, c_funptr, c_int, c_char, c_size_t, &
    c_associated, c_f_pointer, c_f_procpointer
  use kinds, only: wp
  use loaded_symbols, only: symbol
  use errors, only: error_t, raise, exit_resources
  use memory, only: memory_left, memory_text
  use lapack_interface, only: dsymv
  implicit none
  private
  public :: blas_name, blas_core, is_reference_blas, set_blas_threads, blas_threads, start_blas, &
    rest_blas_threads

  !> What OpenBLAS takes for itself at its first call, and never asks whether it got it: it tries
  !! for ever. A little is left for what follows [byte].
  real(wp), parameter :: blas_bytes = 134217728.0_wp, blas_margin = 16777216.0_wp

  !> C's Dl_info: where a symbol comes from.
  type, bind(c) :: symbol_t
    type(c_ptr) :: file !! path of the library
    type(c_ptr) :: base !! where it is loaded
    type(c_ptr) :: name !! nearest symbol
    type(c_ptr) :: address !! its address
  end type symbol_t

  abstract interface
    !> openblas_get_config, openblas_get_corename
    function text_i() bind(c) result(text)
      import :: c_ptr
      implicit none
      type(c_ptr) :: text
    end function text_i

    !> openblas_set_num_threads
    subroutine set_i(n) bind(c)
      import :: c_int
      implicit none
      integer(c_int), value :: n !! number of threads
    end subroutine set_i

    !> openblas_get_num_threads, blas_thread_shutdown_
    function get_i() bind(c) result(n)
      import :: c_int
      implicit none
      integer(c_int) :: n
    end function get_i
  end interface

  interface
    !> C's dladdr: the library that holds an address; 0 if none does.
    function c_dladdr(address, symbol) bind(c, name='dladdr') result(found)
      import :: c_funptr, c_int, symbol_t
      implicit none
      type(c_funptr), value :: address !! any address
      type(symbol_t), intent(out) :: symbol !! what is there
      integer(c_int) :: found
    end function c_dladdr

    !> C's strlen.
    pure function c_strlen(text) bind(c, name='strlen') result(length)
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: text !! a string that ends with a null
      integer(c_size_t) :: length
    end function c_strlen
  end interface

contains

  !> Name of the BLAS in use: OpenBLAS's own description, or the name of the library.
  function blas_name() result(name)
    character(:), allocatable :: name
    procedure(text_i), pointer :: get_config
    type(c_funptr) :: address

    address = symbol('openblas_get_config')
    if (c_associated(address)) then
      call c_f_procpointer(address, get_config)
      name = fortran_text(get_config())
    else
      name = library_of('dgemm_')
      if (name == '') then
        name = 'unknown BLAS'
      else if (index(name, 'libblas.so') > 0) then
        name = 'reference BLAS ('//name//')'
      end if
    end if
  end function blas_name

  !> The processor whose kernels OpenBLAS runs on; '' with another BLAS.
  function blas_core() result(name)
    character(:), allocatable :: name
    procedure(text_i), pointer :: get_core
    type(c_funptr) :: address

    name = ''
    address = symbol('openblas_get_corename')
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, get_core)
    name = fortran_text(get_core())
  end function blas_core

  !> Whether it is the slow reference BLAS.
  logical function is_reference_blas() result(yes)
    yes = index(blas_name(), 'reference BLAS') == 1
  end function is_reference_blas

  !> Sets the number of threads of OpenBLAS; other libraries keep their own.
  subroutine set_blas_threads(n)
    integer, intent(in) :: n !! number of threads
    procedure(set_i), pointer :: set_threads
    type(c_funptr) :: address

    if (blas_threads() == n) return
    address = symbol('openblas_set_num_threads')
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, set_threads)
    call set_threads(int(n, c_int))
  end subroutine set_blas_threads

  !> Ends the threads that OpenBLAS starts before the first statement of a program, one a core: each
  !! spins for 2**28 ticks, a tenth of a second, before it sleeps. They start anew where more than
  !! one is asked for. Where memory is short they still wait for theirs, and are left alone.
  subroutine rest_blas_threads()
    procedure(get_i), pointer :: end_threads
    type(c_funptr) :: address
    integer(c_int) :: ignored
    integer :: n

    n = blas_threads()
    address = symbol('blas_thread_shutdown_')
    if (n == 1 .or. .not. c_associated(address)) return
    if (memory_left() < n*blas_bytes) return
    call set_blas_threads(1)
    call c_f_procpointer(address, end_threads)
    ignored = end_threads()
  end subroutine rest_blas_threads

  !> Lets OpenBLAS take its memory now, if there is enough.
  subroutine start_blas(error)
    type(error_t), allocatable, intent(out) :: error !! there is not
    real(wp) :: a(1, 1), x(1), y(1)

    if (.not. c_associated(symbol('openblas_get_config'))) return
    if (memory_left() < blas_bytes + blas_margin) then
      call raise(error, exit_resources, 'error: out of memory while starting OpenBLAS: '// &
        'it takes '//memory_text(blas_bytes)//', and '//memory_text(memory_left())//' are left'// &
        new_line('a')//'  use a machine with more memory, or a higher limit (ulimit -v)')
      ! its own threads ask for memory until they get some, and it waits for them at the end
      error%at_once = .true.
      return
    end if
    a = 1.0_wp
    x = 1.0_wp
    y = 0.0_wp
    call dsymv('L', 1, 1.0_wp, a, 1, x, 1, 0.0_wp, y, 1)
  end subroutine start_blas

  !> Number of threads of OpenBLAS; 1 for other libraries.
  integer function blas_threads() result(n)
    procedure(get_i), pointer :: get_threads
    type(c_funptr) :: address

    n = 1
    address = symbol('openblas_get_num_threads')
    if (.not. c_associated(address)) return
    call c_f_procpointer(address, get_threads)
    n = get_threads()
  end function blas_threads

  !> Path of the library that holds a symbol, empty if there is none.
  function library_of(name) result(path)
    character(*), intent(in) :: name !! the symbol
    character(:), allocatable :: path
    type(c_funptr) :: address
    type(symbol_t) :: place

    path = ''
    address = symbol(name)
    if (.not. c_associated(address)) return
    if (c_dladdr(address, place) == 0_c_int) return
    if (c_associated(place%file)) path = fortran_text(place%file)
  end function library_of

  !> A C string as Fortran has it.
  function fortran_text(chars) result(text)
    type(c_ptr), intent(in) :: chars !! a string that ends with a null
    character(:), allocatable :: text
    character(kind=c_char), pointer :: view(:)
    integer :: i, length

    length = int(c_strlen(chars))
    call c_f_pointer(chars, view, [length])
    allocate (character(length) :: text)
    do i = 1, length
      text(i:i) = view(i)
    end do
    text = trim(text)
  end function fortran_text
end module blas_info
