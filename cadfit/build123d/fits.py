"""Points and curves as build123d has them, and fits to them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
from build123d import Edge, Vector, VectorLike, Vertex, Wire
from numpy.typing import NDArray

from cadfit import occt
from cadfit.bezier import Array
from cadfit.bspline import BSpline, own
from cadfit.fitting.approximate import Between, Corners, Effort, fit
from cadfit.fitting.deviation import deviation_at
from cadfit.fitting.result import Fit
from cadfit.points.clean import CleanPoints
from cadfit.stages import Progress

Points: TypeAlias = NDArray[Any] | Iterable[VectorLike | Vertex | NDArray[Any]]
"""Points in order: tuples, Vectors, Vertices (a ShapeList of them, say), or an array (n, 2 or 3)."""

PointsOrEdge: TypeAlias = Points | Edge | Wire
"""Points in order, or an edge or a wire to be refitted lighter."""


def as_array(points: Points) -> Array:
    """Return the points as an array (n, 2), or (n, 3) where they leave z = 0; see `cadfit.occt.points_of`.

    >>> as_array([Vector(1, 2), (3, 4), Vertex(5, 6, 0)]).tolist()
    [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]]
    """
    array = occt.points_of(points)
    return array[:, :2] if array.shape[1] == 3 and not array[:, 2].any() else array


def fitted(
    points: PointsOrEdge,
    tolerance: float,
    closed: bool | None,
    corners: Corners,
    between: Between,
    effort: Effort,
    tangents: Iterable[VectorLike] | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Return the fit to points, or an edge or wire refitted; see `FitSpline`."""
    if isinstance(points, Edge | Wire):
        if (
            closed is not None
            or not (isinstance(corners, str) and corners == "auto")
            or between != "curve"
            or tangents is not None
        ):
            raise ValueError("closed, corners, between and tangents go with points: an edge or a wire has its own")
        return occt.simplify(points.wrapped, tolerance, effort=effort, progress=progress)
    given = as_array(points)
    ends: Any = None
    if tangents is not None:
        ends = np.array([tuple(Vector(tangent)) for tangent in tangents])
        if given.shape[1] == 2 and ends.any(axis=0)[2:].any():
            given = np.column_stack([given, np.zeros(len(given))])
        ends = ends[:, : given.shape[1]]
    how: dict[str, Any] = {"closed": closed, "corners": corners, "between": between, "effort": effort}
    return fit(given, tolerance, end_tangents=ends, progress=progress, **how)


def passed(spline: BSpline, cleaned: CleanPoints, parameters: Array) -> Fit:
    """Return what is reported of a spline through points that it passes at the parameters (n,)."""
    found = deviation_at([spline], cleaned.points, parameters, cleaned.closed)
    none = np.zeros(0, dtype=np.intp)
    places = own(cleaned.points.copy())
    return Fit((spline,), found, None, cleaned.closed, places, own(parameters.copy()), none, cleaned.dropped)
