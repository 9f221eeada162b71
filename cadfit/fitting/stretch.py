"""One stretch between corners, or one smooth closed curve: fitted about its middle at unit size, then certified."""

from __future__ import annotations

from itertools import count

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.checking import Check, Stretch, checked, nearer
from cadfit.fitting.feet import wrapped
from cadfit.fitting.relax import Trial, relax, start, watched
from cadfit.fitting.rounded import rounded_chain, rounded_polyline
from cadfit.fitting.search import evenly_fewer, few, fewest, first_knots, grow, singly_fewer
from cadfit.fitting.spans import Curve, Spans
from cadfit.fitting.targets import straight_chain
from cadfit.fitting.taut import thinned_taut, tightened
from cadfit.fitting.thinned import carried, more_rows, spread
from cadfit.points.measures import chord_lengths, distances_from, middle
from cadfit.stages import Progress, portion, stage

_MANY = 2500  # points: of more than these some are fitted, and all are checked
_SOME = 2000  # of them at first
_MARGIN = 1e-3  # of the tolerance, for certified bounds are a little above the distances that occur
_LOST = 120.0  # roundings of the largest coordinate: at most so far is a pole moved in place, most at a seam
_GROWN, _NEARLY = 0.1, 0.8  # of the time, about: where the curve holds, and where it waits for a check
_FEW = 0.2  # of the time that taking many spans away takes, about: what the first few trials take
_MANY_SPANS = 14  # so many have room for single ones to be taken away at several places
_SOFT = 6  # the pass from which on a nearly tight curve is tightened
_SWING = 0.5  # of what a curve may stray: what comes so far is a swing, to be watched where it strays elsewhere
_ROUNDS = 12  # of mending what a check finds
_SEAM = 3e-2  # of a long span beside it: a shorter one is no place for the seam
_EPS = float(np.finfo(np.float64).eps)


def fit_stretch(
    points: Array,
    tolerance: float,
    closed: bool,
    polyline: bool,
    best: bool,
    weights: Array,
    doubled: NDArray[np.bool_],
    tangents: tuple[Array | None, Array | None],
    progress: Progress,
) -> tuple[BSpline, Array]:
    """Return the curve and the parameters (n,) of the points (n, d) on it; arguments as checked by `fit`.

    `doubled` (n,): which of them stand for others that are all but equal.
    """
    straight = None
    if not closed and all(tangent is None for tangent in tangents):
        straight = _straight(points, tolerance * (1.0 - _MARGIN) - _LOST * _EPS * float(np.abs(points).max()))
    if straight is not None and len(points) == 2:
        return straight
    origin = middle(points)
    centred = points - origin
    order, flipped = _canonical(centred, closed)
    size = 2.0 * float(distances_from(points, origin).max())
    near = tolerance * (1.0 - _MARGIN) / size - _LOST * _EPS * float(np.abs(points).max()) / size
    unit = centred[order] / size
    if flipped:
        first, last = tangents
        tangents = None if last is None else -last, None if first is None else -first
    stretch = Stretch(unit, near, closed, polyline, weights[order] / weights[order].mean(), doubled[order], tangents)
    curve, u = _as_given(nearer(stretch, _found(stretch, best, progress)), order, flipped)
    low = curve.spans.knots[0]
    if straight is not None and curve.spans.count > 1:  # points back and forth along a line, in noise
        return straight
    poles = curve.poles * size + origin[:, None]
    if not closed:
        poles[:, 0], poles[:, -1] = points[0], points[-1]
    spline = Spans((curve.spans.knots - low) * size, closed).spline(poles)
    u = (u - low) * size
    return spline, np.clip(u % spline.domain[1] if closed else u, *spline.domain)


def _canonical(points: Array, closed: bool) -> tuple[Ints, bool]:
    """Return the rows, in an order that depends on the places alone, of points about their middle; if it is backward.

    So the same points give the same curve, to the last bit, whichever they start from, and in whichever direction they
    run. The first of a closed curve is the farthest from the middle; the outer half of the length comes first. Ties go
    by coordinates.
    """
    n = len(points)
    away = distances_from(points, np.zeros(points.shape[1]))
    farthest = np.flatnonzero(away == away.max())
    first = int(farthest[np.lexsort(points[farthest].T)[-1]]) if closed else 0
    rows = (first + np.arange(n + closed)) % n
    step = chord_lengths(points[rows])
    along = np.cumsum(step) - 0.5 * (step + step.sum())  # of the chords' middles, from the half
    far = away[rows]
    outward = float(np.sum(step * along * (far[:-1] + far[1:])))
    if abs(outward) <= 1e-9 * step.sum() ** 2 * far.max():
        ahead, behind = points[rows[[int(closed), -1 - closed]]].tolist()
        outward = 1.0 if ahead > behind else -1.0
    return (rows[::-1] if outward > 0 else rows)[:n], outward > 0


