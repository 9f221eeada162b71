"""Fit within a tolerance: split at corners, the fewest spans found for each stretch, and all of it certified."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.apart import corners_apart, fit_apart, nearness
from cadfit.fitting.deviation import deviation_at
from cadfit.fitting.result import Fit, written
from cadfit.numbers import as_number, as_numbers, rounded_up
from cadfit.points.clean import LARGEST, check_size, clean
from cadfit.points.corners import find_corners
from cadfit.stages import Progress, portion, rising, stage

Between = Literal["curve", "polyline"]
Effort = Literal["fast", "best"]
Corners = Literal["auto"] | float | ArrayLike | None
EndTangents: TypeAlias = Iterable[ArrayLike | None]

_POLYLINE_CORNER = float(np.radians(35.0))  # a vertex of the shape need not stand out from its neighbours
_EPS = float(np.finfo(np.float64).eps)


def fit(
    points: ArrayLike,
    tolerance: float,
    *,
    closed: bool | None = None,
    corners: Corners = "auto",
    between: Between = "curve",
    effort: Effort = "best",
    weights: ArrayLike | None = None,
    end_tangents: EndTangents | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Return C2 cubic B-splines within `tolerance` of ordered points, certified, with as few poles as were found.

    `points` (n, d), d >= 1; consecutive repeats are dropped and counted. `tolerance`: a length, in the points' unit;
    every point lies within it of the curve, matched in order. `between`: what holds between two neighbouring points.
    "curve": the points are samples; the curve strays from their chord by no more than the tolerance and 1.5 times what
    the centripetal cardinal curve through the points does there. "polyline": the points are the vertices of the shape;
    the curve strays from the chord by no more than the tolerance. Both are certified by bounds, not by samples.

    `closed`: whether the curve returns to its first point, C2 across the seam; None: when the last point repeats the
    first. `corners`: where one curve ends and the next begins, each such point being kept exactly: "auto"
    (`cadfit.find_corners`), the least angle in radians that is one, rows of `points`, or None. Open ends are kept
    exactly, too. `effort`: "fast", or "best" for fewer poles in some six times the time. `weights` (n,): how much each
    point counts in the least squares; the tolerance holds for all. `end_tangents` (2, d): directions at open ends, None
    in place of one that is free.
    `progress` is called with the part that is done, from 0 to 1; raising from it stops the fit.

    Raises ValueError for bad points (naming the row), a tolerance that is not positive or that float64 cannot hold at
    these coordinates (naming the least that it can), points too small or too large to square, arguments that do not
    fit, and where no curve is found that is certain to hold.
    Source: ours; knot moves after Jupp, Approximation to data by splines with free knots, SIAM J. Numer. Anal. 15,
    1978; tangent distance after Blake and Isard, Active Contours, 1998.

    >>> t = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    >>> circle = fit(10 * np.column_stack([np.cos(t), np.sin(t)]), 0.01, closed=True)
    >>> len(circle.spline.poles) <= 11, circle.deviation.points <= 0.01, circle.spline.closed
    (True, True, True)
    """
    check_choices(between, effort)
    with stage("cleaning the points"):
        cleaned = clean(points, closed)
    given = cleaned.points
    check_size(given)
    least = smallest_tolerance(given)
    if not as_number(tolerance, "tolerance") >= least:
        raise ValueError(f"the tolerance must be at least {rounded_up(least)} for points of this size, not {tolerance}")
    if not tolerance < LARGEST:
        raise ValueError(f"the tolerance must be below {LARGEST:g}, not {tolerance}")
    weight = _weights(weights, len(np.asarray(points)))[cleaned.kept]
    tangents = _tangents(end_tangents, given, cleaned.closed)
    with stage("finding corners"):
        at = _corners(corners, given, tolerance, cleaned.closed, between == "polyline", cleaned.kept)
        near = nearness(given, tolerance)
        at = corners_apart(at, stretches(len(given), at, cleaned.closed), given, near, cleaned.closed)
    parts = stretches(len(given), at, cleaned.closed)
    smooth, polyline, best = cleaned.closed and not len(at), between == "polyline", effort == "best"
    heard = rising(progress)
    curves, parameters, start = [], np.zeros(len(given)), 0.0
    for k, rows in enumerate(parts):
        ends = (tangents[0] if k == 0 else None, tangents[1] if k == len(parts) - 1 else None)
        part_done = portion(heard, k / len(parts), (k + 1) / len(parts))
        curve, u = fit_apart(given[rows], tolerance, near, smooth, polyline, best, weight[rows], ends, part_done)
        curve = BSpline(curve.poles, curve.knots - curve.knots[0] + start) if start else curve
        parameters[rows[: len(u)]] = u + start
        start = curve.domain[1]
        curves.append(curve)
        part_done(1.0)
    found = deviation_at(curves, given, parameters, cleaned.closed)
    if max(found.points, found.between if polyline else 0.0) > tolerance:
        raise ValueError(
            f"no curve was found within {tolerance:g}, but one within {max(found.points, found.between):.3g}: "
            "is the tolerance near the rounding errors?"
        )
    asked: dict[str, Any] = {"closed": closed, "corners": corners, "between": between, "effort": effort}
    asked |= {"weights": weights, "end_tangents": end_tangents}
    unusual = {name: value for name, value in asked.items() if value is not (fit.__kwdefaults__ or {})[name]}
    return Fit(
        tuple(curves), found, float(tolerance), cleaned.closed, own(given.copy()), own(parameters), at, cleaned.dropped,
        between, written("fit", tolerance, **unusual),
    )  # fmt: skip


