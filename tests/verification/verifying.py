"""Runs decks, reads what they write and gathers rows of the verification table.

What a study is free to choose it draws from the seed of the run (`draw`, `whole`, `choose`), so that
nothing is tuned. Python's standard library only; `stresses` alone wants h5py.
"""
import math
import os
import random
import re
import shutil
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
import decks  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
REACTIONS = 'step time set R1 R2 R3'.split()
CONTACTS = ('step time pair active stick slip Fn Ft F1 F2 F3 M1 M2 M3 max_penetration '
            'max_elastic_slip max_criterion Ft_nodes').split()
MARKS = {'NTOS': 'o', 'GTOS': 's', 'NTOS +AUGM': '+', 'GTOS +AUGM': 'x', 'NTOS +SMOO': '^',
         'GTOS +SMOO': 'v', 'GTOS SEGMent': '*', 'GTOS SEGMent +SMOO': 'P', 'MORTar': 'D'}


class Trouble(Exception):
    """A run that did not end as it should."""


class Row:
    """One line of the table: what was compared with what."""

    def __init__(self, case, form, quantity, source, reference, reached, error, wanted, known):
        self.case, self.form, self.quantity, self.source = case, form, quantity, source
        self.reference, self.reached, self.error = reference, reached, error
        self.wanted, self.known = wanted, known
        self.series, self.finer, self.why, self.reduced = None, None, '', False

    def name(self):
        """What tells the row from others, whatever the seed."""
        return ' | '.join((self.case, self.form, re.sub(r' \([-\d.]+\)$', '', self.quantity)))

    def verdict(self):
        """holds; where the case says why it does not and the error has not grown: coarse if the same
        quantity holds on the finest mesh of the study (or that was left out), misses if it does not;
        FAILS otherwise."""
        if self.error <= self.wanted:
            return 'holds'
        if self.known is None or self.error > self.known:
            return 'FAILS'
        if self.finer:
            return 'coarse' if self.finer.error <= self.finer.wanted else 'misses'
        return 'coarse' if self.reduced else 'misses'


class Bench:
    """Where the studies run their decks and leave their rows."""

    def __init__(self, program, folder, seed=1, reduced=False, seconds=900.0):
        self.program, self.folder, self.seconds = program, folder, seconds
        self.seed, self.reduced, self.dice, self.drawn = seed, reduced, random.Random(seed), {}
        self.rows, self.remarks, self.figures, self.spent = [], [], [], {}
        self.case, self.form, self.variant = '', '', None
        self.runs = 0

    def draw(self, name, low, high):
        """A number between two limits, of four digits; the same for all forms of a case."""
        return self.noted(name, float(f'{self.dice.uniform(low, high):.4g}'))

    def whole(self, name, low, high):
        """A whole number between two limits, these included."""
        return self.noted(name, self.dice.randint(low, high))

    def choose(self, name, items):
        """One of several things."""
        return self.noted(name, self.dice.choice(items))

    def noted(self, name, value):
        """Keeps what was drawn for the document."""
        self.drawn.setdefault(self.case, {})[name] = value
        return value

    def study(self, name, work, form='NTOS', variant=False):
        """Runs one study; a run that fails becomes a row of its own.

        form: the form of contact of its rows, unless a row names its own;
        variant: whether to change its decks, which have NTOS, to that form.
        """
        self.case, self.form, self.variant = name, form, form if variant else None
        self.dice = random.Random(f'{self.seed} {name}')
        start, first = time.time(), len(self.rows)
        try:
            work(self)
        except (Trouble, OSError, ValueError, IndexError, KeyError, ArithmeticError) as fault:
            self.broken(form, fault)
        self.spent[name] = time.time() - start
        self.clear()
        return self.rows[first:]

    def clear(self):
        """Removes what the runs of a study have written: together they would be gigabytes."""
        for name in os.listdir(self.folder):
            if name.startswith('run') and os.path.isdir(os.path.join(self.folder, name)):
                shutil.rmtree(os.path.join(self.folder, name))

    def broken(self, form, fault):
        """A row for a run that failed."""
        text = ' '.join(str(fault).split()) or type(fault).__name__
        self.rows.append(Row(self.case, form, text.replace('|', '/'), '', math.nan, math.nan, math.inf,
                             0.0, None))

    def compare(self, quantity, source, reference, reached, wanted, *, scale=None, known=None,
                form=None, mesh=None, why=''):
        """A row: the error is relative to the reference, or to `scale`; the error.

        known: largest error of a case that is known to miss what is wanted;
        mesh: the mesh, of a quantity that is studied on several; the finest one comes last;
        why: the cause of a miss, for the list of what is not reached.
        """
        error = abs(reached - reference)/(abs(reference) if scale is None else scale)
        error = error if math.isfinite(error) else math.inf
        row = Row(self.case, form or self.form, f'{quantity}, {mesh}' if mesh else quantity, source,
                  reference, reached, error, wanted, known)
        for other in self.rows:
            if mesh and (other.case, other.form, other.series) == (row.case, row.form, quantity):
                other.finer = row
        row.series, row.why, row.reduced = quantity if mesh else None, why, bool(mesh and self.reduced)
        self.rows.append(row)
        return error

    def picture(self, name, axes, curves, logarithmic=False):
        """A figure: axes (x, y, title), curves (label, style of matplotlib, xs, ys).

        A second one of the same name, for instance of another form, adds what is new to the first.
        """
        for other, _, there, _ in self.figures:
            if other == name:
                labels = [curve[0] for curve in there]
                there += [curve for curve in curves if curve[0] not in labels]
                return
        self.figures.append((name, axes, list(curves), logarithmic))

    def mark(self):
        """Style of the points of the form that is studied."""
        return MARKS.get(self.form, 'h')

    def remark(self, text):
        """A line below the table."""
        self.remarks.append(f'{self.case}: {text}')

    def run(self, deck, code=0, **values):
        """Runs a deck with parameters set; its tables. The path is relative to this folder."""
        return self.launch([self.path(deck)] + settings(values), code)

    @staticmethod
    def path(deck):
        """A file of this folder."""
        return os.path.join(HERE, deck)

    def run_text(self, name, text, code=0, **values):
        """Runs a deck that a study has written, with parameters set."""
        path = os.path.join(self.folder, name + '.inp')
        with open(path, 'w', encoding='ascii') as stream:
            stream.write(without_penalty(text))
        return self.launch([path] + settings(values), code)

    def launch(self, arguments, code):
        """Runs the program in a folder of its own and checks the exit code."""
        self.runs += 1
        out = os.path.join(self.folder, f'run{self.runs}')
        os.mkdir(out)
        if self.variant:
            arguments = [changed(arguments[0], self.variant, out)] + arguments[1:]
        done = decks.run(self.program, arguments + ['--out', out, '--quiet'], out, self.seconds)
        fault = done.crash()
        if not fault and done.code != code:
            fault = f'exit code {done.code}, {code} wanted: {done.err.strip()[:300]}'
        if fault:
            raise Trouble(f'{os.path.basename(arguments[0])}: {fault}')
        return Tables(os.path.join(out, os.path.basename(arguments[0])[:-4]),
                      done.code)


