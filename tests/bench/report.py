"""Writes benchmark.md, bench/results.csv and the figures."""
import csv
import os
import time

import figures
import measure
import targets

COLUMNS = ('scene', 'size', 'program', 'complete', 'dofs', 'elements', 'cpu', 'wall', 'memory',
           'runs', 'increments', 'iterations', 'cuts', 'code', 'T/N_error', 'force_error',
           'pressure_error', 'largest_error', 'tip_error', 'date', 'load')


def write(folder, found, programs, started, machine_limits, quick):
    """Everything, from the results of the runs alone."""
    inner = os.path.join(folder, 'bench')
    os.makedirs(inner, exist_ok=True)
    write_csv(os.path.join(inner, 'results.csv'), found)
    figures.draw(inner, found)
    rows = targets.rows(found, started)
    text = head(programs, machine_limits, found, quick) + target_table(rows)
    text += cube_table(found) + scaling_table(found) + hertz_table(found) + tip_table(found)
    with open(os.path.join(folder, 'benchmark.md'), 'w', encoding='utf-8') as stream:
        stream.write(text)


def write_csv(path, found):
    """One line a run."""
    with open(path, 'w', encoding='utf-8', newline='') as stream:
        writer = csv.writer(stream, lineterminator='\n')
        writer.writerow(COLUMNS)
        for job, result in found.items():
            own = {'scene': job.scene, 'size': job.size, 'program': figures.label(job),
                   'complete': 'no' if job.limit else 'yes'}
            writer.writerow([show(own.get(name, result.get(name))) for name in COLUMNS])


def show(value):
    """A cell of the CSV file."""
    return '' if value is None else f'{value:.6g}' if isinstance(value, float) else value


def head(programs, limits, found, quick):
    """What was measured, where, and how."""
    machine = measure.machine()
    loads = [r['load'] for r in found.values()]
    return f'''# Benchmark: how long until the answer is there

Written by `make bench{"-quick" if quick else ""}` (`tests/bench/bench`); no number here was written by hand. All runs: [bench/results.csv](bench/results.csv).

- Machine: {machine["processor"]}, {machine["cores"]} cores, {machine["memory"]} GB, {machine["system"]}; {time.strftime("%d %B %Y")}.
- In one thread its dgemm does {limits["dgemm"]:.0f} GFlop/s, a copy moves {limits["copy"]:.0f} GB/s.
- Programs: {"; ".join(programs.versions())}.
- One thread each (`OPENBLAS_NUM_THREADS=1`, `OMP_NUM_THREADS=1`, `OPENBLAS_CORETYPE` unset). *CPU* is user and system time of the whole process, from start to exit, median of up to {measure.REPEATS} runs (one, where it takes more than {measure.ENOUGH:g} s). The machine was shared: load {min(loads):.1f} to {max(loads):.1f}, so wall time says little and even CPU times vary by a tenth or two.
- Both programs read the same mesh file (nodes, linear tetrahedra, sets, surfaces), take the same increments and the same pressure per penetration, with the same stiffness of stick. Neither writes fields, except the contact pressures where they are judged.
- mfec iterates to its default tolerance (energy 1e-16); CalculiX to its own (0.5 % of the mean force).
- CalculiX *default* is SPOOLES, *iterative* is `SOLVER=ITERATIVE SCALING`; N2S node to surface, S2S surface to surface.
- "about": only the first increment was run; the time of an iteration is taken times the iterations of the complete run on the same mesh (CalculiX with its iterative solver, mfec with AUTO).

![time and memory against size](bench/time_size.png)

![time against error](bench/time_error.png)

'''


def table(columns, rows):
    """A Markdown table."""
    lines = ['| ' + ' | '.join(columns) + ' |', '|' + '---|'*len(columns)]
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n\n'


def target_table(rows):
    """The targets and what was measured."""
    return '## Targets\n\nRatios of CPU time, larger is better for mfec. The last column says where mfec\'s time goes in the run that decides the row.\n\n' + table(
        ('target', 'wanted', 'measured', 'met', 'what limits it'),
        [(r.what, r.wanted, r.measured, r.verdict(), r.limit) for r in rows])


def percent(value):
    """An error in percent."""
    return '' if value is None else f'{100*value:+.2f}'


