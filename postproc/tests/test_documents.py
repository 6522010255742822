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
    names = [os.path.basename(path)[:-4] for path in glob.glob(os.path.join(folder, '*.png'))]
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


def test_the_gallery_shows_all_decks():
    page = formulas.read(os.path.join(DOC, 'gallery.md'))
    scenes = figures.SCENES + figures.MORE
    assert len(figures.SCENES) == 15
    for name, deck, _, _, _, text in scenes:
        assert f'gallery/{name}.png' in page and f'inputs/{deck}.inp' in page and text in page
    decks = [os.path.relpath(path, os.path.join(TOP, 'inputs'))[:-4]
             for path in glob.glob(os.path.join(TOP, 'inputs', '**', '*.inp'), recursive=True)]
    assert sorted(decks) == sorted(scene[1] for scene in scenes)
