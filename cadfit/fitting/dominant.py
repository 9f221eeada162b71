"""Dominant points: the part of the points that carries the shape, and the square error of leaving out the rest.

Source: D. Mukherjee, An error reduced and uniform parameter approximation in fitting of B-spline curves to data
points, sections 2.4 to 2.7. What the paper leaves open is settled here, each where it is said: the number of primary
points, which point of a piece is added, and which end of a piece is dropped where several pieces have no error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.bspline import own
from cadfit.fitting.dominant_best import improved, thinned
from cadfit.fitting.dominant_pieces import chain_error, handles, pieces_of
from cadfit.fitting.dominant_swaps import swapped
from cadfit.numbers import as_number
from cadfit.points.clean import as_contour, check_squares
from cadfit.stages import Progress, portion, rising

Method = Literal["best", "paper"]
_Choice = Callable[[Array, int, bool, Progress], tuple[Ints, Array]]


@dataclass(frozen=True, slots=True, eq=False)
class DominantPoints:
    """Points chosen to carry the shape, and what leaving out the others costs.

    `indices` (m,): their rows, rising; an open curve's ends are among them. `square_error`: the sum, over the points
    left out, of the squared distances to `pieces`. `pieces` (m - 1, 4, d), closed (m, 4, d): the cardinal spline
    through the dominant points, as Bézier pieces. `history`: the square error at the start of the search and after each
    swap, or of "best" after each round of changes.
    """

    indices: Ints
    square_error: float
    pieces: Array
    history: Array


def dominant_points(
    points: ArrayLike,
    count: int | None = None,
    fraction: float | None = None,
    square_error: float | None = None,
    closed: bool = False,
    method: Method = "best",
    progress: Progress | None = None,
) -> DominantPoints:
    """Return the dominant points of ordered points: as many as asked for, or few enough for a square error.

    `points` (n, d), d >= 1, repeats allowed. One of `count` (2 to n; closed 3 to n), `fraction` (of the points, above 0
    and at most 1; rounded to the nearest count) and `square_error` (in the square of the points' unit) says how many:
    the last searches for the smallest set whose square error is no larger, by bisection, so that with one point less
    the search exceeds it. `closed`: the curve returns to the first point, which may be repeated at the end or not;
    there are no ends then that must be kept. `method`: "paper" is the paper's search
    (`initial_dominant_points`, `refine_dominant_points`); "best" starts from that or from all points less the least
    costly, whichever is better, then rearranges few points, and moves and exchanges many in a few rounds. Its error is
    never above the paper's for the same count, most often far below, and for an open curve of up to 60 points about the
    least there is. `progress` is called with the part that is
    done, from 0 to 1, as far as can be told; raising from it stops the search.

    Raises ValueError for bad points (naming the row), too small or too large to square, and for a count, fraction or
    square error out of range. Source: the paper, sections 2.4 to 2.7; "best" is ours (`dominant_best`).

    >>> t = np.linspace(0, 3, 40)
    >>> found = dominant_points(np.column_stack([t, np.sin(t * t)]), fraction=0.5)
    >>> len(found.indices), found.indices[[0, -1]], found.square_error < 0.05
    (20, array([ 0, 39]), True)
    """
    if method not in get_args(Method):
        raise ValueError(f"method must be one of {get_args(Method)}, not {method!r}")
    given = _given(points, closed)
    choose = _choose_paper if method == "paper" else _choose_best
    heard = rising(progress)
    wanted = _count(len(given), count, fraction, square_error, closed)
    if wanted is not None:
        indices, history = choose(given, wanted, closed, portion(heard, 0.0, 1.0))
    else:
        assert square_error is not None
        indices, history = _smallest(given, square_error, closed, choose, heard)
    heard(1.0)
    total = chain_error(_columns(given), indices, closed)
    pieces = handles(given, pieces_of(indices, closed))
    indices.setflags(write=False)
    return DominantPoints(indices, total, own(pieces), own(np.asarray(history)))


def turn_angles(points: ArrayLike, closed: bool = False) -> Array:
    """Return the turn angle (n,) at each point (n, d), in radians: 0 straight on, pi turning back.

    An open curve's ends, and points equal to a neighbour, have none: 0. In the plane the angle is the paper's,
    pi - acos(FS TS / (|FS| |TS|)); here it is taken from sine and cosine, which keeps small angles, in any dimension.

    Raises ValueError for bad points (naming the row). Source: the paper, section 2.6.

    >>> turn_angles([(0, 0), (1, 0), (1, 1), (1, 0)]).round(4)
    array([0.    , 1.5708, 3.1416, 0.    ])
    """
    given = _given(points, closed)
    before, after = np.roll(given, 1, axis=0), np.roll(given, -1, axis=0)
    if not closed:
        before[0], after[-1] = given[0], given[-1]
    return np.asarray(_angles(given - before, after - given))


def _angles(first: Array, second: Array) -> Array:
    """Return the angles (n,) between vectors (n, d); 0 where one has no length. 2 atan2(|a - b|, |a + b|) of units."""
    lengths = [np.linalg.norm(each, axis=1) for each in (first, second)]
    whole = (lengths[0] > 0.0) & (lengths[1] > 0.0)
    a, b = (each / np.where(whole, length, 1.0)[:, None] for each, length in zip((first, second), lengths, strict=True))
    angles = 2.0 * np.arctan2(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return np.where(whole, angles, 0.0)


def square_error(points: ArrayLike, indices: ArrayLike, closed: bool = False) -> float:
    """Return the square error of dominant points: the rows `indices` (m,), rising, of the points (n, d).

    It is the sum, over the points left out, of the squared distance to the Bézier piece between the two dominant points
    around it, at the parameter that its projection on their chord gives, as a part of the chord.

    Raises ValueError for bad points (naming the row), and for indices that do not rise, are out of range, or leave out
    an open curve's end. Source: the paper, sections 2.5 and 2.7.

    >>> square_error([(0, 0), (1, 1), (2, 0)], [0, 2])
    1.0
    """
    given = _given(points, closed)
    return chain_error(_columns(given), _rows(given, indices, closed), closed)


def initial_dominant_points(points: ArrayLike, count: int, closed: bool = False) -> Ints:
    """Return the paper's first guess (count,): the points of the largest turn angles, and neighbours of the sharpest.

    Of an open curve the ends. Then the primary points, a quarter of `count`: those of the largest turn angles. With
    each, in that order, its neighbours before and after, the support points, as long as there is room. Then the
    secondary points: the next largest turn angles. The paper does not say how many points are primary; a quarter leaves
    room for their support and for a quarter of secondary points.

    Raises ValueError for bad points (naming the row) and a count out of range. Source: the paper, section 2.7.

    >>> initial_dominant_points([(0, 0), (1, 0), (2, 0), (3, 0), (3, 1), (3, 2), (3, 3)], 5)
    array([0, 2, 3, 4, 6])
    """
    given = _given(points, closed)
    n = len(given)
    count = _checked_count(n, count, closed)
    order = np.argsort(-turn_angles(given, closed), kind="stable")
    if not closed:
        order = order[(order > 0) & (order < n - 1)]
    primary = order[: count // 4]
    support = np.stack([primary - 1, primary + 1], axis=1).ravel() % n
    ends = np.array([] if closed else [0, n - 1], dtype=np.intp)
    wanted = np.concatenate([ends, primary, support, order])
    _, first = np.unique(wanted, return_index=True)
    return np.sort(wanted[np.sort(first)[:count]])


def refine_dominant_points(points: ArrayLike, indices: ArrayLike, closed: bool = False) -> tuple[Ints, Array]:
    """Return the dominant points that the paper's swaps lead to from `indices` (m,), and the errors on the way.

    A swap adds a point in the piece of the largest error: the one farthest from it. It drops an end of a piece of the
    smallest error. Most often many pieces have none: then the first of all their ends, the flattest turn angle first,
    with which the total error falls. The search ends at a local minimum, where none does.

    Raises ValueError as `square_error`. Source: the paper, section 2.7; the order among equals is ours.

    >>> zigzag = [(0, 0), (1, 0), (2, 0), (3, 1), (4, 0), (5, 0)]
    >>> indices, errors = refine_dominant_points(zigzag, [0, 1, 2, 5])
    >>> indices, errors.round(4)
    (array([0, 2, 3, 5]), array([1.0233, 0.2752]))
    """
    given = _given(points, closed)
    rows = _rows(given, indices, closed)
    found, history = swapped(_columns(given), rows, turn_angles(given, closed), closed)
    return found, np.asarray(history)


def _given(points: ArrayLike, closed: bool) -> Array:
    """Return the points checked: below the size that can be squared, all turn angles and errors would be 0."""
    given = as_contour(points, closed)
    check_squares(given)
    return given


def _columns(points: Array) -> Array:
    return np.ascontiguousarray(points.T)


def _choose_paper(points: Array, count: int, closed: bool, progress: Progress) -> tuple[Ints, Array]:
    start = initial_dominant_points(points, count, closed)
    found, history = swapped(_columns(points), start, turn_angles(points, closed), closed, progress)
    return found, np.asarray(history)


def _choose_best(points: Array, count: int, closed: bool, progress: Progress) -> tuple[Ints, Array]:
    columns = _columns(points)
    starts = [thinned(columns, count, closed), _choose_paper(points, count, closed, portion(progress, 0.1, 0.5))[0]]
    found, history = improved(columns, starts, closed, portion(progress, 0.5, 1.0))
    return found, np.asarray(history)


def _smallest(points: Array, bound: float, closed: bool, choose: _Choice, progress: Progress) -> tuple[Ints, Array]:
    """Return the smallest set found within the bound; the search at one point less exceeded it.

    Steps that double, down from how many are left when the least costly points are dropped, then bisection.
    """
    low, high = 2 if closed else 1, len(points)  # low is too few, high enough
    columns = _columns(points)
    best = np.arange(high), np.zeros(1)
    middle, step = _thinned_count(points, bound, closed), 1
    while high - low > 1:
        part = 1.0 - np.log2(high - low) / np.log2(len(points))
        found = choose(points, middle, closed, portion(progress, part, part))
        if chain_error(columns, found[0], closed) <= bound:
            high, best = middle, found
            middle, step = max(high - step, (low + high) // 2), 2 * step
        else:
            low = middle
            middle = (low + high) // 2
    return best


def _thinned_count(points: Array, bound: float, closed: bool) -> int:
    """Return about how many points keep to the bound when the least costly are dropped; never all, nor too few."""
    columns = _columns(points)
    low, high = 3 if closed else 2, len(points) - 1
    while low < high:
        middle = (low + high) // 2
        if chain_error(columns, thinned(columns, middle, closed), closed) <= bound:
            high = middle
        else:
            low = middle + 1
    return low


def _count(n: int, count: int | None, fraction: float | None, square_error: float | None, closed: bool) -> int | None:
    """Return how many points are asked for; None where it is a square error."""
    if sum(given is not None for given in (count, fraction, square_error)) != 1:
        raise ValueError("give one of count, fraction and square_error")
    if square_error is not None:
        if not as_number(square_error, "square error") >= 0.0:
            raise ValueError(f"the square error must be at least 0, not {square_error}")
        return None
    if fraction is not None:
        if not 0.0 < as_number(fraction, "fraction") <= 1.0:
            raise ValueError(f"the fraction must be above 0 and at most 1, not {fraction}")
        return max(int(np.floor(fraction * n + 0.5)), 3 if closed else 2)
    assert count is not None
    return _checked_count(n, count, closed)


def _checked_count(n: int, count: int, closed: bool) -> int:
    least = 3 if closed else 2
    if isinstance(count, bool) or count not in range(least, n + 1):
        raise ValueError(f"the count must be a whole number from {least} to {n}, the number of points, not {count}")
    return int(count)


def _rows(points: Array, indices: ArrayLike, closed: bool) -> Ints:
    """Return the indices checked."""
    n = len(points)
    rows = np.asarray(indices)
    if rows.ndim != 1 or not np.issubdtype(rows.dtype, np.integer):
        raise ValueError("indices must be whole numbers: rows of the points")
    if len(rows) < (3 if closed else 2) or np.any(rows[1:] <= rows[:-1]) or rows[0] < 0 or rows[-1] >= n:
        raise ValueError(f"indices must rise, at least {3 if closed else 2} of them from 0 to {n - 1}")
    if not closed and (rows[0] != 0 or rows[-1] != n - 1):
        raise ValueError(f"an open curve's ends are dominant: indices must start with 0 and end with {n - 1}")
    return rows.astype(np.intp)
