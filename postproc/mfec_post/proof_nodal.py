"""Nodal stresses: the polynomials of patches formed anew from the stresses of the cells' points
(doc/theory, "Nodal stress", eq. (8.14))."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .proof_bulk import EDGES, Bodies
from .proof_lines import Array, Ledger
from .proof_run import Run

ASKED = 300  # corners: more take longer than the other lines together
TERMS, ENOUGH, STEEP, RINGS, NOISE = (1, 4, 10), (0, 16, 50), (2.0, 10.0), 3, 4.0 + 1e-6


def terms_at(d: Array, terms: int) -> Array:
    """The terms of a polynomial at places."""
    return np.asarray(np.concatenate([np.ones((len(d), 1)), d, d * d, d * d[:, [1, 2, 0]]], 1)[:, :terms])


class NodalStress:
    """Which stresses of points make that of a corner, for corners spread evenly over the bodies."""

    def __init__(self, run: Run, bodies: Bodies):
        self.bodies, count = bodies, len(run.material)
        self.place = np.concatenate([b.place.reshape(-1, 3) for b in bodies.blocks])
        cell = np.concatenate([np.tile(b.cells, len(b.place)) for b in bodies.blocks])
        self.samples = [np.zeros(0, int)] * count
        order = np.argsort(cell, kind='stable')
        for part in np.split(order, np.flatnonzero(np.diff(cell[order])) + 1):
            self.samples[cell[part[0]]] = part
        self.ends = np.zeros((count, 4), int)
        self.volume = np.zeros(count)
        self.around: dict[int, list[int]] = {}
        for block in bodies.blocks:
            self.ends[block.cells] = block.nodes[:, :4]
            x = run.x0[block.nodes[:, :4]]
            self.volume[block.cells] = np.abs(np.linalg.det(x[:, :3] - x[:, 3:])) / 6
        for c in np.flatnonzero(self.volume > 0):
            for v in self.ends[c]:
                self.around.setdefault(int(v), []).append(int(c))
        middles: dict[int, tuple[Any, list[int]]] = {}
        for block in bodies.blocks:
            for k in range(4, block.nodes.shape[1]):
                for c, nodes in zip(block.cells, block.nodes):
                    middles.setdefault(int(nodes[k]), (nodes[EDGES[k - 4]], []))[1].append(int(c))
        every, between = ([n for n in sorted(some)][::max(1, -(-len(some) // asked))]
                          for some, asked in ((self.around, ASKED), (middles, ASKED // 4)))
        self.nodes = np.array(every + between)
        self.rows = [self.of_corner(v, run, run.x0[v], self.around[v]) for v in every]
        self.rows += [[row for v in middles[n][0] for row in self.of_corner(
            int(v), run, run.x0[n], middles[n][1])] for n in between]

    def of_corner(self, v: int, run: Run, to: Array, of: list[int]) -> list[tuple[float, Array, Array]]:
        """What a corner says of a place: volume of these cells, samples and their weights, for each
        material."""
        here, found = np.array(self.around[v]), []
        for material in np.unique(run.material[of]):
            own = here[run.material[here] == material]
            several = all(len(self.samples[c]) > 1 for c in own)
            used, c = self.fitted(run, v, own, material, 1 + several)
            d = (to - run.x0[v]) / np.linalg.norm(self.place[used] - run.x0[v], axis=1).max()
            found.append((float(self.volume[np.intersect1d(own, of)].sum()), used,
                          terms_at(d[None], len(c))[0] @ c))
        return found

    def fitted(self, run: Run, v: int, own: Array, material: int, degree: int) -> tuple[Array, Any]:
        """Samples of the best polynomial around a corner, and what each weighs in its terms."""
        for terms, enough in zip(TERMS[degree:0:-1], ENOUGH[degree:0:-1]):
            cells, grows = own, True
            for ring in range(RINGS + 1):
                used = np.concatenate([self.samples[c] for c in cells])
                last = ring == RINGS or not grows
                if len(used) >= (terms if last else enough):
                    weights = self.weights(used, run.x0[v], terms, len(used) > len(cells))
                    if weights is not None:
                        return used, weights
                if last:
                    break
                more = np.unique([c for n in np.unique(self.ends[cells]) for c in self.around[n]])
                more = more[run.material[more] == material]
                grows, cells = len(more) > len(cells), more
        used = np.concatenate([self.samples[c] for c in own])
        return used, self.weights(used, run.x0[v], 1, len(used) > len(own))

    def weights(self, used: Array, x: Array, terms: int, several: bool) -> Optional[Array]:
        """Least squares: what samples weigh in the polynomial about x; None if they do not tell it."""
        d = self.place[used] - x
        far = np.linalg.norm(d, axis=1).max()
        w, d = np.exp(-STEEP[several] * (d ** 2).sum(1) / far ** 2), d / far
        b = terms_at(d, terms)
        normal = b.T @ (w[:, None] * b)
        if terms > 1 and np.linalg.cond(normal) > 1e10:
            return None
        weights = np.linalg.solve(normal, b.T * w)
        return weights if terms == 1 or (weights[0] ** 2).sum() <= NOISE else None

    def judge(self, written: Array, numbers: Array, ledger: Ledger) -> None:
        """The field of an output time against the stresses that the bodies have."""
        stress = np.concatenate([b.cauchy[..., [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]].reshape(-1, 6)
                                 for b in self.bodies.blocks])
        own = np.array([sum(volume * (weights @ stress[used]) for volume, used, weights in row)
                        / sum(volume for volume, _, _ in row) for row in self.rows])
        largest = max(float(np.abs(stress).max()), 1e-300) + self.bodies.round_off
        ledger.judge('nodal stress', (own - written[self.nodes]) / largest, numbers[self.nodes])
