"""Partial slip of two equal cylinders in plane strain, facet by facet: Cattaneo and Mindlin's tractions
and what friction takes, while the tangential force grows, falls and turns round.

Half-planes are of one material, so pressing and pushing do not see each other (Johnson, Contact
Mechanics, 7.2 and 7.5). With L(x) the integral of the logarithm over a half-ellipse of unit weight,
displacements at the surface are those of the logarithms of both half-ellipses of the traction.
"""
import bisect
import itertools
import math

import half_spaces
import meshing
import quadratic_studies as quadratic

OUTER = 12.0  # half of the bodies' width and their height, over the half-width of contact
PRESS, PUSH = 4, 4
ENDS = (0.8, -0.5, 0.8)  # Q/(mu P) at the ends of the three phases after pressing
FORMS = ((4, 'NTOS'), (4, 'GTOS'), (4, 'GTOS SEGMent'), (4, 'MORTar'),
         (10, 'GTOS'), (10, 'GTOS SEGMent'), (10, 'MORTar'))
WHAT = ('pressure', 'shear traction', 'dissipated energy', 'sum of dissipated energy')
SOURCE = 'exact (Cattaneo, Mindlin, Masing)'
# (nodes, facets in the half-width of contact): largest error of each that is wanted, and that is known
WANTED = (0.02, 0.03, 0.05, 0.05)
# Of a flat punch's sole, where the mean traction over a hat is no statement about its singular edge.
INNER = 0.9
KNOWN = {(4, 6): (0.12, 0.4, 0.55, 0.1), (4, 12): (0.1, 0.28, 0.3, 0.06), (4, 24): (0.08, 0.15, 0.2, 0.05),
         (10, 6): (0.02, 0.04, 0.09, 0.06), (10, 12): (0.02, 0.03, 0.06, 0.05)}


# Of MORTar, where it is more than that.
KNOWN_MORTAR = {(10, 6): (0.02, 0.06, 0.09, 0.06)}
NODES = ('the tractions are those of single nodes, which a penalty evens out: with GTOS SEGMent and AUTO 1000 the pressure is off by '
         '5.8 % with four nodes and 12 facets in a, the shear by 20 %, half way to MORTar. With ten nodes and 12 facets all hold')


SINGULAR = ('the traction is singular at both edges, and on four-node elements those of single facets differ the more the '
            'stiffer the penalty is (.2 with AUTO 10); inside 0.9 a all but one hold')
ACROSS = ('the edge of the punch, which has to be the master, lies inside facets of the plane: their dual functions '
          'act on nodes beyond it as on those below it, so these carry a force (11 % of all with 12 facets in a), and the punch '
          'is wider by part of a facet')


def logarithm(x, c):
    """Integral of 2/(pi c^2) sqrt(c^2 - s^2) ln|x - s| over |s| < c."""
    x = abs(x)
    if c <= 0:
        return math.log(x)
    if x <= c:
        return x*x/c**2 + math.log(c/2) - 0.5
    root = math.sqrt(x*x - c*c)
    return math.log((x + root)/2) + x*(x - root)/c**2 - 0.5


def line_load(x, z, nu, young):
    """Displacements (x, z) of a half-plane z > 0 by unit forces at its origin, along z and along x
    (Johnson 2.19 and 2.22); the surface moves by -2 (1 - nu^2)/(pi E) ln|x| along each."""
    r, one = math.hypot(x, z), (1 + nu)/(math.pi*young)
    log, bent = 2*(1 - nu)*one*math.log(r), (1 - 2*nu)*one

    def turned(angle):
        # radial and hoop, angle from the force; a shift takes the constant at the surface away
        s, c = math.sin(angle), math.cos(angle)
        return s, c, -log*c, log*s + one*s
    angle = math.atan2(x, z)
    s, c, radial, hoop = turned(angle)
    radial, hoop = radial - bent*angle*s + one*c, hoop - bent*angle*c - one*s
    normal = radial*s + hoop*c, radial*c - hoop*s
    angle = math.atan2(z, x)
    s, c, radial, hoop = turned(angle)
    radial, hoop = radial - bent*(angle - math.pi/2)*s, hoop - bent*(angle - math.pi/2)*c
    return normal, (radial*c - hoop*s, radial*s + hoop*c)


