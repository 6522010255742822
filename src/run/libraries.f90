!> What --version says: the program, its commit, the compiler and the libraries it runs on.
module libraries
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: compiler_version
  use hdf5, only: h5open_f, h5get_libversion_f
  use text, only: to_text
  use version, only: program_version, program_commit
  use blas_info, only: blas_name
  use cholmod_interface, only: cholmod_l_version
  implicit none
  private
  public :: version_text

contains

  !> All of it, one line each.
  function version_text() result(t)
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')
    integer :: numbers(3), status
    integer(c_int) :: cholmod(3)

    call h5open_f(status)
    call h5get_libversion_f(numbers(1), numbers(2), numbers(3), status)
    status = int(cholmod_l_version(cholmod))
    t = 'mfec '//program_version//nl//'commit '//program_commit//nl// &
      'compiler '//compiler_version()//nl//'BLAS '//blas_name()//nl// &
      'CHOLMOD '//dotted(int(cholmod))//nl//'HDF5 '//dotted(numbers)
  end function version_text

  !> Three numbers with dots between them.
  pure function dotted(numbers) result(t)
    integer, intent(in) :: numbers(3) !! of a version
    character(:), allocatable :: t

    t = to_text(numbers(1))//'.'//to_text(numbers(2))//'.'//to_text(numbers(3))
  end function dotted
end module libraries
