#!/usr/bin/env python3
"""References of two studies: a second program, of axisymmetric elements (numpy, scipy).

    tests/verification/axisymmetric.py 0.02 0.01 0.005      'frictional indentation', cells of these sizes
    tests/verification/axisymmetric.py hertz 20 40          'Hertz, ten nodes', so many cells a contact radius

**Frictional indentation.** The scene of `touch_studies.Press` at small displacements: both bodies of bilinear rings on matching
meshes, condensed to the nodes that may touch. Contact is node by node and without a penalty, and it is
driven by events: each increment ends when the front comes to the next node, so that no rule for the
first touch is asked. Printed are the sums over Fn of friction, of the radial part of the pressure (it
acts along the normal of the dented block), of both, and the force, the radius and that of stick.

**Hertz.** The paraboloids of `half_spaces.Pair` and what holds them there: force and radius of contact
(of the second moment) against Hertz, whose half-spaces are flat and whose surfaces do not move sideways.
The difference is proportional to a/R; its factor is printed by Poisson's ratio, for a/R = 0.02 and 0.04.
"""
import math
import sys

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg as solvers

import half_spaces

RADIUS, APPROACH, REACH = 200.0, 6e-4, 0.5
# Young's modulus, Poisson's ratio, radius, depth, whether a sphere; the upper body and the lower one.
UPPER = (3000.0, 0.25, 0.8, 0.6, True)
LOWER = (1000.0, 0.3, 1.6, 1.0, False)


def graded(cell, fine, end):
    """Coordinates from 0 to end: equal cells up to `fine`, then cells that grow by a tenth."""
    count = round(fine/cell)
    places, step = [fine/count*i for i in range(count + 1)], cell
    while places[-1] < end:
        step *= 1.1
        places.append(places[-1] + step)
    scale = (end - places[count])/(places[-1] - places[count])
    return np.array(places[:count + 1] + [places[count] + scale*(x - places[count])
                                          for x in places[count + 1:]])


def stiffness(young, nu, corners):
    """Stiffness of rings; corners: (element, corner, (r, z))."""
    first, shear = young*nu/(1 + nu)/(1 - 2*nu), young/2/(1 + nu)
    law = np.diag([2*shear]*3 + [shear])
    law[:3, :3] += first
    count, root = len(corners), 1/math.sqrt(3)
    result = np.zeros((count, 8, 8))
    for s in (-root, root):
        for t in (-root, root):
            shape = np.array([(1 - s)*(1 - t), (1 + s)*(1 - t), (1 + s)*(1 + t), (1 - s)*(1 + t)])/4
            slope = np.array([[t - 1, s - 1], [1 - t, -1 - s], [1 + t, 1 + s], [-1 - t, 1 - s]])/4
            jacobian = np.einsum('na,enb->eab', slope, corners)
            slopes = np.einsum('eba,na->enb', np.linalg.inv(jacobian), slope)
            radius = corners[:, :, 0]@shape
            strain = np.zeros((count, 4, 8))
            strain[:, 0, 0::2] = strain[:, 3, 1::2] = slopes[:, :, 0]
            strain[:, 1, 1::2] = strain[:, 3, 0::2] = slopes[:, :, 1]
            strain[:, 2, 0::2] = shape/radius[:, None]
            weight = 2*math.pi*radius*np.linalg.det(jacobian)
            result += np.einsum('eia,ij,ejb,e->eab', strain, law, strain, weight)
    return result


def mesh(r, z):
    """Places of the nodes of a grid, flat, and their numbers by (radius, height)."""
    place = np.stack(np.meshgrid(r, z, indexing='ij'), 2).reshape(-1, 2)
    return place, np.arange(len(place)).reshape(len(r), len(z))


