"""The directions of a path at its vertices, and the vertices that are corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints

_REACH = 8  # vertices to each side, at most
_ARM = 6.0  # tolerances to each side: over less, errors within the tolerance decide the direction
_LONG = 3.0  # a chord this much longer than the next one is a straight line that a bend begins after


def corners(points: Array, tolerance: float, angle: float) -> Ints:
    """Return the rows of the vertices (n, d) that turn by more than `angle` (radians) between chords not too short.

    Chords shorter than the tolerance count for nothing by themselves: their ends turn as the chords around them do.

    >>> corners(np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]]), 0.01, 0.5)
    array([1])
    """
    chords = np.diff(points, axis=0)
    length = np.sqrt(np.einsum("nd,nd->n", chords, chords))
    unit = chords / length[:, None]
    cosine = np.einsum("nd,nd->n", unit[:-1], unit[1:])
    long_enough = np.minimum(length[:-1], length[1:]) >= tolerance
    sharp = (cosine < np.cos(angle)) & (long_enough | (cosine < -0.5))
    return np.flatnonzero(sharp) + 1


def directions(points: Array, tolerance: float) -> tuple[Array, Array]:
    """Return unit tangents (n, d) at the vertices of a smooth path (n, d), n >= 2, and how far (n, d) to move them.

    Where the path is a polygon whose vertices lie on the curve that is meant, its chords lie inside. Moved by half the
    height of the arcs over the chords next to it, a vertex lies midway: a curve through such places is nearest to both.

    Each is that of the parabola over arc length through the vertices around, as far as six tolerances and at least one
    to each side (at the ends, two to one). Next to a chord three times as long as the other, it is that chord's.

    >>> t = np.linspace(0.0, 1.0, 9)
    >>> found, inward = directions(np.column_stack([np.cos(t), np.sin(t)]), 1e-3)
    >>> bool(np.abs(found - np.column_stack([-np.sin(t), np.cos(t)])).max() < 2e-3)
    True
    >>> np.round(inward[4] @ (np.cos(0.5), np.sin(0.5)) * 1e4, 2)  # half of 1 - cos(1/16)
    np.float64(-9.75)
    """
    n = len(points)
    chords = np.diff(points, axis=0)
    length = np.sqrt(np.einsum("nd,nd->n", chords, chords))
    if n == 2:
        return np.repeat(chords / length[:, None], 2, axis=0), np.zeros((2, points.shape[1]))
    slope, bend = _parabolas(points, np.concatenate([[0.0], np.cumsum(length)]), _ARM * tolerance)
    before, after = length[:-1], length[1:]
    from_long, to_long = before > _LONG * after, after > _LONG * before
    unit = chords / length[:, None]
    slope[1:-1][from_long] = unit[:-1][from_long]
    slope[1:-1][to_long] = unit[1:][to_long]
    for end, chord, other in ((0, 0, 1), (-1, -1, -2)):
        if length[chord] > _LONG * length[other]:
            slope[end] = unit[chord]
    slope /= np.sqrt(np.einsum("nd,nd->n", slope, slope))[:, None]
    inward = bend - np.einsum("nd,nd->n", bend, slope)[:, None] * slope
    inward[1:-1] *= ((before * before + after * after) / 32.0)[:, None]
    inward[[0, -1]] = 0.0
    return np.asarray(slope), np.asarray(inward)


def straights(points: Array) -> NDArray[np.bool_]:
    """Return whether each vertex (n,) ends a straight line: a chord three times as long as the next one."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    found = np.zeros(len(points), dtype=bool)
    found[1:-1] = (length[:-1] > _LONG * length[1:]) | (length[1:] > _LONG * length[:-1])
    return found


def _parabolas(points: Array, along: Array, arm: float) -> tuple[Array, Array]:
    """Return both derivatives (n, d) at the vertices of the parabolas of least squares through those around."""
    n = len(points)
    rows = np.arange(n)
    offsets = np.arange(-_REACH, _REACH + 1)
    index = rows[:, None] + offsets
    valid = (index >= 0) & (index < n)
    index = np.clip(index, 0, n - 1)
    step = along[index] - along[:, None]
    least = np.clip(np.maximum(1, np.maximum(2 - rows, 3 - n + rows)), 1, 2)  # at the ends, two to the one side
    used = valid & ((np.abs(step) <= arm) | (np.abs(offsets) <= least[:, None]))
    scale = np.where(used, np.abs(step), 0.0).max(axis=1)
    s = np.where(used, step / scale[:, None], 0.0)
    gap = np.where(used[:, :, None], points[index] - points[:, None], 0.0)
    powers = [used.sum(axis=1, dtype=np.float64), s.sum(axis=1)]
    raised = s * s
    for _ in range(3):
        powers.append(raised.sum(axis=1))
        raised = raised * s
    normal = np.stack([np.stack([powers[i + j] for j in range(3)], axis=1) for i in range(3)], axis=1)
    right = np.stack([np.einsum("nk,nkd->nd", s**k, gap) for k in range(3)], axis=1)
    right[:, 0] = gap.sum(axis=1)
    found = np.linalg.solve(normal, right)
    return found[:, 1] / scale[:, None], 2.0 * found[:, 2] / (scale * scale)[:, None]
