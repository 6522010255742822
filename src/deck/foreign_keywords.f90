!> Rows of the keyword table: words of FEAP that are passed over, and words that are refused because
!! they would change the answer, each with what to write instead.
module foreign_keywords
  use keyword_types, only: keyword_table_t, table_mesh, table_batch, add_ignored, add_refused
  implicit none
  private
  public :: add_foreign_keywords

contains

  !> All of them, behind the commands of this program.
  subroutine add_foreign_keywords(t)
    type(keyword_table_t), intent(inout) :: t !! the table

    call add_ignored(t, table_mesh, 'INTEractive PLOT NOPRint PRINt OPTImize DEBUg NOPArse '// &
                     'PARSe TITLe REMArk MANUal COUNt NOCOunt KEEP NOKEep')
    call add_ignored(t, table_batch, 'BATCh MACRo INTEractive PLOT NOPRint PRINt OPTImize '// &
                     'DIREct ITERative DEBUg COMMent SHOW MANUal HELP ECHO IDENtity')
    call refuse_coordinates(t)
    call refuse_conditions(t)
    call refuse_solutions(t)
  end subroutine add_foreign_keywords

  !> What makes or moves nodes and elements.
  subroutine refuse_coordinates(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: polar = &
      'write Cartesian coordinates: r*cosd(a) and r*sind(a) are numbers'
    character(*), parameter :: offset = 'write the numbers of nodes and elements out'
    character(*), parameter :: blend = 'BLOCk takes 8 to 27 master points; or MESH of a file'

    call add_refused(t, table_mesh, 'POLAr', polar)
    call add_refused(t, table_mesh, 'CYLIndrical', polar)
    call add_refused(t, table_mesh, 'SPHErical', polar)
    call add_refused(t, table_mesh, 'SHIFt', 'TRANsform moves the coordinates that follow it')
    call add_refused(t, table_mesh, 'REGIon', &
                     'BLOCk name, or AS name of MESH, makes a region; INSIde name finds it')
    call add_refused(t, table_mesh, 'EREGion', &
                     'BLOCk name, or AS name of MESH, makes a region; INSIde name finds it')
    call add_refused(t, table_mesh, 'READ', 'INCLude file reads on in another file')
    call add_refused(t, table_mesh, 'LOOP', &
                     'write the records out; COORdinates and ELEMents generate by inc')
    call add_refused(t, table_mesh, 'NEXT', &
                     'write the records out; COORdinates and ELEMents generate by inc')
    call add_refused(t, table_mesh, 'CONStant', 'PARAmeter names numbers')
    call add_refused(t, table_mesh, '*NODe', offset)
    call add_refused(t, table_mesh, '*ELEment', offset)
    call add_refused(t, table_mesh, 'BLENd', blend)
    call add_refused(t, table_mesh, 'SNODe', blend)
    call add_refused(t, table_mesh, 'SIDE', blend)
  end subroutine refuse_coordinates

  !> Supports, loads and links.
  subroutine refuse_conditions(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: angle = &
      'supports follow the axes. One cut plane: turn the mesh by TRANsform so that an axis is '// &
      'normal to it. Two: model a quarter or half, whose planes are normal to axes; or, where '// &
      'it is pressed on all over, hold the second by SURFace name PLANe and a PAIR without '// &
      'FRICtion'
    character(*), parameter :: linked = &
      'TIE joins nodes at one place; a stiff contact PAIR joins others'
    character(*), parameter :: cold = 'there are no temperatures: leave it out'

    call add_refused(t, table_mesh, 'ANGLe', angle)
    call add_refused(t, table_mesh, 'EANGle', angle)
    call add_refused(t, table_mesh, 'CANGle', angle)
    call add_refused(t, table_mesh, 'CSURface', &
                     'TRACtion and PRESsure load a SURFace; EDISplacement moves a plane')
    call add_refused(t, table_mesh, 'LINK', linked)
    call add_refused(t, table_mesh, 'ELINk', linked)
    call add_refused(t, table_mesh, 'CLINk', linked)
    call add_refused(t, table_mesh, 'PERIodic', linked)
    call add_refused(t, table_mesh, 'TEMPerature', cold)
    call add_refused(t, table_mesh, 'BTEMperature', cold)
    call add_refused(t, table_mesh, 'RESEt', 'leave out the restraints that it takes away')
  end subroutine refuse_conditions

  !> Solution commands.
  subroutine refuse_solutions(t)
    type(keyword_table_t), intent(inout) :: t !! the table
    character(*), parameter :: static = 'loads are static: leave out what belongs to inertia'
    character(*), parameter :: way = 'TANG,,1 in a LOOP, or STEP,,n, finds the equilibrium'

    call add_refused(t, table_batch, 'TRANsient', static)
    call add_refused(t, table_batch, 'MASS', static)
    call add_refused(t, table_batch, 'DAMPing', static)
    call add_refused(t, table_batch, 'SUBSpace', static)
    call add_refused(t, table_batch, 'EIGVector', static)
    call add_refused(t, table_batch, 'VELOcity', static)
    call add_refused(t, table_batch, 'ACCEleration', static)
    call add_refused(t, table_batch, 'ARCLength', way)
    call add_refused(t, table_batch, 'BFGS', way)
    call add_refused(t, table_batch, 'DSOLve', way)
    call add_refused(t, table_batch, 'INITial', 'REST takes an initial state')
    call add_refused(t, table_batch, 'MESH', 'all mesh data stand before BATCh')
    call add_refused(t, table_batch, 'IF', 'write the commands that are to be obeyed')
    call add_refused(t, table_batch, 'ELSE', 'write the commands that are to be obeyed')
    call add_refused(t, table_batch, 'ENDIf', 'write the commands that are to be obeyed')
    call add_refused(t, table_batch, 'TPLOt', &
                     'HISTory NODE node dof in OUTPut writes a table over time')
    call add_refused(t, table_batch, 'READ', 'REST,file.h5 takes a state')
    call add_refused(t, table_batch, 'WRITe', 'SAVE,name keeps the state')
  end subroutine refuse_solutions
end module foreign_keywords
