"""Decks made from Python: blocks of tetrahedra, paths, contact pairs (standard library only)."""
import math

TETRAHEDRA = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # of the middle nodes of ten
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def number(value):
    """A real with all its digits."""
    return repr(float(value))


class Body:
    """A block of nx x ny x nz cells, six tetrahedra each, with its nodes by their grid place."""

    def __init__(self, deck, name, cells, low, high, material, shape=None, jiggle=0.0, draw=None):
        self.name, self.cells, self.material = name, cells, material
        self.low, self.high = low, high
        self.first = len(deck.x) + 1
        nx, ny, nz = cells
        for k in range(nz + 1):
            for j in range(ny + 1):
                for i in range(nx + 1):
                    deck.x.append(self.place((i, j, k), shape, jiggle, draw))
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    corner = [self.node(i + a, j + b, k + c) for a, b, c in CORNERS]
                    for tetrahedron in TETRAHEDRA:
                        deck.elements.append((material, [corner[m] for m in tetrahedron]))
        deck.bodies.append(self)

    def place(self, grid, shape, jiggle, draw):
        """Position of a grid point: jiggled within its layer's plane, then shaped."""
        unit = []
        for m in range(3):
            step = 1.0/self.cells[m]
            u = grid[m]*step
            if jiggle and 0 < grid[m] < self.cells[m]:
                u += jiggle*step*draw.uniform(-1, 1)
            unit.append(u)
        # Corners exactly as given, so that gaps of 0 and of one unit in the last place stay so.
        x = [self.high[m] if unit[m] == 1.0 else self.low[m] + unit[m]*(self.high[m] - self.low[m])
             for m in range(3)]
        return shape(x, unit) if shape else x

    def node(self, i, j, k):
        """Node number of a grid point."""
        nx, ny, _ = self.cells
        return self.first + i + (nx + 1)*(j + (ny + 1)*k)

    def facets(self, k):
        """Triangles of layer k as node triples (those of the tetrahedra's faces)."""
        nx, ny, nz = self.cells
        k = nz if k < 0 else k
        for j in range(ny):
            for i in range(nx):
                corner = [self.node(i + a, j + b, k) for a, b, _ in CORNERS[:4]]
                for triangle in ((0, 1, 2), (0, 2, 3)):
                    yield [corner[m] for m in triangle]

    def layer(self, k):
        """Nodes of layer k, -1 for the uppermost."""
        nx, ny, nz = self.cells
        k = nz if k < 0 else k
        return [self.node(i, j, k) for j in range(ny + 1) for i in range(nx + 1)]

    def shares(self, k):
        """Share of the area of layer k that belongs to each of its nodes (undistorted grid)."""
        nx, ny, _ = self.cells
        weights = {}
        for triangle in self.facets(k):
            for node in triangle:
                weights[node] = weights.get(node, 0.0) + 1.0/(6.0*nx*ny)
        return weights


class Deck:
    """Collects what a deck says and writes it."""

    def __init__(self, title):
        self.title = title
        self.form, self.points = 'NTOS', ''  # of contact, and points in a slave facet
        self.x, self.elements, self.bodies = [], [], []
        self.materials, self.sets, self.surfaces = [], [], []
        self.listed = []              # surfaces given by their triangles
        self.boundary, self.displacement, self.force, self.numbers = [], [], [], []
        self.tables, self.pairs, self.outputs, self.batch = [], [], [], []

    def elastic(self, young, poisson):
        """A linear elastic material; its number."""
        self.materials.append('SOLId LINEar\n  ELAStic ISOTropic '
                              f'{number(young)} {number(poisson)}')
        return len(self.materials)

    def rigid(self):
        """A rigid material; its number."""
        self.materials.append('RIGId')
        return len(self.materials)

    def set(self, name, nodes):
        """A named node set."""
        self.sets.append((name, list(nodes)))
        return name

    def surface(self, name, nodes):
        """A set and the exterior facets on it."""
        self.set(name + '_nodes', nodes)
        self.surfaces.append((name, name + '_nodes'))
        return name

    def table(self, points):
        """A proportional load; its number."""
        self.tables.append(list(points))
        return len(self.tables)

    def fix(self, nodes, codes=(1, 1, 1)):
        """Restrains nodes (numbers, or a set's name)."""
        nodes = [nodes] if isinstance(nodes, str) else nodes
        for node in nodes:
            self.boundary.append((node, codes))

    def move(self, node, values, tables):
        """Prescribed displacement of a node or a set."""
        self.displacement.append((node, values))
        self.numbers.append((node, tables))

    def load(self, node, values, tables):
        """Force on a node."""
        self.force.append((node, values))
        self.numbers.append((node, tables))

    def pair(self, name, slave, master, lines):
        """A contact pair with further records; its form is that of the deck."""
        self.pairs.append((name, slave, master, lines))

    def steps(self, duration, count):
        """Increments of the given number over a duration."""
        self.batch.append(f'DT,,{number(duration/count)}')
        self.batch.append(f'STEP,,{count}')

    def add_middles(self, material, place):
        """Gives the elements of a material a node in the middle of each edge, at place(end, end);
        it joins the sets that hold both ends."""
        middles, at_end = {}, len(self.x)
        for n, (number_of, nodes) in enumerate(self.elements):
            if number_of != material:
                continue
            edges = [tuple(sorted((nodes[a], nodes[b]))) for a, b in EDGES]
            for edge in edges:
                if edge not in middles:
                    at_end += 1
                    middles[edge] = at_end
                    self.x.append(place(self.x[edge[0] - 1], self.x[edge[1] - 1]))
            self.elements[n] = (material, nodes + [middles[edge] for edge in edges])
        for k, (name, nodes) in enumerate(self.sets):
            held = set(nodes)
            self.sets[k] = (name, nodes + [m for (a, b), m in middles.items() if a in held and b in held])

    def text(self):
        """The deck."""
        out = [f'MFEC * * {self.title}', '']
        for n, material in enumerate(self.materials, 1):
            out += [f'MATErial {n}', '  ' + material, '']
        out.append('COORdinates')
        out += [f'{n} 0 ' + ' '.join(map(number, x)) for n, x in enumerate(self.x, 1)]
        out += ['', 'ELEMents']
        out += [f'{n} 0 {material} ' + ' '.join(map(str, nodes))
                for n, (material, nodes) in enumerate(self.elements, 1)]
        out.append('')
        for name, nodes in self.sets:
            out.append(f'SET {name}')
            rows = [nodes[k:k + 40] for k in range(0, len(nodes), 40)]
            for k, row in enumerate(rows):
                out += (['  OR'] if k else []) + ['  NODEs ' + ' '.join(map(str, row))]
            out.append('')
        out += [f'SURFace {name} FROM {nodes}' for name, nodes in self.surfaces] + ['']
        for name, triangles in self.listed:
            out.append(f'SURFace {name}')
            out += ['  FACEts ' + ' '.join(map(str, t)) for t in triangles] + ['']
        out += self.records('BOUNdary', self.boundary, str)
        out += self.records('DISPlacement', self.displacement, number)
        out += self.records('FORCe', self.force, number)
        out += self.records('FPROportional', self.numbers, str)
        for n, points in enumerate(self.tables, 1):
            out.append(f'PROPortional {n}')
            out += [f'  {number(t)} {number(p)}' for t, p in points] + ['']
        if self.pairs:
            out.append('CONTact')
            for n, (name, slave, master, lines) in enumerate(self.pairs, 1):
                out += [f'  PAIR {n} {name}', f'    {self.form} {slave} {master} {self.points}'.rstrip()]
                out += ['    ' + line for line in lines
                        if self.form != 'MORTar' or not line.startswith(('PENA', 'AUGM'))]
            out.append('')
        out += ['OUTPut', '  REACtions ' + ' '.join(self.outputs)] if self.outputs else ['OUTPut']
        out += ['  FIELds NONE', '  STATe NONE', '', 'END', 'BATCh']
        out += ['  ' + line for line in self.batch] + ['END', 'STOP', '']
        return '\n'.join(out)

    @staticmethod
    def records(command, rows, form):
        """One data set of node records, if there are any."""
        if not rows:
            return []
        out = [command]
        for node, values in rows:
            increment = '' if isinstance(node, str) else '0 '
            out.append(f'  {node} {increment}' + ' '.join(form(v) for v in values))
        return out + ['']


