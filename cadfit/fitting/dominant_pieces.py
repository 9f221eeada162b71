"""Chains of dominant points: the square errors of their pieces, of any number of pieces at once.

A piece is four rows of the points: the dominant point before its start, its start, its end, and the one after that; an
open curve's ends stand in for what is beyond them. All four matter, since the piece's Bézier handles are the cardinal
tangents at its ends. So a dominant point that comes, goes or moves changes four pieces at most.
"""

from __future__ import annotations

from array import array

import numpy as np

from cadfit.bezier import Array, Ints

TENSION = 0.5
_MOST = 1 << 19  # points at a time: what is computed of them stays within some 100 MB


def piece_errors(columns: Array, pieces: Ints) -> Array:
    """Return the square error (k,) of each piece (k, 4): the sum of `square_distances` over the points inside it.

    `columns` (d, n): the points, a row a coordinate. Pieces of a closed curve may pass its seam.

    >>> columns = np.array([[0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 0.0]])
    >>> piece_errors(columns, np.array([[0, 0, 2, 3], [0, 2, 3, 3]])).round(4)
    array([1.0039, 0.    ])
    """
    errors = np.zeros(len(pieces))
    inside = points_inside(columns.shape[1], pieces)
    busy = np.flatnonzero(inside)
    if not len(busy):
        return errors
    total = np.cumsum(inside[busy])
    cuts = np.searchsorted(total, np.arange(_MOST, total[-1], _MOST)) + 1
    for some in np.split(busy, np.unique(cuts)) if len(cuts) else (busy,):
        owner, squares = square_distances(columns, pieces[some], inside[some])
        errors[some] = np.bincount(owner, squares, len(some))
    return errors


def chain_error(columns: Array, indices: Ints, closed: bool) -> float:
    """Return the square error of the dominant points `indices`: the sum of those of the pieces between them."""
    return float(piece_errors(columns, pieces_of(indices, closed)).sum())


def points_inside(n: int, pieces: Ints) -> Ints:
    """Return how many points (k,) lie inside each piece: between its start and its end."""
    return np.asarray(np.maximum((pieces[:, 2] - pieces[:, 1]) % n - 1, 0))


def square_distances(columns: Array, pieces: Ints, inside: Ints) -> tuple[Ints, Array]:
    """Return for each point inside the pieces, in order, which piece it is in and its squared distance to that.

    The distance is to the place on the piece whose parameter the point's projection on the chord gives, as a part of
    the chord's length, at least 0 and at most 1; 0 where the chord has no length. `inside` as `points_inside`.
    Source: the paper, section 2.5.
    """
    before, start, end, after = pieces.T
    owner, offset, chord, t = along_chord(columns, start, end, inside)
    leave = TENSION / 3.0 * (columns[:, end] - columns[:, before])
    arrive = TENSION / 3.0 * (columns[:, after] - columns[:, start])
    s = 1.0 - t
    inner = 3.0 * s * t
    offset -= (inner * s) * leave[:, owner]
    offset -= (inner * t) * (chord - arrive)[:, owner]
    offset -= (t * t * t) * chord[:, owner]
    offset *= offset
    return owner, offset.sum(axis=0)


