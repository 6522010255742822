"""Concentric rings and spheres of two materials, meshed without structure on both sides: Lame."""
import math

import meshing
import quadratic_studies as quadratic
import unstructured

FORMS = ('NTOS', 'GTOS', 'GTOS SEGMent', 'GTOS +AUGM', 'NTOS +SMOO', 'GTOS +SMOO', 'GTOS SEGMent +SMOO')
BENT = ('NTOS +SMOO', 'GTOS +SMOO', 'GTOS SEGMent +SMOO')
RATIO = 1.27
FLAT = ('the two surfaces are polyhedra. The master\'s chords lie inside the circle, a mean overlap of H^2/12 c that SMOOth '
        'takes away; the slave\'s facets lie inside as well, a mean gap of h^2/12 c that GTOS sees and SMOOth takes away '
        'likewise. The bodies meet too early or too late by that')
STIFF = ('linear tetrahedra are too stiff: the same bodies have as much too large a force where the circles (spheres) of '
         'the interface move as they should, and no contact is there (rows below). What SMOOth leaves beyond that '
         'is a tenth of it')
SOFT = ('linear tetrahedra have one stress each: with the exact displacements at the interface in place of contact the '
        'error is the same (row below)')


class Lame:
    """u = A r + B/r^k in two bodies that meet at c; k = 1 rings in plane strain, 2 spheres."""

    def __init__(self, k, radii, young, nu, way, compliance):
        a, c, b = radii
        self.k, self.c = k, c
        self.moduli = [(e/((1 + n)*(1 - 2*n)), e/(1 + n), n) for e, n in zip(young, nu)]

        def radial(body, r):
            """Factors of A and B in the radial stress."""
            stiff, shear, n = self.moduli[body]
            return (stiff, -shear/r**2) if k == 1 else (stiff*(1 + n), -2*shear/r**3)
        inner, outer = radial(0, c), radial(1, c)
        free = radial(1, b)
        rows = [[a, a**-k, 0.0, 0.0, way], [0.0, 0.0, *free, 0.0], [*inner, -outer[0], -outer[1], 0.0],
                [c + compliance*inner[0], c**-k + compliance*inner[1], -c, -c**-k, 0.0]]
        self.factors = solved(rows)
        self.pressure = -(inner[0]*self.factors[0] + inner[1]*self.factors[1])

    def way(self, body, r):
        """Displacement at a radius."""
        return self.factors[2*body]*r + self.factors[2*body + 1]/r**self.k

    def stress(self, body, x):
        """Stress (xx, yy, zz, xy, yz, zx) at a place."""
        stiff, shear, n = self.moduli[body]
        first, second = self.factors[2*body:2*body + 2]
        r = math.sqrt(sum(v*v for v in x[:self.k + 1]))
        e = [v/r for v in x[:self.k + 1]] + [0.0]*(2 - self.k)
        if self.k == 1:
            mean, part = stiff*first, shear*second/r**2
            whole = (mean - part, mean + part, 2*n*mean)
            return (whole[0]*e[0]**2 + whole[1]*e[1]**2, whole[0]*e[1]**2 + whole[1]*e[0]**2, whole[2],
                    (whole[0] - whole[1])*e[0]*e[1], 0.0, 0.0)
        mean, part = stiff*(1 + n)*first, shear*second/r**3
        along, across = mean - 2*part, mean + part
        return tuple(across*(i == j) + (along - across)*e[i]*e[j]
                     for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)))


def solved(rows):
    """Solution of four equations (Gauss with pivots); the right side stands last in each row."""
    rows, n = [list(row) for row in rows], len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(n):
            if i != k:
                factor = rows[i][k]/rows[k][k]
                rows[i] = [p - factor*q for p, q in zip(rows[i], rows[k])]
    return [row[n]/row[k] for k, row in enumerate(rows)]


