"""Airfoil coordinates as the collections publish them (.dat): a line with the name, then x y.

Two orders are in use. Selig's runs once around, from the trailing edge over the upper side to the leading edge and back
below: a contour as it stands. Lednicer's begins with two counts ("17. 17."), then has the upper side and the lower
side, both from the leading edge: it is turned into Selig's order here.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array

_SEPARATOR = 999.0  # "999.0 999.0" parts the elements of an airfoil with flaps


def from_lednicer(table: Array, lines: list[int]) -> Array:
    """Return rows of numbers (n, d) as one contour: Lednicer's order turned into Selig's, anything else as it is.

    `lines`: the line each row is on. It is Lednicer's where the first row is two whole numbers of 2 or more, and is
    set apart by a blank line or by being larger than coordinates of an airfoil are (1.5). The upper side comes
    reversed, then the lower side, without its first point where that repeats the upper side's.

    Raises ValueError when the counts are not the numbers of rows, or when the file has several elements.

    >>> sides = [[2, 3], [0, 0], [1, 0.1], [0, 0], [0.5, -0.1], [1, 0]]
    >>> from_lednicer(np.array(sides), [2, 4, 5, 7, 8, 9]).tolist()
    [[1.0, 0.1], [0.0, 0.0], [0.5, -0.1], [1.0, 0.0]]
    """
    if table.shape[1] != 2:
        return table
    elements = np.flatnonzero((table == _SEPARATOR).all(axis=1))
    if len(elements):
        raise ValueError(f"line {lines[elements[0]]}: 999 999 parts the elements of an airfoil; give each its own file")
    counts, sides = table[0], table[1:]
    if len(sides) < 2 or np.any(counts < 2) or np.any(counts != counts.round()):
        return table
    if lines[1] == lines[0] + 1 and np.abs(sides).max() > 1.5:
        return table
    if counts.sum() != len(sides):
        upper, lower = counts.astype(int)
        raise ValueError(f"line {lines[0]}: counts {upper} and {lower} of two sides, but {len(sides)} rows below")
    upper, lower = sides[: int(counts[0])], sides[int(counts[0]) :]
    return np.concatenate([upper[::-1], lower[int(np.array_equal(upper[0], lower[0])) :]])
