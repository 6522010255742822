"""Contact pressure: patch tests, matching and not, flat, inclined and sheared."""
import math
import re

import meshing
import quadratic_studies as quadratic
import unstructured

EXACT = 'exact'
SEGMENTED, MORTAR = 'GTOS SEGMent', 'MORTar'
POINTS = 'the rule of fixed points on slave facets that lie over several master facets. It grows with the ' \
    'Poisson ratio that is drawn: sheared, 2 on 3, 2.3e-2 at 0.24 and 3.3e-2 at 0.42 with 3 points, there ' \
    '8.9e-3 with 6 and 3.4e-3 with 12; SEGMent has 1e-8'
WHOLE = ('NTOS hands the force of a slave node to one facet, which is not the integral of a uniform pressure '
         'over the master facets (doc/theory, "Quadrature points"); GTOS and SEGMent integrate')
ROUNDS = ('the bodies are carried by their supports before they touch, so that the cells of the first round are those of '
          'another place; rounds and cuts end where what is left is below their tolerances. Pressed by loads the same blocks '
          'are exact to 1e-15')
DEPTH = 0.01
NOT_MATCHING = ((3, 2), (2, 3), (4, 3), (6, 4), (7, 5), (5, 8))


def patch_error(bench, slave, master, form='NTOS', augmented=False, ten=''):
    """Relative L2 error of the stress; form: NTOS or GTOS, and what follows the surfaces; ten: the
    blocks of elements of ten nodes, of 'upper', 'lower'."""
    drawn = bench.drawn[bench.case]
    young, nu, eps, depth = drawn['E'], drawn['nu'], 100*drawn['E'], 0.01
    modulus = young*(1 - nu)/((1 + nu)*(1 - 2*nu))
    p = depth/(2/modulus + (0 if augmented or form == MORTAR else 1/eps))
    side = -p*nu/(1 - nu)
    with open(bench.path('contact_patch/contact_patch.inp'), encoding='ascii') as stream:
        text = stream.read()
    keyword, points = (form + ' ').split(' ', 1)
    if text.count('NTOS    under track') != 1:
        raise ValueError('the deck has no pair to change')
    text = text.replace('NTOS    under track', f'{keyword} under track {points}' +
                        augmented*'\n    AUGMent 1e-9 40')
    for block, cells in (('upper', 'ns'), ('lower', 'nm')):
        plain = f'CART {cells} {cells} {cells}  MATErial 1  TET4'
        if text.count(plain) != 1:
            raise ValueError(f'the deck has no block {block} to change')
        if block in ten:
            text = text.replace(plain, plain.replace('TET4', 'TET10'))
    tables = bench.run_text('contact_patch', text, ns=slave, nm=master, young=young, nu=nu, eps=eps)
    return stress_error(tables, slave, master, (side, side, -p, 0.0, 0.0, 0.0))


def stress_error(tables, slave, master, exact):
    """L2 error of the stress of both blocks over that of the solution."""
    stresses = tables.stresses()
    blocks = stresses[:6*slave**3], stresses[6*slave**3:]
    if len(blocks[1]) != 6*master**3:
        raise ValueError('unexpected number of elements')
    error = sum(square(stress, exact)/len(block) for block in blocks for stress in block)
    return math.sqrt(error/(2*square(exact, (0.0,)*6)))


def square(a, b):
    """Square of the difference of two stresses; shears count twice."""
    return sum((x - y)**2*(1 if i < 3 else 2) for i, (x, y) in enumerate(zip(a, b)))


