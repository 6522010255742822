"""The error of the stresses in the energy norm, by recovery over patches
(doc/theory, "Error of a result", eq. (13.10)).

Stresses are recovered body by body and material by material: never across a contact or an interface.
"""
from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .adapt_model import EDGES, Bodies

FEWEST = {1: 14, 2: 10}
"""Elements that a patch needs: with fewer it takes its neighbours' neighbours."""
RIDGE = 1e-3
"""Keeps patches on one side of their node (surfaces) from extrapolating wildly."""
A, B = (5 + 3 * math.sqrt(5)) / 20, (5 - math.sqrt(5)) / 20
PRODUCTS = ((1, 1), (2, 2), (3, 3), (1, 2), (2, 3), (3, 1))
"""Of the linear terms: the quadratic ones."""
TOGETHER = 64
"""Patches that are solved in one go: their terms stay in the cache."""
GAUSS = np.full((4, 4), B) + (A - B) * np.eye(4)
"""Barycentric coordinates of the points of stress of T10."""


def slopes(order: int, at: NDArray) -> NDArray:
    """Derivatives of the shape functions by the barycentric coordinates 2 to 4 (nodes, 3)."""
    corner = np.vstack([-np.ones(3), np.eye(3)])
    if order == 1:
        return corner
    grads = [(4 * at[i] - 1) * corner[i] for i in range(4)]
    grads += [4 * (at[i] * corner[j] + at[j] * corner[i]) for i, j in EDGES]
    return np.array(grads)


def elasticity(young: float, poisson: float) -> NDArray:
    """C for xx yy zz xy yz zx with shear angles."""
    shear = young / (2 * (1 + poisson))
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    matrix = np.diag([2 * shear] * 3 + [shear] * 3)
    matrix[:3, :3] += lame
    return matrix


def samples(points: NDArray, cells: NDArray, order: int, u: NDArray, c: NDArray) -> tuple[NDArray, NDArray]:
    """Places (cells, samples, 3) and stresses (cells, samples, times, 6) of all output times."""
    places, stresses = [], []
    x, moved = points[cells], np.swapaxes(u[:, cells], 2, 3)
    for at in GAUSS if order == 2 else [np.full(4, 0.25)]:
        d = slopes(order, at)
        grads = d @ np.swapaxes(np.linalg.inv(d.T @ x), 1, 2)
        h = moved @ grads
        strain = np.stack([h[..., 0, 0], h[..., 1, 1], h[..., 2, 2], h[..., 0, 1] + h[..., 1, 0],
                           h[..., 1, 2] + h[..., 2, 1], h[..., 2, 0] + h[..., 0, 2]], -1)
        stresses.append(np.moveaxis(strain @ c, 0, 1))
        if order == 2:
            shape = np.concatenate([at * (2 * at - 1), 4 * at[EDGES[:, 0]] * at[EDGES[:, 1]]])
            places.append(shape @ x)
        else:
            places.append(x.mean(1))
    return np.stack(places, 1), np.stack(stresses, 1)


def terms(order: int, y: NDArray) -> NDArray:
    """The polynomial's terms, linear or quadratic: (..., points, 3) gives (..., terms, points)."""
    out = np.empty((*y.shape[:-2], 10 if order == 2 else 4, y.shape[-2]))
    out[..., 0, :] = 1.0
    out[..., 1:4, :] = np.swapaxes(y, -1, -2)
    for k, (i, j) in enumerate(PRODUCTS[:out.shape[-2] - 4], 4):
        np.multiply(out[..., i, :], out[..., j, :], out=out[..., k, :])
    return out


def spans(first: NDArray, count: NDArray) -> NDArray:
    """The numbers first, first + 1, ... of each, `count` of them, one after another."""
    ends = np.cumsum(count)
    return np.repeat(first - ends + count, count) + np.arange(ends[-1] if len(ends) else 0)


