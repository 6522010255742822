"""The contact points of a results file against Signorini's conditions and Coulomb's law.

Formulas as in doc/theory, "Contact kinematics" to "Discretisation of the interface"; the facet is
flat, quadratic, part of an exact sphere or cylinder, or a patch of smooth surfaces."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

from .proof_run import ROUND_OFF, Array, Ledger, Run, cross, triangle

CIRCUMFERENTIAL, RADIAL, FIELD = 2, 3, 4
SLIDES, OPEN = 2, 0
FIELDS = ('host', 'status', 'traction', 'gap', 'tip', 'lay', 'lay_traction', 'dissipation',
          'slip_path', 'start_tip', 'offset', 'lift', 'multiplier', 'patch')


def dot(a: Array, b: Array) -> Array:
    """Products of rows."""
    return np.einsum('...i,...i->...', a, b)


def unit(a: Array) -> Array:
    """Rows of length one."""
    size = np.linalg.norm(a, axis=-1, keepdims=True)
    return a / np.where(size > 0, size, 1)


def frame_of(x: Array) -> Array:
    """a1, a2 and the unit normal of flat facets, (n, component, vector)."""
    a1, a2 = x[:, 0] - x[:, 2], x[:, 1] - x[:, 2]
    return np.stack([a1, a2, unit(cross(a1, a2))], -1)


class Points:
    """The points of a pair at one end time."""

    def __init__(self, pair: Pair, k: int):
        group = pair.group
        take = {name: values[k] for name, values in group.items() if name in FIELDS}
        self.host = take['host'] - 1
        self.status, self.force = take['status'], take['traction']
        self.gap, self.tip, self.start = take['gap'], take['tip'], take['start_tip']
        self.lay, self.lay_force = take['lay'], take['lay_traction']
        self.dissipation, self.path = take['dissipation'], take['slip_path']
        zero = np.zeros(len(self.host))
        self.offset, self.lift = take.get('offset', zero), take.get('lift', zero)
        self.multiplier: Optional[Array] = take.get('multiplier')
        self.patch: Optional[Array] = take.get('patch')
        cells = pair.points == -1
        nodes = (group['node'][k] if cells else group['node']).reshape(len(self.host), -1)
        self.area = group['area'][k] if cells else group['area']
        there = (self.area > 0) | (not cells)  # the others are room for cells
        self.at = np.flatnonzero(there & (self.host >= 0))  # points with a facet
        self.nodes = pair.run.place[np.where(there[:, None], nodes, nodes.max())]
        if nodes.shape[1] > 1:
            self.weight = group['weight'][k] if cells else group['weight']
        else:
            self.weight = np.ones((len(self.host), 1))


class Pair:
    """One contact pair."""

    def __init__(self, run: Run, name: str, group: Any):
        self.run, self.name, self.group = run, name, group
        law = group['law'][0]
        self.points, self.smooth, self.augmented, self.round = (int(v) for v in law[:4])
        self.mu, self.rule, self.lay_kind = law[4:6], int(law[6]), int(law[7])
        self.axis, self.origin, self.angle = law[8:11], law[11:14], np.radians(law[14])
        self.convected, self.tolerance = law[15] > 0, law[16]
        self.penalty_kind, self.penalty, self.density = int(law[17]), law[18], law[19]
        self.decay, self.cap = law[20:23], law[23]
        self.offset_used = 'offset' in group
        self.facets = run.place[group['facets']]
        self.middles = np.full_like(self.facets, -1)
        if 'middles' in group:
            given = group['middles']
            self.middles = np.where(given > 0, run.place[given], -1)
        self.curved = (self.middles[:, 0] >= 0) if not self.smooth else np.zeros(
            len(self.facets), bool)
        self.edge = float(np.median(np.linalg.norm(
            run.x0[self.facets[:, 0]] - run.x0[self.facets[:, 1]], axis=1)))
        self.neighbour: dict[tuple[int, int], int] = {}
        for f, (a, b, c) in enumerate(self.facets):
            for edge in ((a, b), (b, c), (c, a)):
                self.neighbour[edge] = f

    def where(self, p: Points, host: Array, tip: Array, x: Array) -> tuple[Array, ...]:
        """Places of the master at (xi, eta) of facets, tangents there, normals (those of a patch
        with their slopes), and the shape functions of the six nodes."""
        flat, slope = triangle(tip, 3)
        corners = x[self.facets[host]]
        n = np.concatenate([flat, np.zeros_like(flat)], 1)
        dn = np.concatenate([slope, np.zeros_like(slope)], 1)
        middle = self.middles[host]
        bent = self.curved[host]
        six = np.concatenate([corners, np.where(bent[:, None, None], x[middle], 0)], 1)
        if bent.any() and self.round:
            r = six[:, :3] - six[:, 3:]
            p_, dp = np.einsum('na,nad->nd', flat, r), np.einsum('nai,nad->nid', slope, r)
            s = np.linalg.norm(r[:, 0], axis=1) / np.linalg.norm(p_, axis=1)
            ds = -s[:, None] * np.einsum('nd,nid->ni', p_, dp) / dot(p_, p_)[:, None]
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
            frame = frame_of(corners)
            v = p.patch[host]
            edge = np.einsum('ndc,nkc->nkd', frame, v[:, :9].reshape(-1, 3, 3))
            corner = np.einsum('ndc,nkc->nkd', frame, v[:, 9:].reshape(-1, 3, 3))
            i, j = [1, 2, 0], [2, 0, 1]
            xm = xm - np.einsum('nk,nkd->nd', flat[:, i] * flat[:, j], edge)
            dq = slope[:, i] * flat[:, j, None] + slope[:, j] * flat[:, i, None]
            t = t - np.einsum('nki,nkd->nid', dq, edge)
            normal = np.einsum('na,nad->nd', flat, corner)
            turn = np.einsum('nai,nad->nid', slope, corner)
        return xm, t, normal, turn, n

    def slave(self, p: Points, at: Array, x: Array) -> Array:
        """Places of the slave points."""
        nodes = x[p.nodes[at]]
        s = np.einsum('nb,nbd->nd', p.weight[at], nodes)
        if p.lift.any():
            s = s + p.lift[at, None] * frame_of(nodes[:, :3])[:, :, 2]
        return s

    def project(self, p: Points, at: Array, s: Array, x: Array) -> tuple[Array, ...]:
        """Projections of slave points: (xi, eta), gap, unit normal, and whether they are there."""
        host, xi, lift = p.host[at], p.tip[at], np.zeros(len(s))
        for _ in range(60):
            xm, t, normal, turn, _n = self.where(p, host, xi, x)
            jacobian = np.stack([t[:, 0] + lift[:, None] * turn[:, 0],
                                 t[:, 1] + lift[:, None] * turn[:, 1], normal], -1)
            step = np.linalg.solve(jacobian, (s - xm - lift[:, None] * normal)[..., None])[..., 0]
            # normals that follow the facet count to first order: a secant of Newton's method
            xi, lift = xi + step[:, :2], lift + step[:, 2]
            if not (np.abs(step[:, :2]) >= 1e-13).any():
                break
        inside = np.minimum(xi.min(1), 1 - xi.sum(1)) > -0.25
        size = np.linalg.norm(normal, axis=1)
        xm, t, normal, turn, _n = self.where(p, host, xi, x)
        return xi, dot(s - xm, unit(normal)), unit(normal), (np.abs(step[:, :2]).max(1) < 1e-9) & (
            inside | (p.patch is None)) & (size > 0)

    def lay_of(self, p: Points, at: Array, xi: Array, e: Array, s: Array, x: Array) -> Array:
        """The axis of mu1 at the points, not a number where a file does not say."""
        host = p.host[at]

        def direction(y: Array) -> Array:
            if self.lay_kind == FIELD:
                return np.asarray(self.group['facet_axis'][host])
            arm = y - self.origin
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
        old = frame_of(corners)
        share, _ = triangle(xi, 3)
        if self.lay_kind in (CIRCUMFERENTIAL, RADIAL):
            v = np.sum([share[:, k, None] * turned(direction(corners[:, k]), old[:, :, 2])
                        for k in range(3)], axis=0)
        else:
            v = turned(direction(s), old[:, :, 2])
        c = np.linalg.solve(old, np.asarray(v)[..., None])[:, :2, 0]
        t = self.where(p, host, xi, x)[1]
        return unit(np.einsum('ni,nid->nd', c, t))

    def forces(self, p: Points, x: Array) -> Array:
        """Forces of the points on all nodes: on the slave's, and at the apexes on the master's."""
        total = np.zeros_like(x)
        at, f = p.at, p.force[p.at]
        slave = p.weight[at][:, :, None] * f[:, None, :]
        if p.lift.any():
            slave[:, :3] += normal_share(x[p.nodes[at, :3]], p.lift[at], f)
        np.add.at(total, p.nodes[at], slave)
        host = p.host[at]
        xm, _, _, _, n = self.where(p, host, p.tip[at], x)
        corners = x[self.facets[host]]
        flat = np.einsum('na,nad->nd', n[:, :3], corners)
        if p.patch is not None:
            frame = frame_of(corners)
            w = np.linalg.solve(frame, (xm - flat)[..., None])[..., 0]
            extra = normal_share(corners, w[:, 2], f)
            extra[:, :2] += w[:, :2, None] * f[:, None]
            extra[:, 2] -= (w[:, 0] + w[:, 1])[:, None] * f
            np.add.at(total, self.facets[host], -extra)
        np.add.at(total, self.facets[host], -n[:, :3, None] * f[:, None])
        bent = self.curved[host]
        np.add.at(total, self.middles[host[bent]], -n[bent, 3:, None] * f[bent, None])
        return total

    def judge(self, ledger: Ledger, k: int, x: Array, before: Optional[tuple[Points, Array]],
              scale: float, cut: bool) -> tuple[Points, float]:
        """All lines of one end time; the energy of the penalty."""
        p = Points(self, k)
        closed = p.status > OPEN
        free = np.flatnonzero(~closed)
        ledger.judge('open points: no force', p.force[free] / max(scale, 1e-300), 1e-12)
        at = p.at
        s = self.slave(p, at, x)
        xi, gap, e, found = self.project(p, at, s, x)
        who = self.run.numbers[p.nodes[at, 0]]
        length = self.edge
        noise = 64 * ROUND_OFF * (self.run.size + float(np.abs(x).max())) / length
        gap = gap + p.offset[at]
        far = ~found | (np.abs(gap) > length)
        error, tolerance = np.abs(gap - p.gap[at]) / length, 1e-9 + noise
        sure = ~far & (closed[at] | (error <= tolerance))
        ledger.judge('gap', error[sure], tolerance, who[sure])
        ledger.leave('gap', 'open points that have passed to another facet since', (
            ~far & ~sure).sum())
        ledger.leave('gap', 'the projection is not on the curved facet', (far & closed[at]).sum())
        away = ~far & ~closed[at]
        ledger.judge('open points: no penetration', np.maximum(0, -gap)[away] / length, 1e-9 + noise,
                     who[away])
        at, xi, e, s, gap, who = (v[closed[at]] for v in (at, xi, e, s, gap, who))
        far = far[closed[p.at]]
        if not len(at):
            ledger.judge('closed without force', p.force[free] / max(scale, 1e-300), 1e-12)
            return p, 0.0
        force, host = -p.force[at], p.host[at]
        xm, t, *_ = self.where(p, host, p.tip[at], x)
        margin = np.minimum(p.tip[at].min(1), 1 - p.tip[at].sum(1))
        bound = 0.05 if self.points == -1 else 1e-2
        ledger.judge('tip inside its facet', np.maximum(0, -margin), bound, who)
        ledger.leave('tip inside its facet', 'beyond an edge by less than the tolerance', (
            margin < -2e-6).sum() if self.points != -1 else 0)
        eps = self.density * p.area[at] if self.points == -1 else self.group['epsilon'][at, 0]
        if self.points != -1:
            self.penalties(ledger, eps, p.area[at], who)
        # stretch of the gap: x_S - x_m(apex), and what is added along the normal
        g = s - xm + p.offset[at, None] * e
        shift = np.zeros_like(g)
        frame = frame_of(x[self.facets[host]])
        if p.multiplier is not None:
            axes = np.stack([unit(frame[:, :, 0]), cross(frame[:, :, 2], unit(frame[:, :, 0])),
                             frame[:, :, 2]], -1)
            shift = np.einsum('ndc,nc->nd', axes, p.multiplier[at])
            trial = eps[:, None] * g
            eps = eps * (dot(trial, force - shift).sum() / max(dot(trial, trial).sum(), 1e-300)
                         if np.abs(trial).max() > 1e-9 * scale else 1.0)
            ledger.judge('AUGMent: tips without gap', np.linalg.norm(g, axis=1) / length,
                         3 * self.tolerance if self.points == 0 else np.inf, who)
        largest = max(float(np.linalg.norm(force, axis=1).max()), scale * 1e-6, 1e-300)
        bad = np.linalg.norm(force - shift - eps[:, None] * g, axis=1) / (
            largest + eps * noise * length / 1e-8)
        ledger.judge('penalty law', bad[~far], 1e-5 if self.augmented else 1e-8, who[~far])
        normal = dot(force, e)
        ledger.judge('pressure, no tension', np.maximum(0, normal)[~far] / largest, 1e-12 + noise,
                     who[~far])
        if p.multiplier is None:
            ledger.judge('closed: no gap', np.maximum(0, gap)[~far] / length, 1e-10, who[~far])
        # the law of friction knows the pressure of the depth, which on curved facets is a little less
        depth = np.abs(p.lay_force[at, 2])
        if p.multiplier is None and not far.all():
            ledger.judge('pressure of the depth', ((depth - eps * np.abs(gap)) / (
                largest + eps * noise * length / 1e-9))[~far], 1e-9, who[~far])
        elif not (self.curved.any() or self.smooth):
            ledger.judge('pressure of the depth', (depth + normal) / largest, 1e-9, who)
        lay = self.lay_of(p, at, xi, e, s, x)
        tells = ~far & np.isfinite(lay).all(1) & (np.linalg.norm(lay, axis=1) > 0.5)
        if (self.mu[0] != self.mu[1]):
            ledger.judge('lay', (p.lay[at] - lay)[tells], 1e-9 + 1e3 * noise, np.repeat(who[tells], 3))
            ledger.leave('lay', 'no direction there', (~tells & ~far).sum())
        lay = p.lay[at]
        axes = np.stack([lay, cross(e, lay)], 1)
        self.friction(ledger, p, at, np.einsum('nid,nd->ni', axes, force), depth, axes, xm, x, eps,
                      noise, who, far, scale)
        if before is not None:
            self.history(ledger, p, before, at, who, cut, noise, scale, x, force, e)
        if self.points != 0 and self.points != 1:
            self.cover(ledger, p, x)
        across = np.linalg.norm(g - dot(g, e)[:, None] * e, axis=1)
        energy = 0.5 * np.linalg.norm(force, axis=1) * np.hypot(gap, across)
        return p, float(energy.sum())

    def penalties(self, ledger: Ledger, eps: Array, area: Array, who: Array) -> None:
        """The penalty that the deck gives."""
        if self.augmented or self.penalty_kind > 2:
            return
        want = self.penalty * (area if self.penalty_kind == 2 else np.ones(len(eps)))
        ledger.judge('penalty of the deck', eps / want - 1, 1e-12, who)

    def coefficients(self, p: Points, at: Array) -> Array:
        """Coefficients of friction at the points, (n, 2)."""
        mu = np.broadcast_to(self.mu, (len(at), 2))
        if self.decay[2] > 0:
            mu = self.decay[:2] + (mu - self.decay[:2]) * np.exp(-p.path[at] / self.decay[2])[:, None]
        return mu

    def friction(self, ledger: Ledger, p: Points, at: Array, f: Array, depth: Array, axes: Array,
                 xm: Array, x: Array, eps: Array, noise: float, who: Array, far: Array,
                 scale: float) -> None:
        """Cone and slip rule, (4.1) and (4.2)."""
        mu, length = self.coefficients(p, at), self.edge
        if self.cap > 0:
            depth = np.minimum(depth, self.cap * p.area[at] / mu.max(1))
        slides = p.status[at] == SLIDES
        works: Array = np.all(mu > 0, axis=1)
        largest = max(float(depth.max()), 1e-6 * scale, 1e-300)
        floor = largest + eps * noise * length / 1e-9
        size = np.sqrt((np.where(mu > 0, f / np.where(mu > 0, mu, 1), 0) ** 2).sum(1))
        ledger.judge('cone', (np.maximum(0, size - depth) / floor)[~far], 1e-8, who[~far])
        ledger.judge('cone where it slips', ((size - depth) / floor)[slides & works & ~far], 1e-8,
                     who[slides & works & ~far])
        ledger.judge('no friction without mu', np.where(mu > 0, 0, f)[~far] / largest, 1e-8)
        way = xm - self.where(p, p.host[at], p.start[at], x)[0]
        moved = np.einsum('nid,nd->ni', axes, way)
        ledger.judge('stick: the apex rests', np.linalg.norm(way, axis=1)[~slides] / length, 1e-12,
                     who[~slides])
        back = f * np.where(works[:, None], (mu.min(1)[:, None] / np.where(mu > 0, mu, 1))
                            ** self.rule, 0)
        far_enough = slides & works & ~far & (np.linalg.norm(moved, axis=1) > 1e4 * noise * length)
        ratio = np.linalg.norm(moved, axis=1) * np.linalg.norm(back, axis=1)
        ratio = np.where(ratio > 0, ratio, 1)
        # round-off of places turns the direction of short ways, and of small forces
        blur = noise * length * (1 / np.maximum(np.linalg.norm(moved, axis=1), 1e-300)
                                 + eps / np.maximum(np.linalg.norm(back, axis=1), 1e-300))
        beside = np.abs(moved[:, 0] * back[:, 1] - moved[:, 1] * back[:, 0]) / ratio
        bound = 1e-5
        against = np.maximum(0, -dot(moved, back) / ratio)
        ledger.judge('slip rule', (np.maximum(beside, against) / (1 + blur / bound))[far_enough],
                     bound, who[far_enough])

    def history(self, ledger: Ledger, p: Points, before: tuple[Points, Array], at: Array,
                who: Array, cut: bool, noise: float, scale: float, x: Array, force: Array,
                e: Array) -> None:
        """Start apexes against those of the end time before, work of friction, slip path."""
        old, x_old = before
        if cut:
            ledger.leave('history', 'the increment was cut, or fields are not of each one', len(at))
            return
        same = np.ones(len(at), bool)
        if self.points == -1:
            same = ((p.weight[at] == old.weight[at]).all(1) & (p.nodes[at] == old.nodes[at]).all(1)
                    & (p.area[at] == old.area[at]))
            ledger.leave('history', 'new cells of SEGMent', (~same).sum())
        closed = old.status[at] > OPEN
        ledger.leave('history', 'first touch: the place of closure is not in the file',
                     (same & ~closed).sum())
        kept = same & closed & (old.host[at] == p.host[at])
        # over an edge and back again costs digits, on curved facets those of two projections
        ledger.judge('history', (p.start[at] - old.tip[at])[kept],
                     1e-6 if self.smooth or self.curved.any() else 1e-10, np.repeat(who[kept], 2))
        crossed = np.flatnonzero(same & closed & (old.host[at] != p.host[at]))
        error, one = [], []
        for i in crossed:
            place = self.unfold(old.host[at[i]], p.host[at[i]], old.tip[at[i]], x_old)
            if place is not None:
                error.append(np.abs(place - p.start[at[i]]).max())
                one.append(who[i])
        ledger.judge('history over an edge', np.array(error), 1e-7, np.array(one))
        ledger.leave('history', 'over several edges, or a curved one', len(crossed) - len(error))
        way = self.where(p, p.host[at], p.tip[at], x)[0] - self.where(
            p, p.host[at], p.start[at], x)[0]
        tangent = force - dot(force, e)[:, None] * e
        work = dot(tangent, way)
        largest = max(float(np.abs(work).max()), float(np.abs(p.dissipation).max()) * 1e-6,
                      1e-4 * float((np.linalg.norm(force, axis=1)
                                    * np.linalg.norm(way, axis=1)).max()), 1e-300)
        ledger.judge('dissipation', ((p.dissipation - old.dissipation)[at] - work)[same] / largest,
                     1e-6, who[same])
        ledger.judge('dissipation, no gain', np.maximum(0, -work)[same] / largest, 1e-6, who[same])
        path = np.where(closed, old.path[at], 0) + np.linalg.norm(way, axis=1)
        # on a curved facet the law's slip is the way in the plane of the normal at the projection
        bend = 1e4 * np.linalg.norm(way, axis=1) if self.smooth or self.curved.any() else 0
        ledger.judge('slip path', ((p.path[at] - path) / (self.edge + bend))[same], 1e-9, who[same])

    def unfold(self, a: int, b: int, tip: Array, x: Array) -> Optional[Array]:
        """An apex of facet a in the next facet b, turned about their edge, (10.2)."""
        common = [n for n in self.facets[a] if n in self.facets[b]]
        if len(common) != 2 or self.smooth or self.curved[[a, b]].any():
            return None
        o, t = x[common[0]], unit(x[common[1]] - x[common[0]])
        place = np.append(tip, 1 - tip.sum()) @ x[self.facets[a]]
        e = frame_of(x[self.facets[[a, b]]])[:, :, 2]
        over = [cross(n, t) for n in e]
        middle = [x[self.facets[f]].mean(0) - o for f in (a, b)]
        over[0] *= -np.sign(over[0] @ middle[0])  # out of a, into b
        over[1] *= np.sign(over[1] @ middle[1])
        y = o + ((place - o) @ t) * t + ((place - o) @ over[0]) * over[1]
        corners = x[self.facets[b]]
        base = np.stack([corners[0] - corners[2], corners[1] - corners[2]], -1)
        return np.asarray(np.linalg.lstsq(base, y - corners[2], rcond=None)[0])

    def cover(self, ledger: Ledger, p: Points, x: Array) -> None:
        """Points of slave facets: never more than the facet, and exact where they cover it."""
        rows = np.concatenate([p.nodes, p.weight, p.area[:, None]], 1)[p.area > 0]
        if self.points > 0:  # on a master with folds each point stands three times
            rows = np.unique(rows, axis=0)
        if not len(rows):
            return
        count = p.nodes.shape[1]
        nodes, m, area = rows[:, :count].astype(int), rows[:, count:-1], rows[:, -1]
        keys, group = np.unique(nodes, axis=0, return_inverse=True)
        group = group.ravel()
        share = np.zeros(len(keys))
        corners = self.run.x0[keys[:, :3]]
        whole = 0.5 * np.linalg.norm(cross(corners[:, 0] - corners[:, 2],
                                              corners[:, 1] - corners[:, 2]), axis=1)
        np.add.at(share, group, area / whole[group])
        flat = np.ones(len(keys), bool)
        if count > 3:
            middle = 0.5 * (corners + corners[:, [1, 2, 0]])
            flat = np.abs(self.run.x0[keys[:, 3:]] - middle).max((1, 2)) < 1e-9 * self.edge
        who = self.run.numbers[keys[:, 0]]
        ledger.judge('cells: no overlap', np.maximum(0, share - 1)[flat], 1e-9, who[flat])
        ledger.leave('cells: no overlap', 'curved slave facets', (~flat).sum())
        full = flat & (np.abs(share - 1) < 1e-9)
        over = np.array([f for f in np.flatnonzero(flat & ~full)
                         if self.points > 0 or self.is_over(x[keys[f, :3]], x)], int)
        ledger.judge('cells: cover what is over', share[over] - 1, 1e-9, who[over])
        if count == 3:
            moments = np.zeros((len(keys), 3, 3))
            np.add.at(moments, group, (area / whole[group])[:, None, None]
                      * m[:, :, None] * m[:, None, :])
            ledger.judge('cells: exact on whole facets', (moments - (1 + np.eye(3)) / 12)[full], 1e-6)

    def is_over(self, corners: Array, x: Array) -> bool:
        """Whether a slave facet lies over the master with some room around it."""
        middle = corners.mean(0)
        around = middle + 1.3 * (np.concatenate(
            [corners, 0.5 * (corners + corners[[1, 2, 0]]), middle[None]]) - middle)
        master = x[self.facets]
        frame = frame_of(master)
        facing = frame[:, :, 2] @ frame_of(corners[None])[0, :, 2] < -0.5
        local = np.einsum('fij,pfj->pfi', np.linalg.inv(frame[facing]),
                          around[:, None] - master[facing, 2])
        inside = (local[..., :2].min(-1) >= 0) & (local[..., :2].sum(-1) <= 1)
        return bool((inside & (np.abs(local[..., 2]) < 0.1 * self.edge)).any(1).all())


def normal_share(x: Array, height: Array, f: Array) -> Array:
    """Forces at three corners that do the work of f on a height over them: a couple."""
    frame = frame_of(x)
    dual = np.linalg.inv(frame)
    along = np.einsum('nid,nd->ni', dual[:, :2], f)
    r = -(height[:, None] * along)[:, :, None] * frame[:, None, :, 2]
    return np.concatenate([r, -r.sum(1, keepdims=True)], 1)
