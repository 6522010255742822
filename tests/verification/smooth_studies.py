"""Smooth masters: sliders on faceted cylinders and spheres, with and without SMOOth."""
import math

import meshing

EXACT = 'exact (smooth body)'
STIFF = ('an elastic drum gives way more under the middle of a facet than under its edges and its rims; with facets of 7 '
         'degrees and a tip near the rim that is as much as the sag')
DOUBLY = ('the patches of a doubly curved surface are off the sphere by some hundredths of the depth of 0.5 %, and the '
          'pressure, penalty times gap, with them: see the row of the pressure')


def polar(radius, angle, z):
    """A point of a cylinder about the z axis; angle 0 is up (y)."""
    return radius*math.sin(angle), radius*math.cos(angle), z


def table(number, points):
    """A proportional load."""
    return f'PROPortional {number}\n' + ''.join(f'  {t!r} {p!r}\n' for t, p in points) + '\n'


def pin(mesh, tip, up, material):
    """One tetrahedron that stands on its tip; its nodes, the tip first."""
    h = 0.2
    first = len(mesh.nodes) + 1
    a, b = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    if abs(up[2]) > 0.5:
        b = (0.0, 1.0, 0.0)
    back = -1.0 if up[1] > 0.5 else 1.0
    corners = [(0.0, 0.0), (1.0, -1.0*back), (1.0, 1.0*back), (-1.0, 0.0)]
    for k, (u, v) in enumerate(corners):
        rise = h if k else 0.0
        mesh.nodes.append(tuple(tip[m] + rise*up[m] + h*(u*a[m] + v*b[m]) for m in range(3)))
    mesh.elements.append((material, first, first + 1, first + 2, first + 3))
    if mesh.volumes()[-1] < 0.0:
        mesh.elements[-1] = (material, first, first + 2, first + 1, first + 3)
    return list(range(first, first + 4))


def slider_deck(mesh, sets, fixed, moved, points, friction, smooth, penalty=1000.0):
    """A body that is fixed, a pin that is carried along the way of `points`: (time, (ux, uy, uz))."""
    text = ('MFEC * * Slider on a faceted surface\n\n' + meshing.solid(1, 1e3, 0.3)
            + 'MATErial 2\n  RIGId\n\n' + mesh.records())
    text += ''.join(meshing.node_set(name, numbers) for name, numbers in sets.items())
    text += f'SURFace under FROM face\n\nBOUNdary\n  {fixed} 1 1 1\n  {moved} 1 1 1\n\n'
    text += f'DISPlacement\n  {moved} 1 1 1\n\nFPROportional\n  {moved} 1 2 3\n\n'
    for k in range(3):
        text += table(k + 1, [(t, u[k]) for t, u in points])
    text += (f'CONTact\n  PAIR 1 slider\n    NTOS tip under\n    PENAlty {penalty!r}\n    {friction}\n'
             + ('    SMOOth\n' if smooth else '') + f'\nOUTPut\n  REACtions {moved}\n'
             '  FIELds NONE\n  STATe NONE\n\nEND\nBATCh\n'
             f'  DT,,1\n  STEP,,{len(points) - 1}\nEND\nSTOP\n')
    return text


