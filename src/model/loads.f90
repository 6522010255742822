!> Proportional loads: the factor of a load number at a time.
module loads
  use kinds, only: wp
  use model_types, only: load_table_t
  implicit none
  private
  public :: load_factor, has_load

contains

  !> Factor of load `number` at `time`: number 0 is the sum of all tables, 1 if there is none.
  pure real(wp) function load_factor(tables, number, time) result(factor)
    type(load_table_t), intent(in) :: tables(:) !! the proportional loads
    integer, intent(in) :: number !! load number of a degree of freedom
    real(wp), intent(in) :: time !! time
    integer :: i

    factor = 0.0_wp
    if (number == 0 .and. size(tables) == 0) factor = 1.0_wp
    do i = 1, size(tables)
      if (number == 0 .or. tables(i)%number == number) then
        factor = factor + table_factor(tables(i), time)
      end if
    end do
  end function load_factor

  !> Whether a load number may be used: 0, or the number of a table.
  pure logical function has_load(tables, number)
    type(load_table_t), intent(in) :: tables(:) !! the proportional loads
    integer, intent(in) :: number !! load number

    has_load = number == 0
    if (.not. has_load) has_load = any(tables%number == number)
  end function has_load

  !> Factor of one table at `time`.
  pure real(wp) function table_factor(table, time) result(factor)
    type(load_table_t), intent(in) :: table !! one proportional load
    real(wp), intent(in) :: time !! time

    if (table%function_form) then
      factor = function_factor(table, time)
    else
      factor = interpolated_factor(table%t, table%p, time)
    end if
  end function table_factor

  !> Piecewise linear between the points, constant outside.
  pure real(wp) function interpolated_factor(t, p, time) result(factor)
    real(wp), intent(in) :: t(:) !! (points) ascending times
    real(wp), intent(in) :: p(:) !! (points) factors
    real(wp), intent(in) :: time !! time
    integer :: low, high, middle

    if (time <= t(1)) then
      factor = p(1)
      return
    end if
    if (time >= t(size(t))) then
      factor = p(size(p))
      return
    end if
    low = 1
    high = size(t)
    do while (high - low > 1)
      middle = (low + high)/2
      if (t(middle) <= time) then
        low = middle
      else
        high = middle
      end if
    end do
    factor = p(low) + (p(high) - p(low))*((time - t(low))/(t(high) - t(low)))
  end function interpolated_factor

  !> FEAP's type 1: a0 + a1 s + a2 sin(a3 s + a4)^k with s = t - tmin, inside tmin..tmax, else 0.
  pure real(wp) function function_factor(table, time) result(factor)
    type(load_table_t), intent(in) :: table !! t = tmin, tmax; p = a0 .. a4, k
    real(wp), intent(in) :: time !! time
    real(wp) :: s, margin

    factor = 0.0_wp
    ! A time is a sum of increments: its round-off must not switch the load off at tmax.
    margin = 1.0e-10_wp*max(abs(time), abs(table%t(1)))
    if (time < table%t(1) - margin .or. time > table%t(2) + margin) return
    s = time - table%t(1)
    associate (a => table%p)
      factor = a(1) + a(2)*s + a(3)*sin(a(4)*s + a(5))**nint(a(6))
    end associate
  end function function_factor
end module loads
