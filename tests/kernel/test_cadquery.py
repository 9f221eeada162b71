"""cadfit in CadQuery: drawn as the host draws, the curve unchanged, never in the way of the host's own."""

import importlib
import re
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh

import cadfit

from corpus_data import curves, turn

cq = pytest.importorskip("cadquery")

from cadquery import cqgi  # noqa: E402
from OCP.BRepAdaptor import BRepAdaptor_Curve  # noqa: E402
from OCP.BRepGProp import BRepGProp  # noqa: E402
from OCP.GeomAbs import GeomAbs_Shape  # noqa: E402
from OCP.GProp import GProp_GProps  # noqa: E402

import cadfit.cadquery as host  # noqa: E402

OWN = {owner: set(dir(owner)) for owner in (cq.Workplane, cq.Sketch)}  # before any test registers

ROOT = Path(__file__).parents[2]
SIDES = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0]])
SQUARE = np.concatenate([a + np.linspace(0, 1, 20, endpoint=False)[:, None] * (b - a) for a, b in pairwise(SIDES)])
SQUARE = np.concatenate([SQUARE, SQUARE[:1]])
OVAL = turn(60, 12.0) * [2.0, 1.0]
WAVE = np.column_stack([np.linspace(0, 10, 41), np.sin(np.linspace(0, 5, 41))])
DRAWN = ("fitSpline", "cardinalSpline", "localSpline")
NAMES = (*DRAWN, "fitProfile", "fitTube")
RING = np.pi * 24 * 12 * 0.75
PLANES = ["XY", "XZ", "ZY", cq.Plane((3, -2, 7), (1, 2, 0.5), (0.3, -0.2, 1.1))]


@pytest.fixture(autouse=True)
def unregistered():
    """CadQuery's classes as they are on import, before and after a test."""
    unregister()
    yield
    unregister()


def unregister():
    for owner, names in OWN.items():
        for name in set(vars(owner)) - names:
            delattr(owner, name)


def volume(shape):
    """The volume, by the one of the kernel's integrations that is right on walls extruded from splines."""
    found = GProp_GProps()
    BRepGProp.VolumePropertiesGK_s(shape.wrapped, found, 1e-6, False, False, False, False, False)
    return found.Mass()


def in_plane(plane, spline):
    """A spline's poles where a plane has them, by CadQuery's own transformation."""
    lifted = np.column_stack([spline.poles, np.zeros((len(spline.poles), 3 - spline.poles.shape[1]))])
    return np.array([plane.toWorldCoords(tuple(row)).toTuple() for row in lifted])


def world(points):
    return np.array([v.toTuple() for v in points])


# Curves and edges


@pytest.mark.parametrize("closed", [False, True])
def test_an_edge_is_the_spline_and_comes_back_to_the_last_bit(closed):
    spline = cadfit.local_spline(OVAL if closed else WAVE, closed=closed)
    edge = host.to_edge(spline)
    assert isinstance(edge, cq.Edge)
    assert edge.isValid()
    assert edge.IsClosed() == closed
    back = host.from_edge(edge)
    assert np.array_equal(back.poles[:, :2], spline.poles)
    assert np.array_equal(back.knots, spline.knots)
    assert edge.Length() == pytest.approx(spline.length(), rel=1e-6)


def test_the_kernel_sees_c2_at_every_knot():
    edge = host.fit_edge(OVAL, 0.01, effort="fast", closed=True)
    adaptor = BRepAdaptor_Curve(edge.wrapped)
    assert adaptor.Continuity() == GeomAbs_Shape.GeomAbs_C2
    assert adaptor.NbIntervals(GeomAbs_Shape.GeomAbs_C2) == 1
    joined = host.to_edge(cadfit.join(cadfit.fit(SQUARE, 0.01).curves))
    assert BRepAdaptor_Curve(joined.wrapped).NbIntervals(GeomAbs_Shape.GeomAbs_C2) == 4


@pytest.mark.parametrize("shape", curves(1, families=["airfoil", "mesh_section", "neuron", "cad_edge"]))
def test_real_curves_pass_through_unchanged(shape):
    fit = cadfit.fit(shape.points, 1e-3 * shape.size, closed=shape.closed, effort="fast")
    wire = host.to_wire(fit)
    assert wire.isValid()
    assert wire.IsClosed() == fit.closed
    for edge, curve in zip(wire.Edges(), fit.curves, strict=True):
        back = host.from_edge(edge)
        assert np.array_equal(back.poles[:, : curve.poles.shape[1]], curve.poles)
        assert np.array_equal(back.knots, curve.knots)


