"""Where points close that have come through the air: ways of the nodes within an increment and what
they meet, formed anew (doc/theory, "Contact initiation", (10.5) to (10.8))."""
from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from .proof_contact import OPEN, Pair, Points, dot, frame_of, shares
from .proof_lines import Array
from .proof_paths import carried, judge_touches
from .proof_run import Run, cross, joined

NEVER, ON_EDGE, RISES = 1e300, 1e-7, 0.42


class Ways:
    """Where the nodes would be at the end of an increment if nothing touched (10.6)."""

    def __init__(self, run: Run, linear: bool):
        self.run, self.linear = run, linear
        self.body = joined(len(run.x0), [c for c in run.corners.values() if len(c)])
        self.fixed = (run.supports[:, :3] > 0) | (run.body > 0)[:, None]
        free = ~self.fixed & (run.springs <= 0)
        moved = np.intersect1d(self.body[self.fixed.any(1)], self.body[~self.fixed.all(1)])
        self.bodies = [np.flatnonzero(self.body == b) for b in moved]
        self.center = 0.5 * (run.x0.max(0) + run.x0.min(0))
        self.size = float(np.ptp(run.x0, axis=0).max())
        self.floats = np.zeros(len(run.x0), bool)  # what supports and springs leave rigid motions
        for b in np.unique(self.body[free.any(1)]):
            here = self.body == b
            rows = self.rows(run.x0[here])[~free[here]]
            self.floats[here] = np.linalg.matrix_rank(rows, 1e-6 * max(1, np.sqrt(len(rows)))) < 6
        self.sure = not (run.table('rigid', 9)[:, 3:].any() or run.supports[:, 3].any())
        self.x: Optional[Array] = None

    def rows(self, x: Array) -> Array:
        """Displacements at places by six motions, (n, 3, 6)."""
        y, row = (x - self.center) / self.size, np.zeros((len(x), 3, 6))
        row[:, :, :3] = np.eye(3)
        row[:, :, 3:] = cross(np.eye(3), y[:, None, :]).swapaxes(1, 2)
        return row

    def carry(self, last: Array, u: Array, turn: bool) -> Array:
        """The bodies moved rigidly as their prescribed nodes move best."""
        done = np.where(self.fixed, u, last)
        for nodes in self.bodies:
            fixed, x, v = self.fixed[nodes], self.run.x0[nodes], last[nodes].copy()
            for _ in range(12 if turn else 1):
                step = np.where(fixed, u[nodes] - v, 0)
                if np.abs(step).max() <= (1e-15 * self.size if turn else 0):
                    break
                row = self.rows(x + v if turn else x)
                used = row[fixed]
                motion = np.linalg.lstsq(used.T @ used, used.T @ step[fixed], 1e-10)[0]
                if turn and np.abs(motion).max() <= 1e-13 * self.size:
                    break
                if turn:
                    w = motion[3:] / self.size
                    angle, y = np.linalg.norm(w) / np.pi, x + v - self.center
                    v += motion[:3] + cross(w, y) * np.sinc(angle) + 0.5 * cross(w, cross(
                        w, y)) * np.sinc(angle / 2) ** 2
                else:
                    v += row @ motion
            done[nodes] = np.where(fixed, u[nodes], v)
        return done

    def take(self, time: float, begin: float, u: list[Array], span: float) -> None:
        """The way to `time`, where displacements are u[0], from those before, the last first; `span` is
        the length of the last increment, 0 if there was none."""
        given = np.where((self.run.body > 0)[:, None], u[0], self.run.loads('displacements', time))
        self.ratio = (time - begin) / span if span > 0 else 0.0
        self.x = self.run.x0 + self.carry(u[1], given, not self.linear)
        if span > 0:
            self.x = self.x + self.ratio * (u[1] - self.carry(u[2], u[1], False))


def touch_rows(pair: Pair, step: int, x: Array) -> tuple[Array, Array]:
    """Places without friction at new points, and the first touch of each node's body; both are no
    numbers where the file has none; without rows nothing was foreseen."""
    place, start = np.full_like(x, np.nan), np.full(len(x), np.nan)
    if 'touch' not in pair.group:
        return place, start
    node, value = pair.group['touch_node'], pair.group['touch']
    begin = np.flatnonzero(node == 0)
    for i in begin[value[begin, 0] == step][-1:]:
        rows = slice(i + 1, begin[begin > i].min(initial=len(node)))
        at = pair.run.place[node[rows]]
        place[at], start[at] = pair.run.x0[at] + value[rows, :3], value[rows, 3]
    return place, start


def closing(gap: Array, free: Array, none: Any) -> Array:
    """When a gap closes that goes evenly (10.7)."""
    with np.errstate(all='ignore'):
        time = np.where(free >= gap - none, NEVER, gap / (gap - free))
    return np.where(gap <= none, 0.0, time)


def way_before(time: Array, empty: Array, start: Array, ratio: float) -> Array:
    """The share of its way that a point has made when it closes (10.7), (10.8)."""
    late = time >= NEVER
    plain = np.maximum(start, np.where(late, 0.5, np.minimum(1, time)))
    if ratio <= 0:
        return plain
    with np.errstate(all='ignore'):
        front = np.minimum(1, 1 / (ratio * ((1 + 1 / (ratio * time)) ** (2 / 3) - 1)))
    return np.where(empty | (time <= 0), plain, 2 / 3 * np.where(late, 0.5, front))