class Scene:
    """Both bodies, what holds them, and the closed form; k as in Lame."""

    young, nu, radii, thickness = (2000.0, 700.0), (0.3, 0.2), (1.0, 1.5, 2.2), 0.25

    def __init__(self, k, size, way, ten=False, inside=None):
        a, c, b = self.radii
        if k == 1:
            bodies = [unstructured.quarter_ring(*ends, self.thickness, h, (c, inside*h/size) if inside else ())
                      for ends, h in (((a, c), size), ((c, b), RATIO*size))]
        else:
            bodies = [unstructured.eighth_shell(*ends, h) for ends, h in (((a, c), size), ((c, b), RATIO*size))]
        self.k, self.way, self.eps = k, way, 50*self.young[1]/size
        self.mesh, self.counts = meshing.Mesh(), [len(body.elements) for body in bodies]
        for material, body in enumerate(bodies, 1):
            first = len(self.mesh.nodes)
            self.mesh.nodes += body.nodes
            self.mesh.elements += [(material, *(n + first for n in e)) for e in body.elements]
        if ten:
            self.mesh = quadratic.ten_nodes(self.mesh, self.middle)
        self.below = {n for e in self.mesh.elements[:self.counts[0]] for n in e[1:]}

    def middle(self, p, q):
        """The middle of an edge: on the circle or sphere that both ends lie on, if there is one."""
        half = [(a + b)/2 for a, b in zip(p, q)]
        ends = [math.hypot(*x[:self.k + 1]) for x in (p, q)]
        grown = 1.0
        if abs(ends[0] - ends[1]) < 1e-6 and min(abs(ends[0] - r) for r in self.radii) < 1e-6:
            grown = ends[0]/math.hypot(*half[:self.k + 1])
        return tuple(grown*v if m <= self.k else v for m, v in enumerate(half))

    def shell(self, radius, bodies=(True, False)):
        """Nodes of a radius, of the inner body (True) or the outer one."""
        return [n for n, x in enumerate(self.mesh.nodes, 1) if (n in self.below) in bodies
                and abs(math.sqrt(sum(v*v for v in x[:self.k + 1])) - radius) < 1e-6]

    def deck(self, form, ways=()):
        """The deck of a form of contact; of none with the ways of bore and interface, or those of the closed form."""
        a, c, _ = self.radii
        bore, codes = set(self.shell(a)), {}
        for n, x in enumerate(self.mesh.nodes, 1):
            code = tuple(int(n in bore and m <= self.k or abs(x[m]) < 1e-9 or self.k == 1 and m == 2)
                         for m in range(3))
            if any(code):
                codes[n] = code
        moves = {n: tuple(self.way*v/a if abs(v) > 1e-9 and m <= self.k else 0.0
                          for m, v in enumerate(self.mesh.nodes[n - 1])) for n in bore}
        pair = self.pair(form) if form else self.held(codes, moves, ways)
        return ('MFEC * * Concentric bodies\n\n' + meshing.solid(1, self.young[0], self.nu[0]) +
                meshing.solid(2, self.young[1], self.nu[1]) + quadratic.records(self.mesh) +
                meshing.node_set('under', self.shell(c, (True,))) +
                meshing.node_set('over', self.shell(c, (False,))) +
                'SURFace inner FROM under\nSURFace outer FROM over\n\n' + meshing.vectors('BOUNdary', codes) +
                meshing.vectors('DISPlacement', moves) + 'PROPortional 1\n  0 0\n  1 1\n\n' + pair +
                '\nOUTPut\n  FIELds stress\n  STATe NONE\n\nEND\nBATCh\n  DT,,1\n  STEP,,1\nEND\nSTOP\n')

    def pair(self, form):
        """CONTact of a form."""
        words, *options = form.split(' +')
        side, *points = words.split()
        return (f'CONTact\n  PAIR 1 fit\n    {side} inner outer ' + ' '.join(points) +
                f'\n    PENAlty AREA {self.eps!r}\n' + ''.join(f'    {option}\n' for option in options))

    def held(self, codes, moves, ways):
        """No contact: the interface goes its way, in codes and moves."""
        c, exact = self.radii[1], self.exact('+AUGM')
        for n in self.shell(c):
            codes[n] = tuple(int(m <= self.k or code) for m, code in enumerate(codes.get(n, (0, 0, 0))))
            way = (ways[1] if ways else exact.way(int(n not in self.below), c))/c
            moves[n] = tuple(way*v if m <= self.k else 0.0 for m, v in enumerate(self.mesh.nodes[n - 1]))
        for n in self.shell(self.radii[0]) if ways else ():
            moves[n] = tuple(ways[0]/self.way*v for v in moves[n])
        return ''

    def pushes(self, bench, ways):
        """Radial forces that hold the interface, of the inner body and the outer one, where bore and interface go
        these ways. The bodies are linear: a tenth of the ways is prescribed, as the whole ones are refused as more
        than small strain (one ring alone takes what both share in contact), and the forces are ten times as large."""
        deck = self.deck('', [0.1*way for way in ways]).replace('FIELds stress', 'FIELds reaction')
        found = bench.run_text('held', deck).nodal_reactions()

        def radial(n):
            place = self.mesh.nodes[n - 1][:self.k + 1]
            return 10.0*sum(f*v for f, v in zip(found[n - 1], place))/math.hypot(*place)
        return [sum(map(radial, self.shell(self.radii[1], side))) for side in ((True,), (False,))]

    def bulk_force(self, bench, compliance):
        """Force of an interface without an error of its own, but for its compliance: the two bodies' stiffness against
        the ways of bore and interface."""
        by_bore, by_way = self.pushes(bench, (self.way, 0.0))[0], self.pushes(bench, (0.0, self.way))
        inner, outer = by_way[0]/self.way, by_way[1]/self.way
        return -outer*by_bore/(inner*(1 + outer*compliance/self.area()) + outer)

    def exact(self, form):
        """The closed form, the penalty's compliance in it."""
        return Lame(self.k, self.radii, self.young, self.nu, self.way, 0.0 if 'AUGM' in form else 1/self.eps)

    def area(self):
        """Of the interface."""
        c = self.radii[1]
        return math.pi/2*c*(self.thickness if self.k == 1 else c)

    def stress_error(self, tables, exact):
        """L2 error of the stress over that of the solution."""
        error = whole = 0.0
        for k, ((_, *corners), volume, found) in enumerate(
                zip(self.mesh.elements, quadratic.meshing_volumes(self.mesh), tables.stresses())):
            middle = [sum(self.mesh.nodes[n - 1][m] for n in corners)/len(corners) for m in range(3)]
            wanted = exact.stress(int(k >= self.counts[0]), middle)
            error += volume*square(found, wanted)
            whole += volume*square(wanted, (0.0,)*6)
        return math.sqrt(error/whole)


