"""Rigid bodies with a point whose motions are free, drawn from seeds: pressed by forces, turned by
moments, by way and by force at once, several of them, with an elastic body between two.

A scene stands anywhere in space, turned by any rotation, in any unit.
"""
import math
import random

# Rubber under a pressure that follows its faces: its flank held, or held by contact alone.
FOLLOWED = ('flank held', 'loose', 'loose, squeezed')
KINDS = ('force', 'moment', 'mixed', 'two', 'between', 'tilted')
FORMS = ('NTOS {} {}', 'GTOS {} {}', 'GTOS {} {} SEGMent')


def turned(draw):
    """A rotation and a shift, as a function of a place."""
    a, b, c = (draw.uniform(0.0, 2.0*math.pi) for _ in range(3))
    rows = [[math.cos(a)*math.cos(b), math.cos(a)*math.sin(b)*math.sin(c) - math.sin(a)*math.cos(c),
             math.cos(a)*math.sin(b)*math.cos(c) + math.sin(a)*math.sin(c)],
            [math.sin(a)*math.cos(b), math.sin(a)*math.sin(b)*math.sin(c) + math.cos(a)*math.cos(c),
             math.sin(a)*math.sin(b)*math.cos(c) - math.cos(a)*math.sin(c)],
            [-math.sin(b), math.cos(b)*math.sin(c), math.cos(b)*math.cos(c)]]
    if draw.random() < 0.4:
        rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    return lambda v: [sum(row[k]*v[k] for k in range(3)) for row in rows]


class Pointed:
    """Collects the blocks, rigid bodies and pairs of one deck."""

    def __init__(self, seed):
        self.draw = random.Random(f'pointed {seed}')
        self.kind = KINDS[seed % len(KINDS)]
        self.way = turned(self.draw)
        self.shift = [self.draw.choice((0.0, 0.0, self.draw.uniform(-30.0, 30.0)))
                      for _ in range(3)]
        self.young = 10.0**self.draw.uniform(2, 5)
        self.mu = self.draw.choice((0.2, 0.4, 0.6))
        self.form = self.draw.choice(FORMS)
        self.materials, self.blocks, self.sets, self.rigid, self.pairs = [], [], [], [], []
        self.nodes = 0

    def place(self, v):
        """Where a place of the scene's own axes is."""
        return ' '.join(f'{p + s!r}' for p, s in zip(self.way(v), self.shift))

    def vector(self, v):
        """A vector of these axes."""
        return ' '.join(repr(p) for p in self.way(v))

    def box(self, name, low, size, cells, elastic, tilt=0.0, cell='TET4'):
        """A box, tilted about y through the middle of its sole, and the surfaces of its ends: nodes are
        numbered layer by layer."""
        self.materials.append((name, elastic))
        middle = [low[0] + 0.5*size[0], low[1] + 0.5*size[1], low[2]]
        ends = []
        for k in (0, 1):
            for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)):
                v = [low[0] + i*size[0] - middle[0], low[1] + j*size[1] - middle[1], k*size[2]]
                c, s = math.cos(tilt), math.sin(tilt)
                ends.append(self.place([middle[0] + c*v[0] + s*v[2], middle[1] + v[1],
                                        middle[2] - s*v[0] + c*v[2]]))
        rows = '\n'.join(f'  {n} {v}' for n, v in enumerate(ends, 1))
        self.blocks.append(f'BLOCk {name}\n  CART {cells[0]} {cells[1]} {cells[2]}  '
                           f'MATErial {len(self.materials)}  {cell}\n{rows}\n')
        fine = 2 if cell == 'TET10' else 1
        layer, layers = (fine*cells[0] + 1)*(fine*cells[1] + 1), fine*cells[2] + 1
        for part, first in (('low', self.nodes + 1), ('top', self.nodes + layer*(layers - 1) + 1)):
            nodes = ' '.join(map(str, range(first, first + layer)))
            self.sets.append(f'SET {name}_{part}_nodes\n  NODEs {nodes}\n\n'
                             f'SURFace {name}_{part} FROM {name}_{part}_nodes IN {name}\n')
        self.nodes += layer*layers

    def body(self, name, records, point):
        """A rigid body's data set."""
        self.rigid.append(f'RIGId {name}\n  POINt {self.place(point)}\n' + records)

    def pair(self, slave, master, friction=True):
        """One pair; the rigid side is the slave as often as not."""
        law = f'COULomb {self.mu!r}' if friction else 'NONE'
        self.pairs.append(f'  PAIR {len(self.pairs) + 1} p{len(self.pairs) + 1}\n    '
                          + self.form.format(slave, master)
                          + f'\n    PENAlty AUTO\n    FRICtion {law}\n')

    def text(self, steps, end=2):
        """The deck, in so many increments for each unit of time."""
        out = ['MFEC * * Rigid bodies that are free to move\n']
        for n, (name, elastic) in enumerate(self.materials, 1):
            out.append(f'MATErial {n} {name}\n' + (
                f'  SOLId LINEar\n  ELAStic ISOTropic {self.young!r} 0.3\n' if elastic else '  RIGId\n'))
        out += self.blocks + self.sets
        out.append('BOUNdary\n  base_low_nodes 1 1 1\n')
        out += self.rigid
        out.append('PROPortional 1\n  0 0\n  1 1\n  2 1\n\nPROPortional 2\n  0 0\n  1 0\n  2 1\n')
        out.append('CONTact\n' + '\n'.join(self.pairs))
        out.append('OUTPut\n  REACtions base_low_nodes\n  FIELds displacement contact\n  STATe ALL\n')
        out.append(f'END\nBATCh\n  DT,,1/{steps}\n  STEP,,{end*steps}\nEND\nSTOP\n')
        return '\n'.join(out)


