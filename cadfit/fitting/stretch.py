"""One stretch between corners, or one smooth closed curve: fitted about its middle at unit size, then certified."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import fsum

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.fitting.deviation import straying_chords, unrolled
from cadfit.fitting.matching import distances
from cadfit.fitting.relax import Trial, feet, foot_steps, relax, start, watched, wrapped
from cadfit.fitting.rounded import rounded
from cadfit.fitting.search import fewest, grow
from cadfit.fitting.spans import Curve
from cadfit.fitting.targets import BULGE, Targets, bulges, cardinal_chain, straight_chain, targets, with_samples

_MANY = 2500  # points: of more than these some are fitted, and all are checked
_SOME = 2000  # of them at first
_MARGIN = 1e-3  # of the tolerance, for certified bounds are a little above the distances that occur
_ROWS_A_SPAN = 8
_FAST, _BEST = (12, 8, 0), (60, 16, 8)  # passes, trials, exchanges of knots
_ROUNDS = 12  # of mending what a check finds
_FEET = 2  # Newton steps toward the foot points of those not fitted
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Points (n, d) about their middle at unit size, and what the fit is held to there.

    `room` (chords,): how far the curve may stray from each chord. `weights` (n,): of the points in the least squares.
    `tangents`: directions at the two ends, where given.
    """

    points: Array
    tolerance: float
    closed: bool
    polyline: bool
    room: Array
    weights: Array
    tangents: tuple[Array | None, Array | None]

    def goal(self, rows: Ints) -> Targets:
        """Return the targets that some of the points make; all of them with samples of the chain between."""
        chain = chain_of(self.points[rows], self.closed, self.polyline)
        weights, whole = self.weights[rows], len(rows) == len(self.points)
        room = self.room if whole else self.tolerance + BULGE * self._left_out(rows)
        goal = targets(self.points[rows], chain, room, self.tolerance, weights, self.closed, self.tangents)
        return with_samples(goal, self.polyline) if whole else goal

    def _left_out(self, rows: Ints) -> Array:
        """Return how far the points between each of the rows (the first among them) and the next are from the chord."""
        ends = np.append(rows, len(self.points)) if self.closed else rows
        chord = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
        start, along = self.points[rows], np.diff(self.points[ends % len(self.points)], axis=0)
        gap = self.points[: len(chord)] - start[chord]
        along = along / np.maximum(np.linalg.norm(along, axis=1), _EPS)[:, None]
        gap -= np.einsum("nd,nd->n", gap, along[chord])[:, None] * along[chord]
        return np.asarray(np.sqrt(np.maximum.reduceat(np.einsum("nd,nd->n", gap, gap), ends[:-1])))


@dataclass(frozen=True, slots=True, eq=False)
class Check:
    """A trial's curve as a BSpline, and how all points of the stretch lie to it.

    `u` (n,): their parameters; `error` (n,): their distances in tolerances; `straying`: the chords that the curve is
    not certain to stay near.
    """

    trial: Trial
    spline: BSpline
    u: Array
    error: Array
    straying: Ints

    @property
    def passed(self) -> bool:
        """Whether everything holds."""
        return float(self.error.max()) <= 1.0 and not len(self.straying)


def fit_stretch(
    points: Array,
    tolerance: float,
    closed: bool,
    polyline: bool,
    best: bool,
    weights: Array,
    tangents: tuple[Array | None, Array | None],
) -> tuple[BSpline, Array]:
    """Return the curve and the parameters (n,) of the points (n, d) on it; arguments as checked by `fit`."""
    if len(points) == 2 and all(tangent is None for tangent in tangents):
        return _straight(points)
    order, flipped = _canonical(points, closed)
    origin = _middle(points)
    size = 2.0 * float(np.linalg.norm(points - origin, axis=1).max())
    near = tolerance * (1.0 - _MARGIN) / size - 20.0 * _EPS * float(np.abs(points).max()) / size
    unit = (points[order] - origin) / size
    room = room_of(chain_of(unit, closed, polyline), near)
    if flipped:
        first, last = tangents
        tangents = None if last is None else -last, None if first is None else -first
    stretch = Stretch(unit, near, closed, polyline, room, weights[order] / weights[order].mean(), tangents)
    curve, u = _as_given(_found(stretch, best), order, flipped)
    spline, low = curve.spans.spline(curve.poles), curve.spans.knots[0]
    poles = spline.poles * size + origin
    if not closed:
        poles[0], poles[-1] = points[0], points[-1]
    spline, u = BSpline(own(poles), own((spline.knots - low) * size)), (u - low) * size
    return spline, np.clip(u % spline.domain[1] if closed else u, *spline.domain)


