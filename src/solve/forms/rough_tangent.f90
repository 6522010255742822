!> The tangent of contact in single precision, where products with the compliances are long: it is
!! half as long to read, and directions need no more digits. What a direction does to displacements
!! is found in double precision while single would show (doc/theory, "Contact operator of low
!! rank").
module rough_tangent
  use kinds, only: wp, sp
  use threads, only: worth_threads, pays_threads
  use lapack_interface, only: sgemv, ssymv, sgetrs
  use shared_lu, only: factorise_dense
  use condensed_types, only: condensed_t, condensed_body_t, contact_tangent_t
  use contact_sums, only: take_shares
  use costs, only: begin_cost, end_cost, count_cost, cost_solve
  use live_candidates, only: own_part, apply_compliance
  use tree_compliance, only: has_trees
  use whole_tangent, only: stiffest_contact
  use system_types, only: system_t
  implicit none
  private
  public :: has_long_products, may_be_rough, form_rough, answer_roughly, apply_roughly, &
    show_direction

  !> A product with the compliances is long if it has this many entries of them for a closed
  !! element: it takes longer than the residual of one more step.
  real(wp), parameter :: long_product = 4000.0_wp
  !> And longer to read in double precision, if it has this many.
  real(wp), parameter :: many_entries = 1.0e6_wp
  !> Largest entry times compliance at which single precision leaves enough digits of an answer.
  real(wp), parameter :: stiffest_rough = 100.0_wp
  !> Share of forces by which displacements in single precision are off.
  real(wp), parameter :: digits = 16.0_wp*epsilon(1.0_sp)
  !> Columns of the small matrix that are formed at a time, rows that a product takes at once.
  integer, parameter :: block = 16, strip = 64

contains

  !> A product with the compliances takes longer than the residual of one more step; with blocks
  !! that is not asked.
  pure logical function has_long_products(condensed) result(long)
    type(condensed_t), intent(in) :: condensed !! live candidates, closed elements

    long = .not. condensed%tangent%parts%iterated .and. sum(real(condensed%bodies%n_live, wp)**2) &
      > long_product*real(condensed%tangent%elements, wp)
  end function has_long_products

  !> Single precision serves for the tangent whose columns have been chosen: products are long,
  !! supports hold all bodies, no penalty takes the digits, and nobody else asks for the factor.
  pure logical function may_be_rough(system) result(rough)
    type(system_t), intent(in) :: system !! columns chosen, compliances gathered

    associate (condensed => system%condensed, tangent => system%condensed%tangent)
      rough = condensed%active .and. tangent%modes == 0 .and. .not. (tangent%whole .or. &
        tangent%parts%iterated .or. has_trees(condensed) .or. system%motion%active .or. &
        system%whole_factors .or. system%slopes_due)
      if (rough) rough = has_long_products(condensed) .and. &
        sum(real(condensed%bodies%n_live, wp)**2) > many_entries
      if (rough) rough = stiffest_contact(condensed, tangent) <= stiffest_rough
    end associate
  end function may_be_rough

  !> Finds in double precision what a direction of single precision does to displacements, unless
  !! what is off by then, with the steps before it, is too little to matter; if it is found, it
  !! leads to where the forces put the candidates.
  subroutine show_direction(system, sought)
    type(system_t), intent(inout) :: system !! force_change given; gets du, solution, change
    real(wp), intent(in) :: sought !! by what displacements may be off, as forces [force]
    real(wp) :: force(system%condensed%alive%n_live), moved(system%condensed%alive%n_live)
    integer :: i

    associate (condensed => system%condensed, alive => system%condensed%alive, &
      bulk => system%condensed%bulk)
      bulk%hides = 0.0_wp
      bulk%shows = .false.
      if (.not. condensed%tangent%rough%used) return
      force = bulk%force_change(alive%live)
      bulk%hides = digits*norm2(force)
      if (bulk%hides + bulk%hidden <= sought) return
      call begin_cost(system%costs, cost_solve)
      moved = 0.0_wp
      call apply_compliance(condensed, bulk%force(alive%live) + force, moved)
      do i = 1, alive%n_live
        associate (c => alive%live(i))
          associate (k => condensed%direction(c), node => condensed%node(c))
            alive%change(i) = condensed%outer%loaded(c) - moved(i) - system%u(k, node)
            system%du(k, node) = alive%change(i)
            system%solution(system%equation(k, node)) = alive%change(i)
          end associate
        end associate
      end do
      bulk%hides = 0.0_wp
      bulk%shows = .true.
      call end_cost(system%costs, cost_solve)
      call count_cost(system%costs, cost_solve, -1)
    end associate
  end subroutine show_direction

  !> C U and the factor of I + V^T C U.
  subroutine form_rough(condensed, tangent, info)
    type(condensed_t), intent(inout) :: condensed !! live compliances; those in single are made
    type(contact_tangent_t), intent(inout) :: tangent !! columns given; gets rough
    integer, intent(out) :: info !! 0: there is a factor
    integer :: b, j
    logical :: pays

    do b = 1, size(condensed%bodies)
      call make_single(condensed%bodies(b))
    end do
    call make_room(condensed%alive%n_live, tangent)
    pays = pays_threads(real(tangent%rank, wp)*size(tangent%dofs, 1)*condensed%alive%n_live)
    !$omp parallel do schedule(static) default(none) shared(condensed, tangent) if(pays)
    do j = 1, tangent%rank
      call add_columns(condensed, tangent%dofs(:, tangent%owner(j)), tangent%u(:, j), &
        tangent%rough%cu(:, j))
    end do
    !$omp end parallel do
    pays = pays_threads(real(tangent%rank, wp)**2*size(tangent%dofs, 1))
    !$omp parallel do schedule(static) default(none) shared(tangent) if(pays)
    do j = 1, tangent%rank, block
      call multiply_rows(tangent, j, min(block, tangent%rank - j + 1))
    end do
    !$omp end parallel do
    info = 0
    if (tangent%rank > 0) call factorise_dense(tangent%rank, tangent%rough%small, &
      size(tangent%rough%small, 1), tangent%rough%pivot, info)
  end subroutine form_rough

  !> The compliance of a body in single precision: that of all its candidates, where the live ones
  !! are a part of it as it stands.
  subroutine make_single(body)
    type(condensed_body_t), intent(inout) :: body !! live compliance; gets single
    integer :: j

    if (body%n_live == 0) return
    if (allocated(body%near%single)) then
      if (size(body%near%single, 1) == merge(body%n_live, body%m, body%copied)) return
      deallocate (body%near%single)
    end if
    if (body%copied) then
      allocate (body%near%single(body%n_live, body%n_live))
      do j = 1, body%n_live
        body%near%single(:, j) = real(body%live(:, j), sp)
      end do
    else
      allocate (body%near%single(body%m, body%m))
      call take_lower(body%compliance, body%near%single)
    end if
  end subroutine make_single

  !> A symmetric matrix in single precision from the lower triangle of one in double.
  pure subroutine take_lower(a, b)
    real(wp), intent(in), contiguous :: a(:, :) !! its lower triangle counts
    real(sp), intent(out), contiguous :: b(:, :) !! both triangles
    integer :: i, k, last

    do k = 1, size(a, 2), block
      last = min(k + block - 1, size(a, 2))
      do i = k, last
        b(i:, i) = real(a(i:, i), sp)
      end do
      do i = k + 1, size(a, 1)
        b(k:min(i - 1, last), i) = real(a(i, k:min(i - 1, last)), sp)
      end do
    end do
  end subroutine take_lower

  !> Room for C U and the small matrix.
  subroutine make_room(rows, tangent)
    integer, intent(in) :: rows !! live candidates
    type(contact_tangent_t), intent(inout) :: tangent !! rank given; gets room in rough
    integer :: room

    room = tangent%rank + tangent%rank/4 + 1
    associate (rough => tangent%rough)
      if (allocated(rough%cu)) then
        if (size(rough%cu, 1) == rows .and. size(rough%cu, 2) >= tangent%rank) return
        deallocate (rough%cu, rough%small, rough%pivot)
      end if
      allocate (rough%cu(rows, room), rough%small(room, room), rough%pivot(room))
    end associate
  end subroutine make_room

  !> y = C u for a u that few degrees of freedom have.
  subroutine add_columns(condensed, dofs, u, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    integer, intent(in) :: dofs(:) !! live candidates, 0 for none
    real(wp), intent(in) :: u(:) !! values
    real(sp), intent(out) :: y(:) !! (n_live) C u
    integer :: b, n, mine(size(dofs))
    real(wp) :: share(size(dofs))

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live == 0) cycle
        call own_part(body, dofs, u, n, mine, share)
        call combine(body%near%single, body%skipped, body%skipped + mine(:n), &
          real(share(:n), sp), y(body%first_live + 1:body%first_live + body%n_live))
      end associate
    end do
  end subroutine add_columns

  !> Sum of some columns with shares, three at a time.
  pure subroutine combine(a, skipped, column, share, y)
    real(sp), intent(in), contiguous :: a(:, :) !! the columns
    integer, intent(in) :: skipped !! rows of theirs before those of the sum
    integer, intent(in) :: column(:) !! which of them
    real(sp), intent(in) :: share(:) !! how much of each
    real(sp), intent(out) :: y(:) !! the sum
    integer :: i

    associate (first => skipped + 1, last => skipped + size(y))
      if (size(column) < 3) then
        y = 0.0_sp
      else
        y = share(1)*a(first:last, column(1)) + share(2)*a(first:last, column(2)) &
          + share(3)*a(first:last, column(3))
      end if
      do i = 4, size(column) - 2, 3
        y = y + share(i)*a(first:last, column(i)) + share(i + 1)*a(first:last, column(i + 1)) &
          + share(i + 2)*a(first:last, column(i + 2))
      end do
      do i = size(column)/3*3 + 1, size(column)
        y = y + share(i)*a(first:last, column(i))
      end do
    end associate
  end subroutine combine

  !> Some columns of I + V^T C U. They are turned first, so that a degree of freedom of V finds all
  !! of them side by side.
  subroutine multiply_rows(tangent, first, columns)
    type(contact_tangent_t), intent(inout) :: tangent !! v and cu given; gets small
    integer, intent(in) :: first !! the first column
    integer, intent(in) :: columns !! how many, at most block
    real(sp) :: turned(block, size(tangent%rough%cu, 1)), total(block)
    integer :: i, k

    associate (small => tangent%rough%small)
      turned = 0.0_sp
      turned(:columns, :) = transpose(tangent%rough%cu(:, first:first + columns - 1))
      do k = 1, tangent%rank
        total = 0.0_sp
        associate (dofs => tangent%dofs(:, tangent%owner(k)))
          do i = 1, size(tangent%dofs, 1)
            if (dofs(i) > 0) total = total + real(tangent%v(i, k), sp)*turned(:, dofs(i))
          end do
        end associate
        small(k, first:first + columns - 1) = total(:columns)
      end do
      do k = first, first + columns - 1
        small(k, k) = small(k, k) + 1.0_sp
      end do
    end associate
  end subroutine multiply_rows

  !> The shares z of the columns with (I + V^T C U) z = V^T d, and t = d - C U z, whose digits are
  !! those of single precision.
  subroutine answer_roughly(tangent, d, z, t)
    type(contact_tangent_t), intent(in) :: tangent !! its factor
    real(wp), intent(in) :: d(:) !! (live) [length]
    real(wp), intent(out) :: z(:) !! (rank) the force is U z
    real(wp), intent(out) :: t(:) !! (live) [length]
    real(sp) :: shares(tangent%rank), taken(size(d))
    real(wp) :: unit
    integer :: info

    t = d
    if (tangent%rank == 0) return
    call take_shares(tangent, d, z)
    unit = maxval(abs(z))
    if (unit <= 0.0_wp) return
    shares = real(z/unit, sp)
    call sgetrs('N', tangent%rank, 1, tangent%rough%small, size(tangent%rough%small, 1), &
      tangent%rough%pivot, shares, tangent%rank, info)
    z = unit*shares
    call take_columns(size(d), tangent%rank, tangent%rough%cu, shares, taken)
    t = d - unit*taken
  end subroutine answer_roughly

  !> t = C U z, some strips of rows at a time where there are threads: each row is added up as it is
  !! in one thread.
  subroutine take_columns(rows, columns, cu, z, t)
    integer, intent(in) :: rows, columns !! of C U
    real(sp), intent(in) :: cu(rows, *) !! C U, perhaps with room for more columns
    real(sp), intent(in) :: z(columns) !! shares of the columns
    real(sp), intent(out) :: t(rows) !! their sum
    integer :: part, parts, first, n

    parts = worth_threads(real(rows, wp)*real(columns, wp))
    !$omp parallel do schedule(static) default(none) private(first, n) &
    !$omp& shared(rows, columns, cu, z, t, parts) if(parts > 1)
    do part = 1, parts
      first = 1 + rows/strip*(part - 1)/parts*strip
      n = merge(rows, rows/strip*part/parts*strip, part == parts) + 1 - first
      call sgemv('N', n, columns, 1.0_sp, cu(first, 1), rows, z, 1, 0.0_sp, t(first), 1)
    end do
    !$omp end parallel do
  end subroutine take_columns

  !> y = C x on the live candidates.
  subroutine apply_roughly(condensed, x, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    real(wp), intent(in) :: x(:) !! (n_live) [force]
    real(wp), intent(out) :: y(:) !! (n_live) [length]
    integer :: b
    logical :: pays

    pays = pays_threads(sum(real(condensed%bodies%n_live, wp)**2))
    !$omp parallel do schedule(dynamic, 1) default(none) shared(condensed, x, y) if(pays)
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live > 0) call apply_body(body, body%n_live, x(body%first_live + 1:), &
          y(body%first_live + 1:))
      end associate
    end do
    !$omp end parallel do
  end subroutine apply_roughly

  !> The same for one body.
  subroutine apply_body(body, n, x, y)
    type(condensed_body_t), intent(in) :: body !! live compliance
    integer, intent(in) :: n !! live candidates
    real(wp), intent(in) :: x(n) !! [force]
    real(wp), intent(inout) :: y(n) !! [length]
    real(sp) :: asked(n), answer(n)
    real(wp) :: unit

    y = 0.0_wp
    unit = maxval(abs(x))
    if (unit <= 0.0_wp) return
    asked = real(x/unit, sp)
    associate (c => body%near%single)
      call ssymv('L', n, 1.0_sp, c(body%skipped + 1, body%skipped + 1), size(c, 1), asked, 1, &
        0.0_sp, answer, 1)
    end associate
    y = unit*answer
  end subroutine apply_body
end module rough_tangent