def test_a_face_has_its_holes_and_the_area_between_the_curves():
    hole = cadfit.fit(turn(80, 3.0), 1e-4, closed=True)
    face = host.to_face(cadfit.fit(SQUARE, 0.01), [hole.spline.transformed(0.3 * np.eye(2), [2.0, 1.5])])
    assert isinstance(face, cq.Face)
    assert face.isValid()
    assert face.Area() == pytest.approx(12.0 - np.pi * 0.81, abs=1e-3)
    assert len(face.innerWires()) == 1


@pytest.mark.parametrize("plane", PLANES)
def test_points_are_in_the_workplanes_coordinates(plane):
    base = host.Workplane(plane)
    fit = cadfit.fit(WAVE, 0.01, effort="fast")
    edge = base.fitSpline(WAVE, 0.01, effort="fast").val()
    assert np.abs(host.from_edge(edge).poles - in_plane(base.plane, fit.spline)).max() < 1e-13
    assert np.array_equal(host.from_edge(edge).knots, fit.spline.knots)
    local = edge.moved(base.plane.location.inverse)
    assert np.abs(host.from_edge(local).poles[:, :2] - fit.spline.poles).max() < 1e-13


# Points


KINDS = {
    "tuples": [tuple(p) for p in WAVE.tolist()],
    "vectors": [cq.Vector(*p) for p in WAVE.tolist()],
    "array": WAVE,
    "3D": np.column_stack([WAVE, np.zeros(len(WAVE))]),
    "locations": [cq.Location((*p, 0.0)) for p in WAVE.tolist()],
}


@pytest.mark.parametrize("points", KINDS.values(), ids=KINDS)
def test_points_of_every_kind_draw_the_same(points):
    edge = host.Workplane("XZ").fitSpline(points, 0.01, effort="fast").val()
    plain = host.Workplane("XZ").fitSpline(WAVE, 0.01, effort="fast").val()
    assert np.abs(host.from_edge(edge).poles - host.from_edge(plain).poles).max() < 1e-12


def test_shapes_and_the_stack_are_taken_where_they_are():
    there = [cq.Vertex.makeVertex(*p, 1.0) for p in WAVE.tolist()]
    on_vertices = host.Workplane("YZ").fitSpline(there, 0.01, effort="fast").val()
    stacked = (
        host.Workplane("XY", origin=(0, 0, 1)).pushPoints(KINDS["tuples"]).fitSpline(None, 0.01, effort="fast").val()
    )
    for edge in (on_vertices, stacked):
        assert edge.startPoint().toTuple() == pytest.approx((0, 0, 1))
        assert edge.endPoint().toTuple() == pytest.approx((10, np.sin(5), 1))


def test_tangents_turn_with_what_they_belong_to():
    flat = host.Workplane("XZ").fitSpline(WAVE, 0.01, effort="fast", tangents=[(0, 1), (1, 0)]).val()
    assert flat.tangentAt(0).toTuple() == pytest.approx((0, 0, 1), abs=1e-9)
    assert flat.tangentAt(1).toTuple() == pytest.approx((1, 0, 0), abs=1e-9)
    there = [cq.Vertex.makeVertex(x, 0.0, z) for x, z in WAVE.tolist()]
    placed = host.Workplane("XZ").fitSpline(there, 0.01, effort="fast", tangents=[(0, 1), (1, 0)]).val()
    assert placed.tangentAt(0).toTuple() == pytest.approx((0, 0, 1), abs=1e-9)
    rising = host.fit_edge(WAVE, 0.01, effort="fast", tangents=[(1, 0, 1), (1, 0, 0)])
    assert rising.tangentAt(0).toTuple() == pytest.approx((0.5**0.5, 0, 0.5**0.5), abs=1e-9)


# Edges and wires refitted


