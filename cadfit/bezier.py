"""Arrays of cubic Bézier pieces, shape (m, 4, d): evaluate, split, bound, measure, find the nearest point.

Every function works on all m pieces at once. Parameters run over [0, 1] on each piece.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

_CHUNK = 1 << 16  # pieces handled at a time where a step needs several numbers for each

_LEAST = 1e-15  # the finest accuracy of a length: below it rounding never lets halves agree with their whole
_NODES, _WEIGHTS = (0.5 * rule for rule in np.polynomial.legendre.leggauss(12))
_BASIS = np.stack(
    [(0.5 - _NODES) ** 2, 2.0 * (0.5 - _NODES) * (0.5 + _NODES), (0.5 + _NODES) ** 2]
)  # Bernstein, (3, 12)


def evaluate(pieces: Array, t: Any) -> Array:
    """Return the point at t on every piece.

    `pieces` (m, 4, d), `t` a number or (m,); the result is (m, d). Bernstein form, so t = 0 and t = 1 give the
    end poles to the last bit.

    >>> evaluate(np.array([[[0.0], [1.0], [2.0], [3.0]]]), 0.5)
    array([[1.5]])
    """
    t = np.asarray(t, dtype=np.float64)[..., None]
    s = 1.0 - t
    inner = (3.0 * s * s * t) * pieces[:, 1] + (3.0 * s * t * t) * pieces[:, 2]
    return np.asarray(s * s * s * pieces[:, 0] + inner + t * t * t * pieces[:, 3])


def split(pieces: Array, t: Any = 0.5) -> tuple[Array, Array]:
    """Cut every piece at t (a number or (m,)) by de Casteljau; returns the left and the right parts, (m, 4, d) each.

    >>> left, right = split(np.array([[[0.0], [0.0], [4.0], [4.0]]]))
    >>> left[0, :, 0], right[0, :, 0]
    (array([0., 0., 1., 2.]), array([2., 3., 4., 4.]))
    """
    t = np.asarray(t, dtype=np.float64)[..., None]
    p0, p1, p2, p3 = (pieces[:, k] for k in range(4))
    a, b, c = p0 + t * (p1 - p0), p1 + t * (p2 - p1), p2 + t * (p3 - p2)
    d, e = a + t * (b - a), b + t * (c - b)
    f = d + t * (e - d)
    return np.stack([p0, a, d, f], axis=1), np.stack([f, e, c, p3], axis=1)


def restrict(pieces: Array, t0: Any, t1: Any) -> Array:
    """Return the part of every piece between t0 and t1 (numbers or (m,), t0 <= t1), as pieces of its own.

    >>> restrict(np.array([[[0.0], [1.0], [2.0], [3.0]]]), 1 / 3, 2 / 3)[0, :, 0].round(12)
    array([1.        , 1.33333333, 1.66666667, 2.        ])
    """
    t0, t1 = np.asarray(t0, dtype=np.float64), np.asarray(t1, dtype=np.float64)
    left = split(pieces, t1)[0]
    with np.errstate(invalid="ignore"):
        inner = np.where(t1 > 0.0, t0 / np.where(t1 > 0.0, t1, 1.0), 0.0)
    return split(left, inner)[1]


def distance_to_segment(points: Array, starts: Array, ends: Array) -> Array:
    """Return the distance from points to the segments from `starts` to `ends` (shapes broadcast, last axis d).

    >>> distance_to_segment(np.array([5.0, 1.0]), np.array([0.0, 0.0]), np.array([4.0, 0.0])).round(6)
    np.float64(1.414214)
    """
    chord = ends - starts
    offset = points - starts
    along = np.einsum("...d,...d->...", offset, chord)
    square = np.einsum("...d,...d->...", chord, chord)
    ratio = np.clip(np.divide(along, square, out=np.zeros_like(along), where=square > 0.0), 0.0, 1.0)
    # From the nearer end, so that a point at an end is at distance zero to the last bit.
    near_end = (ratio > 0.5)[..., None]
    gap = np.where(near_end, points - ends - (ratio - 1.0)[..., None] * chord, offset - ratio[..., None] * chord)
    return np.asarray(np.sqrt(np.einsum("...d,...d->...", gap, gap)))


def flatness(pieces: Array) -> Array:
    """Return an upper bound (m,) on how far each piece strays from the segment between its ends.

    The distance to a segment is a convex function, so over the hull of the poles it is largest at a pole.

    >>> flatness(np.array([[[0.0, 0.0], [1.0, 0.5], [2.0, -1.0], [3.0, 0.0]]]))
    array([1.])
    """
    inner = distance_to_segment(pieces[:, 1:3], pieces[:, :1], pieces[:, 3:])
    return np.asarray(inner.max(axis=1))


def lengths(pieces: Array, accuracy: float = 1e-9, progress: Callable[[float], None] | None = None) -> Array:
    """Return the arc length (m,) of each piece.

    The estimated error of the sum is at most `accuracy` times the sum: each piece is integrated whole and as two
    halves (Gauss-Legendre, 12 nodes), and halved again where the two differ or where the piece may stand still or turn
    back (a leg of its control polygon against its chord), which a rule's nodes can miss; but for pieces whose chord and
    control polygon, which bound the length, settle it. The finer value is kept, between these bounds. `progress` is
    called with the part that is done, below 1, once for many pieces.

    >>> lengths(np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]]))
    array([3.])
    """
    total, accuracy = np.zeros(len(pieces)), max(accuracy, _LEAST)
    share = np.linalg.norm(np.diff(pieces, axis=1), axis=2).sum() / max(len(pieces), 1)
    for start in range(0, len(pieces), _CHUNK):
        if progress is not None:
            progress(start / len(pieces))
        active = pieces[start : start + _CHUNK]
        active = active - active[:, :1]  # from each piece's start: an offset would be rounded along
        owner = np.arange(start, start + len(active))
        whole = _quadrature(active)
        for _ in range(60):
            left, right = split(active)
            halves = np.stack([_quadrature(left), _quadrature(right)])
            legs, along = np.diff(active, axis=1), active[:, 3] - active[:, 0]
            polygon = np.linalg.norm(legs, axis=2).sum(axis=1)
            chord = np.linalg.norm(along, axis=1)
            forward = np.all(np.einsum("mld,md->ml", legs, along) >= 0.0, axis=1)
            allowed = 0.5 * accuracy * np.maximum(polygon, share)
            done = np.abs(halves.sum(axis=0) - whole) <= allowed
            done &= forward | (polygon - chord <= allowed)
            np.add.at(total, owner[done], np.clip(halves.sum(axis=0), chord, polygon)[done])
            if done.all():
                break
            active = np.concatenate([left[~done], right[~done]])
            owner = np.tile(owner[~done], 2)
            whole = np.concatenate([halves[0, ~done], halves[1, ~done]])
        else:
            np.add.at(total, owner, whole)
    return total


def _quadrature(pieces: Array) -> Array:
    """Return each piece's length by one 12-node Gauss-Legendre rule."""
    velocity = np.einsum("kg,mkd->mgd", _BASIS, 3.0 * np.diff(pieces, axis=1))
    return np.asarray(np.sqrt(np.einsum("mgd,mgd->mg", velocity, velocity)) @ _WEIGHTS)


