"""Points as people have them: checked, repeats taken out and counted, closed contours recognised."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.numbers import as_numbers, check_finite
from cadfit.points.measures import extent

LARGEST = 1e60
"""Coordinates are below this: fifth powers of lengths are computed."""
_SQUARED = 1e150  # lengths that are squared, and no more, are below this and above one over it


@dataclass(frozen=True, slots=True, eq=False)
class CleanPoints:
    """Points without consecutive repeats, and what became of the caller's rows.

    `points` (n, d); `kept` (n,) and `dropped` are indices of the caller's rows: points[i] is the caller's row
    kept[i], and each dropped row repeated the row before it. `closed`: the curve returns to its first point, which
    is not repeated at the end (a last row that repeated the first is in neither list).
    """

    points: Array
    kept: Ints
    dropped: Ints
    closed: bool


def as_points(points: ArrayLike | Sequence[Sequence[float]], least: int = 2) -> Array:
    """Return the points as a float64 array (n, d), checked; the caller's own where it is one already.

    Raises ValueError naming the row and what was there: rows of different lengths, text, NaN or infinity, no rows of
    numbers at all, or fewer than `least` rows.

    >>> as_points([(0, 0), (1, 2)])
    array([[0., 0.],
           [1., 2.]])
    >>> as_points([(0, 0), (1, float("nan"))])
    Traceback (most recent call last):
    ValueError: row 1 of the points is not finite: [1.0, nan]
    """
    array = as_numbers(points, "points")
    if array.ndim != 2 or array.shape[1] == 0:
        raise ValueError(f"points must have the shape (n, d): n rows of d coordinates, not {array.shape}")
    if len(array) < least:
        raise ValueError(f"at least {least} points are needed, not {len(array)}")
    check_finite(array, "points")
    return array


def as_contour(points: ArrayLike, closed: bool, least: int = 2) -> Array:
    """Return checked points (n, d); with `closed`, without a last row that repeats the first.

    Raises ValueError as `as_points`, and when a closed curve has fewer than 3 points.

    >>> as_contour([(0, 0), (1, 0), (0, 1), (0, 0)], closed=True).tolist()
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    """
    array = as_points(points, least)
    if not closed:
        return array
    if np.array_equal(array[0], array[-1]):
        array = array[:-1]
    if len(array) < 3:
        raise ValueError(f"a closed curve needs at least 3 points, not {len(array)}")
    return array


def clean(points: ArrayLike, closed: bool | None = None) -> CleanPoints:
    """Return the points (n, d) checked and without consecutive repeats, with what was dropped.

    `closed`: whether the curve returns to its first point; None: it does when the last row repeats the first and three
    points or more are distinct. (Back and forth between two points is no contour: A, B, A, B, A stays open.)

    Raises TypeError for another `closed`, ValueError naming the row for anything but numbers (`as_points`), and when
    fewer than 2 distinct points (closed: 3) are left.

    >>> contour = clean([(0, 0), (1, 0), (1, 0), (0, 1), (0, 0)])
    >>> contour.points.tolist(), contour.dropped.tolist(), contour.closed
    ([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], [2], True)
    """
    if not isinstance(closed, (bool, np.bool_, type(None))):
        raise TypeError(f"closed must be True, False or None, not {closed!r:.80}")
    array = as_points(points)
    fresh = np.ones(len(array), dtype=np.bool_)
    np.any(array[1:] != array[:-1], axis=1, out=fresh[1:])
    kept = np.flatnonzero(fresh)
    returns = len(kept) > 1 and np.array_equal(array[kept[0]], array[kept[-1]])
    if closed is None:
        closed = bool(returns and _up_to_three(array[kept]) == 3)
    if closed and returns:
        kept = kept[:-1]
    least, distinct = 3 if closed else 2, _up_to_three(array[kept])
    if distinct < least:
        kind = "a closed curve" if closed else "a curve"
        raise ValueError(f"{kind} needs at least {least} distinct points; the {len(array)} given have {distinct}")
    return CleanPoints(array[kept], kept, np.flatnonzero(~fresh), closed)


def check_size(points: Array) -> None:
    """Raise ValueError for points whose distances float64 cannot square, nor the squares multiply.

    >>> check_size(np.array([[0.0, 0.0], [1e100, 0.0]]))
    Traceback (most recent call last):
    ValueError: coordinates must be below 1e+60, and one is 1e+100: scale them
    """
    check_largest(points)
    size = extent(points)
    if not size > 1.0 / LARGEST:
        raise ValueError(f"the points' size must be above {1.0 / LARGEST:g}, and it is {size:.3g}: scale them")


def check_largest(points: Array) -> None:
    """Raise ValueError for points too large for that."""
    largest = float(np.abs(points).max())
    if not largest < LARGEST:
        raise ValueError(f"coordinates must be below {LARGEST:g}, and one is {largest:.3g}: scale them")


def check_squares(points: Array) -> None:
    """Raise ValueError for points whose distances float64 cannot square; points that are all equal have none.

    >>> check_squares(np.array([[0.0, 0.0], [1e-200, 0.0]]))
    Traceback (most recent call last):
    ValueError: the points' size must be between 1e-150 and 1e+150, and it is 1e-200: scale them
    """
    with np.errstate(over="ignore"):
        size = extent(points)
    if size and not 1.0 / _SQUARED < size < _SQUARED:
        raise ValueError(
            f"the points' size must be between {1.0 / _SQUARED:g} and {_SQUARED:g}, and it is {size:.3g}: scale them"
        )


def _up_to_three(points: Array) -> int:
    """Return how many points are distinct, at most 3; neighbours differ."""
    if len(points) < 3:
        return len(points)
    some = points[2:3] if np.any(points[2] != points[0]) else points[2:]  # nearly always the third is another
    return 2 + bool(np.any(np.any(some != points[0], axis=1) & np.any(some != points[1], axis=1)))
