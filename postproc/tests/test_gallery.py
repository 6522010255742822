"""The gallery: each number is that of a run, beside its reference, and each picture that of the run.

It takes some three minutes of processor time, and PyVista: `make test-pictures` runs it.
"""
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import sheets
from mfec_post import drawing
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
DOC = os.path.join(TOP, 'doc')
sys.path.insert(0, DOC)
import figures  # noqa: E402
import scenes  # noqa: E402

pytestmark = pytest.mark.skipif(not drawing.has_pyvista(), reason='wants PyVista')


def page():
    """The page as it is kept."""
    with open(os.path.join(DOC, 'gallery.md'), encoding='utf-8') as stream:
        return stream.read()


def numbers(text):
    """The number that a line of facts tells, its reference, degrees of freedom and elements."""
    told = re.search(r'^([\d,]+) dofs, ([\d,]+) elements.*\*\*.*: ([-\d.e+]+)\*\*; reference ([-\d.e+]+),',
                     text)
    return [float(value.replace(',', '')) for value in told.groups()]


@pytest.mark.parametrize('name', [one[0] for one in scenes.SCENES])
def test_numbers_and_pictures_are_those_of_a_run(tmp_path, name):
    _, deck, options, panels, curve, number, title, text = next(
        one for one in scenes.SCENES if one[0] == name)
    base = figures.run(str(tmp_path), figures.deck_of(deck), options)
    _, found, wanted, most = number(base)
    assert abs(found / wanted - 1) < most
    kept = figures.kept_facts(name)
    np.testing.assert_allclose(numbers(figures.facts(base, number)), numbers(kept), rtol=5e-3)
    assert f'## {title}' in page() and text in page()
    picture = Image.fromarray(figures.draw_scene(base, panels, curve))
    with Image.open(os.path.join(DOC, 'gallery', name + '.png')) as old:
        assert old.info['dpi'] == pytest.approx((300, 300), abs=0.1)
        small = [one.convert('RGB').resize((one.width // 4, one.height // 4), Image.Resampling.BOX)
                 for one in (picture, old)]
    assert sheets.difference(*small) == ''


def test_a_scene_is_drawn_in_colours_of_its_range(tmp_path):
    """The picture of another output time is another picture: the comparison above can fail."""
    name, deck, options, panels, curve, *_ = scenes.SCENES[0]
    base = figures.run(str(tmp_path), figures.deck_of(deck), options)
    other = [(what, 2, view) for what, _, view in panels]
    a, b = (Image.fromarray(figures.draw_scene(base, given, curve)) for given in (panels, other))
    assert sheets.difference(*(one.resize((one.width // 4, one.height // 4)) for one in (a, b))) != ''


def test_gallery_meshes_are_what_their_script_makes(tmp_path):
    """Their nodes and elements; lug.msh and seal.msh are Gmsh's."""
    folder = os.path.join(TOP, 'inputs', 'gallery')
    subprocess.run([sys.executable, os.path.join(folder, 'make_meshes.py'), str(tmp_path)], check=True)
    for made in sorted(os.listdir(tmp_path)):
        with open(tmp_path / made, encoding='ascii') as new, open(os.path.join(folder, made),
                                                                 encoding='ascii') as old:
            assert new.read() == old.read(), made
