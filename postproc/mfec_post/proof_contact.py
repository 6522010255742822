"""Contact points of a results file: where they are, the master under them, their forces.

Formulas as in doc/theory, "Contact kinematics" to "Discretisation of the interface"; the facet is
flat, quadratic, part of an exact sphere or cylinder, or a patch of smooth surfaces."""
from __future__ import annotations

import copy
from types import SimpleNamespace
from typing import Any, Optional

import numpy as np

from .proof_lines import Array
from .proof_run import Run, cross, triangle

CIRCUMFERENTIAL, RADIAL, FIELD = 2, 3, 4
OPEN, STICK, SLIP = 0, 1, 2
FIELDS = ('host', 'status', 'traction', 'gap', 'tip', 'lay', 'lay_traction', 'dissipation', 'slip_path',
          'frictional_slip', 'elastic_slip', 'multiplier', 'place')
SEGMENTS, MORTAR = -1, -2  # numbers of points in the law
NEXT, LAST = [1, 2, 0], [2, 0, 1]


def dot(a: Array, b: Array) -> Array:
    """Products of rows."""
    return np.einsum('...i,...i->...', a, b)


def unit(a: Array) -> Array:
    """Rows of length one."""
    size = np.linalg.norm(a, axis=-1, keepdims=True)
    return a / np.where(size > 0, size, 1)


def shares(xi: Array) -> Array:
    """The three area coordinates of (xi, eta)."""
    return np.concatenate([xi, 1 - xi.sum(-1, keepdims=True)], -1)


def frame_of(x: Array) -> Array:
    """a1, a2 and the unit normal of flat facets, (n, component, vector)."""
    a1, a2 = x[:, 0] - x[:, 2], x[:, 1] - x[:, 2]
    return np.stack([a1, a2, unit(cross(a1, a2))], -1)


def normal_share(x: Array, height: Array, f: Array) -> Array:
    """Forces at three corners that do the work of f on a height over them: a couple."""
    frame = frame_of(x)
    along = np.einsum('nid,nd->ni', np.linalg.inv(frame)[:, :2], f)
    r = -(height[:, None] * along)[:, :, None] * frame[:, None, :, 2]
    return np.concatenate([r, -r.sum(1, keepdims=True)], 1)


class Points:
    """The points of a pair at one output time; `at` are those with a facet."""

    def __init__(self, pair: Pair, k: int):
        group = pair.group
        take = {name: values[k] for name, values in group.items() if name in FIELDS}
        self.host = take['host'] - 1
        zero = np.zeros(len(self.host))
        self.status, self.force, self.gap = take['status'], take['traction'], take['gap']
        self.tip, self.lay = take['tip'], take['lay']
        self.start: Any = pair.rows('start_tip', k)
        self.lay_force, self.elastic = take['lay_traction'], take.get('elastic_slip')
        self.dissipation, self.path, self.way = (
            take['dissipation'], take['slip_path'], take.get('frictional_slip'))
        self.offset, self.lift = (zero if v is None else v for v in (
            pair.rows(name, k) for name in ('offset', 'lift')))
        self.multiplier: Optional[Array] = take.get('multiplier')
        self.place: Optional[Array] = take.get('place')
        self.patch = pair.rows('patch', k)
        nodes, self.area, weight = (
            group[name][k] if pair.cells and name in group else group.get(name)
            for name in ('node', 'area', 'weight'))
        nodes = nodes.reshape(len(self.host), -1)
        there = self.area > 0 if pair.cells else np.ones(len(zero), bool)  # others are room for cells
        self.at = np.flatnonzero(there & (self.host >= 0))
        self.nodes = pair.run.place[np.where(there[:, None], nodes, nodes.max())]
        self.weight = np.ones((len(zero), 1)) if weight is None else weight

    def at_rest(self) -> Points:
        """The same points before anything has touched."""
        rest = copy.copy(self)
        rest.status, rest.path, rest.dissipation = (
            np.zeros_like(v) for v in (self.status, self.path, self.dissipation))
        rest.way = None if self.way is None else np.zeros_like(self.way)
        return rest


