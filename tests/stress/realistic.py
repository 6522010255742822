"""Scenes as people have them, meshed by gmsh: one seed, one scene.

Each is built together with the reason why it has a solution or has none: statics where bodies are
held by contact alone (force, tipping and torque in each joint), the fixed point of Coulomb friction
where supports hold every body. What is not certain is drawn again or changed until it is.
"""
import math

import numpy as np

import solids
from building import Building, Wrench, about, inside, rectangle

SAFE = 0.8     # share of the friction, or of the lever, that a scene with a solution uses at most
BEYOND = 1.15  # share that one without a solution uses at least
HELD = 'all bodies are held by supports or pressed between held ones: friction with bounded ' \
       'displacements always has a next state'
SEGMENTED = (('GTOS', '', False), ('GTOS', '', True), ('GTOS', 'SEGMent', False),
             ('GTOS', 'SEGMent', True))


def pressure(b):
    """A pressure that strains the softest body by 1e-5 to 1e-3."""
    return b.young*10.0**b.draw.uniform(-5.0, -3.0)


def floor(b, a, c, level=0.0, name='floor', depth=0.4, length=None):
    """A floor with its upper side at a level, rigid or elastic and clamped below."""
    rigid = b.chance(0.4)
    solid = solids.box((a, c, depth), length or b.draw.uniform(0.35, 0.6))
    part = b.add(name, solid, (0.0, 0.0, level - depth), rigid=rigid)
    if not rigid:
        b.hold(part, solid.plane(0, 0, -1))
    b.notes.append('rigid floor' if rigid else 'elastic floor')
    return part


def touching(b):
    """A gap between bodies that touch: mostly none, or so little that it is none."""
    return b.draw.choice((0.0, 0.0, 0.0, 1e-12, -1e-12, -1e-5))


def weigh(b, part, total, course=None, way=(0.0, 0.0, -1.0)):
    """Gives a body a weight: course(k) of it at the end of phase k. (total, where it acts)"""
    way = np.array(way, float)
    course = course or (lambda k: float(k > 0))
    b.load(part, part.solid.shares(), lambda k: total*course(k)*way)
    return total*way, part.solid.shares() @ part.x


# Stacks -------------------------------------------------------------------------------------------


def stack(seed):
    """2 to 6 blocks on each other under their weight and a load that may be tilted."""
    b = Building(seed, 'stack')
    draw = b.draw
    count = draw.randint(2, 6)
    base = floor(b, 2.4, 2.4)
    way = b.chance(0.25)
    p = pressure(b)
    sizes, blocks, joints = [], [], []
    size, middle, turn, level = (draw.uniform(0.9, 1.4), draw.uniform(0.9, 1.4)), np.zeros(2), 0.0, 0.0
    if b.chance(0.3):
        turn = draw.uniform(0, 90)
    for k in range(count):
        if k and b.chance(0.7):
            size = tuple(draw.uniform(0.75, 0.95)*s for s in size)
            room = min(old - new for old, new in zip(sizes[-1], size))/2
            middle = middle + np.array([draw.uniform(-1, 1), draw.uniform(-1, 1)])*room*0.5
            spin = math.degrees(0.4*room/max(size))
            turn += draw.uniform(-spin, spin)
        height = draw.uniform(0.25, 0.7)
        solid = solids.box((*size, height), draw.uniform(0.28, 0.5)).turned(about(2, turn))
        level += touching(b)
        block = b.add(f'block{k + 1}', solid, (*middle, level))
        blocks.append(block)
        sizes.append(size)
        polygon = rectangle(*size, turn, middle)
        below = blocks[k - 1] if k else base
        mu = b.pair((block, solid.plane(0, 0, -1)), (below, below.solid.plane(0, 0, 1)))
        joints.append((level, polygon, mu))
        level += height
    if way:
        return stack_by_way(b, blocks, level)
    for _ in range(draw.choice((1, 1, 2))):
        b.phase()
    return stack_by_force(b, blocks, joints, p)


def stack_by_way(b, blocks, level):
    """The top is pressed down and shifted."""
    draw = b.draw
    press, shear = b.phase(), b.phase(4)
    top = blocks[-1]
    deep = level*10.0**draw.uniform(-4.5, -3.0)
    angle, far = draw.uniform(0, 2*math.pi), deep*draw.uniform(0.1, 3.0)
    shift = far*np.array([math.cos(angle), math.sin(angle), 0.0])

    def way(_, k):
        return np.array([0.0, 0.0, -deep])*(k >= press) + shift*(k >= shear)
    b.drive(top, top.solid.plane(0, 0, 1), way)
    return b.scene('solution', HELD + '; the blocks between are flat and pressed, the shift is small')