def patches(corners: NDArray, n: int, order: int) -> tuple[NDArray, NDArray]:
    """Elements around each of n nodes, one node after another, and how many each has; two rings where
    one has too few."""
    m = len(corners)
    rings = np.argsort(corners.ravel(), kind='stable') // 4
    count = np.bincount(corners.ravel(), minlength=n)
    first = np.cumsum(count) - count
    few, many = np.flatnonzero(count < FEWEST[order]), np.flatnonzero(count >= FEWEST[order])
    inner = rings[spans(first[few], count[few])]
    around = np.unique(np.repeat(np.repeat(few, count[few]), 4) * n + corners[inner].ravel())
    node, other = around // n, around % n
    two = np.unique(np.repeat(node, count[other]) * m + rings[spans(first[other], count[other])])
    one = np.repeat(many, count[many]) * m + rings[spans(first[many], count[many])]
    keys = np.sort(np.concatenate([one, two]))
    return keys % m, np.bincount(keys // m, minlength=n)


def recover(points: NDArray, cells: NDArray, order: int, places: NDArray, stresses: NDArray) -> NDArray:
    """Stresses at the nodes of each cell (cells, nodes, times, 6): at corners from the fit of their
    patch, in the middle of an edge the mean of what the patches of its ends say there."""
    m, s, times = stresses.shape[:3]
    used, corners = np.unique(cells[:, :4], return_inverse=True)
    corners = corners.reshape(-1, 4)
    centre = points[used]
    around, size = patches(corners, len(used), order)
    first = np.cumsum(size) - size
    width = 10 if order == 2 else 4
    fits = np.zeros((len(used), width, 6 * times))
    scale = np.ones(len(used))
    flat, values = places.reshape(-1, 3), stresses.reshape(m * s, 6 * times)
    # Patches of like size in one go: what is missing to the largest of them weighs nothing.
    for chunk in np.array_split(np.argsort(size, kind='stable'), max(1, len(used) // TOGETHER)):
        column = np.arange(size[chunk].max())
        there = column < size[chunk, None]
        index = around[np.where(there, first[chunk, None] + column, 0)]
        index = (index[..., None] * s + np.arange(s)).reshape(len(chunk), -1)
        weight = np.repeat(there.astype(float), s, axis=1)
        y = flat[index] - centre[chunk, None]
        scale[chunk] = np.sqrt(((y ** 2).sum(-1) * weight).max(1))
        t = terms(order, y / scale[chunk, None, None]) * weight[:, None]
        left = t @ t.transpose(0, 2, 1) + RIDGE * np.diag([0.0] + [1.0] * (width - 1))
        fits[chunk] = np.linalg.solve(left, t @ values[index])
    at_nodes = np.empty((m, cells.shape[1], 6 * times))
    at_nodes[:, :4] = fits[corners, 0]
    if order == 2:
        middle, place, back = np.unique(cells[:, 4:], return_index=True, return_inverse=True)
        ends = corners[:, EDGES].reshape(-1, 2)[place]
        between = 0.5 * sum((terms(2, ((points[middle] - centre[end]) / scale[end, None])[:, None])
                             .transpose(0, 2, 1) @ fits[end])[:, 0] for end in ends.T)
        at_nodes[:, 4:] = between[back.reshape(m, -1)]
    return at_nodes.reshape(m, -1, times, 6)


@lru_cache
def mass(order: int) -> NDArray:
    """Integrals of products of the shape functions over a cell of volume 1."""
    if order == 1:
        return (np.ones((4, 4)) + np.eye(4)) / 20
    powers: list[dict[tuple[int, tuple[int, ...]], float]]
    powers = [{(2, (i,)): 2.0, (1, (i,)): -1.0} for i in range(4)]
    powers += [{(2, (int(i), int(j))): 4.0} for i, j in EDGES]

    def exponents(key: tuple[int, tuple[int, ...]]) -> NDArray:
        degree, places = key
        e = np.zeros(4, int)
        for place in places:
            e[place] += degree if len(places) == 1 else 1
        return e

    def integral(e: NDArray) -> float:
        return 6.0 * math.prod(math.factorial(k) for k in e) / math.factorial(int(e.sum()) + 3)

    return np.array([[sum(a * b * integral(exponents(i) + exponents(j)) for i, a in f.items()
                          for j, b in g.items()) for g in powers] for f in powers])


def estimate(bodies: Bodies, u: NDArray) -> tuple[NDArray, NDArray]:
    """Squares of the energy norms of the error of each cell, and of all stresses together, at each of
    the times of u (times, points, 3): (times, cells) and (times)."""
    order, n = bodies.order, len(u)
    eta, energy = np.zeros((n, len(bodies.cells))), np.zeros(n)
    volumes, product = bodies.volumes, mass(order)
    for number in np.unique(bodies.material):
        material = bodies.materials[int(number)]
        if material.rigid:
            continue
        members = np.flatnonzero(bodies.material == number)
        cells = bodies.cells[members]
        c = elasticity(material.young, material.poisson)
        places, stresses = samples(bodies.points, cells, order, u, c)
        best = recover(bodies.points, cells, order, places, stresses)
        if order == 2:  # linear between the points of stress, to be compared at the nodes
            corner = (np.linalg.inv(GAUSS) @ stresses.reshape(len(cells), 4, -1)).reshape(stresses.shape)
            raw = np.concatenate([corner, corner[:, EDGES].mean(2)], 1)
        else:
            raw = np.broadcast_to(stresses, best.shape)
        compliance = np.linalg.inv(c)

        def norm(field: NDArray, compliance: NDArray = compliance, members: NDArray = members) -> NDArray:
            weighed = (product @ field.reshape(*field.shape[:2], -1)).reshape(field.shape) @ compliance
            return volumes[members] * (weighed * field).sum((1, 3)).T

        eta[:, members] = norm(best - raw)
        energy += norm(np.ascontiguousarray(raw)).sum(1)
    return eta, energy
