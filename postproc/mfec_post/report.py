"""One HTML file of a run, that needs no network: the problem and its mesh, audit, pictures, curves,
fields, convergence, cost, deck."""
from __future__ import annotations

import base64
import html
import os
import re
import tempfile
from typing import Any

import numpy as np

from . import drawing, plots, style
from . import scene as scenes
from .audit import CHECKS
from .results import Results, text_of
from .surfaces import Surfaces
from .tables import TableError

CSS = '''body{font:15px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em;color:#222}
h1{font-size:1.5em}h2{font-size:1.2em;border-bottom:1px solid #ccc;margin-top:2em}
img{max-width:100%;width:30em}img.wide{width:44em}
.pictures{display:flex;flex-wrap:wrap;gap:.5em}.pictures p{flex:1 1 27em;max-width:30em;margin:0}
.table{overflow-x:auto}
pre{background:#f6f6f6;padding:.8em;overflow:auto;font-size:12px}nav{display:flex;flex-wrap:wrap;gap:1em}
table{border-collapse:collapse;font-size:14px}
td,th{padding:.2em .9em .2em 0;text-align:left;vertical-align:top;border-bottom:1px solid #eee}
td.n{text-align:right;white-space:nowrap}.ok{color:#060}.warning{color:#a60}.failed{color:#c00}
@media print{nav{display:none}h2{break-after:avoid}tr,img{break-inside:avoid}}'''
ITERATION = re.compile(r'^step +(\d+) time +\S+ iteration *(\d+) +Residual norm = *(\S+)', re.M)
HEAD = re.compile(r'^(mesh|material|pair|solver:|BLAS) +(.*)$|^(pair .* at the start: .*)$', re.M)
WORDS = ('ok', 'warning', 'failed')


def image(path: str, text: str, kind: str = '') -> str:
    """A picture inside the page: .png, or .svg."""
    with open(path, 'rb') as stream:
        data = base64.b64encode(stream.read()).decode('ascii')
    media = 'svg+xml' if path.endswith('.svg') else 'png'
    kind = f' class="{kind}"' if kind else ''
    return (f'<p><img{kind} alt="{html.escape(text)}" src="data:image/{media};base64,{data}">'
            '</p>\n')


def rows(lines: list[list[str]], head: list[str], numbers: tuple[int, ...] = ()) -> str:
    """A table; columns of numbers stand to the right, a verdict has its colour."""
    text = '<div class="table"><table><tr>' + ''.join(f'<th>{html.escape(h)}</th>' for h in head) + '</tr>\n'
    for line in lines:
        text += '<tr>'
        for k, value in enumerate(line):
            kind = 'n' if k in numbers else value if value in WORDS else ''
            text += (f'<td class="{kind}">' if kind else '<td>') + html.escape(value) + '</td>'
        text += '</tr>\n'
    return text + '</table></div>\n'


def problem(results: Results, log: str) -> str:
    """Program, mesh, materials, pairs with law and penalty, solver."""
    lines = [['program', results.text('version')], ['command', results.text('settings')],
             ['output times with fields', str(results.steps)]]
    found = HEAD.findall(log.split('\naudit:')[0])
    names = {'solver:': 'solver'}
    lines += [[names.get(word, word), text] if word else ['at the start', start]
              for word, text, start in found if word != 'BLAS']
    if not found:
        lines += [['mesh', f'{len(results.points)} nodes, {len(results.cells)} elements'],
                  ['contact pairs', ', '.join(results.pairs) or 'none']]
    return '<h2 id="problem">Problem</h2>\n' + rows(lines, ['', ''])


