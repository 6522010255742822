"""A results file as the checker reads it."""
from __future__ import annotations

from typing import Any, Optional

import h5py
import numpy as np

from .proof_lines import Array

SCENE_VERSION = 2  # of /scene, the highest that is understood


class Refusal(ValueError):
    """The file does not hold what a proof begins with."""


class Run:
    """The parts of a results file: what does not change, and one output time after the other."""

    def __init__(self, path: str):
        self.file = h5py.File(path, 'r')
        self.read: dict[str, Array] = {}
        vtk = self.vtk = self.file['VTKHDF']
        if 'scene' not in self.file:
            raise Refusal(f'{path} has no group /scene: run the deck with this version of mfec')
        version = int(self.file['scene'].attrs['version'])
        if version > SCENE_VERSION:
            raise Refusal(f'{path} has /scene of version {version}, newer than this mfec-post')
        self.x0 = np.asarray(vtk['Points'][()], float)
        numbers = vtk['PointData/node_number'][()]
        self.numbers = numbers
        self.place = np.full(int(numbers.max(initial=0)) + 1, -1)
        self.place[numbers] = np.arange(len(numbers))
        self.steps = int(vtk['Steps'].attrs['NSteps'])
        self.times = vtk['Steps/Values'][:self.steps]
        types, offsets, ids = (vtk[n][()] for n in ('Types', 'Offsets', 'Connectivity'))
        self.cells = {kind: np.flatnonzero(types == kind) for kind in (10, 24)}
        self.corners = {kind: ids[offsets[at][:, None] + np.arange(4 if kind == 10 else 10)]
                        for kind, at in self.cells.items()}
        self.material = vtk['CellData/material'][()]
        self.materials = {int(row[0]): row[1:] for row in self.table('materials', 6)}
        self.size = float(np.linalg.norm(np.ptp(self.x0, axis=0))) if len(self.x0) else 1.0
        ends = [self.x0[c[:, 0]] - self.x0[c[:, 1]] for c in self.corners.values()]
        edges = np.linalg.norm(np.concatenate(ends), axis=1)
        self.shortest = float(np.median(edges)) if len(edges) else self.size
        self.pairs = {n: self.columns('contact/' + n) for n in self.file['contact']
                      if n.isdigit()} if 'contact' in self.file else {}
        self.contact = self.columns('contact')
        self.rows = {n: self.columns('history/' + n) for n in ('reactions', 'contact')}
        self.sets = {n: self.place[v] for n, v in self.columns('run/sets').items()}
        self.audit = self.columns('audit')
        self.starts = {kind: {n: v[()] for n, v in vtk[f'Steps/{kind}Offsets'].items()}
                       for kind in ('PointData', 'CellData')}
        supports = self.file['scene/supports'][()]
        self.supports = (supports[numbers - 1, None] >> np.arange(4)) & 1
        self.body = self.of_nodes('rigid_body', 0)
        self.springs = self.of_nodes('springs', np.zeros(3))

    def table(self, name: str, columns: int) -> Array:
        """A table of /scene, empty if it is not there."""
        if name not in self.read:
            path = 'scene/' + name
            self.read[name] = self.file[path][()] if path in self.file else np.zeros((0, columns))
        return self.read[name]

    def columns(self, name: str) -> dict[str, Array]:
        """All data sets of a group, empty if it is not there."""
        return {key: data[()] for key, data in self.file[name].items()
                if hasattr(data, 'shape')} if name in self.file else {}

    def of_nodes(self, name: str, nothing: Any) -> Array:
        """What /scene says of each node, in the order of the points."""
        path = 'scene/' + name
        if path not in self.file:
            return np.array([nothing] * len(self.numbers))
        return np.asarray(self.file[path][()][self.numbers - 1])

    def field(self, kind: str, name: str, k: int) -> Optional[Array]:
        """A field of output time k, None if it is not written."""
        if name not in self.vtk[kind]:
            return None
        start = int(self.starts[kind][name][k])
        count = len(self.x0) if kind == 'PointData' else len(self.material)
        return np.asarray(self.vtk[f'{kind}/{name}'][start:start + count], float)

    def factor(self, number: int, time: float) -> float:
        """Value of a table of proportional loads; 0 is the sum of all, 1 if there is none."""
        rows = self.table('tables', 4)
        if number == 0 and len(rows) == 0:
            return 1.0
        total = 0.0
        for one in np.unique(rows[:, 0]) if number == 0 else [number]:
            table = rows[rows[:, 0] == one]
            if len(table) and table[0, 1] > 0:
                a, (begin, end) = table[:, 3], table[:2, 2]
                t = time - begin
                total += (a[0] + a[1] * t + a[2] * np.sin(a[3] * t) ** a[4]
                          if begin <= time <= end else 0.0)
            elif len(table):
                total += float(np.interp(time, table[:, 2], table[:, 3]))
        return total

    def loads(self, name: str, time: float) -> Array:
        """Prescribed displacements or applied forces of all nodes at a time."""
        values = np.zeros_like(self.x0)
        loads = self.table('loads', 3)
        factors = np.array([self.factor(int(load[0]), time) for load in loads])
        for k, (_, form, angle) in enumerate(loads):
            if form > 1:
                turn = angle * factors[k]
                factors[k] = np.sin(turn) if form == 2 else 2.0 * np.sin(0.5 * turn) ** 2
        rows = self.table(name, 4)
        which = rows[:, :3].astype(int)
        np.add.at(values, (self.place[which[:, 1]], which[:, 2] - 1),
                  rows[:, 3] * factors[which[:, 0] - 1])
        return values

    def pressures(self, x: Array, time: float) -> Array:
        """Forces of pressures on the facets where they are."""
        force = np.zeros_like(x)
        for row in self.table('pressures', 8):
            nodes = self.place[row[:6].astype(int)[row[:6] > 0]]
            p = row[7] * self.factor(int(row[6]), time)
            for share, weight in zip(*triangle_rule()):
                n, slopes = triangle(share, len(nodes))
                t = np.einsum('ai,ad->id', slopes, x[nodes])
                force[nodes] -= 0.5 * p * weight * np.outer(n, cross(t[0], t[1]))
        return force


