#!/usr/bin/env python3
"""Makes the mesh files of this folder: boxes of cells that are bent into rings, balls and runners.

    inputs/gallery/make_meshes.py [FOLDER] [--fine N]      N times as many cells along each edge

ring      annulus about x3, the disc under a pad: region disc; surfaces face, floor
fit       quarters of a hollow shaft with a slight taper at its end and of a hub that is too narrow
          for it: regions shaft, hub; surfaces seat (shaft), bore (hub)
runner    a plate with a round belly along x2: region runner; surface belly
ball      a ball, its cells finer where a groove of 90 degrees along x2 touches it: region ball;
          surface skin
belt      a band around half of a drum about x2: regions band, drum; surfaces inside, rim; sets of the
          ends of the band
oring     a quarter of a ring about x3: region ring; surface skin
shrunk    quarters of a ring of radius 1.001 and of a hub of radius 1 around it: regions ring, hub;
          surfaces seat (ring), bore (hub)
roller    a tube of radius 1 about x2 that stands on x3 = 0: region roller; surface rim

lug.msh is made by Gmsh from lug.geo: gmsh -3 lug.geo -format msh22 -o lug.msh
"""
import argparse
import math
import os

# A cell as BLOCk TET4 cuts it, and the sides of a box with their two triangles a cell.
CELL = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


class Mesh:
    """Nodes, tetrahedra and triangles of named groups."""

    def __init__(self):
        self.nodes, self.cells, self.names = [], [], {}
        self.places = {}

    def node(self, place):
        """The number of the node at a place; the same place is the same node."""
        key = tuple(round(x, 9) for x in place)
        if key not in self.places:
            self.nodes.append(key)
            self.places[key] = len(self.nodes)
        return self.places[key]

    def group(self, dimension, name):
        """The number of a named group."""
        return self.names.setdefault((dimension, name), len(self.names) + 1)

    def box(self, region, counts, place, sides=()):
        """A box of cells; place(r, s, t) bends it, r, s and t from 0 to 1. sides: (name, axis, end)."""
        def at(*ijk):
            return self.node(place(*(k / n for k, n in zip(ijk, counts))))

        volume, facets = self.group(3, region), {}
        for i in range(counts[0]):
            for j in range(counts[1]):
                for k in range(counts[2]):
                    corner = [at(i + a, j + b, k + c) for a, b, c in CORNERS]
                    for tet in CELL:
                        self.cells.append((4, volume, [corner[m] for m in tet]))
                    for name, axis, end in sides:
                        if (i, j, k)[axis] == end * (counts[axis] - 1):
                            on = {m for m in range(8) if CORNERS[m][axis] == end}
                            for tet in CELL:
                                three = [m for m in tet if m in on]
                                if len(three) == 3:
                                    facets.setdefault(name, []).append([corner[m] for m in three])
        for name, triangles in facets.items():
            number = self.group(2, name)
            self.cells += [(2, number, triangle) for triangle in triangles]

    def points(self, name, test):
        """A set of the nodes whose place passes a test."""
        number = self.group(0, name)
        self.cells += [(15, number, [n]) for n, x in enumerate(self.nodes, 1) if test(*x)]

    def write(self, path):
        """Gmsh's format 2.2."""
        lines = ['$MeshFormat', '2.2 0 8', '$EndMeshFormat', '$PhysicalNames', str(len(self.names))]
        lines += [f'{d} {number} "{name}"' for (d, name), number in self.names.items()]
        lines += ['$EndPhysicalNames', '$Nodes', str(len(self.nodes))]
        lines += [f'{n} {x:.9g} {y:.9g} {z:.9g}' for n, (x, y, z) in enumerate(self.nodes, 1)]
        lines += ['$EndNodes', '$Elements', str(len(self.cells))]
        lines += [f'{n} {kind} 2 {group} {group} ' + ' '.join(map(str, corners))
                  for n, (kind, group, corners) in enumerate(self.cells, 1)]
        with open(path, 'w', encoding='ascii') as stream:
            stream.write('\n'.join(lines + ['$EndElements', '']))


def polar(radius, degrees, height):
    """A point about x3."""
    angle = math.radians(degrees)
    return radius * math.cos(angle), radius * math.sin(angle), height


def graded(s, power=1.8):
    """-1 to 1 for s from 0 to 1, with small steps in the middle."""
    s = 2 * s - 1
    return math.copysign(abs(s)**power, s)


def ring(mesh, n):
    """An annulus with radii 0.5 and 1.5, 0.3 high; its face is at x3 = 0."""
    mesh.box('disc', (5 * n, 36 * n, 2 * n), lambda r, s, t: polar(0.5 + r, 360 * s, 0.3 * t - 0.3),
             [('face', 2, 1), ('floor', 2, 0)])


