!> Polynomials fitted to values at points of the elements around a corner (doc/theory, "Nodal
!! stress", eq. (8.14)).
module patch_fits
  use kinds, only: wp
  use cells, only: corners_of
  use mesh_types, only: mesh_t
  implicit none
  private
  public :: recovery_t, patch_t, begin_patches, fit_patch, find_weights, find_terms, solve_terms, &
    most_terms

  !> Terms of a polynomial of degree 0, 1, 2; of the last one as many as there can be.
  integer, parameter :: terms_of(0:2) = [1, 4, 10]
  integer, parameter :: most_terms = 10
  !> Samples for each term: so many that a corner inside is content with the elements that hold it
  !! (some 24) and one on a surface, from which its polynomial is drawn outwards, is not.
  real(wp), parameter :: enough_of_four = 4.0_wp, enough_of_ten = 5.0_wp
  !> How often a patch takes in the elements around.
  integer, parameter :: most_rings = 3
  !> Largest sum of squares of the weights of samples: that of the four points of ten nodes where
  !! their linear field is followed to a corner, (1 + 3*5)/4; beyond that errors of samples grow.
  real(wp), parameter :: most_noise = 4.0_wp + 1.0e-6_wp
  !> A pivot below that share of its diagonal is round-off: the samples do not tell the term.
  real(wp), parameter :: no_pivot = 1.0e-10_wp
  !> Weight exp(-steep d^2/h^2) of a sample in the distance d, the farthest being at h. Those nearby
  !! count most, lest a pressure that ends within the patch is smeared; as little as this much for
  !! the values of four nodes, which scatter (tried: 0, 2, 4 and 0, 2, 4, 8, 10, 14 on a source
  !! outside of a cube and a line contact).
  real(wp), parameter :: steep_of_four = 2.0_wp, steep_of_ten = 10.0_wp

  !> What does not change in a run.
  type :: recovery_t
    integer, allocatable :: first(:) !! (elements + 1) first sample of each element
    real(wp), allocatable :: place(:, :) !! (3, samples) where they are [length]
    real(wp), allocatable :: volume(:) !! (elements) volumes between corners [length^3]
    logical, allocatable :: ten(:) !! (elements) it has ten nodes
    integer, allocatable :: around(:) !! elements around each corner
    integer, allocatable :: begin(:) !! (nodes + 1) where those of a node begin
    ! Corners of elements of four nodes alone: weights of the samples
    integer, allocatable :: row(:) !! (nodes + 1) where those of a node begin
    integer, allocatable :: column(:) !! samples
    real(wp), allocatable :: weight(:) !! their weights
  end type recovery_t

  !> Elements around a corner and the polynomial fitted to their samples.
  type :: patch_t
    integer :: n = 0 !! its elements
    integer :: own = 0 !! of these, those that hold the corner
    integer, allocatable :: list(:) !! (n) which
    integer, allocatable :: mark(:) !! (elements) number of the last patch that holds each
    integer :: stamp = 0 !! number of the patch
    integer :: samples = 0 !! of these elements
    integer, allocatable :: sample(:) !! (samples) which
    real(wp), allocatable :: b(:, :) !! (most_terms, samples) terms at each, times its weight
    real(wp), allocatable :: w(:) !! (samples) weights
    integer :: terms = 0 !! of the polynomial
    real(wp) :: origin(3) = 0.0_wp !! its centre, the corner [length]
    real(wp) :: size = 1.0_wp !! distance of the farthest sample [length]
    real(wp) :: factor(most_terms, most_terms) = 0.0_wp !! Cholesky's factor of its normal matrix
  end type patch_t

contains

  !> Room for patches.
  pure subroutine begin_patches(patch, recovery)
    type(patch_t), intent(out) :: patch !! gets room
    type(recovery_t), intent(in) :: recovery !! samples listed

    allocate (patch%list(size(recovery%volume)), patch%mark(size(recovery%volume)), source=0)
    allocate (patch%sample(256), patch%b(most_terms, 256), patch%w(256))
  end subroutine begin_patches

  !> The elements of one material around a corner and the best polynomial that they determine: of
  !! degree 2 where all have ten nodes and several samples, 1 elsewhere. Where too few samples are,
  !! the patch takes in the elements around; a body that has no more gets a lower degree.
  subroutine fit_patch(recovery, mesh, v, material, patch)
    type(recovery_t), intent(in) :: recovery !! samples
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: v !! the corner
    integer, intent(in) :: material !! the material
    type(patch_t), intent(inout) :: patch !! gets elements and polynomial
    real(wp) :: enough
    integer :: degree, ring
    logical :: sound, grown

    call begin_ring(recovery, mesh, v, material, patch)
    degree = 1
    enough = enough_of_four
    if (all(recovery%first(patch%list(:patch%n) + 1) - recovery%first(patch%list(:patch%n)) > 1)) &
      then
      degree = 2
      enough = enough_of_ten
    end if
    do degree = degree, 1, -1
      if (patch%n > patch%own) call begin_ring(recovery, mesh, v, material, patch)
      do ring = 1, most_rings
        if (count_samples(recovery, patch) >= enough*terms_of(degree)) then
          call fit(recovery, patch, terms_of(degree), sound)
          if (sound) return
        end if
        call grow_ring(recovery, mesh, material, patch, grown)
        if (.not. grown) exit
      end do
      if (count_samples(recovery, patch) < terms_of(degree)) cycle
      call fit(recovery, patch, terms_of(degree), sound)
      if (sound) return
    end do
    call begin_ring(recovery, mesh, v, material, patch)
    call fit(recovery, patch, 1, sound)
  end subroutine fit_patch

  !> A patch of the elements that hold a corner.
  subroutine begin_ring(recovery, mesh, v, material, patch)
    type(recovery_t), intent(in) :: recovery !! neighbours
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: v !! the corner
    integer, intent(in) :: material !! their material
    type(patch_t), intent(inout) :: patch !! gets them

    patch%n = 0
    patch%stamp = patch%stamp + 1
    patch%origin = mesh%x(:, v)
    call take_around(recovery, mesh, v, material, patch)
    patch%own = patch%n
  end subroutine begin_ring

  !> Takes the elements around a corner into a patch.
  pure subroutine take_around(recovery, mesh, v, material, patch)
    type(recovery_t), intent(in) :: recovery !! neighbours
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: v !! the corner
    integer, intent(in) :: material !! their material
    type(patch_t), intent(inout) :: patch !! takes them
    integer :: i, e

    do i = recovery%begin(v), recovery%begin(v + 1) - 1
      e = recovery%around(i)
      if (patch%mark(e) == patch%stamp .or. mesh%material(e) /= material) cycle
      patch%mark(e) = patch%stamp
      patch%n = patch%n + 1
      patch%list(patch%n) = e
    end do
  end subroutine take_around

  !> Takes in the elements around a patch.
  pure subroutine grow_ring(recovery, mesh, material, patch, grown)
    type(recovery_t), intent(in) :: recovery !! neighbours
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: material !! their material
    type(patch_t), intent(inout) :: patch !! takes them
    logical, intent(out) :: grown !! there were some
    integer :: i, k, before

    before = patch%n
    do i = 1, before
      associate (corners => corners_of(mesh%ix(:, patch%list(i))))
        do k = 1, size(corners)
          call take_around(recovery, mesh, corners(k), material, patch)
        end do
      end associate
    end do
    grown = patch%n > before
  end subroutine grow_ring

  !> Samples of a patch.
  pure integer function count_samples(recovery, patch) result(n)
    type(recovery_t), intent(in) :: recovery !! samples
    type(patch_t), intent(in) :: patch !! elements

    associate (list => patch%list(:patch%n))
      n = sum(recovery%first(list + 1) - recovery%first(list))
    end associate
  end function count_samples

  !> Weights, terms and factor of the fit; sound unless the samples do not determine it well.
  pure subroutine fit(recovery, patch, terms, sound)
    type(recovery_t), intent(in) :: recovery !! samples
    type(patch_t), intent(inout) :: patch !! elements given; gets the rest
    integer, intent(in) :: terms !! terms of the polynomial
    logical, intent(out) :: sound !! it can be used
    real(wp) :: b(most_terms), matrix(most_terms, most_terms), one(most_terms)
    integer :: s, j

    patch%terms = terms
    call take_samples(recovery, patch)
    matrix = 0.0_wp
    do s = 1, patch%samples
      associate (place => recovery%place(:, patch%sample(s)))
        call find_terms((place - patch%origin)/patch%size, terms, b)
      end associate
      patch%b(:terms, s) = patch%w(s)*b(:terms)
      do j = 1, terms
        matrix(j:terms, j) = matrix(j:terms, j) + patch%b(j, s)*b(j:terms)
      end do
    end do
    call factor_terms(matrix, terms, patch%factor, sound)
    if (.not. sound) return
    one = 0.0_wp
    one(1) = 1.0_wp
    call solve_terms(patch, one)
    sound = sum(matmul(one(:terms), patch%b(:terms, :patch%samples))**2) <= most_noise
  end subroutine fit

  !> The samples of a patch and their weights.
  pure subroutine take_samples(recovery, patch)
    type(recovery_t), intent(in) :: recovery !! samples
    type(patch_t), intent(inout) :: patch !! elements given; gets sample, w, size
    integer :: i, k, n

    n = count_samples(recovery, patch)
    if (n > size(patch%sample)) then
      deallocate (patch%sample, patch%b, patch%w)
      allocate (patch%sample(2*n), patch%b(most_terms, 2*n), patch%w(2*n))
    end if
    n = 0
    patch%size = 0.0_wp
    do i = 1, patch%n
      do k = recovery%first(patch%list(i)), recovery%first(patch%list(i) + 1) - 1
        n = n + 1
        patch%sample(n) = k
        patch%w(n) = sum((recovery%place(:, k) - patch%origin)**2)
        patch%size = max(patch%size, patch%w(n))
      end do
    end do
    patch%samples = n
    patch%w(:n) = exp(-merge(steep_of_ten, steep_of_four, n > patch%n)*patch%w(:n)/patch%size)
    patch%size = sqrt(patch%size)
  end subroutine take_samples

  !> Weights of the samples in the value at the corner.
  pure subroutine find_weights(patch, weight)
    type(patch_t), intent(in) :: patch !! fitted
    real(wp), allocatable, intent(out) :: weight(:) !! (samples) weights
    real(wp) :: one(most_terms)

    one = 0.0_wp
    one(1) = 1.0_wp
    call solve_terms(patch, one)
    weight = matmul(one(:patch%terms), patch%b(:patch%terms, :patch%samples))
  end subroutine find_weights

  !> Terms of the polynomial at a place.
  pure subroutine find_terms(d, terms, b)
    real(wp), intent(in) :: d(3) !! from its centre, over its size
    integer, intent(in) :: terms !! 1, 4 or 10
    real(wp), intent(out) :: b(most_terms) !! (terms) the terms

    b(1) = 1.0_wp
    if (terms == 1) return
    b(2:4) = d
    if (terms == 4) return
    b(5:10) = [d(1)**2, d(2)**2, d(3)**2, d(1)*d(2), d(2)*d(3), d(3)*d(1)]
  end subroutine find_terms

  !> Cholesky's factor of the normal matrix.
  pure subroutine factor_terms(matrix, n, factor, sound)
    real(wp), intent(in) :: matrix(most_terms, most_terms) !! its lower half
    integer, intent(in) :: n !! terms
    real(wp), intent(out) :: factor(most_terms, most_terms) !! its lower half
    logical, intent(out) :: sound !! no pivot is round-off
    real(wp) :: pivot
    integer :: j

    factor = matrix
    do j = 1, n
      pivot = matrix(j, j) - sum(factor(j, :j - 1)**2)
      sound = pivot > no_pivot*matrix(j, j)
      if (.not. sound) return
      factor(j, j) = sqrt(pivot)
      factor(j + 1:n, j) = (matrix(j + 1:n, j) - matmul(factor(j + 1:n, :j - 1), &
        factor(j, :j - 1)))/factor(j, j)
    end do
  end subroutine factor_terms

  !> Solves with the normal matrix.
  pure subroutine solve_terms(patch, c)
    type(patch_t), intent(in) :: patch !! its factor
    real(wp), intent(inout) :: c(most_terms) !! right-hand side; solution
    integer :: j

    associate (n => patch%terms, l => patch%factor)
      do j = 1, n
        c(j) = (c(j) - dot_product(l(j, :j - 1), c(:j - 1)))/l(j, j)
      end do
      do j = n, 1, -1
        c(j) = (c(j) - dot_product(l(j + 1:n, j), c(j + 1:n)))/l(j, j)
      end do
    end associate
  end subroutine solve_terms
end module patch_fits