@dataclass
class Moving:
    """Places of nodes on their ways (10.5), read as an array: each row at a time of its own."""
    old: Array
    free: Array
    last: Array
    start: Array
    time: Array

    def __getitem__(self, nodes: Array) -> Array:
        start, t = self.start[:, None, None], self.time[:, None, None]
        x = self.old[nodes] + np.minimum(t, start) * (self.free - self.old)[nodes]
        late = np.maximum(0, t - start) / np.where(start < 1, 1 - start, 1)
        return np.asarray(np.where(late > 0, x + late * (self.last[nodes] - x), x))


def walk(pair: Pair, p: Points, at: Array, host: Array, x: Array, most: int = 50) -> tuple[Array, ...]:
    """The facets that points come to from others, (xi, eta) there, gaps."""
    q, s = copy.copy(p), pair.slave(p, at, x)
    q.host, q.tip = p.host.copy(), np.full_like(p.tip, 1 / 3)
    q.host[at] = host
    before, live, rises = np.full(len(at), -1), np.ones(len(at), bool), concave(pair)
    for step in range(most):
        xi, gap, _, _ = pair.project(q, at, s, x)
        if pair.cells or most == 1:
            break
        here, n, to = q.host[at], shares(xi), np.full(len(at), -1)
        for _ in range(3):
            k = n.argmin(1)
            out = (n[range(len(at)), k] < -ON_EDGE) & (to < 0)
            there = np.where(rises[here, k], -1, pair.across[here, k])
            to = np.where(out, there, to)
            n[range(len(at)), k] = 1
        live &= (to >= 0) & (to != before) & ((step == 0) | (to != host))
        if not live.any():
            break
        before = np.where(live, here, before)
        q.host[at] = np.where(live, to, here)
    return q.host[at], xi, gap


def concave(pair: Pair) -> Array:
    """Edges of the master that no way leads over: the neighbour rises steeply."""
    x, (f, k) = pair.run.x0, np.nonzero(pair.across >= 0)
    rises, there = np.zeros(pair.across.shape, bool), pair.across[f, k]
    a, b, on = x[pair.facets[f]], x[pair.facets[there]], pair.facets[f, (k + 1) % 3]
    na, nb = frame_of(a)[:, :, 2], frame_of(b)[:, :, 2]
    steep = (np.linalg.norm(cross(na, nb), axis=1) >= RISES) | (dot(na, nb) <= 0)
    rises[f, k] = steep & (np.einsum('nkd,nd->nk', b - x[on][:, None], na).max(1) > 1e-12 * pair.edge)
    return rises


def judge_first(judge: Any, p: Points, at: Array) -> None:
    """Points that were open begin where their ways meet the surface."""
    pair, ledger, ways, old, x_old = judge.pair, judge.ledger, judge.motion, judge.old, judge.x_old
    if pair.smooth or ways is None or ways.x is None or 'touch' not in pair.group:
        judge_touches(pair, p, at, x_old, judge.x, judge.noise, ledger)
        return
    last, start = touch_rows(pair, ledger.step, judge.x)
    lone = ways.body[p.nodes[at, 0]][start[p.nodes[at, 0]] >= 0]
    lone = np.setdiff1d(lone, ways.body[old.nodes[old.status > OPEN, 0]])  # any of their points may be first
    every = p.at[np.isin(p.at, at) | np.isin(ways.body[p.nodes[p.at, 0]], lone)]
    body, t1 = ways.body[p.nodes[every, 0]], start[p.nodes[every, 0]]
    mine, was = np.isin(every, at), old.status > OPEN
    empty = ~np.isin(body, ways.body[old.nodes[was, 0]])
    first = p.host[every] if pair.cells else np.where(old.host >= 0, old.host, p.host)[every]
    f, _, gap = walk(pair, p, every, first, x_old)
    time = closing(gap, walk(pair, p, every, f, ways.x)[2], 0.25 * judge.noise * pair.edge)
    for b in np.unique(body[mine]):
        here = body == b
        judge_start(judge, t1[here & mine], time[here], time[here & mine], bool(empty[here].all()),
                    bool(ways.floats[b]), judge.blur_of_cuts(every[here]))
    first, time, t1, empty = (v[mine] for v in (first, time, t1, empty))
    waits, who = t1 >= 0, judge.who(p, at)
    t = way_before(time, empty, t1, ways.ratio)
    where, tip, _ = walk(pair, p, at, first, x_old, 1)
    way: Any = Moving(x_old, ways.x, last, t1[waits], t[waits])
    where[waits], tip[waits], _ = walk(pair, p, at[waits], first[waits], way)
    off = np.array([np.abs(c - p.start[i]).max() if f == p.host[i] else min(
        (np.abs(d - p.start[i]).max() for d in carried(pair, p, f, p.host[i], c, x_old)), default=np.nan)
        for i, f, c in zip(at, where, tip)])
    enters = (old.host[at] < 0) & ~waits & (not pair.cells)
    ledger.leave('first touch', 'over the rim of the master', enters.sum())
    known = np.isfinite(off) & ~enters
    ledger.judge('first touch', off, who, 1e3 * judge.noise, known)
    ledger.leave('first touch', 'over facets whose ways are not in the file', (~known & ~enters).sum())


def judge_start(judge: Any, start: Array, every: Array, closed: Array, empty: bool, floats: bool,
                blur: float) -> None:
    """The first touch of a body is that of one of its points, and of none that closed later."""
    start = np.unique(start[start >= 0])
    if not len(start):
        return
    want = np.append(every, 1)[np.abs(np.append(every, 1) - start[0]).argmin()]
    if not empty or floats:
        want = 0.0
    elif min(closed.min(), 1) < start[0] - 1e-9 - blur:
        want = closed.min()
    judge.ledger.judge('first touch', start - want, blur=blur)
