"""Friction: blocks and plates on rigid bases, closed forms and published values."""
import math
import os

import decks
import meshing

EXACT = 'exact'
PARTLY = ('a facet of the sole has lifted in part, and the cells of SEGMent wander over its kink of the pressure '
          '(doc/theory, "Segmentation"); where all is closed it is 1e-11')
RULES = ('collinear', 'tensor', 'associated')


def elliptical(mu1, mu2, angle):
    """Coefficient of friction for a force at an angle to the lay."""
    c, s = math.cos(angle), math.sin(angle)
    return mu1*mu2/math.sqrt((mu2*c)**2 + (mu1*s)**2)


def base(bench, cell, turned=True):
    """Parameters of the base's mesh in a deck: it lies anywhere under the slave, turned or not."""
    place = {name: bench.draw(name, -0.4*cell, 0.4*cell) for name in ('px', 'py')}
    if turned:
        place['spin'] = bench.draw('spin', -180.0, 180.0)
    return place


def coefficients(bench, low=0.05, high=0.5):
    """mu1 and mu2 of an ellipse between round and two to one, either way."""
    first = bench.draw('mu1', low, high)
    return first, float(f'{first*bench.draw("mu2/mu1", 0.5, 1.8):.4g}')


def wedge(bench):
    """NAFEMS CGS-4, with its slope and at another one."""
    place = base(bench, 0.8, False)
    cases = [(0.1, mu, f'mu = {mu}', 'exact (NAFEMS CGS-4)') for mu in (0.0, 0.1, 0.2, 0.3)]
    slope = bench.draw('slope', 0.02, 0.4)
    cases += [(slope, bench.draw(f'mu {k}', 0.05, 0.8), f'slope and mu drawn, {k} of 3', EXACT)
              for k in (1, 2, 3)]
    weight, found = 10.0, []
    for tangent, mu, text, source in cases:
        last = bench.run('wedge/wedge.inp', mu=mu, slope=tangent, **place).reactions('back')[-1]
        exact = (tangent + mu)/(1 - mu*tangent)
        found.append((exact, last['R1']/weight))
        bench.compare(f'F/G, {text}', source, exact, last['R1']/weight, 1e-3)
    bench.picture('wedge_forces', ('(tan a + mu)/(1 - mu tan a)', 'F/G', 'Wedge (NAFEMS CGS-4)'), [
        (bench.form, bench.mark(), *zip(*found)), ('exact', 'k-', (0.0, 1.2), (0.0, 1.2))])


def dead_loads(bench):
    """Rests with mu above T/N; slides away below."""
    deck, place = 'block_dead_loads/block_dead_loads.inp', base(bench, 0.5)
    ratio = bench.draw('T/N', 0.05, 0.3)
    for times in (1.04, 1.7, 2.6):
        last = bench.run(deck, mu=times*ratio, ratio=ratio, **place).contact('sole')[-1]
        text = f'mu = {times} T/N'
        bench.compare(f'Fn/N, {text}', EXACT, 1.0, last['Fn']/100, 1e-3)
        bench.compare(f'T/N, {text}', EXACT, ratio, math.hypot(last['F1'], last['F2'])/100, 1e-3)
        bench.compare(f'slipping points, {text}', EXACT, 0.0, last['slip'], 0.0, scale=1.0)
    slides = bench.run(deck, code=2, mu=0.96*ratio, ratio=ratio, **place)
    bench.compare('exit code, mu = 0.96 T/N', EXACT, 2.0, slides.code, 0.0)


def oblique_pull(bench):
    """Force along x, body free to drift."""
    # a cube that is pulled at its top tips over where mu is above a half
    place, (mu1, mu2) = base(bench, 0.9), coefficients(bench, 0.05, 0.25)
    for number in (1, 2):
        phi = bench.draw(f'phi {number}', -80.0, 80.0)
        for m, rule in enumerate(RULES):
            tables = bench.run(f'oblique_pull/oblique_pull_{rule}.inp', phi=phi, mu1=mu1, mu2=mu2, **place)
            theta = -math.radians(phi)
            force = tables.reactions('top')[-1]['R1']/100
            first, last = [block[1] for block in tables.displacements()]
            drift = (last[1] - first[1])/(last[0] - first[0])
            psi = math.atan((mu1/mu2)**m*math.tan(theta))
            text = f'm = {m}, direction {number}'
            bench.compare(f'F/N, {text}', EXACT, elliptical(mu1, mu2, theta), force, 1e-4)
            bench.compare(f'drift du2/du1, {text}', EXACT, math.tan(psi - theta), drift, 1e-4, scale=1.0)