@pytest.mark.slow
def test_edges_and_wires_are_refitted_lighter_where_they_are():
    heavy = cq.Workplane("XZ", origin=(0, 5, 0)).spline([tuple(p) for p in turn(200, 10.0)], periodic=True)
    for light in (
        host.simplify(heavy.val(), 0.01, "fast"),
        host.Workplane("YZ").fitSpline(heavy.val(), 0.01, effort="fast").val(),
        host.Workplane(obj=heavy.val()).fitSpline(None, 0.01, effort="fast").val(),
    ):
        assert isinstance(light, cq.Edge)
        spline = host.from_edge(light)
        assert len(spline.poles) < 20
        assert spline.nearest([p.toTuple() for p in heavy.val().positions(np.linspace(0, 1, 50))])[1].max() <= 0.01
    plate = cq.Workplane().rect(40, 20).val()
    wire = host.simplify(cq.Wire.makePolygon([(0, 0), (4, 0), (4, 3)], close=True), 0.01)
    assert isinstance(wire, cq.Wire)
    assert len(wire.Edges()) == 3
    outline = host.Workplane().fitProfile(plate, 0.01, [cq.Wire.makeCircle(5, (0, 0, 0), (0, 0, 1))], effort="fast")
    assert volume(outline.extrude(1).val()) == pytest.approx(800 - 25 * np.pi, abs=0.2)
    assert host.fit_tube(heavy.val(), 1.0, 0.01, effort="fast").isValid()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"corners": None}, "no corners"),
        ({"closed": True}, "no closed"),
        ({"between": "polyline"}, "no between"),
        ({"tangents": [(1, 0), (1, 0)]}, "no tangents"),
        ({"includeCurrent": True}, "no includeCurrent"),
    ],
)
def test_an_edge_is_refitted_as_it_is(options, says):
    with pytest.raises(ValueError, match=says):
        host.Workplane().fitSpline(cq.Edge.makeLine(cq.Vector(), cq.Vector(1, 0, 0)), 0.1, **options)


def test_a_last_point_that_is_the_first_to_the_kernel_closes():
    around = np.linspace(0, 2 * np.pi, 100)
    nearly = 9 * np.column_stack([np.cos(around), np.sin(around), np.zeros(100)])
    assert 0 < np.linalg.norm(nearly[0] - nearly[-1]) < 1e-12
    assert host.fit_edge(nearly, 0.01, effort="fast").IsClosed()
    assert host.fit_tube(nearly, 1.0, 0.01, effort="fast").isValid()


# The host's manner


def test_edges_become_pending_and_close_into_a_solid():
    oval = host.Workplane("XZ").fitSpline(OVAL, 0.01, effort="fast", closed=True).close().extrude(5)
    assert type(oval) is host.Workplane
    assert oval.val().isValid()
    assert volume(oval.val()) == pytest.approx(np.pi * 24 * 12 * 5, rel=2e-3)
    cornered = host.Workplane().fitSpline(SQUARE, 0.01, effort="fast").close().extrude(2)
    assert volume(cornered.val()) == pytest.approx(24.0)
    assert cornered.faces().size() == 6
    open_one = host.Workplane().fitSpline(WAVE, 0.01, effort="fast").lineTo(10, -3).lineTo(0, -3).close().extrude(1)
    assert open_one.val().isValid()
    assert volume(open_one.val()) == pytest.approx(np.trapezoid(WAVE[:, 1] + 3.0, WAVE[:, 0]), abs=0.05)


def test_drawing_goes_on_from_the_current_point():
    ahead = WAVE[1:] + [5.0, 2.0]
    drawn = (
        host.Workplane("YZ").moveTo(*(WAVE[0] + [5.0, 2.0])).fitSpline(ahead, 0.01, effort="fast", includeCurrent=True)
    )
    assert drawn.val().startPoint().toTuple() == pytest.approx((0, 5, 2))
    lifted = host.Workplane("XY").pushPoints([(0, 0, 3)]).localSpline([(1, 0), (2, 1), (3, 0)], includeCurrent=True)
    assert lifted.val().startPoint().toTuple() == pytest.approx((0, 0, 3))
    shape = host.Workplane().lineTo(5, 0).fitSpline([(5.5, 1), (5, 2)], 1e-3, includeCurrent=True).lineTo(0, 2)
    assert shape.close().extrude(1).val().isValid()


