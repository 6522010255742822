"""The answer of REDUced against the penalty, over ten decades."""
import os
import re

import decks
from comparing import read

INPUTS = os.path.join(decks.TOP, 'inputs')
# Deck, form, decades of the penalty over E/h, depth that it is pressed to. GTOS: the element has the
# penalty itself, and an elastic base that does not match locks above 1e4 (manual, "Contact").
SWEEPS = (('press_slide_lift_return', 'NTOS', range(11), 0.01),
          ('sliding_cube', 'NTOS', range(11), 0.005),
          ('sphere_on_plate', 'NTOS', range(11), 0.05),
          ('press_slide_lift_return', 'GTOS', range(11), 0.01),
          ('sliding_cube', 'GTOS', range(5), 0.005))
WANTED = 1e-8


def answer(given, deck, form, decade, folder):
    """Numbers of the reaction table and the largest penetration; what is wrong with the run."""
    text = read(os.path.join(INPUTS, deck + '.inp')).replace('NTOS ', form + ' ', 1)
    text, changes = re.subn(r'PENAlty +AUTO.*', f'PENAlty AUTO 1e{decade}', text)
    assert changes == 1
    place = os.path.join(folder, f'{deck}_{form}_{decade}')
    os.mkdir(place)
    with open(os.path.join(place, 'scene.inp'), 'w', encoding='utf-8') as stream:
        stream.write(re.sub(r'(MESH +)(\S+)', lambda m: f'{m[1]}"{os.path.join(INPUTS, m[2])}"', text))
    done = decks.run(given.program, ['scene.inp', '--quiet', '--solver', 'REDU'], place, 600)
    fault = done.crash() or (done.err.strip() if done.code else '')
    rows = {ending: [[float(item) for item in line.split()[3:]]
                     for line in read(os.path.join(place, 'scene.' + ending)).split('\n')
                     if line.strip() and line[0] != '#'] for ending in ('rea', 'con')}
    return [v for row in rows['rea'] for v in row], max((row[11] for row in rows['con']),
                                                        default=0.0), fault


def sweep(given, deck, form, decades, depth):
    """Rows (penalty, difference from the stiffest, penetration over depth) and faults.

    The share by which a force may differ from its limit is that of the penetration in the depth,
    for by so much less the bodies are pressed; and, where the element itself multiplies a gap
    (GTOS), what one rounding of a coordinate is in the penetration of the stiffest.
    """
    rows, faults = [], []
    with decks.fresh_folder() as folder:
        runs = {k: answer(given, deck, form, k, folder) for k in decades}
    stiffest, least, _ = runs[max(decades)]
    floor = 0.1*WANTED if form == 'NTOS' else 2.2e-16/max(least, 1e-300)
    for decade, (numbers, depths, fault) in runs.items():
        if fault:
            faults.append(f'1e{decade}: {fault}')
            continue
        moved = max(abs(a - b) for a, b in zip(numbers, stiffest))/max(map(abs, stiffest))
        rows.append((decade, moved, depths/depth))
        allowed = depths/depth + floor
        if len(numbers) != len(stiffest) or moved > allowed:
            faults.append(f'1e{decade}: moves by {moved:.1e}, {allowed:.1e} wanted')
        if form == 'NTOS' and depths/depth < WANTED and not moved < WANTED:
            faults.append(f'1e{decade}: moves by {moved:.1e}, penetration is below {WANTED:.0e}')
    return rows, faults


def sweeps(given):
    """Names and results of the sweeps that are asked for."""
    for deck, form, decades, depth in SWEEPS:
        name = f'penalties {deck} {form}'
        if given.names and not any(word in name for word in given.names):
            continue
        if not given.full and not given.names:
            if deck != 'press_slide_lift_return' or form != 'NTOS':
                continue
            decades = range(0, 11, 2)
        if given.count and not given.names:
            continue
        yield name, *sweep(given, deck, form, decades, depth)
