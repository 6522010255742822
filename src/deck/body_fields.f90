!> The fields of the bodies in a results file, each declared once: the word of FIELds that asks for
!! it and what its data set says. Keyword table, output request and file follow from the list;
!! frame_fields: fill_field computes the values.
module body_fields
  implicit none
  private
  public :: body_field_t, fields_of_bodies, n_body_fields, field_words

  !> A field of the bodies.
  type :: body_field_t
    character(12) :: word = '' !! of FIELds; several fields may have one
    character(16) :: name = '' !! of its data set
    logical :: at_nodes = .true. !! it has values at nodes, otherwise in elements
    integer :: components = 1 !! of a value
    character(14) :: unit = '' !! [1], [length] and so on
    character(72) :: description = '' !! for people
    logical :: given = .true. !! written where the deck has no FIELds
    logical :: of_elements = .false. !! comes from the states of the elements
  end type body_field_t

  character(*), parameter :: stress_unit = 'force/length^2'

  !> All of them, in the order of the file.
  type(body_field_t), parameter :: fields_of_bodies(*) = [ &
    body_field_t('displacement', 'displacement', .true., 3, 'length', 'displacement'), &
    body_field_t('reaction', 'reaction', .true., 3, 'force', &
    'force that the support exerts on the structure'), &
    body_field_t('stress', 'stress', .false., 6, stress_unit, 'Cauchy stress xx yy zz xy yz zx', &
    of_elements=.true.), &
    body_field_t('mises', 'von_mises', .false., 1, stress_unit, 'von Mises stress of the cell', &
    .false., .true.), &
    body_field_t('stress', 'nodal_stress', .true., 6, stress_unit, &
    'Cauchy stress at the nodes, recovered from inside the cells around', of_elements=.true.), &
    body_field_t('stress', 'nodal_von_mises', .true., 1, stress_unit, &
    'von Mises stress of nodal_stress', of_elements=.true.), &
    body_field_t('strain', 'strain', .false., 6, '1', &
    'strain xx yy zz xy yz zx; xy is half of the shear angle', .false., .true.), &
    body_field_t('strain', 'nodal_strain', .true., 6, '1', &
    'strain at the nodes, recovered likewise', .false., .true.), &
    body_field_t('lay', 'lay', .true., 3, '1', &
    'unit axis of mu1 on master surfaces, zero elsewhere', .false.)]
  integer, parameter :: n_body_fields = size(fields_of_bodies)

contains

  !> The words of FIELds, parted by commas: those of the list, and that of the contact points.
  pure function field_words() result(words)
    character(:), allocatable :: words
    integer :: k

    words = ''
    do k = 1, n_body_fields
      if (any(fields_of_bodies(:k - 1)%word == fields_of_bodies(k)%word)) cycle
      words = words//trim(fields_of_bodies(k)%word)//','
    end do
    words = words//'contact'
  end function field_words
end module body_fields
