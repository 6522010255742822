"""MORTar: slave nodes with multipliers, whose forces, gaps and slips are means over the points around
them, against the law of contact (doc/theory, "Mortar contact")."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .proof_contact import OPEN, Pair, Points, dot, unit
from .proof_law import TINY, Carriers, Judge
from .proof_lines import Array, Ledger
from .proof_run import cross
from .proof_touch import closing, judge_start, touch_rows, way_before

CORNERS_OF_PART = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])  # of six nodes
LEAST_COVER, FAR = 1e-4, 0.25  # of its area, of its width: such nodes have no multiplier
ROUNDS = 1e-9  # of an edge: what rounds leave of slips


class Multipliers:
    """The multipliers of an output time, one for each slave node and face of the master: weights of
    their points (7.14), and what they do."""

    def __init__(self, corner: Array, hat: Array, area: Array, face: Array, carrier: Array):
        own = carrier[corner]
        self.keys, place = np.unique(np.stack([own, np.repeat(face[:, None], 3, 1)], -1).reshape(-1, 2),
                                     axis=0, return_inverse=True)
        self.names = [tuple(key) for key in self.keys.tolist()]
        self.hat, self.place, self.mean = hat, place.reshape(-1, 3), area[:, None] * hat
        self.weight = np.bincount(self.place.ravel(), self.mean.ravel())
        _, group = np.unique(np.hstack([corner, face[:, None]]), axis=0, return_inverse=True)
        self.group = group.ravel()
        self.d = np.zeros((self.group.max() + 1, 3))
        m = np.zeros((len(self.d), 3, 3))
        np.add.at(self.d, self.group, self.mean)
        np.add.at(m, self.group, self.mean[:, :, None] * hat[:, None, :])
        self.sound = np.linalg.cond(m) < 1e9  # a sliver has no functions of its own
        psi, good = hat.copy(), self.sound[self.group]
        psi[good] = np.linalg.solve(m[self.group[good]], hat[good][..., None])[..., 0] * self.d[
            self.group[good]]
        self.share = area[:, None] * psi / self.weight[self.place]
        self.known = np.zeros(len(self.keys), bool)  # closed at the output time before, too
        self.covered = self.known  # there for sure
        self.slip = np.zeros((len(self.keys), 3))

    def gathered(self, values: Array, by: Array) -> Array:
        """Sums over the points of each multiplier, (n, components)."""
        total = np.zeros((len(self.keys), values.shape[1]))
        np.add.at(total, self.place.ravel(), (by[:, :, None] * values[:, None, :]).reshape(
            -1, values.shape[1]))
        return total

    def spread(self, values: Array) -> Array:
        """What multipliers make at the points."""
        return np.einsum('pk,pkc->pc', self.share, values[self.place])

    def take(self, force: Array, gap: Array, offset: Array, e: Array, lay: Array) -> None:
        """Forces, normals with the lay, and gaps of the multipliers from those of their points."""
        self.force = np.zeros((len(self.keys), 3))
        for _ in range(1 if self.sound.all() else 20):
            self.force += self.gathered(force - self.spread(self.force), self.hat)
        self.normal = unit(self.gathered(e, self.mean))
        along = self.gathered(lay, self.mean)
        p1 = unit(along - dot(along, self.normal)[:, None] * self.normal)
        self.frame = np.stack([p1, cross(self.normal, p1), self.normal], -1)
        self.gap = dot(self.gathered(gap, self.share), self.normal) + self.gathered(
            offset[:, None], self.share)[:, 0]
        self.pressure = dot(self.force, self.normal)


class NodeJudge(Judge):
    """The lines of a pair with multipliers."""

    def __init__(self, pair: Pair, ledger: Ledger):
        super().__init__(pair, ledger)
        self.rounds = ROUNDS
        self.nodes: dict[tuple[int, int], tuple[Any, ...]] = {}  # closed, work of friction, frame
        self.face: Optional[Array] = None
        self.carrier = np.arange(len(pair.run.x0))  # node that has the multiplier of each (7.23)
        if 'carriers' in pair.group:
            node, by = pair.run.place[pair.group['carriers']].T
            self.carrier[node] = by
        self.means: dict[Any, tuple[float, Any]] = {}

    def end_time(self, p: Points, x: Array, scale: float, cut: bool) -> float:
        """All lines of one output time; where nothing is closed nothing is remembered."""
        energy = super().end_time(p, x, scale, cut)
        if not self.row['active']:
            self.nodes = {}
        return energy

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
        pair, ledger, x, at = self.pair, self.ledger, self.x, p.at
        if self.face is None:
            self.face = pair.faces(p)
        m = Multipliers(*self.hats(p), p.area[at], self.face[p.host[at]],
                        self.carrier)
        s = pair.slave(p, at, x)
        xi, _, e, _ = pair.project(p, at, s, x)
        under = pair.where(p, p.host[at], xi, x)[0]
        m.take(p.force[at], s - under, p.offset[at], e, p.lay[at])
        ledger.judge('multipliers: one a node', (p.force[at] - m.spread(m.force)) / self.scale,
                     self.who(p, at))
        closed = np.linalg.norm(m.force, axis=1) > 1e-13 * self.scale
        who = pair.run.numbers[m.keys[:, 0]]
        held = pair.run.supports[m.keys[:, 0], :3] > 0
        beside = np.abs(held * m.normal).max(1) < 1e-6  # supports do not carry the pressure
        ledger.judge('multipliers: no gap', m.gap / pair.edge, who, self.noise, closed & beside)
        ledger.leave('multipliers: no gap', 'the slave node is held', (closed & ~beside).sum())
        m.covered = self.covered(p, m.keys, m.weight, m.place, dot(s - under, e))
        ledger.judge('multipliers: open, no penetration', np.maximum(0, -m.gap) / pair.edge, who, self.noise,
                     ~closed & beside & m.covered)
        ledger.judge('pressure, no tension', np.maximum(0, -m.pressure) / self.scale, who, only=closed)
        tip, open_ = p.tip[at], ~np.array([self.nodes.get(name, (False,))[0] for name in m.names])
        ledger.judge('multipliers: apexes', np.minimum(*(np.abs(tip - v).max(1) for v in (xi, p.start[at]))),
                     self.who(p, at), 1e3 * self.noise, p.status[at] > OPEN)
        if self.known:
            self.slips(p, m, closed, held)
            self.touches(p, m, xi, closed & open_, held)
        ledger.leave('history', 'a cut increment, or multipliers whose first touch is not in the file',
                     (closed & ~m.known).sum())
        none = np.zeros(len(who))
        # where nodes have touched their slip begins at a place with less digits
        slides = m.known & (np.linalg.norm(m.slip, axis=1) > np.where(open_, 1e-4, 1e-8) * pair.edge)
        c = Carriers(who, -m.force, m.frame[:, :, :2].swapaxes(1, 2), np.maximum(0, m.pressure), m.slip,
                     slides, m.weight, none, none, np.zeros_like(m.slip), closed & ~held.any(1))
        if closed.any():
            self.law(Carriers(**{name: value[closed] for name, value in vars(c).items()}))
        tangent = m.force - m.pressure[:, None] * m.normal
        self.row = {'active': closed.sum(), 'Fn': m.pressure[closed].sum(),
                    'Ft': np.linalg.norm(tangent[closed], axis=1).sum(),
                    'max_penetration': max(0.0, (-m.gap[closed]).max(initial=0.0))}
        self.works(p, m, closed)
        self.ways_of_points(p, m, open_ & closed)
        return 0.0

    def slips(self, p: Points, m: Multipliers, closed: Array, held: Array) -> None:
        """Slips of the increment, (7.15): what was between node and master turns with the node."""
        pair, at = self.pair, p.at
        m.known = np.array([here and bool(self.nodes.get(name, (False,))[0])
                            for here, name in zip(closed, m.names)])
        turn = np.stack([m.frame[i] @ self.nodes[name][2].T if m.known[i] else np.eye(3)
                         for i, name in enumerate(m.names)])
        before, now = (m.gathered(pair.slave(p, at, x) - pair.where(p, p.host[at], p.start[at], x)[0],
                                  m.share) for x in (self.x_old, self.x))
        slip = now - np.einsum('nij,nj->ni', turn, before)
        m.slip = np.where(held, 0, slip - dot(slip, m.normal)[:, None] * m.normal)
        # multipliers stick without elastic slip: slips count from below each point
        below, _, _, found = pair.project(p, at, pair.slave(p, at, self.x_old), self.x_old)
        over = found & (np.minimum(below.min(1), 1 - below.sum(1)) > 1e-9)
        self.ledger.judge('history', p.start[at] - below, self.who(p, at), self.noise,
                     over & (p.status[at] > OPEN))

    def touches(self, p: Points, m: Multipliers, xi: Array, new: Array, held: Array) -> None:
        """Slips of multipliers that were open, by the weights of now from where their way meets the
        master (10.5) to (10.8)."""
        pair, at, ways, old = self.pair, p.at, self.motion, self.old
        if not new.any() or ways is None or ways.x is None or old is None or 'touch' not in pair.group:
            return

        def apart(x: Array, below: Array = xi) -> Array:
            return m.gathered(pair.slave(p, at, x) - pair.where(p, p.host[at], below, x)[0], m.share)

        last, start = touch_rows(pair, self.ledger.step, self.x)
        t1, body = start[m.keys[:, 0]], ways.body[m.keys[:, 0]]
        empty = ~np.isin(body, ways.body[old.nodes[old.status > OPEN, 0]])
        below, _, e, _ = pair.project(p, at, pair.slave(p, at, self.x_old), self.x_old)
        offset = m.gathered(p.offset[at, None], m.share)[:, 0]
        gap = dot(apart(self.x_old, below), unit(m.gathered(e, m.mean))) + offset
        time = closing(gap, dot(apart(ways.x), m.normal) + offset, 1e-9 * np.sqrt(m.weight))
        for b in np.unique(body[new]):
            here = body == b
            judge_start(self, t1[here & new], time[here], time[here & new], bool(empty[here].all()),
                        bool(ways.floats[b]), self.blur_of_cuts(at))
        waits = t1 >= 0
        t1 = np.where(waits, t1, 0)
        t = np.where(waits, way_before(time, empty, t1, ways.ratio), 0)
        late = np.where(t > t1, (t - t1) / np.where(t1 < 1, 1 - t1, 1), 0)[:, None]
        early = np.minimum(t, t1)[:, None]
        begin = (1 - late) * ((1 - early) * apart(self.x_old) + early * apart(ways.x))
        begin += np.where(late > 0, late * apart(np.where(np.isnan(last), self.x, last)), 0)
        slip = apart(self.x) - begin
        new = new & (~waits | np.isfinite(t))
        m.slip[new] = np.where(held, 0, slip - dot(slip, m.normal)[:, None] * m.normal)[new]
        m.known |= new

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

    def works(self, p: Points, m: Multipliers, closed: Array) -> None:
        """Work of friction of the multipliers, from what their points show of it."""
        ledger, shown = self.ledger, p.dissipation[p.at]
        # points that lack one of their three multipliers show none of its work
        whole = np.bincount(m.group, np.abs(shown)) > 0
        worked = self.old is not None and self.old.dissipation.any()
        nodes = m.place[np.unique(m.group, return_index=True)[1]]
        seen = np.bincount(nodes.ravel(), (np.where(whole[:, None], m.d, 0) / m.weight[nodes]).ravel(),
                           len(m.keys))
        done = m.gathered(shown[:, None], m.hat)[:, 0] / np.where(seen > 0, seen, 1)
        work = -dot(m.force, m.slip)
        own, before = ({node: [n for n in names if n[0] == node] for node, _ in names}
                       for names in (m.names, list(self.nodes)))
        kept = m.known & np.array([own[node] == before.get(node) or not worked for node, _ in m.names])
        last = np.array([self.nodes[name][1] if name in self.nodes else 0.0 for name in m.names])
        largest = max(float(np.abs(work).max()), float(np.abs(done).max()) * 1e-6, 1e-4 * float(
            (np.linalg.norm(m.force, axis=1) * np.linalg.norm(m.slip, axis=1)).max()), TINY)
        who = self.pair.run.numbers[m.keys[:, 0]]
        # of slips, where all stick: to what rounds leave
        blur = (self.noise + self.rounds) * self.pair.edge * np.linalg.norm(m.force, axis=1) / largest
        off = done - last - work
        kept &= seen > 0
        # one keeps the work of those that are no more, or too little over the master
        if set(before) - set(own) or not m.covered.all():
            kept[np.where(kept, np.abs(off), -1).argmax()] = False
        ledger.judge('dissipation', off / largest, who, blur, kept)
        ledger.judge('dissipation, no gain', np.maximum(0, -work) / largest, who, blur, kept)
        self.nodes = {name: (bool(closed[i]), float(done[i]), m.frame[i]) for i, name in enumerate(m.names)}

    def ways_of_points(self, p: Points, m: Multipliers, new: Array) -> None:
        """A point shows the mean of the ways of its three multipliers."""
        means: dict[Any, tuple[float, Any]] = {}
        path, errors = np.linalg.norm(m.slip, axis=1), []
        for q in np.unique(m.group, return_index=True)[1]:
            nodes, i = m.place[q], p.at[q]
            key = tuple(map(tuple, m.keys[nodes].tolist())), tuple(p.nodes[i].tolist())
            way = p.way[i] if p.way is not None else np.zeros(3)
            if p.path[i] <= 0 and not m.covered[nodes].all():  # points that lack a multiplier show nothing
                continue
            means[key] = float(p.path[i]), way
            base = self.means.get(key, (0.0, np.zeros(3)) if new[nodes].all() else None)
            if m.known[nodes].all() and base is not None:
                errors.append([p.path[i] - base[0] - path[nodes].mean(),
                               *(way - base[1] - m.slip[nodes].mean(0))])
        self.means = means
        if errors:
            self.ledger.judge('slip path', np.array(errors)[:, :1] / self.pair.edge)
            if p.way is not None:
                self.ledger.judge('slip vector', np.array(errors)[:, 1:] / self.pair.edge)
