"""What is run: one job is one scene, size, program and mode."""
import dataclasses
import os
import re
import shutil
import subprocess

import bare
import calculix
import measure
import own_deck
import results
import scenes

CUBE, HERTZ, HERTZ_TEN, CANTILEVER = 'cube', 'hertz', 'hertz_ten', 'cantilever'
CCX_MODES = {'N2S default': ('N2S', 'default'), 'N2S iterative': ('N2S', 'iterative'),
             'S2S default': ('S2S', 'default'), 'S2S iterative': ('S2S', 'iterative')}
STOPPED = 255  # ended with exit code 0, but before the last increment
SOLVERS = ('AUTO', 'UMFP', 'CHOL', 'REDU')
MAKERS = {
    CUBE: scenes.sliding_cube,
    'cube_smooth': lambda n: scenes.sliding_cube(n, friction=0.0),
    'cube_neo': lambda n: scenes.sliding_cube(n, law='NEOHookean'),
    'cube_once': lambda n: scenes.sliding_cube(n, increments=(2, 1)),
    'cube_rough': lambda n: scenes.sliding_cube(n, friction=0.9),
    'cube_1000': lambda n: scenes.sliding_cube(n, increments=(2, 998)),
    'plate': scenes.large_contact,
    'field': scenes.small_contact,
    HERTZ: scenes.hertz,
    HERTZ_TEN: lambda h: scenes.hertz(h, ten=True),
    CANTILEVER: scenes.cantilever,
}


@dataclasses.dataclass(frozen=True)
class Job:
    """A run. With a limit only that many increments are computed: what an iteration takes."""

    scene: str
    size: float
    mode: str               # a solver of mfec, or a key of CCX_MODES
    limit: int = 0
    method: str = 'NTOS'    # of mfec's contact
    threads: int = 1        # of mfec

    def of_calculix(self):
        """Whether CalculiX runs it."""
        return self.mode in CCX_MODES


class Programs:
    """The two programs and what they offer."""

    def __init__(self, own, folder):
        self.own = os.path.abspath(own)
        self.other, self.bare = shutil.which('ccx'), bare.build(folder)
        self.solvers = [name for name in SOLVERS if self.accepts(scenes.sliding_cube(2), name)]
        self.digests = {path: measure.file_digest(path)
                        for path in (self.own, self.other, self.bare) if path}

    def said(self, option):
        """What mfec prints for an option."""
        return subprocess.run([self.own, option], capture_output=True, text=True,
                              env=measure.environment(), check=False).stdout

    def versions(self):
        """Name and version of the programs, one line each."""
        lines = self.said('--version').strip().split('\n')
        lines[0] += f' (digest of the program {self.digests[self.own][:10]})'
        if self.other:
            said = subprocess.run([self.other, '-v'], capture_output=True, text=True, check=False)
            lines.append('CalculiX ' + ''.join(re.findall(r'Version (\S+)', said.stdout)))
        return lines

    def accepts(self, scene, solver='AUTO', method='NTOS'):
        """Whether mfec takes the deck of a scene and a solver (some may be missing)."""
        scene.contact.own_method = method

        def files(folder):
            write_own(scene, folder, 0)

        done = measure.repeat([self.own, 'run.inp', '--check', '--quiet', '--solver', solver],
                              files, 60,
                              lambda folder, run: {}, repeats=1)
        return done['code'] == 0


def write_own(scene, folder, limit):
    """Deck and mesh of mfec."""
    scene.mesh.write(os.path.join(folder, 'mesh.inp'))
    with open(os.path.join(folder, 'run.inp'), 'w', encoding='ascii') as stream:
        stream.write(own_deck.deck(scene, limit))


def write_other(scene, folder, mode, limit):
    """Deck and mesh of CalculiX."""
    scene.mesh.write(os.path.join(folder, 'mesh.inp'))
    with open(os.path.join(folder, 'run.inp'), 'w', encoding='ascii') as stream:
        stream.write(calculix.deck(scene, *CCX_MODES[mode], limit))


def perform(job, programs, store, seconds, run=True):
    """Takes what is kept of a job, else runs it (or returns None, if it is not to be run)."""
    scene = MAKERS[job.scene](job.size)
    if job.of_calculix():
        command, program = [programs.other, 'run'], programs.other
        text = calculix.deck(scene, *CCX_MODES[job.mode], job.limit)
    elif job.mode == bare.MODE:
        command, program, text = [programs.bare], programs.bare, own_deck.deck(scene)
    else:
        if scene.contact:
            scene.contact.own_method = job.method
        command, program = [programs.own, 'run.inp', '--quiet', '--solver', job.mode], programs.own
        if job.threads > 1:
            command += ['--threads', str(job.threads)]
        text = own_deck.deck(scene, job.limit)
    mesh = scene.mesh
    key = measure.digest(programs.digests[program], ' '.join(command[1:]), text, int(seconds),
                         mesh.nodes.tobytes(), mesh.elements.tobytes())
    result = store.get(key)
    if result is None and run:
        if job.of_calculix():
            result = measure.repeat(
                command, lambda folder: write_other(scene, folder, job.mode, job.limit), seconds,
                lambda folder, run: results.other(scene, folder, CCX_MODES[job.mode][0]))
        elif job.mode == bare.MODE:
            result = bare.run(program, scene, seconds)
        else:
            result = measure.repeat(
                command, lambda folder: write_own(scene, folder, job.limit), seconds,
                lambda folder, run: results.own(scene, folder), outputs=('run.log', 'run.vtkhdf'))
        result.update(dofs=3*len(mesh.nodes), elements=len(mesh.elements))
        if result['code'] == 0 and not job.limit and result['increments'] < sum(scene.increments):
            result['code'] = STOPPED
        store.put(key, result)
    return result