def pointed_scene(seed):
    """Its name and deck."""
    s = Pointed(seed)
    draw = s.draw
    n = draw.choice((3, 4, 5))
    s.box('base', [0.0, 0.0, -0.5], [1.6, 1.3, 0.5], (n + 1, n, 2), True)
    force = s.young*10.0**draw.uniform(-4, -3)
    push = draw.uniform(0.2, 0.9)*s.mu*force
    angle = draw.uniform(0.0, 2.0*math.pi)
    side = [push*math.cos(angle), push*math.sin(angle), 0.0]
    still = '  TURN ' + s.vector([0.0, 0.0, 1.0]) + ' 0\n'
    down = s.vector([0.0, 0.0, -force])
    gap = draw.choice((0.0, 0.0, 0.01))
    middle = [0.8, 0.65, 0.2]
    spin = draw.uniform(0.02, 0.1)*s.mu*force

    def load(forces, moment, number):
        return f'  LOAD {s.vector(forces)}  {s.vector(moment)}  {number}\n'

    zero = [0.0, 0.0, 0.0]
    tilt = draw.uniform(0.01, 0.1) if s.kind == 'tilted' else 0.0
    if s.kind == 'two':
        for name, x in (('left', 0.15), ('right', 0.9)):
            s.box(name, [x, 0.35, gap], [0.55, 0.6, 0.3], (2, 2, 1), False)
            s.body(name, load([0.0, 0.0, -force], zero, 1)
                   + load([0.5*v for v in side], [0.0, 0.0, spin], 2), [x + 0.27, 0.65, 0.1])
            s.pair(*draw.sample([name + '_low', 'base_top'], 2))
        return f'pointed {seed}: {s.kind}', s.text(3)
    if s.kind == 'between':
        s.box('pad', [0.3, 0.25, 0.0], [0.9, 0.8, 0.3], (3, 3, 2), True)
        s.box('tool', [0.2, 0.15, 0.3], [1.1, 1.0, 0.2], (4, 4, 1), False)
        s.body('tool', load([0.0, 0.0, -force], zero, 1) + load([0.4*v for v in side], zero, 2),
               [0.75, 0.65, 0.35])
        s.pair(*draw.sample(['pad_low', 'base_top'], 2))
        s.pair(*draw.sample(['tool_low', 'pad_top'], 2))
        return f'pointed {seed}: {s.kind}', s.text(3)
    s.box('tool', [0.4, 0.3, gap], [0.8, 0.7, 0.3], (2, 3, 1), False, tilt)
    if s.kind == 'force':
        s.body('tool', still + load([0.0, 0.0, -force], zero, 1) + load(side, zero, 2), middle)
    elif s.kind == 'moment':
        deep = s.vector([0.0, 0.0, -gap - draw.uniform(0.001, 0.004)])
        s.body('tool', f'  MOVE {deep} 1\n' + load(zero, [spin, 0.5*spin, spin], 2), middle)
    elif s.kind == 'tilted':
        s.body('tool', load([0.0, 0.0, -force], zero, 1), middle)
    else:
        s.body('tool', load([0.0, 0.0, -force], zero, 1) + load(side, [0.0, 0.0, spin], 2), middle)
    tool = ['tool_low', 'base_top']
    s.pair(*(draw.sample(tool, 2) if s.form.startswith('NTOS') is False else tool[::-1]))
    return f'pointed {seed}: {s.kind}', s.text(3)


