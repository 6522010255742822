"""Points of slave facets: what they integrate (doc/theory, "Quadrature points", "Segmentation")."""
from __future__ import annotations

from typing import Optional

import numpy as np

from .proof_contact import MORTAR, NEXT, OPEN, STICK, Pair, Points, frame_of
from .proof_lines import Array, Ledger, strays
from .proof_run import cross, joined, triangle

CORNERS = np.array([[1.0, 0], [0, 1], [0, 0]])  # of a facet
SLIPPED = 0.05  # what slips may move in its cell


def places(pair: Pair, nodes: Array, m: Array) -> tuple[Array, Array]:
    """Area coordinates of points in their facets, and what the unit triangle is worth there at rest."""
    x = pair.run.x0[nodes]
    if nodes.shape[1] > 3:
        m = m[:, :3] + 0.5 * (m[:, 3:] + m[:, [5, 3, 4]])
        flat = nodes[:, 3] == nodes[:, 0]  # of three nodes among those of six
        x[flat, 3:] = 0.5 * (x[flat, :3] + x[flat][:, NEXT])
    t = np.einsum('nai,nad->nid', triangle(m[:, :2], nodes.shape[1])[1], x)
    return m, 0.5 * np.linalg.norm(cross(t[:, 0], t[:, 1]), axis=1)


def is_over(pair: Pair, corners: Array, x: Array) -> bool:
    """Whether a slave facet lies over the master with some room around it."""
    middle = corners.mean(0)
    around = middle + 1.3 * (np.concatenate(
        [corners, 0.5 * (corners + corners[NEXT]), middle[None]]) - middle)
    master = x[pair.facets]
    frame = frame_of(master)
    facing = frame[:, :, 2] @ frame_of(corners[None])[0, :, 2] < -0.5
    local = np.einsum('fij,pfj->pfi', np.linalg.inv(frame[facing]),
                      around[:, None] - master[facing, 2])
    inside = (local[..., :2].min(-1) >= 0) & (local[..., :2].sum(-1) <= 1)
    return bool((inside & (np.abs(local[..., 2]) < 0.1 * pair.edge)).any(1).all())


def judge_cover(pair: Pair, p: Points, x: Array, ledger: Ledger) -> None:
    """Never more than the facet, and exact where it is covered, as it is always by points that stay."""
    used = np.flatnonzero((p.area > 0) & (p.host >= 0))
    if not pair.cells:  # a point is there once for each face of the master that it may touch
        used = np.unique(np.concatenate([p.nodes, p.weight], 1), axis=0, return_index=True)[1]
    nodes, (m, size), area = p.nodes[used], places(pair, p.nodes[used], p.weight[used]), p.area[used]
    every = pair.group.get('slave_facets', np.zeros((0, 3), int))  # older files: those with points
    keys, group = np.unique(np.concatenate([nodes[:, :3], pair.run.place[every]]), axis=0,
                            return_inverse=True)
    if not len(keys):
        return
    group, part, who = group.ravel()[:len(area)], area / size, pair.run.numbers[keys[:, 0]]
    share = np.bincount(group, part, len(keys))
    full = np.abs(share - 1) < 1e-9
    if pair.cells:
        ledger.judge('cells: no overlap', np.maximum(0, share - 1), who)
        over = np.array([f for f in np.flatnonzero(~full) if is_over(pair, x[keys[f]], x)], int)
        ledger.judge('cells: cover what is over', share[over] - 1, who[over])
    else:
        ledger.judge('points: areas of their facets', share - 1, who)
    moments, each = np.zeros((len(keys), 3, 3)), np.bincount(group, None, len(keys))
    np.add.at(moments, group, part[:, None, None] * m[:, :, None] * m[:, None, :])
    ledger.judge('points: exact on whole facets', moments.sum(2) - 1 / 3, who, only=full)
    ledger.judge('points: exact on whole facets', moments - (1 + np.eye(3)) / 12, who,
                 only=full & (each > 1))


def clipped(q: Array) -> Array:
    """Area over that of the unit triangle, and first moments, of the part of triangles in it, (n, 3)."""
    for edge in np.array([[1, 0, 0], [0, 1, 0], [-1, -1, 1]]):
        d, on, m = q @ edge[:2] + edge[2], np.roll(q, -1, 1), 2 * q.shape[1]
        to = np.roll(d, -1, 1)
        crosses = (np.minimum(d, to) < 0) & (np.maximum(d, to) > 0)
        t = d / np.where(crosses, d - to, 1)
        every = np.stack([q, q + t[..., None] * (on - q)], 2).reshape(len(q), m, 2)
        kept = np.stack([d >= 0, crosses], 2).reshape(len(q), m)
        last = np.maximum.accumulate(np.where(kept, np.arange(m), -1), 1)  # others stand on the one before
        last = np.where(last < 0, last[:, -1:], last)
        q = np.take_along_axis(every, np.maximum(last, 0)[..., None], 1) * kept.any(1)[:, None, None]
    a, b = q[:, 1:-1] - q[:, :1], q[:, 2:] - q[:, :1]
    part = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    first = q[:, 0] * part.sum(1)[:, None] + ((a + b) * part[..., None]).sum(1) / 3
    return np.concatenate([part.sum(1)[:, None], first], 1)


