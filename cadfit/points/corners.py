"""Corners: points where one smooth curve ends and the next begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadfit.bezier import Array, Ints
from cadfit.numbers import as_number
from cadfit.points.clean import as_contour
from cadfit.points.measures import distances_from, lengths_along

_LEAST_TURN = np.radians(30.0)
_STANDS_OUT = 3.0  # times the turns next to it
_ARM = 6.0  # tolerances: over less, noise within the tolerance could turn by more than the least turn
_EQUAL = 1e-7  # radians: turns that differ by less differ by rounding, and neither is the larger
_STRAIGHT = 0.9  # chord to length of an arm: a lower ratio is a bend, or noise


def find_corners(points: ArrayLike, tolerance: float, closed: bool = False, angle: float | None = None) -> Ints:
    """Return the rows, rising, of the points (n, d) where the path turns as a corner does: more than all around it.

    The turn at a point is the angle between two arms, from the nearest point at least six `tolerance`s (a length)
    behind, and to the nearest as far ahead; both arms must be nearly straight. A corner's turn is the largest within
    its arms' reach, over 30 degrees, and over three times the turns at both arms' ends: a tight bend, given by a few
    points, and points that zigzag do not stand out so. Where `angle` (radians) is given, every turn larger than that
    is a corner, as the vertices of a polygon are. Points no path runs through (the ends of an open one) are none.

    Raises ValueError for bad points (naming the row) and for a tolerance or an angle that is not positive.
    Source: ours; of the kind surveyed by Teh and Chin, On the detection of dominant points on digital curves, IEEE
    PAMI 11(8), 1989.

    >>> outline = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    >>> find_corners(outline, 0.01, closed=True)
    array([0, 2, 4, 6])
    """
    array = as_contour(points, closed)
    if not as_number(tolerance, "tolerance") > 0 or (angle is not None and not angle > 0):
        raise ValueError(f"tolerance and angle must be positive, not {tolerance} and {angle}")
    n, d = array.shape
    if angle is None and d == 1:  # on a line all turns are reversals: an extremum of a function is no corner
        return np.zeros(0, dtype=np.intp)
    path = np.concatenate([array, array, array]) if closed else array
    behind, ahead, straight = _arms(path, _ARM * tolerance)
    if not straight.any():  # as of many points in noise
        return np.zeros(0, dtype=np.intp)
    turns = _turns(path, behind, ahead)
    corner = straight & (turns > (_LEAST_TURN if angle is None else angle))
    if not corner.any():  # as of most curves: what follows takes as long again
        return np.zeros(0, dtype=np.intp)
    if angle is None:
        corner &= turns > _STANDS_OUT * np.maximum(turns[behind], turns[ahead])
    turns = np.append(np.where(straight, turns, 0.0), 0.0)
    rows = np.arange(len(path))
    least = turns - _EQUAL
    corner &= (turns[:-1] >= least[1:]) | (ahead == rows + 1)
    corner &= (turns[:-1] >= np.roll(least, 1)[:-1]) | (behind == rows - 1)
    found = np.flatnonzero(corner)
    within = np.stack([behind[found] + 1, np.maximum(ahead[found], behind[found] + 2)], axis=1)
    found = found[turns[found] >= np.maximum.reduceat(least, within.ravel())[::2]] if len(found) else found
    return found[(found >= n) & (found < 2 * n)] - n if closed else found


def _arms(path: Array, length: float) -> tuple[Ints, Ints, NDArray[np.bool_]]:
    """Return the rows where each point's arms end, and whether both are that long and nearly straight."""
    along = lengths_along(path)
    rows, last = np.arange(len(path)), len(path) - 1
    ahead = np.maximum(np.searchsorted(along, along + length), rows + 1)
    behind = np.minimum(np.searchsorted(along, along - length, side="right") - 1, rows - 1)
    whole = (behind >= 0) & (ahead <= last)
    behind, ahead = np.maximum(behind, 0), np.minimum(ahead, last)
    for end in (behind, ahead):
        whole &= distances_from(path, path[end]) >= _STRAIGHT * np.abs(along[end] - along)
    return behind, ahead, whole


def _turns(path: Array, behind: Ints, ahead: Ints) -> Array:
    """Return the angles (n,) between the arms of each point of the path."""
    first, second = path - path[behind], path[ahead] - path
    lengths = np.sqrt(np.einsum("nd,nd->n", first, first)) * np.sqrt(np.einsum("nd,nd->n", second, second))
    cosine = np.einsum("nd,nd->n", first, second) / np.where(lengths > 0, lengths, 1.0)
    return np.where(lengths > 0, np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
