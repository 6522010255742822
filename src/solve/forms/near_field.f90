!> The compliance between candidates that are near each other, from the columns that they have in
!! the inverse of a factor (doc/theory, "Implicit compliance", eq. (12.9)).
module near_field
  use kinds, only: wp, sp
  use lapack_interface, only: sgemm
  use supernodes, only: supernodes_t
  use elimination_paths, only: path_t, list_path, reduce_path
  use part_halving, only: halve_parts
  use condensed_types, only: near_field_t
  implicit none
  private
  public :: form_near_field, near_diagonal, take_near, bytes_of_near_field

  !> Candidates of a patch, at most, and how far patches that are near may be apart, over the
  !! longest side of the larger one.
  integer, parameter :: most_candidates = 96
  real(wp), parameter :: reach_share = 0.75_wp
  !> Patches that are near one, on a flat surface; itself and half of the others are stored.
  real(wp), parameter :: near_patches = 9.0_wp

  !> The columns of a patch in the inverse of the factor.
  type :: reduced_t
    type(path_t) :: path !! where they are not zero
    real(sp), allocatable :: x(:, :) !! (columns of the path, candidates)
  end type reduced_t

contains

  !> Patches of candidates side by side, and C between those that are near each other: the product
  !! of their columns of L^-1 on the supernodes that both reach. These columns go after their last
  !! product.
  subroutine form_near_field(nodes, values, unit, equation, place, near)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle, its values aside
    real(sp), intent(in), contiguous :: values(:) !! these, inverse blocks on the diagonal
    real(wp), intent(in) :: unit !! C over the product
    integer, intent(in) :: equation(:) !! (m) of the candidates
    real(wp), intent(in) :: place(:, :) !! (3, m) where they are [length]
    type(near_field_t), intent(out) :: near !! gets patches and compliances
    type(reduced_t), allocatable :: reduced(:)
    integer, allocatable :: last(:)
    integer :: p, k

    call divide_candidates(place, near)
    call find_partners(place, near, last)
    allocate (reduced(size(last)))
    do p = 1, size(last)
      associate (mine => near%member(near%start(p):near%start(p + 1) - 1), pairs => near%pairs(p))
        call list_path(nodes, equation(mine), reduced(p)%path)
        call reduce_path(nodes, values, reduced(p)%path, equation(mine), reduced(p)%x)
        allocate (pairs%c(size(pairs%partner)))
        do k = 1, size(pairs%partner)
          call multiply_patches(reduced(pairs%partner(k)), reduced(p), unit, pairs%c(k)%c)
          if (last(pairs%partner(k)) == p) deallocate (reduced(pairs%partner(k))%x)
        end do
      end associate
    end do
  end subroutine form_near_field

  !> Candidates side by side in patches.
  pure subroutine divide_candidates(place, near)
    real(wp), intent(in) :: place(:, :) !! (3, m) [length]
    type(near_field_t), intent(inout) :: near !! gets start, member, patch, at
    integer :: ends(size(place, 2)), parts, p, i

    near%member = [(i, i=1, size(place, 2))]
    parts = 0
    call halve_parts(place, most_candidates, 1, size(near%member), near%member, ends, parts)
    near%start = [1, ends(:parts) + 1]
    near%patch = near%member
    near%at = near%member
    do p = 1, parts
      do i = near%start(p), near%start(p + 1) - 1
        near%patch(near%member(i)) = p
        near%at(near%member(i)) = i - near%start(p) + 1
      end do
    end do
  end subroutine divide_candidates

  !> The patches before each that are near it, itself the last, and the last one each is near to.
  pure subroutine find_partners(place, near, last)
    real(wp), intent(in) :: place(:, :) !! (3, m) [length]
    type(near_field_t), intent(inout) :: near !! patches; gets partners
    integer, allocatable, intent(out) :: last(:) !! (patches)
    real(wp), allocatable :: low(:, :), high(:, :)
    integer :: p, q

    associate (patches => size(near%start) - 1)
      allocate (low(3, patches), high(3, patches), near%pairs(patches), last(patches))
      do p = 1, patches
        associate (mine => near%member(near%start(p):near%start(p + 1) - 1))
          low(:, p) = minval(place(:, mine), 2)
          high(:, p) = maxval(place(:, mine), 2)
        end associate
        near%pairs(p)%partner = pack([(q, q=1, p)], [(are_near(low(:, [p, q]), high(:, [p, q])), &
          q=1, p)])
        last(near%pairs(p)%partner) = p
      end do
    end associate
  end subroutine find_partners

  !> Two patches are near each other.
  pure logical function are_near(low, high) result(near)
    real(wp), intent(in) :: low(3, 2), high(3, 2) !! the boxes around them [length]
    real(wp) :: gap(3)

    gap = max(0.0_wp, low(:, 1) - high(:, 2), low(:, 2) - high(:, 1))
    near = norm2(gap) <= reach_share*maxval(high - low)
  end function are_near

  !> C between two patches.
  subroutine multiply_patches(first, second, unit, c)
    type(reduced_t), intent(in) :: first, second !! their columns of L^-1
    real(wp), intent(in) :: unit !! C over the product
    real(sp), allocatable, intent(out) :: c(:, :) !! (first, second)
    integer :: i, j

    allocate (c(size(first%x, 2), size(second%x, 2)), source=0.0_sp)
    i = 1
    j = 1
    do while (i <= size(first%path%supernode) .and. j <= size(second%path%supernode))
      if (first%path%supernode(i) < second%path%supernode(j)) then
        i = i + 1
      else if (first%path%supernode(i) > second%path%supernode(j)) then
        j = j + 1
      else
        call sgemm('T', 'N', size(c, 1), size(c, 2), first%path%before(i + 1) &
          - first%path%before(i), real(unit, sp), first%x(first%path%before(i) + 1, 1), &
          size(first%x, 1), second%x(second%path%before(j) + 1, 1), size(second%x, 1), 1.0_sp, &
          c, size(c, 1))
        i = i + 1
        j = j + 1
      end if
    end do
  end subroutine multiply_patches

  !> The compliance of each candidate by itself.
  pure function near_diagonal(near) result(diagonal)
    type(near_field_t), intent(in) :: near !! formed
    real(wp) :: diagonal(size(near%patch))
    integer :: i

    do i = 1, size(diagonal)
      associate (own => near%pairs(near%patch(i)))
        diagonal(i) = real(own%c(size(own%partner))%c(near%at(i), near%at(i)), wp)
      end associate
    end do
  end function near_diagonal

  !> C between some candidates; zero between those that are not near each other.
  pure subroutine take_near(near, candidate, unit, c)
    type(near_field_t), intent(in) :: near !! formed
    integer, intent(in) :: candidate(:) !! (n) which
    real(sp), intent(in) :: unit !! what is taken over C
    real(sp), intent(out) :: c(:, :) !! (n, n)
    integer :: i, j, k, p, q
    integer, allocatable :: order(:), start(:)

    c = 0.0_sp
    call sort_by_patch(near, candidate, order, start)
    do p = 1, size(start) - 1
      associate (second => order(start(p):start(p + 1) - 1))
        do q = 1, p
          associate (first => order(start(q):start(q + 1) - 1))
            associate (pairs => near%pairs(near%patch(candidate(second(1)))))
              k = findloc(pairs%partner, near%patch(candidate(first(1))), 1)
              if (k == 0) cycle
              do j = 1, size(second)
                do i = 1, size(first)
                  c(first(i), second(j)) = unit*pairs%c(k)%c(near%at(candidate(first(i))), &
                    near%at(candidate(second(j))))
                end do
                if (p /= q) c(second(j), first) = c(first, second(j))
              end do
            end associate
          end associate
        end do
      end associate
    end do
  end subroutine take_near

  !> Some candidates patch by patch, in the order of these.
  pure subroutine sort_by_patch(near, candidate, order, start)
    type(near_field_t), intent(in) :: near !! its patches
    integer, intent(in) :: candidate(:) !! (n) which
    integer, allocatable, intent(out) :: order(:) !! (n) their places in candidate
    integer, allocatable, intent(out) :: start(:) !! (patches that occur+1)
    integer :: next(size(near%start)), i

    next = 0
    do i = 1, size(candidate)
      associate (p => near%patch(candidate(i)) + 1)
        next(p) = next(p) + 1
      end associate
    end do
    start = [1, pack(next(2:), next(2:) > 0)]
    do i = 2, size(start)
      start(i) = start(i) + start(i - 1)
    end do
    next(1) = 1
    do i = 2, size(next)
      next(i) = next(i) + next(i - 1)
    end do
    allocate (order(size(candidate)))
    do i = 1, size(candidate)
      associate (p => near%patch(candidate(i)))
        order(next(p)) = i
        next(p) = next(p) + 1
      end associate
    end do
  end subroutine sort_by_patch

  !> Memory of the compliances between candidates that are near each other [byte].
  pure real(wp) function bytes_of_near_field(m) result(bytes)
    integer, intent(in) :: m !! candidates

    bytes = 4.0_wp*real(m, wp)*real(most_candidates, wp)*(near_patches + 1.0_wp)/2.0_wp
  end function bytes_of_near_field
end module near_field
