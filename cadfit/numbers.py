"""Numbers as people give them: taken as float64, or refused by name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array


def as_number(value: Any, name: str) -> float:
    """Return a number as a float.

    Raises TypeError, naming it, for what is none: text, several numbers, a complex one.

    >>> as_number(np.int64(3), "radius")
    3.0
    >>> as_number("big", "radius")
    Traceback (most recent call last):
    TypeError: the radius must be a number, not 'big'
    """
    try:
        if isinstance(value, (str, bytes)) or np.ndim(value) or np.iscomplexobj(value):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"the {name} must be a number, not {value!r:.80}") from None


def as_numbers(values: ArrayLike, name: str) -> Array:
    """Return an array of numbers as float64; the caller's own where it is one already.

    `name`: of several, "points". Raises ValueError naming the row and what was there: rows of different lengths, text,
    complex numbers, masked ones.

    >>> as_numbers([[0, 1], [2]], "points")
    Traceback (most recent call last):
    ValueError: row 1 of the points has 1 numbers, the rows before it 2: [2]
    """
    if isinstance(values, np.ndarray) and np.iscomplexobj(values):  # numpy would drop the imaginary parts
        raise ValueError(f"{name} must be real numbers, not complex ones")
    if isinstance(values, np.ma.MaskedArray) and values.mask.any():  # numpy would take what is under the mask
        row = int(np.argwhere(np.ma.getmaskarray(values))[0, 0])
        raise ValueError(f"row {row} of the {name} is masked: leave such rows out, or fill them")
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(_why_none(values, name)) from None


def check_finite(rows: Array, name: str) -> None:
    """Raise ValueError naming the first of the rows (n, d) that is not finite.

    >>> check_finite(np.array([[0.0, 1.0], [np.nan, 2.0]]), "points")
    Traceback (most recent call last):
    ValueError: row 1 of the points is not finite: [nan, 2.0]
    """
    finite = np.isfinite(rows)
    if not finite.all():
        row = int(np.argmin(finite.all(axis=1)))
        raise ValueError(f"row {row} of the {name} is not finite: {rows[row].tolist()}")


def _why_none(values: Any, name: str) -> str:
    """Find the first row that keeps the values from being an array of numbers."""
    width = None
    for row, some in enumerate(values if isinstance(values, Iterable) else ()):
        try:
            count = np.array(some, dtype=np.float64).size
        except (TypeError, ValueError, OverflowError):
            return f"row {row} of the {name} is not a row of numbers: {some!r:.80}"
        if width is not None and count != width:
            return f"row {row} of the {name} has {count} numbers, the rows before it {width}: {some!r:.80}"
        width = count
    return f"{name} must be rows of numbers, not {values!r:.80}"


def rounded_up(number: float) -> str:
    """Return a number as three digits that are not below it, as a limit is said.

    >>> rounded_up(5.6811e-14)
    '5.71e-14'
    """
    return f"{1.0051 * number:.3g}"
