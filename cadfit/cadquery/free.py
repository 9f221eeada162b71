"""Free functions in the manner of `cadquery.func`: points in, shapes out."""

from __future__ import annotations

from typing import Unpack

import cadquery as cq

from cadfit.cadquery.fits import FitOptions, fitted
from cadfit.cadquery.points import Points
from cadfit.cadquery.shapes import to_edge, to_wire


def fit_edge(points: Points, tolerance: float, **options: Unpack[FitOptions]) -> cq.Edge:
    """
    Construct one smooth edge within a certified tolerance of points.

    :param points: points in order: tuples, Vectors, Vertices or an array
    :param tolerance: every point is within this distance of the curve
    :param options: as for :meth:`Workplane.fitSpline`; `corners` is None where left out
    :raises ValueError: for bad points, naming the row, a tolerance that cannot be held, and where corners split it

    >>> import numpy as np
    >>> turn = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    >>> ring = fit_edge(np.column_stack([5 * np.cos(turn), 5 * np.sin(turn)]), 0.001, closed=True)
    >>> round(ring.Length() / 10, 3), ring.IsClosed()
    (3.142, True)
    """
    options.setdefault("corners", None)
    return to_edge(fitted(points, tolerance, **options))


def fit_wire(points: Points, tolerance: float, **options: Unpack[FitOptions]) -> cq.Wire:
    """
    Construct a wire within a certified tolerance of points, one edge for each part between corners.

    :param points: points in order: tuples, Vectors, Vertices or an array
    :param tolerance: every point is within this distance of the curve
    :param options: as for :meth:`Workplane.fitSpline`
    :raises ValueError: for bad points, naming the row, and a tolerance that cannot be held

    >>> len(fit_wire([(0, 0), (4, 0), (4, 3), (0, 3), (0, 0)], 0.01, between="polyline").Edges())
    4
    """
    return to_wire(fitted(points, tolerance, **options))