def loaded_patch(bench, slave, master, form, slope, shear, augmented=False, ten=False):
    """Relative L2 error of the stress where two blocks meet in the plane z = slope x and stick.

    The stress is -1 along z, and a shear in the xz plane. The sides carry its tractions as nodal
    forces, bottom and top its displacements: those of a uniform strain, and above the joint the
    gap vector (stress . normal)/eps as well, which AUGMent and MORTar make zero.
    """
    young, nu = bench.drawn[bench.case]['E'], bench.drawn[bench.case]['nu']
    eps = 10*young
    exact = (0.0, 0.0, -1.0, 0.0, 0.0, shear)
    traction = (-slope*exact[0] + shear, 0.0, -slope*shear - 1.0)
    gap = tuple((not augmented and form != MORTAR)*value/(eps*math.hypot(1.0, slope)) for value in traction)
    mesh, parts = sloping_blocks(slave, master, slope, ten)
    strain = {'x': nu/young, 'z': -1/young, 'xz': (1 + nu)/young*shear}

    def displacement(node):
        x, y, z = mesh.nodes[node - 1]
        shift = gap if node in upper else (0.0, 0.0, 0.0)
        return (strain['x']*x + strain['xz']*z + shift[0], strain['x']*y + shift[1],
                strain['xz']*x + strain['z']*z + shift[2])

    upper = set(parts['upper'])
    forces = {}
    for end, sign in (('left', -1.0), ('right', 1.0)):
        for node, area in quadratic.shares(mesh, parts[end]).items():
            forces[node] = (0.0, 0.0, sign*shear*area)
    held = {n: displacement(n) for n in parts['top'] + parts['bottom']}
    sets = ''.join(meshing.node_set(name, parts[name]) for name in ('sole', 'face'))
    text = ('MFEC * * Patch\n\n' + meshing.solid(1, young, nu) + quadratic.records(mesh) + sets +
            'SURFace under FROM sole\nSURFace track FROM face\n\n' +
            meshing.vectors('BOUNdary', {n: (1, 1, 1) for n in held}) +
            meshing.vectors('DISPlacement', held) + meshing.vectors('FORCe', forces) +
            'CONTact\n  PAIR 1\n    ' + re.sub(r'^\w+', r'\g<0> under track', form) +
            augmented*'\n    AUGMent 1e-9 40' +
            f"""
    PENAlty  AREA {eps!r}
    FRICtion COULomb 0.5

OUTPut
  FIELds stress

END
BATCh
""" + '  TOL,,1e-20\n'*(form == MORTAR) + """  DT,,1
  STEP,,1
END
STOP
""")
    tables = bench.run_text('loaded_patch', text)
    row = tables.contact('1')[-1]
    if row['slip'] > 0:
        raise ValueError('a point slips')
    return stress_error(tables, slave, master, exact)


def sloping_blocks(slave, master, slope, ten=False):
    """Two blocks of section 1 from z = -1 to 1 that meet in z = slope x, and their parts."""
    mesh = meshing.Mesh()

    def between(n, low, high):
        def place(i, j, k):
            x = i/n
            return x, j/n, low(x) + (high(x) - low(x))*k/n
        return place

    mesh.box((slave,)*3, between(slave, lambda x: slope*x, lambda x: 1.0))
    mesh.box((master,)*3, between(master, lambda x: -1.0, lambda x: slope*x))
    if ten:
        mesh = quadratic.ten_nodes(mesh)
    above = {n for e in mesh.elements[:6*slave**3] for n in e[1:]}
    joint = mesh.where(lambda x, y, z: abs(z - slope*x) < 1e-9)
    return mesh, {
        'upper': sorted(above),
        'sole': [n for n in joint if n in above], 'face': [n for n in joint if n not in above],
        'top': mesh.where(lambda x, y, z: z > 1 - 1e-9),
        'bottom': mesh.where(lambda x, y, z: z < -1 + 1e-9),
        'left': mesh.where(lambda x, y, z: x < 1e-9),
        'right': mesh.where(lambda x, y, z: x > 1 - 1e-9)}


def joint(bench):
    """Draws the material; the slope and the shear of the joint."""
    bench.draw('E', 200.0, 5000.0)
    bench.draw('nu', 0.05, 0.45)
    return bench.draw('slope', 0.1, 0.3), bench.draw('shear', 0.05, 0.2)


def wanted_of(form, segmented=1e-9):
    """What is wanted of a form that integrates exactly."""
    return 1e-10 if form == MORTAR else segmented


def left_of(form):
    """What is known of MORTar where bodies are pressed by displacements."""
    return {'known': 1e-8, 'why': ROUNDS} if form == MORTAR else {}


