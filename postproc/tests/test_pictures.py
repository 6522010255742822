"""Reports, plots, pictures, movies and exports of real runs.

The pictures in pictures/ are what matplotlib draws of three scenes, small: the sliding cube, a disc
with a turned lay, and two pairs. Look at them, and write them anew with

    MFEC_NEW_PICTURES=1 build/venv/bin/python -m pytest postproc/tests/test_pictures.py
"""
import base64
import csv
import os
import re
import subprocess
import xml.etree.ElementTree as tree

import numpy as np
import pytest
import sheets
from mfec_post import Surfaces, cli, pictures, plots, read_table, rows_of, scene
from mfec_post.results import Results
from mfec_post.tables import TableError
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
PROGRAM = os.path.join(TOP, 'mfec')
SMALL = (420, 318)
DECKS = {
    'cube': ('sliding_cube', ['--set', 'n=3', '--set', 'npress=2', '--set', 'nslide=4',
                              '--set', 'phi=45']),
    'disc': ('manual/turned_disc', []),
    'pairs': ('two_cubes_block', []),
}
# picture: run, options of mfec-post picture
WANTED = {
    'cube_mises': ('cube', []),
    'cube_pressure': ('cube', ['--contact', 'pressure']),
    'disc_lay': ('disc', ['--contact', 'status', '--side', 'master']),
    'disc_slip': ('disc', ['--contact', 'slip']),
    'pairs_displacement': ('pairs', ['--field', 'displacement', '--scale', '5']),
    'pairs_shear': ('pairs', ['--contact', 'shear_traction']),
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


@pytest.mark.parametrize('name', sorted(WANTED))
def test_pictures_look_as_they_did(runs, tmp_path, name):
    run, options = WANTED[name]
    out, kept = str(tmp_path / 'p.png'), os.path.join(HERE, 'pictures', name + '.png')
    assert cli.main(['picture', runs[run], '--renderer', 'matplotlib', '--size',
                     *map(str, SMALL), '--out', out] + options) == 0
    if os.environ.get('MFEC_NEW_PICTURES'):
        os.replace(out, kept)
        return
    with Image.open(out) as new, Image.open(kept) as old:
        assert new.size == old.size == SMALL
        assert sheets.difference(new, old) == ''


def test_a_wrong_picture_is_found(runs, tmp_path):
    """The tolerance tells one end time from another."""
    out, kept = str(tmp_path / 'p.png'), os.path.join(HERE, 'pictures', 'cube_mises.png')
    assert cli.main(['picture', runs['cube'], '--renderer', 'matplotlib', '--frame', '0',
                     '--size', *map(str, SMALL), '--out', out]) == 0
    with Image.open(out) as new, Image.open(kept) as old:
        assert sheets.difference(new, old) != ''


def test_a_report_stands_alone(runs, tmp_path):
    out = str(tmp_path / 'r.html')
    assert cli.main(['report', runs['cube'], '--renderer', 'matplotlib', '--out', out]) == 0
    with open(out, encoding='utf-8') as stream:
        text = stream.read()
    assert not re.search(r'(src|href)="(?!data:)', text)
    images = re.findall(r'src="data:image/png;base64,([^"]*)"', text)
    assert len(images) >= 6
    assert all(base64.b64decode(i)[:4] == b'\x89PNG' for i in images)
    for words in ('Sliding cube', 'Audit', 'balance', 'Convergence', 'contact search', 'BATCh'):
        assert words in text


def test_a_report_of_a_run_without_fields(tmp_path):
    """OUTPut FIELds NONE: tables and costs are still worth a page."""
    with open(os.path.join(TOP, 'inputs', 'two_cubes_block.inp'), encoding='ascii') as stream:
        deck = stream.read().replace('END\nBATCh', 'OUTPut\n  FIELds NONE\n\nEND\nBATCh')
    with open(tmp_path / 'x.inp', 'w', encoding='ascii') as stream:
        stream.write(deck)
    if not os.path.exists(PROGRAM):
        pytest.skip('build ./mfec first')
    subprocess.run([PROGRAM, 'x.inp', '--quiet'], check=True, cwd=tmp_path)
    assert cli.main(['report', str(tmp_path / 'x.vtkhdf')]) == 0
    assert os.path.exists(tmp_path / 'x.html')


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


def test_movies_have_a_picture_each_end_time(runs, tmp_path):
    out = str(tmp_path / 'm.gif')
    assert cli.main(['movie', runs['cube'], '--contact', 'pressure', '--renderer', 'matplotlib',
                     '--size', '200', '150', '--out', out]) == 0
    with Image.open(out) as film, Results(runs['cube']) as results:
        assert film.n_frames == results.steps
    assert pictures.progress(3, 6) == '\r[' + '#' * 15 + '.' * 15 + '] 3 of 6'


def test_what_is_missing_is_said(runs, tmp_path, capsys):
    assert cli.main(['picture', runs['cube'], '--field', 'heat']) == 2
    assert 'it has: ' in capsys.readouterr().err
    assert cli.main(['picture', runs['cube'], '--contact', 'pressure', '--pair', 'x']) == 2
    assert 'no pair x' in capsys.readouterr().err
    assert cli.main(['report', str(tmp_path / 'none.vtkhdf')]) == 2


def test_pictures_without_pyvista(monkeypatch):
    import builtins
    real = builtins.__import__

    def without(name, *rest):
        if name == 'pyvista':
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, '__import__', without)
    assert not scene.has_pyvista()
    one = scene.Scene(np.eye(3), np.array([[0, 1, 2]]), np.array([1.0]), 'x')
    assert scene.draw(one, size=(120, 90)).shape == (90, 120, 3)


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
