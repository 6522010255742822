!> DISP, REAC, STRE and CHEC: displacements, reactions, stresses, and what the mesh is like, printed
!! to the log.
module printing
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use mesh_types, only: mesh_t
  use cell_geometry, only: cell_volume, cell_aspect
  use element_fields, only: nodal_fields_t, find_element_fields, find_nodal_fields
  use von_mises_stress, only: von_mises
  use model_types, only: model_t
  use system_types, only: system_t, state_t
  use batch_types, only: batch_command_t
  use run_log, only: log_t, log_line
  use run_audit, only: tell_answers
  use run_context, only: context_t
  implicit none
  private
  public :: print_request, numbers_to_print

contains

  !> DISP, REAC, STRE, CHEC: prints to the log.
  subroutine print_request(command, context, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(context_t), target, intent(inout) :: context !! problem, accepted state, log
    type(error_t), allocatable, intent(out) :: error !! trouble with the log

    associate (model => context%model, state => context%state, log => context%files%log)
      select case (command%command)
      case ('disp')
        call print_vectors(command, model, 'displacements', state%time, state%u, log, error)
      case ('reac')
        call print_vectors(command, model, 'reactions', state%time, state%reaction, log, error)
      case ('stre')
        call print_stresses(command, model, context%system, state, log, error)
      case default
        if (command%option == 'uniq') call tell_answers(context, error)
        if (command%option /= 'uniq') call print_mesh(model%mesh, log, error)
      end select
    end associate
  end subroutine print_request

  !> The nodes or elements that a command names: n1 to n2 in steps of n3; n1 alone is one, none are
  !! all.
  pure subroutine numbers_to_print(command, highest, first, last, stride)
    type(batch_command_t), intent(in) :: command !! which numbers
    integer, intent(in) :: highest !! highest number of the mesh
    integer, intent(out) :: first !! first one
    integer, intent(out) :: last !! last one as asked for, may be beyond the mesh
    integer, intent(out) :: stride !! step between them

    first = max(1, nint(command%v(1)))
    last = nint(command%v(2))
    if (last == 0) last = merge(highest, first, command%v(1) < 1.0_wp)
    stride = max(1, nint(command%v(3)))
  end subroutine numbers_to_print

  !> STRE[,ALL] or STRE,,n1,n2,n3: Cauchy stresses of elements, their means; STRE,NODE,n1,n2,n3: at
  !! nodes, recovered from the elements around. Behind them that of von Mises.
  subroutine print_stresses(command, model, system, state, log, error)
    type(batch_command_t), intent(in) :: command !! which elements or nodes
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! its elements
    type(state_t), intent(in) :: state !! the converged state
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(out) :: error !! trouble with the file
    type(nodal_fields_t) :: nodal
    real(wp), allocatable :: stress(:, :)
    logical, allocatable :: there(:)
    character(:), allocatable :: what

    if (command%option == 'node') then
      what = 'node'
      there = model%mesh%used
      call find_nodal_fields(model%mesh, system, state%u, nodal)
      call move_alloc(nodal%values, stress)
    else
      what = 'element'
      there = model%mesh%ix(1, :model%mesh%elements) > 0
      allocate (stress(6, model%mesh%elements))
      call find_element_fields(system, model%mesh%x, state%u, stress=stress)
    end if
    call log_line(log, '  stresses at time '//to_text(state%time, 12)//': '//what// &
      ' xx yy zz xy yz zx von_mises', error)
    call print_table(command, there, stress, log, error)
  end subroutine print_stresses

  !> Stresses of nodes or elements, a line each.
  subroutine print_table(command, there, stress, log, error)
    type(batch_command_t), intent(in) :: command !! which numbers
    logical, intent(in) :: there(:) !! (n) the mesh has this one
    real(wp), intent(in) :: stress(:, :) !! (6, n) their stresses
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(inout) :: error !! trouble with the file
    character(120) :: line
    integer :: first, last, stride, i

    call numbers_to_print(command, size(there), first, last, stride)
    do i = first, min(last, size(there)), stride
      if (.not. there(i)) cycle
      write (line, '(i10,7es14.5e3)') i, stress(:, i), von_mises(stress(:, i:i))
      call log_line(log, trim(line), error)
    end do
  end subroutine print_table

  !> CHEC: how many nodes and elements, volumes, and the worst shape.
  subroutine print_mesh(mesh, log, error)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(out) :: error !! trouble with the file
    real(wp), allocatable :: volume(:), ratio(:)
    logical, allocatable :: there(:)
    integer :: e

    allocate (there(mesh%elements), source=mesh%ix(1, :mesh%elements) > 0)
    allocate (volume(mesh%elements), ratio(mesh%elements), source=0.0_wp)
    do e = 1, mesh%elements
      if (.not. there(e)) cycle
      volume(e) = cell_volume(mesh%x, mesh%ix(:, e))
      ratio(e) = cell_aspect(mesh%x, mesh%ix(:, e))
    end do
    call log_line(log, '  mesh: '//to_text(count(mesh%defined))//' nodes, '// &
      to_text(count(there))//' elements, volume '//to_text(sum(volume), 12)// &
      ' between their corners', error)
    e = minloc(volume, dim=1, mask=there)
    call log_line(log, '  smallest volume '//to_text(volume(e), 6)//' in element '//to_text(e)// &
      ', largest '//to_text(maxval(volume), 6)//' in element '// &
      to_text(maxloc(volume, dim=1)), error)
    e = maxloc(ratio, dim=1)
    call log_line(log, '  longest edge over shortest height: at most '//to_text(ratio(e), 4)// &
      ', in element '//to_text(e), error)
  end subroutine print_mesh

  !> DISP[,ALL] or DISP,,n1,n2,n3, REAC likewise: the vectors of all nodes, or of n1 to n2 in steps
  !! of n3, and their sum.
  subroutine print_vectors(command, model, what, time, v, log, error)
    type(batch_command_t), intent(in) :: command !! which nodes
    type(model_t), intent(in) :: model !! the problem
    character(*), intent(in) :: what !! heading
    real(wp), intent(in) :: time !! time of the state
    real(wp), intent(in) :: v(:, :) !! (3, nodes) the vectors
    type(log_t), intent(inout) :: log !! the log
    type(error_t), allocatable, intent(inout) :: error !! trouble with the file
    character(80) :: line
    integer :: first, last, stride, i

    call numbers_to_print(command, model%mesh%nodes, first, last, stride)
    last = min(last, model%mesh%nodes)
    call log_line(log, '  nodal '//what//' at time '//to_text(time, 12), error)
    do i = first, last, stride
      if (.not. model%mesh%defined(i)) cycle
      write (line, '(i10,3es20.11e3)') i, v(:, i)
      call log_line(log, trim(line), error)
    end do
    write (line, '(a10,3es20.11e3)') 'sum', sum(v(:, first:last:stride), 2)
    call log_line(log, trim(line), error)
  end subroutine print_vectors
end module printing
