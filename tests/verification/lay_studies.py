"""Lays that vary: a pin on a disc that was turned on a lathe, at rest and turning."""
import math

import meshing
import verifying
from friction_studies import EXACT, RULES, coefficients


LOCAL = ('an elastic disc gives way by another amount at each place of its mesh, so that the tip does not follow the '
         'circle of the pin to better than that; the mean of a revolution is right')


ARM = 0.65  # of the slider on the turntable
RIGID = 'step time set U1 U2 U3 ROT1 ROT2 ROT3 F1 F2 F3 M1 M2 M3'.split()


def disc_and_pin(cells, place, elastic=False):
    """Disc of 2 x 2 (a square one) with its upper face at x3 = 0, and a pin whose tip touches it."""
    mesh = meshing.Mesh()
    number = mesh.box((cells, cells, 1), lambda i, j, k: (2*i/cells - 1, 2*j/cells - 1, k/4 - 0.25))
    disc = list(range(1, len(mesh.nodes) + 1))
    x, y = place
    mesh.nodes += [(x, y, 0.0), (x + 0.1, y, 0.2), (x - 0.05, y + 0.1, 0.2), (x - 0.05, y - 0.1, 0.2)]
    tip = len(disc) + 1
    mesh.elements.append((2, tip, tip + 1, tip + 2, tip + 3))
    return mesh, {'disc': disc, 'pin': list(range(tip, tip + 4)), 'tip': [tip],
                  'face': [number(i, j, 1) for i in range(cells + 1) for j in range(cells + 1)],
                  'ground': [number(i, j, 0) for i in range(cells + 1) for j in range(cells + 1)]}


def head(title, mesh, parts, young=None):
    """Title, materials, mesh, sets; the disc is rigid unless it has a modulus."""
    sets = ''.join(meshing.node_set(name, numbers) for name, numbers in parts.items())
    disc = 'MATErial 1\n  RIGId\n\n' if young is None else meshing.solid(1, young, 0.3)
    return (f'MFEC * * {title}\n\n{disc}MATErial 2\n  RIGId\n\n' + mesh.records() + sets +
            'SURFace track FROM face\n\n')


def tail(direction, rule, batch, penalty, mu):
    """The pair and the solution commands."""
    return f'''CONTact
  PAIR 1
    NTOS      tip track
    PENAlty   {penalty!r}
    FRICtion  ELLIptic {mu[0]!r} {mu[1]!r}
    DIREction {direction}
    SLIP      {rule}

OUTPut
  REACtions pin
  FIELds NONE

END
BATCh
{batch}END
STOP
'''


def table(number, times, values):
    """A proportional load."""
    return f'PROPortional {number}\n' + ''.join(
        f'  {t:.15e} {v:.15e}\n' for t, v in zip(times, values)) + '\n'


def circle_deck(radius, offset, direction, rule, chords, mu, young=None):
    """The pin is pressed, then led around a circle whose centre lies `offset` from the axis."""
    mesh, parts = disc_and_pin(8, (radius + offset, 0.0))
    times = [1 + k/chords for k in range(chords + 1)]
    turns = [2*math.pi*k/chords for k in range(chords + 1)]
    held = 'disc' if young is None else 'ground'
    depth, penalty = (1e-4, 1e4) if young is None else (2e-4, 1e6)
    return head('A pin on a turned disc', mesh, parts, young) + f'''BOUNdary
  {held}  1 1 1
  pin   1 1 1

DISPlacement
  pin   {radius!r} {radius!r} {-depth!r}

FPROportional
  pin   2 3 1

PROPortional 1
  0 0
  1 1

''' + table(2, times, [math.cos(a) - 1 for a in turns]) + table(
        3, times, [math.sin(a) for a in turns]) + tail(
            direction, rule, f'  DT,,1\n  STEP,,1\n  DT,,1/{chords}\n  STEP,,{chords}\n', penalty, mu)


