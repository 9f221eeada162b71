"""How a curve turns, against the polyline of its points: loops, wiggles, length, curvature. Sampled, not certified.

A curve near a polyline need not turn more than that does: a corner rounded turns as much as the corner. What a curve
turns beyond that is a wiggle; half a turn or more within a few chords is a loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

PER_SPAN = 49  # places a span where the direction is looked at
LOOP = np.pi  # radians beyond the polyline's, on a short run of the curve
SHORT = 8  # chords: what adds up to as much over more of them are wiggles, which `curve` against `polyline` tells
REACH = 6.0  # tolerances along the polyline: so far from there the curve may turn as it does; a vertex more in any case


class Turning(NamedTuple):
    """How a fit turns.

    `curve` and `polyline`: their total absolute turning, in radians. `excess`: the most that the curve turns on any run
    between chords beyond what the polyline turns there and near. `loops`: short runs where it is over half a turn.
    `length`: over the polyline's. `bend`: the largest curvature, over that of the roundest arc that the sharpest
    vertex has room for. `slowest`: the least speed over the mean one.
    """

    curve: float
    polyline: float
    excess: float
    loops: int
    length: float
    bend: float
    slowest: float


def turning(fit):
    """The judgement of a `Fit`."""
    closed, tolerance = fit.closed, fit.tolerance
    around = np.vstack([fit.points, fit.points[:1]]) if closed else fit.points
    chords = np.diff(around, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    turns = angles(np.roll(chords, 1, axis=0), chords)  # at the chords' starts
    turns[0] = turns[0] if closed else 0.0
    at = np.append(fit.parameters, fit.parameters[0]) if closed else fit.parameters
    u, turned, bends, speeds, length = looked_at(fit.curves)
    period = fit.curves[-1].knots[-1] - fit.curves[0].knots[0]
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    middles, halves = at[:-1] + 0.5 * (np.diff(at) % period if closed else np.diff(at)), 0.5 * (along[:-1] + along[1:])
    if not closed:  # what lies before the first middle and after the last counts as well
        middles, halves = (
            np.concatenate([ends[:1], inner, ends[-1:]]) for ends, inner in ((at, middles), (along, halves))
        )
    rounds = np.arange(3)[:, None] if closed else np.zeros((1, 1))
    start = np.cumsum(np.tile(turned, len(rounds)))
    places = np.searchsorted((u + rounds * period).ravel(), np.unwrap(middles, period=period) if closed else middles)
    places = (places + (np.arange(2)[:, None] if closed else np.zeros((1, 1), int)) * len(u)).ravel()
    excess, loops = runs(
        start[np.minimum(places, len(start) - 1)],
        (halves + rounds[: max(1, len(rounds) - 1)] * along[-1]).ravel(),
        (along[:-1] + (rounds - (1 if closed else 0)) * along[-1]).ravel(),
        np.tile(turns, len(rounds)),
        REACH * tolerance,
    )
    inner = slice(0, None) if closed else slice(1, None)
    half = 0.5 * np.minimum(turns, np.pi - 1e-9)[inner]
    short = 0.5 * np.minimum(lengths, np.roll(lengths, 1))[inner]
    smooth = ~np.isin(np.arange(len(lengths))[inner], fit.corners)
    needed = np.maximum(np.tan(half) / short, (1.0 / np.cos(half) - 1.0) / tolerance)[smooth].max(initial=0.0)
    needed = max(needed, 1.0 / along[-1])
    return Turning(
        float(turned.sum()),
        float(turns.sum()),
        excess,
        loops,
        float(length / along[-1]),
        float(bends.max() / needed),
        float(speeds.min() / speeds.mean()),
    )


def angles(before, after):
    """The angles (n,) between directions (n, d), exact for small ones, too."""
    before = before / np.linalg.norm(before, axis=1, keepdims=True)
    after = after / np.linalg.norm(after, axis=1, keepdims=True)
    return 2.0 * np.arctan2(np.linalg.norm(after - before, axis=1), np.linalg.norm(after + before, axis=1))


def looked_at(curves):
    """Places u (k,) along curves, the turn (k,) from the place before, curvatures and speeds there; their length."""
    places, directions, bends, speeds, length = [], [], [], [], 0.0
    for curve in curves:
        spline = BSpline(curve.knots, curve.poles - curve.poles[0], 3)
        knots = np.unique(curve.knots)
        u = (knots[:-1, None] + np.diff(knots)[:, None] * np.linspace(0.0, 1.0, PER_SPAN)).ravel()
        u[PER_SPAN - 1 :: PER_SPAN] = np.nextafter(u[PER_SPAN - 1 :: PER_SPAN], -np.inf)
        first, second = spline(u, 1), spline(u, 2)
        speed = np.linalg.norm(first, axis=1)
        moving = speed > 1e-14 * speed.max()
        first, second, unit = first[moving], second[moving], speed[moving, None] ** -1.0
        first *= unit
        across = second - np.sum(second * first, axis=1, keepdims=True) * first
        places.append(u[moving])
        directions.append(first)
        bends.append(np.linalg.norm(across * unit**2, axis=1))
        speeds.append(speed)
        length += float(np.linalg.norm(np.diff(spline(u), axis=0), axis=1).sum())
    along = np.concatenate(directions)
    closed = np.array_equal(curves[0].poles[0], curves[-1].poles[-1])
    turned = np.append(angles(along[-1:], along[:1]) if closed else 0.0, angles(along[:-1], along[1:]))
    return np.concatenate(places), turned, np.concatenate(bends), np.concatenate(speeds), length


def runs(curve, along, vertices, turns, reach):
    """The largest excess of what the curve turned over the polyline, and how many short runs exceed it by `LOOP`.

    `curve` (m,) what the curve turned up to each chord's middle, which lies at `along` (m,) of the polyline; its
    `vertices` (n,) along it, and their `turns` (n,).
    """
    polyline = np.concatenate([[0.0], np.cumsum(turns)])
    inside = np.searchsorted(vertices, along)
    before = polyline[np.maximum(np.minimum(inside - 1, np.searchsorted(vertices, along - reach)), 0)]
    after = np.maximum(inside + 1, np.searchsorted(vertices, along + reach, side="right"))
    after = polyline[np.minimum(after, len(turns))]
    start, end = curve - before, curve - after
    largest = float(np.max(end - np.minimum.accumulate(start), initial=0.0))
    loops, first = 0, 0
    for j in range(len(curve)):
        first = max(first, j - SHORT)
        if end[j] - start[first : j + 1].min(initial=np.inf) > LOOP:
            loops, first = loops + 1, j + 1
    return largest, loops
