"""Scenes with known answers for mfec-post adapt, drawn from seeds: eight kinds take turns.

A scene has a deck to be adapted, and either a closed form or a reference of another kind: MORTar on
meshes graded by hand, thinner slices in plane strain, halves and quarters where they are alike.
"""
import math
import os
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Optional


@dataclass
class Scene:
    """A deck to be adapted. Geometries are functions of the scale of the reference, None for the scene's own."""

    name: str
    goal: str
    wish: float
    order: int
    deck: Callable[[Optional[float]], str]
    geometry: Optional[Callable[[Optional[float]], str]]
    truth: Optional[float] = None
    fine: Optional[Callable[[float], str]] = None
    """Geometry of the reference where the scene has none."""
    times: Callable[[float], float] = lambda scale: 1.0
    """The scene's goal over the reference's."""
    size: float = 0.25
    """Elements of the first mesh."""

    def write(self, folder, scale=None):
        """Deck, geometry and first mesh; with a scale those of the reference. Paths of deck and geometry."""
        from mfec_post.adapt_remesh import by_gmsh
        os.makedirs(folder, exist_ok=True)
        deck, path = os.path.join(folder, 'scene.inp'), os.path.join(folder, 'scene.geo')
        save(deck, self.deck(scale))
        geometry = self.fine if scale and self.fine else self.geometry
        if geometry is None:
            return deck, None
        save(path, geometry(scale))
        by_gmsh(path, None, None, 2 if scale else self.order, os.path.join(folder, 'scene.msh'),
                None if scale else self.size)
        return deck, path


def save(path, text):
    """A file of a scene."""
    with open(path, 'w', encoding='ascii') as stream:
        stream.write(text)


THICK = 0.15
"""Of slices in plane strain; those of a reference are thinner."""
SOLE = '''
SET sole
  INSIde upper
  PLANe 2 0
SURFace under FROM sole IN upper
'''


def thin(scale, least):
    """Thickness of a slice, of about its smallest elements in a reference."""
    return least * scale if scale else THICK


def moduli(chance, far):
    """Young's moduli of two bodies, alike or `far` from each other, and their Poisson's ratios."""
    ratio = math.exp(chance.choice((-1, 1)) * chance.uniform(3.0, 5.0) if far else chance.uniform(-1.0, 1.0))
    return [1000.0, 1000.0 * ratio], [chance.uniform(0.1, 0.4), chance.uniform(0.1, 0.4)]


def deck(title, young, nu, mesh, model, form, mu, steps, more=''):
    """Text of a deck: two materials, mesh, sets and supports, a pair, steps of one unit of time each."""
    bodies = ''.join(f'\nMATErial {k + 1} {name}\n  SOLId LINEar\n  ELAStic ISOTropic {young[k]:.6g} {nu[k]:.4g}\n'
                     for k, name in enumerate(('upper', 'lower')))
    batch = ''.join(f'  DT,,1/{n}\n  STEP,,{n}\n' for n in steps)
    friction = f'COULomb {mu:.4g}' if mu else 'NONE'
    return (f'MFEC * * {title}\n{bodies}\n{mesh}\n{model}\n'
            f'CONTact\n  PAIR 1 c\n    {form}\n    FRICtion {friction}\n{more}\nEND\nBATCh\n{batch}END\nSTOP\n')


def form(kind, slave, master, scale):
    """The scene's form of contact, or that of the reference: at sharp edges facets of six points, with a penalty
    that grows as its elements shrink, for MORTar's weights do not settle there."""
    if scale and slave != 'under':
        return f'MORTar {slave} {master}'
    return (f'GTOS {slave} {master} 6' if scale else f'{kind} {slave} {master}') + '\n    PENAlty AUTO'


def graded(scale, fields):
    """Sizes of a reference: the least of (least size, growth, distance); nothing without a scale."""
    if not scale:
        return ''
    text = ''.join(f'Field[{k}] = MathEval;\nField[{k}].F = "Sqrt(({h * scale:.6g})^2 + ({g * scale:.6g})^2*({d}))";\n'
                   for k, (h, g, d) in enumerate(fields, 1))
    last = len(fields) + 1
    return (f'{text}Field[{last}] = Min;\nField[{last}].FieldsList = {{1:{len(fields)}}};\n'
            f'Background Field = {last};\nMesh.MeshSizeExtendFromBoundary = 0;\nMesh.MeshSizeFromPoints = 0;\n')


def supports(*planes):
    """EBOUndary: the nodes of these planes (axis, place) do not leave them."""
    return '\nEBOUndary\n' + ''.join(f'  {axis} {place:.9g}  {" ".join("1" if k == axis else "0" for k in (1, 2, 3))}\n'
                                     for axis, place in planes)


