"""Two equal elastic bodies of nearly half-space shape with shallow paraboloids, and their decks.

The profile is r^2/(2 R) up to r = 2 a and flat beyond, so that next to nothing is missing of the
half-spaces of Hertz, Cattaneo, Mindlin and Lubkin. The lower body has its own, coarser mesh. Both
meshes are symmetric about x = 0 and y = 0, as the bodies are: one that is not answers a press with
a sideward force.
"""
import math

import meshing
import quadratic_studies as quadratic
import unstructured

COARSER = 1.2
REACH = 1.3


def spacing(fine, cells, growth, layers):
    """Coordinates from 0: equal cells, then layers that grow."""
    places = [fine*i for i in range(cells + 1)]
    step = fine
    for _ in range(layers):
        step *= growth
        places.append(places[-1] + step)
    return places


def graded(cell, inner, outer, growth):
    """Coordinates from 0 to outer: equal cells up to `inner`, then cells that grow, ever faster."""
    count = max(1, round(inner/cell))
    places, step = [cell*i for i in range(count + 1)], cell
    while places[-1] < outer:
        step *= growth
        growth *= 1.02
        places.append(places[-1] + step)
    scale = outer/places[-1]
    tail = places[-1] - places[count]
    return places[:count + 1] + [x*(1 + (scale - 1)*(x - places[count])/tail)
                                 for x in places[count + 1:]]


class Pair:
    """The mesh of both bodies and its sets; mirrored: whether x = 0 and y = 0 are mirrors."""

    def __init__(self, radius, a, cell, mirrored, outer, growth=1.5, coarser=COARSER,
                 reach=REACH, ten=False):
        self.radius, self.a, self.mirrored, self.outer = radius, a, mirrored, outer
        self.mesh, self.parts, self.lower_from = meshing.Mesh(), {}, 0
        self.cell, self.reach = cell, reach*a
        self.add('upper', 1, cell, growth)
        self.lower_from = len(self.mesh.nodes) + 1
        self.upper = range(1, self.lower_from)
        self.add('lower', -1, cell*coarser, growth)
        if ten:
            self.add_middles()
        for axis in (0, 1):
            if mirrored[axis]:
                self.parts[f'mirror{axis + 1}'] = [
                    n for n, x in enumerate(self.mesh.nodes, 1) if abs(x[axis]) < 1e-9*outer]

    def add(self, name, sign, cell, growth):
        """One body."""
        right = graded(cell, self.reach, self.outer, growth)
        whole = [-x for x in reversed(right[1:])] + right
        lines = [right if mirror else whole for mirror in self.mirrored]
        depth = graded(cell, 0.5*self.a, self.outer, growth)
        levels = depth if sign > 0 else [-z for z in reversed(depth)]

        def place(i, j, k):
            x, y = lines[0][i], lines[1][j]
            return x, y, levels[k] + sign*self.rise(x, y)*(1 - abs(levels[k])/self.outer)

        counts = [len(line) - 1 for line in lines] + [len(levels) - 1]
        middle = [0 if mirror else len(right) - 1 for mirror in self.mirrored]
        number = self.mesh.box(counts, place, turned=middle)
        near, far = (0, counts[2]) if sign > 0 else (counts[2], 0)
        limit = self.reach + 0.1*self.a + cell
        far_nodes, face = [], []
        for k in range(counts[2] + 1):
            for j, y in enumerate(lines[1]):
                for i, x in enumerate(lines[0]):
                    if k == near and max(abs(x), abs(y)) < limit:
                        face.append(number(i, j, k))
                    if k == far or max(abs(x), abs(y)) > (1 - 1e-9)*self.outer:
                        far_nodes.append(number(i, j, k))
        self.parts[name], self.parts[name + '_far'] = face, far_nodes

    def rise(self, x, y):
        """Height of the profile of each body."""
        return min(x*x + y*y, 4*self.a**2)/(2*self.radius)

    def add_middles(self):
        """Ten nodes an element: the middles of edges lie where the mesh is mapped to, and belong to
        what both ends belong to."""
        corners, last = self.mesh, self.lower_from

        def place(p, q):
            # which body: the lower one has no node above its paraboloid, the upper none below
            sign = 1 if p[2] + q[2] > 0 or p[2] + q[2] == 0 and max(p[2], q[2]) > 0 else -1
            depth = sum((sign*x[2] - self.rise(*x[:2]))/(1 - self.rise(*x[:2])/self.outer) for x in (p, q))/2
            x, y = ((a + b)/2 for a, b in zip(p[:2], q[:2]))
            high = self.rise(x, y)
            return x, y, sign*(depth + high*(1 - depth/self.outer))
        upper = {n for e in corners.elements if e[1] < last for n in e[1:]}
        self.mesh = quadratic.ten_nodes(corners, place)
        ends = quadratic.ends(self.mesh)
        self.upper = upper | {n for n, pair in ends.items() if upper.issuperset(pair)}
        for name, numbers in self.parts.items():
            inside = set(numbers)
            self.parts[name] = numbers + [n for n, pair in ends.items() if inside.issuperset(pair)]

    def local(self, node):
        """Place of a node in the frame of its half-space, z inwards, and the sign of z."""
        x, y, z = self.mesh.nodes[node - 1]
        sign = 1 if node in self.upper else -1
        return x, y, sign*z, sign

    def sets(self):
        """Node sets and surfaces."""
        return ''.join(meshing.node_set(name, numbers) for name, numbers in self.parts.items()
                       ) + 'SURFace above FROM upper\nSURFace below FROM lower\n\n'

    def held(self):
        """BOUNdary of far faces and mirrors."""
        lines = ['BOUNdary', '  upper_far 1 1 1', '  lower_far 1 1 1']
        lines += [f'  mirror{axis + 1} ' + ' '.join('1' if k == axis else '0' for k in range(3))
                  for axis in (0, 1) if self.mirrored[axis]]
        return '\n'.join(lines) + '\n\n'


