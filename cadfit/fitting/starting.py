"""Points that go round a closed curve: where on it the first of them belongs."""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.fitting.matching import distances, foot_points, match, samples_between
from cadfit.joining import join
from cadfit.stages import Progress, unheard

_MOST = 8  # places where the curve is started, at most: as many branches may pass one point
_SAME = 1e-6  # of the period: places so near each other are one
_ROUNDING = 1e-12  # of the period: a start nearer than this to the seam is the seam
_ROWS = 1000  # sets how finely the curve is sampled, as for so many points


def match_around(spline: BSpline, contour: Array, progress: Progress = unheard) -> tuple[BSpline, Array, Array]:
    """Return the closed curve started where the first point belongs, and `match` there, the ends at its ends.

    `contour` (n, d), the last point the first again. Where the curve crosses or nearly touches itself the nearest place
    may be on the wrong branch. No place is right that is farther than the largest distance found: so the others are
    tried, nearest first, as long as they are nearer than that.
    """
    found = None
    for start, distance in _places(spline, contour[0]):
        if found is not None and distance >= found[2].max():
            break
        started = _started_at(spline, start, contour[0])
        u, gap = to_the_ends(started, contour, *match(started, contour, progress))
        if found is None or gap.max() < found[2].max():
            found = started, u, gap
    assert found is not None
    return found


def to_the_ends(spline: BSpline, points: Array, u: Array, gap: Array) -> tuple[Array, Array]:
    """Return the parameters and the distances there with the first and the last at the ends of the curve."""
    u, gap = u.copy(), gap.copy()
    u[0], u[-1] = spline.domain
    gap[[0, -1]] = distances(spline, points[[0, -1]], u[[0, -1]])
    return u, gap


def _places(spline: BSpline, point: Array) -> list[tuple[float, float]]:
    """Return the parameters of the closed curve's places nearer to the point than those around, and their distances.

    The nearest comes first, and is sure; the others are those that samples show.
    """
    v, samples = samples_between(spline, *spline.domain, _ROWS)
    far = np.linalg.norm(samples[:-1] - point, axis=1)
    lows = np.flatnonzero((far <= np.roll(far, 1)) & (far < np.roll(far, -1)))
    lows = lows[np.argsort(far[lows], kind="stable")[:_MOST]]
    target = point[None]
    feet = [foot_points(spline, target, v[[low]]) for low in lows]  # one by one: each to its own accuracy
    best, least = spline.nearest(point)
    period = spline.domain[1] - spline.domain[0]
    kept = [(float(best), float(least))]
    for distance, place in sorted((float(distances(spline, target, foot)[0]), float(foot[0])) for foot in feet):
        if all(_SAME * period < abs(place - other) < (1.0 - _SAME) * period for other, _ in kept):
            kept.append((place, distance))
    return kept


def _started_at(spline: BSpline, start: float, point: Array) -> BSpline:
    """Return the closed curve started at a place near the point; as it is where that is its start but for rounding."""
    low, high = spline.domain
    edge = min(start - low, high - start) / (high - low)
    here, there = np.linalg.norm(spline([low, start]) - point, axis=1)
    if edge <= _ROUNDING or (edge <= _SAME and here <= there + 1e-14 * spline.size):
        return spline
    knot = float(spline.knots[np.argmin(np.abs(spline.knots - start))])
    lost = 16.0 * np.spacing(abs(low) + abs(high) + high - low)  # a span so short could not be moved by the period
    left, right = spline.split(knot if abs(knot - start) <= lost else start)
    return join([right, left])