def _as_given(check: Check, order: Ints, flipped: bool) -> tuple[Curve, Array]:
    """Return the curve and the parameters of the points in the caller's order and direction."""
    curve, u = check.trial.curve, np.empty(len(order))
    u[order] = check.u
    if flipped:
        curve, u = curve.backward(), -u
    if not curve.spans.closed:
        return curve, u
    curve, u = wrapped(curve, np.where(u < u[0], u + check.trial.goal.period, u))
    return _seamed(curve), u


def _seamed(curve: Curve) -> Curve:
    """Return the closed curve begun where spans are not short: at its start, or at the nearest such knot.

    Next to a short span the last bits of the poles show in the second derivative. Where all knots have one beside them,
    a long span just before the start is cut.
    """
    knots, steps = curve.spans.knots, curve.spans.steps
    k = int(np.argmax(steps[-3:])) - 3 + len(steps)
    if min(steps[0], steps[-1]) >= _SEAM * max(steps[0], steps[k]):
        return curve
    away = np.minimum(knots[:-1] - knots[0], knots[-1] - knots[:-1])
    away[np.minimum(steps, np.roll(steps, 1)) < _SEAM * steps.max()] = np.inf
    nearest = int(np.argmin(away))
    if away[nearest] < np.inf:
        return curve.from_span(nearest)
    curve = curve.from_span(k)
    return curve.with_knot(float(0.5 * (curve.spans.knots[0] + curve.spans.knots[1]))).from_span(1)


