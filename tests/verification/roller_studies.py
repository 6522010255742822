"""A roller on a block in plane strain (NAFEMS): half of it, a slice one cell thick."""
import math

import meshing
from half_spaces import spacing, straight_line


def slices(radius, fine, cells, growth, layers):
    """Half of a roller's cap on half of a plate; sets of their faces."""
    across = spacing(fine, cells, growth, layers)
    depth = spacing(fine, cells//2, growth, layers + 1)
    mesh, parts = meshing.Mesh(), {}
    for name, sign in (('roller', 1), ('plate', -1)):
        levels = depth if sign > 0 else [-z for z in reversed(depth)]

        def place(i, j, k, levels=levels, sign=sign):
            x = across[i]
            rise = radius - math.sqrt(radius**2 - x*x) if sign > 0 else 0.0
            return x, j*fine, levels[k] + rise*(1 - abs(levels[k])/depth[-1])

        n, m = len(across) - 1, len(depth) - 1
        number = mesh.box((n, 1, m), place, 1 if sign > 0 else 2)
        near, far = (0, m) if sign > 0 else (m, 0)
        for part, level in ((name, near), (name + '_far', far)):
            parts[part] = [number(i, j, level) for i in range(n + 1) for j in (0, 1)]
    return mesh, parts


def roller_deck(mesh, parts, approach):
    """The deck: the roller comes down on the block without friction."""
    sets = ''.join(meshing.node_set(name, numbers) for name, numbers in parts.items())
    return ('MFEC * * Roller on a block\n\n' + meshing.solid(1, 210e3, 0.3) +
            meshing.solid(2, 70e3, 0.3) + mesh.records() + sets + f'''SURFace above FROM roller
SURFace below FROM plate

SET everything
  NODEs 1 TO {len(mesh.nodes)}

EBOUndary
  1 0  1 0 0

BOUNdary
  everything 0 1 0
  roller_far 0 0 1
  plate_far  0 0 1

DISPlacement
  roller_far 0 0 {-approach!r}

PROPortional 1
  0 0
  1 1

CONTact
  PAIR 1 roller
    NTOS above below
    PENAlty AREA 1e7

OUTPut
  REACtions roller_far
  FIELds contact

END
BATCh
  DT,,0.25
  STEP,,4
END
STOP
''')


def roller(bench):
    """Pressure and half-width against Hertz for the computed force, about 35 kN/mm."""
    radius, fine = 50.0, bench.draw('facet', 0.25, 0.31)
    mesh, parts = slices(radius, fine, round(7.3/fine), 1.25, 14)
    tables = bench.run_text('roller', roller_deck(mesh, parts, 1.105))
    force = 2*abs(tables.reactions('roller_far')[-1]['R3'])/fine
    stiff = 1/((1 - 0.3**2)*(1/210e3 + 1/70e3))
    p0, b = math.sqrt(force*stiff/(math.pi*radius)), math.sqrt(4*force*radius/(math.pi*stiff))
    shares, points = mesh.shares(parts['roller']), {}
    for n, f in tables.forces().items():
        x = mesh.nodes[n - 1][0]
        load, area = points.get(x, (0.0, 0.0))
        points[x] = load + f[2], area + shares[n]
    top, slope = straight_line([(x*x, (load/area)**2) for x, (load, area) in points.items()
                                if x < 0.8*b])
    ellipse = [k/100 for k in range(101)]
    bench.picture('hertz_roller', ('x/b', 'p/p0', 'Roller on a block (NAFEMS)'), [
        (bench.form, bench.mark(), [x/b for x in points if x < 2*b],
         [load/area/p0 for x, (load, area) in points.items() if x < 2*b]),
        ('Hertz', 'k-', ellipse, [math.sqrt(1 - x*x) for x in ellipse])])
    bench.compare('p0 of the computed force', 'exact (Hertz, NAFEMS)', p0, math.sqrt(top), 0.02)
    bench.compare('half-width b', 'exact (Hertz, NAFEMS)', b, math.sqrt(-top/slope), 0.02)
    worst = max(abs(load/area - p0*math.sqrt(1 - (x/b)**2)) for x, (load, area) in points.items()
                if x < 0.8*b)
    bench.compare('pressure, worst node inside 0.8 b', 'exact (Hertz, NAFEMS)', 0.0, worst/p0, 0.05,
                  scale=1.0)
    bench.remark(f'force {force:.0f} N/mm (NAFEMS: 35000); facets of {fine/b:.3f} b, '
                 f'{max(x for x, _, _ in mesh.nodes):.0f} mm of the roller to each side')
