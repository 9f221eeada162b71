"""Which triangles of two sets pass through each other."""

from __future__ import annotations

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