class Loose(Pair):
    """The same bodies, a quarter of each meshed by gmsh without structure; growth: of a cell over its distance."""

    def add(self, name, sign, cell, growth):
        """One body: a cube, mapped to the profile."""
        def build(occ):
            occ.addBox(0, 0, 0 if sign > 0 else -self.outer, self.outer, self.outer, self.outer)
            unstructured.coarsen(occ, cell, f'Sqrt(x*x+y*y+z*z)-{self.reach!r}', growth)
        body, first = unstructured.meshed(build, cell), len(self.mesh.nodes)
        limit, end = self.reach + 0.1*self.a + cell, (1 - 1e-9)*self.outer
        nodes = list(enumerate(body.nodes, first + 1))
        self.parts[name] = [n for n, (x, y, z) in nodes if abs(z) < 1e-9*self.outer and math.hypot(x, y) < limit]
        self.parts[name + '_far'] = [n for n, x in nodes if max(x[0], x[1], abs(x[2])) > end]
        self.mesh.nodes += [(x, y, z + sign*self.rise(x, y)*(1 - abs(z)/self.outer)) for _, (x, y, z) in nodes]
        self.mesh.elements += [(1, *(first + n for n in e)) for e in body.elements]


def table(number, points):
    """A proportional load."""
    return f'PROPortional {number}\n' + ''.join(f'  {t!r} {p!r}\n' for t, p in points) + '\n'


def friction(mu):
    """Records of the law: none, one coefficient, or two and the angle of the lay from x in degrees."""
    if isinstance(mu, tuple):
        return f'    FRICtion ELLIptic {mu[0]!r} {mu[1]!r}\n    DIREction ANGLe {mu[2]!r} 1 0 0\n'
    return f'    FRICtion COULomb {mu!r}\n' if mu else ''


def deck(pair, young, nu, form, mu, moves, tables, batch):
    """The deck; form: a key of FORMS; mu: as `friction` takes it; moves: records of DISPlacement and
    FPROportional."""
    words, *options = form.split(' +')
    side, *points = words.split()
    # of ten nodes 10 E/h with half the facet for h: a stiffer one makes the points scatter
    stiff = 20 if len(pair.mesh.elements[0]) > 5 else 50
    penalty = 'AUTO' if 'AUGM' in options else f'AREA {stiff*young/pair.cell!r}'
    return ('MFEC * * Two paraboloids\n\n' + meshing.solid(1, young, nu) + quadratic.records(pair.mesh) +
            pair.sets() + pair.held() + moves + tables +
            f'CONTact\n  PAIR 1 caps\n    {side} above below ' + ' '.join(points) +
            f'\n    PENAlty {penalty}\n' +
            friction(mu) +
            ''.join(f'    {option}\n' for option in options) +
            '\nOUTPut\n  REACtions upper_far\n  FIELds contact\n  STATe NONE\n\nEND\nBATCh\n' +
            batch + 'END\nSTOP\n')


def boussinesq(x, y, z, shear, nu):
    """Displacement of a half-space, z inwards, by a unit force along z at the origin."""
    rho, r2 = math.sqrt(x*x + y*y + z*z), x*x + y*y
    radial = (z/rho**3 - (1 - 2*nu)/(rho*(rho + z))) if r2 > 0 else 0.0
    factor = 1/(4*math.pi*shear)
    return factor*x*radial, factor*y*radial, factor*(z*z/rho**3 + 2*(1 - nu)/rho)


