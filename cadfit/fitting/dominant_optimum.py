"""The best places for the dominant points of a stretch, their number kept: an exact dynamic programme.

A piece's error depends on four dominant points, so a state is the last dominant point, the steps to the two before it,
and how many points are left out so far. The errors of all pieces that can occur come from a few sums over the points of
each pair of start and end, since the handles enter squared at most.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.fitting.dominant_pieces import TENSION, along_chord, padded, piece_errors
from cadfit.points.clean import as_points


def optimal_dominant_points(points: ArrayLike, count: int) -> Ints:
    """Return the dominant points (count,) of the least square error that any have, for an open curve.

    `points` (n, d). Time and memory go by n times the fourth power of how many points are left out: a tenth of a second
    for 24 of 60.

    Raises ValueError for bad points (naming the row) and a count out of range. Source: Bellman's principle of
    optimality.

    >>> optimal_dominant_points([(0, 0), (1, 0), (2, 0), (3, 1), (4, 0), (5, 0)], 5)
    array([0, 2, 3, 4, 5])
    """
    given = as_points(points)
    n = len(given)
    if count not in range(2, n + 1):
        raise ValueError(f"the count must be a whole number from 2 to {n}, the number of points, not {count}")
    count = int(count)
    first = np.append(np.arange(count - 1), n - 1)
    return rearranged(np.ascontiguousarray(given.T), padded(first, False, 2), n)


def best_choice(columns: Array, count: int) -> Ints:
    """Return the dominant points (count,) of the least square error on a closed curve, by trying all choices."""
    choices = np.array(list(combinations(range(columns.shape[1]), count)))
    pieces = np.stack([np.roll(choices, -k, axis=1) for k in (-1, 0, 1, 2)], axis=2)
    errors = piece_errors(columns, pieces.reshape(-1, 4)).reshape(choices.shape)
    return np.asarray(choices[errors.sum(axis=1).argmin()])


def rearranged(columns: Array, window: Ints, reach: int) -> Ints:
    """Return the best dominant points between window[2] and window[-3], which are kept, with no step above `reach`.

    `columns` (d, n): the points. `window` (k + 4,): consecutive dominant points, two on either side staying as they
    are; rows rise, beyond n past the seam of a closed curve, and repeat an open end. No step may now be above it.
    """
    outer, first, last, after = window[:2], int(window[2]), int(window[-3]), window[-2:]
    width = last - first
    spare = width - len(window) + 5  # points left out
    reach = min(reach, spare + 1)
    errors = _piece_errors(columns, first, width, reach, int(outer[1]), int(after[0]))
    steps = np.arange(1, reach + 1)
    errors[0, 0, 0] = piece_errors(columns, _rows(columns, *outer, first, np.minimum(first + steps, after[0])))
    # ahead[b, s, g, f]: the least error of the chains to place b, s points left out, whose last step is g, with the
    # piece before b, when f + 1 is the next step; with room for steps back to before the first place, and fewer than no
    # points left out. A step of 0 leads to the dominant points before the window.
    ahead = np.full((reach + width + 1, reach + spare + 1, reach + 1, reach), np.inf)
    ahead[reach, reach, 0] = errors[0, 0, 0]
    # before[b, h, s, g]: the same of chains to place b whose last steps are h and g + 1, with g points left out in that
    from_place, from_left, from_step, to_step = ahead.strides
    before = np.lib.stride_tricks.as_strided(
        ahead[reach - 1 :, reach:],
        (width + 1, reach + 1, spare + 1, reach),
        (from_place, from_step, from_left, to_step - from_place - from_left),
        writeable=False,
    )
    for b in range(1, width):
        ahead[reach + b, reach:, 1:] = np.minimum.reduce(before[b, ..., None] + errors[b, :, None, 1:])
    near = np.maximum(last - np.arange(reach + 1), first)
    errors[width] += piece_errors(columns, _rows(columns, near, last, *after))[:, None]
    return first + _traced(before, errors)


def _traced(before: Array, errors: Array) -> Ints:
    """Return the places of the best chain that leaves out all it can spare, back from its last two steps."""
    places, left = [len(before) - 1], before.shape[2] - 1
    ends = before[-1, :, left] + errors[-1, :, 1:, 0]
    h, g = (int(step) for step in np.unravel_index(ends.argmin(), ends.shape))
    while places[-1] > g + 1:
        places.append(places[-1] - g - 1)
        left -= g
        g, h = h - 1, int((before[places[-1], :, left, h - 1] + errors[places[-1], :, h, g]).argmin())
    return np.array([0, *places[::-1]])


def _rows(columns: Array, *rows: int | Ints) -> Ints:
    """Return pieces (k, 4) of rows, numbers or (k,), back in the range of the points."""
    return np.asarray(np.stack(np.broadcast_arrays(*rows), axis=1) % columns.shape[1])


def _piece_errors(columns: Array, first: int, width: int, reach: int, before: int, after: int) -> Array:
    """Return the errors [b, h, g, f] of the pieces from b - g to b, after b - g - h and before b + f + 1.

    Places count from `first` and end at `width`; h = 0 is the row `before`, for a piece from place 0 alone, and what
    is beyond the last place is the row `after`. What cannot occur is infinite.
    """
    n = columns.shape[1]
    end, step = np.nonzero(np.arange(width + 1)[:, None] >= np.arange(1, reach + 1))
    step += 1
    start = end - step
    back, ahead = start[:, None] - np.arange(reach + 1), end[:, None] + np.arange(1, reach + 1)
    possible = (back >= 0) & (back < start[:, None])
    possible[:, 0] = start == 0
    rows_back = first + back
    rows_back[:, 0] = before
    rows_ahead = np.where(ahead <= width, first + ahead, after)
    places, ends = columns[:, (first + start) % n], columns[:, (first + end) % n]
    leave = TENSION / 3.0 * (ends[:, :, None] - columns[:, rows_back % n])
    arrive = TENSION / 3.0 * (columns[:, rows_ahead % n] - places[:, :, None])
    squares, pull, weights = _sums(columns, first + start, step)
    by_leave = weights[0][:, None] * (leave * leave).sum(axis=0) - 2.0 * (pull[0][:, :, None] * leave).sum(axis=0)
    by_arrive = weights[1][:, None] * (arrive * arrive).sum(axis=0) + 2.0 * (pull[1][:, :, None] * arrive).sum(axis=0)
    by_both = 2.0 * weights[2][:, None, None] * np.einsum("dkh,dkf->khf", leave, arrive)
    found = (squares[:, None] + by_leave)[:, :, None] + by_arrive[:, None] - by_both
    found[~possible] = np.inf
    errors = np.full((width + 1, reach + 1, reach + 1, reach), np.inf)
    errors[end, :, step] = found
    return errors


def _sums(columns: Array, start: Ints, step: Ints) -> tuple[Array, Array, Array]:
    """Return what pieces from `start` over `step` rows need to know of the points inside, whatever their handles.

    A point's gap is q - a L + b A with the handles L and A: the sums of q^2 (k,), of a q and b q (2, d, k), and of a^2,
    b^2 and a b (3, k).
    """
    inside = step - 1
    owner, offset, chord, t = along_chord(columns, start, start + step, inside)
    s = 1.0 - t
    a, b = 3.0 * s * s * t, 3.0 * s * t * t
    q = offset - (b + t * t * t) * chord.take(owner, axis=1)

    def total(terms: Array) -> Array:
        return np.asarray(np.bincount(owner, terms, len(start)))

    pull = np.array([[total(weight * each) for each in q] for weight in (a, b)])
    return total((q * q).sum(axis=0)), pull, np.array([total(a * a), total(b * b), total(a * b)])