def stack_by_force(b, blocks, joints, p):
    """Weights and a dead load on top, tilted within friction, beyond it, or beyond tipping."""
    draw = b.draw
    last = len(b.times) - 1
    area = float(np.ptp(blocks[-1].x[:, 0])*np.ptp(blocks[-1].x[:, 1]))
    weights = [p*area*10.0**draw.uniform(-2, 0) if b.chance(0.7) else 0.0 for _ in blocks]
    load = p*area
    angle = draw.uniform(0, 2*math.pi)
    side = np.array([math.cos(angle), math.sin(angle), 0.0])
    top = blocks[-1]
    _, shares = top.solid.area_shares(top.solid.plane(0, 0, 1))
    at = shares @ top.x

    def use(tilt):
        """Largest share of friction, tipping lever and torque used in a joint."""
        worst_slide, worst_tip, least_slide = 0.0, 0.0, 0.0
        for k, (level, polygon, mu) in enumerate(joints):
            w = Wrench().add(load*(side*tilt - np.array([0.0, 0.0, 1.0])), at)
            for block, weight in zip(blocks[k:], weights[k:]):
                w.add((0.0, 0.0, -weight), block.solid.shares() @ block.x)
            place, ratio, torque = w.on_level(level)
            reach = inside(polygon, polygon.mean(axis=0))
            worst_slide = max(worst_slide, (ratio + torque/(0.15*reach))/mu[0])
            least_slide = max(least_slide, ratio/mu[1])
            worst_tip = max(worst_tip, 1.0 - inside(polygon, place)/reach)
        return worst_slide, worst_tip, least_slide
    wish, reason = 'solution', 'in each joint the resultant lies inside the face and the friction cone'
    kind = draw.random()
    tilt = 0.0 if kind < 0.3 else draw.uniform(0.05, 1.0)*min(mu[0] for _, _, mu in joints)
    if kind > 0.82:
        wish, reason, tilt = beyond(use, kind > 0.94)
    else:
        while max(use(tilt)[:2]) > SAFE:
            assert tilt > 1e-9, 'this stack does not stand'
            tilt = tilt/2 if tilt > 1e-3 else 0.0
    upright = lambda k: np.array([0.0, 0.0, -load])*(k > 0)
    if last == 1:
        b.load(top, shares, lambda k: (k > 0)*load*(tilt*side - np.array([0.0, 0.0, 1.0])))
    else:
        b.load(top, shares, lambda k: upright(k) + load*tilt*side*(k == last))
    for block, weight in zip(blocks, weights):
        if weight:
            weigh(b, block, weight)
    b.bound = 0.05
    b.notes.append(f'tilt {tilt:.3g} use {use(tilt)[0]:.2f}/{use(tilt)[1]:.2f}')
    return b.scene(wish, reason)


def beyond(use, tips):
    """A tilt at which a joint slides, or tips before any slides."""
    for tilt in np.geomspace(0.02, 20.0, 60):
        slide, tip, sure = use(tilt)
        if tips and tip > BEYOND and slide < 0.9:
            return 'none: tips', f'the resultant leaves a face ({tip:.2f} of its half), friction ' \
                f'would hold ({slide:.2f})', tilt
        if not tips and sure > BEYOND and tip < SAFE:
            return 'none: slides', f'a joint has to carry {sure:.2f} times its friction', tilt
    tilt = next(t for t in np.geomspace(0.02, 200.0, 200) if max(use(t)[2], use(t)[1]) > BEYOND)
    slide, tip, sure = use(tilt)
    return 'none: slides or tips', f'a joint has to carry {sure:.2f} times its friction, its ' \
        f'resultant lies at {tip:.2f} of its half face', tilt


