!> What may help where Newton's method does not converge, by what is seen at the failed iterate.
module remedies
  use kinds, only: wp
  use text, only: to_text
  use element_types, only: status_open, status_slip
  use facet_geometry, only: project_on_facet
  use element_lists, only: master_nodes
  use contact_points, only: point_position
  use contact_types, only: pair_t
  use model_types, only: model_t
  use system_types, only: system_t
  implicit none
  private
  public :: what_may_help, settle_advice

  !> A penetration by more than this share of the cells at the surface is deep.
  real(wp), parameter :: deep = 0.2_wp
  !> A softer penalty converges more surely above this times E/h.
  real(wp), parameter :: soft_penalty = 10.0_wp

contains

  !> One line of advice for each thing that is seen; lines begin with two blanks.
  function what_may_help(model, system, cut) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the failed iterate
    logical, intent(in) :: cut !! smaller increments have been tried as far as it goes
    character(:), allocatable :: t
    integer :: k, first, last

    t = ''
    if (.not. cut) t = '  try smaller steps (DT)'
    if (all(system%contact%status <= status_open)) then
      t = joined(t, '  no contact point is closed: let the bodies touch at the start '// &
        '(ADJUst, or move one), and bring them together by DISPlacement before they are loaded')
      return
    end if
    do k = 1, size(model%pairs)
      first = system%place%first_point(k)
      last = system%place%first_point(k + 1) - 1
      if (all(system%contact%status(first:last) <= status_open)) cycle
      t = joined(t, pair_advice(model, system, k))
    end do
    if (cut) t = joined(t, '  steps down to 1/1024 of DT were tried and do not help')
  end function what_may_help

  !> What may help a pair that is closed.
  function pair_advice(model, system, k) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the failed iterate
    integer, intent(in) :: k !! the pair
    character(:), allocatable :: t
    real(wp) :: gap

    t = ''
    associate (pair => model%pairs(k))
      gap = deepest(model, system, k)
      if (pair%points%cell > 0.0_wp .and. gap > deep*pair%points%cell) t = joined(t, '  pair '// &
        pair%name//' is penetrated by '//to_text(gap, 3)//', '//to_text(gap/pair%points%cell, &
        2)//' cells: look at units and size of loads and displacements, or raise its penalty')
      t = joined(t, penalty_advice(pair))
      if (any(pair%friction%mu > 0.0_wp) .and. mostly_slips(system, k)) t = joined(t, '  pair '// &
        pair%name//': most of its points slip: hold what glides with BOUNdary, or move it by '// &
        'DISPlacement in place of FORCe')
      if (.not. (pair%smooth .or. pair%segmented)) t = joined(t, '  pair '//pair%name// &
        ': if its master is curved, write SMOOth or refine it')
    end associate
  end function pair_advice

  !> What to do with the penalty of a pair, or without one.
  function penalty_advice(pair) result(t)
    type(pair_t), intent(in) :: pair !! closed, and not solved
    character(:), allocatable :: t

    if (pair%mortar) then
      t = '  pair '//pair%name//': try GTOS with PENAlty AUTO '// &
        'in place of MORTar: a penalty is more forgiving'
    else if (pair%points%relative > soft_penalty) then
      t = '  pair '//pair%name//': a penalty of '//to_text(pair%points%relative, 3)// &
        ' E/h is stiff: write PENAlty AUTO 10, with AUGMent if its gaps must close'
    else if (pair%points%relative > 0.0_wp) then
      t = '  pair '//pair%name//': try a softer penalty (PENAlty AUTO 1), with AUGMent if its '// &
        'gaps must close'
    else
      t = '  pair '//pair%name//': try PENAlty AUTO, or a softer penalty'
    end if
  end function penalty_advice

  !> What may help a point that does not settle on a facet.
  pure function settle_advice(model, cut) result(t)
    type(model_t), intent(in) :: model !! pairs
    logical, intent(in) :: cut !! smaller increments have been tried as far as it goes
    character(:), allocatable :: t

    t = '  refine the master there'
    if (any(.not. (model%pairs%smooth .or. model%pairs%segmented))) t = t//', write SMOOth'
    if (.not. all(model%pairs%mortar)) t = t//', or a softer penalty (PENAlty AUTO)'
    if (any(model%pairs%mortar)) t = t//', or GTOS with PENAlty AUTO in place of MORTar'
    if (.not. cut) t = t//', or move in smaller steps (DT)'
  end function settle_advice

  !> The deepest penetration of the closed points of a pair.
  real(wp) function deepest(model, system, k)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the failed iterate
    integer, intent(in) :: k !! the pair
    real(wp) :: x(3, size(system%u, 2)), xi(2), gap
    integer :: p, facet(3)

    x = model%mesh%x + system%u
    deepest = 0.0_wp
    do p = system%place%first_point(k), system%place%first_point(k + 1) - 1
      if (system%contact%status(p) <= status_open) cycle
      facet = master_nodes(system%contact, p)
      call project_on_facet(x(:, facet), point_position(model%pairs(k), &
        p - system%place%first_point(k) + 1, x), xi, gap)
      deepest = max(deepest, -gap)
    end do
  end function deepest

  !> More than half of the closed points of a pair slip.
  pure logical function mostly_slips(system, k) result(yes)
    type(system_t), intent(in) :: system !! the failed iterate
    integer, intent(in) :: k !! the pair

    associate (status => system%contact%status(system%place%first_point(k): &
      system%place%first_point(k + 1) - 1))
      yes = 2*count(status == status_slip) > count(status > status_open)
    end associate
  end function mostly_slips

  !> Two texts, the second on a line of its own.
  pure function joined(a, b) result(t)
    character(*), intent(in) :: a !! lines, may be empty
    character(*), intent(in) :: b !! lines, may be empty
    character(:), allocatable :: t

    t = a//b
    if (len(a) > 0 .and. len(b) > 0) t = a//new_line('a')//b
  end function joined
end module remedies