def clearance(deck, upper, lower):
    """Least height of an upper surface over a lower one, at the nodes of either."""
    def over(points, triangles, sign):
        least = math.inf
        for p in points:
            for a, b, c in triangles:
                area = (b[0] - a[0])*(c[1] - a[1]) - (b[1] - a[1])*(c[0] - a[0])
                u = ((p[0] - a[0])*(c[1] - a[1]) - (p[1] - a[1])*(c[0] - a[0]))/area
                v = ((b[0] - a[0])*(p[1] - a[1]) - (b[1] - a[1])*(p[0] - a[0]))/area
                if min(u, v, 1.0 - u - v) >= -1e-9:
                    z = a[2] + u*(b[2] - a[2]) + v*(c[2] - a[2])
                    least = min(least, sign*(p[2] - z))
        return least
    sides = []
    for body, k in ((upper, 0), (lower, -1)):
        sides.append(([deck.x[n - 1] for n in body.layer(k)],
                      [[deck.x[n - 1] for n in triangle] for triangle in body.facets(k)]))
    return min(over(sides[0][0], sides[1][1], 1.0), over(sides[1][0], sides[0][1], -1.0))


class Scene:
    """A deck, what it should end with, and how its result is judged."""

    def __init__(self, name, deck, group, refused=False, judge=None, wanted=0.0, balance=None,
                 mus=None, factor=1.0, seconds=60):
        self.name, self.deck, self.group = name, deck, group
        self.refused = refused          # exit code 2 is what must come
        self.judge = judge              # function of the Result: relative error
        self.wanted = wanted            # largest error allowed
        self.balance = balance or []    # (sets, {pair: sign}, load function of time) for a body
        self.balance_wanted = 1e-9      # of Fn
        self.inside = []                # pairs between bodies that are balanced as one
        self.floor = 1e-300             # forces below are round-off
        self.mus = mus or {}            # pair: (mu1, mu2)
        self.factor = factor            # size of the model, for round-off
        self.notes = ''
        self.seconds = seconds          # time limit


def with_mortar(scene):
    """A scene with multipliers at nodes; where the slave does not deform it becomes the master."""
    deck = scene.deck
    deck.form, deck.points = 'MORTar', ''
    rigid = {n for n, material in enumerate(deck.materials, 1) if material == 'RIGId'}
    still = {n for material, nodes in deck.elements if material in rigid for n in nodes}
    nodes = {name: {n for t in triangles for n in t} for name, triangles in deck.listed}
    nodes.update((name, set(deck_nodes)) for name, deck_nodes in deck.sets)
    nodes.update((name, nodes[own]) for name, own in deck.surfaces)
    for k, (name, slave, master, lines) in enumerate(deck.pairs):
        if still.issuperset(nodes[slave]):
            deck.pairs[k] = (name, master, slave, lines)
            for _, _, signs, _ in scene.balance:
                if name in signs:
                    signs[name] = -signs[name]
    return scene


def rotate(x, y, angle):
    """(x, y) turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return c*x - s*y, s*x + c*y
