"""Points of slave facets: what they integrate (doc/theory, "Quadrature points", "Segmentation")."""
from __future__ import annotations

import numpy as np

from .proof_contact import NEXT, Pair, Points, frame_of
from .proof_lines import Array, Ledger
from .proof_run import cross, triangle


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
    used = np.flatnonzero(p.area > 0)
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
