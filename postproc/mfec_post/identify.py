"""Friction from measured curves: least squares on runs of mfec with their exact derivatives.

The deck is run with the parameters that are sought, `--sens` gives the Jacobian, and Levenberg's and
Marquardt's method corrects them: a handful of runs. The start comes from steady drag in closed form.
The slip rule is a whole number for the program; its real value is estimated from the derivative by
it, and the interval decides among 0, 1 and 2.
"""
from __future__ import annotations

import argparse
import csv
import itertools
import os
import re
import statistics
import subprocess
import sys
import tempfile
from typing import Callable, Optional

import numpy as np
from mfec.program import find_program
from numpy.typing import NDArray

from .tables import TableError, read_table

RULES = ('COLLinear', 'TENSor', 'ASSOciated')
MOST_RUNS = 12
DETERMINED = 100.0  # condition number above which no interval is printed
UNIT = np.pi / 180.0


class Identification(Exception):
    """What cannot be identified, and why."""


def add_options(one: argparse.ArgumentParser) -> None:
    """The options of the command."""
    one.add_argument('deck', help='deck of the experiment')
    one.add_argument('--data', help='CSV file with a header')
    one.add_argument('--columns', help='its columns: time, then R1, R2 and if measured R3')
    one.add_argument('--set', dest='set_name', default='top', help='set whose reactions they are')
    one.add_argument('--fit', required=True, help='parameters of the deck, and slip: m1,m2,phi,slip')
    one.add_argument('--sigma', default='1%', help='standard deviation: a share of the largest '
                     'force in the plane (1%%), or a force')
    one.add_argument('--sigma-column', help='or a column of the data')
    one.add_argument('--bounds', action='append', default=[], help='m1=0:1; may be repeated')
    one.add_argument('--nuisance', default='', help='parameters that are unknown as well')
    one.add_argument('--level', type=float, default=95.0, help='of the intervals [%%]')
    one.add_argument('--plan', action='store_true', help='no data: what this path would determine')
    one.add_argument('--refits', action='store_true', help='fit all three slip rules')
    one.add_argument('--start', choices=('drag', 'deck'), default='drag', help='start from steady '
                     'drag, or from the values of the deck')
    one.add_argument('--program', help='the program (default: that of the package, else of the path)')
    one.add_argument('--out', default='identify.png', help='picture of data, fit and residual')