def judge_clips(pair: Pair, p: Points, xi: Array, x: Array, x_old: Array, made: Array, ledger: Ledger) -> None:
    """Cells against what their master facets leave of the slave facet, cut anew where they say that they
    were made; since then their points have hardly moved over the master. `xi`: where they are; `x_old`:
    places at the last output time; `made`: points of cells made since, whose facets lay as at one of both
    times or between."""
    used = p.at
    if p.place is None or not len(used):
        return
    status, who = p.status[used], pair.run.numbers[p.nodes[used, 0]]
    way = np.abs(np.where(((status > OPEN) & (pair.points != MORTAR))[:, None], p.tip[used], xi)
                 - p.place[used]).max(1)
    most = np.where((status == STICK) | (pair.points == MORTAR), 1e-3, SLIPPED)
    lag = np.maximum(0, way - most)
    late = strays(lag, 1e-4, 0.3, 0.3)
    ledger.judge('cells: where their points are', lag, who, only=~late)
    ledger.leave('cells: where their points are', 'some lag, as where a facet has been cut four times in an '
                 'increment', late.sum())
    used = used[made]
    if pair.bent or p.nodes.shape[1] > 3:
        ledger.leave('cells: clips of facets', 'curved facets', len(used))
        return
    keys, group = np.unique(np.concatenate([p.nodes[used], p.host[used, None]], 1), axis=0,
                            return_inverse=True)
    group, w = group.ravel(), np.concatenate([p.weight[used, :2], np.ones((len(used), 1))], 1)
    size = places(pair, keys[:, :3], np.full((len(keys), 3), 1 / 3))[1]
    own, normal, right = np.zeros((len(keys), 3)), np.zeros((len(keys), 3, 3)), np.zeros((len(keys), 3, 2))
    np.add.at(own, group, (p.area[used] / size[group])[:, None] * w[:, [2, 0, 1]])
    np.add.at(normal, group, w[:, :, None] * w[:, None, :])
    np.add.at(right, group, w[:, :, None] * p.place[used][:, None, :])
    large = (own[:, 0] > 1e-3) & (np.bincount(group, minlength=len(keys)) >= 3)
    keys, own, normal, right = (v[large] for v in (keys, own, normal, right))
    map_ = np.linalg.solve(normal, right)
    first, last, flat = (part_of(pair, keys, map_, y) for y in (x_old, x, None))
    if len(np.unique(joined(len(x), [pair.facets])[pair.facets])) > 1:  # parts may lie over each other
        first, last, flat = (np.stack([np.minimum(own[:, 0], v[:, 0]), own[:, 1], own[:, 2]], 1)
                             for v in (first, last, flat))
    # iterates that turn facets more than that have been cut, too, and now and then farther than that
    room = np.abs(first - last) + 0.2 * np.abs(0.5 * (first + last) - flat)
    off = np.maximum(0, np.abs(own - 0.5 * (first + last)) - room).max(1)
    far = strays(off, 5e-3, 5e-2, 0.01)
    ledger.judge('cells: clips of facets', off, pair.run.numbers[keys[:, 0]], only=~far)
    ledger.leave('cells: clips of facets', 'cut where an iterate had turned them', far.sum())


def part_of(pair: Pair, keys: Array, map_: Array, x: Optional[Array]) -> Array:
    """Area and moments (`clipped`) of what master facets leave of slave facets, `keys`, where the corners
    of the slave's are in the master's, (xi, eta), by an affine map; tilted to each other as at x, or not."""
    cut = outline(map_)
    if x is not None:
        cut += tilted(pair, keys, x)
    part = clipped(cut)
    return np.asarray(part * np.sign(part[:, :1]))


def outline(map_: Array) -> Array:
    """Corners of the master's facet in the slave's, by where those of the slave's are in the master's."""
    return np.linalg.solve(map_[:, :2].swapaxes(1, 2), (CORNERS - map_[:, 2:]).swapaxes(1, 2)).swapaxes(1, 2)


def tilted(pair: Pair, keys: Array, x: Array) -> Array:
    """How far they are from there where the facets are tilted, projected on the slave's at x."""
    s, m = x[keys[:, :3]], x[pair.facets[keys[:, 3]]]
    here, there = (np.einsum('nij,nkj->nki', np.linalg.inv(frame_of(a)), b - a[:, 2:])[:, :, :2]
                   for a, b in ((m, s), (s, m)))
    return np.asarray(there - outline(np.concatenate([here[:, :2] - here[:, 2:], here[:, 2:]], 1)))