def audit(results: Results, log: str) -> str:
    """The worst verdict of each check: its value then, the limit, what it means, what to do."""
    if 'audit' not in results.file or len(results.file['audit/step']) == 0:
        return ''
    group = results.file['audit']
    names = [name.decode().strip() for name in group['checks'][:]]
    verdicts, values, steps = (group[n][:] for n in ('verdict', 'value', 'step'))
    lines = []
    for k, name in enumerate(names):
        worst = int(np.lexsort((values[:, k], verdicts[:, k]))[-1])
        verdict = WORDS[verdicts[worst, k]]
        measured = values[worst, k] >= 0
        limit, meaning, remedy = CHECKS.get(name, ('', '', ''))
        lines.append([name, verdict, f'{values[worst, k]:.3g}' if measured else '-',
                      str(steps[worst]) if measured else '-', limit, meaning,
                      finding(log, name) + ('' if verdict == 'ok' else f'. To do: {remedy}')])
    whole = WORDS[int(verdicts.max())]
    return (f'<h2 id="audit">Audit: <span class="{whole}">{whole}</span></h2>\n'
            + rows(lines, ['check', 'worst', 'value', 'step', 'limit', 'meaning', 'at the end'], (2, 3)))


def finding(log: str, name: str) -> str:
    """What the log says last of a check."""
    found = re.findall(rf'^  {re.escape(name)} +(?:ok|warning|FAILED|failed) +(.*)$', log, re.M)
    return found[-1] if found else ''


def convergence(log: str, folder: str) -> str:
    """Residuals of all iterations, and the warnings of the log."""
    found = [(int(s), int(i), float(r)) for s, i, r in ITERATION.findall(log)]
    text = '<h2 id="convergence">Convergence</h2>\n'
    if found:
        plt = style.pyplot()
        figure, axes = plt.subplots(figsize=(6.4, 2.6))
        residual = np.array([max(item[2], 1e-300) for item in found])
        starts = [k for k, item in enumerate(found) if item[1] == 1]
        for first, last in zip(starts, starts[1:] + [len(found)]):
            axes.semilogy(range(first + 1, last + 1), residual[first:last], '.-', color=style.BLUE,
                          linewidth=0.8, markersize=3)
        axes.set_xlabel('iterations of the run; a line for each load step')
        axes.set_ylabel('residual norm (force)')
        path = os.path.join(folder, 'convergence.svg')
        figure.savefig(path)
        plt.close(figure)
        text += image(path, 'residuals', 'wide')
    else:
        text += '<p>The log holds no iterations (--log brief).</p>\n'
    warnings = re.findall(r'^warning: .*$', log, re.M)
    return text + ''.join(f'<p class="warning">{html.escape(line)}</p>\n' for line in warnings)


def curves(base: str, folder: str) -> str:
    """Reactions and sums of contact over time."""
    text = '<h2 id="curves">Curves</h2>\n<div class="pictures">\n'
    for ending, wanted, label in (('.rea', [], 'reactions (force)'),
                                  ('.con', ['Fn', 'Ft'], 'contact forces (force)'),
                                  ('.con', ['Ft/Fn'], 'mobilised friction'),
                                  ('.con', ['active', 'stick', 'slip'], 'contact points'),
                                  ('.his', [], 'displacements (length)')):
        try:
            found = plots.curves([base + ending], 'time', wanted)
        except TableError:
            continue
        path = os.path.join(folder, 'curves.svg')
        plots.plot(found, path, y_label=label)
        text += image(path, label)
    return text + '</div>\n'


def drawn(made: list[scenes.Scene], folder: str) -> str:
    """Scenes as pictures, two in a row; without PyVista what to install."""
    if not drawing.has_pyvista():
        return "<p>Pictures want PyVista: <code>pip install 'mfec[pictures]'</code></p>\n"
    text = '<div class="pictures">\n'
    for scene in made:
        path = os.path.join(folder, 'picture.png')
        drawing.draw(scene, path)
        text += image(path, f'{scene.title}: {scene.label}')
    return text + '</div>\n'


def pictures(results: Results, base: str, folder: str) -> str:
    """The last output time: stresses, and pressure and status of each pair."""
    text = '<h2 id="pictures">Pictures of the last output time</h2>\n'
    made = []
    if results.steps and 'stress' in results.vtk['CellData']:
        made.append(scenes.bodies(results))
    elif results.steps and 'displacement' in results.vtk['PointData']:
        made.append(scenes.bodies(results, name='displacement'))
    path = base + '.contact.vtkhdf'
    if os.path.exists(path):
        with Surfaces(path) as surfaces:
            for pair in surfaces.pairs if surfaces.steps else ():
                for name in ('pressure', 'status'):
                    try:
                        made.append(scenes.contact(surfaces, name=name, pairs=[pair]))
                    except KeyError:
                        continue  # a slave of single nodes
    if not made:
        return text + '<p>The run has written no fields (OUTPut FIELds NONE).</p>\n'
    return text + drawn(made, folder)


