"""The table of targets: each row is computed from the runs, or says which runs it lacks."""
import dataclasses
import math

import bare
from jobs import CANTILEVER, CUBE, HERTZ, Job

DEFAULT, BEST = 'N2S default', ('N2S default', 'N2S iterative')
NOT_RUN = 'not measured in this form'


@dataclasses.dataclass
class Row:
    """One target; `met` is None where nothing was measured."""

    what: str
    wanted: str
    measured: str = NOT_RUN
    met: bool = None
    missed: str = ''
    limit: str = ''

    def verdict(self):
        """The last but one column."""
        if self.met is None:
            return '–'
        return 'yes' if self.met else 'no: ' + self.missed


class Runs:
    """Looks runs up and completes those that were cut short."""

    def __init__(self, found):
        self.found = found

    def get(self, *job, **more):
        """The result of a complete run that ended well, None if there is none."""
        result = self.found.get(Job(*job, **more))
        return result if result and result['code'] == 0 else None

    def cpu(self, scene, size, mode, method='NTOS'):
        """Processor time and whether it is an estimate: time of an iteration over the first
        increment, times the iterations of a complete run on the same mesh."""
        result = self.get(scene, size, mode, method=method)
        if result:
            return result['cpu'], False
        part = self.found.get(Job(scene, size, mode, 1))
        like = self.get(scene, size, 'N2S iterative' if mode == DEFAULT else 'AUTO')
        if part and like and part.get('iterations'):
            return part['cpu']/part['iterations']*like['iterations'], True
        return None, False

    def best_other(self, scene, size, modes=BEST):
        """The fastest of several settings of CalculiX; nothing, if one was not run."""
        times = [self.cpu(scene, size, mode) + (mode,) for mode in modes]
        return (None, False, '') if any(t[0] is None for t in times) else min(times)


def largest_cost(result, most=2):
    """Where most of the time of a run goes, from its cost table."""
    costs = {k: v for k, v in (result or {}).get('costs', {}).items() if k != 'whole run'}
    whole = (result or {}).get('costs', {}).get('whole run', 0.0)
    if not costs or not whole:
        return ''
    parts = sorted(costs.items(), key=lambda item: -item[1])[:most]
    return ', '.join(f'{name} {100*value/whole:.0f} %' for name, value in parts)


def ratios(runs, row, sizes, wanted, other):
    """Fills a row with the ratios other/mfec at several sizes; other(n) is (time, estimated, ..)."""
    text, misses, last, share = [], [], None, ''
    for n, least in zip(sizes, wanted):
        own, theirs = runs.get(CUBE, n, 'AUTO'), other(n)
        if not own or theirs[0] is None:
            continue
        ratio = theirs[0]/own['cpu']
        text.append(f'n={n}: {"about " if theirs[1] else ""}{ratio:.3g}x')
        last = own
        if ratio < least:
            misses.append(f'n={n} by {least/ratio:.3g}x')
            share = f'n={n}: the one factorisation alone takes ' \
                f'{100*factorisation(own)*least/theirs[0]:.0f} % of the {theirs[0]/least:.3g} s ' \
                'that are wanted; of the whole run: '
    if text:
        row.measured, row.met = ', '.join(text), not misses
        row.missed = ', '.join(misses)
        row.limit = share + largest_cost(last)
    return row


def memory(runs):
    """Peak memory against CalculiX."""
    row = Row('memory at equal mesh, sliding cube', 'below the best CalculiX setting up to n=12, '
              'below its default everywhere')
    text, misses = [], []
    for n in (4, 8, 12, 16, 20):
        own = runs.get(CUBE, n, 'AUTO')
        best = [r['memory'] for r in (runs.get(CUBE, n, mode) for mode in BEST) if r]
        default = runs.found.get(Job(CUBE, n, DEFAULT)) or runs.found.get(Job(CUBE, n, DEFAULT, 1))
        if not own or not (best or default):
            continue
        part = f'n={n}: {own["memory"]:.0f} MB'
        if len(best) == len(BEST) and n <= 12:
            part += f' (best {min(best):.0f})'
            if own['memory'] >= min(best):
                misses.append(f'n={n} {own["memory"]/min(best):.2g} times the best')
        if default:
            part += f' (default {default["memory"]:.0f})'
            if own['memory'] >= default['memory']:
                misses.append(f'n={n} {own["memory"]/default["memory"]:.2g} times the default')
        text.append(part)
    if text:
        row.measured, row.met, row.missed = ', '.join(text), not misses, ', '.join(misses)
    empty = runs.get(CANTILEVER, 4, 'AUTO')
    if misses and empty:
        row.limit = f'small scenes: the shared libraries and their work space (the cantilever of ' \
            f'{empty["dofs"]} dofs takes {empty["memory"]:.0f} MB); large ones: the factors'
    return row