def turn(bench, smooth, inside=False, material=2, cells=12, count=300):
    """A pin goes around a drum (or a bore) of flat facets; rows of the contact table and the depth."""
    drawn = bench.drawn[bench.case]
    radius, degrees, mu = drawn['radius'], drawn['degrees of a facet'], drawn['mu']
    depth = 0.005*radius
    sign = -1.0 if inside else 1.0
    step = math.radians(degrees)
    mesh = meshing.Mesh()

    def place(i, j, k):
        r = radius*(1 - sign*0.1*(1 - k))
        return polar(r, (i - cells/2)*step, 0.4*radius*(j - 0.5))

    drum = mesh.box((cells, 1, 1), place if not inside else lambda i, j, k: place(cells - i, j, k),
                    material=material)
    face = [drum(i, j, 1) for i in range(cells + 1) for j in (0, 1)]
    back = [drum(i, j, 0) for i in range(cells + 1) for j in (0, 1)]
    start = (drawn['phase'] - 3.8)*step
    x0 = polar(radius*(1 + sign*0.001), start, drawn['z']*radius)
    up = (0.0, sign, 0.0)
    nodes = pin(mesh, x0, up, 2)
    points = [(0.0, (0.0, 0.0, 0.0))]
    for k in range(count + 1):
        y = polar(radius - sign*depth, start + 6.6*step*k/count, drawn['z']*radius)
        points.append((float(k + 1), tuple(y[m] - x0[m] for m in range(3))))
    sets = {'tip': nodes[:1], 'pin': nodes, 'face': face, 'back': back if material == 1 else
            face + back}
    tables = bench.run_text('turn', slider_deck(mesh, sets, 'back', 'pin', points,
                                                f'FRICtion COULomb {mu!r}', smooth))
    return tables.contact('slider'), 1000.0*depth


