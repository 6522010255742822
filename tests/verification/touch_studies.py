"""First touch: a block that lands obliquely, and the shear of a frictional press (Spence)."""
import math

import meshing
import quadratic_studies as quadratic
from half_spaces import graded, table

LANDING = '../properties/decks/landing.inp'
# What is wanted of the shear with so many increments.
WANTED = {4: 0.04, 16: 0.03, 64: 0.015}
# Radial sum over Fn in the scene of `Press`: that of friction (axisymmetric.py, cells of 0.02 to 0.0033
# and their limit: 0.0859, 0.0855, 0.0852, 0.0851, 0.0850; for mu = 0.1 0.0748 to 0.0746), and 0.00085 of
# the pressure, which is inclined where the block is dented.
SCENE = {0.3: 0.0858, 0.1: 0.0754}


def landed(bench, form, steps, modulus=None, **values):
    """Last row of the landing block; with a modulus its base is elastic, held where it was rigid."""
    words, *options = form.split(' +')
    side, *points = words.split()
    with open(bench.path(LANDING), encoding='ascii') as stream:
        text = stream.read()
    pair = '\n    '.join([f'{side} under floor ' + ' '.join(points)] + options)
    text = text.replace('NTOS under floor', pair)
    if modulus:
        for old, new in (('  RIGId\n', f'  SOLId LINEar\n  ELAStic ISOTropic {modulus!r} 0.3\n'),
                         ('  ground 1 1 1', '  foot 1 1 1'),
                         ('SET track', 'SET foot\n  PLANe 3 -.5\n\nSET track')):
            if old not in text:
                raise ValueError(f'no {old!r} in {LANDING}')
            text = text.replace(old, new)
    row = bench.run_text('landing', text, steps=steps, **values).contact('pair')[-1]
    return math.hypot(row['F1'], row['F2'])/row['F3'], row['Ft_nodes']/row['Fn']


def landing(bench):
    """Share of friction against the run that has an increment ending at the touch."""
    forms = ('NTOS', 'GTOS', 'GTOS SEGMent', 'NTOS +AUGM', 'GTOS +AUGM', 'GTOS SEGMent +AUGM',
             'NTOS +SMOO', 'GTOS +SMOO', 'MORTar')
    for slope, low, high in (('gentle', 20, 35), ('middle', 40, 50), ('steep', 55, 65)):
        angle = bench.draw(f'{slope} path from the vertical [degree]', low, high)
        for form in forms:
            exact = landed(bench, form, 11, angle=angle)
            worst = [max((landed(bench, form, n, angle=angle)[0] for n in steps),
                         key=lambda x, e=exact[0]: abs(x - e)) for steps in ((1, 2, 3, 4, 7), (22,))]
            bench.compare(f'F_T/F_N, {slope} path, 1 to 7 increments', 'increment to the touch',
                          exact[0], worst[0], 1e-6, form=form)
            bench.compare(f'F_T/F_N, {slope} path, 22 increments', 'increment to the touch',
                          exact[0], worst[1], 1e-6, form=form)
    modulus = bench.draw('modulus of the elastic base', 300, 1000)
    for form in forms:
        exact = landed(bench, form, 11, modulus, angle=45)[0]
        worst = max((landed(bench, form, n, modulus, angle=45)[0] for n in (1, 4)),
                    key=lambda x, e=exact: abs(x - e))
        bench.compare('F_T/F_N, elastic base, 1 and 4 increments', 'increment to the touch',
                      exact, worst, 1e-6, form=form, known=2e-4 if form == 'MORTar' else None,
                      why='not found; against a rigid base the same block is exact')


