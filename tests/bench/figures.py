"""Log-log figures: time against size and against error."""
import csv
import hashlib
import os
import types

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402

COLOURS = {'bare CHOLMOD': '#555555',
           'mfec AUTO': '#0b6e4f', 'mfec UMFP': '#8fbf9f', 'mfec REDU': '#1b9e77',
           'mfec CHOL': '#66a61e', 'mfec AUTO GTOS': '#e7a100', 'CalculiX N2S default': '#a6341b',
           'CalculiX N2S iterative': '#e0765c', 'CalculiX S2S default': '#3b5b92',
           'CalculiX S2S iterative': '#8aa6d6', 'mfec AUTO GTOS 6, ten nodes': '#7b3294',
           'mfec AUTO SEGMent, ten nodes': '#c2a5cf', 'CalculiX N2S iterative, ten nodes': '#d01c8b',
           'CalculiX S2S iterative, ten nodes': '#4dac26'}


def series(found, scene, x, y, smallest=0.0):
    """Curves {label: [(x, y)]} of the complete runs of a scene."""
    curves = {}
    for job, result in found.items():
        if job.scene == scene and job.threads == 1 and not job.limit and result['code'] == 0:
            points = x(job, result), y(job, result)
            if None not in points and min(points) > smallest:
                curves.setdefault(label(job), []).append(points)
    return {name: sorted(points) for name, points in curves.items()}


def hertz(found, what):
    """Curves of Hertz, on elements of four nodes and of ten."""
    curves = series(found, 'hertz', cpu, error(what))
    curves.update({f'{name}, ten nodes': points
                   for name, points in series(found, 'hertz_ten', cpu, error(what)).items()})
    return curves


def label(job):
    """What the legend and the tables call a mode; a row of results.csv says it itself."""
    if isinstance(job, Row):
        return job.program
    if job.mode == 'bare CHOLMOD':
        return job.mode
    name = ('CalculiX ' if job.of_calculix() else 'mfec ') + job.mode
    if job.threads > 1:
        name += f' --threads {job.threads}'
    return name + (f' {job.method}' if job.method != 'NTOS' else '')


class Row(types.SimpleNamespace):
    """A run as results.csv tells it."""

    __hash__ = object.__hash__


def read_csv(path):
    """What results.csv holds, as `draw` wants it."""
    found = {}
    with open(path, encoding='utf-8', newline='') as stream:
        for line in csv.DictReader(stream):
            result = {name: number(value) for name, value in line.items()}
            found[Row(scene=line['scene'], program=line['program'], size=float(line['size']),
                      threads=threads_of(line['program']),
                      limit=line['complete'] == 'no')] = result
    return found


def threads_of(program):
    """How many threads a row's program had."""
    words = program.split()
    return int(words[words.index('--threads') + 1]) if '--threads' in words else 1


def number(text):
    """A number, None for an empty cell, else the text."""
    try:
        return float(text) if text else None
    except ValueError:
        return text


def digest(path):
    """What the figures carry of the file they show."""
    with open(path, 'rb') as stream:
        return hashlib.sha256(stream.read()).hexdigest()[:16]


def size(job, result):
    """Number of degrees of freedom."""
    return result['dofs']


def cpu(job, result):
    """Processor time."""
    return result['cpu']


def panel(axes, curves, across, up, title, legend='best'):
    """One set of curves; legend: where, None for nowhere."""
    for name, points in curves.items():
        axes.loglog(*zip(*points), 's--' if 'ten nodes' in name else 'o-', label=name, color=COLOURS.get(name), markersize=4,
                    linewidth=2.2 if name.startswith('mfec AUTO') else 1.2)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_title(title, fontsize=9)
    axes.grid(True, which='both', linewidth=0.3)
    if curves and legend:
        axes.legend(fontsize=7, loc=legend, bbox_to_anchor=(1.02, 1) if legend == 'upper left' else None)


def error(name):
    """The size of an error in percent."""
    return lambda job, result: None if result.get(name) is None else 100*abs(result[name])


def draw(folder, found):
    """time_size.png and time_error.png."""
    time = 'processor time [s]'
    figure, axes = plt.subplots(1, 2, figsize=(8.5, 3.2))
    panel(axes[0], series(found, 'cube', size, cpu), 'degrees of freedom', time,
          'sliding cube, 22 increments', None)
    panel(axes[1], series(found, 'cube', size, lambda j, r: r['memory']), 'degrees of freedom',
          'peak memory [MB]', 'sliding cube', 'upper left')
    save(figure, folder, 'time_size.png')
    figure, axes = plt.subplots(2, 2, figsize=(8.5, 6.0))
    panel(axes[0, 0], hertz(found, 'pressure_error'), time,
          'error of the peak pressure [%]', 'Hertz: peak pressure of the computed force', None)
    panel(axes[0, 1], hertz(found, 'force_error'), time,
          'error of the force [%]', 'Hertz: force at given approach', 'upper left')
    panel(axes[1, 0], series(found, 'cantilever', cpu, error('tip_error')), time,
          'error of the tip deflection [%]', 'cantilever, no contact')
    panel(axes[1, 1], series(found, 'cube', cpu, error('T/N_error')), time,
          'error of T/N on the plateau [%]', 'sliding cube', 'upper left')
    save(figure, folder, 'time_error.png')


def save(figure, folder, name):
    """Writes a figure without the date, so that equal figures are equal files."""
    figure.tight_layout()
    shown = digest(os.path.join(folder, 'results.csv'))
    figure.savefig(os.path.join(folder, name), dpi=300, metadata={'Software': None, 'Source': shown})
    plt.close(figure)
