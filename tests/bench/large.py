"""The table of ./mfec-petsc, from what tests/petsc/scale --keep has measured."""
import csv
import os

START = '## Large models'


def section(path):
    """The table as text; nothing where nothing was measured."""
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8', newline='') as stream:
        lines = list(csv.DictReader(stream))
    text = [f'{START}\n\nThe sliding cube by `./mfec-petsc` on one and two ranks, four increments '
            '(`tests/petsc/scale --keep doc/bench/petsc.csv 24 24x2 ...`): processor seconds of all '
            'ranks and of the one that took most, peak memory of all ranks together, with the '
            'program and its libraries.\n\n',
            '| n | degrees of freedom | ranks | iterations of Newton | most of a solve, all of GMRES '
            '| CPU, of a rank [s] | wall [s] | memory [MB] | of a degree of freedom [kB] |\n|'
            + '---|'*9 + '\n']
    for line in lines:
        cells = (line['n'], f'{int(line["dofs"]):,}', line['ranks'], line['newton'],
                 f'{line["most"]}, {line["gmres"]}', f'{line["cpu"]}, {line["cpu_rank"]}',
                 line['wall'], line['mb'], line['kb'])
        text.append('| ' + ' | '.join(cells) + ' |\n')
    return ''.join(text) + '\n'