class Cylinders:
    """Their mesh: slices of one cell, the lower one coarser; sets of faces."""

    def __init__(self, radius, a, cell, coarser, ten, *, outer=OUTER, way=0.0):
        """way: by which the place of contact moves to x = 0, from the left."""
        self.radius, self.a, self.thick, self.high, self.way = radius, a, cell, outer*a, way
        self.mesh, self.parts = meshing.Mesh(), {}
        for name, sign, size in (('upper', 1, cell), ('lower', -1, cell*coarser)):
            self.add(name, sign, size, ten)

    def rise(self, x, _):
        """Height of the profile of a body, flat beyond 2 a."""
        return min(x*x, 4*self.a**2)/(2*self.radius)

    def add(self, name, sign, cell, ten):
        """One body: a mesh of its own, mapped to the profile, then put beside the others."""
        right, left = (half_spaces.graded(cell, 1.3*self.a + way, self.high + way, 1.3) for way in (0.0, self.way))
        across = [-x for x in reversed(left[1:])] + right
        levels = half_spaces.graded(cell, 0.5*self.a, self.high, 1.3)
        body = meshing.Mesh()
        body.box((len(across) - 1, 1, len(levels) - 1),
                 lambda i, j, k: (across[i], j*self.thick, levels[k]), turned='alternate')
        if ten:
            body = quadratic.ten_nodes(body)
        first, limit, far = len(self.mesh.nodes), 1.3*self.a + 1.5*cell, 1 - 1e-9
        if sign > 0:
            self.columns = [x for x in across if -limit - self.way < x < limit]
        self.parts[name] = [first + n for n, x in enumerate(body.nodes, 1)
                            if x[2] == 0 and -limit - self.way < x[0] < limit]
        self.parts[name + '_far'] = [first + n for n, x in enumerate(body.nodes, 1)
                                     if max(x[0], -x[0] - self.way, x[2]) > far*self.high]
        self.mesh.nodes += [(x, y, sign*(z + self.rise(x, sign)*(1 - z/self.high))) for x, y, z in body.nodes]
        # mirrored, the lower body's elements are numbered the other way round; the program turns them
        self.mesh.elements += [(m, *(first + n for n in nodes)) for m, *nodes in body.elements]


class Exact:
    """Tractions, slip and dissipation for the force P per thickness that a run has found."""

    def __init__(self, radius, young, nu, mu, force):
        self.mu, self.force = mu, force
        self.soft = 4*(1 - nu**2)/(math.pi*young)  # both surfaces move by this times the logarithm
        self.a = math.sqrt(2*force*radius*2*(1 - nu**2)/(math.pi*young))
        self.top = 2*force/(math.pi*self.a)

    def ellipse(self, x, c):
        """Half-ellipse of the pressure's curvature, of half-width c."""
        return self.top/self.a*math.sqrt(c*c - x*x) if abs(x) < c else 0.0

    def stick(self, share):
        """Half-width of the stick zone at Q = share mu P."""
        return self.a*math.sqrt(1 - share)

    def shift(self, share):
        """Tangential approach of far points at Q = share mu P, of logarithms; the loading alone."""
        c = self.stick(share)
        return -self.soft*self.mu*self.force*(logarithm(0, self.a) - (c/self.a)**2*logarithm(0, c))

    def slip(self, x, share):
        """Way that the surfaces have slipped at x when Q has grown from 0 to share mu P."""
        c = self.stick(share)
        if abs(x) <= c:
            return 0.0
        return self.soft*self.mu*self.force*(c/self.a)**2*(logarithm(0, c) - logarithm(x, c) + (x/c)**2)

    def phases(self, ends):
        """(traction, dissipation so far) as functions of x at the end of each phase: a phase that turns
        round adds twice what half of its force would do to a fresh contact (Masing)."""
        traction, work, last, result = (lambda x: 0.0), (lambda x: 0.0), 0.0, []
        for k, end in enumerate(ends):
            twice, sign = (1, 1) if k == 0 else (2, math.copysign(1, end - last))
            share = abs(end - last)/twice
            c = self.stick(share)

            def added(x, c=c, factor=sign*twice):
                return factor*self.mu*(self.ellipse(x, self.a) - self.ellipse(x, c))

            def lost(x, share=share, twice=twice):
                return self.mu*self.ellipse(x, self.a)*twice*self.slip(x, share)
            traction = (lambda x, f=traction, g=added: f(x) + g(x))
            work = (lambda x, f=work, g=lost: f(x) + g(x))
            result.append((traction, work))
            last = end
        return result