def part(result, names):
    """Processor time of some rows of the cost table, whose seconds are by the clock."""
    share = sum(result['costs'].get(name, 0.0) for name in names)/result['costs']['whole run']
    return share*result['cpu']


ITERATION = ('contact search', 'contact tangent', 'residual', 'dense factorisation', 'solve')
INSIDE = ('recovery of interior dofs',)


def newton_seconds(result, more=()):
    """Time of the rows that belong to the iterations. What a run does once (reading, factors of the
    bodies, their compliance), or once an increment whatever the contact (the displacements inside,
    output), is not among them; sparse factors are, where each iteration makes one."""
    names = (*ITERATION, *more)
    if result.get('counts', {}).get('symmetric factorisation', 0) > 3:
        names += ('symmetric factorisation', 'unsymmetric factorisation')
    return part(result, names)


def frictionless(runs):
    """The Newton part without and with friction."""
    row = Row('frictionless against friction, the Newton part (of the cost table: '
              + ', '.join(ITERATION) + ')', '3x less')
    for n in (20, 16, 12, 8):
        rough, smooth = runs.get(CUBE, n, 'AUTO'), runs.get('cube_smooth', n, 'AUTO')
        if rough and smooth:
            ratio, wider = (newton_seconds(rough, more)/max(newton_seconds(smooth, more), 1e-6)
                            for more in ((), INSIDE))
            row.measured, row.met = f'n={n}: {ratio:.3g}x ({wider:.3g}x with the displacements ' \
                f'inside; the whole run {rough["cpu"]/smooth["cpu"]:.3g}x)', ratio >= 3
            row.missed, row.limit = f'by {3/ratio:.2g}x', newton_limit(smooth)
            break
    return row


def newton_limit(result):
    """Where the Newton part goes, row by row."""
    whole = max(newton_seconds(result), 1e-6)
    shares = sorted(((part(result, [name])/whole, name) for name in ITERATION), reverse=True)
    return 'of the Newton part: ' + ', '.join(f'{name} {100*x:.0f} %' for x, name in shares[:3])


def iterations(runs):
    """Iterations of an increment, increments lost, the slide in one increment."""
    row = Row('Newton iterations an increment, sliding', 'median 3, no increment lost; the whole '
              'slide in one increment converges, T/N within 0.5 %')
    text, misses = [], []
    for n in (4, 8, 12, 16, 20):
        own = runs.get(CUBE, n, 'AUTO')
        if own:
            text.append(f'n={n}: median {own["median_iterations"]:g}, cuts {own["cuts"]}')
            if own['median_iterations'] > 3:
                misses.append(f'n={n} median {own["median_iterations"]:g}')
            if own['cuts']:
                misses.append(f'n={n} {own["cuts"]} cuts')
        once = runs.found.get(Job('cube_once', n, 'AUTO'))
        if once:
            if once['code']:
                misses.append(f'n={n} in one increment: exit code {once["code"]}')
                continue
            text.append(f'in one increment: {once["iterations"]} iterations, {once["cuts"]} cuts, '
                        f'T/N {100*once["T/N_error"]:+.2f} %')
            if abs(once['T/N_error']) > 0.005 or once['cuts']:
                misses.append(f'n={n} in one increment')
    if text:
        row.measured, row.met, row.missed = '; '.join(text), not misses, ', '.join(misses)
    return row


def hertz(runs):
    """Least time to 5 % of the peak pressure of the computed force."""
    row = Row('time to 5 % on the Hertz peak pressure belonging to the computed force',
              '10x less than the best CalculiX setting that reaches it')

    def least(own):
        reached = [(r['cpu'], job) for job, r in runs.found.items()
                   if job.scene == HERTZ and r['code'] == 0 and job.of_calculix() != own
                   and r.get('pressure_error') is not None and stays(runs, job)]
        return min(reached, key=lambda pair: pair[0]) if reached else None

    ours, theirs = least(True), least(False)
    if ours and theirs:
        ratio = theirs[0]/ours[0]
        row.measured = (f'{ratio:.3g}x ({ours[0]:.3g} s at h/a = {ours[1].size:g}, {ours[1].method}; '
                        f'CalculiX {theirs[1].mode} {theirs[0]:.3g} s at {theirs[1].size:g})')
        row.met, row.missed = ratio >= 10, f'by {10/ratio:.2g}x'
        row.limit = largest_cost(runs.found[ours[1]])
    return row


