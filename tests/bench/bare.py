"""The bare CHOLMOD program: built with the C compiler that gfortran brings, fed with a scene."""
import os
import shutil
import subprocess

import numpy as np

import measure

HERE = os.path.dirname(os.path.abspath(__file__))
SOURCE = os.path.join(HERE, 'bare_cholmod.c')
MODE = 'bare CHOLMOD'


def build(folder):
    """Path of the program, None (with a word) where it cannot be built."""
    program = os.path.join(os.path.abspath(folder), 'bare_cholmod')
    if os.path.exists(program) and os.path.getmtime(program) > os.path.getmtime(SOURCE):
        return program
    compiler = shutil.which('gcc') or shutil.which('cc')
    if compiler is None:
        print('no C compiler: the bare CHOLMOD program is left out')
        return None
    os.makedirs(folder, exist_ok=True)
    command = [compiler, '-O3', '-I/usr/include/suitesparse', SOURCE, '-o', program,
               '-Wl,--no-as-needed', '-lopenblas', '-lcholmod']
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print('the bare CHOLMOD program cannot be built and is left out: ' + done.stderr[:300])
        return None
    return program


def write(scene, folder):
    """problem.bin; the head of the C source says what is in it."""
    mesh = scene.mesh
    held = np.zeros((len(mesh.nodes), 3), dtype=np.int8)
    given, force = np.zeros(mesh.nodes.shape), np.zeros(mesh.nodes.shape)
    for name, directions in scene.fixed.items():
        for i in directions:
            held[mesh.node_sets[name].ravel() - 1, i - 1] = 1
    for node, i, value, _ in scene.moved:
        given[node - 1, i - 1] = value
    for node, f in scene.forces.items():
        force[node - 1] = f
    young, nu = scene.young, scene.poisson
    lame = np.array([young*nu/((1 + nu)*(1 - 2*nu)), young/(2*(1 + nu))])
    name, direction = scene.shown
    wanted = 3*(int(mesh.node_sets[name][0]) - 1) + direction - 1
    with open(os.path.join(folder, 'problem.bin'), 'wb') as stream:
        np.array([len(mesh.nodes), len(mesh.elements), wanted], dtype=np.int64).tofile(stream)
        lame.tofile(stream)
        mesh.nodes.tofile(stream)
        (mesh.elements - 1).astype(np.int64).tofile(stream)
        for array in (held, given, force):
            array.tofile(stream)


def run(program, scene, seconds):
    """What it took; `tip_error` as of the other programs."""
    def read(folder, spent):
        with open(os.path.join(folder, 'standard_output'), encoding='ascii') as stream:
            tip, operations, time, entries, solve = map(float, stream.read().split())
        return {'tip_error': tip/scene.known['tip'] - 1, 'iterations': 1, 'increments': 1,
                'gflops': 1e-9*operations/max(time, 1e-9),
                'gigabytes': 2*8e-9*entries/max(solve, 1e-9)}

    return measure.repeat([program], lambda folder: write(scene, folder), seconds, read)
