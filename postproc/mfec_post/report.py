"""One HTML file of a run, that needs no network: what was run, audit, curves, convergence, costs,
pictures."""
from __future__ import annotations

import base64
import html
import os
import re
import tempfile

import numpy as np

from . import plots, style
from . import scene as scenes
from .results import Results
from .surfaces import Surfaces
from .tables import TableError

CSS = ('body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}'
       'img{max-width:100%}pre{background:#f6f6f6;padding:.8em;overflow:auto;font-size:12px}'
       'table{border-collapse:collapse}td,th{padding:.15em .9em .15em 0;text-align:left}'
       'td.n{text-align:right}.warning{color:#a60}.failed{color:#c00}')
ITERATION = re.compile(r'^step +(\d+) time +\S+ iteration *(\d+) +Residual norm = *(\S+)', re.M)


def image(path: str, text: str) -> str:
    """A picture inside the page."""
    with open(path, 'rb') as stream:
        data = base64.b64encode(stream.read()).decode('ascii')
    return f'<p><img alt="{html.escape(text)}" src="data:image/png;base64,{data}"></p>\n'


def rows(lines: list[list[str]], head: list[str]) -> str:
    """A table."""
    text = '<table><tr>' + ''.join(f'<th>{h}</th>' for h in head) + '</tr>\n'
    for line in lines:
        text += '<tr>' + ''.join(f'<td class="{"n" if k else ""}">{html.escape(v)}</td>'
                                 for k, v in enumerate(line)) + '</tr>\n'
    return text + '</table>\n'


def head(results: Results) -> str:
    """What was run."""
    size = [('program', results.text('version')), ('command', results.text('settings')),
            ('nodes, elements', f'{len(results.points)}, {len(results.cells)}'),
            ('end times with fields', str(results.steps)),
            ('contact pairs', ', '.join(results.pairs) or 'none')]
    return rows([list(item) for item in size], ['', ''])


def audit(results: Results) -> str:
    """The worst verdict of each check over the run, and the value then."""
    if 'audit' not in results.file or len(results.file['audit/step']) == 0:
        return ''
    group = results.file['audit']
    names = [name.decode().strip() for name in group['checks'][:]]
    verdicts, values, steps = (group[n][:] for n in ('verdict', 'value', 'step'))
    words = ('ok', 'warning', 'failed')
    lines = []
    for k, name in enumerate(names):
        worst = int(np.lexsort((values[:, k], verdicts[:, k]))[-1])
        measured = values[worst, k] >= 0
        lines.append([name, words[verdicts[worst, k]],
                      f'{values[worst, k]:.3g}' if measured else '-',
                      str(steps[worst]) if measured else '-'])
    return '<h2>Audit</h2>\n' + rows(lines, ['check', 'worst verdict', 'value', 'step'])


def convergence(log: str, folder: str) -> str:
    """Residuals of all iterations, and the warnings of the log."""
    found = [(int(s), int(i), float(r)) for s, i, r in ITERATION.findall(log)]
    text = '<h2>Convergence</h2>\n'
    if found:
        plt = style.pyplot()
        figure, axes = plt.subplots(figsize=(6.4, 2.8))
        residual = np.array([max(item[2], 1e-300) for item in found])
        starts = [k for k, item in enumerate(found) if item[1] == 1]
        for first, last in zip(starts, starts[1:] + [len(found)]):
            axes.semilogy(range(first, last), residual[first:last], '.-', color=style.BLUE,
                          linewidth=0.8, markersize=3)
        axes.set_xlabel('iteration')
        axes.set_ylabel('residual norm [force]')
        path = os.path.join(folder, 'convergence.png')
        figure.savefig(path)
        plt.close(figure)
        text += image(path, 'residuals')
    else:
        text += '<p>The log holds no iterations (--log brief).</p>\n'
    closing = re.findall(r'^\d+ increments?, .*$', log, re.M)
    warnings = re.findall(r'^warning: .*$', log, re.M)
    text += ''.join(f'<p>{html.escape(line)}</p>\n' for line in closing)
    return text + ''.join(f'<p class="warning">{html.escape(line)}</p>\n' for line in warnings)


def curves(base: str, folder: str) -> str:
    """Reactions and sums of contact over time."""
    text = '<h2>Curves</h2>\n'
    for ending, wanted, label in (('.rea', [], 'reactions [force]'),
                                  ('.con', ['Fn', 'Ft'], 'contact forces [force]'),
                                  ('.con', ['Ft/Fn'], 'mobilised friction'),
                                  ('.his', [], 'displacements [length]')):
        try:
            found = plots.curves([base + ending], 'time', wanted)
        except TableError:
            continue
        path = os.path.join(folder, 'curves.png')
        plots.plot(found, path, y_label=label)
        text += image(path, label)
    return text


def pictures(results: Results, base: str, folder: str, renderer: str) -> str:
    """The last end time: stresses, and each pair."""
    text = '<h2>Pictures</h2>\n'
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
    for k, scene in enumerate(made):
        path = os.path.join(folder, f'{k}.png')
        scenes.draw(scene, path, renderer)
        text += image(path, scene.title)
    return text


def costs(results: Results) -> str:
    """What the run cost; it is in the file when the run has ended."""
    run = results.file['run']
    if 'cost_names' not in run:
        return '<p>The run has not ended: there is no table of costs.</p>\n'
    lines = [[name.decode().strip(), str(int(count)), f'{float(seconds):.3f}'] for
             name, count, seconds in zip(run['cost_names'][:], run['cost_counts'][:].ravel(),
                                         run['cost_seconds'][:].ravel())]
    return '<h2>Costs</h2>\n' + rows(lines, ['work', 'count', 'seconds'])


def write(path: str, out: str, renderer: str = 'auto') -> str:
    """Writes the report of a results file."""
    base = os.path.splitext(path)[0]
    log = ''
    if os.path.exists(base + '.log'):
        with open(base + '.log', encoding='utf-8', errors='replace') as stream:
            log = stream.read()
    with Results(path) as results, tempfile.TemporaryDirectory() as folder:
        title = html.escape(results.text('title'))
        body = (f'<h1>{title}</h1>\n' + head(results) + audit(results) + curves(base, folder)
                + pictures(results, base, folder, renderer) + convergence(log, folder)
                + costs(results)
                + f'<h2>Deck</h2>\n<pre>{html.escape(results.text("deck"))}</pre>\n')
    with open(out, 'w', encoding='utf-8') as stream:
        stream.write(f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
                     f'<title>{title}</title><style>{CSS}</style></head>\n<body>\n{body}'
                     '</body></html>\n')
    return out
