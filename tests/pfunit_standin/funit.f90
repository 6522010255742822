!> A small stand-in for pFUnit's module of the same name.
!!
!! It knows what preprocess.awk writes: the assertions, the record of a failure, suites of tests and
!! the loop that runs them. The test files themselves run under the real pFUnit as well.
module funit
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64, output_unit
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_is_finite
  implicit none
  private
  public :: SourceLocation, TestSuite, TestRunner, anyExceptions
  public :: assert_relation, assertTrue, assertFalse, assertIsNaN, assertIsFinite
  public :: assertSameShape, assertFail

  !> Relations in the order of preprocess.awk.
  integer, parameter :: is_equal = 1, is_not_equal = 2, is_less = 3, is_less_equal = 4
  integer, parameter :: is_greater = 5, is_greater_equal = 6, is_relatively_equal = 7
  character(32), parameter :: relation_names(7) = [character(32) :: 'equal', 'not equal', &
    'less than', 'less than or equal', 'greater than', 'greater than or equal', &
    'relatively equal']

  !> Where an assertion stands.
  type :: SourceLocation
    character(128) :: file = '' !! file name
    integer :: line = 0 !! line number
  end type SourceLocation

  abstract interface
    !> A test, or what runs before and after each.
    subroutine procedure_i()
      implicit none
    end subroutine procedure_i
  end interface

  !> One test of a suite.
  type :: test_t
    character(128) :: name = '' !! its name
    procedure(procedure_i), pointer, nopass :: body => null() !! what it does
    logical :: disabled = .false. !! not to be run
  end type test_t

  !> The tests of one file.
  type :: TestSuite
    character(128) :: name = '' !! name of the file's module
    type(test_t), allocatable :: tests(:) !! the tests in order
    procedure(procedure_i), pointer, nopass :: before => null() !! run before each test
    procedure(procedure_i), pointer, nopass :: after => null() !! run after each test
  contains
    procedure :: begin => suite_begin
    procedure :: add => suite_add
  end type TestSuite

  !> Counts over all suites and the options of the command line.
  type :: TestRunner
    logical :: verbose = .false. !! -v: name each test before it runs
    character(256) :: only = '' !! -f: run tests whose suite.name holds this
    integer :: passed = 0 !! tests without a failure
    integer :: failed = 0 !! tests with a failure
    integer :: disabled = 0 !! tests that were not run
  contains
    procedure :: read_options => runner_read_options
    procedure :: run_suite => runner_run_suite
    procedure :: finish => runner_finish
  end type TestRunner

  !> Failures of the test that is running: assertions know nothing of the runner.
  integer :: failures = 0

  !> One call for all relations: preprocess.awk gives the relation as the first argument.
  interface assert_relation
    module procedure relate_int32_00, relate_int32_01, relate_int32_11
    module procedure relate_int32_02, relate_int32_22
    module procedure relate_int64_00, relate_int64_01, relate_int64_11
    module procedure relate_int64_02, relate_int64_22
    module procedure relate_real_00, relate_real_01, relate_real_11
    module procedure relate_real_02, relate_real_22
    module procedure relate_string
  end interface assert_relation

  !> A condition, or all of several.
  interface assertTrue
    module procedure true_0, true_1
  end interface assertTrue

  !> The opposite of a condition, or of each of several.
  interface assertFalse
    module procedure false_0, false_1
  end interface assertFalse

  interface
    !> C's exit: ends without Fortran's remarks on floating-point flags.
    subroutine c_exit(code) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: code !! exit code
    end subroutine c_exit
  end interface

