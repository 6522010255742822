"""Carter's rolling with a tractive force: a cylinder on a half-plane of the same material.

The cylinder is a half-plane with a parabola below. It turns by prescribed displacements of its far
faces that are linear in the angle: they strain nothing, stretch the parabola by angle^2/2 and carry it
forward by angle^3/6, which tables take back. It comes down turned backwards, takes up a tangential
force (Cattaneo) and rolls, with the creepage that Carter has for this force, until its angle is zero.
The material under the contact is new by then. R is its radius, x goes from the middle of the contact.
"""
import math

import half_spaces
import line_studies as lines
import meshing
import quadratic_studies as quadratic

OUTER, WAY = 30.0, 6.0  # half of the width and the height of the bodies, the way of rolling, over a
PRESS, PUSH = 4, 4
SOURCE = 'exact (Carter)'
WHAT = ('pressure', 'shear traction', 'Q/(mu P) of the creepage', 'width of stick over 2 a')
WANTED = (0.02, 0.03, 0.02, 0.02)
# (nodes, facets in a): largest error of each that is known
KNOWN = {(4, 6): (0.17, 0.4, 0.03, 0.18), (4, 12): (0.09, 0.38, 0.02, 0.07), (4, 24): (0.065, 0.27, 0.02, 0.05),
         (10, 6): (0.02, 0.03, 0.02, 0.07), (10, 12): (0.02, 0.03, 0.02, 0.03)}
POINTS = ('tractions of four-node elements change from facet to facet, as in "line, partial slip"; the ends of the '
          'zone of stick lie between points')


class Rolling(lines.Cylinders):
    """The mesh: the upper body has the parabola, above its place of touch by `lift`."""

    def __init__(self, radius, a, cell, coarser, ten, lift):
        self.lift = lift
        super().__init__(radius, a, cell, coarser, ten, outer=OUTER, way=WAY*a)

    def rise(self, x, sign):
        """Height of the profile of a body."""
        return self.lift + x*x/(2*self.radius) if sign > 0 else 0.0


class Carter(lines.Exact):
    """The steady state at Q = share mu P; `radius` of the cylinder, the plane has none."""

    def __init__(self, radius, young, nu, mu, force):
        super().__init__(2*radius, young, nu, mu, force)
        self.radius = radius

    def creepage(self, share):
        """Way of sliding over way of rolling."""
        return self.mu*(self.a - self.stick(share))/self.radius

    def share_of(self, creepage):
        """Q/(mu P) of a creepage."""
        return 1 - (1 - creepage*self.radius/(self.mu*self.a))**2

    def traction(self, share):
        """q(x): the zone of stick begins where material enters, on the right."""
        c = self.stick(share)
        return lambda x: self.mu*(self.ellipse(x, self.a) - self.ellipse(x - self.a + c, c))

    def approach(self, reach):
        """Normal approach of far faces at a distance that stands for `reach`."""
        return self.soft*self.force*(math.log(reach) - lines.logarithm(0, self.a))

    def slide(self, share, reach):
        """Tangential approach of them (Cattaneo)."""
        return self.shift(share) + self.soft*self.mu*self.force*share*math.log(reach)


def motions(exact, share, lift, reach, cells):
    """Tables of angle, way forward and way up of the cylinder, and the batch's records; reach: what the
    far faces' distance stands for, normal and tangential; without cells: up to the force alone."""
    radius, start = exact.radius, -WAY*exact.a/exact.radius
    depth, slide = lift + exact.approach(reach[0]), exact.slide(share, reach[1])
    rows = [(0, 0, 0, 0), (1, start, 0, 0), (2, start, 0, depth), (3, start, slide, depth)]
    for k in range(1, cells + 1):
        angle = start*(1 - k/cells)
        rows.append((3 + k/cells, angle, slide + exact.creepage(share)*radius*(angle - start), depth))
    tables = [[(t, angle) for t, angle, _, _ in rows],
              [(t, way - radius*angle**3/6) for t, angle, way, _ in rows],
              [(t, radius*angle**2/2 - down) for t, angle, _, down in rows]]
    batch = ''.join(f'  DT,,{1/n!r}\n  STEP,,{n}\n' for n in (1, PRESS, PUSH) + (cells,)*(cells > 0))
    return ''.join(half_spaces.table(k, points) for k, points in enumerate(tables, 1)), batch


def deck(body, exact, nu, young, form, motion):
    """Far faces of the plane are held, those of the cylinder move with it."""
    side, *points = form.split()
    tables, batch = motion
    text = ('MFEC * * A cylinder rolls with a tractive force\n\n' + meshing.solid(1, young, nu) +
            quadratic.records(body.mesh) +
            ''.join(meshing.node_set(name, numbers) for name, numbers in body.parts.items()) +
            'SURFace above FROM upper\nSURFace below FROM lower\n\n'
            f'SET everything\n  NODEs 1 TO {len(body.mesh.nodes)}\n\n'
            'BOUNdary\n  everything 0 1 0\n  upper_far 1 0 1\n  lower_far 1 0 1\n\nDISPlacement\n')
    for n in body.parts['upper_far']:
        x, _, z = body.mesh.nodes[n - 1]
        text += f'  {n} 0 {z - body.lift!r} 0 {-x!r} 1\n'
    return (text + '  upper_far 1 0 0 2\n  upper_far 0 0 1 3\n\n' + tables +
            f'CONTact\n  PAIR 1 line\n    {side} above below ' + ' '.join(points) + '\n'
            f'    PENAlty AUTO\n    FRICtion COULomb {exact.mu!r}\n\n'
            'OUTPut\n  REACtions upper_far\n  FIELds contact\n  STATe NONE\n\nEND\nBATCh\n' +
            batch + 'END\nSTOP\n')


