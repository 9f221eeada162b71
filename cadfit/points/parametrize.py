"""Parameters for points: uniform, centripetal or by chord length."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.points.clean import as_points, check_squares
from cadfit.points.measures import chord_lengths

Parametrization = Literal["uniform", "centripetal", "chord"]

_LEAST = 8.0  # roundings of a parameter: between the next two, a spline may have two more knots
_SHORT, _LONG = 1e-150, 1e150  # chords beyond are looked at closely: their squares are rounded, or no numbers
_STEP: dict[str, Callable[[Array], Array]] = {"uniform": np.ones_like, "centripetal": np.sqrt, "chord": np.asarray}


def parametrize(points: ArrayLike, parametrization: Parametrization = "centripetal", closed: bool = False) -> Array:
    """Return a parameter for each point (n,), or (n + 1,) with the period's end when `closed`.

    The step between neighbours is their distance to the power 0 (uniform), 1/2 (centripetal) or 1 (chord). The
    parameters start at 0 and are scaled so that the whole range is the length of the polyline, in the caller's unit:
    speeds are near 1, which is what kernels with absolute parametric tolerances expect.

    Raises ValueError for an unknown parametrization, and where two neighbours are equal (`clean` drops repeats) or so
    near each other that float64 cannot tell their parameters apart, and for points too small or too large to square.
    Source: Lee, Choosing nodes in parametric curve interpolation, CAD 21(6), 1989.

    >>> parametrize([[0, 0], [4, 0], [4, 9]], "centripetal").round(3)
    array([ 0. ,  5.2, 13. ])
    """
    return parameters_of(as_points(points), parametrization, closed)


def parameters_of(points: Array, parametrization: Parametrization, closed: bool) -> Array:
    """Return `parametrize` for points that are checked."""
    if parametrization not in _STEP:
        raise ValueError(f"parametrization must be one of {get_args(Parametrization)}, not {parametrization!r}")
    if closed:
        points = np.concatenate([points, points[:1]])
    with np.errstate(over="ignore"):
        chords = chord_lengths(points)
    if not (chords.min() > _SHORT and chords.max() < _LONG):
        _check_chords(points, closed)
    parameters = np.empty(len(points))
    parameters[0] = 0.0
    steps = _STEP[parametrization](chords)
    np.add.accumulate(steps, out=parameters[1:])
    if steps.min() <= _LEAST * np.spacing(parameters[-1]):
        _check_apart(parameters, steps, chords, closed)
    parameters *= chords.sum() / parameters[-1]
    return parameters


def _check_chords(points: Array, closed: bool) -> None:
    """Refuse neighbours that are equal, and points whose distances cannot be squared."""
    equal = (points[1:] == points[:-1]).all(axis=1)
    if equal.any():
        row = int(np.argmax(equal))
        following = (row + 1) % (len(points) - closed)
        raise ValueError(f"rows {row} and {following} of the points are equal: drop repeats with cadfit.clean")
    check_squares(points)


def _check_apart(parameters: Array, steps: Array, chords: Array, closed: bool) -> None:
    """Refuse neighbours whose parameters differ by rounding alone; round a seam the period is added to them."""
    lost = steps <= _LEAST * np.spacing(parameters[-1:] if closed else parameters[1:])
    if lost.any():
        row = int(np.argmax(lost))
        following = (row + 1) % (len(parameters) - closed)
        raise ValueError(
            f"rows {row} and {following} of the points are {chords[row]:.3g} apart, too near each other to have "
            "different parameters: drop one of them"
        )
