"""Frenet's frames, for the curve's own geometry; sweeps use those of `cadfit.sweeping.frames`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bspline import BSpline
from cadfit.numbers import as_numbers
from cadfit.sweeping.frames import Frames, frames, lifted

_FLAT = 1e-9  # curvature times the path's size: less is a straight line up to rounding


def frenet(spline: BSpline, parameters: ArrayLike) -> Frames:
    """Return Frenet's frames of a path at the given parameters (n,): the normals point to the centre of curvature.

    They turn with the path's torsion and flip over at inflections, which is why sweeps do not use them; they are here
    for those who want the curve's own geometry. `lengths` are as in `frames`.

    Raises ValueError where the path does not bend (no centre to point to), naming the parameter, and as `frames` does.

    >>> path = BSpline([[0, 0, 0], [2, 0, 0], [3, 1, 0], [3, 3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> frenet(path, [0.5]).normals.round(6)
    array([[-0.707107,  0.707107,  0.      ]])
    """
    along = frames(spline, parameters)
    path, u = lifted(spline), as_numbers(parameters, "parameters").reshape(-1)
    bends = path.curvature(u)
    sizes = np.linalg.norm(bends, axis=1)
    flat = sizes * path.size <= _FLAT
    if flat.any():
        raise ValueError(
            f"the path does not bend at the parameter {u[np.argmax(flat)]:g}: Frenet's frame is not defined"
        )
    normals = bends / sizes[:, None]
    return Frames(along.origins, along.tangents, normals, np.cross(along.tangents, normals), along.lengths)