def fit(mesh, n):
    """A shaft of radius 1.001, tapered to 0.999 at its end; the hub, of radius 1, begins there."""
    def shaft(r, s, t):
        outer = 0.999 + 0.002 * min(1.0, 1.6 * t / 0.3)
        return polar(0.5 + (outer - 0.5) * r, 90 * s, 1.6 * t)

    mesh.box('shaft', (3 * n, 12 * n, 10 * n), shaft, [('seat', 0, 1)])
    mesh.box('hub', (3 * n, 12 * n, 4 * n), lambda r, s, t: polar(
        1 + 0.6 * r, 90 * s, 0.8 * t - 0.75), [('bore', 0, 0)])


def runner(mesh, n):
    """2.4 long, 0.6 wide, 0.6 high; the belly has the radius 5 and touches x3 = 0."""
    def place(r, s, t):
        x = 1.2 * graded(r)
        low = 5 - math.sqrt(25 - x * x)
        return x, 0.6 * s, low + t * (0.6 - low)

    mesh.box('runner', (28 * n, 3 * n, 3 * n), place, [('belly', 2, 0)])


def ball(mesh, n):
    """Radius 1: a cube blown up, two of its sides look down at 45 degrees."""
    def place(r, s, t):
        a, b, c = graded(r, 1.3), graded(s, 1.3), graded(t, 1.3)
        size = math.sqrt(a * a + b * b + c * c)
        blow = max(abs(a), abs(b), abs(c)) / size if size > 0 else 0.0
        x, y, z = a * blow, b * blow, c * blow
        return (x - z) / math.sqrt(2), y, (x + z) / math.sqrt(2)

    mesh.box('ball', (8 * n, 8 * n, 8 * n), place, [
        ('skin', axis, end) for axis in range(3) for end in range(2)])


def belt(mesh, n):
    """A band of radii 1 and 1.04 over a drum of radius 1, axis x2."""
    def around(radius, degrees, y):
        x, z, y = polar(radius, degrees, y)
        return x, y, z

    mesh.box('band', (48 * n, 2 * n, n), lambda r, s, t: around(1.000002 + 0.04 * t, 180 * r, 0.3 * s),
             [('inside', 2, 0)])
    mesh.points('pulled', lambda x, y, z: z < 1e-6 and x > 0)
    mesh.points('lifted', lambda x, y, z: z < 1e-6 and x > 1.03)
    mesh.points('loaded', lambda x, y, z: z < 1e-6 and x < 0)
    mesh.places = {}
    mesh.box('drum', (60 * n, 1, 1), lambda r, s, t: around(
        0.7 + 0.3 * t, 360 * r + 2, 0.5 * s - 0.1), [('rim', 2, 1)])


def oring(mesh, n):
    """Radius 1, section of radius 0.2."""
    def place(r, s, t):
        a, b = 2 * r - 1, 2 * s - 1
        blow = max(abs(a), abs(b)) / math.hypot(a, b) if a or b else 0.0
        x, y, _ = polar(1 + 0.2 * a * blow, 90 * t, 0)
        return x, y, 0.2 * b * blow

    mesh.box('ring', (6 * n, 6 * n, 12 * n), place, [
        ('skin', axis, end) for axis in range(2) for end in range(2)])


def shrunk(mesh, n):
    """The ring from 0.5 to 1.001, the hub from 1 to 1.6, both 0.2 high."""
    mesh.box('ring', (8 * n, 20 * n, 2 * n), lambda r, s, t: polar(0.5 + 0.501 * r, 90 * s, 0.2 * t),
             [('seat', 0, 1)])
    mesh.places = {}
    mesh.box('hub', (8 * n, 16 * n, 2 * n), lambda r, s, t: polar(1 + 0.6 * r, 90 * s, 0.2 * t),
             [('bore', 0, 0)])


def roller(mesh, n):
    """Radii 0.7 and 1, 0.5 wide, its axis at x3 = 1; a facet lies flat on x3 = 0."""
    def place(r, s, t):
        x, z, y = polar(1 - 0.3 * r, 360 * s + 2.5, 0.5 * t - 0.05)
        return x, y, 1 + z

    mesh.box('roller', (1, 72 * n, 1), place, [('rim', 0, 0)])


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', nargs='?', default=os.path.dirname(os.path.abspath(__file__)))
    parser.add_argument('--fine', type=int, default=1)
    given = parser.parse_args()
    for make in (ring, fit, runner, ball, belt, oring, shrunk, roller):
        mesh = Mesh()
        make(mesh, given.fine)
        mesh.write(os.path.join(given.folder, make.__name__ + '.msh'))


if __name__ == '__main__':
    main()
