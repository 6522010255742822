!> What statics says of a failed solve, in words.
module statics_report
  use kinds, only: wp
  use text, only: to_text
  use statics, only: verdict_t, statics_slides, statics_turns, statics_tips, statics_lifts
  implicit none
  private
  public :: motion_text, reserve_text, turned_text

contains

  !> What is left of friction where contact could carry the loads.
  function reserve_text(name, verdict, slips, penalties) result(t)
    character(*), intent(in) :: name !! of the body that would move first
    type(verdict_t), intent(in) :: verdict !! what statics says
    logical, intent(in) :: slips !! all of its closed contact points do
    logical, intent(in) :: penalties !! contact has some
    character(:), allocatable :: t

    t = '  statics: contact can carry the loads with '//to_text(100.0_wp*verdict%friction, 3)// &
      ' % of its friction, pressed where that helps'
    if (slips) t = t//new_line('a')//'  but all its closed contact points slip: as they are '// &
      'pressed now, friction is used up'
    if (verdict%friction < 0.5_wp .and. .not. slips) then
      t = t//new_line('a')//'  friction is not what is missing: '
      if (penalties) t = t//'try a softer penalty (PENAlty AUTO 1), or '
      t = t//'let the bodies touch before they are loaded (ADJUst)'
      return
    end if
    if (verdict%next == statics_slides) t = t//new_line('a')//'  with less '//name// &
      ' slides along '//axis_text(verdict%motion(1:3))
    if (verdict%next == statics_turns) t = t//new_line('a')//'  with less '//name// &
      ' turns about '//axis_text(verdict%motion(4:6))
    if (.not. slips) t = t//new_line('a')//'  friction may be used up'
    t = t//new_line('a')//'  lower the load, raise the coefficient '// &
      'of FRICtion, or restrain the body with BOUNdary'
  end function reserve_text

  !> That a body has turned too far for small strain, and what to change.
  function turned_text(name, angle, most) result(t)
    character(*), intent(in) :: name !! of the body
    real(wp), intent(in) :: angle, most !! how far it has turned, and how far it may [degree]
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')

    t = '  '//name//' has rotated by '//to_text(angle, 3)//' degrees as a whole, and may by '// &
      to_text(most, 3)//': in small'//nl//'  strain a rotation by a produces spurious '// &
      'strains of a^2/2, here more than 0.05, and the body grows with them:'//nl// &
      '  restrain it (BOUNdary, more FRICtion, less load), rotate the mesh beforehand, '// &
      'or give it'//nl//'  a law of finite strain (SOLId NEOHookean)'
  end function turned_text

  !> How a body gets away under loads that contact cannot carry, and what to change.
  function motion_text(name, verdict) result(t)
    character(*), intent(in) :: name !! of the body
    type(verdict_t), intent(in) :: verdict !! what statics says
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')

    t = '  no equilibrium: '//name
    if (verdict%here) t = '  nothing holds it where it is: '//name
    select case (verdict%kind)
    case (statics_slides)
      t = t//' slides along '//axis_text(verdict%motion(1:3))//friction_text(verdict%friction)
    case (statics_turns)
      t = t//' turns about '//axis_text(verdict%motion(4:6))//friction_text(verdict%friction)
    case (statics_tips)
      t = t//' tips over, about '//axis_text(verdict%motion(4:6))//': its load passes '// &
        'outside of the places that can carry it'//nl//'  lower the load that tips it, move it '// &
        'inwards, or hold it with BOUNdary'
    case (statics_lifts)
      t = t//' lifts off along '//axis_text(verdict%motion(1:3))//': its load pulls it away '// &
        'from what it touches'//nl//'  lower that load, or hold the body with BOUNdary'
    case default
      t = t//' gets away'
    end select
  end function motion_text

  !> What friction would have to be, and what to change.
  function friction_text(factor) result(t)
    real(wp), intent(in) :: factor !! how much larger friction would have to be, 0: there is none
    character(:), allocatable :: t

    if (factor > 0.0_wp) then
      t = ': friction does not hold it, it would have to be '//to_text(factor, 4)// &
        ' times as large'
    else
      t = ': without friction nothing resists'
    end if
    t = t//new_line('a')//'  lower the load, raise the coefficient of FRICtion, or restrain '// &
      'the body with BOUNdary'
    if (factor <= 0.0_wp) t = t//new_line('a')//'  if it would come to rest farther on, let it '// &
      'start nearer to that place'
  end function friction_text

  !> A direction in words.
  function axis_text(way) result(t)
    real(wp), intent(in) :: way(3) !! the direction, of any length
    character(:), allocatable :: t
    real(wp) :: unit(3)
    integer :: k

    unit = way/max(norm2(way), tiny(1.0_wp))
    do k = 1, 3
      if (abs(unit(k)) < 0.999_wp) cycle
      t = merge(' x', '-x', unit(k) > 0.0_wp)//to_text(k)
      t = trim(adjustl(t))
      return
    end do
    where (abs(unit) < 1.0e-3_wp) unit = 0.0_wp
    t = '('//to_text(unit(1), 3)//', '//to_text(unit(2), 3)//', '//to_text(unit(3), 3)//')'
  end function axis_text
end module statics_report
