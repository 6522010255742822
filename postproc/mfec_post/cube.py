"""A picture of the deformed bodies and of what happens between them.

Left: the outer facets in the deformed state, shaded, coloured by stress or displacement. Right: the
slave surfaces of all pairs, or of one: stick or slip, shear traction, and the lay where friction has one.
"""
from __future__ import annotations

import argparse
import os
import sys
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .results import Results, mises

# Corners of the faces of a tetrahedron; each face is turned outwards by its opposite corner.
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
PANEL = (720, 544)
"""Width and height of each half, in pixels."""
View = tuple[NDArray, NDArray, NDArray]
"""Unit vectors to the right, up, and towards the viewer."""
FIELDS = ('mises', 'pressure', 'displacement', 'xx', 'yy', 'zz', 'xy', 'yz', 'zx')


def exterior_facets(cells: NDArray, x: NDArray) -> tuple[NDArray, NDArray]:
    """Facets that belong to one cell only, counter-clockwise seen from outside, and their cells."""
    faces = cells[:, FACES].reshape(-1, 3)
    owner = np.repeat(np.arange(len(cells)), 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True,
                                return_counts=True)
    outer = first[count == 1]
    faces, owner = faces[outer], owner[outer]
    normal = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    inward = np.einsum('ij,ij->i', normal, x[cells[owner]].mean(axis=1) - x[faces[:, 0]]) > 0
    faces[inward] = faces[inward][:, ::-1]
    return faces, owner


def facet_values(results: Results, frame: int, name: str, faces: NDArray,
                 owner: NDArray) -> tuple[NDArray, str]:
    """The colour of each facet as a number, and what it means."""
    if name == 'displacement':
        u = results.point_field('displacement', frame)
        return np.linalg.norm(u, axis=1)[faces].mean(axis=1), 'displacement'
    stress = results.cell_field('stress', frame)
    if name == 'mises':
        values, label = mises(stress), 'von Mises stress'
    elif name == 'pressure':
        values, label = -stress[:, :3].mean(axis=1), 'pressure'
    else:
        index = ('xx', 'yy', 'zz', 'xy', 'yz', 'zx').index(name)
        values, label = stress[:, index], f'stress {name}'
    return smooth(values, faces, owner, results.cells, len(results.points)), label


def smooth(values: NDArray, faces: NDArray, owner: NDArray, cells: NDArray,
           count: int) -> NDArray:
    """Values of cells averaged over the points of one body, then over each facet."""
    total, number = np.zeros(count), np.zeros(count)
    np.add.at(total, cells.ravel(), np.repeat(values, 4))
    np.add.at(number, cells.ravel(), 1.0)
    points = total / np.maximum(number, 1.0)
    return 0.5 * (points[faces].mean(axis=1) + values[owner])


def camera(azimuth: float, elevation: float) -> View:
    """Unit vectors to the right, up, and towards the viewer."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(towards, right), towards


def draw_axes(axes: Any, view: View, corner: NDArray, length: float) -> None:
    """A small cross of axes at a corner of the picture."""
    for k, name in enumerate('xyz'):
        tip = length * np.array([view[0][k], view[1][k]])
        axes.annotate('', corner + tip, corner, annotation_clip=False,
                      arrowprops={'arrowstyle': '-|>', 'color': style.INK, 'lw': 0.9,
                                  'shrinkA': 0, 'shrinkB': 0, 'mutation_scale': 7})
        axes.text(*(corner + 1.28 * tip), name, ha='center', va='center', fontsize=8)


def plot(results: Results, path: str, frame: int = -1, field: str = 'mises',
         pair: Optional[str] = None, scale: float = 1.0, azimuth: float = -60.0,
         elevation: float = 24.0) -> None:
    """Draws one end time and writes the picture."""
    from . import scene
    from .surfaces import Surfaces, surfaces_beside
    frame = results.index(frame)
    panels = [scene.draw(scene.bodies(results, frame, field, scale, (azimuth, elevation)), None,
                         'matplotlib', PANEL)]
    if results.pairs and os.path.exists(surfaces_beside(results.path)):
        with Surfaces(surfaces_beside(results.path)) as surfaces:
            panels.append(scene.draw(scene.contact(surfaces, frame, 'status', [pair] if pair
                                                   else None, scale=scale), None, 'matplotlib',
                                     PANEL))
    picture = np.concatenate(panels, axis=1)
    plt = style.pyplot()
    figure = plt.figure(figsize=(picture.shape[1] / 100, picture.shape[0] / 100), dpi=100)
    figure.figimage(picture)
    figure.savefig(path, dpi=100, bbox_inches=None)
    plt.close(figure)


def main(arguments: Optional[list[str]] = None) -> int:
    """Draws one end time of the results file on the command line."""
    parser = argparse.ArgumentParser(prog='plot_cube', description=__doc__)
    parser.add_argument('results', help='.vtkhdf file')
    parser.add_argument('--out', default='cube.png', help='picture (.png, .pdf, .svg)')
    parser.add_argument('--frame', type=int, default=-1, help='end time, from 0 (default: last)')
    parser.add_argument('--field', choices=FIELDS, default='mises', help='what colours the facets')
    parser.add_argument('--pair', help='contact pair (default: all)')
    parser.add_argument('--scale', type=float, default=1.0, help='magnifies the displacements')
    parser.add_argument('--view', type=float, nargs=2, default=(-60.0, 24.0),
                        metavar=('AZIMUTH', 'ELEVATION'))
    options = parser.parse_args(arguments)
    try:
        with Results(options.results) as results:
            plot(results, options.out, options.frame, options.field, options.pair, options.scale,
                 *options.view)
    except (OSError, KeyError, IndexError) as problem:
        print(f'plot_cube: {problem}', file=sys.stderr)
        return 2
    print(options.out)
    return 0
