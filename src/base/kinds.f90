!> Kinds of numbers and the few constants that every layer shares.
module kinds
  use, intrinsic :: iso_c_binding, only: c_double, c_float, c_long
  implicit none
  private
  public :: wp, sp, long, pi, machine_epsilon

  !> Working precision: double, because LAPACK, SuiteSparse and HDF5 are called with it.
  integer, parameter :: wp = c_double
  !> Half of that, for what only has to be near.
  integer, parameter :: sp = c_float
  !> SuiteSparse's long integer (factors of 3-D meshes pass 2^31 entries).
  integer, parameter :: long = c_long
  real(wp), parameter :: pi = 3.14159265358979324_wp
  real(wp), parameter :: machine_epsilon = epsilon(1.0_wp)
end module kinds