def _middle(points: Array) -> Array:
    """Return the mean of the points: summed exactly, so that no order of theirs changes its last bit."""
    return np.array([fsum(column) / len(points) for column in points.T.tolist()])


def _canonical(points: Array, closed: bool) -> tuple[Ints, bool]:
    """Return the points' rows in an order that depends on their places alone, and whether that is backward.

    So the same points give the same curve, to the last bit, whichever they start from, and in whichever direction they
    run. The first of a closed curve is the farthest from the middle; the outer half of the length comes first. Ties go
    by coordinates.
    """
    n = len(points)
    away = np.linalg.norm(points - _middle(points), axis=1)
    farthest = np.flatnonzero(away == away.max())
    first = int(farthest[np.lexsort(points[farthest].T)[-1]]) if closed else 0
    rows = (first + np.arange(n + closed)) % n
    step = np.linalg.norm(np.diff(points[rows], axis=0), axis=1)
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
    return wrapped(curve, np.where(u < u[0], u + check.trial.goal.period, u))


def chain_of(points: Array, closed: bool, polyline: bool) -> Array:
    """Return the curve between points (n, d) that says how far a fit may stray: Bézier pieces (chords, 4, d)."""
    return straight_chain(points, closed) if polyline else cardinal_chain(points, closed)


def room_of(chain: Array, tolerance: float) -> Array:
    """Return how far a fit may stray from each chord (chords,)."""
    return tolerance + BULGE * bulges(chain, 0.02 * tolerance)


def _straight(points: Array) -> tuple[BSpline, Array]:
    """Return the segment between two points."""
    length = float(np.linalg.norm(points[1] - points[0]))
    poles = straight_chain(points, closed=False)[0]
    poles[-1] = points[1]
    return BSpline(own(poles), np.repeat([0.0, length], 4)), np.array([0.0, length])


def _found(stretch: Stretch, best: bool) -> Check:
    """Return a curve that holds: grown until it does, then with fewer spans as long as it does."""
    n = len(stretch.points)
    rows = np.arange(n) if n <= _MANY else _spread(np.array([0, n - 1]), _SOME)
    goal = stretch.goal(rows)
    trial = grow(goal, np.linspace(0.0, goal.period, 5 if goal.closed else 2), goal.u)
    grown, rows = _mended(stretch, trial, rows)
    if not grown.passed:
        grown, rows = _surely(stretch), np.arange(n)
    trial = fewest(grown.trial, *(_BEST if best else _FAST))
    if trial is grown.trial:
        return grown
    fewer, _ = _mended(stretch, trial, rows)
    return fewer if fewer.passed and len(fewer.spline.poles) < len(grown.spline.poles) else grown


def _mended(stretch: Stretch, trial: Trial, rows: Ints) -> tuple[Check, Ints]:
    """Return the check of the trial, fitted again with more points or targets where it did not pass; and its rows."""
    for _ in range(_ROUNDS):
        check = _checked(stretch, trial, rows)
        if check.passed or not trial.met:
            break
        if len(rows) < len(stretch.points):
            rows = _more_rows(check, rows)
            goal = _carried(stretch.goal(rows), check, rows)
            trial = start(goal, trial.curve.spans.knots, goal.u)
        else:
            trial = _watched(trial, check.straying)
        trial = relax(trial, 8, move_knots=True)
        if not trial.met:
            trial = grow(trial.goal, trial.curve.spans.knots, trial.u)
    return check, rows


def _checked(stretch: Stretch, trial: Trial, rows: Ints) -> Check:
    """Return what of the stretch the trial, fitted to some of its points, does not hold."""
    points, goal, spans = stretch.points, trial.goal, trial.curve.spans
    spline, u = spans.spline(trial.curve.poles), trial.u[goal.data]
    if len(rows) < len(points):
        u = _all_feet(stretch, trial, rows)
    else:
        u = feet(trial.curve, points.T, u, goal.period if stretch.closed else None)
    if not stretch.closed:
        error = distances(spline, points, u) / stretch.tolerance
        return Check(trial, spline, u, error, straying_chords(spline, points, u, stretch.room))
    if u[0] < spans.knots[0]:
        u += goal.period
    twice, contour, at = unrolled(spline, points, u)
    error = distances(twice, contour, at)[:-1] / stretch.tolerance
    return Check(trial, spline, u, error, straying_chords(twice, contour, at, stretch.room))


