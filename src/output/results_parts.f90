!> /run/surfaces and /run/materials: the parts of a model by their names, for what estimates its
!! error or makes it another mesh (mfec-post adapt).
module results_parts
  use kinds, only: wp
  use errors, only: error_t
  use model_types, only: model_t
  use bulk_laws, only: laws
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: write_parts

  !> Longest label that is written.
  integer, parameter :: label_length = 31

contains

  !> Writes facets of surfaces, and materials with their labels.
  subroutine write_parts(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file, with /run
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    call make_group(file, '/run/surfaces', error)
    do i = 1, size(model%mesh%surfaces)
      if (allocated(error)) return
      associate (surface => model%mesh%surfaces(i))
        if (size(surface%facets, 2) == 0) cycle
        call make_series(file, '/run/surfaces/'//surface%name, stored_integer, [3], &
          size(surface%facets, 2), '1', &
          'corner nodes of the facets, counter-clockwise seen from outside', error)
        if (allocated(error)) return
        call write_block(file, '/run/surfaces/'//surface%name, surface%facets, at_end, error)
      end associate
    end do
    if (.not. allocated(error)) call write_materials(file, model, error)
  end subroutine write_parts

  !> One row and one label for each material.
  subroutine write_materials(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(label_length), allocatable :: labels(:)
    real(wp), allocatable :: rows(:, :)
    integer :: m

    allocate (labels(size(model%materials)), rows(5, size(model%materials)))
    do m = 1, size(labels)
      associate (material => model%materials(m))
        labels(m) = material%label
        rows(:, m) = [real(material%number, wp), material%youngs_modulus, &
          material%poissons_ratio, merge(1.0_wp, 0.0_wp, laws(material%law)%finite), &
          merge(1.0_wp, 0.0_wp, material%rigid)]
      end associate
    end do
    call make_series(file, '/run/materials', stored_real, [5], max(1, size(labels)), '1', &
      'number, Young''s modulus, Poisson''s ratio, 1 for finite strain, 1 for a rigid one', error)
    if (.not. allocated(error)) call make_text_series(file, '/run/material_labels', label_length, &
      'labels of the materials', error)
    if (allocated(error) .or. size(labels) == 0) return
    call write_block(file, '/run/materials', rows, at_end, error)
    if (.not. allocated(error)) call write_block(file, '/run/material_labels', labels, at_end, &
      error)
  end subroutine write_materials
end module results_parts
