"""Plots, pictures, movies and exports of real runs.

The pictures in pictures/ are drawn of four scenes, small: the sliding cube, a disc with a turned lay,
two pairs, and exact tools. Look at them, and write them anew with

    MFEC_NEW_PICTURES=1 build/venv-pictures/bin/python -m pytest postproc/tests/test_pictures.py

What draws wants PyVista, and is skipped without it: `make test-pictures` runs all.
"""
import base64
import csv
import os
import subprocess
import xml.etree.ElementTree as tree

import numpy as np
import pytest
import sheets
from mfec_post import Surfaces, cli, drawing, pictures, plots, read_table, rows_of, scene
from mfec_post.results import Results
from mfec_post.tables import TableError
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
PROGRAM = os.path.join(TOP, 'mfec')
SMALL = (460, 346)
PRINT = ['--size', '117', '88', '--dpi', '100']
"""What makes a picture as large as SMALL."""
WITH_PYVISTA = pytest.mark.skipif(not drawing.has_pyvista(), reason='wants PyVista')
DECKS = {
    'cube': ('sliding_cube', ['--set', 'n=3', '--set', 'npress=2', '--set', 'nslide=4',
                              '--set', 'phi=45']),
    'disc': ('manual/turned_disc', []),
    'pairs': ('two_cubes_block', []),
    'tools': ('manual/exact_tools', []),
}
# picture: run, options of mfec-post picture
WANTED = {
    'cube_mises': ('cube', []),
    'cube_pressure': ('cube', ['--contact', 'pressure']),
    'disc_lay': ('disc', ['--contact', 'status', '--side', 'master']),
    'disc_slip': ('disc', ['--contact', 'slip']),
    'pairs_displacement': ('pairs', ['--field', 'displacement', '--scale', '5']),
    'pairs_shear': ('pairs', ['--contact', 'shear_traction']),
    'tools_mises': ('tools', ['--length', 'mm', '--force', 'N']),
    'tools_facets': ('tools', ['--contact', 'pressure', '--pair', 'under_ball', '--by-facet']),
}


@pytest.fixture(scope='module')
def runs(tmp_path_factory):
    """The results files of the three scenes."""
    if not os.path.exists(PROGRAM):
        pytest.skip('build ./mfec first')
    found = {}
    for name, (deck, options) in DECKS.items():
        folder = str(tmp_path_factory.mktemp(name))
        subprocess.run([PROGRAM, os.path.join(TOP, 'inputs', deck + '.inp'), '--quiet', '--out',
                        folder] + options, check=True, cwd=folder,
                       env=dict(os.environ, OPENBLAS_NUM_THREADS='1'))
        found[name] = os.path.join(folder, os.path.basename(deck) + '.vtkhdf')
    return found


@WITH_PYVISTA
@pytest.mark.parametrize('name', sorted(WANTED))
def test_pictures_look_as_they_did(runs, tmp_path, name):
    run, options = WANTED[name]
    out, kept = str(tmp_path / 'p.png'), os.path.join(HERE, 'pictures', name + '.png')
    assert cli.main(['picture', runs[run], *PRINT, '--out', out] + options) == 0
    if os.environ.get('MFEC_NEW_PICTURES'):
        os.replace(out, kept)
        return
    with Image.open(out) as new, Image.open(kept) as old:
        assert new.size == old.size == SMALL
        assert sheets.difference(new, old) == ''


@WITH_PYVISTA
def test_a_wrong_picture_is_found(runs, tmp_path):
    """The tolerance tells one output time from another."""
    out, kept = str(tmp_path / 'p.png'), os.path.join(HERE, 'pictures', 'cube_mises.png')
    assert cli.main(['picture', runs['cube'], '--frame', '0', *PRINT, '--out', out]) == 0
    with Image.open(out) as new, Image.open(kept) as old:
        assert sheets.difference(new, old) != ''


def test_curves_of_several_runs(runs, tmp_path):
    tables = [runs[name].replace('.vtkhdf', '.con') for name in ('cube', 'pairs')]
    found = plots.curves(tables, 'time', ['Ft/Fn'])
    assert len(found) == 3  # one pair, two pairs
    rows = rows_of(read_table(tables[0]), 'sole_on_track')
    np.testing.assert_allclose(found[0][2], rows['Ft'] / rows['Fn'])
    out = str(tmp_path / 'p.png')
    assert cli.main(['plot', *tables, '--y', 'Fn', 'Ft', '--out', out]) == 0
    assert os.path.getsize(out) > 10000
    with pytest.raises(TableError, match='it has: '):
        plots.curves(tables, 'time', ['Fnn'])
    assert cli.main(['plot', tables[0], '--name', 'nobody', '--out', out]) == 2


