"""The manuals as HTML: every formula is drawn, every link and picture leads somewhere."""
import os
import re
import sys
import xml.etree.ElementTree as tree

import pytest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(TOP, 'doc'))

import formulas  # noqa: E402


@pytest.fixture(scope='module')
def pages(tmp_path_factory):
    """Each document's page."""
    pytest.importorskip('latex2mathml')
    pytest.importorskip('markdown')
    import pages as maker
    folder = str(tmp_path_factory.mktemp('html'))
    return folder, dict(zip(formulas.documents(), maker.write(folder)))


def test_all_formulas_are_drawn(pages):
    found = 0
    for document, page in pages[1].items():
        text = formulas.read(page)
        drawn = re.findall(r'<math.*?</math>', text, re.S)
        assert len(drawn) == len(formulas.formulas(formulas.read(document))), document
        assert '$`' not in text and 'formula0here' not in text
        for formula in drawn:
            tree.fromstring(formula)
        found += len(drawn)
    assert found > 500


def test_links_and_pictures_lead_somewhere(pages):
    folder, made = pages
    for page in made.values():
        text = formulas.read(page)
        for word, target in re.findall(r'\b(href|src)="([^"]*)"', text):
            if re.match(r'[a-z]+:', target):
                continue
            name, _, anchor = target.partition('#')
            there = os.path.normpath(os.path.join(folder, name)) if name else page
            assert os.path.exists(there), f'{page}: {word} {target}'
            if anchor:
                assert f'id="{anchor}"' in formulas.read(there), f'{page}: {target}'