def found_reach(body, row, exact, share, reach, nu, young):
    """What the far faces stood for, from the forces that came with their motion."""
    found = Carter(exact.radius, young, nu, exact.mu, abs(row['F3'])/body.thick)
    part = -row['F1']/(exact.mu*abs(row['F3']))
    depth, slide = exact.approach(reach[0]), exact.slide(share, reach[1])
    return (math.exp(depth/(found.soft*found.force) + lines.logarithm(0, found.a)),
            math.exp((slide - found.shift(part))/(found.soft*exact.mu*found.force*part)))


def judge(body, tables, nu, young, mu, creepage, radius):
    """Errors of p and q, and Q/(mu P) and the width of the zone of stick beside Carter's, at the end."""
    row = tables.contact('line')[-1]
    force, share = abs(row['F3'])/body.thick, -row['F1']/(mu*abs(row['F3']))
    exact, hats = Carter(radius, young, nu, mu, force), lines.Hats(body.columns)
    columns, points = {n: x[0] for n, x in enumerate(body.mesh.nodes, 1)}, tables.points()[-1]
    with tables.results() as file:
        status = file['contact/1/status'][-1]
    sums, sticking = [[0.0]*len(hats.x) for _ in range(2)], []
    for numbers, weight, f, state in zip(*points, status):
        x = sum(w*columns[n] for n, w in zip(numbers, weight))
        hats.add(sums[0], x, f[2]/body.thick)
        hats.add(sums[1], x, -f[0]/body.thick)
        if state == 1:
            sticking.append(x)
    wanted = [hats.exact(g) for g in (lambda x: exact.ellipse(x, exact.a), exact.traction(share))]
    errors = [hats.error(f, e) for f, e in zip(sums, wanted)]
    curve = [(x/exact.a, q/w/(mu*exact.top)) for x, q, w in zip(hats.x, sums[1], hats.widths)
             if abs(x) < 1.3*exact.a]
    return errors, share, exact, (max(sticking) - min(sticking))/(2*exact.a), curve


def carter(bench):
    """A tractive force of a share of the limit: traction, force and stick where rolling is steady."""
    radius = bench.draw('R', 20.0, 100.0)
    # small, for the stress of the linear cylinder does not turn with it
    a = bench.draw('a/R', 0.001, 0.002)*radius
    young, nu = bench.draw('E', 500.0, 50000.0), bench.draw('nu', 0.1, 0.4)
    mu, share = bench.draw('mu', 0.2, 0.5), bench.draw('Q/(mu P)', 0.4, 0.7)
    coarser = bench.draw('master over slave', 1.1, 1.35)
    wanted = Carter(radius, young, nu, mu, a*a*math.pi*young/(8*(1 - nu**2)*radius))
    creepage, reach = wanted.creepage(share), (OUTER*a, OUTER*a)

    def rolled(size, nodes, form, turning=True):
        body = Rolling(radius, a, a/size, coarser, nodes == 10, wanted.approach(reach[0]))
        motion = motions(wanted, share, body.lift, reach, round(WAY*size) if turning else 0)
        return body, bench.run_text('rolling', deck(body, wanted, nu, young, form, motion))
    body, tables = rolled(6, 4, 'GTOS', False)
    reach = found_reach(body, tables.contact('line')[-1], wanted, share, reach, nu, young)
    profiles = []
    for nodes, form in lines.FORMS:
        sizes, errors = [size for kind, size in KNOWN if kind == nodes], []
        for size in sizes[1:2] if bench.reduced else sizes:
            both, part, exact, stick, curve = judge(*rolled(size, nodes, form), nu, young, mu, creepage, radius)
            pairs = [(0.0, e) for e in both] + [(exact.share_of(creepage), part),
                                                (exact.stick(part)/exact.a, stick)]
            errors.append([bench.compare(f'{what}, {nodes} nodes', SOURCE, *pair, limit, scale=1.0, known=known,
                                         form=form, mesh=f'{size} facets in a', why=POINTS)
                           for what, pair, limit, known in zip(WHAT, pairs, WANTED, KNOWN[nodes, size])])
        if bench.reduced:
            continue
        bench.remark(f'{form}, {nodes} nodes, orders of ' + '; '.join(f'{what} ' + ', '.join(
            f'{rate:.1f}' for rate in half_spaces.rates([1/size for size in sizes], column))
            for what, column in zip(WHAT, zip(*errors))))
        label, mark = f'{form}, {nodes} nodes', 'o' if nodes == 4 else 's'
        if form == 'GTOS SEGMent':
            profiles.append((f'{label}, {size} facets in a', mark, *zip(*curve)))
    if profiles:
        line = [k/100 - 1 for k in range(201)]
        q = wanted.traction(share)
        bench.picture('rolling_traction', ('x/a, rolling to the right', 'q/(mu p0)', "Carter's rolling"), profiles + [
            ('Carter', 'k-', line, [q(x*wanted.a)/(mu*wanted.top) for x in line])])
