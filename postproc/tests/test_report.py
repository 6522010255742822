"""The report of a run: what stands in it, and how it looks in a browser."""
import base64
import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from mfec_post import audit, cli, drawing
from mfec_post.results import Results
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
PROGRAM = os.path.join(TOP, 'mfec')
PARTS = ('problem', 'audit', 'pictures', 'curves', 'fields', 'convergence', 'cost', 'deck')
BROWSER = next((found for found in map(shutil.which, ('chromium-headless-shell', 'chromium',
                                                      'google-chrome')) if found), None)
# What the browser says of the page: written into it, and read from what it dumps.
ASK = """<script>window.onload = () => {
  const box = e => { const r = e.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom]; };
  const images = [...document.images].map(i => ({wide: i.naturalWidth, box: box(i), text: i.alt}));
  const heads = [...document.querySelectorAll('h2')].map(h => ({id: h.id, box: box(h)}));
  const links = [...document.querySelectorAll('nav a')].map(a =>
    document.querySelector(a.getAttribute('href')) !== null);
  const pre = document.createElement('pre');
  pre.id = 'answer';
  pre.textContent = JSON.stringify({images, heads, links, wide: document.documentElement.scrollWidth,
    seen: document.documentElement.clientWidth, high: document.documentElement.scrollHeight});
  pre.style.display = 'none';
  document.body.appendChild(pre); };</script>"""


def run(folder, deck, change=lambda text: text):
    """The results file of a deck of inputs/."""
    if not os.path.exists(PROGRAM):
        pytest.skip('build ./mfec first')
    with open(os.path.join(TOP, 'inputs', deck), encoding='ascii') as stream:
        text = change(stream.read())
    with open(folder / 'x.inp', 'w', encoding='ascii') as stream:
        stream.write(text)
    subprocess.run([PROGRAM, 'x.inp', '--quiet'], check=True, cwd=folder,
                   env=dict(os.environ, OPENBLAS_NUM_THREADS='1'))
    return str(folder / 'x.vtkhdf')


@pytest.fixture(scope='module')
def tools(tmp_path_factory):
    """The report of a block under an exact ball, and its results file."""
    results = run(tmp_path_factory.mktemp('report'), 'manual/exact_tools.inp')
    assert cli.main(['report', results]) == 0
    with open(results.replace('.vtkhdf', '.html'), encoding='utf-8') as stream:
        return stream.read(), results


def cells(text, first):
    """The cells of the row that begins with a word."""
    row = next(row for row in re.findall(r'<tr>(.*?)</tr>', text) if f'>{first}</td>' in row)
    return re.findall(r'<td[^>]*>(.*?)</td>', row)


def test_a_report_stands_alone_and_has_all_parts(tools):
    text, _ = tools
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    assert re.findall(r'<h2 id="(\w+)">', text) == list(PARTS)
    for words in ('1 rubber: linear elastic, E = 1000, nu = 0.3', 'penalty 793', 'mu 0.3 and 0.3',
                  'on_floor', 'REDUced', 'contact search', 'BATCh', 'nodal_von_mises', 'whole run'):
        assert words in text, words


def test_numbers_of_the_audit_have_limits_and_meanings(tools):
    text, path = tools
    with Results(path) as results:
        group = results.file['audit']
        names = [name.decode().strip() for name in group['checks'][:]]
        verdicts, values = group['verdict'][:], group['value'][:]
    for k, name in enumerate(names):
        limit, meaning, remedy = audit.CHECKS[name]
        row = cells(text, name)
        worst = verdicts[:, k].max()
        assert row[1] == ('ok', 'warning', 'failed')[worst]
        assert float(row[2]) == pytest.approx(values[verdicts[:, k] == worst, k].max(), rel=5e-3)
        assert row[4] == limit and row[5].replace('&#x27;', "'") == meaning
        assert (remedy.split(',')[0] in row[6].replace('&#x27;', "'")) == (worst > 0)
    assert audit.CHECKS.keys() >= set(names)