def loads(exact, high):
    """Tables over time of what moves the far faces, as (name, points): force P, normal shift, force Q,
    tangential shift. The half-width of contact grows evenly while pressing."""
    force = [(k/PRESS)**2 for k in range(PRESS + 1)]
    steps = [(k/PRESS, share) for k, share in enumerate(force)]
    normal = [(t, -share*exact.soft/2*exact.force*(logarithm(0, exact.a*math.sqrt(share)) if share else 0))
              for t, share in steps]
    shares, shifts, last, base = [(1.0, 0.0)], [(1.0, 0.0)], 0.0, 0.0
    for k, end in enumerate(ENDS):
        twice = 1 if k == 0 else 2
        for m in range(1, PUSH + 1):
            time, share = 1 + k + m/PUSH, last + (end - last)*m/PUSH
            shares.append((time, share))
            shift = exact.shift(abs(share - last)/twice)/2
            shifts.append((time, base + twice*(shift if end > last else -shift)))
        last, base = end, shifts[-1][1]
    return steps, normal, shares, shifts


def deck(body, exact, nu, young, form, penalty):
    """Far faces move as those of half-planes under the line forces do, and by the shifts."""
    side, *points = form.split()
    text = ('MFEC * * Two cylinders, partial slip\n\n' + meshing.solid(1, young, nu) +
            quadratic.records(body.mesh) +
            ''.join(meshing.node_set(name, numbers) for name, numbers in body.parts.items()) +
            'SURFace above FROM upper\nSURFace below FROM lower\n\n'
            f'SET everything\n  NODEs 1 TO {len(body.mesh.nodes)}\n\n'
            'BOUNdary\n  everything 0 1 0\n  upper_far 1 0 1\n  lower_far 1 0 1\n\nDISPlacement\n')
    pressed = exact.mu*exact.force
    for name, sign in (('upper', 1), ('lower', -1)):
        for n in body.parts[name + '_far']:
            x, _, z = body.mesh.nodes[n - 1]
            normal, along = line_load(x, abs(z), nu, young)
            text += (f'  {n} 0 {normal[0]*exact.force!r} 0 {sign*normal[1]*exact.force!r} 1\n'
                     f'  {n} 0 {-sign*along[0]*pressed!r} 0 {-along[1]*pressed!r} 3\n')
        text += f'  {name}_far 0 0 {-sign} 2\n  {name}_far {sign} 0 0 4\n'
    text += '\n' + ''.join(half_spaces.table(k, t) for k, t in enumerate(loads(exact, body.high), 1))
    return (text + f'CONTact\n  PAIR 1 line\n    {side} above below ' + ' '.join(points) + '\n'
            f'    PENAlty {penalty}\n    FRICtion COULomb {exact.mu!r}\n\n'
            'OUTPut\n  REACtions upper_far\n  FIELds contact\n  STATe NONE\n\nEND\nBATCh\n'
            f'  DT,,{1/PRESS!r}\n  STEP,,{PRESS}\n  DT,,{1/PUSH!r}\n  STEP,,{PUSH*len(ENDS)}\nEND\nSTOP\n')


