"""A path as a chain of cubic parts with bounds on each: how long, how bent, where the tangent breaks.

Everything is decided from bounds that hold over a whole part. With q the hodograph (a quadratic Bézier with poles D0,
D1, D2, a third of the velocity), q x q' is a quadratic Bézier too, with poles 2 D0 x D1, D0 x D2 and 2 D1 x D2, so it
is bounded by its poles; and |q| is at least its smallest component along a direction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.sweeping.cubics import SLOW, first_moving, norms
from cadfit.sweeping.frames import SMOOTH

_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])  # the axes after and before x, y and z
_TINY = 1e-100  # in place of zero under a fraction; its cube is a number still


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Cubic parts of a path, m of them, with upper bounds on each one's length and curvature.

    `origins` (3, m) is where they start; `legs` (leg, axis, part), (3, 3, m), lead from Bézier pole to pole. Part k
    runs over the parameters from `starts[k]` to `starts[k] + widths[k]`. A curvature is infinite where the part may
    stand still. A k-th of a part has a bound on the length of at most a k-th, and on the curvature no larger.
    """

    origins: Array
    legs: Array
    starts: Array
    widths: Array
    lengths: Array
    curvatures: Array

    def __len__(self) -> int:
        return len(self.starts)

    def __getitem__(self, which: Ints | NDArray[np.bool_]) -> Chain:
        return Chain(*(getattr(self, name)[..., which] for name in self.__slots__))


def chain(path: BSpline) -> Chain:
    """Return the parts of a path in three dimensions, one a knot span, but for the spans that are one point.

    Raises ValueError for a path that never moves.

    >>> len(chain(BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])))
    1
    """
    widths = path.knots[1:] - path.knots[:-1]
    spans = np.flatnonzero(widths)
    poles = path.pieces_of(spans).transpose(1, 2, 0)
    whole = _bounded(poles[0], poles[1:] - poles[:-1], path.knots[spans], widths[spans])
    longest = whole.lengths.max()
    if longest == 0.0:
        raise ValueError("the path never moves: all its poles are one point")
    moves = whole.lengths > 1e-12 * longest
    return whole if moves.all() else whole[moves]


def tightest(whole: Chain, limit: float) -> tuple[float, float]:
    """Return the parameter and the radius of a path's tightest bend, (nan, inf) where none is as tight as `limit`.

    Branch and bound over the parts; the radius is right to 0.1 %, and 0.0 at a cusp inside a part.

    >>> straight = BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> tightest(chain(straight), 5.0)
    (nan, inf)
    """
    where, sharpest = np.nan, (1.0 - 1e-9) / limit
    todo = whole
    while (candidates := todo.curvatures > 1.001 * sharpest).any():
        todo = todo[candidates]
        tiny = todo.lengths <= 1e-9 * whole.lengths.max()
        if tiny.any():
            return float(todo.starts[tiny][0]), 0.0
        bends = end_bends(todo)
        if bends.max() >= sharpest:
            end, part = np.unravel_index(bends.argmax(), bends.shape)
            where, sharpest = float(todo.starts[part] + end * todo.widths[part]), float(bends[end, part])
        todo = cut(todo, np.full(len(todo), 2))
    return where, (np.inf if np.isnan(where) else 1.0 / sharpest)


def breaks(path: BSpline, whole: Chain) -> tuple[Array, Array]:
    """Return the parameters and the angles (radians) of the joints where a path's tangent breaks, the seam's too.

    At a triple knot that is a corner; elsewhere the path has come to rest there and turns on the spot, a cusp. `whole`
    is the path's chain.

    >>> bent = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [3, 1, 0], [3, 2, 0], [3, 3, 0]]
    >>> path = BSpline(bent, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2])
    >>> breaks(path, chain(path))
    (array([1.]), array([1.57079633]))
    """
    closed, handles = path.closed, _dots(whole.legs[::2], whole.legs[::2])
    if not closed and handles.min() > SLOW * handles.max() and (path.knots[6:-4] > path.knots[4:-6]).all():
        return np.empty(0), np.empty(0)  # without a triple knot, and at rest nowhere
    first, _, last = whole.legs
    following = np.concatenate([first[:, 1:], first[:, :1]], axis=1)
    cosines = _dots(last, following)
    # cos |cos|, times the squares of the lengths, tells which joints to look at closely: all but a few are smooth.
    squares = _dots(last, last) * _dots(following, following)
    squares *= 1.0 - 0.25 * SMOOTH**2
    suspect = cosines * np.abs(cosines) <= squares
    suspect[-1] &= closed
    if not suspect.any():
        return np.empty(0), np.empty(0)
    at = np.flatnonzero(suspect)
    before, after = whole.legs[:, :, at], whole.legs[:, :, (at + 1) % len(whole)]
    arriving = first_moving(before[2], before[2] + before[1], before.sum(axis=0))
    leaving = first_moving(after[0], after[0] + after[1], after.sum(axis=0))
    angles = np.arctan2(norms(_cross(arriving, leaving)), _dots(arriving, leaving))
    broken = angles > SMOOTH
    return (whole.starts[at] + whole.widths[at])[broken], angles[broken]