@pytest.mark.parametrize("name", DRAWN)
def test_construction_and_wires_as_in_spline(name):
    extra = (0.01,) if name == "fitSpline" else ()
    edges = getattr(host.Workplane(), name)(WAVE, *extra)
    assert [type(each) for each in edges.ctx.pendingEdges] == [cq.Edge]
    reference = getattr(host.Workplane(), name)(WAVE, *extra, forConstruction=True)
    assert reference.ctx.pendingEdges == []
    assert reference.val().forConstruction
    wire = getattr(host.Workplane(), name)(WAVE, *extra, makeWire=True)
    assert isinstance(wire.val(), cq.Wire)
    assert (len(wire.ctx.pendingWires), wire.ctx.pendingEdges) == (1, [])
    quiet = getattr(host.Workplane(), name)(WAVE, *extra, makeWire=True, forConstruction=True)
    assert (quiet.ctx.pendingWires, quiet.val().forConstruction) == ([], True)
    tagged = edges.tag("wave").box(1, 1, 1).edges(tag="wave")
    assert tagged.size() == 1


def test_splines_through_points():
    for edge in (
        host.Workplane().cardinalSpline(OVAL, curvature=1.0, closed=True).val(),
        host.Workplane().localSpline(OVAL, "chord", closed=True).val(),
    ):
        assert edge.IsClosed()
        assert host.from_edge(edge).nearest(np.column_stack([OVAL, 0 * OVAL[:, :1]]))[1].max() < 1e-12


# Profiles


@pytest.mark.parametrize("plane", PLANES)
def test_a_profile_is_drawn_at_each_point_of_the_stack(plane):
    drawn = host.Workplane(plane).pushPoints([(0, 0), (60, 5)]).fitProfile(OVAL, 0.01, [OVAL / 2], effort="fast")
    assert [type(each) for each in drawn.vals()] == [cq.Wire] * 4
    assert all(wire.isValid() and wire.IsClosed() for wire in drawn.vals())
    part = drawn.extrude(2)
    assert part.val().isValid()
    assert volume(part.val()) == pytest.approx(4 * RING, rel=2e-3)
    for place, solid in zip([(0, 0), (60, 5)], part.solids().vals(), strict=True):
        seen = np.array([drawn.plane.toLocalCoords(vertex).toTuple() for vertex in solid.tessellate(0.005)[0]])
        middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))  # the kernel's centres of mass are rough
        assert middle == pytest.approx((*place, 1.0), abs=0.015)


@pytest.mark.slow
def test_profiles_revolve_sweep_loft_and_offset():
    ring = host.Workplane("XZ").center(60, 0).fitProfile(OVAL, 0.01, effort="fast")
    torus = ring.revolve(360, (-60, 0), (-60, 1)).val()
    assert volume(torus) == pytest.approx(2 * np.pi * 60 * np.pi * 24 * 12, rel=2e-3)
    swept = host.Workplane().fitProfile(OVAL, 0.01, [OVAL / 2], effort="fast").sweep(cq.Workplane("XZ").lineTo(0, 30))
    assert volume(swept.val()) == pytest.approx(30 * RING, rel=2e-3)
    lofted = (
        host.Workplane()
        .fitProfile(OVAL, 0.01, effort="fast")
        .workplane(10)
        .fitProfile(OVAL / 2, 0.005, effort="fast")  # the same knots: a loft joins equal parameters
        .loft()
    )
    assert lofted.val().isValid()
    assert volume(lofted.val()) == pytest.approx(10 / 3 * np.pi * 24 * 12 * 1.75, rel=5e-3)
    assert host.Workplane().fitProfile(OVAL, 0.01, effort="fast").offset2D(-1).extrude(1).val().isValid()
    assert (
        host.Workplane().rect(99, 99).extrude(5).fitProfile(SIDES, 0.01, effort="fast", between="polyline").cutThruAll()
    )


def test_a_profile_of_vertices_stays_where_it_is():
    there = [cq.Vertex.makeVertex(*p, 5.0) for p in OVAL.tolist()]
    drawn = host.Workplane("XZ", origin=(1, 2, 3)).pushPoints([(7, 7)]).fitProfile(there, 0.01, effort="fast")
    assert drawn.size() == 1
    assert drawn.val().Center().toTuple() == pytest.approx((0, 0, 5), abs=0.02)
    assert drawn.ctx.pendingWires[0].Center().toTuple() == pytest.approx((0, 0, 5), abs=0.02)


