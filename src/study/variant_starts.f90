!> Where the increments of a variant start: from the contact forces that variants with values next
!! to its own had at the same end times (doc/theory, "Variants of a run", eq. (14.9)).
module variant_starts
  use kinds, only: wp
  use lapack_interface, only: dgelss
  use model_types, only: model_t
  use condensed_types, only: condensed_t
  use lever_sums, only: contact_nodes
  use study_types, only: study_t
  implicit none
  private
  public :: starts_t, begin_starts, choose_neighbours, guess_forces, keep_forces_of

  !> Variants that a start is made of, at most, and the largest sum of their shares.
  integer, parameter :: most_neighbours = 12
  real(wp), parameter :: most_shares = 6.0_wp
  !> Memory for the forces of all variants together [byte].
  real(wp), parameter :: most_bytes = 1.0e9_wp

  !> Contact forces before friction acted at points that have touched first, if there are any.
  type :: touching_t
    real(wp), allocatable :: force(:, :) !! (3, contact nodes) [force]
  end type touching_t

  !> Contact forces of one variant.
  type :: forces_t
    integer :: variant = 0 !! its number, 0 for none yet
    integer :: steps = 0 !! its end times
    real(wp), allocatable :: force(:, :, :) !! (3, contact nodes, end times) [force]
    type(touching_t), allocatable :: touching(:) !! (end times)
    real(wp), allocatable :: product(:, :) !! (candidates, end times) compliance product of these;
    !! not allocated if it is not known [length]
  end type forces_t

  !> What the starts of a study are made of.
  type :: starts_t
    integer, allocatable :: nodes(:) !! nodes that contact may load
    integer :: times = 0 !! end times of a run
    integer :: first = 1 !! the first end time that variants do not have in common
    real(wp), allocatable :: places(:, :) !! (parameters, variants) values in steps of the study
    type(forces_t), allocatable :: done(:) !! variants that have been solved; the oldest go first
    integer :: last = 0 !! where the present one goes
    integer, allocatable :: neighbours(:) !! places in done that the present one starts from
    real(wp), allocatable :: shares(:) !! of these; they add up to one
  end type starts_t

