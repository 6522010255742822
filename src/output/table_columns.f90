!> The columns that an end time has in the text tables and in /history: each is declared here once.
module table_columns
  use kinds, only: wp
  use result_types, only: contact_row_t
  implicit none
  private
  public :: column_t, reaction_columns, count_columns, contact_columns, rigid_columns, &
    derivative_columns, contact_counts, contact_values

  !> A column of numbers.
  type :: column_t
    character(16) :: name = '' !! its name, in the text tables and as a data set
    character(16) :: unit = '' !! [1], [length] and so on
  end type column_t

  !> Reactions of a set.
  type(column_t), parameter :: reaction_columns(3) = [column_t('R1', 'force'), &
    column_t('R2', 'force'), column_t('R3', 'force')]
  !> Numbers of points of a pair, as `contact_counts` gives them.
  type(column_t), parameter :: count_columns(3) = [column_t('active', '1'), &
    column_t('stick', '1'), column_t('slip', '1')]
  !> Sums over the points of a pair, as `contact_values` gives them.
  type(column_t), parameter :: contact_columns(12) = [column_t('Fn', 'force'), &
    column_t('Ft', 'force'), column_t('F1', 'force'), column_t('F2', 'force'), &
    column_t('F3', 'force'), column_t('M1', 'force length'), column_t('M2', 'force length'), &
    column_t('M3', 'force length'), column_t('max_penetration', 'length'), &
    column_t('max_elastic_slip', 'length'), column_t('max_criterion', 'length'), &
    column_t('Ft_nodes', 'force')]
  !> Motion of the point of a rigid body, force and moment of its constraint.
  type(column_t), parameter :: rigid_columns(12) = [column_t('U1', 'length'), &
    column_t('U2', 'length'), column_t('U3', 'length'), column_t('ROT1', 'radian'), &
    column_t('ROT2', 'radian'), column_t('ROT3', 'radian'), column_t('F1', 'force'), &
    column_t('F2', 'force'), column_t('F3', 'force'), column_t('M1', 'force length'), &
    column_t('M2', 'force length'), column_t('M3', 'force length')]
  !> Derivatives by a parameter, and the change of it for which they hold.
  type(column_t), parameter :: derivative_columns(4) = [column_t('d1', &
    'force/parameter'), column_t('d2', 'force/parameter'), column_t('d3', 'force/parameter'), &
    column_t('range', 'parameter')]

contains

  !> Numbers of points of a pair in the order of `count_columns`.
  pure function contact_counts(row) result(counts)
    type(contact_row_t), intent(in) :: row !! the sums over its points
    integer :: counts(size(count_columns))

    counts = [row%active, row%stick, row%slip]
  end function contact_counts

  !> Sums over the points of a pair in the order of `contact_columns`.
  pure function contact_values(row) result(values)
    type(contact_row_t), intent(in) :: row !! the sums
    real(wp) :: values(size(contact_columns))

    values = [row%normal, row%tangential, row%force, row%moment, row%max_penetration, &
      row%max_elastic_slip, row%max_criterion, row%lumped]
  end function contact_values
end module table_columns
