"""Friction: blocks and plates on rigid bases, closed forms and published values."""
import math

EXACT = 'exact'
RULES = ('collinear', 'tensor', 'associated')


def elliptical(mu1, mu2, angle):
    """Coefficient of friction for a force at an angle to the lay."""
    c, s = math.cos(angle), math.sin(angle)
    return mu1*mu2/math.sqrt((mu2*c)**2 + (mu1*s)**2)


def wedge(bench):
    """NAFEMS CGS-4."""
    slope, weight, found = 0.1, 10.0, []
    for mu in (0.0, 0.1, 0.2, 0.3):
        last = bench.run('wedge/wedge.inp', mu=mu).reactions('back')[-1]
        found.append(last['R1']/weight)
        bench.compare(f'F/G, mu = {mu}', 'exact (NAFEMS CGS-4)', (slope + mu)/(1 - mu*slope),
                      last['R1']/weight, 1e-3)
    mus = [k/100 for k in range(31)]
    bench.picture('wedge', ('mu', 'F/G', 'Wedge (NAFEMS CGS-4)'), [
        (bench.form, bench.mark(), (0.0, 0.1, 0.2, 0.3), found),
        ('exact', 'k-', mus, [(slope + mu)/(1 - mu*slope) for mu in mus])])


def dead_loads(bench):
    """Rests with T/N = 0.115 for mu above that; slides away below."""
    deck = 'block_dead_loads/block_dead_loads.inp'
    for mu in (0.12, 0.2, 0.3):
        last = bench.run(deck, mu=mu).contact('sole')[-1]
        bench.compare(f'Fn/N, mu = {mu}', EXACT, 1.0, last['Fn']/100, 1e-3)
        bench.compare(f'T/N, mu = {mu}', EXACT, 0.115, math.hypot(last['F1'], last['F2'])/100, 1e-3)
        bench.compare(f'slipping points, mu = {mu}', EXACT, 0.0, last['slip'], 0.0, scale=1.0)
    slides = bench.run(deck, code=2, mu=0.11)
    bench.compare('exit code, mu = 0.11 < T/N', EXACT, 2.0, slides.code, 0.0)


def oblique_pull(bench):
    """Force along x, body free to drift."""
    mu1, mu2 = 0.1, 0.08
    for m, rule in enumerate(RULES):
        for phi in (30, 60):
            tables = bench.run(f'oblique_pull/oblique_pull_{rule}.inp', phi=phi)
            theta = -math.radians(phi)
            force = tables.reactions('top')[-1]['R1']/100
            first, last = [block[1] for block in tables.displacements()]
            drift = (last[1] - first[1])/(last[0] - first[0])
            psi = math.atan((mu1/mu2)**m*math.tan(theta))
            bench.compare(f'F/N, m = {m}, phi = {phi}', EXACT, elliptical(mu1, mu2, theta), force,
                          1e-4)
            bench.compare(f'drift du2/du1, m = {m}, phi = {phi}', EXACT,
                          math.tan(psi - theta), drift, 1e-4, scale=1.0)


def drag_force(m, mu, phi):
    """Steady force over normal force along and across a drag at phi degrees from the lay."""
    c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))
    v = (c, -s)
    size = math.sqrt(sum((a**(m - 1)*b)**2 for a, b in zip(mu, v)))
    f = [a**m*b/size for a, b in zip(mu, v)]
    return f[0]*c - f[1]*s, f[0]*s + f[1]*c


def rigid_drag(bench):
    """Steady drag at an angle to the lay."""
    mu, normal = (0.1, 0.08), 90.0
    for m, rule in enumerate(RULES):
        worst = 0.0
        for phi in (0, 45, 90, 110):
            last = bench.run(f'rigid_drag/drag_{rule}.inp', phi=phi).reactions('plate_nodes')[-1]
            for name, exact in zip(('R1', 'R2'), drag_force(m, mu, phi)):
                reached = last[name]/normal
                worst = max(worst, abs(reached - exact)/0.1)
                if phi == 45:
                    bench.compare(f'{name}/N, m = {m}, phi = 45', EXACT, exact, reached, 1e-6,
                                  scale=0.1)
        bench.compare(f'R1/N and R2/N, m = {m}, phi = 0, 45, 90, 110, worst', EXACT, 0.0, worst,
                      1e-6, scale=1.0)


