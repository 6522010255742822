!> What a parameter of the deck changes: the deck is read again with values next to its own
!! (doc/theory, "Parameters of the input", eq. (14.8)).
module parameter_slopes
  use kinds, only: wp, pi
  use errors, only: error_t
  use deck_types, only: deck_t, override_t, location_t
  use diagnostics, only: diagnostics_t, report_error
  use facets, only: facet_table_t
  use model_types, only: model_t, load_t, nodal_values_t
  use loads, only: join_load, add_values, add_displacement, add_force
  use deck_variants, only: variant_t, difference_t, read_next_variant, set_value, place_other, &
    place_mesh
  use sensitivity_types, only: sensitivity_t, slope_t, new_slope, add_slope
  implicit none
  private
  public :: reading_t, read_parameter

  !> Share by which a parameter is changed to see what it goes into, and the same for one that is 0.
  real(wp), parameter :: parameter_change = 2.0_wp**(-10), change_of_zero = 2.0_wp**(-10)
  !> The changes, in units of that, and the weights of a derivative of fourth order.
  integer, parameter :: changes(4) = [1, -1, 2, -2]
  real(wp), parameter :: weights(4) = [8.0_wp, -8.0_wp, -1.0_wp, 1.0_wp]/12.0_wp
  !> A second difference that grows less than this with twice the change comes from a kink.
  real(wp), parameter :: kinked = 3.0_wp, hardly_changed = 1.0e-9_wp
  !> What round-off leaves of a difference of equal values.
  real(wp), parameter :: difference_noise = 1.0e-14_wp

  !> How the deck has been read.
  type :: reading_t
    character(:), allocatable :: path !! the deck
    type(override_t), allocatable :: overrides(:) !! parameters that the command line sets
    type(facet_table_t) :: exterior !! exterior facets of its mesh
    logical :: names_only = .false. !! the deck has errors: nothing but names can be looked up
  end type reading_t

