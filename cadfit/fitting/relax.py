"""Bring a spline with so many knots as near to its targets as it gets: poles, foot points and knots in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.feet import Look, Place, found, look, look_at, newton, slid, within, wrapped
from cadfit.fitting.spans import Curve, dot
from cadfit.fitting.steps import averaged, held, nearest, with_knots, with_poles
from cadfit.fitting.targets import Targets, sampled
from cadfit.fitting.turning import loops

_LOOKS = np.arange(1, 8) / 8.0
_SHIFT = 0.5  # how strongly weight goes to large errors
_CALM = 0.3  # the same with moving knots, where there are many passes
_ROUNDING = 1e-9  # of the room: bounds that near it are looked at more closely
_NO_ERROR = 1e-100  # of all targets together: then no weight is shifted
_STEPS = 2
_PATIENCE = 6  # passes over which a rate is taken, at most: to wait for nine found next to nothing more


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A curve for some targets, their parameters (n,) and weights (n,), and errors in parts of what is allowed.

    `worst` is the largest error. `met`: it is no more than 1, and the curve strays nowhere between the targets.
    """

    goal: Targets
    curve: Curve
    u: Array
    weights: Array
    seen: Look
    error: Array
    worst: float
    met: bool = False


def measured(goal: Targets, curve: Curve, u: Array, weights: Array, seen: Look | None = None) -> Trial:
    """Return the trial with the errors of the curve: of points the distance, between them how far it strays.

    `seen`: how the curve is seen at u, where that is known.
    """
    turned, u = wrapped(curve, u)
    if seen is None or turned is not curve:
        curve, seen = turned, look(turned, u)
    gap = goal.points - seen.places
    error = np.sqrt(dot(gap, gap)) / goal.allowed
    if len(goal.between):
        error[goal.between] = goal.straying(seen.places[:, goal.between], goal.row[goal.between])
    return Trial(goal, curve, u, weights, seen, error, float(error.max()))


def start(goal: Targets, knots: Array, u: Array) -> Trial:
    """Return the least-squares curve with these knots for targets at these parameters."""
    curve, u = wrapped(averaged(goal, knots, u), u)
    at = found(curve.spans, u)
    curve = with_poles(goal, curve, look_at(curve, at), goal.weights, 1.0) if held(goal) else nearest(goal, curve, at)
    return measured(goal, curve, u, goal.weights, look_at(curve, at))


