!> Arithmetic that says what is wrong before the processor would: nothing here overflows, divides
!! by zero or asks a function for a value outside its domain.
module safe_math
  use kinds, only: wp, pi
  use text, only: to_text, lower
  implicit none
  private
  public :: safe_sum, safe_product, safe_quotient, safe_power, apply_function, function_names, &
    is_function, is_reserved

  !> Functions; the degree forms end in d; all but min and max have one argument.
  character(5), parameter :: function_names(21) = [character(5) :: 'sqrt', 'abs', 'exp', 'log', &
    'sin', 'cos', 'tan', 'asin', 'acos', 'atan', 'sinh', 'cosh', 'tanh', 'sind', 'cosd', 'tand', &
    'asind', 'acosd', 'atand', 'min', 'max']

  real(wp), parameter :: largest_number = huge(1.0_wp)
  !> Largest argument of exp.
  real(wp), parameter :: largest_exponent = 709.0_wp

contains

  !> a + b
  subroutine safe_sum(a, b, value, problem)
    real(wp), intent(in) :: a !! first term
    real(wp), intent(in) :: b !! second term
    real(wp), intent(out) :: value !! the sum
    character(:), allocatable, intent(out) :: problem !! allocated if it overflows

    value = 0.0_wp
    if (abs(0.5_wp*a + 0.5_wp*b) >= 0.5_wp*largest_number) then
      problem = 'the sum overflows'
    else
      value = a + b
    end if
  end subroutine safe_sum

  !> a b
  subroutine safe_product(a, b, value, problem)
    real(wp), intent(in) :: a !! first factor
    real(wp), intent(in) :: b !! second factor
    real(wp), intent(out) :: value !! the product
    character(:), allocatable, intent(out) :: problem !! allocated if it overflows

    value = 0.0_wp
    if (abs(b) > 1.0_wp) then
      if (abs(a) >= largest_number/abs(b)) then
        problem = 'the product overflows'
        return
      end if
    end if
    value = a*b
  end subroutine safe_product

  !> a / b
  subroutine safe_quotient(a, b, value, problem)
    real(wp), intent(in) :: a !! dividend
    real(wp), intent(in) :: b !! divisor
    real(wp), intent(out) :: value !! the quotient
    character(:), allocatable, intent(out) :: problem !! allocated if b is 0 or it overflows

    value = 0.0_wp
    if (abs(b) <= 0.0_wp) then
      problem = 'division by zero'
      return
    end if
    if (abs(b) < 1.0_wp) then
      if (abs(a) >= largest_number*abs(b)) then
        problem = 'the quotient overflows'
        return
      end if
    end if
    value = a/b
  end subroutine safe_quotient

  !> a to the power b
  subroutine safe_power(a, b, value, problem)
    real(wp), intent(in) :: a !! base
    real(wp), intent(in) :: b !! exponent
    real(wp), intent(out) :: value !! the power
    character(:), allocatable, intent(out) :: problem !! allocated if there is none
    real(wp) :: logarithm

    value = 0.0_wp
    if (abs(b) <= 0.0_wp) then
      value = 1.0_wp
    else if (abs(a) <= 0.0_wp) then
      if (b < 0.0_wp) problem = 'division by zero: 0 to a negative power'
    else if (a < 0.0_wp .and. abs(b - aint(b)) > 0.0_wp) then
      problem = 'a negative number to a power that is no integer'
    else
      call safe_product(b, log(abs(a)), logarithm, problem)
      if (.not. allocated(problem)) then
        if (logarithm > largest_exponent) problem = 'the power overflows'
      end if
      if (allocated(problem)) return
      value = abs(a)**b
      if (a < 0.0_wp .and. abs(0.5_wp*b - aint(0.5_wp*b)) > 0.0_wp) value = -value
    end if
  end subroutine safe_power

  !> Value of a function of one argument.
  subroutine apply_function(name, x, value, problem)
    character(*), intent(in) :: name !! one of function_names, lower case
    real(wp), intent(in) :: x !! argument; degrees for sind, cosd and tand
    real(wp), intent(out) :: value !! result; degrees for asind, acosd and atand
    character(:), allocatable, intent(out) :: problem !! allocated outside its domain

    value = 0.0_wp
    problem = domain_problem(name, x)
    if (len(problem) > 0) return
    deallocate (problem)
    select case (name)
    case ('sqrt'); value = sqrt(x)
    case ('abs'); value = abs(x)
    case ('exp'); value = exp(x)
    case ('log'); value = log(x)
    case ('sin'); value = sin(x)
    case ('cos'); value = cos(x)
    case ('tan'); value = tan(x)
    case ('asin'); value = asin(x)
    case ('acos'); value = acos(x)
    case ('atan'); value = atan(x)
    case ('sinh'); value = sinh(x)
    case ('cosh'); value = cosh(x)
    case ('tanh'); value = tanh(x)
    case ('sind'); value = sine_of_degrees(x)
    case ('cosd'); value = sine_of_degrees(90.0_wp - abs(modulo(x, 360.0_wp)))
    case ('tand'); value = sine_of_degrees(x)/sine_of_degrees(90.0_wp - modulo(x, 360.0_wp))
    case ('asind'); value = asin(x)*180.0_wp/pi
    case ('acosd'); value = acos(x)*180.0_wp/pi
    case ('atand'); value = atan(x)*180.0_wp/pi
    case default; problem = 'there is no function '''//name//''''
    end select
  end subroutine apply_function

  !> Says why a function has no value at `x`; empty if it has one.
  function domain_problem(name, x) result(problem)
    character(*), intent(in) :: name !! name of the function
    real(wp), intent(in) :: x !! argument
    character(:), allocatable :: problem
    character(:), allocatable :: call_text

    problem = ''
    call_text = name//'('//to_text(x)//')'
    select case (name)
    case ('sqrt')
      if (x < 0.0_wp) problem = 'the root of a negative number: '//call_text
    case ('log')
      if (x <= 0.0_wp) problem = 'the logarithm of a number that is not positive: '//call_text
    case ('asin', 'acos', 'asind', 'acosd')
      if (abs(x) > 1.0_wp) problem = 'an argument outside -1 .. 1: '//call_text
    case ('exp', 'sinh', 'cosh')
      if (x > largest_exponent) problem = call_text//' overflows'
      if (x < -largest_exponent .and. name /= 'exp') problem = call_text//' overflows'
    case ('tand')
      if (abs(modulo(x, 180.0_wp) - 90.0_wp) <= 0.0_wp) problem = call_text//' is infinite'
    case default
      continue
    end select
  end function domain_problem

  !> sin of an angle in degrees, exact at multiples of 30 and 90 degrees where sin is.
  pure real(wp) function sine_of_degrees(x) result(s)
    real(wp), intent(in) :: x !! angle [degree]
    real(wp) :: angle, sign

    angle = modulo(x, 360.0_wp)
    sign = 1.0_wp
    if (angle >= 180.0_wp) then
      angle = angle - 180.0_wp
      sign = -1.0_wp
    end if
    if (angle > 90.0_wp) angle = 180.0_wp - angle
    if (abs(angle - 30.0_wp) <= 0.0_wp) then
      s = 0.5_wp*sign
    else
      s = sign*sin(angle*pi/180.0_wp)
    end if
  end function sine_of_degrees

  !> Whether a name is that of a function, in any case of letters.
  pure logical function is_function(name)
    character(*), intent(in) :: name !! any name

    is_function = any(function_names == lower(name))
  end function is_function

  !> Whether a name cannot be that of a parameter.
  pure logical function is_reserved(name)
    character(*), intent(in) :: name !! any name

    is_reserved = is_function(name) .or. lower(name) == 'pi'
  end function is_reserved
end module safe_math