def square(a, b):
    """Square of the difference of two stresses; shears count twice."""
    return sum((x - y)**2*(1 if i < 3 else 2) for i, (x, y) in enumerate(zip(a, b)))


def concentric(bench, k, size, known):
    """Force of the interface and stress, all forms; size: largest facet of the inner body.

    Wanted for rings with facets of 0.066: 0.1 % and 5.9 %; both fall with the facet, by h^2 and by h.
    """
    scene = Scene(k, bench.draw('facet', 0.9*size, size), bench.draw('way of the bore', 0.04, 0.06))
    found, finer = [], size/0.066
    for form in FORMS if k == 1 or not bench.reduced else FORMS[-3:]:
        tables = bench.run_text('concentric', scene.deck(form))
        exact = scene.exact(form)
        row = tables.contact('fit')[-1]
        force = bench.compare('force of the interface', 'exact (Lame)', exact.pressure*scene.area(), row['Fn'],
                              1e-3*finer**2, known=known[0], form=form, why=STIFF if form in BENT else FLAT)
        compliance = 0.0 if 'AUGM' in form else 1/scene.eps
        bench.compare('force of the interface over that of the bulk', 'the same tetrahedra, interface of no error',
                      scene.bulk_force(bench, compliance), row['Fn'], 1e-3*finer**2, known=known[0], form=form, why=FLAT)
        stress = bench.compare('L2 error of the stress', 'exact (Lame)', 0.0, scene.stress_error(tables, exact),
                               0.059*finer, scale=1.0, known=known[1], form=form, why=SOFT)
        found.append((form, force, stress))
    bulk = scene.stress_error(bench.run_text('concentric', scene.deck('')), scene.exact('+AUGM'))
    for form, _, stress in found:
        bench.compare('L2 error of the stress over that of the bulk', 'displacements of Lame at the interface', 1.0,
                      stress/bulk, 0.05, form=form)
    bench.remark('; '.join(f'{form}: force {100*f:.2f} %, stress {100*s:.1f} %' for form, f, s in found) +
                 f'; bulk alone: stress {100*bulk:.1f} %. CalculiX 2.20, surface to surface, on rings of 0.066: 1.5 and 5.9 %')


def rings(bench):
    """A quarter of two rings, plane strain."""
    concentric(bench, 1, 0.066, (0.03, 0.1))


def rings_within(bench):
    """Rings whose facets at the interface are of 0.066, as above, but whose tetrahedra behind them are half as large:
    what is left of the error of the force when that of the bulk is small."""
    size = bench.draw('facet', 0.9*0.066, 0.066)
    scene = Scene(1, size, bench.draw('way of the bore', 0.04, 0.06), inside=0.53*size)
    exact = scene.exact('')
    bulk = scene.bulk_force(bench, 1/scene.eps)
    bench.compare('force of the interface, finer inside', 'exact (Lame)', exact.pressure*scene.area(), bulk, 1e-3,
                  form='interface of no error')
    for form in ('GTOS +SMOO', 'GTOS SEGMent +SMOO'):
        row = bench.run_text('concentric', scene.deck(form)).contact('fit')[-1]
        bench.compare('force of the interface, finer inside', 'exact (Lame)', exact.pressure*scene.area(), row['Fn'],
                      1e-3, form=form)
        bench.compare('force of the interface over that of the bulk, finer inside',
                      'the same tetrahedra, interface of no error', bulk, row['Fn'], 2e-4, form=form)


def rings_of_ten(bench):
    """The same rings of elements of ten nodes, whose facets are curved on both sides."""
    scene = Scene(1, bench.draw('facet', 0.9*0.066, 0.066), bench.draw('way of the bore', 0.04, 0.06), ten=True)
    for form in ('GTOS', 'GTOS 12', 'GTOS SEGMent', 'GTOS 6 +AUGM'):
        tables = bench.run_text('concentric', scene.deck(form))
        exact = scene.exact(form)
        bench.compare('force of the interface, ten nodes', 'exact (Lame)', exact.pressure*scene.area(),
                      tables.contact('fit')[-1]['Fn'], 1e-3, form=form)
        bench.compare('L2 error of the stress, ten nodes', 'exact (Lame)', 0.0, scene.stress_error(tables, exact),
                      0.059, scale=1.0, form=form)


def shells(bench):
    """An eighth of two hollow spheres."""
    concentric(bench, 2, 0.11, (0.1, 0.25))
