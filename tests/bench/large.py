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
            'libraries. Beside it the same deck by REDUced, which factorises, and the benchmark\'s '
            'cube in as many increments by CalculiX, node to surface, with its iterative solver. '
            'Growth: the power p of CPU ~ dofs^p from the row above of the same solver and ranks.\n\n',
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
    return ''.join(text) + '\n'


def renew(document, path):
    """Puts the table into a document, in the place of the one before."""
    sections.renew(document, START, '## Hertz', section(path))