# Press fits: rings and spheres of Lame

def fit(chance, name, order, far):
    """A press fit of two rings in plane strain, a quarter of it, or of two hollow spheres, an eighth."""
    ball = name.startswith('shell')
    a, c, b = 0.5 * chance.uniform(0.8, 1.2), 1.0, chance.uniform(1.5, 2.0)
    high, overlap = 0.2, chance.uniform(0.001, 0.004) * (1 if order == 2 else 8)  # flat facets sag
    young, nu = moduli(chance, far)
    outer = c + overlap
    if ball:
        force = sphere_pressure(a, c, b, overlap, young, nu) * math.pi / 2 * c ** 2
    else:
        inside = (1 + nu[0]) / young[0] * ((1 - 2 * nu[0]) * outer ** 2 + a ** 2) / (outer ** 2 - a ** 2)
        outside = (1 + nu[1]) / young[1] * ((1 - 2 * nu[1]) * c ** 2 + b ** 2) / (b ** 2 - c ** 2)
        force = overlap / (inside + outside) * math.pi / 2 * high
    shape = ('Sphere({k}) = {{0, 0, 0, {r}, 0, Pi/2, Pi/2}};' if ball else
             f'Cylinder({{k}}) = {{{{0, 0, 0, 0, 0, {high}, {{r}}, Pi/2}}}};')
    least = c * 0.99 if ball else high / 2
    seat = '\n'.join(f'''{surface}() = Boundary{{ Volume{{{body}}}; }};
For k In {{0:#{surface}()-1}}
  x() = BoundingBox Surface{{ {surface}(k) }};
  If (x(3) - x(0) > {c * 0.99} && x(3) - x(0) < {c * 1.05} && x(4) - x(1) > {c * 0.99} && x(5) - x(2) > {least})
    Physical Surface("{surface}") = {{{surface}(k)}};
  EndIf
EndFor''' for surface, body in (('seat', 5), ('bore', 6)))
    bodies = '\n'.join(shape.format(k=k, r=r) for k, r in enumerate((outer, a, b, c), 1))
    text = f'''SetFactory("OpenCASCADE");
{bodies}
BooleanDifference(5) = {{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }};
BooleanDifference(6) = {{ Volume{{3}}; Delete; }}{{ Volume{{4}}; Delete; }};
Physical Volume("upper") = {{5}};
Physical Volume("lower") = {{6}};
{seat}
'''
    model = supports((1, 0), (2, 0), (3, 0), *([] if ball else [(3, high)])) + '\nPROPortional 1\n  0 0\n  1 1\n'

    def write(scale):
        return deck('A press fit', young, nu, 'MESH scene.msh\n', model, form('GTOS', 'seat', 'bore', scale), 0.0, (2,),
                    '    SHRInk 1\n')
    return Scene(name, 'c:Fn', 0.02 if order == 2 else 0.1, order, write, lambda scale: text, force,
                 size=0.35 if ball else 0.3)


def sphere_pressure(a, c, b, overlap, young, nu):
    """Pressure (on the bore) between hollow spheres a to c + overlap and c to b: u = A r + B/r^2."""
    def way(free, loaded, young, nu):
        """Radial displacement of the loaded surface for a unit pressure on it."""
        bulk, shear = young / (3 * (1 - 2 * nu)), young / (2 * (1 + nu))
        last = -1.0 / (4 * shear * (1 / free ** 3 - 1 / loaded ** 3))
        return 4 * shear * last / (3 * bulk * free ** 3) * loaded + last / loaded ** 2
    outer = c + overlap
    return overlap / (way(b, c, young[1], nu[1]) - way(a, outer, young[0], nu[0]) * (c / outer) ** 2)


# Blocks on blocks, meshed by mmg

