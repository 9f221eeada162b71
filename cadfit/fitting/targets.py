"""What a fitted curve is held to: the points, and places between them, each with the error it allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadfit import bezier
from cadfit.bezier import Array, Ints
from cadfit.fitting.spans import dot
from cadfit.points.measures import blocks

BULGE = 1.5  # how far a curve may stray from a chord, in bulges of the centripetal cardinal curve, beyond the tolerance
_QUARTERS = np.array([[(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3] for t in np.linspace(0, 1, 5)])
_SAMPLES = np.array([[3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3] for t in np.arange(1, 16) / 16])  # of a cubic
_MOST = 32.0  # times as long as a neighbour: a longer chord gets no more samples


@dataclass(frozen=True, eq=False)
class Targets:
    """Places (d, n) the curve shall pass in this order, their allowed errors, weights, and parameters to start from.

    `row` (n,): the number of the point, or for places between points of the point before. `data` (n,): whether it is a
    point. `chain` (chords, 4, d): the curve between the points that they were taken from, `room` (chords,) how far the
    fit may stray from each chord. `closed`: the curve returns to the first place, a point, after `period`. `polyline`:
    the points are the vertices of the shape, not samples. `tangents`:
    unit directions (d,) of an open curve at its ends, where they are given.
    """

    points: Array
    allowed: Array
    weights: Array
    u: Array
    row: Ints
    data: NDArray[np.bool_]
    chain: Array
    room: Array
    closed: bool
    polyline: bool
    period: float
    tangents: tuple[Array | None, Array | None]

    @cached_property
    def between(self) -> Ints:
        """The targets that are no points."""
        return np.flatnonzero(~self.data)

    @cached_property
    def _chords(self) -> tuple[Array, Array, Array]:
        """The chords' starts and directions (d, chords), and their squared lengths."""
        start, along = self.chain[:, 0].T.copy(), (self.chain[:, 3] - self.chain[:, 0]).T.copy()
        return start, along, dot(along, along)

    def straying(self, places: Array, chords: Ints) -> Array:
        """Return how far places (d, n) are from the given chords (n,), in parts of the room the fit has there."""
        start, along, square = self._chords
        along = along[:, chords]
        gap = places - start[:, chords]
        place = dot(gap, along) / square[chords]
        gap -= np.minimum(np.maximum(place, 0.0), 1.0) * along
        return np.asarray(np.sqrt(dot(gap, gap)) / self.room[chords])


def cardinal_chain(points: Array, closed: bool) -> Array:
    """Return the centripetal cardinal curve (chords, 4, d) of points (n, d): one Bézier piece for each chord.

    Tangents are those of the parabolas through three neighbours at centripetal parameters, at open ends the chord's.
    Source: Yuksel, Schaefer and Keyser, Parameterization and applications of Catmull-Rom curves, CAD 43(7), 2011.
    """
    around = np.concatenate([points[-1:], points, points[:2]]) if closed else points
    chords = np.diff(around, axis=0)
    step = np.sqrt(np.sqrt(np.einsum("nd,nd->n", chords, chords)))[:, None]
    slopes = chords / step
    tangent = (slopes[:-1] * step[1:] + slopes[1:] * step[:-1]) / (step[:-1] + step[1:])
    if closed:
        start, end, step = tangent[:-1], tangent[1:], step[1:-1]
        around = around[1:-1]
    else:
        start, end = np.concatenate([slopes[:1], tangent]), np.concatenate([tangent, slopes[-1:]])
    p, q = around[:-1], around[1:]
    return np.stack([p, p + start * step / 3.0, q - end * step / 3.0, q], axis=1)


def straight_chain(points: Array, closed: bool) -> Array:
    """Return the polyline of points (n, d) as Bézier pieces (chords, 4, d)."""
    around = np.concatenate([points, points[:1]]) if closed else points
    chords = np.diff(around, axis=0)[:, None]
    return np.asarray(around[:-1, None] + np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])[:, None] * chords)


def bulges(chain: Array, least: float) -> Array:
    """Return how far each piece (chords, 4, d) strays from its chord (chords,): the largest of 15 samples' distances.

    0 where it is less than `least`, for what two sides of a triangle exceed the third by bounds it.
    """
    found = np.zeros(len(chain))
    sides = np.linalg.norm(np.diff(chain, axis=1), axis=2).sum(axis=1)
    chord = np.linalg.norm(chain[:, 3] - chain[:, 0], axis=1)
    bent = np.flatnonzero(sides * sides - chord * chord > 4.0 * least * least)  # else within that ellipse's half width
    for rows in blocks(len(bent)):
        piece = chain[bent[rows]]
        arms = (piece[:, 1:] - piece[:, :1]).transpose(1, 2, 0)  # (3, d, k)
        gap, along = np.tensordot(_SAMPLES, arms, 1), arms[2]
        place = np.einsum("sdk,dk->sk", gap, along) / dot(along, along)
        gap -= np.minimum(np.maximum(place, 0.0), 1.0)[:, None] * along
        found[bent[rows]] = np.sqrt(np.einsum("sdk,sdk->sk", gap, gap).max(axis=0))
    return found