def changed(path, form, folder):
    """A copy of a deck whose pair NTOS has another form, for instance GTOS +AUGM."""
    words, *options = form.split(' +')
    side, *points = words.split()
    lines = whole(path)
    pairs = [k for k, line in enumerate(lines) if line.split()[:1] == ['NTOS']]
    if len(pairs) != 1:
        raise ValueError(f'{path} has no pair to change')
    lines[pairs[0]] = '\n'.join([' '.join([lines[pairs[0]].replace('NTOS', side, 1)] + points)] + options)
    copy = os.path.join(folder, os.path.basename(path))
    with open(copy, 'w', encoding='ascii') as stream:
        stream.write(without_penalty('\n'.join(lines)))
    return copy


def whole(path):
    """Lines of a deck, with those that it includes."""
    with open(path, encoding='ascii') as stream:
        lines = stream.read().rstrip('\n').split('\n')
    return [line for outer in lines for line in (
        whole(os.path.join(os.path.dirname(path), outer.split()[1])) if outer.split()[:1] == ['INCLude'] else [outer])]


def without_penalty(text):
    """A deck as it is, but without penalties if its pairs are those of MORTar, which has none."""
    lines = text.split('\n')
    if not any(line.split()[:1] == ['MORTar'] for line in lines):
        return text
    return '\n'.join(line for line in lines if line.split()[:1] != ['PENAlty'])


def settings(values):
    """Parameters as arguments."""
    return [item for name, value in values.items() for item in ('--set', f'{name}={value}')]


