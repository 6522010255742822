"""Writes benchmark.md, bench/results.csv and the figures."""
import csv
import dataclasses
import os
import time

import bare
import equal_error
import figures
import large
import large_cubes
import measure
import paired
import targets
import thread_pairs

COLUMNS = ('scene', 'size', 'program', 'complete', 'dofs', 'elements', 'cpu', 'wall', 'memory',
           'runs', 'increments', 'iterations', 'cuts', 'code', 'T/N_error', 'force_error',
           'pressure_error', 'largest_error', 'tip_error', 'chosen', 'date', 'load')
APPENDIX = '''## Appendix\n\nAll tables, scene by scene.\n\n'''
CUBES = {'cube': 'friction', 'cube_smooth': 'no friction', 'cube_once': 'slide in one increment',
         'cube_neo': 'neo-Hooke'}


@dataclasses.dataclass
class Measured:
    """Everything that was measured: results by job, start-up, limits of the machine, profile."""

    found: dict
    programs: object
    started: dict
    limits: dict
    profile: dict
    quick: bool


def write(folder, measured):
    """All files, from what was measured alone."""
    inner = os.path.join(folder, 'bench')
    os.makedirs(inner, exist_ok=True)
    write_csv(os.path.join(inner, 'results.csv'), measured.found)
    figures.draw(inner, measured.found)
    found = measured.found
    text = ''.join([head(measured), summary_table(targets.rows(found, measured.started)), method(measured), APPENDIX,
                    cube_table(found), other_table(found),
                    paired.section(os.path.join(inner, 'ratios.csv')),
                    thread_pairs.section(os.path.join(inner, 'threads.csv')),
                    large_cubes.section(os.path.join(inner, 'largest.csv')),
                    scaling_table(found),
                    large.section(os.path.join(inner, 'petsc.csv')),
                    equal_error.section(os.path.join(inner, 'equal_error.csv')),
                    hertz_table(found), tip_table(found),
                    where_it_goes(measured)])
    with open(os.path.join(folder, 'benchmark.md'), 'w', encoding='utf-8') as stream:
        stream.write(text.rstrip('\n') + '\n')


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


def head(measured):
    """The figures, and who wrote it."""
    command = 'make bench-quick' if measured.quick else 'make bench'
    return f'''# Benchmark: how long until the answer is there

CPU time against the error of the answer, and against the size of the model, beside CalculiX on the same meshes:

![time against error](bench/time_error.png)

![time and memory against size](bench/time_size.png)

Written by `{command}` (`tests/bench/bench`); no number here was written by hand. All runs: [bench/results.csv](bench/results.csv).

'''


def method(measured):
    """Where and how it was measured."""
    machine, limits = measure.machine(), measured.limits
    loads = [r['load'] for r in measured.found.values()]
    dates = sorted({r['date'] for r in measured.found.values()})
    versions = '; '.join(line for line in measured.programs.versions() if line)
    return f'''## Method

- Machine: {machine["processor"]}, {machine["cores"]} cores, {machine["memory"]} GB, {machine["system"]}. In one thread its dgemm does {limits["dgemm"]:.0f} GFlop/s, a copy moves {limits["copy"]:.0f} GB/s.
- Runs of {" to ".join(dates[::max(1, len(dates) - 1)])}; this file {time.strftime("%Y-%m-%d %H:%M")}.
- Programs: {versions}.
- One thread each (`OPENBLAS_NUM_THREADS=1`, `OMP_NUM_THREADS=1`, `OPENBLAS_CORETYPE` unset). *CPU* is user and system time of the whole process, from start to exit, median of up to {measure.REPEATS} runs (one, where they take more than {measure.ENOUGH:g} s together). Before each run another process touches 2 GB: a virtual machine takes back what nobody has used for two seconds, and the first program to want it waits far longer for each page. The load of the machine was {min(loads):.1f} to {max(loads):.1f} on {machine["cores"]} cores: where that is above the number of cores, wall time says nothing and CPU time is too long by some tenths, for both programs.
- Both programs read the same mesh file (nodes, linear tetrahedra, sets, surfaces), take the same increments and the same pressure for a penetration, with the same stiffness of stick. Neither writes fields, except contact pressures where they are judged.
- mfec iterates to its default tolerance (relative energy 1e-16), CalculiX to its own (0.5 % of the mean force).
- CalculiX *default* is SPOOLES, *iterative* is `SOLVER=ITERATIVE SCALING`; N2S node to surface, S2S surface to surface.
- "about": only the first increment was run; the time of one iteration is taken times the iterations of the complete run on the same mesh (CalculiX with its iterative solver; mfec with AUTO).

'''


def table(columns, rows):
    """A Markdown table."""
    lines = ['| ' + ' | '.join(columns) + ' |', '|' + '---|'*len(columns)]
    return '\n'.join(lines + ['| ' + ' | '.join(row) + ' |' for row in rows]) + '\n\n'


def summary_table(rows):
    """The answers in short."""
    return ('## Results in short\n\nRatios of CPU time; larger is better for mfec. The last column says where mfec\'s time '
            'goes in the run that decides the row.\n\n' + table(
                ('quantity', 'measured', 'most of its time'), [(r.what, r.measured, r.limit) for r in rows]))


