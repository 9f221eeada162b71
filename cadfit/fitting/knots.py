"""Which knots a spline may do without, and where fewer of them belong."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.fitting.relax import Trial
from cadfit.fitting.spans import Spans

_JUMP_ERROR = 1.0 / 162.0  # how far |x|^3 / 12, whose third derivative jumps by 1, is off its best cubic on [-1, 1]


def by_removal(trial: Trial, m: int) -> Array:
    """Return the knots without those that are missed least."""
    spans = trial.curve.spans
    missed = importance(trial).tolist()
    gone = np.zeros(len(missed), dtype=bool)
    queue = [(least, k) for k, least in enumerate(missed)]
    heapify(queue)
    left = spans.count - m
    while left:
        least, k = heappop(queue)
        if gone[k] or least != missed[k]:
            continue
        gone[k] = True
        left -= 1
        for j in (k - 1, k + 1):  # each removal makes its neighbours dearer
            if spans.closed or 0 <= j < len(missed):
                j %= len(missed)
                missed[j] *= 4.0
                heappush(queue, (missed[j], j))
    return without(spans, gone)


def exchanged(trial: Trial) -> Array:
    """Return the knots with one more in the span of the largest error, and without another that is missed least."""
    spans = trial.curve.spans
    k = int(spans.find(trial.u[[np.argmax(trial.error)]])[0]) % spans.count
    missed = importance(trial)
    ends = np.array([k, k + 1]) % spans.count if spans.closed else np.array([k - 1, k])
    missed[ends[(ends >= 0) & (ends < len(missed))]] = np.inf
    gone = np.arange(len(missed)) == np.argmin(missed)
    return np.sort(np.append(without(spans, gone), 0.5 * (spans.knots[k] + spans.knots[k + 1])))


def without(spans: Spans, gone: NDArray[np.bool_]) -> Array:
    """Return the knots without some of the inner ones, closed of the starts of spans."""
    knots = spans.knots
    if spans.closed:
        left = knots[:-1][~gone]
        return np.append(left, left[0] + knots[-1] - knots[0])
    return np.concatenate([knots[:1], knots[1:-1][~gone], knots[-1:]])


def importance(trial: Trial) -> Array:
    """Return how much each inner knot, closed the start of each span, is missed where it is taken away.

    That is the jump of the third derivative there, for the spans around.
    """
    spans = trial.curve.spans
    h = spans.steps
    sides = h * np.roll(h, 1) if spans.closed else h[:-1] * h[1:]
    return np.asarray(np.linalg.norm(trial.curve.third_jumps, axis=0) * sides**1.5)


def expected(trial: Trial) -> Array:
    """Return how large the error is expected to be without each inner knot, in the order of `importance`.

    That is the largest beside the knot now, and what the jump of the third derivative leaves.
    """
    spans = trial.curve.spans
    worst = largest_errors(trial)[0][:-1]
    beside = np.maximum(worst, np.roll(worst, 1)) if spans.closed else np.maximum(worst[:-1], worst[1:])
    return np.asarray(beside + importance(trial) * (_JUMP_ERROR / trial.goal.allowed[0]))


def largest_errors(trial: Trial) -> tuple[Array, Ints]:
    """Return the largest error on each span (m + 1,), and the first target of each (m + 2,): after the last, beyond."""
    spans = trial.curve.spans
    starts = trial.seen.at.span.searchsorted(np.arange(spans.count + 2))
    worst = np.maximum.reduceat(np.append(trial.error, 0.0), starts[:-1])
    worst[starts[:-1] == starts[1:]] = 0.0
    if spans.closed:
        worst[0] = max(worst[0], worst[-1])
    return worst, starts


def by_jumps(trial: Trial, m: int) -> Array:
    """Return m spans with knots as dense as the fourth root of the fourth derivative, read off jumps of the third."""
    spans = trial.curve.spans
    h = spans.steps
    jump = np.linalg.norm(trial.curve.third_jumps, axis=0)
    if spans.closed:
        fourth = jump / (0.5 * (h + np.roll(h, 1)))  # at the start of each span
        density = 0.5 * (fourth + np.roll(fourth, -1))
    else:
        if not len(jump):
            return np.linspace(spans.knots[0], spans.knots[-1], m + 1)
        fourth = jump / (0.5 * (h[:-1] + h[1:]))
        fourth = np.concatenate([fourth[:1], fourth, fourth[-1:]])
        density = 0.5 * (fourth[:-1] + fourth[1:])
    density = density**0.25 + 1e-9
    total = np.concatenate([[0.0], np.cumsum(density * h)])
    if not np.isfinite(total[-1]) or total[-1] <= 0:
        return np.linspace(spans.knots[0], spans.knots[-1], m + 1)
    knots = np.interp(np.linspace(0, total[-1], m + 1), total, spans.knots)
    knots[0], knots[-1] = spans.knots[0], spans.knots[-1]
    return knots
