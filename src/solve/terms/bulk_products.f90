!> Products with the bulk's matrix, wherever that is: here, or with a solver that has taken it
!! (doc/theory, "Iterative solution in parallel").
module bulk_products
  use kinds, only: wp
  use block_matrix, only: block_matrix_t, multiply, multiply_absolute
  use linear_solver, only: has_bulk, multiply_taken
  use system_parts, only: whole_form_t
  implicit none
  private
  public :: multiply_bulk, multiply_bulk_absolute, give_bulk

contains

  !> y = K x.
  subroutine multiply_bulk(equation, whole, x, y)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(whole_form_t), intent(inout) :: whole !! bulk's matrix
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    real(wp), allocatable :: rest(:, :)

    if (.not. whole%given) then
      call multiply(whole%bulk_matrix, x, y)
      return
    end if
    call multiply_taken(whole%solver, equation, x, .false., y)
    allocate (rest(3, size(x, 2)))
    call multiply(whole%restrained, x, rest)
    y = y + rest
  end subroutine multiply_bulk

  !> y = |K| |x|.
  subroutine multiply_bulk_absolute(equation, whole, x, y)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(whole_form_t), intent(inout) :: whole !! bulk's matrix
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    real(wp), allocatable :: rest(:, :)

    if (.not. whole%given) then
      call multiply_absolute(whole%bulk_matrix, x, y)
      return
    end if
    call multiply_taken(whole%solver, equation, x, .true., y)
    allocate (rest(3, size(x, 2)))
    call multiply_absolute(whole%restrained, x, rest)
    y = y + rest
  end subroutine multiply_bulk_absolute

  !> Gives the values to a solver that has taken the free ones: what it does not know stays here.
  subroutine give_bulk(equation, whole)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(whole_form_t), intent(inout) :: whole !! gets given, restrained; bulk_matrix its graph

    if (whole%given) return
    if (.not. has_bulk(whole%solver)) return
    call find_restrained(whole%bulk_matrix, equation, whole%restrained)
    deallocate (whole%bulk_matrix%val)
    whole%given = .true.
  end subroutine give_bulk

  !> What a matrix has in rows or columns that are restrained.
  pure subroutine find_restrained(matrix, equation, restrained)
    type(block_matrix_t), intent(in) :: matrix !! all of it
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(block_matrix_t), intent(out) :: restrained !! the same without the free entries
    logical :: bound(matrix%nodes)
    integer :: j, k, n, pass, c

    bound = any(equation == 0, 1)
    restrained%nodes = matrix%nodes
    allocate (restrained%ptr(matrix%nodes + 1))
    do pass = 1, 2
      n = 0
      do j = 1, matrix%nodes
        restrained%ptr(j) = n + 1
        do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
          if (.not. (bound(j) .or. bound(matrix%row(k)))) cycle
          n = n + 1
          if (pass == 1) cycle
          restrained%row(n) = matrix%row(k)
          restrained%val(:, :, n) = matrix%val(:, :, k)
          do c = 1, 3
            if (equation(c, j) > 0) where (equation(:, matrix%row(k)) > 0) &
              restrained%val(:, c, n) = 0.0_wp
          end do
        end do
      end do
      restrained%ptr(matrix%nodes + 1) = n + 1
      if (pass == 1) allocate (restrained%row(n), restrained%val(3, 3, n))
    end do
  end subroutine find_restrained
end module bulk_products
