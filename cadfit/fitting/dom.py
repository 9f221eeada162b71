"""Least squares with knots from dominant points: Park and Lee's DOM, to compare with."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline as ScipySpline
from scipy.sparse.linalg import spsolve

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.dominant import turn_angles
from cadfit.points.clean import as_points
from cadfit.points.parametrize import Parametrization, parametrize

_BEND = 0.5  # the share of curvature in the shape index; the rest is length


def dom(points: ArrayLike, poles: int, parametrization: Parametrization = "chord") -> BSpline:
    """Return the least-squares cubic spline of an open curve whose knots follow dominant points, refined adaptively.

    `points` (n, d), neighbours distinct. `poles`: 4 to n, as many as dominant points. The parameters are those of
    `parametrize`. Dominant points are at first the ends and the local maxima of curvature that stand above the mean
    (the largest of them, if there are too many). Knots are averages of three neighbouring dominant points' parameters,
    and the poles are found by least squares on all points, the ends kept. Then, until there are enough, one is added
    where a point is farthest from the curve at its parameter: where it halves, as well as any, the bend and the length
    between the two dominant points around.

    Raises ValueError for bad points or equal neighbours (naming the row) and a number of poles out of range.
    Source: Park and Lee, B-spline curve fitting based on adaptive curve refinement using dominant points, CAD 39(6),
    2007; curvature is taken here from turn angles instead of from a first fit, the shape index with equal shares.

    >>> t = np.linspace(0, 3, 60)
    >>> wave = np.column_stack([t, np.sin(t * t)])
    >>> curve = dom(wave, 20)
    >>> len(curve.poles), curve(curve.domain[1]).round(6)
    (20, array([3.      , 0.412118]))
    """
    given = as_points(points, 4)
    n = len(given)
    if poles not in range(4, n + 1):
        raise ValueError(f"the number of poles must be a whole number from 4 to {n}, that of points, not {poles}")
    poles = int(poles)
    u = parametrize(given, parametrization)
    angles = turn_angles(given)
    curvature = angles / np.maximum(np.gradient(u), np.finfo(np.float64).tiny)
    index = _shape_index(angles, u)
    dominant = _seeds(curvature, poles)
    curve = _least_squares(given, u, dominant) if len(dominant) >= 4 else None
    while curve is None or len(dominant) < poles:
        gaps = np.linalg.norm((given if curve is None else curve(u)) - given, axis=1)
        dominant = _refined(dominant, gaps, index)
        curve = _least_squares(given, u, dominant) if len(dominant) >= 4 else None
    return curve


def _seeds(curvature: Array, most: int) -> Ints:
    """Return the ends, and the local maxima of curvature above its mean: the largest, if there are too many."""
    inner = curvature[1:-1]
    peak = (inner >= curvature[:-2]) & (inner > curvature[2:]) & (inner > curvature.mean())
    rows = np.flatnonzero(peak) + 1
    rows = rows[np.argsort(-curvature[rows], kind="stable")[: most - 2]]
    return np.concatenate([[0], np.sort(rows), [len(curvature) - 1]])


def _shape_index(angles: Array, u: Array) -> Array:
    """Return how much of the whole shape lies up to each point (n,): shares of the bend and of the length."""
    bend = np.cumsum(angles)
    bend = bend / bend[-1] if bend[-1] > 0.0 else u / u[-1]
    return np.asarray(_BEND * bend + (1.0 - _BEND) * u / u[-1])


def _refined(dominant: Ints, gaps: Array, index: Array) -> Ints:
    """Return the dominant points with one more, in the segment of the largest gap that has a point to spare."""
    largest = np.maximum.reduceat(gaps, dominant[:-1])
    largest[np.diff(dominant) < 2] = -1.0
    k = int(np.argmax(largest if largest.max() > 0.0 else np.diff(dominant)))
    left, right = int(dominant[k]), int(dominant[k + 1])
    inner = index[left + 1 : right]
    middle = left + 1 + int(np.argmin(np.abs(2.0 * inner - index[left] - index[right])))
    return np.insert(dominant, k + 1, middle)


def _least_squares(points: Array, u: Array, dominant: Ints) -> BSpline:
    """Return the spline whose inner knots average the parameters of three dominant points, ends kept."""
    at = u[dominant]
    knots = np.concatenate([[at[0]] * 4, (at[1:-3] + at[2:-2] + at[3:-1]) / 3.0, [at[-1]] * 4])
    basis = ScipySpline.design_matrix(u, knots, 3).tocsc()
    poles = np.empty((len(dominant), points.shape[1]))
    poles[[0, -1]] = points[[0, -1]]
    inner = basis[:, 1:-1]
    rest = points - basis[:, [0, -1]] @ poles[[0, -1]]
    poles[1:-1] = np.asarray(spsolve((inner.T @ inner).tocsc(), inner.T @ rest)).reshape(-1, points.shape[1])
    return BSpline(own(poles), own(knots))
