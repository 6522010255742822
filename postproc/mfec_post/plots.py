"""Curves of any columns of any tables, several runs in one figure."""
from __future__ import annotations

import os
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .tables import INTEGER, TEXT, TableError, key_of, read_table


def column(table: NDArray, name: str, path: str = 'the table') -> NDArray:
    """A column, or a quotient of two: `Ft/Fn`."""
    if name in (table.dtype.names or ()) and name not in TEXT:
        return np.asarray(table[name], dtype=float)
    over, slash, under = name.partition('/')
    if slash:
        a, b = column(table, over, path), column(table, under, path)
        return np.divide(a, b, out=np.full(len(a), np.nan), where=b != 0)
    known = [n for n in table.dtype.names or () if n not in TEXT]
    raise TableError(f'{path} has no column {name}; it has: ' + ', '.join(known))


def curves(paths: list[str], x: str, y: list[str],
           names: Optional[list[str]] = None) -> list[tuple[str, NDArray, NDArray]]:
    """Label, x and y of each curve: each column of each set or pair of each table."""
    found = []
    folders = len({os.path.dirname(os.path.abspath(p)) for p in paths}) > 1
    for path in paths:
        table = read_table(path)
        key = key_of(table)
        groups = list(dict.fromkeys(table[key])) if key else ['']
        for group in groups:
            if names and group not in names:
                continue
            rows = table[table[key] == group] if key else table
            for name in y or default_columns(table):
                label = [name] + [str(group)] * (len(groups) > 1)
                if len(paths) > 1:
                    label.append(run_name(path, folders))
                found.append((', '.join(label), column(rows, x, path), column(rows, name, path)))
    if not found:
        raise TableError('no rows of ' + ', '.join(names or paths))
    return found


def run_name(path: str, folders: bool) -> str:
    """What tells a run from the others."""
    folder, base = os.path.split(os.path.abspath(path))
    return os.path.basename(folder) if folders else base


def default_columns(table: NDArray) -> list[str]:
    """What is drawn if nobody says."""
    names = table.dtype.names or ()
    if 'R1' in names:
        return ['R1', 'R2', 'R3']
    if 'Fn' in names:
        return ['Fn', 'Ft']
    return [n for n in names if n not in INTEGER | TEXT | {'time'}][:6]


def plot(found: list[tuple[str, NDArray, NDArray]], path: str, x: str = 'time', title: str = '',
         y_label: str = '') -> None:
    """Draws curves."""
    plt = style.pyplot()
    figure, axes = plt.subplots(figsize=(6.4, 4.0))
    colours = [style.BLUE, style.RED, style.GREEN, style.ORANGE, style.GREY]
    lines = ['-', '--', ':', '-.']
    for k, (label, a, b) in enumerate(found):
        axes.plot(a, b, lines[k // len(colours) % len(lines)], color=colours[k % len(colours)],
                  label=label, marker='.' if len(a) < 3 else None)
    axes.set_xlabel(x)
    axes.set_ylabel(y_label or (found[0][0] if len(found) == 1 else ''))
    axes.margins(x=0.02)
    if title:
        axes.set_title(title, fontsize=9)
    if len(found) > 1:
        axes.legend(loc='center left', bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path)
    plt.close(figure)
