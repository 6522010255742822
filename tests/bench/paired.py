"""One scene against another, in turn: what a method, many increments, derivatives or a study cost
over the plain run, and what CalculiX takes for the same scene. A busy machine slows both of a pair,
so that their ratio holds."""
import dataclasses
import os
import statistics
import time

import jobs
import measure
import own_deck
import results
import scenes
import sections
import targets

START, PAIRS = '## One scene against another', 5
COLUMNS = ('row', 'size', 'pairs', 'cpu', 'cpu_other', 'least', 'median', 'largest', 'limit',
           'load', 'date')
LAW = (('MESH mesh.inp', 'PARAmeter\n  m1 = 0.1\n  m2 = 0.08\n  phi = 30\n\nMESH mesh.inp'),
       ('FRICtion COULomb 0.1', 'FRICtion ELLIptic m1 m2\n    DIREction ANGLe phi 1 0 0'))
# the same friction; other answers are not looked for where a law changes the cone
STEADY = (('FRICtion COULomb 0.1', 'FRICtion COULomb 0.1\n    DECAy 0.1 0.1 1'),)
EIGHT = (('OUTPut', 'SENSitivity\n  mu1 mu2 phi slip penalty\n  young MATErial 1\n  way top 1\n'
          '  way top 3\n\nOUTPut'),)


def study(m2, phi):
    """A study of the smaller coefficient and the lay."""
    return (('OUTPut', f'STUDy friction\n  m2 {m2}\n  phi {phi}\n\nOUTPut'),)


TWENTY = study('0.06 0.07 0.08 0.09', '0 20 40 60 80')
MANY = study('0.05 TO 0.095 BY 0.005', '0 TO 85.5 BY 4.5')


SEGMENT_LIMIT = (
    'SEGMent has more than twenty times the points of NTOS, and each costs its element in every residual '
    'and tangent, and its share of cutting the cells before and after each increment. What both '
    'share (mesh, factors of the bodies, recovery of the interior) is the smaller part. No cost stands '
    'out any more.')
MORTAR_LIMIT = (
    'MORTar forms the compliance of its nodes once an increment; what is left are four to five '
    'rounds, which weigh the nodes anew, and cutting the facets.')
BEST_LIMIT = (
    'The factors of the two bodies are bound by the speed of products, and CalculiX, whose '
    'iterations wait for the memory, loses less on a processor that multiplies slowly: on one that '
    'does so twice as fast 37.9 times was measured with an older program (this table in the '
    'commit 91dae3a5).')
MANY_LIMIT = (
    '1,000 increments: reactions and audit come from the contact forces, interior displacements are '
    'found at every 64th output time, and a dense factor serves until a point changes its facet. What '
    'is left are the iterations themselves: an increment takes one of Newton and three modified '
    'Newton steps, each some products with the compliance. The results file is extended and '
    'flushed at each output time, so that a kill loses nothing that has converged.')


EIGHT_LIMIT = (
    'Eight derivatives: a run without them shrinks the '
    'factors of the bodies and recovers interior displacements at the last of 22 output times; with derivatives '
    'these are found at each, from whole factors, and the contact factor has to answer to more '
    'digits. Of what they add themselves about half are products of blocks of six directions with the '
    'compliance and with C U, bound by reading these; the other half has no largest part: solves '
    'with the dense factor, element matrices, orthogonalisation, the scene\'s levers, element '
    'slopes, ways to new hosts. Answers of the increment before are no start: forces beside the '
    'normal ones change altogether where points pass to other facets.')


@dataclasses.dataclass(frozen=True)
class Row:
    """Two scenes; the time of the first is divided by that of `each` runs of the second."""

    name: str
    size: int
    wanted: float
    scene: str = jobs.CUBE
    method: str = 'NTOS'
    changes: tuple = ()
    base: tuple = ()
    each: int = 1
    shares: int = 2     # costs that are named
    why: str = ''       # what keeps it from its target, or what the ratio does not say
    other: str = jobs.CUBE      # the second scene
    other_method: str = 'NTOS'
    options: tuple = ()         # of the second run
    calculix: str = ''          # the second run is CalculiX's, in this mode (jobs.CCX_MODES)


MAKERS = {**jobs.MAKERS, 'cube_force': scenes.forced_cube, 'cubes_27': scenes.loose_cubes,
          'disc_neo': scenes.turning_disc, 'punch_ten': scenes.punch,
          'cube_press': lambda n: scenes.sliding_cube(n, increments=(10,), way=0.0),
          'cube_partial': lambda n: scenes.sliding_cube(n, friction=0.9, increments=(2, 10),
                                                        way=0.002)}
