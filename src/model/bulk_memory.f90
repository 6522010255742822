!> What the points of the bulk remember from one converged state to the next, where a law asks.
module bulk_memory
  use cells, only: nodes_of, tet4
  use solid_types, only: most_points
  use bulk_laws, only: laws
  use model_types, only: model_t
  implicit none
  private
  public :: memory_shape

contains

  !> Numbers of a point, points of an element, elements; the first is 0 if no law asks.
  pure function memory_shape(model) result(dims)
    type(model_t), intent(in) :: model !! materials, mesh
    integer :: dims(3), k

    dims = [maxval([0, laws(model%materials%law)%n_state]), 1, model%mesh%elements]
    do k = 1, model%mesh%elements
      if (nodes_of(model%mesh%ix(:, k)) > tet4%nodes) dims(2) = most_points
    end do
  end function memory_shape
end module bulk_memory