def test_profiles_for_construction_and_corners_keep_their_edges():
    drawn = host.Workplane().fitProfile(SQUARE, 0.01, effort="fast", forConstruction=True)
    assert drawn.ctx.pendingWires == []
    assert drawn.val().forConstruction
    assert len(drawn.val().Edges()) == 4
    smooth = host.Workplane().fitProfile(OVAL, 0.01, effort="fast", corners=[0, 20, 40])
    assert len(smooth.val().Edges()) == 3


def test_sketches_add_cut_and_tag_profiles():
    plate = host.Sketch().rect(100, 100).fitProfile(OVAL, 0.01, effort="fast", mode="s")
    assert plate._faces.Area() == pytest.approx(1e4 - np.pi * 24 * 12, rel=1e-3)
    turned = (
        host.Sketch().push([(0, 0), (60, 0)]).fitProfile(OVAL, 0.01, [OVAL / 2], effort="fast", angle=90, tag="ring")
    )
    assert turned._faces.Area() == pytest.approx(2 * RING, rel=2e-3)
    assert turned._faces.BoundingBox().ylen == pytest.approx(48, rel=1e-3)
    assert len(turned.reset().select("ring").vals()) == 2
    part = host.Workplane("YZ").placeSketch(turned).extrude(1)
    assert part.val().isValid()


def test_a_face_has_the_area_of_its_polygon():
    x, y = OVAL.T
    polygon = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    around = np.linalg.norm(np.diff(np.vstack([OVAL, OVAL[:1]]), axis=0), axis=1).sum()
    face = host.fit_face(OVAL, 0.04, between="polyline", effort="fast")
    assert abs(face.Area() - polygon) <= 0.04 * around


@pytest.mark.parametrize(
    ("holes", "says"),
    [
        ([SIDES / 2 + 0.5, SIDES / 2 + 1], "hole 0 crosses or touches hole 1 at"),
        ([SIDES / 2 + 100], "hole 0 is outside the outer curve"),
        (SIDES, "hole 0: points must have the shape"),
        ([SIDES / 2 + 0.5, [(1, 1), (2, 2)]], "hole 1: a closed curve needs at least 3"),
    ],
)
def test_what_is_wrong_with_holes_is_said(holes, says):
    for call in (host.fit_face, host.Workplane().fitProfile, host.Sketch().fitProfile, host.fit_profile):
        with pytest.raises(ValueError, match=says):
            call(SIDES, 0.01, holes, between="polyline", effort="fast")


# Tubes


HELIX = np.column_stack([8 * np.cos(np.linspace(0, 9, 90)), 8 * np.sin(np.linspace(0, 9, 90)), np.linspace(0, 20, 90)])


@pytest.mark.parametrize("plane", PLANES[1:])
def test_a_tube_stands_where_its_points_are(plane):
    base = host.Workplane(plane)
    tube = base.fitTube(HELIX, 1.5, 0.01, effort="fast").val()
    assert tube.isValid()
    length = cadfit.fit(HELIX, 0.01, effort="fast").spline.length()
    assert volume(tube) == pytest.approx(np.pi * 2.25 * length, rel=1e-3)
    start = base.plane.toWorldCoords(tuple(HELIX[0]))
    assert cq.Vertex.makeVertex(*start.toTuple()).distance(tube) < 0.02


def test_a_tube_joins_or_cuts_what_is_there():
    block = host.Workplane().box(30, 30, 30)
    whole = block.val().Volume()
    added = block.faces(">Z").workplane().fitTube([(0, 0, 0), (0, 0, 9), (0, 0, 20)], 2.0, 0.01)
    assert added.solids().size() == 1
    assert volume(added.val()) == pytest.approx(whole + np.pi * 80, rel=1e-4)
    drilled = block.fitTube([(0, 0, -30), (0, 0, 0), (0, 0, 30)], 2.0, 0.01, combine="cut")
    assert volume(drilled.val()) == pytest.approx(whole - np.pi * 120, rel=1e-4)
    rounded = host.Workplane().fitTube([(0, 0, 0), (0, 0, 5), (0, 0, 9)], 2.0, 0.01, caps="round")
    assert volume(rounded.val()) == pytest.approx(np.pi * (36 + 32 / 3), rel=1e-4)
    assert volume(host.fit_tube([(0, 0), (5, 0, 0), (9, 0)], 2.0, 0.01, caps="round")) == pytest.approx(
        volume(rounded.val()), rel=1e-6
    )
    apart = block.fitTube([(0, 0, -30), (0, 0, 0), (0, 0, 30)], 2.0, 0.01, thickness=0.5, combine=False)
    assert volume(apart.val()) == pytest.approx(60 * np.pi * (4 - 2.25), rel=1e-4)
    drawn = host.Workplane("YZ").lineTo(5, 0).fitTube([(9, 0), (15, 0)], 1.0, 0.01, includeCurrent=True)
    assert volume(drawn.val()) == pytest.approx(10 * np.pi, rel=1e-4)
    assert host.fit_tube(OVAL, 1.0, 0.01, closed=True, effort="fast").isValid()