contains

  !> Nothing has been solved yet.
  subroutine begin_starts(study, model, times, first, starts)
    type(study_t), intent(in) :: study !! its variants
    type(model_t), intent(in) :: model !! pairs
    integer, intent(in) :: times !! end times of a run
    integer, intent(in) :: first !! the first one that variants do not have in common
    type(starts_t), intent(out) :: starts !! empty
    real(wp) :: bytes
    integer :: n

    starts%nodes = contact_nodes(model)
    starts%times = times
    starts%first = first
    starts%places = spread_values(study)
    bytes = 48.0_wp*real(size(starts%nodes), wp)*real(max(1, times), wp)
    n = max(2, min(size(study%order), int(min(most_bytes/bytes, 1.0e6_wp))))
    allocate (starts%done(n), starts%neighbours(0), starts%shares(0))
  end subroutine begin_starts

  !> Values of the variants, so that neighbouring values of a parameter are about one apart.
  pure function spread_values(study) result(places)
    type(study_t), intent(in) :: study !! parameters, variants
    real(wp) :: places(size(study%variants, 1), size(study%variants, 2))
    real(wp) :: low, high
    integer :: p, n

    do p = 1, size(places, 1)
      low = minval(study%variants(p, :))
      high = maxval(study%variants(p, :))
      n = size(study%varied(p)%values)
      places(p, :) = 0.0_wp
      if (high > low) places(p, :) = real(max(1, n - 1), wp)*(study%variants(p, :) - low) &
        /(high - low)
    end do
  end function spread_values

  !> The variants next to one, and their shares: those of the spline with the kernel r^3 and a
  !! linear part.
  subroutine choose_neighbours(starts, number)
    type(starts_t), intent(inout) :: starts !! gets neighbours, shares
    integer, intent(in) :: number !! the variant
    real(wp) :: distance(size(starts%done))
    integer :: i, k

    starts%last = mod(starts%last, size(starts%done)) + 1
    starts%done(starts%last)%variant = 0
    starts%done(starts%last)%steps = 0
    distance = huge(1.0_wp)
    do i = 1, size(distance)
      if (starts%done(i)%variant == 0) cycle
      distance(i) = norm2(starts%places(:, starts%done(i)%variant) - starts%places(:, number))
    end do
    starts%done(starts%last)%variant = number
    starts%neighbours = [integer ::]
    do k = 1, most_neighbours
      i = minloc(distance, 1)
      if (distance(i) >= huge(1.0_wp)) exit
      starts%neighbours = [starts%neighbours, i]
      distance(i) = huge(1.0_wp)
    end do
    call find_shares(starts%places(:, number), starts%places(:, &
      starts%done(starts%neighbours)%variant), starts%shares)
    if (size(starts%shares) == 0) return
    if (abs(sum(starts%shares) - 1.0_wp) > 1.0e-6_wp .or. &
      sum(abs(starts%shares)) > most_shares) then
      starts%shares = 0.0_wp
      starts%shares(1) = 1.0_wp
    end if
  end subroutine choose_neighbours

  !> Shares of values at some places in the value at another one.
  subroutine find_shares(wanted, places, shares)
    real(wp), intent(in) :: wanted(:) !! (parameters) where
    real(wp), intent(in) :: places(:, :) !! (parameters, n) where values are known
    real(wp), allocatable, intent(out) :: shares(:) !! (n)
    real(wp) :: a(size(places, 2) + size(wanted) + 1, size(places, 2) + size(wanted) + 1)
    real(wp) :: b(size(a, 1), 1), values(size(a, 1)), work(20*size(a, 1) + 100)
    integer :: i, k, n, rank, info

    n = size(places, 2)
    a = 0.0_wp
    do k = 1, n
      do i = 1, n
        a(i, k) = norm2(places(:, i) - places(:, k))**3
      end do
      a(n + 1, k) = 1.0_wp
      a(n + 2:, k) = places(:, k) - wanted
      a(k, n + 1:) = a(n + 1:, k)
      b(k, 1) = norm2(places(:, k) - wanted)**3
    end do
    b(n + 1:, 1) = 0.0_wp
    b(n + 1, 1) = 1.0_wp
    call dgelss(size(a, 1), size(a, 1), 1, a, size(a, 1), b, size(a, 1), values, 1.0e-10_wp, &
      rank, work, size(work), info)
    shares = b(:n, 1)
    if (info /= 0) shares = 0.0_wp
  end subroutine find_shares

  !> Forces to start from: those of the neighbours there, and by how much the present variant has
  !! been off them at the end time before. Where the neighbours have had points that touched first,
  !! also those before friction acted there.
  subroutine guess_forces(starts, i, condensed)
    type(starts_t), intent(in) :: starts !! neighbours chosen
    integer, intent(in) :: i !! the end time
    type(condensed_t), intent(inout) :: condensed !! forces kept of the end time before; gets those
    !! foretold, and displacements that these make
    integer :: k
    logical :: touches

    associate (outer => condensed%outer)
      outer%foretold = .false.
      if (allocated(outer%touching)) deallocate (outer%touching)
      if (allocated(outer%smooth)) deallocate (outer%smooth)
      if (size(starts%neighbours) == 0) return
      if (any(starts%done(starts%neighbours)%steps < i)) return
      outer%foretold = .true.
      if (i == starts%first) outer%kept = 0.0_wp
      touches = .true.
      do k = 1, size(starts%neighbours)
        associate (done => starts%done(starts%neighbours(k)))
          if (i > starts%first) outer%kept(:, starts%nodes) = outer%kept(:, starts%nodes) &
            - starts%shares(k)*done%force(:, :, i - 1)
          touches = touches .and. allocated(done%touching(i)%force)
        end associate
      end do
      if (touches) outer%smooth = outer%kept
      do k = 1, size(starts%neighbours)
        associate (done => starts%done(starts%neighbours(k)))
          outer%kept(:, starts%nodes) = outer%kept(:, starts%nodes) + starts%shares(k) &
            *done%force(:, :, i)
          if (touches) outer%smooth(:, starts%nodes) = outer%smooth(:, starts%nodes) &
            + starts%shares(k)*done%touching(i)%force
        end associate
      end do
    end associate
    call guess_products(starts, i, condensed)
  end subroutine guess_forces

  !> compliance product of the forces foretold is the same sum of their products before.
  subroutine guess_products(starts, i, condensed)
    type(starts_t), intent(in) :: starts !! neighbours chosen
    integer, intent(in) :: i !! the end time
    type(condensed_t), intent(inout) :: condensed !! forces foretold; gets product
    integer :: k

    if (.not. knows_products(starts, i, condensed)) return
    associate (bulk => condensed%bulk)
      if (i == starts%first) bulk%product = spread(0.0_wp, 1, condensed%n)
      do k = 1, size(starts%neighbours)
        associate (product => starts%done(starts%neighbours(k))%product)
          if (i == starts%first) bulk%product = bulk%product + starts%shares(k)*product(:, i)
          if (i > starts%first) bulk%product = bulk%product + starts%shares(k)*(product(:, i) &
            - product(:, i - 1))
        end associate
      end do
      bulk%product_of = candidate_forces(condensed)
    end associate
  end subroutine guess_products

  !> Products are known of all neighbours and of the end time before.
  logical function knows_products(starts, i, condensed) result(known)
    type(starts_t), intent(in) :: starts !! neighbours chosen
    integer, intent(in) :: i !! the end time
    type(condensed_t), intent(in) :: condensed !! candidates, product
    integer :: k

    known = i == starts%first .or. is_product_current(condensed)
    do k = 1, size(starts%neighbours)
      if (.not. known) return
      associate (done => starts%done(starts%neighbours(k)))
        known = allocated(done%product)
        if (known) known = size(done%product, 1) == condensed%n
      end associate
    end do
  end function knows_products

  !> The product is that of the forces of the iterate.
  pure logical function is_product_current(condensed) result(product)
    type(condensed_t), intent(in) :: condensed !! force, product

    product = allocated(condensed%bulk%product_of)
    if (product) product = all(abs(condensed%bulk%force - condensed%bulk%product_of) <= 0.0_wp)
  end function is_product_current

  !> The forces to start from, at the candidates.
  pure function candidate_forces(condensed) result(force)
    type(condensed_t), intent(in) :: condensed !! kept
    real(wp) :: force(condensed%n)
    integer :: j

    do j = 1, condensed%n
      force(j) = condensed%outer%kept(condensed%direction(j), condensed%node(j))
    end do
  end function candidate_forces

  !> Keeps the forces of the present variant.
  subroutine keep_forces_of(starts, i, condensed)
    type(starts_t), intent(inout) :: starts !! gets them
    integer, intent(in) :: i !! the end time
    type(condensed_t), intent(in) :: condensed !! forces at its end, and before friction; product

    associate (mine => starts%done(starts%last), outer => condensed%outer)
      if (.not. allocated(mine%force)) then
        allocate (mine%force(3, size(starts%nodes), starts%times), source=0.0_wp)
        allocate (mine%touching(starts%times))
      end if
      mine%force(:, :, i) = outer%kept(:, starts%nodes)
      if (allocated(mine%touching(i)%force)) deallocate (mine%touching(i)%force)
      if (allocated(outer%touching)) mine%touching(i)%force = outer%touching(:, starts%nodes)
      call keep_products_of(starts, i, condensed)
      mine%steps = i
    end associate
  end subroutine keep_forces_of

  !> Keeps displacements that these make, as long as candidates are the same.
  subroutine keep_products_of(starts, i, condensed)
    type(starts_t), intent(inout) :: starts !! gets them
    integer, intent(in) :: i !! the end time
    type(condensed_t), intent(in) :: condensed !! product
    logical :: whole

    associate (mine => starts%done(starts%last))
      whole = is_product_current(condensed)
      if (allocated(mine%product)) then
        if (size(mine%product, 1) /= condensed%n .or. .not. whole) deallocate (mine%product)
        whole = whole .and. allocated(mine%product)
      else
        whole = whole .and. i == starts%first
      end if
      if (.not. whole) return
      if (.not. allocated(mine%product)) allocate (mine%product(condensed%n, starts%times))
      mine%product(:, i) = condensed%bulk%product
    end associate
  end subroutine keep_products_of
end module variant_starts
