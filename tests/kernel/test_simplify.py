"""Edges and wires refitted lighter: held, both ways, to the kernel's own evaluation of what they were."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_MakeWire
from OCP.Geom import Geom_BezierCurve, Geom_BSplineCurve, Geom_OffsetCurve
from OCP.gp import gp_Ax2, gp_Ax3, gp_Circ, gp_Dir, gp_Elips, gp_Hypr, gp_Lin, gp_Parab, gp_Pnt, gp_Trsf
from OCP.TopLoc import TopLoc_Location

import cadfit
from cadfit.bezier import distance_to_segment
from cadfit.occt import kernel, simplify, to_edge, to_face, to_wire
from cadfit.occt.exact import halved, placed, raised, rational_pieces, straying

TILTED = gp_Ax2(gp_Pnt(1, 2, 3), gp_Dir(1, 2, 2), gp_Dir(2, 1, -2))


def edge_of(curve, *part):
    return BRepBuilderAPI_MakeEdge(curve, *part).Edge()


def part_of(curve, start=0.1, end=0.7):
    low, high = curve.FirstParameter(), curve.LastParameter()
    return edge_of(curve, low + start * (high - low), low + end * (high - low))


def array_of(kind, values):
    array = kind(1, len(values))
    for k, value in enumerate(values, start=1):
        array.SetValue(k, value)
    return array


def bspline(degree, spans, rational, seed, periodic=False):
    """Return a kernel's B-spline with random poles, knots and weights, C1 or smoother."""
    rng = np.random.default_rng([seed, degree, spans])
    knots = np.cumsum(rng.uniform(0.2, 2.0, spans + 1))
    inner = rng.integers(1, max(degree, 2), spans - 1).tolist()
    often = [int(inner[0]), *inner, int(inner[0])] if periodic else [degree + 1, *inner, degree + 1]
    count = sum(often[:-1]) if periodic else sum(often) - degree - 1
    poles = [
        gp_Pnt(*place) for place in (rng.normal(size=(count, 3)) + np.arange(count)[:, None] * (not periodic)).tolist()
    ]
    weights = rng.uniform(0.3, 3.0, count).tolist() if rational else [1.0] * count
    return Geom_BSplineCurve(
        array_of(kernel.Points, poles),
        array_of(kernel.Reals, weights),
        array_of(kernel.Reals, knots.tolist()),
        array_of(kernel.Integers, often),
        degree,
        periodic,
    )


def bezier(degree, rational):
    rng = np.random.default_rng(degree)
    poles = array_of(kernel.Points, [gp_Pnt(k, *rng.normal(size=2).tolist()) for k in range(degree + 1)])
    weights = array_of(kernel.Reals, rng.uniform(0.3, 3.0, degree + 1).tolist())
    return Geom_BezierCurve(poles, weights) if rational else Geom_BezierCurve(poles)


def moved(edge):
    turn = gp_Trsf()
    turn.SetDisplacement(gp_Ax3(gp_Ax2()), gp_Ax3(TILTED))
    return edge.Moved(TopLoc_Location(turn))