def _straight(points: Array, tolerance: float) -> tuple[BSpline, Array] | None:
    """Return the segment between the first and the last point, if all are within the tolerance of it, in order.

    Then what lies on it between two of their places is within that of the chord between them, too. Where points come
    back along it, their place is in the middle between the farthest so far and the nearest still to come.
    """
    length = float(np.linalg.norm(points[-1] - points[0]))
    if not length:
        return None
    direction = (points[-1] - points[0]) / length
    some = points[:: len(points) // 16 + 1] - points[0]  # they tell of most curves that they are not straight
    if np.linalg.norm(some - (some @ direction)[:, None] * direction, axis=1).max() > tolerance:
        return None
    along = (points - points[0]) @ direction
    u = 0.5 * (np.maximum.accumulate(along) + np.minimum.accumulate(along[::-1])[::-1])
    u = np.minimum(np.maximum(u, 0.0), length)
    u[0], u[-1] = 0.0, length
    far = points - (points[0] + (u / length)[:, None] * (points[-1] - points[0]))
    if np.linalg.norm(far[1:-1], axis=1).max(initial=0.0) > tolerance:
        return None
    poles = straight_chain(points[[0, -1]], closed=False)[0]
    poles[-1] = points[-1]
    return BSpline(own(poles), np.repeat([0.0, length], 4)), u


def _found(stretch: Stretch, best: bool, progress: Progress) -> Check:
    """Return a curve that holds, with few spans.

    A polyline that needs a span for every other chord, or more, may need fewer where its corners are rounded.
    """
    smooth = _smooth(stretch, best, progress)
    if smooth is not None and not (stretch.polyline and 2 * smooth.trial.curve.spans.count > len(stretch.points)):
        return smooth
    rounded = _rounded(stretch, portion(progress, _NEARLY, 1.0))
    return rounded if smooth is None or len(rounded.spline.poles) < len(smooth.spline.poles) else smooth


def _smooth(stretch: Stretch, best: bool, progress: Progress) -> Check | None:
    """Return a curve grown until it holds, then with fewer spans as long as it does; None of too sharp a polyline."""
    n = len(stretch.points)
    rows = np.arange(n) if n <= _MANY else spread(np.array([0, n - 1]), _SOME)
    goal = stretch.goal(rows)
    trial = grow(goal, first_knots(goal), goal.u, portion(progress, 0.0, _GROWN), stretch.most)
    taken_away, searching = _fewest if best else few, portion(progress, _GROWN, _NEARLY)
    searching(0.0)
    if stretch.polyline and not trial.met:
        return None
    if trial.met and len(rows) == n:  # so far as samples tell: nearly always enough for a check to pass
        reduced = taken_away(trial, searching)
        fewer, _ = _mended(stretch, reduced, rows, progress)
        count = fewer.trial.curve.spans.count
        if fewer.passed and (count == reduced.curve.spans.count or count < trial.curve.spans.count):
            return fewer  # else mending gave all spans back, as in noise: once more, from what passes
    grown, rows = _mended(stretch, trial, rows, progress)
    if not grown.passed:
        if stretch.polyline:
            return None
        grown, rows = _surely(stretch), np.arange(n)
        if n > _MANY:  # less than the noise was asked of so many points: hours would take few poles away
            return grown
    fewer, _ = _mended(stretch, taken_away(grown.trial, searching), rows, progress)
    return fewer if fewer.passed and len(fewer.spline.poles) < len(grown.spline.poles) else grown


def _fewest(trial: Trial, progress: Progress) -> Trial:
    """Return the trial with spans taken away by many trials, from where a few have led.

    These are all that "fast" makes, so there are never more spans than with it. They tell whether single spans are to
    be found at many places at once, or at one in many ways. These push knots together, so that what they lead to is
    worth it only if it has fewer spans.
    """
    trial, searching = few(trial, portion(progress, 0.0, _FEW)), portion(progress, _FEW, 1.0)
    if trial.curve.spans.count >= _MANY_SPANS:
        return singly_fewer(evenly_fewer(trial), searching)
    fewer = fewest(trial, searching)
    return fewer if fewer.curve.spans.count < trial.curve.spans.count else trial


def _rounded(stretch: Stretch, progress: Progress) -> Check:
    """Return the polyline with its corners rounded, with as few spans as are found by taking knots away."""
    sure, rows = _surely(stretch), np.arange(len(stretch.points))
    with stage("taking corners' knots away"):
        found = [*thinned_taut(sure.trial, progress)]
    for trial in reversed(found):
        check = checked(stretch, trial, rows)
        for _ in range(_ROUNDS):
            if check.passed or not len(check.straying):
                break
            check = checked(stretch, tightened(_watched(check.trial, check.straying), _SOFT), rows)
        if check.passed:
            return check
    return sure


def _mended(stretch: Stretch, trial: Trial, rows: Ints, progress: Progress) -> tuple[Check, Ints]:
    """Return the check of the trial, fitted again with more points or targets where it did not pass; and its rows."""
    n, least = len(stretch.points), 0
    check = checked(stretch, trial, rows)
    for turn in count():
        progress(0.0)  # how much is still to mend is not known, but it may be stopped
        whole = len(rows) == n
        if check.passed or check.loops or (whole and (turn >= _ROUNDS or not trial.met)):
            break
        if whole:
            trial = _met(_watched(trial, check.straying), stretch.most)
        else:
            rows = more_rows(check, rows, least)
            goal = carried(stretch.goal(rows), check, rows)
            spans = trial.curve.spans
            fitted = _met(start(goal, spans.knots, goal.u), stretch.most)
            spiky = not fitted.met or fitted.curve.spans.count > 1.5 * spans.count + 8
            least = 4 * len(rows) if spiky or turn >= _ROUNDS else 0
            if spiky and len(rows) < n:
                continue  # too few points: what passes them all would miss the others by far
            trial = fitted
        check = checked(stretch, trial, rows)
    return check, rows


def _met(trial: Trial, most: float) -> Trial:
    """Return a trial that meets the targets, if one is found, with knots added where moving them does not do."""
    trial = relax(trial, 24, move_knots=True)
    return trial if trial.met else grow(trial.goal, trial.curve.spans.knots, trial.u, most=most)


def _watched(trial: Trial, chords: Ints) -> Trial:
    """Return the trial with targets on each of the chords: where the curve strays most, and at its other swings."""
    goal = trial.goal
    u = np.append(trial.u[goal.data], trial.u[0] + goal.period)
    within = np.arange(1, 64)[:, None] / 64.0
    at = u[chords] + within * (u[chords + 1] - u[chords])
    places = trial.curve.points(at.ravel(), trial.curve.spans.find(at.ravel()))
    far = goal.straying(places, np.tile(chords, len(within))).reshape(at.shape)
    around = np.pad(far, ((1, 1), (0, 0)))
    peaks = (far >= around[:-2]) & (far > around[2:]) & (far > _SWING)
    peaks[np.argmax(far, axis=0), np.arange(len(chords))] = True
    rows, which = np.nonzero(peaks)
    before, here, after = around[rows, which], around[rows + 1, which], around[rows + 2, which]
    aside = np.clip(0.5 * (after - before) / np.maximum(2.0 * here - before - after, _EPS), -0.5, 0.5)
    # at the peak of their parabola: a target at the sample itself is met where only its neighbourhood is beyond
    return watched(trial, chords[which], within[rows, 0] + aside / 64.0)


def _surely(stretch: Stretch) -> Check:
    """Return the points' own chain, its joints rounded as little as it takes.

    Raises ValueError where that does not do, either: the end tangents lead out of the tolerance.
    """
    rows = np.arange(len(stretch.points))
    goal = stretch.goal(rows)
    make = rounded_polyline if stretch.polyline else rounded_chain
    for share in 0.99 * 0.2 ** np.arange(int(not stretch.polyline), 14):
        check = checked(stretch, make(goal, share), rows)
        if check.passed:
            return check
    raise ValueError(
        "no curve was found within the tolerance: is it near the rounding errors, or an end tangent wrong?"
    )
