"""A C2 curve that is sure to stay near any points: Bézier pieces from point to point, their joints rounded a little."""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array
from cadfit.fitting.relax import Trial, measured
from cadfit.fitting.spans import Curve, Spans
from cadfit.fitting.targets import Targets

_DOUBLE, _TRIPLE = (-1.0, 1.0), (-1.0, 0.0, 1.0)


def rounded(goal: Targets, straight: bool, share: float) -> Trial:
    """Return the trial of the targets' own chain as a C2 spline: two poles a chord, or three where it is `straight`.

    The chain is a B-spline with double knots at the points (C1 on centripetal parameters), the polyline one with triple
    knots (on chord lengths). Set apart by `share` of the shorter span at each point the knots are simple, the poles
    remain, and the curve moves by about as much: as near to the points and chords as one likes.
    """
    chain, closed = goal.chain, goal.closed
    poles = chain[:, 1 : 4 if straight else 3]
    rows = poles.reshape(-1, poles.shape[-1])
    at, u = at_points(goal, 1.0 if straight else 0.5)
    step = np.diff(at)
    apart = share * np.minimum(step, np.roll(step, -1))  # at the end of each chord
    sides = np.array(_TRIPLE if straight else _DOUBLE)
    if closed:
        knots = (at[:-1, None] + np.roll(apart, 1)[:, None] * sides).ravel()
        knots = np.append(knots, knots[0] + goal.period)
        rows = np.roll(rows, len(sides), axis=0)
    else:
        inner = (at[1:-1, None] + apart[:-1, None] * sides).ravel()
        knots = np.concatenate([at[:1], inner, at[-1:]])
        rows = np.concatenate([chain[0, :1], rows] if straight else [chain[0, :1], rows, chain[-1, 3:]])
        for tangent, end, near, sign in zip(goal.tangents, (0, -1), (1, -2), (1.0, -1.0), strict=True):
            if tangent is not None:
                rows[near] = rows[end] + sign * share * np.linalg.norm(rows[near] - rows[end]) * tangent
    curve = Curve(Spans(knots, closed), np.ascontiguousarray(rows.T))
    return measured(goal, curve, u, goal.weights)


def at_points(goal: Targets, power: float) -> tuple[Array, Array]:
    """Return parameters at the points (and, closed, at the period's end), steps by a power of the chords; and for all.

    `power`: 1 for chord lengths, 1/2 for centripetal steps.
    """
    chord = np.linalg.norm(goal.chain[:, 3] - goal.chain[:, 0], axis=1)
    at = np.concatenate([[0.0], np.cumsum(chord**power)])
    at *= goal.period / at[-1]
    before = np.append(goal.u[goal.data], goal.u[0] + goal.period)[: len(at)]
    return at, np.interp(goal.u, before, at)
