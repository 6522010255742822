!> Attributes of the groups and data sets of an HDF5 file.
module hdf5_attributes
  use hdf5, only: hid_t, hsize_t, h5oopen_f, h5oclose_f, h5acreate_f, h5awrite_f, &
    h5aopen_f, h5aclose_f, h5aexists_f, h5screate_simple_f, h5screate_f, h5sclose_f, h5tclose_f, &
    h5s_scalar_f, h5t_native_integer, h5t_native_double, h5t_std_i64le, h5t_ieee_f64le
  use kinds, only: wp
  use errors, only: error_t
  use hdf5_io, only: hdf5_file_t, raise_hdf5, string_type
  implicit none
  private
  public :: write_attribute

  !> Writes an attribute of a group or data set; integers are stored with 64 bits. An attribute that
  !! is there is overwritten.
  interface write_attribute
    module procedure write_text_attribute
    module procedure write_integer_attribute
    module procedure write_integers_attribute
    module procedure write_real_attribute
  end interface write_attribute

contains

  !> Opens an attribute, after creating it if it is not there.
  subroutine open_attribute(file, object, name, type_id, n, attribute, status)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: object !! group or data set
    character(*), intent(in) :: name !! name of the attribute
    integer(hid_t), intent(in) :: type_id !! type in the file
    integer, intent(in) :: n !! number of values, 0 for a scalar
    integer(hid_t), intent(out) :: attribute !! handle of the attribute
    integer, intent(out) :: status !! negative: failed
    integer(hid_t) :: owner, space
    logical :: there
    integer :: s(6)

    s = 0
    attribute = -1_hid_t
    space = -1_hid_t
    owner = -1_hid_t
    there = .false.
    call h5oopen_f(file%id, object, owner, s(1))
    call h5aexists_f(owner, name, there, s(2))
    if (there) then
      call h5aopen_f(owner, name, attribute, s(3))
    else
      if (n == 0) call h5screate_f(h5s_scalar_f, space, s(3))
      if (n > 0) call h5screate_simple_f(1, [int(n, hsize_t)], space, s(3))
      call h5acreate_f(owner, name, type_id, space, attribute, s(4))
      call h5sclose_f(space, s(5))
    end if
    call h5oclose_f(owner, s(6))
    status = minval(s)
  end subroutine open_attribute

  !> Writes a string as an attribute.
  subroutine write_text_attribute(file, object, name, value, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: object !! group or data set
    character(*), intent(in) :: name !! name of the attribute
    character(*), intent(in) :: value !! its value
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: attribute, type_id
    integer :: s(5)

    if (allocated(error)) return
    call string_type(len(value), type_id, s(1))
    call open_attribute(file, object, name, type_id, 0, attribute, s(2))
    call h5awrite_f(attribute, type_id, value, [1_hsize_t], s(3))
    call h5aclose_f(attribute, s(4))
    call h5tclose_f(type_id, s(5))
    if (any(s < 0)) call raise_hdf5(error, file, 'writing the attribute '//object//':'//name)
  end subroutine write_text_attribute

  !> Writes an integer as an attribute.
  subroutine write_integer_attribute(file, object, name, value, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: object !! group or data set
    character(*), intent(in) :: name !! name of the attribute
    integer, intent(in) :: value !! its value
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: attribute
    integer :: s(3)

    if (allocated(error)) return
    call open_attribute(file, object, name, h5t_std_i64le, 0, attribute, s(1))
    call h5awrite_f(attribute, h5t_native_integer, value, [1_hsize_t], s(2))
    call h5aclose_f(attribute, s(3))
    if (any(s < 0)) call raise_hdf5(error, file, 'writing the attribute '//object//':'//name)
  end subroutine write_integer_attribute

  !> Writes integers as an attribute.
  subroutine write_integers_attribute(file, object, name, values, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: object !! group or data set
    character(*), intent(in) :: name !! name of the attribute
    integer, intent(in) :: values(:) !! its values, at least one
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: attribute
    integer :: s(3)

    if (allocated(error)) return
    call open_attribute(file, object, name, h5t_std_i64le, size(values), attribute, s(1))
    call h5awrite_f(attribute, h5t_native_integer, values, [size(values, kind=hsize_t)], s(2))
    call h5aclose_f(attribute, s(3))
    if (any(s < 0)) call raise_hdf5(error, file, 'writing the attribute '//object//':'//name)
  end subroutine write_integers_attribute

  !> Writes a real number as an attribute.
  subroutine write_real_attribute(file, object, name, value, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: object !! group or data set
    character(*), intent(in) :: name !! name of the attribute
    real(wp), intent(in) :: value !! its value
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: attribute
    integer :: s(3)

    if (allocated(error)) return
    call open_attribute(file, object, name, h5t_ieee_f64le, 0, attribute, s(1))
    call h5awrite_f(attribute, h5t_native_double, value, [1_hsize_t], s(2))
    call h5aclose_f(attribute, s(3))
    if (any(s < 0)) call raise_hdf5(error, file, 'writing the attribute '//object//':'//name)
  end subroutine write_real_attribute
end module hdf5_attributes
