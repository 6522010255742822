"""Exactly touching scenes drawn from seeds, and copies of them that are the same problem: turned,
shifted, with other numbers of bodies and nodes (numpy)."""
import math
import random

import numpy as np

# Corners of a cell (bits of x, y, z) and its six tetrahedra, as BLOCk cuts it.
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
CUT = ((1, 2, 3, 7), (1, 3, 4, 7), (1, 4, 8, 7), (1, 8, 5, 7), (1, 5, 6, 7), (1, 6, 2, 7))
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
FORMS = ('NTOS', 'GTOS', 'SEGMent')


class Body:
    """A box of tetrahedra: points (n, 3), elements, and its places in units of half cells."""

    def __init__(self, name, low, high, cells, young, quadratic):
        self.name, self.young, self.quadratic = name, young, quadratic
        self.low, self.high = np.array(low, float), np.array(high, float)
        self.cells = np.array(cells)
        places, self.elements = {}, []
        for k in range(cells[2]):
            for j in range(cells[1]):
                for i in range(cells[0]):
                    at = [tuple(2*np.add((i, j, k), c)) for c in CORNERS]
                    for cut in CUT:
                        four = [at[c - 1] for c in cut]
                        if quadratic:
                            four += [tuple(np.add(four[a], four[b])//2) for a, b in EDGES]
                        self.elements.append([places.setdefault(p, len(places)) for p in four])
        self.places = np.array(sorted(places, key=places.get))
        share = self.places/(2.0*self.cells)
        self.points = self.low*(1.0 - share) + self.high*share

    def face(self, axis, end):
        """Nodes of a face; end: 0 or 1."""
        return np.flatnonzero(self.places[:, axis] == 2*self.cells[axis]*end)


class Scene:
    """What a seed draws."""

    def __init__(self, seed, kinds=('blocks', 'plate', 'stack', 'corner'), form=None):
        draw = random.Random(f'touching {seed}')
        self.seed, self.kind = seed, draw.choice(kinds)
        self.size = 10.0**draw.choice((0, 0, 0, -2, 2))
        self.young = 10.0**draw.choice((3, 3, 5))
        self.quadratic = draw.random() < 0.35
        drawn = draw.choice(FORMS[1:] if self.quadratic else FORMS)
        self.form = form or drawn
        self.points = draw.choice(('', '', '7'))
        self.mu = (draw.uniform(0.1, 0.6),)*2
        if draw.random() < 0.5:
            self.mu = (draw.uniform(0.1, 0.6), draw.uniform(0.05, 0.6))
        self.penalty = draw.choice((1, 10, 10, 50))
        self.angle = draw.uniform(0.0, 180.0)
        self.slip = draw.choice(('COLLinear', 'TENSor', 'ASSOciated'))
        self.counts = [draw.randint(1, 3) for _ in range(3)]
        self.way = [draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3)]
        self.pressed = draw.random() < 0.5
        self.bodies, self.pairs, self.held, self.moved = [], [], [], None
        self.lay = [0.0, 1.0, 0.0] if self.kind == 'corner' else [1.0, 0.0, 0.0]
        further = random.Random(f'further {seed}')
        self.strain = further.choice(('LINEar', 'LINEar', 'LINEar', 'NEOHookean'))
        self.words = further.choice(('', '', '', 'AUGMent', 'SMOOth'))
        if (self.quadratic and self.words == 'SMOOth') or self.form == 'MORTar':
            self.words = ''
        getattr(self, self.kind)(draw)

    def cells(self, draw, matching=None):
        """Cells of a body along its edges."""
        most = 2 if self.quadratic else 4
        return matching or [draw.randint(1, most), draw.randint(1, most), draw.randint(1, 2)]

    def add(self, draw, name, low, high, matching=None, stiffer=1.0):
        """One more body."""
        self.bodies.append(Body(name, np.array(low)*self.size, np.array(high)*self.size,
                                self.cells(draw, matching), self.young*stiffer, self.quadratic))
        return self.bodies[-1]

    def pair(self, slave, master, draw):
        """A pair of two faces that touch; with NTOS nodes of the first, which is not larger, are
        the slave, else either: ((body, axis, end), the other)."""
        swap = draw.random() < 0.5 and self.form != 'NTOS'
        self.pairs.append((master, slave) if swap else (slave, master))

    def blocks(self, draw):
        """A block on another one: as large, or smaller, or hanging over."""
        cells = self.cells(draw)
        self.add(draw, 'lo', (-.5, -.5, -.6), (.5, .5, 0), cells)
        a, b = draw.choice((((-.5, -.5), (.5, .5)), ((-.3, -.35), (.3, .25)), ((-.2, -.3), (.7, .3))))
        same = cells if draw.random() < 0.4 else None
        self.add(draw, 'hi', (*a, 0), (*b, .5), same, draw.choice((1, 1, 10)))
        self.pair(('hi', 2, 0), ('lo', 2, 1), draw)
        self.held, self.moved = [('lo', 2, 0)], ('hi', 2, 1)

    def plate(self, draw):
        """A plate between two blocks, held at one end."""
        t = draw.choice((.03, .1, .2))
        self.add(draw, 'lo', (-.5, -.5, -.5), (.5, .5, 0))
        self.add(draw, 'pl', (-.9, -.6, 0), (.9, .6, t), [draw.randint(2, 5 if not self.quadratic else 3),
                                                      draw.randint(1, 3), 1], draw.choice((1, 100)))
        self.add(draw, 'hi', (-.5, -.5, t), (.5, .5, t + .5))
        self.pair(('lo', 2, 1), ('pl', 2, 0), draw)
        self.pair(('hi', 2, 0), ('pl', 2, 1), draw)
        self.held, self.moved = [('lo', 2, 0), ('pl', 0, 1)], ('hi', 2, 1)

    def stack(self, draw):
        """A body that contact alone holds between two others."""
        self.add(draw, 'lo', (-.5, -.5, -.5), (.5, .5, 0))
        self.add(draw, 'mid', (-.4, -.5, 0), (.4, .5, .4))
        self.add(draw, 'hi', (-.5, -.5, .4), (.5, .5, .8))
        self.pair(('mid', 2, 0), ('lo', 2, 1), draw)
        self.pair(('mid', 2, 1), ('hi', 2, 0), draw)
        self.held, self.moved = [('lo', 2, 0)], ('hi', 2, 1)

    def corner(self, draw):
        """A block on a floor and against a wall."""
        self.add(draw, 'lo', (-.5, -.5, -.5), (.5, .5, 0))
        self.add(draw, 'wall', (.3, -.5, 0), (.8, .5, .8))
        self.add(draw, 'hi', (-.4, -.5, 0), (.3, .5, .6))
        self.pair(('hi', 2, 0), ('lo', 2, 1), draw)
        self.pair(('hi', 0, 1), ('wall', 0, 0), draw)
        self.held, self.moved = [('lo', 2, 0), ('wall', 0, 1)], ('hi', 2, 1)

    def describe(self):
        """A few words."""
        return (f'{self.seed} {self.kind} {self.form} {"T10" if self.quadratic else "T4"} '
                f'{self.strain} {self.words} mu {self.mu[0]:.2f} {self.mu[1]:.2f} counts {self.counts}')


class Copy:
    """How a scene is written: turn (3, 3), shift, order of bodies, a seed that shuffles nodes."""

    def __init__(self, name, turn=None, shift=(0.0, 0.0, 0.0), order=None, shuffle=None):
        self.name = name
        self.turn = np.eye(3) if turn is None else turn
        self.shift = np.array(shift)
        self.order, self.shuffle = order, shuffle


def rotation(axis, degrees):
    """The matrix of a turn about an axis."""
    a = np.array(axis, float)/np.linalg.norm(axis)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    phi = math.radians(degrees)
    return np.eye(3) + math.sin(phi)*k + (1.0 - math.cos(phi))*(k @ k)


def copies(scene):
    """The copies that are compared with the scene itself."""
    draw = random.Random(f'copies {scene.seed}')
    axis = [draw.gauss(0, 1) for _ in range(3)]
    count = len(scene.bodies)
    yield Copy('turned 1', rotation((0, 1, 0), 1.0))
    yield Copy('turned', rotation(axis, draw.uniform(5, 175)))
    yield Copy('shifted 3', shift=[3.7*scene.size*draw.uniform(-1, 1) for _ in range(3)])
    yield Copy('shifted 1000', shift=[1000.3*scene.size*draw.choice((-1, 1)) for _ in range(3)])
    yield Copy('bodies', order=list(range(count))[::-1])
    yield Copy('nodes', shuffle=draw.randint(1, 10**6))
    yield Copy('all', rotation(axis, draw.uniform(5, 175)),
               [3.7*scene.size*draw.uniform(-1, 1) for _ in range(3)], list(range(count))[::-1],
               draw.randint(1, 10**6))


def listed(items, width=12):
    """Numbers in records of NODEs."""
    items = sorted(items)
    rows = [items[i:i + width] for i in range(0, len(items), width)]
    return '\n'.join(('  OR NODEs ' if i else '  NODEs ') + ' '.join(map(str, row))
                     for i, row in enumerate(rows))


def vector(v):
    """Three numbers with all digits."""
    return ' '.join(repr(float(c)) for c in v)


def text_of(scene, copy):
    """The deck of a copy."""
    order = copy.order or list(range(len(scene.bodies)))
    total = sum(len(b.points) for b in scene.bodies)
    numbers = list(range(1, total + 1))
    if copy.shuffle:
        random.Random(copy.shuffle).shuffle(numbers)
    first, own = 0, {}
    for k in order:
        own[scene.bodies[k].name] = np.array(numbers[first:first + len(scene.bodies[k].points)])
        first += len(scene.bodies[k].points)
    out = [f'MFEC * * {scene.describe()} {copy.name}\n']
    rows, e = [], 0
    for k in order:
        body = scene.bodies[k]
        x = body.points @ copy.turn.T + copy.shift
        rows += [(n, p) for n, p in zip(own[body.name], x)]
        out.append(f'MATErial {k + 1} {body.name}m\n  SOLId {scene.strain}\n  ELAStic ISOTropic {body.young!r} '
                   '0.3\n')
    out.append('COORdinates\n' + '\n'.join(f'  {n} 0 {vector(p)}' for n, p in sorted(
        rows, key=lambda r: r[0])) + '\n')
    out.append('ELEMents')
    for k in order:
        body = scene.bodies[k]
        for nodes in body.elements:
            e += 1
            out.append(f'  {e} 0 {k + 1} ' + ' '.join(str(own[body.name][n]) for n in nodes))
    out.append('')
    faces = [f for p in scene.pairs for f in p] + scene.held + [scene.moved]
    bodies = {b.name: b for b in scene.bodies}
    for name, axis, end in faces:
        out.append(f'SET {name}{axis}{end}\n'
                   + listed(own[name][bodies[name].face(axis, end)]) + '\n')
    for pair in scene.pairs:
        for name, axis, end in pair:
            out.append(f'SURFace s{name}{axis}{end} FROM {name}{axis}{end}\n')
    held = ['{}{}{}'.format(*f) for f in scene.held]
    moved = '{}{}{}'.format(*scene.moved)
    out.append('BOUNdary\n' + ''.join(f'  {name} 1 1 1\n' for name in held + [moved]))
    down = np.array([0, 0, -0.01*scene.size])
    along = 0.05*scene.size*np.array([*scene.way, 0.0])
    out.append(f'DISPlacement\n  {moved} {vector(copy.turn @ down)} 1\n'
               f'  {moved} {vector(copy.turn @ along)} 2\n')
    out.append('PROPortional 1\n  0 0\n  1 1\n')
    out.append('PROPortional 2\n  0 0\n  1 0\n  2 1\n  3 -0.5\n')
    out.append('CONTact')
    for k, (slave, master) in enumerate(scene.pairs, 1):
        form = 'GTOS' if scene.form == 'SEGMent' else scene.form
        points = 'SEGMent' if scene.form == 'SEGMent' else scene.points if form == 'GTOS' else ''
        penalty = '' if form == 'MORTar' else f'\n    PENAlty AUTO {scene.penalty}'
        mu = (f'COULomb {scene.mu[0]!r}' if scene.mu[0] == scene.mu[1] else
              f'ELLIptic {scene.mu[0]!r} {scene.mu[1]!r}')
        out.append(f'  PAIR {k}\n    {form} s{slave[0]}{slave[1]}{slave[2]} '
                   f's{master[0]}{master[1]}{master[2]} {points}{penalty}\n'
                   f'    FRICtion {mu}\n    DIREction ANGLe {scene.angle!r} '
                   f'{vector(copy.turn @ np.array(scene.lay))}\n    SLIP {scene.slip}' + (f'\n    {scene.words}' if scene.words else ''))
    out.append('\nOUTPut\n  REACtions ' + ' '.join(held + [moved]) + '\n  FIELds NONE\n  STATe NONE\n\nEND\nBATCh')
    for count in scene.counts:
        out.append(f'  DT,,{1.0/count!r}\n  STEP,,{count}')
    out.append('END\nSTOP\n')
    return '\n'.join(out)