def cube_jobs(solvers, other, sizes, largest):
    """The sliding cube. `largest` is the last size that runs through, by mode."""
    jobs = []
    for n in sizes:
        jobs.append(Job(CUBE, n, 'AUTO'))
        if 'UMFP' in solvers:
            jobs.append(Job(CUBE, n, 'UMFP', 0 if n <= largest['UMFP'] else 1))
        for mode in CCX_MODES if other else ():
            last = largest[mode]
            if n <= last or mode == 'N2S default':
                jobs.append(Job(CUBE, n, mode, 0 if n <= last else 1))
    return jobs


def other_scenes(sizes):
    """What the plain cube leaves out, one cause each; sizes of plates and fields."""
    jobs = [Job(CUBE, 12, 'AUTO', method=method) for method in ('GTOS', 'SEGMent')]
    jobs += [Job('cube_smooth', 12, 'AUTO'), Job('cube_rough', 12, 'AUTO')]
    jobs += [Job(CUBE, 12, 'AUTO', threads=2), Job('cube_1000', 8, 'AUTO')]
    jobs += [Job('plate', n, mode) for n in sizes[0] for mode in ('AUTO', 'REDU')]
    return jobs + [Job('field', n, 'AUTO') for n in sizes[1]]


def ten_node_jobs(other, sizes):
    """Hertz on elements of ten nodes: C3D10 for CalculiX."""
    return [job for h in sizes for job in
            [Job(HERTZ_TEN, h, 'AUTO', method=method) for method in ('GTOS 6', 'SEGMent')]
            + [Job(HERTZ_TEN, h, mode) for mode in ('N2S iterative', 'S2S iterative') if other]]


def quick_jobs(programs):
    """A few minutes at most."""
    other, solvers = bool(programs.other), programs.solvers
    jobs = cube_jobs(solvers, other, (4, 8), {
        'UMFP': 8, 'N2S default': 8, 'N2S iterative': 8, 'S2S default': 4, 'S2S iterative': 4})
    jobs += [Job('cube_smooth', 8, 'AUTO'), Job('cube_once', 8, 'AUTO'), Job(CUBE, 12, 'AUTO')]
    jobs += other_scenes(((30,), (78, 82)))
    modes = ['AUTO'] + (['N2S default', 'N2S iterative'] if other else [])
    jobs += [Job(CUBE, 12, 'N2S iterative')] if other else []
    jobs += [Job(HERTZ, h, mode) for h in (0.4, 0.3) for mode in modes]
    if programs.accepts(MAKERS[CUBE](2), method='GTOS'):
        jobs += [Job(HERTZ, h, 'AUTO', method='GTOS') for h in (0.4, 0.3)]
    modes += [bare.MODE] if programs.bare else []
    jobs += [Job(CANTILEVER, n, mode) for n in (4, 8, 16) for mode in modes
             if n < 16 or not mode.startswith('N2S')]
    return jobs


def full_jobs(programs):
    """Everything."""
    other, solvers = bool(programs.other), programs.solvers
    jobs = cube_jobs(solvers, other, (4, 8, 12, 16, 20), {
        'UMFP': 12, 'N2S default': 12, 'N2S iterative': 20, 'S2S default': 12,
        'S2S iterative': 12})
    quadrature = programs.accepts(MAKERS[CUBE](2), method='GTOS')
    if quadrature:
        jobs += [Job(CUBE, n, 'AUTO', method='GTOS') for n in (4, 8, 12)]
    jobs += [Job('cube_smooth', n, 'AUTO') for n in (8, 12, 16, 20)]
    jobs += [job for job in other_scenes(((30, 44, 59), (78, 82, 90))) if job not in jobs]
    jobs += [Job('cube_once', n, 'AUTO') for n in (4, 8, 12)]
    if programs.accepts(MAKERS['cube_neo'](2)):
        jobs += [Job('cube_neo', n, mode, 1 if n > 12 and mode == 'UMFP' else 0)
                 for n in (4, 8, 12, 16, 20) for mode in ('AUTO', 'UMFP')]
    modes = ['AUTO'] + (['N2S default', 'N2S iterative', 'S2S iterative'] if other else [])
    for h in (0.4, 0.3, 0.2, 0.15, 0.1):
        jobs += [Job(HERTZ, h, mode) for mode in modes if h > 0.12 or mode != 'N2S default']
        jobs += [Job(HERTZ, h, 'AUTO', method='GTOS')] if quadrature else []
    jobs += ten_node_jobs(other, (0.8, 0.6, 0.4, 0.3))
    modes = ['AUTO'] + (['N2S default', 'N2S iterative'] if other else []) + (
        [bare.MODE] if programs.bare else [])
    jobs += [Job(CANTILEVER, n, mode) for n in (4, 8, 16, 24, 32) for mode in modes
             if n < 32 or mode != 'N2S default']
    if 'REDU' in solvers:
        jobs += [Job(CUBE, n, 'AUTO') for n in (10, 15, 25, 30)]
    else:
        jobs += [Job(CUBE, n, 'AUTO') for n in (10, 15)]
    return jobs
