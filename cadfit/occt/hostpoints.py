"""Points as the hosts have them, as an array."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.TopoDS import TopoDS_Shape, TopoDS_Vertex

from cadfit.bezier import Array
from cadfit.occt.kernel import as_vertex
from cadfit.points.clean import as_points


def points_of(points: Any) -> Array:
    """Return points of any of the hosts' kinds as an array (n, d), checked.

    An array (n, d), or an iterable of tuples, arrays, build123d's or CadQuery's `Vector` and `Vertex`, or the kernel's
    own points and vertices. Vectors and vertices are in 3D; where rows in 3D are mixed with pairs of numbers, the pairs
    lie in z = 0, as in the hosts.

    Raises ValueError naming the row that is not a point, and as `cadfit.clean` does.

    >>> points_of([(0, 0), (1, 2)]).tolist(), points_of([(0, 0), (1, 2, 3)]).tolist()
    ([[0.0, 0.0], [1.0, 2.0]], [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]])
    """
    if isinstance(points, np.ndarray):
        return as_points(points)
    if not isinstance(points, Iterable) or isinstance(points, str | bytes):
        raise ValueError(f"points must be a list of points, not {points!r:.80}")
    given = list(points)
    rows = [_coordinates(point, row) for row, point in enumerate(given)]
    pairs = [isinstance(row, tuple | list | np.ndarray) and len(row) == 2 for row in rows]
    if not all(pairs):
        rows = [(*row, 0.0) if pair else row for row, pair in zip(rows, pairs, strict=True)]
    return as_points(rows)


def _coordinates(point: Any, row: int) -> Any:
    """Return the coordinates of the kernel's or a host's point; what is neither, as it is."""
    inner = getattr(point, "wrapped", point)
    if isinstance(inner, TopoDS_Shape):
        if not isinstance(inner, TopoDS_Vertex):
            kind = type(point).__name__
            raise ValueError(f"row {row} of the points is not a point: {kind} (simplify refits edges and wires)")
        return BRep_Tool.Pnt_s(as_vertex(inner)).Coord()
    coordinates = getattr(inner, "Coord", None)  # gp_Pnt, gp_Vec, gp_XYZ
    return coordinates() if callable(coordinates) else point
