"""mfec-post adapt: runs, estimates and remeshes until a number is known to the accuracy that is asked for.

Three errors are told apart, of the mesh, of the penalty and of the increments (doc/theory,
"Error of a result"), and what is larger is mended.
"""
from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Optional

import mfec
import numpy as np
from mfec.run import launch

from .adapt_deck import LABEL, Goal, GoalError, own_names, prepare
from .adapt_estimate import estimate
from .adapt_model import Bodies, facets_of, raised, read_bodies, write_mesh
from .adapt_remesh import MeshError, Sag, by_gmsh, by_mmg, graded, matched, wanted_sizes
from .results import Results

SAFETY = 1.5
"""Times |Q| and the relative error of the stresses: the least bar."""
MOST_RATE = 0.8
"""The mesh of a loop is not believed to be worth less than this."""
ENOUGH_FACETS = 4.0
"""Facets across the contact from which on its differences say anything."""
MORE_FACETS = 1.25
"""Facets across the contact grow with the cells (where these gather at it), or a little less."""
LEAST_GROWTH, MOST_GROWTH = 2.0, 4.0
"""Times the cells of the loop before: the loops are a geometric series, of less than twice its last."""
GROWING = 0.1
"""Part of the penalty's share that contacts which grow may not have in proportion to 1/f."""
SHARE = 0.3
"""Penalty or increments are mended from this share of the wish on."""
FIELDS = 4
"""Output times whose errors shape the mesh, at most (doc/theory, eq. (13.11)); without friction the last."""
SOFTER = 4
"""A companion's penalty is softer by this factor: a stiffer one costs ten times the run."""
SMOOTH_EDGE = np.radians(45)
"""Facets that meet at a smaller angle are those of one smooth surface."""
MOST_LOOPS, MOST_PENALTY, MOST_INCREMENTS = 8, 64, 64


@dataclass
class Loop:
    """A run with what is known of its values. Bars are None where nothing can be said yet."""

    number: int
    cells: int
    penalty_factor: int
    increments: int
    relative: list[float]
    """What the error of the stresses makes of each value, over the value."""
    across: Optional[float]
    """Facets across the smallest contact."""
    raw: list[float]
    """As the run has them."""
    values: list[float]
    """Without the penalty's share, once a companion has told it."""
    mesh: Optional[list[float]] = None
    penalty: Optional[list[float]] = None
    steps: Optional[list[float]] = None
    sag: float = 0.0
    """Mean sag of flat facets where the contact is, over its mean penetration."""
    finer: list[float] = field(default_factory=list)
    """What twice the increments have changed: from then on the loop is that run."""
    rubs: bool = False
    """There was friction."""
    sticks: bool = False
    best: list[float] = field(default_factory=list)
    run_cpu: float = 0.0
    cpu: float = 0.0
    """All of it up to here, companions, meshes and estimates with it."""
    estimate_cpu: float = 0.0

    def bar(self, k: int) -> Optional[float]:
        """The bar of the value k."""
        if self.mesh is None or self.penalty is None or self.steps is None:
            return None
        return self.mesh[k] + self.penalty[k] + self.steps[k]


def add_options(command: argparse.ArgumentParser) -> None:
    """Options of `mfec-post adapt`."""
    command.add_argument('deck', help='the deck')
    command.add_argument('--goal', action='append', required=True,
                         help='set.R1 (reaction), pair:F1 (contact table), or a quotient; repeatable')
    command.add_argument('--error', default='1%', help='wish: half width of the bar over the value (1%%)')
    command.add_argument('--geo', help='geometry of the mesh (.geo, .step, .brep): gmsh makes the meshes')
    command.add_argument('--order', type=int, choices=(1, 2), default=2, help='nodes a cell: 4 or 10 (2)')
    command.add_argument('--set', action='append', default=[], help='name=value, as of mfec')
    command.add_argument('--time', type=float, default=600.0, help='seconds after which none begins (600)')
    command.add_argument('--out', help='folder (default: x_adapt)')


