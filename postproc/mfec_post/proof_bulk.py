"""The bodies of a results file: internal forces, stresses and energy from the displacements alone.

Formulas as in doc/theory, "Bulk", written down anew; what they discretise is
doc/theory, eqs. (2.1), (2.4)."""
from __future__ import annotations

import numpy as np

from .proof_lines import LINES, PLAIN, ROUND_OFF, Array
from .proof_run import Refusal, Run, cross

EDGES = np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])
STRAIGHT = 1e-10  # middle nodes that are off by less of the edge are in its middle
EYE = np.eye(3)


def shares(straight: bool) -> Array:
    """Volume coordinates of the points of ten nodes: degree 2, degree 3 on curved elements."""
    if straight:
        along = [1 / np.sqrt(5.0)]
    else:
        total = 2 * np.sqrt(0.4) * np.cos((np.arccos(-np.sqrt(10.0) / 6) + 4 * np.pi) / 3)
        root = np.sqrt(total ** 2 / 4 - (total ** 2 - 0.4) / 2)
        along = [total / 2 + root, total / 2 - root]
    return np.array([(1 - s) / 4 + s * np.eye(4)[i] for s in along for i in range(4)])


def slopes_of(place: Array, nodes: int) -> Array:
    """Slopes of the shape functions by the volume coordinates, (nodes, 4)."""
    if nodes == 4:
        return np.eye(4)
    d = np.zeros((10, 4))
    d[range(4), range(4)] = 4 * place - 1
    for k, (i, j) in enumerate(EDGES):
        d[4 + k, [i, j]] = 4 * place[j], 4 * place[i]
    return d


class Block:
    """Cells of one kind, material and rule: gradients and weights of their points."""

    def __init__(self, run: Run, cells: Array, nodes: Array, straight: bool, material: Array):
        self.cells, self.nodes = cells, nodes
        self.law, self.form, e, nu = int(material[0]), int(material[1]), material[2], material[3]
        self.lam, self.g = e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))
        count = nodes.shape[1]
        x = run.x0[nodes]
        gradients, weights, places = [], [], []
        for place in np.full((1, 4), 0.25) if count == 4 else shares(straight):
            d = slopes_of(place, count)
            n = place if count == 4 else np.concatenate([place * (2 * place - 1), 4 * place[EDGES].prod(1)])
            places.append(np.einsum('eai,a->ei', x, n))
            d = d[:, :3] - d[:, 3:]
            jacobian = np.einsum('eai,aj->eij', x, d)
            gradients.append(np.einsum('aj,eji->eai', d, np.linalg.inv(jacobian)))
            weights.append(np.abs(np.linalg.det(jacobian)) / 6)
        self.gradient, self.place = np.array(gradients), np.array(places)
        self.weight = np.array(weights) / len(weights)
        self.volume = self.weight.sum(0)

    def stretch(self, u: Array) -> None:
        """Takes displacement gradients H and what follows from them at all points."""
        self.h = np.einsum('eai,qeaj->qeij', u[self.nodes], self.gradient)
        trace = np.trace(self.h, axis1=2, axis2=3)
        if self.law == 1:
            self.j1 = trace
            self.cofactor = np.broadcast_to(EYE, self.h.shape)
        else:
            square = np.einsum('qeij,qeji->qe', self.h, self.h)
            self.j1 = trace + 0.5 * (trace ** 2 - square) + np.linalg.det(self.h)
            self.inverse = np.linalg.inv(EYE + self.h).swapaxes(2, 3)
            self.cofactor = (1 + self.j1)[..., None, None] * self.inverse
        self.mean = (self.weight * self.j1).sum(0) / self.volume

    def pressure(self, j1: Array) -> Array:
        """Derivative of the volumetric energy by J, of what J is above 1."""
        return self.lam * j1 if self.law == 1 else self.lam * np.log1p(j1) / (1 + j1)

    def volumetric(self, j1: Array) -> Array:
        """Volumetric energy per volume."""
        return 0.5 * self.lam * (j1 if self.law == 1 else np.log1p(j1)) ** 2

    def solve(self, pressure: Array) -> tuple[Array, Array, Array]:
        """First Piola-Kirchhoff stress of the points, Cauchy stress and energy of the cells;
        `pressure` is that of MEAN and NODAl."""
        h, g = self.h, self.g
        green = 0.5 * (h + h.swapaxes(2, 3))
        if self.law != 1:
            green = green + 0.5 * np.einsum('qeki,qekj->qeij', h, h)
        trace = np.trace(green, axis1=2, axis2=3)
        lam = 0.0 if self.form else self.lam
        if self.law == 2:
            stress = 2 * g * np.einsum('qeij,qejk->qeik', self.inverse, green)
            energy = g * (trace - np.log1p(self.j1))
            if not self.form:
                stress = stress + (self.pressure(self.j1)[..., None, None]) * self.cofactor
                energy = energy + self.volumetric(self.j1)
        else:
            second = lam * trace[..., None, None] * EYE + 2 * g * green
            stress = second if self.law == 1 else np.einsum('qeij,qejk->qeik', EYE + h, second)
            energy = 0.5 * lam * trace ** 2 + g * np.einsum('qeij,qeij->qe', green, green)
        if self.form:
            stress = stress + pressure[:, None, None] * self.cofactor
        cauchy = stress
        if self.law != 1:
            cauchy = np.einsum('qeij,qekj->qeik', stress, EYE + h) / (1 + self.j1)[..., None, None]
        self.cauchy = cauchy
        cauchy = np.einsum('qe,qeij->eij', self.weight, cauchy) / self.volume[:, None, None]
        return stress, cauchy, (self.weight * energy).sum(0)


