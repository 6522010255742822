"""Unstructured meshes of gmsh: bodies that do not know of each other's mesh."""
import math


class Body:
    """Nodes (x, y, z) and tetrahedra (four nodes, numbered from 1) of one body."""

    def __init__(self, nodes, elements):
        self.nodes, self.elements = nodes, elements


def meshed(build, size):
    """The body that `build` makes of a gmsh kernel (OpenCASCADE), with one size of element."""
    import gmsh
    gmsh.initialize(['-noenv'], interruptible=False)
    try:
        for name, value in (('General.Terminal', 0), ('General.NumThreads', 1), ('Mesh.Algorithm', 6),
                            ('Mesh.MeshSizeMin', size),
                            ('Mesh.MeshSizeMax', size), ('Mesh.MeshSizeFromCurvature', 0)):
            gmsh.option.setNumber(name, value)
        build(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        _, corners = gmsh.model.mesh.getElementsByType(4)
    finally:
        gmsh.finalize()
    place = {int(tag): tuple(float(x) for x in coordinates[3*k:3*k + 3]) for k, tag in enumerate(tags)}
    used = sorted({int(n) for n in corners})
    number = {n: k for k, n in enumerate(used, 1)}
    elements = [[number[int(n)] for n in corners[4*k:4*k + 4]] for k in range(len(corners)//4)]
    return Body([place[n] for n in used], elements)


def quarter_ring(inner, outer, thickness, size, finer=()):
    """A quarter of a ring about z, from z = 0 up; finer: a radius that keeps its size, and the size elsewhere."""
    def build(occ):
        whole = occ.addCylinder(0, 0, 0, 0, 0, thickness, outer, angle=math.pi/2)
        hole = occ.addCylinder(0, 0, 0, 0, 0, thickness, inner, angle=math.pi/2)
        occ.cut([(3, whole)], [(3, hole)])
        if finer:
            grade(occ, size, *finer)
    return meshed(build, size)


def grade(occ, size, radius, inside):
    """Elements of a size at a radius about z, of another half of the first one away from there."""
    import gmsh
    occ.synchronize()
    field = gmsh.model.mesh.field.add('MathEval')
    away = f'((Sqrt(x*x + y*y) - {radius!r})/{size/2!r})'
    gmsh.model.mesh.field.setString(field, 'F', f'{inside!r} + {size - inside!r}*Exp(0 - {away}*{away})')
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for name, value in (('SizeMin', 0), ('SizeMax', 1e22), ('SizeExtendFromBoundary', 0), ('SizeFromPoints', 0)):
        gmsh.option.setNumber('Mesh.Mesh' + name, value)


def coarsen(occ, size, away, growth):
    """Elements of a size that grow with a distance (an expression of x, y, z), where it is above zero."""
    import gmsh
    occ.synchronize()
    field = gmsh.model.mesh.field.add('MathEval')
    gmsh.model.mesh.field.setString(field, 'F', f'{size!r}+{growth/2!r}*({away}+Fabs({away}))')
    gmsh.model.mesh.field.setAsBackgroundMesh(field)
    for name, value in (('SizeMin', 0), ('SizeMax', 1e22), ('SizeExtendFromBoundary', 0), ('SizeFromPoints', 0)):
        gmsh.option.setNumber('Mesh.Mesh' + name, value)


def eighth_shell(inner, outer, size):
    """An eighth of a hollow sphere, x, y and z positive."""
    def build(occ):
        box = occ.addBox(0, 0, 0, outer, outer, outer)
        ball = occ.addSphere(0, 0, 0, outer)
        hole = occ.addSphere(0, 0, 0, inner)
        shell, _ = occ.cut([(3, ball)], [(3, hole)])
        occ.intersect(shell, [(3, box)])
    return meshed(build, size)


def box(corner, sides, size):
    """A box."""
    return meshed(lambda occ: occ.addBox(*corner, *sides), size)
