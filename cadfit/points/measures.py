"""What is measured of many points, a block of rows at a time: 1e6 pass through the cache, and take no fresh memory."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cadfit.bezier import Array

_BLOCK = 1 << 13


def blocks(n: int) -> Iterator[slice]:
    """Yield n rows a block at a time."""
    return (slice(start, start + _BLOCK) for start in range(0, n, _BLOCK))


def chord_lengths(points: Array) -> Array:
    """Return the lengths (n - 1,) of the chords between neighbours of points (n, d).

    >>> chord_lengths(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]))
    array([5., 1.])
    """
    lengths = np.empty(len(points) - 1)
    for rows in blocks(len(lengths)):
        chords = points[rows.start + 1 : rows.stop + 1] - points[rows.start : min(rows.stop, len(lengths))]
        _square_sums(chords, lengths[rows])
    return np.sqrt(lengths, out=lengths)


def lengths_along(points: Array) -> Array:
    """Return how long the polyline of points (n, d) is up to each of them (n,).

    >>> lengths_along(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]))
    array([0., 5., 6.])
    """
    along = np.empty(len(points))
    along[0] = 0.0
    np.add.accumulate(chord_lengths(points), out=along[1:])
    return along


def distances_from(points: Array, place: Array) -> Array:
    """Return the distances (n,) of points (n, d) from a place (d,), or each from a place of its own (n, d).

    >>> distances_from(np.array([[3.0, 4.0], [0.0, 1.0]]), np.zeros(2))
    array([5., 1.])
    """
    found, one = np.empty(len(points)), np.ndim(place) == 1
    for rows in blocks(len(points)):
        _square_sums(points[rows] - (place if one else place[rows]), found[rows])
    return np.sqrt(found, out=found)


def extent(points: Array) -> float:
    """Return the longest side of the box around points (n, d)."""
    return float(max(column.max() - column.min() for column in points.T))  # quicker than along the first axis


def middle(points: Array) -> Array:
    """Return the mean (d,) of points (n, d), to the last bit the same in whichever order they come.

    They are summed as multiples of a unit so coarse that the sum is exact; so is what is left, of a finer one.

    >>> middle(np.array([[1e16, 0.0], [1.0, 3.0], [-1e16, 0.0]]))
    array([0.33333333, 1.        ])
    """
    digits = 52 - len(points).bit_length()
    coarse = 2.0 ** (np.frexp([np.abs(column).max() for column in points.T])[1] - digits)
    sums = np.zeros((2, points.shape[1]))
    for rows in blocks(len(points)):
        left = points[rows]
        for total, unit in zip(sums, (coarse, coarse * 2.0**-digits), strict=True):
            multiples = np.rint(left / unit)
            total += np.ones(len(left)) @ multiples * unit
            left = left - multiples * unit
    return np.asarray(sums.sum(axis=0) / len(points))


def _square_sums(vectors: Array, sums: Array) -> None:
    """Put the squared lengths of vectors (n, d), which are overwritten, into `sums` (n,).

    Column by column: several times as quick as sums of short rows, and to the last bit the same.
    """
    vectors *= vectors
    sums[:] = vectors[:, 0]
    for column in vectors.T[1:]:
        sums += column
