#!/usr/bin/env python3
"""Reads mesh files that were damaged at random: no crash, no hang, every refusal with file:line.

    tests/mutate_meshes.py [--program ./mfec] [--count 300] [--seed 1] [--only N] [--keep DIR]

Each file of tests/meshes is damaged by one to four mutations: bytes, words and lines are removed,
doubled, swapped and replaced, numbers become huge or negative, the end is cut off. Every run
(--check) must end in time with exit code 0 or 1 (3 where memory is short) and without a crash.
The seed is printed; file N is a function of the seed and N alone.
"""
import concurrent.futures
import glob
import os
import random
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import decks  # noqa: E402

SECONDS = 20.0
WORDS = [b'0', b'-1', b'1', b'4', b'5', b'11', b'2147483647', b'2147483648', b'-2147483648',
         b'99999999999999999999', b'1e308', b'-1e308', b'nan', b'inf', b'1e', b'1..2', b'abc', b'',
         b'$Nodes', b'$EndNodes', b'$Elements', b'$End', b'"', b'*NODE', b'*ELEMENT, TYPE=C3D4',
         b'*ELEMENT, TYPE=C3D10', b'*NSET, NSET=a, GENERATE', b'*ELSET, ELSET=shaft',
         b'*SURFACE, NAME=s', b'shaft, S1', b'*SOLID SECTION, ELSET=shaft, MATERIAL=m', b'**', b',',
         b'*INSTANCE', b'*PART', b'1, 100000000, 1', b'4.1', b'2.2', b'4', b'\xff\x00\x80']
DECK = '''MFEC * * a damaged mesh

MATErial 1 steel
  SOLId LINEar
  ELAStic ISOTropic 1000 0.3

MESH {name}

END
BATCh
  DT,,1
  STEP,,1
END
'''


def mutate(rng, data):
    """One mutation of the bytes of a file."""
    kind = rng.randrange(8)
    i, j = sorted((rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)))
    if kind == 0:
        return data[:i]
    if kind == 1:
        return data[:i] + bytes(rng.randrange(256) for _ in range(rng.randint(1, 8))) + data[i+1:]
    if kind == 2:
        j = min(j, i + rng.randint(1, 60))
        return data[:i] + data[j:]
    words = list(re.finditer(rb'[^\s,]+', data))
    lines = data.split(b'\n')
    if kind < 6 and words:
        word = rng.choice(words if rng.random() < 0.5 else words[:200])
        return data[:word.start()] + rng.choice(WORDS) + data[word.end():]
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    if kind == 6:
        lines[a], lines[b] = lines[b], lines[a]
    else:
        lines.insert(a, rng.choice(WORDS + [lines[b]]))
    return b'\n'.join(lines)


def check(program, path, number, seed, keep):
    """Runs one damaged file; returns name and faults."""
    rng = random.Random(seed*1000003 + number)
    with open(path, 'rb') as stream:
        data = stream.read()
    for _ in range(rng.randint(1, 4)):
        data = mutate(rng, data) or b' '
    name = f'm{number}_' + os.path.basename(path)
    with decks.fresh_folder() as folder:
        for target in [folder] + ([keep] if keep else []):
            with open(os.path.join(target, name), 'wb') as stream:
                stream.write(data)
            with open(os.path.join(target, f'm{number}.inp'), 'w', encoding='ascii') as stream:
                stream.write(DECK.format(name=name))
        run = decks.run(program, [f'm{number}.inp', '--check'], folder, SECONDS)
    faults = [run.crash()] if run.crash() else []
    if run.code not in (0, 1, 3):
        faults.append(f'exit code {run.code}')
    if run.code == 1 and not re.search(r'^[^\n]*:\d+:\d+: error: ', run.err, re.M):
        faults.append('a refusal without file:line')
    return name, faults + ([run.err[-1500:]] if faults else []), run.code


def main():
    options = decks.parser(__doc__)
    options.add_argument('--count', type=int, default=300)
    options.add_argument('--seed', type=int, default=1)
    options.add_argument('--only', type=int)
    options.add_argument('--keep')
    given = options.parse_args()
    files = sorted(glob.glob(os.path.join(decks.HERE, 'meshes', '*.msh')) +
                   glob.glob(os.path.join(decks.HERE, 'meshes', '*.inp')))
    numbers = [given.only] if given.only is not None else range(given.count)
    print(f'seed {given.seed}')
    report = decks.Report(given.verbose)
    codes = {}
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        jobs = [pool.submit(check, given.program, files[n % len(files)], n, given.seed, given.keep)
                for n in numbers]
        for job in jobs:
            name, faults, code = job.result()
            codes[code] = codes.get(code, 0) + 1
            report.add(name, faults)
    print('exit codes', dict(sorted(codes.items())))
    return report.close()


if __name__ == '__main__':
    sys.exit(main())
