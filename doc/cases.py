#!/usr/bin/env python3
"""The pages of the verification manual, one a case, from the texts below and doc/verification/table.md.

    doc/cases.py            names the pages that are not what texts and table say
    doc/cases.py --fix      writes them, and their plots
"""
import glob
import math
import os
import re
import sys
import textwrap

from renewed import is_old

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDER = os.path.join(TOP, 'doc', 'verification')
MOST_ROWS = 16
HERTZ = 'K. L. Johnson, *Contact Mechanics*, Cambridge 1985, 4.2'
JOHNSON7 = 'K. L. Johnson, *Contact Mechanics*, Cambridge 1985, 7.2 (Cattaneo 1938, Mindlin 1949)'
SPHERES = ('Boxes with a paraboloid of the sphere\'s curvature, flat beyond two radii of contact; the master\'s cells are '
           '1.1 to 1.35 times as large as the slave\'s, so the meshes do not match.')
KONTER = 'A. Konter, *Advanced Finite Element Contact Benchmarks*, NAFEMS R0094, 2006'
PLATE = 'Two rigid blocks of a few cells; the base is moved and turned by the seed.'
# Case: (problem, reference with its source, mesh, what is known about it).
TEXTS = {
    'bulk patch': ('A cube is given linear displacements on its boundary.', 'Exact: the same linear field inside.',
                   'Tetrahedra of four nodes whose inner nodes are jiggled.', ''),
    'wedge': ('A block is pushed up a rigid slope by a horizontal force F while its weight G hangs on it.',
              'NAFEMS CGS-4: $`F/G = (\\tan a + \\mu)/(1 - \\mu\\tan a)`$; at the slope 0.1 it is 0.1, 0.2020202, 0.3061224 and 0.4123711 '
              'for mu = 0, 0.1, 0.2, 0.3. Other slopes and coefficients are drawn.', 'A block on one rigid facet row.', ''),
    'dead loads': ('A block stands free on a rigid base under dead forces N down and T along, grown together.',
                   'Exact: it rests while mu is above T/N (Fn = N, Ft = T, no slip), and has no equilibrium below: exit code 2.',
                   'A block of a few cells, nodes anywhere on the base.', ''),
    'oblique pull': ('A body on a base with lay is pulled along x1 and free to drift along x2, with each of the three slip rules.',
                     'Exact: force and drift of the ellipse and its slip rule (theory, "Return map").', PLATE, ''),
    'drag': ('A rigid plate is dragged along x1 over a base whose lay is turned by phi, with each slip rule.',
             'Exact: force/N $`= \\mu_i^m v_i/\\sqrt{\\sum(\\mu_k^{m-1} v_k)^2}`$ along the axes of the lay; at 45° with 0.1 and 0.08 '
             'equation (6) of Krstulović-Opara and Wriggers.', PLATE, ''),
    'slope': ('Two blocks, one on the other, stand on a slope that is tilted from 0 to 1.2 atan(mu).',
              'Exact: Fn = W cos a and Ft = W sin a while they stand; they slide beyond atan(mu).', 'Blocks of a few cells.', ''),
    'Jenkins loop': ('A rigid plate is pressed by a given depth and moved to and fro.',
                     'Exact: elastic slip mu N/(penalty) and the area 4 mu N (a - elastic slip) of the loop (Jenkins element).', PLATE, ''),
    'tractrix': ('A plate is dragged along one direction, then along another.',
                 'Exact: the apex of the cone follows a tractrix, $`\\tan\\theta_{k+1} = \\sin\\theta_k/(\\cos\\theta_k + \\Delta s/l)`$.',
                 PLATE, ''),
    'circular path': ('A plate is led around a circle over a base with lay, with each slip rule.',
                      'Exact by quadrature: dissipation of a loop over N R; 0.5602412169, 0.5654866776, 0.5672333578 for 0.1 and 0.08.',
                      PLATE + ' A polygon of 180 chords.', ''),
    'SMOOth, drum': ('A pin goes around a drum, and around a bore, of flat facets, with and without `SMOOth`.',
                     'Exact for the smooth body: constant force. Without exact value: ripple at most a fifth of that on flat facets.',
                     'Facets of 7° to 12°.',
                     'Seed 5 has 1.05 on the elastic drum: it gives way more under the middle of a facet than under its edges, by as '
                     'much as the chordal deviation of facets of 7°.'),
    'shear-lag bar': ('A thin bar under uniform pressure on a rigid base is pulled at one end; friction takes the force up over a length.',
                      'Exact for a bar: $`u = F^2/(2EAq)`$ with q = mu p w.', 'A bar of some hundred cells in length, one in its section.', ''),
    'slip that spreads': ('Slip runs along a band that sticks all over at first.', 'Exact (capstan); no increment is cut.',
                          'A band on a drum of facets that are drawn, with `SMOOth`.', ''),
    'beside the axis': ('A plate is led around a circle beside the axis of a circumferential lay, so it crosses the lay at all angles.',
                        'Exact by quadrature.', PLATE, ''),
    'disc that turns': ('A disc turns under a plate; its lay is carried along.', 'Exact: forces turn with the disc.', PLATE, ''),
    'contact patch': ('Two blocks are pressed together between smooth walls, flat and on an inclined joint, sticking.',
                      'Exact: uniform stress.', 'Equal meshes on both sides, and 2 on 1.', ''),
    'lateral friction': ('Two blocks are pressed straight onto each other, with friction.', 'Exact: no lateral force, by symmetry.',
                         'Blocks of cells that do not match, of four and of ten nodes, between walls and with free sides; the latter '
                         'mirror themselves in x and y.', ''),
    'oblique landing': ('A block comes down obliquely, touches in the middle of an increment, and slides or sticks.',
                        'The run with an increment that ends at the touch.', 'A block of two cells on a rigid and on an elastic base.',
                        'While all points stick the friction ratio is a ratio of two stiffnesses, no number of the law. The number of '
                        'increments (1 to 22) makes no difference to 1.2e-8.'),
    'AUGMent, patch': ('The patch test with penalties from 0.1 to 1e4 E/h.', 'Exact: uniform stress.', 'As *contact patch*.', ''),
    'AUGMent, slide': ('Press, slide, lift, return and press with penalties from 0.1 to 1e4 E/h.',
                       'Exact: Ft = mu Fn, and the same rows for every penalty.', 'As `inputs/press_slide_lift_return.inp`.', ''),
    'AUGMent, stuck': ('The block of *dead loads* with multipliers.', 'Exact: it rests where it is.', 'As *dead loads*.', ''),
    'AUGMent, edge': ('A tip slides over a kinked edge; penalties of a node from 10 to 1e7.', 'Exact: Ft = mu Fn on both facets.',
                      'Two facets.', ''),
    'drag, elastic': ('An elastic cube is dragged over a rigid base, its points cross edges all the way.', 'As *drag*.', 'Cubes of 4 cells.',
                      'Where a facet of the sole has lifted in part, the cells of `SEGMent` wander over the kink of its pressure, and up '
                      'to 2e-5 of the force is left; where all is closed it is 1e-11.'),
    'SMOOth, shaft': ('A faceted shaft grows in an elastic ring and turns.', 'Exact for smooth bodies: uniform pressure, torque mu Fn R.',
                      'Some 30 facets to the circle.', ''),
    'SMOOth, ball': ('A faceted ball grows into a spherical cap and turns.', 'Exact for smooth bodies.', 'Facets of 8 to 12 a quarter.',
                     'Two of ten seeds hold 0.1 % for the moment: the patches of a doubly curved surface are off the sphere by some '
                     'hundredths of the depth, and the pressure with them.'),
    'Hertz roller': ('A steel roller (R 50 mm) on an aluminium block under 35 kN/mm, plane strain.',
                     KONTER + ', no. 1: Hertz, p0 and half-width of the computed force.', 'A slice one cell thick, facets of 0.25 to 0.31 mm.',
                     ''),
    'Hertz spheres': ('Two equal spheres are pressed together; the far faces move as half-spaces under the force do.', HERTZ + '.',
                      SPHERES + ' A quarter; four nodes.',
                      'CalculiX 2.20 (node to surface, its own mesh) has 8, 2.5 and 0.2 % for the force with facets of 0.3, 0.15, 0.075 a. '
                      'The worst node of `NTOS` is at the pole, 25 % off on all meshes: a node gives its force to one facet.'),
    'Hertz, ten nodes': ('The same with elements of ten nodes.', HERTZ + ', with the correction of a/R for finite spheres '
                         '(`tests/verification/axisymmetric.py hertz`).', SPHERES + ' Facets of 0.3 a.',
                         'Hertz takes the bodies as half-spaces and is off by a part of a/R that depends on Poisson\'s ratio (-0.294 a/R of '
                         'the force at 0). Corners are held against the projection of the pressure on linear functions.'),
    'Hertz, pointwise': ('The same, both bodies meshed without structure: pressures at single nodes.', HERTZ + '.',
                         'Quarters of the half-spaces, meshed by Gmsh; 3, 6 and 12 facets in a.',
                         'The pressure of a node is that of the file of the contact surfaces. Inside 0.8 a it is held against Hertz at the '
                         'node, anywhere against his mean around it, which at the rim is itself 12 % of p0 off his pressure there.'),
    'Cattaneo-Mindlin': ('Two spheres are pressed and pushed sideways by a growing force.', JOHNSON7 + ' (spheres: 7.2).',
                         SPHERES + ' Half, outer faces rigid at 60 radii of contact; mirrored in x = 0.',
                         'c is the radius of the half-ellipsoid mu p - q, from its second moment. With Q = 0.9 mu F it is 1.7 and 4 '
                         'facets, and its error 0.08 and 0.15 of one.'),
    'line, partial slip': ('Two equal cylinders in plane strain are pressed, then pushed to Q/(mu P) = 0.8, -0.5 and 0.8.',
                           JOHNSON7 + '; Masing for the reversal.',
                           'A slice, 24 half-widths wide; far faces move as half-planes under the line forces. 6, 12 and 24 facets in a.',
                           'Integrals of traction and dissipated energy times hat functions of the slave\'s corners are compared. Ten nodes '
                           'have the shear within 2.4 % and the energy within 4.1 % with 12 facets in a; four nodes 10 to 14 % and 8 to '
                           '17 % with 24.'),
    'flat punch': ('A rigid flat punch on a half-plane, bonded, and sliding.',
                   'Exact: Abramov (bonded), Bufler (sliding; Johnson 2.5).',
                   'A slice; the sole is the slave, its facets 1.1 to 1.6 times those of the plane, 6 to 24 in a.',
                   'The traction is singular at both edges. In the whole norm the hats at the edge carry the error, and no order above 0.5 can '
                   'be had. *Inside 0.9 a* takes the hats that lie there: 2.6 % (four nodes, 24 facets) and 0.8 % (ten nodes, 12).'),
    'rounded punch': ('A steel punch, D 100, H 100, its edge rounded by 10, is pressed by 100 MPa on an aluminium cylinder, D 200, H 200, '
                      'without friction and with 0.1.',
                      KONTER + ', no. 2. Its curves are printed without numbers, so the reference is Code_Aster (V6.01.122): -0.13290 mm for the '
                      'centre with eight-node rings, -0.13073 and with friction -0.12858 with four-node rings.',
                      'A quarter, meshed by gmsh, ten nodes, curved: cells of 8, 5 and 3 mm at the edge of the contact.',
                      'The ratio of both displacements is compared with that of the coarser run.'),
    'loaded pin': ('A steel pin, R 50, in the bore of an aluminium sheet, 200 wide, its free end rounded by 100, held 200 away, is '
                   'pulled along the sheet by 20 kN for each mm of thickness; friction 0.1, plane strain.',
                   KONTER + ', no. 4, whose curves (pressure, shear and slip over the angle) are printed without numbers. The '
                   'reference is model B of Code_Aster (V6.03.156; test `ssnp156b`): the bore under the load moves by 0.73617 mm, its '
                   'stress along the load is -160.40 MPa. Model A, with contact at nodes, has 0.71799 mm and -136.67 MPa.',
                   'A slice of half the problem as thick as a cell, gmsh, ten nodes, curved: cells of 12, 8 and 5 mm at the bore. '
                   'Saint Venant-Kirchhoff, as there.',
                   'The sheet of 3-D models (OptiStruct OS-V:0230: 10 mm thick, 100 kN) is shown by curves alone.'),
    'turntable': ('A slider on a rigid arm, which turns freely about a fixed point, is towed over a table whose friction is elliptical '
                  '(0.3, 0.15) with the associated slip rule; the table turns once, its lay with it.',
                  'Exact: friction lies along the arm and slip follows from it, an ordinary differential equation, by Runge-Kutta. The '
                  'set-up is that of F. Tapia, D. Le Tourneau and J.-C. Géminard, *EPJ Techniques and Instrumentation* 3 (2016), 1, '
                  'arms over distance 0.65 as there; they measured that the force across the path is the derivative of the force '
                  'along it by the direction of sliding, which is the associated rule. Their coefficients stand in figures alone.',
                  'A slider of four nodes, 0.008 wide, on a rigid table; 90, 360 and 1,440 increments a turn.',
                  'The friction direction of an increment is that of its chord, so the error is of first order.'),
    'other answers': ('One node under a load for which equilibrium has three answers: open, stuck and slipping.',
                      'A. Klarbring, *Ingenieur-Archiv* 60 (1990): closed forms from the compliance of the node.',
                      'One tetrahedron with one free node.', ''),
    'cone': ('A cone is pressed on a half-space of the same material.', 'Sneddon 1965: force and radius of contact.', SPHERES, ''),
    'Mindlin, elliptical law': ('As *Cattaneo-Mindlin* with an elliptical law, pushed aslant of the lay; nu = 0.',
                                JOHNSON7 + ', with the coefficient of equation (6) of Krstulović-Opara and Wriggers.', SPHERES,
                                'The rim of the contact lies between nodes.'),
    'rolling': ('A cylinder rolls with a tractive force on a half-plane of the same material.',
                'Carter 1926; Johnson 8.3.', 'A slice, far faces at 30 half-widths; 6 half-widths rolled, one facet an increment.',
                'Ten nodes have q(x) within 1.5 %, four nodes 19 to 25 % in the mean square. A width is counted in facets.'),
    'Lubkin': ('A sphere is pressed on another and twisted.', 'J. L. Lubkin, J. Appl. Mech. 18 (1951): moment over twist.',
               SPHERES + ' Whole, rigid at 8 radii of contact.', 'At a small twist the ring that slips is thinner than a facet.'),
    'frictional indentation': ('A frictional press on an elastic block in 4, 16 and 64 increments.',
                               'Axisymmetric program of the tests (`axisymmetric.py`, event-driven), after Spence 1968.',
                               'Ten nodes for facets; twice as fine ones of four for `NTOS` and `SMOOth`.',
                               'For mu = 0.3 friction is 0.0850 in the limit of the reference\'s cells, and the radial sum 0.0858.'),
    'AUGMent, sphere': ('A sphere is pressed on an elastic plate and dragged; penalties from 0.1 to 1e4 E/h.',
                        'Exact: nothing penetrates, and the same rows for every penalty.', 'Four nodes.',
                        'A point on a kinked edge may be held by either facet: seed 8 has 7e-4 in one increment.'),
    'AUGMent, penalty': ('Sliding cube, Hertz roller and sphere with penalties from 0.1 to 1e4 E/h.', 'Exact: the same forces.',
                         'As in their cases.', ''),
    'concentric rings': ('A ring is pressed into another by its bore, plane strain.', 'Lamé, two materials.',
                         'gmsh without structure on both sides, facets of 0.066 at the interface.',
                         'The two polygons do not fit: flat facets are off by 0.7 to 1 %, with `SMOOth` by 0.16 %. The same tetrahedra '
                         'without contact are off by 0.15 %.'),
    'rings, finer inside': ('As *concentric rings*, with tetrahedra half as large behind the interface.', 'Lamé.',
                            'Facets of 0.066 at the interface.', 'The force is off by 0.08 %, which is that of the tetrahedra.'),
    'rings, ten nodes': ('As *concentric rings* with ten nodes, curved.', 'Lamé.', 'Facets of 0.066.', ''),
    'concentric spheres': ('An eighth of two hollow spheres.', 'Lamé.', 'gmsh, facets of 0.11.', 'As *concentric rings*.'),
    'cantilever': ('Pure bending of a cantilever.', 'Theory: rate of linear elements.', '4, 8 and 16 cells in the height.', ''),
    'ten nodes, rates': ('A cube in the field of a point source outside of it.', 'Theory: orders 3 and 2.', '4 and 6 cells, ten nodes.', ''),
    "Cook's membrane": ('Cook\'s membrane in plane strain, linear and neo-Hooke, up to nu = 0.4999.',
                        'A second program (numpy, converged), and theory.', 'A slab one cell thick, ten nodes.', ''),
    'sphere blown up': ('A thick sphere of rubber under a pressure that follows.', 'Exact: radial equation of neo-Hooke.', 'Ten nodes.', ''),
    'ball over rubber': ('A rigid ball is pressed into rubber by 30 % of its radius and dragged.',
                         'Balance of energy: the work of the loads is found in strain, penalty and friction.', 'Ten nodes.', ''),
    'patch, no match': ('The patch test on meshes that do not match, 2 on 3 to 7 on 5 cells, flat, inclined, sheared, sticking.',
                        'Exact: uniform stress.', 'Blocks of four and of ten nodes.',
                        '`NTOS` gives the force of a node to one facet and is off by 2 to 17 %. The rule of three points grows with Poisson\'s '
                        'ratio: 2.3e-2 at 0.24 and 3.3e-2 at 0.42; 12 points have 3.4e-3, `SEGMent` 1e-8.'),
    'patch, gmsh': ('Two boxes of gmsh are pressed together between smooth walls.', 'Exact: uniform stress.', 'No structure on both sides.', ''),
    'band on cylinder': ('A thin elastic band around half of a drum is pulled at both ends.',
                         'Capstan: $`T_2/T_1 = e^{\\mu\\pi}`$, and for the elliptical law with the coefficient along the band.',
                         'Matching facets, and drawn ones (80 to 120).',
                         'On flat facets that do not match, the normal is off by up to half a kink and T2/T1 by $`\\pi\\cdot\\pi(1+\\mu^2)/2n`$, '
                         '5.4 % with 100 facets. `SMOOth` has 0.3 to 0.8 %.'),
    'turned disc': ('A pin goes once around the axis of a circumferential lay, on a rigid and on an elastic disc.',
                    'Exact: the coefficient along the lay.', 'Discs of a few facets.', ''),
    'Raous plate': ('Half of a square plate, 40 mm, is pressed on a rigid plane and pushed along it: slip, stick, and lift-off.',
                    'Raous, Chabrand and Lebon 1988; Code_Aster V6.04.128 (SSNV128): u1 = 2.86, 2.72, 2.28, 1.98, 1.50e-5 m, wanted to 5 % '
                    'as there.', 'A slice, 32 cells, plane strain.', ''),
    'Raous plate, fine': ('The same.', 'As *Raous plate*.', '64 cells.', ''),
}


