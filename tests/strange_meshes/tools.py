"""Tools of triangles in any order of corners: the force is that of the tool in the right order."""
import math
import os

import decks
from scene import Place, Solids, box, chance, sheet, table, turned, write_stl

DECK = '''MFEC * * a block on a tool of triangles
MATErial 1
  ELAStic ISOTropic 1000 0.3
MESH 'tool.stl' AS tool
MESH 'block.inp'
SURFace skin FROM foot IN blk
CONTact
  PAIR 1
    {form} skin tool
    FRICtion COULomb 0.2
BOUNdary
  held 1 1 1
DISPlacement
  held {way}
PROPortional 1
  0 0
  1 1
OUTPut
  REACtions held
  FIELds NONE
BATCh
  DT,,0.5
  STEP,,2
END
'''


def plate(gap):
    """A plate below the block, open."""
    return sheet(lambda s, t: (-1 + 6*s, -1 + 6*t, -gap), 3, 2)


def dome(gap):
    """A cap of a ball below the block, open."""
    def point(s, t):
        x, y = -2 + 4*s, -2 + 4*t
        return x + 2, y + 2, math.sqrt(2500 - x*x - y*y) - 50 - gap
    return sheet(point, 6, 6)


def tray(gap):
    """A tray with a rim about the block, open above."""
    low, high = (-0.5, -0.5, -gap), (4.5, 4.5, 2)
    return turned([f for f in box(low, high) if not all(p[2] == 2 for p in f)])


def pieces(gap):
    """Two plates that do not hang together."""
    return (sheet(lambda s, t: (-1 + 3*s, -1 + 6*t, -gap), 2, 2) +
            sheet(lambda s, t: (2.001 + 3*s, -1 + 6*t, -gap), 2, 2))


def anvil(gap):
    """A closed box below the block."""
    return box((-1, -1, -2 - gap), (5, 5, -gap))


def room(gap):
    """A closed box about the block: a cavity."""
    return turned(box((-0.5, -0.5, -gap), (4.5, 4.5, 5)))


def housing(gap):
    """A thick wall about the block: a box in a box."""
    return room(gap) + box((-1, -1, -1 - gap), (5, 5, 6))


def finned(gap):
    """A plate with a fin below: an edge of three facets."""
    rib = sheet(lambda s, t: (2, -1 + 6*t, -gap - 1 + s), 1, 2)
    return (sheet(lambda s, t: (-1 + 3*s, -1 + 6*t, -gap), 2, 2) +
            sheet(lambda s, t: (2 + 3*s, -1 + 6*t, -gap), 2, 2) + rib)


KINDS = (plate, dome, tray, pieces, anvil, room, housing, finned)


def block(folder, place, rng=None):
    """The block, its foot at height 0."""
    solids = Solids()
    solids.brick('blk', (0, 0, 0), (4, 4, 3), (3, 3, 3),
                 (('held', 2, 3), ('foot', 2, 0)))
    solids.write(os.path.join(folder, 'block.inp'), place, rng)


def force(program, folder, kind, gap, place, form, rng, share, whole):
    """Force on the held face in the axes of the block, or what went wrong."""
    block(folder, place, rng)
    triangles = kind(gap)
    write_stl(os.path.join(folder, 'tool.stl'), turned(triangles) if whole else triangles, place, rng,
              share)
    way = ' '.join(f'{v:.17g}' for v in place.turn((0, 0, -0.04 - gap)))
    with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
        out.write(DECK.format(form=form, way=way))
    done = decks.run(program, ['x.inp', '--quiet'], folder, 120)
    if done.code != 0 or done.crash():
        return f'exit code {done.code} {done.crash()} {done.err[-300:]}'
    return place.back(table(folder)[2, 'held'])


def scenes(program, report, seeds, first):
    """Each kind of tool, some facets or all of them turned, anywhere in space."""
    for seed in range(first, first + seeds):
        for kind in KINDS:
            rng = chance(seed, kind.__name__)
            gap = rng.choice((0.0, 0.0, 0.01, 0.5, -0.02))
            form = rng.choice(('GTOS', 'NTOS'))
            with decks.fresh_folder() as folder:
                right = force(program, folder, kind, gap, Place(), form, None, 0, False)
            place = Place(rng, 10**rng.uniform(0, 3)*4)
            share, whole = rng.choice(((0.0, True), (0.1, False), (0.5, False), (0.9, True)))
            with decks.fresh_folder() as folder:
                found = force(program, folder, kind, gap, place, form, rng, share, whole)
            name = f'{kind.__name__}, gap {gap}, {form}, seed {seed}'
            # nothing tells the sides of the fin, for the slave is before both
            if kind is finned and 'look to different sides' in found:
                report.add(name, [])
                continue
            if isinstance(right, str) or isinstance(found, str):
                report.add(name, [f'right: {right}', f'turned: {found}'])
                continue
            # 1e-6: nodes and triangles in another order, and other axes, solve in another order
            off = max(abs(a - b) for a, b in zip(right, found)) / max(abs(right[2]), 1e-300)
            report.add(name, [] if off < 1e-6 and right[2] < -1 else
                       [f'force {found}, in the right order {right}'])


def ribbon():
    """Moebius' strip below the block."""
    def point(s, t):
        a, w = 2*math.pi*s, t - 0.5
        r = 3 + w*math.cos(a/2)
        return r*math.cos(a), r*math.sin(a), -2 + w*math.sin(a/2)
    n = 12
    p = [[point(i/n, j) for j in (0, 1)] for i in range(n)]
    p.append(p[0][::-1])
    out = []
    for i in range(n):
        (a, d), (b, c) = p[i], p[i + 1]
        out += [(a, b, c), (a, c, d)]
    return out


BOTH = '''
SURFace lid FROM under IN low
'''


def refused(program, report):
    """What has no outside is refused, and the facets are named."""
    cases = {'a ribbon': (ribbon(), 'has one side only'),
             'slaves on both sides': (plate(0), 'look at both of its sides'),
             'slaves inside and outside': (anvil(0), 'slaves inside and outside')}
    for name, (triangles, words) in cases.items():
        with decks.fresh_folder() as folder:
            place = Place()
            solids = Solids()
            solids.brick('blk', (0, 0, 0), (4, 4, 3), (2, 2, 2), (('held', 2, 3), ('foot', 2, 0)))
            solids.brick('low', (1, 1, -1), (3, 3, 0), (2, 2, 2), (('held', 2, -1), ('under', 2, 0)))
            solids.write(os.path.join(folder, 'block.inp'), place)
            write_stl(os.path.join(folder, 'tool.stl'), triangles, place)
            text = DECK.format(form='GTOS', way='0 0 -0.01')
            text = text.replace('CONTact', BOTH + 'CONTact\n  PAIR 2\n    GTOS lid tool')
            with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                out.write(text)
            done = decks.run(program, ['x.inp', '--quiet'], folder, 60)
        good = done.code == 1 and words in done.err and 'facet' in done.err
        report.add('refused: ' + name, [] if good else [f'exit code {done.code}: {done.err}'])