def followed_scene(seed):
    """A block of finite strain on a rigid floor under pressures that follow; its name and deck."""
    s = Pointed(1000 + seed)
    draw = s.draw
    kind = FOLLOWED[seed % len(FOLLOWED)]
    cell = draw.choice(('TET4', 'TET10'))
    n = draw.choice((2, 3)) if cell == 'TET10' else draw.choice((3, 4))
    s.box('base', [-0.5, -0.5, -0.2], [2.2, 2.0, 0.2], (6, 5, 1), False)
    # a held flank that touches to round-off has friction where round-off says
    gap = draw.choice((0.0, 0.0, 0.02)) if kind != 'flank held' else 0.01
    s.box('rubber', [0.0, 0.0, gap], [1.0, 1.0, draw.uniform(0.5, 0.9)], (n, n, n), True,
          cell=cell)
    first = 84 + 1
    if cell == 'TET10':
        n, s.form = 2*n, s.form.replace('NTOS', 'GTOS')
    grid = [[(first + i + (n + 1)*(j + (n + 1)*k), (i, j, k)) for i in range(n + 1)]
            for k in range(n + 1) for j in range(n + 1)]
    nodes = [node for row in grid for node in row]
    for name, axis, end in (('left', 0, 0), ('right', 0, n), ('near', 1, 0), ('far', 1, n)):
        members = ' '.join(str(node) for node, at in nodes if at[axis] == end)
        s.sets.append(f'SET {name}_nodes\n  NODEs {members}\n\n'
                      f'SURFace {name} FROM {name}_nodes IN rubber\n')
    press = s.young*draw.uniform(0.02, 0.12)
    pressures = [f'  rubber_top {press!r} 1']
    if kind == 'loose, squeezed':
        side = press*draw.uniform(0.3, 0.9)
        pressures += [f'  {name} {side!r} 2' for name in ('left', 'right', 'near', 'far')]
    elif kind == 'flank held':
        pressures.append(f'  right {press*draw.uniform(-0.5, 0.5)!r} 2')
    s.pair('rubber_low', 'base_top')
    # at rest points neither stick nor slip
    text = s.text(draw.choice((2, 4)), 1 if kind == 'loose' else 2).replace('SOLId LINEar', 'SOLId NEOHookean')
    held = 'BOUNdary\n  base 1 1 1\n' + ('  left_nodes 1 1 1\n' if kind == 'flank held' else '')
    text = text.replace('BOUNdary\n  base_low_nodes 1 1 1\n', held + '\nPRESsure\n'
                        + '\n'.join(pressures) + '\n')
    return f'followed {seed}: {kind}', text