def nearest(pieces: Array, points: Array, progress: Callable[[float], None] | None = None) -> tuple[Ints, Array, Array]:
    """Return, for each of `points` (q, d), the nearest place on any of the pieces.

    The result is (piece (q,), t (q,), distance (q,)). Branch and bound: a piece is dropped only when its chord less
    its flatness is farther than a curve point already seen, so no closer place is missed (but for gaps below 1e-12
    of the size, and for points with very many equally near places, as a circle's centre, where the search stops
    after ten halvings and polishes the candidates left). `progress`: as in `lengths`.

    >>> nearest(np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]]), np.array([[1.5, 2.0]]))
    (array([0]), array([0.5]), array([2.]))
    """
    index = np.zeros(len(points), dtype=np.intp)
    t, distance = np.zeros(len(points)), np.zeros(len(points))
    flat = flatness(pieces)
    step = max(1, (1 << 21) // max(len(pieces), 1))
    for start in range(0, len(points), step):
        if progress is not None:
            progress(start / len(points))
        chunk = slice(start, start + step)
        index[chunk], t[chunk], distance[chunk] = _nearest_chunk(pieces, flat, points[chunk])
    return index, t, distance


def _nearest_chunk(pieces: Array, flat: Array, points: Array) -> tuple[Ints, Array, Array]:
    ends = np.concatenate([pieces[:, 0], pieces[-1:, 3]])
    to_ends = np.linalg.norm(points[:, None] - ends, axis=2)
    upper = to_ends.min(axis=1)
    lower = distance_to_segment(points[:, None], pieces[:, 0], pieces[:, 3]) - flat
    gap = 1e-12 * (1e-300 + np.abs(ends).max() + np.abs(points).max())  # rounding must not drop the nearest itself
    query, owner = np.nonzero(lower <= upper[:, None] + gap)
    part, t0, width = pieces[owner], np.zeros(len(owner)), 1.0
    for halving in range(40):
        if halving >= 10 and len(owner) > 64 * len(points):
            break
        left, right = split(part)
        middle = np.linalg.norm(left[:, 3] - points[query], axis=1)
        np.minimum.at(upper, query, middle)
        width *= 0.5
        part = np.concatenate([left, right])
        t0 = np.concatenate([t0, t0 + width])
        query, owner = np.tile(query, 2), np.tile(owner, 2)
        lower = distance_to_segment(points[query], part[:, 0], part[:, 3]) - flatness(part)
        keep = lower <= upper[query] + gap
        part, t0, query, owner = part[keep], t0[keep], query[keep], owner[keep]
        if np.all(upper[query] - lower[keep] <= gap):
            break
    return _polish(pieces, points, query, owner, t0, width)


def _polish(
    pieces: Array, points: Array, query: Ints, owner: Ints, t0: Array, width: float
) -> tuple[Ints, Array, Array]:
    """Newton from the middle of each candidate interval; keep the best place for each query, ends included."""
    mine, target = pieces[owner], points[query]
    t = t0 + 0.5 * width
    places = [t0, t0 + width, t]
    first, second = 3.0 * np.diff(mine, axis=1), 6.0 * np.diff(mine, n=2, axis=1)
    for _ in range(6):
        gap = evaluate(mine, t) - target
        tt = t[:, None]
        velocity = (1 - tt) ** 2 * first[:, 0] + 2 * tt * (1 - tt) * first[:, 1] + tt**2 * first[:, 2]
        bend = (1 - tt) * second[:, 0] + tt * second[:, 1]
        slope = np.einsum("md,md->m", gap, velocity)
        rate = np.einsum("md,md->m", velocity, velocity) + np.einsum("md,md->m", gap, bend)
        t = np.clip(t - np.divide(slope, rate, out=np.zeros_like(t), where=rate > 0.0), 0.0, 1.0)
        places.append(t)
    place = np.stack(places)
    distance = np.stack([np.linalg.norm(evaluate(mine, p) - target, axis=1) for p in place])
    best = distance.argmin(axis=0)
    column = np.arange(len(best))
    t, near = place[best, column], distance[best, column]
    order = np.lexsort((near, query))
    first_of = order[np.unique(query[order], return_index=True)[1]]
    return owner[first_of], t[first_of], near[first_of]
