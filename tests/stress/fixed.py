"""The scenes that are always run: extreme numbers, exact positions, exact references."""
import math

from scene import Deck, Body, Scene, number

YOUNG = 1000.0


class Cube:
    """The small sliding cube: a cube with its top prescribed, pressed and moved over a base."""

    def __init__(self, title, mu=(0.1, 0.1), phi=0.0, rule='COLLinear', penalty='AUTO 10',
                 poisson=0.3, rigid=True, n=2, base=(7, 5, 1), low=(-0.43, -0.37), high=(2.17, 1.43),
                 depth=0.005, path=((1.0, 0.6, 0.0),), presses=2, slides=8, length=1.0, force=1.0,
                 shift=(0.0, 0.0, 0.0), gap=0.0):
        self.mu, self.size, self.unit = mu, length, force
        deck = self.deck = Deck(title)
        stiff = force/length**2
        cube = deck.elastic(YOUNG*stiff, poisson)
        ground = deck.rigid() if rigid else deck.elastic(YOUNG*stiff, poisson)

        def scaled(x, _):
            return [length*x[m] + shift[m] for m in range(3)]

        def cube_scaled(x, unit):
            x = scaled(x, unit)
            return [x[0], x[1], x[2] + gap]

        self.cube = Body(deck, 'cube', (n, n, n), (0, 0, 0), (1, 1, 1), cube, cube_scaled)
        self.base = Body(deck, 'base', base, (*low, -0.4), (*high, 0.0), ground, scaled)
        deck.set('top', self.cube.layer(-1))
        deck.surface('sole', self.cube.layer(0))
        deck.surface('track', self.base.layer(-1))
        deck.fix('top')
        down = deck.table([(0, 0), (1, -1)])
        ways = [deck.table([(1, 0)] + [(1 + t, (x, y)[k]) for t, x, y in path]) for k in range(2)]
        deck.move('top', (length, length, depth*length), (*ways, down))
        deck.outputs = ['top']
        if not rigid:
            deck.set('ground', self.base.layer(0))
            deck.fix('ground')
            deck.outputs.append('ground')
        lines = [f'PENAlty {penalty}', f'FRICtion ELLIptic {number(mu[0])} {number(mu[1])}',
                 f'DIREction ANGLe {number(phi)} 1 0 0', f'SLIP {rule}']
        if mu == (0.0, 0.0):
            lines[1:] = ['FRICtion NONE']
        deck.pair('contact', 'sole', 'track', lines)
        deck.steps(1.0, presses)
        if slides:
            deck.steps(path[-1][0], slides)

    def scene(self, name, group, judge=None, wanted=0.0, stiff=0.0, **more):
        """The scene of this deck."""
        balance = [('cube', ['top'], {'contact': 1}, lambda _: (0.0, 0.0, 0.0))]
        if len(self.deck.outputs) > 1:
            balance.append(('base', ['ground'], {'contact': -1}, lambda _: (0.0, 0.0, 0.0)))
        far = max(abs(v) for x in self.deck.x for v in x)
        scene = Scene(name, self.deck, group, judge=judge, wanted=wanted, balance=balance,
                      mus={'contact': self.mu}, factor=far, **more)
        # A displacement's last place times the penalty, over Fn.
        scene.balance_wanted += 1e-14*stiff
        return scene


def ratio_to(along, lateral=0.0):
    """Judge: T/N of the top against theory, along x and laterally."""
    def judge(outcome):
        r1, r2, r3 = outcome.last('rea', 'top')[:3]
        return math.hypot(-r1/r3 - along, -r2/r3 - lateral)/max(abs(along), 1e-3)
    return judge


def drag(mu, phi, rule):
    """(along, lateral) friction over N when the cube is moved along x (theory, section 1)."""
    c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))
    v1, v2 = c, -s  # the slip in the axes of the ellipse
    bottom = math.hypot(mu[0]**(rule - 1)*v1, mu[1]**(rule - 1)*v2)
    f1, f2 = mu[0]**rule*v1/bottom, mu[1]**rule*v2/bottom
    return f1*c - f2*s, f1*s + f2*c


def penalties():
    """Ten decades of penalty, sliding and pressed."""
    for decade in range(-2, 9):
        k = 10.0**decade
        # k E/h with h the edge of the cube's cells
        cube = Cube(f'penalty {k:g} E/h', penalty=f'AREA {number(k*YOUNG*2)}')
        yield cube.scene(f'slide k=1e{decade}', 'penalty', ratio_to(0.1), 1e-6, k)
        cube = Cube(f'elastic base, penalty {k:g} E/h', rigid=False,
                    penalty=f'AREA {number(k*YOUNG*2)}')
        yield cube.scene(f'elastic k=1e{decade}', 'penalty', stiff=k)
        yield pressed(k, decade)


