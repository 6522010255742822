!> How a law of friction or of the bulk declares itself. Reader, keyword table, `--help`, element,
!! results and restart take from here what they need of it.
module law_types
  use kinds, only: wp
  implicit none
  private
  public :: law_parameter_t, law_state_t, friction_law_t, cone_state_t, most_parameters
  public :: bulk_law_t, point_law_t, bulk_point_t, bulk_point, most_point_state

  !> Most parameters of a law.
  integer, parameter :: most_parameters = 3
  !> Most numbers that a point of the bulk remembers.
  integer, parameter :: most_point_state = 16

  !> A parameter: how the deck calls it, what it is measured in, and what may stand for it.
  type :: law_parameter_t
    character(8) :: name = '' !! for people
    character(16) :: unit = '' !! [1], [length] and so on
    character(1) :: check = '' !! kind of `signatures`: z not negative, q greater than 0
  end type law_parameter_t

  !> What a contact point remembers for the sake of laws; 0 at each new touch.
  type :: law_state_t
    character(16) :: name = '' !! of its data set
    character(16) :: unit = '' !! [1], [length] and so on
    character(64) :: description = '' !! for people
  end type law_state_t

  !> A law that changes the friction cone.
  type :: friction_law_t
    character(8) :: keyword = '' !! word of a PAIR, the letters that count as capitals
    character(40) :: summary = '' !! what it is, for people
    integer :: count = 0 !! number of its parameters
    type(law_parameter_t) :: parameters(most_parameters) = law_parameter_t() !! in the deck's order
    logical :: keeps_path = .false. !! it asks for the slip path of the point
    logical :: needs_area = .false. !! it asks for the area of the point
  end type friction_law_t

  !> The cone of a point: what laws change, one after the other.
  type :: cone_state_t
    real(wp) :: epsilon = 0.0_wp !! penalty of the point [force/length]
    real(wp) :: area = 0.0_wp !! its reference area, 0 if it has none
    real(wp) :: path = 0.0_wp !! its slip path since it has touched [length]
    real(wp) :: mu(2) = 0.0_wp !! principal coefficients
    real(wp) :: depth = 0.0_wp !! depth that the cone's radius is made of [length]
    real(wp) :: mu_path(2) = 0.0_wp !! derivative of mu by the path [1/length]
    real(wp) :: depth_path = 0.0_wp !! of the depth by the path
    real(wp) :: depth_rho = 1.0_wp !! of the depth by the penetration
  end type cone_state_t

  !> A point of the bulk: what its law is given, and what it answers.
  type :: bulk_point_t
    real(wp) :: lambda = 0.0_wp !! Lame's first constant; 0 where the volumetric part is another's
    !! [force/length^2]
    real(wp) :: g = 0.0_wp !! shear modulus [force/length^2]
    real(wp) :: own(most_parameters) = 0.0_wp !! the law's own parameters
    real(wp) :: gradient(3, 3) = 0.0_wp !! displacement gradient F - I, det F > 0
    real(wp) :: old(most_point_state) = 0.0_wp !! what it remembers of the last converged state
    real(wp) :: new(most_point_state) = 0.0_wp !! the same at this gradient
    real(wp) :: p(3, 3) = 0.0_wp !! first Piola-Kirchhoff stress P_iJ [force/length^2]
    real(wp) :: energy = 0.0_wp !! W [force/length^2]
    real(wp) :: a(3, 3, 3, 3) = 0.0_wp !! A_iJkL = dP_iJ/dF_kL, if asked for [force/length^2]
  end type bulk_point_t

  !> A law of the bulk. Where strain is small its p is the stress of the symmetric part of the
  !! gradient.
  type :: bulk_law_t
    character(10) :: keyword = '' !! its word behind SOLId
    character(40) :: words = '' !! what it is, for people
    logical :: linear = .false. !! stress goes with displacements: there is no more to it than E, nu
    logical :: finite = .false. !! of finite strain: the deformation gradient counts
    logical :: may_mean = .false. !! its volumetric part may be that of the mean dilatation
    integer :: count = 0 !! number of its parameters beside E and nu
    type(law_parameter_t) :: parameters(most_parameters) = law_parameter_t() !! in the deck's order
    integer :: n_state = 0 !! numbers that a point remembers
  end type bulk_law_t

  !> What elements ask of a law of the bulk.
  type :: point_law_t
    logical :: finite = .false. !! it is one of finite strain
    procedure(bulk_point), pointer, nopass :: point => null() !! its routine, unless linear
  end type point_law_t

  abstract interface
    !> Stress, energy and state of a point, and the derivative of the stress if it is asked for.
    pure subroutine bulk_point(slope, q)
      import :: bulk_point_t
      implicit none
      logical, intent(in) :: slope !! the derivative is asked for
      type(bulk_point_t), intent(inout) :: q !! gradient, old given; gets p, energy, new, a
    end subroutine bulk_point
  end interface
end module law_types
