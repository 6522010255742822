!> The laws of the bulk: their keywords, and the way to the routine of each.
!!
!! A new law is one file and one line in each table here.
module bulk_laws
  use kinds, only: wp
  use law_neohooke, only: neohooke_point
  use law_svk, only: svk_point
  implicit none
  private
  public :: law_t, laws, linear, neohooke, svk, law_point

  !> What readers, checks and elements ask of a law.
  type :: law_t
    character(10) :: keyword = '' !! its word behind SOLId
    character(40) :: words = '' !! what it is, for people
    logical :: finite = .false. !! of finite strain: the deformation gradient counts
    logical :: may_mean = .false. !! its volumetric part may be that of the mean dilatation
  end type law_t

  !> Numbers of the laws.
  integer, parameter :: linear = 1
  integer, parameter :: neohooke = 2
  integer, parameter :: svk = 3

  !> The laws by number.
  type(law_t), parameter :: laws(3) = [ &
    law_t('LINEar    ', 'linear elastic', .false., .true.), &
    law_t('NEOHookean', 'neo-Hooke, finite strain', .true., .true.), &
    law_t('SVK       ', 'Saint-Venant-Kirchhoff, finite strain', .true., .false.)]

contains

  !> Stress, its derivative and the energy of one point under a law of finite strain.
  pure subroutine law_point(law, lambda, g, gradient, p, energy, a)
    integer, intent(in) :: law !! its number
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: gradient(3, 3) !! displacement gradient F - I, det F > 0
    real(wp), intent(out) :: p(3, 3) !! first Piola-Kirchhoff stress P_iJ [force/length^2]
    real(wp), intent(out) :: energy !! [force/length^2]
    real(wp), intent(out), optional :: a(3, 3, 3, 3) !! dP_iJ/dF_kL [force/length^2]

    if (law == svk) then
      call svk_point(lambda, g, gradient, p, energy, a)
    else
      call neohooke_point(lambda, g, gradient, p, energy, a)
    end if
  end subroutine law_point
end module bulk_laws