def matching_patch(bench):
    """Equal meshes, and the plainest that are not."""
    slope, drawn = joint(bench)
    for n in (1, 3):
        for form in ('NTOS', 'GTOS', MORTAR):
            bench.compare(f'L2 error of the stress, {n} on {n}', EXACT, 0.0,
                          patch_error(bench, n, n, form), 1e-10, scale=1.0, form=form)
    for form in (SEGMENTED, MORTAR):
        for text, shear in (('', 0.0), (', sheared', drawn)):
            bench.compare(f'inclined{text}, sticking, 3 on 2', EXACT, 0.0,
                          loaded_patch(bench, 3, 2, form, slope, shear), wanted_of(form), scale=1.0, form=form,
                          **left_of(form))
    bench.compare('SMOOth: L2 error of the stress, 3 on 2', EXACT, 0.0,
                  patch_error(bench, 3, 2, SEGMENTED + '\n    SMOOth'), 1e-10, scale=1.0,
                  form=SEGMENTED + ' +SMOO')
    bench.compare('SMOOth: inclined, sheared, sticking, 3 on 2', EXACT, 0.0,
                  loaded_patch(bench, 3, 2, SEGMENTED + '\n    SMOOth', slope, drawn), 1e-9, scale=1.0,
                  form=SEGMENTED + ' +SMOO')
    for form in (SEGMENTED, MORTAR):
        for text, blocks in (('ten nodes', 'upper lower'), ('ten nodes on four', 'upper'),
                             ('four nodes on ten', 'lower')):
            bench.compare(f'{text}: L2 error of the stress, 3 on 2', EXACT, 0.0,
                          patch_error(bench, 3, 2, form, ten=blocks), 1e-10, scale=1.0, form=form)
        for text, shear in (('inclined', 0.0), ('inclined, sheared', drawn)):
            bench.compare(f'ten nodes: {text}, sticking, 3 on 2', EXACT, 0.0,
                          loaded_patch(bench, 3, 2, form, slope, shear, ten=True), 1e-10, scale=1.0, form=form,
                          **left_of(form))
    bench.compare('L2 error of the stress, 3 on 2', EXACT, 0.0,
                  patch_error(bench, 3, 2, 'GTOS'), 0.025, scale=1.0, form='GTOS')
    bench.compare('the same, inclined, sticking', EXACT, 0.0,
                  loaded_patch(bench, 3, 2, 'GTOS', slope, 0.0), 0.025, scale=1.0, form='GTOS')


def non_matching_patch(bench):
    """Unequal meshes: node-to-surface does not pass, whatever the penalty."""
    known = dict(zip(NOT_MATCHING, (0.065, 0.2, 0.044, 0.044, 0.028, 0.11)))
    found, (leans, drawn) = {}, joint(bench)
    pairs = NOT_MATCHING[:2] if bench.reduced else NOT_MATCHING

    def note(form, error):
        found.setdefault(form, []).append(max(error, 1e-16))

    for slave, master in pairs:
        note('NTOS', bench.compare(f'L2 error of the stress, {slave} on {master}', EXACT, 0.0,
                      patch_error(bench, slave, master), 0.025, scale=1.0,
                      known=known[slave, master], why=WHOLE))
    for form in ('GTOS', 'GTOS 12'):
        for slave, master in pairs:
            note(form, bench.compare(f'L2 error of the stress, {slave} on {master}', EXACT, 0.0,
                                     patch_error(bench, slave, master, form), 0.025, scale=1.0,
                                     form=form))
    cases = (('inclined, sticking', leans, 0.0), ('sheared, sticking', 0.0, drawn))
    both = cases + (('inclined, sheared, sticking', leans, drawn),)
    for text, slope, shear in cases:
        for slave, master in pairs + ((3, 3),):
            bench.compare(f'{text}, {slave} on {master}', EXACT, 0.0,
                          loaded_patch(bench, slave, master, 'GTOS', slope, shear),
                          1e-10 if slave == master else 0.025, scale=1.0, form='GTOS',
                          known=None if slave == master else 0.04, why=POINTS)
    for form in (SEGMENTED, MORTAR):
        for slave, master in pairs:
            note(form, bench.compare(
                f'L2 error of the stress, {slave} on {master}', EXACT, 0.0,
                patch_error(bench, slave, master, form), wanted_of(form), scale=1.0, form=form))
            for text, slope, shear in both:
                bench.compare(f'{text}, {slave} on {master}', EXACT, 0.0,
                              loaded_patch(bench, slave, master, form, slope, shear), wanted_of(form, 1e-8),
                              scale=1.0, form=form, **left_of(form))
    for slave, master in pairs:
        for text, slope, shear in (('pressed', 0.0, 0.0),) + both:
            bench.compare(f'ten nodes: {text}, {slave} on {master}', EXACT, 0.0,
                          loaded_patch(bench, slave, master, MORTAR, slope, shear, ten=True), 1e-10, scale=1.0,
                          form=MORTAR, **left_of(MORTAR))
    for form, wanted, most in ((SEGMENTED, 1e-8, None), ('GTOS 6', 5e-3, 6e-3)):
        for slave, master in pairs:
            note(form + ' +AUGM', bench.compare(
                f'L2 error of the stress, {slave} on {master}', EXACT, 0.0,
                patch_error(bench, slave, master, form, True), wanted, scale=1.0,
                form=form + ' +AUGM', known=most, why=POINTS))
            for text, slope, shear in both:
                bench.compare(f'{text}, {slave} on {master}', EXACT, 0.0,
                              loaded_patch(bench, slave, master, form, slope, shear, True), wanted,
                              scale=1.0, form=form + ' +AUGM', known=most, why=POINTS)
    bench.picture('patch', ('number of the pair of meshes, 3 on 2 to 5 on 8',
                            'log10 of the L2 error of the stress', 'Patch test'), [
        (form, 'o-', range(1, len(errors) + 1), [math.log10(e) for e in errors])
        for form, errors in found.items()])
    bench.remark('GTOS integrates over the slave facets; what is left is that of facets which lie over several master '
                 'facets, and it falls with the number of points. SEGMent integrates over the '
                 'intersections of the facets, which is exact. AUGMent closes the gaps on average '
                 'over the slave nodes and integrates as the form does: with SEGMent exactly, with '
                 '6 points as GTOS 6 does.')


