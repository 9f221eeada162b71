"""Dominant points of a lower square error than the paper's search finds: the default.

All points, less the least costly one after another, or what the paper's search finds, where that is better; where the
dominant points are few, their best arrangement (`dominant_optimum`); then rounds of moves and exchanges, each of many
that are far enough apart not to touch the same pieces. No step raises the square error.
"""

from __future__ import annotations

from math import comb

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.dominant_optimum import best_choice, rearranged
from cadfit.fitting.dominant_pieces import (
    chain_error,
    drop_costs,
    errors_near,
    padded,
    pieces_of,
    points_inside,
    start_errors,
    window_errors,
)
from cadfit.stages import Progress, unheard

_APART = 3  # dominant points between two changes that touch no piece in common
_SHARE = 0.8  # of what is still to go, at most this is dropped in a round: at 0.3 the errors are much the same
_STEPS = (-1, 1, -2, 2)  # rows a dominant point is moved by
_CANDIDATES = 8  # points of a piece that are tried as dominant ones
_ROUNDS = 8
_PART = 0.003  # a round that lowers the error by less than this part is the last
_LEAST = 1e-12  # the part of the error by which a change must lower it: less is rounding
_CHOICES = 2000  # of dominant points of a closed curve, that are all tried
_FEW = 130  # dominant points that are rearranged
_SMALL = 60  # points of which steps are tried as long as _LITTLE work allows
_LONGER = 2  # of more, the longest step tried above the longest there is
_LITTLE, _WORK = 2e5, 5e5  # sums to compare: what the longest step tried goes by


def improved(
    columns: Array, starts: list[Ints], closed: bool, progress: Progress = unheard
) -> tuple[Ints, list[float]]:
    """Return the dominant points that descent leads to from the better of some, and the square errors on the way.

    `columns` (d, n): the points. `starts`: dominant points (m,), rising. No square error is above one before it.
    """
    n, m = columns.shape[1], len(starts[0])
    if closed and n <= _SMALL and comb(n, m) <= _CHOICES:
        starts = [*starts, best_choice(columns, m)]
    indices = min(starts, key=lambda each: chain_error(columns, each, closed))
    history, arranged = [chain_error(columns, indices, closed)], False
    for start in _rearranging(n, m, closed):
        found = _rearranged(columns, indices, closed, start)
        arranged = found is not indices
        if (error := chain_error(columns, found, closed)) < history[-1]:
            indices = found
            history.append(error)
    if arranged and n <= _SMALL:  # moves and exchanges find next to nothing then
        return indices, history
    indices, last = settled(columns, indices, closed, progress)
    return indices, history + last[1:]


def thinned(columns: Array, count: int, closed: bool) -> Ints:
    """Return the dominant points left when of all points the least costly are dropped, until `count` are left.

    Each round drops many that are apart, the least costly first.
    """
    indices, errors = np.arange(columns.shape[1]), np.zeros(columns.shape[1])
    while (surplus := len(indices) - count) > 0:
        costs, then = drop_costs(columns, indices, closed, errors)
        most = int(_SHARE * (surplus - 1)) + 1
        order = np.argsort(costs, kind="stable")[:most]
        dropped = _apart(order[np.isfinite(costs[order])], len(indices))
        errors[(dropped[:, None] + np.array([-2, -1, 1])) % len(errors)] = then[dropped]
        indices, errors = np.delete(indices, dropped), np.delete(errors, dropped)
    return indices


def settled(columns: Array, indices: Ints, closed: bool, progress: Progress = unheard) -> tuple[Ints, list[float]]:
    """Return the dominant points after rounds of moves and exchanges, and the square error before and after each."""
    errors = start_errors(columns, indices, closed)
    history = [float(errors.sum())]
    for turn in range(_ROUNDS):
        progress(turn / _ROUNDS)
        before = history[-1]
        needed = _LEAST * before
        changed = _exchanged(columns, _moved(columns, indices, closed, errors, needed), closed, needed)
        errors = start_errors(columns, changed, closed)
        error = float(errors.sum())
        if error < before:
            indices = changed
            history.append(error)
        if error >= (1.0 - _PART) * before:
            break
    return indices, history


