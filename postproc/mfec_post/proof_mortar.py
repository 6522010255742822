"""MORTar: slave nodes with multipliers, whose forces, gaps and slips are means over the points around
them, against the law of contact (doc/theory, "Mortar contact")."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .proof_contact import OPEN, Pair, Points, dot, unit
from .proof_law import TINY, Carriers, Judge
from .proof_lines import Array, Ledger
from .proof_run import cross

CORNERS_OF_PART = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])  # of six nodes
LEAST_COVER, FAR = 1e-4, 0.25  # of its area, of its width: such nodes have no multiplier


class NodeJudge(Judge):
    """The lines of a pair with multipliers."""

    def __init__(self, pair: Pair, ledger: Ledger):
        super().__init__(pair, ledger)
        self.nodes: dict[tuple[int, int], tuple[Any, ...]] = {}  # closed, work of friction
        self.face: Optional[Array] = None
        self.means: dict[Any, tuple[float, Any]] = {}

    def end_time(self, k: int, x: Array, scale: float, cut: bool) -> tuple[Points, float]:
        """All lines of one output time; where nothing is closed nothing is remembered."""
        found = super().end_time(k, x, scale, cut)
        if not self.row['active']:
            self.nodes = {}
        return found

    def hats(self, p: Points) -> tuple[Array, Array]:
        """Nodes and hat functions of the points (7.14): of their facet's corners, or with six nodes
        of those of the part that they lie in."""
        nodes, place = p.nodes[p.at], p.weight[p.at]
        if nodes.shape[1] == 3:
            return nodes, place
        place = place[:, :3] + 0.5 * (place[:, 3:] + place[:, [5, 3, 4]])
        part = np.where(place.max(1) < 0.5, 3, place.argmax(1))
        hat = 2 * place - np.eye(4)[part][:, :3]
        hat = np.where((part == 3)[:, None], 1 - 2 * place[:, [2, 0, 1]], hat)
        return np.take_along_axis(nodes, CORNERS_OF_PART[part], 1), hat

    def carried(self, p: Points, at: Array, s: Array, gap: Array, e: Array, sure: Array) -> float:
        """Forces, gaps and slips of slave nodes as means over their points, (7.13) to (7.16)."""
        pair, ledger, x, at, edge = self.pair, self.ledger, self.x, p.at, self.pair.edge
        if self.face is None:
            self.face = pair.faces(p)
        (own, hat), area, face = self.hats(p), p.area[at], self.face[p.host[at]]
        keys, place = np.unique(np.stack([own, np.repeat(face[:, None], 3, 1)], -1).reshape(-1, 2),
                                axis=0, return_inverse=True)
        place = place.reshape(-1, 3)
        weight = np.bincount(place.ravel(), (area[:, None] * hat).ravel())
        _, group = np.unique(place, axis=0, return_inverse=True)
        group = group.ravel()
        d, m = np.zeros((group.max() + 1, 3)), np.zeros((group.max() + 1, 3, 3))
        np.add.at(d, group, area[:, None] * hat)
        np.add.at(m, group, area[:, None, None] * hat[:, :, None] * hat[:, None, :])
        sound = np.linalg.cond(m) < 1e9  # a sliver has no functions of its own
        psi = hat.copy()
        good = sound[group]
        psi[good] = np.linalg.solve(m[group[good]], hat[good][..., None])[..., 0] * d[group[good]]
        share = area[:, None] * psi / weight[place]

        def gathered(values: Array, by: Array) -> Array:
            """Sums over the points of each multiplier, (n, components)."""
            total = np.zeros((len(keys), values.shape[1]))
            by_point = by[:, :, None] * values[:, None, :]
            np.add.at(total, place.ravel(), by_point.reshape(-1, values.shape[1]))
            return total

        def spread(values: Array) -> Array:
            """What multipliers make at the points."""
            return np.einsum('pk,pkc->pc', share, values[place])

        z, f = np.zeros((len(keys), 3)), p.force[at]
        for _ in range(1 if sound.all() else 20):
            z += gathered(f - spread(z), hat)
        ledger.judge('multipliers: one a node', (f - spread(z)) / self.scale, self.who(p, at))
        s, start = pair.slave(p, at, x), p.start[at]
        xi, _, e, _ = pair.project(p, at, s, x)
        under = pair.where(p, p.host[at], xi, x)[0]
        normal = unit(gathered(e, area[:, None] * hat))
        gap = dot(gathered(s - under, share), normal) + gathered(p.offset[at, None], share)[:, 0]
        lay = gathered(p.lay[at], area[:, None] * hat)
        p1 = unit(lay - dot(lay, normal)[:, None] * normal)
        closed = np.linalg.norm(z, axis=1) > 1e-13 * self.scale
        who = pair.run.numbers[keys[:, 0]]
        held = pair.run.supports[keys[:, 0], :3] > 0
        beside = (np.abs(held * normal).max(1) < 1e-6)  # supports do not carry the pressure
        asked = closed & beside
        ledger.judge('multipliers: no gap', gap[asked] / edge, who[asked], self.noise)
        covered = ~closed & beside & self.covered(p, keys, weight, place, dot(s - under, e))
        ledger.judge('multipliers: open, no penetration', np.maximum(0, -gap)[covered] / edge, who[covered],
                     self.noise)
        ledger.judge('pressure, no tension', np.maximum(0, -dot(z, normal))[closed] / self.scale, who[closed])
        ledger.leave('multipliers: no gap', 'the slave node is held', (closed & ~beside).sum())
        known = np.zeros(len(keys), bool)
        slip = np.zeros_like(z)
        names = [tuple(key) for key in keys.tolist()]
        if self.known:
            known = np.array([closed[i] and bool(self.nodes.get(name, (False,))[0])
                              for i, name in enumerate(names)])
            before = pair.slave(p, at, self.x_old) - pair.where(p, p.host[at], start, self.x_old)[0]
            slip = gathered(s - pair.where(p, p.host[at], start, x)[0] - before, share)
            slip = slip - dot(slip, normal)[:, None] * normal
            slip = np.where(held, 0, slip)
            same = self.same_cells(p, at) & known[place].any(1)
            if self.old is not None:
                self.starts(p, at, same & (self.old.status[at] > OPEN))
        ledger.leave('history', 'multipliers that have closed, a cut increment, or the first output time',
                     (closed & ~known).sum())
        free = closed & ~held.any(1)
        slides = known & (np.linalg.norm(slip, axis=1) > 1e-8 * edge)
        depth = np.maximum(0, dot(z, normal))
        c = Carriers(who, -z, np.stack([p1, cross(normal, p1)], 1), depth, slip, slides, weight,
                     np.zeros(len(keys)), np.zeros(len(keys)), np.zeros_like(z), free)
        if closed.any():
            self.law(Carriers(**{name: value[closed] for name, value in vars(c).items()}))
        tangent = z - dot(z, normal)[:, None] * normal
        self.row = {'active': closed.sum(), 'Fn': dot(z, normal)[closed].sum(),
                    'Ft': np.linalg.norm(tangent[closed], axis=1).sum(),
                    'max_penetration': max(0.0, (-gap[closed]).max(initial=0.0))}
        self.works(p, keys, names, closed, known, z, slip, gathered, hat, group, d, weight, place)
        return 0.0

    def covered(self, p: Points, keys: Array, weight: Array, place: Array, gap: Array) -> Array:
        """Which slave nodes are over the master with more than a sliver, and near it."""
        facets = np.unique(p.nodes[p.at], axis=0)
        x0, six = self.pair.run.x0, facets.shape[1] == 6
        corners = x0[facets[:, :3]]
        size = 0.5 * np.linalg.norm(cross(corners[:, 0] - corners[:, 2], corners[:, 1] - corners[:, 2]),
                                    axis=1)
        whole = np.zeros(len(x0))
        np.add.at(whole, facets[:, :3], size[:, None] / (12 if six else 3))
        np.add.at(whole, facets[:, 3:], size[:, None] / 4)
        whole = whole[keys[:, 0]]
        least = np.full(len(keys), np.inf)
        np.minimum.at(least, place.ravel(), np.repeat(gap, 3))
        return np.asarray((weight > 10 * LEAST_COVER * whole) & (least < 0.5 * FAR * np.sqrt(whole)))

    def works(self, p: Points, keys: Array, names: list[Any], closed: Array, known: Array, z: Array,
              slip: Array, gathered: Any, hat: Array, group: Array, d: Array, weight: Array,
              place: Array) -> None:
        """Work of friction and ways of the multipliers, from what their points show of them."""
        ledger, at = self.ledger, p.at
        # points that lack one of their three multipliers show none of its work
        whole = np.bincount(group, np.abs(p.dissipation[at])) > 0
        first = np.unique(group, return_index=True)[1]
        seen = np.bincount(place[first].ravel(), (np.where(whole[:, None], d, 0)
                                                  / weight[place[first]]).ravel(), len(keys))
        done = gathered(p.dissipation[at, None], hat)[:, 0] / np.where(seen > 0, seen, 1)
        work = -dot(z, slip)
        own = {node: [n for n in names if n[0] == node] for node, _ in names}
        kept = np.array([known[i] and own[name[0]] == [n for n in self.nodes if n[0] == name[0]]
                         for i, name in enumerate(names)])
        last = np.array([self.nodes[name][1] if name in self.nodes else 0.0 for name in names])
        largest = max(float(np.abs(work).max()), float(np.abs(done).max()) * 1e-6,
                      1e-4 * float((np.linalg.norm(z, axis=1) * np.linalg.norm(slip, axis=1)).max()), TINY)
        told = kept & (seen > 0)
        who = self.pair.run.numbers[keys[:, 0]]
        ledger.judge('dissipation', (done - last - work)[told] / largest, who[told])
        ledger.judge('dissipation, no gain', np.maximum(0, -work)[kept] / largest, who[kept])
        self.nodes = {name: (bool(closed[i]), float(done[i])) for i, name in enumerate(names)}
        # a point shows the mean of the ways of its three multipliers
        means: dict[Any, tuple[float, Any]] = {}
        path, errors = np.linalg.norm(slip, axis=1), []
        for q in first:
            nodes, i = place[q], at[q]
            key = tuple(map(tuple, keys[nodes].tolist())), tuple(p.nodes[i].tolist())
            way = p.way[i] if p.way is not None else np.zeros(3)
            means[key] = float(p.path[i]), way
            if known[nodes].all() and key in self.means:
                errors.append([p.path[i] - self.means[key][0] - path[nodes].mean(),
                               *(way - self.means[key][1] - slip[nodes].mean(0))])
        self.means = means
        if errors:
            ledger.judge('slip path', np.array(errors)[:, :1] / self.pair.edge)
            if p.way is not None:
                ledger.judge('slip vector', np.array(errors)[:, 1:] / self.pair.edge)
