"""Outer facets of bodies, curved facets, and where one looks from."""
from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# Corners of the faces of a tetrahedron; each face is turned outwards by its opposite corner.
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
EDGES = np.array([[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])
"""Corners of the edges of a tetrahedron in the order of its mid nodes, those of a facet first."""
LEVEL = 4
"""A curved facet is drawn as LEVEL**2 triangles."""
View = tuple[NDArray, NDArray, NDArray]
"""Unit vectors to the right, up, and towards the viewer."""

def exterior_facets(cells: NDArray, x: NDArray) -> tuple[NDArray, NDArray]:
    """Facets that belong to one cell only, counter-clockwise seen from outside, and their cells."""
    faces = cells[:, FACES].reshape(-1, 3)
    owner = np.repeat(np.arange(len(cells)), 4)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True,
                                return_counts=True)
    outer = first[count == 1]
    faces, owner = faces[outer], owner[outer]
    normal = np.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    inward = np.einsum('ij,ij->i', normal, x[cells[owner]].mean(axis=1) - x[faces[:, 0]]) > 0
    faces[inward] = faces[inward][:, ::-1]
    return faces, owner


def mid_nodes(facets: NDArray, cells: NDArray) -> NDArray:
    """The mid nodes of the edges of facets, -1 where an edge is straight; cells (m, 10) are the
    ten-node tetrahedra of the mesh."""
    found = np.full((len(facets), 3), -1)
    if len(cells) == 0 or len(facets) == 0:
        return found
    count = int(max(cells.max(), facets.max())) + 1
    ends = np.sort(cells[:, EDGES], axis=2).reshape(-1, 2)
    keys, first = np.unique(ends[:, 0] * count + ends[:, 1], return_index=True)
    mids = cells[:, 4:10].ravel()[first]
    ends = np.sort(facets[:, EDGES[:3]], axis=2)
    wanted = ends[..., 0] * count + ends[..., 1]
    at = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[at] == wanted, mids[at], -1)


def lattice() -> tuple[NDArray, NDArray]:
    """The shape functions of a six-node facet at the points that it is drawn with (points, 6), and the
    triangles between these."""
    steps = [(i, j) for i in range(LEVEL + 1) for j in range(LEVEL + 1 - i)]
    at = {step: k for k, step in enumerate(steps)}
    triangles = []
    for i, j in steps:
        if i + j < LEVEL:
            triangles.append([at[i, j], at[i + 1, j], at[i, j + 1]])
        if i + j < LEVEL - 1:
            triangles.append([at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]])
    b, c = np.array(steps).T / LEVEL
    a = 1.0 - b - c
    shapes = [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a]
    return np.stack(shapes, axis=1), np.array(triangles)


def refined(values: NDArray, facets: NDArray, mids: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Values of nodes, places or a field, with those of the points that curved facets are drawn with
    behind them; the triangles; and the facet of each triangle."""
    curved = np.flatnonzero(np.all(mids >= 0, axis=1)) if len(mids) else np.zeros(0, dtype=int)
    straight = np.setdiff1d(np.arange(len(facets)), curved)
    if len(curved) == 0:
        return values, facets, straight
    shapes, triangles = lattice()
    nodes = np.concatenate([facets[curved], mids[curved]], axis=1)
    more = np.einsum('pk,fk...->fp...', shapes, values[nodes])
    start = len(values) + len(shapes) * np.arange(len(curved))
    fine = (start[:, None, None] + triangles).reshape(-1, 3)
    return (np.concatenate([values, more.reshape(-1, *values.shape[1:])]),
            np.concatenate([facets[straight], fine]),
            np.concatenate([straight, np.repeat(curved, len(triangles))]))


def edge_lines(points: NDArray, facets: NDArray, mids: NDArray) -> NDArray:
    """The edges of facets as lines (edges, points of a line, 3), each once."""
    ends = facets[:, EDGES[:3]].reshape(-1, 2)
    _, first = np.unique(np.sort(ends, axis=1), axis=0, return_index=True)
    a, b = points[ends[first]].transpose(1, 0, 2)
    middle = mids.ravel()[first] if len(mids) else np.full(len(first), -1)
    m = np.where((middle >= 0)[:, None], points[middle], 0.5 * (a + b))
    t = np.linspace(0.0, 1.0, LEVEL + 1)[None, :, None] if np.any(middle >= 0) \
        else np.array([0.0, 1.0])[None, :, None]
    a, b, m = a[:, None], b[:, None], m[:, None]
    return (1 - t) * (1 - 2 * t) * a + t * (2 * t - 1) * b + 4 * t * (1 - t) * m


def facet_normals(points: NDArray, facets: NDArray) -> NDArray:
    """Normals of facets, as long as twice their areas."""
    a, b, c = points[facets].transpose(1, 0, 2)
    return np.cross(b - a, c - a)


def facet_size(points: NDArray, facets: NDArray) -> float:
    """Root of the mean area of facets."""
    if len(facets) == 0:
        return 1.0
    return float(np.sqrt(np.linalg.norm(facet_normals(points, facets), axis=1).mean()))


def facets_across(facets: NDArray, mask: NDArray) -> int:
    """How many facets lie across a region of facets at its widest place: layers of nodes are peeled
    off from its rim; from where the surface ends if it ends there all around."""
    inside = facets[mask]
    if len(inside) == 0:
        return 0
    edges, count = edges_of(inside)
    whole, of_all = edges_of(facets)
    rim, size = edges[count == 1], facets.max() + 1
    ends_there = np.isin(rim @ [size, 1], whole[of_all == 1] @ [size, 1])
    rim = rim if np.all(ends_there) else rim[~ends_there]
    if len(rim) == 0:  # closed: no rim to count from
        return len(inside)
    depth, layer = np.full(size, -1), 0
    depth[rim] = 0
    while True:
        a, b = depth[edges].T
        grown = np.concatenate([edges[(a == layer) & (b < 0), 1], edges[(b == layer) & (a < 0), 0]])
        if len(grown) == 0:
            break
        layer += 1
        depth[grown] = layer
    return 2 * layer + int(np.any(np.all(depth[inside] == layer, axis=1)))


def edges_of(facets: NDArray) -> tuple[NDArray, NDArray]:
    """The edges of facets, and how many facets each has."""
    ends = np.sort(facets[:, EDGES[:3]].reshape(-1, 2), axis=1)
    return np.unique(ends, axis=0, return_counts=True)


def camera(azimuth: float, elevation: float) -> View:
    """Unit vectors to the right, up, and towards the viewer."""
    a, e = np.radians([azimuth, elevation])
    towards = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return right, np.cross(towards, right), towards
