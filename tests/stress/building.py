"""Puts bodies meshed by gmsh together: materials, supports, ways, loads and pairs of one scene.

A family works in axes of its own (floor at z = 0, down is -z); what is drawn at the end is a
rotation, a shift and units for all of it, so that nothing lies along an axis by design.
"""
import math
import random

import numpy as np

from scene import Deck, Scene, number

FORMS = (('NTOS', '', False), ('NTOS', '', True), ('GTOS', '', False), ('GTOS', '', True),
         ('GTOS', 'SEGMent', False), ('GTOS', 'SEGMent', True))


class Part:
    """A body in the scene: its solid at its place, the number of its first node, its balance."""

    def __init__(self, name, solid, place, first):
        self.name, self.solid, self.first = name, solid, first
        self.x = solid.points + place
        self.sets, self.signs = [], {}
        self.elastic, self.young = True, 0.0

    def nodes(self, triangles=None):
        """Node numbers, of all of it or of some triangles."""
        if triangles is None:
            return range(self.first, self.first + len(self.x))
        return [int(n) + self.first for n in np.unique(triangles)]

    def lowest(self, triangles=None):
        """Least height of its nodes."""
        nodes = slice(None) if triangles is None else np.unique(triangles)
        return self.x[nodes, 2].min()


class Building:
    """What the families build with: everything is drawn from the seed."""

    def __init__(self, seed, family, forms=FORMS):
        self.draw = random.Random(f'realistic {family} {seed}')
        draw = self.draw
        self.seed, self.family = seed, family
        self.deck = Deck(f'realistic scene {seed}: {family}')
        self.form = draw.choice(forms)
        self.deck.form, self.deck.points = self.form[:2]
        self.parts, self.mus, self.notes = [], {}, []
        self.times, self.counts = [0.0], []
        self.loads, self.ways, self.faces = {}, {}, []
        self.rotation = rotation(draw) if self.chance(0.6) else np.eye(3)
        self.unit = 10.0**draw.choice((-3, 0, 0, 0, 3))
        self.shift = np.array([draw.uniform(-10, 10) if self.chance(0.3) else 0.0 for _ in range(3)])
        self.young = 10.0**draw.uniform(0, 6)
        self.bound = 0.1
        self.allowed = []
        self.stiffness = 0.0  # sum of the penalties of all pairs [force/length]
        self.known = {}

    def chance(self, share):
        """True in this share of the cases."""
        return self.draw.random() < share

    def young_of(self, most=4.0):
        """Young's modulus of a body: the scene's, or stiffer by up to 10^most."""
        return self.young*(1.0 if self.chance(0.5) else 10.0**self.draw.uniform(0, most))

    def poisson(self):
        """Poisson's ratio, to 0.49."""
        return 0.49 if self.chance(0.1) else self.draw.uniform(0.0, 0.45)

    def phase(self, most=3, least=1):
        """One more unit of time, in so many increments at most; the place of its end."""
        self.times.append(self.times[-1] + 1.0)
        self.counts.append(self.draw.randint(least, most))
        return len(self.times) - 1

    def add(self, name, solid, place=(0.0, 0.0, 0.0), young=None, rigid=False):
        """A body at a place; rigid ones stand still unless they are given a way."""
        part = Part(name, solid, np.array(place, float), 0)
        if rigid:
            material, part.elastic = self.deck.rigid(), False
        else:
            part.young = young or self.young_of()
            material = self.deck.elastic(part.young, self.poisson())
        part.first = sum(len(p.x) for p in self.parts) + 1
        self.deck.elements += [(material, [int(n) + part.first for n in t])
                               for t in solid.tetrahedra]
        self.parts.append(part)
        return part

    def hold(self, part, triangles):
        """Clamps the nodes of some triangles (a rigid body needs none)."""
        if part.elastic:
            self.restrain(part, triangles)

    def restrain(self, part, triangles):
        """A set of restrained nodes with its reaction."""
        name = f'held_{part.name}'
        nodes = part.nodes(triangles)
        self.deck.set(name, nodes)
        if part.elastic:
            self.deck.fix(name)
            part.sets.append(name)
        return nodes

    def drive(self, part, triangles, way):
        """Moves nodes by way(x, phase end k) -> displacement of each."""
        nodes = part.nodes(None) if not part.elastic else self.restrain(part, triangles)
        for n in nodes:
            self.ways[n] = [way(part.x[n - part.first], k) for k in range(len(self.times))]

    def load(self, part, shares, force):
        """Forces on nodes of a body: shares of force(k), k the end of a phase; dead."""
        total = [np.array(force(k), float) for k in range(len(self.times))]
        for k, share in enumerate(shares):
            if share != 0.0:
                old = self.loads.setdefault(part.first + k, [np.zeros(3) for _ in self.times])
                self.loads[part.first + k] = [a + share*b for a, b in zip(old, total)]

    def surface(self, part, triangles, name=None):
        """The triangles as a surface; several bodies may give theirs to one name."""
        name = name or f'{part.name}_face{len(self.faces)}'
        listed = next((f for f in self.faces if f[0] == name), None)
        if not listed:
            listed = (name, [])
            self.faces.append(listed)
        listed[1].extend([[int(n) + part.first for n in t] for t in triangles])
        return name

    def pair(self, upper, lower, kind=None, mu=None, swap=False, penalty=None, label=None):
        """A pair between (part, triangles or surface's name); draws law and penalty. The slave is
        the upper side, unless swapped. Its least and largest coefficient."""
        draw = self.draw
        label = label or f'pair{len(self.deck.pairs) + 1}'
        sides = [(part, f if isinstance(f, str) else self.surface(part, f)) for part, f in (upper, lower)]
        sides = sides[::-1] if swap else sides
        factor = 10.0**draw.uniform(0, 2) if self.chance(0.3) else 10.0
        lines = [f'PENAlty {penalty or "AUTO " + number(factor)}']
        young = min((part.young for part, _ in sides if part is not None and part.elastic),
                    default=1e4*self.young)
        self.stiffness += (1e4 if self.form[2] else factor)*young/0.2
        kind = kind or draw.choice(('coulomb', 'coulomb', 'elliptic'))
        mu = self.friction() if mu is None else mu
        mu = (mu, mu) if np.isscalar(mu) else mu
        if kind == 'elliptic':
            mu = (mu[0], mu[1]*draw.uniform(0.4, 1.0))
            way = self.rotation @ np.array([1.0, 0.0, 0.0])
            lines += [f'FRICtion ELLIptic {number(mu[0])} {number(mu[1])}',
                      f'DIREction ANGLe {number(draw.uniform(0, 180))} ' + ' '.join(map(number, way)),
                      'SLIP ' + draw.choice(('COLLinear', 'TENSor', 'ASSOciated'))]
        elif max(mu) == 0.0:
            lines += ['FRICtion NONE']
        else:
            mu = (mu[0], mu[0])
            lines += [f'FRICtion COULomb {number(mu[0])}']
        if self.form[2]:
            lines.append('AUGMent')
        self.deck.pair(label, sides[0][1], sides[1][1], lines)
        self.mus[label] = mu
        for part, sign in ((sides[0][0], 1), (sides[1][0], -1)):
            if part is not None:
                part.signs[label] = sign
        self.notes.append(f'{label} {"Coulomb" if mu[0] == mu[1] else "elliptic"} mu {mu[0]:.3g}'
                          + (f'/{mu[1]:.3g}' if mu[0] != mu[1] else ''))
        return min(mu), max(mu)

    def friction(self, least=0.05, most=2.0):
        """A coefficient of friction."""
        return math.exp(self.draw.uniform(math.log(least), math.log(most)))

    def scene(self, wish, reason):
        """The scene. wish: 'solution', 'none: ' and what the message must say, or 'named: ' and what
        must be said of a solution whose place is one of many."""
        deck = self.deck
        place = [self.unit*(self.rotation @ x + self.shift) for part in self.parts for x in part.x]
        deck.x = [x.tolist() for x in place]
        for name, triangles in self.faces:
            deck.listed.append((name, triangles))
        self.write_ways()
        self.write_loads()
        for (begin, end), n in zip(zip(self.times, self.times[1:]), self.counts):
            deck.steps(end - begin, n)
        elastic = [part for part in self.parts if part.elastic]
        deck.outputs = [s for part in elastic for s in part.sets]
        scene = Scene(f'{self.family} {self.seed}', deck, 'realistic', mus=self.mus,
                      balance=[(part.name, part.sets, part.signs, self.load_of(part))
                               for part in elastic],
                      refused=wish.startswith('none'), seconds=400,
                      factor=max(float(np.abs(x).max()) for x in place))
        scene.family, scene.wish, scene.reason = self.family, wish, reason
        size = max(np.ptp(np.array(place), axis=0))
        far = max((np.linalg.norm(v) for way in self.ways.values() for v in way), default=0.0)
        scene.bound = self.bound*size + 3.0*far*self.unit
        scene.shallow = 0.05*size
        # Forces of the round-off of stresses are no forces.
        stiff = max((part.young for part in elastic), default=0.0)
        scene.floor = 1e-7*stiff*size*max(far*self.unit, 1e-6*size)
        # A gap is known to the last places of positions; times the penalties that is a force.
        scene.noise = 4*2.2e-16*scene.factor*self.stiffness*self.unit
        scene.allowed = self.allowed
        scene.balance_wanted = 1e-6 if self.form[2] else 1e-8
        word = (self.form[1] or self.form[0]) + (' AUGMent' if self.form[2] else '')
        scene.notes = ', '.join([word, f'{len(place)} nodes', *self.notes])
        scene.moments = [self.moment_of(part) for part in elastic]
        return scene

    def load_of(self, part):
        """Sum of the loads on a body as a function of time, in the deck's axes and units."""
        totals = [sum((self.loads[n][k] for n in part.nodes() if n in self.loads), np.zeros(3))
                  for k in range(len(self.times))]
        totals = [self.force_unit()*(self.rotation @ f) for f in totals]
        return lambda time: tuple(np.interp(time, self.times, [f[m] for f in totals])
                                  for m in range(3))

    def moment_of(self, part):
        """Moment of the loads on a body about the origin, as a function of time."""
        turned = [(self.unit*(self.rotation @ part.x[n - part.first] + self.shift), self.loads[n])
                  for n in part.nodes() if n in self.loads]
        totals = [sum((np.cross(x, self.force_unit()*(self.rotation @ f[k])) for x, f in turned),
                      np.zeros(3)) for k in range(len(self.times))]
        return lambda time: tuple(np.interp(time, self.times, [f[m] for f in totals])
                                  for m in range(3))

    def force_unit(self):
        """Forces of the families are pressure times length^2 in their axes."""
        return self.unit**2

    def write_ways(self):
        """Prescribed displacements, one table for each course in time."""
        for n, way in self.ways.items():
            values, tables = self.courses([self.unit*(self.rotation @ np.array(v)) for v in way])
            self.deck.move(n, values, tables)

    def write_loads(self):
        """Nodal forces, likewise."""
        for n, course in self.loads.items():
            values, tables = self.courses([self.force_unit()*(self.rotation @ v) for v in course])
            self.deck.load(n, values, tables)

    def courses(self, vectors):
        """Amplitudes and tables of the three components of a course."""
        values, tables = [], []
        for m in range(3):
            course = [float(v[m]) for v in vectors]
            top = max(course, key=abs)
            if top == 0.0:
                values.append(0.0)
                tables.append(0)
                continue
            key = tuple(round(c/top, 12) for c in course)
            if key not in self.known:
                self.known[key] = self.deck.table(list(zip(self.times, key)))
            values.append(top)
            tables.append(self.known[key])
        return values, tables


