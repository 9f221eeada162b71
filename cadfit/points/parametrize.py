"""Parameters for points: uniform, centripetal or by chord length."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.points.clean import as_points

Parametrization = Literal["uniform", "centripetal", "chord"]

_EXPONENT = {"uniform": 0.0, "centripetal": 0.5, "chord": 1.0}


def parametrize(points: ArrayLike, parametrization: Parametrization = "centripetal", closed: bool = False) -> Array:
    """Return a parameter for each point (n,), or (n + 1,) with the period's end when `closed`.

    The step between neighbours is their distance to the power 0 (uniform), 1/2 (centripetal) or 1 (chord). The
    parameters start at 0 and are scaled so that the whole range is the length of the polyline, in the caller's unit:
    speeds are near 1, which is what kernels with absolute parametric tolerances expect.

    Raises ValueError for an unknown parametrization, and where two neighbours are equal (`clean` drops repeats).
    Source: Lee, Choosing nodes in parametric curve interpolation, CAD 21(6), 1989.

    >>> parametrize([[0, 0], [4, 0], [4, 9]], "centripetal").round(3)
    array([ 0. ,  5.2, 13. ])
    """
    if parametrization not in _EXPONENT:
        raise ValueError(f"parametrization must be one of {get_args(Parametrization)}, not {parametrization!r}")
    points = as_points(points)
    following = np.roll(points, -1, axis=0)
    chords = np.linalg.norm(following - points, axis=1)[: None if closed else -1]
    if np.any(chords == 0):
        row = int(np.argmin(chords))
        raise ValueError(
            f"rows {row} and {(row + 1) % len(points)} of the points are equal: drop repeats with cadfit.clean"
        )
    steps = chords ** _EXPONENT[parametrization]
    parameters = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(parameters * (chords.sum() / parameters[-1]))
