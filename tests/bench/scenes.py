"""The scenes of the benchmark: mesh, supports, loads, contact, and the answers that are known."""
import dataclasses
import math

import numpy as np

from tetrahedra import Mesh


@dataclasses.dataclass
class Contact:
    """One pair of surfaces; the penalty is a pressure per length."""

    slave: str
    master: str
    penalty: float
    friction: float
    own_method: str = 'NTOS'
    tension: float = 5e-3   # CalculiX, node to surface: the pressure far away (it smooths the law)


@dataclasses.dataclass
class Scene:
    """What both programs compute. Displacements and forces are given for the end of each phase as
    value times the factor of that phase; increments are equal within a phase."""

    name: str
    size: float
    mesh: Mesh
    young: float
    poisson: float
    increments: tuple
    fixed: dict                                     # set: restrained directions
    moved: list = dataclasses.field(default_factory=list)   # set or node, direction, value, factors
    forces: dict = dataclasses.field(default_factory=dict)  # node: three components
    contact: Contact = None
    watched: str = ''                               # set whose reactions are summed
    shown: tuple = ()                               # set of one node and direction to be written
    law: str = 'LINEar'
    known: dict = dataclasses.field(default_factory=dict)

    def phases(self):
        """Number of phases."""
        return len(self.increments)


def cube_mesh(n, clearance=0.0):
    """A cube of n cells an edge over a base of 3 x 2 x 0.5 whose nodes lie beside its own."""
    mesh = Mesh()
    grid = np.linspace(0, 1, n + 1)
    cube = mesh.box('cube', grid, grid, grid + clearance)
    cells = round(2.55*n), round(1.7*n), round(0.42*n)
    base = mesh.box('base', np.linspace(-0.75, 2.25, cells[0] + 1),
                    np.linspace(-0.5, 1.5, cells[1] + 1), np.linspace(-0.5, 0, cells[2] + 1))
    mesh.node_sets['top'] = cube.nodes[:, :, -1]
    mesh.node_sets['ground'] = base.nodes[:, :, 0]
    mesh.surfaces['sole'] = cube.face(-1)
    mesh.surfaces['track'] = base.face(1)
    return mesh


def sliding_cube(n, friction=0.1, increments=(2, 20), law='LINEar', way=0.5):
    """The cube is pressed down by 1/200 of its edge and then moved by half of it."""
    depth = 0.005
    return Scene(
        name='cube' + ('' if friction else '_smooth') + ('' if law == 'LINEar' else '_neo')
        + ('' if increments == (2, 20) else '_' + '_'.join(map(str, increments))),
        size=n, mesh=cube_mesh(n), young=1000.0, poisson=0.3, increments=increments, law=law,
        fixed={'top': (1, 2, 3), 'ground': (1, 2, 3)},
        moved=[('top', 3, -depth, (1, 1)), ('top', 1, way, (0, 1))],
        contact=Contact('sole', 'track', 5e4, friction), watched='top',
        known={'T/N': friction})


def forced_cube(n):
    """The same cube, held by nothing but contact: pressed and pushed by forces on its top, in 22
    increments, to nine tenths of what friction bears."""
    scene = sliding_cube(n, increments=(22,))
    top = [int(node) for node in scene.mesh.node_sets['top'].ravel()]
    weight = 4.05/len(top)
    scene.name, scene.moved, scene.fixed = 'cube_force', [], {'ground': (1, 2, 3)}
    scene.watched = 'ground'
    scene.forces = {node: (0.09*weight, 0.0, -weight) for node in top}
    return scene


