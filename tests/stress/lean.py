"""Planks that lean on a wall: statics says before the run which of them fall.

A uniform plank of length L and thickness t stands on a floor (mu_f) and leans on a wall (mu_w). What
floor and wall can do to it are two friction cones; it is held if forces in them balance its weight.
In the plane that is a linear programme of four rays (the edges of the cones) and three equations. Planks
near the border are not drawn: points of facets lie a little inside of the edges that carry them.
"""
import itertools
import math
import random

from scene import Deck, Body, Scene, number, CORNERS, TETRAHEDRA

FORMS = (('NTOS', ''), ('GTOS', ''), ('GTOS', '6'), ('GTOS', 'SEGMent'))
MARGIN = 1.3    # friction is more than so many times what is needed, or so many times less


def carried(rays, load):
    """Whether positive amounts of rays (force x, force z, moment) balance a load."""
    for three in itertools.combinations(rays, 3):
        (a, b, c), (d, e, f), (g, h, i) = three
        det = a*(e*i - f*h) - b*(d*i - f*g) + c*(d*h - e*g)
        if abs(det) < 1e-12:
            continue
        p, q, r = load
        amounts = ((p*(e*i - f*h) - q*(d*i - f*g) + r*(d*h - e*g))/det,
                   (a*(q*i - r*h) - b*(p*i - r*g) + c*(p*h - q*g))/det,
                   (a*(e*r - f*q) - b*(d*r - f*p) + c*(d*q - e*p))/det)
        if min(amounts) >= -1e-12:
            return True
    return False


class Plank:
    """Draws the plank of one seed, and what statics says of it."""

    def __init__(self, seed):
        draw = self.draw = random.Random(7919*seed + 5)
        self.form = draw.choice(FORMS)
        self.length, self.thick = draw.uniform(0.6, 2.0), draw.uniform(0.04, 0.15)
        self.width = draw.uniform(0.2, 0.6)
        self.falls = draw.random() < 0.6
        while True:
            self.angle = math.radians(draw.uniform(35.0, 80.0))
            self.mu = (draw.uniform(0.02, 0.9), draw.choice((0.0, draw.uniform(0.02, 0.9))))
            needed = self.needed()
            if needed > MARGIN if self.falls else needed < 1.0/MARGIN:
                break
        self.young = 10.0**draw.uniform(2.0, 6.0)
        self.softness = 10.0**draw.uniform(-6.0, -4.0)  # weight over modulus and section
        self.increments = draw.choice((1, 2, 3, 5))
        self.turn = draw.choice((0.0, 0.0, draw.uniform(0.0, 2*math.pi)))
        self.unit = 10.0**draw.choice((-2, 0, 0, 0, 2))
        self.shift = [draw.choice((0.0, draw.uniform(-100.0, 100.0))) for _ in range(3)]

    def corner(self, along, over):
        """A point of the plank in its plane: along it, and over its lower face."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        return c*along - s*over, s*along + c*over

    def holds(self, factor):
        """Statics with friction times a factor: cones at the lowest and the foremost edge."""
        foot, head = self.corner(0.0, 0.0), self.corner(self.length, 0.0)
        middle = self.corner(self.length/2, self.thick/2)
        rays = []
        for sign in (-1.0, 1.0):
            for place, force in ((foot, (sign*factor*self.mu[0], 1.0)), (head, (-1.0, sign*factor*self.mu[1]))):
                rays.append((*force, place[0]*force[1] - place[1]*force[0]))
        return carried(rays, (0.0, 1.0, middle[0]))

    def needed(self):
        """The factor on friction from which on it holds."""
        low, high = 1e-3, 1e3
        for _ in range(60):
            middle = math.sqrt(low*high)
            low, high = (low, middle) if self.holds(middle) else (middle, high)
        return high

    def placed(self, x, _):
        """A point of the scene: turned about the vertical, moved, in its units."""
        c, s = math.cos(self.turn), math.sin(self.turn)
        x = [c*x[0] - s*x[1], s*x[0] + c*x[1], x[2]]
        return [self.unit*(v + w) for v, w in zip(x, self.shift)]

    def scene(self, seed):
        """The scene."""
        draw, deck = self.draw, Deck(f'a plank that leans on a wall, {seed}')
        deck.form, deck.points = self.form
        wood = deck.elastic(self.young, draw.choice((0.0, 0.3, 0.4)))
        rigid = deck.rigid()
        a, wall = self.width/2, self.corner(self.length, 0.0)[0]

        def lean(x, unit):
            p, q = self.corner(x[0], x[2])
            return self.placed([p, x[1], q], unit)
        cells = (draw.randint(4, 10), draw.randint(1, 3), draw.randint(1, 2))
        plank = Body(deck, 'plank', cells, (0.0, -a, 0.0), (self.length, a, self.thick), wood, lean)
        floor = Body(deck, 'floor', (draw.randint(2, 4), draw.randint(2, 3), 1), (-2.0, -1.0, -0.3),
                     (wall, 1.0, 0.0), rigid, self.placed)
        beside = Body(deck, 'wall', (1, draw.randint(2, 3), draw.randint(2, 4)), (wall, -1.0, -0.3),
                      (wall + 0.3, 1.0, 2.5), rigid, self.placed)
        nx, ny, nz = cells
        deck.surface('sole', plank.layer(0))
        deck.surface('end', [plank.node(nx, j, k) for k in range(nz + 1) for j in range(ny + 1)])
        deck.surface('ground', floor.layer(-1))
        deck.surface('face', [beside.node(0, j, k) for k in range(beside.cells[2] + 1)
                              for j in range(beside.cells[1] + 1)])
        for name, slave, master, mu in (('foot', 'sole', 'ground', self.mu[0]),
                                        ('head', 'end', 'face', self.mu[1])):
            deck.pair(name, slave, master, ['PENAlty AUTO 10', f'FRICtion COULomb {number(mu)}' if mu
                                            else 'FRICtion NONE'])
        weight = self.young*self.softness*self.thick*self.width*self.unit**2
        table = deck.table([(0, 0), (1, 1)])
        share = plank_shares(plank)
        for node, part in share.items():
            deck.load(node, (0.0, 0.0, -weight*part), (table,)*3)
        deck.steps(1.0, self.increments)
        scene = Scene(f'lean {seed}', deck, 'lean', refused=self.falls,
                      mus={'foot': (self.mu[0],)*2, 'head': (self.mu[1],)*2},
                      balance=[('plank', [], {'foot': 1, 'head': 1}, lambda t: (0.0, 0.0, -weight*t))],
                      factor=self.unit*(2.5 + max(map(abs, self.shift))))
        scene.balance_wanted = 1e-6
        scene.floor = 1e-3*weight
        scene.notes = (f'{" ".join(self.form).strip()}, {math.degrees(self.angle):.0f} degrees, mu {self.mu[0]:.2f} '
                       f'{self.mu[1]:.2f}, {"falls" if self.falls else "holds"} ({self.needed():.3g})')
        return scene


def plank_shares(body):
    """Shares of the volume of a block of equal cells at its nodes: six tetrahedra a cell."""
    share = {}
    nx, ny, nz = body.cells
    for k, j, i in itertools.product(range(nz), range(ny), range(nx)):
        for tetrahedron in TETRAHEDRA:
            for m in tetrahedron:
                a, b, c = CORNERS[m]
                node = body.node(i + a, j + b, k + c)
                share[node] = share.get(node, 0.0) + 1.0/(24.0*nx*ny*nz)
    return share


def lean_scene(seed):
    """The scene of one seed."""
    return Plank(seed).scene(seed)
