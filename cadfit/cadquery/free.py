"""Free functions in the manner of `cadquery.func`: points in, shapes out."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Unpack

import cadquery as cq

from cadfit import occt
from cadfit.cadquery.fits import FitOptions, ProfileOptions, fitted, fitted_profile
from cadfit.cadquery.points import Points
from cadfit.cadquery.shapes import to_edge, to_face, to_tube, to_wire
from cadfit.fitting.approximate import Effort
from cadfit.occt.checks import Caps
from cadfit.stages import Progress, shares
from cadfit.sweeping.laws import Law


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


def fit_face(
    points: Points, tolerance: float, holes: Iterable[Points] = (), **options: Unpack[ProfileOptions]
) -> cq.Face:
    """
    Construct the plane face within a closed outline of points, less holes.

    :param points: the outline in order, closed whether its last point repeats the first or not
    :param tolerance: every point is within this distance of its curve
    :param holes: the outlines of holes, each as `points`
    :param options: `corners`, `between`, `effort` and `progress`, as for :meth:`Workplane.fitSpline`
    :raises ValueError: as :func:`fit_wire`, and where outlines cross, leave the plane or a hole is outside

    >>> round(fit_face([(0, 0), (4, 0), (4, 3), (0, 3)], 0.01, between="polyline").Area(), 6)
    12.0
    """
    outer, *inner = fitted_profile(points, tolerance, holes, **options)
    return to_face(outer, inner)


def fit_tube(
    points: Points,
    radius: Law,
    tolerance: float,
    thickness: float | None = None,
    caps: Caps = "flat",
    **options: Unpack[FitOptions],
) -> cq.Solid:
    """
    Construct the solid tube along points: round, square to its path, mitred at corners.

    :param points: the centreline in order: tuples, Vectors, Vertices or an array
    :param radius: to the outside: a number, a function of the path's parameter, or a 1D spline
    :param tolerance: every point is within this distance of the path, and the wall of the path's exact tube
    :param thickness: of the wall of a hollow tube; solid where left out
    :param caps: how it ends, "flat" or "round"
    :param options: as for :meth:`Workplane.fitSpline`
    :raises ValueError: as :func:`fit_wire`, and where there is no such solid, naming the place: the path bends more
        tightly than the radius allows, say

    >>> bar = fit_tube([(0, 0, 0), (0, 0, 3), (0, 0, 5)], 1.0, 0.001)
    >>> round(bar.Volume(1e-6) / 5, 4), bar.isValid()
    (3.1416, True)
    """
    options["progress"], making = shares(options.get("progress"), 2)
    path = fitted(points, tolerance, **options)
    return to_tube(path, radius, tolerance, thickness, caps, making)


def simplify(
    shape: cq.Edge | cq.Wire, tolerance: float, effort: Effort = "best", progress: Progress | None = None
) -> cq.Edge | cq.Wire:
    """
    Refit an edge or a wire with few poles, within a certified tolerance of it, both ways, all along.

    :param shape: of lines, arcs, conics, Bézier curves and splines of any degree, rational ones, too
    :param tolerance: neither is anywhere farther than this from the other; ends and corners are kept
    :param effort: "best", or "fast"
    :param progress: as for :meth:`Workplane.fitSpline`
    :return: an edge, or a wire where there are corners or a wire was given
    :raises ValueError: for a tolerance that cannot be held, an edge without end, or a wire in parts

    >>> from cadfit.cadquery import from_edge
    >>> ring = simplify(cq.Edge.makeCircle(50), 0.01)
    >>> len(from_edge(ring).poles) <= 12, round(ring.Length(), 2), round(cq.Edge.makeCircle(50).Length(), 2)
    (True, 314.16, 314.16)
    """
    found = occt.simplify(shape.wrapped, tolerance, effort=effort, progress=progress)
    return to_edge(found) if isinstance(shape, cq.Edge) and len(found.curves) == 1 else to_wire(found)
