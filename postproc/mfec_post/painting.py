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
    corners = FINE * corners
    weights = weight_functions(corners)
    owner, row, column, deep = fragments(corners, np.einsum('nk,nki->ni', depth, weights),
                                         width, height)
    at = row * width + column
    nearest = front(at, deep, height * width)
    if len(nearest):
        owner, at = owner[nearest], at[nearest]
        near[at] = deep[nearest]
        x, y = column[nearest] + 0.5, row[nearest] + 0.5
        reach = np.full(len(owner), np.inf)
        for a, b, c in (weights * heights(corners)[:, :, None]).transpose(1, 2, 0):
            reach = np.minimum(reach, a[owner] * x + b[owner] * y + c[owner])
        line = 0.5 * FINE * line
        picture[at] = np.where(reach[:, None] < line, edges[owner], colours[owner])
    picture = picture.reshape(size[1], FINE, size[0], FINE, 3).mean(axis=(1, 3))
    return picture[::-1], near.reshape(size[1], FINE, size[0], FINE).max(axis=(1, 3))


def weight_functions(corners: NDArray) -> NDArray:
    """(n, 3, 3): the weight of corner k of a triangle at x, y is w[k] @ (x, y, 1)."""
    double = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    safe = np.where(np.abs(double) > 1e-12, double, np.inf)
    b, c = corners[:, [1, 2, 0]], corners[:, [2, 0, 1]]
    return np.stack([b[..., 1] - c[..., 1], c[..., 0] - b[..., 0], cross(b, c)],
                    axis=2) / safe[:, None, None]


def heights(corners: NDArray) -> NDArray:
    """The heights of triangles (n, 3) above the edges opposite to their corners."""
    double = np.abs(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    opposite = np.linalg.norm(corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]], axis=2)
    return double[:, None] / np.maximum(opposite, 1e-300)


def cross(a: NDArray, b: NDArray) -> NDArray:
    """The third component of cross products of plane vectors."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def fragments(corners: NDArray, plane: NDArray, width: int,
              height: int) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """For each pixel whose center lies in a triangle: triangle, row, column and depth; plane (n, 3) is
    the depth of a triangle as a function of x, y and 1."""
    low = np.clip(np.ceil(corners[:, :, 1].min(axis=1) - 0.5), 0, height).astype(int)
    high = np.clip(np.floor(corners[:, :, 1].max(axis=1) - 0.5) + 1, 0, height).astype(int)
    owner, row = ranges(low, high)
    y = row + 0.5
    left, right = np.full(len(owner), np.inf), np.full(len(owner), -np.inf)
    for k in range(3):  # where the row crosses the edges
        begin, end = corners[owner, k], corners[owner, (k + 1) % 3]
        rise = end[:, 1] - begin[:, 1]
        share = (y - begin[:, 1]) / np.where(rise == 0, np.inf, rise)
        x = begin[:, 0] + share * (end[:, 0] - begin[:, 0])
        on = (rise != 0) & (share >= 0) & (share <= 1)
        left, right = np.where(on, np.minimum(left, x), left), np.where(on, np.maximum(right, x), right)
    found = left <= right
    owner, row, y, left, right = owner[found], row[found], y[found], left[found], right[found]
    first = np.clip(np.ceil(left - 0.5), 0, width).astype(int)
    last = np.clip(np.floor(right - 0.5) + 1, 0, width).astype(int)
    span, column = ranges(first, last)
    start = plane[owner, 0] * 0.5 + plane[owner, 1] * y + plane[owner, 2]
    return owner[span], row[span], column, start[span] + plane[owner, 0][span] * column


def ranges(low: NDArray, high: NDArray) -> tuple[NDArray, NDArray]:
    """All numbers from low to below high, and for each the place of its range."""
    count = np.maximum(high - low, 0)
    place = np.repeat(np.arange(len(low)), count)
    return place, np.arange(len(place)) - np.repeat(np.cumsum(count) - count, count) + low[place]


def front(at: NDArray, depth: NDArray, pixels: int) -> NDArray:
    """Of all fragments of a pixel the one nearest to the viewer."""
    order = np.argsort(depth, kind='stable')
    winner = np.full(pixels, -1)
    winner[at[order]] = order  # the last one stays
    return winner[winner >= 0]