def cpu() -> float:
    """Processor seconds of this process and of its children."""
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


def wish_of(text: str) -> float:
    """1% or 0.01."""
    try:
        wish = float(text[:-1]) / 100 if text.endswith('%') else float(text)
    except ValueError:
        wish = 0.0
    if not 0.0 < wish < 1.0:
        raise GoalError(f'--error {text}: write a share such as 1% or 0.01')
    return wish


def rate(loop: Loop, last: Loop, k: int) -> float:
    """How much of the error of the loop before a mesh has left of the value k."""
    return min(loop.relative[k] / last.relative[k], MOST_RATE) if last.relative[k] > 0 else MOST_RATE


def mesh_bar(loop: Loop, change: float, last: Loop, k: int) -> float:
    """Bar of the mesh of a value that has changed since the loop before (doc/theory, eq. (13.13))."""
    q = rate(loop, last, k)
    value = loop.values[k]
    bars = [SAFETY * loop.relative[k] * abs(value), 1.5 * abs(change) * q / (1 - q)]
    if last.mesh is not None:
        bars.append(q * last.mesh[k])
    return max(bars)


def penalty_bar(share: float, value: float, sticks: bool) -> float:
    """What may be wrong with the penalty's share of a value (doc/theory, eq. (13.14))."""
    far = 4 * abs(share) / max(abs(value), 1e-300)
    return abs(share) * (1.0 if sticks else min(GROWING + far, 1.0))


def path_fields(results: Results, goals: Sequence[Goal], raw: Sequence[float],
                rubs: bool) -> tuple[np.ndarray, Optional[tuple[int, list[float]]]]:
    """Displacements at the last output time and, with friction, at some before it, in order, and how they
    have changed since the one at which the goals were least; which that was, and what they were."""
    count = min(FIELDS, results.steps) if rubs else 1
    frames = np.unique(np.linspace(results.steps - 1, 0, count).round()).astype(int)
    u = np.stack([results.point_field('displacement', k) for k in frames])
    if len(frames) < 2:
        return u, None
    past = [[goal.value(results, results.times[k]) for goal in goals] for k in frames[:-1]]
    shares = [sum(abs(a) / max(abs(b), 1e-300) for a, b in zip(values, raw)) for values in past]
    least = int(np.argmin(shares))
    return np.concatenate([u, u[-1:] - u[least]]), (least, past[least])


def relative_errors(errors: np.ndarray, raw: Sequence[float],
                    past: Optional[tuple[int, list[float]]]) -> list[float]:
    """Relative errors of values from those of the energies of path_fields: of the last output time, or of the
    one before and of what has come since, if these are larger (doc/theory, eq. (13.11))."""
    if past is None:
        return [float(errors[-1])] * len(raw)
    least, values = past
    return [float(max(errors[-2], (errors[least] * abs(a) + errors[-1] * abs(b - a)) / max(abs(b), 1e-300)))
            for a, b in zip(values, raw)]


Points = dict[str, dict[str, np.ndarray]]
"""The contact points of each pair at the last output time."""


def across_contact(results: Results, contacts: Points) -> Optional[float]:
    """Facets across the contact of the last output time, of the pair with the fewest. A direction counts
    where the contact ends before the slave surface does: where both end together nothing is missed."""
    x = np.zeros((results.node_numbers.max() + 1, 3))
    x[results.node_numbers] = results.points
    counts: list[float] = []
    for points in contacts.values():
        if 'area' not in points:
            continue
        active = (points['status'] > 0) & (points['area'] > 0)
        if not active.any():
            continue
        place = np.einsum('pn,pni->pi', points['weight'], x[points['node']])
        area = points['area'][active]
        edge = np.sqrt(area.sum() / len(np.unique(points['node'][active], axis=0)) * 4 / np.sqrt(3))
        spread, axes = np.linalg.eigh(np.cov(place[active].T, aweights=area, bias=True))
        free = np.ptp(place @ axes, axis=0) - np.ptp(place[active] @ axes, axis=0) > edge
        counts += [float(np.sqrt(12 * max(spread[k], 0.0)) / edge) for k in (1, 2) if free[k]]
    return min(counts, default=None)


