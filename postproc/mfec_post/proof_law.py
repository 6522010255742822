"""The contact points of an output time against Signorini's conditions and Coulomb's law.

doc/theory, eqs. (2.2), (2.3).

What the law is asked of are carriers: points with a penalty or multiplier of their own, or (in
proof_mortar) slave nodes."""
from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from .proof_cells import judge_clips, judge_cover
from .proof_contact import MORTAR, OPEN, SLIP, STICK, Pair, Points, dot, frame_of, shares, unit
from .proof_lines import ROUND_OFF, Array, Ledger, strays
from .proof_paths import carried, over_edge, path_under
from .proof_run import cross
from .proof_touch import Ways, judge_first, touch_rows

TINY, NO_FRICTION = 1e-300, 1e-30


@dataclass
class Carriers:
    """What has a force and a cone; forces on the master, ways since the increment began."""
    who: Array
    force: Array
    axes: Array  # p1, p2 (n, 2, 3)
    depth: Array  # pressure that the cone knows
    way: Array
    slides: Array
    area: Array
    path: Array
    stiff: Array  # penalty, 0 without
    rests: Array  # what may move of those that stick
    asked: Array  # of these the slip rule is asked


@dataclass
class Base:
    """What points begin an increment with."""
    closed: Array
    path: Array
    way: Array
    work: Array

    @staticmethod
    def of(old: Points, at: Array) -> Base:
        """That of points which are those of the output time before."""
        closed = old.status[at] > OPEN
        way = np.zeros((len(at), 3)) if old.way is None else old.way[at]
        return Base(closed, np.where(closed, old.path[at], 0), np.where(closed[:, None], way, 0),
                    old.dissipation[at].copy())


