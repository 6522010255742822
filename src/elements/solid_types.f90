!> The local data of one bulk element.
!!
!! The names are FEAP's: `ix` nodes, `xl` coordinates, `ul` displacements, `s` matrix, `r` vector,
!! `d` parameters. The tasks are those of element_types.
module solid_types
  use kinds, only: wp
  use law_types, only: bulk_point, most_point_state, most_parameters
  use cells, only: most_nodes
  implicit none
  private
  public :: solid_t, most_solid_dofs, n_solid_state, n_solid_parameters, most_points, n_sample
  public :: state_stress, state_rotation, state_strain
  public :: d_youngs_modulus, d_poissons_ratio, d_mean, d_own

  integer, parameter :: most_solid_dofs = 3*most_nodes !! most degrees of freedom of an element
  integer, parameter :: most_points = 8 !! most points of an element
  integer, parameter :: n_sample = 12 !! stress and strain of a point

  !> Parameters d of the bulk elements.
  integer, parameter :: d_youngs_modulus = 1 !! E [force/length^2]
  integer, parameter :: d_poissons_ratio = 2 !! nu
  integer, parameter :: d_mean = 3 !! 1: volumetric part on the mean dilatation of the element
  integer, parameter :: d_own = 4 !! the first of the law's own parameters
  integer, parameter :: n_solid_parameters = d_own - 1 + most_parameters !! length of d

  !> Where task_stress puts what into state.
  integer, parameter :: state_stress(6) = [1, 2, 3, 4, 5, 6] !! Cauchy, xx yy zz xy yz zx
  integer, parameter :: state_rotation(3) = [7, 8, 9] !! rotation vector where strain is small
  integer, parameter :: state_strain(6) = [10, 11, 12, 13, 14, 15] !! tensor, Green's if finite
  integer, parameter :: n_solid_state = 15 !! length of state

  !> Everything a bulk element gets and gives.
  type :: solid_t
    integer :: nel = 0 !! nodes of the element
    integer :: ix(most_nodes) = 0 !! (nel) node numbers
    real(wp) :: xl(3, most_nodes) = 0.0_wp !! (3, nel) reference coordinates [length]
    real(wp) :: ul(3, most_nodes) = 0.0_wp !! (3, nel) displacements [length]
    real(wp) :: dul(3, most_nodes) = 0.0_wp !! (3, nel) a way on from there [length]
    real(wp) :: reach = huge(1.0_wp) !! share of this way at which it turns inside out
    real(wp) :: s(most_solid_dofs, most_solid_dofs) = 0.0_wp !! tangent dr/du [force/length]
    real(wp) :: r(most_solid_dofs) = 0.0_wp !! internal force of the nodes [force]
    real(wp) :: state(n_solid_state) = 0.0_wp !! result of task_stress: means over its points
    real(wp) :: points(n_sample, most_points) = 0.0_wp !! of task_stress, if there are several
    !! points: stress and strain of each as state has them, less those that are even
    real(wp) :: even(2) = 0.0_wp !! of task_stress: normal stress and strain on the mean dilatation,
    !! the same in all of the element
    real(wp) :: energy = 0.0_wp !! strain energy, of elements that are not linear [force length]
    procedure(bulk_point), pointer, nopass :: point => null() !! law of its points, unless linear
    logical :: finite = .true. !! that law is one of finite strain
    real(wp) :: old(most_point_state, most_points) = 0.0_wp !! what its points remember
    real(wp) :: new(most_point_state, most_points) = 0.0_wp !! the same at these displacements
    logical :: inverted = .false. !! it has no answer: it is turned inside out somewhere
  end type solid_t
end module solid_types
