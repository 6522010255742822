#!/usr/bin/env python3
"""A sketch of each verification case that doc/drawings.py has none of, drawn from the first deck that its
study runs: doc/verification/sketch_*.svg.

    build/venv/bin/python doc/sketches.py [--program ./mfec] [CASE...]

`mfec --check` of that deck leaves mesh, supports and loads; bodies are outlined as one sees them, hidden
edges left out, with arrows of what is held, moved and loaded, and the dimensions of the whole.
"""
import argparse
import os
import re
import runpy
import sys
import tempfile

import numpy as np
from contourpy import contour_generator

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path += [os.path.join(TOP, 'postproc'), os.path.join(TOP, 'tests', 'verification')]
import cases  # noqa: E402
import drawings  # noqa: E402
import verifying  # noqa: E402
from mfec_post import geometry  # noqa: E402
from mfec_post.results import Results  # noqa: E402
from mfec_post.scene import exact_tools  # noqa: E402

STUDIES = os.path.join(TOP, 'tests', 'verification', 'run')
DRAWN = {'sketch_' + name[7:] for name in vars(drawings) if name.startswith('sketch_')}
WIDE = 700
"""Cells of the raster that tells what is seen."""
SHARP = np.cos(np.radians(30))
"""An edge is drawn where its facets turn by more."""
LIGHT = np.array([0.35, -0.6, 0.9])
"""Where the light is: top, front and side of a block get three tints, none of them between two."""
TINTS = 6
"""So many tints has a body."""
APART = 0.05
"""Arrows and ticks stand so far apart, of the width of the drawing."""
MANY = 6
"""Loads are drawn one by one up to so many."""
HELD, MOVED, LOADED = drawings.ACCENT, '#0072b2', drawings.POINT


class Taken(Exception):
    """The deck that was wanted, and the path of its check files."""


class FirstDeck(verifying.Bench):
    """Stops a study at its first deck."""

    def launch(self, arguments, code):
        done = verifying.decks.run(self.program, arguments + ['--check', '--quiet', '--out', self.folder],
                                   self.folder, self.seconds)
        if done.code != 0:
            raise SystemExit(f'{self.case}: {done.err.strip()[:300]}')
        raise Taken(os.path.join(self.folder, os.path.basename(arguments[0])[:-4] + '.check.vtkhdf'))


def checked(case, study, program, folder):
    """The check file of a case."""
    bench = FirstDeck(program, folder)
    bench.case, bench.dice = case, verifying.random.Random(f'1 {case}')
    try:
        study(bench)
    except Taken as taken:
        return str(taken)
    raise SystemExit(f'{case} runs no deck')


