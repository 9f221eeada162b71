"""Plane faces, the kernel judging them; and points as the hosts have them."""

from __future__ import annotations

import re

import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.gp import gp_Pnt, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation

import cadfit
from cadfit.occt import edges, from_edge, points_of, to_edge, to_face, to_wire
from cadfit.regions import signed_area


def circle(radius=1.0, centre=(0.0, 0.0), n=40):
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    return cadfit.local_spline(np.add(centre, radius * np.column_stack([np.cos(turn), np.sin(turn)])), closed=True)


def square(side=4.0, centre=(0.0, 0.0)):
    corners = np.add(centre, 0.5 * side * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]))
    return cadfit.fit(corners, 1e-6, corners=0.5, between="polyline")


def area(face):
    found = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, found, 1e-9)
    return found.Mass()


def normal(face):
    direction = BRepAdaptor_Surface(face).Plane().Axis().Direction().Coord()
    return np.array(direction) * (-1 if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED else 1)


def test_a_plane_profile_faces_up_whichever_way_it_runs():
    for outer in (circle(2.0), circle(2.0).reversed()):
        for hole in (circle(0.5), circle(0.5).reversed()):
            face = to_face(outer, [hole])
            assert BRepCheck_Analyzer(face).IsValid()
            assert area(face) == pytest.approx(np.pi * 3.75, rel=1e-5)
            assert normal(face) == pytest.approx([0, 0, 1])
    assert area(to_face(circle(2.0))) == pytest.approx(signed_area(circle(2.0).pieces()), rel=1e-9)


def test_curves_reach_the_face_unchanged():
    outer = circle(2.0)
    (edge,) = edges(to_face(outer))
    assert np.array_equal(from_edge(edge).poles[:, :2], outer.poles)
    assert np.array_equal(from_edge(edge).knots, outer.knots)


def test_in_space_the_outer_curve_runs_counterclockwise_about_the_normal():
    rng = np.random.default_rng(5)
    for _ in range(20):
        axes, offset = np.linalg.qr(rng.normal(size=(3, 3)))[0], rng.normal(size=3) * 100
        outer, hole = (curve.transformed(axes[:, :2], offset) for curve in (circle(2.0), circle(0.5, (0.7, 0.3))))
        up = np.cross(axes[:, 0], axes[:, 1])
        for loop, wanted in ((outer, up), (outer.reversed(), -up)):
            face = to_face(loop, [hole])
            assert BRepCheck_Analyzer(face).IsValid()
            assert area(face) == pytest.approx(np.pi * 3.75, rel=1e-5)
            assert normal(face) == pytest.approx(wanted, abs=1e-9)


def test_a_fit_with_corners():
    face = to_face(square(4.0), [square(1.0, (0.5, 0.5)), circle(0.3, (-1, -1))])
    assert BRepCheck_Analyzer(face).IsValid()
    assert area(face) == pytest.approx(16 - 1 - 0.09 * np.pi, rel=1e-6)
    assert len(edges(face)) == 9


def test_errors_say_what_is_wrong():
    open_arc = cadfit.local_spline([(0, 0), (1, 1), (2, 0)])
    eight = cadfit.local_spline([(0, 0), (2, 2), (4, 0), (2, -2), (0, 0.5), (-2, 2), (-4, 0), (-2, -2)], closed=True)
    bent = circle(2.0).transformed([[1, 0], [0, 1], [0, 0]])
    bent = cadfit.BSpline(bent.poles + np.outer(bent.poles[:, 0] ** 2, [0, 0, 0.1]), bent.knots)
    for loops, message in [
        ((open_arc,), "the outer curve is not closed: its end is 2 away"),
        ((circle(2.0), [open_arc]), "hole 0 is not closed"),
        ((bent,), "the outer curve is not planar: it leaves the plane by up to 0"),
        ((circle(2.0), [bent]), "hole 0 is not planar"),
        ((eight,), r"the outer curve crosses or touches itself at \("),
        ((circle(2.0), [circle(0.5, (5, 0))]), "hole 0 is outside the outer curve"),
        ((circle(2.0), [circle(0.5), circle(0.5, (1.8, 0))]), r"the outer curve crosses or touches hole 1 at \("),
        ((circle(2.0), [circle(0.5), circle(0.6, (0.5, 0))]), r"hole 0 crosses or touches hole 1 at \("),
        ((circle(2.0), [circle(0.5), circle(0.1)]), "hole 1 is inside hole 0"),
        ((circle(2.0), circle(0.5)), "holes must be a list"),
        (([],), "at least one curve"),
        (("abc",), "must be a cadfit.BSpline or a cadfit.Fit, not 'a'"),
    ]:
        with pytest.raises(ValueError, match=message):
            to_face(*loops)
    line = cadfit.BSpline([[0, 0, 0], [1, 1, 0], [1, 1, 0], [0, 0, 0]], [0] * 4 + [1] * 4)
    with pytest.raises(ValueError, match="lies on a line"):
        to_face(line)


def test_a_fit_is_an_edge_or_a_wire():
    turn = np.linspace(0, 3, 50)
    arc = cadfit.fit(np.column_stack([np.cos(turn), np.sin(turn)]), 1e-3)
    assert np.array_equal(from_edge(to_edge(arc)).knots, arc.spline.knots)
    assert len(edges(to_wire(arc))) == 1
    assert to_wire(square()).Closed()
    with pytest.raises(ValueError, match="4 curves, split at corners"):
        to_edge(square())


def test_points_of_every_kind():
    vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(1, 2, 3)).Vertex()
    given = [vertex, gp_Pnt(4, 5, 6), gp_Vec(7, 8, 9), (1, 2), np.array([1.0, 2.0, 3.0])]
    assert points_of(given).tolist() == [[1, 2, 3], [4, 5, 6], [7, 8, 9], [1, 2, 0], [1, 2, 3]]
    assert points_of(iter([(0, 1), [2, 3]])).tolist() == [[0, 1], [2, 3]]
    assert points_of([(0, 1), [2, 3, 4]]).tolist() == [[0, 1, 0], [2, 3, 4]]
    array = np.zeros((3, 2))
    assert points_of(array) is array
    for bad, message in [
        (7, "points must be a list of points, not 7"),
        ("points", "points must be a list"),
        ([(0, 0), (1, 2, 3, 4)], "row 1 of the points has 4 numbers, the rows before it 3"),
        ([(0, 0), "x"], "row 1"),
        ([vertex, to_edge(circle())], "row 1 of the points is not a point: TopoDS_Edge"),
        ([vertex, (1, float("nan"), 2)], "row 1 of the points is not finite"),
    ]:
        with pytest.raises(ValueError, match=re.escape(message)):
            points_of(bad)
