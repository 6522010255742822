"""Tetrahedra of ten nodes and finite strain: rates, Cook's membrane, a sphere of rubber blown up."""
import math

import meshing
import unstructured

EXACT = 'exact'
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
OWN = 'converged run of a second program (numpy), theory: T10'
# Eight points of degree 3 on a tetrahedron, equal weights.
SUM = 2*math.sqrt(0.4)*math.cos((math.acos(-math.sqrt(10)/6) + 4*math.pi)/3)
ROOT = math.sqrt(SUM*SUM/4 - (SUM*SUM - 0.4)/2)
POINTS = [[(1 + 3*s)/4 if k == m else (1 - s)/4 for m in range(4)]
          for s in (SUM/2 + ROOT, SUM/2 - ROOT) for k in range(4)]


def ten_nodes(mesh, place=lambda a, b: tuple((p + q)/2 for p, q in zip(a, b))):
    """The mesh with a node on each edge, at place(end, end)."""
    fine, middles = meshing.Mesh(), {}
    fine.nodes = list(mesh.nodes)
    for material, *corners in mesh.elements:
        added = []
        for a, b in EDGES:
            key = tuple(sorted((corners[a], corners[b])))
            if key not in middles:
                fine.nodes.append(place(fine.nodes[key[0] - 1], fine.nodes[key[1] - 1]))
                middles[key] = len(fine.nodes)
            added.append(middles[key])
        fine.elements.append((material, *corners, *added))
    return fine


def unfold(mesh):
    """Middles of edges nearer to where they halve them, by a quarter at a time, in elements whose Jacobian is not
    positive at their corners and in a grid of places between: round surfaces may fold the elements behind them."""
    places = [(a/4, b/4, c/4, 1 - (a + b + c)/4) for a in range(5) for b in range(5 - a) for c in range(5 - a - b)]
    folded = mesh.elements
    while folded:
        folded = [e for e in folded if min(jacobian([mesh.nodes[n - 1] for n in e[1:]], l) for l in places) <= 0]
        for k, a, b in {(nodes[4 + k], nodes[a], nodes[b]) for _, *nodes in folded for k, (a, b) in enumerate(EDGES)}:
            halves = zip(*(mesh.nodes[n - 1] for n in (k, a, b)))
            mesh.nodes[k - 1] = tuple(0.75*v + 0.125*(p + q) for v, p, q in halves)
    return mesh


def jacobian(x, l):
    """det dx/dxi of ten nodes at volume coordinates."""
    by_l = [[(4*l[a] - 1)*v for v in x[a]] for a in range(4)]
    for k, (a, b) in enumerate(EDGES):
        for i, j in ((a, b), (b, a)):
            by_l[i] = [s + 4*l[j]*v for s, v in zip(by_l[i], x[4 + k])]
    u, v, w = ([p - q for p, q in zip(by_l[a], by_l[0])] for a in (1, 2, 3))
    return (u[0]*(v[1]*w[2] - v[2]*w[1]) + u[1]*(v[2]*w[0] - v[0]*w[2]) + u[2]*(v[0]*w[1] - v[1]*w[0]))


def ends(mesh):
    """The two corners beside each middle of an edge, of a mesh of ten nodes."""
    result = {}
    for _, *nodes in mesh.elements:
        result.update({nodes[4 + k]: (nodes[a], nodes[b]) for k, (a, b) in enumerate(EDGES)})
    return result


def records(mesh):
    """COORdinates and ELEMents, of four nodes or ten."""
    lines = ['COORdinates'] + [f'  {n} 0 ' + ' '.join(f'{v:.15e}' for v in x)
                               for n, x in enumerate(mesh.nodes, 1)]
    lines += ['', 'ELEMents'] + [f'  {n} 0 ' + ' '.join(map(str, e)) for n, e in enumerate(mesh.elements, 1)]
    return '\n'.join(lines) + '\n\n'