@pytest.mark.slow
def test_a_tube_too_thick_for_its_path_is_an_error_that_says_where():
    for call in (host.fit_tube, host.Workplane().fitTube):
        with pytest.raises(ValueError, match=r"^no tube: it passes .* near \(.*a radius below [78]\."):
            call(HELIX, 20.0, 0.01, effort="fast")


# invoke


def test_invoke_draws_on_workplanes_and_in_sketches_and_reports_the_fit():
    outline = host.fit_spline(OVAL, 0.01, effort="fast", closed=True, tag="outline")
    assert outline.fit.deviation.points <= 0.01
    base = cq.Workplane("XZ").invoke(outline)
    assert type(base) is cq.Workplane
    assert volume(base.close().extrude(5).val()) == pytest.approx(np.pi * 24 * 12 * 5, rel=2e-3)
    assert base.edges(tag="outline").size() == 1
    sketch = cq.Sketch().invoke(outline).assemble()
    assert sketch.val().isValid()
    assert sketch._faces.Area() == pytest.approx(np.pi * 24 * 12, rel=1e-3)
    ring = host.fit_profile(OVAL, 0.01, [OVAL / 2], effort="fast", tag="ring")
    assert [fit.closed for fit in ring.fits] == [True, True]
    assert cq.Workplane("YZ").invoke(ring).extrude(1).wires(tag="ring").size() == 2
    assert cq.Sketch().invoke(ring)._faces.Area() == pytest.approx(RING, rel=2e-3)
    ready = cq.Workplane().invoke(host.draw(cadfit.local_spline(OVAL, closed=True), makeWire=True))
    assert ready.extrude(1).val().isValid()


def test_a_sketch_takes_edges_with_a_tag_and_for_construction():
    sketch = (
        host.Sketch()
        .fitSpline(SQUARE, 0.01, effort="fast", tag="outline")
        .fitSpline(WAVE, 0.01, effort="fast", forConstruction=True)
    )
    assert sketch.select("outline").vals() == sketch._edges[:4]
    assert [edge.forConstruction for edge in sketch._edges] == [False] * 4 + [True]
    assert sketch.reset().assemble()._faces.Area() == pytest.approx(12.0)
    mixed = host.Sketch().localSpline(WAVE).segment((10.0, -3.0)).segment((0.0, -3.0)).close().assemble()
    assert mixed._faces.isValid()
    assert host.Sketch().cardinalSpline(OVAL, closed=True).assemble()._faces.Area() > 800


# register


def test_nothing_is_added_on_import():
    assert not any(name in names for name in NAMES for names in OWN.values())


def test_register_adds_methods_that_chain():
    host.register()
    host.register()  # again: nothing changes
    part = cq.Workplane("XZ").fitSpline(OVAL, 0.01, effort="fast", closed=True).close().extrude(5)
    assert type(part) is cq.Workplane
    assert (
        part.faces("<Y")
        .workplane()
        .sketch()
        .fitSpline(OVAL / 2, 0.01, effort="fast", closed=True)
        .assemble()
        .finalize()
    )
    assert cq.Workplane().localSpline(WAVE).cardinalSpline(WAVE).size() == 1


def test_register_never_replaces_a_method(monkeypatch):
    monkeypatch.setattr(cq.Workplane, "localSpline", lambda self: self, raising=False)
    with pytest.raises(ValueError, match=r"Workplane already has a localSpline"):
        host.register()
    assert not hasattr(cq.Workplane, "fitSpline")
    assert not hasattr(cq.Sketch, "localSpline")
    with pytest.raises(ValueError, match="no method 'spline'"):
        host.register(["spline"])


def test_register_takes_a_choice():
    host.register(["fitSpline"])
    assert hasattr(cq.Workplane, "fitSpline")
    assert not hasattr(cq.Workplane, "localSpline")


# Exports


