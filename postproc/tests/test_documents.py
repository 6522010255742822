"""What the manuals show is what the program does: figures, gallery, commands."""
import glob
import hashlib
import os
import re
import sys

from PIL import Image

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DOC = os.path.join(TOP, 'doc')
sys.path.insert(0, DOC)

import cases  # noqa: E402
import figures  # noqa: E402
import formulas  # noqa: E402

# Who makes the pictures of the manuals.
MAKERS = {'doc/pictures/': 'make figures', 'doc/gallery/': 'make gallery',
          'doc/verification/': 'make verify', 'doc/bench/': 'make bench',
          'doc/tutorials/': 'tests/manuals --pictures'}


def test_pictures_are_not_older_than_what_they_show():
    assert figures.stale() == []


def test_figures_of_the_benchmark_show_its_table():
    """tests/bench/bench --redraw draws them from results.csv."""
    folder = os.path.join(DOC, 'bench')
    with open(os.path.join(folder, 'results.csv'), 'rb') as stream:
        shown = hashlib.sha256(stream.read()).hexdigest()[:16]
    for path in glob.glob(os.path.join(folder, '*.png')):
        with Image.open(path) as picture:
            assert picture.text.get('Source') == shown, path


def test_figures_of_the_studies_are_not_older_than_these():
    """make verify writes them with made_from.txt."""
    sys.path.insert(0, os.path.join(TOP, 'tests', 'verification'))
    import drawing
    folder = os.path.join(DOC, 'verification')
    kept = figures.read_digests(folder)
    names = [name for shown in cases.PICTURES.values() for name in shown
             if os.path.exists(os.path.join(folder, name + '.svg'))]
    assert sorted(kept) == sorted(names)
    for name in names:
        assert drawing.study_of(name), f'no study fills {name}'
        assert kept[name] == drawing.digest(name), name


def test_every_picture_has_a_maker():
    for path in formulas.documents():
        for target in re.findall(r'!\[[^\]]*\]\(([^)]+)\)', formulas.read(path)):
            name = os.path.relpath(os.path.join(os.path.dirname(path), target), TOP)
            assert os.path.exists(os.path.join(TOP, name)), f'{path}: {target}'
            assert any(name.startswith(known) for known in MAKERS), f'nobody makes {name}'


def test_the_gallery_shows_its_scenes():
    """test_gallery.py runs them; decks of inputs/gallery that are not shown are those of other tests."""
    page = formulas.read(os.path.join(DOC, 'gallery.md'))
    scenes = figures.scenes.SCENES
    assert len(scenes) == 12 and 'Later' not in page
    for name, deck, options, _, _, number, title, text in scenes:
        part = page[page.index(f'## {title}\n'):].split('\n## ')[0]
        assert f'gallery/{name}.png' in part and text in part and number.__doc__
        assert ' '.join(['./mfec', f'inputs/{deck}.inp'] + options) in part
        assert re.search(r'reference [-\d.e+]+, difference [-+][-\d.e+]+ %', part), name
    shown = {os.path.basename(scene[1]) for scene in scenes}
    for path in glob.glob(os.path.join(TOP, 'inputs', 'gallery', '*.inp')):
        name = os.path.basename(path)[:-4]
        cases = glob.glob(os.path.join(TOP, 'tests', 'regression', f'gallery_{name}', 'case'))
        assert name in shown or cases, f'{name} is neither shown nor tested'
