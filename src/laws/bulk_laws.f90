!> The laws of the bulk: a new law is one file, and one line in each place here that names another.
module bulk_laws
  use law_types, only: bulk_law_t, point_law_t
  use law_linear, only: linear_law
  use law_neohooke, only: neohooke_law, neohooke_point
  use law_svk, only: svk_law, svk_point
  implicit none
  private
  public :: laws, linear, neohooke, svk, point_law, solid_signature

  !> The laws, and their numbers.
  integer, parameter :: linear = 1, neohooke = 2, svk = 3
  type(bulk_law_t), parameter :: laws(3) = [linear_law, neohooke_law, svk_law]

contains

  !> A law as elements know it.
  pure function point_law(number) result(law)
    integer, intent(in) :: number !! which
    type(point_law_t) :: law

    law%finite = laws(number)%finite
    if (number == neohooke) law%point => neohooke_point
    if (number == svk) law%point => svk_point
  end function point_law

  !> What may follow SOLId: a law, with its own parameters if it has any, or what the volumetric
  !! part goes with.
  pure function solid_signature() result(t)
    character(:), allocatable :: t, words
    character(*), parameter :: dilatation = '[c:MEAN,NODAl,FULL]'
    integer :: k, i

    words = ''
    t = ''
    do k = 1, size(laws)
      if (laws(k)%count == 0) then
        words = words//trim(laws(k)%keyword)//','
        cycle
      end if
      t = t//' | '//trim(laws(k)%keyword)
      do i = 1, laws(k)%count
        t = t//' '//laws(k)%parameters(i)%check//':'//trim(laws(k)%parameters(i)%name)
      end do
      t = t//' '//dilatation
    end do
    t = '[c:'//words//dilatation(4:)//' '//dilatation//t
  end function solid_signature
end module bulk_laws
