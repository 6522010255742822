!> Prototypes of the CHOLMOD routines in use (long integers) and mirrors of its structures, and
!! nothing else. The layouts are those of CHOLMOD 3 and 4, cholmod_core.h.
module cholmod_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_size_t, c_double
  implicit none
  private
  public :: cholmod_common_t, cholmod_sparse_t, cholmod_dense_t, cholmod_factor_t
  public :: cholmod_l_start, cholmod_l_finish, cholmod_l_analyze_p, &
    cholmod_l_factorize, cholmod_l_change_factor, cholmod_l_solve2, cholmod_l_free_factor, &
    cholmod_l_free_dense, cholmod_l_realloc, cholmod_l_version

  !> cholmod_common: what is set or read has a name, the rest is room.
  type, bind(c) :: cholmod_common_t
    real(c_double) :: growth(6) = 0.0_c_double !! bytes 0 to 47
    integer(c_int) :: supernodal = 0_c_int !! byte 48: 0 simplicial, 1 automatic, 2 supernodal
    integer(c_int) :: room_1(7) = 0_c_int !! bytes 52 to 79
    real(c_double) :: zrelax(3) = 0.0_c_double !! byte 80: zeros that merged supernodes may have
    integer(c_size_t) :: nrelax(3) = 0_c_size_t !! byte 104: up to how many columns
    integer(c_int) :: room_2 = 0_c_int !! byte 128
    integer(c_int) :: prefer_upper = 0_c_int !! byte 132
    integer(c_int) :: quick_return = 0_c_int !! byte 136
    integer(c_int) :: room_3 = 0_c_int !! byte 140
    integer(c_int) :: print = 0_c_int !! byte 144: how much is printed
    integer(c_int) :: room_4(5) = 0_c_int !! bytes 148 to 167
    integer(c_int) :: nmethods = 0_c_int !! byte 168: orderings that are tried
    integer(c_int) :: room_5(36) = 0_c_int !! bytes 172 to 315
    integer(c_int) :: ordering = 0_c_int !! byte 316: the first ordering
    integer(c_int) :: room_6(386) = 0_c_int !! bytes 320 to 1863
    integer(c_int) :: postorder = 0_c_int !! byte 1864
    integer(c_int) :: room_7(26) = 0_c_int !! bytes 1868 to 1971
    integer(c_int) :: status = 0_c_int !! byte 1972: below 0 errors, above warnings
    integer(c_int) :: room_8(1554) = 0_c_int !! to byte 8191: more than the structure has
  end type cholmod_common_t

  !> cholmod_sparse
  type, bind(c) :: cholmod_sparse_t
    integer(c_size_t) :: nrow = 0_c_size_t, ncol = 0_c_size_t, nzmax = 0_c_size_t !! sizes
    type(c_ptr) :: p = c_null_ptr, i = c_null_ptr, nz = c_null_ptr !! columns, rows, counts
    type(c_ptr) :: x = c_null_ptr, z = c_null_ptr !! values
    integer(c_int) :: stype = 0_c_int !! 1: the upper triangle counts, -1: the lower
    integer(c_int) :: itype = 2_c_int !! long integers
    integer(c_int) :: xtype = 1_c_int !! real; 0 for a pattern
    integer(c_int) :: dtype = 0_c_int !! double
    integer(c_int) :: sorted = 1_c_int !! rows ascend
    integer(c_int) :: packed = 1_c_int !! no counts
  end type cholmod_sparse_t

  !> cholmod_dense
  type, bind(c) :: cholmod_dense_t
    integer(c_size_t) :: nrow = 0_c_size_t, ncol = 0_c_size_t, nzmax = 0_c_size_t !! sizes
    integer(c_size_t) :: d = 0_c_size_t !! leading dimension
    type(c_ptr) :: x = c_null_ptr, z = c_null_ptr !! values
    integer(c_int) :: xtype = 1_c_int !! real
    integer(c_int) :: dtype = 0_c_int !! double
  end type cholmod_dense_t

  !> cholmod_factor
  type, bind(c) :: cholmod_factor_t
    integer(c_size_t) :: n, minor !! order; first column that is not positive definite, or n
    type(c_ptr) :: perm, col_count, inverse_perm !! permutation
    integer(c_size_t) :: nzmax !! simplicial factors
    type(c_ptr) :: p, i, x, z, nz, next, prev !! x is shared with supernodal factors
    integer(c_size_t) :: nsuper, ssize, xsize, maxcsize, maxesize !! supernodes and sizes
    type(c_ptr) :: super, pi, px, s !! columns, places of rows and values, rows of supernodes
    integer(c_int) :: ordering, is_ll, is_super, is_monotonic, itype, xtype, dtype, use_gpu !! kind
  end type cholmod_factor_t

  interface
    !> Main, sub and subsub version.
    integer(c_int) function cholmod_l_version(version) bind(c, name='cholmod_l_version')
      import :: c_int
      implicit none
      integer(c_int), intent(out) :: version(3)
    end function cholmod_l_version

    !> Another size for an array of CHOLMOD's.
    type(c_ptr) function cholmod_l_realloc(new, size, p, n, common) &
      bind(c, name='cholmod_l_realloc')
      import :: c_ptr, c_size_t, cholmod_common_t
      implicit none
      integer(c_size_t), value :: new !! entries wanted
      integer(c_size_t), value :: size !! of an entry [byte]
      type(c_ptr), value :: p !! the array
      integer(c_size_t), intent(inout) :: n !! entries it has
      type(cholmod_common_t), intent(inout) :: common !! settings
    end function cholmod_l_realloc

    !> Sets the defaults.
    integer(c_int) function cholmod_l_start(common) bind(c, name='cholmod_l_start')
      import :: c_int, cholmod_common_t
      implicit none
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_start

    !> Releases the work space.
    integer(c_int) function cholmod_l_finish(common) bind(c, name='cholmod_l_finish')
      import :: c_int, cholmod_common_t
      implicit none
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_finish

    !> Symbolic analysis with the ordering that the settings name, which may be one that is given.
    type(c_ptr) function cholmod_l_analyze_p(a, order, set, size_of_set, common) &
      bind(c, name='cholmod_l_analyze_p')
      import :: c_ptr, c_size_t, cholmod_sparse_t, cholmod_common_t
      implicit none
      type(cholmod_sparse_t), intent(in) :: a
      type(c_ptr), value :: order, set
      integer(c_size_t), value :: size_of_set
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_analyze_p

    !> Numeric factorisation.
    integer(c_int) function cholmod_l_factorize(a, factor, common) &
      bind(c, name='cholmod_l_factorize')
      import :: c_ptr, c_int, cholmod_sparse_t, cholmod_common_t
      implicit none
      type(cholmod_sparse_t), intent(in) :: a
      type(c_ptr), value :: factor
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_factorize

    !> Changes what a factor holds; xtype 0 leaves the analysis.
    integer(c_int) function cholmod_l_change_factor(xtype, to_ll, to_super, to_packed, &
                                                    to_monotonic, factor, common) &
      bind(c, name='cholmod_l_change_factor')
      import :: c_ptr, c_int, cholmod_common_t
      implicit none
      integer(c_int), value :: xtype, to_ll, to_super, to_packed, to_monotonic
      type(c_ptr), value :: factor
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_change_factor

    !> Solution; x, y and e are made if they do not fit.
    integer(c_int) function cholmod_l_solve2(sys, factor, b, bset, x, xset, y, e, common) &
      bind(c, name='cholmod_l_solve2')
      import :: c_ptr, c_int, cholmod_dense_t, cholmod_common_t
      implicit none
      integer(c_int), value :: sys
      type(c_ptr), value :: factor
      type(cholmod_dense_t), intent(in) :: b
      type(c_ptr), value :: bset, xset
      type(c_ptr), intent(inout) :: x, y, e
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_solve2

    !> Releases a factor.
    integer(c_int) function cholmod_l_free_factor(factor, common) &
      bind(c, name='cholmod_l_free_factor')
      import :: c_ptr, c_int, cholmod_common_t
      implicit none
      type(c_ptr), intent(inout) :: factor
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_free_factor

    !> Releases a dense matrix.
    integer(c_int) function cholmod_l_free_dense(x, common) bind(c, name='cholmod_l_free_dense')
      import :: c_ptr, c_int, cholmod_common_t
      implicit none
      type(c_ptr), intent(inout) :: x
      type(cholmod_common_t), intent(inout) :: common
    end function cholmod_l_free_dense
  end interface
end module cholmod_interface
