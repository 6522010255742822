"""How apexes begin an increment: over edges of the master (10.2), and where points close (doc/theory,
"Crossing an edge", "Contact initiation")."""
from __future__ import annotations

import copy
from typing import Optional

import numpy as np

from .proof_contact import Pair, Points, dot, frame_of, shares, unit
from .proof_lines import Array, Ledger
from .proof_run import cross

SMOOTH = np.cos(np.pi / 4) - 1e-6  # of normals at rest in the middle of an edge of six-node facets


def over_edge(pair: Pair, p: Points, a: int, b: int, tip: Array, x: Array) -> Array:
    """An apex of facet a in the next facet b: turned about their edge, or where a curved surface
    goes on smoothly the nearest place there."""
    common = [n for n in pair.facets[a].tolist() if n in pair.facets[b].tolist()]
    if pair.bent:
        probe, two = copy.copy(p), np.array([0, 1])
        probe.host, probe.tip, probe.gap = np.array([a, b]), np.array([tip, [1 / 3, 1 / 3]]), np.zeros(2)
        middle = np.stack([0.5 * np.isin(pair.facets[f], common)[:2] for f in (a, b)])
        flat = frame_of(pair.run.x0[pair.facets[[a, b]]])[:, :, 2]
        normal = flat if pair.smooth else unit(pair.where(probe, probe.host, middle, pair.run.x0)[2])
        if normal[0] @ normal[1] > (np.cos(np.pi / 6) - 1e-6 if pair.smooth else SMOOTH):
            place = pair.where(probe, probe.host[:1], probe.tip[:1], x)[0]
            return np.asarray(pair.project(probe, two[1:], place, x)[0][0])
    o, corners = x[common[0]], x[pair.facets[[a, b]]]
    frame, t = frame_of(corners), unit(x[common[1]] - o)
    place = corners[0, 2] + frame[0, :, :2] @ tip - o
    over = cross(frame[:, :, 2], t[None])
    side = np.sign(dot(over, corners.mean(1) - o))
    y = o + (place @ t) * t - side[0] * side[1] * (place @ over[0]) * over[1]
    return np.asarray(np.linalg.solve(frame[1], y - corners[1, 2])[:2])


def carried(pair: Pair, p: Points, a: int, b: int, tip: Array, x: Array) -> list[Array]:
    """What an apex of facet a may be in facet b: over their edge, or over one facet between them."""
    if b in pair.across[a]:
        return [over_edge(pair, p, a, b, tip, x)]
    between = [d for d in pair.across[a] if d >= 0 and b in pair.across[d]]
    return [over_edge(pair, p, d, b, over_edge(pair, p, a, d, tip, x), x) for d in between]


def path_under(pair: Pair, facet: int, s: Array, x: Array, local: Array) -> Optional[list[int]]:
    """Flat facets from one to that which a place is over, None if a fold or the rim is between;
    `local` has the inverse frames of all."""
    path = [facet]
    while len(path) < 20:
        here = path[-1]
        a, b = (local[here] @ (s - x[pair.facets[here, 2]]))[:2]
        place = (a, b, 1 - a - b)
        if min(place) >= 0:
            return path
        after = int(pair.across[here, place.index(min(place))])
        if after < 0 or after in path:
            return None
        n, to = local[here, 2], x[pair.facets[after]]
        if local[after, 2] @ n < 0.99 and ((to - x[pair.facets[here, 2]]) @ n).max() > 1e-6 * pair.edge:
            return None
        path.append(after)
    return None


def judge_touches(pair: Pair, p: Points, at: Array, x_old: Array, x: Array, noise: float,
                  ledger: Ledger) -> None:
    """Points that close in the increment: where they were if they were on the surface, else no farther
    from there than twice what they have moved since."""
    if not len(at) or pair.smooth:
        ledger.leave('first touch', 'on smooth surfaces', len(at))
        return
    host, who = p.host[at], pair.run.numbers[p.nodes[at, 0]]
    s, before = pair.slave(p, at, x), pair.slave(p, at, x_old)
    xi, gap, _, found = pair.project(p, at, before, x_old)
    under = pair.where(p, host, xi, x)[0]
    way = np.linalg.norm(pair.where(p, host, p.start[at], x)[0] - under, axis=1)
    moved = np.linalg.norm(s - before - under + pair.where(p, host, xi, x_old)[0], axis=1)
    there = found & (shares(xi).min(1) >= 0) & (gap <= 0)
    ledger.judge('first touch', way / pair.edge, who, noise, there)
    ledger.judge('first touch', np.maximum(0, way - 2 * moved) / pair.edge, who, noise, found & ~there)
    ledger.leave('first touch', 'the place of closure in the increment is not in the file', (~there).sum())