def shares(mesh, numbers):
    """What an even pressure gives to nodes, of plane facets: thirds of areas to the corners, or all
    of it to the middles of edges."""
    if all(len(e) < 6 for e in mesh.elements):
        return mesh.shares(numbers)
    straight, middles = meshing.Mesh(), {}
    straight.nodes, straight.elements = mesh.nodes, [e[:5] for e in mesh.elements]
    for _, *nodes in mesh.elements:
        middles.update({frozenset((nodes[a], nodes[b])): nodes[4 + k] for k, (a, b) in enumerate(EDGES)})
    inside, result = set(numbers), dict.fromkeys(numbers, 0.0)
    for facet, area in straight.outer_facets(numbers):
        for k in range(3):
            middle = middles[frozenset((facet[k], facet[k - 1]))]
            if middle not in inside:
                raise ValueError('an edge without its middle')
            result[middle] += area/3
    return result


def shapes(barycentric, nodes):
    """Shape functions at a point."""
    if nodes == 4:
        return list(barycentric)
    return [v*(2*v - 1) for v in barycentric] + [4*barycentric[a]*barycentric[b] for a, b in EDGES]


def mean_error(mesh, found, exact):
    """L2 norm of the error over that of the exact displacement."""
    wrong = whole = 0.0
    for (_, *nodes), volume in zip(mesh.elements, meshing_volumes(mesh)):
        for point in POINTS:
            share = shapes(point, len(nodes))
            x, u = ([sum(n*field(m)[k] for n, m in zip(share, nodes)) for k in range(3)]
                    for field in (lambda m: mesh.nodes[m - 1], lambda m: found[m]))
            wanted = exact(x)
            wrong += volume*sum((a - b)**2 for a, b in zip(u, wanted))
            whole += volume*sum(a*a for a in wanted)
    return math.sqrt(wrong/whole)


def meshing_volumes(mesh):
    """Volumes of elements with straight edges."""
    straight = meshing.Mesh()
    straight.nodes, straight.elements = mesh.nodes, [e[:5] for e in mesh.elements]
    return straight.volumes()


def source_at(center):
    """u = r/|r|^3 about a place outside the body: no divergence, no load."""
    def field(x):
        r = [a - b for a, b in zip(x, center)]
        return [a/math.sqrt(sum(b*b for b in r))**3 for a in r]
    return field


def rates(bench):
    """Rates of convergence of the displacement: a point source outside of a cube."""
    nu = bench.draw('nu', 0.1, 0.4)
    exact = source_at([-bench.draw(f'source {name}', 0.4, 0.8) for name in 'xyz'])
    scale, curves = 1e-3, []
    for nodes, sizes, rate in ((4, (4, 8, 12), 2.0), (10, (2, 4, 6), 3.0)):
        errors = []
        for n in sizes:
            mesh = meshing.Mesh()
            mesh.box((n, n, n), lambda *cell, n=n: tuple(c/n for c in cell))
            if nodes == 10:
                mesh = ten_nodes(mesh)
            outside = mesh.where(lambda *x: any(v in (0.0, 1.0) for v in x))
            given = {m: tuple(scale*v for v in exact(mesh.nodes[m - 1])) for m in outside}
            tables = bench.run_text(f'source_{nodes}_{n}', (
                'MFEC * * A source outside of a cube\n\n' + meshing.solid(1, 1000.0, nu) + records(mesh)
                + meshing.vectors('BOUNdary', {m: (1, 1, 1) for m in outside})
                + meshing.vectors('DISPlacement', given) + ONE_STEP))
            found = {m: [v/scale for v in u] for m, u in tables.displacements()[-1].items()}
            errors.append(mean_error(mesh, found, exact))
        bench.remark(f'{nodes} nodes, {", ".join(map(str, sizes))} cells an edge: L2 error '
                     + ', '.join(f'{e:.3e}' for e in errors))
        reached = math.log(errors[-2]/errors[-1])/math.log(sizes[-1]/sizes[-2])
        bench.compare(f'L2 rate of {nodes} nodes, {sizes[-2]} to {sizes[-1]} cells', 'theory', rate, reached, 0.1)
        curves.append((f'{nodes} nodes', 'o-' if nodes == 4 else 's-', [1/n for n in sizes], errors))
    bench.picture('ten_nodes', ('cell over edge', 'L2 error', 'Displacement of a source outside of a cube'),
                  curves, True)