def assembled(young, nu, place, number):
    """Stiffness of a grid of rings, of unknowns (radial, axial) node by node."""
    nodes = np.stack([x.ravel() for x in (number[:-1, :-1], number[1:, :-1], number[1:, 1:],
                                          number[:-1, 1:])], 1)
    unknown = np.stack([2*nodes, 2*nodes + 1], 2).reshape(len(nodes), 8)
    return sparse.csc_matrix((stiffness(young, nu, place[nodes]).ravel(),
                              (np.repeat(unknown, 8, 1).ravel(), np.tile(unknown, (1, 8)).ravel())))


def compliance(body, cell, count):
    """Compliance of the first nodes of the near face, by (inwards, radial): 2 x 2 blocks."""
    young, nu, outer, depth, sphere = body
    r, z = graded(cell, REACH, outer), graded(cell/2, 0.45, depth)
    place, number = mesh(r, z)
    if sphere:
        place[:, 1] += place[:, 0]**2/(2*RADIUS)*(1 - place[:, 1]/depth)
    whole = assembled(young, nu, place, number)
    free = np.ones(2*len(place), bool)
    free[2*number[0]] = free[2*number[:, -1]] = free[2*number[:, -1] + 1] = False
    at = np.full(2*len(place), -1)
    at[free] = np.arange(free.sum())
    face = np.concatenate([at[2*number[:count, 0] + 1], at[2*number[:count, 0]]])
    loads = np.zeros((free.sum(), 2*count))
    loads[face[face >= 0], np.where(face >= 0)[0]] = 1
    moved = solvers.splu(whole[free][:, free]).solve(loads)[face]
    moved[face < 0] = 0
    return moved.reshape(2, count, 2, count).swapaxes(1, 2)


class Contact:
    """The nodes that may touch: gap and slip (upper less lower) by pressures and friction forces."""

    def __init__(self, cell, mu):
        self.count, self.mu, self.cell = round(REACH/cell), mu, cell
        upper, self.lower = (compliance(body, cell, self.count) for body in (UPPER, LOWER))
        signs = np.array([[1, -1], [1, -1]])[:, :, None, None]
        self.both = signs*upper + np.array([[1, 1], [-1, -1]])[:, :, None, None]*self.lower
        self.r = graded(cell, REACH, UPPER[2])[:self.count]
        self.tip = np.zeros(self.count)

    def solve(self, closed, approach):
        """With so many closed nodes, at an approach, or (None) at the one at which the next node touches.

        Pressures, friction forces, approach, slips and what sticks; friction stands until no node is
        beyond its cone and none goes back.
        """
        k, gap = closed, self.r**2/(2*RADIUS)
        sticks, side = np.arange(k) > 0, np.zeros(k)
        (zz, zr), (rz, rr) = self.both
        last = np.r_[zz[k, :k], zr[k, :k], -1.0] if approach is None else np.r_[np.zeros(2*k), 1.0]
        for _ in range(200):
            bound = np.hstack([-np.diag(self.mu*side), np.eye(k), np.zeros((k, 1))])
            held = np.hstack([rz[:k, :k], rr[:k, :k], np.zeros((k, 1))])
            matrix = np.vstack([np.hstack([zz[:k, :k], zr[:k, :k], -np.ones((k, 1))]),
                                np.where(sticks[:, None], held, bound), last])
            x = np.linalg.solve(matrix, np.r_[-gap[:k], np.where(sticks, self.tip[:k], 0),
                                              -gap[k] if approach is None else approach])
            pressure, friction = x[:k], x[k:2*k]
            slip = rz[:, :k]@pressure + rr[:, :k]@friction
            over = sticks & (np.abs(friction) > self.mu*np.abs(pressure)*(1 + 1e-9))
            back = ~sticks & ((slip[:k] - self.tip[:k])*side < -1e-15)
            if not (over | back).any():
                return pressure, friction, x[-1], slip, sticks
            side[over] = np.sign(friction[over])
            sticks = sticks & ~over if over.any() else sticks | back
        raise ArithmeticError(f'{k} nodes: stick and slip are not found')

    def press(self):
        """Pressed to the end; the six numbers that are printed."""
        for closed in range(1, self.count):
            _, _, approach, slip, sticks = self.solve(closed, None)
            if approach > APPROACH:
                break
            self.tip[:closed][~sticks] = slip[:closed][~sticks]
            self.tip[closed] = slip[closed]
        pressure, friction, _, _, sticks = self.solve(closed, APPROACH)
        down = self.lower[0, 0][:, :closed]@pressure + self.lower[0, 1][:, :closed]@friction
        force = pressure.sum()
        inclined = pressure@np.gradient(-down, self.cell)[:closed]/force
        shear = friction.sum()/force
        return shear, inclined, shear + inclined, force, self.r[closed - 1], self.r[:closed][sticks].max()