def relax(trial: Trial, passes: int, move_knots: bool) -> Trial:
    """Return the best trial of so many passes, stopping at the first that meets the targets, and strays nowhere.

    A pass shifts weight to the largest errors, solves for the poles (and knots), and lets the foot points slide. Where
    the targets are met but the curve strays between them, targets are added. It stops early where the passes left
    would not do at the rate of the last few: most trials fail, so that is where the time goes.
    """
    exponent = min(_CALM + 1.35 / passes, _SHIFT) if move_knots else _SHIFT  # bolder the fewer passes there are
    best = trial = checked(trial)
    worst, window = [best.worst], min(2 + passes // 8, _PATIENCE)
    for left in range(passes, 0, -1):
        gained = worst[-1 - window] - worst[-1] if len(worst) > window else np.inf
        if trial.met or (worst[-1] - 1.0) * window > left * gained:
            break
        trial = _shifted(trial, exponent, move_knots)
        if trial.worst < best.worst or len(trial.u) > len(best.u):
            best = trial
        worst.append(best.worst)
    return trial if trial.met else best


def settled(trial: Trial, passes: int) -> Trial:
    """Return the trial of the least largest error among so many passes on from one that meets its targets, knots moved.

    `relax` stops where the targets are met; with knots as good as they get, others can be taken away.
    """
    best = trial
    for _ in range(passes):
        trial = _shifted(trial, _CALM, True)
        if trial.met and trial.worst < best.worst:
            best = trial
    return best


def _shifted(trial: Trial, exponent: float, move_knots: bool) -> Trial:
    """Return the trial after a pass with weight shifted to the largest errors, as strongly as the exponent says."""
    count = len(trial.error)  # sums, since means take several times as long
    weights = trial.weights * (trial.error * (0.9 * count / (np.add.reduce(trial.error) + _NO_ERROR)) + 0.1) ** exponent
    weights *= count / np.add.reduce(weights)
    return checked(_passed(trial, weights, move_knots))


def _passed(trial: Trial, weights: Array, move_knots: bool) -> Trial:
    """Return the trial after one pass: the knots moved, the poles solved for, the foot points slid along."""
    goal, curve, u, seen = trial.goal, trial.curve, trial.u, trial.seen
    if move_knots:
        curve, u = wrapped(with_knots(goal, curve, seen, weights), u)
        seen = look(curve, u)
    return slid_feet(goal, with_poles(goal, curve, seen, weights), u, weights, seen.at)


def slid_feet(goal: Targets, curve: Curve, u: Array, weights: Array, at: Place) -> Trial:
    """Return the trial of a curve with the targets' parameters u (n,), which are at that place of it, slid along."""
    seen, period = look_at(curve, at), goal.period if goal.closed else None
    for _ in range(_STEPS):
        u = slid(u, newton(curve, goal.points, seen), period)
        seen = look(curve, within(curve, u, period))
    return measured(goal, curve, u, weights, seen)


def checked(trial: Trial) -> Trial:
    """Return the trial as met, or where only the places between the targets keep it from that, with targets there."""
    if trial.worst > 1.0:
        return trial
    strayed, at = strays(trial)
    return watched(trial, strayed, at) if len(strayed) else replace(trial, met=True)


def looping(trial: Trial) -> Ints:
    """Return the spans on which the curve loops or wiggles where the polyline that it is to follow does not."""
    goal, data = trial.goal, trial.goal.data
    if not goal.polyline:
        return np.zeros(0, dtype=np.intp)
    return loops(trial.curve, goal.points[:, data], trial.u[data], float(goal.allowed[0]), goal.tangents)


def watched(trial: Trial, chords: Ints, at: Array) -> Trial:
    """Return the trial with one more target on each of the chords (k,), at the places `at` (k,) in [0, 1]."""
    goal, u, order = sampled(trial.goal, trial.u, chords, at, at)
    weights = np.concatenate([trial.weights, np.full(len(chords), trial.weights.mean())])[order]
    return measured(goal, trial.curve, u, weights)


def strays(trial: Trial) -> tuple[Ints, Array]:
    """Return the chords that the curve strays from farther than there is room, and where most, of seven samples."""
    goal = trial.goal
    u = np.append(trial.u[goal.data], trial.u[0] + goal.period)[: len(goal.room) + 1]
    chords = _in_doubt(trial, u)
    at = (u[chords] + _LOOKS[:, None] * (u[chords + 1] - u[chords])).ravel()
    places = trial.curve.points(at, trial.curve.spans.find(at))
    found = goal.straying(places, np.tile(chords, len(_LOOKS))).reshape(len(_LOOKS), -1)
    strayed = np.flatnonzero((found > 1.0).any(axis=0))
    return chords[strayed], _LOOKS[np.argmax(found[:, strayed], axis=0)]


def _in_doubt(trial: Trial, u: Array) -> Ints:
    """Return the chords that the curve is not sure to stay near; u (chords + 1,) are their ends' parameters.

    A piece of it is off its own chord by no more than an eighth of its largest second derivative times the square of
    the parameters' difference, and that chord off the points' by no more than the farther end.
    """
    goal, curve, seen = trial.goal, trial.curve, trial.seen
    bends = 6.0 * seen.at.local * seen.powers[3] + 2.0 * seen.powers[2]
    bends = np.sqrt(dot(bends, bends)) / curve.spans.steps[seen.at.wrapped] ** 2
    gaps, bends = (trial.error * goal.allowed)[goal.data], bends[goal.data]
    if goal.closed:
        gaps, bends = np.append(gaps, gaps[0]), np.append(bends, bends[0])
    bend = np.maximum(bends[:-1], bends[1:])
    starts = 2.0 * curve.powers[2, :, 1:]  # between two parameters it is linear, but for the knots there
    at = np.searchsorted(u, curve.spans.knots[1:-1]) - 1
    np.maximum.at(bend, at, np.sqrt(dot(starts, starts)) / curve.spans.steps[1:] ** 2)
    off = np.maximum(gaps[:-1], gaps[1:]) + 0.125 * bend * (u[1:] - u[:-1]) ** 2
    return np.flatnonzero(off > (1.0 - _ROUNDING) * goal.room)
