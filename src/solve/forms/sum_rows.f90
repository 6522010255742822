!> The rows of the linear sums (doc/theory, "Static condensation"): forces of the sets of reactions
!! (3 each), forces and moments of the supports on each body (6), work of the reactions on what each
!! load prescribes, work of each load's forces, turns of each body (3), swelling of each body (1).
module sum_rows
  use model_types, only: model_t
  use system_types, only: system_t
  use system_parts, only: bodies_t
  implicit none
  private
  public :: body_rows, reaction_rows, load_rows, turn_rows, swelling_row, count_sums

contains

  !> Force and moment of the supports on a body.
  pure function body_rows(model, body) result(rows)
    type(model_t), intent(in) :: model !! output request
    integer, intent(in) :: body !! the body
    integer :: rows(2)

    rows = 3*size(model%output%reactions) + [6*body - 5, 6*body]
  end function body_rows

  !> Works of the reactions on what a unit of each load prescribes.
  pure function reaction_rows(model, body) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(bodies_t), intent(in) :: body !! bodies
    integer :: rows(2)

    rows = 3*size(model%output%reactions) + 6*body%bodies + [1, size(model%conditions%loads)]
  end function reaction_rows

  !> Works of the forces of a unit of each load.
  pure function load_rows(model, system) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer :: rows(2)

    rows = reaction_rows(model, system%body) + size(model%conditions%loads)
  end function load_rows

  !> Turns of a body: the sum of (x - center) x u over its nodes.
  pure function turn_rows(model, system, body) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: body !! the body
    integer :: rows(2), before(2)

    before = load_rows(model, system)
    rows = before(2) + [3*body - 2, 3*body]
  end function turn_rows

  !> Swelling of a body: what its volume changes by, to first order.
  pure integer function swelling_row(model, system, body) result(row)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: body !! the body
    integer :: before(2)

    before = turn_rows(model, system, system%body%bodies)
    row = before(2) + body
  end function swelling_row

  !> How many sums there are.
  pure integer function count_sums(model, system) result(n)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies

    n = swelling_row(model, system, system%body%bodies)
  end function count_sums
end module sum_rows