def stays(runs, job):
    """Within 5 % on this mesh and on all finer ones that were run: no lucky crossing."""
    errors = [r.get('pressure_error') for other, r in runs.found.items()
              if other.scene == HERTZ and other.mode == job.mode and other.method == job.method
              and other.size <= job.size and r['code'] == 0]
    return all(e is not None and abs(e) <= 0.05 for e in errors)


def growth(runs):
    """The part beside the factorisation may grow no faster than linearly."""
    row = Row('cost against size, n=10 to 30', 'total no steeper than one factorisation plus linear')
    first, last = runs.get(CUBE, 10, 'AUTO'), runs.get(CUBE, 30, 'AUTO')
    if first and last:
        rest = [r['cpu'] - factorisation(r) for r in (first, last)]
        power = math.log(rest[1]/rest[0])/math.log(last['dofs']/first['dofs'])
        row.measured = f'what is not factorisation grows as dofs^{power:.2f}'
        row.met, row.missed = power <= 1.0, f'power {power:.2f} instead of 1'
        row.limit = largest_cost(last)
    return row


def power(small, large):
    """p of CPU ~ dofs^p between two runs."""
    return math.log(large['cpu']/small['cpu'])/math.log(large['dofs']/small['dofs'])


def factorisation(result):
    """Processor time of the factorisations of a run."""
    return part(result, ('symbolic factorisation', 'unsymmetric factorisation',
                         'symmetric factorisation'))


def linear(runs):
    """No contact: counts, and the whole against the factorisation and solve alone."""
    row = Row('a scene with no contact, linear', 'one factorisation, within 1.3x of a bare CHOLMOD '
              'program')
    for n in (32, 24, 16, 8):
        own = runs.get(CANTILEVER, n, 'AUTO')
        least = runs.found.get(Job(CANTILEVER, n, bare.MODE))
        if own and least:
            counts = own['counts']
            number = counts.get('symmetric factorisation', 0) + counts.get(
                'unsymmetric factorisation', 0)
            ratio = own['cpu']/least['cpu']
            row.measured = f'{number} factorisations, {ratio:.2f}x ({own["dofs"]} dofs)'
            row.met = number == 1 and ratio <= 1.3
            row.missed = f'{number} factorisations, {ratio:.2f}x'
            row.limit = largest_cost(own)
            break
    return row


def neo(runs):
    """Neo-Hooke against UMFPACK in each iteration."""
    row = Row('neo-Hooke bulk, against UMFPACK each iteration', 'n=20: 15x')
    own, (theirs, guess) = runs.get('cube_neo', 20, 'AUTO'), runs.cpu('cube_neo', 20, 'UMFP')
    if own and theirs:
        ratio = theirs/own['cpu']
        row.measured = f'n=20: {"about " if guess else ""}{ratio:.3g}x'
        row.met, row.missed, row.limit = ratio >= 15, f'by {15/ratio:.2g}x', largest_cost(own)
    return row


def start(started):
    """The start of the program: by the clock, unless others use the machine."""
    row = Row('start-up: a deck of 10 elements', 'under 50 ms')
    busy = started['load'] > started['cores']
    seconds = started['cpu'] if busy else started['wall']
    row.measured = (f'{1e3*started["wall"]:.0f} ms by the clock (least of 15), '
                    f'{1e3*started["cpu"]:.0f} ms of CPU (median)'
                    + ('; the machine was busy: CPU counts' if busy else ''))
    row.met = started['code'] == 0 and seconds < 0.05
    row.missed = f'{1e3*seconds:.0f} ms'
    return row


def rows(found, started):
    """All rows in the order of the specification."""
    runs = Runs(found)
    return [
        ratios(runs, Row('sliding cube, linear bulk, against the best CalculiX setting '
                         '(node to surface)', 'n=12, 16, 20: 20x less'),
               (12, 16, 20), (20, 20, 20), lambda n: runs.best_other(CUBE, n)),
        ratios(runs, Row('the same against CalculiX\'s default (SPOOLES)',
                         'n=8: 40x, n=12: 80x, n=20: 150x less'),
               (8, 12, 20), (40, 80, 150), lambda n: runs.cpu(CUBE, n, DEFAULT)),
        ratios(runs, Row('the same, against mfec\'s own UMFPACK-each-iteration mode',
                         'n=12: 25x, n=20: 60x'),
               (12, 20), (25, 60), lambda n: runs.cpu(CUBE, n, 'UMFP')),
        memory(runs), neo(runs), frictionless(runs), linear(runs), iterations(runs), hertz(runs),
        growth(runs), start(started)]