class Deck:
    """A deck that is run with parameters and a slip rule of its own."""

    def __init__(self, path: str, program: str, set_name: str):
        self.path, self.program, self.set_name = path, program, set_name
        try:
            with open(path, encoding='utf-8') as stream:
                self.text = stream.read()
        except OSError as problem:
            raise TableError(f'cannot read {path}: {problem}') from problem
        self.runs = 0
        self.title = self.record('MFEC') or path

    def record(self, word: str) -> Optional[str]:
        """What stands behind the first record that begins with these letters."""
        found = re.search(rf'(?im)^\s*{word}\w*[ \t,=]+([^!\n]*)', self.text)
        return found.group(1).strip() if found else None

    @property
    def rule(self) -> int:
        """The slip rule that it has."""
        word = (self.record('SLIP') or 'COLL')[:4].lower()
        return ['coll', 'tens', 'asso'].index(word)

    def roles(self) -> dict[str, str]:
        """Which parameters are mu1, mu2 and the angle of the lay."""
        found = {}
        friction = re.search(r'(?im)^\s*FRIC\w*\s+ELLI\w*\s+(\S+)\s+(\S+)', self.text)
        if friction:
            found = {'mu1': friction.group(1), 'mu2': friction.group(2)}
        angle = re.search(r'(?im)^\s*DIRE\w*\s+(?:MATE\w*\s+)?ANGL\w*\s+(\S+)', self.text)
        if angle:
            found['phi'] = angle.group(1)
        return found

    def lay(self) -> float:
        """Angle in the plane of the vector that the lay is turned from [degree]."""
        found = re.search(r'(?im)^\s*DIRE\w*\s+(?:MATE\w*\s+)?ANGL\w*\s+\S+\s+(\S+)\s+(\S+)', self.text)
        try:
            return float(np.degrees(np.arctan2(float(found.group(2)), float(found.group(1))))) \
                if found else 0.0
        except ValueError:
            return 0.0

    def values(self, names: list[str]) -> list[float]:
        """Values of parameters in the deck."""
        found = []
        for name in names:
            line = re.search(rf'(?m)^\s*{re.escape(name)}\s*=\s*([^\s!]+)', self.text)
            try:
                found.append(float(line.group(1)) if line else np.nan)
            except ValueError:
                found.append(np.nan)
        if np.any(np.isnan(found)):
            unknown = [name for name, value in zip(names, found) if np.isnan(value)]
            raise Identification(f'{", ".join(unknown)}: no PARAmeter of the deck with a plain '
                                 'number as its value')
        return found

    def with_rule(self, rule: int) -> str:
        """The deck's text with a slip rule."""
        text, n = re.subn(r'(?im)^(\s*SLIP[ \t]+)\w+', rf'\g<1>{RULES[rule]}', self.text)
        if n == 0:
            text = re.sub(r'(?im)^(\s*)(FRIC\w*\s.*)$', rf'\1\2\n\1SLIP {RULES[rule]}', text)
        return text

    def run(self, names: list[str], values: list[float], rule: int, derivatives: list[str]) \
            -> tuple[NDArray, NDArray, NDArray]:
        """Times, reactions (times, 3) and their derivatives (times, 3, names)."""
        folder = os.path.dirname(os.path.abspath(self.path))
        handle, deck = tempfile.mkstemp('.inp', '.identify-', folder)
        try:
            with os.fdopen(handle, 'w', encoding='utf-8') as stream:
                stream.write(self.with_rule(rule))
            with tempfile.TemporaryDirectory() as out:
                words = [self.program, deck, '--quiet', '--out', out]
                for name, value in zip(names, values):
                    words += ['--set', f'{name}={value:.17g}']
                if derivatives:
                    words += ['--sens', ','.join(derivatives)]
                done = subprocess.run(words, capture_output=True, text=True, check=False)
                if done.returncode:
                    text = done.stderr.strip().replace(deck, self.path)
                    raise Identification(f'mfec ended with {done.returncode}:\n{text}')
                base = os.path.join(out, os.path.splitext(os.path.basename(deck))[0])
                self.runs += 1
                rows = self.rows(read_table(base + '.rea'), 'set')
                times = rows['time']
                force = np.stack([rows[f'R{k}'] for k in (1, 2, 3)], 1)
                jacobian = np.zeros((len(times), 3, len(derivatives)))
                if derivatives:
                    table = self.rows(read_table(base + '.sen'), 'quantity')
                    for j, name in enumerate(derivatives):
                        mine = table[table['parameter'] == name]
                        jacobian[:, :, j] = np.stack([mine[f'd{k}'] for k in (1, 2, 3)], 1)
        finally:
            os.unlink(deck)
        return times, force, jacobian

    def rows(self, table: NDArray, key: str) -> NDArray:
        """Rows of the set."""
        rows = table[table[key] == self.set_name]
        if len(rows) == 0:
            raise Identification(f'the run has no reactions of {self.set_name}: name one of '
                                 f'{", ".join(sorted(set(table[key])))} with --set')
        return rows


class Measured:
    """What has been measured: times, forces and their standard deviations."""

    def __init__(self, time: NDArray, force: NDArray, sigma: NDArray):
        self.time, self.force, self.sigma = time, force, sigma

    def at(self, times: NDArray, values: NDArray) -> NDArray:
        """Values of a run at the times of the data, linear in between."""
        flat = values.reshape(len(times), -1)
        columns = [np.interp(self.time, times, column) for column in flat.T]
        return np.stack(columns, 1).reshape((len(self.time),) + values.shape[1:])