def turning_disc(n):
    """A pad is pressed on a disc that turns by 90 degrees (`TURN`) under it, in 30 increments; the
    disc has 2 n cells across, its corners are rounded off."""
    mesh, grid, cells = Mesh(), np.linspace(-1, 1, 2*n + 1), max(3, round(0.55*n))
    disc = mesh.box('disc', grid, grid, np.linspace(-0.25, 0, max(2, n//4) + 1), rounded)
    pad = mesh.box('pad', np.linspace(0.35, 0.75, cells + 1), np.linspace(-0.2, 0.2, cells + 1),
                   np.linspace(0, 0.3, round(0.75*cells) + 1))
    mesh.node_sets['top'], mesh.node_sets['hub'] = pad.nodes[:, :, -1], disc.nodes[:, :, 0]
    mesh.surfaces['sole'], mesh.surfaces['track'] = pad.face(-1), disc.face(1)
    return Scene(name='disc_neo', size=n, mesh=mesh, young=1000.0, poisson=0.3,
                 increments=(2, 30), law='NEOHookean', fixed={'top': (1, 2, 3)},
                 moved=[('top', 3, -0.003, (1, 1))], contact=Contact('sole', 'track', 5e4, 0.3),
                 watched='top')


TURN = (('CONTact\n', 'ROTAtion\n  hub 0 0 0 0 0 1 90 3\n\nPROPortional 3\n  0 0\n  1 0\n  2 1\n\n'
         'CONTact\n'),)


def rounded(points):
    """A square's points on a disc, nearly: its corners stay 0.77 of their width."""
    x, y = points[:, 0], points[:, 1]
    return np.stack([x*np.sqrt(1 - 0.4*y*y), y*np.sqrt(1 - 0.4*x*x), points[:, 2]], axis=1)


def loose_cubes(n):
    """27 cubes of n cells an edge that touch exactly, under a pressure on the upper nine, on a plate:
    contact alone holds them. Pairs beside that with the plate: `JOINTS`."""
    mesh, grid = Mesh(), np.linspace(0, 1, n + 1)
    place = {at: mesh.box('cube' + ''.join(map(str, at)), *(grid + k for k in at))
             for at in np.ndindex(3, 3, 3)}
    side = np.linspace(-0.3, 3.3, round(2.7*n) + 1)
    plate = mesh.box('plate', side, side, np.linspace(-0.5, 0, max(2, n//2) + 1))
    for axis in (1, 2, 3):
        for name, end, last in (('low', 1, 2), ('high', -1, 0)):
            faces = [box.face(end, axis) for at, box in place.items() if at[axis - 1] != last]
            mesh.surfaces[f'{name}{axis}'] = np.concatenate([f[0] for f in faces]), faces[0][1]
    soles = [box.face(-1) for at, box in place.items() if at[2] == 0]
    mesh.surfaces['soles'] = np.concatenate([f[0] for f in soles]), soles[0][1]
    mesh.surfaces['floor'] = plate.face(1)
    mesh.node_sets['ground'] = plate.nodes[:, :, 0]
    top = np.concatenate([box.nodes[:, :, -1].ravel() for at, box in place.items() if at[2] == 2])
    return Scene(name='cubes_27', size=n, mesh=mesh, young=1000.0, poisson=0.3, increments=(1,),
                 fixed={'ground': (1, 2, 3)}, watched='ground',
                 forces={int(node): (0.0, 0.0, -9.0/len(top)) for node in top},
                 contact=Contact('soles', 'floor', 5e4, 0.5))


JOINTS = ''.join(f'  PAIR {axis + 1} joints{axis}\n    GTOS low{axis} high{axis}\n'
                 '    PENAlty AREA 50000.0\n    FRICtion COULomb 0.5\n' for axis in (1, 2, 3))


def two_slabs(cells, spacing, height, base, start, layers=3):
    """A slab of cells x cells over a base of base x base cells whose corner is at `start`."""
    mesh = Mesh()
    grid = spacing*np.arange(cells + 1)
    under = start + 0.93*spacing*np.arange(base + 1)
    slab = mesh.box('cube', grid, grid, np.linspace(0, height, layers + 1))
    plate = mesh.box('base', under, under, np.linspace(-height, 0, layers + 1))
    mesh.node_sets['top'] = slab.nodes[:, :, -1]
    mesh.node_sets['ground'] = plate.nodes[:, :, 0]
    mesh.surfaces['sole'] = slab.face(-1)
    mesh.surfaces['track'] = plate.face(1)
    return mesh


def slid(name, size, mesh, height, way, friction=0.1, increments=(2, 5)):
    """A slab is pressed by 1/100 of the heights and slides."""
    return Scene(
        name=name, size=size, mesh=mesh, young=1000.0, poisson=0.3, increments=increments,
        fixed={'top': (1, 2, 3), 'ground': (1, 2, 3)},
        moved=[('top', 3, -0.01*height, (1, 1)), ('top', 1, way, (0, 1))],
        contact=Contact('sole', 'track', 2.5e4/height, friction), watched='top',
        known={'T/N': friction})


def large_contact(n):
    """A slab of (n+1)^2 slave nodes in contact from the first increment on, three cells thick."""
    height = 3/n
    mesh = two_slabs(n, 1/n, height, round(1.2*n/0.93), -0.1)
    return slid('plate', n, mesh, height, 1.5/n)


def small_contact(n):
    """A slab of 12 x 12 cells on a large base of n x n cells: the surface is large, contact not."""
    return slid('field', n, two_slabs(12, 1/12, 0.25, n, -0.7), 0.25, 0.3)


def graded(fine, inner, outer, growth):
    """Planes from 0 to outer: equal cells up to inner, from there on cells that grow."""
    cells = math.ceil(inner/fine - 1e-9)
    places, step = [fine*i for i in range(cells + 1)], fine
    while places[-1] + 0.5*step*growth < outer:
        step *= growth
        places.append(places[-1] + step)
    stretch = (outer - places[cells])/(places[-1] - places[cells])
    return [p if i <= cells else places[cells] + stretch*(p - places[cells])
            for i, p in enumerate(places)]


def boussinesq(points, force, young, poisson):
    """Displacement (n, 3) of the half-space x3 > 0 under a force along x3 at the origin."""
    z, rho = points[:, 2], np.linalg.norm(points, axis=1)
    scale = force*(1 + poisson)/(2*math.pi*young)
    along = scale*(z**2/rho**3 + 2*(1 - poisson)/rho)
    out = scale*(z/rho**3 - (1 - 2*poisson)/(rho*(rho + z)))
    return np.stack([out*points[:, 0], out*points[:, 1], along], axis=1)


def hertz(size, increments=4, ten=False):
    """A paraboloid on a plate, both elastic, no friction: a quarter, radius of contact 1, curvature
    1/200, facets of `size`. The far faces at distance 8 move as those of half-spaces under a point
    load, so that approach, force and pressure are Hertz's. ten: elements of ten nodes, whose middles
    lie on the paraboloid."""
    radius, young, poisson, outer = 200.0, 1000.0, 0.3, 8.0
    modulus = young/(2*(1 - poisson**2))
    approach = 1/radius
    force = 4/3*modulus*math.sqrt(radius)*approach**1.5
    mesh, moved = Mesh(), []
    growth = 1 + 3*size

    def lifted(points):
        rise = (points[:, 0]**2 + points[:, 1]**2)/(2*radius)
        return points + np.outer(rise*(1 - points[:, 2]/outer), (0, 0, 1))

    across = graded(size, 1.25, outer, growth)
    depth = graded(size, 0.6, outer, growth)
    cap = mesh.box('cap', across, across, depth, lifted)
    across = graded(0.85*size, 1.25, outer, growth)
    plate = mesh.box('plate', across, across, [-z for z in reversed(depth)])
    mesh.surfaces['above'], mesh.surfaces['below'] = cap.face(-1), plate.face(1)
    for name, box, sign in (('cap', cap, 1), ('plate', plate, -1)):
        far = np.unique(np.concatenate([box.nodes[-1].ravel(), box.nodes[:, -1].ravel(),
                                        box.nodes[:, :, -1 if sign > 0 else 0].ravel()]))
        mesh.node_sets[name + '_far'] = far
        mesh.node_sets[name + '_x'], mesh.node_sets[name + '_y'] = box.nodes[0].ravel(), box.nodes[:, 0].ravel()
    flat = mesh.nodes.copy()  # where the cap was before it was lifted
    flat[:cap.nodes.size, 2] = heights(cap, depth, cap.nodes.ravel(order='F'))
    if ten:
        flat = np.vstack([flat, mesh.add_middles(flat, lambda middles, pairs: np.where(
            (pairs[:, :1] <= cap.nodes.size), lifted(middles), middles))])
    for name, sign in (('cap', 1), ('plate', -1)):
        far = mesh.node_sets[name + '_far']
        for side in ('_x', '_y'):
            mesh.node_sets[name + side] = np.setdiff1d(mesh.node_sets[name + side], far)
        shift = boussinesq(np.abs(flat[far - 1]), force, young, poisson)*(1, 1, sign) - \
            np.array((0, 0, approach if sign > 0 else 0))
        moved += [(int(n), i, float(u), (1,)) for n, row in zip(far, shift)
                  for i, u in enumerate(row, 1)]
    return Scene(
        name='hertz_ten' if ten else 'hertz', size=size, mesh=mesh, young=young, poisson=poisson,
        increments=(increments,), moved=moved,
        fixed={'cap_far': (1, 2, 3), 'plate_far': (1, 2, 3), 'cap_x': (1,), 'plate_x': (1,),
               'cap_y': (2,), 'plate_y': (2,)},
        contact=Contact('above', 'below', 20*young/size if ten else 5e5, 0.0), watched='cap_far',
        known={'force': force/4, 'pressure': 2*modulus/(math.pi*radius), 'modulus': modulus,
               'radius': radius})


def punch(n, radius=4.0, depth=0.06, way=0.012, increments=(4, 8)):
    """A paraboloid of ten-node tetrahedra is pressed on a block and sheared: partial slip."""
    mesh, across = Mesh(), np.linspace(-1, 1, n + 1)
    layers = np.linspace(0, 1, n//2 + 1)

    def lifted(points):
        rise = (points[:, 0]**2 + points[:, 1]**2)/(2*radius)
        return points + np.outer(rise*(1 - points[:, 2]), (0, 0, 1))

    cap = mesh.box('cap', across, across, layers, lifted)
    wide = np.linspace(-1.3, 1.3, n + 2)
    base = mesh.box('base', wide, wide, layers - 1)
    mesh.surfaces['sole'], mesh.surfaces['track'] = cap.face(-1), base.face(1)
    flat = mesh.nodes.copy()  # where the cap was before it was lifted
    flat[:cap.nodes.size, 2] = heights(cap, layers, cap.nodes.ravel(order='F'))
    flat = np.vstack([flat, mesh.add_middles(flat, lambda middles, pairs: np.where(
        pairs[:, :1] <= cap.nodes.size, lifted(middles), middles))])
    for name, height in (('top', 1), ('ground', -1)):
        mesh.node_sets[name] = 1 + np.flatnonzero(abs(flat[:, 2] - height) < 1e-9)
    return Scene(
        name='punch_ten', size=n, mesh=mesh, young=1000.0, poisson=0.3, increments=increments,
        fixed={'top': (1, 2, 3), 'ground': (1, 2, 3)},
        moved=[('top', 3, -depth, (1, 1)), ('top', 1, way, (0, 1))],
        contact=Contact('sole', 'track', 2e4, 0.3), watched='top')


def heights(box, depth, numbers):
    """The plane in which each node of a box was before it was mapped."""
    plane = np.broadcast_to(np.asarray(depth), box.nodes.shape).ravel(order='F')
    return plane[numbers - box.nodes.min()]


def bent(points, length, radius, poisson):
    """Displacement (n, 3) of a beam along x1 bent to a radius, clamped in the mean at x1 = 0."""
    a, b, c = points.T
    return np.stack([a*c/radius, -poisson*b*c/radius,
                     -(a*a + poisson*(c*c - b*b))/(2*radius)], axis=1)


def cantilever(n):
    """Pure bending of a beam of 2n x n x n cells by the tractions of the exact solution."""
    young, poisson, length, radius = 1000.0, 0.3, 2.0, 100.0
    mesh = Mesh()
    across = np.linspace(-0.5, 0.5, n + 1)
    beam = mesh.box('beam', np.linspace(0, length, 2*n + 1), across, across)
    clamped = beam.nodes[0].ravel()
    tip = beam.nodes[-1, n//2, n//2]
    mesh.node_sets['clamped'], mesh.node_sets['tip'] = clamped, np.array([tip])
    given = bent(mesh.nodes[clamped - 1], length, radius, poisson)
    end, z = beam.nodes[-1], across.tolist()
    forces = {int(m): 0.0 for m in end.ravel()}
    for j in range(n):
        for k in range(n):
            corner = [(j, k), (j + 1, k), (j + 1, k + 1), (j, k + 1)]
            for facet in ((0, 1, 2), (0, 2, 3)):
                total = sum(z[corner[m][1]] for m in facet)
                for m in facet:
                    forces[int(end[corner[m]])] += \
                        young/radius*(total + z[corner[m][1]])/(24*n*n)
    exact = bent(mesh.nodes[tip - 1:tip], length, radius, poisson)[0, 2]
    return Scene(
        name='cantilever', size=n, mesh=mesh, young=young, poisson=poisson, increments=(1,),
        fixed={'clamped': (1, 2, 3)}, shown=('tip', 3),
        moved=[(int(m), i, float(u), (1,)) for m, row in zip(clamped, given)
               for i, u in enumerate(row, 1)],
        forces={m: (f, 0.0, 0.0) for m, f in forces.items()}, known={'tip': float(exact)})
