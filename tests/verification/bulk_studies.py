"""The tetrahedron by itself: patch test and rates of convergence. The decks are written here."""
import math

import meshing

EXACT = 'exact'
ONE_STEP = 'END\nBATCh\n  DT,,1\n  STEP,,1\n  DISP,ALL\nEND\nSTOP\n'


def deck(title, mesh, young, nu, sections):
    """A deck without contact."""
    return (f'MFEC * * {title}\n\n' + meshing.solid(1, young, nu) + mesh.records() +
            ''.join(sections) + 'OUTPut\n  FIELds stress\n\n' + ONE_STEP)


def patch(bench):
    """Linear displacements on the boundary of a jiggled cube."""
    n, dice = bench.whole('cells', 3, 5), bench.dice
    young, nu = bench.draw('E', 100.0, 1e4), bench.draw('nu', 0.0, 0.45)
    gradient = [[dice.uniform(-2e-3, 2e-3) for _ in range(3)] for _ in range(3)]

    def place(*cell):
        return tuple(c/n + (dice.uniform(-0.2, 0.2)/n if all(0 < m < n for m in cell) else 0.0)
                     for c in cell)

    def field(x):
        return tuple(sum(g*y for g, y in zip(row, x)) for row in gradient)

    mesh = meshing.Mesh()
    mesh.box((n, n, n), place)
    outside = mesh.where(lambda *x: any(v in (0.0, 1.0) for v in x))
    given = {m: field(mesh.nodes[m - 1]) for m in outside}
    tables = bench.run_text('bulk_patch', deck(
        'Bulk patch test', mesh, young, nu,
        [meshing.vectors('BOUNdary', {m: (1, 1, 1) for m in outside}),
         meshing.vectors('DISPlacement', given)]))
    found = tables.displacements()[-1]
    worst = max(abs(a - b) for m, x in enumerate(mesh.nodes, 1)
                for a, b in zip(found[m], field(x)))
    bench.compare('displacement inside a jiggled cube, worst node', EXACT, 0.0, worst, 1e-10,
                  scale=2e-3)
    trace = sum(gradient[i][i] for i in range(3))
    shear, bulk = young/(2*(1 + nu)), young*nu/((1 + nu)*(1 - 2*nu))
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
    stress = [shear*(gradient[i][j] + gradient[j][i]) + (bulk*trace if i == j else 0.0)
              for i, j in pairs]
    worst = max(abs(a - b) for row in tables.stresses() for a, b in zip(row, stress))
    bench.compare('stress, worst element', EXACT, 0.0, worst, 1e-10, scale=2e-3*young)


def bending(x, length, radius, nu):
    """Displacement of a beam bent to a radius, clamped in the mean at x = 0."""
    a, b, c = x
    return (a*c/radius, -nu*b*c/radius, -(a*a + nu*(c*c - b*b))/(2*radius))


def bent_beam(n, young, nu, length, radius):
    """A cantilever of 2n x n x n cells bent by the tractions of pure bending at its end."""
    mesh = meshing.Mesh()
    number = mesh.box((2*n, n, n), lambda i, j, k: (length*i/(2*n), j/n - 0.5, k/n - 0.5))
    clamped = [number(0, j, k) for j in range(n + 1) for k in range(n + 1)]
    forces = {}
    for j in range(n):
        for k in range(n):
            corner = [number(2*n, j + b, k + c) for b, c in ((0, 0), (1, 0), (1, 1), (0, 1))]
            for facet in ((corner[0], corner[1], corner[2]), (corner[0], corner[2], corner[3])):
                height = [mesh.nodes[m - 1][2] for m in facet]
                for m, z in zip(facet, height):
                    forces[m] = forces.get(m, 0.0) + young/radius*(sum(height) + z)/(24*n*n)
    return mesh, [
        meshing.vectors('BOUNdary', {m: (1, 1, 1) for m in clamped}),
        meshing.vectors('DISPlacement', {m: bending(mesh.nodes[m - 1], length, radius, nu)
                                         for m in clamped}),
        meshing.vectors('FORCe', {m: (f, 0, 0) for m, f in forces.items()})]


def energy_error(mesh, stresses, young, nu, radius):
    """Relative error of the stress in the energy norm; the exact stress is E z/radius along x."""
    shear, error, whole = young/(2*(1 + nu)), 0.0, 0.0
    for (_, *corners), volume, s in zip(mesh.elements, mesh.volumes(), stresses):
        z = [mesh.nodes[m - 1][2] for m in corners]
        middle, square = sum(z)/4, (sum(z)**2 + sum(v*v for v in z))/20
        trace = s[0] + s[1] + s[2]
        own = sum(v*v for v in s[:3])*(1 + nu)/young - nu/young*trace**2 + \
            sum(v*v for v in s[3:])/shear
        mixed = (s[0] - nu*(s[1] + s[2]))/young*young*middle/radius
        exact = young*square/radius**2
        error += volume*(own - 2*mixed + exact)
        whole += volume*exact
    return math.sqrt(error/whole)


def cantilever(bench):
    """Rates of convergence in pure bending."""
    young, nu, length, radius = 1000.0, bench.draw('nu', 0.1, 0.35), bench.draw('length', 1.7, 2.3), 100.0
    sizes, tips, errors, energies = (4, 8, 16), [], [], []
    for n in sizes:
        mesh, sections = bent_beam(n, young, nu, length, radius)
        tables = bench.run_text(f'cantilever_{n}', deck('Cantilever in pure bending', mesh, young,
                                                        nu, sections))
        found = tables.displacements()[-1]
        wrong = [sum((a - b)**2 for a, b in zip(found[m], bending(x, length, radius, nu)))
                 for m, x in enumerate(mesh.nodes, 1)]
        size = [sum(a*a for a in bending(x, length, radius, nu)) for x in mesh.nodes]
        errors.append(math.sqrt(sum(wrong)/sum(size)))
        energies.append(energy_error(mesh, tables.stresses(), young, nu, radius))
        end = mesh.where(lambda x, y, z: x == length and y == 0.0 and z == 0.0)[0]
        tips.append(found[end][2]/bending(mesh.nodes[end - 1], length, radius, nu)[2])
    for n, tip, error, energy in zip(sizes, tips, errors, energies):
        bench.remark(f'{2*n} x {n} x {n} cells: tip deflection {tip:.5f} of the exact one, L2 error '
                     f'{error:.3e}, energy error {energy:.3e}')
    for name, values, rate in (('L2', errors, 2.0), ('energy', energies, 1.0)):
        bench.compare(f'{name} rate, {sizes[-2]} to {sizes[-1]} cells in the height',
                      'theory: linear elements', rate, math.log2(values[-2]/values[-1]), 0.1)
