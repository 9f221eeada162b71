"""How far a curve is from its points: certified upper bounds, at the points and between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.chords import chord_bounds, halves, pieces_over, segment_bounds
from cadfit.fitting.matching import distances, match
from cadfit.fitting.starting import match_around, to_the_ends
from cadfit.joining import Splines, join, splines_of
from cadfit.points.clean import as_contour, check_largest
from cadfit.points.measures import blocks
from cadfit.stages import Progress, portion, rising, stage, unheard

_MOST_CELLS = 1 << 21  # past this many the bound is returned as it stands
_MATCHED = 0.6  # of the time, about: where the points are matched
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


def deviation(curves: Splines, points: ArrayLike, closed: bool = False, progress: Progress | None = None) -> Deviation:
    """Return certified upper bounds on the distance between curves, joined end to end, and ordered points (n, d).

    `curves`: a `BSpline`, several, or the `Fit` that has them. Both bounds hold for every place of the curve, not for
    samples of it, float64's rounding included, and are within 0.1 % of distances that occur. Points are matched in
    order (`matching.match`), so a curve that crosses or nearly touches itself is not credited with the wrong branch.
    With `closed` the curve returns to the first point, which may be repeated at the end or not; its start may lie
    anywhere on the contour. `progress` is called with the part that is done, from 0 to 1; raising from it stops the
    work.

    Raises ValueError for bad points (naming the row), another dimension than the curve's, curves that are not joined,
    `closed` for a curve that does not return to its start, and coordinates too large to square.
    Source: ours (`chords.chord_bounds`).

    >>> arc = BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> far = deviation(arc, [[0, 0], [3, 0]])
    >>> far.points < 1e-12, round(far.between, 3)
    (True, 0.75)
    """
    chain = splines_of(curves)
    spline = join(chain)
    opening = max((_gap(a, b) for a, b in pairwise(chain)), default=0.0)  # joining moves the curve by that much at most
    given = as_contour(points, closed)
    d = spline.poles.shape[1]
    if given.shape[1] != d:
        raise ValueError(f"the points have {given.shape[1]} coordinates, the curve {d}")
    for each in (given, spline.poles):
        check_largest(each)
    spline, given = _centred(spline, given)
    heard = rising(progress)
    matching, bounding = portion(heard, 0.0, _MATCHED), portion(heard, _MATCHED, 1.0)
    if not closed:
        u, gap = match(spline, given, matching)
        found = _bounds(spline, given, gap, *to_the_ends(spline, given, u, gap), opening, progress=bounding)
        bounding(1.0)
        return found
    seam = _gap(spline, spline)
    if seam > 1e-9 * spline.size:
        raise ValueError("closed=True needs a curve that ends where it starts")
    contour = np.concatenate([given, given[:1]])
    spline, u, gap = match_around(spline, contour, matching)
    found = _bounds(spline, contour, gap, u, gap, opening + seam, repeated=1, progress=bounding)
    bounding(1.0)
    return found


@stage("bounding the deviation")
def deviation_at(curves: Sequence[BSpline], points: Array, u: Array, closed: bool) -> Deviation:
    """Return `deviation` for points (n, d) whose parameters u (n,) are known, and rise; with `closed`, but for a step.

    The bounds hold for any parameters; they are tight where these are the nearest places. `curves` are joined to the
    last bit, closed ones at the seam, too; their parameters run on from one to the next. Open ends are points.
    """
    spline, points = _centred(join(curves), points)
    if closed:
        spline, points, u = unrolled(spline, points, u)
    gap = distances(spline, points, u)
    return _bounds(spline, points, gap, u, gap, 0.0, repeated=int(closed))


def unrolled(spline: BSpline, points: Array, u: Array) -> tuple[BSpline, Array, Array]:
    """Return two rounds of the closed curve, the points (n + 1, d) back to the first, and rising parameters."""
    period = spline.domain[1] - spline.domain[0]
    on = np.where(np.logical_or.accumulate(u < u[0]), u + period, u)  # the last may be at the first's place
    return join([spline, spline]), np.concatenate([points, points[:1]]), np.append(on, u[0] + period)


def straying_chords(spline: BSpline, points: Array, u: Array, gaps: Array, room: Array) -> Ints:
    """Return the chords whose part of the curve is not certain to stay within their room (n - 1,).

    `points` (n, d), `u` (n,) not falling, `gaps` (n,) their distances from the curve there; the part of chord i runs
    from u[i] to u[i + 1].
    """
    knots = spline.distinct_knots
    unsure = np.flatnonzero(chord_bounds(spline, u, gaps) > room)
    strays = np.zeros(len(room), dtype=bool)
    for rows in blocks(len(unsure)):
        pieces, length, chord = pieces_over(spline, knots, points, u, unsure[rows])
        for _ in range(30):
            ends, upper = segment_bounds(pieces, length)
            strays[chord[ends.max(axis=0) > room[chord]]] = True
            keep = (upper > room[chord]) & ~strays[chord]
            pieces, length, chord = halves(pieces[:, :, keep]), np.tile(length[keep], 2), np.tile(chord[keep], 2)
            if not keep.any() or len(chord) > _MOST_CELLS:
                break
        strays[chord] = True
    return np.flatnonzero(strays)


def _gap(before: BSpline, after: BSpline) -> float:
    return float(np.linalg.norm(after.poles[0] - before.poles[-1]))


def _centred(spline: BSpline, points: Array) -> tuple[BSpline, Array]:
    """Return both about the points' mean: at large offsets rounding would drown the distances."""
    origin = np.array([column.mean() for column in points.T])
    return BSpline(own(spline.poles - origin), spline.knots), points - origin


