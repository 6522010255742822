"""Follows a run while it goes on: residuals of its log and reactions of its table, drawn or as text."""
from __future__ import annotations

import argparse
import fcntl
import os
import re
import sys
import time
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from .tables import TableError, read_table

SOLVE = re.compile(r'step +(\d+) time +(\S+) iteration +(\d+) +Residual norm = +(\S+)')
LAST = re.compile(r'^(whole run +[\d.]+|stopped by .*|error: .*)$', re.M)
BARS = ' .:-=+*#%@'
WIDTH = 60


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument('log', help='x.log of the run; x.rea lies beside it')
    parser.add_argument('--text', action='store_true', help='in the terminal, also where there are windows')
    parser.add_argument('--out', help='draws into this picture (.png) in place of a window')
    parser.add_argument('--every', type=float, default=1.0, metavar='SECONDS', help='how often (default 1)')


class Watched:
    """What the files of a run say at the moment."""

    def __init__(self, log: str):
        self.log, self.reactions = log, os.path.splitext(log)[0] + '.rea'
        self.rest, self.read = b'', 0
        self.solves: list[tuple[int, float, float]] = []
        self.curves: dict[str, tuple[NDArray, NDArray]] = {}

    def look(self) -> bool:
        """Reads what is new; whether there was something."""
        with open(self.log, 'rb') as stream:
            if os.fstat(stream.fileno()).st_size < self.read:  # another run has begun it anew
                self.rest, self.read, self.solves = b'', 0, []
            stream.seek(self.read)
            new = stream.read()
            self.read = stream.tell()
        whole, _, self.rest = (self.rest + new).rpartition(b'\n')
        for step, at, _, norm in SOLVE.findall(whole.decode('utf-8', 'replace')):
            self.solves.append((int(step), float(at), float(norm)))
        try:
            table = read_table(self.reactions)
        except TableError:
            return bool(new)
        force = ('R1', 'R2', 'R3')
        largest = max((np.abs(table[which]).max(initial=0.0) for which in force), default=0.0)
        self.curves = {f'{name} {which}': (rows['time'], rows[which]) for name in dict.fromkeys(table['set'])
                       for rows in [table[table['set'] == name]] for which in force
                       if np.abs(rows[which]).max(initial=0.0) > 1e-9 * largest}
        return bool(new)

    def ended(self) -> Optional[str]:
        """How the run has ended; None while it goes on, that is while it holds the lock of its log."""
        with open(self.log, encoding='utf-8', errors='replace') as stream:
            try:
                fcntl.flock(stream, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return None
            fcntl.flock(stream, fcntl.LOCK_UN)
            said = [match.group(1) for match in LAST.finditer(stream.read())]
        trouble = [line for line in said if not line.startswith('whole run')]
        return trouble[-1] if trouble else 'done' if said else 'killed: its log has no end'


def bar(values: NDArray, logarithmic: bool = False) -> str:
    """A line of characters, the higher the darker; the newest value is the last."""
    values = np.asarray(values, dtype=float)[-WIDTH:]
    if logarithmic:
        values = np.log10(np.maximum(np.abs(values), 1e-300))
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)
    level = (values - low) / ((high - low) or 1.0) * (len(BARS) - 1)
    return ''.join(BARS[round(float(one))] for one in level)


def as_text(run: Watched) -> list[str]:
    """Lines for a terminal."""
    if not run.solves:
        return [f'{run.log}: no linear solve yet']
    step, at, norm = run.solves[-1]
    found = [f'{run.log}: step {step}, time {at:g}, {len(run.solves)} solves',
             f'{"residual":12.12} {norm:12.4g} |{bar(np.array([s[2] for s in run.solves]), True):{WIDTH}}|']
    return found + [f'{name:12.12} {rows[-1]:12.5g} |{bar(rows):{WIDTH}}|'
                    for name, (_, rows) in run.curves.items() if len(rows)]


def draw(figure: Any, run: Watched) -> None:
    """Residual of each solve above, reactions over time below."""
    figure.clear()
    above, below = figure.subplots(2, 1)
    above.semilogy(range(1, len(run.solves) + 1), [max(s[2], 1e-300) for s in run.solves], lw=0.8)
    above.set_xlabel('linear solves')
    above.set_ylabel('residual')
    for name, (times, rows) in run.curves.items():
        below.plot(times, rows, marker='.', lw=0.8, label=name)
    below.set_xlabel('time')
    below.set_ylabel('reactions')
    if run.curves:
        below.legend(fontsize=7)
    figure.suptitle(as_text(run)[0], fontsize=9)
    figure.tight_layout()


def window(given: argparse.Namespace) -> Any:
    """A figure to draw in; None where text is wanted or nothing else can be had."""
    if given.out:
        from matplotlib.figure import Figure
        return Figure(figsize=(7, 6))
    if given.text or not (os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY')):
        return None
    import matplotlib.pyplot as plt
    plt.ion()
    return plt.figure(figsize=(7, 6)) if plt.get_backend().lower() != 'agg' else None


def show(figure: Any, run: Watched, given: argparse.Namespace, before: int) -> int:
    """Shows where the run is; the lines of a terminal that the next look writes over."""
    if figure is not None:
        draw(figure, run)
        if given.out:
            figure.savefig(given.out + '.part', format=os.path.splitext(given.out)[1][1:] or 'png', dpi=150)
            os.replace(given.out + '.part', given.out)  # who looks at it never sees half of it
        return 0
    lines = as_text(run)
    sys.stdout.write(f'\x1b[{before}A\x1b[J' if before and sys.stdout.isatty() else '')
    print('\n'.join(lines), flush=True)
    return len(lines)


def main(given: argparse.Namespace) -> int:
    """Watches until the run has ended; exit code 0 if it is done, 1 if something has stopped it."""
    figure, lines = window(given), 0
    run = Watched(given.log)
    while True:
        end = run.ended()  # first, so that what it wrote at last is read
        if run.look() or end:
            lines = show(figure, run, given, lines)
        if end:
            print(f'{given.log}: {end}')
            return 0 if end == 'done' else 1
        if figure is not None and not given.out:
            figure.canvas.start_event_loop(given.every)
        else:
            time.sleep(given.every)
