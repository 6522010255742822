"""Fixed cases of bodies that contact alone holds, and of elements with all nodes prescribed: each
with its closed form from statics."""
import math

from scene import Deck, Body, Scene, number
from outcome import imbalance

FORMS = (('NTOS', '', False), ('GTOS', '', False), ('GTOS', 'SEGMent', False),
         ('NTOS', '', True), ('GTOS', '', True), ('GTOS', 'SEGMent', True))
YOUNG = 1e7
SLIDES = r'slid|glid|friction does not (carry|hold)'


class Case:
    """One or more decks, and what their outcomes must come to."""

    def __init__(self, name, scenes, judge, wanted, says=''):
        self.name, self.scenes, self.judge, self.wanted, self.says = name, scenes, judge, wanted, says


def word_of(form):
    """How a form is called in the name of a case."""
    return (form[1][:4].upper() or form[0]) + (' AUGM' if form[2] else '')


def exact(form, wanted):
    """What may be asked of a form: with multipliers the tolerance of their updates."""
    return 1e-6 if form[2] else wanted


def placed(turn, shift, unit):
    """Shape of a body whose axes are turned about y by an angle [rad], moved, and scaled."""
    c, s = math.cos(turn), math.sin(turn)

    def shape(x, _):
        return [unit*(c*x[0] + s*x[2] + shift[0]), unit*(x[1] + shift[1]),
                unit*(-s*x[0] + c*x[2] + shift[2])]
    return shape


def stack(form, tilt=0.0, overlap=0.0, turn=0.0, shift=(0.0, 0.0, 0.0), unit=1.0, force=1.0,
          young=YOUNG):
    """Two blocks on a rigid floor under nodal weights and a load of their size that is tilted by
    an angle [degrees]; one increment. (scene, load on the joint, load on the floor)"""
    deck = Deck(f'two blocks on a floor, load tilted by {tilt} degrees')
    deck.form, deck.points = form[:2]
    steel = deck.elastic(young*force/unit**2, 0.3)
    shape = placed(turn, shift, unit)
    floor = Body(deck, 'floor', (4, 4, 1), (-0.8, -0.7, -0.3), (0.9, 0.8, 0.0), deck.rigid(), shape)
    lower = Body(deck, 'lower', (3, 3, 2), (-0.5, -0.5, -overlap), (0.5, 0.5, 0.3 - overlap), steel,
                 shape)
    upper = Body(deck, 'upper', (2, 3, 2), (-0.45, -0.44, 0.3 - 2*overlap),
                 (0.43, 0.45, 0.6 - 2*overlap), steel, shape)
    weights = {}
    for body, density in ((lower, 30000.0), (upper, 25000.0)):
        for node, part in volumes(deck, body).items():
            weights[node] = [0.0, 0.0, -density*force*part/unit**3]
    a = math.radians(tilt)
    for node, part in upper.shares(-1).items():
        for m, way in enumerate((math.sin(a), 0.0, -math.cos(a))):
            weights[node][m] += 10000.0*force*part*way
    total = {lower: [0.0]*3, upper: [0.0]*3}
    for node, w in weights.items():
        w = spun(w, turn)
        body = upper if node >= upper.first else lower
        total[body] = [p + q for p, q in zip(total[body], w)]
        deck.force.append((node, w))
    joints(deck, form, ((lower, 0, floor), (upper, 0, lower)), 0.5)
    deck.steps(1.0, 1)
    scene = Scene(f'stack {word_of(form)}', deck, 'free', mus={'joint1': (0.5, 0.5), 'joint2': (0.5, 0.5)},
                  balance=[('lower', [], {'joint1': 1, 'joint2': -1}, lambda _: total[lower]),
                           ('upper', [], {'joint2': 1}, lambda _: total[upper])],
                  factor=unit*(1.0 + max(map(abs, shift))))
    scene.up = spun((0.0, 0.0, 1.0), turn)
    return scene


def spun(v, turn):
    """A vector in the axes of `placed`."""
    c, s = math.cos(turn), math.sin(turn)
    return [c*v[0] + s*v[2], v[1], -s*v[0] + c*v[2]]


def volumes(deck, body):
    """Quarters of the volumes of its tetrahedra at each node."""
    share = {}
    for _, nodes in deck.elements:
        if not body.first <= nodes[0] < body.first + grid(body):
            continue
        a, b, c, d = (deck.x[n - 1] for n in nodes)
        e = [[q[m] - a[m] for m in range(3)] for q in (b, c, d)]
        volume = abs(e[0][0]*(e[1][1]*e[2][2] - e[1][2]*e[2][1])
                     - e[0][1]*(e[1][0]*e[2][2] - e[1][2]*e[2][0])
                     + e[0][2]*(e[1][0]*e[2][1] - e[1][1]*e[2][0]))/6.0
        for n in nodes:
            share[n] = share.get(n, 0.0) + volume/4.0
    return share


