"""mfec-post check: an independent proof of a result, from its results file alone."""
from __future__ import annotations

import argparse
import hashlib
import json
import sys
from typing import Any

import numpy as np

from .proof_bulk import Bodies
from .proof_contact import MORTAR as AT_NODES
from .proof_contact import Pair, Points
from .proof_law import Judge
from .proof_lines import AUGMENTED, MORTAR, PLAIN, ROUND_OFF, Array, Ledger
from .proof_mortar import NodeJudge
from .proof_nodal import NodalStress
from .proof_run import Refusal, Run, cross
from .proof_smooth import Shapes
from .proof_touch import Ways


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument('results', help='results file (.vtkhdf)')
    parser.add_argument('--certificate', help='file to write the proof to (.json)')
    parser.add_argument('--quiet', action='store_true', help='the last line alone')


class Proof:
    """All lines of a results file."""

    def __init__(self, path: str):
        self.run, self.ledger = Run(path), Ledger()
        self.bodies = Bodies(self.run)
        plain = self.bodies.blocks and not any(block.form for block in self.bodies.blocks)
        self.nodal = NodalStress(self.run, self.bodies) if plain and 'nodal_stress' in self.run.vtk[
            'PointData'] else None
        self.pairs = [Pair(self.run, name, group) for name, group in self.run.pairs.items()]
        self.judges = [(NodeJudge if pair.points == AT_NODES else Judge)(pair, self.ledger)
                       for pair in self.pairs]
        self.shapes = [Shapes(pair) if pair.smooth else None for pair in self.pairs]
        if any(pair.augmented for pair in self.pairs):
            self.ledger.form = AUGMENTED
        if any(pair.points == AT_NODES for pair in self.pairs):
            self.ledger.form = MORTAR
        self.stiff = self.bodies.stiffest * self.run.shortest  # a force per length
        self.ways = Ways(self.run, all(block.law == 1 for block in self.bodies.blocks))
        self.last: tuple[float, Any] = (0.0, [np.zeros_like(self.run.x0)])  # its length, displacements
        for judge in self.judges:
            judge.motion = self.ways
        if not self.run.steps:
            self.ledger.leave('fields', 'no output time has fields')
        for k in range(self.run.steps):
            self.end_time(k)

    def end_time(self, k: int) -> None:
        """All lines of one output time."""
        run, ledger = self.run, self.ledger
        u, reaction = run.field('PointData', 'displacement', k), run.field('PointData', 'reaction', k)
        contact = len(run.contact.get('step', ())) > 0
        ledger.step = int(run.contact['step'][k]) if contact else k + 1
        if u is None or reaction is None or not (contact or not self.pairs):
            ledger.leave('all but the tables', 'displacement, reaction or contact is not written')
            return
        x = run.x0 + u
        internal, stress, strain, moment = self.bodies.solve(u)
        self.stresses(k, stress)
        begin, last = (float(run.contact['begin'][k]) if contact else 0.0), float(
            run.times[k - 1]) if k else 0.0
        points = [Points(pair, k) for pair in self.pairs]
        for shape, p in zip(self.shapes, points):
            if shape is not None:
                shape.judge(p, k, x, ledger)
        sides = [pair.forces(p, x) for pair, p in zip(self.pairs, points)]
        forces = sum((here + there for here, there in sides), np.zeros_like(x))
        self.equilibrium(float(run.times[k]), u, reaction, internal, forces, moment)
        time = float(run.times[k])
        cut = abs(begin - last) > 1e-9 * max(abs(last), 1e-12)
        self.ways.x = None
        if self.pairs and not cut and self.ways.sure and self.last[0] >= 0:
            self.ways.take(time, begin, [u, *self.last[1]], self.last[0])
        # what the next increment goes on from
        self.last = (-1.0, [u]) if cut else (time - begin, [u, self.last[1][0]])
        self.lay(k, x)
        penalty = sum(judge.end_time(p, x, self.scale, cut) for judge, p in zip(self.judges, points))
        self.tables(reaction, [here for here, _ in sides], x)
        self.energies(strain, penalty, sum(float(p.dissipation.sum()) for p in points))

    def lay(self, k: int, x: Array) -> None:
        """The axes of mu1 at the nodes of masters: means of those of their facets."""
        written, own = self.run.field('PointData', 'lay', k), np.zeros_like(x)
        if written is None or any(pair.smooth or pair.curved.any() for pair in self.pairs):
            return
        for pair in self.pairs:
            if pair.mu[0] != pair.mu[1]:
                pair.add_lay(x, own)
        size = np.linalg.norm(own, axis=1, keepdims=True)
        self.ledger.judge('lay of the nodes', own / np.where(size > 0, size, 1) - written, self.run.numbers,
                          only=np.isfinite(size[:, 0]))

    def stresses(self, k: int, stress: Array) -> None:
        """Stress of the cells, and what is formed from written stresses."""
        run, ledger = self.run, self.ledger
        written = run.field('CellData', 'stress', k)
        if written is not None:
            known = np.isfinite(stress).all(1)
            floor = max(float(np.abs(stress[known]).max(initial=0)), 1e-300) + self.bodies.round_off
            ledger.judge('stress of the cells', (stress - written)[known] / floor)
        nodal = run.field('PointData', 'nodal_stress', k)
        if nodal is not None and self.nodal is not None:
            self.nodal.judge(nodal, run.numbers, ledger)
        elif nodal is not None:
            ledger.leave('nodal stress', 'elements of MEAN or NODAl')
        for kind, of, name in (('CellData', 'stress', 'von_mises'),
                               ('PointData', 'nodal_stress', 'nodal_von_mises')):
            s, value = run.field(kind, of, k), run.field(kind, name, k)
            if s is not None and value is not None:
                mises = np.sqrt(0.5 * ((s[:, :3] - s[:, [1, 2, 0]]) ** 2).sum(1) + 3 * (s[:, 3:] ** 2).sum(1))
                ledger.judge('von Mises stress', (mises - value) / max(float(mises.max(initial=0)), 1e-300))

    def equilibrium(self, time: float, u: Array, reaction: Array, internal: Array, contact: Array,
                    moment: Array) -> None:
        """Balance of the nodes, supports and resultants; the scale of forces."""
        run, ledger = self.run, self.ledger
        x, n = run.x0 + u, np.sqrt(len(u))
        applied = run.loads('forces', time) + run.pressures(x, time)
        plain = max(float(np.linalg.norm(v, axis=1).max(initial=0)) for v in (reaction, contact, applied))
        self.scale = scale = max(plain, 64 * ROUND_OFF * self.stiff * run.size / 1e-8)
        ledger.judge('equilibrium of the nodes', np.linalg.norm(
            internal - contact - applied - reaction, axis=1) / scale, run.numbers)
        ledger.judge('resultant force', (reaction + applied + contact).sum(0) / (scale * n))
        ledger.judge('no moment from inside', moment / (scale * n * run.size))
        alone = (run.body == 0)[:, None]
        free = (run.supports[:, :3] == 0) & (run.supports[:, 3:] == 0) & alone
        sprung = free & (run.springs > 0)
        ledger.judge('no reaction without support', reaction[free & ~sprung] / scale)
        ledger.judge('springs', (reaction + run.springs * u)[sprung] / scale)
        held = (run.supports[:, 3] > 0) & (run.body == 0)
        if held.any():
            ledger.judge('held regions carry nothing', reaction[held].sum(0) / scale)
        fixed = (run.supports[:, :3] > 0) & alone
        ledger.judge('prescribed displacements',
                     (u - run.loads('displacements', time))[fixed] / run.size)
        if self.pairs:
            ledger.judge('contact: action, reaction', contact.sum(0) / (scale * n))
            if ledger.form == PLAIN and not any('offset' in pair.group for pair in self.pairs):
                ledger.judge('contact: no moment', cross(x - x.mean(0), contact).sum(0) / (
                    scale * n * run.size))
        for b, row in enumerate(run.table('rigid', 9), 1):
            self.rigid_body(b, row, x, reaction, time)

    def rigid_body(self, b: int, row: Array, x: Array, reaction: Array, time: float) -> None:
        """A body with a point: it is rigid, and what is free of it is in balance with its loads."""
        run, nodes = self.run, self.run.body == b
        arm, now = run.x0[nodes] - row[:3], x[nodes] - x[nodes].mean(0)
        middle = arm.mean(0)
        left, _, right = np.linalg.svd((arm - middle).T @ now)
        turn = (left @ np.diag([1, 1, np.sign(np.linalg.det(left @ right))]) @ right).T
        self.ledger.judge('rigid bodies', (now - (arm - middle) @ turn.T) / run.size)
        point = x[nodes].mean(0) - turn @ middle
        load = sum((r[2:] * run.factor(int(r[1]), time) for r in run.table('rigid_loads', 8)
                    if int(r[0]) == b), np.zeros(6))
        held = np.concatenate([reaction[nodes].sum(0), cross(x[nodes] - point, reaction[nodes]).sum(0)])
        size = self.scale * np.sqrt(nodes.sum()) * np.repeat([1, run.size], 3)
        self.ledger.judge('rigid bodies: balance', ((held - load) / size)[row[3:] > 0])

    def tables(self, reaction: Array, slave: list[Array], x: Array) -> None:
        """The rows of .rea and .con from the fields."""
        run, ledger, group = self.run, self.ledger, self.run.rows['reactions']
        for i in np.flatnonzero(group['step'] == ledger.step) if group else ():
            nodes = run.sets.get(group['set'][i].decode().rstrip('\0 '))
            if nodes is not None:
                row = np.array([group[f'R{j}'][i] for j in (1, 2, 3)])
                ledger.judge('table of reactions', (reaction[nodes].sum(0) - row) / (
                    self.scale * max(1, len(nodes))))
        group = run.rows['contact']
        if not self.pairs or not group:
            return
        arms = np.where(self.bodies.small[:, None], run.x0, x)
        for i, judge, force in zip(np.flatnonzero(group['step'] == ledger.step), self.judges, slave):
            size = self.scale * max(1, judge.row.get('active', 1))
            for name, value in judge.row.items():
                off = value - group[name][i]
                if name in ('active', 'stick', 'slip'):
                    ledger.judge('table of contact: points', off)
                elif name.startswith('max'):
                    ledger.judge('table of contact: lengths', off / judge.pair.edge)
                else:
                    ledger.judge('table of contact: forces', off / size)
            row = np.array([[group[f'{c}{j}'][i] for j in (1, 2, 3)] for c in 'FM'])
            ledger.judge('table of contact: forces', (force.sum(0) - row[0]) / size)
            # arms at rest where the slave's strain is small; a prescribed body has none
            moments = [np.abs(cross(y, force).sum(0) - row[1]).max() for y in (arms, x)]
            ledger.judge('table of contact: forces', min(moments) / (size * np.abs(x).max()))

    def energies(self, strain: float, penalty: float, friction: float) -> None:
        """Energies of the audit at an output time from the fields."""
        run, ledger = self.run, self.ledger
        at = np.flatnonzero(run.audit.get('step', np.zeros(0)) == ledger.step)
        if len(at) != 1 or not self.pairs:
            return
        names = [name.decode().rstrip('\0 ') for name in run.audit['sum_names']]
        sums = dict(zip(names, run.audit['sums'][int(at[0])]))
        largest = max(abs(sums['largest_energy']), abs(strain), abs(sums['dissipation']), 1e-300)
        floor = largest + 64 * ROUND_OFF * self.bodies.stiffest * run.size ** 3 / 1e-6
        ledger.judge('energy: strain', (strain - sums['strain_energy']) / floor)
        if ledger.form != AUGMENTED:
            ledger.judge('energy: penalty', (penalty - sums['penalty_energy']) / floor)
        ledger.judge('energy: friction', (friction - sums['dissipation']) / floor)