def _bounds(
    spline: BSpline,
    points: Array,
    gap: Array,
    u: Array,
    gap_at_u: Array,
    moved: float,
    repeated: int = 0,
    progress: Progress = unheard,
) -> Deviation:
    """Put the deviation together for points (n, d) at distances `gap` (n,), with chords from u[i] to u[i + 1].

    The curve was moved by up to `moved`. The last `repeated` points stand for the first, closing the contour.
    """
    rounding = 16 * float(np.finfo(np.float64).eps) * float(max(np.abs(spline.poles).max(), np.abs(points).max()))
    between = largest_between(spline, points, u, gap_at_u, rounding, progress)
    own = gap[: len(gap) - repeated]
    return Deviation(
        points=float(gap.max() + rounding + moved),
        between=float(between + rounding + moved),
        rms=float(np.sqrt(np.mean(own**2)) + rounding + moved),
        worst=int(np.argmax(own)),
    )


def largest_between(
    spline: BSpline, points: Array, u: Array, gap: Array, floor: float, progress: Progress = unheard
) -> float:
    """Return an upper bound on the distance from the curve between u[i] and u[i + 1] to the segment of points i, i + 1.

    `points` (n, d), `u` (n,) not falling, `gap` (n,) the points' distances from the curve there. The bound is within
    0.05 % (or `floor`) of a distance that occurs.

    >>> arc = BSpline([[0.0, 0.0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> round(largest_between(arc, np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([0.0, 1.0]), np.zeros(2), 0.0), 3)
    0.75
    """
    knots, upper = spline.distinct_knots, chord_bounds(spline, u, gap)
    occurs, bound, count = 0.0, 0.0, 1 << 10
    while len(chords := np.flatnonzero(upper > occurs * (1.0 + _TIGHT) + floor)):
        progress(1.0 - len(chords) / len(upper))
        if len(chords) > count:  # the largest first: most of the others need no look once these are known
            chords = np.sort(chords[np.argpartition(upper[chords], -count)[-count:]])
        for rows in blocks(len(chords)):
            pieces, length, _ = pieces_over(spline, knots, points, u, chords[rows])
            occurs, over = _refined(pieces, length, occurs, floor)
            bound = max(bound, over)
        upper[chords] = 0.0
        count *= 4
    return max(bound, float(upper.max()))


def _refined(pieces: Array, length: Array, occurs: float, floor: float) -> tuple[float, float]:
    """Return the largest distance that occurs, at least `occurs`, and a bound on all of them over some chords.

    Pieces are halved where their bound stands out.
    """
    bound = 0.0
    for _ in range(50):
        ends, upper = segment_bounds(pieces, length)
        occurs = max(occurs, float(ends.max()))
        keep = upper > occurs * (1.0 + _TIGHT) + floor
        bound = max(bound, float(upper[~keep].max(initial=0.0)))
        if not keep.any() or len(keep) > _MOST_CELLS:
            break
        pieces, length = halves(pieces[:, :, keep]), np.tile(length[keep], 2)
    return occurs, max(bound, float(upper[keep].max(initial=0.0)))
