"""What the manuals show is what the program does: figures, gallery, commands."""
import glob
import os
import re
import shlex
import subprocess
import sys

import pytest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DOC = os.path.join(TOP, 'doc')
sys.path.insert(0, DOC)

import figures  # noqa: E402
import formulas  # noqa: E402

# Who makes the pictures of the manuals.
MAKERS = {'doc/pictures/': 'make figures', 'doc/gallery/': 'make gallery',
          'doc/verification/': 'make verify', 'doc/bench/': 'make bench'}


def test_pictures_are_not_older_than_what_they_show():
    assert figures.stale() == []


def test_every_picture_has_a_maker():
    for path in formulas.documents():
        for target in re.findall(r'!\[[^\]]*\]\(([^)]+)\)', formulas.read(path)):
            name = os.path.relpath(os.path.join(os.path.dirname(path), target), TOP)
            assert os.path.exists(os.path.join(TOP, name)), f'{path}: {target}'
            assert any(name.startswith(known) for known in MAKERS), f'nobody makes {name}'


def test_the_gallery_shows_all_decks():
    page = formulas.read(os.path.join(DOC, 'gallery.md'))
    scenes = figures.SCENES + figures.MORE
    assert len(figures.SCENES) == 12
    for name, deck, _, _, _, text in scenes:
        assert f'gallery/{name}.png' in page and f'inputs/{deck}.inp' in page and text in page
    decks = [os.path.relpath(path, os.path.join(TOP, 'inputs'))[:-4]
             for path in glob.glob(os.path.join(TOP, 'inputs', '**', '*.inp'), recursive=True)]
    assert sorted(decks) == sorted(scene[1] for scene in scenes)


def commands():
    """The command lines of the tutorials that run as they stand."""
    text = formulas.read(os.path.join(DOC, 'tutorials.md'))
    blocks = re.findall(r'^```\n(\./mfec.*?)^```', text, re.S | re.M)
    return [line for block in blocks for line in block.strip().split('\n')]


def test_the_commands_of_the_tutorials_run(tmp_path):
    program = os.path.join(TOP, 'mfec')
    if not os.path.exists(program):
        pytest.skip('build ./mfec first')
    os.symlink(os.path.join(TOP, 'inputs'), tmp_path / 'inputs')
    os.symlink(program, tmp_path / 'mfec')
    lines = commands()
    assert len(lines) >= 10
    for line in lines:
        command, _, remark = line.partition('#')
        wanted = re.search(r'exit code (\d)', remark)
        done = subprocess.run(shlex.split(command) + ['--quiet'] * ('--help' not in command),
                              cwd=tmp_path, capture_output=True, text=True, check=False,
                              env=dict(os.environ, OPENBLAS_NUM_THREADS='1'))
        assert done.returncode == (int(wanted.group(1)) if wanted else 0), line + done.stderr
        said = re.search(r': (did you mean .*)$', remark)
        assert not said or said.group(1) in done.stderr
