!> Nested dissection of a graph whose nodes have weights: METIS, which CHOLMOD brings along but asks
!! without any (doc/theory, "Static condensation").
module nested_dissection
  use, intrinsic :: iso_c_binding, only: c_funptr, c_ptr, c_int32_t, c_associated, &
    c_f_procpointer, c_loc
  use kinds, only: long
  use csc_matrix, only: csc_matrix_t
  use loaded_symbols, only: symbol
  implicit none
  private
  public :: dissect

  !> Entries of METIS's options (metis.h), and what says that all went well.
  integer, parameter :: options_size = 40, metis_ok = 1
  !> The option that says how often a separator is refined on each level: once in graphs of at most
  !! so many nodes, whose factor takes less time than more of it would.
  integer, parameter :: refinements = 7, few_nodes = 20000

  abstract interface
    !> METIS_SetDefaultOptions
    function defaults_i(options) bind(c) result(status)
      import :: c_int32_t
      implicit none
      integer(c_int32_t), intent(inout) :: options(*) !! get -1
      integer(c_int32_t) :: status
    end function defaults_i

    !> METIS_NodeND
    function order_i(n, first, neighbour, weight, options, permutation, inverse) bind(c) &
      result(status)
      import :: c_int32_t, c_ptr
      implicit none
      integer(c_int32_t), intent(in) :: n !! nodes
      integer(c_int32_t), intent(in) :: first(*) !! (n+1) first neighbour of each, 0-based
      integer(c_int32_t), intent(in) :: neighbour(*) !! 0-based, both ways, no node its own
      integer(c_int32_t), intent(in) :: weight(*) !! (n)
      type(c_ptr), value :: options !! -1: what METIS has
      integer(c_int32_t), intent(out) :: permutation(*) !! (n) the node at each place, 0-based
      integer(c_int32_t), intent(out) :: inverse(*) !! (n) the place of each node, 0-based
      integer(c_int32_t) :: status
    end function order_i
  end interface

contains

  !> The order of elimination of a graph; not found where no METIS of the usual kind is loaded.
  subroutine dissect(graph, weight, order, found)
    type(csc_matrix_t), intent(in) :: graph !! a pattern, both triangles
    integer, intent(in) :: weight(:) !! (n) of the nodes, 1 or more
    integer(long), allocatable, intent(out) :: order(:) !! (n) the node at each place, 0-based
    logical, intent(out) :: found !! there is one
    procedure(order_i), pointer :: order_by_metis
    integer(c_int32_t), allocatable, dimension(:) :: first, neighbour, permutation, inverse
    integer(c_int32_t), target :: options(options_size)
    type(c_funptr) :: address
    integer(c_int32_t) :: status

    allocate (order(graph%n))
    address = symbol('METIS_NodeND')
    found = c_associated(address) .and. size(graph%row, kind=long) < huge(1)
    if (found) found = has_short_integers()
    if (.not. found) return
    call list_neighbours(graph, first, neighbour)
    allocate (permutation(graph%n), inverse(graph%n))
    call c_f_procpointer(address, order_by_metis)
    options = -1
    if (graph%n <= few_nodes) options(refinements) = 1
    status = order_by_metis(int(graph%n, c_int32_t), first, neighbour, int(weight, c_int32_t), &
      c_loc(options), permutation, inverse)
    found = status == metis_ok
    if (found) order = permutation
  end subroutine dissect

  !> METIS was built with integers of four bytes: it sets so many of them, and not twice as many.
  logical function has_short_integers() result(short)
    procedure(defaults_i), pointer :: set_defaults
    integer(c_int32_t) :: options(2*options_size), status
    type(c_funptr) :: address

    address = symbol('METIS_SetDefaultOptions')
    short = c_associated(address)
    if (.not. short) return
    call c_f_procpointer(address, set_defaults)
    options = 0
    status = set_defaults(options)
    short = status == metis_ok .and. all(options(:options_size) == -1) .and. &
      all(options(options_size + 1:) == 0)
  end function has_short_integers

  !> The pattern without its diagonal.
  pure subroutine list_neighbours(graph, first, neighbour)
    type(csc_matrix_t), intent(in) :: graph !! a pattern, both triangles
    integer(c_int32_t), allocatable, intent(out) :: first(:) !! (n+1) 0-based
    integer(c_int32_t), allocatable, intent(out) :: neighbour(:) !! 0-based
    integer(long) :: j, k
    integer :: filled

    allocate (first(graph%n + 1), neighbour(size(graph%row)))
    filled = 0
    first(1) = 0
    do j = 1, graph%n
      do k = graph%ptr(j) + 1, graph%ptr(j + 1)
        if (graph%row(k) == j - 1) cycle
        filled = filled + 1
        neighbour(filled) = int(graph%row(k), c_int32_t)
      end do
      first(j + 1) = filled
    end do
  end subroutine list_neighbours
end module nested_dissection