def slug(case):
    """The name of the page of a case."""
    return re.sub(r'[^a-z0-9]+', '-', case.lower()).strip('-')


def sketch_of(case):
    """The file of the sketch of a case."""
    return 'sketch_' + slug(case).replace('-', '_') + '.svg'


def cells(line):
    """The cells of a row of a table."""
    return [cell.strip() for cell in line.strip().strip('|').split(' | ')]


def read_table():
    """Rows and causes of table.md, by case."""
    with open(os.path.join(FOLDER, 'table.md'), encoding='utf-8') as stream:
        text = stream.read()
    rows, causes = {}, {}
    for line in text[:text.index('## Numbers drawn')].split('\n'):
        found = cells(line)
        if len(found) == 10 and found[0] not in ('case', '---'):
            rows.setdefault(found[0], []).append(found)
    if '## Not reached' in text:
        part = text[text.index('## Not reached'):text.index('## Numbers drawn')]
        for line in part.split('\n'):
            found = cells(line)
            if len(found) == 3 and found[0] in rows:
                causes.setdefault(found[0], []).append(found[1:])
    return rows, causes


def series_of(quantity):
    """A quantity without its mesh, and the size of a cell there; None where it names no mesh."""
    for pattern, size in ((r', facet ([\d.]+) a', lambda v: v), (r', (\d+) facets in a', lambda v: 1/v),
                          (r', cells of ([\d.]+) mm', lambda v: v), (r', (\d+) increments a turn', lambda v: 1/v), (r', (\d+) cells$', lambda v: 1/v)):
        found = re.search(pattern, quantity)
        if found:
            return re.sub(r' \([\d.]+\)$', '', quantity.replace(found.group(0), '')), size(float(found.group(1)))
    return quantity, None


