"""Volumes by Gauss' rule: those of extruded and revolved splines to rounding, and none of cut faces."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakePipe
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pnt, gp_Vec

from cadfit import fit, local_spline
from cadfit.bezier import Array
from cadfit.occt import to_face, to_wire, tube_solid, volume


@pytest.fixture(scope="module")
def outline():
    """A wavy closed outline of many poles, at x > 0 as it must be to revolve it about y."""
    angle = np.linspace(0.0, 2.0 * np.pi, 400)
    radius = 8.0 + np.sin(11.0 * angle)
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)]) + [20.0, 3.0]
    points[-1] = points[0]
    return fit(points, 1e-3, effort="fast")


def by_dense_polygon(outline) -> tuple[float, float]:
    """The area within the outline, and its moment about the y axis, of polygons of it: two, and what they tend to."""
    found = [area_and_moment(outline.spline(np.linspace(*outline.spline.domain, n))) for n in (20_001, 40_001)]
    return tuple((4.0 * found[1] - found[0]) / 3.0)


def area_and_moment(polygon: Array) -> Array:
    (x, y), (u, v) = polygon[:-1].T, polygon[1:].T
    return np.array([np.sum(x * v - u * y) / 2.0, np.sum((x + u) * (x * v - u * y)) / 6.0])


def test_extruded_and_revolved(outline):
    face, (area, moment) = to_face(outline), by_dense_polygon(outline)
    bar = BRepPrimAPI_MakePrism(face, gp_Vec(0.0, 0.0, 7.0)).Shape()
    assert volume(bar) == pytest.approx(7.0 * area, rel=1e-9)
    ring = BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 1.0, 0.0))).Shape()
    assert abs(volume(ring)) == pytest.approx(2.0 * np.pi * moment, rel=1e-9)


def test_a_whole_turn_in_one_rational_span():
    turn = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    path = local_spline(np.column_stack([50 * np.cos(turn), 50 * np.sin(turn), 0 * turn]), closed=True)
    circle = gp_Circ(gp_Ax2(gp_Pnt(*path.poles[0]), gp_Dir(*path.derivative(0.0))), 2.0)
    disc = BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire()).Face()
    ring = BRepOffsetAPI_MakePipe(to_wire([path]), disc).Shape()
    assert abs(volume(ring)) == pytest.approx(4.0 * np.pi * path.length(), rel=1e-6)


def test_a_cut_face_is_refused():
    points = [[0, 0, 0], [0, 0, 10], [0, 0, 20]]
    long, across = tube_solid(fit(points, 0.1), 2.0), tube_solid(fit(np.roll(points, 1, axis=1) + [-9, 0, 9], 0.1), 1.0)
    assert volume(long) == pytest.approx(80.0 * np.pi, rel=1e-6)
    drilled = BRepAlgoAPI_Cut(long, across).Shape()
    with pytest.raises(ValueError, match="a face is cut out of its surface"):
        volume(drilled)
