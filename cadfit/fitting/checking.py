"""What of a stretch a trial does not hold: all its points, and the curve between them, whichever were fitted."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.fitting.deviation import straying_chords, unrolled
from cadfit.fitting.feet import feet, look, newton, within
from cadfit.fitting.matching import distances
from cadfit.fitting.relax import Trial
from cadfit.fitting.spans import dot
from cadfit.fitting.targets import BULGE, Targets, bulges, cardinal_chain, straight_chain, targets, with_samples
from cadfit.fitting.turning import loops
from cadfit.points.measures import blocks, lengths_along
from cadfit.stages import stage

_FEET = 2  # Newton steps toward the foot points of those not fitted
_ROUNDS = 8  # of them where the farthest is not at its own
_WORTH = 0.98  # of its squared distance: so much nearer it has to come at the first step
SURER = 0.97  # of the tolerance, for some of the points: so the others keep it sooner
_EPS = float(np.finfo(np.float64).eps)
_NONE = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, eq=False)
class Stretch:
    """Points (n, d) about their middle at unit size, and what the fit is held to there.

    `weights` (n,): of the points in the least squares. `doubled` (n,): where several are all but equal, and one stands
    for them: the cardinal curve through all would hold there, so the fit has less room beside. `tangents`: directions
    at the two ends, where given.
    """

    points: Array
    tolerance: float
    closed: bool
    polyline: bool
    weights: Array
    doubled: NDArray[np.bool_]
    tangents: tuple[Array | None, Array | None]

    @cached_property
    def chain(self) -> Array:
        """The curve between the points that says how far the fit may stray: Bézier pieces (chords, 4, d)."""
        chain = chain_of(self.points, self.closed, self.polyline)
        if self.doubled.any() and not self.polyline:
            before, after = np.roll(self.doubled, -1)[: len(chain)], self.doubled[: len(chain)]
            chain[before, 2], chain[after, 1] = chain[before, 3], chain[after, 0]
        return chain

    @cached_property
    def room(self) -> Array:
        """How far the curve may stray from each chord (chords,)."""
        return room_of(self.chain, self.tolerance)

    @property
    def most(self) -> float:
        """How many spans are tried to smooth it with: where more are needed, what is sure to hold takes fewer poles.

        That is the points' cardinal chain, at two poles a chord (and what grew a little past that often loses more of
        them than the chain does), or the polyline with its corners rounded.
        """
        return float(len(self.points) if self.polyline else 3 * len(self.points))

    @cached_property
    def along(self) -> Array:
        """How long the polyline of the points is up to each of them; where closed, and back to the first."""
        return lengths_along(np.concatenate([self.points, self.points[:1]]) if self.closed else self.points)

    def goal(self, rows: Ints) -> Targets:
        """Return the targets that some of the points make; all of them with samples of the chain between."""
        weights = self.weights[rows]
        if len(rows) < len(self.points):
            chain = chain_of(self.points[rows], self.closed, self.polyline)
            tolerance = SURER * self.tolerance
            room = self.tolerance + BULGE * self._left_out(rows)
            return targets(
                self.points[rows], chain, room, tolerance, weights, self.closed, self.polyline, self.tangents
            )
        goal = targets(
            self.points, self.chain, self.room, self.tolerance, weights, self.closed, self.polyline, self.tangents
        )
        return with_samples(goal)

    def _left_out(self, rows: Ints) -> Array:
        """Return how far the points between each of the rows (the first among them) and the next are from the chord."""
        ends = np.append(rows, len(self.points)) if self.closed else rows
        chord = np.repeat(np.arange(len(ends) - 1), np.diff(ends))
        start, along = self.points[rows], np.diff(self.points[ends % len(self.points)], axis=0)
        along = along / np.maximum(np.linalg.norm(along, axis=1), _EPS)[:, None]
        points, square = self.points[: len(chord)], np.empty(len(chord))
        for some in blocks(len(chord)):
            gap, direction = points[some] - start[chord[some]], along[chord[some]]
            gap -= np.einsum("nd,nd->n", gap, direction)[:, None] * direction
            square[some] = np.einsum("nd,nd->n", gap, gap)
        return np.asarray(np.sqrt(np.maximum.reduceat(square, ends[:-1])))


@dataclass(frozen=True, slots=True, eq=False)
class Check:
    """A trial's curve as a BSpline, and how all points of the stretch lie to it.

    `u` (n,): their parameters; `error` (n,): their distances in tolerances; `straying`: the chords that the curve is
    not certain to stay near; `loops`: whether it turns much more than the polyline that it is to follow.
    """

    trial: Trial
    spline: BSpline
    u: Array
    error: Array
    straying: Ints
    loops: bool

    @property
    def passed(self) -> bool:
        """Whether everything holds."""
        return float(self.error.max()) <= 1.0 and not len(self.straying) and not self.loops


@stage("checking the promise")
def checked(stretch: Stretch, trial: Trial, rows: Ints) -> Check:
    """Return what of the stretch the trial, fitted to some of its points, does not hold.

    Which chords the curve strays from is found where the points are within the tolerance.
    """
    if len(rows) < len(stretch.points):
        return _checked_at(stretch, trial, _all_feet(stretch, trial, rows), rows)
    cycle = trial.goal.period if stretch.closed else None
    return _checked_at(stretch, trial, feet(trial.curve, stretch.points.T, trial.u[trial.goal.data], cycle), rows)


def _checked_at(stretch: Stretch, trial: Trial, u: Array, rows: Ints) -> Check:
    """Return the check for the points at the parameters u (n,), closed a period on where they are before the start."""
    points, spline = stretch.points, trial.curve.spans.spline(trial.curve.poles)
    if stretch.closed and u[0] < trial.curve.spans.knots[0]:
        u = u + trial.goal.period
    twice, contour, at = unrolled(spline, points, u) if stretch.closed else (spline, points, u)
    gaps = distances(twice, contour, at)
    error = gaps[: len(points)] / stretch.tolerance
    near = error.max() <= 1.0
    strayed = _strayed(stretch, twice, contour, at, gaps, rows) if near else _NONE
    looped = _NONE
    if near and stretch.polyline:
        looped = loops(trial.curve, points.T, u, stretch.tolerance, stretch.tangents)
    return Check(trial, spline, u, error, strayed, len(looped) > 0)


@stage("finding the nearest places")
def nearer(stretch: Stretch, check: Check) -> Check:
    """Return the check with points at their foot points where the farthest is not at its own, and comes nearer so.

    While fitting, points move less than half of the way to the next ones, which short of dense ones' foot points ends.
    """
    trial, worst = check.trial, [int(np.argmax(check.error))]
    cycle, reach = trial.goal.period if stretch.closed else None, 2.0 * stretch.tolerance
    there = _toward_feet(trial, stretch.points[worst].T, check.u[worst], cycle, reach, 1)[1]
    if there[0] > _WORTH * (check.error.max() * stretch.tolerance) ** 2:
        return check
    u = _in_order(stretch, trial, _toward_feet(trial, stretch.points.T, check.u, cycle, reach, _ROUNDS)[0])
    found = _checked_at(stretch, trial, u, np.arange(len(u)))
    return found if found.passed and found.error.max() < check.error.max() else check


def _strayed(stretch: Stretch, spline: BSpline, points: Array, u: Array, gaps: Array, rows: Ints) -> Ints:
    """Return the chords that the curve is not certain to stay near."""
    least = np.full(len(u) - 1, stretch.tolerance)
    if len(rows) < len(stretch.points) and not len(straying_chords(spline, points, u, gaps, least)):
        return _NONE  # of many chords, all do without the room that their bulge would give them
    return straying_chords(spline, points, u, gaps, stretch.room)


def _all_feet(stretch: Stretch, trial: Trial, rows: Ints) -> Array:
    """Return the parameters (n,) of all points' foot points, in order, on a curve fitted to some rows of them.

    They start from the polyline's lengths between those rows. Where foot points are out of order, which noise brings
    about, they move by as little as can be: to the middle of the largest so far and the smallest still to come.
    """
    n, period, along = len(stretch.points), trial.goal.period, stretch.along
    known = np.append(trial.u[trial.goal.data], trial.u[0] + period)
    rows = np.append(rows, n)[: len(rows) + stretch.closed]
    u = np.interp(along[:n], along[rows], known[: len(rows)])
    cycle = period if stretch.closed else None
    return _in_order(
        stretch, trial, _toward_feet(trial, stretch.points.T, u, cycle, 2.0 * period / len(rows), _FEET)[0]
    )


def _toward_feet(
    trial: Trial, places: Array, u: Array, cycle: float | None, reach: float, steps: int
) -> tuple[Array, Array]:
    """Return the parameters (n,) that Newton's steps, none above `reach`, lead to from u, and the squared distances.

    A step that leads away from a place (d, n) is its last, and not taken.
    """
    reached, square, (low, high) = np.empty(len(u)), np.empty(len(u)), trial.curve.spans.knots[[0, -1]]
    for rows in blocks(len(u)):
        there, at = places[:, rows], u[rows]
        seen = look(trial.curve, within(trial.curve, at, cycle))
        least = dot(seen.places - there, seen.places - there)
        coming = np.ones(len(at), dtype=np.bool_)
        for _ in range(steps):
            moved = at + np.clip(newton(trial.curve, there, seen), -reach, reach)
            moved = moved if cycle is not None else np.clip(moved, low, high)
            seen = look(trial.curve, within(trial.curve, moved, cycle))
            far = dot(seen.places - there, seen.places - there)
            coming &= far < least
            at, least = np.where(coming, moved, at), np.where(coming, far, least)
        reached[rows], square[rows] = at, least
    return reached, square


def _in_order(stretch: Stretch, trial: Trial, u: Array) -> Array:
    """Return parameters (n,) that rise: what is out of order is moved as little as can be, to the middle."""
    n, period, knots = len(u), trial.goal.period, trial.curve.spans.knots
    if stretch.closed:
        u = np.concatenate([u - period, u, u + period])
    else:
        u[0], u[-1] = knots[0], knots[-1]
    u = 0.5 * (np.maximum.accumulate(u) + np.minimum.accumulate(u[::-1])[::-1])
    return np.asarray(u[n : 2 * n] if stretch.closed else u)


def chain_of(points: Array, closed: bool, polyline: bool) -> Array:
    """Return the curve between points (n, d) that says how far a fit may stray: Bézier pieces (chords, 4, d)."""
    return straight_chain(points, closed) if polyline else cardinal_chain(points, closed)


def room_of(chain: Array, tolerance: float) -> Array:
    """Return how far a fit may stray from each chord (chords,)."""
    return tolerance + BULGE * bulges(chain, 0.02 * tolerance)
