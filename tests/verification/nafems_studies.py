"""Contact benchmarks of NAFEMS R0094 (Konter 2006) that are bodies of their own here: the punch with
rounded edges (no. 2) and the loaded pin (no. 4). The roller (no. 1) is in roller_studies, the wedge CGS-4
in friction_studies."""
import math

import meshing
import quadratic_studies as quadratic
import unstructured

# Displacement of the centre of the contact without friction: EDF's manual V6.01.122, model D (671 eight-node
# rings). Model A (four-node rings) has -0.13073, and with mu = 0.1 -0.12858: coarser, so 1.7 % below.
FINE = -0.13289744810653
COARSE = {0.0: -0.13073, 0.1: -0.12858}
SOURCE = 'code (Code_Aster V6.01.122)'
# Forms and the record of each.
BENDS = ('a dual function is negative away from its node: of a gap that opens with the curvature k it sees k h^2/6 less '
         'than is there, so slave nodes beside a rounding of radius 10 close too early; the error falls with h^2')
PAIRS = {'GTOS 6': 'GTOS slave master 6', 'MORTar': 'MORTar slave master'}
# The same of the bore under the load, and the stress there: EDF's manual V6.03.156, model B (contact at points of
# Gauss). Model A (contact at nodes) has 0.71799091025213 and -136.67357, coarser by 2.5 %.
PIN, PIN_STRESS = 0.736165779271, -160.40113477117
PIN_SOURCE = 'code (Code_Aster V6.03.156)'


def graded(occ, cell, away='Sqrt((Sqrt(x*x+y*y)-42)^2+z*z)'):
    """Cells of a size around the edge of the contact (of the punch: r = 42), growing away from it, at most 25."""
    import gmsh
    occ.synchronize()
    field = gmsh.model.mesh.field.add('MathEval')
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
    return quadratic.unfold(quadratic.ten_nodes(mesh, middle)), len(parts[0].elements)


def forms_of(bench):
    """The form of a variant, or the usual one: the decks here are made for either."""
    form, bench.variant = bench.variant or 'GTOS 6', None
    return (form,)


def deck(mesh, below, mu, form):
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
            f'CONTact\n  PAIR 1 sole\n    {PAIRS[form]}\n' + (f'    FRICtion COULomb {mu!r}\n' if mu else '') +
            '\nOUTPut\n  FIELds displacement contact\n  STATe NONE\n\nEND\nBATCh\n  DT,,0.25\n  STEP,,4\nEND\nSTOP\n')


def rounded_punch(bench):
    """Displacement of the centre of the foundation's face over three meshes, without friction and with 0.1."""
    cells = (8.0,) if bench.reduced else (8.0, 5.0, 3.0)
    forms = forms_of(bench)
    found = {(form, mu): [] for form in forms for mu in (0.0, 0.1)}
    for cell in cells:
        mesh, below = bodies(cell)
        centre = min((max(abs(v) for v in mesh.nodes[n - 1]), n) for e in mesh.elements[:below] for n in e[1:])[1]
        for (form, mu), moved in found.items():
            tables = bench.run_text('punch', deck(mesh, below, mu, form))
            with tables.results() as file:
                moved.append(float(file['VTKHDF/PointData/displacement'][-len(mesh.nodes):][centre - 1, 2]))
        where = f'cells of {cell:.0f} mm'
        for form in forms:
            known = (0.09, 0.0025) if form == 'MORTar' else (None, None)
            bench.compare('displacement of the centre, mu = 0', SOURCE, FINE, found[form, 0.0][-1], 0.005, form=form,
                          mesh=where, known=known[0], why=BENDS)
            bench.compare('displacement with mu = 0.1 over that without', SOURCE, COARSE[0.1]/COARSE[0.0],
                          found[form, 0.1][-1]/found[form, 0.0][-1], 0.002, form=form, mesh=where, known=known[1],
                          why=BENDS)
    bench.picture('nafems_punch', ('cells at the edge of the contact [mm]', 'displacement of the centre [mm]',
                                   'Punch with rounded edges (NAFEMS R0094, no. 2)'),
                  [(f'{form}, mu = {mu}', 'o-' if form != 'MORTar' else 'D-', cells, moved)
                   for (form, mu), moved in found.items()] +
                  [(f'Code_Aster, {name}', style, (0.0, 8.0), (value, value)) for name, style, value in (
                      ('eight-node rings, mu = 0', 'k-', FINE), ('four-node rings, mu = 0', 'k--', COARSE[0.0]),
                      ('four-node rings, mu = 0.1', 'k:', COARSE[0.1]))])


def half_pin(cell):
    """Half of the pin R 50 (y > 0), a slice as thick as a cell, with an edge along its axis."""
    def build(occ):
        quarters = [(3, occ.addCylinder(0, 0, 0, 0, 0, cell, 50, angle=math.pi/2)) for _ in range(2)]
        occ.rotate(quarters[1:], 0, 0, 0, 0, 0, 1, math.pi/2)
        occ.fragment(quarters[:1], quarters[1:])
        graded(occ, cell, 'Fabs(Sqrt(x*x+y*y)-50)')
    return unstructured.meshed(build, cell)


