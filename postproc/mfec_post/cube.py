"""A picture of the deformed bodies and of what happens between them.

Left: the outer facets in the deformed state, shaded, coloured by stress or displacement, with the
contact forces on the slave points. Right: the contact points seen from above: stick or slip, the
normal force as the size of the dot, the friction force as an arrow.
"""
from __future__ import annotations

import argparse
import sys
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import style
from .results import Results

# Corners of the faces of a tetrahedron; each face is turned outwards by its opposite corner.
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
LIGHT = np.array([-0.35, -0.55, 0.76])
STATUS = {1: ('stick', style.BLUE), 2: ('slip', style.RED)}
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


def bodies(cells: NDArray, count: int) -> NDArray:
    """A number for each cell: cells that share points have the same."""
    label = np.arange(count)
    while True:
        lowest = label[cells].min(axis=1)
        new = label.copy()
        np.minimum.at(new, cells.ravel(), np.repeat(lowest, cells.shape[1]))
        if np.array_equal(new, label):
            return label[cells[:, 0]]
        label = new


def mises(stress: NDArray) -> NDArray:
    """Equivalent stress of xx yy zz xy yz zx."""
    xx, yy, zz, xy, yz, zx = stress.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
                   + 3.0 * (xy ** 2 + yz ** 2 + zx ** 2))


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


