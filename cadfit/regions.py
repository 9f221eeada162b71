"""Plane regions bounded by closed curves: signed area, where curves meet, what lies inside.

A loop is an array of cubic Bézier pieces (m, 4, 2), each starting where the one before ends, the first where the last
ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadfit.bezier import Array, Ints, evaluate, split

_NODES, _WEIGHTS = (0.5 * rule for rule in np.polynomial.legendre.leggauss(3))  # exact to degree 5
_LEVELS = 60  # halvings after which a pair that still meets is settled as it stands
_MOST_PAIRS = 1 << 18  # more than this meet only where curves run along each other


def signed_area(loop: Array) -> float:
    """Return the area that a loop (m, 4, 2) runs around: positive counterclockwise. Exact but for rounding.

    >>> signed_area(polygon([(0, 0), (2, 0), (2, 1), (0, 1)]))
    2.0
    """
    places = loop - loop[0, 0]
    legs = 3.0 * np.diff(places, axis=1)
    total = 0.0
    for t, weight in zip(_NODES + 0.5, _WEIGHTS, strict=True):
        at, s = evaluate(places, t), 1.0 - t
        velocity = s * s * legs[:, 0] + 2.0 * s * t * legs[:, 1] + t * t * legs[:, 2]
        total += weight * float((at[:, 0] * velocity[:, 1] - at[:, 1] * velocity[:, 0]).sum())
    return float(0.5 * total)


def polygon(vertices: Array | Sequence[Sequence[float]]) -> Array:
    """Return the loop (m, 4, 2) of straight pieces through m vertices (m, 2)."""
    starts = np.asarray(vertices, dtype=np.float64)
    chords = np.roll(starts, -1, axis=0) - starts
    loop = starts[:, None] + np.array([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0])[:, None] * chords[:, None]
    loop[:, 3] = np.roll(starts, -1, axis=0)
    return loop


def inside(loop: Array, others: Array) -> bool:
    """Whether a loop that does not meet `others` (a loop, too) lies inside it: judged at its place farthest from it.

    >>> square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)])
    >>> inside(0.25 * square + 1.0, square), inside(square, 0.25 * square + 1.0)
    (True, False)
    """
    boundary = np.concatenate([evaluate(others, t) for t in np.arange(16) / 16])
    boundary = boundary.reshape(16, -1, 2).transpose(1, 0, 2).reshape(-1, 2)
    places = loop[np.linspace(0, len(loop) - 1, min(len(loop), 64)).astype(np.intp), 0]
    gaps = np.array([np.linalg.norm(boundary - place, axis=1).min() for place in places])
    x, y = (boundary - places[int(gaps.argmax())]).T
    turned = np.arctan2(x * np.roll(y, -1) - y * np.roll(x, -1), x * np.roll(x, -1) + y * np.roll(y, -1))
    return bool(abs(turned.sum()) > np.pi)


def meeting(loops: Sequence[Array]) -> tuple[int, int, Array] | None:
    """Return the numbers of two loops (or twice the same) and a place where they cross or touch; None if nowhere.

    Pairs of pieces are halved until their boxes or their fat lines are apart, or both are straight to 1e-13 of the
    size and their chords meet. Neighbouring pieces are settled when all legs of their control polygons point forward
    along one direction: such a curve cannot meet itself. So no crossing is missed; loops that come closer than 1e-13
    of the size may be said to touch.

    >>> meeting([polygon([(0, 0), (2, 0), (2, 1), (0, 1)])]) is None
    True
    >>> meeting([polygon([(0, 0), (2, 2), (2, 0), (0, 2)])])
    (0, 0, array([1., 1.]))
    """
    fine = [_in_three(loop) for loop in loops]
    pieces, owner = np.concatenate(fine), np.repeat(np.arange(len(fine)), [len(loop) for loop in fine])
    size = float(np.ptp(pieces.reshape(-1, 2), axis=0).max())
    following = np.concatenate([np.roll(np.arange(len(loop)), -1) for loop in fine])
    following += np.concatenate([np.full(len(loop), start) for loop, start in zip(fine, _starts(fine), strict=True)])
    alone, first, second = _own_meetings(pieces, following)
    left, right = _boxes_meeting(pieces)
    apart = (following[left] != right) & (following[right] != left)
    left, right = left[apart], right[apart]
    who = np.concatenate([np.column_stack([owner[alone]] * 2), np.column_stack([owner[left], owner[right]])])
    return _settled(np.concatenate([first, pieces[left]]), np.concatenate([second, pieces[right]]), who, size)


def _starts(loops: Sequence[Array]) -> Ints:
    return np.cumsum([0, *[len(loop) for loop in loops[:-1]]])


def _in_three(loop: Array) -> Array:
    """Return the loop in three pieces or more, so that no two pieces meet at both ends."""
    while len(loop) < 3:
        loop = np.stack(split(loop), axis=1).reshape(-1, 4, 2)
    return loop


def _own_meetings(pieces: Array, following: Ints) -> tuple[Ints, Array, Array]:
    """Return the pairs of parts of a piece, or of a piece and its follower, that are still to be looked at.

    As the number of the piece (k,), and the parts (k, 4, 2) twice; parts that follow each other are settled here.
    """
    number = np.arange(len(pieces))
    one, one_of = pieces, number  # against themselves
    before, after, pair_of = pieces, pieces[following], number  # one follows the other
    rows, first, second = [], [], []
    for _ in range(_LEVELS):
        bent = ~_forward(one)
        one, one_of = one[bent], one_of[bent]
        bent = ~_forward(before, after)
        before, after, pair_of = before[bent], after[bent], pair_of[bent]
        if not len(one) and not len(before):
            break
        left, right = split(one)
        a, b = split(before)
        c, d = split(after)
        rows += [pair_of] * 3
        first += [a, a, b]
        second += [c, d, d]
        before, after = np.concatenate([left, b]), np.concatenate([right, c])
        pair_of = np.concatenate([one_of, pair_of])
        one, one_of = np.concatenate([left, right]), np.tile(one_of, 2)
    empty = np.zeros((0, 4, 2))
    return (
        np.concatenate([np.zeros(0, dtype=np.intp), *rows]),
        np.concatenate([empty, *first]),
        np.concatenate([empty, *second]),
    )


def _forward(*chain: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether all legs of pieces that follow each other point forward along one direction (m,): the legs' mean."""
    legs = np.concatenate([np.diff(pieces, axis=1) for pieces in chain], axis=1)
    sizes = np.linalg.norm(legs, axis=2, keepdims=True)
    units = np.divide(legs, sizes, out=np.zeros_like(legs), where=sizes > 0)
    along = np.einsum("mld,md->ml", units, units.sum(axis=1))
    return np.asarray(np.all((along > 1e-9) | (sizes[:, :, 0] == 0), axis=1))