def deviation(text: str, force: NDArray) -> NDArray:
    """Standard deviations from --sigma."""
    try:
        if text.endswith('%'):
            plane = np.linalg.norm(force[:, :2], axis=1).max()
            sigma = np.full(force.shape, float(text[:-1]) / 100.0 * plane)
            if force.shape[1] > 2:
                sigma[:, 2] = float(text[:-1]) / 100.0 * np.abs(force[:, 2]).max()
            return sigma
        return np.full(force.shape, float(text))
    except ValueError as problem:
        raise Identification(f'--sigma {text}: write 1% or a force') from problem


def read_data(given: argparse.Namespace) -> Measured:
    """The data file."""
    if not given.data or not given.columns:
        raise Identification('--data T.csv and --columns time,R1,R2 are wanted, or --plan')
    names = given.columns.split(',')
    if not 3 <= len(names) <= 4:
        raise Identification('--columns wants the time and two or three forces: time,R1,R2[,R3]')
    try:
        with open(given.data, encoding='utf-8', newline='') as stream:
            rows = list(csv.DictReader(line for line in stream if not line.startswith('#')))
        table = np.array([[float(row[name]) for name in names] for row in rows])
        sigma = deviation(given.sigma, table[:, 1:])
        if given.sigma_column:
            sigma = np.repeat([[float(row[given.sigma_column])] for row in rows],
                              len(names) - 1, 1)
    except (OSError, KeyError, ValueError, IndexError) as problem:
        raise Identification(f'{given.data}: {problem}') from problem
    if len(table) < 3 or np.any(sigma <= 0.0):
        raise Identification(f'{given.data}: three rows at least, and deviations above zero')
    return Measured(table[:, 0], table[:, 1:], sigma)


def drag(mu1: float, mu2: float, angle: float, m: float, way: NDArray) -> NDArray:
    """Friction over the pressure in steady drag along unit vectors (n, 2); angle of axis 1."""
    c, s = np.cos(angle), np.sin(angle)
    v = way @ np.array([[c, -s], [s, c]])
    mu = np.abs([mu1, mu2]) + 1e-12
    force = mu**m * v / np.linalg.norm(mu**(m - 1.0) * v, axis=1)[:, None]
    return force @ np.array([[c, s], [-s, c]])


def differences(f: Callable[[NDArray], NDArray], x: NDArray) -> NDArray:
    """Jacobian of a cheap function."""
    columns = []
    for j, value in enumerate(x):
        h = 1e-6 * max(abs(value), 0.1)
        ahead, back = x.copy(), x.copy()
        ahead[j] += h
        back[j] -= h
        columns.append((f(ahead) - f(back)).ravel() / (2.0 * h))
    return np.stack(columns, 1)


def fit_drag(way: NDArray, ratio: NDArray) -> tuple[NDArray, int]:
    """mu1, mu2, angle and rule that explain ratios of friction, from twelve angles and three rules.

    The first points of each course are no steady drag: a point counts less the worse it fits.
    """
    best, start = np.inf, (np.array([.1, .1, 0.0]), 0)
    mean = np.median(np.linalg.norm(ratio, axis=1))
    for m, angle in itertools.product(range(3), np.arange(12) * np.pi / 12.0):
        x = np.array([1.2 * mean, 0.8 * mean, angle])

        def model(p: NDArray, rule: int = m) -> NDArray:
            return drag(p[0], p[1], p[2], rule, way)
        for _ in range(25):
            r = (model(x) - ratio).ravel()
            weight = 1.0 / np.maximum(np.abs(r), 0.02 * mean)
            j = differences(model, x)
            a = j.T @ (weight[:, None] * j)
            step = np.linalg.solve(a + 1e-3 * np.diag(np.diag(a) + 1e-12), -j.T @ (weight * r))
            x = x + np.clip(step, -0.3, 0.3)
        r = np.abs((model(x) - ratio).ravel())
        cost = np.sum(np.minimum(r, 0.1 * mean))
        if cost < best - 1e-9:
            best, start = cost, (x, m)
    return start


def canonical(mu1: float, mu2: float, degrees: float) -> tuple[float, float, float]:
    """The same law with mu1 >= mu2 and the angle in (-90, 90]."""
    if mu2 > mu1:
        mu1, mu2, degrees = mu2, mu1, degrees + 90.0
    degrees = (degrees + 90.0) % 180.0 - 90.0
    return mu1, mu2, 90.0 if degrees == -90.0 else degrees


