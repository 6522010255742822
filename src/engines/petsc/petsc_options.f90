!> PETSc's settings: the ways of multigrid, factors and iterations, by their names in its manual
!! (doc/theory, "Iterative solution in parallel").
module petsc_options
  use, intrinsic :: iso_c_binding, only: c_null_ptr, c_int, c_null_char
  use kinds, only: wp
  use memory, only: memory_left
  use ranks, only: count_ranks
  use petsc_interface, only: petsc_options_set
  use petsc_faults, only: note
  implicit none
  private
  public :: set_options, is_scarce, choose_products
  public :: way_kept, way_renewed, way_algebraic, way_direct, n_ways, prefixes

  !> What stands for the inverse of the whole matrix, the cheapest first.
  integer, parameter :: way_kept = 1 !! multigrid of the bulk, kept
  integer, parameter :: way_renewed = 2 !! multigrid of the tangent
  integer, parameter :: way_algebraic = 3 !! BoomerAMG of the tangent
  integer, parameter :: way_direct = 4 !! a factor of the tangent
  integer, parameter :: n_ways = 4
  !> What the options of each begin with.
  character(14), parameter :: prefixes(n_ways) = [character(14) :: 'mfec_kept_', 'mfec_renewed_', &
    'mfec_boomer_', 'mfec_direct_']

  !> Bytes of the products that coarser matrices of several processes are formed with, a degree of
  !! freedom (measured at n = 24), and the share of the free memory that these may take.
  real(wp), parameter :: product_bytes = 1000.0_wp, product_share = 0.05_wp

contains

  !> All options, once.
  subroutine set_options(fault)
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer :: k

    do k = way_kept, way_renewed
      call set(trim(prefixes(k))//'pc_type', 'gamg', fault)
    end do
    call set(trim(prefixes(way_algebraic))//'pc_type', 'hypre', fault)
    call set(trim(prefixes(way_algebraic))//'pc_hypre_type', 'boomeramg', fault)
    call set(trim(prefixes(way_direct))//'pc_type', 'lu', fault)
    call set(trim(prefixes(way_direct))//'pc_factor_mat_solver_type', 'mumps', fault)
    call set('mfec_block_pc_type', 'lu', fault)
    call set('mfec_block_pc_factor_mat_solver_type', 'umfpack', fault)
    call set('mfec_block_mat_umfpack_ordering', 'METIS', fault)
    call set('mfec_gmres_ksp_type', 'gmres', fault)
    call set('mfec_gmres_ksp_pc_side', 'right', fault)
    call set('mfec_gmres_ksp_gmres_restart', '30', fault)
    call set('mfec_gmres_ksp_gmres_modifiedgramschmidt', '1', fault)
    call set('mfec_cg_ksp_type', 'cg', fault)
    call set('mfec_cg_ksp_norm_type', 'unpreconditioned', fault)
  end subroutine set_options

  !> Products as large as the matrix would be much of the memory that is left here.
  logical function is_scarce(nodes) result(scarce)
    integer, intent(in) :: nodes !! of the matrix

    scarce = product_bytes*3.0_wp*real(nodes, wp) > product_share*memory_left()
  end function is_scarce

  !> How the next coarser matrices are formed: through a product that stays beside them for a while,
  !! or without, in three times the time. Matrices of one process know no such choice.
  subroutine choose_products(scarce, fault)
    logical, intent(in) :: scarce !! memory is, on one of the processes
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    if (count_ranks() == 1) return
    if (scarce) then
      call set('matptap_via', 'allatonce', fault)
    else
      call set('matptap_via', 'nonscalable', fault)
    end if
  end subroutine choose_products

  !> One option.
  subroutine set(name, value, fault)
    character(*), intent(in) :: name !! without the dash
    character(*), intent(in) :: value !! its value
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, petsc_options_set(c_null_ptr, '-'//name//c_null_char, value//c_null_char))
  end subroutine set
end module petsc_options