def curves(rows):
    """Errors over sizes of what was computed on several meshes: {(form, quantity): [(size, error)]}."""
    found = {}
    for row in rows:
        quantity, size = series_of(row[2])
        if size and float(row[6]) > 0:
            found.setdefault((row[1], quantity), []).append((size, float(row[6])))
    return {name: sorted(points) for name, points in found.items() if len({s for s, _ in points}) > 1}


def order(points):
    """The order from the coarsest to the finest mesh."""
    (fine, small), (coarse, large) = points[0], points[-1]
    return math.log(large/small)/math.log(coarse/fine)


def plot(case, rows, path):
    """Errors over sizes where there are several, else over what is wanted."""
    import matplotlib
    matplotlib.use('Agg')
    import matplotlib.pyplot as plt
    plt.rcParams.update({'svg.fonttype': 'none', 'svg.hashsalt': 'mfec', 'font.size': 9})
    lines = curves(rows)
    labels = [textwrap.fill(f'{form}: {quantity}', 48) for form, quantity in lines]
    deep = 0.17*((len(lines) + 1)//2) + 0.06*sum('\n' in label for label in labels)
    figure, axes = plt.subplots(figsize=(6.5, 3.4 + deep if lines else 3.2), layout='constrained')
    if lines:
        for k, points in enumerate(lines.values()):
            axes.loglog(*zip(*points), 'os^vD'[k % 5] + ('-', '--', ':')[k//10 % 3], ms=4, lw=1, label=labels[k])
        axes.set(xlabel='size of a facet or increment', ylabel='relative error')
        figure.legend(fontsize=7, loc='outside lower center', ncol=2)
    else:
        forms = list(dict.fromkeys(row[1] for row in rows))
        for row in rows:
            wanted = float(row[7])
            share = max(float(row[6]), 1e-16)/(wanted if wanted > 0 else 1e-12)
            axes.semilogx(share, forms.index(row[1]), 'o' if row[8] == 'holds' else 'x', ms=5,
                          color='#0072b2' if row[8] == 'holds' else '#d55e00')
        axes.axvline(1, color='0.5', lw=1)
        axes.set(yticks=range(len(forms)), yticklabels=forms, xlabel='error over what is wanted', ylim=(-0.6, len(forms) - 0.4))
    axes.set_title(case)
    axes.grid(alpha=0.3)
    figure.savefig(path, metadata={'Date': None})
    plt.close(figure)


def rows_shown(rows):
    """All rows, or of each form and verdict the one with the largest error over what is wanted."""
    if len(rows) <= MOST_ROWS:
        return rows, ''
    worst = {}
    for row in rows:
        key = (row[1], series_of(row[2])[1] is not None and series_of(row[2])[0], row[8])
        if key not in worst or float(row[6])*float(worst[key][7] or 1) > float(worst[key][6])*float(row[7] or 1):
            worst[key] = row
    shown = list(worst.values())
    return shown, f'The worst of each kind; all {len(rows)} rows are in the [table](table.md).'


def page(case, rows, causes):
    """The page of a case."""
    problem, reference, mesh, known = TEXTS[case]
    shown, note = rows_shown(rows)
    held = sum(row[8] == 'holds' for row in rows)
    sketch = sketch_of(case)
    drawn = [f'![Sketch of {case}]({sketch})', ''] if os.path.exists(os.path.join(FOLDER, sketch)) else []
    lines = [f'# {case[0].upper() + case[1:]}', '', f'**Problem.** {problem}', '', *drawn, f'**Reference.** {reference}', '',
             f'**Mesh.** {mesh}', '', f'**Result.** {held} of {len(rows)} rows hold. {note}'.rstrip(), '',
             f'![Errors of {case}]({slug(case)}.svg)', '']
    for name in PICTURES.get(case, ()):
        if os.path.exists(os.path.join(FOLDER, name + '.svg')):
            lines += [f'![{case}]({name}.svg)', '']
    lines += ['| form | quantity | reference | reached | error | wanted | verdict |', '|---|---|---|---|---|---|---|']
    lines += ['| ' + ' | '.join((r[1], r[2], r[3], r[5], r[6], r[7], r[8])) + ' |' for r in shown] + ['']
    orders = [f'| {form} | {quantity} | {order(points):.1f} |' for (form, quantity), points in curves(rows).items()]
    if orders:
        lines += ['Order from the coarsest to the finest mesh:', '', '| form | quantity | order |', '|---|---|---|'] + orders + ['']
    if known:
        lines += [f'**Known.** {known}', '']
    if causes:
        lines += ['| not reached | cause |', '|---|---|'] + [f'| {what} | {why} |' for what, why in causes] + ['']
    lines += [f'**Command.** `tests/verification/run {quoted(case)}`']
    return '\n'.join(lines) + '\n'


def quoted(case):
    """A name as one word of a command line."""
    return '"' + case + '"' if "'" in case else f"'{case}'" if ' ' in case else case


PICTURES = {'wedge': ['wedge_forces'], 'shear-lag bar': ['shear_lag_bar'], 'Hertz roller': ['hertz_roller'],
            'Hertz spheres': ['hertz_convergence', 'hertz_pressure'], 'Hertz, pointwise': ['hertz_pointwise'], 'band on cylinder': ['band_on_cylinder'], 'Raous plate': ['raous_plate'],
            'Lubkin': ['lubkin_moment'], 'Cattaneo-Mindlin': ['mindlin_convergence', 'mindlin_force'], 'patch, no match': ['patch'],
            'ten nodes, rates': ['ten_nodes'], 'rolling': ['rolling_traction'], 'rounded punch': ['nafems_punch'], 'loaded pin': ['nafems_pin'],
            'turntable': ['turntable_arm']}
"""Curves that a study draws, beside the errors of the table."""


def old_pages(fix=False):
    """Names of pages that are not what texts and table say, and of sketches that are not there; writes the pages
    with fix."""
    rows, causes = read_table()
    wrong = sorted(set(rows) - set(TEXTS))
    pages = {slug(case) + '.md': page(case, mine, causes.get(case, ()))
             for case, mine in rows.items() if case in TEXTS}
    for name, text in pages.items():
        if is_old(os.path.join(FOLDER, name), text, fix):
            wrong.append(name)
    if fix:
        for case, mine in rows.items():
            plot(case, mine, os.path.join(FOLDER, slug(case) + '.svg'))
    wrong += [sketch_of(case) for case in rows if not os.path.exists(os.path.join(FOLDER, sketch_of(case)))]
    kept = {os.path.basename(path) for path in glob.glob(os.path.join(FOLDER, '*.md'))}
    return wrong + sorted(kept - set(pages) - {'table.md'})


def main():
    """Exit code 1 if a page is old."""
    wrong = old_pages('--fix' in sys.argv[1:])
    for name in wrong:
        print(f'doc/verification: {name} is not what table.md and doc/cases.py say: doc/cases.py --fix')
    return 1 if wrong and '--fix' not in sys.argv[1:] else 0


if __name__ == '__main__':
    sys.exit(main())