class Tables:
    """What a run has left: its exit code and its files, `base` being their path without suffix."""

    def __init__(self, base, code):
        self.base, self.code = base, code

    def reactions(self, name):
        """Rows of a set in the reaction table."""
        return [row for row in read_table(self.base + '.rea', REACTIONS) if row['set'] == name]

    def contact(self, name):
        """Rows of a pair in the contact table."""
        return [row for row in read_table(self.base + '.con', CONTACTS) if row['pair'] == name]

    def displacements(self):
        """What each DISP has printed to the log, as {node: (u1, u2, u3)}."""
        return self.printed('displacements')

    def printed(self, what):
        """Nodal vectors in the log: one dictionary for each print."""
        prints, open_print = [], False
        with open(self.base + '.log', encoding='utf-8') as stream:
            for line in stream:
                items = line.split()
                if items[:2] == ['nodal', what]:
                    prints.append({})
                    open_print = True
                elif open_print and len(items) == 4 and items[0].isdigit():
                    prints[-1][int(items[0])] = tuple(float(item) for item in items[1:])
                else:
                    open_print = False
        return prints

    def cuts(self):
        """How often an increment was cut, as the log counts."""
        with open(self.base + '.log', encoding='utf-8') as stream:
            return int(re.findall(r'(\d+) cuts?,', stream.read())[-1])

    def work_lost(self):
        """Share of the work of loads and supports that is not found again at the end (h5py)."""
        with self.results() as file:
            audit = file['audit']
            sums = dict(zip((name.decode().strip() for name in audit['sum_names'][:]), audit['sums'][-1]))
        lost = sums['work'] - sums['strain_energy'] - sums['penalty_energy'] - sums['dissipation']
        return abs(lost)/abs(sums['work'])

    def audited(self, name):
        """What the audit compares with its limit, at each end time (h5py)."""
        with self.results() as file:
            names = [item.decode().strip() for item in file['audit']['checks'][:]]
            return [float(row[names.index(name)]) for row in file['audit']['value'][:]]

    def second_pressure(self):
        """Pressure of the first second answer with contact that CHECk,UNIQue has printed."""
        with open(self.base + '.log', encoding='utf-8') as stream:
            return float(re.findall(r' time .* answers: .*? pressure ([-+.\dE]+)', stream.read())[-1])

    def stresses(self):
        """Stress of the elements at the last time (h5py)."""
        with self.results() as file:
            group = file['VTKHDF']
            steps = group['Steps']
            cells = int(group['NumberOfCells'][0])
            offset = int(steps['CellDataOffsets']['stress'][len(steps['Values']) - 1])
            stress = group['CellData']['stress'][offset:offset + cells]
        return [tuple(float(x) for x in row) for row in stress]

    def nodal_reactions(self):
        """Reactions of all nodes at the last time (h5py)."""
        with self.results() as file:
            group = file['VTKHDF']
            steps, nodes = group['Steps'], int(group['NumberOfPoints'][0])
            offset = int(steps['PointDataOffsets']['reaction'][len(steps['Values']) - 1])
            reaction = group['PointData']['reaction'][offset:offset + nodes]
        return [tuple(float(x) for x in row) for row in reaction]

    def forces(self, when=-1):
        """Forces on the slave nodes of pair 1, as {node: [f1, f2, f3]} (h5py).

        The force of a quadrature point goes to the nodes of its facet by its weights.
        """
        total = {}
        for corners, share, force in zip(*self.points()[when]):
            for n, w in zip(corners, share):
                there = total.setdefault(n, [0.0]*3)
                for k in range(3):
                    there[k] += w*force[k]
        return total

    def points(self):
        """Points of pair 1 at each time: their nodes, weights (SEGMent moves them), forces (h5py)."""
        with self.results() as file:
            group = file['contact/1']
            nodes, forces = group['node'][:], group['traction'][:]
            count = forces.shape[1]
            weights = group['weight'][:] if 'weight' in group else [[1.0]]*count
            moving = 'weight' in group and weights.ndim == 3
            return [([nodes, nodes[k]][nodes.ndim == 3].reshape(count, -1).tolist(),
                     weights[k] if moving else weights, force.tolist())
                    for k, force in enumerate(forces)]

    def states(self):
        """Status of the slave nodes of pair 1 (0 open, 1 stick, 2 slip) at each time (h5py)."""
        with self.results() as file:
            group = file['contact/1']
            nodes = [int(n) for n in group['node'][:]]
            return [dict(zip(nodes, (int(s) for s in row))) for row in group['status'][:]]

    def at_nodes(self, field):
        """A field of the contact at the slave's nodes at the last time, as {node: value} (h5py)."""
        with self.results('.contact.vtkhdf') as file:
            data = file['VTKHDF/PointData']
            nodes, sides = data['node_number'][:], data['side'][:]
            return {int(n): value for n, side, value in zip(nodes, sides, data[field][-len(nodes):]) if side == 1}

    def results(self, suffix='.vtkhdf'):
        """An open result file."""
        try:
            import h5py
        except ImportError as fault:
            raise Trouble('wants h5py: run it with build/venv/bin/python') from fault
        return h5py.File(self.base + suffix, 'r')


def read_table(path, columns):
    """Rows of a table as dictionaries, numbers read."""
    rows = []
    with open(path, encoding='utf-8') as stream:
        for line in stream:
            if line.strip() and not line.startswith('#'):
                row = dict(zip(columns, line.split()))
                rows.append({key: value if key in ('set', 'pair') else float(value)
                             for key, value in row.items()})
    return rows