def check_choices(between: str, effort: str) -> None:
    """Raise ValueError for what `fit` does not know."""
    if between not in get_args(Between):
        raise ValueError(f"between must be one of {get_args(Between)}, not {between!r}")
    if effort not in get_args(Effort):
        raise ValueError(f"effort must be one of {get_args(Effort)}, not {effort!r}")


def smallest_tolerance(points: Array) -> float:
    """Return the least tolerance that float64 holds for points (n, d) of such coordinates."""
    return 256.0 * _EPS * float(np.abs(points).max())


def _weights(weights: ArrayLike | None, n: int) -> Array:
    if weights is None:
        return np.ones(n)
    array = as_numbers(weights, "weights")
    if array.shape != (n,) or not np.all(np.isfinite(array)) or not np.all(array > 0):
        raise ValueError(f"weights must be {n} positive numbers, one for each point")
    return array


def _tangents(tangents: EndTangents | None, points: Array, closed: bool) -> tuple[Array | None, Array | None]:
    """Return the unit directions at both ends of the curve, where they are given."""
    if tangents is None:
        return None, None
    if closed:
        raise ValueError("a closed curve has no ends: leave end_tangents out")
    d = points.shape[1]
    try:
        first, last = (None if each is None else np.array(each, dtype=np.float64) for each in tangents)
    except (TypeError, ValueError):  # another number of them, text
        first = last = np.empty(0)
    for direction in (first, last):
        if direction is not None:
            size = np.abs(direction).max(initial=0.0)
            if direction.shape != (d,) or not 0.0 < size < np.inf:
                raise ValueError(
                    f"end_tangents must be two finite directions, shape (2, {d}), none of them zero, None where one is "
                    f"free, and not {tangents!r:.80}"
                )
            direction /= size  # so that its square is a number
            direction /= np.linalg.norm(direction)
    return first, last


def _corners(corners: Corners, points: Array, tolerance: float, closed: bool, polyline: bool, kept: Ints) -> Ints:
    """Return the rows of the cleaned points that split them, rising; never an open end."""
    if corners is None:
        return np.zeros(0, dtype=np.intp)
    if isinstance(corners, (str, bool)):
        if corners != "auto":
            raise ValueError(
                f'corners must be "auto", None, an angle in radians or rows of the points, not {corners!r}'
            )
        return find_corners(points, tolerance, closed, _POLYLINE_CORNER if polyline else None)
    if np.ndim(corners) == 0:
        angle = as_number(corners, "angle of corners")
        if not 0.0 < angle <= np.pi:
            raise ValueError(f"a corner's angle must be in radians, above 0 and at most pi, not {angle}")
        return find_corners(points, tolerance, closed, angle)
    rows = np.asarray(corners)
    if rows.ndim != 1 or (len(rows) and not np.issubdtype(rows.dtype, np.integer)):
        raise ValueError("corners must be whole numbers: rows of the points")
    at = np.searchsorted(kept, rows, side="right") - 1  # a dropped row repeats the kept one before it
    if len(rows) and (rows.min() < 0 or rows.max() > max(kept[-1], len(points) - 1) + closed):
        raise ValueError(f"corners must be rows of the points, 0 to {kept[-1]}, not {rows.min()} to {rows.max()}")
    at = np.unique(at % len(points))
    return at if closed else at[(at > 0) & (at < len(points) - 1)]


def stretches(n: int, corners: Ints, closed: bool) -> list[Ints]:
    """Return the rows of each stretch between corners, both of its ends with it; of a smooth closed curve, all once."""
    if not closed:
        edges = np.concatenate([[0], corners, [n - 1]])
    elif len(corners):
        edges = np.append(corners, corners[0] + n)
    else:
        return [np.arange(n)]
    return [np.arange(a, b + 1) % n for a, b in zip(edges[:-1], edges[1:], strict=True)]