class Press:
    """A sphere of radius 200 on a block: quarter bodies, both far faces held, pressed by 6e-4.

    The mesh is polar, cut without a direction of its own; a cut along one direction is wrong by 10 %.
    Cells of one size go down to 0.45 and grow slowly: with cells that grow by 1.35 below 0.2 the
    radial sum tends to a value 1.3 % too small, whatever the facets and the increments are. A
    penalty of 10 E/h takes another 1.2 %, one of 100 E/h 0.1 %. Elements of ten nodes have cells of
    twice the size: those of four take 0.4 to 3.6 % with cells of 0.04 to 0.056, whatever the form.
    """

    radius, approach, height = 200.0, 6e-4, 0.6

    def __init__(self, cell, ratio=1.2, ten=False):
        self.mesh, self.parts = meshing.Mesh(), {}
        self.add('upper', cell, (0.8, self.height), 0.45, 1)
        self.add('lower', ratio*cell, (1.6, 1.0), 0.5, -1)
        for k in (0, 1):
            self.parts[f'mirror{k + 1}'] = [n for n, x in enumerate(self.mesh.nodes, 1)
                                            if abs(x[k]) < 1e-9]
        if ten:
            self.add_middles()

    def add_middles(self):
        """Ten nodes an element; the middles of edges of the upper body lie on its paraboloids."""
        upper = {n for material, *nodes in self.mesh.elements if material == 1 for n in nodes}
        number = {x: n for n, x in enumerate(self.mesh.nodes, 1) if n in upper}

        def rise(x):
            return (x[0]*x[0] + x[1]*x[1])/(2*self.radius)

        def middle(p, q):
            x = [(a + b)/2 for a, b in zip(p, q)]
            if p in number and q in number:
                level = sum((z[2] - rise(z))/(1 - rise(z)/self.height) for z in (p, q))/2
                x[2] = level + rise(x)*(1 - level/self.height)
            return tuple(x)
        self.mesh = quadratic.ten_nodes(self.mesh, middle)
        ends = quadratic.ends(self.mesh)
        for name, numbers in self.parts.items():
            inside = set(numbers)
            self.parts[name] = numbers + [n for n, pair in ends.items() if inside.issuperset(pair)]

    def add(self, name, cell, size, fine, sign):
        """One body: radius and height, cells of one size up to the radius `fine`."""
        line = graded(cell, fine, size[0], 1.15)
        levels = graded(0.5*cell, 0.45, size[1], 1.15)
        if sign < 0:
            levels = [-z for z in reversed(levels)]

        def place(i, j, k):
            r = max(line[i], line[j])
            if i == j == 0:
                angle = 0.0
            elif line[j] <= line[i]:
                angle = math.pi/4*line[j]/line[i]
            else:
                angle = math.pi/2 - math.pi/4*line[i]/line[j]
            rise = r*r/(2*self.radius) if sign > 0 else 0.0
            return (r*math.cos(angle) if line[i] > 0 else 0.0, r*math.sin(angle),
                    levels[k] + rise*(1 - abs(levels[k])/size[1]))

        n, m = len(line) - 1, len(levels) - 1
        number = self.mesh.box((n, n, m), place, 1 if sign > 0 else 2, turned='alternate')
        near, far = (0, m) if sign > 0 else (m, 0)
        self.parts[name] = [number(i, j, near) for j in range(n + 1) for i in range(n + 1)
                            if max(line[i], line[j]) < 0.56]
        self.parts[name + '_far'] = [number(i, j, far) for j in range(n + 1) for i in range(n + 1)]

    def deck(self, form, mu, steps):
        """The deck."""
        words, *options = form.split(' +')
        side, *points = words.split()
        sets = ''.join(meshing.node_set(name, numbers) for name, numbers in self.parts.items())
        return ('MFEC * * Frictional indentation\n\n' + meshing.solid(1, 3000.0, 0.25) +
                meshing.solid(2, 1000.0, 0.3) + quadratic.records(self.mesh) + sets +
                'SURFace above FROM upper\nSURFace below FROM lower\n\nBOUNdary\n  upper_far 1 1 1\n'
                '  lower_far 1 1 1\n  mirror1 1 0 0\n  mirror2 0 1 0\n\n'
                f'DISPlacement\n  upper_far 0 0 {-self.approach!r}\n\n' + table(1, ((0, 0), (1, 1))) +
                f'CONTact\n  PAIR 1 caps\n    {side} above below ' + ' '.join(points) +
                ('' if 'AUGM' in form else '\n    PENAlty AUTO 100') +
                f'\n    FRICtion COULomb {mu!r}\n' + ''.join(f'    {option}\n' for option in options) +
                f'\nOUTPut\n  REACtions upper_far\n  FIELds contact\n  STATe NONE\n  EVERy {steps}\n\n'
                f'END\nBATCh\n  DT,,1/{steps}\n  STEP,,{steps}\nEND\nSTOP\n')

    def shear(self, bench, form, mu, steps):
        """Sum of the radial components of the contact traction over the normal force."""
        tables = bench.run_text('press', self.deck(form, mu, steps))
        radial = normal = 0.0
        for node, force in tables.forces().items():
            x, y, _ = self.mesh.nodes[node - 1]
            normal += force[2]
            radial += (force[0]*x + force[1]*y)/math.hypot(x, y) if x*x + y*y > 0 else 0.0
        return abs(radial/normal)


def indentation(bench):
    """Shear under a press in few and in many increments, against axisymmetric elements.

    Nodes and smooth surfaces want elements of four nodes, all other forms are judged by those of ten.
    With mu = 0.1 the ring that slips is 0.07 wide: elements of four nodes have finer cells there.
    """
    ratio = bench.draw('cells below over above', 1.15, 1.25)
    four = Press(bench.draw('cell, four nodes', 0.028, 0.032), ratio)
    ten = Press(bench.draw('cell, ten nodes', 0.07, 0.08), ratio, True)
    fine = Press(bench.draw('cell, four nodes, mu = 0.1', 0.023, 0.025), ratio)
    flat = ('NTOS', 'NTOS +AUGM', 'NTOS +SMOO', 'GTOS +SMOO')
    fields = ('GTOS', 'GTOS SEGMent', 'GTOS +AUGM', 'MORTar')
    cases = ((0.3, ten, fields), (0.3, four, flat), (0.1, ten, ('GTOS', 'MORTar')), (0.1, fine, flat[:1]))
    for mu, press, forms in cases:
        for form in forms:
            for steps, wanted in WANTED.items():
                if bench.reduced and steps > 16 and press is not ten:
                    continue
                known, why = misses(form, steps)
                bench.compare(f'radial sum, mu {mu}, {steps} increments', 'axisymmetric elements',
                              SCENE[mu], press.shear(bench, form, mu, steps), wanted, form=form,
                              known=known, why=why)


def misses(form, steps):
    """How far a row may be off that is known to miss, and why."""
    if steps == 4 and form == 'GTOS +SMOO':
        return 0.05, 'the outermost ring of facets is closed in part, and the gaps of its points do not ' \
            'follow the law of the front: its way before the touch is 4 % too long (doc/theory, "Contact initiation")'
    return None, ''