class Judge:
    """The lines of one pair, output time after output time."""

    def __init__(self, pair: Pair, ledger: Ledger):
        self.pair, self.ledger = pair, ledger
        self.old: Optional[Points] = None
        self.before: Array = np.zeros(0, int)  # where each point was at the output time before, -1 if new
        self.x_old: Array = np.zeros(0)
        self.row: dict[str, Any] = {}
        self.begins = True
        self.rounds = 0.0  # of an edge: what rounds of cells leave of ways
        self.covered_once = False
        self.motion: Optional[Ways] = None

    def end_time(self, p: Points, x: Array, scale: float, cut: bool) -> float:
        """All lines of one output time; the energy of the penalty."""
        pair, ledger = self.pair, self.ledger
        self.begins = self.old is None
        if self.begins and not cut:  # the run begins at rest, with all points open
            self.old, self.x_old = p.at_rest(), pair.run.x0
        self.x, self.scale, self.cut = x, max(scale, TINY), cut
        self.noise = 64 * ROUND_OFF * (pair.run.size + float(np.abs(x).max())) / pair.edge
        self.known = self.old is not None and not cut
        open_ = p.status <= OPEN
        stiff = pair.density * p.area if pair.cells else pair.group['epsilon'][:, 0]
        ledger.judge('open points: no force', p.force[open_] / self.scale,
                     blur=(stiff * self.noise * pair.edge / self.scale)[open_])  # of a depth of round-off
        s = pair.slave(p, p.at, x)
        xi, gap, e, found = pair.project(p, p.at, s, x)
        gap = gap + p.offset[p.at]
        sure = self.gaps(p, xi, gap, found)
        if pair.cells or p.nodes.shape[1] > 2 and not self.covered_once:
            judge_cover(pair, p, x, ledger)
            self.covered_once = True
        self.before = self.same_cells(p)
        judge_clips(pair, p, xi, x, self.x_old if len(self.x_old) else x,
                    (self.before[p.at] < 0) | self.begins, ledger)
        closed = p.status[p.at] > OPEN
        self.row = dict.fromkeys(('active', 'stick', 'slip', 'Fn', 'Ft', 'Ft_nodes', 'max_penetration',
                                  'max_elastic_slip', 'max_criterion'), 0.0)
        at, s, xi, gap, e, sure = (v[closed] for v in (p.at, s, xi, gap, e, sure))
        energy = 0.0
        if len(at):
            self.directions(p, at, s, xi, gap, e, sure)
        if len(at) or len(p.at) and pair.points == MORTAR:
            energy = self.carried(p, at, s, gap, e, sure)
        self.old, self.x_old = p, x
        return energy

    def carried(self, p: Points, at: Array, s: Array, gap: Array, e: Array, sure: Array) -> float:
        """The law of the closed points; their energy."""
        carriers, energy = self.penalties(p, at, s, gap, e, sure)
        self.law(carriers)
        self.ways(p, at, carriers, e)
        return energy

    def gaps(self, p: Points, xi: Array, gap: Array, found: Array) -> Array:
        """Gaps of all points against those of the file; which are sure."""
        ledger, edge, at = self.ledger, self.pair.edge, p.at
        closed, who = p.status[at] > OPEN, self.who(p, at)
        near = found & (np.abs(gap) <= edge)
        error = np.abs(gap - p.gap[at]) / edge
        sure = near & (closed | (error <= 1e-9 + self.noise))
        ledger.judge('gap', error, who, self.noise, sure)
        ledger.leave('gap', 'open points that have passed to another facet since', (near & ~sure).sum())
        ledger.leave('gap', 'the projection is not on the curved facet', (~near & closed).sum())
        if self.pair.points != MORTAR:
            ledger.judge('open points: no penetration', np.maximum(0, -gap) / edge, who, self.noise,
                         near & ~closed)
        ledger.judge('open points: apex below', p.tip[at] - xi, who, 1e3 * self.noise, sure & ~closed)
        beyond, rim = -shares(p.tip[at])[closed], self.pair.rim[p.host[at]][closed]
        # cells are cut anew after a share of a facet; others pass to the next, if there is one
        off = np.where(rim, 0, np.maximum(0, beyond)).max(1)
        stays = strays(off, 1e-4, 0.1, 0.1) & (not self.pair.cells)
        ledger.judge('apex inside its facet', off, who[closed], 0.1 if self.pair.cells else 0, ~stays)
        if not self.pair.cells:
            ledger.leave('apex inside its facet', 'beyond an edge by less than the tolerance, or the rim, '
                         'or one that facets pass to and fro', (beyond.max(1) > 2e-6).sum())
        return near

    def who(self, p: Points, at: Array) -> Array:
        """Node numbers for messages."""
        return np.asarray(self.pair.run.numbers[p.nodes[at, 0]])

    def directions(self, p: Points, at: Array, s: Array, xi: Array, gap: Array, e: Array,
                   sure: Array) -> None:
        """Lay, and forces along it."""
        pair, ledger, who = self.pair, self.ledger, self.who(p, at)
        lay = pair.lay_of(p, at, xi, e, s, self.x)
        tells = sure & np.isfinite(lay).all(1) & (np.linalg.norm(lay, axis=1) > 0.5)
        ledger.judge('lay', p.lay[at] - lay, who, 1e3 * self.noise, tells)
        if pair.mu[0] != pair.mu[1]:
            ledger.leave('lay', 'no direction there', (~tells & sure).sum())
        across = cross(e, p.lay[at])
        parts = np.stack([dot(p.force[at], p.lay[at]), dot(p.force[at], across)], 1)
        size = max(float(np.linalg.norm(p.force[at], axis=1).max()), 1e-6 * self.scale)
        ledger.judge('forces along the lay', (p.lay_force[at, :2] - parts) / size, who, self.noise, sure)
        friction = np.zeros_like(self.x)
        np.add.at(friction, p.nodes[at], p.weight[at][:, :, None]
                  * (p.force[at] - dot(p.force[at], e)[:, None] * e)[:, None])
        self.row = {'active': len(at), 'stick': (p.status == STICK).sum(), 'slip': (p.status == SLIP).sum(),
                    'Fn': p.lay_force[at, 2].sum(), 'Ft': np.linalg.norm(parts, axis=1).sum(),
                    'Ft_nodes': np.linalg.norm(friction, axis=1).sum(),
                    'max_penetration': max(0.0, (-p.gap[at]).max())}
        if p.elastic is not None:
            self.row['max_elastic_slip'] = p.elastic[at].max()

    def penalties(self, p: Points, at: Array, s: Array, gap: Array, e: Array, sure: Array
                  ) -> tuple[Carriers, float]:
        """Force from the gap vector at the apex, (3.2); the points as carriers; the energy."""
        pair, ledger, who, edge = self.pair, self.ledger, self.who(p, at), self.pair.edge
        force, host, plain = -p.force[at], p.host[at], p.multiplier is None
        xm = pair.where(p, host, p.tip[at], self.x)[0]
        eps = pair.density * p.area[at] if pair.cells else pair.group['epsilon'][at, 0]
        if not (pair.cells or pair.augmented or pair.penalty_kind > 2):
            want = pair.penalty * (p.area[at] if pair.penalty_kind == 2 else 1.0)
            ledger.judge('penalty of the deck', eps / want - 1, who)
        g = s - xm + p.offset[at, None] * e
        shift = np.zeros_like(g)
        if p.multiplier is not None:
            t1, n = (unit(v) for v in np.moveaxis(frame_of(self.x[pair.facets[host]])[:, :, ::2], 2, 0))
            shift = np.einsum('ndc,nc->nd', np.stack([t1, cross(n, t1), n], -1), p.multiplier[at])
            trial = eps[:, None] * g  # the penalty is raised by one factor
            if np.abs(trial).max() > 1e-9 * self.scale:
                eps = eps * dot(trial, force - shift).sum() / max(dot(trial, trial).sum(), TINY)
            if pair.points == 0:
                ledger.judge('AUGMent: apexes without gap', np.linalg.norm(g, axis=1) / edge
                             / (3 * pair.accuracy), who)
        largest = max(float(np.linalg.norm(force, axis=1).max()), self.scale * 1e-6, TINY)
        blur = eps * self.noise * edge / largest  # of places, through the penalty
        ledger.judge('penalty law', np.linalg.norm(force - shift - eps[:, None] * g, axis=1) / largest,
                     who, blur, sure)
        ledger.judge('pressure, no tension', np.maximum(0, dot(force, e)) / largest, who, self.noise, sure)
        along = g - dot(g, e)[:, None] * e
        if p.elastic is not None and not pair.bent:
            ledger.judge('elastic slip', (np.linalg.norm(along, axis=1) - p.elastic[at]) / edge, who,
                         self.noise, sure)
        if plain:
            ledger.judge('closed: no gap', np.maximum(0, gap) / edge, who, only=sure)
        # the law of friction knows the pressure of the depth: on curved facets a little more than the
        # force has, where multipliers stand in for a stiff penalty somewhere between
        depth, normal = p.lay_force[at, 2], -dot(force, e)
        if plain or not pair.bent:
            want = eps * np.abs(gap) if plain else normal
            other = normal if pair.bent else want
            off = depth - np.clip(depth, np.minimum(want, other), np.maximum(want, other))
            ledger.judge('pressure of the depth', off / largest, who, 10 * blur, sure)
        way = xm - pair.where(p, host, p.start[at], self.x)[0]
        slides = p.status[at] == SLIP
        carriers = Carriers(who, force, np.stack([p.lay[at], cross(e, p.lay[at])], 1), depth, way, slides,
                            p.area[at], p.path[at], eps, way, sure)
        energy = 0.5 * np.linalg.norm(force, axis=1) * np.hypot(gap, np.linalg.norm(along, axis=1))
        return carriers, float(energy.sum())

    def law(self, c: Carriers) -> None:
        """Cone and slip rule, (4.1) and (4.2)."""
        pair, ledger, edge = self.pair, self.ledger, self.pair.edge
        mu, depth = self.coefficients(c.path), c.depth
        if pair.cap > 0:
            depth = np.minimum(depth, pair.cap * c.area / mu.max(1))
        f, moved = (np.einsum('nid,nd->ni', c.axes, v) for v in (c.force, c.way))
        rubs, sure = mu > 0, c.asked
        largest = max(float(depth.max()), 1e-6 * self.scale)
        noise = c.stiff * self.noise * edge / largest
        size = np.linalg.norm(np.where(rubs, f / np.where(rubs, mu, 1), 0), axis=1)
        blur = 10 * noise
        if pair.points != MORTAR and not (pair.augmented or pair.bent):
            self.row['max_criterion'] = float(((size - depth) / c.stiff).max())
        ledger.judge('cone', np.maximum(0, size - depth) / largest, c.who, blur, sure)
        on = c.slides & rubs.all(1) & sure
        ledger.judge('cone where it slips', (size - depth) / largest, c.who, blur, on)
        ledger.judge('no friction without mu', np.where(rubs, 0, f) / largest, c.who, self.noise, sure)
        if pair.points != MORTAR:  # what slides is told from its way
            ledger.judge('no friction without mu', ~(c.slides | rubs.any(1)), c.who)
        ledger.judge('stick: the apex rests', c.rests / edge, c.who, only=~c.slides)
        back = f * np.where(rubs.all(1, keepdims=True),
                            (mu.min(1, keepdims=True) / np.where(rubs, mu, 1)) ** pair.rule, 0)
        # round-off of places turns the direction of short ways, and of small forces
        long, strong = np.linalg.norm(moved, axis=1), np.linalg.norm(back, axis=1)
        on &= long > 1e4 * self.noise * edge
        blur = (self.noise + self.rounds) * edge / np.maximum(long, TINY)
        blur += noise * largest / np.maximum(strong, TINY)
        ratio = np.maximum(long * strong, TINY)
        beside = np.abs(moved[:, 0] * back[:, 1] - moved[:, 1] * back[:, 0]) / ratio
        ledger.judge('slip rule', np.maximum(beside, -dot(moved, back) / ratio), c.who, blur, on)

    def ways(self, p: Points, at: Array, c: Carriers, e: Array) -> None:
        """Start apexes against those of the output time before, work of friction, slip path."""
        pair, ledger, old = self.pair, self.ledger, self.old
        if not self.known or old is None:
            ledger.leave('history', 'the first output time, a cut increment, or fields not of each one',
                         len(at))
            return
        same, last = self.before[at] >= 0, np.where(self.before >= 0, self.before, np.arange(len(p.host)))
        base = Base.of(old, last[at])
        told = same.copy()
        if not same.all():
            told[~same] = self.new_cells(p, at[~same], c, base, np.flatnonzero(~same))
        judge_first(self, p, at[~base.closed & (same | ~told)])
        tangent = c.force - dot(c.force, e)[:, None] * e
        work, long = dot(tangent, c.way), np.linalg.norm(c.way, axis=1)
        self.starts(p, at, last[at], same & base.closed & ~self.found_again(p, at, base, long))
        largest = max(float(np.abs(work).max()), float(np.abs(p.dissipation).max()) * 1e-6,
                      1e-4 * float((np.linalg.norm(c.force, axis=1) * long).max()), TINY)
        blur = self.noise * pair.edge * np.linalg.norm(tangent, axis=1) / largest  # of places
        off = np.abs(p.dissipation[at] - base.work - work)
        if pair.cells and len(at):  # a facet that has been cut to the same cells has shared it among them
            off = np.minimum(off, np.abs(p.dissipation[at] - self.shared_work(p, at) - work))
        ledger.judge('dissipation', off / largest, c.who, blur, told)
        ledger.judge('dissipation, no gain', np.maximum(0, -work) / largest, c.who, blur, told)
        # on a curved facet the law's slip is the way in the plane of the normal at the projection
        bend = 1e4 * long if pair.bent else 0
        ledger.judge('slip path', (p.path[at] - base.path - long) / (pair.edge + bend), c.who, only=told)
        if p.way is not None and old.way is not None:
            ledger.judge('slip vector', np.linalg.norm(p.way[at] - base.way - c.way, axis=1)
                         / (pair.edge + 100 * bend), c.who, only=told)

    def shared_work(self, p: Points, at: Array) -> Array:
        """Work of friction that the facets of points had before, shared among their points by area."""
        old = self.old
        assert old is not None
        _, facet = np.unique(np.concatenate([old.nodes, p.nodes]), axis=0, return_inverse=True)
        was, now = np.split(facet.ravel(), [len(old.nodes)])
        work = np.bincount(was, old.dissipation * (old.area > 0), len(facet))
        area = np.bincount(now, p.area, len(facet))
        return np.asarray(work[now[at]] * p.area[at] / area[now[at]])

    def found_again(self, p: Points, at: Array, base: Base, long: Array) -> Array:
        """Points that had passed the rim of the master begin anew where it is under them again: at the
        projection of their old place, with no path (which tells where that was their apex)."""
        pair, old, x = self.pair, self.old, self.x_old
        assert old is not None
        again = np.zeros(len(at), bool)
        if pair.cells:
            return again
        rows = np.flatnonzero(base.closed & (pair.rim[old.host[at]] & (shares(old.tip[at]) < 0)).any(1))
        place = pair.project(p, at[rows], pair.slave(old, at[rows], x), x)[0]
        off = [np.abs(p.start[at[rows]] - tip).max(1) for tip in (place, old.tip[at[rows]])]
        path = p.path[at[rows]] - long[rows]
        again[rows] = (off[0] < 1e-9) & ((off[1] > 1e-9) | (path < 0.5 * base.path[rows]))
        base.path[again], base.way[again] = 0, 0
        return again

    def blur_of_cuts(self, at: Array) -> float:
        """Of a first touch, as a share of an increment: points of cells that were cut there have not met it,
        and weights of multipliers were others."""
        cut, mortar = self.pair.cells and bool((self.before[at] < 0).any()), self.pair.points == MORTAR
        cut |= self.pair.cells and self.begins and not mortar
        return self.noise + (0.03 if cut else 5e-4 if mortar else 0)

    def same_cells(self, p: Points) -> Array:
        """Where each point was at the output time before, -1 for those of facets that have been cut anew."""
        old, before = self.old, np.full(len(p.host), -1)
        if not self.pair.cells:
            return np.arange(len(before))
        if old is None:
            return before
        now, was = p.at, old.at
        _, facet = np.unique(np.concatenate([p.nodes[now], old.nodes[was]]), axis=0, return_inverse=True)
        here, there = np.split(facet.ravel(), [len(now)])
        same = np.bincount(here, minlength=len(facet)) == np.bincount(there, minlength=len(facet))
        # rows of a facet stay in their order
        now, was = (v[np.argsort(f, kind='stable')] for v, f in ((now, here), (was, there)))
        here, there = np.sort(here), np.sort(there)
        now, was, here = now[same[here]], was[same[there]], here[same[here]]
        new = (p.weight[now] != old.weight[was]).any(1) | (p.area[now] != old.area[was])
        if p.place is not None and old.place is not None:  # the same cells again, histories handed on
            new |= (p.place[now] != old.place[was]).any(1)
        stays = np.bincount(here, new, len(facet))[here] == 0
        before[now[stays]] = was[stays]
        return before

    def new_cells(self, p: Points, at: Array, c: Carriers, base: Base, rows: Array) -> Array:
        """Start apexes of new points of SEGMent: elastic slips of the old points of their facet as
        a linear field, (6.5); which of them it tells, and what these begin with."""
        pair, old, x, ledger = self.pair, self.old, self.x_old, self.ledger
        assert old is not None
        told = np.zeros(len(at), bool)
        used = np.flatnonzero(old.area > 0)
        _, facet = np.unique(np.concatenate([old.nodes[used], p.nodes[at]]), axis=0, return_inverse=True)
        was, now = np.split(facet.ravel(), [len(used)])
        # friction waits where the closest old point was open
        off = np.where(now[:, None] == was, np.linalg.norm(p.weight[at][:, None] - old.weight[used], axis=2),
                       np.inf)
        touches = (touch_rows(pair, ledger.step, x)[1][p.nodes[at, 0]] >= 0) | ('touch' not in pair.group)
        touches &= (old.status[used[off.argmin(1)]] <= OPEN) | np.isinf(off.min(1))
        base.closed[rows] = ~touches
        if pair.bent or p.nodes.shape[1] > 3 or pair.augmented:
            ledger.leave('history', 'new cells, curved or with AUGMent', len(at))
            return told
        s, q = pair.slave(p, at, x), copy.copy(p)
        local = np.linalg.inv(frame_of(x[pair.facets]))
        paths = [path_under(pair, p.host[i], y, x, local) for i, y in zip(at, s)]
        q.host = p.host.copy()  # the facets that the points were over
        q.host[at] = [p.host[i] if path is None else path[-1] for i, path in zip(at, paths)]
        corners = x[pair.facets[q.host[at]]]
        xi = np.linalg.solve(frame_of(corners), (s - corners[:, 2])[..., None])[..., 0]
        start, beyond = np.full((len(at), 2), np.nan), 0
        for f in np.unique(now):
            mine, there = np.flatnonzero(now == f), used[was == f]
            closed = there[(old.status[there] > OPEN) & (old.host[there] >= 0)]
            base.work[rows[mine]] = old.dissipation[there].sum() * p.area[at[mine]] / p.area[
                (p.nodes == p.nodes[at[mine[0]]]).all(1)].sum()
            told[mine] = [paths[i] is not None and not touches[i] for i in mine]
            beyond += int((~told[mine] & ~touches[mine]).sum())
            dual = np.linalg.inv(frame_of(corners[mine]))[:, :2]
            if not len(closed):
                start[mine], base.path[rows[mine]], base.way[rows[mine]] = xi[mine, :2], 0, 0
                continue
            frame = frame_of(x[old.nodes[closed[:1]]])[0]
            frame = np.stack([unit(frame[:, 0]), cross(frame[:, 2], unit(frame[:, 0])), frame[:, 2]], 1)
            to = pair.project(old, closed, pair.slave(old, closed, x), x)[0]
            slip = pair.where(old, old.host[closed], to, x)[0] - pair.where(
                old, old.host[closed], old.tip[closed], x)[0]
            way = np.zeros_like(slip) if old.way is None else old.way[closed]
            value = np.concatenate([slip @ frame, old.path[closed, None], way @ frame], 1)
            area, place = old.area[closed], old.weight[closed, :2]
            middle = area @ place / area.sum()
            y, mean = place - middle, area @ value / area.sum()
            a = (y * area[:, None]).T @ y
            field = np.repeat(mean[None], len(mine), 0)
            if np.linalg.det(a) > 1e-12 * np.trace(a) ** 2:
                field += (p.weight[at[mine], :2] - middle) @ np.linalg.solve(
                    a, (y * area[:, None]).T @ (value - mean))
            low, high = value.min(0), value.max(0)
            wide = (high - low) * (np.arange(7) < 3)
            field = np.clip(field, low - wide, high + wide)
            slip, base.path[rows[mine]], base.way[rows[mine]] = (
                field[:, :3] @ frame.T, field[:, 3], field[:, 4:] @ frame.T)
            way, path = base.way[rows[mine]], base.path[rows[mine]]  # never longer than its path
            base.way[rows[mine]] = way * np.minimum(1, path / np.maximum(np.linalg.norm(way, axis=1), TINY)
                                                    )[:, None]
            slip = self.returned(q, at[mine], xi[mine], s[mine], slip, path)
            start[mine] = xi[mine, :2] - np.einsum('nid,nd->ni', dual, slip)
        for i in np.flatnonzero(told):
            for a, b in zip(paths[i][:0:-1], paths[i][-2::-1]):
                start[i] = over_edge(pair, old, a, b, start[i], x)
        ledger.judge('history of new cells', p.start[at] - start, c.who[rows], only=told)
        ledger.leave('history', 'new cells beyond the rim or a fold at first', beyond)
        return told

    def returned(self, p: Points, at: Array, xi: Array, s: Array, slip: Array, path: Array) -> Array:
        """What the law leaves of an elastic slip at the old places, (4.3)."""
        pair, x = self.pair, self.x_old
        e = frame_of(x[pair.facets[p.host[at]]])[:, :, 2]
        lay = pair.lay_of(p, at, xi[:, :2], e, s, x) if pair.mu[0] != pair.mu[1] else unit(
            x[pair.facets[p.host[at], 0]] - x[pair.facets[p.host[at], 2]])
        axes, mu = np.stack([lay, cross(e, lay)], 1), self.coefficients(path)
        depth = np.maximum(0, -xi[:, 2] - p.offset[at])
        if pair.cap > 0:
            depth = np.minimum(depth, pair.cap / pair.density / mu.max(1))
        trial, bound = np.einsum('nid,nd->ni', axes, slip), np.maximum(mu, NO_FRICTION)
        kappa = (mu.min(1, keepdims=True) / bound) ** pair.rule if pair.mu.min() > 0 else np.ones_like(mu)
        low, high = np.zeros(len(at)), np.full(len(at), 1e9)
        for _ in range(100):  # gamma by bisection: the way over the cone shrinks with it
            gamma = 0.5 * (low + high)
            out = np.linalg.norm(trial / (1 + gamma[:, None] * kappa) / bound, axis=1) > depth
            low, high = np.where(out, gamma, low), np.where(out, high, gamma)
        inside = np.linalg.norm(trial / bound, axis=1) <= depth
        left = np.where(inside[:, None], trial, trial / (1 + high[:, None] * kappa))
        return np.einsum('nid,ni->nd', axes, np.where((depth > 0)[:, None], left, 0))

    def coefficients(self, path: Array) -> Array:
        """Coefficients of friction at points, (n, 2)."""
        mu, decay = np.broadcast_to(self.pair.mu, (len(path), 2)), self.pair.decay
        if decay[2] > 0:
            mu = decay[:2] + (mu - decay[:2]) * np.exp(-path / decay[2])[:, None]
        return mu

    def starts(self, p: Points, at: Array, last: Array, known: Array) -> None:
        """Start apexes of points that were closed before, where they were `last`."""
        pair, ledger, old, who = self.pair, self.ledger, self.old, self.who(p, at)
        assert old is not None
        kept = known & (old.host[last] == p.host[at])
        # over an edge and back again costs digits, on curved facets those of two projections
        ledger.judge('history', p.start[at] - old.tip[last], who, 1e-6 if pair.bent else 0, kept)
        crossed = np.flatnonzero(known & (old.host[last] != p.host[at]))
        places = [carried(pair, old, old.host[j], p.host[i], old.tip[j], self.x_old)
                  for i, j in zip(at[crossed], last[crossed])]
        told = [i for i, place in enumerate(places) if place]
        ledger.judge('history over an edge', [np.abs(places[i] - p.start[at[crossed[i]]]).max(1).min()
                                              for i in told], who[crossed[told]],
                     3e-5 if pair.smooth else 0)  # the program projects on a shape of its iteration
        ledger.leave('history', 'over several edges', len(crossed) - len(told))
