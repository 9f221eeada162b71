"""Arrays of poles, weights and knots as the kernel's curves and surfaces."""

from __future__ import annotations

from collections import deque
from itertools import repeat

import numpy as np
from OCP.Geom import Geom_BSplineCurve, Geom_BSplineSurface
from OCP.gp import gp_Pnt

from cadfit.bezier import Array
from cadfit.occt.kernel import Integers, PointGrid, Points, RealGrid, Reals


def curve(poles: Array, knots: Array, degree: int, weights: Array | None = None) -> Geom_BSplineCurve:
    """Return the curve with these poles (n, 3), full vector of knots (n + degree + 1,), and weights (n,), if any."""
    points = Points(1, len(poles))
    point = gp_Pnt()  # one for all: the array copies it, and making 1e5 of them is what takes time
    moves = map(point.SetCoord, *poles.T.tolist())
    deque(zip(moves, map(points.SetValue, range(1, len(poles) + 1), repeat(point)), strict=False), maxlen=0)
    if weights is None or np.all(weights == weights[0]):
        return Geom_BSplineCurve(points, *_knots(knots), degree)
    return Geom_BSplineCurve(points, _reals(weights), *_knots(knots), degree)


def surface(
    poles: Array, knots: tuple[Array, Array], degrees: tuple[int, int], weights: Array | None = None
) -> Geom_BSplineSurface:
    """Return the surface with these poles (n, m, 3), two full vectors of knots, and weights (n, m), if any."""
    n, m = poles.shape[:2]
    grid, point = PointGrid(1, n, 1, m), gp_Pnt()
    rows, columns = np.repeat(np.arange(1, n + 1), m).tolist(), np.tile(np.arange(1, m + 1), n).tolist()
    moves = map(point.SetCoord, *poles.reshape(-1, 3).T.tolist())
    deque(zip(moves, map(grid.SetValue, rows, columns, repeat(point)), strict=False), maxlen=0)
    (u, u_often), (v, v_often) = (_knots(each) for each in knots)
    if weights is None or np.all(weights == weights.flat[0]):
        return Geom_BSplineSurface(grid, u, v, u_often, v_often, *degrees)
    heavy = RealGrid(1, n, 1, m)
    deque(map(heavy.SetValue, rows, columns, weights.ravel().tolist()), maxlen=0)
    return Geom_BSplineSurface(grid, heavy, u, v, u_often, v_often, *degrees)


def _reals(values: Array) -> Reals:
    out = Reals(1, len(values))
    deque(map(out.SetValue, range(1, len(values) + 1), values.tolist()), maxlen=0)
    return out


def _knots(knots: Array) -> tuple[Reals, Integers]:
    """Return a full vector of knots as the kernel has it: distinct ones, and how often each stands."""
    starts = np.flatnonzero(np.concatenate([[True], knots[1:] > knots[:-1], [True]]))
    often = np.diff(starts)
    multiplicities = Integers(1, len(often))
    multiplicities.Init(1)
    for k in np.flatnonzero(often > 1).tolist():
        multiplicities.SetValue(k + 1, int(often[k]))
    return _reals(knots[starts[:-1]]), multiplicities