def pressed(k, decade):
    """A block under uniaxial stress: exact whatever the penalty."""
    epsilon = k*YOUNG*2
    cube = Cube(f'pressed, penalty {k:g} E/h', mu=(0.0, 0.0), poisson=0.0, depth=0.01, slides=0,
                penalty=f'AREA {number(epsilon)}')
    exact = 0.01/(1.0/YOUNG + 1.0/epsilon)

    def judge(outcome):
        return abs(-outcome.last('rea', 'top')[2]/exact - 1.0)
    return cube.scene(f'press k=1e{decade}', 'penalty', judge, 1e-8)


def frictions():
    """mu from 0 to 10; coefficients apart by up to 1000; all rules."""
    for mu in (0.0, 1e-6, 0.01, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0, 10.0):
        cube = Cube(f'mu {mu}', mu=(mu, mu))
        judge = ratio_to(mu) if 0.0 < mu <= 0.3 else None
        yield cube.scene(f'rigid mu={mu:g}', 'mu', judge, 1e-6)
        cube = Cube(f'mu {mu}, elastic base', mu=(mu, mu), rigid=False)
        yield cube.scene(f'elastic mu={mu:g}', 'mu')
    for share in (1, 10, 100, 1000):
        for rule, word in enumerate(('COLLinear', 'TENSor', 'ASSOciated')):
            for phi in (0, 30, 45, 90):
                mu = (0.3, 0.3/share)
                cube = Cube(f'mu1/mu2 {share}, phi {phi}, {word}', mu=mu, phi=phi, rule=word,
                            slides=12)
                # Across a strong axis the force along it relaxes over more than this slide; along
                # it a collinear law follows each small turn of the slip.
                judge = None if share >= 100 and phi == 90 and rule or share == 1000 and phi == 0 else \
                    ratio_to(*drag(mu, phi, rule))
                yield cube.scene(f'{share}:1 phi={phi} m={rule}', 'ellipse', judge,
                                 1e-4 if rule else 1e-6)


def shapes():
    """Stretched facets, far from the origin, exact positions, nearly incompressible."""
    for rigid in (True, False):
        kind = 'rigid' if rigid else 'elastic'
        # Facets 0.02 x 20
        cube = Cube(f'aspect 1000, {kind}', rigid=rigid, base=(80, 1, 1), low=(-0.3, -9.7),
                    high=(1.3, 10.3), path=((1.0, 0.25, 0.0),))
        yield cube.scene(f'aspect 1000 {kind} x', 'aspect', ratio_to(0.1), 1e-6 if rigid else 0.1)
        cube = Cube(f'aspect 1000 across, {kind}', rigid=rigid, base=(1, 80, 1), low=(-9.7, -0.3),
                    high=(10.3, 1.3))
        yield cube.scene(f'aspect 1000 {kind} y', 'aspect', ratio_to(0.1), 1e-6 if rigid else 0.1)
    for size in (1e3, 1e6):
        for rigid in (True, False):
            cube = Cube(f'{size:g} from the origin', rigid=rigid, shift=(size, -size, size))
            yield cube.scene(f'origin {size:g} ' + ('rigid' if rigid else 'elastic'), 'origin',
                             ratio_to(0.1), 1e-6*size**0.5 if rigid else 0.05)
    for poisson in (0.0, 0.4, 0.45, 0.49, 0.499, 0.4999):
        for rigid in (True, False):
            cube = Cube(f'nu {poisson}', poisson=poisson, rigid=rigid)
            yield cube.scene(f'nu={poisson} ' + ('rigid' if rigid else 'elastic'), 'nu',
                             ratio_to(0.1), 1e-6 if rigid else 0.05)
    yield from exact_places()


def exact_places():
    """Slave nodes exactly on vertices, edges and diagonals; gaps of 0 and of one last place."""
    ulp = math.ulp(1.0)
    for rigid in (True, False):
        kind = 'rigid' if rigid else 'elastic'
        grid = {'base': (6, 4, 1), 'low': (-1.0, -0.5), 'high': (2.0, 1.5), 'rigid': rigid}
        half = {'base': (6, 4, 1), 'low': (-0.75, -0.5), 'high': (2.25, 1.5), 'rigid': rigid}
        ways = {'x': (1.0, 0.5, 0.0), 'xy': (1.0, 0.5, 0.5), 'y': (1.0, 0.0, 0.5)}
        for word, way in ways.items():
            for place, where in (('vertex', grid), ('edge', half)):
                cube = Cube(f'on {place}, along {word}', path=(way,), **where)
                judge = None
                if rigid:
                    c = math.hypot(way[1], way[2])
                    judge = ratio_to(0.1*way[1]/c, 0.1*way[2]/c)
                yield cube.scene(f'on {place} {word} {kind}', 'places', judge, 1e-6)
        for word, gap in (('0', 0.0), ('+1ulp', ulp), ('-1ulp', -ulp)):
            cube = Cube(f'gap {word}', gap=gap, shift=(0.0, 0.0, 1.0), **grid)
            yield cube.scene(f'gap {word} {kind}', 'places', ratio_to(0.1) if rigid else None, 1e-6)


