"""Figures are drawn, and what they show is what the files hold."""
import os
import stat

import fakes
import h5py
import numpy as np
import pytest
from mfec_post import cube, demo, lay, reactions
from mfec_post.results import Results
from mfec_post.tables import TableError


def test_a_curve_joins_table_and_displacement(run):
    curve = reactions.Curve(run)
    assert curve.name == 'mfec_45'
    np.testing.assert_allclose(curve.displacement, 0.1 * np.maximum(np.arange(1, 9) - 2, 0),
                               atol=1e-12)
    np.testing.assert_allclose(curve.ratio[3:], 0.09)
    assert np.all(curve.normal > 0)


def test_no_normal_force_gives_no_ratio(run):
    curve = reactions.Curve(run)
    curve.normal = np.zeros_like(curve.normal)
    assert np.all(np.isnan(curve.ratio))


def test_reactions_are_drawn(run, tmp_path, capsys):
    picture = str(tmp_path / 'r.png')
    assert reactions.main([run, '--out', picture, '--length', 'mm', '--force', 'N']) == 0
    assert os.path.getsize(picture) > 10000
    assert capsys.readouterr().out.strip() == picture
    assert reactions.main([run, '--set', 'nowhere', '--out', picture]) == 2


def test_exterior_facets_close_a_box():
    points, cells = fakes.block([0, 0, 0], [1, 2, 3], [2, 3, 2])
    faces, owner = cube.exterior_facets(cells[:, [1, 0, 2, 3]], points)
    assert len(faces) == 2 * 2 * (2 * 3 + 3 * 2 + 2 * 2)
    a, b, c = points[faces].transpose(1, 0, 2)
    area = np.cross(b - a, c - a) / 2
    np.testing.assert_allclose(area.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.einsum('ij,ij->', area, a) / 3, 6.0)
    assert owner.max() < len(cells)


def test_equivalent_stress_of_uniaxial_tension_and_shear():
    stress = np.array([[5.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0], [3.0, 3.0, 3.0, 0, 0, 0]])
    np.testing.assert_allclose(cube.mises(stress), [5.0, 2.0 * np.sqrt(3.0), 0.0])


@pytest.mark.parametrize('field', ['mises', 'pressure', 'displacement', 'zz'])
def test_the_cube_is_drawn(run, tmp_path, field):
    picture = str(tmp_path / 'c.png')
    assert cube.main([run[:-4] + '.vtkhdf', '--out', picture, '--field', field, '--scale', '2']) == 0
    assert os.path.getsize(picture) > 10000


def test_the_lay_is_drawn(run, tmp_path):
    results, picture = run[:-4] + '.vtkhdf', str(tmp_path / 'l.png')
    assert lay.main([results, '--out', picture]) == 2
    with h5py.File(results, 'a') as file:
        vtk = file['VTKHDF']
        steps, points = int(vtk['Steps'].attrs['NSteps']), len(vtk['Points'])
        vtk['PointData/lay'] = np.tile([1.0, 0, 0], (steps * points, 1))
        vtk['Steps/PointDataOffsets/lay'] = points * np.arange(steps)
    assert lay.main([results, '--out', picture]) == 0
    assert os.path.getsize(picture) > 10000
    assert lay.main([results, '--out', picture, '--pair', 'nowhere']) == 2


def test_friction_is_the_part_of_the_force_along_the_facet(run):
    with Results(run[:-4] + '.vtkhdf') as results:
        surface = lay.Surface(results, 'skid', -1)
    _, force = surface.friction()
    np.testing.assert_allclose(surface.points['traction'][:, 0], force[:, 0])
    np.testing.assert_allclose(force[:, 2], 0, atol=1e-12)


def test_the_view_is_along_the_normal():
    for normal in np.array([[0, 0, 2.0], [3.0, 0, 0], [1.0, -1, 0.5], [0, -1.0, 0]]):
        plane = lay.view(normal)
        np.testing.assert_allclose(plane @ plane.T, np.eye(2), atol=1e-15)
        assert np.cross(*plane) @ normal == pytest.approx(np.linalg.norm(normal))


def test_a_missing_file_gives_two(tmp_path):
    assert cube.main([str(tmp_path / 'none.vtkhdf')]) == 2


def test_closed_form_of_the_ellipse():
    assert demo.closed_form(0.1, 0.08, 0) == pytest.approx(0.1)
    assert demo.closed_form(0.1, 0.08, 45) == pytest.approx(0.088345221, abs=1e-9)
    assert demo.closed_form(0.1, 0.08, 90) == pytest.approx(0.08)


def program(path, text):
    """An executable Python script in place of mfec."""
    path.write_text('#!/usr/bin/env python3\n' + text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_the_demo_runs_five_decks_and_draws(tmp_path, capfd, monkeypatch):
    def run(command, check):
        set_values = dict(item.split('=') for item in command if '=' in item)
        mu = demo.closed_form(*(float(set_values[name]) for name in ('mu1', 'mu2', 'phi')))
        out = command[command.index('--out') + 1]
        fakes.write_run(*os.path.split(out), mu, float(set_values['phi']))
        return type('Done', (), {'returncode': 0})
    monkeypatch.setattr(demo.subprocess, 'run', run)
    assert demo.main(['--deck', 'sliding_cube.inp', '--out', str(tmp_path)]) == 0
    text = capfd.readouterr().out
    assert '0.088345' in text
    for name in ('reactions.png', 'cube.png'):
        assert str(tmp_path / name) in text
        assert os.path.getsize(tmp_path / name) > 10000


def test_the_demo_stops_when_a_run_fails(tmp_path, capfd):
    script = program(tmp_path / 'mfec', 'raise SystemExit(2)\n')
    assert demo.main(['--program', script, '--out', str(tmp_path)]) == 1
    assert 'exit code 2' in capfd.readouterr().err


def test_a_run_without_fields_cannot_be_drawn(tmp_path):
    base = str(tmp_path / 'x')
    fakes.write_tables(base, 0.1)
    fakes.write_results(base, 0.1)
    with h5py.File(base + '.vtkhdf', 'a') as file:
        file['VTKHDF/Steps'].attrs['NSteps'] = 0
    with pytest.raises(TableError, match='no fields'):
        reactions.Curve(base + '.rea')