def cubes(seed):
    """2 x 2 x 2 or 3 x 3 x 3 cubes that touch exactly, under their weights."""
    b = Building(seed, 'cubes')
    draw = b.draw
    n = draw.choice((2, 3, 3))
    base = floor(b, n + 0.6, n + 0.6, length=draw.uniform(0.6, 0.9))
    p = pressure(b)
    same = b.young_of(2.0) if b.chance(0.5) else None
    steps = [draw.uniform(0.35, 0.6) for _ in range(3)] if n == 2 else [0.6, 0.8, 1.0]
    kinds = [solids.box((1.0, 1.0, 1.0), s) for s in steps]
    whole = []
    for i in range(n**3):
        place = (i % n - (n - 1)/2, i//n % n - (n - 1)/2, i//n**2)
        block = b.add(f'cube{i + 1}', draw.choice(kinds), place, young=same)
        whole.append((place, block))
    b.phase(2)
    total = np.zeros(3)
    for place, block in whole:
        total = total + weigh(b, block, p*draw.uniform(0.2, 1.0))[0]
        for axis in range(3):
            low, high = np.zeros(3), np.zeros(3)
            low[axis], high[axis] = -1.0, 1.0
            far = (n - 1)/2 if axis < 2 else n - 1
            if abs(place[axis] + (far if axis < 2 else 0.0)) > 1e-9:
                b.surface(block, block.solid.plane(*low), f'low{axis + 1}')
            if abs(place[axis] - far) > 1e-9:
                b.surface(block, block.solid.plane(*high), f'high{axis + 1}')
        if place[2] == 0.0:
            b.surface(block, block.solid.plane(0, 0, -1), 'soles')
    for axis in range(3):
        b.pair((None, f'low{axis + 1}'), (None, f'high{axis + 1}'), kind='coulomb',
               label=f'joints{axis + 1}')
    b.pair((None, 'soles'), (base, base.solid.plane(0, 0, 1)), label='ground')
    b.bound = 0.02
    scene = b.scene('solution', 'each column stands by itself under a central weight; the joints '
                    'between columns carry what bulging presses')
    loads = [item[3] for item in scene.balance]
    elastic = [part for part in b.parts if part.elastic]
    free = [k for k, part in enumerate(elastic) if part is not base]
    scene.balance = [('all cubes', [], {'ground': 1},
                      lambda t: tuple(np.sum([loads[k](t) for k in free], axis=0)))]
    moments = scene.moments
    scene.moments = [lambda t: tuple(np.sum([moments[k](t) for k in free], axis=0))]
    scene.inside = [f'joints{axis}' for axis in (1, 2, 3)]
    return scene


# One body on a plane ------------------------------------------------------------------------------


def sole_body(b):
    """A body with a flat sole around the origin: (solid, convex polygon of its sole)."""
    draw = b.draw
    kind = draw.choice(('box', 'box', 'cylinder', 'ring', 'prism'))
    if kind == 'box':
        size = (draw.uniform(0.6, 1.2), draw.uniform(0.6, 1.2), draw.uniform(0.2, 1.2))
        return solids.box(size, draw.uniform(0.15, 0.3)), rectangle(*size[:2])
    if kind == 'prism':
        a, high, width = draw.uniform(0.7, 1.2), draw.uniform(0.3, 0.8), draw.uniform(0.6, 1.0)
        roof = draw.uniform(-0.2, 0.2)
        solid = solids.prism([(-a/2, 0.0), (a/2, 0.0), (roof + 0.1, high), (roof - 0.1, high)],
                             width, draw.uniform(0.15, 0.25))
        return solid, rectangle(a, width)
    radius, height = draw.uniform(0.4, 0.7), draw.uniform(0.2, 1.2)
    if kind == 'cylinder':
        solid = solids.cylinder(radius, height, draw.uniform(0.15, 0.25))
    else:
        solid = solids.ring(radius, radius*draw.uniform(0.5, 0.75), min(height, 0.5),
                            draw.uniform(0.12, 0.2))
    # The corners of the mesh, not the circle: at least a hexagon lies within.
    turn = np.radians(np.arange(0, 360, 30))
    return solid, radius*0.96*np.column_stack([np.cos(turn), np.sin(turn)])


def slope(seed):
    """A body under its weight on a slope: it sticks, slides or tips."""
    b = Building(seed, 'slope')
    draw = b.draw
    base = floor(b, 2.6, 2.6)
    solid, polygon = sole_body(b)
    turn = draw.uniform(0, 360)
    solid, polygon = solid.turned(about(2, turn)), polygon @ about(2, turn)[:2, :2].T
    kind = draw.choice(('below', 'below', 'below', 'level', 'slides', 'tips'))
    mu = math.exp(draw.uniform(math.log(1.0), math.log(2.0))) if kind == 'tips' else None
    body = b.add('body', solid, (0.0, 0.0, touching(b)))
    least, most = b.pair((body, solid.plane(0, 0, -1)), (base, base.solid.plane(0, 0, 1)), mu=mu,
                         kind='coulomb' if kind == 'tips' else None)
    b.phase(4)
    center = solid.centroid()
    angle = draw.uniform(0, 2*math.pi)
    side = np.array([math.cos(angle), math.sin(angle)])
    lever = ray(polygon, center[:2], side)/center[2]  # tan of the angle at which it tips
    tilt = 0.0
    wish = 'solution'
    if kind == 'below':
        tilt = draw.uniform(0.1, 0.95)*min(least, SAFE*lever)
        reason = f'tan of the slope {tilt:.3g}: below mu {least:.3g} and below {lever:.3g}, where it tips'
    elif kind == 'slides' or (kind == 'tips' and BEYOND*lever > 0.9*least):
        tilt = draw.uniform(1.05, 1.6)*most
        wish, reason = 'none: slides', f'tan of the slope {tilt:.3g} is above mu {most:.3g}'
        if tilt > SAFE*lever:
            wish, reason = 'none: slides or tips', reason + f'; it would tip from {lever:.3g} on'
    elif kind == 'tips':
        tilt = min(draw.uniform(BEYOND, 1.5)*lever, 0.95*least)
        wish, reason = 'none: tips', f'tan of the slope {tilt:.3g} is above {lever:.3g}, where it tips'
    else:
        reason = 'the weight acts inside the sole'
    a = math.atan(tilt)
    weight = pressure(b)*0.5
    way = np.array([*(math.sin(a)*side), -math.cos(a)])
    weigh(b, body, weight, (lambda k: 1.0) if b.chance(0.3) else None, way)
    b.bound = 0.05
    b.notes.append(f'slope {math.degrees(a):.2f} degrees')
    return b.scene(wish, reason)


def ray(polygon, start, way):
    """Distance from a point inside a polygon to its rim in a direction."""
    least = math.inf
    for p, q in zip(polygon, np.roll(polygon, -1, axis=0)):
        d = q - p
        out = np.array([d[1], -d[0]])
        speed = out @ way
        if speed > 1e-12:
            least = min(least, out @ (p - start)/speed)
    return least


def push(seed):
    """A body under its weight that is pushed, pulled back, turned or lifted by dead loads."""
    b = Building(seed, 'push')
    draw = b.draw
    base = floor(b, 2.6, 2.6)
    solid, polygon = sole_body(b)
    kind = draw.choice(('push', 'push', 'reverse', 'turn', 'lift', 'beyond', 'spin', 'off',
                        'frictionless'))
    body = b.add('body', solid, (0.0, 0.0, touching(b)))
    mu = 0.0 if kind == 'frictionless' else None
    least, most = b.pair((body, solid.plane(0, 0, -1)), (base, base.solid.plane(0, 0, 1)), mu=mu,
                         kind='coulomb' if kind == 'frictionless' else None)
    press = b.phase(2)
    weight = pressure(b)*0.5
    center = solid.centroid()
    angle = draw.uniform(0, 2*math.pi)
    side = np.array([math.cos(angle), math.sin(angle), 0.0])
    lever = ray(polygon, center[:2], side[:2])/center[2]
    down = np.array([0.0, 0.0, -weight])
    reach = float(np.linalg.norm(solid.points[np.unique(solid.plane(0, 0, -1))][:, :2]
                                 - center[:2], axis=1).max())
    wish = 'solution'
    part = 0.0
    if kind in ('push', 'reverse'):
        back = ray(polygon, center[:2], -side[:2])/center[2]
        part = draw.uniform(0.2, 0.95)*min(least, SAFE*min(lever, back))
        reason = f'pushed with {part:.3g} of the weight: below mu {least:.3g} and below tipping'
    elif kind == 'beyond':
        part = draw.uniform(1.1, 1.6)*most
        wish, reason = 'none: slides', f'pushed with {part:.3g} of its weight, friction {most:.3g}'
        if part > SAFE*lever:
            wish = 'none: slides or tips'
    elif kind == 'lift':
        part = draw.uniform(0.3, 0.9)
        reason = f'{part:.2f} of the weight is lifted, the rest presses inside the sole'
    elif kind == 'off':
        part = draw.uniform(1.1, 2.0)
        wish, reason = 'none: lifts', f'lifted with {part:.2f} times the weight'
    elif kind == 'turn':
        part = draw.uniform(0.2, 0.9)*0.15*least*reach
        reason = 'the torque is below mu W times 0.15 of the reach of the sole, a pressure inside it holds it'
    elif kind == 'spin':
        part = draw.uniform(BEYOND, 1.6)*most*reach
        wish, reason = 'none: turns', f'the torque over the weight, {part:.3g}, is above mu times ' \
            f'the farthest point of the sole, {most*reach:.3g}'
    else:
        wish, reason = 'named: unrestrained', 'the weight is carried, but without friction nothing ' \
            'resists motions along the floor: the place is one of many'
    if kind == 'frictionless':
        weigh(b, body, weight)
        return b.scene(wish, reason)
    last = b.phase(4)
    backs = b.phase(4) if kind == 'reverse' else 0
    sign = lambda k: -1.0 if backs and k == backs else 1.0 if k >= last else 0.0
    if kind in ('turn', 'spin'):
        twist(b, body, solid, lambda k: weight*part*sign(k))
        b.load(body, solid.shares(), lambda k: down*(k >= press))
    elif kind in ('lift', 'off'):
        b.load(body, solid.shares(), lambda k: down*((k >= press) - part*sign(k)))
    else:
        b.load(body, solid.shares(), lambda k: down*(k >= press) + weight*part*sign(k)*side)
    b.bound = 0.05
    b.notes.append(f'{kind} {part:.3g}')
    return b.scene(wish, reason)


def twist(b, body, solid, torque):
    """A torque about the upright through the centre of gravity, as body forces."""
    shares, center = solid.shares(), solid.centroid()
    arms = solid.points - center
    arms[:, 2] = 0.0
    inertia = shares @ (arms**2).sum(axis=1)
    for n, (share, arm) in enumerate(zip(shares, arms)):
        force = share*np.array([-arm[1], arm[0], 0.0])/inertia
        only = np.zeros(len(shares))
        only[n] = 1.0
        b.load(body, only, lambda k, f=force: f*torque(k))
    residual = sum((shares[n]*np.array([-a[1], a[0], 0.0]) for n, a in enumerate(arms)), np.zeros(3))
    assert np.abs(residual).max() < 1e-10


def wedge(seed):
    """A body with an inclined sole on a wedge that rests on the floor."""
    b = Building(seed, 'wedge')
    draw = b.draw
    base = floor(b, 3.0, 2.4)
    slides = b.chance(0.2)
    mu1, mu2 = b.friction(0.1, 1.0), b.friction(0.1, 2.0)
    rise = draw.uniform(1.1, 1.5)*mu2 if slides else draw.uniform(0.2, 0.9)*mu2
    rise = min(rise, 0.9)
    slides = slides and rise > 1.08*mu2
    if not slides:
        rise = min(rise, 0.9*mu2)  # a slide that the greatest rise has stopped
    long, low, width = 1.4, 0.3, draw.uniform(0.8, 1.2)
    lower = solids.prism([(-long/2, 0.0), (long/2, 0.0), (long/2, low + rise*long), (-long/2, low)],
                         width, draw.uniform(0.25, 0.35))
    under = b.add('wedge', lower, (0.0, 0.0, touching(b)))
    a, part = draw.uniform(0.6, 1.0), draw.uniform(0.6, 1.0)
    middle = draw.uniform(-1, 1)*(long - a)/2*0.8
    z = [low + rise*(long/2 + x) for x in (middle - a/2, middle + a/2)]
    top = z[1] + draw.uniform(0.15, 0.4)
    upper = solids.prism([(middle - a/2, z[0]), (middle + a/2, z[1]), (middle + a/2, top),
                          (middle - a/2, top)], width*part, draw.uniform(0.2, 0.3))
    over = b.add('rider', upper, (0.0, 0.0, touching(b)))
    normal = np.array([-rise, 0.0, 1.0])
    b.pair((over, upper.plane(*-normal)), (under, lower.plane(*normal)), kind='coulomb', mu=mu2)
    b.pair((under, lower.plane(0, 0, -1)), (base, base.solid.plane(0, 0, 1)), kind='coulomb', mu=mu1)
    b.phase(3)
    p = pressure(b)
    weigh(b, over, 0.3*p*draw.uniform(0.1, 1.0))
    weigh(b, under, 0.3*p*draw.uniform(0.1, 1.0))
    shares = upper.area_shares(upper.plane(0, 0, 1))[1]
    b.load(over, shares, lambda k: np.array([0.0, 0.0, -p*a*width*part])*(k > 0))
    # The roof's middle and the centre of gravity lie above the inclined face; all is upright below.
    b.bound = 0.05
    b.notes.append(f'rise {rise:.3g} mu {mu2:.3g}')
    if slides:
        return b.scene('none: slides', f'the incline {rise:.3g} is above mu {mu2:.3g}, nothing else '
                       'holds the rider')
    return b.scene('solution', f'the incline {rise:.3g} is below mu {mu2:.3g}, all loads are upright '
                   'and act inside the faces')


# Bodies that roll ---------------------------------------------------------------------------------


def groove(seed):
    """A ball, cylinder, wedge or bar in a groove, under its weight or below a plate."""
    kind = np.random.default_rng(seed).choice(('ball', 'cylinder', 'cylinder', 'wedge'))
    b = Building(seed, 'groove', SEGMENTED if kind == 'ball' else Building.__init__.__defaults__[0])
    draw = b.draw
    half = draw.uniform(35, 60)  # degrees between a wall and the upright
    wall = 1.0/math.tan(math.radians(half))
    deep, rim, width = 0.6, 0.25, 1.6
    span = deep/wall
    base = solids.prism([(-span - rim, -0.4), (span + rim, -0.4), (span + rim, deep), (span, deep),
                         (0.0, 0.0), (-span, deep), (-span - rim, deep)], width,
                        draw.uniform(0.2, 0.3))
    rigid = b.chance(0.3)
    ground = b.add('groove', base, rigid=rigid)
    b.hold(ground, base.plane(0, 0, -1))
    walls = [np.array([s*wall, 0.0, 1.0])/math.hypot(wall, 1.0) for s in (1.0, -1.0)]
    flat = np.vstack([base.plane(*n) for n in walls])
    tilted = False
    if kind == 'wedge':
        high = draw.uniform(0.3, 0.5)
        low = draw.uniform(0.1, 0.2)
        solid = solids.prism([(-low/wall, low), (low/wall, low), (high/wall, high), (high/wall, high + 0.2),
                              (-high/wall, high + 0.2), (-high/wall, high)], draw.uniform(0.5, 1.2),
                             draw.uniform(0.15, 0.25))
        sole = np.vstack([solid.plane(*-n) for n in walls])
        place = np.zeros(3)
        tilted = b.chance(0.5)
    else:
        radius = draw.uniform(0.25, 0.38)
        if kind == 'ball':
            solid = solids.ball(radius, radius/6)
        else:
            solid = solids.cylinder(radius, draw.uniform(0.5, 1.1), radius/6)
            solid = solid.turned(about(0, 90))
            solid.points[:, 1] -= solid.points[:, 1].mean()
            tilted = b.chance(0.3)
        sole = solid.curved()
        # Both walls are touched: n . (x + place) = 0 for the nearest node of each.
        least = [(solid.points @ n).min() for n in walls]
        place = np.linalg.solve(np.array([[n[0], n[2]] for n in walls]), -np.array(least))
        place = np.array([place[0], 0.0, place[1]])
    body = b.add(kind, solid, place)
    mu = b.friction(0.1, 0.4)
    least, most = b.pair((body, sole), (ground, flat), kind='coulomb', mu=mu)
    b.bound = 0.2
    b.notes.append(f'{kind}, {half:.0f} degrees')
    plate_above = kind != 'wedge' and b.chance(0.5)
    if plate_above:
        return groove_plate(b, body, solid, place, radius)
    b.phase(3)
    weight = pressure(b)*0.1
    sine = math.sin(math.radians(half))
    along, wish = 0.0, 'solution'
    reason = 'pressed into the groove by its weight: it runs against two walls, friction holds the rest'
    if tilted and b.chance(0.7):
        along = draw.uniform(0.1, 0.7)*least
        reason = f'along the groove it is pulled by {along:.3g} of the weight, the walls hold more ' \
                 f'than {least/sine:.3g} of it'
    elif tilted:
        along = draw.uniform(1.1, 1.5)*most/(sine - most*math.cos(math.radians(half)))
        wish, reason = 'none: slides', f'along the groove it is pulled by {along:.3g} of the weight, ' \
            f'with friction across the walls they hold less'
    # The pull acts at the height of the walls' forces, so that nothing tips.
    shares = solid.shares()
    if along:
        b.notes.append(f'pulled by {along:.3g}')
    b.load(body, shares, lambda k: weight*np.array([0.0, 0.0, -1.0])*(k > 0))
    if along:
        only = solid.area_shares(sole if kind == 'wedge' else touched(solid, sole, walls))[1]
        b.load(body, only, lambda k: weight*along*np.array([0.0, 1.0, 0.0])*(k > 0))
    return b.scene(wish, reason)


def touched(solid, sole, walls):
    """Triangles of the sole that lie nearest to the walls."""
    centers = solid.points[sole].mean(axis=1)
    near = np.zeros(len(sole), bool)
    for n in walls:
        height = centers @ n
        near |= height < height.min() + 0.02*np.ptp(height)
    return sole[near]


def indent(b):
    """How deep a round body of facets radius/6 is pressed, over its radius, so that it touches on
    both sides: quadrature points lie radius/216 above the corners of the facets."""
    return 10.0**(b.draw.uniform(-2.3, -1.6) if b.form[0] == 'NTOS' else b.draw.uniform(-1.7, -1.4))


def groove_plate(b, body, solid, place, radius):
    """A plate above presses the body into the groove by way."""
    draw = b.draw
    top = body.x[:, 2].max()
    size = (1.0, 1.2, 0.25)
    gap = draw.choice((0.0, 0.0, draw.uniform(0.0, 0.01)))
    plate_solid = solids.box(size, draw.uniform(0.25, 0.35))
    plate = b.add('plate', plate_solid, (place[0], place[1], top + gap), rigid=b.chance(0.3))
    b.pair((body, solid.curved()), (plate, plate_solid.plane(0, 0, -1)), kind='coulomb')
    press = b.phase(1)
    deep = gap + radius*indent(b)
    b.drive(plate, plate_solid.plane(0, 0, 1), lambda _, k: (0.0, 0.0, -deep*(k >= press)))
    return b.scene('solution', 'pressed by a plate against two walls: three contacts with friction '
                   'hold the body')


def between(seed):
    """A roller, a ring or a ball between two plates; the upper one presses, then moves aside."""
    kind = np.random.default_rng(seed).choice(('roller', 'ring', 'ring', 'ball', 'flat ring'))
    b = Building(seed, 'between', SEGMENTED if kind == 'ball' else Building.__init__.__defaults__[0])
    draw = b.draw
    radius = draw.uniform(0.35, 0.5)
    if kind == 'roller':
        solid = solids.cylinder(radius, draw.uniform(0.6, 1.2), radius/6).turned(about(0, 90))
    elif kind == 'ring':
        solid = solids.ring(radius, radius*draw.uniform(0.6, 0.8), draw.uniform(0.5, 0.9),
                            radius/6).turned(about(0, 90))
    elif kind == 'ball':
        solid = solids.ball(radius, radius/6)
    else:
        solid = solids.ring(radius, radius*draw.uniform(0.5, 0.8), draw.uniform(0.15, 0.4), radius/4)
    solid.points[:, 1] -= solid.points[:, 1].mean()
    gap = 0.0 if b.chance(0.6) else draw.uniform(0.0, 0.01)
    base = floor(b, 1.8, 1.8)
    place = (0.0, 0.0, -solid.points[:, 2].min() + touching(b))
    body = b.add('roller', solid, place)
    size = (1.4, 1.5, 0.3)
    plate_solid = solids.box(size, draw.uniform(0.3, 0.4))
    top = body.x[:, 2].max() + gap
    plate = b.add('plate', plate_solid, (0.0, 0.0, top), rigid=b.chance(0.3))
    if kind == 'flat ring':
        low, high = solid.plane(0, 0, -1), solid.plane(0, 0, 1)
    else:
        skin = solid.curved(inside=False) if kind == 'ring' else solid.curved()
        heights = solid.points[skin].mean(axis=1)[:, 2]
        low, high = skin[heights < 0.0], skin[heights > 0.0]
    b.pair((body, low), (base, base.solid.plane(0, 0, 1)), mu=b.friction(0.1))
    b.pair((body, high), (plate, plate_solid.plane(0, 0, -1)), mu=b.friction(0.1))
    press = b.phase(1 if gap or kind != 'flat ring' else 2)  # before it touches nothing holds the body
    strain = indent(b) if kind != 'flat ring' else 10.0**draw.uniform(-4.5, -3)
    deep = gap + strain*radius
    shear = b.phase(4) if b.chance(0.5) else 99
    back = b.phase(4) if shear < 99 and b.chance(0.5) else 99
    far = 0.5*strain*radius*draw.uniform(0.2, 2.0)
    angle = draw.uniform(0, 2*math.pi)
    side = far*np.array([math.cos(angle), math.sin(angle), 0.0])

    def way(_, k):
        return np.array([0.0, 0.0, -deep*(k >= press)]) + side*(shear <= k < back)
    b.drive(plate, plate_solid.plane(0, 0, 1), way)
    b.bound = 0.2
    b.notes.append(f'{kind}, strain {strain:.2g}' + (f', gap {gap:.2g}' if gap else ''))
    return b.scene('solution', 'pressed between two plates, both held: friction on both sides holds '
                   'the body in every motion')


# Bodies driven by way -----------------------------------------------------------------------------


def punch(seed):
    """A punch that touches first within a large step, and then slides, turns, lifts, returns."""
    b = Building(seed, 'punch')
    draw = b.draw
    kind = draw.choice(('box', 'cylinder', 'dome', 'dome', 'wedge', 'ring'))
    if kind == 'box':
        solid = solids.box((draw.uniform(0.5, 1.0), draw.uniform(0.5, 1.0), 0.6), draw.uniform(0.15, 0.25))
        sole = solid.plane(0, 0, -1)
    elif kind == 'cylinder':
        solid = solids.cylinder(draw.uniform(0.3, 0.5), 0.6, draw.uniform(0.12, 0.2))
        sole = solid.plane(0, 0, -1)
    elif kind == 'ring':
        solid = solids.ring(0.5, draw.uniform(0.25, 0.4), 0.4, draw.uniform(0.1, 0.15))
        sole = solid.plane(0, 0, -1)
    elif kind == 'wedge':
        solid = solids.prism([(-0.5, 0.2), (0.0, 0.0), (0.5, 0.2), (0.5, 0.6), (-0.5, 0.6)], 0.8,
                             draw.uniform(0.15, 0.22))
        sole = np.vstack([solid.plane(-0.2, 0, -0.5), solid.plane(0.2, 0, -0.5)])
    else:
        solid = solids.dome(0.6, draw.uniform(0.12, 0.18))
        sole = solid.curved()
    base = floor(b, 2.2, 2.2, length=draw.uniform(0.25, 0.4), depth=0.5)
    gap = draw.choice((0.0, draw.uniform(0.0, 0.02), draw.uniform(0.0, 0.1)))
    tool = b.add('punch', solid, (0.0, 0.0, gap - solid.points[:, 2].min()),
                 rigid=base.elastic and b.chance(0.2))
    swap = b.chance(0.2) and kind != 'dome'
    none = b.chance(0.15)
    b.pair((tool, sole), (base, base.solid.plane(0, 0, 1)), swap=swap, mu=0.0 if none else None,
           kind='coulomb' if none or kind in ('dome', 'wedge') else None)
    sharp = kind in ('dome', 'wedge')
    deep = 10.0**draw.uniform(-3.0, -2.0) if sharp else 10.0**draw.uniform(-4.0, -2.7)
    state, course = np.zeros(4), [np.zeros(4)]
    words = ['press'] + [draw.choice(('slide', 'slide', 'twist', 'press', 'back', 'lift', 'return'))
                         for _ in range(draw.randint(0, 3))]
    for word in words:
        if word in ('press', 'return'):
            state[2] = -gap - deep*(1.0 if state[2] >= -gap else 1.3)
            state[:2] *= word == 'press'
        elif word == 'slide':
            angle, far = draw.uniform(0, 2*math.pi), 10.0**draw.uniform(-3, -1)
            state[:2] += far*np.array([math.cos(angle), math.sin(angle)])
        elif word == 'twist':
            state[3] += draw.uniform(-0.03, 0.03)
        elif word == 'back':
            state[:2] = 0.0
        else:
            state[2] = 0.01
        course.append(state.copy())
        b.phase(2 if word in ('press', 'lift', 'return') else 5)

    def way(x, k):
        turn = course[k][3]
        return np.array([course[k][0] - turn*x[1], course[k][1] + turn*x[0], course[k][2]])
    b.drive(tool, solid.plane(0, 0, 1), way)
    b.bound = 0.05
    b.notes.append(f'{kind}, gap {gap:.2g}, {"-".join(words)}, deep {deep:.2g}')
    return b.scene('solution', HELD)


def pin(seed):
    """A pin in the bore of a plate: loose or tight, pulled by way, by force along a guide, turned."""
    b = Building(seed, 'pin')
    draw = b.draw
    radius, thick = draw.uniform(0.3, 0.45), draw.uniform(0.3, 0.6)
    length = radius/draw.uniform(2.5, 4.0)
    plate_solid = solids.bored_plate((1.6, 1.6, thick), radius, length)
    plate = b.add('plate', plate_solid, young=b.young_of())
    outer = np.vstack([plate_solid.plane(-1, 0, 0), plate_solid.plane(1, 0, 0),
                       plate_solid.plane(0, -1, 0)])
    b.hold(plate, outer)
    play = radius*draw.choice((draw.uniform(0.002, 0.02), draw.uniform(0.002, 0.02), -0.002, 0.0))
    out = draw.uniform(0.05, 0.15)
    pin_solid = solids.cylinder(radius - play, thick + 2*out, length*draw.uniform(0.7, 1.1))
    pin_solid = pin_solid.turned(about(2, draw.uniform(0, 360)))
    body = b.add('pin', pin_solid, (0.0, 0.0, -out), rigid=b.chance(0.2))
    b.pair((body, pin_solid.curved()), (plate, plate_solid.curved()), swap=b.chance(0.2),
           kind='coulomb')
    ends = np.vstack([pin_solid.plane(0, 0, 1), pin_solid.plane(0, 0, -1)])
    seat, last = b.phase(2), b.phase(3)
    back = b.phase(3) if b.chance(0.4) else 99
    turn = draw.choice((0.0, 0.0, draw.uniform(-0.03, 0.03)))
    push_out = draw.choice((0.0, 0.0, draw.uniform(-0.01, 0.01)))
    strain = 10.0**draw.uniform(-3.0, -2.0)
    far = max(play, 0.0) + strain*radius
    angle = draw.uniform(0, 2*math.pi)
    side = np.array([math.cos(angle), math.sin(angle), 0.0])

    def way(x, k):
        u = far*side*(k >= seat)
        if last <= k < back:
            u = u + np.array([-turn*x[1], turn*x[0], push_out])
        return u - 2.0*far*side*(k >= back)
    b.drive(body, ends, way)
    b.bound = 0.05
    b.notes.append(f'play {play/radius:.2g} r, turn {turn:.2g}, out {push_out:.2g}')
    return b.scene('solution', HELD)


def strut(seed):
    """A loose bar, ring or cylinder that stands between two held plates which press and twist it."""
    b = Building(seed, 'strut')
    draw = b.draw
    solid, _ = sole_body(b)
    while not any(n is not None and n[2] > 0.99 for _, n, _ in solid.faces):
        solid, _ = sole_body(b)
    base = floor(b, 2.4, 2.4)
    body = b.add('strut', solid, (0.0, 0.0, touching(b)))
    gap = draw.choice((0.0, 0.0, draw.uniform(0.0, 0.01)))
    top = body.x[:, 2].max() + gap
    plate_solid = solids.box((1.8, 1.8, 0.3), draw.uniform(0.35, 0.5))
    plate = b.add('plate', plate_solid, (0.0, 0.0, top), rigid=b.chance(0.4))
    b.pair((body, solid.plane(0, 0, -1)), (base, base.solid.plane(0, 0, 1)))
    b.pair((body, solid.plane(0, 0, 1)), (plate, plate_solid.plane(0, 0, -1)))
    press, turned = b.phase(1 if gap else 2), b.phase(4)
    deep = gap + (top - gap)*10.0**draw.uniform(-4.5, -3.0)
    angle = (deep - gap)*draw.uniform(-2.0, 2.0)
    shift = (deep - gap)*draw.uniform(-1.0, 1.0)

    def way(x, k):
        return np.array([0.0, 0.0, -deep*(k >= press)]) + \
            np.array([shift - angle*x[1], angle*x[0], 0.0])*(k >= turned)
    b.drive(plate, plate_solid.plane(0, 0, 1), way)
    b.bound = 0.1
    b.notes.append(f'gap {gap:.2g}')
    return b.scene('solution', HELD + '; the strut is wide and the shift is small')


FAMILIES = {'stack': stack, 'cubes': cubes, 'slope': slope, 'push': push, 'wedge': wedge,
            'groove': groove, 'between': between, 'punch': punch, 'pin': pin, 'strut': strut}
# How often each of them is drawn.
TURNS = ('stack', 'slope', 'push', 'between', 'stack', 'punch', 'groove', 'pin', 'wedge', 'stack',
         'slope', 'strut', 'between', 'punch', 'push', 'pin', 'groove', 'stack', 'wedge', 'cubes')


def realistic_scene(seed):
    """The scene of a seed."""
    return FAMILIES[TURNS[seed % len(TURNS)]](seed)
