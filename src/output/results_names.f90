!> Names of the files that hold bodies, contact surfaces and states.
!!
!! ParaView chooses its reader by what stands behind a dot of the name: `vtkhdf` is VTKHDF's (from
!! ParaView 5.12 on), `h5` is other programs'. A file that SAVE writes holds a state and nothing to
!! look at, so it keeps the ending of plain HDF5.
module results_names
  implicit none
  private
  public :: bodies_ending, contact_ending, state_ending, find_results, without_ending

  !> Ending of the results file, with the bodies.
  character(*), parameter :: bodies_ending = '.vtkhdf'
  !> Ending of the file of the contact surfaces.
  character(*), parameter :: contact_ending = '.contact.vtkhdf'
  !> Ending of a file of one state, and of results files before these had one that ParaView knows.
  character(*), parameter :: state_ending = '.h5'

contains

  !> The results file that a path means: of the two endings that there are, the one that is there.
  function find_results(path) result(found)
    character(*), intent(in) :: path !! a path as written
    character(:), allocatable :: found, other
    logical :: there

    found = path
    inquire (file=path, exist=there)
    if (there) return
    other = path
    if (has_ending(path, bodies_ending)) other = without_ending(path)//state_ending
    if (has_ending(path, state_ending)) other = without_ending(path)//bodies_ending
    inquire (file=other, exist=there)
    if (there) found = other
  end function find_results

  !> A path without the ending of a results file or state.
  pure function without_ending(path) result(base)
    character(*), intent(in) :: path !! a results file
    character(:), allocatable :: base

    base = path
    if (has_ending(path, bodies_ending)) base = path(:len(path) - len(bodies_ending))
    if (has_ending(path, state_ending)) base = path(:len(path) - len(state_ending))
  end function without_ending

  !> Whether a path ends so, with something before it.
  pure logical function has_ending(path, ending) result(yes)
    character(*), intent(in) :: path !! any path
    character(*), intent(in) :: ending !! what it may end with

    yes = len(path) > len(ending)
    if (yes) yes = path(len(path) - len(ending) + 1:) == ending
  end function has_ending
end module results_names
