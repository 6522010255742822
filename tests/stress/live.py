"""Runs realistic scenes, several at a time, and judges them as a person would."""
import concurrent.futures
import math
import os
import re
import statistics

import decks
from outcome import Outcome, friction_faults
from realistic import FAMILIES, realistic_scene
from scene import with_mortar

# What a message must say for a scene that has no solution, by the word of the written reason.
SAYS = {
    'slides': r'slid|glid|friction does not (carry|hold)|beyond (its |the )?friction',
    'tips': r'\btip|topple|turns? (over|about)',
    'turns': r'spin|turns? about|torque',
    'lifts': r'lift|no closed contact point|no contact point is closed|pulled off|leaves',
    'unrestrained': r'nothing resists|without resistance|without friction|unrestrained',
}
PROCESSOR = re.compile(r'processor time[^\d\n]*([\d.]+)')
AUDIT = re.compile(r'^.*\bfailed\b.*$', re.MULTILINE | re.IGNORECASE)


class Row:
    """What is left of a run: its counts, and what is wrong with it."""

    def __init__(self, seed, scene, outcome, faults):
        self.seed, self.family, self.wish, self.reason = seed, scene.family, scene.wish, scene.reason
        self.notes, self.faults = scene.notes, faults
        self.solves, self.cuts, self.code = outcome.solves, outcome.cuts, outcome.run.code
        found = PROCESSOR.findall(outcome.texts.get('log', ''))
        self.seconds = float(found[-1]) if found else 0.0
        self.said = ' / '.join(outcome.run.err.strip().split('\n'))


def live(program, seed, folder=None, mortar=False):
    """Makes, runs and judges the scene of a seed, or that scene with MORTar."""
    scene = realistic_scene(seed)
    if mortar:
        scene = with_mortar(scene)
    text = scene.deck.text()
    if folder:
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, f'{scene.family}_{seed}.inp'), 'w', encoding='utf-8') as out:
            out.write(f'! {scene.wish}: {scene.reason}\n! {scene.notes}\n{text}')
    text = text.replace('FIELds NONE', 'FIELds displacement')
    with decks.fresh_folder() as place:
        with open(os.path.join(place, 'scene.inp'), 'w', encoding='utf-8') as out:
            out.write(text)
        run = decks.run(program, ['scene.inp', '--quiet'], place, scene.seconds)
        outcome = Outcome(place, 'scene', run)
        return Row(seed, scene, outcome, faults_of(scene, outcome, place))


def faults_of(scene, outcome, place):
    """What is wrong with a run."""
    run = outcome.run
    if run.crash():
        return [run.crash()]
    if run.code not in (0, 2):
        return [f'exit code {run.code}: ' + ' / '.join(run.err.split('\n')[:3])]
    if scene.wish.startswith('none'):
        return without_solution(scene, run)
    if scene.wish.startswith('named') and not re.search(
            SAYS['unrestrained'], run.err + outcome.texts['log'], re.IGNORECASE):
        return [f'exit code {run.code} without a word that {scene.reason}']
    if scene.wish.startswith('named') and run.code == 2:
        return []
    said = ' / '.join(run.err.strip().split('\n'))
    if run.code == 2:
        return [f'there is a solution ({scene.reason}); exit code 2: {said}']
    faults = [f'audit: {line.strip()}' for line in AUDIT.findall(outcome.texts['log'])]
    return faults + friction_faults(outcome, scene) + balance(outcome, scene) + \
        bounds(outcome, scene, place)


def without_solution(scene, run):
    """A scene without a solution must end with exit code 2 and the written reason."""
    if run.code == 0:
        return [f'exit code 0, but {scene.reason} ({scene.wish})']
    words = [w for w in SAYS if w in scene.wish]
    if any(re.search(SAYS[w], run.err, re.IGNORECASE) for w in words):
        return []
    return [f'says not that it {" or ".join(words)} ({scene.reason}): '
            + ' / '.join(run.err.strip().split('\n'))]


# Each body's moments balance about its nodes at rest. Those of a pile do so as a whole only where
# nothing slides within it: a force that has slid has another arm on either side. So much of the
# scene's size slides at most, times the forces.
SLIDE = 1e-4


def balance(outcome, scene):
    """Forces and moments on each elastic body: supports, contact, loads."""
    worst, before = {}, {}
    pairs, reactions = {}, {}
    for _, time, label, values in outcome.con:
        pairs.setdefault(time, {})[label] = values
    for _, time, label, values in outcome.rea:
        reactions.setdefault(time, {})[label] = values
    for time, by_pair in sorted(pairs.items()):
        for k, (name, sets, signs, load) in enumerate(scene.balance):
            loads = load(time)
            total = [*loads, *scene.moments[k](time)]
            scale = math.hypot(*loads) + sum(by_pair[label][3] for label in signs)
            for label in sets:
                for m in range(3):
                    total[m] += reactions[time][label][m]
            for label, sign in signs.items():
                for m in range(6):
                    total[m] += sign*by_pair[label][5 + m]
            # The scale of TOL: forces of now, or of the state before.
            larger = max(scale, before.get(name, 0.0), scene.floor)
            before[name] = scale
            noise = scene.noise/larger
            note(worst, name + ': force', math.hypot(*total[:3])/larger,
                 scene.balance_wanted + noise)
            # Reactions have no moments in the table, and a master's arms are those of the slave.
            if not sets:
                exact = all(sign > 0 for sign in signs.values())
                slides = any(by_pair[label][2] > 0 for label in scene.inside)
                note(worst, name + ': moment', math.hypot(*total[3:])/larger/scene.factor,
                     0.01 if not exact else SLIDE if slides else scene.balance_wanted + noise)
    return [f'balance of {name} is off by {value:.1e} of its forces'
            for name, value in worst.items()]


