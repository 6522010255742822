"""Scenes with known answers for mfec-post adapt, drawn from seeds.

Each kind writes a deck (and a geometry) into a folder and says goal, wish, order, and where the true
value comes from: a closed form, or None: then tests/adapt/campaign asks a finer adaptation.
"""
import math
import os
import random
from dataclasses import dataclass
from typing import Optional


@dataclass
class Scene:
    """A deck to be adapted."""

    name: str
    deck: str
    goal: str
    wish: float
    order: int
    geometry: Optional[str]
    truth: Optional[float]
    settings: tuple = ()
    other: tuple = ()
    """--set of the reference: another first mesh."""


def materials(*moduli):
    """MATErial of bodies a, b, ..."""
    return ''.join(f'\nMATErial {k} {name}\n  SOLId LINEar\n  ELAStic ISOTropic {young:.6g} {nu:.4g}\n'
                   for k, (name, young, nu) in enumerate(moduli, 1))


def block(name, number, cells, low, high):
    """BLOCk between two corners."""
    (a, b, c), (d, e, f) = low, high
    corners = [(a, b, c), (d, b, c), (d, e, c), (a, e, c), (a, b, f), (d, b, f), (d, e, f), (a, e, f)]
    return f'\nBLOCk {name}\n  CART {cells} MATErial {number} TET4\n' + ''.join(
        '  %d  %.9g %.9g %.9g\n' % (k, *x) for k, x in enumerate(corners, 1))


def pressed(folder, chance, slides):
    """A small block on a large one: pressed, and with `slides` pushed sideways until some of it slips."""
    side, high = chance.uniform(0.6, 1.0), chance.uniform(0.4, 0.8)
    mu = chance.uniform(0.2, 0.6)
    young = [1000.0, 1000.0 * math.exp(chance.uniform(-1.0, 1.0))]
    down = chance.uniform(0.004, 0.01) * high
    push = chance.uniform(0.15, 0.45) * mu * down
    lines = ['MFEC * * A block on another', 'PARAmeter', '  n = 2', '  m = 4',
             materials(('small', young[0], chance.uniform(0.0, 0.4)), ('large', young[1], chance.uniform(0.0, 0.4))),
             block('small', 1, 'n n n', (0, 0, 0), (side, side, high)),
             block('large', 2, 'm m n', (-0.5, -0.5, -0.8), (side + 0.5, side + 0.5, 0)), f'''
SET top
  INSIde small
  PLANe 3 {high:.9g}
SET sole
  INSIde small
  PLANe 3 0
SET ground
  PLANe 3 -0.8
SET face
  INSIde large
  PLANe 3 0

SURFace under FROM sole IN small
SURFace track FROM face IN large

BOUNdary
  top     1 1 1
  ground  1 1 1
DISPlacement
  top     {push if slides else 0:.9g} 0 {-down:.9g}
FPROportional
  top     2 2 1
PROPortional 1
  0 0
  1 1
PROPortional 2
  1 0
  2 1

CONTact
  PAIR 1 c
    NTOS under track
    PENAlty AUTO
    FRICtion {f"COULomb {mu:.4g}" if slides or chance.random() < 0.5 else "NONE"}

END
BATCh
  DT,,1/2
  STEP,,2
{"  DT,,1/4" if slides else ""}
{"  STEP,,4" if slides else ""}
END
STOP
''']
    deck = os.path.join(folder, 'scene.inp')
    with open(deck, 'w', encoding='ascii') as stream:
        stream.write('\n'.join(lines))
    return deck, ('top.R1' if slides else 'top.R3')


def ring_geometry(folder, a, c, b, overlap, high):
    """A quarter of two rings; the inner one is larger by the overlap. (c: common radius before)"""
    path = os.path.join(folder, 'scene.geo')
    e = 1e-6
    with open(path, 'w', encoding='ascii') as stream:
        stream.write(f'''SetFactory("OpenCASCADE");
Cylinder(1) = {{0, 0, 0, 0, 0, {high}, {c + overlap}, Pi/2}};
Cylinder(2) = {{0, 0, 0, 0, 0, {high}, {a}, Pi/2}};
BooleanDifference(3) = {{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }};
Cylinder(4) = {{0, 0, 0, 0, 0, {high}, {b}, Pi/2}};
Cylinder(5) = {{0, 0, 0, 0, 0, {high}, {c}, Pi/2}};
BooleanDifference(6) = {{ Volume{{4}}; Delete; }}{{ Volume{{5}}; Delete; }};
Physical Volume("shaft") = {{3}};
Physical Volume("hub") = {{6}};
s() = Boundary{{ Volume{{3}}; }};
h() = Boundary{{ Volume{{6}}; }};
For k In {{0:#s()-1}}
  x() = BoundingBox Surface{{ s(k) }};
  If (x(3) - x(0) > {c}*0.99 && x(4) - x(1) > {c}*0.99 && x(5) - x(2) > {high / 2})
    Physical Surface("seat") = {{s(k)}};
  EndIf
EndFor
For k In {{0:#h()-1}}
  x() = BoundingBox Surface{{ h(k) }};
  If (x(3) - x(0) > {c}*0.99 && x(3) - x(0) < {c}*1.01 && x(4) - x(1) > {c}*0.99 && x(5) - x(2) > {high / 2})
    Physical Surface("bore") = {{h(k)}};
  EndIf
EndFor
''')
    return path


