"""The check of a release finds what is missing or untrue; setting a version sets it everywhere."""
import importlib.machinery
import importlib.util
import os
import re
import shutil
import subprocess
import sys

import pytest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PATH = os.path.join(TOP, '.ci', 'release')


def load():
    """.ci/release as a module."""
    loader = importlib.machinery.SourceFileLoader('release', PATH)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader('release', loader))
    sys.dont_write_bytecode, before = True, sys.dont_write_bytecode
    loader.exec_module(module)
    sys.dont_write_bytecode = before
    return module


RELEASE = load()
NAMES = sorted({*RELEASE.FILES, *RELEASE.VERSIONS, *RELEASE.DATES, *RELEASE.LICENCES, *RELEASE.GUIDES,
                *RELEASE.SOURCES, '.ci/release'})


@pytest.fixture
def tree(tmp_path):
    """A copy of the files that it looks at."""
    for name in NAMES:
        os.makedirs(os.path.dirname(tmp_path / name), exist_ok=True)
        shutil.copy(os.path.join(TOP, name), tmp_path / name)
    for name in os.listdir(os.path.join(TOP, '.ci')):  # scripts that guides name
        if not (tmp_path / '.ci' / name).exists():
            (tmp_path / '.ci' / name).touch()
    (tmp_path / 'tests').symlink_to(os.path.join(TOP, 'tests'))
    return tmp_path


def check(tree, *words):
    """Exit code and output."""
    done = subprocess.run([sys.executable, str(tree / '.ci' / 'release'), *(words or ['check'])],
                          stdout=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stdout


def test_all_is_there_and_true(tree):
    """As it stands."""
    assert check(tree)[0] == 0, check(tree)[1]


@pytest.mark.parametrize('name', [name for name in RELEASE.VERSIONS if name != 'Makefile'])
def test_another_version_is_found(tree, name):
    """Each place by itself."""
    text = (tree / name).read_text(encoding='utf-8')
    (tree / name).write_text(re.sub(RELEASE.VERSIONS[name], r'\g<1>9.8.7\g<3>', text, count=1),
                             encoding='utf-8')
    code, said = check(tree)
    assert code == 1 and f'{name}: the version is 9.8.7' in said


@pytest.mark.parametrize('name', sorted(RELEASE.FILES))
def test_a_missing_file_is_found(tree, name):
    """Each file by itself."""
    (tree / name).unlink()
    code, said = check(tree)
    assert code == 1 and f'{name}: there is no such file' in said


UNTRUE = [  # file, what stands there, what is untrue, what is said
    ('README.md', 'make stress', 'make strength', 'there is no make strength'),
    ('CONTRIBUTING.md', 'tests/mutants', 'tests/mutant', 'there is no tests/mutant'),
    ('postproc/README.md', 'mfec-post report', 'mfec-post paper', 'there is no mfec-post paper'),
    ('.gitlab-ci.yml', '    - .ci/run', '    - .ci/run\n    - .ci/again', 'there is no .ci/again'),
    ('README.md', 'libopenblas-dev', 'libblas-dev', 'does not name libopenblas-dev'),
    ('.ci/packaging/conda/meta.yaml', 'pandas >=2', 'pandas >=1', 'does not ask for pandas>=2'),
    ('.ci/packaging/debian/control', 'the authors of mfec', 'somebody', 'does not name the authors'),
    ('.zenodo.json', 'quasi-static', 'dynamic', 'its abstract is not the description'),
    ('codemeta.json', '"friction"', '"wear"', 'key words differ'),
    ('README.md', '# mfec', '# [mfec](https://example.org/mfec/badge.svg)', 'is not below'),
    ('CITATION.cff', 'date-released: 2', 'date-released: 1', 'the date is 1'),
    ('.ci/packaging/debian/changelog', 'Nov 2026', 'Dec 2026', 'the date is not that'),
]


@pytest.mark.parametrize('name, true, untrue, wanted', UNTRUE)
def test_what_is_not_true_is_found(tree, name, true, untrue, wanted):
    """Commands, scripts, libraries, authors, texts, addresses and dates."""
    text = (tree / name).read_text(encoding='utf-8')
    assert true in text
    (tree / name).write_text(text.replace(true, untrue), encoding='utf-8')
    code, said = check(tree)
    assert code == 1 and any(line.startswith(name) or name == '.zenodo.json' or name == 'codemeta.json'
                             for line in said.splitlines()) and wanted in said, said


def test_set(tree):
    """A version goes everywhere, with a dated chapter of the changelog; no number is refused."""
    assert check(tree, 'set', '3.2.1')[0] == 0
    assert 'VERSION := 3.2.1' in (tree / 'Makefile').read_text(encoding='utf-8')
    changes = (tree / 'CHANGELOG.md').read_text(encoding='utf-8')
    assert re.search(r'## \[Unreleased\]\n\n## \[3\.2\.1\] - \d{4}-\d\d-\d\d\n', changes)
    debian = (tree / '.ci/packaging/debian/changelog').read_text(encoding='utf-8')
    assert debian.startswith('mfec (3.2.1-1)') and check(tree)[0] == 0
    (tree / 'CHANGELOG.md').write_text(changes.replace('[3.2.1] - ', '[3.2.1] '), encoding='utf-8')
    assert '3.2.1 has no date' in check(tree)[1]
    assert check(tree, 'set', '1.0')[0] == 1
