!> The back end that takes its matrix by nodes: this program has none.
module nodal_engine
  use back_ends, only: back_end_t
  implicit none
  private
  public :: has_nodal_engine, start_nodal_engine

contains

  !> This program has it.
  pure logical function has_nodal_engine() result(has)
    has = .false.
  end function has_nodal_engine

  !> Makes nothing.
  subroutine start_nodal_engine(engine)
    class(back_end_t), allocatable, intent(out) :: engine !! stays empty

    if (allocated(engine)) deallocate (engine)
  end subroutine start_nodal_engine
end module nodal_engine