class Hats:
    """Integrals of traction times hat functions between the columns of the slave's corner nodes: what
    forces at points say of a traction, whatever their rule."""

    def __init__(self, columns):
        self.x = sorted(columns)
        self.widths = [(b - a)/2 for a, b in zip([self.x[0]] + self.x, self.x[1:] + [self.x[-1]])]

    def add(self, sums, x, value):
        """Adds a force at x."""
        k = min(max(bisect.bisect_right(self.x, x) - 1, 0), len(self.x) - 2)
        share = (x - self.x[k])/(self.x[k + 1] - self.x[k])
        sums[k] += (1 - share)*value
        sums[k + 1] += share*value

    def exact(self, function, cuts=40):
        """The integrals of a function."""
        sums = [0.0]*len(self.x)
        for a, b in zip(self.x, self.x[1:]):
            for i in range(cuts):
                x = a + (b - a)*(i + 0.5)/cuts
                self.add(sums, x, function(x)*(b - a)/cuts)
        return sums

    def norm(self, sums, within=math.inf):
        """Norm of the means, of the hats that lie within |x| < within."""
        return math.sqrt(sum(v*v/w for x, v, w in zip(self.x, sums, self.widths) if abs(x) + w < within))

    def error(self, found, wanted, within=math.inf):
        """Norm of the error of the means over the norm of the means themselves."""
        return self.norm([f - e for f, e in zip(found, wanted)], within)/self.norm(wanted, within)


def judge(body, tables, nu, young, mu):
    """Errors of p, q, dissipation (its mean and its sum) and stick width at the end of each phase."""
    first, last = PRESS - 1, PRESS + PUSH*len(ENDS) - 1
    with tables.results() as file:
        lost = file['contact/1/dissipation'][:]
    hats = Hats(body.columns)
    columns, points = {n: x[0] for n, x in enumerate(body.mesh.nodes, 1)}, tables.points()
    rows = tables.contact('line')
    force = abs(rows[first]['F3'])/body.thick
    ends = [abs(rows[first]['F3'])]
    ends = [-rows[first + PUSH*(k + 1)]['F1']/(mu*ends[0]) for k in range(len(ENDS))]
    exact, result = Exact(body.radius, young, nu, mu, force), []
    for phase, (traction, work) in enumerate(exact.phases(ends)):
        step = first + PUSH*(phase + 1)
        sums = [[0.0]*len(hats.x) for _ in range(3)]
        for numbers, share, f, energy in zip(*points[step], lost[step]):
            x = sum(w*columns[n] for n, w in zip(numbers, share))
            for one, value in zip(sums, (f[2], f[0], energy)):
                hats.add(one, x, value/body.thick)
        wanted = [hats.exact(g) for g in (lambda x: exact.ellipse(x, exact.a), traction, work)]
        sums[1] = [-v for v in sums[1]]
        result.append([hats.error(f, e) for f, e in zip(sums, wanted)] +
                      [abs(sum(sums[2])/sum(wanted[2]) - 1)])
    return result


def partial_slip(bench):
    """Tractions and dissipation, worst end of a phase, over the facets; orders below the table."""
    radius = bench.draw('R', 20.0, 100.0)
    a = bench.draw('a/R', 0.02, 0.03)*radius
    young, nu = bench.draw('E', 500.0, 50000.0), bench.draw('nu', 0.1, 0.4)
    mu, coarser = bench.draw('mu', 0.1, 0.5), bench.draw('master over slave', 1.1, 1.35)
    force = a*a*math.pi*young/(4*(1 - nu**2)*radius)
    for nodes, form in FORMS:
        sizes = [size for kind, size in KNOWN if kind == nodes]
        sizes = sizes[1:2] if bench.reduced else sizes
        worst = []
        for size in sizes:
            body = Cylinders(radius, a, a/size, coarser, nodes == 10)
            exact = Exact(radius, young, nu, mu, force)
            tables = bench.run_text('line', deck(body, exact, nu, young, form, 'AUTO'))
            phases = judge(body, tables, nu, young, mu)
            worst.append([max(column) for column in zip(*phases)])
            limits = KNOWN[nodes, size] if form != 'MORTar' else KNOWN_MORTAR.get((nodes, size), KNOWN[nodes, size])
            for what, error, wanted, known in zip(WHAT, worst[-1], WANTED, limits):
                bench.compare(f'{what}, {nodes} nodes', SOURCE, 0.0, error, wanted, scale=1.0, known=known,
                              form=form, mesh=f'{size} facets in a', why=NODES if form == 'MORTar' else '')
        if bench.reduced:
            continue
        orders = [half_spaces.rates([1/size for size in sizes], [w[k] for w in worst]) for k in range(3)]
        bench.remark(f'{form}, {nodes} nodes, orders of ' + '; '.join(
            f'{what} ' + ', '.join(f'{rate:.1f}' for rate in rates) for what, rates in zip(WHAT, orders)))


