!> The local data of one element, the numbers of the element routines, and the tasks that these can
!! be told to do.
!!
!! The names are FEAP's: `ix` nodes, `xl` coordinates, `ul` displacements, `s` matrix, `r` vector,
!! `h1` and `h2` history at the last converged and at the current state, `d` parameters.
module element_types
  use kinds, only: wp
  implicit none
  private
  public :: element_t, task_tangent, task_stick_tangent, task_residual, task_stress
  public :: task_shift_tangent, task_stick_shift_tangent, task_reach
  public :: routine_none, routine_t4, routine_small, routine_mfec, routine_smooth, routine_finite, &
    routine_quadratic, routine_round
  public :: status_off, status_open, status_stick, status_slip
  public :: make_room, max_slaves, max_dofs, n_element_history, n_element_stress

  !> What an element routine is told to do (FEAP's isw 3, 6 and 8).
  integer, parameter :: task_tangent = 3 !! matrix s and vector r
  integer, parameter :: task_stick_tangent = 4 !! as 3, the matrix of a contact element that sticks
  integer, parameter :: task_residual = 6 !! vector r only
  integer, parameter :: task_stress = 8 !! stress of a bulk element, state of a contact point
  !> The force of a contact element in the frame t1, t2, e of its facet in stress(1:3), and as rows
  !! of s what it does: 1 to 3 its derivative by displacements, 4 to 6 that of r by the shift
  !! (transposed), 7 to 9 its derivative by the shift.
  integer, parameter :: task_shift_tangent = 9
  integer, parameter :: task_stick_shift_tangent = 10 !! the same of an element that sticks
  integer, parameter :: task_reach = 11 !! how far a bulk element can go along a way

  !> Numbers of the element routines: elmlib calls them by these.
  integer, parameter :: routine_none = 0 !! an element that takes no part
  integer, parameter :: routine_t4 = 1 !! linear tetrahedron, small strain
  integer, parameter :: routine_small = 2 !! tetrahedron of any shape, small strain
  integer, parameter :: routine_mfec = 3 !! contact: moving friction elliptical cone
  integer, parameter :: routine_smooth = 4 !! the same on a curved patch with continuous normals
  integer, parameter :: routine_finite = 5 !! tetrahedron of any shape, finite strain
  integer, parameter :: routine_quadratic = 6 !! contact on a facet of six nodes
  integer, parameter :: routine_round = 7 !! contact on a part of a sphere or cylinder

  !> Status of a contact point. Off: no facet lies under it.
  integer, parameter :: status_off = -1
  integer, parameter :: status_open = 0
  integer, parameter :: status_stick = 1
  integer, parameter :: status_slip = 2

  integer, parameter :: max_nodes = 12 !! most nodes of a contact element
  integer, parameter :: max_slaves = 6 !! of these, most slave nodes of a contact element
  integer, parameter :: max_dofs = 3*max_nodes !! most degrees of freedom of a contact element
  integer, parameter :: n_element_history = 2 !! history variables: the apex of a contact element
  integer, parameter :: n_element_stress = 14 !! values of task_stress

  !> Everything an element routine gets and gives.
  type :: element_t
    integer :: number = 0 !! element number, or the point of a contact pair
    integer :: nel = 0 !! nodes of the element
    integer :: slaves = 1 !! of a contact element: its first nodes that make the slave point
    integer :: ix(max_nodes) = 0 !! (nel) node numbers
    real(wp) :: xl(3, max_nodes) = 0.0_wp !! (3, nel) reference coordinates [length]
    real(wp) :: ul(3, max_nodes) = 0.0_wp !! (3, nel) displacements [length]
    real(wp) :: weight(max_slaves) = 0.0_wp !! (slaves) M_b of x_S = sum M_b x_b, of one: 1
    real(wp) :: lift = 0.0_wp !! how high S stands over the facet of its first three slaves [length]
    real(wp), allocatable :: s(:, :) !! (dofs, dofs) tangent dr/du, once a task asks [force/length]
    real(wp) :: r(max_dofs) = 0.0_wp !! internal force of the nodes [force]
    real(wp) :: h1(n_element_history) = 0.0_wp !! history at the last converged state
    real(wp) :: h2(n_element_history) = 0.0_wp !! history at the current state
    real(wp) :: path1 = 0.0_wp !! slip path of a contact element, last converged [length]
    real(wp) :: path2 = 0.0_wp !! the same at the current state, 0 unless a law asks for it [length]
    real(wp) :: shift(3) = 0.0_wp !! shift of the gap of a contact element [length], see there
    real(wp) :: offset = 0.0_wp !! what is added to its normal gap, along its normal [length]
    integer :: status = status_open !! of a contact element
    real(wp) :: slip(3) = 0.0_wp !! tangential gap that a contact element carries [length]
    real(wp) :: stress(n_element_stress) = 0.0_wp !! result of task_stress, see each element
  end type element_t
contains

  !> Room for the matrix of an element, if a task writes one: as large as any element may want it.
  pure subroutine make_room(task, e)
    integer, intent(in) :: task !! what the element is told to do
    type(element_t), intent(inout) :: e !! gets s, unless it has one

    if (allocated(e%s)) return
    select case (task)
    case (task_tangent, task_stick_tangent, task_shift_tangent, task_stick_shift_tangent)
      allocate (e%s(max_dofs, max_dofs), source=0.0_wp)
    case default
      ! No other task has a matrix.
    end select
  end subroutine make_room
end module element_types
