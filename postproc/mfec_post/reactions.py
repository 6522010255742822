"""The reaction curves of the sliding cube, as the paper's Fig. 6 shows them, and T/N below; no data of the paper."""
from __future__ import annotations

import argparse
import os
import sys
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .results import Results
from .tables import TableError, read_table, rows_of

# Name of a run, its label, colour and line. MFC is Coulomb's law, MFEC the elliptical one.
LOOKS = {
    'mfc_0.10': ('MFC, $\\mu$ = 0.1', style.GREY, '-', 3.6),
    'mfc_0.08': ('MFC, $\\mu$ = 0.08', '#b0b0b0', '-', 3.6),
    'mfec_00': ('MFEC, $\\varphi$ = 0°', style.BLUE, '--', 1.4),
    'mfec_45': ('MFEC, $\\varphi$ = 45°', style.RED, '-', 1.8),
    'mfec_90': ('MFEC, $\\varphi$ = 90°', style.GREEN, '--', 1.4),
}


class Curve:
    """Reactions of one set over its displacement, direction 1 being the way."""

    def __init__(self, path: str, set_name: str = 'top', name: Optional[str] = None):
        base = os.path.splitext(path)[0]
        rows = rows_of(read_table(base + '.rea'), set_name)
        self.name = name or os.path.basename(os.path.dirname(os.path.abspath(path)))
        self.time = rows['time']
        self.tangential = rows['R1']
        self.lateral = rows['R2']
        self.normal = -rows['R3']
        self.displacement = displacement_at(base + '.vtkhdf', set_name, self.time)

    @property
    def ratio(self) -> NDArray:
        """T/N, not a number where nothing presses."""
        pressed = np.abs(self.normal) > 1e-9 * np.max(np.abs(self.normal), initial=0.0)
        return np.divide(self.tangential, self.normal, where=pressed,
                         out=np.full_like(self.normal, np.nan))


def displacement_at(path: str, set_name: str, times: NDArray) -> NDArray:
    """Displacement along 1 of a set at the times of the table's rows."""
    with Results(path) as run:
        u = run.set_displacement(set_name)[:, 0]
        if len(u) == 0:
            raise TableError(f'{path} holds no fields yet')
        return np.interp(times, run.times, u)


def sliding(curve: Curve) -> slice:
    """The rows of the way along 1: from the last row before it moves."""
    moved = np.flatnonzero(np.abs(curve.displacement) > 0)
    start = max(moved[0] - 1, 0) if len(moved) else 0
    return slice(start, None)


def plot(curves: list[Curve], path: str, length: str = '', force: str = '') -> None:
    """Draws the curves and writes the picture."""
    plt = style.pyplot()
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(6.3, 6.6), sharex=True,
                                          gridspec_kw={'height_ratios': [1.15, 1], 'hspace': 0.1})
    spare = iter([style.BLUE, style.RED, style.GREEN, style.ORANGE, style.GREY] * 9)
    for curve in curves:
        look = LOOKS.get(curve.name)
        label, colour, line, width = look or (curve.name, next(spare), '-', 1.6)
        part = sliding(curve)
        for axes, values in ((upper, curve.tangential), (lower, curve.ratio)):
            axes.plot(curve.displacement[part], values[part], line, color=colour,
                      linewidth=width, label=label, solid_capstyle='round')
    upper.set_ylabel('tangential reaction T' + unit(force))
    lower.set_ylabel('T / N')
    lower.set_xlabel('displacement of the clamped and moved nodes' + unit(length))
    for axes in (upper, lower):
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        axes.margins(x=0)
        axes.set_xlim(left=0)
    label_ends(lower, curves)
    upper.legend(loc='lower right', ncol=1, handlelength=2.6)
    figure.align_ylabels()
    figure.savefig(path)
    plt.close(figure)


def unit(name: str) -> str:
    """A unit for the label of an axis."""
    return f' [{name}]' if name else ''


def label_ends(axes: Any, curves: list[Curve]) -> None:
    """Writes the last T/N beside the curves, one label for those that end together."""
    ends = sorted((curve.ratio[-1], curve.displacement[-1]) for curve in curves
                  if len(curve.ratio) and np.isfinite(curve.ratio[-1]))
    span = np.diff(axes.get_ylim())[0]
    groups: list[list[tuple[float, float]]] = []
    for value, x in ends:
        if groups and value - groups[-1][-1][0] < 0.035 * span:
            groups[-1].append((value, x))
        else:
            groups.append([(value, x)])
    for group in groups:
        value = np.mean([item[0] for item in group])
        axes.annotate(f'{value:.4f}', (max(item[1] for item in group), value), xytext=(5, 0),
                      textcoords='offset points', va='center', fontsize=8, annotation_clip=False)


def main(arguments: Optional[list[str]] = None) -> int:
    """Draws the runs named on the command line."""
    parser = argparse.ArgumentParser(prog='plot_reactions', description=__doc__)
    parser.add_argument('runs', nargs='+', help='.rea files; their .vtkhdf lie beside them')
    parser.add_argument('--set', default='top', dest='set_name', help='node set (default top)')
    parser.add_argument('--out', default='reactions.png', help='picture (.png, .pdf, .svg)')
    parser.add_argument('--length', default='', help='unit of length for the labels')
    parser.add_argument('--force', default='', help='unit of force for the labels')
    options = parser.parse_args(arguments)
    try:
        curves = [Curve(path, options.set_name) for path in options.runs]
    except (TableError, OSError, KeyError) as problem:
        print(f'plot_reactions: {problem}', file=sys.stderr)
        return 2
    plot(curves, options.out, options.length, options.force)
    print(options.out)
    return 0
