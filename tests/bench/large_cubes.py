"""The plain sliding cube where one thread takes minutes: time, memory, and where the time goes."""
import os
import time

import jobs
import measure
import paired
import results
import sections

START, FOLLOWER = '## Largest cubes', '## Cost against size'
SIZES = (36, 45)
SHARES = ('symmetric factorisation', 'compliance columns', 'solve', 'dense factorisation',
          'recovery of interior dofs')
COLUMNS = ('size', 'dofs', 'cpu', 'wall', 'memory', *SHARES, 'load', 'date')


def measure_size(size, program, folder, seconds=3600):
    """One run; a line of the table."""
    scene = paired.MAKERS[jobs.CUBE](size)
    paired.write(folder, scene, 'NTOS', ())
    load = os.getloadavg()[0]
    spent = measure.spend([os.path.abspath(program), 'run.inp', '--quiet', '--threads', '1'],
                          folder, seconds)
    if spent['code']:
        raise OSError(f'n = {size}: exit code {spent["code"]}')
    costs = results.own_log(results.text_of(folder, 'run.log'))['costs']
    return dict({share: costs[share] for share in SHARES}, size=size, dofs=3*len(scene.mesh.nodes),
                cpu=spent['cpu'], wall=spent['wall'], memory=spent['memory'], load=load,
                date=time.strftime('%Y-%m-%d'))


def read(path):
    """The lines kept, by size."""
    return sections.read(path, lambda line: int(line['size']))


def keep(path, lines):
    """Writes the lines in the order of the sizes."""
    sections.keep(path, COLUMNS, [lines[size] for size in SIZES if size in lines])


def section(path):
    """The table as text; nothing where nothing was measured."""
    lines = read(path)
    if not lines:
        return ''
    text = (f'{START}\n\nWritten by `tests/bench/largest`: the plain cube in 22 increments, one '
            'thread, AUTO, which takes REDUced. The last columns are seconds of the log\'s cost '
            'table.\n\n| n | dofs | CPU [s] | wall [s] | memory [MB] | ' + ' | '.join(SHARES)
            + ' |\n|' + '---|'*(5 + len(SHARES)) + '\n')
    for line in lines.values():
        numbers = [f'{float(line[name]):.4g}' for name in ('cpu', 'wall', 'memory', *SHARES)]
        text += f'| {line["size"]} | {int(line["dofs"]):,} | ' + ' | '.join(numbers) + ' |\n'
    return text + '\n'


def renew(document, path):
    """Puts the table in the document in place of the one before."""
    sections.renew(document, START, FOLLOWER, section(path))
