!> The candidates that elements or forces touch at present, the live ones, and their compliance: a
!! part of that of all candidates as it stands, or a copy of it (doc/theory, "Static condensation").
module live_candidates
  use kinds, only: wp
  use lapack_interface, only: dsymv
  use threads, only: pays_threads
  use condensation, only: drop_live
  use tree_compliance, only: apply_tree
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: widen_live, number_live, forget_live, gather_compliance, &
    complete_compliance, apply_compliance, own_part

  !> Live candidates over those that are needed.
  real(wp), parameter :: idle_ratio = 1.25_wp

contains

  !> Where the live candidates of a body follow each other with few gaps, or are most of many, those
  !! in the gaps are live as well: their compliance needs no copy. In narrow runs those that have
  !! been live stay so while they are few: no new copy each time that a point comes or goes.
  pure subroutine widen_live(condensed, live)
    type(condensed_t), intent(in) :: condensed !! bodies
    logical, intent(inout) :: live(:) !! (n) candidates that elements or forces touch
    logical :: both(size(live))
    integer :: b

    if (condensed%narrow) then
      both = live .or. condensed%alive%live_place > 0
      if (real(count(both), wp) <= idle_ratio*real(count(live), wp)) live = both
      return
    end if
    do b = 1, size(condensed%bodies)
      associate (first => condensed%bodies(b)%first + 1, last => condensed%bodies(b)%first &
        + condensed%bodies(b)%m)
        call close_gaps(condensed%tangent%parts%most_dense, &
          condensed%alive%live_place(first:last) > 0, live(first:last))
      end associate
    end do
  end subroutine widen_live

  !> The same for one body. What was live stays so while it has no gaps either and is not much more:
  !! factors of contact serve on.
  pure subroutine close_gaps(many, before, live)
    integer, intent(in) :: many !! candidates that are many
    logical, intent(in) :: before(:) !! (m) its live candidates so far
    logical, intent(inout) :: live(:) !! (m) those that are touched; gets those in the gaps
    integer :: first, last, wanted

    if (.not. any(live)) return
    first = findloc(live, .true., 1)
    last = findloc(live, .true., 1, back=.true.)
    wanted = count(live)
    if (real(last - first + 1, wp) > idle_ratio*real(wanted, wp) .and. &
      (size(live) <= many .or. 2*wanted <= size(live))) return
    live(first:last) = .true.
    if (.not. all(before(first:last))) return
    if (real(count(before), wp) > idle_ratio*real(last - first + 1, wp)) return
    first = findloc(before, .true., 1)
    last = findloc(before, .true., 1, back=.true.)
    if (all(before(first:last))) live = before
  end subroutine close_gaps

  !> Numbers the live candidates body after body.
  subroutine number_live(condensed)
    type(condensed_t), intent(inout) :: condensed !! live given; gets right and change
    integer :: b, first

    first = 0
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        body%first_live = first
        body%n_live = count(condensed%alive%live > body%first .and. &
          condensed%alive%live <= body%first + body%m)
        first = first + body%n_live
      end associate
    end do
    call clear_values(condensed)
  end subroutine number_live

  !> None is live: those of the increment before must not decide which are, as a restart from there
  !! does not know them. Their compliances stay at hand.
  subroutine forget_live(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets live

    if (.not. allocated(condensed%alive%live_place)) return
    condensed%alive%live_place = 0
    condensed%alive%live = [integer ::]
    condensed%alive%n_live = 0
    condensed%bodies%n_live = 0
    call clear_values(condensed)
  end subroutine forget_live

  !> Forces and displacements of the live candidates, zero.
  pure subroutine clear_values(condensed)
    type(condensed_t), intent(inout) :: condensed !! n_live given; gets right, change and a product

    condensed%alive%right = spread(0.0_wp, 1, condensed%alive%n_live)
    condensed%alive%change = condensed%alive%right
    condensed%alive%pushed = condensed%alive%right
    condensed%alive%product = condensed%alive%right
  end subroutine clear_values

  !> Compliance of the live candidates of each body, unless it is at hand.
  subroutine gather_compliance(condensed)
    type(condensed_t), intent(inout) :: condensed !! live numbered
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), mine => condensed%alive%live( &
        condensed%bodies(b)%first_live + 1:condensed%bodies(b)%first_live &
        + condensed%bodies(b)%n_live) - condensed%bodies(b)%first)
        if (allocated(body%gathered)) then
          if (size(body%gathered) == size(mine)) then
            if (all(body%gathered == mine)) cycle
          end if
        end if
        call drop_live(body)
        body%gathered = mine
        call take_part(body)
      end associate
    end do
  end subroutine gather_compliance

  !> Compliance of the live candidates of a body: columns of that of all where they have no gaps,
  !! else a copy.
  subroutine take_part(body)
    type(condensed_body_t), intent(inout) :: body !! gathered given; gets live
    integer :: j, n

    n = body%n_live
    if (body%tree%used) return
    if (n > 0) then
      if (body%gathered(n) - body%gathered(1) == n - 1) then
        body%skipped = body%gathered(1) - 1
        body%live => body%compliance(:, body%gathered(1):body%gathered(n))
        return
      end if
    end if
    allocate (body%live(n, n))
    body%copied = .true.
    do j = 1, n
      body%live(j:, j) = body%compliance(body%gathered(j:), body%gathered(j))
    end do
    call mirror(body%live)
  end subroutine take_part

  !> Fills the upper triangles of compliances that are no copies: products with them ask for the
  !! lower ones alone, columns of the tangent for both.
  subroutine complete_compliance(condensed)
    type(condensed_t), intent(inout) :: condensed !! gathered; gets them
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live == 0 .or. body%copied .or. body%mirrored .or. body%tree%used) cycle
        call mirror(body%compliance)
        body%mirrored = .true.
      end associate
    end do
  end subroutine complete_compliance

  !> Fills the upper triangle of a symmetric matrix from the lower one, in blocks.
  pure subroutine mirror(a)
    real(wp), intent(inout) :: a(:, :) !! the matrix
    integer, parameter :: columns_at_a_time = 32
    integer :: i, j, k

    do k = 1, size(a, 2), columns_at_a_time
      do i = k, size(a, 1), columns_at_a_time
        do j = k, min(k + columns_at_a_time - 1, size(a, 2))
          a(j, max(i, j + 1):min(i + columns_at_a_time - 1, size(a, 1))) = &
            a(max(i, j + 1):min(i + columns_at_a_time - 1, size(a, 1)), j)
        end do
      end do
    end do
  end subroutine mirror

  !> What of a column with few entries belongs to a body.
  pure subroutine own_part(body, dofs, values, n, mine, share)
    type(condensed_body_t), intent(in) :: body !! its live candidates
    integer, intent(in) :: dofs(:) !! live candidates, 0 for none
    real(wp), intent(in) :: values(:) !! entries
    integer, intent(out) :: n !! those of the body
    integer, intent(out) :: mine(:) !! (n) which of its live candidates
    real(wp), intent(out) :: share(:) !! (n) their entries
    integer :: i

    n = 0
    do i = 1, size(dofs)
      if (dofs(i) <= body%first_live .or. dofs(i) > body%first_live + body%n_live) cycle
      n = n + 1
      mine(n) = dofs(i) - body%first_live
      share(n) = values(i)
    end do
  end subroutine own_part

  !> y = C x on the live candidates.
  subroutine apply_compliance(condensed, x, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    real(wp), intent(in) :: x(:) !! (n_live) [force]
    real(wp), intent(inout) :: y(:) !! (n_live) [length]
    integer :: b
    logical :: pays

    pays = pays_threads(sum(real(condensed%bodies%n_live, wp)**2))
    !$omp parallel do schedule(dynamic, 1) default(none) shared(condensed, x, y) if(pays)
    do b = 1, size(condensed%bodies)
      if (condensed%bodies(b)%n_live > 0) call apply_body(condensed%bodies(b), x, y)
    end do
    !$omp end parallel do
  end subroutine apply_compliance

  !> The same on those of one body.
  subroutine apply_body(body, x, y)
    type(condensed_body_t), intent(in) :: body !! live compliance
    real(wp), intent(in) :: x(:) !! (n_live) [force]
    real(wp), intent(inout) :: y(:) !! (n_live) gets the part of the body [length]

    if (body%tree%used) then
      call apply_tree(body, body%gathered, x(body%first_live + 1:body%first_live + body%n_live), &
        y(body%first_live + 1:body%first_live + body%n_live))
      return
    end if
    call apply_part(size(body%live, 1), body%skipped, body%n_live, body%live, &
      x(body%first_live + 1:), y(body%first_live + 1:))
  end subroutine apply_body

  !> The same for one body.
  subroutine apply_part(rows, skipped, n, c, x, y)
    integer, intent(in) :: rows !! of c
    integer, intent(in) :: skipped !! those before the live candidates
    integer, intent(in) :: n !! live candidates
    real(wp), intent(in) :: c(rows, n) !! their columns of the compliance [length/force]
    real(wp), intent(in) :: x(n) !! [force]
    real(wp), intent(inout) :: y(n) !! [length]

    call dsymv('L', n, 1.0_wp, c(skipped + 1, 1), rows, x, 1, 0.0_wp, y, 1)
  end subroutine apply_part
end module live_candidates
