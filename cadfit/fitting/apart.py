"""Points that rounding hardly tells apart: fitted as one, so that no chord and no span vanishes about their middle.

Computed outlines have them: where an arc meets a line, or closes, sines and cosines leave a last bit of difference.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.fitting.stretch import fit_stretch
from cadfit.points.measures import chord_lengths, distances_from
from cadfit.stages import Progress

Tangents = tuple[Array | None, Array | None]

_EPS = float(np.finfo(np.float64).eps)
_ROUNDINGS = 4.0  # of the largest coordinate: points so near are one
_ALONG = 16.0  # roundings of the length: knots so near are one, or no corner can be rounded between them
_SHARE = 1.0 / 16.0  # of the tolerance, at most, is given up for the latter


def nearness(points: Array, tolerance: float) -> float:
    """Return how near neighbours among the points (n, d) count as one."""
    length = float(chord_lengths(points).sum())
    least = _ROUNDINGS * _EPS * float(np.abs(points).max())
    return max(least, min(_ALONG * _EPS * length, _SHARE * tolerance))


def corners_apart(corners: Ints, parts: list[Ints], points: Array, near: float, closed: bool) -> Ints:
    """Return the corners, without one end of each part between them that is all within `near`.

    `parts`: the rows of each, in order. An open curve's ends are none of its corners.
    """
    gone = np.zeros(len(corners), dtype=bool)
    if len(parts) < 2:
        return corners
    for k, rows in enumerate(parts):
        if distances_from(points[rows], points[rows[0]]).max() <= near:
            gone[(k + 1) % len(corners) if closed else min(k, len(corners) - 1)] = True
    return corners[~gone]


def fit_apart(
    points: Array,
    tolerance: float,
    near: float,
    closed: bool,
    polyline: bool,
    best: bool,
    weights: Array,
    tangents: Tangents,
    progress: Progress,
) -> tuple[BSpline, Array]:
    """Return `fit_stretch` of the points (n, d) that are more than `near` apart, and the parameters (n,) of all."""
    rows = told_apart(points, near, closed)
    if closed and len(rows) < 3:
        raise ValueError("a closed curve needs at least 3 points that float64 tells apart")
    if len(rows) == len(points):
        alone = np.zeros(len(rows), dtype=bool)
        return fit_stretch(points, tolerance, closed, polyline, best, weights, alone, tangents, progress)
    which = _which(points, rows, closed)
    doubled = np.bincount(which % len(rows)) > 1
    held = tolerance - near  # never much less: of 256 roundings `near` is a few, or else a small part
    curve, u = fit_stretch(points[rows], held, closed, polyline, best, weights[rows], doubled, tangents, progress)
    low, high = curve.domain
    before_first = high if u[0] <= low else np.nextafter(u[0], low)
    return curve, np.append(u, before_first)[which]


def told_apart(points: Array, near: float, closed: bool) -> Ints:
    """Return the rows of the points (n, d), each farther than `near` from the one before; open ends are among them.

    >>> told_apart(np.array([[0.0], [0.1], [1.0], [1.9], [2.0]]), 0.5, closed=False).tolist()
    [0, 2, 4]
    """
    fresh, last = np.append(True, chord_lengths(points) > near), 0
    for row in np.flatnonzero(~fresh).tolist():
        last = row - 1 if fresh[row - 1] else last
        fresh[row] = bool(np.linalg.norm(points[row] - points[last]) > near)  # many that crawl are not one
    rows = np.flatnonzero(fresh)
    if closed:
        back = np.flatnonzero(distances_from(points[rows], points[0]) > near)
        return rows[: back[-1] + 1] if len(back) else rows[:1]
    if rows[-1] != len(points) - 1:
        rows = np.append(rows[: max(len(rows) - 1, 1)], len(points) - 1)
    return rows


def _which(points: Array, rows: Ints, closed: bool) -> Ints:
    """Return for each point (n,) which of the rows (k,) stands for it, rising; where closed, k for the first again."""
    which = np.searchsorted(rows, np.arange(len(points)), side="right") - 1
    first, last = (len(rows) - 1, len(rows)) if closed else (len(rows) - 2, len(rows) - 1)
    rest, end = points[rows[first] :], points[0 if closed else -1]
    ending = np.linalg.norm(rest - end, axis=1) < np.linalg.norm(rest - rest[0], axis=1)
    which[rows[first] :][np.logical_or.accumulate(ending)] = last
    return which
