"""Which triangles of two sets pass through each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints

_CHUNK = 1 << 20  # pairs looked at in one go


def crossing(first: Array, second: Array) -> Ints:
    """Return the rows k at which triangle k (p, 3, 3) of the first and of the second pass through each other.

    An edge of one passes through the inside of the other. Triangles that only touch, or lie in one plane, do not.

    >>> flat = np.array([[[0.0, 0, 0], [4, 0, 0], [0, 4, 0]]])
    >>> crossing(flat, np.array([[[1.0, 1, -1], [1, 1, 1], [2, 1, 1]]]))
    array([0])
    """
    found = np.zeros(len(first), dtype=bool)
    for start in range(0, len(first), _CHUNK):
        rows = slice(start, start + _CHUNK)
        found[rows] = _pierced(first[rows], second[rows])
        found[rows] |= _pierced(second[rows], first[rows])
    return np.flatnonzero(found)


def wall_meets_itself(first: Array, second: Array, following: Ints) -> bool:
    """Return whether the wall between two rings (k, 3) passes through itself; `following` (k,) as in `loops_around`.

    Of triangles that share no corner two must pass through each other: where a fold begins at a corner that two share,
    it ends among others. A wall whose fibres are parallel does not, as its rings do not.

    >>> square = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    >>> wall_meets_itself(square, np.roll(square, 2, axis=0) + [0.3, 0.1, 1], loops_around([4]))
    True
    """
    fibres = second - first
    size = float(np.ptp(first, axis=0).max())
    middle = fibres[np.square(fibres).sum(axis=1).argmax()]
    if np.abs(np.cross(fibres, middle)).max() <= 1e-9 * size * float(np.linalg.norm(middle)):
        return False
    here, k = np.arange(len(first)), len(first)
    corners = np.concatenate(
        [np.column_stack([here, following, following + k]), np.column_stack([here, following + k, here + k])]
    )
    triangles = np.concatenate([first, second])[corners]
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    rows = max(1, _CHUNK // len(triangles))
    for start in range(0, len(triangles), rows):
        near = np.ones((len(low[start : start + rows]), len(low)), dtype=bool)
        for axis in range(3):
            near &= low[start : start + rows, None, axis] <= high[:, axis]
            near &= low[:, axis] <= high[start : start + rows, None, axis]
        i, j = np.nonzero(near)
        i += start
        apart = (i < j) & (corners[i][:, :, None] != corners[j][:, None, :]).all(axis=(1, 2))
        if len(crossing(triangles[i[apart]], triangles[j[apart]])):
            return True
    return False


def loops_around(sizes: Sequence[int]) -> Ints:
    """Return for the corners of loops of so many corners, one loop after the other, the number of the one that follows.

    >>> loops_around([3, 4]).tolist()
    [1, 2, 0, 4, 5, 6, 3]
    """
    starts = np.cumsum(sizes) - sizes
    return np.concatenate([start + np.roll(np.arange(n), -1) for start, n in zip(starts, sizes, strict=True)])


def _pierced(edges: Array, faces: Array) -> NDArray[np.bool_]:
    """Return whether an edge of each triangle of `edges` passes through the triangle of `faces`."""
    a, b, c = faces.transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    heights = np.einsum("pkd,pd->pk", edges - a[:, None], normal)
    out = np.zeros(len(edges), dtype=bool)
    maybe = np.flatnonzero((heights.min(axis=1) < 0.0) & (heights.max(axis=1) > 0.0))
    a, b, c, normal = a[maybe], b[maybe], c[maybe], normal[maybe]
    for k in range(3):
        p, q = edges[maybe, k], edges[maybe, (k + 1) % 3]
        hp, hq = heights[maybe, k], heights[maybe, (k + 1) % 3]
        through = hp * hq < 0.0
        t = hp / np.where(through, hp - hq, 1.0)
        at = p + t[:, None] * (q - p)
        inside = through
        for start, end in ((a, b), (b, c), (c, a)):
            side = np.einsum("pd,pd->p", np.cross(end - start, at - start), normal)
            inside = inside & (side > 0.0)
        out[maybe] |= inside
    return out