def unstructured_patch(bench):
    """Two boxes meshed by gmsh, pressed between smooth walls; AUGMent beside penalties."""
    joint(bench)
    size, mu = bench.draw('facet', 0.2, 0.3), bench.draw('mu', 0.1, 0.8)
    bodies = [unstructured.box((0, 0, 0), (1, 1, 1), size),
              unstructured.box((0, 0, -1), (1, 1, 1), bench.draw('master over slave', 1.15, 1.4)*size)]
    mesh = meshing.Mesh()
    for body in bodies:
        first = len(mesh.nodes)
        mesh.nodes += body.nodes
        mesh.elements += [(1, *(n + first for n in e)) for e in body.elements]
    young, errors = bench.drawn[bench.case]['E'], {}
    for form, wanted, known in (('NTOS', 0.025, 0.06), ('GTOS', 0.025, None), ('GTOS 6', 0.025, None),
                                (SEGMENTED, 1e-9, None)):
        for factor in (10, 100, 10000):
            errors[form, factor] = bench.compare(
                f'L2 error of the stress, {factor} E/h', EXACT, 0.0,
                pressed_boxes(bench, mesh, len(bodies[0].nodes), form, factor*young/size), wanted, scale=1.0,
                form=form, known=known, why=WHOLE)
        errors[form, 0] = bench.compare(
            'L2 error of the stress', EXACT, 0.0, pressed_boxes(bench, mesh, len(bodies[0].nodes), form, None),
            wanted, scale=1.0, form=form + ' +AUGM', known=known, why=WHOLE)
    for text, ten in (('', False), ('ten nodes: ', True)):
        bench.compare(f'{text}L2 error of the stress', EXACT, 0.0,
                      pressed_boxes(bench, mesh, len(bodies[0].nodes), MORTAR, None, ten), 1e-10, scale=1.0, form=MORTAR)
        for form in (SEGMENTED, MORTAR):
            tables = pressed(bench, mesh, len(bodies[0].nodes), form, f'PENAlty AUTO\n    FRICtion COULomb {mu!r}', ten)
            bench.compare(f'{text}lateral force over Fn', EXACT, 0.0, lateral_share(tables), 1e-9, scale=1.0, form=form)
    for form in ('GTOS', 'GTOS 6'):
        bench.compare('error over that of 100 E/h', 'the penalty of the field', 1.0,
                      errors[form, 0]/errors[form, 100], 0.2, form=form + ' +AUGM')
    bench.remark('GTOS with AUGMent has the error of GTOS at 100 E/h, the penalty of its field: a smooth field of forces '
                 'at fixed points hands the nodes of the master shares that are wrong by the error of the rule. Stiffer, '
                 'the forces of the points part until each gap closes, which is the flat joint, and the error falls ('
                 f'{errors["GTOS", 10]:.1e}, {errors["GTOS", 100]:.1e}, {errors["GTOS", 10000]:.1e} at 10, 100, 1e4 E/h): '
                 'in a joint that is not flat those forces are rough. SEGMent has no such error')


