!> What a deck is once it has been read: records of items, gathered into data sets.
!!
!! The deck layer knows words, numbers and places in files; it knows no mechanics. Everything here
!! carries its place in the source, so that later layers can report an error at file:line:column.
module deck_types
  use kinds, only: wp
  implicit none
  private
  public :: location_t, item_t, record_t, data_set_t, deck_t, parameter_t, &
    override_t, loss_t
  public :: item_empty, item_number, item_word, item_quoted
  public :: name_length, longest_line

  !> Longest line of a deck.
  integer, parameter :: longest_line = 1024
  !> Longest name of a set, region, surface, pair or parameter.
  integer, parameter :: name_length = 31

  !> Kinds of items.
  integer, parameter :: item_empty = 0 !! nothing between two commas; counts as 0
  integer, parameter :: item_number = 1 !! a number or an expression, already evaluated
  integer, parameter :: item_word = 2 !! a keyword, an own word or a name, as written
  integer, parameter :: item_quoted = 3 !! a name in quotes, quotes removed

  !> A place in the source text.
  type :: location_t
    integer :: file = 0 !! index of the file in the source, 0 is the command line
    integer :: line = 0 !! line number in that file, from 1
    integer :: column = 0 !! column in that line, from 1
  end type location_t

  !> One item of a record.
  type :: item_t
    integer :: kind = item_empty !! one of the kinds above
    real(wp) :: value = 0.0_wp !! value of a number; 0 for an empty item
    character(:), allocatable :: text !! as written (quotes removed)
    type(location_t) :: at !! where it stands
  end type item_t

  !> One record: the items of a line (and of the lines joined to it by &).
  type :: record_t
    type(item_t), allocatable :: items(:) !! its items, in order
    type(location_t) :: at !! where it starts
    integer :: word = 0 !! index of the own word it begins with in the keyword table, 0 if none
    integer :: group = 0 !! number of the block it stands in after BATCh (blank lines part blocks)
  end type record_t

  !> A command with the data records that belong to it.
  type :: data_set_t
    character(4) :: command = '' !! first four letters of the command, lower case
    type(record_t) :: head !! the command's record; items(1) is the keyword itself
    type(record_t), allocatable :: records(:) !! data records in order (may be larger than count)
    integer :: count = 0 !! number of data records
    logical :: complete = .true. !! false if records were left out because of errors
    logical :: unknown = .false. !! one of these begins with a word that nobody knows
  end type data_set_t

  !> Data of a command that were left out because of an error.
  type :: loss_t
    character(4) :: command = '' !! first four letters of the command, empty if it may be any, ? if
    !! there may be several, and any names
    character(:), allocatable :: name !! what it would have defined, empty if that is unknown
  end type loss_t

  !> A parameter and its value.
  type :: parameter_t
    character(:), allocatable :: name !! as written where it was defined
    real(wp) :: value = 0.0_wp !! its value at the end of the deck
    ! A tree over all parameters, by keys that scatter: see link_parameter
    integer :: key = 0 !! where the name sorts
    integer :: below(2) = 0 !! parameters with lower and with higher keys, 0 for none
  end type parameter_t

  !> A parameter as the command line sets it (--set name=value).
  type :: override_t
    character(:), allocatable :: name !! its name
    character(:), allocatable :: value !! a number or an expression
  end type override_t

  !> A deck as read: nothing but text, numbers and places.
  type :: deck_t
    character(:), allocatable :: title !! raw rest of the title line
    integer :: control(6) = 0 !! numnp numel nummat ndm ndf nen; zeros where not given
    real(wp) :: penalty_factor = 1.0_wp !! of all pairs, from the command line
    logical :: hopeless = .false. !! no more is read of it: two dimensions, no deck at all
    type(record_t) :: control_record !! the control record, without items if there is none
    type(data_set_t), allocatable :: mesh(:) !! mesh commands in order (PARA, INCL, END are gone)
    type(loss_t), allocatable :: losses(:) !! what is missing in the mesh commands
    type(data_set_t), allocatable :: batch(:) !! solution commands in order (END, STOP are gone)
    type(record_t), allocatable :: tables(:) !! records after the END of BATCh (FEAP's PROP tables)
    type(parameter_t), allocatable :: parameters(:) !! parameters with their last values
    type(location_t) :: last !! last line of the deck
  end type deck_t
end module deck_types