class Bodies:
    """All elastic cells of a run."""

    def __init__(self, run: Run):
        self.run, self.blocks = run, []
        self.stiffest = 0.0
        self.small = np.zeros(len(run.x0), bool)  # nodes of bodies in small strain
        for kind, cells in run.cells.items():
            x = run.x0[run.corners[kind]]
            off = np.zeros(len(cells))
            if kind == 24:
                ends = x[:, EDGES]
                off = (np.linalg.norm(x[:, 4:] - ends.mean(2), axis=2)
                       / np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2)).max(1)
            for number, material in run.materials.items():
                if material[0] not in (1, 2, 3):
                    raise Refusal(f'law {material[0]:.0f} of the bulk is not in the proof yet')
                for straight in (True, False):
                    here = (run.material[cells] == number) & ((off <= STRAIGHT) == straight)
                    if here.any() and not material[4]:
                        self.small[run.corners[kind][here]] = material[0] == 1
                        self.stiffest = max(self.stiffest, material[2])
                        self.blocks.append(Block(run, cells[here], run.corners[kind][here],
                                                 straight, material))
        self.round_off = 64 * ROUND_OFF * self.stiffest / LINES['stress of the cells'][PLAIN]

    def solve(self, u: Array) -> tuple[Array, Array, float, Array]:
        """Internal forces of the nodes, Cauchy stress of the cells (6), strain energy, and the
        moment of the forces about the places where the law balances it: at rest in small strain."""
        force, total, moment = np.zeros_like(u), 0.0, np.zeros(3)
        stress = np.full((len(self.run.material), 6), np.nan)
        for block in self.blocks:
            block.stretch(u)
        for block in self.blocks:
            pressure, extra = block.pressure(block.mean), block.volume * block.volumetric(block.mean)
            if block.form == 2:
                pressure, extra = self.of_nodes(block)
            p, cauchy, energy = block.solve(pressure)
            if block.form == 0:
                extra = np.zeros_like(energy)
            nodal = np.einsum('qe,qeij,qeaj->eai', block.weight, p, block.gradient)
            np.add.at(force, block.nodes, nodal)
            arm = self.run.x0 if block.law == 1 else self.run.x0 + u
            moment += cross(arm[block.nodes] - self.run.x0.mean(0), nodal).sum((0, 1))
            stress[block.cells] = cauchy[:, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]
            total += float(energy.sum() + extra.sum())
        return force, stress, total, moment

    def of_nodes(self, block: Block) -> tuple[Array, Array]:
        """Pressure and volumetric energy of the cells of NODAl: means over the nodes around."""
        volume, dilated = np.zeros(len(self.run.x0)), np.zeros(len(self.run.x0))
        np.add.at(volume, block.nodes, block.volume[:, None] / 4)
        np.add.at(dilated, block.nodes, (block.volume * block.mean)[:, None] / 4)
        j1 = dilated / np.where(volume > 0, volume, 1)
        return block.pressure(j1)[block.nodes].mean(1), \
            block.volume * block.volumetric(j1)[block.nodes].mean(1)
