#!/usr/bin/env python3
"""mfec-post adapt against CalculiX at the same true error: scenes of tests/adapt with ten nodes a cell.

    build/venv/bin/python tests/bench/equal_error.py [--out doc] [--seconds 60] [SEED...]

adapt is asked for a bar of 5 %; CalculiX (surface to surface) gets uniform meshes of its own, each of 2/3 the size,
until its result is as near to the answer (tests/adapt/truths.csv), or a run takes longer than --seconds. Renews the
section of the benchmark.
"""
import argparse
import math
import os
import pathlib
import re
import sys
import tempfile
import time

import calculix
import measure
import sections

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
START, FOLLOWER = '## Equal error', '## Hertz'
SEEDS = (2, 3, 7)
WISH, FINER = 0.05, 1.5
COLUMNS = ('scene', 'error', 'cells', 'cpu', 'last', 'other_error', 'other_cells', 'other_cpu', 'other_sum', 'meshes',
           'cut', 'load', 'date')


def other_deck(text, bodies, stiffness, goal):
    """CalculiX's deck of a scene's; supports and motions are read from its text."""
    import numpy as np
    young = re.findall(r'ELAStic ISOTropic (\S+) (\S+)', text)
    lines = ['*INCLUDE, INPUT=mesh.inp']
    for k, (modulus, poisson) in enumerate(young, 1):
        lines += [f'*MATERIAL, NAME=m{k}', f'*ELASTIC\n{modulus}, {poisson}']
    slave, master = re.search(r'(?:GTOS|NTOS) (\S+) (\S+)', text).groups()
    mu = re.search(r'COULomb (\S+)', text)
    lines += ['*SURFACE INTERACTION, NAME=law', '*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR', f'{stiffness:.6g}']
    lines += [f'*FRICTION\n{mu.group(1)}, {stiffness:.6g}'] if mu else []
    lines += ['*CONTACT PAIR, INTERACTION=law, TYPE=SURFACE TO SURFACE', f'{slave}, {master}', '*BOUNDARY']
    planes = re.search(r'EBOUndary\n((?:  .*\n)+)', text)
    for line in planes.group(1).splitlines():
        axis, place = int(line.split()[0]), float(line.split()[1])
        held = np.flatnonzero(abs(bodies.points[:, axis - 1] - place) < 1e-9)
        lines += [f'{node + 1}, {axis}, {axis}' for node in held]
    lines += [f'ground, {axis}, {axis}' for axis in (1, 2, 3)]
    fixed = re.search(r'\nBOUNdary\n  top (\S+) (\S+) (\S+)', text).groups()
    way = list(map(float, re.search(r'DISPlacement\n  top\s+(\S+) (\S+) (\S+)', text).groups()))
    late = way[0] if 'FPROportional' in text else 0.0
    counts = list(map(int, re.findall(r'STEP,,(\d+)', text)))
    for phase, count in enumerate(counts):
        lines += [f'*STEP, INC=10000\n*STATIC\n{1 / count:.9g}, 1.0, 1e-5, {1 / count:.9g}', '*BOUNDARY']
        now = [late if phase else 0.0, *way[1:]]
        lines += [f'top, {axis}, {axis}, {now[axis - 1]:.12g}' for axis in (1, 2, 3) if fixed[axis - 1] == '1']
        lines += [f'*NODE PRINT, NSET={goal.partition(".")[0]}, TOTALS=ONLY\nRF\n*END STEP']
    return '\n'.join(lines) + '\n'


def shorten(path):
    """Coordinates of twelve digits: CalculiX reads 20 characters of each."""
    nodes, rest = path.read_text(encoding='ascii').split('*ELEMENT', 1)
    lines = [line.split(',') for line in nodes.splitlines()]
    short = [','.join([line[0], *(f'{float(x):.12g}' for x in line[1:])]) for line in lines]
    path.write_text('\n'.join(short) + '\n*ELEMENT' + rest, encoding='ascii')