def paths():
    """Reversal in each increment, and the whole slide in one."""
    for rigid in (True, False):
        kind = 'rigid' if rigid else 'elastic'
        zigzag = tuple((0.1*k, 0.2 if k % 2 else 0.0, 0.0) for k in range(1, 11))
        cube = Cube('reversal in each increment', rigid=rigid, path=zigzag, slides=10)
        yield cube.scene(f'reversal {kind}', 'path', ratio_to(-0.1) if rigid else None, 1e-3)
        tiny = tuple((0.1*k, 1e-5 if k % 2 else -1e-5, 0.0) for k in range(1, 11))
        cube = Cube('small reversal in each increment', rigid=rigid, path=tiny, slides=10)
        yield cube.scene(f'small reversal {kind}', 'path')
        for way in (0.6, 1.0):
            cube = Cube('the whole slide at once', rigid=rigid, path=((1.0, way, 0.0),), slides=1,
                        presses=1)
            yield cube.scene(f'one increment {way:g} {kind}', 'path',
                             ratio_to(0.1) if rigid else None, 1e-3)
        cube = Cube('a seventh pressed deep at once', rigid=rigid, depth=0.14, presses=1)
        yield cube.scene(f'deep press {kind}', 'path')


def dead_loads():
    """A cube that only contact holds, under dead N and T at its top (T/N below and above mu)."""
    for mu, share, refused in ((0.12, 0.115, False), (0.2, 0.115, False), (0.3, 0.115, False),
                               (1.0, 0.115, False), (0.1, 0.115, True), (0.0, 0.115, True),
                               (0.1, 0.0, False), (0.2, 0.19, False), (0.2, 0.21, True)):
        for rigid in (True, False):
            yield dead(mu, share, refused, rigid)


def dead(mu, share, refused, rigid):
    """One cube under dead loads."""
    deck = Deck(f'dead loads, mu {mu}, T/N {share}')
    cube_material = deck.elastic(YOUNG, 0.3)
    ground = deck.rigid() if rigid else deck.elastic(YOUNG, 0.3)
    cube = Body(deck, 'cube', (2, 2, 1), (0, 0, 0), (1, 1, 0.5), cube_material)
    base = Body(deck, 'base', (5, 4, 1), (-0.43, -0.37, -0.4), (1.6, 1.43, 0), ground)
    deck.surface('sole', cube.layer(0))
    deck.surface('track', base.layer(-1))
    deck.set('top', cube.layer(-1))
    if not rigid:
        deck.set('ground', base.layer(0))
        deck.fix('ground')
        deck.outputs = ['ground']
    press = deck.table([(0, 0), (1, 1)])
    pull = deck.table([(1, 0), (2, 1)])
    for node, part in cube.shares(-1).items():
        deck.load(node, (10*share*part, 0.0, -10*part), (pull, pull, press))
    friction = f'FRICtion COULomb {number(mu)}' if mu else 'FRICtion NONE'
    deck.pair('contact', 'sole', 'track', ['PENAlty AUTO 10', friction])
    deck.steps(1.0, 2)
    deck.steps(1.0, 4)

    def judge(outcome):
        values = outcome.last('con', 'contact')
        return math.dist(values[5:8], (-10*share, 0.0, 10.0))/10.0

    def load(time):
        return (10*share*max(0.0, time - 1.0), 0.0, -10*min(1.0, time))
    kind = 'rigid' if rigid else 'elastic'
    return Scene(f'dead T/N={share:g} mu={mu:g} {kind}', deck, 'force', refused=refused,
                 judge=None if refused else judge, wanted=1e-8,
                 balance=[('cube', [], {'contact': 1}, load)], mus={'contact': (mu, mu)}, factor=2.0)


def unit_families():
    """Pairs (reference, scaled, factor): the same scene in other units."""
    for rigid in (True, False):
        for rule in ('COLLinear', 'ASSOciated'):
            more = {'rigid': rigid, 'mu': (0.3, 0.2), 'phi': 30.0, 'rule': rule}
            kind = ('rigid' if rigid else 'elastic') + ' ' + rule[:4].lower()
            first = Cube('units', **more)
            yield first.scene(f'units 1 {kind}', 'units'), None
            for word, length, force in (('length 2^-30', 2.0**-30, 1.0), ('length 2^30', 2.0**30, 1.0),
                                        ('force 2^-30', 1.0, 2.0**-30), ('force 2^30', 1.0, 2.0**30),
                                        ('both', 2.0**-30, 2.0**30)):
                other = Cube('units', length=length, force=force, **more)
                scene = other.scene(f'units {word} {kind}', 'units', wanted=1e-10)
                yield scene, (f'units 1 {kind}', force)


def compare_units(outcome, reference, factor):
    """Largest difference of the reactions, over the largest reaction."""
    if len(outcome.rea) != len(reference.rea):
        return math.inf
    top = max(max(map(abs, row[3])) for row in reference.rea)
    worst = max(abs(a/factor - b) for new, old in zip(outcome.rea, reference.rea)
                for a, b in zip(new[3], old[3]))
    return worst/top


def all_fixed():
    """Every fixed scene with its reference for the units, or None."""
    for family in (penalties, frictions, shapes, paths, dead_loads):
        for scene in family():
            yield scene, None
    yield from unit_families()