def blocks(chance, name, order, far):
    """A block on a larger one in plane strain, pressed, and `push`: then moved sideways until some of it slips."""
    slides = name.startswith('push')
    half, high, wide, deep = chance.uniform(0.3, 0.5), chance.uniform(0.4, 0.8), 0.5, 0.8
    mu = chance.uniform(0.2, 0.6)
    young, nu = moduli(chance, far)
    down = chance.uniform(0.004, 0.01) * high
    push = chance.uniform(0.15, 0.45) * mu * down if slides else 0.0
    mu = mu if slides or chance.random() < 0.5 else 0.0

    def block(body, number, cells, low, up):
        (a, c), (d, f) = low, up
        corners = [(x, y, z) for z in (0, THICK) for x, y in ((a, c), (d, c), (d, f), (a, f))]
        return f'\nBLOCk {body}\n  CART {cells} MATErial {number} TET4\n' + ''.join(
            '  %d  %.9g %.9g %.9g\n' % (k, *x) for k, x in enumerate(corners, 1))

    mesh = (block('upper', 1, '4 4 1', (-half, 0), (half, high))
            + block('lower', 2, '6 3 1', (-half - wide, -deep), (half + wide, 0)))

    def fine(scale):
        return slices(f'Rectangle(3) = {{{-half}, 0, 0, {2 * half}, {high}}};',
                      f'Rectangle(4) = {{{-half - wide}, {-deep}, 0, {2 * (half + wide)}, {deep}}};',
                      scale, thin(scale, 0.04 * half), [(0.006 * half, 0.2, f'(Fabs(x)-{half})^2+y^2')], '')

    def write(scale):
        model = flat(f'INSIde upper\n  PLANe 2 {high:.9g}', deep, 2) + SOLE + supports(
            (3, 0), (3, thin(scale, 0.04 * half))) + moved(push, -down)
        return deck('A block on another', young, nu, 'MESH scene.msh\n' if scale else mesh, model,
                    form('NTOS', 'under', 'track', scale), mu, (2, 4) if slides else (2,))
    return Scene(name, 'top.R1' if slides else 'top.R2', 0.02 if order == 2 else 0.1, order, write, None,
                 fine=fine, times=lambda scale: THICK / thin(scale, 0.04 * half))


def moved(along, down):
    """The top is pressed down, then moved along."""
    return f'''
BOUNdary
  top 1 1 1
  ground 1 1 1
DISPlacement
  top {along:.9g} {down:.9g} 0
FPROportional
  top 2 1 1
PROPortional 1
  0 0
  1 1
PROPortional 2
  1 0
  2 1
'''


# Round on flat: a ball in space, rollers and punches in plane strain

def ball(chance, name, order, far):
    """A quarter of a ball pressed on a block, held by its top; with friction every other time."""
    wide, deep, way = chance.uniform(0.7, 0.9), 0.5, chance.uniform(0.05, 0.08)
    mu = chance.uniform(0.1, 0.5) * chance.choice((0, 1))
    young, nu = moduli(chance, far)

    def geometry(scale):
        return f'''SetFactory("OpenCASCADE");
Sphere(1) = {{0, 0, 1, 1, -Pi/2, 0, Pi/2}};
Box(2) = {{0, 0, -0.4, 0.6, 0.6, 0.8}};
BooleanIntersection(3) = {{ Volume{{1}}; Delete; }}{{ Volume{{2}}; Delete; }};
Box(4) = {{0, 0, {-deep}, {wide}, {wide}, {deep}}};
Physical Volume("upper") = {{3}};
Physical Volume("lower") = {{4}};
s() = Boundary{{ Volume{{3}}; }};
For k In {{0:#s()-1}}
  x() = BoundingBox Surface{{ s(k) }};
  If (x(2) < 1e-3 && x(3) - x(0) > 0.5 && x(4) - x(1) > 0.5)
    Physical Surface("skin") = {{s(k)}};
  EndIf
EndFor
{graded(scale, [(0.1 * math.sqrt(way), 0.22 / 1.5, 'x^2+y^2+z^2')])}'''

    def write(scale):
        model = flat('INSIde upper\n  PLANe 3 0.4', deep, 3) + supports((1, 0), (2, 0)) + f'''
BOUNdary
  top 0 0 1
  ground 1 1 1
DISPlacement
  top 0 0 {-way:.9g}
PROPortional 1
  0 0
  1 1
'''
        return deck('A ball on a block', young, nu, 'MESH scene.msh\n', model, form('GTOS', 'skin', 'track', scale), mu,
                    (2,))
    return Scene(name, 'top.R3', 0.02 if order == 2 else 0.1, order, write, geometry)


def flat(top, deep, axis):
    """Sets of a body on a slab whose face is in 0."""
    return f'''
SET top
  {top}
SET ground
  PLANe {axis} {-deep}
SET face
  INSIde lower
  PLANe {axis} 0
SURFace track FROM face IN lower
'''


def slices(body, low, scale, thin, fields, skin):
    """Two plane bodies, drawn as surfaces 3 and 4, as slices. Those of a reference are thin, of one layer."""
    layer = 'Layers{1};' if scale else ''
    return f'''SetFactory("OpenCASCADE");
{body}
{low}
a() = Extrude {{0, 0, {thin}}} {{ Surface{{3}}; {layer} }};
b() = Extrude {{0, 0, {thin}}} {{ Surface{{4}}; {layer} }};
Physical Volume("upper") = {{a(1)}};
Physical Volume("lower") = {{b(1)}};
{skin}
{graded(scale, fields)}'''