def law(m, mu, v, lay):
    """Friction force per normal force of a steady drag along v: doc/theory, eq. (4.4)."""
    across = (-lay[1], lay[0])
    c = (v[0]*lay[0] + v[1]*lay[1], v[0]*across[0] + v[1]*across[1])
    size = math.sqrt(sum((k**(m - 1)*a)**2 for k, a in zip(mu, c)))
    f = [k**m*a/size for k, a in zip(mu, c)]
    return f[0]*lay[0] + f[1]*across[0], f[0]*lay[1] + f[1]*across[1]


def power(m, mu, radius, offset, angle):
    """Friction force per normal force along a circle about (offset, 0)."""
    x, y = offset + radius*math.cos(angle), radius*math.sin(angle)
    size = math.hypot(x, y)
    v = (-math.sin(angle), math.cos(angle))
    force = law(m, mu, v, (-y/size, x/size))
    return force[0]*v[0] + force[1]*v[1]


def work(rows, radius):
    """Work of the pin along its circle over its normal force and radius."""
    total, n = 0.0, len(rows)
    for i, row in enumerate(rows):
        a, b = (2*math.pi*(i + k)/n for k in (0, 1))
        total -= (row['R1']*(math.cos(b) - math.cos(a)) + row['R2']*(math.sin(b) - math.sin(a)))/row['R3']
    return total


def along_and_across(row, angle):
    """Force on the pin along its way and towards the axis, over the normal force."""
    c, s = math.cos(angle), math.sin(angle)
    return (-row['R1']*s + row['R2']*c)/-row['R3'], (row['R1']*c + row['R2']*s)/-row['R3']


def lathe(bench):
    """One revolution about the axis of the lay, on a rigid and on an elastic disc."""
    radius, chords, mu = bench.draw('radius', 0.4, 0.85), 360, coefficients(bench)
    for name, young, wanted in (('rigid', None, 1e-3), ('elastic', 1e4, 1e-2)):
        for prefix in ('', 'MATErial '):
            deck = circle_deck(radius, 0.0, prefix + 'CIRCumferential 0 0 3 0 0 1', 'COLLinear', chords,
                               mu, young)
            rows = bench.run_text('lathe', deck).reactions('pin')[2:]
            pairs = [along_and_across(row, 2*math.pi*(i + 1.5)/chords) for i, row in enumerate(rows)]
            worst = max((p[0] for p in pairs), key=lambda value: abs(value - mu[0]))
            what = f'{name} disc, {prefix}CIRC'
            bench.compare(f'T/N along the lay, worst of a revolution, {what}', EXACT, mu[0], worst,
                          wanted, known=2*wanted, why=LOCAL)
            bench.compare(f'T/N across, mean of a revolution, {what}', EXACT, 0.0,
                          sum(p[1] for p in pairs)/len(pairs), 0.01, scale=mu[0])
    radial = circle_deck(radius, 0.0, 'RADial 0 0 3 0 0 1', 'COLLinear', chords, mu)
    rows = bench.run_text('lathe', radial).reactions('pin')[1:]
    bench.remark('along and across are those of the chord of an increment, which is the way the pin has slipped')
    bench.compare('dissipation/(N R), RADial', EXACT, 2*math.pi*mu[1], work(rows, radius), 1e-3)


def eccentric(bench):
    """A circle that lies beside the axis crosses the lay at all angles."""
    radius, chords, mu = bench.draw('radius', 0.35, 0.6), 360, coefficients(bench)
    offset = bench.draw('beside', 0.1, 0.9)*(0.98 - radius)
    for m, rule in enumerate(RULES):
        exact = sum(power(m, mu, radius, offset, 2*math.pi*(i + 0.5)/20000) for i in range(20000))
        exact *= 2*math.pi/20000
        for prefix in ('', 'MATErial '):
            deck = circle_deck(radius, offset, prefix + 'CIRCumferential 0 0 0 0 0 1', rule, chords, mu)
            rows = bench.run_text('eccentric', deck).reactions('pin')[1:]
            bench.compare(f'dissipation/(N R), m = {m}, {prefix}CIRC', 'exact (quadrature)', exact,
                          work(rows, radius), 1e-3)