class Estimate:
    """Jacobian in units of the deviations, and what follows from it."""

    def __init__(self, names: list[str], jacobian: NDArray):
        self.names = names
        lengths = np.linalg.norm(jacobian, axis=0)
        self.dead = [name for name, length in zip(names, lengths) if length < 1e-12]
        scaled = jacobian / np.where(lengths > 0.0, lengths, 1.0)
        _, singular, vectors = np.linalg.svd(scaled, full_matrices=False)
        self.condition = singular[0] / max(singular[-1], 1e-300)
        self.shares = vectors[-1]
        self.weakest = vectors[-1] / np.where(lengths > 0.0, lengths, 1.0)
        inverse = vectors.T @ np.diag(1.0 / np.maximum(singular, 1e-12)**2) @ vectors
        scale = np.where(lengths > 0.0, lengths, 1e-12)
        self.covariance = inverse / np.outer(scale, scale)
        self.sd = np.sqrt(np.diag(self.covariance))

    @property
    def determined(self) -> bool:
        """Intervals mean something."""
        return not self.dead and self.condition <= DETERMINED

    def correlation(self) -> NDArray:
        """Correlation matrix."""
        return self.covariance / np.outer(self.sd, self.sd)

    def combination(self) -> str:
        """What is not determined, in words."""
        if self.dead:
            return f'{", ".join(self.dead)}: nothing that was measured depends on it'
        v = self.weakest / np.abs(self.weakest).max()
        return 'any multiple of (' + ', '.join(f'{value:+.2g} {name}' for name, value, share in zip(
            self.names, v, self.shares) if abs(share) > 0.05) + ')'


class Problem:
    """Deck, data and parameters of one identification."""

    def __init__(self, deck: Deck, data: Measured, names: list[str], with_rule: bool,
                 bounds: dict[str, tuple[float, float]]):
        self.deck, self.data, self.names, self.with_rule = deck, data, names, with_rule
        self.bounds = bounds
        self.columns = names + (['slip'] if with_rule else [])

    def evaluate(self, x: NDArray, rule: int) -> tuple[NDArray, NDArray, NDArray]:
        """Residuals over deviations, their derivatives by all columns, and forces."""
        times, force, jacobian = self.deck.run(self.names, list(x), rule, self.columns)
        k = self.data.force.shape[1]
        values = self.data.at(times, force[:, :k])
        slopes = self.data.at(times, jacobian[:, :k])
        r = (values - self.data.force) / self.data.sigma
        j = slopes / self.data.sigma[:, :, None]
        return r.ravel(), j.reshape(r.size, -1), values

    def clip(self, x: NDArray) -> NDArray:
        """Parameters within their bounds."""
        low = np.array([self.bounds.get(name, (-np.inf, np.inf))[0] for name in self.names])
        high = np.array([self.bounds.get(name, (-np.inf, np.inf))[1] for name in self.names])
        return np.clip(x, low, high)

    def fit(self, x: NDArray, rule: int) -> Fit:
        """Levenberg-Marquardt; a rule that the data do not want is changed on the way."""
        best: Optional[Fit] = None
        damping, tried = 1e-3, {rule}
        n = len(self.names)
        for _ in range(MOST_RUNS):
            r, j, values = self.evaluate(x, rule)
            chi2 = float(r @ r)
            if best is None or chi2 <= best.chi2 or best.rule != rule:
                best = Fit(x, rule, r, j, values, chi2)
                damping = max(damping / 10.0, 1e-9)
            else:
                damping = min(damping * 30.0, 1e6)
            if self.with_rule:
                step = np.linalg.lstsq(best.jacobian, -best.r, rcond=1e-8)[0]
                best.m = best.rule + step[-1]
                wanted = int(np.clip(round(best.m), 0, 2))
                if wanted not in tried and abs(best.m - best.rule) > 0.6:
                    tried.add(wanted)
                    x, rule = self.clip(best.x + step[:n]), wanted
                    continue
            mine = best.jacobian[:, :n]
            a = mine.T @ mine
            step = np.linalg.solve(a + damping * np.diag(np.diag(a) + 1e-30), -mine.T @ best.r)
            sd = np.sqrt(np.diag(np.linalg.pinv(a)))
            gain = -float(2.0 * step @ (mine.T @ best.r) + step @ a @ step)
            if gain < 1e-3 * max(1.0, best.chi2 / max(1, len(r) - n)) and \
                    np.all(np.abs(step) < 0.05 * sd + 1e-12):
                break
            x = self.clip(best.x + step)
        assert best is not None
        return best