def klarbring_compliance(nu=0.45):
    """Compliance NN, NT, TT of the free node of the deck's one tetrahedron, E = 1."""
    corners = ((1.24610224235115, 0.0, 0.668751973161525), (-0.190038419283356, 0.866025403784439, 1.10176467505374),
               (-0.190038419283357, -0.866025403784438, 1.10176467505374))
    a, b, c = corners
    cross = (a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0])
    volume = abs(sum(x*y for x, y in zip(cross, c)))/6
    # the gradient of the free node's shape function: twice the area vector of the held facet over 6 V
    p, q = ([y - x for x, y in zip(a, other)] for other in (b, c))
    g = [(p[1]*q[2] - p[2]*q[1])/(6*volume), 0.0, (p[0]*q[1] - p[1]*q[0])/(6*volume)]
    first, shear = nu/(1 + nu)/(1 - 2*nu), 1/(2 + 2*nu)
    k = [[volume*((first + shear)*x*y + (shear*(g[0]**2 + g[2]**2) if i == j else 0.0))
          for j, y in enumerate((g[2], g[0]))] for i, x in enumerate((g[2], g[0]))]
    size = k[0][0]*k[1][1] - k[0][1]**2
    return k[1][1]/size, -k[0][1]/size, k[0][0]/size


def klarbring(bench):
    """One load, three answers: of one node with friction above what it bears."""
    mu, deck = 0.9, '../../inputs/manual/second_answers.inp'
    nn, nt, tt = klarbring_compliance()
    nn, tt = nn + 1e-6, tt + 1e-6
    pressed, let_down = bench.run(deck), bench.run(deck, press=0)
    bench.compare('friction over what the point bears, pressed', EXACT, mu*abs(nt)/nn, pressed.audited('answers')[-1],
                  1e-6)
    bench.compare('the same, let down', EXACT, mu*abs(nt)/nn, let_down.audited('answers')[-1], 1e-6)
    # forces on the free node, N and T, and the gaps that they bring without contact
    slip = []
    for share in (0.9, 1.0):
        free = [x*-0.001 + y*-0.0008 for x, y in ((share*nn, share*nt), (share*nt, share*tt))]
        slip.append(-free[0]/(nn - mu*abs(nt)))
    bench.compare('pressure that slips (unstable)', EXACT, slip[1], pressed.contact('foot_on_floor')[-1]['Fn'], 1e-4)
    bench.compare('pressure without contact, the same load', EXACT, 0.0,
                  let_down.contact('foot_on_floor')[-1]['Fn'], 1e-12, scale=1.0)
    # stuck where the foot was one increment before: by 0.1 of the load and of the slip's way
    way = [nt*slip[0] + tt*mu*slip[0] + 0.9*(nt*-0.001 + tt*-0.0008), nt*-0.001 + tt*-0.0008]
    size = nn*tt - nt*nt
    push = [-(nn*-0.001 + nt*-0.0008), way[0] - way[1]]
    stuck = (tt*push[0] - nt*push[1])/size
    bench.compare('pressure that sticks, by second starts', EXACT, stuck, pressed.second_pressure(), 1e-3)


def drag_force(m, mu, phi):
    """Steady force over normal force along and across a drag at phi degrees from the lay."""
    c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))
    v = (c, -s)
    size = math.sqrt(sum((a**(m - 1)*b)**2 for a, b in zip(mu, v)))
    f = [a**m*b/size for a, b in zip(mu, v)]
    return f[0]*c - f[1]*s, f[0]*s + f[1]*c