def half_sheet(cell):
    """Half of the sheet: 200 from its held end to the bore R 50, as wide, its free end round."""
    def build(occ):
        whole = occ.fuse([(3, occ.addBox(-200, 0, 0, 200, 100, cell))],
                         [(3, occ.addCylinder(0, 0, 0, 0, 0, cell, 100, angle=math.pi/2))])[0]
        occ.cut(whole, [(3, occ.addCylinder(0, 0, 0, 0, 0, cell, 50, angle=math.pi))])
        graded(occ, cell, 'Fabs(Sqrt(x*x+y*y)-50)')
    return unstructured.meshed(build, cell)


def on_arc(p, q):
    """The middle of an edge, on the circle about z that both ends lie on."""
    x, y, z = ((a + b)/2 for a, b in zip(p, q))
    ends = [math.hypot(*v[:2]) for v in (p, q)]
    if abs(ends[0] - ends[1]) < 1e-6 and min(abs(ends[0] - r) for r in (50, 100)) < 1e-6 and p[0] + q[0] > -99:
        return x*ends[0]/math.hypot(x, y), y*ends[0]/math.hypot(x, y), z
    return x, y, z


def pin_deck(mesh, sheet, cell, form):
    """Plane strain; 10 kN for each mm of thickness on the axis of half the pin."""
    of_sheet, of_pin = ({n for e in part for n in e[1:]} for part in (mesh.elements[:sheet], mesh.elements[sheet:]))
    codes, axis = {}, [n for n in of_pin if math.hypot(*mesh.nodes[n - 1][:2]) < 1e-9]
    for n, x in enumerate(mesh.nodes, 1):
        codes[n] = (1, 1, 1) if x[0] < -199.999 else (0, int(abs(x[1]) < 1e-9), 1)
    round_ = [{n for n in nodes if abs(math.hypot(*mesh.nodes[n - 1][:2]) - 50) < 1e-6} for nodes in (of_pin, of_sheet)]
    shares = {n: 1/6 if min(abs(mesh.nodes[n - 1][2] - z) for z in (0, cell)) < 1e-9 else 2/3 for n in axis}
    scale = 10000.0*cell/sum(shares.values())
    law = 'MATErial {}\n  SOLId SVK\n  ELAStic ISOTropic {!r} 0.3\n\n'
    return ('MFEC * * NAFEMS R0094, no. 4\n\n' + law.format(1, 70000.0) + law.format(2, 210000.0) +
            quadratic.records(mesh) + meshing.node_set('pin', sorted(round_[0])) + meshing.node_set('bore', sorted(round_[1])) +
            'SURFace slave FROM pin\nSURFace master FROM bore\n\n' + meshing.vectors('BOUNdary', codes) +
            meshing.vectors('FORCe', {n: (scale*share, 0.0, 0.0) for n, share in shares.items()}) +
            'PROPortional 1\n  0 0\n  1 1\n\nCONTact\n  PAIR 1 pin\n'
            f'    {PAIRS[form]}\n    FRICtion COULomb 0.1\n'
            '\nOUTPut\n  FIELds displacement stress contact\n  STATe NONE\n\nEND\nBATCh\n  DT,,0.125\n  STEP,,8\nEND\nSTOP\n')


def loaded_pin(bench):
    """Displacement and stress of the bore under the load, over three meshes."""
    forms = forms_of(bench)
    cells, moved = (12.0,) if bench.reduced else (12.0, 8.0, 5.0), {form: [] for form in forms}
    for cell in cells:
        sheet, pin = half_sheet(cell), half_pin(cell)
        mesh = meshing.Mesh()
        for material, body in enumerate((sheet, pin), 1):
            first = len(mesh.nodes)
            mesh.nodes += body.nodes
            mesh.elements += [(material, *(n + first for n in e)) for e in body.elements]
        mesh = quadratic.unfold(quadratic.ten_nodes(mesh, on_arc))
        under = min((math.dist(x, (50, 0, 0)), n) for n, x in enumerate(mesh.nodes, 1) if n <= len(sheet.nodes))[1]
        for form in forms:
            with bench.run_text('pin', pin_deck(mesh, len(sheet.elements), cell, form)).results() as file:
                way = float(file['VTKHDF/PointData/displacement'][-len(mesh.nodes):][under - 1, 0])
                stress = float(file['VTKHDF/PointData/nodal_stress'][-len(mesh.nodes):][under - 1, 0])
            moved[form].append(way)
            where = f'cells of {cell:.0f} mm'
            bench.compare('displacement of the bore under the load', PIN_SOURCE, PIN, way, 0.002, form=form, mesh=where)
            bench.compare('stress of the bore under the load', PIN_SOURCE, PIN_STRESS, stress, 0.02, form=form, mesh=where)
    bench.picture('nafems_pin', ('cells at the bore [mm]', 'displacement of the bore [mm]', 'Loaded pin (NAFEMS R0094, no. 4)'),
                  [(form, 'D-' if form == 'MORTar' else 'o-', cells, ways) for form, ways in moved.items()] + [('Code_Aster, model B', 'k-', (0.0, 12.0), (PIN, PIN))])