class Fit:
    """Where a fit has come to."""

    def __init__(self, x: NDArray, rule: int, r: NDArray, jacobian: NDArray, values: NDArray,
                 chi2: float):
        self.x, self.rule, self.r, self.jacobian = x, rule, r, jacobian
        self.values, self.chi2 = values, chi2
        self.m = float(rule)


def first_guess(deck: Deck, data: Measured, names: list[str], roles: dict[str, str]) \
        -> tuple[NDArray, int]:
    """Start from steady drag: the ways are those of a run whose friction opposes the slip."""
    x = np.array(deck.values(names))
    if not {'mu1', 'mu2', 'phi'} <= set(roles) or not {roles['mu1'], roles['mu2']} <= set(names):
        return x, deck.rule
    times, force, _ = deck.run([], [], 0, [])
    force = data.at(times, force)
    size = np.linalg.norm(force[:, :2], axis=1)
    steady = size > 0.5 * size.max()
    way = force[steady, :2] / size[steady, None]
    pressure = np.abs(data.force[steady, 2] if data.force.shape[1] > 2 else force[steady, 2])
    found, rule = fit_drag(way, data.force[steady, :2] / pressure[:, None])
    mu1, mu2, angle = canonical(abs(found[0]), abs(found[1]), np.degrees(found[2]) - deck.lay())
    # the branch next to what the deck says
    if roles['phi'] in names:
        value = x[names.index(roles['phi'])]
        angle += 180.0 * round((value - angle) / 180.0)
        x[names.index(roles['phi'])] = angle
    x[names.index(roles['mu1'])] = max(mu1, 1e-4)
    x[names.index(roles['mu2'])] = max(mu2, 1e-4)
    return x, rule


