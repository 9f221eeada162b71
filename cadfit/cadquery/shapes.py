"""Splines as CadQuery's edges, wires and faces, and edges as splines."""

from __future__ import annotations

from collections.abc import Iterable

import cadquery as cq

from cadfit import occt
from cadfit.bspline import BSpline
from cadfit.fitting.result import Fit
from cadfit.joining import HasCurves, Splines
from cadfit.occt.checks import Caps
from cadfit.stages import Progress
from cadfit.sweeping.laws import Law


def to_edge(curve: BSpline | HasCurves) -> cq.Edge:
    """
    Make an edge of a spline, with its very poles and knots; a 2D spline lies in the XY plane.

    :param curve: a spline in 2D or 3D, or a fit without corners
    :return: the edge, closed where the spline returns to its start
    :raises ValueError: where corners split the fit (:func:`to_wire` takes it), and for other dimensions
    :raises cadfit.occt.KernelError: where the kernel refuses the curve

    >>> arc = to_edge(BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 4, 4, 4, 4]))
    >>> arc.geomType(), arc.endPoint().toTuple()
    ('BSPLINE', (3.0, 0.0, 0.0))
    """
    return cq.Edge(occt.to_edge(curve))


def to_wire(curves: Splines) -> cq.Wire:
    """
    Make a wire of splines that follow each other end to end; consecutive edges share a vertex.

    :param curves: a spline, a fit, or several splines in order
    :return: the wire, closed where the last spline ends at the start of the first
    :raises ValueError: for no curves, and for an open joint, naming it
    :raises cadfit.occt.KernelError: where the kernel refuses a curve

    >>> there = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 3, 3, 3, 3])
    >>> back = BSpline([[3, 0], [3, 3], [0, 3], [0, 0]], [3, 3, 3, 3, 12, 12, 12, 12])
    >>> to_wire([there, back]).IsClosed()
    True
    """
    return cq.Wire(occt.to_wire(curves))


def to_face(outer: Splines, holes: Iterable[Splines] = ()) -> cq.Face:
    """
    Make the plane face inside a closed curve, less the holes.

    :param outer: a spline, a fit, or several splines in order; of a 2D one the face lies in the XY plane, facing up
    :param holes: closed curves inside it, as many as there are holes
    :return: the face, its edges with the splines' very poles and knots (reversed where a curve runs the other way)
    :raises ValueError: saying which curve is open, not planar, crosses itself or another, and where
    :raises cadfit.occt.KernelError: where the kernel refuses

    >>> from cadfit import cardinal_spline
    >>> leaf = to_face(cardinal_spline([(3, 0), (0, 1), (-3, 0), (0, -1)], curvature=1.0, closed=True))
    >>> leaf.isValid(), leaf.normalAt().toTuple()
    (True, (0.0, 0.0, 1.0))
    """
    return cq.Face(occt.to_face(outer, holes))


def to_tube(
    path: Fit, radius: Law, tolerance: float, thickness: float | None, caps: Caps, progress: Progress | None
) -> cq.Solid:
    """
    Make the tube along a fit; see :meth:`Workplane.fitTube`.
    """
    try:
        return cq.Solid(occt.tube_solid(path, radius, tolerance, thickness=thickness, caps=caps, progress=progress))
    except occt.KernelError as error:  # a path no tube fits round, which is a wrong value to the user
        raise ValueError(f"no tube: {str(error).removeprefix('no solid: ')}") from error


def from_edge(edge: cq.Edge) -> BSpline:
    """
    Return the spline of an edge, where it lies and in its direction.

    :param edge: a line, or a Bézier curve or spline of degree 3 or less that is not rational
    :return: the spline in 3D; of an edge made by :func:`to_edge`, its poles and knots to the last bit
    :raises ValueError: for a curve that no such spline equals, saying what it is

    >>> from_edge(cq.Edge.makeLine(cq.Vector(0, 0, 0), cq.Vector(3, 0, 0))).poles[:, 0]
    array([0., 1., 2., 3.])
    """
    return occt.from_edge(edge.wrapped)