def rotation(draw):
    """A random rotation."""
    q = np.array([draw.gauss(0, 1) for _ in range(4)])
    w, x, y, z = q/np.linalg.norm(q)
    return np.array([[1 - 2*(y*y + z*z), 2*(x*y - w*z), 2*(x*z + w*y)],
                     [2*(x*y + w*z), 1 - 2*(x*x + z*z), 2*(y*z - w*x)],
                     [2*(x*z - w*y), 2*(y*z + w*x), 1 - 2*(x*x + y*y)]])


def about(axis, degrees):
    """Rotation about axis 0, 1 or 2."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    m, n = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[m, m] = matrix[n, n] = c
    matrix[m, n], matrix[n, m] = -s, s
    return matrix


class Wrench:
    """Sum of forces with the moment about the origin: what an interface has to carry."""

    def __init__(self):
        self.force, self.moment = np.zeros(3), np.zeros(3)

    def add(self, force, at):
        """One more force."""
        force = np.array(force, float)
        self.force = self.force + force
        self.moment = self.moment + np.cross(np.array(at, float), force)
        return self

    def on_level(self, z):
        """(where its line meets the plane z, |T|/N, torque about the normal there over N)."""
        fx, fy, fz = self.force
        mx, my, mz = self.moment
        # x fz' terms of M = r x F with r = (x, y, z)
        x = (z*fx - my)/fz
        y = (mx + z*fy)/fz
        torque = mz - (x*fy - y*fx)
        return np.array([x, y]), math.hypot(fx, fy)/abs(fz), abs(torque/fz)


def inside(polygon, p):
    """Distance of a point to the rim of a convex polygon (counter-clockwise), positive inside."""
    least = math.inf
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0)):
        d = b - a
        least = min(least, (d[0]*(p[1] - a[1]) - d[1]*(p[0] - a[0]))/np.hypot(*d))
    return least


def rectangle(a, b, turn=0.0, middle=(0.0, 0.0)):
    """Corners of a rectangle, turned by degrees about its middle, counter-clockwise."""
    corners = np.array([[-a, -b], [a, -b], [a, b], [-a, b]])/2
    return corners @ about(2, turn)[:2, :2].T + np.array(middle)