def _all_feet(stretch: Stretch, trial: Trial, rows: Ints) -> Array:
    """Return the parameters (n,) of all points' foot points, in order, on a curve fitted to some rows of them.

    They start from the polyline's lengths between those rows. Where foot points are out of order, which noise brings
    about, they move by as little as can be: to the middle of the largest so far and the smallest still to come.
    """
    n, period = len(stretch.points), trial.goal.period
    around = np.concatenate([stretch.points, stretch.points[:1]]) if stretch.closed else stretch.points
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))])
    known = np.append(trial.u[trial.goal.data], trial.u[0] + period)
    rows = np.append(rows, n)[: len(rows) + stretch.closed]
    u = np.interp(along[:n], along[rows], known[: len(rows)])
    reach = 2.0 * period / len(rows)
    for _ in range(_FEET):
        u = u + np.clip(foot_steps(trial.curve, stretch.points.T, u, period if stretch.closed else None), -reach, reach)
    if stretch.closed:
        u = np.concatenate([u - period, u, u + period])
    else:
        u[0], u[-1] = known[0], known[-2]
        u = np.clip(u, known[0], known[-2])
    u = 0.5 * (np.maximum.accumulate(u) + np.minimum.accumulate(u[::-1])[::-1])
    return np.asarray(u[n : 2 * n] if stretch.closed else u)


def _more_rows(check: Check, rows: Ints) -> Ints:
    """Return the rows fitted so far, with the worst of each quarter span where points are out of tolerance, and others.

    Those are the ends of chords that the curve strays from; and rows in between where there are few for so many spans.
    """
    n, spans = len(check.u), check.trial.curve.spans
    far = _worst(check, np.flatnonzero(check.error > 1.0), check.error)
    either = np.maximum(check.error, np.roll(check.error, -1))  # end of a chord
    chords = _worst(check, check.straying[either[check.straying] <= 1.0], either)
    more = np.unique(np.concatenate([rows, far, chords, (chords + 1) % n]))
    if len(more) < _ROWS_A_SPAN * spans.count or len(more) < 1.02 * len(rows):
        more = _spread(more, 2 * len(more))
    return more if len(more) < 0.5 * n else np.arange(n)


def _worst(check: Check, rows: Ints, error: Array) -> Ints:
    """Return of some rows the one with the largest error in each quarter of a span."""
    spans = check.trial.curve.spans
    span = spans.find(check.u[rows])
    quarter = 4 * span + (4.0 * spans.local(check.u[rows], span)[0]).astype(np.intp)
    order = np.lexsort([-error[rows], quarter])
    return rows[order[np.unique(quarter[order], return_index=True)[1]]]


def _spread(rows: Ints, count: int) -> Ints:
    """Return the rows, the first and the last of all among them, with about so many spread evenly between them."""
    gap = np.diff(rows)
    parts = np.maximum(np.round(gap * (count / rows[-1])), 1).astype(np.intp)
    place = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.unique(
        np.append(np.repeat(rows[:-1], parts) + np.repeat(gap, parts) * place // np.repeat(parts, parts), rows[-1])
    )


def _carried(goal: Targets, check: Check, rows: Ints) -> Targets:
    """Return the targets of some rows with parameters on the curve that was checked."""
    period, u = check.trial.goal.period, check.u[rows]
    before = np.append(goal.u[goal.data], goal.u[0] + goal.period)
    return replace(goal, u=np.interp(goal.u, before, np.append(u, u[0] + period)), period=period)


def _watched(trial: Trial, chords: Ints) -> Trial:
    """Return the trial with a target on each of the chords, where the curve strays most."""
    goal = trial.goal
    u = np.append(trial.u[goal.data], trial.u[0] + goal.period)
    within = np.arange(1, 64)[:, None] / 64.0
    at = u[chords] + within * (u[chords + 1] - u[chords])
    places = trial.curve.points(at.ravel(), trial.curve.spans.find(at.ravel()))
    far = goal.straying(places, np.tile(chords, len(within))).reshape(at.shape)
    return watched(trial, chords, within[np.argmax(far, axis=0), 0])


def _surely(stretch: Stretch) -> Check:
    """Return the points' own chain, its joints rounded as little as it takes.

    Raises ValueError where that does not do, either: the end tangents lead out of the tolerance.
    """
    rows = np.arange(len(stretch.points))
    goal = stretch.goal(rows)
    for share in 0.2 ** np.arange(1, 14):
        check = _checked(stretch, rounded(goal, stretch.polyline, share), rows)
        if check.passed:
            return check
    raise ValueError(
        "no curve was found within the tolerance: is it near the rounding errors, or an end tangent wrong?"
    )
