"""What is to be seen along curves: arc length, curvature on both sides of every knot, distances to the points.

For pictures: everything here is sampled, or exact at samples. The bounds are in `cadfit.fitting.deviation`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cadfit.bezier import Array, Ints, distance_to_segment, evaluate, lengths, restrict
from cadfit.bspline import BSpline
from cadfit.fitting.approximate import stretches
from cadfit.fitting.checking import chain_of, room_of
from cadfit.fitting.deviation import unrolled
from cadfit.fitting.result import Fit
from cadfit.joining import join

_REFINED = 6  # rounds in which the sharpest bend is looked for between its neighbours, each sixteen times as fine


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Samples along curves, in order: at every knot two, from before and from after.

    `u` (k,): the parameters of the curves joined. `s` (k,): the arc lengths from the start. `places` (k, d).
    `curvature` (k, d): curvature vectors, toward the centre, zero where the curve stands still. `span` (k,): the Bézier
    pieces, counted over all curves, that each sample is of.
    """

    u: Array
    s: Array
    places: Array
    curvature: Array
    span: Ints

    @property
    def length(self) -> float:
        """The length of the curves."""
        return float(self.s[-1])

    @property
    def bend(self) -> Array:
        """The curvature's size (k,); in 2D with its sign, positive where the curve turns left."""
        size = np.asarray(np.linalg.norm(self.curvature, axis=1))
        if self.places.shape[1] != 2:
            return size
        forward = np.gradient(self.places, axis=0)
        turn = forward[:, 0] * self.curvature[:, 1] - forward[:, 1] * self.curvature[:, 0]
        return np.asarray(np.copysign(size, turn))

    def at(self, u: Array) -> Array:
        """Return the arc lengths at parameters u (n,) of the curves joined, linear between samples."""
        return np.interp(u, self.u, self.s)


def trace(curves: Sequence[BSpline], most: int = 6000) -> Trace:
    """Return some `most` samples along curves joined end to end, fewer on few spans, at least three a span.

    The place of the largest curvature is among them.

    >>> arc = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> round(trace([arc]).length, 6), round(arc.length(), 6), round(float(trace([arc]).bend.min()), 6)
    (3.443381, 3.443381, -0.666667)
    """
    pieces = np.concatenate([curve.pieces() for curve in curves])
    knots = join(curves).distinct_knots
    each = int(np.clip(most // len(pieces), 3, 65))
    t = np.tile(np.linspace(0.0, 1.0, each), len(pieces))
    span = np.repeat(np.arange(len(pieces)), each)
    if (sharpest := _sharpest(pieces, span, t, each)) is not None:
        row, place = sharpest
        span, t = np.insert(span, row, span[row]), np.insert(t, row, place)
    steps = np.flatnonzero(span[1:] == span[:-1])
    s = np.zeros(len(t))
    s[steps + 1] = lengths(restrict(pieces[span[steps]], t[steps], t[steps + 1]), 1e-7)
    u = (1.0 - t) * knots[span] + t * knots[span + 1]  # the end of a span is the start of the next, to the last bit
    return Trace(u, np.cumsum(s), evaluate(pieces[span], t), _curvature(pieces[span], t), span)


def off_points(fit: Fit) -> Array:
    """Return the vectors (n, d) from the fit's curve to its points, at the points' parameters."""
    return np.asarray(fit.points - join(fit.curves)(fit.parameters))


def off_chords(fit: Fit, most: int = 6000) -> tuple[Array, Array, Ints]:
    """Return places along the curve between its points, and how far they are from the segments that join those.

    Parameters (k,) of the curves joined, rising, distances (k,), and the rows (k,) of the points before: some `most` of
    them, where there are more points the largest of the samples of neighbouring chords.
    """
    spline, points, u = join(fit.curves), fit.points, fit.parameters
    low, high = spline.domain
    if fit.closed:
        spline, points, u = unrolled(spline, points, u)
    each = int(np.clip(most // len(points), 3, 64))
    t = np.linspace(0.0, 1.0, each)
    at = u[:-1, None] + t * np.diff(u)[:, None]
    gap = distance_to_segment(spline(np.clip(at, *spline.domain)), points[:-1, None], points[1:, None])
    rows = largest_rows(gap.ravel(), most)
    at = at.ravel()[rows]
    at = np.where(at > high, at - (high - low), at)
    order = np.argsort(at, kind="stable")
    return at[order], gap.ravel()[rows[order]], rows[order] // each


def allowed(fit: Fit) -> Array | None:
    """Return how far `cadfit.fit` let the curve be from each segment between points (chords,), the closing one last.

    None for a fit without a tolerance.
    """
    if fit.tolerance is None or fit.between is None:
        return None
    smooth, polyline = fit.closed and not len(fit.corners), fit.between == "polyline"
    room = np.zeros(len(fit.points) - (not fit.closed))
    for rows in stretches(len(fit.points), fit.corners, fit.closed):
        found = room_of(chain_of(fit.points[rows], smooth, polyline), fit.tolerance)
        room[rows[: len(found)]] = found
    return room


def largest_rows(values: Array, most: int) -> Ints:
    """Return at most `most` rows, rising: of each of as many runs of values (n,) that of the largest.

    >>> largest_rows(np.array([0.0, 3.0, 1.0, 5.0, 2.0, 1.0]), 3)
    array([1, 3, 4])
    """
    n = len(values)
    if n <= most:
        return np.arange(n)
    edges = np.linspace(0, n, most + 1).astype(np.intp)
    return np.array([a + int(np.argmax(values[a:b])) for a, b in zip(edges[:-1], edges[1:], strict=True)])


def _curvature(pieces: Array, t: Array) -> Array:
    """Return the curvature vectors (k, d) at t (k,) of Bézier pieces (k, 4, d), zero where a piece stands still."""
    t = t[:, None]
    legs, bends = np.diff(pieces, axis=1), np.diff(pieces, n=2, axis=1)
    first = 3.0 * ((1.0 - t) ** 2 * legs[:, 0] + 2.0 * t * (1.0 - t) * legs[:, 1] + t**2 * legs[:, 2])
    second = 6.0 * ((1.0 - t) * bends[:, 0] + t * bends[:, 1])
    square = np.einsum("kd,kd->k", first, first)[:, None]
    still = square == 0.0
    square = np.where(still, 1.0, square)
    across = second - np.einsum("kd,kd->k", first, second)[:, None] / square * first
    return np.where(still, 0.0, across / square)


def _sharpest(pieces: Array, span: Ints, t: Array, each: int) -> tuple[int, float] | None:
    """Return where the curvature is largest near its largest sample: the row to insert it before, and its t.

    None where that is the sample itself.
    """
    row = int(np.argmax(np.linalg.norm(_curvature(pieces[span], t), axis=1)))
    low, high = (float(np.clip(t[row] + step / (each - 1), 0.0, 1.0)) for step in (-1, 1))
    best = float(t[row])
    for _ in range(_REFINED):
        fine = np.append(np.linspace(low, high, 33), best)
        bend = np.linalg.norm(_curvature(np.broadcast_to(pieces[span[row]], (34, 4, pieces.shape[2])), fine), axis=1)
        best, step = float(fine[np.argmax(bend)]), (high - low) / 32.0
        low, high = max(low, best - step), min(high, best + step)
    if best == t[row]:
        return None
    return row + (best > t[row]), best