def pressed_boxes(bench, mesh, last, form, eps, ten=False):
    """L2 error of the stress of two boxes that are pressed together; eps: penalty, or None for AUGMent and MORTar."""
    young, nu = bench.drawn[bench.case]['E'], bench.drawn[bench.case]['nu']
    modulus = young*(1 - nu)/((1 + nu)*(1 - 2*nu))
    p = DEPTH/(2/modulus + (1/eps if eps else 0))
    exact = (-p*nu/(1 - nu), -p*nu/(1 - nu), -p, 0.0, 0.0, 0.0)
    law = f'PENAlty AREA {eps!r}' if eps else '' if form == MORTAR else 'AUGMent 1e-9 40'
    tables, volumes = pressed(bench, mesh, last, form, law, ten), mesh.volumes()
    error = sum(v*square(found, exact) for v, found in zip(volumes, tables.stresses()))
    return math.sqrt(error/(sum(volumes)*square(exact, (0.0,)*6)))


def pressed(bench, mesh, last, form, law, ten=False, walls=True):
    """Tables of a run: two bodies of four-node elements, or of ten nodes, that meet in z = 0 are pressed together by
    their ends z = -1 and 1; last: node of the upper one, the slave; walls: x and y = 0 and 1 are planes that
    nothing leaves, else the ends are held and the sides free."""
    upper = set(range(1, last + 1))
    if ten:
        mesh = quadratic.ten_nodes(mesh)
        upper |= {n for n, pair in quadratic.ends(mesh).items() if upper.issuperset(pair)}
    codes = {}
    for n, x in enumerate(mesh.nodes, 1):
        end = int(abs(abs(x[2]) - 1) < 1e-9)
        code = tuple(int(min(abs(v), abs(1 - v)) < 1e-9) if walls else end for v in x[:2]) + (end,)
        if any(code):
            codes[n] = code
    joint_nodes = mesh.where(lambda x, y, z: abs(z) < 1e-9)
    side, *points = form.split()
    young, nu = bench.drawn[bench.case]['E'], bench.drawn[bench.case]['nu']
    return bench.run_text('boxes', (
        'MFEC * * Boxes\n\n' + meshing.solid(1, young, nu) + quadratic.records(mesh) +
        meshing.node_set('sole', [n for n in joint_nodes if n in upper]) +
        meshing.node_set('face', [n for n in joint_nodes if n not in upper]) +
        'SURFace under FROM sole\nSURFace track FROM face\n\n' + meshing.vectors('BOUNdary', codes) +
        meshing.vectors('DISPlacement', {n: (0.0, 0.0, -DEPTH) for n in mesh.where(lambda x, y, z: z > 1 - 1e-9)}) +
        f'CONTact\n  PAIR 1\n    {side} under track ' + ' '.join(points) + f'\n    {law}\n' +
        '\nOUTPut\n  FIELds stress\n\nEND\nBATCh\n  DT,,1\n  STEP,,1\nEND\nSTOP\n'))


def lateral_share(tables):
    """Lateral contact force over the normal one."""
    row = tables.contact('1')[-1]
    return math.hypot(row['F1'], row['F2'])/row['Fn']


def lateral(bench):
    """Lateral force from nothing: bodies pressed straight onto each other, with friction.

    Between walls nothing moves sideways. With free sides friction acts where the bodies spread, and cancels on
    meshes that mirror themselves in x and y as the bodies do.
    """
    joint(bench)
    law = f'PENAlty AUTO\n    FRICtion COULomb {bench.draw("mu", 0.1, 0.8)!r}'
    above, below = 2*bench.whole('half of the cells above', 1, 2), 2*bench.whole('half of the cells below', 2, 3)
    meshes = {}
    for name, walls in (('walls', True), ('free sides', False)):
        mesh = meshing.Mesh()
        for n, half, low in ((above, 0.5, 0), (below, 0.5 if walls else 1.0, -1)):
            mesh.box((n,)*3, lambda i, j, k, n=n, half=half, low=low: (
                0.5 + half*(2*i/n - 1), 0.5 + half*(2*j/n - 1), low + k/n), turned=(0, 0) if walls else (n//2, n//2))
        meshes[name] = mesh, walls
    for form in (SEGMENTED, MORTAR):
        for name, (mesh, walls) in meshes.items():
            for text, ten in (('', False), (', ten nodes', True)):
                tables = pressed(bench, mesh, (above + 1)**3, form, law, ten, walls)
                bench.compare(f'lateral force over Fn, {name}{text}', EXACT, 0.0, lateral_share(tables), 1e-9,
                              scale=1.0, form=form)
                if not walls and not tables.contact('1')[-1]['Ft'] > 1e-3*tables.contact('1')[-1]['Fn']:
                    raise ValueError('no friction that could fail to cancel')