def _apart(ranks: Ints, m: int) -> Ints:
    """Return those of the ranks, below m, that are far enough from all before them, also round the ends."""
    near, kept = bytearray(m), []
    for rank in ranks.tolist():
        if not near[rank]:
            kept.append(rank)
            for other in range(rank - _APART, rank + _APART + 1):
                near[other % m] = True
    return np.array(kept, dtype=np.intp)


def _moved(columns: Array, indices: Ints, closed: bool, errors: Array, needed: float) -> Ints:
    """Return the dominant points after a round of moves by a row or two, between their neighbours."""
    n, m = columns.shape[1], len(indices)
    ranks = np.arange(m) if closed else np.arange(1, m - 1)
    if m < 4:
        return indices
    around = padded(indices, closed, 3)
    gaps = np.diff(around) % n  # from the dominant point of rank k - 3 to the next
    steps = np.array(_STEPS)
    possible = np.abs(steps)[:, None] < np.where(steps[:, None] > 0, gaps[ranks + 3], gaps[ranks + 2])
    which, some = np.nonzero(possible)
    some = ranks[some]
    windows = np.stack([around[some + k] for k in range(7)], axis=1)
    windows[:, 3] = (windows[:, 3] + steps[which]) % n
    falls = np.zeros((len(steps), m))
    falls[which, some] = errors_near(errors, some, -2, 1) - window_errors(columns, windows).sum(axis=1)
    most, step = falls.max(axis=0), steps[falls.argmax(axis=0)]
    order = np.argsort(-most, kind="stable")
    chosen = _apart(order[most[order] > needed], m)
    moved = indices.copy()
    moved[chosen] = (moved[chosen] + step[chosen]) % n
    return np.sort(moved)


def _exchanged(columns: Array, indices: Ints, closed: bool, needed: float) -> Ints:
    """Return the dominant points after a round of exchanges: one added for each dropped, where that pays."""
    m = len(indices)
    errors = start_errors(columns, indices, closed)
    rows, pieces, gains = _additions(columns, indices, closed, errors)
    costs = drop_costs(columns, indices, closed, errors)[0]
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
    gains = errors_near(errors, pieces, -1, 1) - window_errors(columns, windows).sum(axis=1)
    order = np.lexsort((-gains, pieces))
    best = order[np.unique(pieces[order], return_index=True)[1]]
    best = best[np.argsort(-gains[best], kind="stable")]
    return rows[best], pieces[best], gains[best]


def _rearranging(n: int, m: int, closed: bool) -> tuple[int, ...]:
    """Return the ranks from which the dominant points are rearranged; a closed curve's three from there on stay."""
    if m > _FEW or m < (4 if closed else 3):
        return ()
    quarters = 1 if not closed else 2 if n > _SMALL else 4
    return tuple(quarter * m // quarters for quarter in range(quarters))


def _rearranged(columns: Array, indices: Ints, closed: bool, start: int) -> Ints:
    """Return the dominant points in the best arrangement, as they are where that is too much work.

    Of many points steps are not tried that are much longer than the longest.
    """
    n, m = columns.shape[1], len(indices)
    ranks = np.arange(start, start + m + 3) if closed else np.clip(np.arange(-2, m + 2), 0, m - 1)
    window = indices[ranks % m] + n * (ranks // m)
    width, longest = int(window[-3] - window[2]), int(np.diff(window[2:-2]).max())
    most = max(int(((_LITTLE if n <= _SMALL else _WORK) / (width * (width - len(window) + 7))) ** (1.0 / 3.0)), 3)
    if longest > most + 1:
        return indices
    found = rearranged(columns, window, max(most if n <= _SMALL else min(most, longest + _LONGER), longest))
    return np.unique(np.concatenate([window[:2], found, window[-2:]]) % n)