EDGES = {
    "line": lambda: edge_of(gp_Lin(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 1)), -2.0, 7.0),
    "circle": lambda: edge_of(gp_Circ(TILTED, 5.0)),
    "arc over the seam": lambda: edge_of(gp_Circ(TILTED, 5.0), 5.0, 8.0),
    "ellipse": lambda: edge_of(gp_Elips(TILTED, 5.0, 1.0)),
    "arc of an ellipse": lambda: edge_of(gp_Elips(TILTED, 5.0, 1.0), 1.0, 4.5).Reversed(),
    "parabola": lambda: edge_of(gp_Parab(TILTED, 0.5), -2.0, 3.0),
    "hyperbola": lambda: edge_of(gp_Hypr(TILTED, 2.0, 1.0), -1.0, 2.0),
    "Bézier of degree 2": lambda: edge_of(bezier(2, False)),
    "Bézier of degree 9": lambda: edge_of(bezier(9, False), 0.2, 0.9),
    "rational Bézier": lambda: edge_of(bezier(5, True)).Reversed(),
    "degree 1": lambda: edge_of(bspline(1, 4, False, 0)),
    "degree 2, rational": lambda: edge_of(bspline(2, 5, True, 1)),
    "degree 3": lambda: edge_of(bspline(3, 6, False, 2)),
    "degree 5": lambda: moved(edge_of(bspline(5, 4, False, 3))),
    "degree 7, rational, part": lambda: moved(part_of(bspline(7, 3, True, 4)).Reversed()),
    "degree 12": lambda: edge_of(bspline(12, 2, False, 5)),
    "degree 25": lambda: edge_of(bspline(25, 1, False, 5)),
    "periodic": lambda: edge_of(bspline(3, 6, False, 6, periodic=True)),
    "periodic, rational, over the seam": lambda: part_of(bspline(4, 6, True, 7, periodic=True), 0.6, 1.4),
}


def places(edge, n):
    """Return points (n, 3) of an edge as the kernel evaluates them, from its start to its end."""
    curve = BRepAdaptor_Curve(kernel.as_edge(edge))
    u = np.linspace(curve.FirstParameter(), curve.LastParameter(), n)
    found = np.array([curve.Value(t).Coord() for t in u.tolist()])
    return found[::-1] if edge.Orientation().name == "TopAbs_REVERSED" else found


def off_by(edge, fit, n=400):
    """Return the largest distance, both ways, between samples of an edge and of what it became."""
    chain, fine = cadfit.join(fit.curves), places(edge, 40 * n)
    there = chain.nearest(places(edge, n))[1].max()
    back = chain(np.linspace(*chain.domain, n))[:, None]
    return max(there, *(distance_to_segment(place, fine[:-1], fine[1:]).min() for place in back))


@pytest.mark.parametrize("kind", EDGES)
def test_pieces_are_the_edge_itself(kind):
    edge = EDGES[kind]()
    pieces = rational_pieces(edge)
    assert pieces.shape[2] == 4
    assert np.abs(placed(pieces[1:, 0]) - placed(pieces[:-1, -1])).max(initial=0.0) < 1e-12
    ends = places(edge, 2)
    assert placed(pieces[0, 0]) == pytest.approx(ends[0], abs=1e-12)
    assert placed(pieces[-1, -1]) == pytest.approx(ends[1], abs=1e-12)
    fine = pieces
    for _ in range(7):
        fine = halved(fine)
    strays = straying(fine)
    polyline = np.concatenate([placed(fine[:, 0]), placed(fine[-1:, -1])])
    near = distance_to_segment(places(edge, 300)[:, None], polyline[:-1], polyline[1:])
    assert near.min(axis=1).max() <= strays.max() + 1e-12
    assert strays.max() < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize("kind", EDGES)
def test_what_is_promised_holds(kind):
    edge = EDGES[kind]()
    fit = simplify(edge, 1e-3, effort="fast")
    assert fit.deviation.points == fit.deviation.between <= 1e-3 == fit.tolerance
    assert off_by(edge, fit) <= fit.deviation.between + 1e-6, "the judge's polyline is that far off"
    ends = places(edge, 2)
    if not fit.closed:
        assert fit.curves[0].poles[0] == pytest.approx(ends[0], abs=1e-12)
        assert fit.curves[-1].poles[-1] == pytest.approx(ends[1], abs=1e-12)
    assert np.linalg.norm(cadfit.join(fit.curves)(fit.parameters) - fit.points, axis=1).max() <= 1e-3
    if kind in ("circle", "ellipse"):
        assert fit.closed
        first, last = (fit.spline.derivative(u, 2) for u in fit.spline.domain)
        assert first == pytest.approx(last, abs=1e-9)


