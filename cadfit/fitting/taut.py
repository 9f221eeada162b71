"""The least bent curve within the tolerance of a polyline: what follows chords and rounds corners, and never wiggles.

Where the tolerance is below the chords' sagitta, least squares have nothing to smooth: they swing about the chords, and
with more knots they loop at the vertices. Here only what is beyond the tolerance is drawn in, and the curve resists by
its bending energy, ever less. So it bends no more than it has to.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cadfit.bezier import Array
from cadfit.fitting.feet import wrapped
from cadfit.fitting.knots import importance
from cadfit.fitting.relax import Trial, checked, measured, slid_feet
from cadfit.fitting.squares import for_all, local
from cadfit.fitting.steps import averaged, solved, sums
from cadfit.fitting.targets import Targets
from cadfit.fitting.thinning import Mask, in_order, thinned
from cadfit.stages import Progress, unheard

_INSIDE = 0.9  # of what is allowed: so far in is drawn what is beyond it
_REST = 0.01  # the weight of what is within: it tends to stay
_ALONG = 0.05  # of a residual's part along the curve
_STIFF, _SOFTER, _PASSES = 500.0, 0.4, 12  # the bending's weight in tolerances, at first; times that each pass
_DAMPING = 1e-9
_SWEEPS, _ROUNDS, _REACHES = 2, 20, range(1, 9)
_BENDING = np.zeros((4, 4))  # the integrals over [0, 1] of products of the second derivatives of 1, x, x^2 and x^3
_BENDING[2:, 2:] = [[4.0, 6.0], [6.0, 12.0]]


def thinned_taut(trial: Trial, progress: Progress = unheard) -> Iterator[Trial]:
    """Yield the trial without ever more of the knots that it can do without, the curve being as little bent as it can.

    Each round takes away knots that are missed less than their neighbours; so the rounds are few, however long the
    curve is.
    """
    for _ in range(_SWEEPS):
        before = trial
        for fewer in thinned(trial, _least_missed, _taut_with, _ROUNDS, _REACHES, progress):
            yield (trial := fewer)
        if trial is before:
            break


def _taut_with(trial: Trial, knots: Array) -> Trial:
    return taut(trial.goal, knots, trial.u)


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


def _least_missed(trial: Trial, needed: Mask) -> Mask:
    """Return which of the inner knots are missed less than both neighbours, of those that are not needed."""
    missed, closed = np.where(needed, np.inf, in_order(trial, importance(trial))), trial.goal.closed
    before, after = np.roll(missed, 1), np.roll(missed, -1)
    if not closed:
        before[:1] = after[-1:] = np.inf
    gone = (missed < before) & (missed <= after)
    if closed and len(gone) - gone.sum() < 4:
        gone[:] = False
    return gone