def turning_deck(direction, rule, turn, mu, steps=12):
    """The pin slides over the disc while both are turned by an angle about x3."""
    mesh, parts = disc_and_pin(3, (-0.3, 0.2))
    times = [float(k) for k in range(steps + 1)]
    records, tables, number = [], [], 0
    loads, values, codes = {}, {}, {}
    for node in parts['disc'] + parts['pin']:
        x = mesh.nodes[node - 1]
        path = []
        for k in range(steps + 1):
            p = list(x)
            if node in parts['pin']:
                p[0] += 0.06*max(0, k - 1)
                p[1] -= 0.05*math.sin(0.7*max(0, k - 1))
                p[2] -= 1e-3*min(1, k)
            a = turn*k/steps
            c, s = (round(math.cos(a)), round(math.sin(a))) if k == steps and turn else (
                math.cos(a), math.sin(a))
            path.append((c*p[0] - s*p[1] - x[0], s*p[0] + c*p[1] - x[1], p[2] - x[2]))
        mine = []
        for i in range(3):
            number += 1
            mine.append(number)
            tables.append(table(number, times, [u[i] for u in path]))
        loads[node], values[node], codes[node] = tuple(mine), (1.0, 1.0, 1.0), (1, 1, 1)
    return (head('A pin on a disc that turns', mesh, parts) + meshing.vectors('BOUNdary', codes) +
            meshing.vectors('DISPlacement', values) + meshing.vectors('FPROportional', loads) +
            ''.join(tables) + tail(direction, rule, f'  DT,,1\n  STEP,,{steps}\n', 1e4, mu))


def turning(bench):
    """A lay that is carried along turns the friction with the disc."""
    quarter, mu = math.pi/2, coefficients(bench)
    phi = [bench.draw(f'phi {k}', -90.0, 90.0) for k in (1, 2)]
    for name, direction, rule in (('ANGLe', f'ANGLe {phi[0]} 1 0 0', 'COLLinear'),
                                  ('CIRCumferential', 'CIRCumferential -1 -1 0 0 0 1', 'TENSor'),
                                  ('ANGLe RADial', f'ANGLe {phi[1]} RADial 0 2 0 0 0 1', 'ASSOciated')):
        rest, turned = (bench.run_text('turning', turning_deck('MATErial ' + direction, rule, angle, mu))
                        .reactions('pin') for angle in (0.0, quarter))
        worst = slipped = 0.0
        for k, (a, b) in enumerate(zip(rest, turned), 1):
            c, s = math.cos(quarter*k/len(rest)), math.sin(quarter*k/len(rest))
            expected = (c*a['R1'] - s*a['R2'], s*a['R1'] + c*a['R2'], a['R3'])
            worst = max(worst, max(abs(p - b[r]) for p, r in zip(expected, ('R1', 'R2', 'R3'))))
            slipped = max(slipped, math.hypot(a['R1'], a['R2']))
        bench.compare(f'forces turned back, worst over N, {name}', EXACT, 0.0,
                      worst/abs(rest[-1]['R3']), 1e-10, scale=1.0)
        bench.compare(f'(sliding: T/N at least the smaller mu at some time, {rule})', EXACT, 1.0,
                      float(slipped > 0.999*min(mu)*abs(rest[-1]['R3'])), 0.0)


def towed_deck(centre, mu, phi, chords, size=0.004):
    """A slider of four tips on a rigid arm of length ARM, which turns freely about a point at `centre`, on a
    table that turns once about its middle; it starts where a slider of isotropic friction stays."""
    angle, (px, py) = start_of(centre), centre
    x, y = px + ARM*math.cos(angle), py + ARM*math.sin(angle)

    def block(name, material, cells, low, high, middle):
        return (f'BLOCk {name}\n  CART {cells} {cells} 1  MATErial {material}  TET4\n' + ''.join(
            f'  {k} {middle[0] + i!r} {middle[1] + j!r} {z!r}\n' for k, (i, j, z) in enumerate(
                ((i, j, z) for z in (low[2], high[2]) for i, j in (low[:2], (high[0], low[1]), high[:2], (low[0], high[1]))), 1)) +
            f'\nSET {name}_face\n  INSIde {name}\n  PLANe 3 0\n\n')

    return ('MFEC * * A slider on a turning table\n\nMATErial 1\n  RIGId\n\nMATErial 2\n  RIGId\n\n' +
            block('table', 1, 4, (-1, -1, -0.25), (1, 1, 0), (0, 0)) +
            block('arm', 2, 1, (-size, -size, 0), (size, size, 0.1), (x, y)) +
            'SURFace track FROM table_face IN table\n\nRIGId table\n  POINt 0 0 0\n  MOVE 0 0 0\n  TURN 0 0 1 360 2\n\n'
            f'RIGId arm\n  POINt {px!r} {py!r} 0\n  MOVE 0 0 0\n  TURN FREE\n\nFORCe\n  arm_face 0 0 -0.25 1\n\n' +
            table(1, (0, 1), (0, 1)) + table(2, (1, 2), (0, 1)) +
            tail(f'MATErial ANGLe {phi!r} 1 0 0', 'ASSOciated', f'  DT,,1\n  STEP,,1\n  DT,,1/{chords}\n  STEP,,{chords}\n',
                 1e5, mu).replace('pin', 'arm_face').replace('tip', 'arm_face'))


