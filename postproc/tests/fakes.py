"""Files as mfec writes them, made by hand: a cube pressed on a base and moved along x."""
import os

import h5py
import numpy as np

CUTS = np.array([[1, 2, 3, 7], [1, 3, 4, 7], [1, 4, 8, 7], [1, 8, 5, 7], [1, 5, 6, 7],
                 [1, 6, 2, 7]]) - 1


def block(low, high, cells):
    """Points and tetrahedra of a box, cut as deck.md 3 says."""
    nx, ny, nz = cells
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, cells)]
    z, y, x = np.meshgrid(*axes[::-1], indexing='ij')
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    at = np.arange(len(points)).reshape(nz + 1, ny + 1, nx + 1)
    corners = np.stack([at[:-1, :-1, :-1], at[:-1, :-1, 1:], at[:-1, 1:, 1:], at[:-1, 1:, :-1],
                        at[1:, :-1, :-1], at[1:, :-1, 1:], at[1:, 1:, 1:], at[1:, 1:, :-1]], -1)
    return points, corners.reshape(-1, 8)[:, CUTS].reshape(-1, 4)


def write_tables(base, mu, steps=8):
    """A .rea table of a cube that slides with T/N = mu from step 3 on."""
    lines = ['# a cube', '# reactions', '#   step   time  set  R1  R2  R3']
    for step in range(1, steps + 1):
        t, n = ratio(step, mu), 50.0 * min(step, 2) / 2
        for name, sign in (('top', 1), ('ground', -1)):
            lines.append(f'{step:8d}  {step / 4:21.12E}  {name:<6}  {sign * t * n:21.12E}  '
                         f'{0.0:21.12E}  {-sign * n:21.12E}')
    with open(base + '.rea', 'w', encoding='utf-8') as stream:
        stream.write('\n'.join(lines) + '\n')


def ratio(step, mu):
    """T/N of a step: pressed in the first two, stuck in the third, then slipping."""
    return 0.0 if step <= 2 else 0.6 * mu if step == 3 else mu


def displacement(step):
    """Displacement of the cube at a step."""
    return np.array([0.1 * max(step - 2, 0), 0.0, -0.005 * min(step, 2)])


def write_results(base, mu, phi=0.0, steps=8):
    """A .vtkhdf file with the layout of the program."""
    upper, cells = block([0, 0, 0], [1, 1, 1], [4, 4, 4])
    lower, more = block([-0.4, -0.4, -0.4], [2.2, 1.4, 0], [13, 9, 2])
    points = np.concatenate([upper, lower])
    cells = np.concatenate([cells, more + len(upper)])
    sole = np.flatnonzero(upper[:, 2] == 0)
    with h5py.File(base + '.vtkhdf', 'w') as file:
        vtk = file.create_group('VTKHDF')
        vtk.attrs['Version'] = [2, 0]
        vtk.attrs.create('Type', b'UnstructuredGrid', dtype='S16')
        vtk['NumberOfPoints'], vtk['NumberOfCells'] = [len(points)], [len(cells)]
        vtk['NumberOfConnectivityIds'] = [cells.size]
        vtk['Points'], vtk['Connectivity'] = points, cells.ravel()
        vtk['Offsets'] = 4 * np.arange(len(cells) + 1)
        vtk['Types'] = np.full(len(cells), 10, dtype='u1')
        vtk['PointData/node_number'] = np.arange(1, len(points) + 1)
        vtk['CellData/region'] = np.repeat([1, 2], [len(cells) - len(more), len(more)])
        write_fields(vtk, points, cells, len(upper), steps)
        write_contact(file, upper, sole, mu, phi, steps)
        file['run/sets/top'] = 1 + np.flatnonzero(upper[:, 2] == 1)
        file['run/title'] = [b'a cube']
        file['history/reactions/step'] = np.arange(1, steps + 1)
        file['history/reactions/set'] = np.array([b'top   '] * (steps + 1))


def write_fields(vtk, points, cells, moved, steps):
    """Displacement and stress of each step."""
    u, stress = [], []
    centre = points[cells].mean(axis=1)
    for step in range(1, steps + 1):
        depth = np.clip((points[:, 2] + 0.4) / 0.4, 0, 1)
        field = 0.3 * depth[:, None] * displacement(step) * [0, 0, 1]
        field[:moved] = displacement(step)
        u.append(field)
        s = np.zeros((len(cells), 6))
        s[:, 2] = -10.0 * min(step, 2) * np.exp(-3 * (centre[:, 2] / 0.6) ** 2)
        s[:, 5] = 0.1 * s[:, 2] * (step > 2)
        stress.append(s)
    vtk['PointData/displacement'] = np.concatenate(u)
    vtk['CellData/stress'] = np.concatenate(stress)
    vtk['Steps/Values'] = np.arange(1, steps + 1) / 4
    vtk['Steps'].attrs['NSteps'] = steps
    for name in ('PartOffsets', 'PointOffsets'):
        vtk['Steps/' + name] = np.zeros(steps, dtype=int)
    for name in ('CellOffsets', 'ConnectivityIdOffsets'):
        vtk['Steps/' + name] = np.zeros((steps, 1), dtype=int)
    vtk['Steps/NumberOfParts'] = np.ones(steps, dtype=int)
    vtk['Steps/PointDataOffsets/displacement'] = len(points) * np.arange(steps)
    vtk['Steps/CellDataOffsets/stress'] = len(cells) * np.arange(steps)
    vtk['Steps/PointDataOffsets/node_number'] = np.zeros(steps, dtype=int)
    vtk['Steps/CellDataOffsets/region'] = np.zeros(steps, dtype=int)


def write_contact(file, upper, sole, mu, phi, steps):
    """The contact points of each step."""
    group = file.create_group('contact/1')
    group.attrs.create('name', b'skid', dtype='S4')
    n = len(sole)
    group['node'] = sole + 1
    group['facets'] = np.array([[1, 2, 6]])
    edge = 1 + 2 * np.max(np.abs(upper[sole, :2] - 0.5), axis=1) ** 2
    for name, shape in (('traction', (n, 3)), ('tip', (n, 2)), ('lay', (n, 3)), ('gap', (n,))):
        group[name] = np.zeros((steps,) + shape)
    for step in range(1, steps + 1):
        normal = 50.0 * min(step, 2) / 2 * edge / edge.sum()
        group['traction'][step - 1] = np.stack([-ratio(step, mu) * normal, 0 * normal, normal], 1)
        group['lay'][step - 1] = [np.cos(np.radians(phi)), np.sin(np.radians(phi)), 0]
    group['host'] = np.ones((steps, n), dtype=int)
    group['status'] = np.repeat([[1], [2]], [3, steps - 3], axis=0) * np.ones((1, n), dtype=int)


def write_run(folder, name, mu, phi=0.0):
    """A whole run in a folder of its own; its .rea file."""
    os.makedirs(os.path.join(folder, name), exist_ok=True)
    base = os.path.join(folder, name, 'sliding_cube')
    write_tables(base, mu)
    write_results(base, mu, phi)
    return base + '.rea'
