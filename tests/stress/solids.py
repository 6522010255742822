"""Bodies meshed by gmsh: unstructured tetrahedra, and the triangles of each of their faces."""
import gmsh
import numpy as np


class Solid:
    """A meshed body: points (n, 3), tetrahedra and faces; node numbers count from 0.

    A face is (kind, outward normal or None, triangles); kind is gmsh's word: Plane, Cylinder, ...
    """

    def __init__(self, points, tetrahedra, faces):
        self.points, self.tetrahedra, self.faces = points, tetrahedra, faces

    def plane(self, *normal):
        """Triangles of the plane faces with this outward normal."""
        normal = np.array(normal, float)/np.linalg.norm(normal)
        found = [t for kind, n, t in self.faces if n is not None and n @ normal > 0.999]
        assert found, f'no face with normal {normal}'
        return np.vstack(found)

    def curved(self, inside=None):
        """Triangles of the faces that are not plane; inside: of the bore (or not) of a ring."""
        found = [t for kind, n, t in self.faces if n is None]
        if inside is not None:
            radii = [np.linalg.norm(self.points[t.ravel()][:, :2], axis=1).mean() for t in found]
            middle = (min(radii) + max(radii))/2
            found = [t for t, r in zip(found, radii) if (r < middle) == inside]
        return np.vstack(found)

    def volumes(self):
        """Volume of each tetrahedron."""
        a, b, c, d = (self.points[self.tetrahedra[:, k]] for k in range(4))
        return np.einsum('ij,ij->i', np.cross(b - a, c - a), d - a)/6.0

    def shares(self):
        """Share of the volume that belongs to each node."""
        volumes = self.volumes()
        shares = np.zeros(len(self.points))
        for k in range(4):
            np.add.at(shares, self.tetrahedra[:, k], volumes/4.0)
        return shares/volumes.sum()

    def area_shares(self, triangles):
        """Area of some triangles and the share of it that belongs to each node."""
        a, b, c = (self.points[triangles[:, k]] for k in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)/2.0
        shares = np.zeros(len(self.points))
        for k in range(3):
            np.add.at(shares, triangles[:, k], areas/3.0)
        return areas.sum(), shares/areas.sum()

    def centroid(self):
        """Centre of gravity of the mesh, as the nodal shares have it."""
        return self.shares() @ self.points

    def turned(self, matrix):
        """The same body, turned about the origin."""
        faces = [(kind, None if n is None else matrix @ n, t) for kind, n, t in self.faces]
        return Solid(self.points @ matrix.T, self.tetrahedra, faces)


def mesh(make, length, algorithm=6):
    """Meshes what make() builds with gmsh's OpenCASCADE kernel."""
    if not gmsh.isInitialized():
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber('General.Terminal', 0)
        gmsh.option.setNumber('General.NumThreads', 1)
    gmsh.clear()
    gmsh.option.setNumber('Mesh.MeshSizeMin', length)
    gmsh.option.setNumber('Mesh.MeshSizeMax', length)
    gmsh.option.setNumber('Mesh.Algorithm', algorithm)
    gmsh.model.add('body')
    make(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    tags, x, _ = gmsh.model.mesh.getNodes()
    _, corners = gmsh.model.mesh.getElementsByType(4)
    used = np.unique(corners)
    place = np.full(int(max(tags)) + 1, -1)
    place[used.astype(int)] = np.arange(len(used))
    order = np.full(int(max(tags)) + 1, 0)
    order[tags.astype(int)] = np.arange(len(tags))
    points = x.reshape(-1, 3)[order[used.astype(int)]]
    tetrahedra = place[corners.astype(int)].reshape(-1, 4)
    solid = Solid(points, tetrahedra, faces(place))
    negative = solid.volumes() < 0.0
    solid.tetrahedra[negative] = solid.tetrahedra[negative][:, [0, 2, 1, 3]]
    flatten(solid)
    return solid


def faces(place):
    """The faces of the model with their triangles."""
    found = []
    for dimension, tag in gmsh.model.getEntities(2):
        _, corners = gmsh.model.mesh.getElementsByType(2, tag)
        kind = gmsh.model.getType(dimension, tag)
        normal = None
        if kind == 'Plane':
            low, high = gmsh.model.getParametrizationBounds(2, tag)
            normal = np.array(gmsh.model.getNormal(tag, [(low[0] + high[0])/2, (low[1] + high[1])/2]))
        found.append((kind, normal, place[corners.astype(int)].reshape(-1, 3)))
    return found


def flatten(solid):
    """Turns the normals of plane faces outwards, and puts their nodes exactly on axis planes."""
    outward = []
    behind = {}
    for t in solid.tetrahedra:
        for k in range(4):
            behind[frozenset(np.delete(t, k).tolist())] = t[k]
    for kind, normal, triangles in solid.faces:
        if normal is not None:
            a = solid.points[triangles[0, 0]]
            inner = solid.points[behind[frozenset(triangles[0].tolist())]]
            normal = normal if normal @ (inner - a) < 0.0 else -normal
            axis = int(np.argmax(np.abs(normal)))
            if abs(normal[axis]) > 1.0 - 1e-12:
                nodes = np.unique(triangles)
                solid.points[nodes, axis] = solid.points[nodes[0], axis]
        outward.append((kind, normal, triangles))
    solid.faces = outward


def box(size, length, **more):
    """A box, its sole around the origin in z = 0."""
    a, b, c = size
    return mesh(lambda occ: occ.addBox(-a/2, -b/2, 0, a, b, c), length, **more)


def cylinder(radius, height, length, **more):
    """A cylinder that stands on z = 0 around the z axis."""
    return mesh(lambda occ: occ.addCylinder(0, 0, 0, 0, 0, height, radius), length, **more)


def ring(outer, inner, height, length, **more):
    """A ring that lies on z = 0 around the z axis."""
    def make(occ):
        occ.cut([(3, occ.addCylinder(0, 0, 0, 0, 0, height, outer))],
                [(3, occ.addCylinder(0, 0, 0, 0, 0, height, inner))])
    return mesh(make, length, **more)


def ball(radius, length, **more):
    """A ball around the origin."""
    return mesh(lambda occ: occ.addSphere(0, 0, 0, radius), length, **more)


def dome(radius, length, **more):
    """The lower half of a ball around the origin."""
    return mesh(lambda occ: occ.addSphere(0, 0, 0, radius, -1, -np.pi/2, 0.0), length, **more)


def bored_plate(size, radius, length, **more):
    """A plate around the z axis with a bore along it, its sole in z = 0."""
    a, b, c = size

    def make(occ):
        occ.cut([(3, occ.addBox(-a/2, -b/2, 0, a, b, c))],
                [(3, occ.addCylinder(0, 0, 0, 0, 0, c, radius))])
    return mesh(make, length, **more)


def prism(polygon, width, length, **more):
    """A polygon of the plane (x, z), drawn out along y from -width/2 to width/2."""
    def make(occ):
        points = [occ.addPoint(x, -width/2, z) for x, z in polygon]
        lines = [occ.addLine(p, q) for p, q in zip(points, points[1:] + points[:1])]
        occ.extrude([(2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))], 0, width, 0)
    return mesh(make, length, **more)