ONE_STEP = 'OUTPut\n  FIELds displacement\n\nEND\nBATCh\n  DT,,1\n  STEP,,1\n  DISP,ALL\nEND\nSTOP\n'


def membrane(bench):
    """Cook's membrane in plane strain, a slab one cell thick: does it lock, does it bend?"""
    young = 240.565
    # the last one under next to nothing: it moves as a linear body does
    for law, nu, n, force, wanted in (('LINear', 0.3, 8, 100.0, 9.441), ('LINear', 0.4999, 8, 100.0, 7.978),
                                      ('NEOHookean', 0.4999, 4, 100.0, 6.784),
                                      ('NEOHookean', 0.4999, 4, 1e-6, 7.856e-8)):
        thick = 48.0/n

        def place(i, j, k, n=n, thick=thick):
            x, low = 48*i/n, 44*i/n
            return x, low + (44 - 28*i/n)*j/n, thick*k
        mesh = meshing.Mesh()
        mesh.box((n, n, 1), place)
        mesh = ten_nodes(mesh)
        held = {m: (int(x[0] == 0.0), int(x[0] == 0.0), 1) for m, x in enumerate(mesh.nodes, 1)}
        text = ('MFEC * * Cook\'s membrane\n\nMATErial 1\n'
                f'  SOLId {law}\n  ELAStic ISOTropic {young} {nu}\n\n' + records(mesh)
                + meshing.vectors('BOUNdary', held)
                + meshing.node_set('edge', mesh.where(lambda x, *_: x == 48.0))
                + f'SURFace rim FROM edge\n\nTRACtion\n  rim 0 {force/16!r} 0 1\n\n'
                'PROPortional 1\n  0 0\n  1 1\n\nOUTPut\n  FIELds displacement\n\nEND\nBATCh\n  DT,,0.25\n'
                '  STEP,,4\n  DISP,ALL\nEND\nSTOP\n')
        found = bench.run_text('membrane', text).displacements()[-1]
        tip = mesh.where(lambda x, y, z: x == 48.0 and abs(y - 60.0) < 1e-9 and z == 0.0)[0]
        name = 'neo-Hooke' if law == 'NEOHookean' else 'linear'
        bench.compare(f'displacement of the tip, {name}, nu = {nu}, n = {n}, force {force:g}', OWN, wanted, found[tip][1], 0.01)


def blown_sphere(bench):
    """A thick sphere of neo-Hooke under a pressure that follows: closed form by a radial equation."""
    way = {100.0: (0.0969796217, 0.0381550870), 200.0: (0.2571350026, 0.1090582586)}
    pressure = bench.choose('pressure', sorted(way))
    shell = unstructured.eighth_shell(1.0, 2.0, bench.draw('size of element', 0.3, 0.4))

    def place(a, b):
        middle = [(p + q)/2 for p, q in zip(a, b)]
        radius = (math.hypot(*a) + math.hypot(*b))/2
        grown = radius/math.hypot(*middle)
        return tuple(grown*v for v in middle)
    mesh = meshing.Mesh()
    mesh.nodes, mesh.elements = list(shell.nodes), [(1, *e) for e in shell.elements]
    mesh = ten_nodes(mesh, place)
    near = 1e-6
    held = {m: tuple(int(abs(v) < near) for v in x) for m, x in enumerate(mesh.nodes, 1)
            if min(map(abs, x)) < near}
    text = ('MFEC * * A sphere blown up\n\nMATErial 1\n  SOLId NEOHookean\n  ELAStic ISOTropic 1000 0.3\n\n'
            + records(mesh) + meshing.vectors('BOUNdary', held)
            + meshing.node_set('hole', mesh.where(lambda *x: abs(math.hypot(*x) - 1) < near))
            + f'SURFace wall FROM hole\n\nPRESsure\n  wall {pressure!r} 1\n\n'
            'PROPortional 1\n  0 0\n  1 1\n\nOUTPut\n  FIELds displacement\n\nEND\nBATCh\n  DT,,0.2\n'
            '  STEP,,5\n  DISP,ALL\nEND\nSTOP\n')
    found = bench.run_text('sphere', text).displacements()[-1]
    for radius, name, wanted in zip((1.0, 2.0), ('inside', 'outside'), way[pressure]):
        ways = [sum(a*b for a, b in zip(found[m], x))/radius for m, x in enumerate(mesh.nodes, 1)
                if abs(math.hypot(*x) - radius) < near]
        bench.compare(f'mean displacement {name}, p = {pressure:g}', 'exact (radial equation)', wanted,
                      sum(ways)/len(ways), 0.005)
        spread = max(abs(w/wanted - 1) for w in ways)
        bench.remark(f'{len(mesh.nodes)} nodes, {name}: the farthest node is off by {100*spread:.2f} %')


