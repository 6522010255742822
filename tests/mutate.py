#!/usr/bin/env python3
"""Runs the program on decks that were damaged at random.

    tests/mutate.py [--program ./mfec] [--count 500] [--first 0] [--seed 1] [--only N] [--keep DIR]
                    [--jobs N]

Each deck of inputs/ and tests/ is damaged by one to four mutations, sound ones more often: lines, items and characters are
removed, doubled and swapped, numbers become huge, negative or NaN, keywords change, bytes are
random, the end is cut off. Every run must end in time, without a crash, with exit code 0, 1 or 2
(3 where memory is short); a refusal (1) names file:line and leaves no file; tables that are written
are whole, and a run that ends with 0 has passed the audit of its own balance. Half of the decks run
with --check first; of what that accepts all run but the decks that take long as they are (LONG).
Time is time of the processor, so that a loaded machine is no hang.
The seed is printed; deck N is a function of the seed and N alone (--only N repeats it).
"""
import concurrent.futures
import glob
import os
import random
import re
import resource
import signal
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import decks  # noqa: E402

SECONDS = 10  # a run that takes longer hangs, unless its deck is legal and merely large
WAIT = 120  # the same by the clock of the wall: what sleeps takes no time of the processor
LONG = ('coarse_to_fine', 'sliding_cube_segmented', 'sphere_on_plate')  # these are only checked
MEMORY = 2*1024**3
NUMBERS = ['0', '-1', '1e308', '-1e308', 'nan', 'inf', '1e-320', '99999999', '2147483648',
           '-2147483649', '1e', '1/0', '1..2', '(1', '3.5', '1d400', 'sqrt(-1)', '0x10', '""']
WORDS = ['COOR', 'ELEM', 'MATE', 'BOUN', 'EBOU', 'FORC', 'DISP', 'EDIS', 'FPRO', 'PROP', 'BLOC',
         'PARA', 'INCL', 'SET', 'SURF', 'CONT', 'PAIR', 'NTOS', 'MORT', 'PENA', 'FRIC', 'DIRE', 'SLIP',
         'OUTP', 'BATC', 'DT', 'TIME', 'TANG', 'STEP', 'TOL', 'SOLV', 'LOOP', 'NEXT', 'TIE', 'MESH',
         'END', 'STOP', 'PLAN', 'BOX', 'NODE', 'INSI', 'OR', 'CART', 'TET4', 'AREA', 'ELLI', 'XYZZY',
         '&', ',,', '=', '!', "'a", 'a' * 40]
NUMBER = re.compile(r'(?<![\w.])[-+]?\d+\.?\d*(?:[ed][-+]?\d+)?(?![\w.])', re.I)


def pick(rng, items, text, new):
    """Replaces one of the matches by new, the text itself where there is none."""
    found = list(items.finditer(text))
    if not found:
        return text
    match = rng.choice(found)
    return text[:match.start()] + new(match.group()) + text[match.end():]


def scaled(rng, number):
    """A number near the one that stands there."""
    try:
        value = float(number.lower().replace('d', 'e'))
        int(value)
    except (ValueError, OverflowError):
        return number
    if abs(value) > 1e300:
        return number
    return rng.choice([repr(-value), repr(value*rng.choice([0.1, 0.5, 2, 3])), str(int(value) + 1),
                       str(int(value) - 1)])


def mutate(rng, text):
    """One mutation of a deck."""
    lines = text.split('\n')
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(14)
    if kind == 0:
        del lines[i]
    elif kind == 1:
        lines.insert(j, lines[i])
    elif kind == 2:
        lines[i], lines[j] = lines[j], lines[i]
    elif kind in (3, 4):
        words = re.split(r'([ ,=]+)', lines[i])
        k, m = rng.randrange(len(words)), rng.randrange(len(words))
        if kind == 3:
            del words[k]
        else:
            words[k], words[m] = words[m], words[k]
        lines[i] = ''.join(words)
    elif kind in (5, 6):
        return pick(rng, NUMBER, text, lambda old: rng.choice(NUMBERS))
    elif kind in (7, 8):
        return pick(rng, NUMBER, text, lambda old: scaled(rng, old))
    elif kind == 9:
        return pick(rng, re.compile(r'[A-Za-z_]\w*'), text, lambda old: rng.choice(WORDS))
    elif kind == 10:
        return pick(rng, re.compile(r'[A-Za-z_]\w+'), text,
                    lambda old: old[:1] + old[2:] + rng.choice(['', old[1:2], 'x']))
    elif kind == 11:
        place = rng.randrange(len(text) + 1)
        return text[:place] + ''.join(chr(rng.randrange(256)) for _ in range(rng.randint(1, 6))) \
            + text[place:]
    elif kind == 12:
        return text[:rng.randrange(len(text) + 1)]
    else:
        lines.insert(i, rng.choice(WORDS) + ' ' + ' '.join(rng.choices(NUMBERS, k=3)))
    return '\n'.join(lines)


