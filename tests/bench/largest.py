"""The largest cubes that one thread solves, from doc/bench/largest.csv: what a run by hand has
printed in its cost table (`paired.write` makes the deck, `--threads 1` runs it)."""
import csv
import os

START = '## Largest cubes'
SHARES = ('symmetric factorisation', 'compliance columns', 'solve', 'dense factorisation',
          'displacements inside')


def section(path):
    """The table as text; nothing where nothing was measured."""
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8', newline='') as stream:
        lines = list(csv.DictReader(stream))
    text = (f'{START}\n\nThe sliding cube in 22 increments by REDUced, which AUTO takes, one thread '
            'beside other work, which has lengthened the wall time; its shares are those of the '
            'log\'s cost table.\n\n'
            '| n | free dofs | CPU [s] | wall [s] | memory [MB] | ' + ' | '.join(SHARES) + ' |\n|'
            + '---|'*(5 + len(SHARES)) + '\n')
    for line in lines:
        text += (f'| {line["size"]} | {int(line["dofs"]):,} | {line["cpu"]} | {line["wall"]} | {line["memory"]} | '
                 + ' | '.join(line[share] for share in SHARES) + ' |\n')
    return text + '\n'
