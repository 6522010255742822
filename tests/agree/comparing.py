"""Compares two runs of one deck: tables, displacements, and facet and status of each contact point.

Wants h5py (build/venv/bin/python).
"""
import os
import re

import h5py
import numpy as np

CUT = re.compile(r'^step +(\d+) cut: ', re.MULTILINE)
DECISION = re.compile(r'REDUced cannot be had, [^;\n]*|REDUced, one symmetric factor', re.MULTILINE)
STATUS = {-1: 'off', 0: 'open', 1: 'stick', 2: 'slip'}
# Forces that differ by less belong to the same solution, whatever facets and statuses are called: the
# facet is a tie over a flat edge, stick and slip are one at the edge of the cone.
SAME = 1e-8
# Share of scenes that may take another path.
MOST_OTHERS = 0.01
# A gap is known to so many units in the last place of the coordinates: all that a stiff penalty or
# a multiplier leaves of it.
ROUNDINGS = 64
REACTIONS = ('force', 'force', 'force')
CONTACTS = (None, None, None, 'force', 'force', 'force', 'force', 'force', 'moment', 'moment', 'moment',
            'length', 'length', None)


class Finished:
    """What a run has left behind in a folder."""

    def __init__(self, base, run):
        self.base, self.run = base, run
        self.log = read(base + '.log')
        self.cuts = [int(step) for step in CUT.findall(self.log)]
        self.decision = ' / '.join(DECISION.findall(self.log))

    def adrift(self):
        """The first step at which a pair carries no force in a scene with a body that contact alone
        holds: where such a body lies from then on is not determined."""
        if 'held by contact alone' not in self.decision:
            return np.inf
        rows = [line.split() for line in read(self.base + '.con').split('\n') if line.strip()]
        forces = [(int(row[0]), abs(float(row[6]))) for row in rows if row[0] != '#']
        top = max((force for _, force in forces), default=0.0)
        return min((step for step, force in forces if force <= 1e-12*top), default=np.inf)

    def converged(self):
        """It has reached its end."""
        return self.run.code == 0


class Difference:
    """How two runs differ: the verdict, the largest relative error, the one before the first other
    cut, facet or status, and where it began."""

    def __init__(self, verdict, error=0.0, before=0.0, where=''):
        self.verdict, self.error, self.before, self.where = verdict, error, before, where


def agreement(verdicts):
    """Faults of a whole table: too many scenes that take another way."""
    other = [v for v in verdicts if v.startswith('other')]
    share = len(other)/max(1, len(verdicts))
    return [f'{100*share:.1f} % have others, {100*MOST_OTHERS:g} % allowed'] if (
        share > MOST_OTHERS) else []


def read(path):
    """The text of a file, empty if there is none."""
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8') as stream:
        return stream.read()


def compare(one, other, least=0.0):
    """The difference between two runs.

    least: forces are compared relative to no less than this.
    """
    if one.converged() != other.converged():
        failed = 'the second' if one.converged() else 'the first'
        return Difference('one fails', where=f'{failed} does not converge')
    if not (os.path.exists(one.base + '.vtkhdf') and os.path.exists(other.base + '.vtkhdf')):
        return Difference('agree')
    with h5py.File(one.base + '.vtkhdf', 'r') as a, h5py.File(other.base + '.vtkhdf', 'r') as b:
        count = min(len(a['contact/step']), len(b['contact/step'])) if 'contact/step' in a else 0
        cut = first_cut(one.cuts, other.cuts)
        step, where = first_choice(a, b, count)
        adrift = other.adrift()
        before, what = numbers(one, other, (a, b), min(cut, step, adrift) - 1, least)
        whole, _ = numbers(one, other, (a, b), np.inf, least)
        if not np.isfinite(min(cut, step, adrift)):
            return Difference('agree', before, before, what)
        if adrift <= min(cut, step) and whole > SAME:
            return Difference('adrift', before, before, f'step {adrift:g}, {before:.1e} before it: nothing '
                              f'holds a body; {whole:.1e} after it')
        if not np.isfinite(min(cut, step)):
            return Difference('agree', whole, before, what)
        if whole <= SAME and not np.isfinite(cut):
            return Difference(f'tie of {where[0]}', whole, before, f'step {step:g}: {where[1]}')
        if cut <= step:
            return Difference('other cuts', whole, before,
                              f'step {cut:g}, {before:.1e} before it')
        return Difference('other ' + where[0], whole, before,
                          f'step {step:g}, {before:.1e} before it: {where[1]}')


