"""Distant parts of a sweep that pass through each other: those of its triangles that do.

First by the path alone: where it comes within two reaches of itself. There by boxes around short cells of walls, around
single walls and around triangles, and at last triangle by triangle, as the mesh has them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cadfit.bezier import Array, Ints
from cadfit.sweeping.cubics import norms
from cadfit.sweeping.spinors import running
from cadfit.sweeping.triangles import crossing

APART = 0.5 * np.pi  # parts of a path between which it turns less do not meet, unless a bend is too tight
_COARSE = 8  # times half a reach: how far apart places are sampled at first
_MOST_SAMPLES = 200_000
_MOST_PAIRS = 500_000  # of places near each other; where there are more, only the nearest
_ASKED = 500  # places that are asked how many others are near
_PAIRS_AT_FIRST, _PAIRS_AT_ONCE = 1 << 1, 1 << 12
_AT_ONCE_AT_FIRST, _AT_ONCE = 1 << 13, 1 << 20  # boxes that are compared in one go
_TIGHT = 0.5  # of 1 / reach: a step that bends more, between chords, may bend too tightly
_CELL = 0.1  # of a reach, or twice that in radians: how much of the path a cell of walls has


def askew(rings: Array, centres: Array, tangents: Array) -> NDArray[np.bool_]:
    """Return whether each ring (n, k, 3) stands askew on the path, as in a mitre; `centres`, `tangents` (n, 3)."""
    arms = rings - centres[:, None]
    leans = np.abs(np.einsum("nkd,nd->nk", arms, tangents)).max(axis=1)
    return np.asarray(leans > 1e-6 * np.linalg.norm(arms, axis=2).max())


def tight_steps(rings: Array, centres: Array, tangents: Array) -> NDArray[np.bool_]:
    """Return for each step (n - 1,) from ring to ring whether the largest ring of the sweep may be too large for it.

    A profile that stays the same and has room in the path's bends does not meet itself where the path turns by less
    than a right angle. One that grows or turns may, on both sides of a bend that has room for the ring that is there,
    or of a mitre. `rings` (n, k, 3), `centres`, `tangents` (n, 3).
    """
    reach = float(np.linalg.norm(rings - centres[:, None], axis=2).max())
    turns, steps = (np.linalg.norm(np.diff(rows, axis=0), axis=1) for rows in (tangents, centres))
    mitres = askew(rings, centres, tangents)
    return np.asarray((turns > 0.0) & (reach * turns >= _TIGHT * steps) | mitres[1:] | mitres[:-1])


def near_parts(
    centres: Array, tangents: Array, closed: bool, reach: float, tight: NDArray[np.bool_] | None = None
) -> Array:
    """Return pairs (p, 2) of places, as distances along the polyline of `centres`, that are less than 2 reaches apart.

    `centres`, `tangents` (3, n), both ends of a closed path too. Only places count between which the path turns by a
    right angle or more, or takes one of the `tight` steps (n - 1,). Places are sampled 4 reaches apart, and near others
    by halves down to half of one. The nearest come first.
    """
    turning = norms(tangents[:, 1:] - tangents[:, :-1])  # chords of the angles: a little less
    if tight is not None:
        turning = turning + 2.0 * APART * tight  # twice: a place may lie on the step
    turns = running(np.add, 0.0, turning)
    if turns[-1] < APART:
        return np.empty((0, 2))
    s = running(np.add, 0.0, norms(centres[:, 1:] - centres[:, :-1]))
    length = float(s[-1])
    unit = max(0.5 * reach, length / (_COARSE * _MOST_SAMPLES))
    last = int(length / unit) + 1
    marks = np.arange(0, last + _COARSE, _COARSE)
    for spacing in 2 ** np.arange(int(math.log2(_COARSE)), -1, -1):
        samples = np.minimum(unit * marks, length)
        places = np.stack([np.interp(samples, s, row) for row in centres], axis=1)
        found = _pairs(places, 2.0 * reach + spacing * unit)
        first, second = np.interp(samples, s, turns)[found.T]
        between = np.abs(first - second)
        if closed:
            between = np.minimum(between, turns[-1] - between)
        found = found[between >= APART]
        if not len(found):
            return np.empty((0, 2))
        if spacing > 1:  # twice as fine, but only about those that are near others
            near, finer = np.zeros(len(marks), dtype=bool), np.zeros(last + 1, dtype=bool)
            near[found] = True
            finer[np.clip(marks[near] + spacing // 2 * np.arange(-2, 3)[:, None], 0, last)] = True
            marks = np.flatnonzero(finer)
    first, second = places[found.T]
    nearest = np.argsort(np.linalg.norm(first - second, axis=1), kind="stable")
    return np.asarray(samples[found[nearest]])


def _pairs(places: Array, distance: float) -> Ints:
    """Return the rows (p, 2) of places (n, 3) within a distance, or a shorter one where these would be too many."""
    tree = cKDTree(places)
    some = places[:: max(1, len(places) // _ASKED)]
    least = 1e-3 * distance
    while (
        len(places) ** 2 > 2 * _MOST_PAIRS
        and distance > least
        and tree.query_ball_point(some, distance, return_length=True).mean() * len(places)
        > 2 * _MOST_PAIRS + len(places)
    ):
        distance *= 0.7
    return np.asarray(tree.query_pairs(distance, output_type="ndarray"))


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """The outside of a sweep in order: the lid at the start, the walls from ring to ring, the lid at the end.

    `rings` (n, k, 3), on a closed path with the first at the end again. `lids` (p, 2 k, 3, 3): triangles, as many a
    piece as a wall has. `spans` (m, 2): the first and the last ring that each piece touches; `low`, `high` (m, 3): the
    box around it. The lids of the start are the first `before` pieces.
    """

    rings: Array
    lids: Array
    before: int
    spans: Ints
    low: Array
    high: Array

    @classmethod
    def of(cls, rings: Array, lids: Sequence[Array]) -> _Pieces:
        """Return the pieces of rings, and of triangles (t, 3, 3) at the start and at the end."""
        n, k = rings.shape[:2]
        cut = [np.resize(lid, (-(-len(lid) // (2 * k)), 2 * k, 3, 3)) for lid in lids]  # the first ones again, to fill
        before = len(cut[0])
        flat = np.concatenate(cut)
        spans = np.column_stack([np.arange(n - 1), np.arange(1, n)])
        spans = np.concatenate([np.zeros((before, 2), int), spans, np.full((len(cut[1]), 2), n - 1)])
        low, high = rings.min(axis=1), rings.max(axis=1)
        low, high = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
        low, high = (
            np.concatenate([lid[:before], wall, lid[before:]])
            for lid, wall in ((flat.min(axis=(1, 2)), low), (flat.max(axis=(1, 2)), high))
        )
        return cls(rings, flat, before, spans, low, high)

    def triangles(self, which: Ints) -> Array:
        """Return the triangles (q, 2 k, 3, 3) of some pieces (q,)."""
        wall = which - self.before
        inside = (wall >= 0) & (wall < len(self.rings) - 1)
        out = np.empty((len(which), 2 * self.rings.shape[1], 3, 3))
        out[inside] = _wall_triangles(self.rings[wall[inside]], self.rings[wall[inside] + 1])
        lid = np.where(wall < 0, which, which - (len(self.rings) - 1))
        out[~inside] = self.lids[lid[~inside]]
        return out


def touching(
    rings: Array,
    lids: Sequence[Array],
    centres: Array,
    tangents: Array,
    closed: bool,
    tight: NDArray[np.bool_] | None = None,
) -> tuple[int, int] | None:
    """Return rings i < j after which the walls, or at which the ends, of distant parts pass through each other.

    Of the parts that come near each other the nearest are looked at first, and no more of them once some do; of these
    those are returned whose middles are nearest. None where there are none. `rings` (n, k, 3) are those of one outline;
    `centres`, `tangents` (3, n) their places; on a closed path all with the first at the end again. `lids`: the
    triangles (t, 3, 3) at the start and at the end. Parts between which the path turns by less than a right angle and
    takes no `tight` step (n - 1,) are not compared, nor walls that share a ring.
    """
    reach = float(np.linalg.norm(rings - centres.T[:, None], axis=2).max())
    pairs = near_parts(centres, tangents, closed, reach, tight)
    if not len(pairs):
        return None
    pieces = _Pieces.of(rings, lids)
    s, starts = _cells(centres, tangents, reach, pieces)
    start, some = 0, _PAIRS_AT_FIRST
    while start < len(pairs):
        cells = _cells_between(pairs[start : start + some], s, 0.5 * reach)
        start, some = start + some, min(2 * some, _PAIRS_AT_ONCE)
        both = _meeting(pieces, starts, cells, closed)
        if len(both):
            middles = 0.5 * (pieces.low + pieces.high)
            nearest = np.linalg.norm(middles[both[:, 0]] - middles[both[:, 1]], axis=1).argmin()
            i, j = pieces.spans[both[nearest], 0].tolist()
            return min(i, j), max(i, j)
    return None


def _cells(centres: Array, tangents: Array, reach: float, pieces: _Pieces) -> tuple[Array, Ints]:
    """Return distances (c + 1,) along the path, and the first piece of each of the cells between, and one past all."""
    steps = norms(centres[:, 1:] - centres[:, :-1])
    gone = steps / (_CELL * reach) + norms(tangents[:, 1:] - tangents[:, :-1]) / (2.0 * _CELL)
    counted = np.floor(running(np.add, 0.0, gone))
    rows = np.flatnonzero(np.concatenate([[True], counted[1:] > counted[:-1]]))
    rows = rows[rows < len(counted) - 1]  # the last ring begins no wall
    starts = np.concatenate([[0], rows[1:] + pieces.before, [len(pieces.spans)]])
    s = running(np.add, 0.0, steps)
    return np.append(s[rows], s[-1]), starts


def _cells_between(pairs: Array, s: Array, window: float) -> Ints:
    """Return the pairs (p, 2) of cells, first not above second, within a window about pairs of places."""
    low = np.clip(np.searchsorted(s, pairs - window, side="right") - 1, 0, len(s) - 2)
    high = np.clip(np.searchsorted(s, pairs + window, side="left"), low + 1, len(s) - 1)
    i, j = _products(low, high - low).T
    keys = np.unique(np.minimum(i, j) * len(s) + np.maximum(i, j))
    return np.column_stack([keys // len(s), keys % len(s)])


def _meeting(pieces: _Pieces, starts: Ints, cells: Ints, closed: bool) -> Ints:
    """Return pairs (p, 2) of pieces in pairs of cells that pass through each other: some of the nearest, where any do.

    The nearest are compared first, few to begin with: in a tight bend nearly all do, and there are very many.
    """
    low, high = np.minimum.reduceat(pieces.low, starts[:-1]), np.maximum.reduceat(pieces.high, starts[:-1])
    i, j = cells.T
    cells = cells[((low[i] <= high[j]) & (low[j] <= high[i])).all(axis=1)]
    i, j = cells.T
    cells = cells[np.argsort(np.linalg.norm(low[i] + high[i] - low[j] - high[j], axis=1), kind="stable")]
    many = np.cumsum(np.diff(starts)[cells].prod(axis=1) * pieces.rings.shape[1])
    first, most = 0, _AT_ONCE_AT_FIRST
    while first < len(cells):
        before = many[first - 1] if first else 0
        last = max(int(np.searchsorted(many, before + most)), first + 1)
        part = cells[first:last]
        found = _meeting_pieces(pieces, _products(starts[part], np.diff(starts)[part]), closed)
        if len(found):
            return found
        first, most = last, min(2 * most, _AT_ONCE)
    return np.zeros((0, 2), dtype=np.intp)


def _meeting_pieces(pieces: _Pieces, pairs: Ints, closed: bool) -> Ints:
    """Return those of the pairs (p, 2) of pieces that pass through each other, and do not share a ring."""
    i, j = pairs[pairs[:, 0] < pairs[:, 1]].T
    before, after = pieces.spans[i], pieces.spans[j]
    apart = before[:, 1] < after[:, 0]
    if closed:
        apart &= (before[:, 0] > 0) | (after[:, 1] < len(pieces.rings) - 1)
    near = apart & ((pieces.low[i] <= pieces.high[j]) & (pieces.low[j] <= pieces.high[i])).all(axis=1)
    used, numbers = np.unique(np.column_stack([i[near], j[near]]), return_inverse=True)
    a, b = numbers.reshape(-1, 2).T
    triangles = pieces.triangles(used)
    low, high = pieces.low[used], pieces.high[used]
    lowest, highest = triangles.min(axis=2), triangles.max(axis=2)
    # Of each piece, the triangles that reach into the other one's box; then all of these against each other.
    mine = ((lowest[a] <= high[b][:, None]) & (low[b][:, None] <= highest[a])).all(axis=2)
    theirs = ((lowest[b] <= high[a][:, None]) & (low[a][:, None] <= highest[b])).all(axis=2)
    pair, first, second = _each_with_each(mine, theirs)
    ends = a[pair], first, b[pair], second
    meet = ((lowest[ends[:2]] <= highest[ends[2:]]) & (lowest[ends[2:]] <= highest[ends[:2]])).all(axis=1)
    hit = crossing(*(triangles[ends[k][meet], ends[k + 1][meet]] for k in (0, 2)))
    return np.asarray(used[np.column_stack([a, b])[np.unique(pair[meet][hit])]])


def _products(starts: Ints, counts: Ints) -> Ints:
    """Return all pairs (q, 2) of numbers from two runs, for each pair of runs: their starts and counts (p, 2)."""
    owner, within = _shared_out(counts.prod(axis=1))
    second = counts[owner, 1]
    return np.column_stack([starts[owner, 0] + within // second, starts[owner, 1] + within % second])


def _each_with_each(mine: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> tuple[Ints, Ints, Ints]:
    """Return for each row of two masks (p, t) all pairs of places where they hold: the row, the first, the second."""
    (row_a, first), (row_b, second) = np.nonzero(mine), np.nonzero(theirs)
    many = np.bincount(row_b, minlength=len(theirs))
    begin = np.cumsum(many) - many
    owner, within = _shared_out(many[row_a])
    return row_a[owner], first[owner], second[begin[row_a[owner]] + within]


def _shared_out(counts: Ints) -> tuple[Ints, Ints]:
    """Return owner and number within the owner of so many things each."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]


def _wall_triangles(first: Array, second: Array) -> Array:
    """Return the triangles (n, 2 k, 3, 3) between rings (n, k, 3) and the next."""
    a, b = first, np.roll(first, -1, axis=1)
    c, d = second, np.roll(second, -1, axis=1)
    return np.concatenate([np.stack([a, b, d], axis=2), np.stack([a, d, c], axis=2)], axis=1)
