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
fitted    ten nodes: a quarter of a hollow shaft and of the bush around it, which overlap; regions shaft,
          bush; surfaces seat (shaft), bore (bush)
gears     ten nodes: three teeth of two gears on parts of their rims; regions drive, driven; surfaces
          flanks (drive), teeth (driven); sets of the nodes of their hubs
tyre      a ring about x2 that stands on x3 = 0: regions tyre, rim; surface tread
lap       two plates with a hole, lapped, and a hollow bolt with two heads: regions lower, upper, bolt;
          surfaces lower_top, upper_bottom, seat_above, seat_below, head, nut, shank, hole1, hole2

lug.msh is made by Gmsh from lug.geo: gmsh -3 lug.geo -format msh22 -o lug.msh; seal.msh, a quarter of an
O-ring of ten-node elements, from seal.geo: gmsh -3 seal.geo -order 2 -format msh22 -o seal.msh
"""
import argparse
import math
import os

# A cell as BLOCk TET4 cuts it, and the sides of a box with their two triangles a cell.
CELL = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
MIDDLES = ((0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3))
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


class Mesh:
    """Nodes, tetrahedra and triangles of named groups."""

    def __init__(self, has_mid_nodes=False):
        self.nodes, self.cells, self.names = [], [], {}
        self.places = {}
        self.kinds = {4: 11, 3: 9} if has_mid_nodes else {4: 4, 3: 2}
        self.has_mid_nodes = has_mid_nodes

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

        def nodes_of(cell, corners):
            """Corners, and mid nodes in Gmsh's order, on the curved geometry."""
            ends = [tuple(a + b for a, b in zip(cell, CORNERS[m])) for m in corners]
            found = [at(*e) for e in ends]
            for a, b in MIDDLES[:3 if len(ends) == 3 else 6] if self.has_mid_nodes else ():
                found.append(at(*((x + y) / 2 for x, y in zip(ends[a], ends[b]))))
            return found

        volume, facets = self.group(3, region), {}
        for i in range(counts[0]):
            for j in range(counts[1]):
                for k in range(counts[2]):
                    for a, b, c in CORNERS:  # numbered in this order
                        at(i + a, j + b, k + c)
                    for tet in CELL:
                        self.cells.append((self.kinds[4], volume, nodes_of((i, j, k), tet)))
                    for name, axis, end in sides:
                        if (i, j, k)[axis] == end * (counts[axis] - 1):
                            on = {m for m in range(8) if CORNERS[m][axis] == end}
                            for tet in CELL:
                                three = [m for m in tet if m in on]
                                if len(three) == 3:
                                    facets.setdefault(name, []).append(nodes_of((i, j, k), three))
        for name, triangles in facets.items():
            number = self.group(2, name)
            self.cells += [(self.kinds[3], number, triangle) for triangle in triangles]

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


def fitted(mesh, n):
    """Radii 10, 20, 32; each of the two is 0.01 thicker than there is room for, both 20 long."""
    mesh.box('shaft', (3 * n, 8 * n, 8 * n), lambda r, s, t: polar(10 + 10.01 * r, 90 * s, 20 * t),
             [('seat', 0, 1)])
    mesh.places = {}
    mesh.box('bush', (3 * n, 8 * n, 8 * n), lambda r, s, t: polar(19.99 + 12.01 * r, 90 * s, 20 * t),
             [('bore', 0, 0)])


TEETH, MODULE, PRESSURE_ANGLE = 20, 5.0, math.radians(20)
BASE = TEETH * MODULE / 2 * math.cos(PRESSURE_ANGLE)


def half_tooth(radius, backlash):
    """Half of the angle that an involute tooth takes at a radius; straight below the base circle."""
    angle = math.acos(min(1.0, BASE / radius))
    involute = math.tan(angle) - angle
    at_pitch = math.tan(PRESSURE_ANGLE) - PRESSURE_ANGLE
    return math.pi / (2 * TEETH) + at_pitch - involute - backlash / (TEETH * MODULE)


