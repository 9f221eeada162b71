"""The kernel's own fit of points, to hold ours against."""

from __future__ import annotations

import numpy as np
from OCP.GeomAbs import GeomAbs_Shape
from OCP.GeomAPI import GeomAPI_PointsToBSpline
from OCP.gp import gp_Pnt

from cadfit.bezier import Array
from cadfit.bspline import DEGREE, BSpline
from cadfit.occt.kernel import KernelError, Points, building


def approximate(points: Array, tolerance: float) -> BSpline:
    """Return what `GeomAPI_PointsToBSpline` makes of points (n, d), d 2 or 3: degree 3, C2, the tolerance.

    It calls itself done at many times the tolerance, too: measure what it keeps. Raises KernelError where it gives up.
    """
    flat = points.shape[1]
    if flat not in (2, 3):
        raise ValueError(f"the kernel takes points in 2D or 3D, not in {flat}D")
    array = Points(1, len(points))
    for k, row in enumerate(points.tolist(), 1):
        array.SetValue(k, gp_Pnt(*row, *[0.0] * (3 - flat)))
    with building(f"a spline near {len(points)} points"):
        make = GeomAPI_PointsToBSpline(array, DEGREE, DEGREE, GeomAbs_Shape.GeomAbs_C2, tolerance)
        if not make.IsDone():
            raise KernelError("not done")
        curve = make.Curve()
    poles = np.array([pole.Coord() for pole in curve.Poles()])[:, :flat]
    return BSpline(poles, np.repeat([*curve.Knots()], [*curve.Multiplicities()]))
