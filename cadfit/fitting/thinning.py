"""Knots taken away at many places at once: where the curve does not hold without them, they are given back.

One after the other would take as many fits as there are knots. Far from where it was none is missed: so many are tried
in each.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array
from cadfit.fitting.relax import Trial, looping
from cadfit.stages import Progress

Mask = NDArray[np.bool_]


def thinned(
    trial: Trial,
    choose: Callable[[Trial, Mask], Mask],
    fitted: Callable[[Trial, Array], Trial],
    rounds: int,
    reaches: range,
    progress: Progress,
) -> Iterator[Trial]:
    """Yield the trial without ever more of the knots that it can do without.

    `choose` says which of the inner knots to take away next, given which are known to be needed, both in the order of
    `in_order`; `fitted` makes a trial with fewer knots. Those near which that does not hold stay, and the others are
    taken away alone: near means so many spans, the next of `reaches` each time.
    """
    needed = np.zeros(len(_inner(trial)), dtype=bool)
    for turn in range(rounds):
        progress(turn / rounds)
        gone = choose(trial, needed)
        if not gone.any():
            break
        fewer, needed = _without(trial, gone, needed, fitted, reaches)
        if fewer is not trial:
            trial = fewer
            yield trial


def in_order(trial: Trial, values: Array) -> Array:
    """Return the values (k,) of inner knots, closed of spans' starts, as parameters rise from 0 however it is begun."""
    knots = trial.curve.spans.knots
    return values[np.argsort(knots[:-1] % trial.goal.period)] if trial.goal.closed else values


def _without(
    trial: Trial, gone: Mask, needed: Mask, fitted: Callable[[Trial, Array], Trial], reaches: range
) -> tuple[Trial, Mask]:
    """Return the trial without those of some knots that turn out not to be needed, and which of its knots are."""
    knots = _inner(trial)
    for reach in reaches:
        fewer = fitted(trial, _around(trial, knots[~gone]))
        if fewer.met and not len(looping(fewer)):
            return fewer, needed[~gone]
        back = gone & _concerned(fewer, knots, reach)
        needed = needed | (back if back.any() else gone)
        gone = gone & ~needed
        if not gone.any():
            break
    return trial, needed | gone


def _inner(trial: Trial) -> Array:
    """Return the knots that may go, rising; of closed curves those in one period from 0."""
    knots = trial.curve.spans.knots
    return np.sort(knots[:-1] % trial.goal.period) if trial.goal.closed else knots[1:-1]


def _around(trial: Trial, inner: Array) -> Array:
    """Return all knots of the curve with these inner ones."""
    if trial.goal.closed:
        return np.append(inner, inner[0] + trial.goal.period)
    return np.concatenate([trial.curve.spans.knots[:1], inner, trial.curve.spans.knots[-1:]])


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
