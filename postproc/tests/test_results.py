"""The reader of results files, ours and VTK's."""
import os

import fakes
import numpy as np
import pytest
from mfec_post import Results


@pytest.fixture
def results(run):
    with Results(os.path.splitext(run)[0] + '.vtkhdf') as file:
        yield file


def test_fields_belong_to_their_end_time(results):
    assert results.steps == 8
    np.testing.assert_allclose(results.times, np.arange(1, 9) / 4)
    np.testing.assert_allclose(results.point_field('displacement', 4)[0], [0.3, 0, -0.01])
    assert results.cell_field('stress').shape == (len(results.cells), 6)


def test_a_set_moves_as_its_nodes_do(results):
    u = results.set_displacement('top')
    np.testing.assert_allclose(u, [fakes.displacement(k) for k in range(1, 9)], atol=1e-12)


def test_contact_points_of_a_pair(results):
    assert results.pairs == {'skid': '1'}
    points = results.contact('skid', 0)
    assert points['node'].shape == points['weight'].shape == (25, 1)
    assert np.all(points['weight'] == 1)
    np.testing.assert_allclose(points['traction'][:, 2].sum(), 25.0)
    assert set(points['status']) == {1}


def test_tables_end_at_their_last_whole_row(results):
    table = results.history('reactions')
    assert len(table['set']) == len(table['step']) == 8
    assert table['set'][0] == 'top'


def test_a_file_is_found_by_either_name(run):
    base = os.path.splitext(run)[0]
    with Results(base + '.h5') as file:
        assert file.path == base + '.vtkhdf'
    os.rename(base + '.vtkhdf', base + '.h5')
    with Results(base + '.vtkhdf') as file:
        assert file.path == base + '.h5' and file.steps == 8


def test_what_is_not_there_is_said_with_what_is(results):
    with pytest.raises(KeyError, match='displacement'):
        results.point_field('temperature')
    with pytest.raises(KeyError, match='top'):
        results.set_nodes('bottom')
    with pytest.raises(IndexError, match='8 output times'):
        results.point_field('displacement', 8)
    assert results.text('title') == 'a cube'


def test_vtk_reads_all_end_times(results):
    reader_module = pytest.importorskip('vtkmodules.vtkIOHDF')
    from vtkmodules.util.numpy_support import vtk_to_numpy
    reader = reader_module.vtkHDFReader()
    reader.SetFileName(results.path)
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == results.steps
    for frame in range(results.steps):
        reader.SetStep(frame)
        reader.Update()
        data = reader.GetOutput()
        assert data.GetNumberOfCells() == len(results.cells)
        np.testing.assert_array_equal(
            vtk_to_numpy(data.GetPointData().GetArray('displacement')),
            results.point_field('displacement', frame))
        np.testing.assert_array_equal(vtk_to_numpy(data.GetCellData().GetArray('stress')),
                                      results.cell_field('stress', frame))