def sag_of(bodies: Bodies, names: set[str]) -> float:
    """How far a smooth surface through flat facets would rise above them, at most."""
    sag = 0.0
    for name in names & set(bodies.surfaces):
        facets = bodies.surfaces[name]
        a, b, c = (bodies.points[facets[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        order = np.lexsort(edges.T)
        edges, owner = edges[order], order // 3
        twin = np.flatnonzero((edges[1:] == edges[:-1]).all(1))
        turn = np.arccos(np.clip(np.einsum('ij,ij->i', normal[owner[twin]], normal[owner[twin + 1]]), -1, 1))
        length = np.linalg.norm(a - b, axis=1)[owner[twin]]
        smooth = turn < SMOOTH_EDGE
        sag = max([sag, *(turn * length / 8)[smooth]])
    return sag


def outward(bodies: Bodies, facets: np.ndarray) -> np.ndarray:
    """Normals of facets that point out of their body; their length is twice the area."""
    a, b, c = (bodies.points[facets[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    corners, cells, _ = facets_of(bodies.cells)
    number = len(bodies.points) ** np.arange(3)
    keys = np.sort(corners, axis=1) @ number
    order = np.argsort(keys)
    cell = cells[order[np.searchsorted(keys, np.sort(facets, axis=1) @ number, sorter=order)]]
    inside = bodies.points[bodies.cells[cell, :4]].mean(1) - a
    return np.where(np.einsum('ij,ij->i', normal, inside)[:, None] > 0, -normal, normal)


def mean_sag(bodies: Bodies, name: str, places: np.ndarray) -> float:
    """How far, in the mean, the smooth surface lies outside the facets near some places; negative for
    hollow ones (doc/theory, eq. (13.15))."""
    facets = bodies.surfaces[name]
    normal = outward(bodies, facets)
    area = np.linalg.norm(normal, axis=1) / 2
    normal /= 2 * area[:, None]
    x = bodies.points[facets]
    middle, length = x.mean(1), np.linalg.norm(x[:, [1, 2, 0]] - x, axis=2)
    edges = np.sort(facets[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    order = np.lexsort(edges.T)
    twin = np.flatnonzero((edges[order[1:]] == edges[order[:-1]]).all(1))
    one, other = order[twin] // 3, order[twin + 1] // 3
    turn = normal[other] - normal[one]
    bend = 2 * np.arcsin(np.clip(np.linalg.norm(turn, axis=1) / 2, 0, 1))
    bend *= (bend < SMOOTH_EDGE) * np.sign(np.einsum('ij,ij->i', turn, middle[other] - middle[one]))
    bend *= length.ravel()[order[twin]]
    total, sides = np.zeros(len(facets)), np.zeros(len(facets))
    for ends in (one, other):
        np.add.at(total, ends, bend)
        np.add.at(sides, ends, 1.0)
    squares = (length ** 2).sum(1)
    sag = total * 3 / np.maximum(sides, 1) / (2 * area) * squares / 48
    near = np.array([((places - m) ** 2).sum(1).min() < s / 3 for m, s in zip(middle, squares)])
    told = near & (sides == 3) if (near & (sides == 3)).any() else near
    return float(np.average(sag[told], weights=area[told])) if told.any() else 0.0


def bent_sag(sags: Sequence[Sag], places: np.ndarray) -> float:
    """What facets of six nodes change of the gap at some places, in the mean: the sags of both sides, which
    lie on each other, take each other away."""
    ways = np.zeros((len(sags), len(places), 3))
    normal = np.zeros((len(places), 3))
    for way, sag in zip(ways, sags):
        away = ((places[:, None] - sag.places) ** 2).sum(-1)
        near = away.argmin(1)
        close = away[np.arange(len(places)), near] < 2 * sag.areas[near]
        way[close] = (sag.ways[:, None] * sag.normals)[near[close]]
        first = close & ~normal.any(1)
        normal[first] = sag.normals[near[first]]
        way[close & ~first] *= -1  # the other side
    return float(np.einsum('spi,pi->p', ways, normal).mean()) if len(sags) else 0.0


def mean_sags(bodies: Bodies, names: Sequence[str], places: np.ndarray) -> list[float]:
    """The mean sag of each of some surfaces near some places."""
    return [mean_sag(bodies, name, places) for name in names]


def sag_over_penetration(results: Results, contacts: Points,
                         sides: Mapping[str, Callable[[np.ndarray], Sequence[float]]]) -> float:
    """The largest mean sag at a contact over its mean penetration; of the worst pair. `sides` gives the sags
    of its surfaces near some places."""
    x = np.zeros((results.node_numbers.max() + 1, 3))
    x[results.node_numbers] = results.points
    ratios = [0.0]
    for pair, sags in sides.items():
        points = contacts[pair]
        active = points['status'] > 0
        area = points['area'][active] if 'area' in points else np.zeros(active.sum())
        depth = -(points['gap'][active] * area).sum()
        if depth > 0.0:
            places = np.einsum('pn,pni->pi', points['weight'], x[points['node']])[active]
            ratios.append(max(map(abs, sags(places)), default=0.0) * area.sum() / depth)
    return max(ratios)


class Adaptation:
    """All loops of one deck."""

    def __init__(self, given: argparse.Namespace, tell: Callable[[str], None] = print):
        self.tell = tell
        self.goals = [Goal(text) for text in given.goal]
        self.wish = wish_of(given.error)
        self.order, self.limit = given.order, given.time
        self.geometry = Path(given.geo).resolve() if given.geo else None
        self.path = Path(given.deck)
        self.out = Path(given.out or self.path.stem + '_adapt')
        self.sets = dict(word.split('=', 1) for word in given.set)
        self.loops: list[Loop] = []
        self.notes: list[str] = []
        self.penalty_factor = self.increments = 1
        self.share = 0.6 if self.geometry else 1.0
        self.began, self.cpu = time.monotonic(), cpu()
        self.estimate_cpu = 0.0
        self.eta = np.zeros(0)
        self.sags = False
        self.bent: list[Sag] = []

    # The meshes

    def start(self) -> Bodies:
        """The deck's mesh as the first; the deck of the runs."""
        self.out.mkdir(parents=True, exist_ok=True)
        original = mfec.Deck.read(self.path)
        launch(original, ['--check'], self.sets, self.out / 'given', None, None)
        bodies = read_bodies(str(self.out / 'given' / (self.path.stem + '.check.vtkhdf')))
        self.deck, self.notes = prepare(original, set(bodies.surfaces), self.order, self.geometry is None)
        self.own = own_names(self.deck)
        self.pairs = [r for word in ('NTOS', 'GTOS') for r in self.deck.records(word)]
        self.own_order = bodies.order
        self.tell_limits(bodies)
        return raised(bodies) if self.order == 2 else bodies

    def tell_limits(self, bodies: Bodies) -> None:
        """What no number here knows of."""
        elastic = [bodies.materials[int(m)] for m in np.unique(bodies.material)]
        if any(m.finite for m in elastic):
            self.notes.append('finite strain: the stresses of small strain shape the mesh; the bar rests '
                              'on the differences of loops')
        if any(m.poisson >= 0.45 for m in elastic if not m.rigid):
            self.notes.append('nearly incompressible: pressures weigh too much in the estimate')
        if any(m.rigid for m in elastic):
            self.notes.append('rigid regions keep their meshes, and count as exact')

    def judge_sag(self, results: Results, contacts: Points, bodies: Bodies, u: np.ndarray) -> float:
        """Facets of round surfaces: their sag over the penetration, where it counts; flat ones are said."""
        if self.geometry is not None and self.order == 2:
            return sag_over_penetration(results, contacts, dict.fromkeys(
                contacts, lambda places: [bent_sag(self.bent, places)])) if self.bent else 0.0
        names = {name for pair in self.sides(bodies) for name in pair}
        sag, way = sag_of(bodies, names), np.abs(u).max()
        text = 'facets of round contact surfaces sag'
        if sag > 0.01 * way and not any(text in note for note in self.notes):
            remedy = ('finer meshes keep it; give a geometry by --geo' if self.geometry is None else
                      'it falls with the mesh; elements of ten nodes have none')
            self.notes.append(f'{text} by up to {sag:.2g} where bodies move by {way:.2g}: no stress tells '
                              f'that error, and {remedy}')
        if not sag > 0.01 * way:
            return 0.0
        self.sags = True
        sides = self.sides(bodies)
        known = len(sides) == len(contacts)  # MORTar has no penetration to compare with
        sags = {pair: partial(mean_sags, bodies, names) for pair, names in zip(contacts, sides)}
        return sag_over_penetration(results, contacts, sags) if known else 0.0

    def write(self, bodies: Bodies, h: Optional[np.ndarray], folder: Path) -> Optional[Path]:
        """The mesh file of a loop; none where the deck's own mesh does."""
        folder.mkdir(parents=True, exist_ok=True)
        if self.geometry is not None:
            if h is None and self.order == self.own_order:
                return None
            path = folder / 'mesh.msh'
            h = graded(bodies, bodies.sizes) if h is None else h
            self.bent = by_gmsh(self.geometry, bodies, h, self.order, path)
            return path
        if h is not None:
            bodies = by_mmg(bodies, h, self.own, folder)
            bodies = raised(bodies) if self.order == 2 else bodies
        path = folder / 'mesh.inp'
        write_mesh(bodies, path, self.own, LABEL)
        return path

    def sides(self, bodies: Bodies) -> list[tuple[str, str]]:
        """Slave and master of each pair, where both are surfaces of the mesh."""
        names = [tuple(item.strip('\'"') for item in r.items[1:3]) for r in self.pairs]
        return [(a, b) for a, b in names if a in bodies.surfaces and b in bodies.surfaces]

    def factor(self, loop: Loop) -> float:
        """How many times the cells of a loop the next should have."""
        bars = loop.mesh or [SAFETY * r * abs(v) for r, v in zip(loop.relative, loop.values)]
        worst = max(b / (0.4 * self.wish * abs(v)) if v else 1.0 for b, v in zip(bars, loop.values))
        facets = ENOUGH_FACETS / loop.across if loop.across else 1.0
        growth = max(worst ** (1.5 / self.order), MORE_FACETS * facets)
        return float(np.clip(growth, LEAST_GROWTH, MOST_GROWTH))

    # The runs

    def run(self, folder: Path, mesh: Optional[Path], factor: float, increments: int) -> Path:
        """One run; its results file."""
        words = ['--mesh', str(mesh.resolve())] if mesh else []
        words += ['--penalty-factor', f'{factor:g}'] if factor != 1 else []
        words += ['--increments', str(increments)] if increments != 1 else []
        launch(self.deck, words, self.sets, folder, None, None)
        return folder / (self.path.stem + '.vtkhdf')

    def solve(self, number: int, mesh: Optional[Path]) -> tuple[Loop, Bodies]:
        """A run with its estimate."""
        begin = cpu()
        path = self.run(self.out / str(number), mesh, self.penalty_factor, self.increments)
        run_cpu, begin = cpu() - begin, cpu()
        bodies = read_bodies(str(path))
        with Results(str(path)) as results:
            table = results.history('contact')
            sticks, rubs = (any(np.abs(table.get(name, np.zeros(1))) > 0) for name in ('stick', 'Ft'))
            contacts = {pair: results.contact(pair) for pair in results.pairs}
            across = across_contact(results, contacts)
            raw = [goal.value(results) for goal in self.goals]
            u, past = path_fields(results, self.goals, raw, rubs)
            sag = self.judge_sag(results, contacts, bodies, u)
        eta, energy = estimate(bodies, u)
        if not energy.max() > 0.0:
            raise GoalError('no body is strained at the output times looked at: nothing to estimate')
        told = energy > 1e-12 * energy.max()
        self.eta = (eta[told] / energy[told, None]).max(0)
        relative = relative_errors(np.where(told, eta.sum(1) / np.where(told, energy, 1.0), 0.0), raw, past)
        self.estimate_cpu += cpu() - begin
        loop = Loop(number, len(bodies.cells), self.penalty_factor, self.increments,
                    relative, across, raw, list(raw), rubs=rubs, sticks=sticks,
                    run_cpu=run_cpu, sag=sag)
        return loop, bodies

    def companions(self, loop: Loop, last: Loop, mesh: Optional[Path]) -> None:
        """What the penalty takes, by a run with a softer one: the values lose it (doc/theory, eq. (13.14)).
        What the increments take, by a run with twice as many, the first time."""
        folder = self.out / str(loop.number)
        zero = [0.0] * len(self.goals)
        loop.penalty, loop.steps = zero, zero
        if self.pairs:
            soft = self.accompany(folder / 'soft', mesh, self.penalty_factor / SOFTER, self.increments)
            share = [(a - b) / (SOFTER - 1) for a, b in zip(loop.raw, soft)]
            loop.values = [a + b for a, b in zip(loop.raw, share)]
            loop.penalty = [penalty_bar(b, value, loop.sticks) for b, value in zip(share, loop.values)]
        if last.steps is not None:
            loop.steps = [b * last.increments / loop.increments for b in last.steps]
        elif loop.rubs:
            begin = cpu()
            fine = self.accompany(folder / 'fine', mesh, self.penalty_factor, 2 * self.increments)
            loop.run_cpu = cpu() - begin
            loop.finer = [a - b for a, b in zip(fine, loop.raw)]

    def accompany(self, folder: Path, mesh: Optional[Path], factor: float, increments: int) -> list[float]:
        """The goals of a run beside that of a loop."""
        with Results(str(self.run(folder, mesh, factor, increments))) as results:
            return [goal.value(results) for goal in self.goals]

    # The loop

    def adapt(self) -> bool:
        """Loops until all bars are within the wish; whether they are."""
        bodies = self.start()
        mesh = self.write(bodies, None, self.out / '0')
        loop, bodies = self.solve(0, mesh)
        self.keep(loop)
        before, remesh, late = loop.raw, True, self.is_late(0)
        while not self.is_met(loop):
            if late or self.is_late(loop.number):
                return False
            number, last = loop.number + 1, loop
            if remesh:
                asked = self.factor(last)
                sides = self.sides(bodies)
                sides += [(b, a) for a, b in sides] if self.sags else []  # of like facets the sags cancel
                h = matched(bodies, wanted_sizes(bodies, self.eta, asked / self.share), sides)
                mesh = self.write(bodies, h, self.out / str(number))
            loop, bodies = self.solve(number, mesh)
            if remesh:
                self.share = float(np.clip(self.share * loop.cells / last.cells / asked, 0.3, 2.0))
            late = self.is_late(number)
            self.judge(loop, last, before, mesh, remesh, late)
            self.keep(loop)
            before, remesh = self.mend(loop)
        return True

    def judge(self, loop: Loop, last: Loop, before: Sequence[float], mesh: Optional[Path],
              remeshed: bool, late: bool = False) -> None:
        """The bars of a loop, where its contact is fine enough for any. Companions run once the mesh alone is
        good enough, or where it is the last."""
        if loop.across is not None and loop.across < ENOUGH_FACETS:
            return
        n = range(len(self.goals))
        if last.penalty is None:
            loop.mesh = [mesh_bar(loop, loop.raw[k] - before[k], last, k) for k in n]
            if not late and any(b > self.wish * abs(v) for b, v in zip(loop.mesh, loop.raw)):
                return
        self.companions(loop, last, mesh)
        if not remeshed:
            loop.mesh, loop.best = last.mesh, list(loop.values)
            return
        now = loop.raw if last.penalty is None else loop.values
        sag = [loop.sag * abs(loop.values[k] - loop.raw[k]) for k in n]
        self.sags |= any(b > SHARE * self.wish * abs(v) for b, v in zip(sag, loop.values))
        loop.mesh = [mesh_bar(loop, now[k] - before[k], last, k) + sag[k] for k in n]
        q = [rate(loop, last, k) for k in n]
        loop.best = [loop.values[k] + (now[k] - before[k]) * q[k] / (1 - q[k]) for k in n]
        if loop.finer:
            self.become_finer(loop)

    def become_finer(self, loop: Loop) -> None:
        """The companion of twice the increments takes the place of the loop's run: what it has left is,
        in first order, what it has changed."""
        loop.increments *= 2
        loop.steps = [abs(change) for change in loop.finer]
        loop.values = [a + b for a, b in zip(loop.values, loop.finer)]
        loop.best = [a + b for a, b in zip(loop.best, loop.finer)]

    def mend(self, loop: Loop) -> tuple[list[float], bool]:
        """Raises penalty or increments where they are the larger part. The values of this loop as the next
        has to be compared with; whether the next mesh is another."""
        if loop.penalty is None or loop.steps is None or loop.mesh is None:
            return list(loop.values), True
        parts = list(zip(loop.mesh, loop.penalty, loop.steps, (self.wish * abs(v) for v in loop.values)))
        if any(p > SHARE * w and p >= m for m, p, _, w in parts) and self.penalty_factor < MOST_PENALTY:
            self.penalty_factor *= SOFTER
        while self.increments < min(2 * loop.increments, MOST_INCREMENTS) and any(
                s > SHARE * w and s >= m for m, s, w in (
                    (m, s * loop.increments / self.increments, w) for m, _, s, w in parts)):
            self.increments *= 2
        raised = self.penalty_factor > loop.penalty_factor or self.increments > loop.increments
        back = loop.finer if self.increments < loop.increments else []
        before = [a - b for a, b in zip(loop.values, back)] if back else list(loop.values)
        return before, not raised or any(m > 0.5 * w for m, _, _, w in parts)

    def is_late(self, number: int) -> bool:
        """No loop begins after this one."""
        return number + 1 >= MOST_LOOPS or time.monotonic() - self.began > self.limit

    def is_met(self, loop: Loop) -> bool:
        """All bars are within the wish."""
        return all((bar := loop.bar(k)) is not None and bar <= self.wish * abs(v)
                   for k, v in enumerate(loop.values))

    # What is said and written

    def keep(self, loop: Loop) -> None:
        """A loop that is done: its line, and the files as they are now."""
        loop.cpu, loop.estimate_cpu = cpu() - self.cpu, self.estimate_cpu
        self.loops.append(loop)
        self.tell(f'loop {loop.number}: {loop.cells} elements, {loop.cpu:.1f} s of processor'
                  + (f', {loop.across:.1f} facets across the contact: too few for a bar'
                     if loop.across is not None and loop.across < ENOUGH_FACETS else ''))
        for line in self.lines(loop):
            self.tell('  ' + line)
        self.write_files()

    def lines(self, loop: Loop) -> list[str]:
        """The values of a loop with their bars."""
        lines = []
        for k, (goal, value) in enumerate(zip(self.goals, loop.values)):
            bar = loop.bar(k)
            if bar is None:
                part = f': {loop.mesh[k]:.2g} of the mesh alone' if loop.mesh is not None else ''
                lines.append(f'{goal.text} = {value:.6g}, no bar yet{part}')
                continue
            assert loop.mesh is not None and loop.penalty is not None and loop.steps is not None
            digits = max(1, 2 - int(np.floor(np.log10(max(bar, 1e-300) / max(abs(value), 1e-300)))))
            parts = [part[k] * (part[k] > bar / 1000) for part in (loop.mesh, loop.penalty, loop.steps)]
            lines.append(f'{goal.text} = {value:.{digits}g} +- {bar:.2g}    mesh {parts[0]:.2g}  penalty '
                         f'{parts[1]:.2g}  increments {parts[2]:.2g}')
        return lines

    def write_files(self) -> None:
        """adapt.json and adapt.txt."""
        record = {'deck': str(self.path), 'goals': [goal.text for goal in self.goals], 'wish': self.wish,
                  'met': self.is_met(self.loops[-1]), 'notes': self.notes,
                  'loops': [{**asdict(loop), 'bars': [loop.bar(k) for k in range(len(self.goals))]}
                            for loop in self.loops]}
        (self.out / 'adapt.json').write_text(json.dumps(record, indent=1) + '\n', encoding='utf-8')
        head = ' loop  elements penalty increments   cpu'
        rows = [f'{head}  values with bars']
        for loop in self.loops:
            for k, line in enumerate(self.lines(loop)):
                start = (f'{loop.number:5d} {loop.cells:9d} {loop.penalty_factor:7d} '
                         f'{loop.increments:10d} {loop.cpu:5.1f}')
                rows.append((start if k == 0 else ' ' * len(head)) + '  ' + line)
        (self.out / 'adapt.txt').write_text('\n'.join(rows + self.notes) + '\n', encoding='utf-8')


def draw(loops: Sequence[Loop], goals: Sequence[str], wish: float, path: str) -> None:
    """Values with their bars and the three errors, against elements."""
    from matplotlib.figure import Figure
    figure = Figure(figsize=(8, 2.9 * len(goals)), layout='constrained')
    axes = figure.subplots(len(goals), 2, squeeze=False)
    for k, (left, right) in enumerate(axes):
        left.plot([loop.cells for loop in loops], [loop.values[k] for loop in loops], 'o-', color='0.6', ms=3)
        told = [loop for loop in loops if loop.bar(k) is not None]
        cells = [loop.cells for loop in told]
        left.errorbar(cells, [loop.values[k] for loop in told], [loop.bar(k) or 0.0 for loop in told],
                      fmt='o', capsize=4, color='C0')
        for label, bars in (('mesh', [loop.mesh for loop in told]),
                            ('penalty', [loop.penalty for loop in told]),
                            ('increments', [loop.steps for loop in told])):
            right.plot(cells, [(bar or goals)[k] for bar in bars], 'o-', ms=4, label=label)
        if told:
            right.axhline(wish * abs(told[-1].values[k]), color='0.6', ls='--', label='wish')
            right.set_yscale('symlog', linthresh=1e-4 * wish * max(abs(told[-1].values[k]), 1e-300))
            right.legend(fontsize=8)
        left.set(xlabel='elements', ylabel=goals[k])
        right.set(xlabel='elements', ylabel='error')
    figure.savefig(path, dpi=300)


def main(given: argparse.Namespace) -> int:
    """Exit code 0: the wish is met; 1: it is not, but the last bars hold; 2: not to be done."""
    try:
        work = Adaptation(given)
        met = work.adapt()
        draw(work.loops, [goal.text for goal in work.goals], work.wish, str(work.out / 'adapt.png'))
    except (GoalError, MeshError, mfec.MfecError, OSError, KeyError) as problem:
        text = problem.args[0] if isinstance(problem, KeyError) else problem
        print(f'mfec-post adapt: {text}', file=sys.stderr)
        return 2
    print()
    for line in work.lines(work.loops[-1]):
        print(line)
    last = work.loops[-1]
    print(f'{len(work.loops)} loops, {last.cells} elements, {last.cpu:.1f} s of processor; the last run '
          f'{last.run_cpu:.1f} s; in {work.out}: adapt.txt, adapt.json, adapt.png')
    for note in work.notes:
        print('note: ' + note)
    if not met:
        print(f'the wish of {100 * work.wish:g} % is not met: more --time, or more error')
    return 0 if met else 1