@WITH_PYVISTA
def test_movies_have_a_picture_each_end_time(runs, tmp_path):
    out = str(tmp_path / 'm.gif')
    assert cli.main(['movie', runs['cube'], '--contact', 'pressure', '--size', '60', '48', '--dpi',
                     '80', '--out', out]) == 0
    with Image.open(out) as film, Results(runs['cube']) as results:
        assert film.n_frames == results.steps
    assert pictures.progress(3, 6) == '\r[' + '#' * 15 + '.' * 15 + '] 3 of 6'


def test_what_is_missing_is_said(runs, tmp_path, capsys):
    assert cli.main(['picture', runs['cube'], '--field', 'heat']) == 2
    assert 'it has: ' in capsys.readouterr().err
    assert cli.main(['picture', runs['cube'], '--contact', 'pressure', '--pair', 'x']) == 2
    assert 'no pair x' in capsys.readouterr().err
    assert cli.main(['report', str(tmp_path / 'none.vtkhdf')]) == 2


def test_without_pyvista_it_is_said_what_to_install(runs, tmp_path, capsys, monkeypatch):
    import builtins
    real = builtins.__import__

    def without(name, *rest):
        if name == 'pyvista':
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, '__import__', without)
    assert cli.main(['picture', runs['cube'], '--out', str(tmp_path / 'p.png')]) == 2
    assert "pip install 'mfec[pictures]'" in capsys.readouterr().err


@WITH_PYVISTA
def test_a_picture_has_the_size_of_print(runs, tmp_path):
    """Pixels are those of 130 x 98 mm at 300 dpi, and words of a .pdf are words."""
    out = str(tmp_path / 'p.png')
    assert cli.main(['picture', runs['pairs'], '--out', out]) == 0
    with Image.open(out) as picture:
        assert picture.size == (1535, 1157)
        assert picture.info['dpi'] == pytest.approx((300, 300), abs=0.1)
    assert cli.main(['picture', runs['pairs'], '--out', str(tmp_path / 'p.pdf')]) == 0
    with open(tmp_path / 'p.pdf', 'rb') as stream:
        assert b'/Font' in stream.read()


@WITH_PYVISTA
def test_colours_are_those_of_the_nodes(runs):
    """The pixel over a node of a flat contact surface has the colour of its pressure."""
    import matplotlib
    with Surfaces(runs['cube'].replace('.vtkhdf', '.contact.vtkhdf')) as surfaces:
        one = scene.contact(surfaces)
        part = surfaces.surface('sole_on_track')
    one.strokes, one.arrows, one.mids = [], [], np.zeros((0, 3), dtype=int)
    np.testing.assert_array_equal(one.values, part.at_nodes['pressure'])
    size = (400, 300)
    picture = drawing.rendered(one, size, 100).astype(float)
    low, high = scene.colour_limits(one)
    map_of = matplotlib.colormaps['viridis']
    x = one.points[:, :2]  # seen from above
    middle = 0.5 * (x.min(axis=0) + x.max(axis=0))
    unit = 1.06 * np.ptp(x, axis=0)[1] / size[1]
    for facet in part.facets:
        at = ((one.points[facet].mean(axis=0)[:2] - middle) / unit * [1, -1] + np.array(size) / 2)
        wanted = np.array(map_of((one.values[facet].mean() - low) / (high - low))[:3]) * 255
        found = picture[int(at[1]), int(at[0])]
        assert np.abs(found - wanted).max() < 12, (facet, found, wanted)


def test_exports_hold_what_the_files_hold(runs, tmp_path):
    out = str(tmp_path / 'e')
    assert cli.main(['export', runs['pairs'], '--out', out]) == 0
    index = tree.parse(os.path.join(out, 'two_cubes_block.contact.pvd')).getroot()
    parts = [(float(p.get('timestep')), p.get('file')) for p in index.iter('DataSet')]
    with Surfaces(runs['pairs'].replace('.vtkhdf', '.contact.vtkhdf')) as surfaces:
        np.testing.assert_allclose([time for time, _ in parts], surfaces.times)
        count = len(surfaces.vtk['Points'])
        offset = surfaces.vtk['Steps/PointDataOffsets/pressure'][3]
        wanted = surfaces.vtk['PointData/pressure'][offset:offset + count]
    piece = tree.parse(os.path.join(out, parts[3][1])).getroot()
    data = next(a for a in piece.iter('DataArray') if a.get('Name') == 'pressure')
    raw = base64.b64decode(data.text)
    assert int(np.frombuffer(raw[:8], dtype='<u8')[0]) == len(raw) - 8
    np.testing.assert_array_equal(np.frombuffer(raw[8:], dtype=wanted.dtype), wanted)
    table = read_table(runs['pairs'].replace('.vtkhdf', '.con'))
    with open(os.path.join(out, 'two_cubes_block.con.csv'), encoding='utf-8') as stream:
        rows = list(csv.DictReader(stream))
    assert [float(row['Fn']) for row in rows] == list(table['Fn'])