def other_paths(deck: Deck, names: list[str], x: NDArray, rule: int, roles: dict[str, str],
                points: int, share: float, with_rule: bool) -> list[str]:
    """What a circle and a triangle would give, by steady drag."""
    if not {'mu1', 'mu2', 'phi'} <= set(roles):
        return []
    value = dict(zip(names, x))
    try:
        mu1, mu2, phi = (value.get(roles[role], None) for role in ('mu1', 'mu2', 'phi'))
        mu1, mu2, phi = (deck.values([roles[role]])[0] if v is None else v
                         for role, v in (('mu1', mu1), ('mu2', mu2), ('phi', phi)))
    except Identification:
        return []
    start = np.array([mu1, mu2, (phi + deck.lay()) * UNIT, float(rule)][:4 if with_rule else 3])
    lines = []
    for name, turns in (('a circle', np.arange(points) / points),
                        ('a triangle 0, 120, 240 degrees', np.arange(points) * 3 // points / 3.0)):
        way = np.stack([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns)], 1)

        def model(p: NDArray, way: NDArray = way) -> NDArray:
            return drag(p[0], p[1], p[2], p[3] if with_rule else rule, way)
        estimate = Estimate(['mu1', 'mu2', 'phi', 'slip'][:len(start)],
                            differences(model, start) / (share * np.abs(model(start)).max()))
        text = f'mu1 {100 * estimate.sd[0] / mu1:.2g} %, mu2 {100 * estimate.sd[1] / mu2:.2g} %, ' \
            f'phi {np.degrees(estimate.sd[2]):.2g} degrees'
        if with_rule:
            text += f', slip {estimate.sd[3]:.2g}'
        lines.append(f'  {name} of the same points would give {text} (condition '
                     f'{estimate.condition:.2g})')
    return lines


def table_of(estimate: Estimate, values: NDArray, level: float) -> list[str]:
    """Values with intervals and the correlation matrix."""
    z = statistics.NormalDist().inv_cdf(0.5 + level / 200.0)
    width = max(len(name) for name in estimate.names)
    lines = [f'{"":{width}}  {"value":>12}  {"sd":>10}  {level:g} % interval']
    for name, value, sd in zip(estimate.names, values, estimate.sd):
        lines.append(f'{name:{width}}  {value:12.6g}  {sd:10.3g}  {value - z * sd:.6g} .. '
                     f'{value + z * sd:.6g}')
    lines.append('correlations')
    for name, row in zip(estimate.names, estimate.correlation()):
        lines.append(f'{name:{width}}  ' + ' '.join(f'{value:7.3f}' for value in row))
    return lines


def rule_lines(estimate: Estimate, m: float) -> list[str]:
    """Probabilities of the slip rules from the interval of m."""
    sd = estimate.sd[-1]
    weight = np.exp(-0.5 * ((np.arange(3) - m) / sd)**2 + 0.5 * np.min(
        ((np.arange(3) - m) / sd)**2))
    return ['slip rule: ' + ', '.join(f'{name} (m = {k}) {p:.3f}' for k, (name, p) in enumerate(
        zip(RULES, weight / weight.sum())))]


def isotropic(names: list[str], fit: Fit, roles: dict[str, str]) -> list[str]:
    """A word where mu1 and mu2 are the same within what is known."""
    if not {'mu1', 'mu2'} <= set(roles) or not {roles['mu1'], roles['mu2']} <= set(names):
        return []
    i, k = names.index(roles['mu1']), names.index(roles['mu2'])
    only = Estimate([names[i], names[k]], fit.jacobian[:, [i, k]])
    sd = np.sqrt(only.covariance[0, 0] + only.covariance[1, 1] - 2.0 * only.covariance[0, 1])
    if abs(fit.x[i] - fit.x[k]) > 2.0 * sd:
        return []
    return [f'{names[i]} and {names[k]} differ by less than two deviations ({2.0 * sd:.2g}): the '
            'friction is isotropic as far as these data go, and neither the angle of the lay nor '
            f'the slip rule has a meaning. One coefficient: {(fit.x[i] + fit.x[k]) / 2.0:.6g}']


def draw(path: str, data: Measured, fit: Fit) -> None:
    """Data, fit and residual over time."""
    from . import style
    plt = style.pyplot()
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7.0, 5.5), height_ratios=(2, 1))
    colours = (style.BLUE, style.RED, style.GREEN)
    residual = (fit.values - data.force) / data.sigma
    for k in range(data.force.shape[1]):
        axes[0].errorbar(data.time, data.force[:, k], data.sigma[:, k], fmt='o', ms=3,
                         color=colours[k], label=f'R{k + 1}')
        axes[0].plot(data.time, fit.values[:, k], color=colours[k])
        axes[1].plot(data.time, residual[:, k], 'o', ms=3, color=colours[k])
    axes[0].set_ylabel('force')
    axes[0].legend()
    axes[1].axhline(0.0, color=style.GREY, lw=1)
    axes[1].set_ylabel('residual / deviation')
    axes[1].set_xlabel('time')
    figure.tight_layout()
    figure.savefig(path, dpi=300)
    plt.close(figure)


def read_bounds(words: list[str]) -> dict[str, tuple[float, float]]:
    """--bounds name=low:high."""
    found = {}
    for word in words:
        try:
            name, values = word.split('=')
            low, high = map(float, values.split(':'))
        except ValueError as problem:
            raise Identification(f'--bounds {word}: write name=low:high') from problem
        found[name] = (low, high)
    return found