def cut(parts: Chain, counts: Ints) -> Chain:
    """Return every part in so many of equal width."""
    owner, t = shared(counts)
    share = 1.0 / counts[owner]
    # The polar form of the hodograph at (t, t), (t, t + share) and (t + share, t + share); with (0, 0) and (0, t) it
    # gives the way to t as well.
    legs = parts.legs[:, :, owner]
    rise = legs[1:] - legs[:-1]
    here, there = legs[:-1] + t * rise, legs[:-1] + (t + share) * rise
    slope = here[1] - here[0]
    leaving = here[0] + t * slope
    arriving = there[0] + (t + share) * (there[1] - there[0])
    origins = parts.origins[:, owner] + t * (legs[0] + here[0] + leaving)
    widths = parts.widths[owner]
    inner = np.stack([leaving, leaving + share * slope, arriving])
    return _bounded(origins, share * inner, parts.starts[owner] + t * widths, share * widths)


def shared(counts: Ints, ends: int = 0) -> tuple[Ints, Array]:
    """Return the part, and the fraction of it, at which each one begins when every part is cut into so many.

    With `ends` = 1 the end of the last one comes after these.

    >>> shared(np.array([1, 2]), ends=1)
    (array([0, 1, 1, 1]), array([0. , 0. , 0.5, 1. ]))
    """
    repeats = counts.copy()
    repeats[-1] += ends
    owner = np.repeat(np.arange(len(counts)), repeats)
    within = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    return owner, within / counts[owner]


def end_bends(parts: Chain) -> Array:
    """Return the curvatures (2, m) at the start and the end of every part, zero where it stands still."""
    ends = parts.legs[::2]
    speeds = np.sqrt(_dots(ends, ends))
    crossed = _cross(parts.legs[:2], parts.legs[1:])
    turning = np.sqrt(_dots(crossed, crossed))
    moving = speeds > SLOW * speeds.max()
    speeds[~moving] = 1.0
    return np.where(moving, 2.0 / 3.0 * turning / (speeds * speeds * speeds), 0.0)


def _bounded(origins: Array, legs: Array, starts: Array, widths: Array) -> Chain:
    """Return these parts with the bounds on their lengths and curvatures."""
    longest = np.sqrt(_dots(legs, legs).max(axis=0))
    crossed = _cross(legs.take([0, 0, 1], axis=0), legs.take([1, 2, 2], axis=0))
    crossed[::2] *= 2.0
    turning = np.sqrt(_dots(crossed, crossed).max(axis=0))
    along = _dots(legs, legs.sum(axis=0))
    slowest = along.min(axis=0) / np.sqrt(along.sum(axis=0) + _TINY * _TINY)  # a sum of squares
    speeds = np.maximum(slowest, 1e-3 * longest + _TINY)
    curvatures = turning / (3.0 * speeds * speeds * speeds)
    slow = slowest <= 1e-3 * longest
    if slow.any():
        # Straight up to rounding, and never back, is straight, even where it starts from rest.
        straight = (turning <= 1e-14 * longest**2) & (slowest >= -1e-14 * longest)
        curvatures[slow] = np.where(straight, 0.0, np.inf)[slow]
    return Chain(origins, legs, starts, widths, 3.0 * longest, curvatures)


def _dots(a: Array, b: Array) -> Array:
    """Return the dot products (..., n) of vectors (..., 3, n)."""
    return np.asarray(np.einsum("...dn,...dn->...n", a, b))


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products (..., 3, n) of vectors (..., 3, n)."""
    a_next, b_next = a.take(_NEXT, axis=-2), b.take(_NEXT, axis=-2)
    a_last, b_last = a.take(_LAST, axis=-2), b.take(_LAST, axis=-2)
    return np.asarray(a_next * b_last - a_last * b_next)
