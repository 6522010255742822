"""A picture of the deformed bodies and of what happens between them.

Left: the outer facets in the deformed state, coloured by stress or displacement. Right: the slave
surfaces of all pairs, or of one: stick or slip, shear traction, and the lay where friction has one.
"""
from __future__ import annotations

import argparse
import os
import sys
from typing import Optional

from . import drawing, scene
from .results import Results
from .surfaces import Surfaces, surfaces_beside

FIELDS = ('mises', 'pressure', 'displacement') + scene.STRESSES


def plot(results: Results, path: str, frame: int = -1, field: str = 'mises',
         pair: Optional[str] = None, scale: float = 1.0,
         view: tuple[float, float] = scene.FRONT) -> None:
    """Draws one output time and writes the picture."""
    frame = results.index(frame)
    shown = [scene.bodies(results, frame, field, scale, view)]
    if results.pairs and os.path.exists(surfaces_beside(results.path)):
        with Surfaces(surfaces_beside(results.path)) as surfaces:
            shown.append(scene.contact(surfaces, frame, 'status', [pair] if pair else None,
                                       scale=scale))
    drawing.draw_row(shown, path, (87.0, 75.0))


def main(arguments: Optional[list[str]] = None) -> int:
    """Draws one output time of the results file on the command line."""
    parser = argparse.ArgumentParser(prog='plot_cube', description=__doc__)
    parser.add_argument('results', help='.vtkhdf file')
    parser.add_argument('--out', default='cube.png', help='picture (.png, .pdf, .svg)')
    parser.add_argument('--frame', type=int, default=-1, help='output time, from 0 (default: last)')
    parser.add_argument('--field', choices=FIELDS, default='mises', help='what colours the facets')
    parser.add_argument('--pair', help='contact pair (default: all)')
    parser.add_argument('--scale', type=float, default=1.0, help='magnifies the displacements')
    parser.add_argument('--view', type=float, nargs=2, default=scene.FRONT,
                        metavar=('AZIMUTH', 'ELEVATION'))
    options = parser.parse_args(arguments)
    try:
        with Results(options.results) as results:
            plot(results, options.out, options.frame, options.field, options.pair, options.scale,
                 tuple(options.view))
    except (OSError, KeyError, IndexError) as problem:
        print(f'plot_cube: {problem}', file=sys.stderr)
        return 2
    print(options.out)
    return 0
