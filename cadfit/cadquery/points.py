"""Points as CadQuery has them, as an array."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, TypeAlias

import cadquery as cq
import numpy as np
from cadquery.cq import VectorLike
from numpy.typing import NDArray

from cadfit.bezier import Array
from cadfit.occt import points_of

Point: TypeAlias = VectorLike | Sequence[float] | NDArray[Any] | cq.Vertex | cq.Location
Points: TypeAlias = NDArray[Any] | Iterable[Point] | cq.Edge | cq.Wire | cq.Workplane
"""Points in order: tuples, Vectors, Vertices or Locations, an array (n, 2 or 3), or what is on a Workplane's stack.

Where a fit is made, an Edge or a Wire may stand for them.
"""


def as_array(points: Points) -> Array:
    """Return the points as an array (n, 2), or (n, 3) where they leave z = 0; see `cadfit.occt.points_of`.

    >>> as_array([cq.Vertex.makeVertex(1, 2, 3), cq.Location((4, 5, 6))])
    array([[1., 2., 3.],
           [4., 5., 6.]])

    >>> as_array([cq.Vector(1, 2), cq.Vector(4, 5)]).tolist()
    [[1.0, 2.0], [4.0, 5.0]]
    """
    rows = points.vals() if isinstance(points, cq.Workplane) else listed(points)
    if isinstance(rows, list | tuple):
        rows = [cq.Vector(row.toTuple()[0]) if isinstance(row, cq.Location) else row for row in rows]
    array = points_of(rows)
    return array[:, :2] if array.shape[1] == 3 and not array[:, 2].any() else array


def listed(points: Points) -> Points:
    """Return a list of points that come from a generator, a view or the like, to look at the first; others as they are.

    >>> listed(cq.Vector(k, 0) for k in range(2))
    [Vector: (0.0, 0.0, 0.0), Vector: (1.0, 0.0, 0.0)]
    """
    ready = isinstance(points, np.ndarray | cq.Shape | cq.Workplane | list | tuple | str)
    return points if ready or not isinstance(points, Iterable) else [*points]


def in_one_space(first: Array, second: Array) -> tuple[Array, Array]:
    """Return two arrays (n, 2 or 3) with as many columns; 2D rows lie in z = 0."""
    d = max(first.shape[1], second.shape[1])
    lifted = [np.column_stack([rows, np.zeros((len(rows), d - rows.shape[1]))]) for rows in (first, second)]
    return lifted[0], lifted[1]


def curve_of(points: object) -> cq.Edge | cq.Wire | None:
    """Return the edge or wire that stands for points, alone or on a stack, whose edges make one wire; else None."""
    found = points.vals() if isinstance(points, cq.Workplane) else [points]
    if len(found) == 1 and isinstance(found[0], cq.Edge | cq.Wire):
        return found[0]
    edges = [each for each in found if isinstance(each, cq.Edge)]
    return cq.Wire.assembleEdges(edges) if edges and len(edges) == len(found) else None


def in_world(points: object) -> bool:
    """Whether points have their place in the world, not on a workplane: shapes, and what is on a stack."""
    first = points[0] if isinstance(points, list | tuple) and points else points
    return isinstance(first, cq.Shape | cq.Workplane)
