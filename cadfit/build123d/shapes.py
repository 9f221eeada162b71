"""Splines as build123d's edges, wires and faces, and edges as splines."""

from __future__ import annotations

from collections.abc import Iterable

from build123d import Edge, Face, Wire

from cadfit import occt
from cadfit.bspline import BSpline
from cadfit.fitting.approximate import Effort
from cadfit.fitting.result import Fit
from cadfit.joining import HasCurves, Splines
from cadfit.stages import Progress


def to_edge(curve: BSpline | HasCurves) -> Edge:
    """Create an edge of a spline, with its very poles and knots

    Args:
        curve (BSpline | Fit): a spline in 2D (it lies in Plane.XY) or 3D, or a fit without
            corners

    Raises:
        ValueError: corners split the fit (`to_wire` takes it), other dimensions
        cadfit.occt.KernelError: the kernel refuses the curve

    Returns:
        Edge: closed if the spline returns to its start

    >>> arc = to_edge(BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 4, 4, 4, 4]))
    >>> arc.geom_type.name, arc @ 1
    ('BSPLINE', Vector(3, 0, 0))
    """
    return Edge(occt.to_edge(curve))


def to_wire(curves: Splines) -> Wire:
    """Create a wire of splines that follow each other end to end

    Args:
        curves (BSpline | Fit | Sequence[BSpline]): a spline, a fit, or several splines in order

    Raises:
        ValueError: no curves, an open joint, naming it
        cadfit.occt.KernelError: the kernel refuses a curve

    Returns:
        Wire: closed if the last spline ends at the start of the first

    >>> there = BSpline([[0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 3, 3, 3, 3])
    >>> back = BSpline([[3, 0], [3, 3], [0, 3], [0, 0]], [3, 3, 3, 3, 12, 12, 12, 12])
    >>> to_wire([there, back]).is_closed
    True
    """
    return Wire(occt.to_wire(curves))


def to_face(outer: Splines, holes: Iterable[Splines] = ()) -> Face:
    """Create the planar face inside a closed curve, less the holes

    Args:
        outer (BSpline | Fit | Sequence[BSpline]): the closed outer curve; of one in 2D the face
            lies in Plane.XY and faces up, in 3D it runs counterclockwise about the normal
        holes (Iterable, optional): closed curves inside it, one for each hole. Defaults to ()

    Raises:
        ValueError: which curve is open, not planar, crosses itself or another, and where
        cadfit.occt.KernelError: the kernel refuses

    Returns:
        Face: its edges with the splines' very poles and knots

    >>> from cadfit import cardinal_spline
    >>> leaf = to_face(cardinal_spline([(3, 0), (0, 1), (-3, 0), (0, -1)], curvature=1.0, closed=True))
    >>> leaf.is_valid, leaf.normal_at()
    (True, Vector(0, 0, 1))
    """
    return Face(occt.to_face(outer, holes))


def from_edge(edge: Edge) -> BSpline:
    """Return the spline of an edge, where it lies and in its direction

    Args:
        edge (Edge): a line, or a Bézier curve or B-spline of degree 3 or less, not rational

    Raises:
        ValueError: a curve that no such spline equals, saying what it is (`simplify` takes it)

    Returns:
        BSpline: in 3D; of an edge made by `to_edge`, poles and knots to the last bit

    >>> from_edge(Edge.make_line((0, 0), (3, 0))).poles[:, 0]
    array([0., 1., 2., 3.])
    """
    return occt.from_edge(edge.wrapped)


def simplify(edge: Edge | Wire, tolerance: float, effort: Effort = "best", progress: Progress | None = None) -> Fit:
    """Refit an edge or a wire with fewer poles, within a certified tolerance of what it was

    Every kind of edge that is rational or polynomial is taken: lines, arcs, conics, Bézier
    curves and B-splines of every degree. The bound holds both ways, for whole curves. Edges that
    go on smoothly become one; corners are kept. `FitSpline(edge, tolerance)` draws the result.

    Args:
        edge (Edge | Wire): what to refit, where it lies
        tolerance (float): the largest distance between it and the result
        effort ("best" | "fast", optional): "fast" takes less time, and more poles
        progress (Callable[[float], None], optional): as for FitSpline

    Raises:
        ValueError: an offset curve, a wire that branches, a tolerance that cannot be certified

    Returns:
        Fit: the splines; `to_wire` and `to_edge` take it

    >>> simplify(Edge.make_circle(10), 0.01, "fast").deviation.between <= 0.01
    True
    """
    return occt.simplify(edge.wrapped, tolerance, effort=effort, progress=progress)
