"""Meshes as they come from elsewhere: bricks of tetrahedra in Abaqus files, tools of triangles."""
import math
import os
import random

# Corners of the six tetrahedra of a cell: 0 to 3 below, 4 to 7 above, counter-clockwise.
SIX = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
CELL = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


class Place:
    """A turn and a shift of space."""

    def __init__(self, rng=None, shift=0.0):
        self.axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        self.shift = (0.0, 0.0, 0.0)
        if rng is None:
            return
        q = [rng.gauss(0, 1) for _ in range(4)]
        n = math.sqrt(sum(v * v for v in q))
        w, x, y, z = (v / n for v in q)
        self.axes = ((1 - 2*(y*y + z*z), 2*(x*y - z*w), 2*(x*z + y*w)),
                     (2*(x*y + z*w), 1 - 2*(x*x + z*z), 2*(y*z - x*w)),
                     (2*(x*z - y*w), 2*(y*z + x*w), 1 - 2*(x*x + y*y)))
        self.shift = tuple(rng.uniform(-shift, shift) for _ in range(3))

    def turn(self, v):
        """A vector, turned."""
        return tuple(sum(row[k] * v[k] for k in range(3)) for row in self.axes)

    def point(self, p):
        """A point, turned and shifted."""
        return tuple(a + b for a, b in zip(self.turn(p), self.shift))

    def back(self, v):
        """A vector as it was before the turn."""
        return tuple(sum(self.axes[k][i] * v[k] for k in range(3)) for i in range(3))


class Solids:
    """Bricks of tetrahedra, written as one Abaqus file, numbered at random if a generator is given."""

    def __init__(self):
        self.nodes, self.cells, self.regions, self.sets = [], [], {}, {}

    def brick(self, name, low, high, cells, sets=(), bend=None):
        """Adds a brick; sets are (name, axis, place): nodes with that coordinate of the brick."""
        n, first = cells, len(self.nodes)
        number = {}
        for k in range(n[2] + 1):
            for j in range(n[1] + 1):
                for i in range(n[0] + 1):
                    ijk = (i, j, k)
                    p = tuple(low[a] + (high[a] - low[a]) * ijk[a] / n[a] for a in range(3))
                    number[ijk] = len(self.nodes)
                    self.nodes.append(bend(p) if bend else p)
                    for label, axis, place in sets:
                        if abs(p[axis] - place) < 1e-9 * (1 + abs(place)):
                            self.sets.setdefault(label, []).append(number[ijk])
        start = len(self.cells)
        for k in range(n[2]):
            for j in range(n[1]):
                for i in range(n[0]):
                    corner = [number[i + a, j + b, k + c] for a, b, c in CELL]
                    self.cells += [[corner[v] for v in six] for six in SIX]
        self.regions[name] = range(start, len(self.cells))
        return range(first, len(self.nodes))

    def write(self, path, place, rng=None, digits=17):
        """Writes the file; the number of each node in it."""
        order = list(range(len(self.nodes)))
        cells = list(range(len(self.cells)))
        if rng:
            rng.shuffle(order)
            rng.shuffle(cells)
        number = {n: i + 1 for i, n in enumerate(order)}
        element = {c: i + 1 for i, c in enumerate(cells)}
        with open(path, 'w', encoding='ascii') as out:
            out.write('*NODE\n')
            for n in order:
                x = place.point(self.nodes[n])
                out.write(f'{number[n]}, ' + ', '.join(f'{v:.{digits}g}' for v in x) + '\n')
            out.write('*ELEMENT, TYPE=C3D4\n')
            for c in cells:
                out.write(f'{element[c]}, ' + ', '.join(str(number[n]) for n in self.cells[c]) + '\n')
            for kind, groups, numbers in (('*ELSET, ELSET=', self.regions, element),
                                          ('*NSET, NSET=', self.sets, number)):
                for name, members in groups.items():
                    out.write(kind + name + '\n')
                    for m in members:
                        out.write(f'{numbers[m]},\n')
        return number


def sheet(point, n, m):
    """Triangles over the unit square that point maps into space, counter-clockwise from above."""
    p = [[point(i / n, j / m) for j in range(m + 1)] for i in range(n + 1)]
    out = []
    for i in range(n):
        for j in range(m):
            a, b, c, d = p[i][j], p[i + 1][j], p[i + 1][j + 1], p[i][j + 1]
            out += [(a, b, c), (a, c, d)] if (i + j) % 2 else [(a, b, d), (b, c, d)]
    return out


def box(low, high, n=2):
    """Triangles of a box, outwards."""
    out = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, 1):
            def point(s, t, axis=axis, u=u, v=v, end=end):
                p = [0.0, 0.0, 0.0]
                p[axis] = (low, high)[end][axis]
                p[u] = low[u] + (high[u] - low[u]) * s
                p[v] = low[v] + (high[v] - low[v]) * t
                return tuple(p)
            faces = sheet(point, n, n)
            out += faces if end else turned(faces)
    return out


def turned(triangles):
    """The same, seen from the other side."""
    return [(b, a, c) for a, b, c in triangles]


def write_stl(path, triangles, place, rng=None, share=0.0):
    """Writes triangles in any order, with a share of them turned."""
    triangles = list(triangles)
    if rng:
        rng.shuffle(triangles)
    with open(path, 'w', encoding='ascii') as out:
        out.write('solid s\n')
        for corners in triangles:
            if rng:
                k = rng.randrange(3)
                corners = corners[k:] + corners[:k]
                if rng.random() < share:
                    corners = (corners[1], corners[0], corners[2])
            out.write('facet normal 0 0 0\nouter loop\n')
            for p in corners:
                out.write('vertex ' + ' '.join(f'{v:.17g}' for v in place.point(p)) + '\n')
            out.write('endloop\nendfacet\n')
        out.write('endsolid s\n')


def table(folder, name='x', suffix='.rea'):
    """Rows of a table: {(step, set): numbers}."""
    rows = {}
    with open(os.path.join(folder, name + suffix), encoding='utf-8') as stream:
        for line in stream:
            words = line.split()
            if words and not line.startswith('#'):
                rows[int(words[0]), words[2]] = [float(w) for w in words[3:]]
    return rows


def chance(seed, *words):
    """A generator that is a function of the seed and the words alone."""
    return random.Random(' '.join(map(str, (seed,) + words)))