def rigid_drag(bench):
    """Steady drag at an angle to the lay; at 45 degrees with 0.1 and 0.08 as well, the paper's (6)."""
    place, mu = base(bench, 0.6), coefficients(bench)
    angles = (0.0, 90.0) + tuple(bench.draw(f'phi {k}', 0.0, 180.0) for k in (1, 2))
    for m, rule in enumerate(RULES):
        deck = f'rigid_drag/drag_{rule}.inp'
        last = bench.run(deck, phi=45, **place).reactions('plate_nodes')[-1]
        for name, exact in zip(('R1', 'R2'), drag_force(m, (0.1, 0.08), 45)):
            bench.compare(f'{name}/N, m = {m}, mu = 0.1/0.08, phi = 45', EXACT, exact, last[name]/90.0,
                          1e-6, scale=0.1)
        worst = 0.0
        for phi in angles:
            last = bench.run(deck, phi=phi, mu1=mu[0], mu2=mu[1], **place).reactions('plate_nodes')[-1]
            for name, exact in zip(('R1', 'R2'), drag_force(m, mu, phi)):
                worst = max(worst, abs(last[name]/90.0 - exact)/mu[0])
        bench.compare(f'R1/N and R2/N, m = {m}, four angles, worst', EXACT, 0.0, worst, 1e-6, scale=1.0)


def elastic_drag(bench):
    """Steady drag of an elastic cube over a rigid base: points of all forms cross edges all the way."""
    mu = coefficients(bench, 0.05, 0.3)
    phi, shift = bench.draw('phi', 0.0, 180.0), bench.draw('shift of the base', -0.1, 0.1)
    with open(os.path.join(decks.TOP, 'inputs', 'sliding_cube_rigid.inp'), encoding='ascii') as stream:
        text = stream.read()
    for old, new in (('-0.43 -0.37', f'{-0.43 + shift:.6f} -0.37'), ('2.17 -0.37', f'{2.17 + shift:.6f} -0.37'),
                     ('-0.43  1.43', f'{-0.43 + shift:.6f}  1.43'), ('2.17  1.43', f'{2.17 + shift:.6f}  1.43')):
        if old not in text:
            raise ValueError(f'sliding_cube_rigid.inp has no {old!r}')
        text = text.replace(old, new)
    for form in ('NTOS', 'GTOS', 'GTOS SEGMent', 'MORTar'):
        side, *points = form.split()
        for m, rule in enumerate(RULES):
            pair = f'{side} under track ' + ' '.join(points) + f'\n    SLIP {rule[:4]}'
            last = bench.run_text('elastic_drag', text.replace('NTOS      under track', pair), phi=phi,
                                  mu1=mu[0], mu2=mu[1]).reactions('top')[-1]
            worst = max(abs(last[name]/-last['R3'] - exact)/mu[0]
                        for name, exact in zip(('R1', 'R2'), drag_force(m, mu, phi)))
            bench.compare(f'R1/N and R2/N over mu1, m = {m}, worst', EXACT, 0.0, worst, 1e-8, scale=1.0,
                          form=form, known=1e-4 if points else None, why=PARTLY)


def jenkins(bench):
    """Loop of a plate that goes to and fro."""
    mu, place = bench.draw('mu', 0.05, 0.9), base(bench, 0.6)
    depth, normal = 1e-3, 90.0
    way = 10*mu*depth
    rows = [row for row in bench.run('rigid_drag/jenkins.inp', mu=mu, **place).reactions('plate_nodes')
            if row['time'] > 1.999]
    moved = [way*(1 - 2*(t - 2) if t < 3 else 2*(t - 3) - 1) for t in (r['time'] for r in rows)]
    area = sum((b['R1'] + a['R1'])/2*(v - u)
               for a, b, u, v in zip(rows, rows[1:], moved, moved[1:]))
    bench.compare('loop area', EXACT, 4*mu*normal*(way - mu*depth), area, 1e-10)
    slope = (rows[1]['R1'] - rows[0]['R1'])/(moved[1] - moved[0])
    bench.compare('elastic slip mu N/K', EXACT, mu*depth, mu*normal/slope, 1e-10)