def roller(chance, name, order, far):
    """A rounded die in plane strain, pressed on a slab, then moved: `rub` a little, so that some of the contact
    slips, `iron` by its whole width."""
    irons = name.startswith('iron')
    deep, wide, high = chance.uniform(0.4, 0.7), chance.uniform(0.4, 0.6), 0.5
    way, mu = chance.uniform(0.01, 0.025), chance.uniform(0.2, 0.5)
    width = math.sqrt(2 * way)
    push = chance.uniform(0.8, 1.5) * width if irons else chance.uniform(0.2, 0.6) * mu * way
    young, nu = moduli(chance, far)
    ends = wide + 0.5, wide + 0.5 + (push if irons else 0.0)
    least = 0.1 * width

    def geometry(scale):
        t, e = thin(scale, least), 1e-6
        rise = 1 - math.sqrt(1 - wide ** 2)
        middle = push if irons else 0.0
        fields = [(0.09 * width, 0.2, f'Fabs(Fabs(x-{k})-{0.6 * width})^2+y^2') for k in {0.0, middle}]
        return slices(f'Disk(1) = {{0, 1, 0, 1}};\nRectangle(2) = {{{-wide}, -0.1, 0, {2 * wide}, {high + 0.1}}};\n'
                      'BooleanIntersection(3) = { Surface{1}; Delete; }{ Surface{2}; Delete; };',
                      f'Rectangle(4) = {{{-ends[0]}, {-deep}, 0, {sum(ends)}, {deep}}};', scale, t, fields,
                      'Physical Surface("skin") = Surface In BoundingBox'
                      f'{{{-wide - e}, {-e}, {-e}, {wide + e}, {rise + e}, {t + e}}};')

    def write(scale):
        model = flat(f'INSIde upper\n  PLANe 2 {high}', deep, 2) + supports(
            (3, 0), (3, thin(scale, least))) + moved(push, -way)
        return deck('A die on a slab', young, nu, 'MESH scene.msh\n', model, form('GTOS', 'skin', 'track', scale), mu,
                    (2, 6) if irons else (2, 4))
    return Scene(name, 'top.R1', 0.02 if order == 2 else 0.1, order, write, geometry,
                 times=lambda scale: THICK / thin(scale, least))


def punch(chance, name, order, far):
    """Half a punch with sharp edges in plane strain, on a slab."""
    deep, wide, high = chance.uniform(0.4, 0.8), chance.uniform(0.3, 0.6), chance.uniform(0.3, 0.6)
    way, mu = chance.uniform(0.004, 0.01), chance.uniform(0.1, 0.5) * chance.choice((0, 1))
    young, nu = moduli(chance, far)
    least = 0.04 * wide

    def geometry(scale):
        return slices(f'Rectangle(3) = {{0, 0, 0, {wide}, {high}}};',
                      f'Rectangle(4) = {{0, {-deep}, 0, {wide + 0.6}, {deep}}};', scale, thin(scale, least),
                      [(0.006 * wide, 0.2, f'(x-{wide})^2+y^2')], '')

    def write(scale):
        model = flat(f'INSIde upper\n  PLANe 2 {high:.9g}', deep, 2) + SOLE + supports(
            (1, 0), (3, 0), (3, thin(scale, least))) + f'''
BOUNdary
  top 1 1 1
  ground 1 1 1
DISPlacement
  top 0 {-way:.9g} 0
PROPortional 1
  0 0
  1 1
'''
        return deck('A punch on a slab', young, nu, 'MESH scene.msh\n', model,
                    form('GTOS', 'under', 'track', scale), mu, (2,))
    return Scene(name, 'top.R2', 0.02 if order == 2 else 0.1, order, write, geometry,
                 times=lambda scale: THICK / thin(scale, least))


KINDS = {'fit': fit, 'press': blocks, 'rub': roller, 'ball': ball, 'shell': fit, 'push': blocks, 'iron': roller,
         'punch': punch}


def draw(seed):
    """The scene of a seed: kinds take turns; two of five have four nodes a cell, and two bodies of like stiffness."""
    chance = random.Random(51000 + seed)
    kind, turn = list(KINDS)[seed % len(KINDS)], seed // len(KINDS)
    return KINDS[kind](chance, f'{kind} {seed}', 1 if turn % 5 in (1, 3) else 2, turn % 5 in (0, 3))