def grid(body):
    """Number of nodes of a block."""
    return (body.cells[0] + 1)*(body.cells[1] + 1)*(body.cells[2] + 1)


def joints(deck, form, places, mu, penalty='AUTO 10'):
    """A pair for each (upper body, its layer, lower body)."""
    for k, (upper, layer, lower) in enumerate(places, 1):
        deck.surface(f'under{k}', upper.layer(layer))
        deck.surface(f'over{k}', lower.layer(-1))
        lines = [f'PENAlty {penalty}', f'FRICtion COULomb {number(mu)}'] + ['AUGMent']*form[2]
        deck.pair(f'joint{k}', f'under{k}', f'over{k}', lines)


def statics(scene):
    """Judge: imbalance of each body, which is all that statics asks."""
    return lambda outcomes: imbalance(outcomes[0], scene)[0]


def stacks():
    """Two blocks, all gaps zero, one increment, load tilted by 0 to 25 degrees; all forms."""
    for form in FORMS:
        for tilt in (0, 5, 10, 15, 20, 25):
            scene = stack(form, tilt)
            yield Case(f'stack {word_of(form)} {tilt} degrees', [scene], statics(scene),
                       exact(form, 1e-9))


def forces(outcome, up):
    """Normal forces and resultants of all pairs at the end, resultants along `up` and across."""
    values = []
    for label in ('joint1', 'joint2'):
        row = outcome.last('con', label)
        normal = sum(f*u for f, u in zip(row[5:8], up))
        across = math.dist(row[5:8], [normal*u for u in up])
        values += [row[3], normal, across]
    return values


def equal_forces(scenes, factors):
    """Judge: the forces of all decks are those of the first, times their unit of force."""
    def judge(outcomes):
        first = forces(outcomes[0], scenes[0].up)
        return max(abs(a/factor - b)/max(map(abs, first))
                   for scene, outcome, factor in zip(scenes[1:], outcomes[1:], factors)
                   for a, b in zip(forces(outcome, scene.up), first))
    return judge


def same_stacks():
    """An overlap of 1e-12 of the block, units, rotation and origin change no force."""
    for form in FORMS:
        word = word_of(form)
        for tilt in (0, 15):
            scenes = [stack(form, tilt, overlap) for overlap in (0.0, 1e-12, -1e-12)]
            yield Case(f'overlap 1e-12 {word} {tilt} degrees', scenes,
                       equal_forces(scenes, (1.0, 1.0)), exact(form, 1e-9))
        scenes, factors = [stack(form, 10)], []
        for unit, force in ((1e-3, 1.0), (1e3, 1.0), (1.0, 1e-6), (7.3e-4, 3.1e5)):
            scenes.append(stack(form, 10, unit=unit, force=force))
            factors.append(force)
        yield Case(f'units {word}', scenes, equal_forces(scenes, factors), exact(form, 1e-9))
        scenes = [stack(form, 10)] + [stack(form, 10, turn=turn) for turn in (0.3, 1.0, 2.5)]
        yield Case(f'rotation {word}', scenes, equal_forces(scenes, (1.0,)*3), exact(form, 1e-9))
        scenes = [stack(form, 10)] + [stack(form, 10, shift=shift) for shift in
                                      ((10.0, -3.0, 7.0), (100.0, 200.0, -50.0), (-1e3, 1e3, 1e3))]
        yield Case(f'origin {word}', scenes, equal_forces(scenes, (1.0,)*3), exact(form, 1e-9))


def slope(form, angle, mu=0.5, weight=1000.0):
    """A block under its weight on a slope; the slope is really inclined. (scene, up)"""
    deck = Deck(f'a block on a slope of {math.degrees(angle)} degrees')
    deck.form, deck.points = form[:2]
    shape = placed(angle, (0.3, 0.2, 0.1), 1.0)
    steel = deck.elastic(YOUNG, 0.3)
    floor = Body(deck, 'floor', (5, 4, 1), (-0.83, -0.7, -0.3), (0.92, 0.8, 0.0), deck.rigid(), shape)
    block = Body(deck, 'block', (3, 3, 2), (-0.5, -0.5, 0.0), (0.5, 0.5, 0.4), steel, shape)
    share = volumes(deck, block)
    whole = sum(share.values())
    for node, part in share.items():
        deck.force.append((node, (0.0, 0.0, -weight*part/whole)))
    joints(deck, form, ((block, 0, floor),), mu)
    deck.steps(1.0, 1)
    scene = Scene(f'slope {word_of(form)}', deck, 'free', mus={'joint1': (mu, mu)}, factor=1.0,
                  balance=[('block', [], {'joint1': 1}, lambda _: (0.0, 0.0, -weight))])
    scene.up = spun((0.0, 0.0, 1.0), angle)
    return scene