NODES = {'method': 'MORTar', 'other_method': 'GTOS'}
LOOSE = (('FRICtion COULomb 0.5\n', 'FRICtion COULomb 0.5\n' + scenes.JOINTS),)
UMFPACK = dict(scene='cubes_27', method='GTOS', changes=LOOSE, other='cubes_27',
               other_method='GTOS', base=LOOSE, options=('--solver', 'UMFPack'))

CUBE_NEO = dict(scene='cube_neo', other='cube_neo', options=('--solver', 'UMFPack'))
DISC_NEO = dict(scene='disc_neo', changes=scenes.TURN, other='disc_neo', base=scenes.TURN,
                options=('--solver', 'UMFPack'))
NEO_LIMIT = (
    'A pass through the factors reads them twice, in single precision at the speed of the memory, and '
    'leaves about the strain: 1/150 in the cube, 1/60 in the disc, so that an increment takes 6 and '
    '7 to 8 of them for the digits that are asked for. They are about two fifths of the time in the '
    'cube, half of it in the disc; residuals are a seventh and a quarter.')

ANSWERS_LIMIT = (
    'Other answers are not looked for under a law that changes the cone: the second deck has DECAy of '
    'equal coefficients, whose own cost hides that of the search. Against the same program without it '
    '(user and system time, nine pairs in turn, medians): steady friction 1.03 (n = 8) and 1.04 '
    '(n = 12), partial slip 1.03 (n = 12), T10 punch 1.05 (n = 8; least over least 1.01).')

# CalculiX with its iterative solver, the best of its settings here
BEST, SURFACE = {'calculix': 'N2S iterative'}, {'calculix': 'S2S iterative'}

ROWS = (
    Row('NTOS against CalculiX, its best solver', 12, 1/30, **BEST),
    Row('NTOS against CalculiX, its best solver', 16, 1/30, **BEST),
    Row('NTOS against CalculiX, its best solver', 20, 1/40, why=BEST_LIMIT, **BEST),
    Row('NTOS against CalculiX, its default solver', 12, 1/120, calculix='N2S default'),
    Row('SEGMent against CalculiX surface to surface', 12, 1/15, method='SEGMent', **SURFACE),
    Row('SEGMent against NTOS', 12, 2.5, method='SEGMent', shares=6, why=SEGMENT_LIMIT),
    Row('GTOS against NTOS', 12, 1.8, method='GTOS'),
    Row('MORTar against GTOS', 12, 2.0, method='MORTar', other_method='GTOS', why=MORTAR_LIMIT),
    Row('MORTar against GTOS, pressed', 12, 1.5, scene='cube_press', other='cube_press', **NODES),
    Row('MORTar against GTOS, partial slip', 12, 1.5, scene='cube_partial', other='cube_partial',
        **NODES),
    Row('MORTar against GTOS, T10 punch', 8, 1.5, scene='punch_ten', other='punch_ten',
        method='MORTar', other_method='GTOS 6'),
    Row('other answers looked for against not', 8, 1.05, base=STEADY),
    Row('other answers looked for against not', 12, 1.05, base=STEADY, why=ANSWERS_LIMIT),
    Row('force control against displacement control', 12, 2.5, scene='cube_force'),
    Row('27 cubes, AUTO against UMFPACK', 4, 1.2, **UMFPACK),
    Row('27 cubes, AUTO against UMFPACK', 8, 0.2, **UMFPACK),
    Row('neo-Hooke cube, AUTO against UMFPACK', 20, 1/15, **CUBE_NEO),
    Row('neo-Hooke disc that turns, AUTO against UMFPACK', 24, 1/15, why=NEO_LIMIT, **DISC_NEO),
    Row('1,000 increments against 22', 8, None, scene='cube_1000', shares=8, why=MANY_LIMIT),
    Row('eight derivatives against none', 20, 1.15, changes=LAW + EIGHT, base=LAW,
        why=EIGHT_LIMIT),
    Row('20 variants against 20 runs', 12, 1/3, changes=LAW + TWENTY, base=LAW, each=20),
    Row('20 variants against 20 runs', 20, 1/3, changes=LAW + TWENTY, base=LAW, each=20),
    Row('200 variants against 200 runs', 12, 0.2, changes=LAW + MANY, base=LAW, each=200),
)