contains

  !> A parameter of the deck: the deck is read again with values next to its own, and what differs
  !! then is its slope.
  subroutine read_parameter(deck, name, value, at, reading, diagnostics, model, s)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: name !! the parameter
    real(wp), intent(in) :: value !! its value
    type(location_t), intent(in) :: at !! where the derivative is asked for
    type(reading_t), intent(in) :: reading !! how the deck was read
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(variant_t) :: variants(size(changes))
    type(override_t), allocatable :: overrides(:)
    type(error_t), allocatable :: error
    type(difference_t) :: difference
    real(wp) :: h
    integer :: v

    h = parameter_change*abs(value)
    if (.not. h > 0.0_wp) h = change_of_zero
    do v = 1, size(changes)
      overrides = reading%overrides
      call set_value(overrides, name, value + real(changes(v), wp)*h)
      call read_next_variant(reading%path, overrides, deck, model, reading%exterior, &
        variants(v), difference, error)
      if (allocated(error) .and. difference%worst /= place_other) then
        call report_error(diagnostics, at, 'the deck cannot be read with a '''//name// &
          ''' next to its value', 'choose a value that is not at the end of what is allowed')
        return
      end if
      if (difference%worst /= place_other) then
        if (differs(model, variants(v)%model)) difference = difference_t(place_mesh, at)
      end if
      if (difference%worst >= place_other) then
        call report_error(diagnostics, difference%at, 'the parameter '''//name// &
          ''' goes in here, and derivatives know only those of friction, angle of the lay, '// &
          'penalty, Young''s modulus, prescribed values, forces and proportional loads', &
          'leave '''//name// &
          ''' out of SENSitivity and --sens, or take differences of two runs with --set')
        return
      end if
    end do
    call take_differences(name, at, h, variants, diagnostics, model, s)
  end subroutine read_parameter

  !> Two readings differ in what derivatives do not know.
  logical function differs(a, b)
    type(model_t), intent(in) :: a !! one reading
    type(model_t), intent(in) :: b !! another one
    integer :: k

    differs = a%mesh%nodes /= b%mesh%nodes .or. size(a%pairs) /= size(b%pairs) &
      .or. size(a%tables) /= size(b%tables)
    if (differs) return
    differs = any(abs(a%mesh%x - b%mesh%x) > 0.0_wp) &
      .or. any(a%conditions%restrained .neqv. b%conditions%restrained)
    do k = 1, size(a%pairs)
      differs = differs .or. size(a%pairs(k)%points%epsilon) /= size(b%pairs(k)%points%epsilon)
    end do
  end function differs

  !> The slope of a parameter from four readings.
  subroutine take_differences(name, at, h, variants, diagnostics, model, s)
    character(*), intent(in) :: name !! the parameter
    type(location_t), intent(in) :: at !! where the derivative is asked for
    real(wp), intent(in) :: h !! its change
    type(variant_t), intent(in) :: variants(:) !! the readings
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(slope_t) :: slope
    integer :: v, k, m
    logical :: kink

    slope = new_slope(name, model)
    slope%at = at
    kink = .false.
    do k = 1, size(model%pairs)
      do m = 1, 2
        slope%mu(m, k) = slope_of([(variants(v)%model%pairs(k)%friction%mu(m), v=1, 4)], &
          model%pairs(k)%friction%mu(m))
      end do
      slope%angle(k) = pi/180.0_wp*slope_of([(variants(v)%model%pairs(k)%friction%angle, v=1, 4)], &
        model%pairs(k)%friction%angle)
      associate (epsilon => model%pairs(k)%points%epsilon)
        if (size(epsilon) > 0 .and. .not. model%pairs(k)%segmented) slope%penalty(k) = &
          slope_of([(variants(v)%model%pairs(k)%points%epsilon(1), v=1, 4)], epsilon(1))/epsilon(1)
      end associate
    end do
    do m = 1, size(model%materials)
      if (model%materials(m)%rigid) cycle
      slope%modulus(m) = slope_of([(variants(v)%model%materials(m)%youngs_modulus, v=1, 4)], &
        model%materials(m)%youngs_modulus)/model%materials(m)%youngs_modulus
    end do
    call change_of_loads(h, variants, model, slope)
    deallocate (slope%variants)
    allocate (slope%variants(size(variants)))
    do v = 1, size(variants)
      slope%variants(v)%tables = variants(v)%model%tables
      slope%variants(v)%weight = weights(v)/h
    end do
    if (kink) then
      call report_error(diagnostics, at, 'what the deck makes of '''//name//''' has a kink at '// &
        'its value (min, max or abs)', 'choose a value on one side of it')
      return
    end if
    call add_slope(slope, s)

  contains

    !> The derivative of a value of the deck; finds out whether it has a kink there.
    real(wp) function slope_of(values, middle) result(change)
      real(wp), intent(in) :: values(4) !! at the four changes
      real(wp), intent(in) :: middle !! without a change
      real(wp) :: near, far

      change = sum(weights*values)/h
      if (all(abs(values - middle) <= 0.0_wp)) change = 0.0_wp
      near = abs(values(1) - 2.0_wp*middle + values(2))
      far = abs(values(3) - 2.0_wp*middle + values(4))
      if (far > hardly_changed*maxval(abs(values)) .and. far < kinked*near) kink = .true.
    end function slope_of
  end subroutine take_differences

  !> Differences of prescribed values and forces, load by load.
  subroutine change_of_loads(h, variants, model, slope)
    real(wp), intent(in) :: h !! change of the parameter
    type(variant_t), intent(in) :: variants(:) !! the readings
    type(model_t), intent(in) :: model !! the problem
    type(slope_t), intent(inout) :: slope !! gets loads
    type(load_t), allocatable :: loads(:)
    real(wp) :: displacement(3, model%mesh%nodes), force(3, model%mesh%nodes), size_of(2)
    integer :: k, v, place, node

    allocate (loads(0))
    do v = 1, size(variants)
      associate (more => variants(v)%model%conditions%loads)
        do k = 1, size(more)
          call join_load(loads, more(k)%table, place)
        end do
      end associate
    end do
    do k = 1, size(loads)
      displacement = 0.0_wp
      force = 0.0_wp
      size_of = 0.0_wp
      do v = 1, size(variants)
        associate (more => variants(v)%model%conditions%loads)
          do place = 1, size(more)
            if (more(place)%table /= loads(k)%table) cycle
            call add_displacement(more(place), weights(v)/h, displacement)
            call add_force(more(place), weights(v)/h, force)
            size_of = max(size_of, [largest(more(place)%displacement), largest(more(place)%force)])
          end do
        end associate
      end do
      where (abs(displacement)*h <= difference_noise*size_of(1)) displacement = 0.0_wp
      where (abs(force)*h <= difference_noise*size_of(2)) force = 0.0_wp
      do node = 1, model%mesh%nodes
        call add_values(loads(k)%displacement, node, displacement(:, node))
        call add_values(loads(k)%force, node, force(:, node))
      end do
    end do
    slope%loads = loads
  end subroutine change_of_loads

  !> Largest of some values.
  pure real(wp) function largest(values)
    type(nodal_values_t), intent(in) :: values !! the values

    largest = 0.0_wp
    if (values%n > 0) largest = maxval(abs(values%value(:values%n)))
  end function largest
end module parameter_slopes