def dragged_ball(bench):
    """A rigid ball pressed into rubber by 30 % of its radius and dragged: each increment converges
    and the work of the loads is found again."""
    mu, depth, way = bench.draw('mu', 0.1, 0.4), 0.3, 1.0
    n, press, drag = 6, 12, 40
    mesh = meshing.Mesh()
    mesh.box((3*n, n, n), lambda i, j, k: (-1.2 + 3.6*i/(3*n), 1.2*j/n, -1.4*(1 - (k/n)**0.7)))
    rubber = len(mesh.nodes)

    def cap(i, j, k):
        u, v = (2*i/8 - 1)*0.85, j/4*0.85
        # a square to a disc, without its corners
        x, y = u*math.sqrt(1 - v*v/2), v*math.sqrt(1 - u*u/2)
        return x, y, 1 - math.sqrt(1 - x*x - y*y) if k == 0 else 1.0
    mesh.box((8, 4, 1), cap, material=2)
    ball = set(range(rubber + 1, len(mesh.nodes) + 1))
    top = [m for m in mesh.where(lambda x, y, z: z == 0.0) if m <= rubber]
    under = [m for m in ball if mesh.nodes[m - 1][2] < 1.0]
    far = set(mesh.where(lambda x, y, z: z == -1.4))
    held = {m: (1, 1, 1) for m in far}
    held.update({m: (0, 1, 0) for m in mesh.where(lambda x, y, z: y == 0.0)
                 if m <= rubber and m not in far})
    held.update({m: (1, 1, 1) for m in ball})
    text = ('MFEC * * A ball dragged over rubber\n\nMATErial 1\n  SOLId NEOHookean\n  ELAStic ISOTropic 3 0.45\n\n'
            'MATErial 2\n  RIGId\n\n' + records(mesh) + meshing.vectors('BOUNdary', held)
            + meshing.node_set('top', top) + meshing.node_set('under', under) + meshing.node_set('ball', sorted(ball))
            + 'SURFace face FROM top\nSURFace bottom FROM under\n\n'
            f'DISPlacement\n  ball {way!r} 0 {-depth!r}\n\nFPROportional\n  ball 2 0 1\n\n'
            'PROPortional 1\n  0 0\n  1 1\n\nPROPortional 2\n  1 0\n  2 1\n\n'
            f'CONTact\n  PAIR 1 pair\n    FORM\n    PENAlty AUTO 10\n    FRICtion COULomb {mu!r}\n\n'
            'OUTPut\n  REACtions ball\n\nEND\nBATCh\n'
            f'  DT,,1/{press}\n  STEP,,{press}\n  DT,,1/{drag}\n  STEP,,{drag}\nEND\nSTOP\n')
    for form, pair in (('NTOS', 'NTOS face bottom\n    SMOOth'), ('MORTar', 'MORTar face bottom')):
        tables = bench.run_text('dragged_ball', text.replace('FORM', pair))
        bench.compare('increments that were cut', EXACT, 0.0, float(tables.cuts()), 0.5, scale=1.0, form=form)
        bench.compare('energy imbalance over the work done', 'balance of energy', 0.0,
                      tables.work_lost(), 0.01, scale=1.0, form=form, known=0.13 if form == 'MORTar' else None,
                      why='not found: three times the increments leave 11.5 %, facets of the ball half as large 11.4 %; on the same '
                      'flat facets NTOS lacks 4.4 % and GTOS SEGMent 2.5 %')
