"""Augmented Lagrangian: the answer no longer depends on the penalty, and nothing penetrates."""
import os
import re

import decks
import roller_studies
from contact_studies import square
from friction_studies import base

EXACT = 'exact'
PENALTIES = ('0.1', '1', '10', '100', '1e4')


def augmented(path, factor, *, penalty='AUTO', changes=()):
    """The text of a deck with AUGMent and another penalty."""
    with open(os.path.join(decks.TOP, path), encoding='ascii') as stream:
        lines = stream.read().split('\n')
    text = '\n'.join(f'    PENAlty {penalty} {factor}\n    AUGMent' if line.split()[:1] == ['PENAlty']
                     else line for line in lines)
    for old, new in changes:
        if old not in text:
            raise ValueError(f'{path} has no {old!r}')
        text = text.replace(old, new)
    return text


def spread(values):
    """Largest difference over the largest value."""
    return (max(values) - min(values))/max(abs(value) for value in values)


def deepest(rows):
    """Deepest penetration or longest elastic slip of all rows."""
    return max(max(abs(row['max_penetration']), row['max_elastic_slip']) for row in rows)


def weighted_gap(tables):
    """Largest gap over a facet that the last update of an increment has left, from the log.

    At the nodes of NTOS it is that of the node, on the facets of GTOS the weighted one.
    """
    largest, last = 0.0, None
    with open(tables.base + '.log', encoding='utf-8') as stream:
        for line in stream:
            found = re.search(r'updates?, gap (\S+) of a facet', line)
            if found:
                last = float(found.group(1))
            elif re.search(r'increment +\d+ converged', line):
                if last is None:
                    raise ValueError(f'{tables.base}.log has an increment without a gap')
                largest, last = max(largest, last), None
    return largest


def scenes(bench):
    """Text and pair of the scenes that are run with every penalty, by name."""
    mesh = os.path.join(decks.TOP, 'inputs', 'sphere.msh')
    roller = os.path.join(bench.folder, 'roller.inp')
    with open(roller, 'w', encoding='ascii') as stream:
        stream.write(roller_studies.roller_deck(*roller_studies.slices(50.0, 0.3, 24, 1.25, 14),
                                                1.105))
    return {
        'cube': ('inputs/sliding_cube.inp', 'sole_on_track', (
            ('npress = 5', 'npress = 2'), ('nslide = 25', 'nslide = 5'),
            ('phi = 0', f'phi = {bench.draw("phi", -80.0, 80.0)}'))),
        'roller': (roller, 'roller', ()),
        'sphere': ('inputs/sphere_on_plate.inp', 'sole_on_track', (
            ('MESH sphere.msh', f'MESH "{mesh}"'), ('STEP,,15', 'STEP,,5')))}


def any_penalty(bench):
    """Nodes and facets: forces and weighted gaps with penalties from 0.1 to 1e4 E/h."""
    found = scenes(bench)
    for name, form in (('cube', 'NTOS'), ('cube', 'GTOS'), ('roller', 'NTOS'), ('roller', 'GTOS'),
                       ('sphere', 'GTOS')):
        path, pair, changes = found[name]
        forces, gaps = [], []
        for factor in ('0.1', '1', '10', '100', '1e3', '1e4'):
            tables = bench.run_text(f'{name}_{form}_{factor}', augmented(
                path, factor, changes=changes).replace('NTOS ', form + ' '))
            rows = tables.contact(pair)
            gaps.append(weighted_gap(tables))
            forces.append([row[k] for row in rows for k in ('Fn', 'Ft')])
        bench.compare(f'{name}: Fn, Ft of all rows, spread', EXACT, 0.0,
                      max(spread(values) for values in zip(*forces) if max(values) > 0), 1e-5,
                      scale=1.0, form=form + ' +AUGM')
        bench.compare(f'{name}: weighted gap over a facet', EXACT, 0.0, max(gaps), 1e-6, scale=1.0,
                      form=form + ' +AUGM')


def patch(bench):
    """Blocks pressed together: the stress of one piece."""
    young, nu, depth = bench.draw('E', 200.0, 5000.0), bench.draw('nu', 0.05, 0.45), 0.01
    modulus = young*(1 - nu)/((1 + nu)*(1 - 2*nu))
    p = depth*modulus/2
    side = -p*nu/(1 - nu)
    exact = (side, side, -p, 0.0, 0.0, 0.0)
    for factor in PENALTIES:
        deck = augmented('tests/verification/contact_patch/contact_patch.inp', factor)
        tables = bench.run_text(f'patch_{factor}', deck, young=young, nu=nu)
        error = max(square(stress, exact) for stress in tables.stresses())
        bench.compare(f'stress, penalty {factor} E/h', EXACT, 0.0,
                      (error/square(exact, (0.0,)*6))**0.5, 1e-6, scale=1.0)
        bench.compare(f'penetration over 1/3, {factor} E/h', EXACT, 0.0,
                      deepest(tables.contact('joint'))*3, 1e-6, scale=1.0)


