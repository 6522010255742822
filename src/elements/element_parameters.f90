!> Places of the parameters d of the contact elements: those of element 3 come first in all of them.
module element_parameters
  use friction_laws, only: n_law_values
  use smooth_patch, only: n_patch_values
  implicit none
  private
  public :: d03_epsilon, d03_mu, d03_rule, d03_axis_kind, d03_axis, d03_turn, d03_place, d03_law, &
    d03_area, d04_patch, n_parameters
  public :: axis_convected, axis_space_fixed, axis_circumferential, axis_radial

  integer, parameter :: d03_epsilon = 1 !! place of the penalty in d [force/length]
  integer, parameter :: d03_mu = 2 !! mu1, mu2
  integer, parameter :: d03_rule = 4 !! slip rule m
  integer, parameter :: d03_axis_kind = 5 !! one of the kinds below
  integer, parameter :: d03_axis = 6 !! vector or axis (3); or c1, c2 of p = c1 a1 + c2 a2
  integer, parameter :: d03_turn = 9 !! cosine and sine of the turn about the normal (space-fixed)
  integer, parameter :: d03_place = 11 !! point of the axis (3); or dc/dxi (2), dc/deta (2)
  integer, parameter :: d03_law = 15 !! values of the laws that change the cone (n_law_values)
  integer, parameter :: d03_area = d03_law + n_law_values !! reference area of the point [length^2]
  integer, parameter :: d04_patch = d03_area + 1 !! place of the patch of element 4 in d
  integer, parameter :: n_parameters = d03_area + n_patch_values !! room for d

  integer, parameter :: axis_convected = 0 !! the axis is carried with the facet
  integer, parameter :: axis_space_fixed = 1 !! a fixed vector is projected on the facet
  integer, parameter :: axis_circumferential = 2 !! the direction around a fixed axis is projected
  integer, parameter :: axis_radial = 3 !! the direction away from a fixed axis is projected
end module element_parameters