def percent(value):
    """An error in percent."""
    return '' if value is None else f'{100*value:+.2f}'


def outcome(job, result):
    """The CPU time, or what else became of a run."""
    if job.limit:
        return f'{result["cpu"]:.3g} (first increment)'
    if result['late']:
        return f'over {result["cpu"]:.0f}'
    if result['code']:
        return f'{result["cpu"]:.3g} (exit code {result["code"]})'
    return f'{result["cpu"]:.3g}'


def cube_row(runs, job, result):
    """One run of the sliding cube."""
    own = runs.get(job.scene, job.size, 'AUTO')
    time_of, guess = runs.cpu(job.scene, job.size, job.mode, job.method)
    ratio = f'{"about " if guess else ""}{time_of/own["cpu"]:.2g}' if own and time_of else ''
    each = f'{result["cpu"]/result["iterations"]:.3g}' if result.get('iterations') else ''
    return (CUBES[job.scene], f'{job.size:g}', f'{result["dofs"]:,}', figures.label(job),
            outcome(job, result), f'{result["wall"]:.3g}', each, f'{result["memory"]:.0f}',
            f'{result.get("iterations", "")}', f'{result.get("cuts", "")}',
            percent(result.get('T/N_error')), ratio)


def cube_table(found):
    """The sliding cube, one row a run, with the ratio to mfec's own choice."""
    runs = targets.Runs(found)
    rows = [cube_row(runs, job, r)
            for job, r in sorted(found.items(), key=lambda item: (item[0].scene, item[0].size))
            if job.scene in CUBES and job.threads == 1]
    return '''## Sliding cube

An elastic cube of n cells an edge is pressed by 1/200 of its edge (2 increments) on an elastic block of 3 x 2 x 0.5 edges and moved by half an edge (20 increments), mu = 0.1. *T/N*: error of the mean of tangential over normal force from time 1.2 on, where the cube slides as a whole.

''' + table(('scene', 'n', 'dofs', 'program', 'CPU [s]', 'wall [s]', 'CPU an iteration [s]',
             'memory [MB]', 'iterations', 'cuts', 'T/N [%]', 'CPU against mfec AUTO'), rows)


# Scene, method and threads of a row: what is different from the plain cube, whose size counts.
OTHERS = {('cube', 'GTOS', 1): 'GTOS', ('cube', 'SEGMent', 1): 'SEGMent',
          ('cube_smooth', 'NTOS', 1): 'no friction', ('cube_rough', 'NTOS', 1): 'mu = 0.9',
          ('cube', 'NTOS', 2): '--threads 2', ('cube_1000', 'NTOS', 1): '1,000 increments',
          ('plate', 'NTOS', 1): 'large contact', ('field', 'NTOS', 1): 'small contact, large body'}


def other_table(found):
    """Every other scene: mfec alone, against the plain cube of n = 12 (or of its own size)."""
    runs = targets.Runs(found)
    rows = []
    for job, r in sorted(found.items(), key=lambda item: (item[0].scene, item[0].size)):
        what = OTHERS.get((job.scene, job.method, job.threads))
        if not what or r['code'] or (job.scene.startswith('cube') and job.size not in (8, 12)):
            continue
        if job.size == 8 and job.scene != 'cube_1000':
            continue
        plain = runs.get('cube', job.size if job.scene.startswith('cube') else 12, 'AUTO')
        if job.mode not in ('AUTO', 'REDU') or not plain:
            continue
        rows.append((what, f'{job.size:g}', f'{r["dofs"]:,}', job.mode, f'{r["cpu"]:.3g}',
                     f'{1000*r["cpu"]/max(1, r["increments"]):.3g}', f'{r["memory"]:.0f}',
                     f'{r["iterations"]}', f'{r["cpu"]/plain["cpu"]:.2g}',
                     f'{r["memory"]/plain["memory"]:.2g}'))
    if not rows:
        return ''
    return '''## Other scenes

Each differs from the plain cube in one thing. *plate*: two slabs of three cells, n cells an edge, all of the upper one in contact, 7 increments; *field*: a slab of 12 x 12 cells on a base of n x n. The last columns are against the plain cube, n = 12 (1,000 increments: n = 8).

''' + table(('scene', 'n', 'dofs', 'solver', 'CPU [s]', 'CPU an increment [ms]', 'memory [MB]',
             'iterations', 'CPU against the cube', 'memory'), rows)


def scaling_table(found):
    """mfec alone, n = 10 to 30."""
    rows, before = [], None
    for n in (10, 15, 20, 25, 30):
        r = targets.Runs(found).get('cube', n, 'AUTO')
        if not r:
            continue
        factor, power = targets.factorisation(r), ''
        if before:
            power = f'{targets.power(before, r):.2f}'
        rows.append((str(n), f'{r["dofs"]:,}', f'{r["cpu"]:.3g}', f'{factor:.3g}',
                     f'{100*factor/r["cpu"]:.0f}', f'{r["cpu"] - factor:.3g}',
                     f'{r["memory"]:.0f}', power))
        before = r
    if not rows:
        return ''
    return '''## Cost against size

mfec AUTO on the sliding cube with friction. The last column is the power p of CPU ~ dofs^p from the row above.

''' + table(('n', 'dofs', 'CPU [s]', 'factorisation [s]', 'share [%]', 'the rest [s]',
             'memory [MB]', 'growth p'), rows)


