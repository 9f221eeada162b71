"""C2 curves that are sure to stay near any points: their polyline, or cardinal curve, its joints rounded a little."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadfit.bezier import Array
from cadfit.fitting.relax import Trial, measured
from cadfit.fitting.spans import Curve, Spans
from cadfit.fitting.steps import averaged
from cadfit.fitting.targets import Targets
from cadfit.fitting.turning import lengths

_THIRD = 1.0 / 3.0  # of a chord: no corner is rounded farther, and its knots are even then
_DOUBLE, _TRIPLE = (-1.0, 1.0), (-1.0, 0.0, 1.0)


def rounded_polyline(goal: Targets, share: float) -> Trial:
    """Return the trial of Schoenberg's spline of the polyline, with three knots about each vertex.

    Its poles lie on the polyline, at averages of three knots, the vertices among them. So their polygon is the
    polyline, and the curve turns no more than that. With knots up to `a` away, a vertex that turns by t is missed by
    a/3 sin(t/2): `share` of the tolerance, or less where the chords are short.
    Source: Schoenberg, On spline functions, in Inequalities, 1967.
    """
    at, u = at_points(goal, 1.0)
    chord = np.diff(at)
    unit = ((goal.chain[:, 3] - goal.chain[:, 0]) / chord[:, None]).T
    bend, shorter = lengths(unit - np.roll(unit, 1, axis=1)), np.minimum(chord, np.roll(chord, 1))  # 2 sin(t/2)
    allowed = share * float(goal.allowed[0])
    apart = np.minimum(_THIRD * shorter, 6.0 * allowed / np.maximum(bend, allowed / shorter))
    curve = averaged(replace(goal, tangents=(None, None)), _about(goal, at, apart, _TRIPLE), u)
    return _tried(goal, curve, u, share)


def rounded_chain(goal: Targets, share: float) -> Trial:
    """Return the trial of the targets' cardinal chain as a C2 spline of two poles a chord.

    The chain is a B-spline with double knots at the points (C1 on centripetal parameters). Set apart by `share` of the
    shorter span at each point the knots are simple, the poles remain, and the curve moves by about as much.
    """
    at, u = at_points(goal, 0.5)
    step, chain = np.diff(at), goal.chain
    knots = _about(goal, at, share * np.minimum(step, np.roll(step, 1)), _DOUBLE)
    poles = chain[:, 1:3].reshape(-1, chain.shape[-1])
    poles = np.roll(poles, 2, axis=0) if goal.closed else np.concatenate([chain[0, :1], poles, chain[-1, 3:]])
    return _tried(goal, Curve(Spans(knots, goal.closed), np.ascontiguousarray(poles.T)), u, share)


def _about(goal: Targets, at: Array, apart: Array, sides: tuple[float, ...]) -> Array:
    """Return the knots at some multiples (`sides`) of `apart` (chords,) from the points, each at its chord's start."""
    first = int(not goal.closed)
    knots = (at[first:-1, None] + apart[first:, None] * np.array(sides)).ravel()
    return np.append(knots, knots[0] + goal.period) if goal.closed else np.concatenate([at[:1], knots, at[-1:]])


def _tried(goal: Targets, curve: Curve, u: Array, share: float) -> Trial:
    """Return the trial of the curve, its ends on the tangents that are given."""
    poles = curve.poles
    for tangent, end, near, sign in zip(goal.tangents, (0, -1), (1, -2), (1.0, -1.0), strict=True):
        if tangent is not None:
            length = share * min(float(np.linalg.norm(poles[:, near] - poles[:, end])), float(goal.allowed[0]))
            poles[:, near] = poles[:, end] + sign * length * tangent
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