def fit(folder, chance, order):
    """A press fit of two rings in plane strain, a quarter of it: Lame."""
    from mfec_post.adapt_remesh import by_gmsh
    a, c, b = 0.5 * chance.uniform(0.8, 1.2), 1.0, chance.uniform(1.5, 2.0)
    high, overlap = 0.2, chance.uniform(0.001, 0.004)
    young = [1000.0, 1000.0 * math.exp(chance.uniform(-1.0, 1.0))]
    nu = [chance.uniform(0.1, 0.4), chance.uniform(0.1, 0.4)]
    geometry = ring_geometry(folder, a, c, b, overlap, high)
    by_gmsh(geometry, None, None, order, os.path.join(folder, 'scene.msh'), 0.3)
    # radii of the unstrained shaft a, c + overlap; of the hub c, b. Plane strain. The force of one is
    # that of the other, on areas that differ by the overlap: 1e-3 of the answer.
    outer = c + overlap
    inside = (1 + nu[0]) / young[0] * outer * ((1 - 2 * nu[0]) * outer ** 2 + a ** 2) / (outer ** 2 - a ** 2)
    outside = (1 + nu[1]) / young[1] * c * ((1 - 2 * nu[1]) * c ** 2 + b ** 2) / (b ** 2 - c ** 2)
    force = overlap / (inside / outer + outside / c) * math.pi / 2 * high
    deck = os.path.join(folder, 'scene.inp')
    with open(deck, 'w', encoding='ascii') as stream:
        stream.write('MFEC * * A press fit\n' + materials(('shaft', young[0], nu[0]), ('hub', young[1], nu[1])) + f'''
MESH scene.msh

EBOUndary
  1 0  1 0 0
  2 0  0 1 0
  3 0  0 0 1
  3 {high}  0 0 1

PROPortional 1
  0 0
  1 1

CONTact
  PAIR 1 fit
    GTOS seat bore
    PENAlty AUTO
    SHRInk 1

END
BATCh
  DT,,1/2
  STEP,,2
END
STOP
''')
    return deck, geometry, force


def ball(folder, chance, order, rubs):
    """A quarter of a ball pressed on a block, and with `rubs` with friction: held by its top."""
    from mfec_post.adapt_remesh import by_gmsh
    radius, deep = 1.0, 0.5
    wide = chance.uniform(0.7, 0.9)
    way = chance.uniform(0.01, 0.03)
    mu = chance.uniform(0.1, 0.5)
    young = [1000.0, 1000.0 * math.exp(chance.uniform(-1.0, 1.0))]
    nu = [chance.uniform(0.1, 0.4), chance.uniform(0.1, 0.4)]
    path = os.path.join(folder, 'scene.geo')
    with open(path, 'w', encoding='ascii') as stream:
        stream.write(f'''SetFactory("OpenCASCADE");
Sphere(1) = {{0, 0, {radius}, {radius}, -Pi/2, 0, Pi/2}};
Box(2) = {{0, 0, -0.4, 0.6, 0.6, {deep - 0.1 + radius}}};
BooleanIntersection(3) = {{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }};
Box(4) = {{0, 0, {-deep}, {wide}, {wide}, {deep}}};
Physical Volume("ball") = {{3}};
Physical Volume("block") = {{4}};
s() = Boundary{{ Volume{{3}}; }};
For k In {{0:#s()-1}}
  x() = BoundingBox Surface{{ s(k) }};
  If (x(2) < 1e-3 && x(3) - x(0) > 0.5 && x(4) - x(1) > 0.5)
    Physical Surface("skin") = {{s(k)}};
  EndIf
EndFor
''')
    by_gmsh(path, None, None, order, os.path.join(folder, 'scene.msh'), 0.25)
    deck = os.path.join(folder, 'scene.inp')
    with open(deck, 'w', encoding='ascii') as stream:
        stream.write('MFEC * * A ball on a block\n' + materials(('ball', young[0], nu[0]), ('block', young[1], nu[1])) + f'''
MESH scene.msh

SET top
  INSIde ball
  PLANe 3 {radius}
SET ground
  PLANe 3 {-deep}
SET face
  INSIde block
  PLANe 3 0
SURFace track FROM face IN block

EBOUndary
  1 0  1 0 0
  2 0  0 1 0
BOUNdary
  top 0 0 1
  ground 1 1 1
DISPlacement
  top 0 0 {-way:.9g}
PROPortional 1
  0 0
  1 1

CONTact
  PAIR 1 c
    GTOS skin track
    PENAlty AUTO
    FRICtion {f"COULomb {mu:.4g}" if rubs else "NONE"}

END
BATCh
  DT,,1/2
  STEP,,2
END
STOP
''')
    return deck, path


KINDS = ('fit', 'press', 'push', 'ball', 'rub')


def draw(seed, folder):
    """The scene of a seed: kinds take turns, every third has four nodes a cell."""
    chance = random.Random(7000 + seed)
    kind, order = KINDS[seed % len(KINDS)], 1 if seed % 3 == 2 else 2
    os.makedirs(folder, exist_ok=True)
    name = f'{kind} {seed}'
    if kind == 'fit':
        deck, geometry, truth = fit(folder, chance, order)
        return Scene(name, deck, 'fit:Fn', 0.01 if order == 2 else 0.05, order, geometry, truth)
    if kind in ('press', 'push'):
        deck, goal = pressed(folder, chance, kind == 'push')
        return Scene(name, deck, goal, 0.04 if order == 2 else 0.25, order, None, None, other=('n=3', 'm=5'))
    deck, geometry = ball(folder, chance, order, kind == 'rub')
    goal = 'top.R3' if kind == 'ball' or order == 1 else 'c:Ft'
    return Scene(name, deck, goal, 0.04 if order == 2 else 0.15, order, geometry, None)