def slopes():
    """20 angles from 0 to 1.2 atan(mu): Fn = W cos a, Ft = W sin a; beyond atan(mu) it slides."""
    mu, weight = 0.5, 1000.0
    for form in FORMS:
        for k in range(20):
            angle = 1.2*math.atan(mu)*k/19
            scene = slope(form, angle, mu, weight)
            name = f'slope {word_of(form)} {math.degrees(angle):.2f} degrees'
            if math.tan(angle) > mu:
                yield Case(name, [scene], None, 0.0, SLIDES)
            else:
                yield Case(name, [scene], on_slope(scene, angle, weight), exact(form, 1e-9))


def on_slope(scene, angle, weight):
    """Judge: normal and tangential force of a block on a slope over its weight."""
    def judge(outcomes):
        row = outcomes[0].last('con', 'joint1')
        normal = sum(f*u for f, u in zip(row[5:8], scene.up))
        across = math.dist(row[5:8], [normal*u for u in scene.up])
        return max(abs(normal - weight*math.cos(angle)), abs(across - weight*math.sin(angle)),
                   abs(row[3] - weight*math.cos(angle)))/weight
    return judge


def driven(form, penalty, elastic, tangents, deep=1e-3, slip=5e-3, mu=0.3):
    """A block, all of its nodes prescribed, pressed into a base, all of its nodes held, and moved
    along it: N = penalty x depth x area, T = mu N."""
    deck = Deck(f'all nodes prescribed, penalty {penalty} E/h')
    deck.form, deck.points = form[:2]
    steel = deck.elastic(1000.0, 0.3)
    block = Body(deck, 'block', (2, 2, 1), (0.0, 0.0, 0.0), (1.0, 1.0, 0.5), steel)
    base = Body(deck, 'base', (3, 3, 1), (-0.3, -0.4, -0.5), (1.4, 1.3, 0.0),
                steel if elastic else deck.rigid())
    deck.set('driven', range(block.first, block.first + grid(block)))
    deck.fix('driven')
    if elastic:
        deck.set('held', range(base.first, base.first + grid(base)))
        deck.fix('held')
    press, slide = deck.table([(0, 0), (1, 1)]), deck.table([(1, 0), (2, 1)])
    deck.move('driven', (slip, 0.0, -deep), (slide, 0, press))
    joints(deck, form, ((block, 0, base),), mu, f'AREA {number(penalty*1000.0/0.5)}')
    deck.outputs = ['driven'] + ['held']*elastic
    if tangents:
        deck.batch = ['DT,,1', 'LOOP,,2', 'TIME', 'LOOP,,30', 'TANG,,1', 'NEXT', 'NEXT']
    else:
        deck.steps(2.0, 2)
    normal = penalty*1000.0/0.5*deep

    def judge(outcomes):
        worst = 0.0
        for (_, con), (_, rea), share in zip(outcomes[0].rows('con', 'joint1'),
                                             outcomes[0].rows('rea', 'driven'), (0.0, mu)):
            truth = (-share*normal, 0.0, normal)
            worst = max(worst, math.dist(con[5:8], truth), abs(con[3] - normal),
                        abs(con[4] - share*normal), math.dist(rea, [-f for f in truth]))
        return worst/normal if len(outcomes[0].con) == 2 else math.inf
    scene = Scene(f'prescribed {word_of(form)}', deck, 'free', mus={'joint1': (mu, mu)}, factor=1.0)
    return scene, judge


def prescribed():
    """Penalties from 1e-3 to 1e15 E/h where no degree of freedom is free."""
    for form in FORMS[:3]:
        for elastic in (False, True):
            for tangents in (False, True):
                for decade in range(-3, 16, 3):
                    scene, judge = driven(form, 10.0**decade, elastic, tangents)
                    yield Case(f'prescribed {word_of(form)} 1e{decade} '
                               + ('elastic' if elastic else 'rigid') + (' TANG' if tangents else ''),
                               [scene], judge, 1e-10)


def all_free():
    """Every case of this file."""
    for family in (stacks, same_stacks, slopes, prescribed):
        yield from family()


def quick_free():
    """A few of each kind."""
    for family, every in ((stacks, 7), (slopes, 11)):
        yield from [case for case in list(family())[2::every] if 'stack GTOS' not in case.name]
    yield from list(same_stacks())[:2]
    yield from [case for case in prescribed() if '1e0' in case.name][::2]


def free_scenes():
    """30 scenes with a free body for the comparison of the solvers."""
    for form in FORMS[:3]:
        for tilt in (0, 5, 10, 15, 20, 25):
            scene = stack(form, tilt)
            scene.name = f'free {scene.name} {tilt} degrees'
            yield scene
        for k in (0, 5, 10, 14):
            scene = slope(form, 1.2*math.atan(0.5)*k/19)
            scene.name = f'free {scene.name} {k}'
            yield scene
