"""How far a curve is from its points: certified upper bounds, at the points and between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints, restrict, split
from cadfit.bspline import BSpline, own
from cadfit.fitting.matching import blocks, distances, match
from cadfit.joining import join
from cadfit.points.clean import as_contour

_MOST_CELLS = 1 << 21  # past this many the bound is returned as it stands
_TIGHT = 5e-4  # a bound is refined until it is within this of a distance that occurs


@dataclass(frozen=True, slots=True, eq=False)
class Deviation:
    """Upper bounds on the distance between a curve and its points, in the caller's unit.

    `points`: no point is farther from the curve, matched in order. `between`: between the places of two neighbouring
    points the curve is nowhere farther from the segment that joins them. `rms`: the root mean square of the points'
    distances. `worst`: the row of the point that is farthest.

    The larger of `points` and `between` bounds both one-sided distances between the curve and the polyline of the
    points, and the weak Fréchet distance; where the curve does not run back along a segment, the Fréchet distance.
    """

    points: float
    between: float
    rms: float
    worst: int


def deviation(curves: BSpline | Sequence[BSpline], points: ArrayLike, closed: bool = False) -> Deviation:
    """Return certified upper bounds on the distance between curves, joined end to end, and ordered points (n, d).

    Both bounds hold for every place of the curve, not for samples of it, float64's rounding included, and are within
    0.1 % of distances that occur. Points are matched in order (`matching.match`), so a curve that crosses or nearly
    touches itself is not credited with the wrong branch. With `closed` the curve returns to the first point, which may
    be repeated at the end or not; its start may lie anywhere on the contour.

    Raises ValueError for bad points (naming the row), another dimension than the curve's, curves that are not joined,
    and `closed` for a curve that does not return to its start.
    Source: ours (`_largest_cubic`).

    >>> arc = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> far = deviation(arc, [[0, 0], [3, 0]])
    >>> far.points < 1e-12, round(far.between, 3)
    (True, 0.75)
    """
    chain = [curves] if isinstance(curves, BSpline) else list(curves)
    spline = join(chain)
    opening = max((_gap(a, b) for a, b in pairwise(chain)), default=0.0)  # joining moves the curve by that much at most
    given = as_contour(points, closed)
    d = spline.poles.shape[1]
    if given.shape[1] != d:
        raise ValueError(f"the points have {given.shape[1]} coordinates, the curve {d}")
    origin = given.mean(axis=0)  # at large offsets rounding would drown the distances
    spline, given = BSpline(own(spline.poles - origin), spline.knots), given - origin
    if not closed:
        u = match(spline, given)
        return _bounds(spline, given, u, np.concatenate([[spline.domain[0]], u[1:-1], [spline.domain[1]]]), opening)
    seam = _gap(spline, spline)
    if seam > 1e-9 * spline.size:
        raise ValueError("closed=True needs a curve that ends where it starts")
    spline = _started_at(spline, given[0])
    contour = np.concatenate([given, given[:1]])
    u = match(spline, contour).copy()
    u[0], u[-1] = spline.domain
    return _bounds(spline, contour, u, u, opening + seam, repeated=1)


def deviation_at(curves: Sequence[BSpline], points: Array, u: Array, closed: bool) -> Deviation:
    """Return `deviation` for points (n, d) whose parameters u (n,) are known, and rise; with `closed`, but for a step.

    The bounds hold for any parameters; they are tight where these are the nearest places. `curves` are joined to the
    last bit, closed ones at the seam, too; their parameters run on from one to the next. Open ends are points.
    """
    origin = points.mean(axis=0)
    spline = join(curves)
    spline, points = BSpline(own(spline.poles - origin), spline.knots), points - origin
    if not closed:
        return _bounds(spline, points, u, u, 0.0)
    spline, points, u = unrolled(spline, points, u)
    return _bounds(spline, points, u, u, 0.0, repeated=1)


def unrolled(spline: BSpline, points: Array, u: Array) -> tuple[BSpline, Array, Array]:
    """Return two rounds of the closed curve, the points (n + 1, d) back to the first, and rising parameters."""
    period = spline.domain[1] - spline.domain[0]
    on = np.where(u < u[0], u + period, u)
    return join([spline, spline]), np.concatenate([points, points[:1]]), np.append(on, u[0] + period)


def straying_chords(spline: BSpline, points: Array, u: Array, room: Array) -> Ints:
    """Return the chords whose part of the curve is not certain to stay within their room (n - 1,).

    `points` (n, d), `u` (n,) not falling; the part of chord i runs from u[i] to u[i + 1].
    """
    knots = spline.distinct_knots
    unsure = np.flatnonzero(_chord_bounds(spline, knots, points, u) > room)
    strays = np.zeros(len(room), dtype=bool)
    for rows in blocks(len(unsure)):
        pieces, length, chord = _pieces_over(spline, knots, points, u, unsure[rows])
        for _ in range(30):
            ends, upper = _segment_bounds(pieces, length)
            strays[chord[ends.max(axis=0) > room[chord]]] = True
            keep = (upper > room[chord]) & ~strays[chord]
            pieces, length, chord = _halves(pieces[:, :, keep]), np.tile(length[keep], 2), np.tile(chord[keep], 2)
            if not keep.any() or len(chord) > _MOST_CELLS:
                break
        strays[chord] = True
    return np.flatnonzero(strays)


def _started_at(spline: BSpline, point: Array) -> BSpline:
    """Return the closed curve started at its place nearest to the point."""
    start, distance = spline.nearest(point)
    low, high = spline.domain
    here = float(np.linalg.norm(spline.poles[0] - point))
    edge = 1e-12 * (high - low)  # a start nearer than this to the seam is the seam
    if here <= float(distance) + 1e-14 * spline.size or not low + edge < start < high - edge:
        return spline
    left, right = spline.split(float(start))
    return join([right, left])


def _gap(before: BSpline, after: BSpline) -> float:
    return float(np.linalg.norm(after.poles[0] - before.poles[-1]))


def _bounds(spline: BSpline, points: Array, u: Array, ends: Array, moved: float, repeated: int = 0) -> Deviation:
    """Put the deviation together for points at u (n,) with chords from ends[i] to ends[i + 1].

    The curve was moved by up to `moved`. The last `repeated` points stand for the first, closing the contour.
    """
    gap = distances(spline, points, u)
    rounding = 16 * float(np.finfo(np.float64).eps) * float(max(np.abs(spline.poles).max(), np.abs(points).max()))
    between = largest_between(spline, points, ends, rounding)
    own = gap[: len(gap) - repeated]
    return Deviation(
        points=float(gap.max() + rounding + moved),
        between=float(between + rounding + moved),
        rms=float(np.sqrt(np.mean(own**2)) + rounding + moved),
        worst=int(np.argmax(own)),
    )


def largest_between(spline: BSpline, points: Array, u: Array, floor: float) -> float:
    """Return an upper bound on the distance from the curve between u[i] and u[i + 1] to the segment of points i, i + 1.

    `points` (n, d), `u` (n,) not falling. The bound is within 0.05 % (or `floor`) of a distance that occurs.

    >>> arc = BSpline([[0.0, 0.0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> round(largest_between(arc, np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([0.0, 1.0]), 0.0), 3)
    0.75
    """
    knots = spline.distinct_knots
    upper = _chord_bounds(spline, knots, points, u)
    order = np.argsort(-upper)
    occurs = bound = 0.0
    start, count = 0, 1 << 10
    while start < len(order):
        rest = float(upper[order[start]])
        if rest <= occurs * (1.0 + _TIGHT) + floor:
            return max(bound, rest)
        chords = np.sort(order[start : start + count])
        pieces, length, _ = _pieces_over(spline, knots, points, u, chords)
        occurs, chords_bound = _refined(pieces, length, occurs, floor)
        bound = max(bound, chords_bound)
        start, count = start + count, 1 << 12  # as many as fit the cache
    return bound


def _knots_inside(knots: Array, low: Array, high: Array) -> tuple[Ints, Ints]:
    """Return the range of the distinct knots strictly between low and high (empty: first == stop)."""
    first = np.searchsorted(knots, low, side="right")
    return first, np.maximum(np.searchsorted(knots, high, side="left"), first)


def _chord_bounds(spline: BSpline, knots: Array, points: Array, u: Array) -> Array:
    """Return a first upper bound (n - 1,) for each chord, infinite for those whose part of the curve has knots inside.

    Also infinite where it ends at a multiple knot, from which on another second derivative may hold.
    """
    multiple = knots[:-1][spline.multiplicities[:-1] > 1][1:]
    upper = np.full(len(u) - 1, np.inf)
    for rows in blocks(len(upper)):
        ends = slice(rows.start, rows.stop + 1)
        at = u[ends]
        first, stop = _knots_inside(knots, at[:-1], at[1:])
        whole = (first == stop) & ~np.isin(at[1:], multiple)
        if not whole.any():
            continue
        second = spline.derivative(at, 2)
        bend = np.sqrt(np.einsum("kd,kd->k", second, second)) / 6.0
        gap = distances(spline, points[ends], at)
        square = (at[1:] - at[:-1]) ** 2
        bound = _largest_cubic(gap[:-1], gap[1:], np.stack([square * bend[:-1], square * bend[1:]]))
        upper[rows][whole] = bound[whole]
    return upper


def _largest_cubic(start: Array, end: Array, bend: Array) -> Array:
    """Return the largest value over t in [0, 1] of (1 - t) start + t end + t (1 - t) ((2 - t) A + (1 + t) B).

    With A, B = `bend` (2, k), a cubic's second derivative at both ends times width^2 / 6, the last term is how far the
    cubic leaves its chord at most; with `start` and `end` the distances to a convex set at the ends, the first two
    bound the chord's. The sum is concave in t; for a plane arc over a parallel chord it is exact.
    """
    first, last = bend
    a, b = 2.0 * first + last, last - first
    rise, turn = end - start + a, 2.0 * (a - b)  # the slope is rise - turn t - 3 b t^2
    square = turn * turn + 12.0 * b * rise
    bottom = turn + np.sqrt(np.maximum(square, 0.0))
    t = np.divide(2.0 * rise, bottom, out=np.ones_like(rise), where=(bottom > 0) & (square >= 0))
    t = np.clip(t, 0.0, 1.0)
    largest = start + t * (end - start) + t * (1.0 - t) * (a + b * t)
    return np.asarray(np.maximum(largest, np.maximum(start, end)))


def _refined(pieces: Array, length: Array, occurs: float, floor: float) -> tuple[float, float]:
    """Return the largest distance that occurs, at least `occurs`, and a bound on all of them over some chords.

    Pieces are halved where their bound stands out.
    """
    bound = 0.0
    for _ in range(50):
        ends, upper = _segment_bounds(pieces, length)
        occurs = max(occurs, float(ends.max()))
        keep = upper > occurs * (1.0 + _TIGHT) + floor
        bound = max(bound, float(upper[~keep].max(initial=0.0)))
        if not keep.any() or len(keep) > _MOST_CELLS:
            break
        pieces, length = _halves(pieces[:, :, keep]), np.tile(length[keep], 2)
    return occurs, max(bound, float(upper[keep].max(initial=0.0)))


def _pieces_over(spline: BSpline, knots: Array, points: Array, u: Array, chords: Ints) -> tuple[Array, Array, Ints]:
    """Return the Bézier pieces (4, 1 + d, k) of the curve over some chords, seen from these; their lengths; the chords.

    Seen from a chord: the first coordinate runs along it from its start, the others are what is across. The pieces
    stand in the last place: long rows are what numpy is quick at.
    """
    first, stop = _knots_inside(knots, u[chords], u[chords + 1])
    counts = stop - first + 1
    chord = np.repeat(chords, counts)
    within = np.arange(len(chord)) - np.repeat(np.cumsum(counts) - counts, counts)
    knot = np.minimum(np.repeat(first, counts) + within, len(knots) - 1)
    low = np.where(within == 0, u[chord], knots[knot - 1])
    high = np.where(within == np.repeat(counts, counts) - 1, u[chord + 1], knots[knot])
    span = np.searchsorted(spline.knots, knots[knot], side="left") - 1
    start, width = spline.knots[span], knots[knot] - spline.knots[span]
    pieces = spline.pieces_of(span)
    part = (low > start) | (high < knots[knot])
    if part.any():
        ends = ((side[part] - start[part]) / width[part] for side in (low, high))
        pieces[part] = restrict(pieces[part], *ends)
    pieces = pieces.transpose(1, 2, 0)
    here = np.ascontiguousarray(points[chord].T)
    direction = points[chord + 1].T - here
    length = np.sqrt(np.einsum("dk,dk->k", direction, direction))
    direction = np.divide(direction, length, out=np.zeros_like(here), where=length > 0)
    seen = np.empty((4, len(here) + 1, len(length)))
    np.subtract(pieces, here, out=seen[:, 1:])
    seen[:, 0] = np.einsum("pdk,dk->pk", seen[:, 1:], direction)
    seen[:, 1:] -= seen[:, :1] * direction
    return seen, length, chord


def _halves(pieces: Array) -> Array:
    """Return the first and then the second halves of pieces (4, d, k), as (4, d, 2 k)."""
    return np.concatenate([half.transpose(1, 2, 0) for half in split(pieces.transpose(2, 0, 1))], axis=2)


def _segment_bounds(pieces: Array, length: Array) -> tuple[Array, Array]:
    """Return the distances (2, k) of the ends of pieces from their segments, and an upper bound (k,) over each piece.

    Across the segment the bound is `_largest_cubic`; beyond the segment's ends, the hull of the poles.
    """
    along, across = pieces[:, 0], pieces[:, 1:]
    beyond = np.maximum(np.maximum(-along, along - length), 0.0)
    size = np.sqrt(np.einsum("pdk,pdk->pk", across[::3], across[::3]))
    bend = across[:2] - 2.0 * across[1:3] + across[2:]
    aside = _largest_cubic(size[0], size[1], np.sqrt(np.einsum("pdk,pdk->pk", bend, bend)))
    return np.hypot(size, beyond[::3]), np.hypot(aside, beyond.max(axis=0))
