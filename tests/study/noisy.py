"""Identification on seeded noisy data: rms errors, intervals and rules over many sets.

    build/venv/bin/python tests/study/noisy.py [--program ./mfec] [--sets 20] [-v]

The deck inputs/lay_by_circle.inp, led around a circle and around a triangle, makes data with 1 % of
noise from values that change from set to set; `mfec_post.identify` finds them again. The rms errors
may be 1.3 times the foretold ones, 95 % intervals must hold in 88 %, the rule must be right in all,
each in at most five runs. A straight pull must be refused.
"""
import argparse
import os
import re
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.join(HERE, '..', '..')
sys.path.insert(0, os.path.join(TOP, 'postproc'))
from mfec_post import identify as tool  # noqa: E402

DECK = os.path.join(TOP, 'inputs', 'lay_by_circle.inp')


def led_around(corners):
    """The deck with another path: corners in units of the radius, at equal times."""
    with open(DECK, encoding='ascii') as stream:
        text = stream.read()
    for k in (0, 1):
        rows = ''.join(f'  {2 + 24 * i / (len(corners) - 1):g} {c[k]:.12g}\n'
                       for i, c in enumerate(corners))
        text = re.sub(rf'PROPortional {k + 2}\n(?:  .*\n)+', f'PROPortional {k + 2}\n{rows}', text)
    return text


SIDE = 2 * np.pi / 3  # as long as the circle
PATHS = {'circle': None,
         'triangle': [(0, 0), (SIDE, 0), (SIDE / 2, SIDE * 3**.5 / 2), (0, 0)],
         'straight': [(0, 0), (3, 0)]}


def write_deck(folder, path):
    """The deck of a path, and where it is."""
    name = os.path.join(folder, path + '.inp')
    text = led_around(PATHS[path]) if PATHS[path] else open(DECK, encoding='ascii').read()
    with open(name, 'w', encoding='ascii') as stream:
        stream.write(text)
    return name


def one_set(program, deck, seed, folder):
    """Errors over foretold deviations, hits of intervals, rule and runs of one set."""
    pick = np.random.default_rng(seed)
    truth = np.array([pick.uniform(.2, .4), 0., pick.uniform(-60, 60)])
    truth[1] = truth[0] * pick.uniform(.55, .8)
    rule = int(pick.choice([0, 0, 2]))
    names = ['m1', 'm2', 'phi']
    run = tool.Deck(deck, program, 'top')
    times, force, _ = run.run(names, list(truth), rule, [])
    times, force = times[2:], force[2:, :2]
    sigma = .01 * np.linalg.norm(force, axis=1).max()
    force = force + sigma * pick.standard_normal(force.shape)
    data = os.path.join(folder, 'data.csv')
    np.savetxt(data, np.column_stack([times, force]), delimiter=',', header='time,R1,R2',
               comments='')
    given = argparse.Namespace(deck=deck, data=data, columns='time,R1,R2', set_name='top',
                               fit='m1,m2,phi,slip', sigma=f'{sigma:.17g}', sigma_column=None,
                               bounds=['m1=0.01:1', 'm2=0.01:1'], nuisance='', level=95.,
                               plan=False, refits=False, start='drag', program=program,
                               out=os.path.join(folder, 'x.png'))
    fresh = tool.Deck(deck, program, 'top')
    problem = tool.Problem(fresh, tool.read_data(given), names, True, tool.read_bounds(given.bounds))
    x, start = tool.first_guess(fresh, problem.data, names, fresh.roles())
    fit = problem.fit(problem.clip(x), start)
    estimate = tool.Estimate(problem.columns, fit.jacobian)
    found = np.append(fit.x, fit.m)
    off = found - np.append(truth, rule)
    off[2] = (off[2] + 90.) % 180. - 90.
    return off, estimate.sd, fit.rule == rule, fresh.runs, fit.chi2 / (fit.r.size - 4)


def check_sets(program, count, folder):
    """[(name, faults)] of circle and triangle, and of the straight pull."""
    results = []
    for path in ('circle', 'triangle'):
        deck = write_deck(folder, path)
        sets = [one_set(program, deck, 100 + seed, folder) for seed in range(count)]
        ratio = np.array([off / sd for off, sd, *_ in sets])
        rms = np.sqrt(np.mean(ratio**2, axis=0))
        hits = np.mean(np.abs(ratio) < 1.96, axis=0)
        rules = sum(right for _, _, right, *_ in sets)
        runs = [n for *_, n, _ in sets]
        text = f'{path}: {count} sets, rms over foretold {np.round(rms, 2)}, ' \
            f'hits {np.round(hits, 2)}, rule right in {rules}, runs {min(runs)} to {max(runs)}, ' \
            f'mean chi2/dof {np.mean([c for *_, c in sets]):.2f}'
        faults = []
        if np.any(rms > 1.3 + (.4 if count < 20 else 0.)):
            faults.append('rms errors above 1.3 times the foretold ones')
        if np.mean(hits) < .88 or (count >= 20 and np.any(hits < .8)):
            faults.append('intervals hold too seldom')
        if rules < count or max(runs) > 5:
            faults.append('a wrong rule, or more than five runs')
        results.append((text, faults))
    deck = write_deck(folder, 'straight')
    given = argparse.Namespace(deck=deck, set_name='top', fit='m1,m2,phi,slip', sigma='1%',
                               level=95., nuisance='', plan=True, program=program)
    lines, determined = tool.identify(given)
    results.append(('straight pull: ' + ' | '.join(lines[1:4]),
                    [] if not determined and any('circle' in line for line in lines) else lines))
    return results


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--program', default=os.path.join(TOP, 'mfec'))
    parser.add_argument('--sets', type=int, default=20)
    given = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, faults in check_sets(os.path.abspath(given.program), given.sets, folder):
            print('FAILED' if faults else 'passed', name, *faults, sep='\n   ')
            failed += bool(faults)
    return failed


if __name__ == '__main__':
    sys.exit(main())