def ripple(rows, name='Fn'):
    """Range of a force over its mean, once the pin slides."""
    values = [row[name] for row in rows[len(rows)//10:]]
    return (max(values) - min(values))/(sum(values)/len(values))


def turned(x, axis, angle):
    """A point turned about an axis through the origin (unit vector)."""
    c, s = math.cos(angle), math.sin(angle)
    along = (1.0 - c)*sum(a*b for a, b in zip(axis, x))
    across = (axis[1]*x[2] - axis[2]*x[1], axis[2]*x[0] - axis[0]*x[2],
              axis[0]*x[1] - axis[1]*x[0])
    return tuple(c*x[m] + s*across[m] + along*axis[m] for m in range(3))


def turning_tables(mesh, numbers, axis, angle, count, first, grow=1.0):
    """Displacements of a rigid body that grows from time 0 to 1 and then turns; its deck records.

    Each component of each node has a proportional load of its own.
    """
    lines, loads, tables = ['DISPlacement'], ['FPROportional'], []
    n = first
    for node in numbers:
        x = mesh.nodes[node - 1]
        ways = [turned(tuple(grow*v for v in x), axis, angle*k/count) for k in range(count + 1)]
        lines.append(f'  {node} 0 1 1 1')
        loads.append(f'  {node} 0 {n} {n + 1} {n + 2}')
        for m in range(3):
            tables.append(table(n, [(0.0, 0.0)] + [(1.0 + k, way[m] - x[m])
                                                    for k, way in enumerate(ways)]))
            n += 1
    return '\n'.join(lines) + '\n\n' + '\n'.join(loads) + '\n\n' + ''.join(tables)


def pressed_deck(mesh, sets, restrained, motion, count, smooth, penalty, mu):
    """A slave that is pressed by a master that grows, then turns."""
    text = 'MFEC * * Faceted bodies inside each other\n\n' + meshing.solid(1, 1e3, 0.3)
    text += 'MATErial 2\n  RIGId\n\n' + mesh.records()
    text += ''.join(meshing.node_set(name, numbers) for name, numbers in sets.items())
    text += 'SURFace inner FROM sole\nSURFace outer FROM face\n\nBOUNdary\n'
    text += ''.join(f'  {name} 1 1 1\n' for name in restrained) + '\n' + motion
    return text + (f'CONTact\n  PAIR 1 fit\n    NTOS inner outer\n    PENAlty {penalty}\n'
                   f'    FRICtion COULomb {mu!r}\n' + ('    SMOOth\n' if smooth else '') +
                   f'\nOUTPut\n  REACtions {restrained[0]}\n  FIELds contact\n  EVERy {count + 1}\n'
                   f'  STATe NONE\n\nEND\nBATCh\n  DT,,1\n  STEP,,{count + 1}\nEND\nSTOP\n')


def shaft(bench, smooth, count=24):
    """A rigid shaft of flat facets grows in an elastic ring and turns; contact rows and forces."""
    mesh, drawn = meshing.Mesh(), bench.drawn[bench.case]
    facets, segments = drawn['facets of the shaft'], drawn['facets of the ring']
    full = 2.0*math.pi

    def seam(counts, radius, shift, material):
        """A closed ring: box whose first and last columns are one."""
        number = mesh.box(counts, lambda i, j, k: polar(radius(k), (shift - i/counts[0])*full,
                                                        0.1*(j - 0.5)), material)
        n = counts[0]
        same = {number(n, j, k): number(0, j, k) for j in (0, 1) for k in range(counts[2] + 1)}
        mesh.elements = [(e[0],) + tuple(same.get(v, v) for v in e[1:]) for e in mesh.elements]
        return lambda i, j, k: number(i % n, j, k)

    ring = seam((segments, 1, 2), lambda k: 1.0 + 0.15*k, drawn['phase'], 1)
    rod = seam((facets, 1, 1), lambda k: 0.8 + 0.2*k, 0.0, 2)
    face = [rod(i, j, 1) for i in range(facets) for j in (0, 1)]
    rigid = face + [rod(i, j, 0) for i in range(facets) for j in (0, 1)]
    sets = {'wall': [ring(i, j, 2) for i in range(segments) for j in (0, 1)],
            'sole': [ring(i, j, 0) for i in range(segments) for j in (0, 1)], 'face': face,
            'rod': rigid}
    used = sorted({v for e in mesh.elements for v in e[1:]})
    place = {v: k for k, v in enumerate(used, 1)}
    mesh.nodes = [mesh.nodes[v - 1] for v in used]
    mesh.elements = [(e[0],) + tuple(place[v] for v in e[1:]) for e in mesh.elements]
    sets = {name: [place[v] for v in numbers] for name, numbers in sets.items()}
    motion = turning_tables(mesh, sets['rod'], (0.0, 0.0, 1.0), 1.7*full/facets, count, 1, 1.005)
    return bench.run_text('shaft', pressed_deck(mesh, sets, ['wall', 'rod'], motion, count, smooth,
                                                'AREA 1e5', drawn['mu']))


def ball(bench, smooth, count=12, cells=8):
    """A rigid cap of a sphere of flat facets grows into another and turns about z."""
    mesh, drawn = meshing.Mesh(), bench.drawn[bench.case]

    def cap(counts, half, radius, turn_by, material):
        def place(i, j, k):
            a, b = ((2.0*v/counts[m] - 1.0)*half for m, v in enumerate((i, j)))
            x = (math.tan(a), math.tan(b), 1.0)
            size = radius(k)/math.sqrt(sum(v*v for v in x))
            return turned(tuple(size*v for v in x), (drawn['lean'], 0.0, math.sqrt(1 - drawn['lean']**2)), turn_by)
        return mesh.box(counts, place, material)

    upper = cap((4, 4, 1), 0.25, lambda k: 1.0 + 0.1*k, drawn['turn'], 2)
    first = len(mesh.nodes) + 1
    lower = cap((cells, cells, 1), 0.6, lambda k: 0.9 + 0.1*k, 0.0, 2)
    sets = {'cap': list(range(1, first)), 'ball': list(range(first, len(mesh.nodes) + 1)),
            'sole': [upper(i, j, 0) for i in range(5) for j in range(5)],
            'face': [lower(i, j, 1) for i in range(cells + 1) for j in range(cells + 1)]}
    motion = turning_tables(mesh, sets['ball'], (0.0, 0.0, 1.0), 0.25, count, 1, 1.005)
    return bench.run_text('ball', pressed_deck(mesh, sets, ['cap', 'ball'], motion, count, smooth,
                                               'AREA 1000', drawn['mu'])), mesh, sets


def drum(bench):
    """A pin around a drum and in a bore: ripple with and without SMOOth; on flat facets no change."""
    mu = bench.draw('mu', 0.05, 0.5)
    bench.draw('radius', 0.5, 2.0)
    bench.draw('degrees of a facet', 6.0, 12.0)
    bench.draw('phase', 0.0, 1.0)
    bench.draw('z', -0.15, 0.15)
    for name, inside in (('drum', False), ('bore', True)):
        flat = turn(bench, False, inside)[0]
        smooth, force = turn(bench, True, inside)
        bench.compare(f'{name}: ripple with SMOOth over that without', 'at most a fifth wanted', 0.0,
                      ripple(smooth)/ripple(flat), 0.2, scale=1.0)
        worst = max(smooth[30:], key=lambda row: abs(row['Fn'] - force))
        bench.compare(f'{name}: Fn, farthest from eps g', EXACT, force, worst['Fn'], 0.005)
        worst = max(smooth[30:], key=lambda row: abs(row['Ft']/row['Fn'] - mu))
        bench.compare(f'{name}: Ft/Fn', EXACT, mu, worst['Ft']/worst['Fn'], 1e-10)
    plain = turn(bench, False, material=1)[0]
    bent = turn(bench, True, material=1)[0]
    bench.compare('elastic drum: ripple with SMOOth over that without', 'at most a fifth wanted', 0.0,
                  ripple(bent)/ripple(plain), 0.2, scale=1.0, known=1.5, why=STIFF)
    bench.remark(f'facets of {bench.drawn[bench.case]["degrees of a facet"]} degrees, depth 0.5 % of the radius: the force varies by '
                 f'{100*ripple(turn(bench, False)[0]):.0f} % without SMOOth and by '
                 f'{100*ripple(turn(bench, True)[0]):.2f} % with it')


def shaft_in_ring(bench):
    """A faceted shaft grows in an elastic ring and turns: pressure and torque are uniform."""
    mu = bench.draw('mu', 0.05, 0.4)
    facets, segments = bench.whole('facets of the shaft', 32, 40), bench.whole('facets of the ring', 25, 31)
    bench.draw('phase', 0.0, 1.0)
    rows = {smooth: shaft(bench, smooth).contact('fit')[3:] for smooth in (False, True)}
    torques = {k: [row['M3']/(mu*row['Fn']) for row in r] for k, r in rows.items()}
    spread = {k: max(t) - min(t) for k, t in torques.items()}
    bench.compare('ripple of torque, with SMOOth over without', 'at most a fifth wanted', 0.0,
                  spread[True]/spread[False], 0.2, scale=1.0)
    bench.compare('ripple of Fn with SMOOth', EXACT, 0.0, ripple(rows[True]), 1e-3, scale=1.0)
    bench.compare('torque/(mu Fn R), worst', EXACT, 1.0,
                  max(torques[True], key=lambda t: abs(t - 1.0)), 0.02)
    bench.remark(f'{facets} facets against {segments} nodes; without SMOOth torque/(mu Fn R) is '
                 f'{min(torques[False]):.3f} to {max(torques[False]):.3f}. What is left is the twist of the '
                 'ring, as moments are taken at reference positions')


def ball_in_ball(bench):
    """A faceted ball grows into a spherical cap and turns: pressure and moment against exact."""
    mu = bench.draw('mu', 0.05, 0.5)
    bench.draw('turn', 0.1, 0.35)
    bench.draw('lean', 0.3, 0.6)
    for smooth in (False, True):
        tables, mesh, sets = ball(bench, smooth)
        area = mesh.shares(sets['sole'])
        forces = tables.forces()
        pressure = [math.hypot(*forces[n])/area[n]/math.hypot(1.0, mu) for n in forces]
        exact = mu*5.0*sum(area[n]*math.hypot(*mesh.nodes[n - 1][:2]) for n in area)
        moment = tables.contact('fit')[-1]['M3']
        if not smooth:
            first = min(pressure)
            flat_moment = moment
            continue
        bench.compare('pressure, worst node', EXACT, 5.0,
                      max(pressure, key=lambda p: abs(p - 5.0)), 0.03)
        bench.compare('moment about the axis', EXACT, exact, moment, 1e-3, known=0.01, why=DOUBLY)
        bench.remark(f'8 facets over 69 degrees; without SMOOth the worst node has {first:.2f} of 5, the '
                     f'moment is {flat_moment/exact:.2f} of the exact one')
