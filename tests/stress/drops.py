"""Random scenes of a body that falls: into a bowl, onto a shelf or a floor that it does not touch at
the start, of four and ten nodes, with and without multipliers. Supports, friction or nothing hold it
on the way; in the end the surface below carries what it weighs."""
import math
import random

from scene import Deck, Body, Scene, number

HALF = 1.3              # half the width of what it falls on
FORMS = ('GTOS 6', 'GTOS 3', 'GTOS SEGMent', 'NTOS')
BENT_FORMS = FORMS[:2] + ('GTOS',)  # what facets of six nodes take


class Drop:
    """Draws the scene of one seed."""

    def __init__(self, seed):
        draw = self.draw = random.Random(100003*seed + 17)
        self.kind = draw.choice(('bowl', 'bowl', 'shelf', 'floor', 'floor'))
        self.ten = draw.random() < 0.6
        self.ten_below = self.ten and draw.random() < 0.5
        self.augment = draw.random() < 0.5
        self.form = draw.choice(BENT_FORMS if self.ten else FORMS)
        self.mu = draw.choice((0.0, 0.0, 0.0, 0.1, 0.3, 0.6))
        self.increments = draw.choice((1, 1, 2, 3, 5))
        self.moved = draw.random() < 0.25   # its top is let down, else it falls
        self.young = 10.0**draw.uniform(2.5, 5.0)
        self.size = (draw.uniform(0.3, 0.9), draw.uniform(0.3, 0.9), draw.uniform(0.2, 0.7))
        self.gap = 10.0**draw.uniform(-1.7, 0.3)*min(self.size)
        self.turn = [draw.choice((0.0, 0.0, draw.uniform(-0.3, 0.3))) for _ in range(2)]
        self.bulge = draw.choice((0.0, 0.3))*draw.random()
        self.aside = [draw.uniform(-0.3, 0.3) for _ in range(2)]
        self.curve = draw.uniform(0.15, 0.8) if self.kind == 'bowl' else 0.0
        self.deck = Deck(f'a body that falls, {seed}')
        self.deck.form, _, self.deck.points = self.form.partition(' ')

    def place(self, x, unit):
        """A point of the body: its sole bulges, then it is turned and moved aside."""
        z = x[2] + 0.5*self.bulge*self.size[2]*(1.0 - unit[2])*((2*unit[0] - 1)**2 + (2*unit[1] - 1)**2)
        out = [x[0], x[1], z]
        for m, angle in enumerate(self.turn):
            c, s = math.cos(angle), math.sin(angle)
            out[m], out[2] = c*out[m] + s*out[2], c*out[2] - s*out[m]
        return [out[0] + self.aside[0], out[1] + self.aside[1], out[2]]

    def below(self, x, unit):
        """A point of what it falls on."""
        return [x[0], x[1], x[2] + self.curve*(x[0]**2 + x[1]**2)*unit[2]]

    def bodies(self):
        """The body, lifted by its gap, and what is below; both."""
        draw, deck = self.draw, self.deck
        most = 3 if self.ten else 4
        cells = (draw.randint(1, most), draw.randint(1, most), draw.randint(1, most - 1))
        a, b, c = self.size
        steel = deck.elastic(self.young, 0.3)
        body = Body(deck, 'body', cells, (-a/2, -b/2, 0.0), (a/2, b/2, c), steel, self.place,
                    draw.choice((0.0, 0.3)), draw)
        most = 5 if self.ten_below else 8
        cells = (draw.randint(3, most), draw.randint(3, most), 1 if self.ten_below else draw.randint(1, 2))
        ground = deck.elastic(self.young*10.0**draw.uniform(-0.5, 1.0), 0.3)
        low, high = (-HALF, -HALF, -0.4), (HALF, HALF, 0.0)
        if self.kind == 'shelf':
            end = draw.uniform(0.2, 0.6)
            low, high = (end - 2.0, -HALF, -draw.uniform(0.1, 0.5)), (end, HALF, 0.0)
        lower = Body(deck, 'lower', cells, low, high, ground, self.below, draw.choice((0.0, 0.3)), draw)
        points = deck.x[body.first - 1:lower.first - 1]
        lift = self.gap - min(x[2] - self.curve*(x[0]**2 + x[1]**2) for x in points)
        lift += self.curve*(HALF/min(cells[:2]))**2     # facets lie above the bowl that they cut off
        for x in points:
            x[2] += lift
        return body, lower

    def scene(self, seed):
        """The scene."""
        deck, draw = self.deck, self.draw
        body, lower = self.bodies()
        deck.surface('under', body.layer(0))
        deck.surface('upper', lower.layer(-1))
        nx, ny, nz = lower.cells
        deck.set('ground', [lower.node(0, j, k) for j in range(ny + 1) for k in range(nz + 1)]
                 if self.kind == 'shelf' else lower.layer(0))
        deck.set('top', body.layer(-1))
        deck.fix('ground')
        table = deck.table([(0, 0), (1, 1)])
        if self.moved:
            deck.fix('top', draw.choice(((1, 1, 1), (0, 0, 1))))
            deck.move('top', (0, 0, -self.gap - 0.02*self.size[2]), (table,)*3)
        lines = [f'PENAlty {draw.choice(("AUTO", "AUTO 10", "AUTO 100"))}']
        if self.mu:
            lines.append(f'FRICtion COULomb {number(self.mu)}')
        deck.pair('touch', 'under', 'upper', lines + ['AUGMent']*self.augment)
        deck.steps(1.0, self.increments)
        for material, ten in ((1, self.ten), (2, self.ten_below)):
            if ten:
                deck.add_middles(material, lambda p, q: [0.5*(u + v) for u, v in zip(p, q)])
        weight = self.weigh(10.0**draw.uniform(-3.0, -1.0)*self.young, table)
        deck.outputs = ['ground'] + ['top']*self.moved
        scene = Scene(f'drop {seed}', deck, 'drop', mus={'touch': (self.mu, self.mu)},
                      balance=[('body', ['top']*self.moved, {'touch': 1}, lambda t: (0.0, 0.0, -weight*t))],
                      factor=2.0*HALF)
        scene.balance_wanted = 1e-6 if self.augment else 1e-9
        scene.floor = 1e-3*weight
        scene.notes = (f'{self.kind}, {10 if self.ten else 4} nodes, {self.form}'
                       f'{", AUGMent" if self.augment else ""}, mu {self.mu}, {self.increments} increments')
        return scene

    def weigh(self, density, table):
        """Puts the weight of each element on its nodes; all of it."""
        deck, share, total = self.deck, {}, 0.0
        for material, nodes in deck.elements:
            if material != 1:
                continue
            a, b, c, d = (deck.x[n - 1] for n in nodes[:4])
            e = [[q[m] - a[m] for m in range(3)] for q in (b, c, d)]
            part = density/6.0*abs(sum(e[0][m]*(e[1][m - 2]*e[2][m - 1] - e[1][m - 1]*e[2][m - 2])
                                       for m in range(3)))
            total += part
            for k, n in enumerate(nodes):
                factor = 0.25 if len(nodes) == 4 else -0.05 if k < 4 else 0.2
                share[n] = share.get(n, 0.0) + factor*part
        for n, part in share.items():
            deck.load(n, (0.0, 0.0, -part), (table,)*3)
        return total


def drop_scene(seed):
    """The scene of one seed."""
    return Drop(seed).scene(seed)
