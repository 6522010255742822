"""Two threads against one, in turn, on the plain sliding cube: wall time and processor time, on an
idle machine and beside two processes that never end."""
import dataclasses
import os
import statistics
import subprocess
import sys
import time

import jobs
import measure
import paired
import sections

START, FOLLOWER = '## Two threads', '## Cost against size'
PAIRS = {False: 9, True: 15}
COLUMNS = ('size', 'busy', 'pairs', 'wall_one', 'wall_two', 'least', 'median', 'largest', 'cpu',
           'memory_one', 'memory_two', 'load', 'date')
MOST_CPU, MOST_BUSY = 1.2, 1.1


@dataclasses.dataclass(frozen=True)
class Row:
    """A size, beside what, and the least ratio of the wall times of one thread and of two."""

    size: int
    busy: bool = False
    wanted: float = 0.0


ROWS = (Row(8), Row(12), Row(16), Row(20, wanted=1.5), Row(24, wanted=1.5),
        Row(12, True, 1/MOST_BUSY), Row(20, True, 1/MOST_BUSY))


def measure_row(row, program, folder, pairs=0):
    """Runs one and two threads in turn; a line of the table."""
    scene = paired.MAKERS[jobs.CUBE](row.size)
    paired.write(folder, scene, 'NTOS', ())
    load = os.getloadavg()[0]
    loops = [subprocess.Popen([sys.executable, '-c', 'while True: pass'])
             for _ in range(2 if row.busy else 0)]
    runs = []
    try:
        for _ in range(pairs or PAIRS[row.busy]):
            runs.append([run(program, folder, threads) for threads in (1, 2)])
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    ratios = [one['wall']/two['wall'] for one, two in runs]
    middle = {f'{what}_{name}': statistics.median(pair[k][what] for pair in runs)
              for what in ('wall', 'memory') for k, name in enumerate(('one', 'two'))}
    return dict(middle, size=row.size, busy=int(row.busy), pairs=len(runs), least=min(ratios),
                median=statistics.median(ratios), largest=max(ratios),
                cpu=statistics.median(two['cpu']/one['cpu'] for one, two in runs), load=load,
                date=time.strftime('%Y-%m-%d'))


def run(program, folder, threads):
    """What one run took."""
    spent = measure.spend([os.path.abspath(program), 'run.inp', '--quiet', '--threads',
                           str(threads)], folder, 600)
    if spent['code']:
        raise OSError(f'{threads} threads: exit code {spent["code"]}')
    return spent


def read(path):
    """The lines kept, by size and whether the machine was busy."""
    return sections.read(path, lambda line: (int(line['size']), line['busy'] == '1'))


def keep(path, lines):
    """Writes the lines in the order of the rows."""
    sections.keep(path, COLUMNS, [lines[row.size, row.busy] for row in ROWS
                                  if (row.size, row.busy) in lines])


def verdict(row, line):
    """Whether what is wanted of a row is met."""
    missed = []
    if float(line['median']) < row.wanted:
        missed.append(f'{line["median"]} instead of {row.wanted:.3g}')
    if not row.busy and float(line['cpu']) > MOST_CPU:
        missed.append(f'CPU {float(line["cpu"]):.2f} instead of {MOST_CPU}')
    return 'no: ' + ', '.join(missed) if missed else 'yes'


def section(path):
    """The table as text; nothing where nothing was measured."""
    lines = read(path)
    if not lines:
        return ''
    text = [f'{START}\n\nWritten by `tests/bench/threads`: the plain cube with `--threads 1` and '
            f'`--threads 2` in turn, the ratios pair by pair; beside nothing else, or beside two '
            f'processes that never end on two cores.\n\n'
            '| n | beside | one thread, wall [s] | two threads | as fast: least, median, largest of '
            'the pairs | CPU, times that of one | memory [MB] | of two |\n|'
            + '---|'*8 + '\n']
    for row in ROWS:
        line = lines.get((row.size, row.busy))
        if line:
            cells = (str(row.size), 'two endless loops' if row.busy else 'nothing',
                     line['wall_one'], line['wall_two'],
                     f'{line["least"]}, **{line["median"]}**, {line["largest"]} ({line["pairs"]})',
                     line['cpu'], line['memory_one'], line['memory_two'])
            text.append('| ' + ' | '.join(cells) + ' |\n')
    return ''.join(text) + '\n'


def renew(document, path):
    """Puts the table into a document, in the place of the one before."""
    sections.renew(document, START, FOLLOWER, section(path))
