!> DISP and REAC: displacements and reactions of nodes, printed to the log.
module printing
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use mesh_types, only: mesh_t
  use model_types, only: model_t
  use system_types, only: state_t
  use batch_types, only: batch_command_t
  use run_log, only: log_t, log_line
  implicit none
  private
  public :: print_displacements, print_reactions, nodes_to_print

contains

  !> DISP[,ALL] or DISP,,n1,n2,n3: displacements of all nodes, or of n1 to n2 in steps of n3.
  subroutine print_displacements(command, model, state, log, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(model_t), intent(in) :: model !! the problem
    type(state_t), intent(in) :: state !! the converged state
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(out) :: error !! trouble with the file

    call print_vectors(command, model, 'displacements', state%time, state%u, log, error)
  end subroutine print_displacements

  !> REAC[,ALL] or REAC,,n1,n2,n3: reactions likewise.
  subroutine print_reactions(command, model, state, log, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(model_t), intent(in) :: model !! the problem
    type(state_t), intent(in) :: state !! the converged state
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(out) :: error !! trouble with the file

    call print_vectors(command, model, 'reactions', state%time, state%reaction, log, error)
  end subroutine print_reactions

  !> The nodes that a command names: n1 to n2 in steps of n3; n1 alone is one node, none are all.
  pure subroutine nodes_to_print(command, mesh, first, last, stride)
    type(batch_command_t), intent(in) :: command !! which nodes
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(out) :: first !! first node
    integer, intent(out) :: last !! last node as asked for, may be beyond the mesh
    integer, intent(out) :: stride !! step between them

    first = max(1, nint(command%v(1)))
    last = nint(command%v(2))
    if (last == 0) last = merge(mesh%nodes, first, command%v(1) < 1.0_wp)
    stride = max(1, nint(command%v(3)))
  end subroutine nodes_to_print

  !> A vector a node, and the sum.
  subroutine print_vectors(command, model, what, time, v, log, error)
    type(batch_command_t), intent(in) :: command !! which nodes
    type(model_t), intent(in) :: model !! the problem
    character(*), intent(in) :: what !! heading
    real(wp), intent(in) :: time !! time of the state
    real(wp), intent(in) :: v(:, :) !! (3, nodes) the vectors
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(out) :: error !! trouble with the file
    character(80) :: line
    integer :: first, last, stride, i

    call nodes_to_print(command, model%mesh, first, last, stride)
    last = min(last, model%mesh%nodes)
    call log_line(log, '  nodal '//what//' at time '//to_text(time, 12), error)
    do i = first, last, stride
      if (allocated(error)) return
      if (.not. model%mesh%defined(i)) cycle
      write (line, '(i10,3es20.11e3)') i, v(:, i)
      call log_line(log, trim(line), error)
    end do
    if (allocated(error)) return
    write (line, '(a10,3es20.11e3)') 'sum', sum(v(:, first:last:stride), 2)
    call log_line(log, trim(line), error)
  end subroutine print_vectors
end module printing