contains

  !> True when the running test has failed.
  logical function anyExceptions()
    anyExceptions = failures > 0
  end function anyExceptions

  !> Records and prints one failure.
  subroutine report(text, message, location)
    character(*), intent(in) :: text !! what was wrong
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    failures = failures + 1
    if (present(location)) then
      write (output_unit, '(3x,a,a,i0,a)') trim(location%file), ':', location%line, ':'
    end if
    write (output_unit, '(6x,a)') text
    if (present(message)) write (output_unit, '(6x,a)') message
  end subroutine report

  !> Names a suite and empties it.
  subroutine suite_begin(self, name)
    class(TestSuite), intent(inout) :: self !! the suite
    character(*), intent(in) :: name !! its name

    self%name = name
    allocate (self%tests(0))
  end subroutine suite_begin

  !> Adds one test.
  subroutine suite_add(self, name, body, disabled)
    class(TestSuite), intent(inout) :: self !! the suite
    character(*), intent(in) :: name !! name of the test
    procedure(procedure_i) :: body !! what it does
    logical, intent(in) :: disabled !! not to be run
    type(test_t), allocatable :: longer(:)
    integer :: n

    n = size(self%tests)
    allocate (longer(n + 1))
    longer(:n) = self%tests
    longer(n + 1)%name = name
    longer(n + 1)%body => body
    longer(n + 1)%disabled = disabled
    call move_alloc(longer, self%tests)
  end subroutine suite_add

  !> Reads -v and -f SUBSTRING.
  subroutine runner_read_options(self)
    class(TestRunner), intent(inout) :: self !! the runner
    character(256) :: word
    integer :: i

    i = 1
    do while (i <= command_argument_count())
      call get_command_argument(i, word)
      select case (word)
      case ('-v')
        self%verbose = .true.
      case ('-f')
        i = i + 1
        call get_command_argument(i, self%only)
      case default
        write (output_unit, '(3a)') 'unknown option ', trim(word), '; known: -v, -f SUBSTRING'
        call c_exit(2_c_int)
      end select
      i = i + 1
    end do
  end subroutine runner_read_options

  !> Runs the tests of one suite.
  subroutine runner_run_suite(self, suite)
    class(TestRunner), intent(inout) :: self !! the runner
    type(TestSuite), intent(in) :: suite !! the suite
    character(257) :: name
    integer :: i

    do i = 1, size(suite%tests)
      name = trim(suite%name)//'.'//trim(suite%tests(i)%name)
      if (index(name, trim(self%only)) == 0) cycle
      if (suite%tests(i)%disabled) then
        self%disabled = self%disabled + 1
        cycle
      end if
      if (self%verbose) write (output_unit, '(a)') trim(name)
      flush (output_unit)
      failures = 0
      if (associated(suite%before)) call suite%before()
      if (failures == 0) call suite%tests(i)%body()
      if (associated(suite%after)) call suite%after()
      if (failures > 0) then
        self%failed = self%failed + 1
        write (output_unit, '(2a)') 'FAILED ', trim(name)
      else
        self%passed = self%passed + 1
      end if
    end do
  end subroutine runner_run_suite

  !> Prints the closing line and ends the program.
  subroutine runner_finish(self)
    class(TestRunner), intent(inout) :: self !! the runner

    if (self%passed + self%failed == 0) write (output_unit, '(a)') 'no test has run'
    if (self%disabled > 0) write (output_unit, '(i0,a)') self%disabled, ' disabled'
    write (output_unit, '(i0,a,i0,a)') self%passed, ' passed, ', self%failed, ' failed'
    flush (output_unit)
    if (self%failed > 0 .or. self%passed == 0) call c_exit(2_c_int)
    call c_exit(0_c_int)
  end subroutine runner_finish

  !> Fails always.
  subroutine assertFail(message, location)
    character(*), intent(in) :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call report('assertFail', message, location)
  end subroutine assertFail

  !> A condition.
  subroutine true_0(condition, message, location)
    logical, intent(in) :: condition !! what must be true
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (.not. condition) call report('expected true, found false', message, location)
  end subroutine true_0

  !> Several conditions.
  subroutine true_1(condition, message, location)
    logical, intent(in) :: condition(:) !! what must be true
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (.not. all(condition)) call report('expected all true', message, location)
  end subroutine true_1

  !> The opposite of a condition.
  subroutine false_0(condition, message, location)
    logical, intent(in) :: condition !! what must be false
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (condition) call report('expected false, found true', message, location)
  end subroutine false_0

  !> The opposite of each of several conditions.
  subroutine false_1(condition, message, location)
    logical, intent(in) :: condition(:) !! what must be false
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (any(condition)) call report('expected all false', message, location)
  end subroutine false_1

  !> Not a number.
  subroutine assertIsNaN(x, message, location)
    real(real64), intent(in) :: x !! the number
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (.not. ieee_is_nan(x)) call report('expected NaN, found '//text_of(x), message, location)
  end subroutine assertIsNaN

  !> A finite number.
  subroutine assertIsFinite(x, message, location)
    real(real64), intent(in) :: x !! the number
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (.not. ieee_is_finite(x)) then
      call report('expected a finite number, found '//text_of(x), message, location)
    end if
  end subroutine assertIsFinite

  !> Two shapes, as SHAPE returns them.
  subroutine assertSameShape(a, b, message, location)
    integer, intent(in) :: a(:) !! first shape
    integer, intent(in) :: b(:) !! second shape
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (.not. conformable(a, b)) call report('shapes differ', message, location)
  end subroutine assertSameShape

  !> Whether shapes agree; a scalar (shape of size 0) agrees with everything.
  pure logical function conformable(a, b)
    integer, intent(in) :: a(:) !! first shape
    integer, intent(in) :: b(:) !! second shape

    conformable = size(a) == 0 .or. size(b) == 0
    if (.not. conformable .and. size(a) == size(b)) conformable = all(a == b)
  end function conformable

  !> A real number in full.
  pure function text_of(x) result(t)
    real(real64), intent(in) :: x !! the number
    character(:), allocatable :: t
    character(40) :: buffer

    write (buffer, '(es24.16e3)') x
    t = trim(adjustl(buffer))
  end function text_of

  !> ' at element N', or nothing for a scalar.
  pure function place(i, extent) result(t)
    integer, intent(in) :: i !! element, counted through the array
    integer, intent(in) :: extent(:) !! shape of the array
    character(:), allocatable :: t
    character(80) :: buffer

    t = ''
    if (size(extent) == 0) return
    if (size(extent) == 1) then
      write (buffer, '(a,i0,a)') ' at (', i, ')'
    else
      write (buffer, '(a,i0,a,i0,a)') ' at (', 1 + mod(i - 1, extent(1)), ',', &
        1 + (i - 1)/extent(1), ')'
    end if
    t = trim(buffer)
  end function place

  !> Whether one pair of integers stands in a relation.
  pure logical function integers_stand(relation, e, a) result(yes)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e !! first operand
    integer(int64), intent(in) :: a !! second operand

    select case (relation)
    case (is_equal)
      yes = e == a
    case (is_not_equal)
      yes = e /= a
    case (is_less)
      yes = e < a
    case (is_less_equal)
      yes = e <= a
    case (is_greater)
      yes = e > a
    case (is_greater_equal)
      yes = e >= a
    case default
      yes = .false.
    end select
  end function integers_stand

  !> Whether one pair of reals stands in a relation; a NaN stands in none.
  pure logical function reals_stand(relation, e, a, tolerance) result(yes)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e !! first operand
    real(real64), intent(in) :: a !! second operand
    real(real64), intent(in) :: tolerance !! absolute, or relative to the first operand
    logical :: same

    yes = .false.
    if (ieee_is_nan(e) .or. ieee_is_nan(a)) return
    same = .not. (e < a .or. e > a)
    if (.not. same .and. ieee_is_finite(e) .and. ieee_is_finite(a)) then
      same = abs(a - e) <= tolerance
    end if
    select case (relation)
    case (is_equal)
      yes = same
    case (is_not_equal)
      yes = .not. same
    case (is_less)
      yes = e < a + tolerance
    case (is_less_equal)
      yes = e <= a + tolerance
    case (is_greater)
      yes = e + tolerance > a
    case (is_greater_equal)
      yes = e + tolerance >= a
    case (is_relatively_equal)
      yes = abs(a - e) <= tolerance*abs(e)
    case default
      yes = .false.
    end select
  end function reals_stand

  !> Compares integers of any rank, laid out in order.
  subroutine relate_integers(relation, e, shape_e, a, shape_a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e(:) !! first operand
    integer, intent(in) :: shape_e(:) !! its shape
    integer(int64), intent(in) :: a(:) !! second operand
    integer, intent(in) :: shape_a(:) !! its shape
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where
    character(128) :: buffer
    integer :: i, j

    if (.not. conformable(shape_e, shape_a)) then
      call report('shapes differ', message, location)
      return
    end if
    do i = 1, size(a)
      j = merge(1, i, size(shape_e) == 0)
      if (integers_stand(relation, e(j), a(i))) cycle
      write (buffer, '(a,i0,3a,i0)') '<', e(j), '> should be ', trim(relation_names(relation)), &
        ' to <', a(i)
      call report(trim(buffer)//'>'//place(i, shape_a), message, location)
      return
    end do
  end subroutine relate_integers

  !> Compares reals of any rank, laid out in order.
  subroutine relate_reals(relation, e, shape_e, a, shape_a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e(:) !! first operand
    integer, intent(in) :: shape_e(:) !! its shape
    real(real64), intent(in) :: a(:) !! second operand
    integer, intent(in) :: shape_a(:) !! its shape
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where
    real(real64) :: t
    integer :: i, j

    if (.not. conformable(shape_e, shape_a)) then
      call report('shapes differ', message, location)
      return
    end if
    t = 0.0_real64
    if (present(tolerance)) t = tolerance
    do i = 1, size(a)
      j = merge(1, i, size(shape_e) == 0)
      if (reals_stand(relation, e(j), a(i), t)) cycle
      call report('<'//text_of(e(j))//'> should be '//trim(relation_names(relation))//' to <'// &
        text_of(a(i))//'>'//place(i, shape_a)//', tolerance '//text_of(t), message, location)
      return
    end do
  end subroutine relate_reals

  !> Compares strings as pFUnit does: blanks at both ends do not count.
  subroutine relate_string(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one: equal alone
    character(*), intent(in) :: e !! first operand
    character(*), intent(in) :: a !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    if (relation /= is_equal) then
      call report('strings can be compared with assertEqual only', message, location)
    else if (trim(adjustl(e)) /= trim(adjustl(a))) then
      call report('expected <'//trim(adjustl(e))//'>, found <'//trim(adjustl(a))//'>', message, &
        location)
    end if
  end subroutine relate_string

  !> Default integers: a scalar and a scalar.
  subroutine relate_int32_00(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int32), intent(in) :: e !! first operand
    integer(int32), intent(in) :: a !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [int(e, int64)], shape(e), [int(a, int64)], shape(a), &
      message, location)
  end subroutine relate_int32_00

  !> Default integers: a scalar and a vector.
  subroutine relate_int32_01(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int32), intent(in) :: e !! first operand
    integer(int32), intent(in) :: a(:) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [int(e, int64)], shape(e), [int(a, int64)], shape(a), &
      message, location)
  end subroutine relate_int32_01

  !> Default integers: a vector and a vector.
  subroutine relate_int32_11(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int32), intent(in) :: e(:) !! first operand
    integer(int32), intent(in) :: a(:) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [int(e, int64)], shape(e), [int(a, int64)], shape(a), &
      message, location)
  end subroutine relate_int32_11

  !> Default integers: a scalar and a matrix.
  subroutine relate_int32_02(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int32), intent(in) :: e !! first operand
    integer(int32), intent(in) :: a(:, :) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [int(e, int64)], shape(e), [int(a, int64)], shape(a), &
      message, location)
  end subroutine relate_int32_02

  !> Default integers: a matrix and a matrix.
  subroutine relate_int32_22(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int32), intent(in) :: e(:, :) !! first operand
    integer(int32), intent(in) :: a(:, :) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [int(e, int64)], shape(e), [int(a, int64)], shape(a), &
      message, location)
  end subroutine relate_int32_22

  !> Long integers: a scalar and a scalar.
  subroutine relate_int64_00(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e !! first operand
    integer(int64), intent(in) :: a !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [e], shape(e), [a], shape(a), &
      message, location)
  end subroutine relate_int64_00

  !> Long integers: a scalar and a vector.
  subroutine relate_int64_01(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e !! first operand
    integer(int64), intent(in) :: a(:) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [e], shape(e), [a], shape(a), &
      message, location)
  end subroutine relate_int64_01

  !> Long integers: a vector and a vector.
  subroutine relate_int64_11(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e(:) !! first operand
    integer(int64), intent(in) :: a(:) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [e], shape(e), [a], shape(a), &
      message, location)
  end subroutine relate_int64_11

  !> Long integers: a scalar and a matrix.
  subroutine relate_int64_02(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e !! first operand
    integer(int64), intent(in) :: a(:, :) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [e], shape(e), [a], shape(a), &
      message, location)
  end subroutine relate_int64_02

  !> Long integers: a matrix and a matrix.
  subroutine relate_int64_22(relation, e, a, message, location)
    integer, intent(in) :: relation !! which one
    integer(int64), intent(in) :: e(:, :) !! first operand
    integer(int64), intent(in) :: a(:, :) !! second operand
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_integers(relation, [e], shape(e), [a], shape(a), &
      message, location)
  end subroutine relate_int64_22

  !> Reals: a scalar and a scalar.
  subroutine relate_real_00(relation, e, a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e !! first operand
    real(real64), intent(in) :: a !! second operand
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_reals(relation, [e], shape(e), [a], shape(a), &
      tolerance, message, location)
  end subroutine relate_real_00

  !> Reals: a scalar and a vector.
  subroutine relate_real_01(relation, e, a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e !! first operand
    real(real64), intent(in) :: a(:) !! second operand
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_reals(relation, [e], shape(e), [a], shape(a), &
      tolerance, message, location)
  end subroutine relate_real_01

  !> Reals: a vector and a vector.
  subroutine relate_real_11(relation, e, a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e(:) !! first operand
    real(real64), intent(in) :: a(:) !! second operand
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_reals(relation, [e], shape(e), [a], shape(a), &
      tolerance, message, location)
  end subroutine relate_real_11

  !> Reals: a scalar and a matrix.
  subroutine relate_real_02(relation, e, a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e !! first operand
    real(real64), intent(in) :: a(:, :) !! second operand
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_reals(relation, [e], shape(e), [a], shape(a), &
      tolerance, message, location)
  end subroutine relate_real_02

  !> Reals: a matrix and a matrix.
  subroutine relate_real_22(relation, e, a, tolerance, message, location)
    integer, intent(in) :: relation !! which one
    real(real64), intent(in) :: e(:, :) !! first operand
    real(real64), intent(in) :: a(:, :) !! second operand
    real(real64), intent(in), optional :: tolerance !! 0 unless given
    character(*), intent(in), optional :: message !! the author's remark
    type(SourceLocation), intent(in), optional :: location !! where

    call relate_reals(relation, [e], shape(e), [a], shape(a), &
      tolerance, message, location)
  end subroutine relate_real_22
end module funit
