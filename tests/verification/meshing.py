"""Structured tetrahedral meshes of mapped boxes, written as numbered records."""
import math

CELL = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


class Mesh:
    """Nodes (x, y, z) and elements (material and four nodes), both numbered from 1."""

    def __init__(self):
        self.nodes, self.elements = [], []

    def box(self, counts, place, material=1, turned=(0, 0)):
        """Adds a box of cells cut as BLOCk TET4 cuts them; place(i, j, k) is where a node lies.

        turned: along x and y, how many of the first cells are cut as their mirror image, so that
        a mesh can have the symmetry of its body; or 'alternate': every second one, so that it has no
        direction of its own. Returns the function that numbers its nodes.
        """
        first = len(self.nodes) + 1
        nx, ny, nz = counts

        def number(i, j, k):
            return first + i + (nx + 1)*(j + (ny + 1)*k)

        for k in range(nz + 1):
            for j in range(ny + 1):
                self.nodes += [place(i, j, k) for i in range(nx + 1)]
        for k in range(nz):
            for j in range(ny):
                for i in range(nx):
                    flip = (i % 2 > 0, j % 2 > 0) if turned == 'alternate' else (
                        i < turned[0], j < turned[1])
                    corner = [number(i + abs(a - flip[0]), j + abs(b - flip[1]), k + c)
                              for a, b, c in CORNERS]
                    order = (0, 2, 1, 3) if flip[0] != flip[1] else (0, 1, 2, 3)
                    self.elements += [(material,) + tuple(corner[tet[m]] for m in order)
                                      for tet in CELL]
        return number

    def where(self, test):
        """Numbers of the nodes whose place passes a test."""
        return [n for n, x in enumerate(self.nodes, 1) if test(*x)]

    def volumes(self):
        """Volumes of the elements."""
        result = []
        for _, *corners in self.elements:
            a, b, c, d = (self.nodes[n - 1] for n in corners)
            u, v, w = ([p - q for p, q in zip(x, a)] for x in (b, c, d))
            result.append((u[0]*(v[1]*w[2] - v[2]*w[1]) + u[1]*(v[2]*w[0] - v[0]*w[2]) +
                           u[2]*(v[0]*w[1] - v[1]*w[0]))/6)
        return result

    def outer_facets(self, numbers):
        """Corners and areas of the exterior facets whose corners are all listed."""
        inside, count = set(numbers), {}
        for _, *e in self.elements:
            for facet in ((e[0], e[1], e[2]), (e[0], e[1], e[3]), (e[0], e[2], e[3]),
                          (e[1], e[2], e[3])):
                if inside.issuperset(facet):
                    key = tuple(sorted(facet))
                    count[key] = count.get(key, 0) + 1
        for facet in (key for key, often in count.items() if often == 1):
            a, b, c = (self.nodes[n - 1] for n in facet)
            u, v = ([p - q for p, q in zip(x, a)] for x in (b, c))
            yield facet, math.sqrt((u[1]*v[2] - u[2]*v[1])**2 + (u[2]*v[0] - u[0]*v[2])**2 +
                                   (u[0]*v[1] - u[1]*v[0])**2)/2

    def shares(self, numbers):
        """Thirds of the areas of the exterior facets around nodes whose corners are all listed."""
        result = dict.fromkeys(numbers, 0.0)
        for facet, area in self.outer_facets(numbers):
            for n in facet:
                result[n] += area/3
        return result

    def records(self):
        """COORdinates and ELEMents."""
        lines = ['COORdinates']
        lines += [f'  {n} 0 {x[0]:.15e} {x[1]:.15e} {x[2]:.15e}'
                  for n, x in enumerate(self.nodes, 1)]
        lines += ['', 'ELEMents']
        lines += [f'  {n} 0 {e[0]}  {e[1]} {e[2]} {e[3]} {e[4]}'
                  for n, e in enumerate(self.elements, 1)]
        return '\n'.join(lines) + '\n\n'


def vectors(command, values):
    """A data set of three numbers a node; values: {node: (v1, v2, v3)}."""
    lines = [command] + [f'  {n} 0 ' + ' '.join(f'{v:.15e}' if isinstance(v, float) else str(v)
                                                for v in values[n]) for n in sorted(values)]
    return '\n'.join(lines) + '\n\n'


def node_set(name, numbers):
    """A set of listed nodes."""
    lines = [f'SET {name}']
    for start in range(0, len(numbers), 10):
        lines += (['  OR'] if start else []) + [
            '  NODEs ' + ' '.join(str(n) for n in numbers[start:start + 10])]
    return '\n'.join(lines) + '\n\n'


def solid(number, young, nu):
    """A linear elastic material."""
    return f'MATErial {number}\n  SOLId LINEar\n  ELAStic ISOTropic {young!r} {nu!r}\n\n'
