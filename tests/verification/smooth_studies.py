"""Smooth masters: sliders on faceted cylinders and spheres, with and without SMOOth."""
import math

import meshing

EXACT = 'exact (smooth body)'


def polar(radius, angle, z):
    """A point of a cylinder about the z axis; angle 0 is up (y)."""
    return radius*math.sin(angle), radius*math.cos(angle), z


def table(number, points):
    """A proportional load."""
    return f'PROPortional {number}\n' + ''.join(f'  {t!r} {p!r}\n' for t, p in points) + '\n'


def pin(mesh, tip, up, material):
    """One tetrahedron that stands on its tip; its nodes, the tip first."""
    h = 0.2
    first = len(mesh.nodes) + 1
    a, b = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    if abs(up[2]) > 0.5:
        b = (0.0, 1.0, 0.0)
    back = -1.0 if up[1] > 0.5 else 1.0
    corners = [(0.0, 0.0), (1.0, -1.0*back), (1.0, 1.0*back), (-1.0, 0.0)]
    for k, (u, v) in enumerate(corners):
        rise = h if k else 0.0
        mesh.nodes.append(tuple(tip[m] + rise*up[m] + h*(u*a[m] + v*b[m]) for m in range(3)))
    mesh.elements.append((material, first, first + 1, first + 2, first + 3))
    if mesh.volumes()[-1] < 0.0:
        mesh.elements[-1] = (material, first, first + 2, first + 1, first + 3)
    return list(range(first, first + 4))


def slider_deck(mesh, sets, fixed, moved, points, friction, smooth, penalty=1000.0):
    """A body that is fixed, a pin that is carried along the way of `points`: (time, (ux, uy, uz))."""
    text = ('MFEC * * Slider on a faceted surface\n\n' + meshing.solid(1, 1e3, 0.3)
            + 'MATErial 2\n  RIGId\n\n' + mesh.records())
    text += ''.join(meshing.node_set(name, numbers) for name, numbers in sets.items())
    text += f'SURFace under FROM face\n\nBOUNdary\n  {fixed} 1 1 1\n  {moved} 1 1 1\n\n'
    text += f'DISPlacement\n  {moved} 1 1 1\n\nFPROportional\n  {moved} 1 2 3\n\n'
    for k in range(3):
        text += table(k + 1, [(t, u[k]) for t, u in points])
    text += (f'CONTact\n  PAIR 1 slider\n    NTOS tip under\n    PENAlty {penalty!r}\n    {friction}\n'
             + ('    SMOOth\n' if smooth else '') + f'\nOUTPut\n  REACtions {moved}\n'
             '  FIELds NONE\n  STATe NONE\n\nEND\nBATCh\n'
             f'  DT,,1\n  STEP,,{len(points) - 1}\nEND\nSTOP\n')
    return text


def turn(bench, smooth, inside=False, material=2, cells=12, count=300, degrees=10.0):
    """A pin goes around a drum (or a bore) of flat facets; rows of the contact table and the depth."""
    radius, depth = 1.0, 0.005
    sign = -1.0 if inside else 1.0
    step = math.radians(degrees)
    mesh = meshing.Mesh()

    def place(i, j, k):
        r = radius - sign*0.1*(1 - k)
        return polar(r, (i - cells/2)*step, 0.4*(j - 0.5))

    drum = mesh.box((cells, 1, 1), place if not inside else lambda i, j, k: place(cells - i, j, k),
                    material=material)
    face = [drum(i, j, 1) for i in range(cells + 1) for j in (0, 1)]
    back = [drum(i, j, 0) for i in range(cells + 1) for j in (0, 1)]
    start = -3.3*step
    x0 = polar(radius + sign*0.001, start, 0.03)
    up = (0.0, sign, 0.0)
    nodes = pin(mesh, x0, up, 2)
    points = [(0.0, (0.0, 0.0, 0.0))]
    for k in range(count + 1):
        y = polar(radius - sign*depth, start + 6.6*step*k/count, 0.03)
        points.append((float(k + 1), tuple(y[m] - x0[m] for m in range(3))))
    sets = {'tip': nodes[:1], 'pin': nodes, 'face': face, 'back': back if material == 1 else
            face + back}
    tables = bench.run_text('turn', slider_deck(mesh, sets, 'back', 'pin', points,
                                                'FRICtion COULomb 0.2', smooth))
    return tables.contact('slider'), 1000.0*depth


def ripple(rows, name='Fn'):
    """Range of a force over its mean, once the pin slides."""
    values = [row[name] for row in rows[len(rows)//10:]]
    return (max(values) - min(values))/(sum(values)/len(values))
