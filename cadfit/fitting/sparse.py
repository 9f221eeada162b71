"""Dominant points of a lower square error than the paper's search finds: the default.

All points, less the least costly one after another; then rounds of moves and exchanges, each of many that are far
enough apart not to touch the same pieces; then the best rearrangement of one stretch after another (`rearrange`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from cadfit.bezier import Array, Ints
from cadfit.fitting.chain import (
    drop_costs,
    padded,
    padded_errors,
    piece_errors,
    pieces_of,
    points_inside,
    window_errors,
)
from cadfit.fitting.rearrange import rearranged

_APART = 3  # dominant points between two changes that touch no piece in common
_SHARE = 0.3  # of what is still to go, dropped in a round; at 0.1 the errors are the same
_STEPS = (-1, 1, -2, 2)  # rows a dominant point is moved by
_CANDIDATES = 8  # points of a piece that are tried as dominant ones
_ROUNDS = 30
_LEAST = 1e-12  # the part of the error by which a change must lower it: less is rounding
_WHOLE, _WINDOW = 60, 24  # dominant points rearranged at once: all if not more, and of longer chains
_LONGER = 2  # the longest step tried above the longest there is
_WORK = 1e6, 3e5  # sums to compare, likewise: what the longest step tried goes by


def sparse_chain(columns: Array, count: int, closed: bool) -> tuple[Ints, list[float]]:
    """Return `count` dominant points, rising, of the points `columns` (d, n), and the square errors on the way."""
    indices, history = settled(columns, thinned(columns, count, closed), closed)
    for start in (0, _WINDOW // 2) if count > _WHOLE else (0, count // 2):
        indices = _rearranged(columns, indices, closed, start)
    indices, last = settled(columns, indices, closed)
    return indices, history + (last if last[0] < history[-1] else last[1:])


def thinned(columns: Array, count: int, closed: bool) -> Ints:
    """Return the dominant points left when of all points the least costly are dropped, until `count` are left.

    Each round drops those that are the least costly of all near them, and among the least costly of all.
    """
    indices = np.arange(columns.shape[1])
    while (surplus := len(indices) - count) > 0:
        costs = drop_costs(columns, indices, closed, padded_errors(columns, indices, closed))
        most = int(_SHARE * surplus) + 1
        chosen = np.flatnonzero(_least_around(costs) & np.isfinite(costs))
        chosen = chosen[costs[chosen] <= np.partition(costs, most - 1)[most - 1]]
        indices = np.delete(indices, chosen[np.argsort(costs[chosen], kind="stable")[:most]])
    return indices


def settled(columns: Array, indices: Ints, closed: bool) -> tuple[Ints, list[float]]:
    """Return the dominant points after rounds of moves and exchanges, and the square error before and after each."""
    history = [float(piece_errors(columns, pieces_of(indices, closed)).sum())]
    for _ in range(_ROUNDS):
        needed = _LEAST * history[-1]
        changed = _exchanged(columns, _moved(columns, indices, closed, needed), closed, needed)
        if np.array_equal(changed, indices):
            break
        indices = changed
        history.append(float(piece_errors(columns, pieces_of(indices, closed)).sum()))
    return indices, history


def _least_around(costs: Array) -> NDArray[np.bool_]:
    """Return whether each number (m,) is the least of those near it, round the ends, the first of equal ones."""
    rank = np.empty(len(costs), dtype=np.intp)
    rank[np.argsort(costs, kind="stable")] = np.arange(len(costs))
    return np.asarray(minimum_filter1d(rank, 2 * _APART + 1, mode="wrap") == rank, dtype=bool)


def _moved(columns: Array, indices: Ints, closed: bool, needed: float) -> Ints:
    """Return the dominant points after a round of moves by a row or two, between their neighbours."""
    n, m = columns.shape[1], len(indices)
    ranks = np.arange(m) if closed else np.arange(1, m - 1)
    if m < 4:
        return indices
    around, errors = padded(indices, closed, 3), padded_errors(columns, indices, closed)
    falls, targets = np.zeros(m), indices.copy()
    for step in _STEPS:
        neighbours = around[ranks + 3], around[ranks + 4] if step > 0 else around[ranks + 2]
        room = np.sign(step) * (neighbours[1] - neighbours[0]) % n
        some = ranks[room > abs(step)]
        windows = np.stack([around[some + k] for k in range(7)], axis=1)
        windows[:, 3] = (windows[:, 3] + step) % n
        falls_now = sum(errors[some + k] for k in (1, 2, 3, 4)) - window_errors(columns, windows)
        better = falls_now > falls[some]
        falls[some[better]], targets[some[better]] = falls_now[better], windows[better, 3]
    chosen = _least_around(-falls) & (falls > needed)
    return np.sort(np.where(chosen, targets, indices))


def _exchanged(columns: Array, indices: Ints, closed: bool, needed: float) -> Ints:
    """Return the dominant points after a round of exchanges: one added for each dropped, where that pays."""
    m = len(indices)
    errors = padded_errors(columns, indices, closed)
    rows, pieces, gains = _additions(columns, indices, closed, errors)
    costs = drop_costs(columns, indices, closed, errors)
    cheapest, value = np.argsort(costs, kind="stable").tolist(), costs.tolist()
    taken = bytearray(m)  # dominant points near a change
    added, dropped = [], []

    def take(low: int, high: int) -> bool:
        near = [rank % m for rank in range(low, high)]
        free = not any(taken[rank] for rank in near) and len(near) <= m
        for rank in near:
            taken[rank] |= free
        return free

    k = 0
    for row, piece, gain in zip(rows.tolist(), pieces.tolist(), gains.tolist(), strict=True):
        if not take(piece - _APART + 1, piece + _APART + 1):
            continue
        while k < m and value[cheapest[k]] < gain - needed and not take(cheapest[k] - _APART, cheapest[k] + _APART + 1):
            k += 1
        if k == m or not value[cheapest[k]] < gain - needed:
            break
        added.append(row)
        dropped.append(cheapest[k])
        k += 1
    return np.sort(np.append(np.delete(indices, dropped), np.array(added, dtype=np.intp)))


def _additions(columns: Array, indices: Ints, closed: bool, errors: Array) -> tuple[Ints, Ints, Array]:
    """Return of each piece the row to add, the piece, and by how much that lowers the square error, falling."""
    n = columns.shape[1]
    inside = points_inside(n, pieces_of(indices, closed))
    counts = np.minimum(inside, _CANDIDATES)
    pieces = np.repeat(np.arange(len(inside)), counts)
    within = np.arange(len(pieces)) - np.repeat(np.cumsum(counts) - counts, counts)
    rows = (indices[pieces] + 1 + (2 * within + 1) * inside[pieces] // (2 * counts[pieces])) % n
    around = padded(indices, closed, 3)
    windows = np.stack(
        [*(around[pieces + k] for k in (1, 2, 3)), rows, *(around[pieces + k] for k in (4, 5, 6))], axis=1
    )
    gains = sum(errors[pieces + k] for k in (2, 3, 4)) - window_errors(columns, windows)
    order = np.lexsort((-gains, pieces))
    best = order[np.unique(pieces[order], return_index=True)[1]]
    best = best[np.argsort(-gains[best], kind="stable")]
    return rows[best], pieces[best], gains[best]


def _rearranged(columns: Array, indices: Ints, closed: bool, start: int) -> Ints:
    """Return the dominant points with stretches, from rank `start` on, rearranged as is best.

    Every other stretch at once, so that none is next to one that changes, then those in between.
    """
    m = len(indices)
    if m <= _WHOLE:
        edges = [(start, start + m - 5) if closed else (0, m - 1)]
        return _with_windows(columns, indices, closed, edges, _WORK[0]) if m > 6 or not closed else indices
    edges = [(low, low + _WINDOW if closed else min(low + _WINDOW, m - 1)) for low in range(start, m - 1, _WINDOW)]
    if closed and edges[-1][1] > edges[0][0] + m - 5:
        edges.pop()
    for some in (edges[::2], edges[1::2]):
        indices = _with_windows(columns, indices, closed, some, _WORK[1])
    return indices


def _with_windows(columns: Array, indices: Ints, closed: bool, edges: list[tuple[int, int]], work: float) -> Ints:
    """Return the dominant points with stretches, each from rank to rank, rearranged, and points exchanged between them.

    One point moves from a stretch where dropping one costs least to where one more gains most, while that pays.
    """
    n, m = columns.shape[1], len(indices)
    kept: list[list[Ints]] = []  # of each stretch: its rows with one more, as many, and one less
    errors = np.full((len(edges), 3), np.inf)
    for k, (low, high) in enumerate(edges):
        ranks = np.arange(low - 2, high + 3)
        window = indices[ranks % m] + n * (ranks // m) if closed else indices[np.clip(ranks, 0, m - 1)]
        kept.append(_choices(columns, window, work))
        for j, rows in enumerate(kept[k]):
            if len(rows):
                around = np.concatenate([window[:2], rows, window[-2:]])
                errors[k, j] = window_errors(columns, around[None] % n)[0]
    chosen = _shared_out(errors)
    dropped = np.concatenate([np.arange(low, high + 1) for low, high in edges]) % m
    found = [np.delete(indices, dropped), *(rows[j] for rows, j in zip(kept, chosen, strict=True))]
    return np.sort(np.concatenate(found) % n)


def _choices(columns: Array, window: Ints, work: float) -> list[Ints]:
    """Return the best rows between window[2] and window[-3] with one more, as many as now, and one less; maybe none."""
    own, none = window[2:-2], np.zeros(0, dtype=np.intp)
    width, spare = int(own[-1] - own[0]), int(own[-1] - own[0]) - len(own) + 1
    reach = max(int((work / (max(width, 1) * (spare + 2))) ** (1.0 / 3.0)), 3)
    if len(own) < 3 or (longest := int(np.diff(own).max())) > reach:
        return [none, own, none]
    more, same, less = rearranged(columns, window, min(reach, longest + _LONGER), (-1, 0, 1))
    pieces = [np.concatenate([window[:2], rows, window[-2:]]) % columns.shape[1] for rows in (own, same)]
    old, new = window_errors(columns, np.stack(pieces))
    return [more, same if new < (1.0 - _LEAST) * old else own, less]


def _shared_out(errors: Array) -> list[int]:
    """Return for each stretch which of its choices (k, 3) to take, as many of the first as of the last."""
    with np.errstate(invalid="ignore"):
        gains, costs = errors[:, 1] - errors[:, 0], errors[:, 2] - errors[:, 1]
    chosen = [1] * len(errors)
    cheapest = iter(np.argsort(costs, kind="stable").tolist())
    for k in np.argsort(-gains, kind="stable").tolist():
        if chosen[k] != 1:
            continue
        other = next((j for j in cheapest if j != k and chosen[j] == 1), None)
        if other is None or not gains[k] > costs[other] + _LEAST * errors[:, 1].sum():
            break
        chosen[k], chosen[other] = 0, 2
    return chosen
