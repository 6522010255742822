!> Stresses to look at: at the nodes, and as one number.
module nodal_stress
  use kinds, only: wp
  use vectors, only: cross
  use mesh_types, only: mesh_t
  implicit none
  private
  public :: average_stress, von_mises

contains

  !> Mean of the stresses around each node, weighted by the volumes of the elements. Elements
  !! without stress, those of rigid regions, take no part where others are.
  pure subroutine average_stress(mesh, stress, nodal)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(in) :: stress(:, :) !! (6, elements) xx yy zz xy yz zx
    real(wp), allocatable, intent(out) :: nodal(:, :) !! (6, nodes) the same at the nodes
    real(wp), allocatable :: share(:)
    real(wp) :: volume
    integer :: e, k, n

    allocate (nodal(6, mesh%nodes), share(mesh%nodes), source=0.0_wp)
    do e = 1, size(stress, 2)
      if (mesh%ix(1, e) == 0 .or. all(abs(stress(:, e)) <= 0.0_wp)) cycle
      volume = corner_volume(mesh%x(:, mesh%ix(1:4, e)))
      do k = 1, count(mesh%ix(:, e) > 0)
        n = mesh%ix(k, e)
        nodal(:, n) = nodal(:, n) + volume*stress(:, e)
        share(n) = share(n) + volume
      end do
    end do
    do n = 1, mesh%nodes
      if (share(n) > 0.0_wp) nodal(:, n) = nodal(:, n)/share(n)
    end do
  end subroutine average_stress

  !> Volume of a tetrahedron, by its corners.
  pure real(wp) function corner_volume(x) result(volume)
    real(wp), intent(in) :: x(3, 4) !! its corners [length]

    volume = abs(dot_product(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1)), x(:, 4) - x(:, 1)))/6.0_wp
  end function corner_volume

  !> sqrt(3/2 s:s) with the deviator s.
  pure function von_mises(stress) result(value)
    real(wp), intent(in) :: stress(:, :) !! (6, n) xx yy zz xy yz zx
    real(wp) :: value(1, size(stress, 2))
    integer :: k

    do k = 1, size(stress, 2)
      associate (s => stress(:, k))
        value(1, k) = sqrt(0.5_wp*((s(1) - s(2))**2 + (s(2) - s(3))**2 + (s(3) - s(1))**2) &
          + 3.0_wp*sum(s(4:6)**2))
      end associate
    end do
  end function von_mises
end module nodal_stress