def write(folder, scene, method, changes):
    """Deck and mesh of a scene with replaced texts."""
    scene.contact.own_method = method
    text = own_deck.deck(scene)
    for old, new in changes:
        if text.count(old) != 1:
            raise ValueError(f'{old!r} is not once in the deck')
        text = text.replace(old, new)
    scene.mesh.write(os.path.join(folder, 'mesh.inp'))
    with open(os.path.join(folder, 'run.inp'), 'w', encoding='ascii') as stream:
        stream.write(text)


def measure_row(row, program, folder, pairs=PAIRS, seconds=600):
    """Runs both scenes in turn; a line of the table."""
    first, second = (os.path.join(folder, name) for name in ('first', 'second'))
    os.makedirs(first)
    os.makedirs(second)
    command = [os.path.abspath(program), 'run.inp', '--quiet']
    write(first, MAKERS[row.scene](row.size), row.method, row.changes)
    if row.calculix:
        jobs.write_other(MAKERS[row.other](row.size), second, row.calculix, 0)
        runs = (first, command), (second, ['ccx', 'run'])
    else:
        write(second, MAKERS[row.other](row.size), row.other_method, row.base)
        runs = (first, command), (second, [*command, *row.options])
    times = []
    for _ in range(pairs):
        spent = [measure.spend(words, place, seconds) for place, words in runs]
        if any(s['code'] for s in spent):
            raise OSError(f'{row.name}: exit codes {[s["code"] for s in spent]}')
        times.append([s['cpu'] for s in spent])
    ratios = [a/(row.each*b) for a, b in times]
    with open(os.path.join(first, 'run.log'), encoding='utf-8') as stream:
        limit = targets.largest_cost(results.own_log(stream.read()), row.shares)
    return {'row': row.name, 'size': row.size, 'pairs': pairs,
            'cpu': statistics.median(a for a, _ in times),
            'cpu_other': statistics.median(b for _, b in times), 'least': min(ratios),
            'median': statistics.median(ratios), 'largest': max(ratios), 'limit': limit,
            'load': os.getloadavg()[0], 'date': time.strftime('%Y-%m-%d')}


def read(path):
    """The lines kept, by row and size."""
    return sections.read(path, lambda line: (line['row'], int(line['size'])))


def keep(path, lines):
    """Writes the lines in the order of the rows."""
    sections.keep(path, COLUMNS, [lines[row.name, row.size] for row in ROWS
                                  if (row.name, row.size) in lines])


def verdict(row, line):
    """Whether a target is met, and by how much not."""
    if row.wanted is None:
        return '–'
    ratio = float(line['median'])
    return 'yes' if ratio <= row.wanted else f'no: {ratio/row.wanted:.2f} times'


def section(path):
    """The table as text; nothing where nothing was measured."""
    lines = read(path)
    if not lines:
        return ''
    text = [f'{START}\n\nWritten by `tests/bench/ratios`: both scenes in turn on the same machine, '
            f'one thread, the ratio pair by pair. 1,000 increments: the median is '
            f'{thousand(lines)} ms each. The last column: where the first of the two '
            f'spends most. {loads(lines)}\n\n',
            '| first against second | n | CPU [s] | other [s] | ratio: least, median, largest of '
            'the pairs | most of its time |\n|' + '---|'*6 + '\n']
    for row in ROWS:
        line = lines.get((row.name, row.size))
        if not line:
            continue
        cells = (row.name, f'{row.size}', line['cpu'], line['cpu_other'],
                 f'{line["least"]}, **{line["median"]}**, {line["largest"]} ({line["pairs"]})',
                 line['limit'])
        text.append('| ' + ' | '.join(cells) + ' |\n')
    text += [f'\n{row.why}\n' for row in ROWS if row.why and (row.name, row.size) in lines]
    return ''.join(text) + '\n'


def loads(lines):
    """What else the machine did."""
    found = sorted(float(line['load']) for line in lines.values())
    return f'Load of the two cores when a row was measured: {found[0]:.1f} to {found[-1]:.1f}.'


def thousand(lines):
    """Milliseconds an increment where they are many."""
    line = lines.get(('1,000 increments against 22', 8))
    return f'{float(line["cpu"]):.2g}' if line else '?'


def renew(document, path):
    """Puts the table into a document, in the place of the one before."""
    sections.renew(document, START, '## Cost against size', section(path))
