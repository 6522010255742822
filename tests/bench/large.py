"""The table of ./mfec-petsc, from what tests/petsc/scale --keep has measured."""
import csv
import math
import os

import sections

START = '## Large models'


def section(path):
    """The table as text; nothing where nothing was measured."""
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8', newline='') as stream:
        lines = list(csv.DictReader(stream))
    text = [f'{START}\n\nThe sliding cube by `./mfec-petsc`, four increments (`tests/petsc/scale --keep '
            'doc/bench/petsc.csv 24 24x2 24:REDUced ...`): processor seconds of all ranks and of the '
            'one that took most, peak memory of all ranks together, with the program and its '
            'libraries. Beside it the same deck by CHOLMOD (UMFPACK where friction slips) and by '
            'REDUced, which has one factor of CHOLMOD a body, and the benchmark\'s cube in as many '
            'increments by CalculiX, node to surface, with its iterative solver. Growth: the '
            'power p of CPU ~ dofs^p from the row above of the same solver and ranks.\n\n',
            '| solver | n | degrees of freedom | ranks | iterations of Newton | most of a solve, all '
            'of GMRES | CPU, of a rank [s] | growth p | wall [s] | memory [MB] | of a degree of '
            'freedom [kB] |\n|' + '---|'*11 + '\n']
    last = {}
    for line in lines:
        way = line['solver'], line['ranks']
        dofs, cpu = float(line['dofs']), float(line['cpu'])
        growth = ''
        if way in last:
            growth = f'{math.log(cpu/last[way][1])/math.log(dofs/last[way][0]):.2f}'
        last[way] = dofs, cpu
        iterated = line['solver'] == 'PETSc'
        cells = (line['solver'], line['n'], f'{int(line["dofs"]):,}', line['ranks'], line['newton'],
                 f'{line["most"]}, {line["gmres"]}' if iterated else '',
                 f'{line["cpu"]}, {line["cpu_rank"]}', growth, line['wall'], line['mb'], line['kb'])
        text.append('| ' + ' | '.join(cells) + ' |\n')
    return ''.join(text) + '\n' + scaling(lines) + crossings(lines)


def scaling(lines):
    """How much faster more ranks are."""
    alone = {line['n']: float(line['cpu']) for line in lines
             if line['solver'] == 'PETSc' and line['ranks'] == '1'}
    parts = [f'{alone[line["n"]]/float(line["cpu_rank"]):.2f} times as fast on {line["ranks"]} ranks '
             f'as on one at n = {line["n"]}' for line in lines
             if line['solver'] == 'PETSc' and line['ranks'] != '1' and line['n'] in alone]
    return f'Strong scaling: {", ".join(parts)}.\n\n' if parts else ''


def crossings(lines):
    """From which size on PETSc on one rank needs less than another solver."""
    ours = {line['n']: line for line in lines if line['solver'] == 'PETSc' and line['ranks'] == '1'}
    parts = []
    for other in ('CHOLmod', 'REDUced', 'CalculiX'):
        rows = [(ours[line['n']], line) for line in lines
                if line['solver'] == other and line['n'] in ours]
        parts += [f'{other} {what} {crossing(rows, column)}'
                  for what, column in (('in time', 'cpu'), ('in memory', 'mb')) if rows]
    return f'Cross-over, degrees of freedom: {"; ".join(parts)}.\n\n' if parts else ''


def crossing(rows, column):
    """Where two solvers need the same, between two sizes, in logarithms."""
    points = [(math.log(float(mine['dofs'])), math.log(float(mine[column])/float(its[column])))
              for mine, its in rows]
    for (x0, y0), (x1, y1) in zip(points, points[1:]):
        if y0 > 0 >= y1:
            return f'{round(math.exp(x0 + (x1 - x0)*y0/(y0 - y1)), -3):,.0f}'
    return f'{"below" if points[0][1] <= 0 else "above"} what was measured'


def renew(document, path):
    """Puts the table into a document, in the place of the one before."""
    sections.renew(document, START, '## Hertz', section(path))