def test_limits_of_the_audit_are_those_of_the_manual():
    with open(os.path.join(TOP, 'doc', 'manual.md'), encoding='utf-8') as stream:
        manual = stream.read()
    for name, (limit, _, _) in audit.CHECKS.items():
        row = next(line for line in manual.split('\n') if line.startswith('| ')
                   and f'`{name}`' in line.split('|')[1] and len(line.split('|')) == 6)
        for number in re.findall(r'\d[\d.]*(?:e-\d+)?', limit):
            assert number in row, (name, number)


def test_fields_have_their_ranges(tools):
    text, path = tools
    with Results(path) as results:
        values = results.point_field('nodal_von_mises')
    assert cells(text, 'nodal_von_mises')[3:5] == [f'{values.min() + 0.0:.4g}', f'{values.max():.4g}']


def test_curves_are_vectors_and_pictures_fit_for_print(tools):
    text, _ = tools
    assert text.count('data:image/svg+xml;base64,') >= 5
    raster = [base64.b64decode(item) for item in
              re.findall(r'src="data:image/png;base64,([^"]*)"', text)]
    assert len(raster) == (6 if drawing.has_pyvista() else 0)
    for data in raster:  # mesh, stresses, pressure and status of two pairs: 130 mm at 300 dpi
        assert data[:4] == b'\x89PNG' and int.from_bytes(data[16:20], 'big') == 1535


def test_a_report_of_a_run_without_fields(tmp_path):
    """OUTPut FIELds NONE: tables and costs are still worth a page."""
    path = run(tmp_path, 'two_cubes_block.inp', lambda text: text.replace(
        'END\nBATCh', 'OUTPut\n  FIELds NONE\n\nEND\nBATCh'))
    assert cli.main(['report', path]) == 0
    with open(tmp_path / 'x.html', encoding='utf-8') as stream:
        assert 'has written no fields' in stream.read()


@pytest.mark.skipif(BROWSER is None, reason='wants Chromium (.ci/setup browser)')
@pytest.mark.parametrize('width', [1100, 480])
def test_a_browser_shows_all_of_it(tools, tmp_path, width):
    """All pictures are there, in their places and in colours; no part runs over the edge."""
    text, _ = tools
    page = tmp_path / 'page.html'
    page.write_text(text.replace('</body>', ASK + '</body>'), encoding='utf-8')
    command = [BROWSER, '--headless', '--no-sandbox', '--disable-gpu', '--hide-scrollbars',
               f'--window-size={width},14000', '--virtual-time-budget=5000',
               f'--user-data-dir={tmp_path}/profile']
    done = subprocess.run(command + ['--dump-dom', page.as_uri()], check=True, timeout=120,
                          stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    answer = json.loads(re.search(r'<pre id="answer"[^>]*>(.*?)</pre>',
                                  done.stdout.decode('utf-8'), re.S).group(1)
                        .replace('&lt;', '<').replace('&gt;', '>').replace('&amp;', '&'))
    assert [head['id'] for head in answer['heads']] == list(PARTS)
    tops = [head['box'][1] for head in answer['heads']]
    assert tops == sorted(tops) and all(answer['links'])
    assert answer['wide'] <= answer['seen'], 'the page is wider than the window'
    assert len(answer['images']) == len(re.findall('<img ', text))
    picture = tmp_path / 'page.png'
    subprocess.run(command + [f'--screenshot={picture}', page.as_uri()], check=True, timeout=120,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with Image.open(picture) as shot:
        pixels = np.asarray(shot.convert('RGB')).astype(int)
    for one in answer['images']:
        left, top, right, bottom = (int(value) for value in one['box'])
        assert one['wide'] > 0 and right - left > 0.5 * min(480, answer['seen']), one['text']
        part = pixels[top:bottom, left:right]
        colourful = np.ptp(part, axis=2) > 40
        assert 0.001 < colourful.mean() < 0.9, one['text']
