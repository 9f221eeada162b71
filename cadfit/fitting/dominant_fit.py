"""The C2 spline through the dominant points, certified against all points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline, own
from cadfit.fitting.cardinal import cardinal_spline
from cadfit.fitting.deviation import deviation_at
from cadfit.fitting.dominant import Method, dominant_points
from cadfit.fitting.matching import match
from cadfit.fitting.result import Fit, written
from cadfit.points.clean import check_largest, check_size, clean
from cadfit.stages import Progress, stage


def fit_dominant(
    points: ArrayLike,
    count: int | None = None,
    fraction: float | None = None,
    square_error: float | None = None,
    *,
    closed: bool | None = None,
    method: Method = "best",
    curvature: float = 1.0,
    progress: Progress | None = None,
) -> Fit:
    """Return the C2 spline through the dominant points of ordered points, with its certified deviation from all points.

    `points` (n, d); consecutive repeats are dropped and counted. One of `count`, `fraction` and `square_error` (in the
    square of the points' unit) says how many points are dominant, and `method` how they are found, as in
    `dominant_points`. `closed`: whether the curve returns to its first point, C2 across the seam; None: when the last
    point repeats the first. A closed curve starts at its first dominant point. `curvature`: as in `cardinal_spline`; 0
    is the paper's curve, flat at every dominant point. `progress`: as in `dominant_points`.

    Use this to thin points to a share, or to a sum of squares, with a curve that meets those kept exactly and follows a
    moved one only nearby. It has about 3 poles a dominant point. Where a distance is to be kept to, or poles are to be
    few, use `cadfit.fit`: it promises a tolerance, and takes a fraction of the poles.

    Raises ValueError as `dominant_points`, and for points too small or too large to square.
    Source: the paper, sections 2.3 and 2.7.

    >>> t = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    >>> found = fit_dominant(np.column_stack([np.cos(t), np.sin(t)]), fraction=0.2, closed=True)
    >>> len(found.spline.poles), found.deviation.points < 5e-3
    (63, True)
    """
    cleaned = clean(points, closed)
    given = cleaned.points
    check_size(given)
    with stage("choosing dominant points"):
        rows = dominant_points(given, count, fraction, square_error, cleaned.closed, method, progress).indices
    chosen = given[rows]
    start = 0
    if cleaned.closed:  # not where two dominant points are equal: the seam would take them for one
        start = int(np.argmax(np.any(chosen != np.roll(chosen, 1, axis=0), axis=1)))
    spline = cardinal_spline(np.roll(chosen, -start, axis=0), curvature=curvature, closed=cleaned.closed)
    check_largest(spline.poles)  # by a huge curvature
    u = _places(spline, given, int(rows[start]), cleaned.closed)
    found = deviation_at([spline], given, u, cleaned.closed)
    none = np.zeros(0, dtype=np.intp)
    asked = {"count": count, "fraction": fraction, "square_error": square_error, "closed": closed}
    call = written(
        "fit_dominant",
        **{name: value for name, value in asked.items() if value is not None},
        **{"method": method} if method != "best" else {},
        **{"curvature": curvature} if curvature != 1.0 else {},
    )
    kept, places = own(given.copy()), own(u)
    return Fit((spline,), found, None, cleaned.closed, kept, places, none, cleaned.dropped, None, call)


def _places(spline: BSpline, points: Array, start: int, closed: bool) -> Array:
    """Return the parameters (n,) of the points; where closed, the curve starts at the point in row `start`."""
    if not closed:
        return match(spline, points)[0]
    around = np.roll(points, -start, axis=0)
    u, _ = match(spline, np.concatenate([around, around[:1]]))
    u = np.concatenate([spline.domain[:1], u[1:-1]])
    return np.roll(u, start)
