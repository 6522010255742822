!> Wide supernodes of a factor of CHOLMOD's, split into panels before it is made (doc/theory,
!! "Sparse factorisation"). A supernode is stored as a rectangle: half of its square on the diagonal
!! is room that nothing uses, and the work space holds all that one supernode takes from another.
module supernode_panels
  use, intrinsic :: iso_c_binding, only: c_ptr, c_size_t, c_sizeof, c_f_pointer
  use kinds, only: long
  use cholmod_interface, only: cholmod_common_t, cholmod_factor_t, cholmod_l_realloc
  use supernodes, only: supernodes_t, supernodes_of
  implicit none
  private
  public :: split_supernodes, expand_supernodes

  !> Columns of a panel at most: products with so many columns are as fast as with more.
  integer(long), parameter :: widest = 256_long

  !> The panels: as supernodes_t, numbers 0-based.
  type :: panels_t
    integer(long), allocatable :: super(:) !! (n+1) first column of each
    integer(long), allocatable :: pi(:) !! (n+1) where its rows begin in s
    integer(long), allocatable :: px(:) !! (n+1) where its values begin
    integer(long), allocatable :: s(:) !! rows
  end type panels_t

contains

  !> Splits the supernodes of an analysis that are wider than a panel. A panel has the columns of
  !! its supernode that come after those of the panels before it, and their rows.
  subroutine split_supernodes(handle, common)
    type(c_ptr), intent(in) :: handle !! a factor of CHOLMOD's, analysed, without values
    type(cholmod_common_t), intent(inout) :: common !! settings; its status tells of failure
    type(supernodes_t) :: nodes
    type(panels_t) :: panels

    nodes = supernodes_of(handle)
    if (nodes%factor%nsuper == 0_c_size_t) return
    if (maxval(nodes%super(2:) - nodes%super(:size(nodes%super) - 1)) <= widest) return
    call find_panels(nodes%super, nodes%pi, nodes%s, panels)
    call replace_supernodes(panels, nodes%factor, common)
  end subroutine split_supernodes

  !> Makes the analysis of a graph that of the equations of its nodes, which follow each other, and
  !! splits it.
  subroutine expand_supernodes(handle, before, common)
    type(c_ptr), intent(in) :: handle !! a factor of CHOLMOD's, analysed, without values
    integer(long), intent(in) :: before(:) !! (nodes+1) equations before those of each node
    type(cholmod_common_t), intent(inout) :: common !! settings; its status tells of failure
    type(supernodes_t) :: nodes
    type(panels_t) :: wide, panels
    integer(c_size_t) :: entries
    integer(long) :: k, i, j, filled

    nodes = supernodes_of(handle)
    wide%super = before(nodes%super + 1)
    allocate (wide%pi(size(nodes%pi)), wide%s(sum(before(nodes%s + 2) - before(nodes%s + 1))))
    filled = 0
    do k = 1, size(nodes%pi, kind=long) - 1
      wide%pi(k) = filled
      do i = nodes%pi(k) + 1, nodes%pi(k + 1)
        associate (first => before(nodes%s(i) + 1), n => before(nodes%s(i) + 2) &
          - before(nodes%s(i) + 1))
          wide%s(filled + 1:filled + n) = [(j, j=first, first + n - 1)]
          filled = filled + n
        end associate
      end do
    end do
    wide%pi(size(wide%pi)) = filled
    call find_panels(wide%super, wide%pi, wide%s, panels)
    call replace_supernodes(panels, nodes%factor, common)
    associate (factor => nodes%factor, n => before(size(before)))
      entries = factor%n
      call replace([(i, i=0, n - 1)], factor%perm, entries, common)
      call replace(spread(1_long, 1, int(n)), factor%col_count, entries, common)
      factor%n = int(n, c_size_t)
      factor%minor = factor%n
    end associate
  end subroutine expand_supernodes

  !> Puts panels in place of the supernodes of an analysis.
  subroutine replace_supernodes(panels, factor, common)
    type(panels_t), intent(in) :: panels !! the new ones
    type(cholmod_factor_t), intent(inout) :: factor !! analysed, without values
    type(cholmod_common_t), intent(inout) :: common !! settings; its status tells of failure

    associate (before => factor%nsuper + 1_c_size_t)
      call replace(panels%super, factor%super, before, common)
      call replace(panels%pi, factor%pi, before, common)
      call replace(panels%px, factor%px, before, common)
      call replace(panels%s, factor%s, factor%ssize, common)
    end associate
    if (common%status < 0) return
    factor%nsuper = size(panels%super, kind=c_size_t) - 1_c_size_t
    factor%ssize = size(panels%s, kind=c_size_t)
    factor%xsize = int(panels%px(size(panels%px)), c_size_t)
    call measure_updates(panels, panels%super(size(panels%super)), factor%maxcsize, &
      factor%maxesize)
  end subroutine replace_supernodes

  !> Panels of about the same width from each supernode.
  pure subroutine find_panels(super, pi, s, panels)
    integer(long), intent(in) :: super(:), pi(:), s(:) !! supernodes, as in panels_t
    type(panels_t), intent(out) :: panels !! of all of them
    integer(long), allocatable :: from(:)
    integer(long) :: k, j, n, columns, parts, past

    n = sum((super(2:) - super(:size(super) - 1) + widest - 1)/widest)
    allocate (panels%super(n + 1), panels%pi(n + 1), panels%px(n + 1), from(n))
    panels%super(1) = 0_long
    panels%pi(1) = 0_long
    panels%px(1) = 0_long
    n = 0
    do k = 1, size(super, kind=long) - 1
      columns = super(k + 1) - super(k)
      parts = (columns + widest - 1)/widest
      do j = 1, parts
        n = n + 1
        past = panels%super(n) - super(k)
        panels%super(n + 1) = super(k) + columns*j/parts
        from(n) = pi(k) + past
        panels%pi(n + 1) = panels%pi(n) + pi(k + 1) - from(n)
        panels%px(n + 1) = panels%px(n) + (panels%pi(n + 1) - panels%pi(n)) &
          *(panels%super(n + 1) - panels%super(n))
      end do
    end do
    allocate (panels%s(panels%pi(n + 1)))
    do k = 1, n
      panels%s(panels%pi(k) + 1:panels%pi(k + 1)) = s(from(k) + 1:from(k) + panels%pi(k + 1) &
        - panels%pi(k))
    end do
  end subroutine find_panels

  !> Puts an array in place of one of CHOLMOD's.
  subroutine replace(values, block, n, common)
    integer(long), intent(in) :: values(:) !! the new ones
    type(c_ptr), intent(inout) :: block !! array of CHOLMOD's
    integer(c_size_t), intent(in) :: n !! entries that it has
    type(cholmod_common_t), intent(inout) :: common !! settings; its status tells of failure
    integer(long), pointer :: now(:)
    integer(c_size_t) :: entries

    entries = n
    if (common%status < 0) return
    block = cholmod_l_realloc(size(values, kind=c_size_t), c_sizeof(0_long), block, entries, common)
    if (common%status < 0) return
    call c_f_pointer(block, now, [size(values)])
    now = values
  end subroutine replace

  !> What one panel takes from another at most, and rows below a panel at most.
  pure subroutine measure_updates(panels, columns, largest, longest)
    type(panels_t), intent(in) :: panels !! all panels
    integer(long), intent(in) :: columns !! of the factor
    integer(c_size_t), intent(out) :: largest !! entries of an update
    integer(c_size_t), intent(out) :: longest !! rows below
    integer(long) :: owner(0:columns - 1), k, first, last, past

    do k = 1, size(panels%super, kind=long) - 1
      owner(panels%super(k):panels%super(k + 1) - 1) = k
    end do
    largest = 1_c_size_t
    longest = 1_c_size_t
    do k = 1, size(panels%super, kind=long) - 1
      first = panels%pi(k) + panels%super(k + 1) - panels%super(k) + 1
      last = panels%pi(k + 1)
      longest = max(longest, int(last - first + 1, c_size_t))
      do while (first <= last)
        past = first
        do while (past <= last)
          if (owner(panels%s(past)) /= owner(panels%s(first))) exit
          past = past + 1
        end do
        largest = max(largest, int((past - first)*(last - first + 1), c_size_t))
        first = past
      end do
    end do
  end subroutine measure_updates
end module supernode_panels