def tractrix(bench):
    """The force follows a drag whose direction was turned."""
    # beyond acos(-ratio/2) the first step does not slip
    degrees, mu, ratio = bench.draw('turn', 20.0, 95.0), bench.draw('mu', 0.05, 0.9), 0.3
    turn = math.radians(degrees)
    rows = bench.run('rigid_drag/tractrix.inp', turn=degrees, mu=mu,
                     **base(bench, 0.6)).reactions('plate_nodes')[1:]
    angle, worst = -turn, 0.0
    for row in rows[1:]:
        angle = math.atan2(math.sin(angle), math.cos(angle) + ratio)
        have = math.atan2(row['R2'], row['R1']) - turn
        have = math.atan2(math.sin(have), math.cos(have))
        worst = max(worst, abs(have - angle))
    bench.compare('largest error of the angle [rad], 20 increments', EXACT, 0.0, worst, 1e-10,
                  scale=1.0)


def circle_work(m, mu):
    """Dissipation along a circle over N R, the lay along x: quadrature."""
    count, total = 20000, 0.0
    for k in range(count):
        angle = 2*math.pi*(k + 0.5)/count
        v = (-math.sin(angle), math.cos(angle))
        size = math.sqrt(sum((a**(m - 1)*b)**2 for a, b in zip(mu, v)))
        total += sum(a**m*b*b for a, b in zip(mu, v))/size
    return 2*math.pi*total/count


def circular_path(bench):
    """Dissipation along a circle, also with the coefficients of the paper's (6)."""
    place, drawn, size = base(bench, 0.6), coefficients(bench, 0.05, 0.2), bench.draw('radius', 0.2, 0.4)
    published = (0.5602412169, 0.5654866776, 0.5672333578)
    for m, rule in enumerate(RULES):
        cases = [((0.1, 0.08), 0.3, 'mu = 0.1/0.08')] if m == 2 else []
        for mu, radius, text in cases + [(drawn, size, 'mu drawn')]:
            rows = bench.run(f'circular_path/circle_{rule}.inp', mu1=mu[0], mu2=mu[1], radius=radius,
                             depth=2e-3*radius/3, **place).reactions('plate_nodes')[-180:]
            reference = published[m] if text != 'mu drawn' else circle_work(m, mu)
            normal = -rows[-1]['R3']
            bench.compare(f'dissipation/(N R), {rule}, {text}', 'exact (quadrature)', reference,
                          work_along(rows, radius)/(normal*radius), 1e-3)


def work_along(rows, radius):
    """Work of a plate along the chords of a circle."""
    work, chords = 0.0, len(rows)
    for i, row in enumerate(rows):
        a, b = (2*math.pi*(i + k)/chords for k in (0, 1))
        work += radius*(row['R1']*(math.cos(b) - math.cos(a)) + row['R2']*(math.sin(b) - math.sin(a)))
    return work