def jenkins(bench):
    """Loop of a plate that goes to and fro."""
    mu, depth, normal = 0.25, 1e-3, 90.0
    way = 10*mu*depth
    rows = [row for row in bench.run('rigid_drag/jenkins.inp').reactions('plate_nodes')
            if row['time'] > 1.999]
    moved = [way*(1 - 2*(t - 2) if t < 3 else 2*(t - 3) - 1) for t in (r['time'] for r in rows)]
    area = sum((b['R1'] + a['R1'])/2*(v - u)
               for a, b, u, v in zip(rows, rows[1:], moved, moved[1:]))
    bench.compare('loop area', EXACT, 4*mu*normal*(way - mu*depth), area, 1e-10)
    slope = (rows[1]['R1'] - rows[0]['R1'])/(moved[1] - moved[0])
    bench.compare('elastic slip mu N/K', EXACT, mu*depth, mu*normal/slope, 1e-10)


def tractrix(bench):
    """The force follows a drag whose direction was turned."""
    turn, ratio = math.radians(60), 0.3
    rows = bench.run('rigid_drag/tractrix.inp').reactions('plate_nodes')[1:]
    angle, worst = -turn, 0.0
    for row in rows[1:]:
        angle = math.atan2(math.sin(angle), math.cos(angle) + ratio)
        have = math.atan2(row['R2'], row['R1']) - turn
        have = math.atan2(math.sin(have), math.cos(have))
        worst = max(worst, abs(have - angle))
    bench.compare('largest error of the angle [rad], 20 increments', EXACT, 0.0, worst, 1e-10,
                  scale=1.0)


def circular_path(bench):
    """Dissipation along a circle."""
    radius, normal, chords = 0.3, 90.0, 180
    wanted = (0.5602412169, 0.5654866776, 0.5672333578)
    for rule, reference in zip(RULES, wanted):
        rows = bench.run(f'circular_path/circle_{rule}.inp').reactions('plate_nodes')[-chords:]
        work = 0.0
        for i, row in enumerate(rows):
            a, b = (2*math.pi*(i + k)/chords for k in (0, 1))
            work += radius*(row['R1']*(math.cos(b) - math.cos(a)) +
                            row['R2']*(math.sin(b) - math.sin(a)))
        bench.compare(f'dissipation/(N R), {rule}', 'exact (quadrature)', reference,
                      work/(normal*radius), 1e-3)


def shear_lag(bench):
    """Thin bar pulled over a base."""
    bar = {'young': 1000.0, 'section': 0.04, 'q': 0.1*0.3*0.2}
    rows = bench.run('shear_lag_bar/shear_lag_bar.inp').reactions('pulled')
    pull = bar['q']*36/(2*bar['young']*bar['section'])
    flexibility = 2*bar['young']*bar['section']*bar['q']
    pulls = [k*rows[-1]['R1']/50 for k in range(51)]
    bench.picture('shear_lag_bar', ('u', 'F', 'Bar on a flat base'), [
        (bench.form, bench.mark(), [pull*max(row['time'] - 1, 0) for row in rows],
         [row['R1'] for row in rows]),
        ('bar', 'k-', [force**2/flexibility for force in pulls], pulls)])
    for row in rows[5::5]:
        u = pull*(row['time'] - 1)
        bench.compare(f'u, slip length {6*math.sqrt(row["time"] - 1):.3g} of 10', 'exact (bar)',
                      row['R1']**2/(2*bar['young']*bar['section']*bar['q']), u, 0.02)


def raous(bench, n=32):
    """SSNV128."""
    points = ((0.0, 2.86e-5), (1.25, 2.72e-5), (5.0, 2.28e-5), (7.5, 1.98e-5), (11.25, 1.50e-5))
    sole = bench.run('raous_plate/raous_plate.inp', n=n).displacements()[-1]
    bench.picture('raous_plate', ('x [mm]', 'u1 [m]', 'Raous plate (SSNV128)'), [
        (f'{bench.form}, {n} cells', bench.mark() + '-', [40*k/n for k in range(n + 1)],
         [sole[1 + k][0] for k in range(n + 1)]),
        ('Code_Aster', 'k*', *zip(*points))])
    for x, reference in points:
        node = 1 + round(x/40*n)
        bench.compare(f'u1 at {x:g} mm, {n} cells', 'Code_Aster V6.04.128', reference,
                      sole[node][0], 0.05)


def raous_fine(bench):
    """SSNV128 on a mesh half as coarse."""
    raous(bench, 64)
