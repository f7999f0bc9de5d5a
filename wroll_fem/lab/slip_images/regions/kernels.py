"""Compiled loops over the pixels: smoothing, connected regions, their outlines, and intensity-weighted centroids."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit

AREA, FIRST, TOP, BOTTOM, LEFT, RIGHT = range(6)
"""Columns of the table of regions: number of pixels, first pixel (row by row), and the bounding box, inclusive."""

MID_CRACK = 1.0548
"""Length of the polygon through the middles of the pixel edges over the length of a smooth outline, averaged over the
directions: (4/pi) (sin 45 deg + (sqrt 2 - 1)(1 - cos 45 deg))."""


@njit(cache=True)
def smooth(image: Any, row: Any, out: Any) -> None:
    """Filter with the weights 1/4, 1/2, 1/4 along both axes; pixels of the edge are repeated."""
    rows, columns = image.shape
    for i in range(rows):
        up, down = max(i - 1, 0), min(i + 1, rows - 1)
        for j in range(columns):
            row[j] = np.float32(0.25) * (image[up, j] + image[down, j]) + np.float32(0.5) * image[i, j]
        for j in range(1, columns - 1):
            out[i, j] = np.float32(0.25) * (row[j - 1] + row[j + 1]) + np.float32(0.5) * row[j]
        for j in (0, columns - 1):
            left, right = row[max(j - 1, 0)], row[min(j + 1, columns - 1)]
            out[i, j] = np.float32(0.25) * (left + right) + np.float32(0.5) * row[j]


@njit(cache=True)
def _root(parent: Any, k: int) -> int:
    while parent[k] != k:
        parent[k] = parent[parent[k]]
        k = parent[k]
    return k


@njit(cache=True)
def _join(parent: Any, a: int, b: int) -> int:
    a, b = _root(parent, a), _root(parent, b)
    if a < b:
        parent[b] = a
        return a
    parent[a] = b
    return b


@njit(cache=True)
def label_regions(image: Any, level: Any, labels: Any, parent: Any) -> Any:
    """Label the pixels above a level; pixels that touch with an edge or a corner belong to one region.

    Parameters
    ----------
    image, level
        (rows, columns).
    labels
        (rows, columns) integers, overwritten: number of the region from 1, 0 elsewhere.
    parent
        Integers, one more than pixels, as working space.

    Returns
    -------
    ndarray
        (regions, 6), with the columns `AREA` to `RIGHT`.
    """
    rows, columns = image.shape
    count = 0
    for i in range(rows):
        for j in range(columns):
            if not image[i, j] > level[i, j]:
                labels[i, j] = 0
                continue
            w = labels[i, j - 1] if j > 0 else 0
            nw = labels[i - 1, j - 1] if i > 0 and j > 0 else 0
            n = labels[i - 1, j] if i > 0 else 0
            ne = labels[i - 1, j + 1] if i > 0 and j < columns - 1 else 0
            if n > 0:
                found = n
            elif ne > 0:
                found = ne
                if nw > 0:
                    found = _join(parent, ne, nw)
                elif w > 0:
                    found = _join(parent, ne, w)
            elif nw > 0:
                found = nw
            elif w > 0:
                found = w
            else:
                count += 1
                parent[count] = count
                found = count
            labels[i, j] = found
    return _table(labels, parent, count)


@njit(cache=True)
def _table(labels: Any, parent: Any, count: int) -> Any:
    """Number the joined regions from 1 and measure area and bounding box."""
    number = np.zeros(count + 1, np.int64)
    regions = 0
    for k in range(1, count + 1):
        root = _root(parent, k)
        if root == k:
            regions += 1
            number[k] = regions
        else:
            number[k] = number[root]
    rows, columns = labels.shape
    table = np.zeros((regions, 6), np.int64)
    for i in range(rows):
        for j in range(columns):
            k = labels[i, j]
            if k == 0:
                continue
            k = number[k]
            labels[i, j] = k
            entry = table[k - 1]
            if entry[0] == 0:
                entry[1], entry[2], entry[4], entry[5] = i * columns + j, i, j, j
            entry[0] += 1
            entry[3] = i
            entry[4] = min(entry[4], j)
            entry[5] = max(entry[5], j)
    return table


@njit(cache=True)
def _inside(labels: Any, i: int, j: int, k: int) -> bool:
    return 0 <= i < labels.shape[0] and 0 <= j < labels.shape[1] and labels[i, j] == k


@njit(cache=True)
def outlines(labels: Any, first: Any, wanted: Any) -> Any:
    """Area and length of the outer outline of regions; holes belong to the area.

    Parameters
    ----------
    labels
        (rows, columns), numbers of regions.
    first
        (regions,) first pixel of each region in the order of the rows.
    wanted
        (n,) places of the regions in ``first``.

    Returns
    -------
    ndarray
        (n, 2), px^2 and px.

    Notes
    -----
    The outline follows the edges of the pixels clockwise. Its length is that of the polygon through the middles of
    these edges over `MID_CRACK`: exact on average over the directions, hence for circles.
    """
    columns = labels.shape[1]
    result = np.zeros((wanted.size, 2))
    for n in range(wanted.size):
        start = first[wanted[n]]
        k = wanted[n] + 1
        y0, x0 = start // columns, start % columns
        y, x, dy, dx = y0, x0, 0, 1  # corner of pixels, and direction: the region is to the right
        area, steps, turns = 0, 0, 0
        while True:
            area -= y * dx
            y, x = y + dy, x + dx
            steps += 1
            # pixels ahead, left and right of the direction; pixel (i, j) lies between the corners i and i + 1
            ly, lx = y + (dy - dx - 1) // 2, x + (dx + dy - 1) // 2
            ry, rx = y + (dy + dx - 1) // 2, x + (dx - dy - 1) // 2
            if _inside(labels, ly, lx, k):
                dy, dx = -dx, dy
                turns += 1
            elif not _inside(labels, ry, rx, k):
                dy, dx = dx, -dy
                turns += 1
            if y == y0 and x == x0 and dy == 0 and dx == 1:
                break
        result[n, 0] = area
        result[n, 1] = (steps - turns + turns * np.sqrt(0.5)) / MID_CRACK
    return result


@njit(cache=True)
def sums(signal: Any, labels: Any, number: Any, margin: int, stamp: Any) -> Any:
    """Sums of the signal over regions and the pixels around them.

    Parameters
    ----------
    signal
        (rows, columns), zero in the ground.
    labels
        (rows, columns) numbers of regions; overwritten by places from 1 and their surroundings.
    number
        (regions + 1,) place of each region among those to sum, counted from 1; 0 leaves it out.
    margin
        Width of the surroundings, px. Pixels as near to another region belong to neither of them.
    stamp
        (rows, columns) small integers as working space.

    Returns
    -------
    ndarray
        (n, 3): sum of the signal, and of the signal times column and row.
    """
    rows, columns = labels.shape
    edge = np.empty(labels.size, np.int64)
    size = 0
    for i in range(rows):
        for j in range(columns):
            stamp[i, j] = 0
            if labels[i, j] > 0:
                labels[i, j] = number[labels[i, j]]
    for i in range(rows):
        for j in range(columns):
            if labels[i, j] > 0:
                inner = 0 < i < rows - 1 and 0 < j < columns - 1
                if not (inner and labels[i - 1, j] == labels[i + 1, j] == labels[i, j - 1] == labels[i, j + 1] > 0):
                    edge[size] = i * columns + j
                    size += 1
    begin = 0
    for step in range(1, margin + 1):
        end = size
        for n in range(begin, end):
            size = _grow(labels, stamp, edge, size, edge[n], step)
        begin = end
    total = np.zeros((int(number.max()), 3))
    for i in range(rows):
        for j in range(columns):
            if labels[i, j] > 0:
                entry, value = total[labels[i, j] - 1], signal[i, j]
                entry[0] += value
                entry[1] += value * j
                entry[2] += value * i
    return total


@njit(cache=True)
def _grow(labels: Any, stamp: Any, edge: Any, size: int, pixel: int, step: int) -> int:
    """Add the free neighbours of a pixel to its region; corners in every second step, for round surroundings."""
    rows, columns = labels.shape
    i, j = pixel // columns, pixel % columns
    k = labels[i, j]
    if k <= 0:
        return size
    for di in range(-1, 2):
        for dj in range(-1, 2):
            if di * di + dj * dj == 0 or (step % 2 and di != 0 and dj != 0):
                continue
            a, b = i + di, j + dj
            if a < 0 or b < 0 or a >= rows or b >= columns or labels[a, b] == k:
                continue
            if labels[a, b] == 0 and stamp[a, b] == 0:
                labels[a, b] = k
                stamp[a, b] = step
                edge[size] = a * columns + b
                size += 1
            elif stamp[a, b] == step:
                labels[a, b] = -1  # as near to another region
    return size
