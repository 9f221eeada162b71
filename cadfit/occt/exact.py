"""Edges of every kind as rational Bézier pieces: the same curve, not an approximation."""

from __future__ import annotations

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepTools import BRepTools_WireExplorer
from OCP.Geom import Geom_Circle, Geom_Ellipse, Geom_Hyperbola, Geom_Parabola, Geom_TrimmedCurve
from OCP.GeomConvert import GeomConvert
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopoDS import TopoDS_Edge, TopoDS_Shape

from cadfit.bezier import Array, distance_to_segment
from cadfit.occt.kernel import as_edge, as_wire, building
from cadfit.occt.shapes import clamped_curve, edges, range_and_kind

_CONICS = {
    "Circle": (Geom_Circle, BRepAdaptor_Curve.Circle),
    "Ellipse": (Geom_Ellipse, BRepAdaptor_Curve.Ellipse),
    "Hyperbola": (Geom_Hyperbola, BRepAdaptor_Curve.Hyperbola),
    "Parabola": (Geom_Parabola, BRepAdaptor_Curve.Parabola),
}


def edges_in_order(shape: TopoDS_Shape) -> list[TopoDS_Edge]:
    """Return an edge, or the edges of a wire as they follow each other, each in the direction it is run through.

    Raises ValueError for other shapes, and for wires that branch or fall apart.
    """
    kind = None if shape.IsNull() else shape.ShapeType()
    if kind == TopAbs_ShapeEnum.TopAbs_EDGE:
        return [as_edge(shape)]
    if kind != TopAbs_ShapeEnum.TopAbs_WIRE:
        raise ValueError(f"an edge or a wire is needed, not {kind.name[7:].lower() if kind else 'nothing'}")
    walk, found = BRepTools_WireExplorer(as_wire(shape)), []
    while walk.More():
        found.append(walk.Current())
        walk.Next()
    if len(found) != len(edges(shape)) or not found:
        raise ValueError(f"only {len(found)} of the wire's {len(edges(shape))} edges follow each other")
    return found


def rational_pieces(edge: TopoDS_Edge) -> Array:
    """Return an edge as rational Bézier pieces (m, p + 1, 4) of its degree p, in its direction: (w x, w y, w z, w).

    Lines, circles, ellipses, parabolas, hyperbolas, Bézier curves and B-splines of every degree, rational or not,
    trimmed, periodic, moved or reversed; the pieces are the curve itself, to rounding. Raises ValueError naming the
    kind of any other curve (an offset curve, a curve on a surface), which no rational curve equals.
    """
    with building("the pieces of an edge"):
        adaptor = BRepAdaptor_Curve(as_edge(edge))
        first, last, kind = range_and_kind(adaptor)
        if kind == "Line":
            ends = [adaptor.Value(u).Coord() for u in (first, last)]
            pieces = np.insert(np.array(ends), 3, 1.0, axis=1)[None]
        else:
            pieces = _pieces(adaptor, first, last, kind)
    return pieces[::-1, ::-1] if edge.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else pieces


def _pieces(edge: BRepAdaptor_Curve, first: float, last: float, kind: str) -> Array:
    if kind in _CONICS:
        curve_of, conic_of = _CONICS[kind]
        curve = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(curve_of(conic_of(edge)), first, last))
    elif kind in ("BSplineCurve", "BezierCurve"):
        curve = clamped_curve(edge)
    else:
        raise ValueError(f"the edge's curve is of the kind {kind}, which no rational curve equals")
    degree, knots = curve.Degree(), curve.NbKnots()
    if knots > 2:
        curve.IncreaseMultiplicity(2, knots - 1, degree)
    poles = np.array([point.Coord() for point in curve.Poles()])
    weights = (
        np.array([curve.Weight(k) for k in range(1, len(poles) + 1)]) if curve.IsRational() else np.ones(len(poles))
    )
    homogeneous = np.column_stack([poles * weights[:, None], weights])
    return np.asarray(homogeneous[np.arange(knots - 1)[:, None] * degree + np.arange(degree + 1)])


def raised(pieces: Array, rows: int) -> Array:
    """Return the same pieces (m, p + 1, k) with so many rows of poles (m, rows, k): their degree raised."""
    while pieces.shape[1] < rows:
        degree = pieces.shape[1]  # the new one
        share = (np.arange(1, degree) / degree)[:, None]
        inner = share * pieces[:, :-1] + (1.0 - share) * pieces[:, 1:]
        pieces = np.concatenate([pieces[:, :1], inner, pieces[:, -1:]], axis=1)
    return pieces


def placed(pieces: Array) -> Array:
    """Return the poles (..., 3) of homogeneous ones (..., 4)."""
    return np.asarray(pieces[..., :3] / pieces[..., 3:])


def halved(pieces: Array) -> Array:
    """Return pieces (m, p + 1, 4) cut at 1/2 (2 m, p + 1, 4), the halves of each side by side; of every degree."""
    row, left, right = pieces, [pieces[:, :1]], [pieces[:, -1:]]
    while row.shape[1] > 1:
        row = 0.5 * (row[:, :-1] + row[:, 1:])
        left.append(row[:, :1])
        right.append(row[:, -1:])
    sides = np.stack([np.concatenate(left, axis=1), np.concatenate(right[::-1], axis=1)], axis=1)
    return np.asarray(sides.reshape(-1, *pieces.shape[1:]))


def straying(pieces: Array) -> Array:
    """Return an upper bound (m,) on how far pieces (m, p + 1, 4) stray from the chords between their ends.

    The weights being positive, a piece lies in the hull of its poles, where the distance to the chord, a convex
    function, is largest at a pole.
    """
    poles = placed(pieces)
    return np.asarray(distance_to_segment(poles, poles[:, :1], poles[:, -1:]).max(axis=1))
