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
_MOST = 1 << 14  # points at a time: what is computed of them stays within the processor's cache


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
    total = inside[busy].cumsum()
    cuts = np.arange(_MOST, total[-1], _MOST)
    for some in np.split(busy, np.unique(np.searchsorted(total, cuts) + 1)) if len(cuts) else (busy,):
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
    leave = TENSION / 3.0 * (columns.take(end, axis=1) - columns.take(before, axis=1))
    arrive = TENSION / 3.0 * (columns.take(after, axis=1) - columns.take(start, axis=1))
    s = 1.0 - t
    inner = 3.0 * s * t
    offset -= (inner * s) * leave.take(owner, axis=1)
    offset -= (inner * t) * (chord - arrive).take(owner, axis=1)
    offset -= (t * t * t) * chord.take(owner, axis=1)
    offset *= offset
    return owner, np.add.reduce(offset)


def piece_squares(
    xs: array[float], ys: array[float], zs: array[float], before: int, start: int, end: int, after: int
) -> list[float]:
    """Return the `square_distances` of one piece, to the last bit; for a few points quicker than numpy's calls.

    `xs`, `ys`, `zs`: the points' coordinates, 0 where they have fewer than three.

    >>> piece_squares(array("d", [0, 1, 2]), array("d", [0, 1, 0]), array("d", [0, 0, 0]), 0, 0, 2, 2)
    [1.0]
    """
    part, n = TENSION / 3.0, len(xs)
    x, y, z = xs[start], ys[start], zs[start]
    end_x, end_y, end_z = xs[end], ys[end], zs[end]
    chord_x, chord_y, chord_z = end_x - x, end_y - y, end_z - z
    leave_x, leave_y, leave_z = part * (end_x - xs[before]), part * (end_y - ys[before]), part * (end_z - zs[before])
    arrive_x, arrive_y = chord_x - part * (xs[after] - x), chord_y - part * (ys[after] - y)
    arrive_z = chord_z - part * (zs[after] - z)
    length = chord_x * chord_x + chord_y * chord_y + chord_z * chord_z
    squares = []
    for row in range(start + 1, end if end > start else end + n):
        row %= n
        gap_x, gap_y, gap_z = xs[row] - x, ys[row] - y, zs[row] - z
        t = (gap_x * chord_x + gap_y * chord_y + gap_z * chord_z) / length if length > 0.0 else 0.0
        t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
        s = 1.0 - t
        inner, last = 3.0 * s * t, t * t * t
        first, second = inner * s, inner * t
        gap_x = gap_x - first * leave_x - second * arrive_x - last * chord_x
        gap_y = gap_y - first * leave_y - second * arrive_y - last * chord_y
        gap_z = gap_z - first * leave_z - second * arrive_z - last * chord_z
        squares.append(gap_x * gap_x + gap_y * gap_y + gap_z * gap_z)
    return squares


def along_chord(columns: Array, start: Ints, end: Ints, inside: Ints) -> tuple[Ints, Array, Array, Array]:
    """Return of the points between rows `start` and `end` (k,) the owner, offset from the start, place on the chord.

    With the offsets (d, points) come the chords (d, k). Rows may be beyond n, past the seam of a closed curve.
    """
    owner = np.arange(len(start)).repeat(inside)
    rows = (start + 1 + inside - inside.cumsum()).repeat(inside) + np.arange(len(owner))
    origin = columns.take(start, axis=1, mode="wrap")  # take is several times as quick as an index of a second axis
    chord = columns.take(end, axis=1, mode="wrap") - origin
    offset = columns.take(rows, axis=1, mode="wrap") - origin.take(owner, axis=1)
    length = np.add.reduce(chord * chord).take(owner)
    along = np.add.reduce(offset * chord.take(owner, axis=1))
    t = np.divide(along, length, out=np.zeros(len(along)), where=length > 0.0)
    return owner, offset, chord, np.minimum(np.maximum(t, 0.0), 1.0)


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


def window_errors(columns: Array, windows: Ints) -> Array:
    """Return the square errors (k, width - 3) of the pieces along rows of consecutive dominant points (k, width)."""
    pieces = windows.take(np.arange(windows.shape[1] - 3)[:, None] + np.arange(4), axis=1)
    return piece_errors(columns, pieces.reshape(-1, 4)).reshape(pieces.shape[:2])


def start_errors(columns: Array, indices: Ints, closed: bool) -> Array:
    """Return the errors (m,) of the pieces by their starts; an open curve's end starts none: 0."""
    errors = piece_errors(columns, pieces_of(indices, closed))
    return errors if closed else np.append(errors, 0.0)


def errors_near(errors: Array, ranks: Ints, low: int, high: int) -> Array:
    """Return the summed errors (k,) of the pieces that start from `low` to `high` ranks after each of the ranks (k,).

    `errors`: the `start_errors`. No further than one rank before an open curve's start, nor at its end.
    """
    return np.asarray(errors.take(ranks[:, None] + np.arange(low, high + 1), mode="wrap").sum(axis=1))


def drop_costs(columns: Array, indices: Ints, closed: bool, errors: Array) -> tuple[Array, Array]:
    """Return by how much the square error rises (m,) when a dominant point is dropped; infinite at open ends.

    With it the errors (m, 3) of the pieces there are then: those that start at the second dominant point before it, the
    one before and the one after. `errors`: the `start_errors`.
    """
    around = padded(indices, closed, 3)
    m = len(indices)
    dropped = window_errors(columns, np.stack([around[k : k + m] for k in (0, 1, 2, 4, 5, 6)], axis=1))
    costs = dropped.sum(axis=1) - errors_near(errors, np.arange(m), -2, 1)
    if not closed:
        costs[[0, -1]] = np.inf
    return costs, dropped