def piece_squares(points: array[float], d: int, before: int, start: int, end: int, after: int) -> list[float]:
    """Return the `square_distances` of one piece, to the last bit; for a few points quicker than numpy's calls.

    `points`: the n d coordinates, point by point.

    >>> piece_squares(array("d", [0, 0, 1, 1, 2, 0]), 2, 0, 0, 2, 2)
    [1.0]
    """
    z, a, b, c = (points[d * row : d * row + d] for row in (before, start, end, after))
    part = TENSION / 3.0
    axes = [  # start, chord, and the handles from the start
        (p, q - p, part * (q - o), (q - p) - part * (r - p)) for o, p, q, r in zip(z, a, b, c, strict=True)
    ]
    length = 0.0
    for _, chord, _, _ in axes:
        length += chord * chord
    squares = []
    for row in range(start + 1, end if end > start else end + len(points) // d):
        place = d * row % len(points)
        point = points[place : place + d]
        along = 0.0
        for x, (origin, chord, _, _) in zip(point, axes, strict=True):
            along += (x - origin) * chord
        t = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0
        s = 1.0 - t
        inner, last = 3.0 * s * t, t * t * t
        first, second = inner * s, inner * t
        square = 0.0
        for x, (origin, chord, leave, arrive) in zip(point, axes, strict=True):
            gap = x - origin - first * leave - second * arrive - last * chord
            square += gap * gap
        squares.append(square)
    return squares


def along_chord(columns: Array, start: Ints, end: Ints, inside: Ints) -> tuple[Ints, Array, Array, Array]:
    """Return of the points between rows `start` and `end` (k,) the owner, offset from the start, place on the chord.

    With the offsets (d, points) come the chords (d, k). Rows may be beyond n, past the seam of a closed curve.
    """
    n = columns.shape[1]
    owner = np.repeat(np.arange(len(start)), inside)
    rows = np.repeat(start + 1 + inside - np.cumsum(inside), inside) + np.arange(len(owner))
    origin = columns[:, start % n]
    chord = columns[:, end % n] - origin
    length = (chord * chord).sum(axis=0)[owner]
    offset = columns[:, rows % n] - origin[:, owner]
    along = (offset * chord[:, owner]).sum(axis=0)
    t = np.clip(np.divide(along, length, out=np.zeros_like(along), where=length > 0.0), 0.0, 1.0)
    return owner, offset, chord, t


def padded(indices: Ints, closed: bool, width: int) -> Ints:
    """Return the dominant points (m + 2 width,) with as many more at each end: an open end's, or round the seam."""
    m = len(indices)
    around = np.arange(-width, m + width)
    return indices[around % m] if closed else indices[np.clip(around, 0, m - 1)]


def pieces_of(indices: Ints, closed: bool) -> Ints:
    """Return the pieces of a chain, (m - 1, 4), closed (m, 4).

    >>> pieces_of(np.array([0, 3, 5]), closed=False)
    array([[0, 0, 3, 5],
           [0, 3, 5, 5]])
    """
    around = padded(indices, closed, 2)
    count = len(indices) - (not closed)
    return np.stack([around[k : k + count] for k in (1, 2, 3, 4)], axis=1)


def handles(points: Array, pieces: Ints) -> Array:
    """Return the Bézier poles (k, 4, d) of pieces (k, 4), of points (n, d): those of the cardinal spline.

    >>> handles(np.array([[0.0], [1.0], [3.0]]), np.array([[0, 0, 2, 2]]))[0, :, 0]
    array([0. , 0.5, 2.5, 3. ])
    """
    before, start, end, after = (points[rows] for rows in pieces.T)
    poles = [start, start + TENSION / 3.0 * (end - before), end - TENSION / 3.0 * (after - start), end]
    return np.stack(poles, axis=1)


def pieces_along(windows: Ints) -> Ints:
    """Return the pieces (k, width - 3, 4) of rows of consecutive dominant points (k, width)."""
    return np.lib.stride_tricks.sliding_window_view(windows, 4, axis=1)


def window_errors(columns: Array, windows: Ints) -> Array:
    """Return the summed square errors (k,) of the pieces along each row of consecutive dominant points (k, width)."""
    pieces = pieces_along(windows)
    return np.asarray(piece_errors(columns, pieces.reshape(-1, 4)).reshape(pieces.shape[:2]).sum(axis=1))


def padded_errors(columns: Array, indices: Ints, closed: bool) -> Array:
    """Return the errors (m + 6,) of the pieces by their starts, from the third before the first dominant point on."""
    errors = piece_errors(columns, pieces_of(indices, closed))
    return errors[np.arange(-3, len(indices) + 3) % len(errors)] if closed else np.pad(errors, (3, 4))


def drop_costs(columns: Array, indices: Ints, closed: bool, errors: Array) -> Array:
    """Return by how much the square error rises (m,) when a dominant point is dropped; infinite at open ends.

    `errors`: those of `padded_errors`.
    """
    around = padded(indices, closed, 3)
    m = len(indices)
    windows = np.stack([around[k : k + m] for k in (0, 1, 2, 4, 5, 6)], axis=1)
    costs = window_errors(columns, windows) - sum(errors[k : k + m] for k in (1, 2, 3, 4))
    if not closed:
        costs[[0, -1]] = np.inf
    return np.asarray(costs)
