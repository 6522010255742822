"""The contact surfaces (.contact.vtkhdf): pressure, shear traction, gap, status, slip, lay."""
from __future__ import annotations

import os

import h5py
import numpy as np
from numpy.typing import NDArray

TRIANGLES = (5, 22)
SIDES = {'slave': 1, 'master': 2}


def surfaces_beside(path: str) -> str:
    """The file of contact surfaces of a results file."""
    if path.endswith('.contact.vtkhdf'):
        return path
    return os.path.splitext(path)[0] + '.contact.vtkhdf'


class Surface:
    """One side of a contact pair at one output time."""

    def __init__(self, points: NDArray, facets: NDArray, mids: NDArray, nodes: NDArray,
                 at_nodes: dict[str, NDArray], at_facets: dict[str, NDArray]):
        self.points = points
        """Reference coordinates (nodes, 3)."""
        self.facets = facets
        """Corners of the facets, places in `points` (facets, 3)."""
        self.mids = mids
        """Mid nodes of their edges, -1 where a facet has none (facets, 3)."""
        self.nodes = nodes
        """Node numbers of the deck."""
        self.at_nodes = at_nodes
        """Fields at the nodes by their names: pressure, traction, shear_traction, gap, ..."""
        self.at_facets = at_facets
        """Fields of the facets by their names."""

    def __repr__(self) -> str:
        return f'<Surface, {len(self.points)} nodes, {len(self.facets)} facets: {", ".join(self.at_nodes)}>'

    @property
    def places(self) -> NDArray:
        """Current coordinates (nodes, 3)."""
        return self.points + self.at_nodes['displacement']

    @property
    def areas(self) -> NDArray:
        """Reference areas of the facets."""
        a, b, c = self.points[self.facets].transpose(1, 0, 2)
        return np.linalg.norm(np.cross(a - c, b - c), axis=1) / 2

    def integral(self, name: str) -> NDArray:
        """The integral of a field of the nodes, linear over each reference facet."""
        values = self.at_nodes[name][self.facets].mean(axis=1)
        return np.tensordot(self.areas, values, axes=(0, 0))

    def facet_integral(self, name: str) -> NDArray:
        """The integral of a field of the facets over the reference facets."""
        return np.tensordot(self.areas, self.at_facets[name], axes=(0, 0))


class Surfaces:
    """A file of contact surfaces open for reading. Output times count from 0 (-1 is the last)."""

    def __init__(self, path: str):
        self.path = path
        self.file = h5py.File(path, 'r')
        self.vtk = self.file['VTKHDF']
        self.steps = int(self.vtk['Steps'].attrs['NSteps'])
        self.times = self.vtk['Steps/Values'][:self.steps]
        self.pairs = {name[5:]: int(number) for name, number in self.vtk.attrs.items()
                      if name.startswith('pair_')}

    def __enter__(self) -> Surfaces:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the file."""
        self.file.close()

    def fields(self) -> list[str]:
        """Names of the fields at nodes that change in time."""
        return [name for name, data in self.vtk['PointData'].items() if data.dtype.kind == 'f']

    def unit(self, name: str) -> str:
        """The unit of a field."""
        value = self.vtk['PointData'][name].attrs['unit']
        return value.decode() if isinstance(value, bytes) else str(value)

    def surface(self, pair: str, side: str = 'slave', frame: int = -1) -> Surface:
        """One side, `slave` or `master`, of a pair at one output time."""
        if pair not in self.pairs:
            raise KeyError(f'{self.path} has no pair {pair}; it has: ' + ', '.join(self.pairs))
        if side not in SIDES:
            raise KeyError(f'a pair has no side {side}; it has: ' + ', '.join(SIDES))
        index = frame + self.steps if frame < 0 else frame
        if not 0 <= index < self.steps:
            raise IndexError(f'{self.path} holds {self.steps} output times, not {frame}')
        wanted = (self.pairs[pair], SIDES[side])
        points = np.flatnonzero(self._chosen('PointData', wanted))
        triangles = np.isin(self.vtk['Types'][:], TRIANGLES)
        cells = np.flatnonzero(self._chosen('CellData', wanted) & triangles)
        offsets = self.vtk['Offsets'][:][cells]
        ends = self.vtk['Offsets'][:][cells + 1]
        ids = self.vtk['Connectivity'][:]
        facets = ids[offsets[:, None] + np.arange(3)]
        mids = np.full(facets.shape, -1)
        curved = ends - offsets == 6
        mids[curved] = ids[offsets[curved][:, None] + np.arange(3, 6)]
        start = points[0] if len(points) else 0
        facets = facets - start
        mids[curved] -= start
        at_nodes = self._fields('PointData', index, points)
        at_facets = means(at_nodes, facets) | self._fields('CellData', index, cells)
        return Surface(self.vtk['Points'][:][points], facets, mids,
                       self.vtk['PointData/node_number'][:][points], at_nodes, at_facets)

    def _chosen(self, group: str, wanted: tuple[int, int]) -> NDArray:
        return ((self.vtk[group]['pair'][:] == wanted[0])
                & (self.vtk[group]['side'][:] == wanted[1]))

    def _fields(self, group: str, index: int, chosen: NDArray) -> dict[str, NDArray]:
        count = int(self.vtk['NumberOfPoints' if group == 'PointData' else 'NumberOfCells'][0])
        fields = {}
        for name, data in self.vtk[group].items():
            if data.dtype.kind == 'f':
                first = int(self.vtk['Steps'][group + 'Offsets'][name][index])
                fields[name] = data[first:first + count][chosen].astype(float)
        return fields


def means(at_nodes: dict[str, NDArray], facets: NDArray) -> dict[str, NDArray]:
    """Fields of facets from those of their corners, where the file has these alone."""
    return {name: values[facets].mean(axis=1) for name, values in at_nodes.items()
            if name not in ('force', 'displacement')}
