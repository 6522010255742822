!> Procedures of loaded libraries that are asked for by name at run time: they may be there or not.
module loaded_symbols
  use, intrinsic :: iso_c_binding, only: c_ptr, c_funptr, c_char, c_null_char, c_null_ptr
  implicit none
  private
  public :: symbol

  interface
    !> C's dlsym: the address of a symbol, null if no library has it.
    function c_dlsym(handle, name) bind(c, name='dlsym') result(address)
      import :: c_ptr, c_funptr, c_char
      implicit none
      type(c_ptr), value :: handle !! null: all libraries
      character(kind=c_char), intent(in) :: name(*) !! the symbol
      type(c_funptr) :: address
    end function c_dlsym
  end interface

contains

  !> Address of a symbol, null if no loaded library has it.
  type(c_funptr) function symbol(name) result(address)
    character(*), intent(in) :: name !! the symbol

    address = c_dlsym(c_null_ptr, c_text(name))
  end function symbol

  !> A Fortran string as C wants it.
  pure function c_text(text) result(chars)
    character(*), intent(in) :: text !! any text
    character(kind=c_char) :: chars(len(text) + 1)
    integer :: i

    do i = 1, len(text)
      chars(i) = text(i:i)
    end do
    chars(len(text) + 1) = c_null_char
  end function c_text
end module loaded_symbols
