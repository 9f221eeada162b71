"""A smooth stretch of a path as cubic pieces, in the coefficients that controllers with splines take."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.fitting.approximate import fit, smallest_tolerance
from cadfit.fitting.deviation import deviation_at

Rounding = Callable[[Array, Array, bool], Array]  # poles (4, d) meant, the start (d,) there is, whether the end is kept

_ROOM = 0.9  # of the tolerance, for the fit: rounding takes some


def cubics(points: Array, tolerance: float, written: Rounding, exact: bool) -> tuple[Array, float] | None:
    """Return the poles (m, 4, d) of cubic pieces along a smooth path (n, d), as they are written, and their deviation.

    The fit is C2 before it is rounded; what is returned is certified after. `exact`: the end is not rounded. None where
    there are not fewer pieces than the path has chords, or where they do not keep the tolerance.
    """
    n = len(points)
    if n < 4 or tolerance * _ROOM < smallest_tolerance(points):
        return None
    try:
        found = fit(points, _ROOM * tolerance, closed=False, corners=None, between="polyline", effort="fast")
    except ValueError:
        return None  # it cannot be held
    spline = found.spline
    meant = spline.pieces()
    if len(meant) >= n - 1:
        return None
    poles = np.empty_like(meant)
    start = points[0]
    for k, piece in enumerate(meant):
        poles[k] = written(piece, start, exact and k == len(meant) - 1)
        start = poles[k, 3]
    chain = BSpline(np.concatenate([poles[0, :1], poles[:, 1:].reshape(-1, points.shape[1])]), _triple(spline))
    far = deviation_at([chain], points, found.parameters, closed=False)
    worst = max(far.points, far.between)
    return (poles, worst) if worst <= tolerance else None


def _triple(spline: BSpline) -> Array:
    knots = spline.distinct_knots
    return np.concatenate([knots[:1], np.repeat(knots, 3), knots[-1:]])


def control_points(decimals: int) -> Rounding:
    """Return how G5 rounds: the control points as offsets from the start and from the end.

    Source: LinuxCNC, G-codes, G5 cubic spline.
    """

    def written(poles: Array, start: Array, keep_end: bool) -> Array:
        end = poles[3] if keep_end else np.round(poles[3], decimals)
        leaving, arriving = np.round(poles[1] - start, decimals), np.round(poles[2] - end, decimals)
        return np.stack([start, start + leaving, end + arriving, end])

    return written


def polynomials(decimals: int) -> Rounding:
    """Return how POLY rounds: the end and the coefficients of p squared and cubed, p from 0 to 1.

    The coefficient of p is what brings the piece to its end. Source: SINUMERIK 840D sl Job Planning, 03/2013, 4.5.
    """

    def written(poles: Array, start: Array, keep_end: bool) -> Array:
        end = poles[3] if keep_end else np.round(poles[3], decimals)
        square, cube = coefficients(np.stack([start, poles[1], poles[2], end]))
        square, cube = np.round(square, decimals), np.round(cube, decimals)
        first = start + (end - start - square - cube) / 3.0
        return np.stack([start, first, 2.0 * first - start + square / 3.0, end])

    return written


def ends(decimals: int) -> Rounding:
    """Return how SPL rounds: the ends; its coefficients have eight decimals, which is next to nothing."""

    def written(poles: Array, start: Array, keep_end: bool) -> Array:
        end = poles[3] if keep_end else np.round(poles[3], decimals)
        return np.stack([start, poles[1], poles[2], end])

    return written


def coefficients(poles: Array) -> tuple[Array, Array]:
    """Return the coefficients (d,) of the parameter's square and cube, of a cubic piece with poles (4, d).

    >>> coefficients(np.array([[0.0], [0.0], [0.0], [5.0]]))
    (array([0.]), array([5.]))
    """
    a, b, c, d = poles
    return 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)