@pytest.fixture(scope="module")
def ring():
    return host.fit_profile(OVAL, 0.01, [OVAL / 2], effort="fast")


def test_step_keeps_poles_and_knots(tmp_path):
    fit = cadfit.fit(SQUARE * 7.3, 0.01, effort="fast")
    cq.exporters.export(cq.Workplane(obj=host.to_wire(fit)), str(tmp_path / "wire.step"))
    back = [host.from_edge(edge) for edge in cq.importers.importStep(str(tmp_path / "wire.step")).edges().vals()]
    assert len(back) == len(fit.curves)
    for curve in fit.curves:
        same = min(back, key=lambda other: np.abs(other.poles[0, :2] - curve.poles[0]).max())
        assert np.abs(same.poles[:, :2] - curve.poles).max() < 1e-11
        assert np.abs(same.knots - curve.knots).max() < 1e-11


@pytest.mark.slow
def test_solids_come_back_from_step_and_stl(tmp_path, ring):
    part = cq.Workplane("XZ").invoke(ring).extrude(5)
    for name in ("part.step", "part.stl"):
        cq.exporters.export(part, str(tmp_path / name), tolerance=0.001, angularTolerance=0.02)
    again = cq.importers.importStep(str(tmp_path / "part.step")).val()
    assert again.isValid()
    assert volume(again) == pytest.approx(volume(part.val()), rel=1e-7)
    mesh = trimesh.load_mesh(tmp_path / "part.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(volume(part.val()), rel=1e-3)


def test_dxf_and_svg_hold_the_outline(tmp_path, ring):
    drawn = cq.Workplane().invoke(ring)
    cq.exporters.export(cq.Workplane(obj=host.to_face(ring.fits[0], ring.fits[1:])), str(tmp_path / "ring.dxf"))
    face = cq.importers.importDXF(str(tmp_path / "ring.dxf")).faces().val()
    assert face.isValid()
    assert len(face.innerWires()) == 1
    assert volume(cq.Workplane(obj=face).wires().toPending().extrude(1).val()) == pytest.approx(RING, rel=2e-3)
    cq.exporters.export(drawn.extrude(1), str(tmp_path / "ring.svg"), opt={"projectionDir": (0, 0, 1)})
    assert (tmp_path / "ring.svg").read_text(encoding="utf-8").count("<path") >= 2


# Pages


@pytest.mark.slow
def test_the_readmes_lines_for_cadquery_run(tmp_path, monkeypatch):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    [code] = [block for block in blocks if "cadquery" in block]
    assert len([line for line in code.splitlines() if line.strip()]) <= 10
    shown = []
    monkeypatch.setattr("cadquery.vis.show", shown.append)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    [wing] = shown
    assert wing.val().isValid()
    assert len(wing.faces().vals()) == 3
    again = cq.importers.importStep("wing.step")
    assert volume(again.val()) == pytest.approx(volume(wing.val()), rel=1e-6)


# Errors


@pytest.mark.parametrize(
    ("points", "tolerance", "says"),
    [
        ([(0, 0), (1, float("nan")), (2, 0)], 0.1, "row 1 of the points is not finite"),
        ([(0, 0), (1, 1)], 0.0, "tolerance must be at least"),
        ([(0, 0), "one"], 0.1, "row 1 of the points is not a row of numbers"),
        ([(0, 0), (0, 0)], 0.1, "at least 2 distinct points"),
        ([(0, 0, 0, 0), (1, 1, 1, 1)], 0.1, "2D or 3D, not in 4D"),
        ("points", 0.1, "points must be a list of points"),
    ],
)
def test_what_is_wrong_is_a_value_error_everywhere(points, tolerance, says):
    calls = (host.fit_edge, host.fit_wire, host.Workplane().fitSpline, host.Sketch().fitSpline)
    for call in calls:
        with pytest.raises(ValueError, match=says):
            call(points, tolerance)


@pytest.mark.parametrize(
    "drawing",
    [
        "cq.Workplane('XZ').fitSpline(bad, 0.1)",
        "cq.Workplane().box(1, 1, 1).faces('>Z').workplane().fitProfile(bad, 0.1).cutThruAll()",
        "cq.Workplane().fitTube(bad, 0.1, 0.1)",
        "cq.Workplane().pushPoints([(0, 0)]).each(lambda at: fit_edge(bad, 0.1))",
        "cq.Workplane().pushPoints([(0, 0)]).eachpoint(lambda at: fit_edge(bad, 0.1).moved(at))",
        "cq.Workplane().invoke(lambda base: base.localSpline(bad))",
        "cq.Workplane().invoke(fit_spline(bad, 0.1))",
        "cq.Workplane().sketch().fitProfile(bad, 0.1).finalize().extrude(1)",
        "cq.Sketch().push([(0, 0)]).each(lambda at: cq.Sketch().fitProfile(bad, 0.1).moved(at))",
        "cq.Sketch().invoke(lambda sketch: sketch.cardinalSpline(bad))",
    ],
)
def test_errors_show_where_the_host_catches_them(drawing):
    script = "from cadfit.cadquery import fit_edge, fit_spline, register\n"
    script += f"register()\nbad = [(0, 0), (1, float('nan')), (2, 0)]\nshow_object({drawing})"
    built = cqgi.parse(script).build()  # as the host's editor runs scripts, whatever they raise
    assert not built.success
    assert type(built.exception) is ValueError
    assert str(built.exception).startswith("row 1 of the points is not finite")


def test_corners_make_no_single_edge():
    with pytest.raises(ValueError, match="4 curves, split at corners"):
        host.fit_edge(SQUARE, 0.01, effort="fast", corners="auto")


def test_without_cadquery_the_message_names_the_extra(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("cadfit.cadquery")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "cadquery", None)
    with pytest.raises(ImportError, match=r"pip install 'cadfit\[cadquery\]'"):
        importlib.import_module("cadfit.cadquery")


# Types


USER = """
import cadquery as cq
import numpy as np

from cadfit.cadquery import Sketch, Workplane, draw, fit_edge, fit_spline, to_wire

points = np.zeros((5, 2))
outline = fit_spline(points, 0.1, closed=True)
reveal_type(cq.Workplane().invoke(outline))
reveal_type(outline.fit.deviation.points)
reveal_type(Workplane().fitSpline([(0, 0), (1, 1)], 0.1, makeWire=True).extrude(1))
reveal_type(Sketch().fitSpline([cq.Vector(0, 0), cq.Vector(1, 1)], 0.1).assemble())
reveal_type(fit_edge([(0.0, 0.0), (1.0, 1.0)], 0.1))
reveal_type(to_wire(outline.fit))
Workplane().fitSpline(points, 0.1, betwen="curve")
fit_edge(points, "0.1", effort="bst")
fit_edge("points", 0.1)
"""


@pytest.mark.slow
def test_a_users_script_has_types(tmp_path):
    api = pytest.importorskip("mypy.api")
    (tmp_path / "user.py").write_text(USER, encoding="utf-8")
    said, wrong, _ = api.run(["--strict", "--cache-dir", str(tmp_path), str(tmp_path / "user.py")])
    assert not wrong
    revealed = [line.split('"')[1] for line in said.splitlines() if "Revealed type" in line]
    assert revealed == [
        "cadquery.cq.Workplane",
        "float",
        "cadfit.cadquery.workplane.Workplane",
        "cadfit.cadquery.sketch.Sketch",
        "cadquery.occ_impl.shapes.Edge",
        "cadquery.occ_impl.shapes.Wire",
    ]
    errors = [line for line in said.splitlines() if ": error:" in line]
    assert [line.rsplit("[", 1)[1] for line in errors] == ["call-arg]", *["arg-type]"] * 3], said


def test_vertices_from_a_generator_are_where_they_are():
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = [cq.Vertex.makeVertex(10 * np.cos(a), 5.0, 6 * np.sin(a)) for a in turn]
    draw = [
        lambda points: host.Workplane("XZ").fitSpline(points, 0.01, closed=True),
        lambda points: host.Workplane("XZ").fitProfile(points, 0.01),
        lambda points: cq.Workplane("XZ").invoke(host.fit_spline(points, 0.01, closed=True)),
        lambda points: cq.Workplane("XZ").invoke(host.fit_profile(points, 0.01)),
    ]
    for each in draw:
        box = each(vertex for vertex in ring).val().BoundingBox()
        assert (box.ymin, box.ymax) == pytest.approx((5.0, 5.0), abs=1e-6)
    places = (cq.Location(vertex.Center()) for vertex in ring)
    assert len(host.fit_edge(places, 0.01, closed=True).Edges()) == 1