def targets(
    points: Array,
    chain: Array,
    room: Array,
    tolerance: float,
    weights: Array,
    closed: bool,
    polyline: bool,
    tangents: tuple[Array | None, Array | None],
) -> Targets:
    """Return the points (n, d) as targets, held to the tolerance; their parameters are the lengths of `chain`.

    `chain` (chords, 4, d): the curve between the points; `room` (chords,): how far the fit may stray from each.
    """
    n = len(points)
    start = np.concatenate([[0.0], np.cumsum(_parts(chain).sum(axis=1))])
    return Targets(
        points.T.copy(),
        np.full(n, tolerance),
        weights,
        start[:n],
        np.arange(n),
        np.ones(n, dtype=bool),
        chain,
        room,
        closed,
        polyline,
        float(start[-1]),
        tangents,
    )


def _parts(chain: Array) -> Array:
    """Return the lengths (chords, 4) between samples of the pieces."""
    steps = np.diff(_QUARTERS @ chain, axis=1)
    return np.asarray(np.sqrt(np.einsum("nkd,nkd->nk", steps, steps)))


def with_samples(goal: Targets) -> Targets:
    """Return the targets with lightly weighted samples of the chain where the points say too little.

    Those are three on a chord: where the chain bulges by over a quarter of the tolerance; of a polyline, where a chord
    is longer than the tolerance; and on an only chord. On a chord more than three times as long as a neighbour they are
    half as many as it is times as long, or three: what joins short chords to a long straight one ends within the reach
    of the short ones.
    """
    tolerance = goal.allowed[0]
    chord = np.linalg.norm(goal.chain[:, 3] - goal.chain[:, 0], axis=1)
    shorter = np.minimum(np.roll(chord, 1), np.roll(chord, -1))
    if not goal.closed:
        shorter[0], shorter[-1] = chord[min(1, len(chord) - 1)], chord[-2 % len(chord)]
    bent = chord > tolerance if goal.polyline else goal.room - tolerance > 0.25 * BULGE * tolerance
    bent |= len(chord) == 1  # with given tangents: nothing else says where the poles between the ends lie
    times = np.minimum(chord, _MOST * shorter) / np.maximum(shorter, np.finfo(np.float64).tiny)
    counts = np.where(times > 3.0, np.maximum(0.5 * times, 3.0), np.where(bent, 3.0, 0.0)).astype(np.intp)
    if not counts.any():
        return goal
    chosen = np.repeat(np.arange(len(chord)), counts)
    within = np.arange(len(chosen)) - np.repeat(np.cumsum(counts) - counts, counts)
    at = (within + 1.0) / (counts[chosen] + 1.0)
    straight = (goal.room == tolerance)[chosen]
    return sampled(goal, goal.u, chosen, at, np.where(straight, _shares(goal.chain[chosen], at), at))[0]


def _shares(pieces: Array, at: Array) -> Array:
    """Return how far along straight pieces (n, 4, d) their places at (n,) are: beside short ones they start slowly."""
    places = bezier.evaluate(pieces, at)
    before, after = (np.linalg.norm(places - pieces[:, end], axis=1) for end in (0, 3))
    return np.asarray(before / (before + after))


def sampled(goal: Targets, u: Array, chords: Ints, at: Array, share: Array) -> tuple[Targets, Array, Ints]:
    """Return the targets with more at places `at` (k,) in [0, 1] of chords (k,), the parameters with theirs, the order.

    `share` (k,): where their parameters lie between those of the chords' ends, in [0, 1].
    The order (n + k,) is that in which old and new were merged.
    """
    ends = np.append(u[goal.data], u[0] + goal.period)
    tolerance = goal.allowed[0]
    places = bezier.evaluate(goal.chain[chords], at)
    between = (1.0 - share) * ends[chords] + share * ends[chords + 1]
    room = tolerance + (goal.room[chords] - tolerance) / (2.0 * BULGE)
    u = np.concatenate([u, between])
    order = np.argsort(u, kind="stable")

    def merged(old: NDArray[Any], new: NDArray[Any]) -> NDArray[Any]:
        return np.concatenate([old, new], axis=-1)[..., order]

    new = replace(
        goal,
        points=merged(goal.points, places.T),
        allowed=merged(goal.allowed, room),
        weights=merged(goal.weights, 0.1 * (tolerance / room) ** 2),
        u=u[order],
        row=merged(goal.row, chords),
        data=merged(goal.data, np.zeros(len(chords), dtype=bool)),
    )
    return new, new.u, order