def gears(mesh, n):
    """Module 5, 20 teeth, 20 degrees, 8 wide; the upper flank of the middle tooth of `drive` is at the
    pitch point (50, 0). `driven` is drive turned by 180 degrees about that point, 0.02 away."""
    root, tip, hub = 43.75, 54.8, 37.0
    pitch, base = 2 * math.pi / TEETH, half_tooth(43.75, 0.1)

    def gear(region, side, flank, whole):
        def at(radius, angle, z):
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            return (x, y, z) if side > 0 else (100.02 - x, -y, z)

        middle = -half_tooth(MODULE * TEETH / 2, 0.1)
        for k in (-1, 0, 1):
            centre = middle + k * pitch

            def tooth(r, s, t, centre=centre):
                radius = root + (tip - root) * r
                return at(radius, centre + (2 * s - 1) * half_tooth(radius, 0.1), 8 * t)

            def below(r, s, t, centre=centre):
                return at(hub + (root - hub) * r, centre + (2 * s - 1) * base, 8 * t)

            def beside(r, s, t, centre=centre):
                return at(hub + (root - hub) * r, centre + base + s * (pitch - 2 * base), 8 * t)

            mesh.box(region, (8 * n, 5 * n, 2 * n), tooth, [(flank, 1, 0), (flank, 1, 1)])
            mesh.box(region, (2 * n, 5 * n, 2 * n), below)
            if k < 1:
                mesh.box(region, (2 * n, 2 * n, 2 * n), beside)
        mesh.points(whole, lambda x, y, z: abs(math.hypot(x if side > 0 else 100.02 - x, y) - hub) < 1e-6
                    and (side > 0) == (x < 50))
        mesh.places = {}

    gear('drive', 1, 'flanks', 'hub1')
    gear('driven', -1, 'teeth', 'hub2')


def tyre(mesh, n):
    """Radius 1, from 0.72 on of rubber, inside it a rim; 0.36 wide; its axis at x3 = 1."""
    def around(radius, s, t):
        x, z, y = polar(radius, 360 * s + 2.5, 0.36 * t - 0.18)
        return x, y, 1 + z

    mesh.box('tyre', (3 * n, 60 * n, 4 * n), lambda r, s, t: around(1 - 0.28 * r, s, t),
             [('tread', 0, 0)])
    mesh.box('rim', (n, 60 * n, 4 * n), lambda r, s, t: around(0.72 - 0.12 * r, s, t))


def lap(mesh, n):
    """Plates 60 x 40 x 8, lapped by 40, holes of radius 5.2; a bolt of radius 5 with a hole of 2."""
    def plate(x0, x1, z0, z1, away):
        def place(r, s, t):
            angle = 360 * s - 135
            c, d = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            out = 20 / max(abs(c), abs(d))
            radius = 5.2 + (out - 5.2) * r**1.3
            return radius * c, radius * d, z0 + (z1 - z0) * t

        def tongue(r, s, t):
            # the square's side is cut at equal angles
            y = 20 * math.tan(math.radians(90 * s - 45))
            return x0 + (x1 - x0) * r, y if away > 0 else -y, z0 + (z1 - z0) * t

        return place, tongue

    for region, ends, heights, away, facing, other, hole in (
            ('lower', (-20, -50), (-8, 0), -1, 1, 0, 'hole1'),
            ('upper', (20, 50), (0, 8), 1, 0, 1, 'hole2')):
        place, tongue = plate(*ends, *heights, away)
        names = {0: 'upper_bottom', 1: 'seat_above'} if away > 0 else {0: 'seat_below', 1: 'lower_top'}
        mesh.box(region, (5 * n, 32 * n, 3 * n), place, [(names[0], 2, 0), (names[1], 2, 1), (hole, 0, 0)])
        mesh.box(region, (4 * n, 8 * n, 3 * n), tongue, [(names[0], 2, 0), (names[1], 2, 1)])
        mesh.places = {}
    grip = 8 - 0.01

    def around(low, high, bottom, top):
        def place(r, s, t):
            x, y, _ = polar(low + (high - low) * r, 360 * s, 0)
            return x, y, bottom + (top - bottom) * t
        return place

    for bottom, top, count, side in ((-13, -grip, 2, None), (-grip, grip, 6, 'shank'), (grip, 13, 2, None)):
        mesh.box('bolt', (2 * n, 24 * n, count * n), around(2, 5, bottom, top),
                 [(side, 0, 1)] if side else [])
    mesh.box('bolt', (3 * n, 24 * n, 2 * n), around(5, 9, grip, 13), [('head', 2, 0)])
    mesh.box('bolt', (3 * n, 24 * n, 2 * n), around(5, 9, -13, -grip), [('nut', 2, 1)])


SECOND_ORDER = (fitted, gears)


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('folder', nargs='?', default=os.path.dirname(os.path.abspath(__file__)))
    parser.add_argument('--fine', type=int, default=1)
    parser.add_argument('--only', nargs='*', default=[])
    given = parser.parse_args()
    for make in (ring, fit, runner, ball, belt, oring, shrunk, roller, *SECOND_ORDER, tyre, lap):
        if given.only and make.__name__ not in given.only:
            continue
        mesh = Mesh(make in SECOND_ORDER)
        make(mesh, given.fine)
        mesh.write(os.path.join(given.folder, make.__name__ + '.msh'))


if __name__ == '__main__':
    main()