def prove(path: str) -> tuple[Ledger, Run]:
    """The ledger of a results file."""
    proof = Proof(path)
    return proof.ledger, proof.run


def certificate(path: str, ledger: Ledger, run: Run) -> dict[str, Any]:
    """What was proved of which file, for those who have to rely on it."""
    digest = hashlib.sha256()
    with open(path, 'rb') as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    deck = run.file['run/deck'][0].rstrip(b'\0 ')
    return {'file': path, 'sha256': digest.hexdigest(), 'deck_sha256': hashlib.sha256(deck).hexdigest(),
            'program': run.file['run/version'][0].decode().rstrip('\0 '), 'end_times': run.steps,
            **ledger.count(), 'lines': ledger.lines,
            'gaps': [[name, why, n] for (name, why), n in ledger.gaps.items()]}


def main(given: argparse.Namespace) -> int:
    """Exit code 0: proved, nothing is refuted; 1: something is; 2: there is nothing to prove."""
    try:
        ledger, run = prove(given.results)
        proof = certificate(given.results, ledger, run)
        run.file.close()
        if given.certificate:
            with open(given.certificate, 'w', encoding='ascii') as stream:
                json.dump(proof, stream, indent=1)
    except (OSError, KeyError, Refusal) as problem:
        print(f'mfec-post check: {problem}', file=sys.stderr)
        return 2
    if not given.quiet:
        print('\n'.join(ledger.rows()))
    print(f'{given.results}: {proof["end_times"]} output times, {proof["proved"]} lines proved, '
          f'{proof["open"]} open, {proof["refuted"]} refuted; sha256 {proof["sha256"]}')
    return 1 if proof['refuted'] else 0 if proof['proved'] else 2