def note(worst, name, value, wanted):
    """Keeps the worst of what is too large."""
    if not value <= max(wanted, worst.get(name, 0.0)):
        worst[name] = value


def bounds(outcome, scene, place):
    """Displacements stay within what the scene can do, bodies do not enter each other."""
    import h5py
    import numpy as np
    faults = []
    with h5py.File(os.path.join(place, 'scene.vtkhdf'), 'r') as file:
        moved = np.asarray(file['VTKHDF/PointData/displacement'])
    far = float(np.sqrt((moved**2).sum(axis=1)).max())
    if not far <= scene.bound:
        faults.append(f'moves by {far:.1e}, at most {scene.bound:.1e} makes sense')
    deep = max((row[3][11] for row in outcome.con), default=0.0)
    if deep > scene.shallow:
        faults.append(f'penetrates by {deep:.1e}, at most {scene.shallow:.1e} makes sense')
    return faults


# Share of the scenes with a solution that a long list of seeds must solve, and in how many linear
# solves an increment (median).
SHARE_SOLVED = 0.995
MEDIAN_SOLVES = 4


def run_live(program, seeds, jobs, keep, report, verbose=False, mortar=False):
    """Runs the scenes, or these with MORTar: one line each, and one test. In a long list a scene with a solution may end
    with exit code 2, but for the share of all of them."""
    long = len(seeds) >= 100
    rows = []
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        tasks = [pool.submit(live, program, seed, keep, mortar) for seed in seeds]
        for seed, task in zip(seeds, tasks):
            row = task.result()
            rows.append(row)
            verdict = 'FAIL' if row.faults else 'converged' if row.code == 0 else 'exit 2 with reason'
            print(f'{row.family:8} {seed:5} {statistics.median(row.solves or [0]):4g} /'
                  f'{max(row.solves, default=0):3} {row.cuts:5} {row.seconds:7.2f} s  {row.wish:18} '
                  f'{verdict}' + (f'  [{row.notes}]' if row.faults or verbose else ''), flush=True)
            for fault in row.faults:
                print('    ' + fault)
            spared = long and row.code == 2 and row.wish == 'solution'
            report.passed += spared or not row.faults
            report.failed += bool(row.faults) and not spared
    if long:
        mine = [row for row in rows if not row.wish.startswith('none')]
        share = sum(not row.faults for row in mine)/max(1, len(mine))
        report.add('share of the realistic scenes with a solution that are solved',
                   [] if share >= SHARE_SOLVED else
                   [f'{100*share:.1f} %, {100*SHARE_SOLVED:g} % wanted'])
        middle = statistics.median([n for row in mine for n in row.solves] or [0])
        report.add('median of linear solves an increment, realistic scenes',
                   [] if middle <= MEDIAN_SOLVES else [f'{middle:g}, {MEDIAN_SOLVES} wanted'])
    return rows


def table(rows):
    """Rows of Markdown, one a family, and one for all."""
    out = ['| family | runs | with a solution: ok of | without: ok of | solves an increment, median / '
           'median of the worst / worst | cuts | CPU s |', '|---|---|---|---|---|---|---|']
    families = [f for f in FAMILIES if any(row.family == f for row in rows)]
    for family in families + ['all']:
        mine = [row for row in rows if family in (row.family, 'all')]
        good = [row for row in mine if not row.wish.startswith('none')]
        bad = [row for row in mine if row.wish.startswith('none')]
        solves = [n for row in good for n in row.solves] or [0]
        worst = [max(row.solves) for row in good if row.solves] or [0]
        out.append(f'| {family} | {len(mine)} | {sum(not r.faults for r in good)} of {len(good)} | '
                   f'{sum(not r.faults for r in bad)} of {len(bad)} | {statistics.median(solves):g} / '
                   f'{statistics.median(worst):g} / {max(solves)} | {sum(r.cuts for r in mine)} | '
                   f'{sum(r.seconds for r in mine):.0f} |')
    return '\n'.join(out)


def failed_list(rows):
    """The seeds that failed, by family, with reason."""
    out = []
    for family in FAMILIES:
        for row in rows:
            if row.family == family and row.faults:
                out.append(f'- {family} {row.seed} ({row.wish}; {row.notes}): ' + '; '.join(row.faults))
    return '\n'.join(out)