class Traction:
    """Slave nodes of a run: distance from the axis, area, and force at given times."""

    def __init__(self, pair, tables, times=(-1,)):
        shares = pair.mesh.shares(pair.parts['upper'])
        nodes = [n for n in shares if shares[n] > 0]
        self.areas = [shares[n] for n in nodes]
        self.radii = [math.hypot(*pair.mesh.nodes[n - 1][:2]) for n in nodes]
        self.forces = []
        for when in times:
            forces = tables.forces(when)
            self.forces.append([forces.get(n, [0.0]*3) for n in nodes])

    def pressures(self, when=-1):
        """(r, pressure, area) of each point."""
        return [(r, f[2]/area, area) for r, area, f in zip(self.radii, self.areas, self.forces[when])]

    def deficits(self, mu, when):
        """(r, mu p - q, area) of each point, q being the traction along x."""
        return [(r, (mu*f[2] - abs(f[0]))/area, area)
                for r, area, f in zip(self.radii, self.areas, self.forces[when])]


class Corners:
    """Linear functions of the corners on the slave's facets, for pressures: of ten nodes a corner has
    no force by itself (numpy, h5py)."""

    def __init__(self, pair):
        import numpy
        self.pair, self.facets = pair, dict(pair.mesh.outer_facets(pair.parts['upper']))
        corners = sorted({n for facet in self.facets for n in facet})
        self.place = {n: k for k, n in enumerate(corners)}
        self.radii = [math.hypot(*pair.mesh.nodes[n - 1][:2]) for n in corners]
        self.mass, self.areas = numpy.zeros([len(corners)]*2), numpy.zeros(len(corners))
        for facet, area in self.facets.items():
            at = [self.place[n] for n in facet]
            self.mass[numpy.ix_(at, at)] += area/12*(1 + numpy.eye(3))
            self.areas[at] += area/3

    def solve(self, right):
        """(r, pressure, area) of each corner, by the integrals of pressure times function."""
        import numpy
        return list(zip(self.radii, numpy.linalg.solve(self.mass, right), self.areas))

    def found(self, tables):
        """The pressure whose integrals are those of the points' forces."""
        right = [0.0]*len(self.place)
        for numbers, share, force in zip(*tables.points()[-1]):
            for k in range(3):
                # linear: a corner's weight and half of those of the edges at it
                linear = share[k] + (share[3 + k] + share[3 + (k + 2) % 3])/2
                right[self.place[numbers[k]]] += force[2]*linear
        return self.solve(right)

    def ellipse(self, radius):
        """The same of the half-ellipsoid of height 1: linear functions cannot follow its steep rim, and the
        corners within it swing by up to a tenth for that."""
        return self.solve(self.sums(radius))

    def means(self, radius):
        """Means of the half-ellipsoid around each corner, {node: mean}: a force over the area that it stands for."""
        sums = self.sums(radius)
        return {n: sums[k]/self.areas[k] for n, k in self.place.items()}

    def sums(self, radius, cuts=20):
        """Integrals of the half-ellipsoid times the functions, by cuts^2 points a facet."""
        right = [0.0]*len(self.place)
        for facet, area in self.facets.items():
            corners = [self.pair.mesh.nodes[n - 1][:2] for n in facet]
            for i, j, more in ((i, j, k/3) for k in (1, 2) for i in range(cuts) for j in range(cuts - i - k + 1)):
                share = (i + more)/cuts, (j + more)/cuts
                share += (1 - sum(share),)
                r2 = sum(sum(w*x[k] for w, x in zip(share, corners))**2 for k in (0, 1))/radius**2
                if r2 < 1:
                    for n, w in zip(facet, share):
                        right[self.place[n]] += w*math.sqrt(1 - r2)*area/cuts**2
        return right


def spread_of(pair, tables):
    """Radius of the half-ellipsoid from the moments of the points' forces themselves (h5py)."""
    whole = moment = 0.0
    for numbers, share, force in zip(*tables.points()[-1]):
        x, y = (sum(w*pair.mesh.nodes[n - 1][k] for n, w in zip(numbers, share)) for k in (0, 1))
        whole += force[2]
        moment += force[2]*(x*x + y*y)
    return math.sqrt(2.5*moment/whole)


def straight_line(points):
    """Least squares: value at 0 and slope."""
    n = len(points)
    sx, sy = sum(x for x, _ in points), sum(y for _, y in points)
    slope = (n*sum(x*y for x, y in points) - sx*sy)/(n*sum(x*x for x, _ in points) - sx*sx)
    return (sy - slope*sx)/n, slope


def top_of(points, radius):
    """Top of p = top sqrt(1 - r^2/radius^2), least squares of p^2 over (r, p, area) inside 0.8."""
    inside = [(1 - (r/radius)**2, p*p, area) for r, p, area in points if r < 0.8*radius]
    return math.sqrt(sum(w*x*y for x, y, w in inside)/sum(w*x*x for x, _, w in inside))


def radius_of(points):
    """Radius of that half-ellipsoid from its moments: integral of p r^2 = 2/5 radius^2 of p."""
    return math.sqrt(2.5*sum(p*r*r*area for r, p, area in points) /
                     sum(p*area for _, p, area in points))


def rates(sizes, errors):
    """Orders of convergence between neighbouring sizes."""
    return [math.log(e/f)/math.log(h/g) for h, g, e, f in zip(sizes, sizes[1:], errors, errors[1:])]