def damaged(seed, number, bases):
    """Deck `number`: its base and its text."""
    rng = random.Random(f'{seed}/{number}')
    sound = [b for b in bases if f'bad_decks{os.sep}' not in b]
    base = rng.choice(sound if sound and rng.random() < 0.8 else bases)
    with open(base, encoding='latin-1') as stream:
        text = stream.read()
    for _ in range(rng.choice([1, 1, 2, 4])):
        text = mutate(rng, text) or '\n'
    return base, text


def short_memory(program):
    """What runs in the child: a deck for 10**9 nodes must not take the machine down."""
    sanitised = decks.is_sanitised(program)

    def limit():
        if not sanitised:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    return limit


def whole(path):
    """What is wrong with a table, '' if nothing."""
    with open(path, 'rb') as stream:
        text = stream.read()
    if text and not text.endswith(b'\n'):
        return 'ends within a line'
    widths = {len(line.split()) for line in text.split(b'\n') if line and line[:1] != b'#'}
    return 'has rows of different length' if len(widths) > 1 else ''


def trial(program, base, text, check, limit):
    """Runs one damaged deck; its exit code and what is wrong."""
    with decks.fresh_folder() as folder:
        deck, out = os.path.join(folder, 'damaged.inp'), os.path.join(folder, 'out')
        os.mkdir(out)
        with open(deck, 'w', encoding='latin-1', newline='') as stream:
            stream.write(text)
        for path in glob.glob(os.path.join(os.path.dirname(base), '*')):
            if os.path.isfile(path) and os.path.basename(path) in text:  # what the deck includes
                os.symlink(path, os.path.join(folder, os.path.basename(path)))

        def attempt(more):
            return decks.run(program, [deck, '--out', out] + more, folder, WAIT, limit)
        if check:
            done = attempt(['--check'])
            faults = judge(done, out)
            if faults or done.code or is_long(base):
                return done.code, faults
        done = attempt([])
        if is_late(done):  # legal but large?
            for path in glob.glob(os.path.join(out, '*')):
                os.remove(path)
            done = attempt(['--check'])
        return done.code, judge(done, out)


def is_late(done):
    """Whether a run was ended because it took too long."""
    return done.timed_out or done.code in (-signal.SIGXCPU, -signal.SIGKILL)


def is_long(base):
    """Whether a deck takes long as it is."""
    return os.path.basename(base)[:-4] in LONG


def judge(done, out):
    """What is wrong with a finished run."""
    faults = [f for f in [done.crash()] if f]
    if faults:
        return faults + [done.err[-600:]]
    if done.code not in (0, 1, 2) and not (done.code == 3 and 'memory' in done.err):
        faults.append(f'exit code {done.code}')
    if done.code == 1 and not re.search(r'^[^\n:]+:\d+:\d+: error: ', done.err, re.M):
        faults.append('a refusal without file:line:column')
    if done.code != 0 and not done.err.strip():
        faults.append('nothing on standard error')
    left = sorted(os.listdir(out))
    if done.code == 1 and left:
        faults.append('left behind: ' + ' '.join(left))
    for name in left:
        if name.endswith(('.rea', '.con')):
            fault = whole(os.path.join(out, name))
            faults += [f'{name} {fault}'] if fault else []
    return faults + ([done.err[-600:]] if faults else [])


def main():
    options = decks.parser(__doc__)
    options.add_argument('--count', type=int, default=500, help='how many')
    options.add_argument('--seed', type=int, default=1, help='of the random numbers')
    options.add_argument('--first', type=int, default=0, help='number of the first')
    options.add_argument('--only', type=int, help='run this deck and print it')
    options.add_argument('--jobs', type=int, default=decks.processors(), help='at a time')
    options.add_argument('--keep', default='build/mutate', help='where failing decks are kept')
    given = options.parse_args()
    bases = sorted(p for pattern in ('inputs/*.inp', 'tests/bad_decks/*.inp',
                                     'tests/regression/*/*.inp')
                   for p in glob.glob(os.path.join(decks.TOP, pattern)))
    report = decks.Report(given.verbose)
    if not bases:
        report.add('base decks', ['there are none'])
        return report.close()
    limit = short_memory(given.program)
    print(f'seed {given.seed}, {given.count} decks from {len(bases)}')

    def one(number):
        base, text = damaged(given.seed, number, bases)
        check = number % 2 == 1 or is_long(base)
        return number, base, text, trial(given.program, base, text, check, limit)

    codes = {}
    numbers = range(given.first, given.first + given.count) if given.only is None else [given.only]
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for number, base, text, (code, faults) in pool.map(one, numbers):
            codes[code] = codes.get(code, 0) + 1
            if given.only is not None:
                print(text)
            if faults:
                os.makedirs(given.keep, exist_ok=True)
                kept = os.path.join(given.keep, f'{given.seed}-{number}.inp')
                with open(kept, 'w', encoding='latin-1', newline='') as stream:
                    stream.write(text)
                faults.insert(0, f'{os.path.relpath(base, decks.TOP)} -> {kept}')
            report.add(f'mutation {number}', faults)
    print('exit codes: ' + ', '.join(f'{n} times {code}' for code, n in sorted(codes.items())))
    return report.close()


if __name__ == '__main__':
    sys.exit(main())
