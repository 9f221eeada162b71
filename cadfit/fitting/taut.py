"""The least bent curve within the tolerance of a polyline: what follows chords and rounds corners, and never wiggles.

Where the tolerance is below the chords' sagitta, least squares have nothing to smooth: they swing about the chords, and
with more knots they loop at the vertices. Here only what is beyond the tolerance is drawn in, and the curve resists by
its bending energy, ever less. So it bends no more than it has to.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array
from cadfit.fitting.feet import wrapped
from cadfit.fitting.relax import Trial, checked, looping, measured, slid_feet
from cadfit.fitting.search import importance
from cadfit.fitting.squares import for_all, local
from cadfit.fitting.steps import averaged, solved, sums
from cadfit.fitting.targets import Targets
from cadfit.stages import Progress, unheard

Mask = NDArray[np.bool_]

_INSIDE = 0.9  # of what is allowed: so far in is drawn what is beyond it
_REST = 0.01  # the weight of what is within: it tends to stay
_ALONG = 0.05  # of a residual's part along the curve
_STIFF, _SOFTER, _PASSES = 500.0, 0.4, 12  # the bending's weight in tolerances, at first; times that each pass
_DAMPING = 1e-9
_SWEEPS, _ROUNDS, _REPAIRS = 2, 20, 8
_BENDING = np.zeros((4, 4))  # the integrals over [0, 1] of products of the second derivatives of 1, x, x^2 and x^3
_BENDING[2:, 2:] = [[4.0, 6.0], [6.0, 12.0]]


def thinned(trial: Trial, progress: Progress = unheard) -> Iterator[Trial]:
    """Yield the trial without ever more of the knots that it can do without, those missed least first.

    Each round takes away knots that are missed less than their neighbours, and gives those back near which the curve
    then does not hold. They stay, at first; so the rounds are few, however long the curve is.
    """
    for _ in range(_SWEEPS):
        before, needed = trial, np.zeros(len(_inner(trial)), dtype=bool)
        for turn in range(_ROUNDS):
            progress(turn / _ROUNDS)
            gone = _least_missed(trial, needed)
            if not gone.any():
                break
            fewer, needed = _without(trial, gone, needed)
            if fewer is not trial:
                trial = fewer
                yield trial
        if trial is before:
            break


def _without(trial: Trial, gone: Mask, needed: Mask) -> tuple[Trial, Mask]:
    """Return the trial without those of some knots that turn out not to be needed, and which of its knots are."""
    knots = _inner(trial)
    for reach in range(1, _REPAIRS + 1):
        fewer = taut(trial.goal, _around(trial, knots[~gone]), trial.u)
        if fewer.met and not len(looping(fewer)):
            return fewer, needed[~gone]
        back = gone & _concerned(fewer, knots, reach)
        needed = needed | (back if back.any() else gone)
        gone = gone & ~needed
        if not gone.any():
            break
    return trial, needed | gone


def taut(goal: Targets, knots: Array, u: Array) -> Trial:
    """Return the trial of the least bent curve with these knots that meets the targets, from Schoenberg's curve on."""
    curve, u = wrapped(averaged(goal, knots, u), u)
    return tightened(measured(goal, curve, u, goal.weights))


def tightened(trial: Trial, first: int = 0) -> Trial:
    """Return the trial of the least bent curve with the same knots that meets the targets, or else of the last pass.

    Each pass solves for the poles that draw in what is beyond the tolerance, and lets the foot points slide. Where
    little is beyond, the `first` may be a later, softer one.
    """
    trial = checked(trial)
    for turn in range(first, _PASSES):
        if trial.worst <= 1.0:
            break
        trial = checked(_passed(trial, _STIFF * _SOFTER**turn * float(trial.goal.allowed[0])))
    return trial


def _passed(trial: Trial, stiffness: float) -> Trial:
    """Return the trial after one pass at this weight of the bending energy."""
    goal, curve, u, seen = trial.goal, trial.curve, trial.u, trial.seen
    spans, d = curve.spans, len(curve.poles)
    beyond = np.maximum(1.0 - _INSIDE / np.maximum(trial.error, _INSIDE), 0.0)
    weight = np.where(beyond > 0.0, 1.0, _REST) / goal.allowed**2
    squares, pulls = sums(curve, seen, beyond * (goal.points - seen.places), weight, _ALONG)
    bending = _BENDING * (stiffness / spans.steps**3)[:, None, None]  # (m, 4, 4)
    squares += for_all(bending, d)
    pulls -= (bending @ curve.powers.transpose(2, 0, 1)).reshape(pulls.shape)
    matrices, sides = local(squares, pulls, for_all(spans.matrices, d))
    return slid_feet(goal, solved(goal, curve, matrices, sides, _DAMPING), u, trial.weights, seen.at)


def _inner(trial: Trial) -> Array:
    """Return the knots that may go, rising; of closed curves those in one period from 0."""
    knots = trial.curve.spans.knots
    return np.sort(knots[:-1] % trial.goal.period) if trial.goal.closed else knots[1:-1]


def _around(trial: Trial, inner: Array) -> Array:
    """Return all knots of the curve with these inner ones."""
    if trial.goal.closed:
        return np.append(inner, inner[0] + trial.goal.period)
    return np.concatenate([trial.curve.spans.knots[:1], inner, trial.curve.spans.knots[-1:]])


def _least_missed(trial: Trial, needed: Mask) -> Mask:
    """Return which of the inner knots are missed less than both neighbours, of those that are not needed."""
    missed, closed = importance(trial), trial.goal.closed
    if closed:
        missed = missed[np.argsort(trial.curve.spans.knots[:-1] % trial.goal.period)]
    missed = np.where(needed, np.inf, missed)
    before, after = np.roll(missed, 1), np.roll(missed, -1)
    if not closed:
        before[:1] = after[-1:] = np.inf
    gone = (missed < before) & (missed <= after)
    if closed and len(gone) - gone.sum() < 4:
        gone[:] = False
    return gone


def _concerned(fewer: Trial, knots: Array, reach: int) -> Mask:
    """Return which of the knots lie in a span where the trial does not hold, or up to so many spans away."""
    spans = fewer.curve.spans
    bad = np.zeros(spans.count, dtype=bool)
    bad[spans.find(fewer.u[fewer.error > 1.0]) % spans.count] = True
    if fewer.worst <= 1.0:
        bad[looping(fewer)] = True
    near = np.any([np.roll(bad, k) for k in range(-reach, reach + 1)], axis=0)
    if spans.closed:
        knots = spans.knots[0] + (knots - spans.knots[0]) % fewer.goal.period
    return np.asarray(near[spans.find(knots) % spans.count])
