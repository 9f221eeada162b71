"""A curve seen from points: places, tangents, and the way to the points' feet, in order."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.spans import Curve, Spans, dot, shifted
from cadfit.points.measures import blocks

_NO_TANGENT = 1e-300  # squared: where there is none, there is no step
_NEAR = 0.45  # of the gap to a neighbour: the farthest a foot point moves in one step


class Place(NamedTuple):
    """Where on a spline parameters (n,) are: in which spans, at which local parameters, and the spans modulo m."""

    span: Ints
    local: Array
    wrapped: Ints


class Look(NamedTuple):
    """A curve seen at a place: `powers` (4, d, n), the spans' polynomials of the local parameter; places and tangents.

    These are (d, n), the tangents derivatives by the local parameter.
    """

    at: Place
    powers: Array
    places: Array
    tangents: Array


def look(curve: Curve, u: Array) -> Look:
    """Return how the curve is seen at u (n,)."""
    return look_at(curve, found(curve.spans, u))


def found(spans: Spans, u: Array) -> Place:
    """Return where on the spans the parameters u (n,) are."""
    span = spans.find(u)
    return Place(span, *spans.local(u, span))


def look_at(curve: Curve, at: Place) -> Look:
    """Return how the curve is seen at a place found on its spans."""
    powers = curve.powers.take(at.wrapped, axis=2, mode="clip")  # nothing to clip, but quicker than looking
    a, b, c, e = powers
    tangents = e * at.local
    places = tangents + c
    tangents += places + places
    for row, lower in ((places, b), (places, a), (tangents, b)):
        row *= at.local
        row += lower
    return Look(at, powers, places, tangents)


def newton(curve: Curve, points: Array, seen: Look) -> Array:
    """Return Newton's step (n,) toward the foot of each point (d, n), a minimum of the distance."""
    _, _, c, e = seen.powers
    gap, first = points - seen.places, seen.tangents
    slope, flat = dot(gap, first), dot(first, first)
    rate = flat - dot(gap, (6.0 * seen.at.local) * e + 2.0 * c)
    rate = np.where(rate > 0.2 * flat, rate, flat) + _NO_TANGENT
    return np.asarray(slope * curve.spans.steps.take(seen.at.wrapped) / rate)


def slid(u: Array, step: Array, period: float | None) -> Array:
    """Return the parameters u (n,) moved by the steps (n,), none by as much as half the gap to a neighbour.

    The ends of an open curve (no `period`) stay.
    """
    if period is not None:
        room = _NEAR * (np.append(u[1:], u[0] + period) - u)
        return u + np.minimum(np.maximum(step, -shifted(room, 1)), room)
    room = _NEAR * (u[1:] - u[:-1])
    u = u.copy()
    u[1:-1] += np.minimum(np.maximum(step[1:-1], -room[:-1]), room[1:])
    return u


def feet(curve: Curve, points: Array, u: Array, period: float | None, steps: int = 2) -> Array:
    """Return the parameters u (n,) of points (d, n) moved toward their foot points, order kept."""
    for _ in range(steps):
        u = slid(u, foot_steps(curve, points, u, period), period)
    return u


def foot_steps(curve: Curve, points: Array, u: Array, period: float | None) -> Array:
    """Return how far (n,) the parameters u (n,) of points (d, n) are from those of their foot points, by Newton."""
    step = np.empty(len(u))
    for rows in blocks(len(u)):
        step[rows] = newton(curve, points[:, rows], look(curve, within(curve, u[rows], period)))
    return step


def within(curve: Curve, u: Array, period: float | None) -> Array:
    """Return the parameters u (n,), where closed a period on if they are before the curve's first."""
    return u if period is None else np.where(u < curve.spans.knots[0], u + period, u)


def wrapped(curve: Curve, u: Array) -> tuple[Curve, Array]:
    """Where closed, number the spans so that the first parameter lies in span 0."""
    spans = curve.spans
    if not spans.closed or spans.knots[0] <= u[0] < spans.knots[1]:
        return curve, u
    period = spans.knots[-1] - spans.knots[0]
    turns = np.floor((u[0] - spans.knots[0]) / period)
    u = u - turns * period
    k = int(np.clip(np.searchsorted(spans.knots, u[0], side="right") - 1, 0, spans.count - 1))
    return curve.from_span(k), u