def slide(bench):
    """Presses, slides, lifts, returns: every penalty gives the same rows, and Coulomb's law."""
    last, depths = [], []
    drawn = {'mu': bench.draw('mu', 0.05, 0.5), 'way': bench.draw('way', 0.3, 0.7),
             'depth': bench.draw('depth', 0.005, 0.02), 'gap': bench.draw('gap', 0.0005, 0.003)}
    for factor in PENALTIES:
        tables = bench.run_text(f'slide_{factor}', augmented(
            'inputs/press_slide_lift_return.inp', factor), **drawn)
        rows = tables.contact('block_on_base')
        depths.append(deepest(rows)/0.5)
        last.append([row['Fn'] for row in rows if row['Fn'] > 0] + [
            row['Ft'] for row in rows if row['Ft'] > 0])
        row = rows[11]
        bench.compare(f'Ft/Fn sliding, penalty {factor} E/h', EXACT, drawn['mu'], row['Ft']/row['Fn'], 1e-10)
        top = tables.reactions('top')[11]
        bench.compare(f'R + F over Fn, penalty {factor} E/h', EXACT, 0.0, max(
            abs(top[f'R{k}'] + row[f'F{k}']) for k in (1, 2, 3))/row['Fn'], 1e-9, scale=1.0)
    bench.compare('Fn and Ft of all rows, spread over penalties', EXACT, 0.0,
                  max(spread(values) for values in zip(*last)), 1e-5, scale=1.0)
    bench.compare('penetration and elastic slip over a facet', EXACT, 0.0, max(depths), 1e-6,
                  scale=1.0)


def stuck(bench):
    """A block held by contact alone under dead loads below the limit rests where it is."""
    ratio, place = bench.draw('T/N', 0.05, 0.3), base(bench, 0.5)
    mu = ratio*bench.draw('mu over T/N', 1.03, 2.0)
    for factor in PENALTIES:
        last = bench.run_text(f'stuck_{factor}', augmented(
            'tests/verification/block_dead_loads/block_dead_loads.inp', factor), mu=mu, ratio=ratio,
                              **place).contact('sole')[-1]
        bench.compare(f'Ft/N, penalty {factor} E/h', EXACT, ratio, last['Ft']/100, 1e-3)
        bench.compare(f'slipping nodes, penalty {factor} E/h', EXACT, 0.0, last['slip'], 0.0, scale=1.0)
        bench.compare(f'penetration and elastic slip, {factor} E/h', EXACT, 0.0, deepest([last]), 1e-7,
                      scale=1.0)


def edge(bench):
    """A tip over a kinked edge: penalties per node, the multiplier turns with the facet."""
    forces, depths = [], []
    drawn = {'mu': bench.draw('mu', 0.05, 0.4), 'slope': bench.draw('slope', 0.03, 0.15),
             'depth': bench.draw('depth', 0.005, 0.02)}
    for factor in ('10', '100', '1e3', '1e5', '1e7'):
        tables = bench.run_text(f'edge_{factor}', augmented(
            'inputs/two_facet_edge.inp', factor, penalty=''), **drawn)
        rows = tables.contact('tip_on_roof')
        depths.append(deepest(rows))
        forces.append([row[f'F{k}'] for row in rows[8:] for k in (1, 3)])
        bench.compare(f'Ft/Fn behind the edge, penalty {factor}', EXACT, drawn['mu'],
                      rows[23]['Ft']/rows[23]['Fn'], 1e-10)
    bench.compare('F1 and F3 of all rows, spread over penalties', EXACT, 0.0,
                  max(spread(values) for values in zip(*forces)), 1e-5, scale=1.0)
    bench.compare('penetration and elastic slip over a facet', EXACT, 0.0, max(depths)/2, 1e-6,
                  scale=1.0)


def sphere(bench):
    """A sphere pressed on an elastic plate and dragged."""
    forces, depths, mu = [], [], bench.draw('mu', 0.05, 0.4)
    mesh = os.path.join(decks.TOP, 'inputs', 'sphere.msh')
    for factor in PENALTIES:
        deck = augmented('inputs/sphere_on_plate.inp', factor, changes=(
            ('MESH sphere.msh', f'MESH "{mesh}"'), ('STEP,,15', 'STEP,,5')))
        rows = bench.run_text(f'sphere_{factor}', deck, mu=mu).contact('sole_on_track')
        depths.append(deepest(rows)/0.107)
        forces.append([row[name] for row in rows for name in ('Fn', 'Ft')])
    bench.compare('Fn and Ft of all rows, spread over penalties', EXACT, 0.0,
                  max(spread(values) for values in zip(*forces)), 1e-5, scale=1.0, known=3e-3,
                  why='a tip on a kinked edge of the dented plate: from each of its two facets it lies on the '
                  'other (by 1e-3 and 2e-4 of a facet), so either may hold it, and with another penalty the other '
                  'does; it is one point of 24 in one increment, and the next ones agree to 2e-7')
    bench.compare('penetration and elastic slip over a facet', EXACT, 0.0, max(depths), 1e-6,
                  scale=1.0)
