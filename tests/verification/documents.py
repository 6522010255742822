"""The document of a run: findings, the table of all rows, and the spread over seeds."""
import json
import math
import os
import re

import decks

VERDICTS = ('holds', 'coarse', 'misses', 'FAILS')


def place(folder, seed, study):
    """File of a study that is kept."""
    name = ''.join(c if c.isalnum() else '_' for c in study)
    return os.path.join(folder, f'{seed:03}', name + '.json')


def kept(folder, seed, study):
    """Whether an earlier run has left the rows of a study."""
    return bool(folder) and os.path.exists(place(folder, seed, study))


def keep(folder, seed, study, rows):
    """Leaves the rows of a study for `write_spread`."""
    if not folder:
        return
    path = place(folder, seed, study)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + '.part', 'w', encoding='utf-8') as stream:
        json.dump([{'name': row.name(), 'error': float(row.error) if math.isfinite(row.error) else 1e99,
                    'wanted': row.wanted, 'verdict': row.verdict(), 'why': row.why} for row in rows], stream)
    os.replace(path + '.part', path)


def write_spread(folder, path):
    """Least and largest error of each row over the seeds, how many hold, and the cause where not all do."""
    found = {}
    for seed in sorted(os.listdir(folder)):
        for name in sorted(os.listdir(os.path.join(folder, seed))):
            with open(os.path.join(folder, seed, name), encoding='utf-8') as stream:
                for row in json.load(stream):
                    found.setdefault(row['name'], []).append(dict(row, seed=int(seed)))
    spread = {name: {
        'least': min(row['error'] for row in rows), 'largest': max(row['error'] for row in rows),
        'at': max(rows, key=lambda row: row['error'])['seed'], 'wanted': rows[0]['wanted'], 'seeds': len(rows),
        'why': next((row['why'] for row in rows if row['verdict'] != 'holds'), ''),
        **{word: sum(row['verdict'] == word for row in rows) for word in VERDICTS}}
        for name, rows in sorted(found.items())}
    with open(path, 'w', encoding='utf-8') as stream:
        json.dump(spread, stream, indent=0, sort_keys=True)
        stream.write('\n')


def read_spread(path):
    """The spread, by the name of a row; empty where there is none."""
    if not path or not os.path.exists(path):
        return {}
    with open(path, encoding='utf-8') as stream:
        return json.load(stream)


def over_seeds(rows):
    """Two cells of the overview: rows that hold with every seed, and the worst error over wanted."""
    if not rows:
        return '– | –'
    worst = max((row for row in rows if row['wanted'] > 0), default=None,
                key=lambda row: row['largest']/row['wanted'])
    whole = sum(row['holds'] == row['seeds'] for row in rows)
    return f'{whole} of {len(rows)} | ' + (
        f'{worst["largest"]:.1e} / {worst["wanted"]:.2g} (seed {worst["at"]})' if worst else '')


def overview(bench, spread, folder):
    """What is reached: a line for each case, with its page in the folder of the table (doc/cases.py)."""
    seeds = max((row['seeds'] for row in spread.values()), default=0)
    lines = [f'| case | rows | hold | coarse | miss | worst row on the finest mesh, error / wanted | rows that hold with '
             f'each of {seeds} seeds | largest error / wanted of the seeds |', '|---|---|---|---|---|---|---|---|']
    for case in dict.fromkeys(row.case for row in bench.rows):
        rows = [row for row in bench.rows if row.case == case]
        count = [sum(row.verdict() == word for row in rows) for word in VERDICTS[:3]]
        last = [row for row in rows if not row.finer and row.wanted > 0 and math.isfinite(row.error)]
        worst = max(last, key=lambda row: row.error/row.wanted, default=None)
        page = re.sub(r'[^a-z0-9]+', '-', case.lower()).strip('-')
        lines.append(f'| [{case}]({folder}/{page}.md) | {len(rows)} | ' + ' | '.join(str(n) for n in count) + ' | ' + (
            f'{worst.form}: {worst.quantity}, {worst.error:.1e} / {worst.wanted:.2g}' if worst else '') + ' | ' +
            over_seeds([row for name, row in spread.items() if name.split(' | ')[0] == case]) + ' |')
    return lines