def other_run(scene, size, seconds):
    """CalculiX on a uniform mesh: value, cells, processor seconds."""
    import mfec
    from mfec.run import launch
    from mfec_post.adapt_model import read_bodies, write_mesh
    scene.size = size
    with tempfile.TemporaryDirectory(prefix='mfec-bench-') as folder:
        deck, _ = scene.write(folder)
        launch(mfec.Deck.read(deck), ['--check'], {}, os.path.join(folder, 'check'), None, None)
        bodies = read_bodies(os.path.join(folder, 'check', 'scene.check.vtkhdf'))
        write_mesh(bodies, pathlib.Path(folder, 'mesh.inp'), set(), 'm')
        shorten(pathlib.Path(folder, 'mesh.inp'))
        with open(deck, encoding='ascii') as stream:
            text = stream.read()
        young = min(float(e) for e in re.findall(r'ELAStic ISOTropic (\S+)', text))
        with open(os.path.join(folder, 'run.inp'), 'w', encoding='ascii') as stream:
            stream.write(other_deck(text, bodies, 20 * young / size, scene.goal))
        spent = measure.spend(['ccx', 'run'], folder, seconds)
        with open(os.path.join(folder, 'run.dat'), encoding='ascii') as stream:
            rows = calculix.totals(stream.read())
    whole = rows and abs(rows[-1][0] - len(re.findall('STEP,,', text))) < 1e-6 and not spent['code']
    return rows[-1][int(scene.goal[-1])] if whole else None, len(bodies.cells), spent['cpu']


def measure_seed(seed, seconds):
    """The line of a scene."""
    sys.path[:0] = [os.path.join(TOP, 'tests', 'adapt'), os.path.join(TOP, 'tests'), os.path.join(TOP, 'postproc')]
    from importlib.machinery import SourceFileLoader
    campaign = SourceFileLoader('campaign', os.path.join(TOP, 'tests', 'adapt', 'campaign')).load_module()
    scene = campaign.scenes.draw(seed)
    scene.wish = WISH
    answer = float(campaign.truths.read()[scene.name]['answer'])
    with tempfile.TemporaryDirectory(prefix='mfec-bench-') as folder:
        own = campaign.measure(scene, folder)
    error = abs(own['value'] / answer - 1)
    line = {'scene': scene.name, 'error': error, 'cells': own['cells'], 'cpu': own['all'], 'last': own['last'],
            'other_error': math.nan, 'other_cells': 0, 'other_cpu': 0.0, 'other_sum': 0.0, 'meshes': 0,
            'cut': 0.0, 'load': os.getloadavg()[0], 'date': time.strftime('%Y-%m-%d')}
    size = 0.25
    while not line['other_error'] <= error:
        value, cells, cpu = other_run(scene, size, seconds)
        line['other_sum'] += cpu
        print(f'{scene.name} {size:.3g} {cells} {value} {cpu:.1f} s', flush=True)
        if value is None:
            line['cut'] = cpu if cpu >= seconds else 0.0
            break
        line.update(other_error=abs(value / answer - 1), other_cells=cells, other_cpu=cpu, meshes=line['meshes'] + 1)
        size /= FINER
    return line


def section(path):
    """The table as text; nothing where nothing was measured."""
    lines = sections.read(path, lambda line: line['scene'])
    if not lines:
        return ''
    text = (f'{START}\n\nWritten by `tests/bench/equal_error.py`: scenes of `tests/adapt` (by seed), ten nodes a cell; '
            '`mfec-post adapt` asked for a bar of 5 % (all its runs, meshes and estimates), and CalculiX surface to surface '
            'on uniform meshes of its own, each of 2/3 the size, until the result is as near to the answer. Where the '
            'next mesh was cut after --seconds the ratio is that of what it had used by then: a bound.\n\n'
            '| scene | true error of adapt [%] | elements | CPU of all, of the last run [s] | true error '
            'of CalculiX [%] | elements | CPU of this run, of all its meshes [s] | this run over all of adapt |\n'
            '|---|---|---|---|---|---|---|---|\n')
    for line in lines.values():
        error, other = float(line['error']), float(line['other_error'])
        reached = other <= error
        ratio = max(float(line['other_cpu']), 0.0 if reached else float(line['cut'])) / float(line['cpu'])
        text += (f'| {line["scene"]} | {100 * error:.2f} | {float(line["cells"]):.0f} | {line["cpu"]}, {line["last"]} | '
                 f'{100 * other:.2f} | {line["other_cells"]} | {line["other_cpu"]}, {line["other_sum"]} | '
                 f'{"" if reached else "above "}{ratio:.2g} |\n')
    return text + '\n'


def main():
    """Each line is kept as soon as it is measured."""
    options = argparse.ArgumentParser()
    options.add_argument('--out', default=os.path.join(TOP, 'doc'))
    options.add_argument('--seconds', type=int, default=60)
    options.add_argument('seeds', nargs='*', type=int)
    given = options.parse_args()
    path = os.path.join(given.out, 'bench', 'equal_error.csv')
    for seed in given.seeds or SEEDS:
        line = measure_seed(seed, given.seconds)
        lines = sections.read(path, lambda line: line['scene'])
        lines[line['scene']] = line
        sections.keep(path, COLUMNS, lines.values())
    sections.renew(os.path.join(given.out, 'benchmark.md'), START, FOLLOWER, section(path))
    return 0


if __name__ == '__main__':
    sys.exit(main())