def plan(deck: Deck, given: argparse.Namespace, names: list[str], with_rule: bool) -> list[str]:
    """--plan: what the path of the deck would determine."""
    x = np.array(deck.values(names))
    columns = names + (['slip'] if with_rule else [])
    times, force, jacobian = deck.run(names, list(x), deck.rule, columns)
    sigma = deviation(given.sigma, force[:, :2])
    estimate = Estimate(columns, (jacobian[:, :2] / sigma[:, :, None]).reshape(
        -1, len(columns)))
    values = np.append(x, deck.rule) if with_rule else x
    lines = [f'plan: {len(times)} output times of {given.deck}, forces R1 and R2 of '
             f'{given.set_name}, deviation {given.sigma}',
             f'condition number {estimate.condition:.3g}']
    share = float(given.sigma[:-1]) / 100.0 if given.sigma.endswith('%') else 0.01
    better = other_paths(deck, names, x, deck.rule, deck.roles(), len(times), share, with_rule)
    if estimate.determined:
        return lines + table_of(estimate, values, given.level) + better
    return lines + [f'not determined: {estimate.combination()}'] + better


def identify(given: argparse.Namespace) -> tuple[list[str], bool]:
    """The report, and whether the parameters are determined."""
    names = [name for name in given.fit.split(',') + given.nuisance.split(',') if name]
    with_rule = 'slip' in names
    names = [name for name in names if name != 'slip']
    if not names:
        raise Identification('--fit wants a parameter of the deck')
    deck = Deck(given.deck, find_program(given.program), given.set_name)
    if given.plan:
        lines = plan(deck, given, names, with_rule)
        return lines, not any(line.startswith('not determined') for line in lines)
    data = read_data(given)
    problem = Problem(deck, data, names, with_rule, read_bounds(given.bounds))
    roles = deck.roles()
    x, rule = (np.array(deck.values(names)), deck.rule) if given.start == 'deck' else first_guess(
        deck, data, names, roles)
    if not with_rule:
        rule = deck.rule
    fit = problem.fit(problem.clip(x), rule)
    runs = deck.runs
    estimate = Estimate(problem.columns, fit.jacobian)
    values = np.append(fit.x, fit.m) if with_rule else fit.x.copy()
    dof = fit.r.size - len(problem.columns)
    lines = [f'{runs} runs of mfec; chi2 {fit.chi2:.4g} at {dof} degrees of freedom',
             f'condition number {estimate.condition:.3g}']
    if set(roles.values()) <= set(names) and len(roles) == 3:
        i, k, a = (names.index(roles[role]) for role in ('mu1', 'mu2', 'phi'))
        if fit.x[k] <= fit.x[i]:
            values[a] = canonical(fit.x[i], fit.x[k], fit.x[a])[2]
    alike = isotropic(names, fit, roles) if set(roles.values()) & set(names) else []
    if alike:
        lines += alike
    elif estimate.determined:
        lines += table_of(estimate, values, given.level)
        if with_rule:
            lines += rule_lines(estimate, fit.m)
    else:
        share = float(np.median(data.sigma)) / max(np.abs(data.force[:, :2]).max(), 1e-300)
        lines += ['no intervals: the path does not determine ' + estimate.combination(),
                  'values that fit: ' + ', '.join(f'{n} = {v:.6g}' for n, v in zip(
                      problem.columns, values))]
        lines += other_paths(deck, names, fit.x, fit.rule, roles, len(data.time), share, with_rule)
    if given.refits and with_rule:
        chi2 = [problem.fit(fit.x, k).chi2 if k != fit.rule else fit.chi2 for k in range(3)]
        weight = np.exp(-0.5 * (np.array(chi2) - min(chi2)))
        lines += ['three fits: ' + ', '.join(f'{name} chi2 {c:.4g}, {p:.3f}' for name, c, p in zip(
            RULES, chi2, weight / weight.sum()))]
    draw(given.out, data, fit)
    return lines + [given.out], bool(alike) or estimate.determined


def main(given: argparse.Namespace) -> int:
    """Exit code 0: done; 1: the path does not determine what is sought; 2: not to be done."""
    try:
        lines, determined = identify(given)
    except (OSError, Identification, TableError) as problem:
        print(f'mfec-post identify: {problem}', file=sys.stderr)
        return 2
    for line in lines:
        print(line)
    return 0 if determined else 1
