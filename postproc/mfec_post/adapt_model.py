"""Bodies of a results file as an adapted run needs them: mesh, parts by name, elasticity; mesh files."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .results import Results, text_of

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
"""Corners that the middle nodes 5 to 10 of a tetrahedron lie between."""
FACES = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
"""Corners of the faces S1 to S4 of Abaqus; the order does not count."""


@dataclass
class Material:
    """An elastic material, or a rigid one."""

    number: int
    young: float
    poisson: float
    finite: bool
    rigid: bool


@dataclass
class Bodies:
    """A mesh with its parts. Points count from 0; cells have 4 or 10 of them."""

    points: NDArray
    cells: NDArray
    material: NDArray
    region: NDArray
    """Number of each cell's region, from 1; 0 for none."""
    regions: list[str]
    sets: dict[str, NDArray]
    surfaces: dict[str, NDArray]
    """Corners of the facets."""
    materials: dict[int, Material] = field(default_factory=dict)

    @property
    def order(self) -> int:
        """1 for tetrahedra of four nodes, 2 for such of ten."""
        return 2 if self.cells.shape[1] > 4 else 1

    @property
    def volumes(self) -> NDArray:
        """Volumes between the corners."""
        a, b, c, d = (self.points[self.cells[:, k]] for k in range(4))
        return np.abs(np.einsum('ij,ij->i', b - a, np.cross(c - a, d - a))) / 6.0

    @property
    def sizes(self) -> NDArray:
        """Edges of regular tetrahedra of the same volumes."""
        return np.cbrt(6.0 * np.sqrt(2.0) * self.volumes)

    def groups(self) -> list[tuple[int, int, NDArray]]:
        """Material, region and cells of what has both in common."""
        keys = np.stack([self.material, self.region], 1)
        return [(int(m), int(r), np.flatnonzero((keys == (m, r)).all(1)))
                for m, r in np.unique(keys, axis=0)]

    def pieces(self) -> list[NDArray]:
        """Cells of each body: those that are joined by nodes."""
        corners = self.cells[:, :4]
        label, before = np.arange(len(self.points)), None
        while before is None or (label != before).any():
            before = label.copy()
            np.minimum.at(label, corners.ravel(), np.repeat(label[corners].min(1), 4))
            label = label[label]
        return [np.flatnonzero(label[corners[:, 0]] == k) for k in np.unique(label[corners[:, 0]])]


def read_bodies(path: str) -> Bodies:
    """The bodies of a results file, of a run or of a check."""
    with Results(path) as results:
        numbers = results.node_numbers
        place = np.full(numbers.max() + 1, -1)
        place[numbers] = np.arange(len(numbers))
        offsets, nodes = results.vtk['Offsets'][:], results.vtk['Connectivity'][:]
        width = np.diff(offsets)
        count = 10 if (width == 10).all() else 4
        run = results.file['run']
        if 'scene' not in results.file:
            raise KeyError(f'{results.path} does not tell its materials: run the deck anew')
        parts = {name: place[data[:]] for name, data in run['surfaces'].items()}
        rows = results.file['scene/materials'][:].reshape(-1, 6)  # number, law, volumetric part, E, nu, rigid
        return Bodies(
            results.points, nodes[offsets[:-1, None] + np.arange(count)],
            results.vtk['CellData/material'][:], results.vtk['CellData/region'][:],
            text_of(run['regions'][0]).split(),
            {name: place[data[:]] for name, data in run['sets'].items()},
            {name: facets for name, facets in parts.items() if (facets >= 0).all()},
            {int(row[0]): Material(int(row[0]), row[3], row[4], row[1] > 1.0, row[5] > 0.0)
             for row in rows})


def raised(bodies: Bodies) -> Bodies:
    """The same with ten nodes a cell, the new ones in the middle of straight edges."""
    if bodies.order == 2:
        return bodies
    pairs = np.sort(bodies.cells[:, EDGES], axis=2).reshape(-1, 2)
    edges, number = np.unique(pairs, axis=0, return_inverse=True)
    points = np.vstack([bodies.points, bodies.points[edges].mean(1)])
    cells = np.hstack([bodies.cells, len(bodies.points) + number.reshape(-1, 6)])
    sets = {}
    for name, nodes in bodies.sets.items():
        inside = np.zeros(len(bodies.points), bool)
        inside[nodes] = True
        sets[name] = np.concatenate([nodes, len(bodies.points) + np.flatnonzero(
            inside[edges].all(1))])
    return Bodies(points, cells, bodies.material, bodies.region, bodies.regions, sets,
                  bodies.surfaces, bodies.materials)


def lowered(bodies: Bodies) -> Bodies:
    """The same with four nodes a cell."""
    if bodies.order == 1:
        return bodies
    used = np.unique(bodies.cells[:, :4])
    new = np.full(len(bodies.points), -1)
    new[used] = np.arange(len(used))
    return Bodies(bodies.points[used], new[bodies.cells[:, :4]], bodies.material, bodies.region,
                  bodies.regions, {name: new[nodes][new[nodes] >= 0] for name, nodes
                                   in bodies.sets.items()},
                  {name: new[facets] for name, facets in bodies.surfaces.items()},
                  bodies.materials)


def facets_of(cells: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Exterior facets: their corners, cells, and faces from 0."""
    faces = np.sort(cells[:, FACES], axis=2).reshape(-1, 3)
    _, first, count = np.unique(faces, axis=0, return_index=True, return_counts=True)
    outer = np.sort(first[count == 1])
    return cells[:, FACES].reshape(-1, 3)[outer], outer // 4, outer % 4


def write_mesh(bodies: Bodies, path: Path, own: set[str], label: str) -> None:
    """An Abaqus mesh. Sets and surfaces that the deck defines itself (`own`) are left to it; each
    region names its material by `label` and a number."""
    lines = ['*NODE']
    lines += ['%d, %.17g, %.17g, %.17g' % (k, *x) for k, x in enumerate(bodies.points, 1)]
    for material, region, members in bodies.groups():
        name = bodies.regions[region - 1] if region > 0 else f'{label}{material}_part'
        lines.append(f'*ELEMENT, TYPE=C3D{bodies.cells.shape[1]}, ELSET={name}')
        lines += [', '.join(map(str, (e + 1, *(bodies.cells[e] + 1)))) for e in members]
        lines.append(f'*SOLID SECTION, ELSET={name}, MATERIAL={label}{material}')
    sides = {}
    if set(bodies.surfaces) - own:
        corners, cells, faces = facets_of(bodies.cells)
        sides = {key: side for key, *side in zip(map(tuple, np.sort(corners, axis=1)), cells, faces)}
    for name, facets in bodies.surfaces.items():
        if name in own:
            continue
        lines.append(f'*SURFACE, NAME={name}, TYPE=ELEMENT')
        for key in map(tuple, np.sort(facets, axis=1)):
            cell, face = sides[key]
            lines.append(f'{cell + 1}, S{face + 1}')
    for name, nodes in bodies.sets.items():
        if name not in own:
            lines.append(f'*NSET, NSET={name}')
            lines += [str(node + 1) for node in nodes]
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
