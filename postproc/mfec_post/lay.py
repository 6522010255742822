"""A picture of the lay of a master surface and of the friction forces on it.

The master surface is seen along its mean normal. Short lines show the lay at its nodes (the field
`lay` of OUTPut FIELds), dots the contact points at some output times, arrows the friction forces on
the slave side.
"""
from __future__ import annotations

import argparse
import sys
from typing import Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .results import Results


def view(normal: NDArray) -> NDArray:
    """Two unit vectors that span the plane normal to a direction: the axes of the picture."""
    normal = normal / np.linalg.norm(normal)
    right = np.eye(3)[np.argmin(np.abs(normal))]
    if abs(normal[0]) < 0.7:
        right = np.array([1.0, 0.0, 0.0])
    right = right - (right @ normal) * normal
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(normal, right)])


class Surface:
    """The master surface of a pair at one output time."""

    def __init__(self, results: Results, pair: str, frame: int):
        self.points = results.contact(pair, frame)
        place = np.zeros(int(results.node_numbers.max()) + 1, dtype=int)
        place[results.node_numbers] = np.arange(len(results.node_numbers))
        self.facets = place[self.points['facets'].reshape(-1, 3)]
        self.x = results.points + results.point_field('displacement', frame)
        self.nodes = np.unique(self.facets)
        a, b, c = self.x[self.facets].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        self.size = np.sqrt(np.linalg.norm(normals, axis=1).mean() / 2)
        self.normal = normals.sum(axis=0)

    def friction(self) -> tuple[NDArray, NDArray]:
        """Places of the closed points on the surface, and the tangential forces on the slave side."""
        closed = (self.points['status'] > 0) & (self.points['host'] > 0)
        corners = self.x[self.facets[self.points['host'][closed] - 1]]
        xi, eta = self.points['tip'][closed].T
        shape = np.stack([xi, eta, 1 - xi - eta], axis=1)
        places = np.einsum('pk,pki->pi', shape, corners)
        normals = np.cross(corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2])
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        force = self.points['traction'][closed]
        return places, force - np.einsum('pi,pi->p', force, normals)[:, None] * normals


def draw(results: Results, pair: str, frames: list[int], path: str) -> None:
    """Draws the picture."""
    plt = style.pyplot()
    figure, axes = plt.subplots(figsize=(4.8, 4.6))
    surfaces = [Surface(results, pair, frame) for frame in frames]
    last = surfaces[-1]
    plane = view(last.normal)
    flat = last.x @ plane.T
    axes.triplot(flat[:, 0], flat[:, 1], last.facets, color=style.GRID, linewidth=0.5, zorder=1)
    lay = results.point_field('lay', frames[-1])[last.nodes] @ plane.T * 0.3 * last.size
    ends = np.stack([flat[last.nodes] - lay, flat[last.nodes] + lay])
    axes.plot(ends[:, :, 0], ends[:, :, 1], color=style.BLUE, linewidth=1.1, zorder=2)
    arrows = [surface.friction() for surface in surfaces]
    longest = max((np.linalg.norm(force, axis=1).max() for _, force in arrows if len(force)),
                  default=0.0)
    scale = 1.6 * last.size / longest if longest > 0 else 0.0
    for places, force in arrows:
        start, arrow = places @ plane.T, force @ plane.T * scale
        axes.plot(start[:, 0], start[:, 1], '.', color=style.INK, markersize=3, zorder=3)
        axes.quiver(start[:, 0], start[:, 1], arrow[:, 0], arrow[:, 1], angles='xy',
                    scale_units='xy', scale=1, color=style.RED, width=0.005, zorder=4)
    axes.plot([], [], color=style.BLUE, label='lay (axis of mu1)')
    axes.plot([], [], color=style.RED, label='friction force on the slave side')
    axes.legend(loc='upper center', bbox_to_anchor=(0.5, -0.08), ncol=2)
    axes.set_aspect('equal')
    axes.grid(False)
    axes.set_title(results.text('title'), fontsize=9)
    figure.savefig(path)
    plt.close(figure)


def main(arguments: Optional[list[str]] = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(prog='plot_lay.py', description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('results', help='results file (.vtkhdf) with the field lay')
    parser.add_argument('--pair', help='name of the pair; the first one without it')
    parser.add_argument('--frames', type=int, nargs='+', metavar='K',
                        help='output times whose points are drawn, counted from 0; three without it')
    parser.add_argument('--out', default='lay.png', help='picture to write')
    given = parser.parse_args(arguments)
    try:
        with Results(given.results) as results:
            pair = given.pair or next(iter(results.pairs))
            last = results.steps - 1
            frames = given.frames or sorted({min(1, last), (last + 1) // 2, last})
            draw(results, pair, frames, given.out)
    except (OSError, KeyError, IndexError, StopIteration) as fault:
        print(f'plot_lay.py: {fault}', file=sys.stderr)
        return 2
    print(given.out)
    return 0
