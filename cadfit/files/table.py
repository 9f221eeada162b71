"""What every point file has in common: rows of 2 to 8 finite numbers."""

from __future__ import annotations

from typing import Any

from cadfit.bezier import Array
from cadfit.points.clean import as_points

COLUMNS = range(2, 9)


def as_table(rows: Any, where: str) -> Array:
    """Return the rows as points (n, d), n >= 1; raises ValueError that starts with `where` and names the row.

    >>> as_table([[1.0]], "a.npy")
    Traceback (most recent call last):
    ValueError: a.npy: points have 2 to 8 coordinates, not 1
    """
    try:
        table = as_points(rows, least=1)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    if table.shape[1] not in COLUMNS:
        raise ValueError(f"{where}: points have {COLUMNS[0]} to {COLUMNS[-1]} coordinates, not {table.shape[1]}")
    return table