def _boxes_meeting(pieces: Array) -> tuple[Ints, Ints]:
    """Return the pairs of different pieces whose boxes meet: swept along the longer side."""
    low, high = pieces.min(axis=1), pieces.max(axis=1)
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    stop = np.searchsorted(low[order, axis], high[order, axis], side="right")
    counts = stop - np.arange(len(order)) - 1
    lefts, rights = [], []
    for start in range(0, len(order), 4096):
        rows = np.arange(start, min(start + 4096, len(order)))
        left = np.repeat(rows, counts[rows])
        right = left + 1 + np.arange(len(left)) - np.repeat(np.cumsum(counts[rows]) - counts[rows], counts[rows])
        left, right = order[left], order[right]
        both = np.all((low[left] <= high[right]) & (low[right] <= high[left]), axis=1)
        lefts.append(left[both])
        rights.append(right[both])
    return np.concatenate(lefts), np.concatenate(rights)


def _settled(first: Array, second: Array, who: Ints, size: float) -> tuple[int, int, Array] | None:
    """Halve pairs of parts until none is left, or one is found to meet."""
    for level in range(_LEVELS):
        near = np.all((first.min(1) <= second.max(1)) & (second.min(1) <= first.max(1)), axis=1)
        near[near] = ~_lines_apart(first[near], second[near])
        near[near] &= ~_lines_apart(second[near], first[near])
        first, second, who = first[near], second[near], who[near]
        if not len(who):
            return None
        straight = np.maximum(_thickness(first), _thickness(second)) <= 1e-13 * size
        met = straight & _chords_meet(first, second)
        if level == _LEVELS - 1 or len(who) > _MOST_PAIRS:
            met[:1] = True
        if met.any():
            k = int(np.argmax(met))
            return int(who[k, 0]), int(who[k, 1]), _crossing(first[k], second[k])
        first, second, who = first[~straight], second[~straight], who[~straight]
        (a, b), (c, d) = split(first), split(second)
        first, second, who = np.concatenate([a, a, b, b]), np.concatenate([c, d, c, d]), np.tile(who, (4, 1))
    return None


def _sides(pieces: Array, chord_of: Array) -> Array:
    """Return the signed areas (m, 4) that the poles of pieces make with the chords of others."""
    chord, offset = chord_of[:, 3] - chord_of[:, 0], pieces - chord_of[:, :1]
    return np.asarray(chord[:, :1] * offset[:, :, 1] - chord[:, 1:] * offset[:, :, 0])


def _lines_apart(first: Array, second: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether the second parts lie on one side of the strips, along their chords, that hold the first (m,)."""
    own, other = _sides(first, first), _sides(second, first)
    return np.asarray((other.min(axis=1) > own.max(axis=1)) | (other.max(axis=1) < own.min(axis=1)))


def _thickness(pieces: Array) -> Array:
    """Return how far the inner poles are from their thirds of the chord (m,): the piece is straight to that."""
    thirds = np.array([1.0 / 3.0, 2.0 / 3.0])[:, None]
    chord = pieces[:, :1] + thirds * (pieces[:, 3:] - pieces[:, :1])
    return np.asarray(np.linalg.norm(pieces[:, 1:3] - chord, axis=2).max(axis=1))


def _chords_meet(first: Array, second: Array) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    one, other = _sides(second, first)[:, ::3], _sides(first, second)[:, ::3]
    return np.asarray((one[:, 0] * one[:, 1] <= 0) & (other[:, 0] * other[:, 1] <= 0))


def _crossing(first: Array, second: Array) -> Array:
    """Return where two chords meet: the first's place that divides it as the second's line does."""
    one = _sides(first[None], second[None])[0, ::3]
    share = one[0] / (one[0] - one[1]) if one[0] != one[1] else 0.5
    return np.asarray(first[0] + share * (first[3] - first[0]))