def start_of(centre):
    """Direction of the arm that is square to the radius of its slider."""
    return math.atan2(centre[1], centre[0]) + math.asin(ARM/math.hypot(*centre)) + math.pi/2


def towed(centre, mu, phi, turn, steps):
    """Directions of the arm over a turn of the table: friction along the arm, slip by the associated rule
    (doc/theory, eq. (4.4), m = 2), so that v ~ (f1/mu1^2, f2/mu2^2) along and across the lay. Runge-Kutta."""
    def rate(psi, omega):
        e, lay = (math.cos(psi), math.sin(psi)), (math.cos(phi + omega), math.sin(phi + omega))
        along, across = e[0]*lay[0] + e[1]*lay[1], e[1]*lay[0] - e[0]*lay[1]
        along, across = along/mu[0]**2, across/mu[1]**2
        v = (along*lay[0] - across*lay[1], along*lay[1] + across*lay[0])
        x, y = centre[0] + ARM*e[0], centre[1] + ARM*e[1]
        # a psi' e_perp - (-y, x) is parallel to v.
        return (-y*v[1] - x*v[0])/(ARM*(-e[1]*v[1] - e[0]*v[0]))

    found, step = [start_of(centre)], turn/steps
    for k in range(steps):
        psi, omega = found[-1], k*step
        k1 = rate(psi, omega)
        k2 = rate(psi + step/2*k1, omega + step/2)
        k3 = rate(psi + step/2*k2, omega + step/2)
        k4 = rate(psi + step*k3, omega + step)
        found.append(psi + step/6*(k1 + 2*k2 + 2*k3 + k4))
    return found


def turntable(bench):
    """A slider that is towed over an orthotropic table, after Tapia, Le Tourneau and Geminard 2016."""
    mu, phi = (0.3, 0.15), bench.draw('phi', -90.0, 90.0)
    centre, finest, curves = (1.0, 0.0), 2880, []
    exact = towed(centre, mu, math.radians(phi), 2*math.pi, finest)
    swing = max(exact) - min(exact)
    for chords in (90, 360) if bench.reduced else (90, 360, 1440):
        tables = bench.run_text('turntable', towed_deck(centre, mu, phi, chords))
        arm = [row for row in verifying.read_table(tables.base + '.rig', RIGID) if row['set'] == 'arm'][1:]
        found = [exact[0] + row['ROT3'] for row in arm]
        wanted = exact[finest//chords::finest//chords]
        worst = max((abs(a - b) for a, b in zip(found, wanted)))
        bench.compare('direction of the arm over its swing, worst of a revolution', 'exact (Runge-Kutta)', 0.0, worst,
                      0.01, scale=swing, known=0.1, mesh=f'{chords} increments a turn')
        curves.append((f'mfec, {chords} increments', '-', [360*(k + 1)/chords for k in range(chords)],
                       [math.degrees(a - exact[0]) for a in found]))
    bench.picture('turntable_arm', ('turn of the table [degrees]', 'turn of the arm [degrees]', 'A slider towed over a turning table'),
                  curves + [('exact', 'k:', [360*k/finest for k in range(finest + 1)], [math.degrees(a - exact[0]) for a in exact])])
