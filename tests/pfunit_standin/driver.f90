!> Runs all suites: the two include files are written by the Makefile, one line a test file.
program driver
  use funit, only: TestSuite, TestRunner
  implicit none
  type(TestRunner) :: runner

  interface
    include 'suite_interfaces.inc'
  end interface

  call runner%read_options()
  include 'suites.inc'
  call runner%finish()
end program driver
