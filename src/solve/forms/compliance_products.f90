!> Products of the compliance of condensed bodies with the forces of contact (doc/theory, "Static
!! condensation").
module compliance_products
  use kinds, only: wp
  use threads, only: pays_threads
  use lapack_interface, only: dsymv, dgelss
  use costs, only: cost_t, add_costs
  use condensed_types, only: condensed_t, condensed_body_t
  use condensed_motions, only: add_motion
  use condensation, only: spread_body, push_body
  use tree_compliance, only: apply_tree
  use inside_refinement, only: settle_inside
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: find_equilibrium, fit_motions, spread_product

  !> Entries of a factor for each of its rows, at least, where bodies are large.
  real(wp), parameter :: least_row = 100.0_wp

contains

  !> Displacements of all candidates in equilibrium with the forces of the iterate.
  subroutine find_equilibrium(condensed, u)
    type(condensed_t), intent(inout) :: condensed !! loaded and force given
    real(wp), intent(out) :: u(:) !! (n) [length]

    call find_product(condensed)
    u = condensed%outer%loaded - condensed%bulk%product
    call add_motion(condensed, condensed%rigid%alpha, u)
  end subroutine find_equilibrium

  !> The rigid motions with which the equilibrium under the forces of the iterate comes closest to
  !! given displacements.
  subroutine fit_motions(condensed, u)
    type(condensed_t), intent(inout) :: condensed !! loaded and force given; gets alpha
    real(wp), intent(in) :: u(:) !! (n) displacements of the candidates [length]
    real(wp) :: normal(6, 6), right(6, 1), values(6), work(200)
    integer :: b, rank, info

    if (condensed%rigid%modes == 0) return
    call find_product(condensed)
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n)
        if (n == 0 .or. body%m == 0) cycle
        associate (first => body%first + 1, last => body%first + body%m)
          right(:n, 1) = matmul(u(first:last) - condensed%outer%loaded(first:last) &
            + condensed%bulk%product(first:last), body%modes)
        end associate
        normal(:n, :n) = matmul(transpose(body%modes), body%modes)
        call dgelss(n, n, 1, normal, 6, right, 6, values, 1.0e-12_wp, rank, work, size(work), info)
        condensed%rigid%alpha(body%first_mode + 1:body%first_mode + n) = right(:n, 1)
      end associate
    end do
  end subroutine fit_motions

  !> C times the forces of the iterate, unless they are those of the last time.
  subroutine find_product(condensed)
    type(condensed_t), intent(inout) :: condensed !! force given; gets product
    integer :: b
    logical :: pays

    if (allocated(condensed%bulk%product_of)) then
      if (all(abs(condensed%bulk%force - condensed%bulk%product_of) <= 0.0_wp)) return
    end if
    condensed%bulk%product = spread(0.0_wp, 1, condensed%n)
    pays = pays_threads(sum(real(condensed%bodies%m, wp)**2))
    !$omp parallel do schedule(dynamic, 1) default(none) shared(condensed) if(pays)
    do b = 1, size(condensed%bodies)
      if (condensed%bodies(b)%m > 0) call add_product(condensed%bodies(b), condensed%bulk%force, &
        condensed%bulk%product)
    end do
    !$omp end parallel do
    condensed%bulk%product_of = condensed%bulk%force
  end subroutine find_product

  !> C times the forces on the candidates of one body.
  subroutine add_product(body, force, product)
    type(condensed_body_t), intent(in) :: body !! its compliance
    real(wp), intent(in) :: force(:) !! (n) of all candidates [force]
    real(wp), intent(inout) :: product(:) !! (n) gets those of the body [length]
    integer :: i

    associate (mine => force(body%first + 1:body%first + body%m), &
      moved => product(body%first + 1:body%first + body%m))
      if (body%tree%used) then
        call apply_tree(body, [(i, i=1, body%m)], mine, moved)
      else
        call dsymv('L', body%m, 1.0_wp, body%compliance, body%m, mine, 1, 0.0_wp, moved, 1)
      end if
    end associate
  end subroutine add_product

  !> Displacements of all nodes under the contact forces of the iterate alone.
  subroutine spread_product(system, form, u)
    type(system_t), intent(in) :: system !! bodies and force of condensed
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    real(wp), intent(out) :: u(:, :) !! (3, nodes) [length]
    type(cost_t) :: own(system%body%bodies)
    integer :: b
    logical :: pays

    u = 0.0_wp
    call find_product(form%condensed)
    pays = pays_threads(least_row*real(size(u), wp))
    !$omp parallel do schedule(dynamic, 1) default(none) shared(system, form, u, own) if(pays)
    do b = 1, system%body%bodies
      call spread_product_of(form, b, u, own(b))
    end do
    !$omp end parallel do
    do b = 1, system%body%bodies
      call add_costs(form%costs, own(b))
    end do
  end subroutine spread_product

  !> The same for one body.
  subroutine spread_product_of(form, b, u, costs)
    type(form_t), intent(in) :: form !! bodies and products of condensed
    integer, intent(in) :: b !! the body
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) gets those of the body [length]
    type(cost_t), intent(inout) :: costs !! cost table

    associate (body => form%condensed%bodies(b))
      if (.not. allocated(body%node)) return
      if (body%tree%used) then
        call push_body(body, -form%condensed%bulk%force(body%first + 1:body%first + body%m), u, &
          costs)
        return
      end if
      call spread_body(body, -form%condensed%bulk%product(body%first + 1:body%first + body%m), &
        u, costs)
      if (body%solver%half_inside) call settle_inside(form%whole%bulk_matrix, body, u, costs)
    end associate
  end subroutine spread_product_of
end module compliance_products
