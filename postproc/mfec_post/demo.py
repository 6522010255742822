"""The paper's example, with data of our own, in one command: five runs, figures and a small table.

MFC is Coulomb's law with mu 0.1 and 0.08; MFEC the elliptical law with mu1 = 0.1 along the lay and
mu2 = 0.08 across it, the lay turned by 0, 45 and 90 degrees against the direction of sliding.
"""
from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from typing import Optional

import numpy as np

from .cube import plot as plot_cube
from .drawing import has_pyvista
from .reactions import Curve, plot as plot_reactions
from .results import Results
from .tables import TableError

# Name, what it is, mu1, mu2, phi.
RUNS = [
    ('mfc_0.10', 'MFC   mu 0.1', 0.1, 0.1, 0),
    ('mfc_0.08', 'MFC   mu 0.08', 0.08, 0.08, 0),
    ('mfec_00', 'MFEC  phi 0', 0.1, 0.08, 0),
    ('mfec_45', 'MFEC  phi 45', 0.1, 0.08, 45),
    ('mfec_90', 'MFEC  phi 90', 0.1, 0.08, 90),
]


def closed_form(mu1: float, mu2: float, phi: float) -> float:
    """T/N on a flat rigid base, slip along the way: the radius of the friction ellipse."""
    c, s = np.cos(np.radians(phi)), np.sin(np.radians(phi))
    return mu1 * mu2 / np.hypot(mu2 * c, mu1 * s)


def run_all(program: str, deck: str, folder: str) -> Optional[list[str]]:
    """Runs the five decks one after the other; the base paths of their files."""
    bases = []
    for name, what, mu1, mu2, phi in RUNS:
        out = os.path.join(folder, name)
        os.makedirs(out, exist_ok=True)
        command = [program, deck, '--set', f'mu1={mu1}', '--set', f'mu2={mu2}',
                   '--set', f'phi={phi}', '--out', out, '--quiet']
        start = time.monotonic()
        status = subprocess.run(command, check=False).returncode
        if status != 0:
            print(f'demo: {" ".join(command)} ended with exit code {status}', file=sys.stderr)
            return None
        print(f'  {what:<14} {time.monotonic() - start:6.1f} s   {out}', flush=True)
        bases.append(os.path.join(out, os.path.splitext(os.path.basename(deck))[0]))
    return bases


def table(curves: list[Curve]) -> str:
    """T/N of each run beside the closed form."""
    lines = ['', f'  {"run":<14} {"T":>10} {"N":>10} {"T/N":>10} {"flat base":>10} {"error":>8}']
    for (_, what, mu1, mu2, phi), curve in zip(RUNS, curves):
        wanted = closed_form(mu1, mu2, phi)
        ratio = curve.ratio[-1]
        lines.append(f'  {what:<14} {curve.tangential[-1]:10.4f} {curve.normal[-1]:10.4f} '
                     f'{ratio:10.6f} {wanted:10.6f} {100 * (ratio / wanted - 1):7.2f}%')
    return '\n'.join(lines)


def main(arguments: Optional[list[str]] = None) -> int:
    """Exit code 0: all five runs are done and drawn."""
    parser = argparse.ArgumentParser(prog='demo', description=__doc__)
    parser.add_argument('--program', default='./mfec')
    parser.add_argument('--deck', default='inputs/sliding_cube.inp')
    parser.add_argument('--out', default='demo', help='folder (default demo)')
    options = parser.parse_args(arguments)
    print(f'Sliding cube, five runs of {options.deck}')
    bases = run_all(options.program, options.deck, options.out)
    if bases is None:
        return 1
    try:
        curves = [Curve(base + '.rea', name=run[0]) for base, run in zip(bases, RUNS)]
        pictures = [os.path.join(options.out, 'reactions.png')]
        plot_reactions(curves, pictures[0])
        if has_pyvista():
            pictures.append(os.path.join(options.out, 'cube.png'))
            with Results(bases[3] + '.vtkhdf') as results:
                plot_cube(results, pictures[1])
    except (TableError, OSError, KeyError, IndexError) as problem:
        print(f'demo: {problem}', file=sys.stderr)
        return 2
    print(table(curves))
    print('\nFigures')
    for picture in pictures:
        print('  ' + picture)
    if not has_pyvista():
        print("  with pip install 'mfec[pictures]': a picture of the cube, too")
    print('Tables')
    for base in bases:
        print(f'  {base}.rea')
    return 0
