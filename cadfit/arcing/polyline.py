"""Nodes along a polyline, beside its vertices and chords too, and what of it lines and its own moves can stand for.

The vertices of a polyline lie on the curve that was meant, and its chords inside: the arcs nearest to both keep to the
middle. So arcs that are to stay near them as long as they can meet beside the polyline, at up to the tolerance.
"""

from __future__ import annotations

import numpy as np

from cadfit.arcing.nodes import Nodes, Samples
from cadfit.arcing.reach import Limits, Links, between
from cadfit.bezier import Array, Ints

_EDGE = 0.95  # of the tolerance, beside the polyline
_LANES = {False: (0.0, -_EDGE, _EDGE), True: (0.0, -_EDGE, -0.45, 0.45, _EDGE)}
_PER_CHORD, _PER_LONG = 4, 8  # samples
_LONG = 3.0  # a chord so many times as long as one beside it is long
_KINK = np.radians(0.25)  # by so much a line may turn off what is before or after it
_LINE, _SMOOTH, _KINKED = 1.0, 2.0, -1.0  # ranks: a line, a move that is kept, one that is kept with its kinks


def sampled(points: Array, corners: Ints) -> Nodes:
    """Return the vertices of the polyline of points (n, 2), and the middles of its chords, as nodes.

    `corners`: the rows of vertices where any direction may follow any.
    """
    chord: Array = np.diff(points, axis=0)
    length = np.hypot(chord[:, 0], chord[:, 1])
    heading = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    beside = np.concatenate([length[1:2], length, length[-2:-1]])
    count = np.where(length > _LONG * np.minimum(beside[:-2], beside[2:]), _PER_LONG, _PER_CHORD)
    first = np.concatenate([[0], np.cumsum(count)])
    on = np.append(np.repeat(np.arange(len(chord)), count), len(chord) - 1)
    part = (np.arange(len(on)) - first[on]) / count[on]
    spots = points[on] + part[:, None] * chord[on]
    spots[first] = points
    angles = heading[on]
    angles[first[1:-1]] = 0.5 * (heading[:-1] + heading[1:])
    samples = Samples(on + part, spots, angles)
    rows = np.flatnonzero((part == 0.0) | (part == 0.5) | (part == 1.0))
    return Nodes(samples, rows, spots[rows], np.isin(rows, first[corners]))


def share(every: Nodes, limits: Limits, per_arc: float) -> Array:
    """Return the share (n,) of nodes to take: about `per_arc` to the length that an arc can have there."""
    reach = _reach(every, limits)
    around = np.minimum(reach, np.minimum(np.roll(reach, 1), np.roll(reach, -1)))
    return np.asarray(np.minimum(per_arc / (1.5 * around), 1.0))


def chosen(every: Nodes, share: Array, tolerance: float, best: bool) -> Nodes:
    """Return a share (n,) of all samples as nodes, and others beside each; `best`: twice as many."""
    total = np.concatenate([[0.0], np.cumsum(share[:-1])])
    some = (np.diff(np.floor(total + 1e-9), prepend=-1.0) > 0.0) | every.corners
    some[[0, -1]] = True
    alone = every.corners[some]
    alone[[0, -1]] = True
    lanes = tolerance * np.array(_LANES[best])
    count = np.where(alone, 1, len(lanes))
    of = np.repeat(np.flatnonzero(some), count)
    lane = lanes[np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)]
    angles = every.angles[of]
    across = np.column_stack([-np.sin(angles), np.cos(angles)])
    return Nodes(every.samples, every.rows[of], every.spots[of] + lane[:, None] * across, every.corners[of])


def _reach(nodes: Nodes, limits: Limits) -> Ints:
    """Return for each node how many rows on an arc reaches for sure: a power of two (or 1); at the last one, 1."""
    n = len(nodes.rows)
    ends = np.append(np.flatnonzero(nodes.corners), n - 1)
    stop = ends[np.minimum(np.searchsorted(ends, np.arange(n), side="right"), len(ends) - 1)]
    reach, alive, step = np.ones(n, dtype=np.intp), np.arange(n - 1), 2
    while len(alive := alive[alive + step <= stop[alive]]):
        low, high, _ = between(nodes, alive, alive + step, limits)
        alive = alive[low <= high]
        reach[alive] = step
        step *= 2
    return reach


def lines(nodes: Nodes, links: Links) -> Links:
    """Return those of the links that a line, too, can be."""
    straight = _start(nodes, links, np.zeros(len(links.start)))
    able = (links.low <= straight) & (straight <= links.high)
    found, straight = links.of(able), straight[able]
    turn = np.zeros(len(straight))
    return _one(found, straight, (turn, turn), np.zeros(len(straight)), np.full(len(straight), _LINE))


def kept(nodes: Nodes, begins: Ints, ends: Ints, sweeps: Array, turns: Array) -> Links:
    """Return the links of the moves that the polyline is made of: from vertices `begins` (k,) to `ends` (k,).

    `sweeps` (k,): of arcs, 0 for lines. `turns` (k + 1,): by how much the path turns where each begins, and at the end.
    They may follow and be followed by other directions, as long as the turn is no larger than it was.
    """
    at = nodes.at
    first, last = np.searchsorted(at, begins), np.minimum(np.searchsorted(at, ends), len(at) - 1)
    there = (at[first] == begins) & (at[last] == ends)
    first, last, sweeps = first[there], last[there], sweeps[there]
    before, after = turns[:-1][there], turns[1:][there]
    chord = nodes.spots[last] - nodes.spots[first]
    angles = nodes.angles
    direction, middle = np.arctan2(chord[:, 1], chord[:, 0]), 0.5 * (angles[first] + angles[last])
    direction += 2.0 * np.pi * np.round((middle - direction) / (2.0 * np.pi))
    total = 2.0 * direction - angles[first] - angles[last]
    links = Links.arcs(first, last, total, total, total)
    smooth = np.maximum(np.abs(before), np.abs(after)) <= _KINK
    return _one(links, _start(nodes, links, sweeps), (before, after), sweeps, np.where(smooth, _SMOOTH, _KINKED))


def _start(nodes: Nodes, links: Links, sweeps: Array) -> Array:
    """Return the angles at which arcs of these sweeps start, against the curve."""
    turned = nodes.angles[links.end] - nodes.angles[links.start]
    return np.asarray(0.5 * (links.total + turned - sweeps))


def _one(links: Links, start: Array, turns: tuple[Array, Array], sweeps: Array, rank: Array) -> Links:
    """Return the links as the one arc of a sweep, where what is before and after may turn off it by `turns`."""
    before, after = turns
    end = links.total - start
    return Links(
        links.start,
        links.end,
        start - np.maximum(before, 0.0) - _KINK,
        start - np.minimum(before, 0.0) + _KINK,
        links.total,
        end + np.minimum(after, 0.0) - _KINK,
        end + np.maximum(after, 0.0) + _KINK,
        sweeps,
        rank,
    )
