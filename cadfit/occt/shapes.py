"""Splines as edges and wires, and edges as splines."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeVertex
from OCP.Geom import Geom_BSplineCurve
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Pnt
from OCP.Precision import Precision
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Shape, TopoDS_Vertex, TopoDS_Wire

from cadfit.bspline import DEGREE, BSpline
from cadfit.joining import HasCurves, Splines, splines_of
from cadfit.occt.geometry import curve as kernel_curve
from cadfit.occt.kernel import CONFUSION, KernelError, Shapes, as_edge, as_face, building


def to_edge(curve: BSpline | HasCurves) -> TopoDS_Edge:
    """Return the edge of a spline, with its very poles, knots and multiplicities; a 2D spline lies in z = 0.

    `curve` may also be a fit of one curve. Ends no farther apart than `CONFUSION` share one vertex, so a closed curve
    is a closed edge. Raises ValueError for a dimension other than 2 or 3, for a fit that corners split (`to_wire` takes
    it), and where all poles lie within `CONFUSION`; KernelError where the kernel refuses.
    """
    found = splines_of(curve)
    if len(found) > 1:
        raise ValueError(f"{len(found)} curves, split at corners, are no single edge: to_wire makes a wire of them")
    return _chain([_lifted(found[0])])[0]


def to_wire(curves: Splines) -> TopoDS_Wire:
    """Return the wire of splines that follow each other end to end (or of a fit); consecutive edges share a vertex.

    The wire is closed when the last end is the first start. Raises ValueError when there is no curve or a joint is
    open by more than `CONFUSION`, naming the joint, and as `to_edge`.
    """
    curves = [_lifted(curve) for curve in splines_of(curves)]
    for k, (before, after) in enumerate(pairwise(curves)):
        if (gap := _gap(before, after)) > CONFUSION:
            raise ValueError(f"curve {k} ends {gap:.3g} away from the start of curve {k + 1}: not one wire")
    builder, wire = BRep_Builder(), TopoDS_Wire()
    builder.MakeWire(wire)
    for edge in _chain(curves):
        builder.Add(wire, edge)
    wire.Closed(_gap(curves[-1], curves[0]) <= CONFUSION)
    return wire


def from_edge(edge: TopoDS_Edge) -> BSpline:
    """Return the 3D spline of an edge, over the edge's range, where it lies and in its direction.

    Lines, Bézier curves and B-splines of degree 3 or less are taken over exactly; an edge made by `to_edge` comes
    back bit for bit. Raises ValueError saying what the curve is where no non-rational cubic equals it (a circle, a
    rational curve, a higher degree, no end), and where it is no edge.
    """
    kind = None if edge.IsNull() else edge.ShapeType()
    if kind != TopAbs_ShapeEnum.TopAbs_EDGE:  # at one without a shape the kernel would crash
        raise ValueError(f"an edge is needed, not {kind.name[7:].lower() if kind else 'nothing'}")
    with building("a spline of an edge"):
        spline = _spline(BRepAdaptor_Curve(as_edge(edge)))
    return spline.reversed() if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else spline


def edges(shapes: TopoDS_Shape | Iterable[TopoDS_Shape]) -> list[TopoDS_Edge]:
    """Return the edges of one or more shapes in the order they are found, each once."""
    return [as_edge(found) for found in _parts(shapes, TopAbs_ShapeEnum.TopAbs_EDGE)]


def faces(shapes: TopoDS_Shape | Iterable[TopoDS_Shape]) -> list[TopoDS_Face]:
    """Return the faces of one or more shapes in the order they are found, each once."""
    return [as_face(found) for found in _parts(shapes, TopAbs_ShapeEnum.TopAbs_FACE)]


def solids(shapes: TopoDS_Shape | Iterable[TopoDS_Shape]) -> list[TopoDS_Shape]:
    """Return the solids of one or more shapes in the order they are found, each once."""
    return _parts(shapes, TopAbs_ShapeEnum.TopAbs_SOLID)


def _parts(shapes: TopoDS_Shape | Iterable[TopoDS_Shape], kind: TopAbs_ShapeEnum) -> list[TopoDS_Shape]:
    found = Shapes()
    for shape in [shapes] if isinstance(shapes, TopoDS_Shape) else shapes:
        TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(k) for k in range(1, found.Extent() + 1)]


def _lifted(spline: BSpline) -> BSpline:
    """Return the spline in 3D."""
    n, d = spline.poles.shape
    if d not in (2, 3):
        raise ValueError(f"the kernel takes curves in 2D or 3D, not in {d}D: transform the spline first")
    return spline if d == 3 else BSpline(np.column_stack([spline.poles, np.zeros(n)]), spline.knots)


def _gap(before: BSpline, after: BSpline) -> float:
    """Return how far the end of one spline is from the start of another."""
    return float(np.linalg.norm(after.poles[0] - before.poles[-1]))


def _chain(curves: Sequence[BSpline]) -> list[TopoDS_Edge]:
    """Return the edges of splines that follow each other, one vertex where they meet and at a return to the start."""
    made = []
    start = first = _vertex(curves[0], 0)
    for k, curve in enumerate(curves):
        what = f"an edge of {len(curve.poles)} poles" + f" (curve {k})" * (len(curves) > 1)
        if curve.size <= CONFUSION:
            raise ValueError(f"{what}: the poles all lie within {CONFUSION}, one point to the kernel")
        if _gap(curve, curve) <= CONFUSION:
            end = start
        else:
            end = first if _gap(curve, curves[0]) <= CONFUSION else _vertex(curve, -1)
        with building(what):
            # With its ends' parameters given, the kernel does not search for the vertices along the curve.
            make = BRepBuilderAPI_MakeEdge(kernel_curve(curve.poles, curve.knots, DEGREE), start, end, *curve.domain)
            if not make.IsDone():
                raise KernelError(make.Error().name.removeprefix("BRepBuilderAPI_"))
            made.append(make.Edge())
        start = end
    return made


def _vertex(spline: BSpline, end: int) -> TopoDS_Vertex:
    return BRepBuilderAPI_MakeVertex(gp_Pnt(*spline.poles[end].tolist())).Vertex()


def _spline(edge: BRepAdaptor_Curve) -> BSpline:
    """Return the spline of an edge's curve over the edge's range."""
    first, last, kind = range_and_kind(edge)
    if kind == "Line":
        poles = np.linspace(edge.Value(first).Coord(), edge.Value(last).Coord(), DEGREE + 1)
        return BSpline(poles, np.repeat([first, last], DEGREE + 1))
    polynomial = kind in ("BSplineCurve", "BezierCurve") and not edge.IsRational()
    if not polynomial or edge.Degree() > DEGREE:
        what = f"{kind} of degree {edge.Degree()}" if polynomial else f"{kind} (not polynomial)"
        raise ValueError(f"no non-rational cubic spline equals the edge's curve, a {what}")
    curve = clamped_curve(edge)
    curve.IncreaseDegree(DEGREE)
    poles = np.array([point.Coord() for point in curve.Poles()])
    return BSpline(poles, np.repeat([*curve.Knots()], [*curve.Multiplicities()]))


def range_and_kind(edge: BRepAdaptor_Curve) -> tuple[float, float, str]:
    """Return the first and the last parameter of an edge, and the kind of its curve ("Circle", "BSplineCurve", ...)."""
    first, last = edge.FirstParameter(), edge.LastParameter()
    kind = edge.GetType().name.removeprefix("GeomAbs_")
    if Precision.IsInfinite_s(first) or Precision.IsInfinite_s(last):
        raise ValueError(f"the edge, a {kind}, has no end: a spline needs both")
    return first, last, kind


def clamped_curve(edge: BRepAdaptor_Curve) -> Geom_BSplineCurve:
    """Return a Bézier or B-spline edge's curve as a clamped B-spline of its own over the edge's range."""
    first, last, kind = range_and_kind(edge)
    # A copy: Segment and IncreaseDegree would change the edge's own curve.
    curve = edge.BSpline().Copy() if kind == "BSplineCurve" else GeomConvert.CurveToBSplineCurve_s(edge.Bezier())
    clamped = {curve.Multiplicity(1), curve.Multiplicity(curve.NbKnots())} == {curve.Degree() + 1}
    if not clamped or (first, last) != (curve.FirstParameter(), curve.LastParameter()):
        curve.Segment(first, last)
    return curve