def first_cut(one, other):
    """The first step that is not cut as often in both."""
    steps = [s for s in set(one + other) if one.count(s) != other.count(s)]
    return min(steps, default=np.inf)


def first_choice(a, b, count):
    """The first step at which a closed point has another facet or a point another status."""
    for k in range(count):
        for pair in sorted(name for name in a['contact'] if name.isdigit()):
            found = choices(a['contact'][pair], b['contact'][pair], k)
            if found:
                return int(a['contact/step'][k]), (found[0], f'pair {pair} {found[1]}')
    return np.inf, None


def choices(a, b, k):
    """What differs at entry k of one pair: facets or statuses, and the points."""
    status = [np.maximum(g['status'][k], 0) for g in (a, b)]
    if status[0].shape != status[1].shape:
        return 'points', 'other points'
    closed = np.minimum(*status) > 0
    for word, here in (('statuses', status[0] != status[1]),
                       ('facets', closed & (a['host'][k] != b['host'][k]))):
        if here.any():
            return word, '; '.join(describe(a, b, k, p) for p in np.flatnonzero(here)[:3])
    return None


def describe(a, b, k, p):
    """One point in both runs."""
    node = a['node'][:]
    node = node[k] if node.ndim == 3 or node.shape[0] != a['status'].shape[1] else node
    sides = [f'facet {g["host"][k][p]} {STATUS[int(g["status"][k][p])]} gap {g["gap"][k][p]:.3e} '
             f'tip {g["tip"][k][p][0]:.9f} {g["tip"][k][p][1]:.9f}' for g in (a, b)]
    return f'point {p + 1} (node {np.ravel(node[p])}): {sides[0]} | {sides[1]}'


def numbers(one, other, results, last, least):
    """Largest difference up to a step, relative to the largest of its kind in the run, and where."""
    a, b = results
    worst = [(0.0, '')]
    steps = a['state/step'][:] if 'state/step' in a else []
    extent = np.abs(a['state/coordinates'][:]).max() if len(steps) else 0.0
    least = {'force': least, 'length': ROUNDINGS*np.finfo(float).eps*extent/1e-8}
    for ending, kinds in (('.rea', REACTIONS), ('.con', CONTACTS)):
        worst += table_differences(read(one.base + ending), read(other.base + ending), kinds, last, least)
    if len(steps):
        n = min(len(steps), len(b['state/step']))
        u, v = a['state/displacement'][:n], b['state/displacement'][:n]
        top = max(np.abs(u).max(), least['length'], 1e-300)
        worst += [(np.abs(u[k] - v[k]).max()/top, f'displacement, step {steps[k]}')
                  for k in range(n) if steps[k] <= last]
    return max(worst)


def table_differences(ours, theirs, kinds, last, least):
    """Differences of the entries of two tables, up to a step."""
    rows = [[line.split() for line in text.split('\n') if line.strip() and line[0] != '#']
            for text in (ours, theirs)]
    largest = dict(least)
    for row in rows[0]:
        for kind, item in zip(kinds, row[3:]):
            largest[kind] = max(largest.get(kind, 0.0), abs(float(item)))
    found = []
    for x, y in zip(*rows):
        if int(x[0]) > last:
            break
        for kind, p, q in zip(kinds, x[3:], y[3:]):
            if kind and largest[kind] > 0.0:
                found.append((abs(float(p) - float(q))/largest[kind], f'{kind} of {x[2]}, step {x[0]}'))
    return found