def pressed_paraboloid(slope, nu, cells):
    """Force and radius of contact over those of Hertz, less 1; slope: radius of contact over that of
    the bodies; cells: so many in the radius of contact, which is 1.

    One body on a rigid plane stands for two equal ones.
    """
    outer, young = 8.0, 1.0
    place, number = mesh(graded(1/cells, 1.5, outer), graded(0.5/cells, 0.7, outer))
    place[:, 1] += np.minimum(place[:, 0]**2, 4)*slope/2*(1 - place[:, 1]/outer)
    whole = assembled(young, nu, place, number)
    stiff = young/(2*(1 - nu**2))
    target, moved, free = 8*stiff*slope/3, np.zeros(2*len(place)), np.ones(2*len(place), bool)
    for node in np.union1d(number[-1], number[:, -1]):
        radial, _, axial = half_spaces.boussinesq(place[node, 0], 0.0, place[node, 1], young/(2*(1 + nu)), nu)
        moved[2*node:2*node + 2] = target*radial, target*axial - slope
        free[2*node:2*node + 2] = False
    free[2*number[0]] = False
    factor, at = solvers.splu(whole[free][:, free]), np.cumsum(free) - 1
    near = number[:int(1.4*cells), 0]
    face, loads = at[2*near + 1], np.zeros((free.sum(), len(near)))
    loads[face, np.arange(len(near))] = 1
    gap, give = place[near, 1] + factor.solve(-(whole@moved)[free])[face], factor.solve(loads)[face]
    closed, force = gap < 0, np.zeros(len(near))
    for _ in range(100):
        force[:] = 0
        force[closed] = np.linalg.solve(give[np.ix_(closed, closed)], -gap[closed])
        settled = np.where(closed, force > 0, gap + give@force < 0)
        if (settled == closed).all():
            break
        closed = settled
    whole_force = force.sum()
    width = math.sqrt(2.5*(force@place[near, 0]**2)/whole_force)
    return whole_force/target - 1, width/(3*whole_force/(8*stiff*slope))**(1/3) - 1


def hertz(sizes):
    """What Hertz leaves out, over a/R, by Poisson's ratio and size of cell."""
    for cells in sizes:
        for nu in (0.0, 0.1, 0.2, 0.3, 0.4):
            flat = pressed_paraboloid(1e-4, nu, int(cells))
            bent = [[(a - b)/slope for a, b in zip(pressed_paraboloid(slope, nu, int(cells)), flat)]
                    for slope in (0.02, 0.04)]
            print(f'cells {cells} nu {nu}: force {bent[0][0]:.4f} {bent[1][0]:.4f}, radius '
                  f'{bent[0][1]:.4f} {bent[1][1]:.4f}; flat {flat[0]:.1e} {flat[1]:.1e}', flush=True)


def main():
    """Both coefficients of friction, for the cells that are asked for; or Hertz."""
    if sys.argv[1:2] == ['hertz']:
        hertz(sys.argv[2:] or ['20'])
        return
    for mu in (0.3, 0.1):
        for cell in sys.argv[1:] or ('0.02', '0.01'):
            print(f'mu {mu} cell {cell}: ' + 'friction {:.5f} inclined {:.5f} sum {:.5f} force {:.6f} radius '
                  '{:.4f} stick {:.4f}'.format(*Contact(float(cell), mu).press()), flush=True)


if __name__ == '__main__':
    main()