class Punch:
    """A rigid flat punch |x| < a on half of a plane, its corners exact: the punch is the slave."""

    def __init__(self, a, size, coarser, ten):
        self.a, self.high, self.thick = a, OUTER*a, a/size
        self.mesh, self.parts = meshing.Mesh(), {}
        right = half_spaces.graded(a/size/coarser, 1.2*a, self.high, 1.3)
        across = [-x for x in reversed(right[1:])] + right
        levels = half_spaces.graded(a/size/coarser, 0.3*a, self.high, 1.3)
        self.mesh.box((len(across) - 1, 1, len(levels) - 1),
                      lambda i, j, k: (across[i], j*self.thick, -levels[k]), turned='alternate')
        self.columns, self.plane = [a*(i/size - 1) for i in range(2*size + 1)], across
        self.kind = 'TET10' if ten else 'TET4'
        if ten:
            self.mesh = quadratic.ten_nodes(self.mesh)
        nodes, far = list(enumerate(self.mesh.nodes, 1)), (1 - 1e-9)*self.high
        self.parts['plane'] = [n for n, x in nodes if x[2] == 0]
        self.parts['far'] = [n for n, x in nodes if max(abs(x[0]), -x[2]) > far]
        self.parts['plane_strain'] = [n for n, _ in nodes]

    def block(self):
        """The punch, one cell high."""
        places = ((x, y, z) for z in (0, self.thick) for x, y in (
            (-self.a, 0), (self.a, 0), (self.a, self.thick), (-self.a, self.thick)))
        return (f'BLOCk punch\n  CART {len(self.columns) - 1} 1 1 MATErial 2 {self.kind}\n' +
                ''.join(f'  {k} {x!r} {y!r} {z!r}\n' for k, (x, y, z) in enumerate(places, 1)) +
                '\nSET sole\n  PLANe 3 0\n  INSIde punch\n\n')


def punch_deck(punch, nu, young, mu, force, side, form):
    """Pressed by a force; side: how far it is then drawn along x (0: it sticks). With MORTar the plane is
    the slave, which must deform."""
    pair = 'MORTar top under' if form == 'MORTar' else 'GTOS under top SEGMent'
    text = ('MFEC * * Flat punch\n\n' + meshing.solid(1, young, nu) + 'MATErial 2 punch\n  RIGId\n\n' +
            quadratic.records(punch.mesh) + punch.block() +
            ''.join(meshing.node_set(name, numbers) for name, numbers in punch.parts.items()) +
            'SURFace under FROM sole IN punch\nSURFace top FROM plane\n\n'
            'BOUNdary\n  plane_strain 0 1 0\n  far 1 0 1\n\nDISPlacement\n')
    for n in punch.parts['far']:
        x, _, z = punch.mesh.nodes[n - 1]
        normal, along = line_load(x, -z, nu, young)
        pull = mu*force if side else 0.0
        text += (f'  {n} 0 {normal[0]*force!r} 0 {-normal[1]*force!r} 1\n'
                 f'  {n} 0 {along[0]*pull!r} 0 {-along[1]*pull!r} 2\n')
    return (text + '\n' + half_spaces.table(1, ((0, 0), (1, 1))) + half_spaces.table(2, ((1, 0), (2, 1))) +
            f'RIGId punch\n  POINt 0 0 0\n  MOVE {side!r} 0 FREE 2\n  TURN 0 1 0 0\n'
            f'  LOAD 0 0 {-force*punch.thick!r} 0 0 0 1\n\n'
            f'CONTact\n  PAIR 1 line\n    {pair}\n    FRICtion COULomb {mu!r}\n\nOUTPut\n  FIELds contact\n  STATe NONE\n\nEND\nBATCh\n'
            f'  DT,,1\n  STEP,,1\n' + ('  DT,,0.25\n  STEP,,4\n' if side else '') + 'END\nSTOP\n')