def slope_deck(counts, mu, degrees, place, form):
    """Two blocks one on the other on a rigid base, under their weight; gravity turns instead of the base."""
    mesh = meshing.Mesh()
    parts, floor = {}, 0.0
    for name, n, size, left in (('lower', counts[0], 1.0, (0.0, 0.0)), ('upper', counts[1], 0.7, place)):
        first = len(mesh.nodes) + 1
        number = mesh.box((n, n, n), lambda i, j, k, n=n, size=size, left=left, floor=floor: (
            left[0] + size*i/n, left[1] + size*j/n, floor + size*k/n))
        parts[name] = list(range(first, len(mesh.nodes) + 1))
        for part, level in (('_sole', 0), ('_top', n)):
            parts[name + part] = [number(i, j, level) for i in range(n + 1) for j in range(n + 1)]
        floor += size
    first = len(mesh.nodes) + 1
    ground = mesh.box((3, 3, 1), lambda i, j, k: (-0.9 + i, -0.83 + j, 0.5*(k - 1)), material=2)
    parts['ground'] = list(range(first, len(mesh.nodes) + 1))
    parts['face'] = [ground(i, j, 1) for i in range(4) for j in range(4)]
    weights = {}
    for element, volume in zip(mesh.elements, mesh.volumes()):
        for n in element[1:] if element[0] == 1 else ():
            weights[n] = weights.get(n, 0.0) + volume/4
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    pair = '    PENAlty AUTO 10\n    FRICtion COULomb ' + repr(mu) + '\n'
    return ('MFEC * * Stack on a slope\n\n' + meshing.solid(1, 1e5, 0.3) + 'MATErial 2\n  RIGId\n\n' +
            mesh.records() + ''.join(meshing.node_set(name, numbers) for name, numbers in parts.items()) +
            'SURFace s1 FROM lower_sole\nSURFace m1 FROM face\nSURFace s2 FROM upper_sole\n'
            'SURFace m2 FROM lower_top\n\nBOUNdary\n  ground 1 1 1\n\n' +
            meshing.vectors('FORCe', {n: (w*s, 0.0, -w*c) for n, w in weights.items()}) +
            'PROPortional 1\n  0 0\n  1 1\n\nCONTact\n'
            f'  PAIR 1 base\n    {form} s1 m1\n{pair}  PAIR 2 joint\n    {form} s2 m2\n{pair}'
            '\nOUTPut\n  REACtions ground\n  FIELds NONE\n\nEND\nBATCh\n  DT,,0.5\n  STEP,,2\nEND\nSTOP\n')


def slope(bench):
    """A stack of two blocks under its weight on a slope from 0 to 1.2 atan(mu)."""
    mu, counts = bench.draw('mu', 0.1, 0.7), (bench.whole('cells below', 2, 4), bench.whole('cells above', 2, 4))
    place = bench.draw('x of the upper', 0.05, 0.25), bench.draw('y of the upper', 0.05, 0.25)
    limit, whole = math.degrees(math.atan(mu)), 1 + 0.7**3
    for form in ('NTOS', 'MORTar'):
        for share in (0.0, 0.5, 0.97):
            tables = bench.run_text('slope', slope_deck(counts, mu, share*limit, place, form))
            c, s = math.cos(math.radians(share*limit)), math.sin(math.radians(share*limit))
            for pair, weight in (('base', whole), ('joint', 0.7**3)):
                last = tables.contact(pair)[-1]
                error = max(abs(abs(last['F3']) - weight*c), abs(abs(last['F1']) - weight*s))/weight
                bench.compare(f'{pair}: Fn - W cos a and Ft - W sin a, {share} atan(mu)', EXACT, 0.0, error,
                              1e-9, scale=1.0, form=form)
        for share in (1.03, 1.2):
            slides = bench.run_text('slope', slope_deck(counts, mu, share*limit, place, form), code=2)
            bench.compare(f'exit code, {share} atan(mu)', EXACT, 2.0, slides.code, 0.0, form=form)


def shear_lag(bench):
    """Thin bar pulled over a base."""
    drawn = {'mu': bench.draw('mu', 0.05, 0.3), 'young': bench.draw('young', 500.0, 5000.0),
             'pressure': bench.draw('pressure', 0.1, 0.6), 'reach': bench.draw('reach', 4.5, 7.0),
             'n': bench.whole('cells', 90, 130)}
    q, reach = drawn['mu']*drawn['pressure']*0.2, drawn['reach']
    rows = bench.run('shear_lag_bar/shear_lag_bar.inp', **drawn).reactions('pulled')
    flexibility = 2*drawn['young']*0.04*q
    pull = (q*reach)**2/flexibility
    pulls = [k*rows[-1]['R1']/50 for k in range(51)]
    bench.picture('shear_lag_bar', ('u', 'F', 'Bar on a flat base'), [
        (bench.form, bench.mark(), [pull*max(row['time'] - 1, 0) for row in rows],
         [row['R1'] for row in rows]),
        ('bar', 'k-', [force**2/flexibility for force in pulls], pulls)])
    for row in rows[5::5]:
        u = pull*(row['time'] - 1)
        bench.compare(f'u, at {row["time"] - 1:.1g} of the pull', 'exact (bar)', row['R1']**2/flexibility, u,
                      0.02)


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