class Pair:
    """One contact pair: its law, and the geometry of its surfaces."""

    def __init__(self, run: Run, name: str, group: Any):
        self.run, self.name, self.group = run, name, group
        law = group['law'][0]
        self.points, self.smooth, self.augmented, self.round = (int(v) for v in law[:4])
        self.mu, self.rule, self.lay_kind = law[4:6], int(law[6]), int(law[7])
        self.axis, self.origin, self.angle = law[8:11], law[11:14], np.radians(law[14])
        self.convected, self.accuracy = law[15] > 0, law[16]
        self.penalty_kind, self.penalty, self.density = int(law[17]), law[18], law[19]
        self.decay, self.cap = law[20:23], law[23]
        self.cells = self.points in (SEGMENTS, MORTAR)
        self.facets = run.place[group['facets']]
        middles = group.get('middles', np.zeros_like(self.facets))
        self.middles = np.where(middles > 0, run.place[middles], -1)
        self.curved = (self.middles[:, 0] >= 0) & (self.smooth == 0)
        self.bent = bool(self.smooth or self.curved.any())
        near = group['host'] > 0
        self.there = {'start_tip': group['status'] > OPEN, 'offset': near, 'lift': near}
        if self.smooth:
            self.there['patch'] = np.array([np.isin(np.arange(1, len(self.facets) + 1), host)
                                            for host in group['host']])
        self.begin = {name: np.cumsum(mask.sum(1)) - mask.sum(1) for name, mask in self.there.items()}
        edges = {(f[NEXT[k]], f[LAST[k]]): i for i, f in enumerate(self.facets) for k in range(3)}
        self.across = np.array([[edges.get((f[LAST[k]], f[NEXT[k]]), -1) for k in range(3)]
                                for f in self.facets])  # facet across the edge opposite to corner k
        self.rim = self.across < 0
        self.edge = float(np.median(np.linalg.norm(
            run.x0[self.facets[:, 0]] - run.x0[self.facets[:, 1]], axis=1)))

    def rows(self, name: str, k: int) -> Any:
        """What is written of an output time, a row for each of those that are there, of the others
        zeros; version 1 has rows of all."""
        data = self.group.get(name)
        if data is None or data.ndim == (2 if name in ('offset', 'lift') else 3):
            return None if data is None else data[k]
        there, begin = self.there[name][k], self.begin[name][k]
        full = np.zeros((len(there),) + data.shape[1:])
        full[there] = data[begin:begin + int(there.sum())]
        return full

    def where(self, p: Points, host: Array, tip: Array, x: Array) -> tuple[Array, ...]:
        """Places of the master at (xi, eta) of facets, tangents there, normals (those of a patch
        with their slopes), and the shape functions of the six nodes."""
        flat, slope = triangle(tip, 3)
        corners, bent = x[self.facets[host]], self.curved[host]
        n, dn = (np.concatenate([v, np.zeros_like(v)], 1) for v in (flat, slope))
        six = np.concatenate([corners, np.where(bent[:, None, None], x[self.middles[host]], 0)], 1)
        if bent.any() and self.round:
            r = six[:, :3] - six[:, 3:]
            y, dy = np.einsum('na,nad->nd', flat, r), np.einsum('nai,nad->nid', slope, r)
            s = np.linalg.norm(r[:, 0], axis=1) / np.linalg.norm(y, axis=1)
            ds = -s[:, None] * np.einsum('nd,nid->ni', y, dy) / dot(y, y)[:, None]
            n = np.concatenate([s[:, None] * flat, (1 - s)[:, None] * flat], 1)
            turn = flat[:, :, None] * ds[:, None, :]
            dn = np.concatenate([s[:, None, None] * slope + turn,
                                 (1 - s)[:, None, None] * slope - turn], 1)
        elif bent.any():
            n6, dn6 = triangle(tip, 6)
            n, dn = np.where(bent[:, None], n6, n), np.where(bent[:, None, None], dn6, dn)
        xm, t = np.einsum('na,nad->nd', n, six), np.einsum('nai,nad->nid', dn, six)
        normal, turn = cross(t[:, 0], t[:, 1]), np.zeros_like(t)
        if p.patch is not None:
            edge, corner = np.einsum('ndc,nskc->snkd', frame_of(corners),
                                     p.patch[host].reshape(-1, 2, 3, 3))
            xm = xm - np.einsum('nk,nkd->nd', flat[:, NEXT] * flat[:, LAST], edge)
            dq = slope[:, NEXT] * flat[:, LAST, None] + slope[:, LAST] * flat[:, NEXT, None]
            t = t - np.einsum('nki,nkd->nid', dq, edge)
            normal, turn = np.einsum('na,nad->nd', flat, corner), np.einsum('nai,nad->nid', slope, corner)
        return xm, t, normal, turn, n

    def slave(self, p: Points, at: Array, x: Array) -> Array:
        """Places of the slave points."""
        nodes = x[p.nodes[at]]
        s = np.einsum('nb,nbd->nd', p.weight[at], nodes)
        return s + p.lift[at, None] * frame_of(nodes[:, :3])[:, :, 2] if p.lift.any() else s

    def project(self, p: Points, at: Array, s: Array, x: Array) -> tuple[Array, ...]:
        """Projections of slave points: (xi, eta), gap, unit normal, and whether they are there: far off
        a curved facet there may be none."""
        host, xi, lift = p.host[at], p.tip[at], np.zeros(len(s))
        with np.errstate(all='ignore'):
            for _ in range(60):
                xm, t, normal, turn, _n = self.where(p, host, xi, x)
                a, b = np.moveaxis(t + lift[:, None, None] * turn, 1, 0)
                # normals that follow the facet count to first order: a secant of Newton's method
                rest, across = s - xm - lift[:, None] * normal, cross(a, b)
                step = np.stack([dot(rest, cross(b, normal)), dot(rest, cross(normal, a)),
                                 dot(rest, across)], 1) / dot(across, normal)[:, None]
                xi, lift = xi + step[:, :2], lift + step[:, 2]
                if not (np.abs(step[:, :2]) >= 1e-13).any():
                    break
            xm, t, normal, turn, _n = self.where(p, host, xi, x)
            there = (shares(xi).min(1) > -0.25) | (p.patch is None)
            found = there & (np.abs(step[:, :2]).max(1) < 1e-9) & (np.linalg.norm(normal, axis=1) > 0)
            gap = dot(s - xm, unit(normal))
        return xi, np.where(np.isfinite(gap), gap, p.gap[at]), unit(normal), found

    def lay_of(self, p: Points, at: Array, xi: Array, e: Array, s: Array, x: Array) -> Array:
        """The axis of mu1 at the points, shorter where there is none."""
        host = p.host[at]

        def direction(y: Array) -> Array:
            arm = y - self.origin
            if self.lay_kind == FIELD:
                return np.asarray(self.group['facet_axis'][host])
            if self.lay_kind == CIRCUMFERENTIAL:
                return cross(self.axis, arm)
            if self.lay_kind == RADIAL:
                return arm - dot(arm, self.axis)[:, None] * self.axis
            return np.broadcast_to(self.axis, y.shape)

        def turned(v: Array, n: Array) -> Array:
            v = v - dot(v, n)[:, None] * n
            return np.cos(self.angle) * v + np.sin(self.angle) * cross(n, v)

        if not self.convected:
            return unit(turned(direction(s), e))
        corners = self.run.x0[self.facets[host]]
        old, (share, _) = frame_of(corners), triangle(xi, 3)
        v = turned(direction(s), old[:, :, 2])
        if self.lay_kind in (CIRCUMFERENTIAL, RADIAL):
            v = np.sum([share[:, k, None] * turned(direction(corners[:, k]), old[:, :, 2])
                        for k in range(3)], axis=0)
        c = np.linalg.solve(old, np.asarray(v)[..., None])[:, :2, 0]
        return unit(np.einsum('ni,nid->nd', c, self.where(p, host, xi, x)[1]))

    def add_lay(self, x: Array, mean: Array) -> None:
        """Adds the axes of the facets at their corners, no numbers where one has none; the first counts
        where they disagree about its sign."""
        probe: Any = SimpleNamespace(host=np.arange(len(self.facets)), patch=None)
        corners = x[self.facets]
        axes = np.stack([self.lay_of(probe, probe.host, np.full((len(corners), 2), place), frame_of(
            corners)[:, :, 2], corners[:, k], x) for k, place in enumerate(np.eye(3)[:, :2])], 1)
        axes[~(np.linalg.norm(axes, axis=2) > 0.5)] = np.nan
        for nodes, three in zip(self.facets, axes):
            for n, axis in zip(nodes, three):
                mean[n] += -axis if mean[n] @ axis < 0 else axis

    def forces(self, p: Points, x: Array) -> tuple[Array, Array]:
        """Forces of the points on all nodes: on the slave's, and on the master's at the apexes
        (with MORTar at the projections)."""
        here, there, at, f = np.zeros_like(x), np.zeros_like(x), p.at, p.force[p.at]
        slave = p.weight[at][:, :, None] * f[:, None, :]
        if p.lift.any():
            slave[:, :3] += normal_share(x[p.nodes[at, :3]], p.lift[at], f)
        np.add.at(here, p.nodes[at], slave)
        host, tip = p.host[at], p.tip[at]
        if self.points == MORTAR:
            tip = self.project(p, at, self.slave(p, at, x), x)[0]
        xm, _, _, _, n = self.where(p, host, tip, x)
        corners, bent = x[self.facets[host]], self.curved[host]
        master = n[:, :3, None] * f[:, None]
        if p.patch is not None:
            w = np.linalg.solve(frame_of(corners), (xm - np.einsum('na,nad->nd', n[:, :3], corners))
                                [..., None])[..., 0]
            master += normal_share(corners, w[:, 2], f)
            master[:, :2] += w[:, :2, None] * f[:, None]
            master[:, 2] -= (w[:, 0] + w[:, 1])[:, None] * f
        np.add.at(there, self.facets[host], -master)
        np.add.at(there, self.middles[host[bent]], -n[bent, 3:, None] * f[bent, None])
        return here, there

    def faces(self, p: Points) -> Array:
        """Faces of the master for multipliers: facets that hang together without a kink."""
        edges = {(nodes[k], nodes[NEXT[k]]): (f, k) for f, nodes in enumerate(self.facets)
                 for k in range(3)}
        every = np.repeat(np.arange(len(self.facets)), 3)
        middle = np.tile([[0.5, 0.5], [0, 0.5], [0.5, 0]], (len(self.facets), 1))
        normal = unit(self.where(p, every, middle, self.run.x0)[2]).reshape(-1, 3, 3)
        face, limit = np.arange(len(self.facets)), 0.7 if self.curved.any() else 0.9
        for (a, b), here in edges.items():
            there = edges.get((b, a))
            if there is not None and dot(normal[here], normal[there]) > limit:
                face[face == face[there[0]]] = face[here[0]]
        return face
