"""The text tables .rea, .con, .rig, .his and .pts as numpy structured arrays."""
from __future__ import annotations

from typing import Optional

import numpy as np
from numpy.typing import NDArray

TEXT = {'set', 'pair', 'body', 'quantity', 'parameter'}
INTEGER = {'step', 'active', 'stick', 'slip', 'kinks', 'point', 'status'}


class TableError(Exception):
    """A table that cannot be read: no such file, no header, a broken row."""


def column_type(name: str) -> str:
    """The numpy type of a column."""
    if name in TEXT:
        return 'U31'
    return 'i8' if name in INTEGER else 'f8'


def read_table(path: str) -> NDArray:
    """All rows of a table; the columns are named by the last header line.

    A last line without its end, as a killed run may leave it, is dropped.
    """
    try:
        with open(path, encoding='utf-8') as stream:
            text = stream.read()
    except (OSError, UnicodeDecodeError) as problem:
        raise TableError(f'cannot read {path}: {problem}') from problem
    names, rows = None, []
    lines = text.split('\n')[:-1]
    for number, line in enumerate(lines, 1):
        if line.startswith('#'):
            names = line[1:].split()
        elif line.strip():
            rows.append((number, line.split()))
    if not names or names[0] != 'step':
        raise TableError(f'{path}: no header line with the names of the columns')
    kinds = {name: column_type(name) for name in names}
    if 'point' in kinds:
        kinds['slip'] = 'f8'  # a way, in the table of points; in others a count
    table = np.zeros(len(rows), dtype=list(kinds.items()))
    for i, (number, words) in enumerate(rows):
        if len(words) != len(names):
            raise TableError(f'{path}:{number}: {len(words)} items, {len(names)} columns')
        try:
            table[i] = tuple(words)
        except ValueError as problem:
            raise TableError(f'{path}:{number}: {problem}') from problem
    return table


def rows_of(table: NDArray, name: str) -> NDArray:
    """The rows of one set, pair or rigid body."""
    key = key_of(table)
    if key is None:
        raise TableError('the table has no column set, pair or body')
    rows = table[table[key] == name]
    if len(rows) == 0:
        known = ', '.join(sorted(set(table[key])))
        raise TableError(f'the table has no {key} {name!r}; it has: {known}')
    return rows


def key_of(table: NDArray) -> Optional[str]:
    """The name of the column of names, None if there is none."""
    for key in ('set', 'pair', 'body'):
        if key in (table.dtype.names or ()):
            return key
    return None
