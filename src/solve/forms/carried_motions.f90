!> What the compliance of a body that contact alone holds owes to its fixings: rigid motions, which
!! are unknowns by themselves (doc/theory, "Condensed floating bodies", eqs. (12.13), (12.14)).
module carried_motions
  use kinds, only: wp, sp
  use lapack_interface, only: dgelss, dsymv, dgemv, ssymv
  use tree_compliance, only: apply_tree_single
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: part_motions, add_carried, carry, apply_nearly

contains

  !> What of the compliance is rigid motion of the bodies: C = C' + R X^T + X R^T, where C' neither
  !! feels forces that balance on the motions R nor moves along these. The springs that fix a
  !! body carry forces from one end of it to the other; with C' the blocks know nothing of them.
  subroutine part_motions(condensed)
    type(condensed_t), intent(inout) :: condensed !! live compliances, motions; gets near
    integer :: b

    do b = 1, size(condensed%bodies)
      if (condensed%bodies(b)%n_live > 0) call part_body(condensed%bodies(b))
    end do
  end subroutine part_motions

  !> The same of one body, unless it is known: it is forgotten with the live compliance.
  subroutine part_body(body)
    type(condensed_body_t), intent(inout) :: body !! live compliance, motions; gets near
    real(wp) :: column(body%n_live)
    integer :: j

    if (allocated(body%near%modes)) return
    associate (near => body%near, n => body%n_live, m => body%motions%n)
      allocate (near%modes(n, m), near%carried(n, m))
      if (body%tree%used) return
      allocate (near%c(n, n))
      if (m > 0) then
        near%modes = body%modes(body%gathered, :m)
        call find_carried(body%live(body%skipped + 1:body%skipped + n, :), near%modes, near%carried)
      end if
      do j = 1, n
        column = body%live(body%skipped + 1:body%skipped + n, j)
        if (m > 0) then
          call dgemv('N', n, m, -1.0_wp, near%modes, n, near%carried(j, :), 1, 1.0_wp, column, 1)
          call dgemv('N', n, m, -1.0_wp, near%carried, n, near%modes(j, :), 1, 1.0_wp, column, 1)
        end if
        near%c(:, j) = real(column/body%softness, sp)
      end do
    end associate
  end subroutine part_body

  !> X = C W - R W^T C W / 2 with W = R (R^T R)^-1; zero where the motions do not show in full.
  subroutine find_carried(c, modes, carried)
    real(wp), contiguous, intent(in) :: c(:, :) !! (n, n) C [length/force]
    real(wp), intent(in) :: modes(:, :) !! (n, motions) R
    real(wp), intent(out) :: carried(:, :) !! (n, motions) X
    real(wp) :: normal(6, 6), share(6, 6), values(6), work(200)
    real(wp), dimension(size(modes, 1), size(modes, 2)) :: forces, moved
    integer :: k, n, rank, info

    carried = 0.0_wp
    n = size(modes, 2)
    normal(:n, :n) = matmul(transpose(modes), modes)
    share = 0.0_wp
    do k = 1, n
      share(k, k) = 1.0_wp
    end do
    call dgelss(n, n, n, normal, 6, share, 6, values, 1.0e-10_wp, rank, work, size(work), info)
    if (info /= 0 .or. rank < n) return
    forces = matmul(modes, share(:n, :n))
    do k = 1, n
      call dsymv('L', size(c, 1), 1.0_wp, c, size(c, 1), forces(:, k), 1, 0.0_wp, moved(:, k), 1)
    end do
    carried = moved - 0.5_wp*matmul(modes, matmul(transpose(forces), moved))
  end subroutine find_carried

  !> y = C x on the live candidates with C' in single precision. What goes to and from it is of the
  !! size of one.
  subroutine apply_nearly(condensed, x, y)
    type(condensed_t), intent(in) :: condensed !! near compliances
    real(wp), intent(in) :: x(:) !! (n_live) [force]
    real(wp), intent(out) :: y(:) !! (n_live) [length]
    real(sp) :: asked(size(x)), answer(size(x))
    real(wp) :: unit
    integer :: b

    y = 0.0_wp
    unit = maxval(abs(x))
    if (.not. unit > 0.0_wp) return
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), near => condensed%bodies(b)%near, &
        first => condensed%bodies(b)%first_live + 1, n => condensed%bodies(b)%n_live)
        if (n == 0) cycle
        asked(:n) = real(x(first:first + n - 1)/unit, sp)
        if (body%tree%used) then
          call apply_tree_single(body, body%gathered, asked(:n), answer(:n))
        else
          call ssymv('L', n, 1.0_sp, near%c, n, asked, 1, 0.0_sp, answer, 1)
        end if
        associate (mine => x(first:first + n - 1))
          y(first:first + n - 1) = unit*body%softness*answer(:n)
          if (body%motions%n > 0) y(first:first + n - 1) = y(first:first + n - 1) &
            + matmul(near%modes, matmul(mine, near%carried)) &
            + matmul(near%carried, matmul(mine, near%modes))
        end associate
      end associate
    end do
  end subroutine apply_nearly

  !> Adds X p for what is asked of the rigid motions.
  pure subroutine add_carried(condensed, push, t)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies, near
    real(wp), intent(in) :: push(:) !! (modes) p [length]
    real(wp), intent(inout) :: t(:) !! (live) [length]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n)
        if (n == 0 .or. body%n_live == 0) cycle
        associate (mine => t(body%first_live + 1:body%first_live + body%n_live))
          mine = mine + matmul(body%near%carried, push(body%first_mode + 1:body%first_mode + n) &
            /body%softness)
        end associate
      end associate
    end do
  end subroutine add_carried

  !> Adds X^T y to rigid motions.
  pure subroutine carry(condensed, y, alpha)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies, near
    real(wp), intent(in) :: y(:) !! (live) [force]
    real(wp), intent(inout) :: alpha(:) !! (modes) [length]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n)
        if (n == 0 .or. body%n_live == 0) cycle
        associate (mine => alpha(body%first_mode + 1:body%first_mode + n))
          mine = mine + matmul(y(body%first_live + 1:body%first_live + body%n_live), &
            body%near%carried)
        end associate
      end associate
    end do
  end subroutine carry
end module carried_motions
