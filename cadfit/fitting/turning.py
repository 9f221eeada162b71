"""How much a curve turns, against the polyline of its points: what it turns beyond that is a wiggle, or a loop.

Rounding the corners of a polyline turns as much as they do. A curve that wiggles keeps a tolerance, too, and may need
fewer poles for that, but nobody wants it.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.spans import Curve

Tangents = tuple[Array | None, Array | None]

_REACH = 6.0  # tolerances along the polyline: so far from a vertex, or a chord, the curve may turn as it does
_SHARE = 1.1  # of what the polyline turns there, the curve may turn
_LEAST = 0.3  # radians beyond that: less is no loop


def loops(curve: Curve, points: Array, u: Array, tolerance: float, tangents: Tangents = (None, None)) -> Ints:
    """Return the spans on which the curve loops or wiggles where the polyline does not; arguments as `worst_run`."""
    excess, first, stop = worst_run(curve, points, u, tolerance, tangents)
    return np.arange(first, stop if excess > _LEAST else first) % curve.spans.count


def worst_run(
    curve: Curve, points: Array, u: Array, tolerance: float, tangents: Tangents = (None, None)
) -> tuple[float, int, int]:
    """Return how much, in radians, the curve turns beyond a little more than the polyline, on its worst run of spans.

    `points` (d, n): the polyline, at u (n,). What the curve turns is bounded from above. The run is given by its first
    span, and the one after its last; where closed it may go on into a second round. `tangents`: directions that are
    given at open ends, which a curve leaves for that of the polyline, and turns twice.
    """
    knots, spans = curve.spans.knots, span_turns(curve)
    if curve.spans.closed:  # two rounds of the curve, and what of the polyline is about them
        chords = np.diff(points, axis=1, append=points[:, :1])
        period, rounds = knots[-1] - knots[0], np.arange(-1, 3)[:, None]
        along = np.append(0.0, np.cumsum(lengths(chords)))
        along, u = (along[:-1] + rounds * along[-1]).ravel(), (u + rounds * period).ravel()
        vertices, turns = along, np.tile(angles(np.roll(chords, 1, axis=1), chords), len(rounds))
        knots, spans = np.concatenate([knots[:-1], knots + period]), np.tile(spans, 2)
    else:
        chords = np.diff(points, axis=1)
        along = np.append(0.0, np.cumsum(lengths(chords)))
        ends = [
            np.zeros(1) if tangent is None else 2.0 * angles(tangent[:, None], chord[:, None])
            for tangent, chord in zip(tangents, (chords[:, 0], chords[:, -1]), strict=True)
        ]
        vertices, turns = along, np.concatenate([ends[0], angles(chords[:, :-1], chords[:, 1:]), ends[1]])
    at, reach = np.interp(knots, u, along), _REACH * tolerance
    turned, polyline = (np.append(0.0, np.cumsum(each)) for each in (spans, _SHARE * turns))
    before = polyline[np.maximum(np.searchsorted(vertices, at - reach) - 1, 0)]
    after = polyline[np.minimum(np.searchsorted(vertices, at + reach, side="right") + 1, len(vertices))]
    least = np.minimum.accumulate(turned - before)
    stop = int(np.argmax(turned - after - least))
    first = stop - int(np.argmin((turned - before)[stop::-1]))  # the last of the least
    return float(turned[stop] - after[stop] - least[stop]), first, stop


def span_turns(curve: Curve) -> Array:
    """Return bounds (m,) on what the curve turns in each span: the polygons of the derivative's poles, halved once."""
    _, first, second, third = curve.powers
    a, b, c = first, first + second, first + 2.0 * second + 3.0 * third
    left, right = 0.5 * (a + b), 0.5 * (b + c)
    middle = 0.5 * (left + right)
    legs = (a, left, middle, right, c)
    return np.asarray(sum(angles(p, q) for p, q in zip(legs[:-1], legs[1:], strict=True)))


def angles(before: Array, after: Array) -> Array:
    """Return the angles (n,) between directions (d, n), exact for small ones, too; 0 where there is no direction."""
    p, q = before * lengths(after), after * lengths(before)
    return np.asarray(2.0 * np.arctan2(lengths(p - q), lengths(p + q)))


def lengths(vectors: Array) -> Array:
    """Return the lengths (n,) of vectors (d, n)."""
    return np.asarray(np.sqrt(np.einsum("dn,dn->n", vectors, vectors)))