def stuck(x, a, nu):
    """Pressure and shear, outwards on the plane, under a bonded punch, over the force (Abramov; Mossakovskii has the round one)."""
    eta = math.log(3 - 4*nu)/(2*math.pi)
    top = 2*(1 - nu)/(math.pi*math.sqrt(3 - 4*nu)*math.sqrt(a*a - x*x))
    angle = eta*math.log((a + x)/(a - x))
    return top*math.cos(angle), top*math.sin(angle)


def sliding(x, a, nu, mu):
    """Pressure of a punch that slides towards +x over the force (Bufler; Johnson 2.5)."""
    bent = math.atan(mu*(1 - 2*nu)/(2*(1 - nu)))/math.pi
    return math.cos(math.pi*bent)/(math.pi*math.sqrt(a*a - x*x))*((a - x)/(a + x))**bent


def punches(bench):
    """Mean tractions between columns of the slave, and their orders, of a bonded and of a sliding punch."""
    a, young = bench.draw('a', 0.5, 5.0), bench.draw('E', 500.0, 50000.0)
    nu, mu, coarser = bench.draw('nu', 0.0, 0.3), bench.draw('mu', 0.2, 0.8), bench.draw('sole over plane', 1.1, 1.6)
    force = 1e-4*young*a
    for nodes, form in itertools.product((4, 10), ('GTOS SEGMent', 'MORTar')):
        errors, sizes = [], (6, 12, 24) if nodes == 4 else (3, 6, 12)
        for size in sizes:
            punch = Punch(a, size, coarser, nodes == 10)
            # of the slave, whose forces are along the axes of the plane or against them
            hats, sign = (Hats(punch.plane), -1) if form == 'MORTar' else (Hats(punch.columns), 1)
            found = []
            for friction, side in ((1000.0, 0.0), (mu, 0.01*a)):
                tables = bench.run_text('punch', punch_deck(punch, nu, young, friction, force, side, form))
                sums = [0.0]*len(hats.x), [0.0]*len(hats.x)
                with tables.results() as file:
                    places = file['VTKHDF/Points'][:, 0]
                for numbers, share, f in zip(*tables.points()[-1]):
                    x = sum(w*places[n - 1] for n, w in zip(numbers, share))
                    for one, value in zip(sums, (f[2]*sign, f[0]*sign)):
                        hats.add(one, x, value/punch.thick/force)
                found.append(sums)
            bonded = [hats.exact(lambda x, k=k: stuck(x, a, nu)[k] if abs(x) < a else 0.0, 4000) for k in (0, 1)]
            slid = hats.exact(lambda x: sliding(x, a, nu, mu) if abs(x) < a else 0.0, 4000)
            shear = [-f - e for f, e in zip(found[0][1], bonded[1])]
            errors.append(())
            for within, name in ((math.inf, ''), (INNER*a, f', inside {INNER} a')):
                whole = math.hypot(*(hats.norm(b, within) for b in bonded))
                errors[-1] += (hats.error(found[0][0], bonded[0], within), hats.norm(shear, within)/whole,
                               hats.error(found[1][0], slid, within))
                for what, error in zip(('pressure, bonded', 'shear, bonded', 'pressure, sliding'), errors[-1][-3:]):
                    bench.compare(f'{what}{name}, {nodes} nodes', 'exact (Abramov, Bufler)', 0.0, error, 0.05,
                                  scale=1.0, known=0.1 if name else 0.8 if form == 'MORTar' else 0.4, form=form,
                                  mesh=f'{size} facets in a', why=ACROSS if form == 'MORTar' else SINGULAR)
        bench.remark(f'{form}, {nodes} nodes, orders: ' + '; '.join(
            ', '.join(f'{rate:.1f}' for rate in half_spaces.rates([1/s for s in sizes], column))
            for column in zip(*errors)) + ' (singular edges: 0.5 in this norm is the best there is)')
