"""Triangles as pixels: the nearest to the viewer wins, pixel by pixel."""
from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FINE = 2
"""Pixels are painted so many times finer along each side, and averaged."""


def paint(corners: NDArray, depth: NDArray, colours: NDArray, edges: NDArray,
          size: tuple[int, int], line: float = 0.45) -> tuple[NDArray, NDArray]:
    """A white picture (height, width, 3) of triangles, and how near to the viewer its pixels are
    (height, width; rows from below).

    corners (n, 3, 2) are in pixels from the lower left, depth (n, 3) grows towards the viewer; colours
    and edges (n, 3) are red, green, blue from 0 to 1. line is the width of edges in pixels.
    """
    width, height = FINE * size[0], FINE * size[1]
    picture, near = np.ones((height * width, 3)), np.full(height * width, -np.inf)
    owner, at, weight = fragments(FINE * corners, width, height)
    if len(owner):
        deep = np.einsum('ij,ij->i', weight, depth[owner])
        nearest = front(at, deep)
        owner, at, weight = owner[nearest], at[nearest], weight[nearest]
        near[at] = deep[nearest]
        reach = (weight * heights(FINE * corners)[owner]).min(axis=1)
        picture[at] = np.where(reach[:, None] < 0.5 * FINE * line, edges[owner], colours[owner])
    picture = picture.reshape(size[1], FINE, size[0], FINE, 3).mean(axis=(1, 3))
    return picture[::-1], near.reshape(size[1], FINE, size[0], FINE).max(axis=(1, 3))


def heights(corners: NDArray) -> NDArray:
    """The heights of triangles (n, 3) above the edges opposite to their corners."""
    double = np.abs(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    opposite = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)
    return double[:, None] / np.maximum(opposite, 1e-300)


def cross(a: NDArray, b: NDArray) -> NDArray:
    """The third component of cross products of plane vectors."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def fragments(corners: NDArray, width: int, height: int) -> tuple[NDArray, NDArray, NDArray]:
    """For each pixel whose center lies in a triangle: triangle, pixel, weights of the corners."""
    limits = np.array([width, height])
    low = np.clip(np.ceil(corners.min(axis=1) - 0.5), 0, limits).astype(int)
    high = np.clip(np.floor(corners.max(axis=1) - 0.5) + 1, 0, limits).astype(int)
    span = np.maximum(high - low, 0)
    count = span[:, 0] * span[:, 1]
    owner = np.repeat(np.arange(len(corners)), count)
    place = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
    column = low[owner, 0] + place % np.maximum(span[owner, 0], 1)
    row = low[owner, 1] + place // np.maximum(span[owner, 0], 1)
    centre = np.stack([column, row], axis=1) + 0.5
    a, b, c = corners[owner].transpose(1, 0, 2)
    double = cross(b - a, c - a)
    safe = np.where(np.abs(double) > 1e-12, double, np.inf)
    weight = np.stack([cross(b - centre, c - centre), cross(c - centre, a - centre),
                       cross(a - centre, b - centre)], axis=1) / safe[:, None]
    inside = (weight.min(axis=1) >= -1e-9) & np.isfinite(safe)
    return owner[inside], (row * width + column)[inside], weight[inside]


def front(at: NDArray, depth: NDArray) -> NDArray:
    """Of all fragments of a pixel the one nearest to the viewer."""
    order = np.lexsort((depth, at))
    last = np.append(at[order][1:] != at[order][:-1], True)
    return order[last]
