!> The ways of the apexes of friction cones over the master: what friction works on.
module apex_ways
  use kinds, only: wp
  use quadratic_facet, only: place_on_quadratic, facet_flat, facet_of_routine
  use element_types, only: routine_smooth
  use element_lists, only: element_list_t, master_nodes
  use smooth_patch, only: patch_t, patch_point_t, patch_from_values, patch_at, patch_frame
  use element_parameters, only: d04_patch, n_parameters
  implicit none
  private
  public :: way_of_apex

contains

  !> Way of an apex over the master in one increment: friction takes the force on it times this way.
  pure function way_of_apex(list, element, x) result(way)
    type(element_list_t), intent(in) :: list !! contact elements
    integer, intent(in) :: element !! a closed one
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions they are at [length]
    real(wp) :: way(3), dxi(2)
    integer :: kind

    associate (nodes => master_nodes(list, element))
      kind = facet_of_routine(list%routine(element))
      if (kind /= facet_flat) then
        associate (facet => x(:, list%ix(list%nel(element) - 5:list%nel(element), element)))
          way = place_on_quadratic(facet, list%h2(:, element), kind) &
            - place_on_quadratic(facet, list%h1(:, element), kind)
        end associate
      else if (list%routine(element) == routine_smooth) then
        way = patch_way(list%d(d04_patch:n_parameters, element), x(:, nodes), &
          list%h1(:, element), list%h2(:, element))
      else
        dxi = list%h2(:, element) - list%h1(:, element)
        way = dxi(1)*(x(:, nodes(1)) - x(:, nodes(3))) + dxi(2)*(x(:, nodes(2)) - x(:, nodes(3)))
      end if
    end associate
  end function way_of_apex

  !> The way from one point of a patch to another.
  pure function patch_way(values, x, from, to) result(way)
    real(wp), intent(in) :: values(:) !! (n_patch_values) the patch
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp), intent(in) :: from(2) !! (xi, eta)
    real(wp), intent(in) :: to(2) !! (xi, eta)
    real(wp) :: way(3)
    type(patch_t) :: patch
    type(patch_point_t) :: start, finish

    patch = patch_from_values(values)
    start = patch_at(patch, from)
    finish = patch_at(patch, to)
    way = matmul(patch_frame(x), finish%x - start%x)
  end function patch_way
end module apex_ways
