"""What the programs wrote, as numbers: errors, iterations, costs."""
import math
import os
import re
import statistics

import numpy as np

import calculix

SETTLED = 1.2  # from here on the cube slides as a whole


def text_of(folder, name):
    """A file's text, '' if it is not there."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return ''
    with open(path, encoding='utf-8', errors='replace') as stream:
        return stream.read()


def own(scene, folder):
    """Values from the files of mfec."""
    log = text_of(folder, 'run.log')
    values = own_log(log)
    rows = [line.split() for line in text_of(folder, 'run.rea').split('\n')
            if line and line[0] != '#']
    rows = [(float(r[1]), *map(float, r[3:6])) for r in rows if len(r) == 6]
    values.update(judge_reactions(scene, rows))
    if 'pressure' in scene.known and rows:
        values.update(judge_pressure(scene, own_pressures(scene, folder), rows[-1][3]))
    if 'tip' in scene.known:
        last = text_of(folder, 'run.his').strip().split('\n')[-1].split()
        values['tip_error'] = float(last[-1])/scene.known['tip'] - 1
    return values


def own_log(log):
    """Iterations, cuts, solvers, cost table of a log."""
    done = re.findall(r'increment +\d+ converged: .* solves *(\d+)', log)
    values = {'increments': len(done), 'iterations': sum(map(int, done)),
              'median_iterations': statistics.median(map(int, done)) if done else None,
              'cuts': 0, 'costs': {}, 'counts': {}}
    found = re.search(r'(\d+) increments, (\d+) iterations, (\d+) cuts', log)
    if found:
        values['iterations'], values['cuts'] = int(found.group(2)), int(found.group(3))
    table = log.rpartition('\ncost ')[2]
    for line in table.split('\n')[1:]:
        found = re.match(r'(\S.*?\S)\s{2,}(?:(\d+)\s+)?(\d+\.\d+)\s*$', line)
        if found:
            values['costs'][found.group(1)] = float(found.group(3))
            if found.group(2):
                values['counts'][found.group(1)] = int(found.group(2))
    for name in ('processor time of all threads', 'peak memory, MB',
                 'memory per free dof, kB'):
        values['costs'].pop(name, None)
    chosen = re.findall(r'^solver: (\w+)', log, re.M)
    values['chosen'] = chosen[0] if chosen else ''
    return values


def own_pressures(scene, folder):
    """Normal force of each slave node over its share of the surface; the force of a quadrature
    point belongs to the nodes of its facet by its weights."""
    import h5py
    shares = scene.mesh.shares(scene.contact.slave)
    with h5py.File(os.path.join(folder, 'run.vtkhdf'), 'r') as results:
        group = results['contact/1']
        nodes, force = group['node'][()], group['traction'][-1][:, 2]
        weights = group['weight'][()] if nodes.ndim > 1 else np.ones((len(nodes), 1))
    if nodes.ndim == 3:  # SEGMent: written at each time
        nodes, weights = nodes[-1], weights[-1]
    if weights.shape[1] == 6:
        return projected(scene, nodes, weights, force)
    total = np.bincount(nodes.ravel(), (weights*force[:, None]).ravel())
    total = {int(n): float(total[n]) for n in np.unique(nodes) if total[n]}
    return {node: f/shares[node] for node, f in total.items() if f}


def projected(scene, nodes, weights, force):
    """Pressure at the corners of facets of six nodes, which have no force by themselves: linear
    functions with the integrals of the points' forces."""
    facets = scene.mesh.facets(scene.contact.slave)
    corners, at = np.unique(facets, return_inverse=True)
    at = at.reshape(-1, 3)
    a, b, c = (scene.mesh.nodes[facets[:, i] - 1] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)/2
    mass, right = np.zeros([len(corners)]*2), np.zeros(len(corners))
    for k in range(3):
        for m in range(3):
            np.add.at(mass, (at[:, k], at[:, m]), areas/12*(1 + (k == m)))
        # of a corner's linear function: its own weight and half of those of the edges at it
        linear = weights[:, k] + (weights[:, 3 + k] + weights[:, 3 + (k + 2) % 3])/2
        used = nodes[:, k] > 0
        np.add.at(right, np.searchsorted(corners, nodes[used, k]), (linear*force)[used])
    return {int(n): float(p) for n, p in zip(corners, np.linalg.solve(mass, right)) if p}


def other(scene, folder, method):
    """Values from the files of CalculiX."""
    dat = text_of(folder, 'run.dat')
    increments, iterations, cuts = calculix.history(text_of(folder, 'run.sta'))
    values = {'increments': increments, 'iterations': iterations, 'cuts': cuts}
    rows = calculix.totals(dat)
    values.update(judge_reactions(scene, rows))
    if 'pressure' in scene.known and rows:
        found = calculix.pressures(dat, '' if method == 'N2S' else text_of(folder, 'run.frd'))
        values.update(judge_pressure(scene, found, rows[-1][3]))
    if 'tip' in scene.known and 'displacements' in dat:
        node = int(scene.mesh.node_sets['tip'][0])
        values['tip_error'] = calculix.displacements(dat)[node][2]/scene.known['tip'] - 1
    return values


def judge_reactions(scene, rows):
    """T/N against mu over the plateau; the force against Hertz."""
    values = {}
    if scene.known.get('T/N'):
        plateau = [math.hypot(r[1], r[2])/abs(r[3]) for r in rows if r[0] > SETTLED and r[3]]
        if plateau:
            values['T/N'] = statistics.fmean(plateau)
            values['T/N_error'] = values['T/N']/scene.known['T/N'] - 1
    if 'force' in scene.known and rows:
        values['force_error'] = abs(rows[-1][3])/scene.known['force'] - 1
    if rows:
        values['normal'] = abs(rows[-1][3])
    return values


def judge_pressure(scene, pressures, quarter):
    """The peak pressure against that of Hertz for the computed force: as the vertex of p^2 against
    r^2 (least squares within 0.8 of the contact radius), and as the largest value at a node."""
    modulus, radius, force = scene.known['modulus'], scene.known['radius'], 4*abs(quarter)
    peak = (6*force*modulus**2/(math.pi**3*radius**2))**(1/3)
    edge = (3*force*radius/(4*modulus))**(1/3)
    nodes = np.array(sorted(pressures), dtype=int)
    p = np.array([pressures[n] for n in nodes.tolist()])
    r2 = (scene.mesh.nodes[nodes - 1, :2]**2).sum(axis=1)
    inner = (r2 < (0.8*edge)**2) & (p > 0)
    # S2S writes values for master nodes too: the slave surface is what counts.
    inner &= np.isin(nodes, np.unique(scene.mesh.facets(scene.contact.slave)))
    if inner.sum() < 3:
        return {}
    top = np.polynomial.polynomial.polyfit(r2[inner], p[inner]**2, 1)[0]
    return {'pressure_error': math.sqrt(top)/peak - 1 if top > 0 else -1.0,
            'largest_error': float(p[inner].max())/peak - 1}