class Picture:
    """Facets of a check file in the plane of the paper: right, up and towards the viewer."""

    def __init__(self, results):
        self.points, self.numbers = results.points, results.node_numbers
        faces, owner = geometry.exterior_facets(results.cells, self.points)
        self.bodies = bodies_of(results.cells, len(self.points))[results.cells[owner, 0]] if len(faces) else owner
        at = {n: k for k, n in enumerate(self.numbers)}
        known = {tuple(sorted(f)) for f in faces.tolist()}
        shells, tools = [], exact_tools(results, 0, 0.0)
        group = results.file['run/surfaces']
        for name in group:
            corners = np.vectorize(lambda n: at.get(n, -1))(group[name][:, :3]) if len(group[name]) else np.zeros((0, 3), int)
            shells += [f for f in corners.tolist() if min(f) >= 0 and tuple(sorted(f)) not in known]
        self.facets = np.vstack([faces.reshape(-1, 3), np.array(shells, dtype=int).reshape(-1, 3)])
        self.bodies = np.append(self.bodies, np.full(len(shells), -1))
        for places, corners in tools:
            self.facets = np.vstack([self.facets, np.asarray(corners)[:, :3] + len(self.points)])
            self.points = np.vstack([self.points, places])
            self.bodies = np.append(self.bodies, np.full(len(corners), -2))
        right, up, towards = geometry.camera(-60.0, 24.0)
        self.axes = np.array([right, up, towards])
        self.flat = self.points@self.axes.T
        used = self.flat[np.unique(self.facets)]
        self.low, self.high = used.min(axis=0), used.max(axis=0)
        self.cell = max(self.high[:2] - self.low[:2])/WIDE
        self.normals = unit_normals(self.points, self.facets)
        self.raster()

    def raster(self):
        """Which facet is in front, cell by cell, and how near it is."""
        shape = np.ceil((self.high[:2] - self.low[:2])/self.cell).astype(int) + 3
        self.front, self.near = np.full(shape, -1), np.full(shape, -np.inf)
        places = (self.flat[:, :2] - self.low[:2])/self.cell + 1
        for k, facet in enumerate(self.facets):
            corners = places[facet]
            first, last = np.floor(corners.min(axis=0)).astype(int), np.ceil(corners.max(axis=0)).astype(int) + 1
            (ax, ay), (bx, by) = corners[1] - corners[0], corners[2] - corners[0]
            area = ax*by - ay*bx
            if abs(area) < 1e-9:
                continue
            x, y = np.mgrid[first[0]:last[0], first[1]:last[1]]
            x, y = x - corners[0, 0], y - corners[0, 1]
            s, t = (x*by - y*bx)/area, (ax*y - ay*x)/area
            depth = self.flat[facet[0], 2]*(1 - s - t) + self.flat[facet[1], 2]*s + self.flat[facet[2], 2]*t
            part = (slice(first[0], last[0]), slice(first[1], last[1]))
            mine = (s >= -1e-6) & (t >= -1e-6) & (s + t <= 1 + 1e-6) & (depth > self.near[part])
            self.front[part][mine], self.near[part][mine] = k, depth[mine]

    def tint(self, k):
        """The fill of a facet: the colour of its body, lighter where it looks up."""
        body = self.bodies[k]
        colour = np.array(drawings.matplotlib.colors.to_rgb(
            '0.45' if body < 0 else (drawings.SLAVE, '#e69f00', '#009e73', '#cc79a7')[body % 4]))
        shade = round(TINTS*min(1.0, abs(float(self.normals[k]@LIGHT))))/TINTS
        return tuple(np.round(1 - (1 - colour)*(0.46 - 0.30*shade), 3))

    def fills(self):
        """Closed lines around what has one tint, and that tint."""
        seen = np.unique(self.front[self.front >= 0])
        tints = {}
        for k in seen:
            tints.setdefault(self.tint(k), []).append(k)
        for tint, mine in tints.items():
            mask = np.isin(self.front, mine).astype(float)
            rings = contour_generator(z=mask.T, fill_type='OuterCode').filled(0.5, 2.0)
            for line, codes in zip(*rings):
                outline = drawings.matplotlib.path.Path(line, codes)
                outline.simplify_threshold = 0.5
                outline = outline.cleaned(simplify=True)
                yield tint, (outline.vertices - 1)*self.cell + self.low[:2], outline.codes

    def edges(self):
        """Visible pieces of edges where a surface ends, turns sharply or turns away."""
        ends = np.sort(self.facets[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        order = np.lexsort(ends.T[::-1])
        ends, owner = ends[order], order//3
        start = np.flatnonzero(np.append(True, np.any(ends[1:] != ends[:-1], axis=1)))
        for first, last in zip(start, np.append(start[1:], len(ends))):
            normals = self.normals[owner[first:last]]
            facing = normals@self.axes[2]
            if last - first == 2 and normals[0]@normals[1] > SHARP and facing[0]*facing[1] > 0:
                continue
            yield from self.visible(*self.flat[ends[first]])

    def seen(self, places):
        """Of the places those that nothing stands before; all of them if nothing is seen of any."""
        flat = places@self.axes.T
        cells = np.round((flat[:, :2] - self.low[:2])/self.cell).astype(int)
        cells = np.clip(cells, 0, np.array(self.near.shape) - 3)
        ahead = np.min([self.near[tuple((cells + step).T)] for step in np.ndindex(3, 3)], axis=0)
        found = np.flatnonzero(ahead <= flat[:, 2] + 4*self.cell)
        return found if len(found) else np.arange(len(places))

    def visible(self, a, b):
        """Pieces of a line that nothing stands before."""
        count = max(2, int(np.abs(b - a)[:2].max()/self.cell/3) + 1)
        at = a + np.linspace(0, 1, count)[:, None]*(b - a)
        cells = np.round((at[:, :2] - self.low[:2])/self.cell).astype(int)  # of its neighbour below and left
        ahead = np.min([self.near[tuple((cells + step).T)] for step in np.ndindex(3, 3)], axis=0)
        free = ahead <= at[:, 2] + 4*self.cell
        first = None
        for k in range(count):
            if free[k] and first is None:
                first = k
            if first is not None and (not free[k] or k == count - 1):
                last = k if free[k] else k - 1
                if last > first:
                    yield at[first, :2], at[last, :2]
                first = None


def unit_normals(points, facets):
    """Outward normals of length 1."""
    normals = np.cross(points[facets[:, 1]] - points[facets[:, 0]], points[facets[:, 2]] - points[facets[:, 0]])
    return normals/np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]


def bodies_of(cells, count):
    """The body of each node: nodes that elements join, numbered from 0."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    rows = np.repeat(cells[:, 0], 3)
    _, label = connected_components(coo_matrix((np.ones(len(rows)), (rows, cells[:, 1:4].ravel())),
                                               shape=(count, count)))
    used = np.unique(label[np.unique(cells)])
    return np.searchsorted(used, label)


def spread(picture, nodes, most):
    """Some of the nodes, of those that are seen, far from each other."""
    nodes = nodes[picture.seen(picture.points[nodes])]
    points = picture.points[nodes]
    least = APART*max(picture.high[:2] - picture.low[:2])
    chosen = [int(np.argmin(points@np.array([0.31, 0.53, 0.79])))]
    away = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < most and away.max() > least:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return nodes[chosen]


def vectors(rows, loads, tables, at):
    """Nodes and their values in /scene/displacements or /scene/forces, a table a pair; those of many tables
    (nodes that go around an axis) at once, as they begin."""
    kinds = [tuple(loads[int(row[0]) - 1, :2]) for row in rows]
    many = len(set(kinds)) > MANY
    for kind in ['all'] if many else sorted(set(kinds)):
        found = {}
        for (_, node, direction, value), (table, form) in zip(rows, kinds):
            if (many or (table, form) == kind) and form != 3:
                found.setdefault(at[int(node)], np.zeros(3))[int(direction) - 1] += value*(
                    begin(tables[tables[:, 0] == table]) if many else farthest(tables[tables[:, 0] == table]))
        nodes = [n for n, v in found.items() if np.any(v)]
        if nodes:
            yield np.array(nodes), np.array([found[n] for n in nodes])


def begin(corners):
    """The factor of a table at its first time that is not the start."""
    corners = corners[np.argsort(corners[:, 2], kind='stable')]
    return corners[min(1, len(corners) - 1), 3] if len(corners) else 0.0


def farthest(corners):
    """The factor of a table that is farthest from zero: where its load goes."""
    corners = corners[corners[:, 1] == 0]
    return corners[np.argmax(np.abs(corners[:, 3])), 3] if len(corners) else 1.0


def marks(picture, results):
    """(place, vector, colour) of arrows at loads, and (place, direction) of ticks at supports."""
    at, size = {n: k for k, n in enumerate(picture.numbers)}, max(picture.high[:2] - picture.low[:2])
    file, arrows, ticks = results.file, [], []

    def rows(name, width):
        return file['scene/' + name][:].reshape(-1, width) if 'scene/' + name in file else np.zeros((0, width))

    for name, colour in (('displacements', MOVED), ('forces', LOADED)):
        for nodes, values in vectors(rows(name, 4), rows('loads', 3), rows('tables', 4), at):
            largest = np.linalg.norm(values, axis=1).max()
            value = dict(zip(nodes, values))
            for n in spread(picture, nodes, 4):
                if np.linalg.norm(value[n]) > 0.05*largest:
                    arrows.append((picture.points[n], 0.14*size*value[n]/np.linalg.norm(value[n]), colour))
    pressed = rows('pressures', 8)
    if len(pressed):
        corners = np.array([[at[int(n)] for n in row[:3]] for row in pressed])
        normals = unit_normals(picture.points, corners)
        middles = picture.points[corners].mean(axis=1)
        nearest = {int(corners[k, 0]): k for k in range(len(corners))}
        arrows += [(middles[k], -0.11*size*normals[k]*np.sign(pressed[k, 7] or 1), LOADED)
                   for k in (nearest[n] for n in spread(picture, np.array(sorted(nearest)), 6))]
    for _, _, *loads in rows('rigid_loads', 8):
        for vector in (np.array(loads[:3]),):
            if np.any(vector):
                arrows.append((picture.points.mean(axis=0), 0.2*size*vector/np.linalg.norm(vector), LOADED))
    supports = file['scene/supports'][:]
    moved = {int(n) for n in rows('displacements', 4)[:, 1]}
    for code in range(1, 8):
        nodes = np.array([at[n + 1] for n in np.flatnonzero(supports % 8 == code) if n + 1 in at and n + 1 not in moved],
                         dtype=int)
        for n in spread(picture, nodes, 6) if len(nodes) else ():
            ticks += [(picture.points[n], np.eye(3)[i]) for i in range(3) if code >> i & 1]
    return arrows, ticks, size


def dimensions(one, picture, size, left):
    """The extents of the whole along its lower edges and its height, with their lengths."""
    used = picture.points[np.unique(picture.facets)]
    low, high = used.min(axis=0), used.max(axis=0)
    corner = np.array([low[0], low[1], low[2]])
    for i, start in ((0, corner), (1, np.array([high[0], low[1], low[2]])), (2, corner)):
        end = start.copy()
        end[i] = high[i]
        if high[i] - low[i] < 1e-9*size:
            continue
        a, b = ((p@picture.axes.T)[:2] for p in (start, end))
        off = {0: np.array([0, -1.0]), 1: np.array([0.6, -0.8]), 2: np.array([-1.0, 0])}[i]*0.07*size
        if i == 2:
            off[0] = min(off[0], left - a[0] - 0.03*size)
        one.annotate('', xy=b + off, xytext=a + off, arrowprops={'arrowstyle': '<|-|>', 'color': '0.35', 'lw': 0.6,
                                                                 'shrinkA': 0, 'shrinkB': 0, 'mutation_scale': 6})
        beyond = off*0.07*size/np.linalg.norm(off)
        middle = (a + b)/2 + off + 0.75*beyond
        one.text(*middle, f'{high[i] - low[i]:.4g}', fontsize=8, color='0.25', ha='center', va='center',
                 rotation=90 if i == 2 else 0)
        one.plot(*np.array([a + off + 1.1*beyond, b + off + 1.1*beyond]).T, alpha=0)


def sketch(path, target):
    """Draws a check file."""
    with Results(path) as results:
        picture = Picture(results)
        arrows, ticks, size = marks(picture, results)
    figure, (one,) = drawings.axes(1, 4.6, 3.4)
    for tint, line, codes in picture.fills():
        one.add_patch(drawings.matplotlib.patches.PathPatch(
            drawings.matplotlib.path.Path(line, codes), fc=tint, ec=tint, lw=0.4))
    pieces = np.array(list(picture.edges())).reshape(-1, 2)
    one.add_patch(drawings.matplotlib.patches.PathPatch(drawings.matplotlib.path.Path(
        pieces, np.tile([1, 2], len(pieces)//2)), fc='none', ec='0.15', lw=0.7, capstyle='round'))
    one.plot(*picture.flat[np.unique(picture.facets), :2][[0, -1]].T, alpha=0)
    for place, vector, colour in arrows:
        end, start = place@picture.axes.T, (place - vector)@picture.axes.T
        if np.linalg.norm((end - start)[:2]) > 0.02*size:
            drawings.arrow(one, start[:2], end[:2], colour, shrinkA=0, shrinkB=0, mutation_scale=9)
    for place, along in ticks:
        line = np.array([place - 0.028*size*along, place + 0.028*size*along])@picture.axes.T
        one.plot(line[:, 0], line[:, 1], color=HELD, lw=1.6, solid_capstyle='butt')
    dimensions(one, picture, size, min((((p - v)@picture.axes.T)[0] for p, v, _ in arrows), default=np.inf))
    words = [(word, colour) for word, colour, there in (
        ('held', HELD, ticks), ('moved', MOVED, [1 for a in arrows if a[2] == MOVED]),
        ('loaded', LOADED, [1 for a in arrows if a[2] == LOADED])) if there]
    for k, (word, colour) in enumerate(words):
        one.text(0.01 + 0.17*k, 0.995, word, color=colour, fontsize=8, transform=one.transAxes, va='bottom')
    figure.savefig(target, metadata={'Date': None}, bbox_inches='tight', pad_inches=0.04)
    with open(target, encoding='utf-8') as stream:
        text = re.sub(r'<[^>]*>', lambda tag: re.sub(r'(\d\.\d\d)\d+', r'\1', tag[0]), stream.read())  # of a point
    with open(target, 'w', encoding='utf-8') as stream:
        stream.write(text)
    drawings.plt.close(figure)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--program', default=os.path.join(TOP, 'mfec'))
    parser.add_argument('cases', nargs='*')
    given = parser.parse_args()
    studies = runpy.run_path(STUDIES)
    studies = {**studies['QUICK'], **studies['SLOW']}
    for case in given.cases or cases.TEXTS:
        if cases.sketch_of(case)[:-4] in DRAWN and not given.cases:
            continue
        with tempfile.TemporaryDirectory() as folder:
            sketch(checked(case, studies[case], given.program, folder), os.path.join(cases.FOLDER, cases.sketch_of(case)))
        print(case, flush=True)


if __name__ == '__main__':
    main()
