!> Sums over what the balance of a state rests on, by which a restart knows that the deck is still
!! the one that the state was in balance with: loads and supports at its time, materials, pairs.
module scene_marks
  use, intrinsic :: iso_fortran_env, only: int32, int64
  use kinds, only: wp
  use checksums, only: block_sum
  use friction_laws, only: any_acts
  use contact_types, only: pair_t
  use loads, only: conditions_at, load_factor
  use rigid_paths, only: count_rigid, load_at
  use model_types, only: model_t
  use system_types, only: system_t
  implicit none
  private
  public :: mark_scene, mark_time

contains

  !> The sum over a scene at a time, in two words.
  pure function mark_scene(model, system, time) result(mark)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! its degrees of freedom
    real(wp), intent(in) :: time !! the time
    integer(int32) :: mark(2)
    integer(int64) :: sum
    integer :: m, k

    sum = ieor(sum_of_loads(model, system%equation, time), &
      block_sum('supports', reshape(merge(1, 2, system%equation == 0), [3*model%mesh%nodes])))
    sum = ieor(sum, block_sum('laws', [(model%materials(m)%law + &
      merge(100, 0, model%materials(m)%rigid) + merge(1000, 0, model%materials(m)%nodal), &
      m=1, size(model%materials))]))
    sum = ieor(sum, sum_of('moduli', [([model%materials(m)%youngs_modulus, &
      model%materials(m)%poissons_ratio, model%materials(m)%density], m=1, size(model%materials))]))
    sum = ieor(sum, sum_of('own parameters', &
      [(model%materials(m)%own, m=1, size(model%materials))]))
    if (allocated(model%conditions%pressures)) then
      if (size(model%conditions%pressures) > 0) sum = ieor(sum, sum_of('pressures', &
        [(real(model%conditions%pressures(k)%surface, wp), model%conditions%pressures(k)%value* &
        load_factor(model%tables, model%conditions%pressures(k)%table, time), &
        k=1, size(model%conditions%pressures))]))
    end if
    if (allocated(system%loads%spring)) sum = ieor(sum, sum_of('springs', &
      reshape(system%loads%spring, [size(system%loads%spring)])))
    if (count_rigid(model) > 0) sum = ieor(sum, sum_of('rigid', &
      [([model%conditions%rigid(k)%point, merge(1.0_wp, 0.0_wp, model%conditions%rigid(k)%free), &
      load_at(model, k, time)], k=1, count_rigid(model))]))
    do k = 1, size(model%pairs)
      sum = ieor(sum, sum_of_pair(model%pairs(k)))
      if (model%pairs(k)%shrinking%shrink >= 0) sum = ieor(sum, sum_of(model%pairs(k)%name// &
        ' shrink', [load_factor(model%tables, model%pairs(k)%shrinking%shrink, time)]))
    end do
    mark = transfer(sum, mark)
  end function mark_scene

  !> The sum over a time, in two words.
  pure function mark_time(time) result(mark)
    real(wp), intent(in) :: time !! the time
    integer(int32) :: mark(2)

    mark = transfer(sum_of('time', [time]), mark)
  end function mark_time

  !> The sum over prescribed displacements and applied forces; forces on supports count by
  !! themselves, and only where there are such.
  pure integer(int64) function sum_of_loads(model, equation, time) result(sum)
    type(model_t), intent(in) :: model !! conditions and tables
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: time !! the time
    real(wp), dimension(3, model%mesh%nodes) :: u, force
    integer :: n

    n = 3*model%mesh%nodes
    call conditions_at(model, time, u, force)
    sum = sum_of('loads', reshape(merge(u, force, equation == 0), [n]))
    where (equation > 0) force = 0.0_wp
    if (any(abs(force) > 0.0_wp)) sum = ieor(sum, sum_of('forces on supports', reshape(force, [n])))
  end function sum_of_loads

  !> The sum over what the forces of a pair depend on.
  pure integer(int64) function sum_of_pair(pair) result(sum)
    type(pair_t), intent(in) :: pair !! the pair
    integer :: flags(7)

    flags = [merge(1, 0, [pair%segmented, pair%smooth, pair%augmented, pair%history%softened, &
      pair%friction%convected]), pair%friction%slip_rule, pair%friction%direction]
    sum = ieor(block_sum(pair%name//' form', flags), sum_of(pair%name//' friction', &
      [pair%friction%mu, pair%friction%axis, pair%friction%point, pair%friction%angle]))
    if (pair%segmented) then
      sum = ieor(sum, sum_of(pair%name//' density', [pair%points%density]))
    else
      sum = ieor(sum, sum_of(pair%name//' penalty', pair%points%epsilon))
    end if
    if (any_acts(pair%law)) sum = ieor(sum, sum_of(pair%name//' laws', pair%law))
    if (allocated(pair%surface%lay)) sum = ieor(sum, sum_of(pair%name//' lay', &
      reshape(pair%surface%lay, [size(pair%surface%lay)])))
    if (allocated(pair%surface%facet_axis)) sum = ieor(sum, sum_of(pair%name//' field', &
      reshape(pair%surface%facet_axis, [size(pair%surface%facet_axis)])))
  end function sum_of_pair

  !> The sum over numbers; zeros of either sign are the same.
  pure integer(int64) function sum_of(name, values) result(sum)
    character(*), intent(in) :: name !! of the block
    real(wp), intent(in) :: values(:) !! the numbers

    sum = block_sum(name, transfer(values + 0.0_wp, [integer(int32) ::]))
  end function sum_of
end module scene_marks