def test_the_bound_sees_a_change():
    edge = EDGES["rational Bézier"]()
    fit = simplify(edge, 1e-3, effort="fast")
    poles = fit.spline.poles.copy()
    poles[len(poles) // 2] += [0.0, 0.0, 5e-3]
    spoiled = cadfit.BSpline(poles, fit.spline.knots)
    far = cadfit.deviation(spoiled, fit.points)
    assert max(far.points, far.between) > 1e-3


def test_degree_and_halves_leave_the_curve_as_it_is():
    pieces = rational_pieces(EDGES["degree 7, rational, part"]())
    assert np.array_equal(raised(pieces, 8), pieces)
    higher = raised(pieces, 12)
    for _ in range(3):
        pieces, higher = halved(pieces), halved(higher)
    assert placed(higher[:, 0]) == pytest.approx(placed(pieces[:, 0]), abs=1e-12)
    assert len(pieces) == len(higher)


def test_edges_that_go_on_smoothly_become_one():
    line = edge_of(gp_Lin(gp_Pnt(0, -5, 0), gp_Dir(1, 0, 0)), 0.0, 20.0)
    arc = edge_of(gp_Circ(gp_Ax2(gp_Pnt(20, 0, 0), gp_Dir(0, 0, 1)), 5.0), -np.pi / 2, np.pi / 2)
    stop = edge_of(gp_Lin(gp_Pnt(20, 5, 0), gp_Dir(-1, 2, 0)), 0.0, 10.0)
    make = BRepBuilderAPI_MakeWire(line, arc, stop)
    fit = simplify(make.Wire(), 0.01)
    assert len(fit.curves) == 2
    assert fit.points[fit.corners] == pytest.approx(np.array([[20, 5, 0]]), abs=1e-12)
    assert fit.deviation.between <= 0.01
    assert off_by(line, fit, 100) > 1.0, "the judge sees the rest of the wire"
    assert max(cadfit.join(fit.curves).nearest(places(each, 500))[1].max() for each in (line, arc, stop)) <= 0.01


def test_a_polygon_comes_back_as_it_is():
    make = BRepBuilderAPI_MakePolygon()
    for place in ((0, 0), (4, 0), (4, 3), (0, 3)):
        make.Add(gp_Pnt(*place, 1.0))
    make.Close()
    fit = simplify(make.Wire(), 1e-3)
    assert fit.closed
    assert [len(curve.poles) for curve in fit.curves] == [4] * 4
    assert fit.points[fit.corners][:, :2].tolist() == [[0, 0], [4, 0], [4, 3], [0, 3]]
    assert simplify(to_wire(fit), 1e-3).poles == 16
    assert to_face(fit) is not None


def test_a_cubic_that_cannot_be_lighter_comes_back_as_it_is():
    spline = cadfit.interpolate(np.random.default_rng(2).normal(size=(9, 3)))
    fit = simplify(to_edge(spline), 1e-4, effort="fast")
    assert np.array_equal(fit.spline.poles, spline.poles)
    assert fit.deviation.between < 1e-12
    assert fit.spline(fit.parameters) == pytest.approx(fit.points, abs=1e-12)


def test_errors_say_what_is_wrong():
    edge = EDGES["circle"]()
    for bad in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="the tolerance must be a positive length"):
            simplify(edge, bad)
    offset = edge_of(Geom_OffsetCurve(bspline(5, 2, False, 3), 0.5, gp_Dir(0, 0, 1)))
    with pytest.raises(ValueError, match="of the kind OffsetCurve, which no rational curve equals"):
        simplify(offset, 1e-3)
    with pytest.raises(ValueError, match="an edge or a wire is needed, not face"):
        simplify(to_face(cadfit.local_spline([(0, 0), (1, 0), (0, 1)], closed=True)), 1e-3)


@pytest.mark.slow
def test_a_tolerance_too_small_names_one_that_may_do():
    with pytest.raises(ValueError, match=r"too small to be certified here; .* may do"):
        simplify(EDGES["circle"](), 1e-13)
