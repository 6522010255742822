"""Contact benchmarks of NAFEMS R0094 (Konter 2006) that are bodies of their own here: the punch with
rounded edges (no. 2). The roller (no. 1) is in roller_studies, the wedge CGS-4 in friction_studies."""
import math

import meshing
import quadratic_studies as quadratic
import unstructured

# Displacement of the centre of the contact without friction: EDF's manual V6.01.122, model D (671 eight-node
# rings). Model A (four-node rings) has -0.13073, and with mu = 0.1 -0.12858: coarser, so 1.7 % below.
FINE = -0.13289744810653
COARSE = {0.0: -0.13073, 0.1: -0.12858}
SOURCE = 'code (Code_Aster V6.01.122)'


def graded(occ, cell):
    """Cells of a size around the edge of the contact (r = 42), growing away from it, at most 25."""
    import gmsh
    occ.synchronize()
    field = gmsh.model.mesh.field.add('MathEval')
    away = 'Sqrt((Sqrt(x*x+y*y)-42)^2+z*z)'
    size = f'{cell!r}+0.22*0.5*({away}-6+Fabs({away}-6))'
    gmsh.model.mesh.field.setString(field, 'F', f'0.5*({size}+25-Fabs({size}-25))')
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for name, value in (('SizeMin', 0), ('SizeMax', 1e22), ('SizeExtendFromBoundary', 0), ('SizeFromPoints', 0)):
        gmsh.option.setNumber('Mesh.Mesh' + name, value)


def foundation(cell):
    """A quarter of the cylinder R 100, H 200 below z = 0."""
    def build(occ):
        occ.addCylinder(0, 0, -200, 0, 0, 200, 100, angle=math.pi/2)
        graded(occ, cell)
    return unstructured.meshed(build, cell)


def punch(cell):
    """A quarter of the cylinder R 50, H 100 on z = 0, its lower edge rounded by 10."""
    def build(occ):
        points = [occ.addPoint(x, 0, z) for x, z in ((0, 0), (40, 0), (40, 10), (50, 10), (50, 100), (0, 100))]
        lines = [occ.addLine(points[0], points[1]), occ.addCircleArc(points[1], points[2], points[3]),
                 occ.addLine(points[3], points[4]), occ.addLine(points[4], points[5]),
                 occ.addLine(points[5], points[0])]
        face = occ.addPlaneSurface([occ.addCurveLoop(lines)])
        occ.revolve([(2, face)], 0, 0, 0, 0, 0, 1, math.pi/2)
        graded(occ, cell)
    return unstructured.meshed(build, cell)


def middle(p, q):
    """The middle of an edge, on the cylinder or fillet that both ends lie on."""
    x, y, z = ((a + b)/2 for a, b in zip(p, q))
    r, ends = math.hypot(x, y), [(math.hypot(*v[:2]), v[2]) for v in (p, q)]
    on_fillet = all(0 <= h < 10 + 1e-6 and r > 39.999 and abs(math.hypot(r - 40, h - 10) - 10) < 1e-6 for r, h in ends)
    if on_fillet:
        wanted = sum(v for v, _ in ends)/2
        off, up = wanted - 40, z - 10
        far = 10/math.hypot(off, up)
        wanted, z = 40 + far*off, 10 + far*up
    elif abs(ends[0][0] - ends[1][0]) < 1e-6 and min(abs(ends[0][0] - round_) for round_ in (50, 100)) < 1e-6:
        wanted = ends[0][0]
    else:
        return x, y, z
    return x*wanted/r, y*wanted/r, z


def bodies(cell):
    """Both, the foundation in cells 1.2 times as large, with ten nodes; the number of its elements."""
    mesh, parts = meshing.Mesh(), (foundation(1.2*cell), punch(cell))
    for material, body in enumerate(parts, 1):
        first = len(mesh.nodes)
        mesh.nodes += body.nodes
        mesh.elements += [(material, *(n + first for n in e)) for e in body.elements]
    return quadratic.ten_nodes(mesh, middle), len(parts[0].elements)


def deck(mesh, below, mu):
    """Pressed by 100 MPa on the top of the punch; the foundation stands on its bottom."""
    lower = {n for e in mesh.elements[:below] for n in e[1:]}
    codes = {}
    for n, x in enumerate(mesh.nodes, 1):
        code = (1, 1, 1) if x[2] < -199.999 else tuple(int(abs(v) < 1e-9) for v in x[:2]) + (0,)
        if any(code):
            codes[n] = code
    sets = {'ground': [n for n in lower if abs(mesh.nodes[n - 1][2]) < 1e-9],
            'sole': [n for n, x in enumerate(mesh.nodes, 1) if n not in lower and x[2] < 6.0],
            'top': [n for n, x in enumerate(mesh.nodes, 1) if x[2] > 99.999]}
    # Facets of the sole: those below 6 mm; the cuts at x = 0 and y = 0 are no part of it.
    return ('MFEC * * NAFEMS R0094, no. 2\n\n' + meshing.solid(1, 70000.0, 0.3) + meshing.solid(2, 210000.0, 0.3) +
            quadratic.records(mesh) + ''.join(meshing.node_set(name, nodes) for name, nodes in sets.items()) +
            'SURFace slave FROM ground\nSURFace master FROM sole\nSURFace loaded FROM top\n\n' +
            meshing.vectors('BOUNdary', codes) + 'PRESsure\n  loaded 100 1\n\nPROPortional 1\n  0 0\n  1 1\n\n'
            'CONTact\n  PAIR 1 sole\n    GTOS slave master 6\n' + (f'    FRICtion COULomb {mu!r}\n' if mu else '') +
            '\nOUTPut\n  FIELds displacement contact\n  STATe NONE\n\nEND\nBATCh\n  DT,,0.25\n  STEP,,4\nEND\nSTOP\n')


def rounded_punch(bench):
    """Displacement of the centre of the foundation's face over three meshes, without friction and with 0.1."""
    cells = (8.0,) if bench.reduced else (8.0, 5.0, 3.0)
    found = {0.0: [], 0.1: []}
    for cell in cells:
        mesh, below = bodies(cell)
        centre = min((max(abs(v) for v in mesh.nodes[n - 1]), n) for e in mesh.elements[:below] for n in e[1:])[1]
        for mu, moved in found.items():
            tables = bench.run_text('punch', deck(mesh, below, mu))
            with tables.results() as file:
                moved.append(float(file['VTKHDF/PointData/displacement'][-len(mesh.nodes):][centre - 1, 2]))
        where = f'cells of {cell:.0f} mm'
        bench.compare('displacement of the centre, mu = 0', SOURCE, FINE, found[0.0][-1], 0.005, form='GTOS 6',
                      mesh=where)
        bench.compare('displacement with mu = 0.1 over that without', SOURCE, COARSE[0.1]/COARSE[0.0],
                      found[0.1][-1]/found[0.0][-1], 0.002, form='GTOS 6', mesh=where)
    bench.picture('nafems_punch', ('cells at the edge of the contact [mm]', 'displacement of the centre [mm]',
                                   'Punch with rounded edges (NAFEMS R0094, no. 2)'),
                  [(f'mfec, mu = {mu}', 'o-', cells, moved) for mu, moved in found.items()] +
                  [(f'Code_Aster, {name}', style, (0.0, 8.0), (value, value)) for name, style, value in (
                      ('eight-node rings, mu = 0', 'k-', FINE), ('four-node rings, mu = 0', 'k--', COARSE[0.0]),
                      ('four-node rings, mu = 0.1', 'k:', COARSE[0.1]))])
