"""Figures are drawn, and what they show is what the files hold."""
import os
import stat

import fakes
import h5py
import numpy as np
import pytest
from mfec_post import cube, demo, drawing, geometry, lay, reactions, scene
from mfec_post.results import Results, mises
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
    faces, owner = geometry.exterior_facets(cells[:, [1, 0, 2, 3]], points)
    assert len(faces) == 2 * 2 * (2 * 3 + 3 * 2 + 2 * 2)
    a, b, c = points[faces].transpose(1, 0, 2)
    area = np.cross(b - a, c - a) / 2
    np.testing.assert_allclose(area.sum(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.einsum('ij,ij->', area, a) / 3, 6.0)
    assert owner.max() < len(cells)


def curved_facet():
    """A six-node facet of a paraboloid z = x² + y², and its places."""
    x = np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]], dtype=float)
    return np.column_stack([x, (x ** 2).sum(axis=1)]), np.array([[0, 1, 2]]), np.array([[3, 4, 5]])


def test_curved_facets_are_drawn_curved():
    points, facets, mids = curved_facet()
    places, triangles, parent = geometry.refined(points, facets, mids)
    np.testing.assert_allclose(places[:, 2], (places[:, :2] ** 2).sum(axis=1), atol=1e-14)
    assert len(triangles) == geometry.LEVEL ** 2 and np.all(parent == 0)
    area = 0.5 * geometry.facet_normals(places, triangles)[:, 2]
    assert area.min() > 0 and area.sum() == pytest.approx(0.5)
    field = 1 + points[:, 0] * points[:, 1]
    np.testing.assert_allclose(geometry.refined(field, facets, mids)[0],
                               1 + places[:, 0] * places[:, 1], atol=1e-14)
    net = geometry.edge_lines(points, facets, mids)
    assert net.shape == (3, geometry.LEVEL + 1, 3)
    np.testing.assert_allclose(net[..., 2], (net[..., :2] ** 2).sum(axis=2), atol=1e-14)


def test_mid_nodes_are_those_of_the_edges():
    cell = np.array([[10, 11, 12, 13, 20, 21, 22, 23, 24, 25]])
    facets = np.array([[12, 11, 10], [10, 11, 13], [11, 12, 9]])
    np.testing.assert_array_equal(geometry.mid_nodes(facets, cell),
                                  [[21, 20, 22], [20, 24, 23], [21, -1, -1]])


@pytest.mark.parametrize('rows', [1, 2, 3, 7, 8])
def test_facets_across_a_strip_are_counted(rows):
    """A strip of a sheet of 30 by 12 squares, each cut in two, that lies over `rows` of them."""
    at = np.arange(31 * 13).reshape(13, 31)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    facets = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], 2)  # (12, 30, 2, 3)
    mask = np.zeros((12, 30, 2), dtype=bool)
    mask[2:2 + rows] = True
    flat = facets.reshape(-1, 3)
    assert geometry.facets_across(flat, mask.ravel()) == rows
    narrow = facets[:1].reshape(-1, 3)  # a slice one square wide, pressed over 8: counted along it
    assert geometry.facets_across(narrow, np.repeat(np.abs(np.arange(30) - 14.5) < 4, 2)) == 8
    assert geometry.facets_across(flat, np.ones(len(flat), dtype=bool)) == 12  # the whole of it


def tube(bore):
    """Facets of a tube around z, seen from its axis if it is a bore."""
    turn = np.linspace(0, 2 * np.pi, 25)[:-1]
    ring = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    points = np.concatenate([ring, ring + [0, 0, 2]])
    k = np.arange(24)
    n = (k + 1) % 24
    facets = np.concatenate([np.column_stack([k, n, n + 24]), np.column_stack([k, n + 24, k + 24])])
    return points, facets[:, ::-1] if bore else facets


def test_bores_are_looked_into():
    for bore in (False, True):
        one = scene.Scene(*tube(bore), np.zeros(48), 'x')
        _, one.is_closed = scene.view_of(one, 'master', np.zeros(48))
        assert one.is_closed
        there = scene.facet_normals(one.points, one.facets) @ [1.0, 0.0, 0.0] > 0.0  # pressed towards x
        (azimuth, _), _ = scene.view_of(one, 'master', np.where(there, 1.0, 0.0))
        assert -10 < azimuth < 50
    half = np.arange(24) < 12
    points, facets = tube(True)
    facets = facets[np.tile(half, 2)]  # y > 0, hollow towards -y
    pressed = np.zeros(len(facets))
    for side in ('slave', 'master'):
        (azimuth, _), closed = scene.view_of(scene.Scene(points, facets, np.zeros(48), 'x'), side, pressed)
        assert not closed and -120 < azimuth < -60
    one = scene.Scene(points, facets[:, ::-1], np.zeros(48), 'x')  # a shaft: its slave is of glass
    assert 60 < scene.view_of(one, 'master', pressed)[0][0] < 120
    assert -120 < scene.view_of(one, 'slave', pressed)[0][0] < -60


def test_units_are_written_as_in_print():
    assert scene.Units().label('pressure', 'force/length^2') == 'pressure (force/length²)'
    assert scene.Units('mm', 'N').label('pressure', 'force/length^2') == 'pressure (N/mm²)'
    assert scene.Units('m', 'N').label('energy', 'force/length') == 'energy (N/m)'
    assert scene.Units('mm').label('share', '1') == 'share'


def test_equivalent_stress_of_uniaxial_tension_and_shear():
    stress = np.array([[5.0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 2.0, 0], [3.0, 3.0, 3.0, 0, 0, 0]])
    np.testing.assert_allclose(mises(stress), [5.0, 2.0 * np.sqrt(3.0), 0.0])


WITH_PYVISTA = pytest.mark.skipif(not drawing.has_pyvista(), reason='wants PyVista')


@WITH_PYVISTA
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
    for name in ('reactions.png', 'cube.png') if drawing.has_pyvista() else ('reactions.png',):
        assert str(tmp_path / name) in text
        assert os.path.getsize(tmp_path / name) > 10000
    assert ('mfec[pictures]' in text) == (not drawing.has_pyvista())


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