def draw_bodies(axes: Any, x: NDArray, faces: NDArray, values: NDArray, colours: Any, view: View,
                back: NDArray) -> None:
    """Paints the facets that face the viewer, the body `back` first, then from far to near."""
    from matplotlib.collections import PolyCollection
    right, up, towards = view
    corners = x[faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    seen = np.flatnonzero(normal @ towards > 1e-9)
    depth = corners.mean(axis=1) @ towards
    order = seen[np.lexsort((depth[seen], ~back[seen]))]
    flat = np.stack([corners[order] @ right, corners[order] @ up], axis=-1)
    shade = 0.62 + 0.38 * np.clip(normal[order] @ (LIGHT / np.linalg.norm(LIGHT)), 0.0, 1.0)
    paint = colours(values[order])
    paint[:, :3] *= shade[:, None]
    edge = 0.82 * paint
    edge[:, 3] = 1.0
    axes.add_collection(PolyCollection(flat, facecolors=paint, edgecolors=edge, linewidths=0.35))
    axes.autoscale_view()
    axes.set_aspect('equal')
    axes.axis('off')


def draw_axes(axes: Any, view: View, corner: NDArray, length: float) -> None:
    """A small cross of axes at a corner of the picture."""
    for k, name in enumerate('xyz'):
        tip = length * np.array([view[0][k], view[1][k]])
        axes.annotate('', corner + tip, corner, annotation_clip=False,
                      arrowprops={'arrowstyle': '-|>', 'color': style.INK, 'lw': 0.9,
                                  'shrinkA': 0, 'shrinkB': 0, 'mutation_scale': 7})
        axes.text(*(corner + 1.28 * tip), name, ha='center', va='center', fontsize=8)


def draw_forces(axes: Any, x: NDArray, points: dict[str, NDArray], view: View,
                size: float) -> None:
    """The contact forces on the slave points as arrows that end at the points."""
    right, up, _ = view
    force = -points['traction'][points['active']]
    if len(force) == 0 or np.max(np.abs(force)) == 0:
        return
    scale = 0.22 * size / np.max(np.linalg.norm(force, axis=1))
    head = places(x, points)[points['active']]
    tail = head - scale * force
    axes.quiver(tail @ right, tail @ up, (head - tail) @ right, (head - tail) @ up,
                angles='xy', scale_units='xy', scale=1, color=style.INK, width=0.0035,
                headwidth=3.6, headlength=4.5, headaxislength=4, zorder=5)


def draw_contact(axes: Any, x: NDArray, points: dict[str, NDArray], size: float) -> None:
    """The contact points from above."""
    from matplotlib.lines import Line2D
    at = places(x, points)
    normal = np.abs(points['traction'][:, 2])
    largest = max(np.max(normal, initial=0.0), 1e-300)
    axes.scatter(at[:, 0], at[:, 1], s=5, color='#bbbbbb', zorder=2)
    handles = []
    for status, (name, colour) in STATUS.items():
        mine = points['status'] == status
        if np.any(mine):
            axes.scatter(at[mine, 0], at[mine, 1], s=8 + 130 * normal[mine] / largest, color=colour,
                         alpha=0.55, linewidths=0, zorder=3)
            handles.append(Line2D([], [], marker='o', linestyle='', color=colour, alpha=0.55,
                                  label=f'{name} ({np.count_nonzero(mine)})'))
    open_points = np.count_nonzero(points['status'] < 1)
    if open_points:
        handles.append(Line2D([], [], marker='o', linestyle='', color='#bbbbbb', markersize=2.5,
                              label=f'open ({open_points})'))
    friction = points['traction'][:, :2]
    longest = np.max(np.linalg.norm(friction, axis=1), initial=0.0)
    if longest > 0:
        scale = 0.16 * size / longest
        axes.quiver(at[:, 0], at[:, 1], scale * friction[:, 0], scale * friction[:, 1], angles='xy',
                    scale_units='xy', scale=1, color=style.INK, width=0.0045, zorder=4)
    draw_lay(axes, at[:, :2], points['lay'][:, :2], size)
    handles.append(Line2D([], [], color=style.GREEN, lw=1, label='lay (axis of $\\mu_1$)'))
    axes.set_aspect('equal')
    axes.margins(0.14)
    axes.set_xlabel('x')
    axes.set_ylabel('y')
    axes.set_title('contact points from above: friction force (arrow),\nnormal force (area)',
                   fontsize=9)
    axes.legend(handles=handles, loc='upper center', bbox_to_anchor=(0.5, -0.16), ncol=3,
                handletextpad=0.3, columnspacing=1.2, fontsize=8)


def draw_lay(axes: Any, at: NDArray, lay: NDArray, size: float) -> None:
    """The lay at each point as a short stroke."""
    from matplotlib.collections import LineCollection
    half = 0.035 * size * lay
    axes.add_collection(LineCollection(np.stack([at - half, at + half], axis=1),
                                       colors=style.GREEN, linewidths=1.2, zorder=3.5))


def contact_points(results: Results, pair: str, frame: int) -> dict[str, NDArray]:
    """The contact points of a pair with the indices of each point's nodes."""
    points = results.contact(pair, frame)
    index = {number: i for i, number in enumerate(results.node_numbers)}
    points['point'] = np.array([[index[number] for number in row] for row in points['node']],
                               dtype=int)
    points['active'] = points['status'] > 0
    return points


def places(x: NDArray, points: dict[str, NDArray]) -> NDArray:
    """Where the contact points are if the nodes are at x."""
    return (points['weight'][:, :, None] * x[points['point']]).sum(axis=1)


def plot(results: Results, path: str, frame: int = -1, field: str = 'mises',
         pair: Optional[str] = None, scale: float = 1.0, azimuth: float = -60.0,
         elevation: float = 24.0) -> None:
    """Draws one end time and writes the picture."""
    plt = style.pyplot()
    import matplotlib as mpl
    frame = results.index(frame)
    reference, cells = results.points, results.cells
    x = reference + scale * results.point_field('displacement', frame)
    faces, owner = exterior_facets(cells, reference)
    values, label = facet_values(results, frame, field, faces, owner)
    pairs = list(results.pairs)
    points = contact_points(results, pair or pairs[0], frame) if pairs else None
    size = np.ptp(x, axis=0).max()
    back = np.zeros(len(faces), dtype=bool)
    if points is not None:
        body = bodies(cells, len(reference))
        front = np.isin(body, body[np.isin(cells, points['point']).any(axis=1)])
        back = ~front[owner]
        size = np.ptp(places(x, points), axis=0).max()
    norm = mpl.colors.Normalize(*np.percentile(values, [0.5, 99.5]))
    colours = mpl.colors.ListedColormap(plt.get_cmap('viridis')(np.linspace(0.15, 1, 256)))
    mapping = mpl.cm.ScalarMappable(norm, colours)
    view = camera(azimuth, elevation)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.2, 4.6), gridspec_kw={
        'width_ratios': [1.75, 1], 'wspace': 0.16})
    draw_bodies(left, x, faces, values, mapping.to_rgba, view, back)
    low = np.array([left.get_xlim()[0], left.get_ylim()[0]])
    draw_axes(left, view, low + 0.06 * np.ptp(left.get_xlim()), 0.09 * np.ptp(left.get_xlim()))
    bar = figure.colorbar(mapping, ax=left, orientation='horizontal', fraction=0.045, pad=0.02,
                          shrink=0.62, aspect=30)
    bar.set_label(label)
    bar.outline.set_visible(False)
    title = f'time {results.times[frame]:g}; arrows: contact forces on the lower body'
    if points is None:
        title = f'time {results.times[frame]:g}'
    if scale != 1.0:
        title += f', displacements {scale:g} times'
    left.set_title(title, fontsize=9)
    if points is None:
        right.axis('off')
    else:
        draw_forces(left, x, points, view, size)
        draw_contact(right, x, points, size)
    figure.savefig(path)
    plt.close(figure)


def main(arguments: Optional[list[str]] = None) -> int:
    """Draws one end time of the results file on the command line."""
    parser = argparse.ArgumentParser(prog='plot_cube', description=__doc__)
    parser.add_argument('results', help='.h5 file')
    parser.add_argument('--out', default='cube.png', help='picture (.png, .pdf, .svg)')
    parser.add_argument('--frame', type=int, default=-1, help='end time, from 0 (default: last)')
    parser.add_argument('--field', choices=FIELDS, default='mises', help='what colours the facets')
    parser.add_argument('--pair', help='contact pair (default: the first)')
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