def fields(results: Results, base: str) -> str:
    """Each field: its unit, its range at the last output time, what it is."""
    lines = field_rows(results.vtk, 'of the bodies')
    path = base + '.contact.vtkhdf'
    if os.path.exists(path):
        with Surfaces(path) as surfaces:
            lines += field_rows(surfaces.vtk, 'of contact surfaces')
    if not lines:
        return ''
    return '<h2 id="fields">Fields</h2>\n' + rows(lines, ['field', '', 'unit', 'least', 'largest',
                                                          'meaning'], (3, 4))


def field_rows(vtk: Any, where: str) -> list[list[str]]:
    """Rows of one file; vectors by their lengths, of tensors the components."""
    steps, lines = int(vtk['Steps'].attrs['NSteps']), []
    for group, count in (('PointData', 'NumberOfPoints'), ('CellData', 'NumberOfCells')):
        for name, data in vtk[group].items() if steps else ():
            if data.dtype.kind != 'f':
                continue
            first = int(vtk['Steps'][group + 'Offsets'][name][steps - 1])
            values = data[first:first + int(vtk[count][0])]
            values = scenes.lengths(values) if values.shape[1:] == (3,) else values
            values = values[np.isfinite(values)]
            unit, meaning = (text_of(data.attrs[key]) if key in data.attrs else ''
                             for key in ('unit', 'description'))
            ends = [f'{end + 0.0:.4g}' for end in (values.min(), values.max())] if values.size else ['-'] * 2
            place = 'nodes ' if group == 'PointData' else 'elements ' if 'bodies' in where else 'facets '
            lines.append([name, place + where, scenes.Units().label('', unit).strip(' ()'), *ends,
                          meaning])
    return lines


def costs(results: Results, log: str) -> str:
    """What the run cost; it is in the file when the run has ended."""
    text = '<h2 id="cost">Cost</h2>\n'
    run = results.file['run']
    if 'cost_names' not in run:
        return text + '<p>The run has not ended: there is no table of costs.</p>\n'
    for line in re.findall(r'^\d+ increments?, .*$', log, re.M):
        text += f'<p>{html.escape(line)}</p>\n'
    lines = [[name.decode().strip(), str(int(count)), f'{float(seconds):.3f}'] for
             name, count, seconds in zip(run['cost_names'][:], run['cost_counts'][:].ravel(),
                                         run['cost_seconds'][:].ravel()) if count]
    lines += [[name.strip(), '', value] for name, value in re.findall(
        r'^(whole run|processor time of all threads|peak memory, MB) +([\d.]+)$', log, re.M)]
    return text + rows(lines, ['work', 'count', 'seconds'], (1, 2))


def write(path: str, out: str) -> str:
    """Writes the report of a results file."""
    base = os.path.splitext(path)[0]
    log = ''
    if os.path.exists(base + '.log'):
        with open(base + '.log', encoding='utf-8', errors='replace') as stream:
            log = stream.read()
    with Results(path) as results, tempfile.TemporaryDirectory() as folder:
        title = html.escape(results.text('title'))
        body = (problem(results, log) + drawn([scenes.mesh(results)], folder)
                + audit(results, log) + pictures(results, base, folder) + curves(base, folder)
                + fields(results, base) + convergence(log, folder) + costs(results, log)
                + f'<h2 id="deck">Deck</h2>\n<pre>{html.escape(results.text("deck"))}</pre>\n')
    places = re.findall(r'<h2 id="(\w+)">', body)
    links = ''.join(f'<a href="#{place}">{place}</a>' for place in places)
    with open(out, 'w', encoding='utf-8') as stream:
        stream.write(f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
                     f'<title>{title}</title><style>{CSS}</style></head>\n<body>\n<h1>{title}</h1>\n'
                     f'<nav>{links}</nav>\n{body}</body></html>\n')
    return out
