!> TRANsform: turns and moves the coordinates that follow it.
module transform_reader
  use kinds, only: wp
  use vectors, only: determinant
  use deck_types, only: data_set_t
  use records, only: item_real, item_count
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use mesh_building, only: max_coordinate
  implicit none
  private
  public :: read_transform

contains

  !> Reads one TRANsform: three records of a matrix T and one of a vector x0, for x = T x + x0; with
  !! INCrement it comes after the one before it.
  subroutine read_transform(set, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(inout) :: mesh !! gets turn and shift
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    real(wp) :: rows(3, 4)
    integer :: i, k

    if (.not. set%complete) return
    if (set%count /= 4) then
      call report_error(diagnostics, set%head%at, 'TRANsform takes four records', &
        'three rows of the matrix T, then x0: x = T x + x0')
      return
    end if
    do i = 1, 4
      rows(:, i) = [(item_real(set%records(i), k), k=1, 3)]
    end do
    if (any(abs(rows) > sqrt(max_coordinate))) then
      call report_error(diagnostics, set%head%at, 'a number of TRANsform is absurdly large', &
        'three rows of the matrix T, then x0: x = T x + x0')
    else if (is_singular(rows(:, :3))) then
      call report_error(diagnostics, set%head%at, 'the matrix of TRANsform is singular', &
        'it turns, mirrors or stretches; 1 0 0, 0 1 0, 0 0 1 leaves all as it is')
    else if (item_count(set%head) > 1) then
      mesh%turn = matmul(transpose(rows(:, :3)), mesh%turn)
      mesh%shift = matmul(transpose(rows(:, :3)), mesh%shift) + rows(:, 4)
    else
      mesh%turn = transpose(rows(:, :3))
      mesh%shift = rows(:, 4)
    end if
    mesh%mirrors = determinant(mesh%turn) < 0.0_wp
  end subroutine read_transform

  !> Whether three vectors span no volume to speak of.
  pure logical function is_singular(a)
    real(wp), intent(in) :: a(3, 3) !! the vectors

    is_singular = abs(determinant(a)) <= 1.0e-12_wp*product(norm2(a, 1))
  end function is_singular
end module transform_reader
