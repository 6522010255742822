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
    report.add('a pair that never touches', [] if 'pair gap was in contact at no output time' in seen
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


def cracked(n, front, shared):
    """A bar of 4 x 1 x 2 with a joint at half its height that is bonded up to the front; its nodes
    there are shared, or two at a place."""
    solids = Solids()
    solids.brick('low', (0, 0, 0), (4, 1, 1), (4*n, n, n), (('foot', 2, 0), ('lid', 2, 1)))
    solids.brick('up', (0, 0, 1), (4, 1, 2), (4*n, n, n), (('top', 2, 2), ('sole', 2, 1)))
    beyond = [m for m in solids.sets['lid'] if solids.nodes[m][0] > front - 1e-9]
    solids.sets['lid_open'] = beyond
    within = {solids.nodes[m]: m for m in solids.sets['lid'] if solids.nodes[m][0] < front + 1e-9}
    same = {}
    for m in solids.sets['sole']:
        if shared and solids.nodes[m] in within:
            same[m] = within[solids.nodes[m]]
    solids.cells = [[same.get(m, m) for m in cell] for cell in solids.cells]
    solids.sets['sole'] = [same.get(m, m) for m in solids.sets['sole']]
    solids.sets['sole_open'] = [m for m in solids.sets['sole'] if solids.nodes[m][0] > front - 1e-9]
    solids.sets['sole_bond'] = [m for m in solids.sets['sole'] if solids.nodes[m][0] < front + 1e-9]
    solids.sets['lid_bond'] = list(within.values())
    return solids


CRACK = '''MFEC * * a bar with a joint that is bonded in part
MATErial 1
  ELAStic ISOTropic 1000 0.0
MESH 'x_mesh.inp'
SURFace a FROM {low} IN low
SURFace b FROM {up} IN up
{more}
BOUNdary
  foot 1 1 1
  top 1 1 1
DISPlacement
  top {way}
PROPortional 1
  0 0
  1 -1
  3 1
OUTPut
  REACtions top
  FIELds NONE
BATCh
  DT,,1
  STEP,,3
END
'''
FORMS = ('GTOS b a', 'GTOS a b', 'NTOS b a', 'GTOS b a SEGMent', 'GTOS b a\n    SMOOth',
         'GTOS b a\n    AUGMent', 'NTOS a b\n    AUGMent', 'GTOS b a\n    FRICtion COULomb 0.3')


def cracks(program, report, seeds, first):
    """Pressed the bar is whole, pulled it is as if nothing were in the crack."""
    for seed in range(first, first + seeds):
        for form in FORMS:
            rng = chance(seed, 'cracks', form)
            n = rng.randint(1, 3)
            front = rng.choice((1.0, 2.0, 3.0))
            shared = rng.random() < 0.6
            solids = cracked(n, front, shared)
            place = Place(rng, 10.0**rng.uniform(0, 3))
            # a TIE knows where the joint ends from its own sets, or from those of the pair
            tie = '' if shared else rng.choice(('TIE REGIon lid_bond sole_bond', 'TIE'))
            names = rng.choice((('lid_open', 'sole_open'), ('lid', 'sole_open')))
            pair = f'CONTact\n  PAIR 1\n    {form}\n'
            way = ' '.join(f'{v:.17g}' for v in place.turn((0, 0, 0.02)))
            forces, trouble = [], []
            for more in (pair + tie, tie.replace('TIE', 'TIE REGIon lid_bond sole_bond')
                         if tie == 'TIE' else tie):
                with decks.fresh_folder() as folder:
                    solids.write(os.path.join(folder, 'x_mesh.inp'), place, chance(seed, form))
                    with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                        out.write(CRACK.format(more=more, way=way, low=names[0], up=names[1]))
                    done = decks.run(program, ['x.inp', '--quiet'], folder, 120)
                    if done.code != 0 or done.crash():
                        trouble.append(f'exit code {done.code}: {done.err[-400:]}')
                        continue
                    rows = table(folder)
                    forces.append([place.back(rows[step, 'top'])[2] for step in (1, 3)])
            if not trouble:
                (press, pull), (_, bare) = forces
                # 10 E/h over a height of 2 with cells h gives h/20 of the crack's share
                allowed = 1e-5 if 'AUGM' in form else 0.06/n
                if abs(press + 40) > 40*allowed:
                    trouble.append(f'pressed: force {press}, -40 expected')
                if abs(pull - bare) > 1e-6*abs(bare):
                    trouble.append(f'pulled: force {pull}, without the pair {bare}')
            report.add(f'crack: {form!r}, {n} cells, front {front}, shared {shared}, {tie!r}, {names}, '
                       f'seed {seed}', trouble)


EDGE = '''MFEC * * two faces of one block that meet at an edge
MATErial 1
  ELAStic ISOTropic 1000 0.3
MESH 'x_mesh.inp'
SURFace a FROM lid
SURFace b FROM flank
{more}
BOUNdary
  foot 1 1 1
TRACtion
  a {way}
OUTPut
  REACtions foot
  FIELds NONE
BATCh
  DT,,1
  STEP,,1
END
'''


def edges(program, report, seeds, first):
    """Faces of one body that meet at an edge, or lie on two sides of it, do not touch."""
    for seed in range(first, first + seeds):
        for form in ('GTOS a b', 'GTOS b a', 'NTOS a b', 'NTOS b a', 'GTOS a b SEGMent',
                     'GTOS b a 7'):
            rng = chance(seed, 'edges', form)
            high = rng.choice((0.1, 0.5, 1.0))
            lean = rng.uniform(-0.7, 0.7)*high
            n = rng.randint(2, 4)
            solids = Solids()
            solids.brick('body', (0, 0, 0), (1, 1, high), (n, n, n),
                         (('foot', 1, 0), ('lid', 2, high), (rng.choice(('flank', 'flank', 'rear')), 0, 1)),
                         lambda p: (p[0] + lean*p[2], p[1], p[2]))
            if 'flank' not in solids.sets:
                solids.sets['flank'] = [m for m, x in enumerate(solids.nodes) if x[2] == 0.0]
            place = Place(rng, 100.0)
            way = ' '.join(f'{v:.17g}' for v in place.turn((0.1, 0.2, -0.3)))
            with decks.fresh_folder() as folder:
                solids.write(os.path.join(folder, 'x_mesh.inp'), place, rng)
                with open(os.path.join(folder, 'x.inp'), 'w', encoding='ascii') as out:
                    out.write(EDGE.format(way=way, more=f'CONTact\n  PAIR 1\n    {form}'))
                done = decks.run(program, ['x.inp'], folder, 60)
                force = table(folder, suffix='.con')[1, '1'][3] if done.code == 0 else None
            report.add(f'edge: {form}, {n} cells, height {high}, lean {lean:.2f}, seed {seed}',
                       [] if force == 0.0 else [f'exit code {done.code}, force {force} '
                                                f'{done.err[-300:]}'])
