"""Meshes of mapped boxes, cut into tetrahedra; both programs read the same file (Abaqus format)."""
import numpy as np

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
# As BLOCk TET4 cuts a cell; the faces C3D4 calls S1 (nodes 1 2 3) and S3 (nodes 2 4 3).
CELL = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
LOWER, UPPER = ((0, 1), 'S1'), ((3, 4), 'S3')
# The same towards lower and higher x and y.
SIDES = {(1, -1): ((2, 3), 'S1'), (1, 1): ((0, 5), 'S3'), (2, -1): ((4, 5), 'S1'),
         (2, 1): ((1, 2), 'S3'), (3, -1): LOWER, (3, 1): UPPER}
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))  # of C3D10, in its order


class Box:
    """One box of a mesh: node numbers (nx+1, ny+1, nz+1) and element numbers (cells, 6)."""

    def __init__(self, counts, first_node, first_element):
        nx, ny, nz = counts
        self.nodes = first_node + np.arange((nx + 1)*(ny + 1)*(nz + 1)).reshape(
            (nx + 1, ny + 1, nz + 1), order='F')
        self.elements = first_element + np.arange(6*nx*ny*nz).reshape((nz, ny, nx, 6))

    def face(self, side, axis=3):
        """Elements of the tetrahedra at the lower (-1) or upper (1) end of an axis, and the name of
        their face."""
        which, face = SIDES[axis, side]
        layer = np.take(self.elements, 0 if side < 0 else -1, axis=3 - axis)
        return layer[:, :, which].ravel(), face


class Mesh:
    """Nodes (n, 3), tetrahedra (m, 4), and named groups; everything numbered from 1."""

    def __init__(self):
        self.nodes, self.elements = np.zeros((0, 3)), np.zeros((0, 4), dtype=int)
        self.node_sets, self.regions, self.surfaces = {}, {}, {}

    def box(self, name, x, y, z, place=None):
        """Adds a box with these coordinates of its planes; place maps (n, 3) points. Its name
        becomes a region."""
        counts = len(x) - 1, len(y) - 1, len(z) - 1
        grid = np.stack(np.meshgrid(x, y, z, indexing='ij'), axis=-1)
        points = np.stack([grid[..., i].ravel(order='F') for i in range(3)], axis=1)
        made = Box(counts, len(self.nodes) + 1, len(self.elements) + 1)
        corner = [made.nodes[a:a + counts[0], b:b + counts[1], c:c + counts[2]].ravel(order='F')
                  for a, b, c in CORNERS]
        tets = np.stack([np.stack([corner[m] for m in tet], axis=1) for tet in CELL], axis=1)
        self.nodes = np.vstack([self.nodes, points if place is None else place(points)])
        self.elements = np.vstack([self.elements, tets.reshape(-1, 4)])
        self.regions[name] = (int(made.elements.min()), int(made.elements.max()))
        return made

    def add_middles(self, flat, place):
        """Ten nodes an element: place maps the middles of edges between places (n, 3) of the corners;
        where `flat` has these before they were mapped. Node sets take the middles whose ends they have.
        Returns where the middles were before."""
        ends = np.sort(self.elements[:, EDGES], axis=2)
        pairs, at = np.unique(ends.reshape(-1, 2), axis=0, return_inverse=True)
        first = len(self.nodes) + 1
        middles = (flat[pairs[:, 0] - 1] + flat[pairs[:, 1] - 1])/2
        self.nodes = np.vstack([self.nodes, place(middles, pairs)])
        self.elements = np.hstack([self.elements, first + at.reshape(-1, 6)])
        for name, numbers in self.node_sets.items():
            inside = np.isin(pairs, numbers).all(axis=1)
            self.node_sets[name] = np.concatenate([numbers, first + np.flatnonzero(inside)])
        return middles

    def volumes(self):
        """Volumes of the tetrahedra (m)."""
        a, b, c, d = (self.nodes[self.elements[:, i] - 1] for i in range(4))
        return np.einsum('ij,ij->i', np.cross(b - a, c - a), d - a)/6

    def facets(self, name):
        """Corner nodes of a surface (facets, 3)."""
        elements, face = self.surfaces[name]
        corners = (0, 1, 2) if face == 'S1' else (1, 3, 2)
        return self.elements[elements - 1][:, corners]

    def shares(self, name):
        """A third of the facets around each node of a surface: {node: area}."""
        facets = self.facets(name)
        a, b, c = (self.nodes[facets[:, i] - 1] for i in range(3))
        areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)/6
        numbers = np.unique(facets)
        total = np.bincount(facets.ravel(), np.repeat(areas, 3))
        return {int(n): float(total[n]) for n in numbers}

    def write(self, path):
        """The mesh as *NODE, *ELEMENT, *NSET, *ELSET and *SURFACE."""
        with open(path, 'w', encoding='ascii') as stream:
            stream.write('*NODE, NSET=all_nodes\n')
            stream.writelines(f'{n}, {x:.15g}, {y:.15g}, {z:.15g}\n'
                              for n, (x, y, z) in enumerate(self.nodes.tolist(), 1))
            stream.write(f'*ELEMENT, TYPE=C3D{self.elements.shape[1]}\n')
            stream.writelines(', '.join(map(str, [n] + nodes)) + '\n'
                              for n, nodes in enumerate(self.elements.tolist(), 1))
            for name, (first, last) in self.regions.items():
                stream.write(f'*ELSET, ELSET={name}, GENERATE\n{first}, {last}, 1\n')
            for name, numbers in self.node_sets.items():
                stream.write(f'*NSET, NSET={name}\n' + records(numbers))
            for name, (elements, face) in self.surfaces.items():
                stream.write(f'*SURFACE, NAME={name}, TYPE=ELEMENT\n')
                stream.writelines(f'{e}, {face}\n' for e in elements.tolist())


def records(numbers):
    """Numbers as records of at most 16."""
    numbers = [int(n) for n in np.ravel(numbers)]
    return ''.join(', '.join(map(str, numbers[i:i + 16])) + '\n'
                   for i in range(0, len(numbers), 16))