def cross(a: Array, b: Array) -> Array:
    """Vector products of rows; numpy's takes longer than all the rest with few rows."""
    i, j = [1, 2, 0], [2, 0, 1]
    return np.asarray(a[..., i] * b[..., j] - a[..., j] * b[..., i])


def joined(count: int, cells: list[Array]) -> Array:
    """Numbers of what cells join: the lowest node of it."""
    name, before = np.arange(count), np.zeros(0)
    while not np.array_equal(name, before):
        before = name.copy()
        for c in cells:
            np.minimum.at(name, c, name[c].min(1, keepdims=True).repeat(c.shape[1], 1))
        name = name[name]
    return name


def triangle_rule() -> tuple[Array, Array]:
    """Points and weights of a triangle, exact to degree 4."""
    points, weights = [], []
    for a, w in ((0.445948490915965, 0.223381589678011), (0.091576213509771, 0.109951743655322)):
        points += [(a, a), (a, 1 - 2 * a), (1 - 2 * a, a)]
        weights += [w] * 3
    return np.array(points), np.array(weights) / np.sum(weights)


def triangle(xi: Array, nodes: int) -> tuple[Array, Array]:
    """Shape functions of three or six nodes at points (..., 2), and their slopes (..., nodes, 2)."""
    share = np.stack([xi[..., 0], xi[..., 1], 1 - xi[..., 0] - xi[..., 1]], -1)
    slope = np.broadcast_to(np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]]), share.shape + (2,))
    if nodes == 3:
        return share, slope
    i, j = [0, 1, 2], [1, 2, 0]
    n = np.concatenate([share * (2 * share - 1), 4 * share[..., i] * share[..., j]], -1)
    middle = 4 * (slope[..., i, :] * share[..., j, None] + slope[..., j, :] * share[..., i, None])
    return n, np.concatenate([slope * (4 * share - 1)[..., None], middle], -2)
