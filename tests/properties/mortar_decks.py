"""Decks of multipliers at nodes (MORTar) whose exact answer is known: blocks, a seam, a corner, a
kinked joint, rings. For tests/properties/mortar_laws.py.
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'verification'))
import meshing  # noqa: E402
import quadratic_studies as quadratic  # noqa: E402

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
E, PRESSURE = 1000.0, 10.0


def block(name, cells, low, high, tilt, kind):
    """A BLOCk whose joint at z = 1 leans along x."""
    lines = [f'BLOCk {name}', '  CART {} {} {}  MATErial 1  {}'.format(*cells, kind)]
    for k, bits in enumerate(CORNERS, 1):
        x, y, z = ((low, high)[b][axis] for axis, b in enumerate(bits))
        if z == 1:
            z += tilt*(x - 0.5)
        lines.append(f'  {k}  {x} {y} {z!r}')
    return '\n'.join(lines) + '\n'


def two_blocks(form, below, above, tilt, mu, kind):
    """A column of two blocks with frictionless sides on two planes, pressed from above."""
    boxes = []  # of the nodes of the joint, which leans: a box for each column of nodes
    for x in sorted({a/(2*m) for m in (below[0], above[0]) for a in range(2*m + 1)}):
        z = 1 + tilt*(x - 0.5)
        boxes.append(f'  BOX {x - 1e-6!r} {x + 1e-6!r} -1 2 {z - 1e-5!r} {z + 1e-5!r}\n')
    return ('MFEC * * two blocks\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic 1000 0.3\n'
            + block('low', below, (0, 0, 0), (1, 1, 1), tilt, kind)
            + block('high', above, (0, 0, 1), (1, 1, 2), tilt, kind)
            + 'SET floor\n  PLANe 3 0\nSET lid\n  PLANe 3 2\nSET x0\n  PLANe 1 0\nSET y0\n  PLANe 2 0\n'
            + 'SURFace under FROM joint IN low\nSURFace over FROM joint IN high\nSURFace top FROM lid\n'
            + 'SET joint\n' + '  OR\n'.join(boxes)
            + f'CONTact\n  PAIR 1\n    {form}\n    FRICtion COULomb {mu}\n'
            + 'BOUNdary\n  floor 0 0 1\n  x0 1 0 0\n  y0 0 1 0\n'
            + f'TRACtion\n  top 0 0 {-PRESSURE}\nOUTPut\n  REACtions floor\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')


def held_rims(text, rims, tilt):
    """The same with slave nodes at x = 0 or 1 held where an even pressure puts them."""
    for x in rims:
        z = 1 + tilt*(x - 0.5)
        text = text.replace('CONTact', f'SET rim{x}\n  INSIde high\n  BOX {x - 1e-6} {x + 1e-6} -1 2 {z - 1e-5!r} {z + 1e-5!r}\n'
                            'CONTact', 1).replace('BOUNdary\n', f'BOUNdary\n  rim{x} 0 0 1\n')
    moves = ''.join(f'  rim{x} 0 0 {-PRESSURE/E*(1 + tilt*(x - 0.5))!r}\n' for x in rims)
    return text.replace('TRACtion', 'DISPlacement\n' + moves + 'TRACtion')


def sprung(form, cells, kind, spring):
    """A cube on a block that springs at its top hold, pressed, then pushed along x by a quarter of that."""
    high, low = (cells,)*3, (cells + 2, cells + 2, 2)
    return ('MFEC * * a cube on springs\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic 1000 0.3\n'
            + block('low', low, (-0.5, -0.5, 0), (1.5, 1.5, 1), 0, kind)
            + block('high', high, (0, 0, 1), (1, 1, 2), 0, kind)
            + 'SET floor\n  PLANe 3 0\nSET lid\n  PLANe 3 2\nSET joint\n  PLANe 3 1\nSET side\n  INSIde high\n  PLANe 1 0\n'
            + 'SURFace under FROM joint IN low\nSURFace over FROM joint IN high\nSURFace top FROM lid\nSURFace face FROM side\n'
            + f'CONTact\n  PAIR 1\n    {form}\n    FRICtion COULomb 0.3\nBOUNdary\n  floor 1 1 1\n'
            + f'SPRIng\n  lid {spring} {spring} {spring}\nTRACtion\n  top 0 0 {-PRESSURE} 1\n  face {PRESSURE/4} 0 0 2\n'
            + 'PROPortional 1\n  0 0\n  1 1\nPROPortional 2\n  0 0\n  1 0\n  2 1\n'
            + 'OUTPut\n  REACtions floor\nBATCh\n  DT,,1/4\n  STEP,,8\nEND\n')


def dragged(text):
    """The same with the side x = 0 of the upper block held along x, over a lower one that is drawn along x."""
    return (text.replace('CONTact', 'SET side\n  INSIde high\n  PLANe 1 0\nCONTact', 1)
            .replace('  floor 0 0 1\n  x0 1 0 0\n  y0 0 1 0\n', '  floor 1 1 1\n  side 1 1 0\nDISPlacement\n'
                     '  floor 0.05 0 0\nPROPortional 1\n  0 0\n  1 1\n').replace('  DT,,1\n  STEP,,1', '  TOL,,1e-20\n  DT,,1/4\n  STEP,,4'))


def on_two(below):
    """A block over two others side by side, each with a pair of its own: nodes over the seam have two
    multipliers. Without lateral strain the seam stays where it is."""
    seam, mesh = 0.45, ''
    for name, x0, x1, cells in (('left', 0, seam, below[0]), ('right', seam, 1, below[1])):
        mesh += block(name, (cells, 3, 2), (x0, 0, 0), (x1, 1, 1), 0, 'TET4')
    return (f'MFEC * * three blocks\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic {E} 0\n' + mesh
            + block('high', (5, 4, 2), (0, 0, 1), (1, 1, 2), 0, 'TET4')
            + 'SET floor\n  PLANe 3 0\nSET lid\n  PLANe 3 2\nSET x0\n  PLANe 1 0\nSET y0\n  PLANe 2 0\n'
            + f'SET x2\n  BOX {seam - 1e-6} {seam + 1e-6} -1 2 -1 0.99\n'
            + 'SET joint\n  PLANe 3 1\nSURFace one FROM joint IN left\nSURFace two FROM joint IN right\n'
            + 'SURFace over FROM joint IN high\nSURFace top FROM lid\nCONTact\n'
            + ''.join(f'  PAIR {k}\n    MORTar over {name}\n    FRICtion COULomb 0.4\n'
                      for k, name in ((1, 'one'), (2, 'two')))
            + 'BOUNdary\n  floor 0 0 1\n  x0 1 0 0\n  x2 1 0 0\n  y0 0 1 0\n'
            + f'TRACtion\n  top 0 0 {-PRESSURE}\nOUTPut\n  REACtions floor\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')


def pile(one, two, pressed):
    """Three blocks with two joints: pressed by a pressure, or by a lid that then drags."""
    text = (f'MFEC * * three blocks\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic {E} 0.3\n'
            + block('low', (3, 3, 2), (0, 0, 0), (1, 1, 1), 0, 'TET4')
            + block('mid', (4, 3, 2), (0, 0, 1), (1, 1, 2), 0, 'TET4')
            + block('high', (4, 3, 2) if 'NTOS' in two else (5, 2, 2), (0, 0, 2), (1, 1, 3), 0, 'TET4')
            + 'SET floor\n  PLANe 3 0\nSET lid\n  PLANe 3 3\nSET x0\n  PLANe 1 0\nSET y0\n  PLANe 2 0\n'
            + 'SET one\n  PLANe 3 1\nSET two\n  PLANe 3 2\nSURFace under FROM one IN low\nSURFace over FROM one IN mid\n'
            + 'SURFace below FROM two IN mid\nSURFace above FROM two IN high\nSURFace top FROM lid\nCONTact\n'
            + f'  PAIR 1\n    {one}\n    FRICtion COULomb 0.9\n  PAIR 2\n    {two}\n    FRICtion COULomb 0.3\n')
    if pressed:
        return (text + f'BOUNdary\n  floor 0 0 1\n  x0 1 0 0\n  y0 0 1 0\nTRACtion\n  top 0 0 {-PRESSURE}\n'
                + 'OUTPut\n  REACtions floor\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')
    return (text + 'BOUNdary\n  floor 1 1 1\n  lid 1 1 1\nDISPlacement\n  lid 0 0 -0.01 1\n  lid 0.02 0.005 0 2\n'
            + 'PROPortional 1\n  0 0\n  1 1\nPROPortional 2\n  0 0\n  1 0\n  2 1\n'
            + 'OUTPut\n  REACtions floor lid\nBATCh\n  DT,,1/4\n  STEP,,8\nEND\n')


def on_thirds(form, n, kind):
    """A block on a plate three times as large, both of n cells: edges of the slave lie on edges of the master."""
    return ('MFEC * * edges on edges\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic 1000 0.3\n'
            + block('low', (n, n, 1), (-1, -1, -1), (2, 2, 0), 0, kind)
            + block('high', (n, n, 2), (0, 0, 0), (1, 1, 1), 0, kind)
            + 'SET floor\n  PLANe 3 -1\nSET joint\n  PLANe 3 0\nSET lid\n  PLANe 3 1\n'
            + 'SURFace under FROM joint IN low\nSURFace over FROM joint IN high\n'
            + f'CONTact\n  PAIR 1\n    {form}\n    FRICtion COULomb 0.3\nBOUNdary\n  floor 1 1 1\n  lid 1 1 1\n'
            + 'DISPlacement\n  lid 0.003 0.001 -0.01\nPROPortional 1\n  0 0\n  1 1\nOUTPut\n  REACtions floor lid\n'
            + 'BATCh\n  DT,,1/2\n  STEP,,2\nEND\n')


def resting(shift, kind):
    """A stiff block that friction holds on a softer one, under a dead load, somewhere in space."""
    x, y, z = shift
    return ('MFEC * * a block that rests\n'
            + ''.join(f'MATErial {k}\n  ELAStic ISOTropic {young} 0.3\n' for k, young in ((1, 1e4), (2, 2e5)))
            + f'TRANsform\n  1 0 0\n  0 1 0\n  0 0 1\n  {x!r} {y!r} {z!r}\n'
            + block('low', (4, 3, 1), (-0.6, -0.5, -0.4), (0.6, 0.5, 0), 0, kind)
            + block('high', (3, 2, 1), (-0.4, -0.35, 0), (0.4, 0.3, 0.5), 0, kind).replace('MATErial 1', 'MATErial 2')
            + f'SET floor\n  PLANe 3 {z - 0.4!r}\nSET joint\n  PLANe 3 {z!r}\nSET lid\n  PLANe 3 {z + 0.5!r}\n'
            + 'SURFace under FROM joint IN low\nSURFace over FROM joint IN high\nSURFace top FROM lid\n'
            + 'CONTact\n  PAIR 1\n    MORTar over under\n    FRICtion COULomb 1\nBOUNdary\n  floor 1 1 1\n'
            + 'TRACtion\n  top 0.03 0.02 -0.2\nOUTPut\n  REACtions floor\nBATCh\n  DT,,1/3\n  STEP,,1\nEND\n')


def cushion(cells):
    """A soft plate of rubber that contact alone holds between two stiff blocks: pressed, then sheared."""
    names = (('low', -0.5, -0.3, 0), ('mid', -0.45, 0, 0.2), ('high', -0.5, 0.2, 0.5))
    return ('MFEC * * a cushion\nMATErial 1\n  ELAStic ISOTropic 100 0.3\n'
            + 'MATErial 2\n  SOLId NEOHookean\n  ELAStic NEOHookean 1 0.3\n'
            + ''.join(block(name, n, (a, a, b), (-a, -a, c), 0, 'TET4').replace('MATErial 1', f'MATErial {m}')
                      for (name, a, b, c), n, m in zip(names, cells, (1, 2, 1)))
            + 'SET floor\n  PLANe 3 -0.3\nSET one\n  PLANe 3 0\nSET two\n  PLANe 3 0.2\nSET lid\n  PLANe 3 0.5\n'
            + 'SURFace bed FROM one IN low\nSURFace foot FROM one IN mid\nSURFace head FROM two IN mid\n'
            + 'SURFace roof FROM two IN high\nBOUNdary\n  floor 1 1 1\n  lid 1 1 1\n'
            + 'DISPlacement\n  lid 0 0 -0.01 1\n  lid 0.008 0.004 0 2\n'
            + 'PROPortional 1\n  0 0\n  1 1\nPROPortional 2\n  1 0\n  2 1\nCONTact\n'
            + ''.join(f'  PAIR {k}\n    MORTar {sides}\n    FRICtion COULomb 0.6\n'
                      for k, sides in ((1, 'foot bed'), (2, 'head roof')))
            + 'OUTPut\n  REACtions floor lid\nBATCh\n  DT,,1/4\n  STEP,,8\nEND\n')


def in_corner(kind):
    """A block between a rigid floor and a rigid wall: nodes of its edge are in two pairs."""
    return (f'MFEC * * a corner\nMATErial 1\n  SOLId LINEar\n  ELAStic ISOTropic {E} 0.3\n'
            + 'MATErial 2\n  RIGId\n'
            + block('low', (2, 2, 1), (-0.5, -0.5, -1), (1.5, 1.5, 0), 0, 'TET4').replace('MATErial 1', 'MATErial 2')
            + block('side', (1, 3, 2), (-1, -0.5, -0.5), (0, 1.5, 1.5), 0, 'TET4').replace('MATErial 1', 'MATErial 2')
            + block('cube', (4, 3, 3), (0, 0, 0), (1, 1, 1), 0, kind)
            + 'SET floor\n  PLANe 3 0\nSET wall\n  PLANe 1 0\nSET lid\n  INSIde cube\n  PLANe 3 1\n'
            + 'SET face\n  INSIde cube\n  PLANe 1 1\nSET y0\n  INSIde cube\n  PLANe 2 0\n'
            + 'SURFace ground FROM floor IN low\nSURFace foot FROM floor IN cube\nSURFace barrier FROM wall IN side\n'
            + 'SURFace back FROM wall IN cube\nSURFace top FROM lid\nSURFace front FROM face\nCONTact\n'
            + '  PAIR 1\n    MORTar foot ground\n  PAIR 2\n    MORTar back barrier\nBOUNdary\n  y0 0 1 0\n'
            + f'TRACtion\n  top 0 0 {-PRESSURE}\n  front {-0.5*PRESSURE} 0 0\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')


def numbered(mesh, ten, middle=lambda a, b: tuple((p + q)/2 for p, q in zip(a, b))):
    """Records of a mesh of four nodes, or of ten; the mesh as it is then."""
    if not ten:
        return mesh, mesh.records()
    mesh = quadratic.ten_nodes(mesh, middle)
    return mesh, quadratic.records(mesh)


def surfaces(mesh, elements, on):
    """Sets and surfaces of two bodies: `foot` of elements behind the first so many, `bed` of these."""
    below = {n for e in mesh.elements[:elements] for n in e[1:]}
    return ''.join(meshing.node_set(f'of_{name}', [n for n, x in enumerate(mesh.nodes, 1) if on(*x) and (n in below) == low])
                   + f'SURFace {name} FROM of_{name}\n' for name, low in (('bed', True), ('foot', False)))


def kinked(form, below, above, slope, ten):
    """Two blocks whose joint is flat, then rises, then is flat again: the traction of an even
    pressure jumps at both kinks. Cells along x: multiples of 4."""
    def top(x):
        return 1 + 2*slope*min(max(x - 0.25, 0), 0.5)

    mesh = meshing.Mesh()
    mesh.box(below, lambda i, j, k: (i/below[0], j/below[1], top(i/below[0])*k/below[2]))
    elements = len(mesh.elements)
    mesh.box(above, lambda i, j, k: (i/above[0], j/above[1],
                                     2.5*k/above[2] + top(i/above[0])*(1 - k/above[2])))
    mesh, records = numbered(mesh, ten)
    codes = {n: tuple(int(abs(v) < 1e-9) for v in x) for n, x in enumerate(mesh.nodes, 1) if min(map(abs, x)) < 1e-9}
    return ('MFEC * * a kinked joint\n' + meshing.solid(1, E, 0.3) + records
            + surfaces(mesh, elements, lambda x, y, z: abs(z - top(x)) < 1e-9)
            + 'SET lid\n  PLANe 3 2.5\nSURFace top FROM lid\n' + meshing.vectors('BOUNdary', codes)
            + f'CONTact\n  PAIR 1\n    {form}\n    FRICtion COULomb {3*slope}\n'
            + f'TRACtion\n  top 0 0 {-PRESSURE}\nBATCh\n  DT,,1\n  STEP,,1\nEND\n')


RADII, OVERLAP, YOUNG, NU = (1.0, 1.5, 2.2), 0.003, (2000.0, 1000.0), (0.3, 0.25)
QUARTER = math.pi/2*RADII[1]*0.25


def lame():
    """Force over a quarter of the interface of two rings of plane strain, one shrunk on the other."""
    a, c, b = RADII
    inner, outer = ((1 - n*n)/e*c for e, n in zip(YOUNG, NU))
    inner *= (c*c + a*a)/(c*c - a*a) - NU[0]/(1 - NU[0])
    outer *= (b*b + c*c)/(b*b - c*c) + NU[1]/(1 - NU[1])
    return OVERLAP/(inner + outer)*QUARTER


def rings(form, cells):
    """Quarters of two rings of ten-node elements, with so many cells around; the outer one is shrunk."""
    a, c, b = RADII
    mesh, counts = meshing.Mesh(), []
    for material, n, inside, outside in ((1, cells[0], a, c), (2, cells[1], c - OVERLAP, b)):
        def place(i, j, k, n=n, inside=inside, outside=outside):
            r, turn = inside + (outside - inside)*j/max(2, n//3), math.pi/2*i/n
            return r*math.sin(turn), r*math.cos(turn), 0.25*k
        mesh.box((n, max(2, n//3), 1), place, material)
        counts.append(len(mesh.elements))

    def middle(p, q):
        half, ends = [(u + v)/2 for u, v in zip(p, q)], [math.hypot(*x[:2]) for x in (p, q)]
        grown = ends[0]/math.hypot(*half[:2]) if abs(ends[0] - ends[1]) < 1e-9 else 1
        return half[0]*grown, half[1]*grown, half[2]

    mesh, records = numbered(mesh, True, middle)
    codes = {n: (int(abs(x[0]) < 1e-9), int(abs(x[1]) < 1e-9), 1) for n, x in enumerate(mesh.nodes, 1)}
    return ('MFEC * * a shrunk ring\n' + ''.join(meshing.solid(k + 1, YOUNG[k], NU[k]) for k in (0, 1)) + records
            + surfaces(mesh, counts[0], lambda x, y, z: c - 2*OVERLAP < math.hypot(x, y) < c + OVERLAP)
            + meshing.vectors('BOUNdary', codes) + 'PROPortional 1\n  0 0\n  1 1\n'
            + f'CONTact\n  PAIR 1\n    {form}\n    SHRInk 1\nBATCh\n  DT,,1/2\n  STEP,,2\nEND\n')