def missed(bench):
    """What the run has not reached, by cause."""
    causes = {}
    for row in bench.rows:
        if row.verdict() in ('misses', 'FAILS'):
            causes.setdefault((row.case, row.why), []).append(
                (row.form, row.quantity, row.error, row.error, row.wanted, ''))
    return ['', f'With seed {bench.seed}:', ''] + said(causes)


def missed_over_seeds(spread):
    """What some seed has not reached on the reduced meshes, by cause."""
    causes = {}
    for name, row in spread.items():
        case, form, quantity = name.split(' | ')
        if row['misses'] + row['FAILS'] > 0:
            causes.setdefault((case, row['why']), []).append((
                form, quantity, row['least'], row['largest'], row['wanted'],
                f', {row["holds"]} of {row["seeds"]} hold'))
    if not spread:
        return []
    return ['', 'With some seed, on the meshes of the seeds:', ''] + said(causes)


def said(causes):
    """A line for each cause: its worst row of each form of contact, and how many rows there are."""
    lines = ['| case | what | cause |', '|---|---|---|']
    for (case, why), rows in causes.items():
        texts = []
        for form in dict.fromkeys(row[0] for row in rows):
            mine = [row for row in rows if row[0] == form]
            _, quantity, least, largest, wanted, hold = max(mine, key=lambda row: row[3])
            error = f'{largest:.1e}' if least == largest else f'{least:.1e} to {largest:.1e}'
            more = f', the worst of {len(mine)} rows' if len(mine) > 1 else ''
            texts.append(f'{form}: {quantity}, {error} ({wanted:.2g} wanted{hold}{more})')
        lines.append(f'| {case} | ' + '; '.join(texts) + f' | {why or "–"} |')
    return lines


def seeds_of(row, spread):
    """The cell of a row for its spread."""
    there = spread.get(row.name())
    if not there:
        return '–'
    return f'{there["least"]:.1e} to {there["largest"]:.1e}, {there["holds"]} of {there["seeds"]} hold'


def write_table(bench, path, spread):
    """All rows, what was drawn, and the remarks."""
    lines = ['# Verification: all rows', '',
             f'Written by `make verify` (seed {bench.seed}); what the words mean stands in the verification manual.', '',
             '| case | form | quantity | reference | its source | reached | error | wanted | verdict | error over the seeds |',
             '|---|---|---|---|---|---|---|---|---|---|']
    for row in bench.rows:
        lines.append('| ' + ' | '.join([
            row.case, row.form, row.quantity, f'{row.reference:.8g}', row.source, f'{row.reached:.8g}',
            f'{row.error:.1e}', f'{row.wanted:.2g}', row.verdict(), seeds_of(row, spread)]) + ' |')
    lines += ['', '## Not reached'] + missed(bench) + missed_over_seeds(spread)
    lines += ['', '## Numbers drawn', ''] + [
        f'- {case}: ' + ', '.join(f'{name} {value}' for name, value in drawn.items())
        for case, drawn in bench.drawn.items()]
    lines += ['', '## Remarks', ''] + ['- ' + remark for remark in bench.remarks]
    os.makedirs(os.path.dirname(path) or '.', exist_ok=True)
    with open(path, 'w', encoding='utf-8') as stream:
        stream.write('\n'.join(lines) + '\n')


def write_findings(bench, path, table, spread):
    """The overview; in a file that marks its place, there."""
    def link(target):
        return os.path.relpath(target, os.path.dirname(path) or '.')
    lines = overview(bench, spread, link(os.path.dirname(table)) if table else 'verification')
    if table:
        lines += ['', f'All rows, the numbers drawn and remarks: [table.md]({link(table)}).']
    decks.replace_part(path, 'verify', '\n'.join(lines).strip() + '\n')
