"""The global C2 interpolant, the yardstick users know."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.joining import periodic
from cadfit.numbers import as_numbers
from cadfit.points.clean import as_contour
from cadfit.points.parametrize import Parametrization, parameters_of


def interpolate(
    points: ArrayLike,
    parametrization: Parametrization = "centripetal",
    closed: bool = False,
    end_tangents: ArrayLike | None = None,
) -> BSpline:
    """Return the C2 cubic spline through the points with a knot at each, from one linear system.

    `points` (n, d), at least 2 (closed: 3), neighbours distinct. Open curves are natural (second derivative zero at
    the ends), or clamped to the directions `end_tangents` (2, d), of any length: the speed is that of the first and the
    last chord. Closed curves are periodic, C2 across the seam; the first point may be repeated at the end or not.
    Every point moves the whole curve, though ever less with distance: `local_spline` is the local one. Point k lies at
    the parameter `parametrize(points, parametrization, closed)[k]`.

    Raises ValueError naming the row for bad points or equal neighbours, for `end_tangents` on a closed curve, of a
    wrong shape or of length zero. Source: de Boor, A Practical Guide to Splines, chapter IV.

    >>> s = interpolate([[0, 0], [3, 4], [6, 0]], end_tangents=[[0, 1], [0, -1]])
    >>> s(5.0), s.derivative(0.0)
    (array([3., 4.]), array([0., 1.]))
    """
    given = as_contour(points, closed)
    u = parameters_of(given, parametrization, closed)
    origin = given.mean(axis=0)  # far from zero, the system's rounding would show
    centred = given - origin
    if closed:
        if end_tangents is not None:
            raise ValueError("a closed curve has no ends: leave end_tangents out")
        return _periodic_interpolant(centred, u).transformed(np.eye(given.shape[1]), origin)
    if end_tangents is None and len(given) == 2:  # scipy needs three rows for natural ends; of two it is the segment
        return BSpline(given[0] + np.linspace(0, 1, 4)[:, None] * (given[1] - given[0]), np.repeat(u, 4))
    ends: Any = "natural"  # scipy's stubs know numbers only
    step = u[-1] / (len(u) - 1)  # steps near 1: the system has rows of derivatives beside rows of values
    if end_tangents is not None:
        velocities = step * _end_velocities(given, u, end_tangents)
        ends = ([(1, velocities[0])], [(1, velocities[1])])
    found = make_interp_spline(u / step, centred, k=3, bc_type=ends)
    return BSpline(found.c + origin, np.concatenate([u[[0, 0, 0]], u, u[[-1, -1, -1]]]))


def _periodic_interpolant(points: Array, u: Array) -> BSpline:
    found = make_interp_spline(u, np.concatenate([points, points[:1]]), k=3, bc_type="periodic")
    # scipy's periodic knots run on beyond the period; its pole j is centred on knot j + 2, the period starts at knot 3.
    return periodic(found.c[1 : len(points) + 1], found.t[3:-3])


def _end_velocities(points: Array, u: Array, end_tangents: ArrayLike) -> Array:
    directions = as_numbers(end_tangents, "end tangents")
    if directions.shape != (2, points.shape[1]) or not np.isfinite(directions).all():
        raise ValueError(f"end_tangents must be two finite directions, shape (2, {points.shape[1]})")
    largest = np.abs(directions).max(axis=1, keepdims=True)
    if not largest.all():
        raise ValueError(f"end_tangents must not be zero: {directions.tolist()}")
    directions = directions / largest  # of any length: squares would be zero, or no numbers
    sizes = np.linalg.norm(directions, axis=1)
    chords = np.linalg.norm([points[1] - points[0], points[-1] - points[-2]], axis=1)
    speeds = chords / np.array([u[1] - u[0], u[-1] - u[-2]])
    return np.asarray(directions * (speeds / sizes)[:, None])
