!> Prototypes of PETSc's iterative methods (KSP) and preconditioners (PC) in use, and nothing else;
!! what holds for petsc_interface holds here.
module petsc_solver_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_char, c_funptr
  implicit none
  private
  public :: ksp_create, ksp_set_operators, ksp_set_prefix, ksp_from_options, ksp_set_tolerances, &
    ksp_solve, ksp_reason, ksp_iterations, ksp_get_pc, ksp_operators, &
    ksp_destroy
  public :: pc_create, pc_set_operators, pc_set_prefix, pc_from_options, pc_set_type, pc_set_up, &
    pc_failed, pc_apply, pc_destroy, pc_shell_set_apply, pc_shell_set_context, &
    pc_shell_get_context, pc_levels, pc_smoother

  interface
    !> An iterative method.
    integer(c_int) function ksp_create(comm, ksp) bind(c, name='KSPCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: ksp
    end function ksp_create

    !> Its matrix, and that of its preconditioner.
    integer(c_int) function ksp_set_operators(ksp, a, b) bind(c, name='KSPSetOperators')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp, a, b
    end function ksp_set_operators

    !> What its options begin with.
    integer(c_int) function ksp_set_prefix(ksp, prefix) bind(c, name='KSPSetOptionsPrefix')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: ksp
      character(kind=c_char), intent(in) :: prefix(*)
    end function ksp_set_prefix

    !> Takes its options.
    integer(c_int) function ksp_from_options(ksp) bind(c, name='KSPSetFromOptions')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp
    end function ksp_from_options

    !> Relative and absolute residual, that of divergence, iterations.
    integer(c_int) function ksp_set_tolerances(ksp, relative, absolute, divergence, most) &
      bind(c, name='KSPSetTolerances')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: ksp
      real(c_double), value :: relative, absolute, divergence
      integer(c_int), value :: most
    end function ksp_set_tolerances

    !> Solves.
    integer(c_int) function ksp_solve(ksp, b, x) bind(c, name='KSPSolve')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp, b, x
    end function ksp_solve

    !> How that ended: above 0 converged.
    integer(c_int) function ksp_reason(ksp, reason) bind(c, name='KSPGetConvergedReason')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp
      integer(c_int), intent(out) :: reason
    end function ksp_reason

    !> Iterations that it took.
    integer(c_int) function ksp_iterations(ksp, n) bind(c, name='KSPGetIterationNumber')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp
      integer(c_int), intent(out) :: n
    end function ksp_iterations

    !> Its preconditioner.
    integer(c_int) function ksp_get_pc(ksp, pc) bind(c, name='KSPGetPC')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp
      type(c_ptr), intent(out) :: pc
    end function ksp_get_pc

    !> Releases it.
    integer(c_int) function ksp_destroy(ksp) bind(c, name='KSPDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: ksp
    end function ksp_destroy

    !> How many levels multigrid has.
    integer(c_int) function pc_levels(pc, n) bind(c, name='PCMGGetLevels')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
      integer(c_int), intent(out) :: n
    end function pc_levels

    !> The smoother of a level, 0 the coarsest.
    integer(c_int) function pc_smoother(pc, level, ksp) bind(c, name='PCMGGetSmoother')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
      integer(c_int), value :: level
      type(c_ptr), intent(out) :: ksp
    end function pc_smoother

    !> Its matrices.
    integer(c_int) function ksp_operators(ksp, a, b) bind(c, name='KSPGetOperators')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: ksp
      type(c_ptr), intent(out) :: a, b
    end function ksp_operators

    !> A preconditioner.
    integer(c_int) function pc_create(comm, pc) bind(c, name='PCCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: pc
    end function pc_create

    !> Its matrices.
    integer(c_int) function pc_set_operators(pc, a, b) bind(c, name='PCSetOperators')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc, a, b
    end function pc_set_operators

    !> What its options begin with.
    integer(c_int) function pc_set_prefix(pc, prefix) bind(c, name='PCSetOptionsPrefix')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: pc
      character(kind=c_char), intent(in) :: prefix(*)
    end function pc_set_prefix

    !> Takes its options.
    integer(c_int) function pc_from_options(pc) bind(c, name='PCSetFromOptions')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
    end function pc_from_options

    !> Which one it is.
    integer(c_int) function pc_set_type(pc, name) bind(c, name='PCSetType')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: pc
      character(kind=c_char), intent(in) :: name(*)
    end function pc_set_type

    !> Makes it ready.
    integer(c_int) function pc_set_up(pc) bind(c, name='PCSetUp')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
    end function pc_set_up

    !> Why it could not be made ready: 0 if it could.
    integer(c_int) function pc_failed(pc, reason) bind(c, name='PCGetFailedReason')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
      integer(c_int), intent(out) :: reason
    end function pc_failed

    !> y = M x.
    integer(c_int) function pc_apply(pc, x, y) bind(c, name='PCApply')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc, x, y
    end function pc_apply

    !> Releases it.
    integer(c_int) function pc_destroy(pc) bind(c, name='PCDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: pc
    end function pc_destroy

    !> The procedure that applies a preconditioner of our own.
    integer(c_int) function pc_shell_set_apply(pc, apply) bind(c, name='PCShellSetApply')
      import :: c_int, c_ptr, c_funptr
      implicit none
      type(c_ptr), value :: pc
      type(c_funptr), value :: apply
    end function pc_shell_set_apply

    !> What that procedure is to know.
    integer(c_int) function pc_shell_set_context(pc, context) bind(c, name='PCShellSetContext')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc, context
    end function pc_shell_set_context

    !> The same, asked for.
    integer(c_int) function pc_shell_get_context(pc, context) bind(c, name='PCShellGetContext')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: pc
      type(c_ptr), intent(out) :: context
    end function pc_shell_get_context
  end interface
end module petsc_solver_interface
