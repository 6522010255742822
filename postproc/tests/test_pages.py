"""The manuals as HTML: contents, search, formulas; links and pictures lead somewhere, none to the network."""
import glob
import html
import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as tree

import pytest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(TOP, 'doc'))

import formulas  # noqa: E402


@pytest.fixture(scope='module')
def pages(tmp_path_factory):
    """The folder of the pages, and the text of each."""
    pytest.importorskip('myst_parser')
    pytest.importorskip('furo')
    folder = str(tmp_path_factory.mktemp('html'))
    done = subprocess.run([sys.executable, '-m', 'sphinx', '-q', '-W', '--keep-going', '-c', 'doc', '-d',
                           folder + '.read', '.', folder], cwd=TOP, capture_output=True, text=True,
                          check=False)
    assert done.returncode == 0, done.stderr
    return folder, {path: formulas.read(path)
                    for path in glob.glob(os.path.join(folder, '**', '*.html'), recursive=True)}


def page_of(pages, document):
    """The text of a document's page."""
    name = os.path.splitext(os.path.relpath(document, formulas.TOP))[0]
    return pages[1][os.path.join(pages[0], name + '.html')]


def test_all_formulas_are_drawn(pages):
    found = 0
    for document in formulas.documents():
        text = page_of(pages, document)
        drawn = re.findall(r'<math.*?</math>', text, re.S)
        assert len(drawn) == len(formulas.formulas(formulas.read(document))), document
        assert '$`' not in text
        for formula in drawn:
            tree.fromstring(formula)
        found += len(drawn)
    assert found > 500


def test_links_and_pictures_lead_somewhere_on_disk(pages):
    anchors = {path: set(re.findall(r'\bid="([^"]*)"', text)) for path, text in pages[1].items()}
    for page, text in pages[1].items():
        for word, target in re.findall(r'\b(href|src)="([^"]+)"', text):
            if re.match(r'[a-z]+:|//', target):
                assert word == 'href', f'{page}: {target} is of the network'
                continue
            name, _, anchor = html.unescape(target).partition('#')
            name = name.split('?')[0]
            there = os.path.normpath(os.path.join(os.path.dirname(page), name)) if name else page
            assert os.path.exists(there), f'{page}: {word} {target}'
            if anchor and there in anchors:
                assert anchor in anchors[there], f'{page}: {target}'
        assert not re.search(r'<(link|script)[^>]*(href|src)="(https?:)?//', text), f'{page}: the network'


def test_contents_name_all_manuals_and_their_pages(pages):
    contents = set(re.findall(r'class="reference internal" href="([^"#]+)"',
                              page_of(pages, os.path.join(formulas.TOP, 'README.md'))))
    for document in formulas.documents():
        name = os.path.splitext(os.path.relpath(document, formulas.TOP))[0] + '.html'
        assert name in contents or name == 'README.html', name


def test_the_search_finds_words_of_the_field(pages):
    with open(os.path.join(pages[0], 'searchindex.js'), encoding='utf-8') as stream:
        index = json.loads(re.fullmatch(r'Search\.setIndex\((.*)\)', stream.read(), re.S).group(1))
    for word in ('penalti', 'schur', 'mortar', 'friction', 'augment'):
        assert word in index['terms'], word
    found = index['terms']['schur']
    names = [index['docnames'][k] for k in (found if isinstance(found, list) else [found])]
    assert 'doc/theory' in names
