"""Faces that a TIE joins, or does not; bodies that start inside each other; pairs that never touch."""
import os

import decks
from scene import Place, Solids, chance, table

PULLED = '''MFEC * * two blocks, pulled
MATErial 1
  ELAStic ISOTropic 1000 0.0
MESH 'x_mesh.inp'
{more}
BOUNdary
  foot 1 1 1
  top 1 1 1
DISPlacement
  top {way}
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


def pulled(program, folder, solids, rng, more, far=100.0, turn=True):
    """The run of a scene in any place; the force on its top in the axes of the scene, or None."""
    place = Place(rng if turn else None, far)
    solids.write(os.path.join(folder, 'x_mesh.inp'), place, rng)
    way = ' '.join(f'{v:.17g}' for v in place.turn((0, 0, 0.02)))
    with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
        out.write(PULLED.format(more=more, way=way))
    done = decks.run(program, ['x.inp'], folder, 60)
    return done, place.back(table(folder)[1, 'top']) if done.code == 0 else None


def blocks(low, high, mirrored=False, aside=0.0):
    """Two blocks of 1 x 1 x 1 on each other, of so many cells each way."""
    solids = Solids()
    solids.brick('low', (0, 0, 0), (1, 1, 1), low, (('foot', 2, 0), ('lid', 2, 1)))
    # a mirrored block has its diagonals the other way; right-handed again in the file's reader
    solids.brick('up', (aside, 0, 1), (1 + aside, 1, 2), high, (('top', 2, 2), ('sole', 2, 1)),
                 (lambda p: (1 - p[0], p[1], p[2])) if mirrored else None)
    return solids


def ties(program, report, seeds, first):
    """Equal meshes are joined and carry 10; others are an error, unless a PAIR is between them."""
    for seed in range(first, first + seeds):
        rng = chance(seed, 'ties')
        n = rng.randint(1, 4)
        m = rng.choice([k for k in range(1, 7) if k != n])
        cases = {'equal': (blocks((n, n, 2), (n, n, 1)), 'TIE', True),
                 'named': (blocks((n, n, 2), (n, n, 1)), 'TIE REGIon lid sole', True),
                 'unlike': (blocks((n, n, 2), (m, m, 1)), 'TIE', False),
                 'unlike and named': (blocks((n, n, 2), (m, n, 1)), 'TIE REGIon low up', False),
                 'none alike': (blocks((2, 2, 2), (2, 2, 1), aside=0.3), 'TIE', False)}
        for name, (solids, tie, good) in cases.items():
            with decks.fresh_folder() as folder:
                done, force = pulled(program, folder, solids, chance(seed, name), tie)
            where = f'tie: {name}, {n} and {m} cells, seed {seed}'
            if good:
                report.add(where, [] if force and abs(force[2] - 10) < 1e-6 else
                           [f'force {force}, 10 expected; exit code {done.code} {done.err[-300:]}'])
            else:
                report.add(where, [] if done.code == 1 and 'TIE joins faces' in done.err else
                           [f'exit code {done.code}, force {force}, an error expected'])
        # other diagonals: joined at all nodes, and said
        with decks.fresh_folder() as folder:
            done, force = pulled(program, folder, blocks((n, n, 1), (n, n, 1), True),
                                 chance(seed, 'diagonals'), 'TIE')
        report.add(f'tie: other diagonals, seed {seed}', [] if done.code == 0 else [done.err[-300:]])
        pair = ('SURFace a FROM lid IN low\nSURFace b FROM sole IN up\nCONTact\n  PAIR 1\n'
                '    GTOS b a\nTIE')
        with decks.fresh_folder() as folder:
            done, force = pulled(program, folder, blocks((n, n, 2), (m, m, 1)),
                                 chance(seed, 'pair'), pair, 3.0)
        # it opens: nothing holds, but nothing is wrong
        report.add(f'tie: a pair between, seed {seed}', [] if done.code == 0 else [done.err[-300:]])


INSIDE = '''MFEC * * a punch in a plate
MATErial 1
  ELAStic ISOTropic 1000 0.3
MESH 'x_mesh.inp'
SURFace sp FROM lid IN plate
SURFace sk FROM sole IN punch
CONTact
  PAIR 1
    {form} sk sp
    {search}
BOUNdary
  foot 1 1 1
  top 1 1 1
DISPlacement
  top 0 0 0
OUTPut
  REACtions top
  FIELds NONE
BATCh
  DT,,1
  STEP,,1
END
'''


def starts(program, report, seeds, first):
    """A punch that starts in a plate, or beyond it: it presses, or that is an error."""
    for seed in range(first, first + seeds):
        for depth in (0.05, 0.3, 0.8, 1.1, 2.5):
            rng = chance(seed, 'starts', depth)
            thick = rng.choice((0.5, 1.0, 3.0))
            form = rng.choice(('GTOS', 'NTOS', 'GTOS'))
            solids = Solids()
            solids.brick('plate', (0, 0, -thick), (4, 4, 0), (8, 8, 2), (('foot', 2, -thick), ('lid', 2, 0)))
            solids.brick('punch', (1, 1, -depth), (3, 3, 1 - depth), (2, 2, 1),
                         (('top', 2, 1 - depth), ('sole', 2, -depth)))
            with decks.fresh_folder() as folder:
                solids.write(os.path.join(folder, 'x_mesh.inp'), Place(), rng)
                with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                    out.write(INSIDE.format(form=form, search=''))
                done = decks.run(program, ['x.inp'], folder, 60)
                force = table(folder)[1, 'top'][2] if done.code == 0 else None
            good = (done.code == 1 and 'start behind the master' in done.err or
                    done.code == 2 or force is not None and force < -1)
            report.add(f'starts {depth} deep in a plate of {thick}, {form}, seed {seed}', [] if good
                       else [f'exit code {done.code}, force {force} {done.err[-300:]}'])


def said(program, report):
    """A pair that never touches, and a table that nothing uses, are warned of."""
    with decks.fresh_folder() as folder:
        solids = blocks((1, 1, 1), (1, 1, 1))
        more = ('SURFace a FROM lid IN low\nSURFace b FROM sole IN up\nCONTact\n  PAIR 1 gap\n'
                '    GTOS b a\nPROPortional 2\n  0 0\n  1 1')
        done, _ = pulled(program, folder, solids, chance(0, 'said'),
                         more.replace('DISPlacement', 'x'), 3.0)
        seen = done.out + done.err
    report.add('a pair that never touches', [] if 'pair gap was in contact at no end time' in seen
               else [seen[-500:]])
    # a displacement without a number takes the sum of all tables
    report.add('tables without a number are used', [] if 'used by nothing' not in seen else [seen])
    with decks.fresh_folder() as folder:
        Solids.write(blocks((1, 1, 1), (1, 1, 1)), os.path.join(folder, 'x_mesh.inp'), Place())
        with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
            out.write(PULLED.format(more='TIE\nPROPortional 2\n  0 0\n  1 1', way='0 0 0.02 1'))
        done = decks.run(program, ['x.inp'], folder, 60)
    seen = done.out + done.err
    report.add('a table that nothing uses', [] if 'proportional load 2 is used by nothing' in seen
               else [seen[-500:]])
