"""Coordinates of few digits: a plane, a box, a TIE finds all of its nodes, or says which it leaves."""
import math
import os
import struct

import decks
from scene import Place, Solids, chance, table

DECK = '''MFEC * * rounded coordinates
MATErial 1
  ELAStic ISOTropic 1000 0.0
{mesh}
{sets}
DISPlacement
  top 0 0 -0.1
PROPortional 1
  0 0
  1 1
OUTPut
  REACtions top
  FIELds NONE
BATCh
  DT,,1
  STEP,,1
END
'''


def single(v):
    """A number in single precision."""
    return struct.unpack('f', struct.pack('f', v))[0]


def shaken(point, axis, angle, shift):
    """A point that has been turned to and fro in single precision, and shifted."""
    p = list(point)
    for a in (angle, -angle):
        c, s = single(math.cos(a)), single(math.sin(a))
        u, v = (axis + 1) % 3, (axis + 2) % 3
        p[u], p[v] = single(c*p[u] - s*p[v]), single(s*p[u] + c*p[v])
    return tuple(single(x + d) for x, d in zip(p, shift))


def solids_of(rng, shift, halves):
    """A cube of 10, or its halves, the nodes off by round-off of single precision."""
    solids = Solids()
    axis, angle = rng.randrange(3), rng.uniform(-3, 3)
    for name, low, high in ([('a', 0, 5), ('b', 5, 10)] if halves else [('a', 0, 10)]):
        solids.brick(name, (0, 0, low), (10, 10, high), (4, 4, 2 if halves else 4), (),
                     lambda p: shaken(p, axis, angle, shift))
    return solids


def feap(solids, path, digits):
    """The same as records of a deck."""
    with open(path, 'w', encoding='ascii') as out:
        out.write('COORdinates\n')
        for n, x in enumerate(solids.nodes, 1):
            out.write(f'{n} 0 ' + ' '.join(f'{v:.{digits}g}' for v in x) + '\n')
        out.write('\nELEMents\n')
        for e, nodes in enumerate(solids.cells, 1):
            out.write(f'{e} 0 1 ' + ' '.join(str(n + 1) for n in nodes) + '\n')
        out.write('\n')


def sets_of(kind, z):
    """What holds the foot and takes the top, at heights z and z + 10."""
    if kind == 'plane':
        bottom, top = f'  PLANe 3 {z!r}', f'  PLANe 3 {z + 10!r}'
    else:
        bottom = f'  BOX -1e9 1e9 -1e9 1e9 {z - 1!r} {z!r}'
        top = f'  BOX -1e9 1e9 -1e9 1e9 {z + 10!r} {z + 11!r}'
    held = f'EBOUndary\n  3 {z!r} 1 1 1\n' if kind == 'edge' else ''
    return (f'SET bottom\n{bottom}\nSET top\n{top}\n' + held +
            'BOUNdary\n  top 1 1 1\n' + ('' if held else '  bottom 1 1 1\n'))


def scenes(program, report, seeds, first):
    """Force on a cube that is pressed by 1 %: -1000, whatever the digits of its mesh."""
    for seed in range(first, first + seeds):
        for kind in ('plane', 'box', 'edge', 'tied', 'records'):
            for digits in (4, 5, 6, 7, 8, 9, 12):
                rng = chance(seed, kind, digits)
                # numbers of few digits tell no shape far from the origin
                far = 10.0**rng.uniform(0, min(4, max(0, digits - 4)))
                shift = [float(round(rng.uniform(-far, far))) for _ in range(3)]
                with decks.fresh_folder() as folder:
                    solids = solids_of(rng, shift, kind == 'tied')
                    mesh = 'MESH x_mesh.inp' + ('\nTIE' if kind == 'tied' else '')
                    if kind == 'records':
                        feap(solids, os.path.join(folder, 'records'), digits)
                        mesh = 'INCLude records'
                    else:
                        solids.write(os.path.join(folder, 'x_mesh.inp'), Place(), rng, digits)
                    sets = sets_of('plane' if kind in ('tied', 'records') else kind, shift[2])
                    with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                        out.write(DECK.format(mesh=mesh, sets=sets))
                    done = decks.run(program, ['x.inp', '--quiet'], folder, 60)
                    name = f'digits: {kind}, {digits}, shift {shift}, seed {seed}'
                    if done.code != 0 or done.crash():
                        report.add(name, [f'exit code {done.code}: {done.err[-300:]}'])
                        continue
                    found = table(folder)[1, 'top'][2]
                # the shape itself is off by half a unit of the digits: area, height and what is
                # pressed already when the top takes up its places
                size = max(10.0, max(map(abs, shift)) + 10)
                off = 20*10.0**(math.floor(math.log10(size)) + 1 - digits)/10 + 1e-5
                report.add(name, [] if abs(found + 1000) <= 1000*off else
                           [f'force {found}, -1000 to {off:.1e} expected'])


def warned(program, report):
    """Nodes that lie beside a plane by more than their digits tell are named; other bodies not."""
    for name, off, gap, words in (('beside', 1e-4, None, 'leaves out 4 nodes'),
                                  ('far', 0.2, None, ''), ('a body behind a gap', 0, 0.001, '')):
        with decks.fresh_folder() as folder:
            solids = Solids()
            solids.brick('a', (0, 0, 0), (1, 1, 1), (3, 3, 3))
            for n in range(len(solids.nodes) - 4, len(solids.nodes)):
                x = solids.nodes[n]
                solids.nodes[n] = (x[0], x[1], x[2] - off)
            if gap:
                solids.brick('b', (0, 0, 1 + gap), (1, 1, 2 + gap), (4, 4, 4))
            solids.write(os.path.join(folder, 'x_mesh.inp'), Place())
            cap = f'SET cap\n  PLANe 3 {2 + gap!r}\n' if gap else ''
            held = '  cap 1 1 1\n' if gap else ''
            text = DECK.format(mesh='MESH x_mesh.inp', sets=cap + 'SET top\n  PLANe 3 1\nSET bottom\n'
                               '  PLANe 3 0\nBOUNdary\n  top 1 1 1\n  bottom 1 1 1\n' + held)
            with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                out.write(text)
            done = decks.run(program, ['x.inp', '--check'], folder, 60)
        seen = done.out + done.err
        good = words in seen if words else 'leaves out' not in seen
        report.add('digits: warned of nodes ' + name, [] if good and done.code == 0 else [seen[-600:]])