def cube_table(found):
    """The sliding cube, one row a run, with the ratio to mfec's own choice."""
    rows = []
    for job, r in sorted(found.items(), key=lambda item: (item[0].scene, item[0].size)):
        if not job.scene.startswith('cube'):
            continue
        own = targets.Runs(found).get(job.scene, job.size, 'AUTO')
        time_of, guess = targets.Runs(found).cpu(job.scene, job.size, job.mode)
        ratio = f'{time_of/own["cpu"]:.2g}' if own and time_of else ''
        each = f'{r["cpu"]/r["iterations"]:.3g}' if r.get('iterations') else ''
        name = {'cube': 'friction', 'cube_smooth': 'no friction', 'cube_once': 'slide in one increment',
                'cube_neo': 'neo-Hooke'}[job.scene]
        rows.append((name, f'{job.size:g}', f'{r["dofs"]:,}', figures.label(job),
                     outcome(job, r), f'{r["wall"]:.3g}', each, f'{r["memory"]:.0f}',
                     f'{r.get("iterations", "")}', f'{r.get("cuts", "")}', percent(r.get('T/N_error')),
                     ('about ' if guess else '') + ratio))
    return ('## Sliding cube\n\nAn elastic cube of n cells an edge is pressed by 1/200 of its edge (2 increments) on an elastic block of 3 x 2 x 0.5 edges and moved by half an edge (20 increments), mu = 0.1. '
            '*T/N*: error of the mean of tangential over normal force once the cube slides as a whole.\n\n'
            + table(('scene', 'n', 'dofs', 'program', 'CPU [s]', 'wall [s]', 'CPU an iteration [s]',
                     'memory [MB]', 'iterations', 'cuts', 'T/N [%]', 'CPU against mfec AUTO'), rows))


def outcome(job, result):
    """The CPU time, or what else became of a run."""
    if job.limit:
        return f'{result["cpu"]:.3g} (first increment)'
    if result['late']:
        return f'over {result["cpu"]:.0f}'
    return f'{result["cpu"]:.3g}' + ('' if result['code'] == 0 else f' (exit code {result["code"]})')


def scaling_table(found):
    """mfec alone, n = 10 to 30."""
    rows, before = [], None
    for n in (10, 15, 20, 25, 30):
        r = targets.Runs(found).get('cube', n, 'AUTO')
        if not r:
            continue
        factor = targets.factorisation(r)
        slope = ''
        if before:
            slope = f'{targets.math.log(r["cpu"]/before["cpu"])/targets.math.log(r["dofs"]/before["dofs"]):.2f}'
        rows.append((str(n), f'{r["dofs"]:,}', f'{r["cpu"]:.3g}', f'{factor:.3g}',
                     f'{100*factor/r["cpu"]:.0f}', f'{r["cpu"] - factor:.3g}', f'{r["memory"]:.0f}', slope))
        before = r
    if not rows:
        return ''
    return '## Cost against size\n\nmfec AUTO on the sliding cube with friction. The last column is the power p of CPU ~ dofs^p from the row above.\n\n' + table(
        ('n', 'dofs', 'CPU [s]', 'factorisation [s]', 'share [%]', 'the rest [s]', 'memory [MB]', 'growth p'),
        rows)


def hertz_table(found):
    """Work and precision of Hertz."""
    rows = [(f'{job.size:g}', f'{r["dofs"]:,}', figures.label(job), outcome(job, r),
             f'{r["memory"]:.0f}', f'{r.get("iterations", "")}', percent(r.get('force_error')),
             percent(r.get('pressure_error')), percent(r.get('largest_error')))
            for job, r in sorted(found.items(), key=lambda item: -item[0].size)
            if job.scene == 'hertz']
    return ('## Hertz\n\nA paraboloid on a plate, both elastic, a quarter, no friction, 4 increments; the far faces move as those of half-spaces. *h/a*: facet over radius of contact. *force*: against Hertz at the given approach. '
            '*p0*: peak pressure, from a parabola through the pressures at the nodes, against Hertz for the computed force; *largest*: the largest value at a node, likewise.\n\n'
            + table(('h/a', 'dofs', 'program', 'CPU [s]', 'memory [MB]', 'iterations', 'force [%]',
                     'p0 [%]', 'largest [%]'), rows))


def tip_table(found):
    """The cantilever."""
    rows = [(f'{job.size:g}', f'{r["dofs"]:,}', figures.label(job), outcome(job, r),
             f'{r["memory"]:.0f}', percent(r.get('tip_error')))
            for job, r in sorted(found.items(), key=lambda item: item[0].size)
            if job.scene == 'cantilever']
    return ('## Cantilever\n\nPure bending, 2n x n x n cells, no contact, one increment; the error is that of the deflection of the tip (exact solution).\n\n'
            + table(('n', 'dofs', 'program', 'CPU [s]', 'memory [MB]', 'tip [%]'), rows))
