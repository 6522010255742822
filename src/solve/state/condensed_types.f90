!> The condensed form of a system: compliances of the bodies at the nodes that contact may touch,
!! and the contact forces there (doc/theory, "Static condensation", eq. (12.3)).
module condensed_types
  use kinds, only: wp, sp
  use gcr, only: gcr_t
  use cholmod_solver, only: cholmod_t
  use rigid_motions, only: motions_t
  implicit none
  private
  public :: condensed_t, condensed_body_t, near_compliance_t, contact_tangent_t, contact_block_t, &
    columns_t, defects_t, carried_t, center_t, influence_t, linear_sums_t, &
    body_sums_t, seen_t, near_field_t, tree_t
  public :: turns_not, turns_freely

  !> What the mean rotation of a body may be: none, any, or one about axis 1, 2 or 3.
  integer, parameter :: turns_not = -1, turns_freely = 0

  !> Compliances in single precision between one patch of candidates and another.
  type :: patch_block_t
    real(sp), allocatable :: c(:, :) !! (first, second) [length/force]
  end type patch_block_t

  !> The patches that are near one, from among those before it, and itself, the last.
  type :: patch_pair_t
    integer, allocatable :: partner(:) !! their numbers, ascending
    type(patch_block_t), allocatable :: c(:) !! for each
  end type patch_pair_t

  !> Patches of candidates side by side, and the compliance between those that are near each other.
  type :: near_field_t
    integer, allocatable :: start(:) !! (patches+1) where each begins in member
    integer, allocatable :: member(:) !! (m) candidates patch by patch
    integer, allocatable :: patch(:), at(:) !! (m) patch of each candidate, and its place there
    type(patch_pair_t), allocatable :: pairs(:) !! (patches)
  end type near_field_t

  !> A body whose candidates are eliminated among its other nodes: products with their compliance
  !! are solves with the factor.
  type :: tree_t
    logical :: used = .false. !! they are
    logical, allocatable :: reached(:) !! (supernodes) on the way of a candidate up the tree
    real(sp), allocatable :: values(:) !! the factor in single precision, times root
    real(wp) :: root = 1.0_wp !! [(length/force)^1/2]
    type(near_field_t) :: near !! compliance between candidates that are near each other
  end type tree_t

  !> The compliance of a body in single precision; for blocks of contact C = C' + R X^T + X R^T
  !! without what its rigid motions R carry.
  type :: near_compliance_t
    real(sp), allocatable :: c(:, :) !! (n_live, n_live) C' in the unit of its softness
    real(wp), allocatable :: modes(:, :) !! (n_live, motions) R
    real(wp), allocatable :: carried(:, :) !! (n_live, motions) X
  end type near_compliance_t

  !> One body: its factor, and its compliance at the candidates.
  type :: condensed_body_t
    type(cholmod_t) :: solver !! its factor, kept
    integer, allocatable :: node(:), direction(:) !! (n) where each equation of it belongs, in the
    !! order of elimination, the candidates last
    integer :: first = 0 !! candidates of the bodies before
    integer :: m = 0 !! its candidates
    integer, allocatable :: equation(:) !! (m) equation of each candidate
    real(wp), pointer, contiguous :: compliance(:, :) => null() !! (m, m) at the candidates
    !! [length/force]; its lower triangle counts
    real(wp), pointer, contiguous :: trailing(:, :) => null() !! (m, m) L22 of a factor in single
    !! precision, until its product has become the compliance
    real(wp), allocatable :: diagonal(:) !! (m) compliance of each candidate itself [length/force]
    type(tree_t) :: tree !! in place of compliance, where that would cost more
    logical :: mirrored = .false. !! its upper triangle counts as well
    integer :: first_live = 0, n_live = 0 !! live candidates of the bodies before, and its own
    integer, allocatable :: gathered(:) !! (n_live) its candidates that live belongs to
    real(wp), pointer, contiguous :: live(:, :) => null() !! (rows, n_live) columns of these, whose
    !! rows begin after those skipped [length/force]: gathered, or columns of compliance itself
    integer :: skipped = 0 !! rows of live before those of the live candidates
    logical :: copied = .false. !! it has been gathered
    type(motions_t) :: motions !! rigid motions that its supports leave
    integer :: first_mode = 0 !! motions of the bodies before
    integer, allocatable :: fixing_node(:), fixing_direction(:) !! (motions) where springs stop them
    real(wp), allocatable :: modes(:, :) !! (m, motions) what they do to the candidates
    real(wp), allocatable :: ways(:, :, :) !! (3, nodes, motions) Y, the same with what springs do
    !! to the body then, if springs resist some
    real(wp) :: softness = 1.0_wp !! mean compliance of its candidates [length/force]
    integer :: turns_about = turns_not !! what its mean rotation may be, where it is followed
    real(wp), allocatable :: turned_then(:, :) !! (3, 3) its mean rotation when it was factorised
    real(wp), allocatable :: turn(:, :) !! (3, 3) from that rotation to that of this iteration
    real(wp), allocatable :: reduced(:) !! (n) a right-hand side that is half solved for
    type(near_compliance_t) :: near !! in single precision
  end type condensed_body_t

  !> Some rows of contact and those around them, with the inverse of their part of the small matrix.
  type :: contact_block_t
    integer, allocatable :: row(:) !! (n) rows
    logical, allocatable :: own(:) !! (n) not of the overlap
    real(sp), allocatable :: inverse(:, :) !! (n, own) rows of the inverse of I + V^T C' U of these
    integer, allocatable :: mode(:) !! rigid motions that show in these rows
    real(wp), allocatable :: raised(:, :) !! (own, mode) what the block answers to each
  end type contact_block_t

  !> A sparse matrix on the live candidates, by columns.
  type :: columns_t
    integer :: n = 0 !! columns
    integer, allocatable :: column(:) !! (n) live candidate that each belongs to
    integer, allocatable :: start(:) !! (n+1) where each begins
    integer, allocatable :: row(:) !! live candidate of each entry
    real(wp), allocatable :: value(:) !! entries
  end type columns_t

  !> Overlapping blocks of rows where the small matrix is large.
  type :: contact_parts_t
    integer :: most_dense = 1000 !! rows of a small matrix that is factorised as a whole, at most
    logical :: iterated = .false. !! blocks stand in for the small matrix
    logical :: dense = .false. !! blocks have not led to an answer: the small matrix is to be formed
    logical :: grouped = .false. !! rows are those of groups of points
    type(contact_block_t), allocatable :: blocks(:) !! overlapping blocks of the rows
    real(wp), allocatable :: weight(:) !! (rank) force of a residual [force/length]
    real(wp), allocatable :: border(:, :) !! (modes, modes) what is left for them, factorised
    integer, allocatable :: border_pivot(:) !! (modes) of its factor
  end type contact_parts_t

  !> Answers of the rest of the element matrices.
  type :: rest_course_t
    integer :: iterations = 0 !! that the last answer of contact has taken, by factor or by blocks
    type(gcr_t) :: known !! answers of the rest since its matrix was formed: a way is the force on
    !! the rest (live), the displacements it becomes (live), the shares of the columns (rank+modes)
  end type rest_course_t

  !> The tangent of contact as a sum of element matrices, and its leading part U V^T.
  type :: contact_tangent_t
    integer :: elements = 0 !! closed contact elements
    logical :: whole = .false. !! U are columns of the sum of the element matrices, V takes them
    logical :: complete = .false. !! these are all columns of the sum
    logical :: fresh = .false. !! the factor is that of the present element matrices
    integer :: rank = 0 !! columns of U and V
    integer :: modes = 0 !! rigid motions that are unknowns beside them
    integer, allocatable :: element(:) !! (elements) place in the list of contact elements
    integer, allocatable :: dofs(:, :) !! (dofs of an element, list) live candidates, 0 for none
    real(wp), allocatable :: s(:, :, :) !! (dofs, dofs, list) element matrices, their rest
    integer :: resting = 0 !! elements with a rest, in element
    integer, allocatable :: owner(:) !! (rank) place in the list of each column's element
    integer, allocatable :: status(:) !! (list) when it was factorised; none if it cannot serve
    real(wp), allocatable :: u(:, :), v(:, :) !! (dofs, rank) columns
    type(columns_t) :: sum !! sum of the element matrices that are factorised [force/length]
    type(columns_t) :: now !! that of the present ones, where these are others
    type(columns_t) :: lead !! (rank) U of the whole form, and of blocks
    type(columns_t) :: taken !! (rank) V of blocks
    integer, allocatable :: held(:, :) !! (3, rank) live candidates of V there, 0 for none
    real(wp), allocatable :: hold(:, :) !! (3, rank) V there
    real(wp), allocatable :: cu(:, :) !! (live, rank+modes) C U, and -R; not in the whole form
    real(wp), allocatable :: small(:, :) !! (rank+modes, rank+modes) I + V^T C U, bordered by the
    !! rigid motions, factorised
    integer, allocatable :: pivot(:) !! (rank+modes) of its factor
    type(contact_parts_t) :: parts !! blocks, where it is large
    type(rest_course_t) :: course !! answers of the rest
  end type contact_tangent_t

  !> When the displacements of all nodes were known last.
  type :: seen_t
    real(wp), allocatable :: factors(:) !! (loads) factors of the loads then
    real(wp), allocatable :: u(:, :) !! (3, nodes) these displacements [length]
    real(wp), allocatable :: carried(:, :) !! (3, nodes) rigid ways of the bodies since [length]
  end type seen_t

  !> What the loads do to the bodies without contact.
  type :: influence_t
    real(wp), allocatable :: factors(:) !! (loads) their factors at the end of the increment
    real(wp), allocatable :: influence(:, :, :) !! (3, nodes, loads) u of unit loads [length]
    real(wp), allocatable :: kept(:, :) !! (3, nodes) contact forces of the last state [force]
    logical :: foretold = .false. !! they are those that are expected at the end of the increment
    real(wp), allocatable :: smooth(:, :) !! (3, nodes) those that are expected before friction acts
    !! at points that touch first, if it waits [force]
    real(wp), allocatable :: rubbed(:, :) !! (3, nodes) those that are expected once it does [force]
    real(wp), allocatable :: touching(:, :) !! (3, nodes) those that the increment had before; not
    !! allocated if no point has touched first [force]
    real(wp), allocatable :: loaded(:) !! (n) displacement without contact [length]
    real(wp), allocatable :: pushes(:, :) !! (modes, loads) work of unit loads on them [force]
    type(seen_t) :: seen !! where all nodes were last
  end type influence_t

  !> What acts on a body and what it does to sums over supports and loads (sum_shares).
  type :: body_sums_t
    real(wp), allocatable :: by_load(:, :) !! (sums, loads) what a unit of a load does to each
    real(wp), allocatable :: by_force(:, :) !! (m, sums) what a unit of a contact force does
  end type body_sums_t

  !> Sums over supports and loads that are linear in the contact forces (linear_sums).
  type :: linear_sums_t
    logical :: known = .false. !! by_load is that of all bodies
    real(wp), allocatable :: by_load(:, :) !! (sums, loads) what a unit of a load does to each
    type(body_sums_t), allocatable :: bodies(:) !! what each body has to do with it
    real(wp), allocatable :: center(:, :) !! (3, bodies) where turns are measured about [length]
    real(wp), allocatable :: value(:) !! (sums) of the converged state, without displacements inside
  end type linear_sums_t

  !> The rigid motions of the iterate that supports leave to the bodies.
  type :: carried_t
    integer :: modes = 0 !! rigid motions of all bodies
    real(wp), allocatable :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), allocatable :: alpha(:) !! (modes) rigid motion of the iterate [length]
    real(wp), allocatable :: alpha_change(:) !! (modes) its direction [length]
    real(wp), allocatable :: alpha_next(:) !! (modes) that of the last answer of contact [length]
    real(wp), allocatable :: imbalance(:) !! (modes) contact forces less loads on them [force]
    real(wp), allocatable :: imbalance_change(:) !! (modes) its direction [force]
    real(wp), allocatable :: hold(:, :) !! (modes, modes) what holds them in the tangent alone,
    !! times the compliance of their bodies
    real(wp), allocatable :: spring(:, :) !! (modes, modes) what resists them beside multipliers:
    !! springs to ground and stress, eq. (7.21) [force/length]
    real(wp), allocatable :: loose(:, :) !! (modes, any) what contact leaves free while regularised
    real(wp) :: damping = 0.0_wp !! on them [force/length]
    real(wp), allocatable :: center(:) !! (modes) where it is measured from [length]
  end type carried_t

  !> The unknowns of rigid bodies with a point as a border of contact's tangent, and what contact
  !! and bodies answer to each.
  type :: point_border_t
    integer :: n = 0 !! unknowns
    logical :: known = .false. !! the answers are those of the present tangent
    real(wp), allocatable :: columns(:, :) !! (live, n) forces of contact by each [force/length]
    real(wp), allocatable :: rows(:, :) !! (live, n) what displacements do to each [force/length]
    real(wp), allocatable :: corner(:, :) !! (n, n) what they do to each other [force/length]
    real(wp), allocatable :: force(:, :) !! (live, n) forces that each becomes [force/length]
    real(wp), allocatable :: way(:, :) !! (live, n) displacements that it becomes
    real(wp), allocatable :: motion(:, :) !! (modes, n) rigid motions that it becomes
    real(wp), allocatable :: factor(:, :) !! (n, n) what is left of the corner, factorised
    integer, allocatable :: pivot(:) !! (n) of it
    real(wp), allocatable :: asked(:) !! (n) residual that the next answer is to [force]
    real(wp), allocatable :: change(:) !! (n) the last answer [length]
  end type point_border_t

  !> The candidates that elements or forces touch at present, and the unknowns there.
  type :: live_t
    integer :: n_live = 0 !! candidates that elements or forces touch at present
    integer, allocatable :: live(:) !! (n_live) candidate
    integer, allocatable :: live_place(:) !! (n) place in live, 0 for none
    real(wp), allocatable :: right(:) !! (n_live) residual [force]
    real(wp), allocatable :: change(:) !! (n_live) direction [length]
    real(wp), allocatable :: pushed(:) !! (n_live) residual that was multiplied last [force]
    real(wp), allocatable :: product(:) !! (n_live) C times that one [length]
  end type live_t

  !> The contact forces that the bulk bears, and by how much the iterate is off.
  type :: defects_t
    real(wp), allocatable :: force(:) !! (n) contact force that the bulk bears [force]
    real(wp), allocatable :: product(:) !! (n) compliance times the forces product_of [length]
    real(wp), allocatable :: product_of(:) !! (n) the forces it was computed for last [force]
    real(wp), allocatable :: force_change(:) !! (n) its direction in the iteration [force]
    real(wp), allocatable :: defect(:) !! (n) loaded - C force - u [length]
    real(wp) :: defect_norm = 0.0_wp !! the same as forces [force]
    real(wp) :: defect_share = 1.0_wp !! what the trial leaves of it
  end type defects_t

  !> Where a step of pseudo-time began.
  type :: center_t
    type(carried_t) :: rigid !! rigid motions there
    type(defects_t) :: bulk !! forces that the bulk bears there
  end type center_t

  !> All bodies with contact, the loads' influence, and the contact forces of the iterate.
  type :: condensed_t
    logical :: active = .false. !! this form is in use
    logical :: preconditions = .false. !! the bulk is not linear: the factors stand in for it
    logical :: exact = .false. !! factors answer by themselves: in double precision
    real(wp) :: aging = 0.0_wp !! passes that older factors have cost so far: beyond `aged` new
    !! ones are made
    real(wp), allocatable :: made_at(:, :) !! (3, nodes) displacements that they were made at; not
    !! allocated if at rest [length]
    integer :: refusals = 0 !! tangents in a row that were not positive definite
    real(wp) :: aged = 0.0_wp !! passes that are worth new factors
    logical :: surface_only = .false. !! only candidates are asked for at the end of an increment
    logical :: narrow = .false. !! the live candidates are few, though their compliance is copied
    type(condensed_body_t), allocatable :: bodies(:) !! bodies with free degrees of freedom
    logical, allocatable :: candidate(:) !! (nodes) nodes that contact may touch
    integer :: n = 0 !! candidate degrees of freedom
    integer, allocatable :: place(:, :) !! (3, nodes) candidate number, 0 for none
    integer, allocatable :: node(:), direction(:) !! (n) where each candidate belongs
    integer, allocatable :: facets(:, :) !! (3, facets) master facets of all pairs
    type(contact_tangent_t) :: tangent !! of the iteration
    real(wp) :: norm_before = 0.0_wp !! residual norm one iteration before, 0 at a start [force]
    integer :: failed = 0 !! outcome of the last extension
    type(influence_t) :: outer !! the loads' influence
    type(carried_t) :: rigid !! rigid motions
    type(point_border_t) :: points !! unknowns of rigid bodies with a point
    type(live_t) :: alive !! live candidates
    type(defects_t) :: bulk !! forces that the bulk bears
    type(linear_sums_t) :: sums !! over supports and loads
    logical :: goes_on = .false. !! no state has been saved since the increment before: its factor
    !! may serve again
  end type condensed_t
end module condensed_types
