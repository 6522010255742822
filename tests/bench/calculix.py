"""CalculiX: its deck from a scene, and what it says in its files."""
import re

METHODS = {'N2S': 'NODE TO SURFACE', 'S2S': 'SURFACE TO SURFACE'}
SOLVERS = {'default': '', 'iterative': ', SOLVER=ITERATIVE SCALING'}


def deck(scene, method, solver, limit=None):
    """The input deck; it includes mesh.inp. With a limit: only that many increments."""
    text = [f'*HEADING\n{scene.name} {scene.size:g}\n*INCLUDE, INPUT=mesh.inp\n',
            f'*MATERIAL, NAME=bulk\n*ELASTIC\n{scene.young!r}, {scene.poisson!r}\n']
    text += [f'*SOLID SECTION, ELSET={region}, MATERIAL=bulk\n' for region in scene.mesh.regions]
    if scene.contact:
        text.append(pair(scene.contact, method))
    text.append('*BOUNDARY\n' + ''.join(f'{name}, {i}, {i}\n' for name, directions in
                                         scene.fixed.items() for i in directions))
    phases = range(1 if limit else scene.phases())
    text += [step(scene, phase, method, solver, limit or 10000) for phase in phases]
    return ''.join(text)


def pair(contact, method):
    """The contact pair: pressure and friction have the same stiffness, as in mfec."""
    stiffness = f'{contact.penalty!r}'
    if method == 'N2S':
        stiffness += f', {contact.tension:.12g}'
    friction = f'*FRICTION\n{contact.friction!r}, {contact.penalty!r}\n' if contact.friction else ''
    return ('*SURFACE INTERACTION, NAME=law\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n'
            f'{stiffness}\n{friction}*CONTACT PAIR, INTERACTION=law, TYPE={METHODS[method]}\n'
            f'{contact.slave}, {contact.master}\n')


def step(scene, phase, method, solver, limit):
    """One phase: equal increments, smaller only where one does not converge."""
    size = 1.0/scene.increments[phase]
    text = (f'*STEP, INC={limit}\n*STATIC{SOLVERS[solver]}\n'
            f'{size:.12g}, 1.0, {size/1024:.12g}, {size:.12g}\n')
    values = ''.join(f'{name}, {i}, {i}, {value*factors[phase]:.12g}\n'
                     for name, i, value, factors in scene.moved)
    if values:
        text += '*BOUNDARY\n' + values
    if scene.forces and phase == 0:
        text += '*CLOAD\n' + ''.join(f'{node}, {i}, {f:.12g}\n' for node, force in
                                     scene.forces.items() for i, f in enumerate(force, 1) if f)
    if scene.watched:
        text += f'*NODE PRINT, NSET={scene.watched}, TOTALS=ONLY\nRF\n'
    if scene.shown:
        text += f'*NODE PRINT, NSET={scene.shown[0]}\nU\n'
    if scene.contact and scene.known.get('pressure'):
        text += '*CONTACT PRINT\nCSTR\n' if method == 'N2S' else '*CONTACT FILE\nCSTR\n'
    return text + '*END STEP\n'


def totals(text):
    """Sums of the reactions in a .dat file: one row (time, f1, f2, f3) an increment."""
    found = re.findall(r'total force \(fx,fy,fz\) for set \S+ and time\s+(\S+)\s+(\S+)\s+(\S+)'
                       r'\s+(\S+)', text)
    return [tuple(map(float, row)) for row in found]


def displacements(text):
    """Last displacements in a .dat file: {node: (u1, u2, u3)}."""
    return last_block(text, 'displacements (vx,vy,vz)')


def last_block(text, title):
    """Rows of a number and three values below the last such title of a .dat file."""
    block = (text.rpartition(title)[2].split('\n\n') + [''])[1]
    rows = re.findall(r'^\s+(\d+)((?:\s+[-+.\dE]+){3})\s*$', block, re.M)
    return {int(n): tuple(map(float, values.split())) for n, values in rows}


def pressures(dat, frd):
    """Last contact pressures at nodes: of the slave nodes (.dat, node to surface) or as the viewer
    shows them (.frd, surface to surface)."""
    title = 'contact stress (slave node,press'
    if title in dat:
        return {n: values[0] for n, values in last_block(dat, title).items()}
    block = frd.rpartition(' -4  CONTACT')[2].partition('\n -3')[0]
    result = {}
    for line in block.split('\n'):
        if line.startswith(' -1'):
            result[int(line[3:13])] = float(line[13 + 36:13 + 48])
    return result


def history(sta):
    """What a .sta file says: increments, iterations, attempts that failed."""
    increments = iterations = cuts = 0
    for line in sta.split('\n')[2:]:
        words = line.split()
        if len(words) == 7:
            failed = words[2].endswith('U')
            increments += not failed
            cuts += failed
            iterations += int(words[3])
    return increments, iterations, cuts
