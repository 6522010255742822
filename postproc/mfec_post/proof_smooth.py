"""SMOOth: the surfaces of a pair bent anew from their facets (doc/theory, "Surface smoothing")."""
from __future__ import annotations

from typing import Optional

import numpy as np

from .proof_contact import LAST, NEXT, Pair, Points, dot, frame_of, unit
from .proof_lines import Array, Ledger
from .proof_run import cross

SHARP = np.cos(np.pi / 6) - 1e-6  # of normals at rest: 30 degrees, which drums of twelve facets have
TURNS = 0.75 * np.pi  # where facets fill less at a boundary, the boundary itself turns
STEEPEST, SHARE = 0.3, 1 / 19  # of a tilt; of the edges that tell it


class Surface:
    """Which corners of the facets of a surface have one normal, and the patches at any positions."""

    def __init__(self, facets: Array, x: Array):
        count, self.facets = len(facets), facets
        ends = np.stack([facets[:, NEXT], facets[:, LAST]], -1).reshape(-1, 2)  # of the edge facing corner k
        key, back = (ends @ [len(x), 1]), (ends @ [1, len(x)])
        order = np.argsort(key)
        other = order[np.minimum(np.searchsorted(key, back, sorter=order), len(order) - 1)]
        normal = frame_of(x[facets])[:, :, 2].repeat(3, 0)
        joined = (key[other] == back) & (dot(normal, normal[other]) >= SHARP)
        begin, end = (3 * (np.arange(3 * count) // 3) + np.tile(turn, count) for turn in (NEXT, LAST))
        one = np.concatenate([begin[joined], end[joined]])
        two = np.concatenate([end[other[joined]], begin[other[joined]]])
        name = np.arange(3 * count)
        while (name[one] != name[two]).any():
            np.minimum.at(name, one, name[two])
            np.minimum.at(name, two, name[one])
        self.corner = np.unique(name, return_inverse=True)[1].reshape(count, 3)
        self.rim = np.zeros(self.corner.max() + 1, bool)
        self.rim[self.corner.ravel()[np.concatenate([begin[~joined], end[~joined]])]] = True
        self.ends = self.rim & (np.bincount(self.corner.ravel(), self.angles(x).ravel()) < TURNS)

    def angles(self, x: Array) -> Array:
        """The angles of the facets, (n, 3)."""
        y = x[self.facets]
        a, b = y[:, NEXT] - y, y[:, LAST] - y
        return np.asarray(np.arctan2(np.linalg.norm(cross(a, b), axis=2), dot(a, b)))

    def normals(self, x: Array) -> Array:
        """Those of the corners: means of the facets around by their angles, at a boundary tilted so
        that edges from within end as they begin."""
        total, facet = np.zeros((len(self.rim), 3)), frame_of(x[self.facets])[:, None, :, 2]
        np.add.at(total, self.corner, self.angles(x)[:, :, None] * facet)
        n, here = unit(total), np.tile(self.corner, 2).ravel()
        there = np.concatenate([self.corner[:, NEXT], self.corner[:, LAST]], 1).ravel()
        y = x[self.facets]
        d = unit(np.concatenate([y[:, NEXT] - y, y[:, LAST] - y], 1).reshape(-1, 3))
        tell = self.rim[here] & ~self.ends[there] & (~self.rim[there] | self.ends[here])
        here, there, d = here[tell], there[tell], d[tell]
        w = d - dot(d, n[here])[:, None] * n[here]
        a, b = np.zeros((len(n), 3, 3)), np.zeros((len(n), 3))
        np.add.at(a, here, w[:, :, None] * w[:, None, :])
        np.add.at(b, here, -dot(d, n[here] + n[there])[:, None] * w)
        tilt = np.einsum('nij,nj->ni', np.linalg.pinv(a, rcond=SHARE, hermitian=True), b)
        tilt *= np.minimum(1, STEEPEST / np.maximum(np.linalg.norm(tilt, axis=1), STEEPEST))[:, None]
        return n * np.sqrt(1 - dot(tilt, tilt))[:, None] + tilt

    def patches(self, x: Array) -> Array:
        """Curvatures of the edges (6.7) and normals of the corners, (n, 2, 3, component)."""
        n, y = self.normals(x)[self.corner], x[self.facets]
        d, one, two = y[:, LAST] - y[:, NEXT], n[:, NEXT], n[:, LAST]
        m = unit(one + two - d * (dot(d, one + two) / dot(d, d))[..., None])
        i, j = dot(m, one), dot(m, two)
        size = (dot(d, one) * i - dot(d, two) * j) / (i ** 2 + j ** 2)
        return np.stack([size[..., None] * m, n], 1)


class Shapes:
    """The two surfaces of a smooth pair."""

    def __init__(self, pair: Pair):
        self.pair, self.slave = pair, None if 'lift' not in pair.group else pair.group.get('slave_facets')
        self.sides: list[Optional[Surface]] = [Surface(pair.facets, pair.run.x0), None]

    def judge(self, p: Points, k: int, x: Array, ledger: Ledger) -> None:
        """Patches of the master, and heights of the points over their slave facets."""
        pair, there = self.pair, np.flatnonzero(self.pair.there['patch'][k])
        if p.patch is None or not len(there):
            return
        master, slave = self.sides
        assert master is not None
        frame = frame_of(x[pair.facets[there]])
        written = np.einsum('ndc,nskc->nskd', frame, p.patch[there].reshape(-1, 2, 3, 3))
        patches = master.patches(x)
        off = (patches[there] - written) / np.array([pair.edge, 1])[:, None, None]
        ledger.judge('patches of SMOOth', off, pair.run.numbers[pair.facets[there, 0]])
        p.patch = np.einsum('ncd,nskd->nskc', np.linalg.inv(frame_of(x[pair.facets])), patches)
        if 'lift' not in pair.group:
            return
        nodes = p.nodes[:, :3]
        if slave is None:  # points of GTOS are on all facets
            every = nodes if self.slave is None else pair.run.place[self.slave]
            slave = self.sides[1] = Surface(np.unique(every, axis=0), pair.run.x0)
        height = np.einsum('fkd,fd->fk', slave.patches(x)[:, 0], frame_of(x[slave.facets])[:, :, 2])
        _, first, facet = np.unique(np.concatenate([slave.facets, nodes[p.at]]), axis=0, return_index=True,
                                    return_inverse=True)
        facet = first[facet.ravel()[len(slave.facets):]]
        height = np.concatenate([height, np.full((len(nodes), 3), np.nan)])  # of no facet
        m = p.weight[p.at, :3]
        lift = -(m[:, NEXT] * m[:, LAST] * height[facet]).sum(1)
        ledger.judge('height over slave facets', (lift - p.lift[p.at]) / pair.edge, pair.run.numbers[nodes[
            p.at, 0]])
