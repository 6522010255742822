!> How a law of friction declares itself. Reader, keyword table, `--help`, element, results and
!! restart take from here what they need of it.
module law_types
  use kinds, only: wp
  implicit none
  private
  public :: law_parameter_t, law_state_t, friction_law_t, cone_state_t, most_parameters

  !> Most parameters of a law.
  integer, parameter :: most_parameters = 3

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
end module law_types
