"""Splines made of parts: curves joined end to end, polylines, closed curves from one period."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.numbers import as_numbers, check_finite

_LONG = 1e2  # times the shorter of two spans: a pole there moves by so many of its last bits, at most


class HasCurves(Protocol):
    """What carries splines that follow each other: a `cadfit.Fit`, or `cadfit.Curves`."""

    @property
    def curves(self) -> tuple[BSpline, ...]:
        """The splines."""


Splines: TypeAlias = BSpline | HasCurves | Sequence[BSpline]
"""One spline, a fit, or splines that follow each other end to end."""


def splines_of(curves: Splines) -> tuple[BSpline, ...]:
    """Return the splines that follow each other: the one, those of a fit, or the several.

    Raises ValueError where there is none, or something else.

    >>> line = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> splines_of(line) == splines_of([line]) == (line,)
    True
    """
    given: Any = getattr(curves, "curves", curves)
    found: tuple[BSpline, ...] = tuple(given) if isinstance(given, Iterable) else (given,)
    if not found:
        raise ValueError("at least one curve is needed")
    for curve in found:
        if not isinstance(curve, BSpline):
            raise ValueError(f"a curve must be a cadfit.BSpline or a cadfit.Fit, not {curve!r:.80}")
    return found


def join(curves: Splines, tolerance: float = 1e-9) -> BSpline:
    """Return curves that follow each other end to end as one B-spline, with a triple knot at each joint.

    `curves`: splines, or the `Fit` that has them.
    The parameters run on from the first curve's. An end may miss the next start by `tolerance` times the size of
    the largest curve; the later curve's pole is kept. `split` at the joints gives the curves back.

    Raises ValueError for no curves, what is no curve, different dimensions, and naming the joint that is open and by
    how much.

    >>> line = BSpline([[0.0], [1.0], [2.0], [3.0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> join([line, line.transformed([[2.0]], 3.0)])
    BSpline(7 poles in 1D, 2 spans, u in [0.0, 2.0])
    """
    curves = splines_of(curves)
    if len(curves) == 1:
        return curves[0]
    dimensions = [curve.poles.shape[1] for curve in curves]
    if len(set(dimensions)) > 1:
        raise ValueError(f"the curves have different dimensions: {dimensions}")
    size = max(curve.size for curve in curves)
    end = curves[0].domain[0]
    knots, poles = [np.full(4, end)], []
    for k, curve in enumerate(curves):
        if k:
            gap = float(np.linalg.norm(curve.poles[0] - curves[k - 1].poles[-1]))
            if gap > tolerance * size:
                raise ValueError(f"curve {k} starts {gap:.6g} away from the end of curve {k - 1}")
        shifted = curve.knots - curve.domain[0] + end
        end = shifted[-1]
        knots.append(shifted[4:-1])
        poles.append(curve.poles[:-1])
    return BSpline(np.concatenate([*poles, curves[-1].poles[-1:]]), np.append(np.concatenate(knots), end))


def polyline(points: ArrayLike, closed: bool = False) -> BSpline:
    """Return the straight lines from point to point (n, d) as one B-spline, its parameter the length, corners and all.

    With `closed` the last point is joined to the first, unless it repeats it.

    Raises ValueError for fewer than 2 points, what is not finite, and a point that repeats the one before it.

    >>> polyline([[0, 0], [3, 0], [3, 4]])
    BSpline(7 poles in 2D, 2 spans, u in [0.0, 7.0])
    """
    points = as_numbers(points, "points")
    if points.ndim != 2 or len(points) < 2:
        raise ValueError(f"points must have the shape (n >= 2, d), not {points.shape}")
    check_finite(points, "points")
    if closed and not np.array_equal(points[0], points[-1]):
        points = np.concatenate([points, points[:1]])
    steps = points[1:] - points[:-1]
    lengths = np.linalg.norm(steps, axis=1)
    if not lengths.all():
        row = int(np.argmin(lengths)) + 1
        raise ValueError(f"row {row} of the points repeats the row before it: {points[row].tolist()}")
    poles = np.concatenate(
        [(points[:-1, None] + steps[:, None] * [[0.0], [1 / 3], [2 / 3]]).reshape(-1, points.shape[1]), points[-1:]]
    )
    joints = np.concatenate([[0.0], np.cumsum(lengths)])
    return BSpline(poles, np.concatenate([joints[:1], np.repeat(joints, 3), joints[-1:]]))


def periodic(poles: ArrayLike, knots: ArrayLike) -> BSpline:
    """Return the closed C2 spline of periodic control points, clamped at the period's ends.

    `poles` (n, d): control point j is the polar value at knots j - 1, j, j + 1 of the period, so on uniform knots it
    pulls at knots[j]; `knots` (n + 1,), rising strictly, from the period's start to its end. n is 3 or more. The
    shape is not changed by the clamping (knot insertion); the last pole is the first, to the last bit.

    >>> square = periodic([[0, 0], [6, 0], [6, 6], [0, 6]], [0, 1, 2, 3, 4])
    >>> square(0.0), square.closed
    (array([1., 1.]), True)
    """
    poles, knots = as_numbers(poles, "poles"), as_numbers(knots, "knots")
    if poles.ndim != 2:
        raise ValueError(f"poles must have the shape (n, d), not {poles.shape}")
    if not np.isfinite(poles).all() or not np.isfinite(knots).all():
        raise ValueError("poles and knots must be finite")
    n = len(poles)
    if n < 3 or knots.shape != (n + 1,) or np.any(np.diff(knots) <= 0):
        raise ValueError(f"{n} periodic poles (3 or more) need {n + 1} knots that rise")
    period = knots[-1] - knots[0]
    steps = np.arange(-2, n + 3)
    t = knots[steps % n] + period * (steps // n)  # t[j + 2] is knot j
    start = _polar(poles[np.array([-1, 0, 1, 2]) % n], t[:6])
    end = _polar(poles[np.array([-1, 0, 1, 2]) % n], t[:6] + period)
    a, b = knots[0], knots[-1]
    head = [start(a, a, a), start(a, a, t[3]), start(a, t[3], t[4])]
    tail = [end(t[n], t[n + 1], b), end(t[n + 1], b, b), head[0]]
    clamped = np.concatenate([head, poles[2 : n - 1], tail]) if n > 3 else np.array(head + tail)
    bend = _second_at_seam(poles, t)
    clamped[:3] = _bent(clamped[:3], t[3] - a, t[4] - a, bend)
    clamped[:-4:-1] = _bent(clamped[:-4:-1], a - t[1], a - t[0], bend)
    return BSpline(clamped, np.concatenate([[a] * 3, knots, [b] * 3]))


def _second_at_seam(poles: Array, t: Array) -> Array:
    """Return the second derivative at t[2] of periodic poles, as the poles themselves have it: nothing cancels."""
    before, after = (poles[0] - poles[-1]) / (t[3] - t[0]), (poles[1] - poles[0]) / (t[4] - t[1])
    return np.asarray(6.0 * (after - before) / (t[3] - t[1]))


def _bent(three: Array, h: float, both: float, bend: Array) -> Array:
    """Return the poles (3, d) next to a clamped end, the third set for the second derivative `bend` there.

    On a short span h the last bit of the second pole changes that by more than the last bit of the third can. Where it
    is so much shorter than `both` spans that the third would move visibly, it stays.
    """
    end, near, third = three
    if both < _LONG * h:
        third = near + both * ((near - end) / h + bend * h / 6.0)
    return np.array([end, near, third])


def _polar(four: Array, t: Array) -> Callable[[float, float, float], Array]:
    """Return the polar form of the span between t[2] and t[3], given its four poles and six knots."""

    def value(*x: float) -> Array:
        level = four
        for r in range(3):
            low, high = t[r:3], t[3 : 6 - r]
            ratio = ((x[r] - low) / (high - low))[:, None]
            level = level[:-1] + ratio * np.diff(level, axis=0)
        return np.asarray(level[0])

    return value
