!> Rows of the table of contact points (.pts): the slave nodes of a pair, or the facets that its
!! points lie in (doc/manual, "Table of points").
module point_rows
  use kinds, only: wp
  use contact_types, only: pair_t, form_quadrature_to_surface
  use contact_points, only: count_points
  use point_fields, only: point_fields_t
  use contact_sides, only: contact_surface_t
  use contact_surfaces, only: find_slave_fields, n_columns, at_pressure, &
    at_shear, at_gap, at_status, at_slip
  implicit none
  private
  public :: point_row_t, find_point_rows

  !> One row.
  type :: point_row_t
    integer :: point = 0 !! node, or facet of the slave surface
    integer :: status = 0 !! -1 off, 0 open, 1 stick, 2 slip
    real(wp) :: values(6) = 0.0_wp !! p, t1, t2, t3, gap, slip
  end type point_row_t

contains

  !> The rows of a pair at one time.
  subroutine find_point_rows(pair, surface, points, highest, rows)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its slave side
    type(point_fields_t), intent(in) :: points !! its points
    integer, intent(in) :: highest !! highest node number
    type(point_row_t), allocatable, intent(out) :: rows(:) !! the rows, by number
    real(wp) :: at_nodes(n_columns, size(surface%nodes))
    real(wp) :: at_facets(n_columns, size(surface%facets, 2) + size(surface%lone))
    integer :: i

    call find_slave_fields(pair, surface, points, highest, at_nodes, at_facets)
    if (pair%form == form_quadrature_to_surface) then
      allocate (rows(size(surface%facets, 2)))
      do i = 1, size(rows)
        rows(i)%point = i
        call take_fields(at_facets(:, i), rows(i))
      end do
    else
      allocate (rows(size(surface%nodes)))
      do i = 1, size(rows)
        rows(i)%point = surface%nodes(i)
        call take_fields(at_nodes(:, i), rows(i))
      end do
      call take_forces(pair, surface, points, highest, rows)
      rows = pack(rows, is_slave(pair, surface, highest))
    end if
  end subroutine find_point_rows

  !> Fields to a row; without a master there is neither gap nor slip, without an area no traction.
  pure subroutine take_fields(fields, row)
    real(wp), intent(in) :: fields(:) !! (n_columns) fields of contact_surfaces
    type(point_row_t), intent(inout) :: row !! gets them

    row%status = nint(fields(at_status))
    row%values = 0.0_wp
    if (row%status < 0) return
    row%values(1) = fields(at_pressure)
    row%values(2:4) = fields(at_shear:at_shear + 2)
    row%values(5) = fields(at_gap)
    row%values(6) = norm2(fields(at_slip:at_slip + 2))
  end subroutine take_fields

  !> Slave nodes that no facet holds have forces in the place of tractions.
  pure subroutine take_forces(pair, surface, points, highest, rows)
    type(pair_t), intent(in) :: pair !! the pair, NTOS
    type(contact_surface_t), intent(in) :: surface !! its slave side
    type(point_fields_t), intent(in) :: points !! its points
    integer, intent(in) :: highest !! highest node number
    type(point_row_t), intent(inout) :: rows(:) !! (slave nodes) p and t of lone ones
    integer :: row_of(highest), i, p

    if (size(surface%lone) == 0) return
    row_of = 0
    do i = 1, size(surface%lone)
      row_of(surface%nodes(surface%lone(i))) = surface%lone(i)
      rows(surface%lone(i))%values(1:4) = 0.0_wp
    end do
    do p = 1, count_points(pair)
      i = row_of(pair%points%point_nodes(1, p))
      if (i == 0) cycle
      associate (values => rows(i)%values, normal => points%normal_force(p))
        values(1) = values(1) + normal
        values(2:4) = values(2:4) + points%traction(:, p) - normal*points%normal(:, p)
      end associate
    end do
  end subroutine take_forces

  !> Which nodes of the slave side are points of the pair.
  pure function is_slave(pair, surface, highest) result(yes)
    type(pair_t), intent(in) :: pair !! the pair, NTOS
    type(contact_surface_t), intent(in) :: surface !! its slave side
    integer, intent(in) :: highest !! highest node number
    logical :: yes(size(surface%nodes))
    logical :: slave(highest)

    slave = .false.
    slave(pair%points%point_nodes(1, :)) = .true.
    yes = slave(surface%nodes)
  end function is_slave
end module point_rows
