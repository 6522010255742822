"""Compares two tables row by row, with tolerances for each column.

A number passes if its error is at most abs + rel * size, size being the largest magnitude of that
column in the reference: a component that should be zero is measured against its column.
"""
from __future__ import annotations

import argparse
import sys
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from .tables import INTEGER, TEXT, TableError, key_of, read_table


def tolerance(text: str) -> tuple[str, float, float]:
    """`R1=1e-6` or `R1=1e-6,1e-9`: the column, its relative and its absolute tolerance."""
    name, _, numbers = text.partition('=')
    try:
        values = [float(number) for number in numbers.split(',')]
    except ValueError:
        values = []
    if not name or len(values) not in (1, 2) or min(values, default=0) < 0:
        raise argparse.ArgumentTypeError(f'{text!r} is not COLUMN=REL or COLUMN=REL,ABS')
    return name, values[0], (values + [0.0])[1]


def compare_tables(reference: NDArray, table: NDArray, rel: float = 1e-6, absolute: float = 0.0,
                   columns: Optional[dict[str, tuple[float, float]]] = None) -> list[str]:
    """Findings: one text for each column that differs; none if the tables agree."""
    columns = columns or {}
    names, found = reference.dtype.names or (), table.dtype.names or ()
    if names != found:
        return [f'columns differ: {" ".join(names)} against {" ".join(found)}']
    unknown = sorted(set(columns) - set(names))
    if unknown:
        raise TableError('no such column: ' + ', '.join(unknown))
    if len(reference) != len(table):
        return [f'{len(reference)} rows in the reference, {len(table)} in the table']
    findings: list[str] = []
    for name in names:
        own_rel, own_absolute = columns.get(name, (rel, absolute))
        findings += compare_column(reference, table, name, own_rel, own_absolute, name in columns)
    return findings


def compare_column(reference: NDArray, table: NDArray, name: str, rel: float, absolute: float,
                   asked: bool) -> list[str]:
    """The finding of one column; integers are exact unless a tolerance is asked for."""
    old, new = reference[name], table[name]
    if name in TEXT or (name in INTEGER and not asked):
        wrong = np.flatnonzero(old != new)
        if len(wrong) == 0:
            return []
        row = wrong[0]
        return [f'{name}: {len(wrong)} of {len(old)} rows differ, first {where(reference, row)}: '
                f'{old[row]}, found {new[row]}']
    error = np.abs(new - old)
    error[~np.isfinite(error)] = np.inf
    limit = absolute + rel * np.max(np.abs(old), initial=0.0)
    if not np.any(error > limit):
        return []
    row = int(np.argmax(error))
    return [f'{name}: {np.count_nonzero(error > limit)} of {len(old)} rows differ, worst '
            f'{where(reference, row)}: {old[row]:.12g}, found {new[row]:.12g}, '
            f'error {error[row]:.3g} above {limit:.3g}']


def where(table: NDArray, row: int) -> str:
    """A row in words."""
    key = key_of(table)
    place = f'step {table["step"][row]}'
    return place if key is None else f'{place} {table[key][row]}'


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit code 0: the tables agree; 1: they differ; 2: they cannot be compared."""
    parser = argparse.ArgumentParser(prog='compare', description=__doc__)
    parser.add_argument('reference')
    parser.add_argument('table')
    parser.add_argument('--rel', type=float, default=1e-6, help='relative to the largest '
                        'magnitude of the column (default %(default)g)')
    parser.add_argument('--abs', type=float, default=0.0, dest='absolute',
                        help='absolute (default %(default)g)')
    parser.add_argument('--column', type=tolerance, action='append', default=[],
                        metavar='NAME=REL[,ABS]', help='tolerances of one column')
    options = parser.parse_args(arguments)
    columns = {name: (rel, absolute) for name, rel, absolute in options.column}
    try:
        findings = compare_tables(read_table(options.reference), read_table(options.table),
                                  options.rel, options.absolute, columns)
    except TableError as problem:
        print(f'compare: {problem}', file=sys.stderr)
        return 2
    for finding in findings:
        print(finding)
    if findings:
        print(f'{options.table} differs from {options.reference}')
    return 1 if findings else 0
