"""Random scenes: blocks of random shape on a random base, random pairs, laws and paths.

A scene depends on its seed only, so any one can be run again by its number.
"""
import math
import random

from scene import Deck, Body, Scene, clearance, number, rotate, with_mortar

# A top that turns takes its block of small strain along; from 18 degrees on that ends a run.
MOST_TURN = 0.2  # [rad]


class Maker:
    """Makes the scene of one seed."""

    def __init__(self, seed):
        self.draw = random.Random(seed)
        self.deck = Deck(f'random scene {seed}')
        self.seed = seed
        self.scale = 10.0**self.draw.choice((-3, 0, 0, 0, 2))
        self.young = 10.0**self.draw.uniform(0, 6)
        self.balance, self.mus, self.notes = [], {}, []
        self.signs = {}
        self.stiffest = 0.0
        self.hardest = self.young       # of all bodies
        self.times = [0.0]
        self.phases = []

    def chance(self, share):
        """True in this share of the cases."""
        return self.draw.random() < share

    def scene(self):
        """Draws everything; the scene."""
        draw = self.draw
        self.draw_path()
        count = draw.choice((1, 1, 1, 2, 2, 3))
        self.base(count)
        for k in range(count):
            self.block(k)
        if self.chance(0.15):
            self.upper_block()
        for name, sets, load in self.held:
            self.balance.append((name, sets, self.signs[name], load))
        deck = self.deck
        deck.outputs = [s for _, sets, _ in self.held for s in sets]
        for (begin, end), n in zip(zip(self.times, self.times[1:]), self.counts):
            deck.steps(end - begin, n)
        far = max(abs(v) for x in deck.x for v in x)
        scene = Scene(f'random {self.seed}', deck, 'random', balance=self.balance, mus=self.mus,
                      factor=far)
        # A gap is known to the last place of positions of a few times the scale; times the penalty, and
        # summed over some tens of points, that is a force of 3e-14 k E scale^2: 1e-9 of this floor.
        # And displacements, times the modulus of the hardest body.
        scene.floor = (1e-5*self.hardest + 3e-5*self.stiffest*self.young)*self.scale**2
        scene.notes = ', '.join(self.notes)
        return scene

    def of_hardness(self, factor):
        """Young's modulus of a body."""
        young = factor*self.young
        self.hardest = max(self.hardest, young)
        return young

    def draw_path(self):
        """The phases all blocks go through; each block follows them in its own way."""
        draw = self.draw
        words = ['press']
        for _ in range(draw.randint(1, 4)):
            words += draw.choice((['slide'], ['slide'], ['slide'], ['turn'], ['slide', 'back'],
                                  ['press'], ['lift', 'return', 'press'], ['tilt']))
        self.phases = words
        self.counts = []
        for word in words:
            self.times.append(self.times[-1] + 1.0)
            most = 3 if word in ('press', 'lift', 'return') else 6
            self.counts.append(draw.randint(1, most))
        self.notes.append('-'.join(f'{w}{n}' for w, n in zip(words, self.counts)))

    def base(self, count):
        """The body below: flat, rough, wavy or with a ridge."""
        draw, s = self.draw, self.scale
        self.span = (1.7*count + 1.2, 2.6)
        cells = (draw.randint(2 + count, 4 + 2*count), draw.randint(2, 5), draw.randint(1, 2))
        kind = draw.choice(('flat', 'flat', 'rough', 'wavy', 'ridge'))
        amount = draw.uniform(0.0, 0.03)
        rigid = self.chance(0.35)
        self.notes.append(f'{"rigid" if rigid else "elastic"} {kind} base')
        span = self.span

        def height(x, y):
            if kind == 'rough':
                return amount*draw.uniform(-1, 1)
            if kind == 'wavy':
                return amount*math.cos(2.5*x + 1.0)*math.cos(1.5*y)
            if kind == 'ridge':
                return -3*amount*abs(x - 0.47*span[0])
            return 0.0

        def shape(x, unit):
            return [s*x[0], s*x[1], s*(x[2] + unit[2]*height(x[0], x[1]))]
        material = self.deck.rigid() if rigid else self.deck.elastic(
            self.of_hardness(10.0**draw.uniform(-1, 1)), draw.uniform(0.0, 0.45))
        body = Body(self.deck, 'base', cells, (0.0, 0.0, -draw.uniform(0.3, 0.8)), (*span, 0.0),
                    material, shape, draw.choice((0.0, 0.2)), draw)
        self.base_body, self.base_rigid = body, rigid
        self.deck.surface('track', body.layer(-1))
        self.held = []
        self.signs['base'] = {}
        if not rigid:
            self.deck.set('ground', body.layer(0))
            self.deck.fix('ground')
            self.held.append(('base', ['ground'], lambda _: (0.0, 0.0, 0.0)))

    def block(self, k):
        """One block above the base, with its path or load, and its pair."""
        draw, s, deck = self.draw, self.scale, self.deck
        size = [draw.uniform(0.5, 1.2), draw.uniform(0.5, 1.2), draw.uniform(0.3, 0.9)]
        cells = (draw.randint(1, 3), draw.randint(1, 3), draw.randint(1, 2))
        angle = draw.choice((0.0, 0.0, draw.uniform(0, 2*math.pi)))
        middle = (1.2 + 1.7*k + draw.uniform(-0.1, 0.1), 1.3 + draw.uniform(-0.1, 0.1))
        bulge = draw.choice((0.0, 0.0, draw.uniform(0.0, 0.05)))
        gap = draw.choice((0.0, 0.0, draw.uniform(0.0, 0.01), -draw.uniform(0.0, 0.003)))
        def shape(x, unit):
            u, v = rotate(x[0], x[1], angle)
            drop = bulge*(1 - unit[2])*((2*unit[0] - 1)**2 + (2*unit[1] - 1)**2)
            return [s*(middle[0] + u), s*(middle[1] + v), s*(1.0 + x[2] + drop)]
        young = self.of_hardness(10.0**draw.uniform(-0.5, 0.5))
        material = deck.elastic(young, draw.uniform(0.0, 0.45))
        name = f'block{k + 1}'
        body = Body(deck, name, cells, (-size[0]/2, -size[1]/2, 0.0),
                    (size[0]/2, size[1]/2, size[2]), material, shape, draw.choice((0.0, 0.2)), draw)
        down = clearance(deck, body, self.base_body) - s*gap
        for x in deck.x[body.first - 1:]:
            x[2] -= down
        body.size, body.middle, body.young = size, middle, young
        deck.surface(name + '_sole', body.layer(0))
        self.signs[name] = {}
        dead = self.chance(0.25)
        self.drive(body, dead, max(gap, 0.0))
        # Under a dead load three nodes must touch: the sole's, for the base may have none below it.
        self.pair(f'pair{k + 1}', (name, name + '_sole', 'base', 'track'), size, not dead)

    def pair(self, label, sides, size, both=True):
        """A pair with a random law; now and then the master is the upper side."""
        draw = self.draw
        upper, upper_surface, lower, lower_surface = sides
        turned = self.chance(0.2) and both
        slave, master = (lower_surface, upper_surface) if turned else (upper_surface, lower_surface)
        k = 10.0**draw.uniform(-1, 3)
        self.stiffest = max(self.stiffest, k)
        if self.chance(0.5):
            penalty = f'AUTO {number(k)}'
        else:
            penalty = f'AREA {number(k*self.young/(0.4*min(size)*self.scale))}'
        kind = draw.choice(('none', 'coulomb', 'coulomb', 'elliptic', 'elliptic'))
        lines = [f'PENAlty {penalty}']
        mu = (0.0, 0.0)
        if kind == 'none':
            lines.append('FRICtion NONE')
        elif kind == 'coulomb':
            mu = (10.0**draw.uniform(-2, 0.2),)*2
            lines.append(f'FRICtion COULomb {number(mu[0])}')
        else:
            mu = (10.0**draw.uniform(-2, 0), 10.0**draw.uniform(-2, 0))
            lines.append(f'FRICtion ELLIptic {number(mu[0])} {number(mu[1])}')
            fixed = draw.choice(('', 'MATErial '))
            lines.append(f'DIREction {fixed}ANGLe {number(draw.uniform(0, 180))} 1 0 0')
            lines.append('SLIP ' + draw.choice(('COLLinear', 'TENSor', 'ASSOciated')))
        self.notes.append(f'{label} {kind} mu {mu[0]:.2g}/{mu[1]:.2g} {penalty.split()[0]} k {k:.2g}'
                          + (' turned' if turned else '') + ' ' + lines[-1].split()[-1][:5])
        self.deck.pair(label, slave, master, lines)
        self.mus[label] = mu
        sign = -1 if turned else 1
        self.signs[upper][label] = sign
        self.signs[lower][label] = -sign

    def drive(self, body, dead, gap):
        """Prescribes the top of a block: presses, slides, turns, tilts, lifts, moves back."""
        draw, deck, s = self.draw, self.deck, self.scale
        depth = (gap + body.size[2]*10.0**draw.uniform(-3, -1.7))*s
        state = [0.0, 0.0, 0.0, 0.0, 0.0]  # x, y, down, turn about z, tilt about y
        way = [list(state)]
        side = min(body.size[:2])
        for word in self.phases:
            if word == 'press':
                state[2] = depth if state[2] <= 0.0 else state[2] + 0.3*depth
            elif word == 'slide':
                far, angle = draw.uniform(0.02, 0.6)*side*s, draw.uniform(0, 2*math.pi)
                state[0] += far*math.cos(angle)
                state[1] += far*math.sin(angle)
            elif word in ('back', 'return'):
                state[0] = state[1] = 0.0
            elif word == 'turn':
                state[3] = max(-MOST_TURN, min(MOST_TURN, state[3] + draw.uniform(-0.5, 0.5)))
            elif word == 'tilt':
                state[4] += draw.uniform(-0.5, 0.5)*depth/(side*s)
            elif word == 'lift':
                state[2] = -2.0*(gap + 0.02)*s
            way.append(list(state))
        top = body.layer(-1)
        name = body.name + '_top'
        deck.set(name, top)
        force = body.young*body.size[0]*body.size[1]*s*depth/body.size[2]
        shares = body.shares(-1)
        deck.fix(top, (1, 1, 0) if dead else (1, 1, 1))
        weight = deck.table([(t, min(w[2], depth)/depth if w[2] > 0 else 0.0)
                             for t, w in zip(self.times, way)]) if dead else 0
        for node in top:
            x = [deck.x[node - 1][m] - s*body.middle[m] for m in range(2)]
            tables = []
            for m in range(3):
                if m == 2 and dead:
                    tables.append(weight)
                    continue
                points = []
                for time, w in zip(self.times, way):
                    turned = rotate(x[0], x[1], w[3])
                    points.append((time, (w[0] + turned[0] - x[0], w[1] + turned[1] - x[1],
                                          w[4]*x[0] - w[2])[m]))
                tables.append(deck.table(points))
            deck.move(node, (1.0, 1.0, 0.0 if dead else 1.0), tables)
            if dead:
                deck.force.append((node, (0.0, 0.0, -force*shares[node])))
        if dead:
            self.notes.append(body.name + ' dead load')
        times = list(self.times)

        def load(time):
            if not dead:
                return (0.0, 0.0, 0.0)
            points = deck.tables[weight - 1]
            value = points[-1][1]
            for (t0, p0), (t1, p1) in zip(points, points[1:]):
                if t0 <= time <= t1:
                    value = p0 + (p1 - p0)*(time - t0)/(t1 - t0)
                    break
            return (0.0, 0.0, -force*value)
        assert times[-1] > 0.0
        self.held.append((body.name, [name], load))

    def upper_block(self):
        """A block on a slab that rests on the base beside the others: the slab is held by contact
        alone, and two pairs act at once."""
        draw, s, deck = self.draw, self.scale, self.deck
        middle = (self.span[0] + 2.0, 1.0)
        self.notes.append('stack')
        slab = deck.elastic(self.young, draw.uniform(0.0, 0.4))
        floor = Body(deck, 'floor', (2, 2, 1), (middle[0] - 1.0, 0.0, -0.3),
                     (middle[0] + 1.0, 2.0, 0.0), deck.rigid(), lambda x, _: [s*v for v in x])
        plate = Body(deck, 'plate', (draw.randint(1, 3), draw.randint(1, 3), 1),
                     (middle[0] - 0.5, 0.5, 0.0), (middle[0] + 0.53, 1.51, 0.3), slab,
                     lambda x, _: [s*v for v in x])
        stamp = Body(deck, 'stamp', (2, 2, 1), (middle[0] - 0.3, 0.7, 0.3),
                     (middle[0] + 0.33, 1.33, 0.8), slab, lambda x, _: [s*v for v in x])
        stamp.size, stamp.middle, stamp.young = [0.63, 0.63, 0.5], (middle[0], 1.0), self.young
        deck.surface('floor_face', floor.layer(-1))
        deck.surface('plate_sole', plate.layer(0))
        deck.surface('plate_face', plate.layer(-1))
        deck.surface('stamp_sole', stamp.layer(0))
        for name in ('floor', 'plate', 'stamp'):
            self.signs[name] = {}
        self.phases = ['press' if word in ('lift', 'return') else word for word in self.phases]
        self.drive(stamp, False, 0.0)
        self.held.append(('plate', [], lambda _: (0.0, 0.0, 0.0)))
        self.pair('lower', ('plate', 'plate_sole', 'floor', 'floor_face'), (0.5, 0.5, 0.3))
        self.pair('upper', ('stamp', 'stamp_sole', 'plate', 'plate_face'), (0.3, 0.3, 0.5))


def random_scene(seed):
    """The scene of a seed."""
    return Maker(seed).scene()


def quadrature_scene(seed):
    """The same scene with GTOS in its pairs, most of them with three points in a facet."""
    scene = Maker(seed).scene()
    scene.name, scene.group = f'gtos {seed}', 'gtos'
    scene.deck.form = 'GTOS'
    scene.deck.points = random.Random(f'points {seed}').choice(('', '', '', '1', '6', '7', '12'))
    scene.notes += ', ' + (scene.deck.points or '3') + ' points'
    return scene


def segmented_scene(seed):
    """The same scene with facets cut with each other."""
    scene = Maker(seed).scene()
    scene.name, scene.group = f'segm {seed}', 'segm'
    scene.deck.form, scene.deck.points = 'GTOS', 'SEGMent'
    return scene


def mortar_scene(seed):
    """The same scene with multipliers at nodes."""
    scene = with_mortar(Maker(seed).scene())
    scene.name, scene.group = f'mortar {seed}', 'mortar'
    return scene