def hertz_table(found):
    """Work and precision of Hertz, on elements of four nodes and of ten."""
    return '''## Hertz

A paraboloid on a plate, both elastic, a quarter, no friction, 4 increments; the far faces move as those of half-spaces. *h/a*: facet over radius of contact. *force*: against Hertz at the given approach. *p0*: peak pressure, from the parabola of p^2 through the pressures at the nodes within 0.8 a, against Hertz for the computed force; *largest*: the largest value at a node, likewise.

''' + hertz_rows(found, 'hertz') + '''
Elements of ten nodes (`C3D10`), middles of edges on the paraboloid. Pressures of mfec are linear functions of the corners with the integrals of the points' forces, those of CalculiX what it prints at nodes.

''' + hertz_rows(found, 'hertz_ten')


def hertz_rows(found, scene):
    """The table of one kind of element."""
    rows = [(f'{job.size:g}', f'{r["dofs"]:,}', figures.label(job), outcome(job, r),
             f'{r["memory"]:.0f}', f'{r.get("iterations", "")}', percent(r.get('force_error')),
             percent(r.get('pressure_error')), percent(r.get('largest_error')))
            for job, r in sorted(found.items(), key=lambda item: -item[0].size)
            if job.scene == scene]
    return table(('h/a', 'dofs', 'program', 'CPU [s]', 'memory [MB]', 'iterations', 'force [%]',
             'p0 [%]', 'largest [%]'), rows)


def tip_table(found):
    """The cantilever."""
    rows = [(f'{job.size:g}', f'{r["dofs"]:,}', figures.label(job), outcome(job, r),
             f'{r["memory"]:.0f}', percent(r.get('tip_error')))
            for job, r in sorted(found.items(), key=lambda item: item[0].size)
            if job.scene == 'cantilever']
    return '''## Cantilever

Pure bending, 2n x n x n cells, no contact, one increment; the error is that of the deflection of the tip (exact solution). *bare CHOLMOD* is `tests/bench/bare_cholmod.c`: it reads the mesh in binary, assembles, factorises and solves once, nothing else.

''' + table(('n', 'dofs', 'program', 'CPU [s]', 'memory [MB]', 'tip [%]'), rows)


def where_it_goes(measured):
    """Profile, cost table and the speed of the factorisation."""
    text = '## Where the time goes\n\n'
    speeds = [(job.size, r['gflops'], r['gigabytes']) for job, r in measured.found.items()
              if job.mode == bare.MODE and r.get('gflops')]
    if speeds:
        size, speed, moved = max(speeds)
        share = 100*speed/measured.limits['dgemm']
        through = 100*moved/measured.limits['copy']
        text += (f'CHOLMOD\'s factorisation alone (bare program, cantilever n={size:g}) runs at '
                 f'{speed:.1f} GFlop/s, {share:.0f} % of the dgemm of this machine; a '
                 f'solve with its factor (read twice) at {moved:.1f} GB/s, {through:.0f} % of what a '
                 'copy moves.\n\n')
    if measured.profile:
        text += (f'Samples of {measured.profile["tool"]}, {measured.profile["job"]} '
                 '(`tests/bench/profile`):\n\n')
        text += table(('work', 'share of CPU [%]'), [
            (name, f'{share:.1f}') for name, share in measured.profile['kinds'].items()
            if share >= 0.05])
        text += table(('largest symbols', 'library', '[%]'), [
            (f'`{symbol}`', library, f'{share:.1f}')
            for share, library, symbol in measured.profile['rows']])
    return text + cost_table(measured.found)


def cost_table(found):
    """The cost tables of the logs, in percent, of the largest runs."""
    runs = []
    for scene in ('cube', 'cube_smooth', 'hertz', 'cantilever'):
        done = [(r['dofs'], job, r) for job, r in found.items() if job.scene == scene and
                job.mode == 'AUTO' and r['code'] == 0 and not job.limit and r.get('costs')]
        if done:
            _, job, r = max(done, key=lambda item: item[0])
            runs.append((f'{job.scene} {job.size:g}', r))
    if not runs:
        return ''
    names = [n for n in runs[0][1]['costs'] if n != 'whole run']
    rows = []
    for name in names:
        cells = []
        for _, r in runs:
            share = 100*r['costs'].get(name, 0.0)/max(r['costs']['whole run'], 1e-9)
            cells.append(f'{share:.1f} ({r["counts"].get(name, 0)})')
        rows.append((name, *cells))
    return ('The cost tables of the logs of mfec (AUTO), largest size of each scene: share of the '
            'whole run in percent, and how often.\n\n'
            + table(('cost', *(name for name, _ in runs)), rows))
