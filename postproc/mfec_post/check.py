"""mfec-post check: an independent proof of a result, from its results file alone."""
from __future__ import annotations

import argparse
import hashlib
import json
import sys
from typing import Any, Optional

import numpy as np

from .proof_bulk import Bodies
from .proof_contact import OPEN, Pair, Points
from .proof_run import ROUND_OFF, Array, Ledger, Refusal, Run, cross

MORTAR = -2
"""First number of the law of a pair with multipliers at nodes."""

TOLERANCE, MULTIPLIERS = 1e-8, 1e-5  # of forces: plain, with AUGMent


def add_options(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument('results', help='results file (.vtkhdf)')
    parser.add_argument('--certificate', help='file to write the proof to (.json)')
    parser.add_argument('--quiet', action='store_true', help='the last line alone')


def equilibrium(run: Run, ledger: Ledger, k: int, u: Array, reaction: Array, internal: Array,
                contact: Array, moment: Array) -> float:
    """Balance of the nodes, supports and resultants; the scale of forces."""
    x, time = run.x0 + u, float(run.times[k])
    applied = run.loads('forces', time) + run.pressures(x, time)
    springs = np.where(run.supports[:, :3] > 0, 0, -run.springs * u)
    plain = max(float(np.linalg.norm(v, axis=1).max(initial=0)) for v in
                (reaction, contact, applied))
    plain = max(plain, 64 * ROUND_OFF * run.stiffest * run.shortest * run.size / TOLERANCE)
    # displacements to eight digits, through the stiffness
    scale = max(plain, run.stiffest * run.shortest * float(np.abs(u).max(initial=0)))
    tolerance = MULTIPLIERS if any(p.augmented for p in run.pairs_law) else TOLERANCE
    ledger.judge('equilibrium of the nodes',
                 np.linalg.norm(internal - contact - applied - reaction, axis=1) / scale,
                 tolerance, run.numbers)
    total = (reaction + applied + contact).sum(0)
    ledger.judge('resultant force', total / (scale * np.sqrt(len(x))), tolerance)
    ledger.judge('no moment from inside', moment / (scale * np.sqrt(len(x)) * run.size), TOLERANCE)
    free = (run.supports[:, :3] == 0) & (run.supports[:, 3:] == 0) & (run.body == 0)[:, None]
    sprung = free & (run.springs > 0)
    ledger.judge('no reaction without support', reaction[free & ~sprung] / scale, tolerance)
    ledger.judge('springs', (reaction - springs)[sprung] / scale, TOLERANCE)
    held = run.supports[:, 3] > 0
    if held.any():
        ledger.judge('held regions carry nothing', reaction[held & (run.body == 0)].sum(0) / scale,
                     1e-6)
    fixed = (run.supports[:, :3] > 0) & (run.body == 0)[:, None]
    want = run.loads('displacements', time)
    ledger.judge('prescribed displacements', (u - want)[fixed] / run.size, 1e-10)
    for b, row in enumerate(run.table('rigid', 9), 1):
        rigid_body(run, ledger, b, row, x, reaction, scale, time)
    return plain


def rigid_body(run: Run, ledger: Ledger, b: int, row: Array, x: Array, reaction: Array,
               scale: float, time: float) -> None:
    """A body with a point: it is rigid, and what is free of it is in balance with its loads."""
    nodes = run.body == b
    arm = run.x0[nodes] - row[:3]
    middle = arm.mean(0)
    left, _, right = np.linalg.svd((arm - middle).T @ (x[nodes] - x[nodes].mean(0)))
    turn = (left @ np.diag([1, 1, np.sign(np.linalg.det(left @ right))]) @ right).T
    ledger.judge('rigid bodies', (x[nodes] - x[nodes].mean(0) - (arm - middle) @ turn.T) / run.size,
                 1e-10)
    point = x[nodes].mean(0) - turn @ middle
    load = sum((r[2:] * run.factor(int(r[1]), time) for r in run.table('rigid_loads', 8)
                if int(r[0]) == b), np.zeros(6))
    held = np.concatenate([reaction[nodes].sum(0),
                           cross(x[nodes] - point, reaction[nodes]).sum(0) / run.size])
    load[3:] /= run.size
    ledger.judge('rigid bodies: balance', (held - load)[row[3:] > 0] / (
        scale * np.sqrt(nodes.sum())), MULTIPLIERS if any(p.augmented for p in run.pairs_law)
        else TOLERANCE)


def tables(run: Run, ledger: Ledger, reaction: Array, contacts: dict[str, Points],
           scale: float) -> None:
    """The rows of .rea and .con from the fields."""
    group = run.rows['reactions']
    if group:
        for i in np.flatnonzero(group['step'] == ledger.step):
            nodes = run.sets.get(group['set'][i].decode().rstrip('\0 '))
            if nodes is not None:
                row = np.array([group[f'R{j}'][i] for j in (1, 2, 3)])
                ledger.judge('table of reactions', (reaction[nodes].sum(0) - row) / (
                    scale * max(1, len(nodes))), 1e-9)
    group = run.rows['contact']
    if not contacts or not group:
        return
    at = np.flatnonzero(group['step'] == ledger.step)
    for i, p in zip(at, contacts.values()):
        closed = p.status > OPEN
        ledger.judge('table of contact: points', np.array([
            closed.sum() - group['active'][i], (p.status == 1).sum() - group['stick'][i],
            (p.status == 2).sum() - group['slip'][i]]), 0.5)
        size = max(scale, 1e-300) * max(1, int(closed.sum()))
        force = p.force[closed].sum(0) if closed.any() else np.zeros(3)
        row = np.array([group[f'F{j}'][i] for j in (1, 2, 3)])
        ledger.judge('table of contact: forces', (force - row) / size, 1e-9)
        ledger.judge('table of contact: forces', (p.lay_force[closed, 2].sum() - group['Fn'][i])
                     / size, 1e-9)
        deepest = float(np.max(-p.gap[closed], initial=0.0))
        ledger.judge('table of contact: depth', (deepest - group['max_penetration'][i]) / run.size,
                     1e-12)


def energies(run: Run, ledger: Ledger, strain: float, penalty: Optional[float],
             friction: float) -> None:
    """Energies of the audit at an end time from the fields."""
    at = np.flatnonzero(run.audit.get('step', np.zeros(0)) == ledger.step)
    if len(at) != 1:
        return
    names = [name.decode().rstrip('\0 ') for name in run.audit['sum_names']]
    sums = dict(zip(names, run.audit['sums'][int(at[0])]))
    largest = max(abs(sums['largest_energy']), abs(strain), abs(sums['dissipation']), 1e-300)
    floor = largest + 64 * ROUND_OFF * run.stiffest * run.size ** 3 / 1e-6
    ledger.judge('energy: strain', (strain - sums['strain_energy']) / floor, 1e-6)
    if penalty is not None:
        ledger.judge('energy: penalty', (penalty - sums['penalty_energy']) / floor, 1e-6)
    ledger.judge('energy: friction', (friction - sums['dissipation']) / floor, 1e-6)


def prove(path: str) -> tuple[Ledger, Run]:
    """All lines of a results file."""
    run, ledger = Run(path), Ledger()
    bodies = Bodies(run)
    run.stiffest = bodies.stiffest
    run.pairs_law = [Pair(run, name, group) for name, group in run.pairs.items()]
    if any(pair.points == MORTAR for pair in run.pairs_law):
        raise Refusal(f'{path}: multipliers at nodes (MORTar) are not in the proof yet: prove the '
                      'same scene with SEGMent')
    before: dict[str, tuple[Points, Array]] = {}
    with_contact = len(run.contact.get('step', ())) > 0
    if not run.steps:
        ledger.leave('fields', 'no end time has fields')
    for k in range(run.steps):
        u, reaction = run.field('PointData', 'displacement', k), run.field('PointData', 'reaction', k)
        ledger.step = int(run.contact['step'][k]) if with_contact else k + 1
        if u is None or reaction is None or not (with_contact or not run.pairs_law):
            ledger.leave('all but the tables', 'displacement, reaction or contact is not written')
            continue
        x = run.x0 + u
        internal, stress, strain, moment = bodies.solve(u)
        written = run.field('CellData', 'stress', k)
        if written is not None:
            known = np.isfinite(stress).all(1)
            floor = max(float(np.abs(stress[known]).max(initial=0)), 1e-300) \
                + 64 * ROUND_OFF * run.stiffest / 1e-9
            ledger.judge('stress of the cells', (stress - written)[known] / floor, 1e-9)
        begin = float(run.contact['begin'][k]) if with_contact else 0.0
        last = float(run.times[k - 1]) if k else 0.0
        contact, now = np.zeros_like(x), {}
        for pair in run.pairs_law:
            now[pair.name] = Points(pair, k)
            contact += pair.forces(now[pair.name], x)
        scale = equilibrium(run, ledger, k, u, reaction, internal, contact, moment)
        if run.pairs_law:
            ledger.judge('contact: action, reaction', contact.sum(0) / (
                scale * np.sqrt(len(x))), 1e-11)
            if not any(p.augmented or p.offset_used for p in run.pairs_law):
                ledger.judge('contact: no moment', cross(x - x.mean(0), contact).sum(0) / (
                    scale * np.sqrt(len(x)) * run.size), 1e-11)
        penalty: Optional[float] = 0.0
        for pair in run.pairs_law:
            old = before.get(pair.name)
            cut = old is None or abs(begin - last) > 1e-9 * max(abs(last), 1e-12) + 1e-300
            p, energy = pair.judge(ledger, k, x, old or (now[pair.name], x), scale, cut)
            penalty = None if penalty is None or pair.augmented else penalty + energy
            before[pair.name] = p, x
        tables(run, ledger, reaction, now, scale)
        if with_contact:
            energies(run, ledger, strain, penalty,
                     sum(float(p.dissipation.sum()) for p in now.values()))
    return ledger, run


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
    print(f'{given.results}: {proof["end_times"]} end times, {proof["proved"]} lines proved, '
          f'{proof["open"]} open, {proof["refuted"]} refuted; sha256 {proof["sha256"]}')
    return 1 if proof['refuted'] else 0 if proof['proved'] else 2
