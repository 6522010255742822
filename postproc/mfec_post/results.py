"""The results file (.vtkhdf): fields, tables, contact points."""
from __future__ import annotations

import os

import h5py
import numpy as np
from numpy.typing import NDArray


def text_of(value: bytes) -> str:
    """A string of the file without the blanks at its end."""
    return value.decode('utf-8', 'replace').rstrip('\0 ')


def results_path(path: str) -> str:
    """The results file that a path means: x.vtkhdf, or x.h5 of an older run; the one that is there."""
    base, ending = os.path.splitext(path)
    other = {'.vtkhdf': '.h5', '.h5': '.vtkhdf'}.get(ending)
    if other and not os.path.exists(path) and os.path.exists(base + other):
        return base + other
    return path


def mises(stress: NDArray) -> NDArray:
    """Equivalent stress of xx yy zz xy yz zx."""
    xx, yy, zz, xy, yz, zx = stress.T
    return np.sqrt(0.5 * ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2)
                   + 3.0 * (xy ** 2 + yz ** 2 + zx ** 2))


class Results:
    """A results file open for reading. Output times of the fields count from 0 (-1 is the last)."""

    def __init__(self, path: str):
        self.path = results_path(path)
        self.file = h5py.File(self.path, 'r')
        self.vtk = self.file['VTKHDF']
        self.steps = int(self.vtk['Steps'].attrs['NSteps'])
        self.times = self.vtk['Steps/Values'][:self.steps]

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the file."""
        self.file.close()

    def index(self, frame: int) -> int:
        """The output time `frame`, counted from 0, or from the end if negative."""
        index = frame + self.steps if frame < 0 else frame
        if not 0 <= index < self.steps:
            raise IndexError(f'{self.path} holds {self.steps} output times with fields, not {frame}')
        return index

    def text(self, name: str) -> str:
        """A text of /run: title, deck, version, settings."""
        return text_of(self.file['run'][name][0])

    @property
    def points(self) -> NDArray:
        """Reference coordinates (points, 3)."""
        return self.vtk['Points'][:]

    @property
    def node_numbers(self) -> NDArray:
        """Node number of the deck of each point."""
        return self.vtk['PointData/node_number'][:]

    @property
    def cells(self) -> NDArray:
        """Corner points of the tetrahedra (cells, 4)."""
        offsets = self.vtk['Offsets'][:-1]
        return self.vtk['Connectivity'][:][offsets[:, None] + np.arange(4)]

    @property
    def ten_node_cells(self) -> NDArray:
        """Points of the tetrahedra with mid nodes (cells, 10)."""
        offsets = self.vtk['Offsets'][:-1][self.vtk['Types'][:] == 24]
        return self.vtk['Connectivity'][:][offsets[:, None] + np.arange(10)]

    def point_field(self, name: str, frame: int = -1) -> NDArray:
        """A field over the points at one output time."""
        return self._field('PointData', name, frame, int(self.vtk['NumberOfPoints'][0]))

    def cell_field(self, name: str, frame: int = -1) -> NDArray:
        """A field over the cells at one output time; `von_mises` follows from the stress."""
        if name == 'von_mises' and name not in self.vtk['CellData']:
            return mises(self.cell_field('stress', frame))
        return self._field('CellData', name, frame, int(self.vtk['NumberOfCells'][0]))

    def unit(self, name: str) -> str:
        """The unit of a field of points or cells, '' if the file does not say."""
        for group in ('PointData', 'CellData'):
            if name in self.vtk[group]:
                unit = self.vtk[group][name].attrs.get('unit', b'')
                return text_of(unit) if isinstance(unit, bytes) else str(unit)
        raise KeyError(f'{self.path} has no field {name}')

    def _field(self, group: str, name: str, frame: int, count: int) -> NDArray:
        if name not in self.vtk[group]:
            raise KeyError(f'{self.path} has no field {name}; it has: '
                           + ', '.join(self.vtk[group]))
        first = int(self.vtk['Steps'][group + 'Offsets'][name][self.index(frame)])
        values = self.vtk[group][name][first:first + count]
        return values.astype(float) if values.dtype.kind == 'f' else values

    def regions(self) -> tuple[NDArray, list[str]]:
        """The region of each cell, from 1, and the names; materials where the deck has no regions."""
        number, names = self.vtk['CellData/region'][:], self.text('regions').split()
        if names and number.min() > 0:
            return number, names
        material = self.vtk['CellData/material'][:]
        return material, [f'material {k + 1}' for k in range(material.max())]

    def set_nodes(self, name: str) -> NDArray:
        """Indices of the points of a node set of the deck."""
        sets = self.file['run/sets']
        if name not in sets:
            raise KeyError(f'{self.path} has no set {name}; it has: ' + ', '.join(sets))
        return np.flatnonzero(np.isin(self.node_numbers, sets[name][:]))

    def set_displacement(self, name: str) -> NDArray:
        """Mean displacement of the nodes of a set at each output time (times, 3)."""
        nodes = self.set_nodes(name)
        return np.array([self.point_field('displacement', k)[nodes].mean(axis=0)
                         for k in range(self.steps)]).reshape(-1, 3)

    def history(self, kind: str) -> dict[str, NDArray]:
        """The table `reactions` or `contact` as a dictionary of columns."""
        columns = {name: data[:] for name, data in self.file['history'][kind].items()}
        rows = min((len(column) for column in columns.values()), default=0)
        for name, column in columns.items():
            columns[name] = column[:rows]
            if column.dtype.kind == 'S':
                columns[name] = np.array([text_of(item) for item in column[:rows]])
        return columns

    @property
    def pairs(self) -> dict[str, str]:
        """Contact pairs: their names, and the keys of their groups."""
        groups = self.file['contact'] if 'contact' in self.file else {}
        return {text_of(groups[key].attrs['name']): key for key in groups
                if isinstance(groups[key], h5py.Group)}

    def contact(self, pair: str, frame: int = -1) -> dict[str, NDArray]:
        """The contact points of a pair at one output time as a dictionary of arrays.

        A point is the sum of the nodes in its row of `node` times the `weight`s there: one node
        with NTOS, the three of a facet with GTOS; with SEGMent they change with time. `traction`
        is a force; over `area`, the reference area of the point, it is a traction.
        """
        group = self.file['contact'][self.pairs[pair]]
        index = self.index(frame)
        points = {name: group[name][index] for name in
                  ('host', 'status', 'traction', 'gap', 'tip', 'lay')}
        points_move = group['node'].ndim == 3
        if points_move:
            points['node'], points['weight'] = group['node'][index], group['weight'][index]
        else:
            points['node'] = group['node'][:].reshape(len(points['host']), -1)
            points['weight'] = (group['weight'][:] if 'weight' in group
                                else np.ones(points['node'].shape))
        for name in ('frictional_slip', 'slip_path'):  # files of before have the latter with DECAy
            if name in group:
                points[name] = group[name][index]
        if 'area' in group:
            points['area'] = group['area'][index] if points_move else group['area'][:]
        points['facets'] = group['facets'][:]
        return points
