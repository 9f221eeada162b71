"""cadfit in build123d: in its builders, in algebra mode, with its types, and what its users are told."""

# ruff: noqa: E402  the host can be imported only once it is known to be there

from __future__ import annotations

import copy
import importlib
import inspect
import pydoc
import re
import sys
import types
from pathlib import Path

import numpy as np
import pytest
import trimesh

b3d = pytest.importorskip("build123d", reason="needs build123d: install cadfit[build123d]")

import ezdxf

import cadfit
from cadfit.build123d import (
    CardinalSpline,
    FitProfile,
    FitSpline,
    FitTube,
    LocalSpline,
    from_edge,
    simplify,
    to_edge,
    to_face,
    to_wire,
)
from cadfit.occt import volume

ROOT = Path(__file__).parents[2]
TURN = np.linspace(0, 2 * np.pi, 60, endpoint=False)
RING = np.column_stack([5 * np.cos(TURN), 3 * np.sin(TURN)])
ARC = np.column_stack([TURN, np.sin(TURN)])
SQUARE = [(0, 0), (4, 0), (4, 3), (0, 3), (0, 0)]
PLANES = {
    "XY": b3d.Plane.XY,
    "XZ": b3d.Plane.XZ,
    "tilted": b3d.Plane(origin=(1, 2, 3), x_dir=(1, 1, 0), z_dir=(1, -1, 2)),
}


def ends(wire):
    return np.array([tuple(wire @ 0), tuple(wire @ 1)])


def on(plane, points):
    return np.array([tuple(plane.from_local_coords(tuple(point))) for point in points])


LINES = {
    "FitSpline": lambda **options: FitSpline(ARC, 0.01, effort="fast", **options),
    "CardinalSpline": lambda **options: CardinalSpline(ARC, 0.5, 1.0, **options),
    "LocalSpline": lambda **options: LocalSpline(ARC, **options),
}


def drawings(make, plane):
    """Return the ends of what is drawn, in builders and without, as the object and as the builder's product."""
    with b3d.BuildLine(plane) as line:
        drawn = make()
    with b3d.BuildLine(plane) as elsewhere, b3d.Locations((1, 2)):
        moved = make()
    with b3d.BuildPart() as part:
        with b3d.BuildSketch(plane):
            with b3d.BuildLine():
                curve = make()
                b3d.Line(curve @ 1, curve @ 0)
            b3d.make_face()
        b3d.extrude(amount=1)
    placed = [plane * make(), plane.location * b3d.Pos(1, 2) * make(), plane * b3d.Rot(0, 0, 30) * make()]
    box = part.part.bounding_box()
    found = [drawn, line.line.edges()[0], moved, elsewhere.line.edges()[0], *placed]
    return np.array([*(ends(each) for each in found), [tuple(box.min), tuple(box.max)]])


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("kind", LINES)
def test_lines_are_placed_as_the_hosts_own(kind, plane):
    found = drawings(LINES[kind], PLANES[plane])
    hosts = drawings(lambda: b3d.Spline(*[tuple(place) for place in ARC.tolist()]), PLANES[plane])
    assert found[:-1] == pytest.approx(hosts[:-1], abs=1e-9)
    assert found[-1] == pytest.approx(hosts[-1], abs=0.02)
    assert found[1] == pytest.approx(on(PLANES[plane], ARC[[0, -1]]), abs=1e-9)
    assert found[4] == pytest.approx(on(PLANES[plane], ARC[[0, -1]]), abs=1e-9)


@pytest.mark.parametrize("kind", LINES)
def test_every_mode_of_a_line(kind):
    with b3d.BuildLine() as line:
        LINES[kind](mode=b3d.Mode.PRIVATE)
        assert line.line is None or not line.line.edges()
        LINES[kind](mode=b3d.Mode.ADD)
        assert len(line.line.edges()) == 1
        b3d.Line((20, 0), (30, 0))
        LINES[kind](mode=b3d.Mode.REPLACE)
        assert len(line.line.edges()) == 1
        LINES[kind](mode=b3d.Mode.SUBTRACT)
        assert line.line is None or not line.line.edges()


def test_a_profile_in_every_mode():
    with b3d.BuildSketch(b3d.Plane.XZ) as sketch:
        b3d.Rectangle(20, 20)
        FitProfile(RING, 0.01, effort="fast", mode=b3d.Mode.SUBTRACT)
        assert sketch.sketch.area == pytest.approx(400 - 15 * np.pi, rel=1e-3)
        FitProfile(RING, 0.01, effort="fast", mode=b3d.Mode.ADD)
        assert sketch.sketch.area == pytest.approx(400, rel=1e-6)
        FitProfile(RING, 0.01, effort="fast", mode=b3d.Mode.INTERSECT)
        assert sketch.sketch.area == pytest.approx(15 * np.pi, rel=1e-3)
        FitProfile(2 * RING, 0.01, [RING], effort="fast", mode=b3d.Mode.REPLACE)
        FitProfile(3 * RING, 0.01, mode=b3d.Mode.PRIVATE)
    (face,) = sketch.sketch.faces()
    assert face.area == pytest.approx(45 * np.pi, rel=1e-3)
    assert abs(face.normal_at().dot(b3d.Plane.XZ.z_dir)) == pytest.approx(1.0)
    assert face.is_valid


def test_profiles_become_parts():
    with b3d.BuildPart() as part:
        with b3d.BuildSketch():
            profile = FitProfile(2 * RING, 0.01, [RING], effort="fast")
        b3d.extrude(amount=2)
    area = 45 * np.pi
    assert [len(profile.fit.curves), len(profile.hole_fits)] == [1, 1]
    assert volume(part.part.solid().wrapped) == pytest.approx(2 * area, rel=2e-3)
    assert part.part.is_valid
    whole = FitProfile(RING, 0.01, effort="fast")
    for solid, height in [
        (b3d.extrude(whole, 2), 2),
        (b3d.revolve(b3d.Pos(20, 0) * whole, b3d.Axis.Y), 2 * np.pi * 20),
        (b3d.loft([whole, b3d.Pos(0, 0, 4) * whole]), 4),
        (b3d.sweep(b3d.Plane.XZ * whole, path=b3d.Line((0, 0), (0, 7))), 7),
    ]:
        assert solid.is_valid
        assert abs(solid.volume) == pytest.approx(height * whole.area, rel=1e-2)


def test_a_profile_turned_and_aligned():
    turned = FitProfile(RING + [50, 0], 0.01, rotation=90, align=b3d.Align.CENTER, effort="fast")
    box = turned.bounding_box()
    assert tuple(box.size)[:2] == pytest.approx((6, 10), abs=0.05)
    assert tuple(box.center())[:2] == pytest.approx((0, 0), abs=1e-6)
    clockwise = FitProfile(RING[::-1], 0.01, effort="fast")
    assert pytest.approx(1) == clockwise.faces()[0].normal_at().Z


def test_a_tube_in_every_mode():
    path = np.column_stack([TURN, np.sin(TURN), np.zeros(60)])
    with b3d.BuildPart(b3d.Plane.YZ) as part:
        tube = FitTube(path, 0.2, 0.01, effort="fast")
    assert tube.is_valid
    assert part.part.volume == pytest.approx(np.pi * 0.04 * tube.fit.spline.length(), rel=1e-3)
    assert part.part.bounding_box().size.X < 0.5, "the path lies in YZ"
    with b3d.BuildPart() as part:
        b3d.Box(30, 30, 30)
        FitTube(path, 0.2, 0.01, effort="fast", mode=b3d.Mode.SUBTRACT)
    assert part.part.volume == pytest.approx(27000 - tube.volume, rel=1e-6)
    hollow = FitTube([(0, 0, 0), (0, 0, 5)], 1.0, 0.001, thickness=0.25)
    assert hollow.volume == pytest.approx(np.pi * (1 - 0.75**2) * 5, rel=1e-3)
    rounded = FitTube([(0, 0, 0), (0, 0, 5)], 1.0, 0.001, caps="round")
    assert rounded.volume == pytest.approx(np.pi * (5 + 4 / 3), rel=1e-3)
    with pytest.raises(ValueError, match="round caps are for what has no holes"):
        FitTube([(0, 0, 0), (0, 0, 5)], 1.0, 0.001, thickness=0.25, caps="round")
    with pytest.raises(ValueError, match=r"^no tube: it passes .* a radius below"):
        FitTube(RING / 5, 1.5, 0.001, closed=True)


def test_points_of_every_kind_give_the_same():
    wanted = from_edge(FitSpline(ARC, 0.01, effort="fast").edge()).poles
    vectors = [b3d.Vector(*place) for place in ARC.tolist()]
    vertices = b3d.ShapeList(b3d.Vertex(*place, 0) for place in ARC.tolist())
    for points in (
        vectors,
        vertices,
        ARC.tolist(),
        [tuple(p) for p in ARC.tolist()],
        iter(vectors),
        [*vectors[:9], *ARC[9:]],
        [(*ARC[0].tolist(), 0.0), *ARC[1:].tolist()],
    ):
        assert np.array_equal(from_edge(FitSpline(points, 0.01, effort="fast").edge()).poles, wanted)


def test_corners_make_edges_and_the_fit_says_what_was_done():
    drawn = FitSpline([*SQUARE[:2], SQUARE[1], *SQUARE[2:]], 0.01, between="polyline")
    assert isinstance(drawn, b3d.Wire)
    assert [len(drawn.edges()), drawn.is_closed, drawn.is_valid] == [4, True, True]
    assert [drawn.fit.corners.tolist(), drawn.fit.cleaned.tolist()] == [[0, 1, 2, 3], [2]]
    bent = FitSpline(ARC, 0.01, tangents=[(0, 1), (0, -1)], effort="fast")
    assert tuple(bent % 0) == pytest.approx((0, 1, 0), abs=1e-9)
    lifted = FitSpline(ARC, 0.01, tangents=[(0, 1, 1), (0, -1, 0)], effort="fast")
    assert pytest.approx(np.sqrt(0.5)) == (lifted % 0).Z
    assert CardinalSpline(SQUARE).is_closed
    assert LocalSpline(SQUARE).fit.closed
    assert not LocalSpline(SQUARE, closed=False, parametrization="chord").fit.closed


def test_what_passes_through_points_says_so():
    for closed in (False, True):
        for drawn in (CardinalSpline(RING, closed=closed), LocalSpline(RING, closed=closed)):
            assert drawn.fit.deviation.points < 1e-12
            assert drawn.fit.spline(drawn.fit.parameters) == pytest.approx(drawn.fit.points, abs=1e-12)
            again = cadfit.deviation(drawn.fit.spline, drawn.fit.points, closed)
            assert drawn.fit.deviation.between == pytest.approx(again.between, rel=1e-2)


def test_edges_and_wires_are_refitted():
    spline = b3d.Spline(*[tuple(p) for p in (3 * ARC).tolist()])
    light = FitSpline(spline, 0.01)
    assert len(from_edge(light.edge()).poles) < len(from_edge(spline).poles) / 3
    assert light.fit.deviation.between <= 0.01
    assert simplify(spline, 0.01, "fast").poles < 20
    with pytest.raises(ValueError, match="go with points: an edge or a wire has its own"):
        FitSpline(spline, 0.01, closed=True)
    with pytest.raises(ValueError, match="go with points: an edge or a wire has its own"):
        FitSpline(spline, 0.01, corners=np.array([1, 2]))
    disc = FitProfile(b3d.Edge.make_circle(5), 0.001, [b3d.Wire.make_rect(2, 2)])
    assert disc.area == pytest.approx(25 * np.pi - 4, abs=0.001 * 10 * np.pi)
    assert pytest.approx(1) == disc.faces()[0].normal_at().Z
    with pytest.raises(ValueError, match="the outer curve is not closed"):
        FitProfile(b3d.Line((0, 0), (1, 1)), 0.001)
    bar = FitTube(b3d.Polyline((0, 0), (9, 0), (9, 5)), 0.5, 0.001)
    assert bar.volume == pytest.approx(np.pi / 4 * 14, rel=1e-2)


def test_objects_are_copied_and_moved_with_their_fit():
    drawn = FitSpline(ARC, 0.01, effort="fast")
    for other in (copy.copy(drawn), copy.deepcopy(drawn), drawn.moved(b3d.Pos(1, 0, 0)), b3d.Pos(1, 0, 0) * drawn):
        assert other.fit.poles == drawn.fit.poles
        assert np.array_equal(other.fit.spline.poles, drawn.fit.spline.poles)
    assert isinstance(drawn, b3d.Wire)
    assert isinstance(LocalSpline(ARC), b3d.Edge)
    assert isinstance(FitProfile(RING, 0.1), b3d.Sketch)
    assert isinstance(FitTube(ARC, 0.1, 0.01), b3d.Part)


def test_curves_there_and_back():
    fit = cadfit.fit(ARC, 0.01)
    assert np.array_equal(from_edge(to_edge(fit)).knots, fit.spline.knots)
    assert to_wire(fit).length == pytest.approx(fit.spline.length(), rel=1e-5)
    assert to_face(cadfit.fit(RING, 0.01, closed=True)).area == pytest.approx(15 * np.pi, rel=1e-2)


def test_users_are_told_what_is_wrong():
    for call, message in [
        (lambda: FitSpline([(0, 0)], 0.1), "at least 2 points"),
        (lambda: FitSpline([(0, 0), (1, float("nan"))], 0.1), "row 1 of the points is not finite"),
        (lambda: FitSpline([(0, 0), "x"], 0.1), "row 1"),
        (lambda: FitSpline(ARC, -1.0), "the tolerance must be at least"),
        (lambda: FitSpline(ARC, 0.1, between="line"), "between must be one of"),
        (lambda: FitSpline(b3d.Face.make_rect(1, 1), 0.1), "points must be a list|is not a point"),
        (lambda: FitSpline([b3d.Line((0, 0), (1, 1))], 0.1), "row 0 of the points is not a point: Line"),
        (lambda: CardinalSpline([(0, 0), (1, 1)], tension=float("inf")), "the tension must be"),
        (lambda: LocalSpline([(0, 0), (0, 0)]), "at least 2 distinct points"),
        (lambda: FitProfile(ARC[:, [0, 1, 1]], 0.1), r"the outline leaves the sketch's plane: row 1 .* plane \* Fit"),
        (lambda: FitProfile(RING, 0.1, [RING + 50]), "hole 0 is outside the outer curve"),
        (lambda: FitProfile(RING, 0.1, [[(0, 0)]]), "hole 0: at least 2 points"),
        (lambda: FitTube(ARC, -1.0, 0.1), "above zero"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()


@pytest.mark.parametrize("builder", [b3d.BuildLine, b3d.BuildSketch, b3d.BuildPart])
def test_errors_show_through_builders(builder):
    made = {b3d.BuildLine: FitSpline, b3d.BuildSketch: FitProfile, b3d.BuildPart: lambda p, t: FitTube(p, 1.0, t)}
    with pytest.raises(ValueError, match="row 2 of the points is not finite"), builder(b3d.Plane.XZ):
        made[builder]([(0, 0), (1, 0), (1, float("inf"))], 0.1)
    with pytest.raises(RuntimeError, match="doesn't have a FitTube"), b3d.BuildLine():  # the host's own words
        FitTube([(0, 0), (1, 1)], 0.1, 0.1)


def test_errors_show_through_builders_in_builders():
    says = "row 1 of the points is not finite"
    with pytest.raises(ValueError, match=says), b3d.BuildPart(), b3d.BuildSketch(b3d.Plane.XZ), b3d.BuildLine():
        LocalSpline([(0, 0), (1, float("nan"))])


# The same edge


def outline():
    """An outline with a corner, and the face inside it."""
    turn = np.linspace(0, 1.5 * np.pi, 80)
    arc = 20 * np.column_stack([np.cos(turn), np.sin(turn)])
    drawn = FitSpline([*arc, (0, 0), arc[0]], 0.01, corners=[0, 79, 80], closed=True, effort="fast")
    assert len(drawn.fit.curves) == 3
    return drawn


def test_poles_and_knots_reach_the_kernel_unchanged():
    near = np.nextafter(1.0, 2.0) + 1e-9  # the host's own make_bspline would merge these knots
    spline = cadfit.BSpline(np.random.default_rng(0).normal(size=(6, 3)), [0, 0, 0, 0, 1, near, 2, 2, 2, 2])
    assert np.array_equal(from_edge(to_edge(spline)).knots, spline.knots)
    drawn = outline()
    for edge, curve in zip(drawn.edges(), drawn.fit.curves, strict=True):
        assert np.array_equal(from_edge(edge).poles[:, :2], curve.poles)
        assert np.array_equal(from_edge(edge).knots, curve.knots)
        assert edge.geom_adaptor().Continuity().name in ("GeomAbs_C2", "GeomAbs_CN")
    ring = FitSpline(RING, 0.01, closed=True, effort="fast")
    assert [ring.edge().is_closed, ring.is_closed, ring.is_valid] == [True, True, True]
    with b3d.BuildSketch(b3d.Plane.XZ):
        with b3d.BuildLine():
            inner = FitSpline(RING, 0.01, closed=True, effort="fast")
        b3d.make_face()
    assert np.array_equal(from_edge(inner.edge()).poles[:, :2], inner.fit.spline.poles)


def test_step_there_and_back(tmp_path):
    drawn = outline()
    b3d.export_step(drawn, tmp_path / "outline.step")
    back = [from_edge(edge) for edge in b3d.import_step(tmp_path / "outline.step").edges()]
    assert len(back) == 3
    for curve in drawn.fit.curves:
        near = [each for each in back if len(each.poles) == len(curve.poles)]
        assert min(np.abs(each.poles[:, :2] - curve.poles).max() for each in near) < 1e-9
    part = b3d.extrude(b3d.make_face(drawn), 5)
    b3d.export_step(part, tmp_path / "part.step")
    again = b3d.import_step(tmp_path / "part.step")
    assert again.is_valid
    assert again.volume == pytest.approx(part.volume, rel=1e-9)


def test_meshes_there_and_back(tmp_path):
    part = b3d.extrude(b3d.make_face(outline()), 5)
    b3d.export_stl(part, tmp_path / "part.stl", tolerance=0.01, angular_tolerance=0.05)
    mesh = trimesh.load_mesh(tmp_path / "part.stl")
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(0.75 * np.pi * 400 * 5, rel=2e-3)


def test_drawings_there_and_back(tmp_path):
    drawn = outline()
    svg = b3d.ExportSVG()
    svg.add_shape(drawn)
    svg.write(tmp_path / "outline.svg")
    (face,) = b3d.make_face(b3d.import_svg(tmp_path / "outline.svg")).faces()
    assert face.area == pytest.approx(0.75 * np.pi * 400, rel=2e-3)
    dxf = b3d.ExportDXF()
    dxf.add_shape(drawn)
    dxf.write(tmp_path / "outline.dxf")
    splines = [*ezdxf.readfile(tmp_path / "outline.dxf").modelspace().query("SPLINE")]
    whole = cadfit.join(drawn.fit.curves)  # the host writes other poles for the same curve
    for spline in splines:
        places = np.array([tuple(place)[:2] for place in spline.flattening(0.001)])
        assert whole.nearest(places)[1].max() < 1e-6
    assert len(splines) == 3


# Types and pages


USER = """
import numpy as np
from build123d import BuildLine, Edge, Plane, Pos, Vector, Vertex, ShapeList, extrude
from cadfit.build123d import CardinalSpline, FitProfile, FitSpline, FitTube
from cadfit.build123d import from_edge, simplify, to_edge, to_face, to_wire

points = np.zeros((5, 2))
with BuildLine(Plane.XZ):
    drawn = FitSpline(points, 0.1, closed=True)
reveal_type(drawn)
reveal_type(drawn.fit.deviation.points)
reveal_type(drawn.edge())
reveal_type(FitSpline(Edge.make_circle(1), tolerance=0.1).fit.spline)
reveal_type(CardinalSpline([Vector(0, 0), (1, 1)], 0.5, 1.0) @ 0.5)
reveal_type(FitProfile([(0.0, 0.0), (1, 1), (2, 0)], 0.1, [points]).hole_fits)
reveal_type(FitTube(ShapeList([Vertex(0, 0, 0), Vertex(1, 1, 1)]), 0.5, 0.1).volume)
reveal_type(to_wire(simplify(drawn, 0.1)))
reveal_type(to_face(drawn.fit))
reveal_type(from_edge(to_edge(drawn.fit)))
extrude(FitProfile(points, 0.1), amount=2)
FitSpline(points, 0.1, betwen="curve")
FitProfile(points, "0.1", effort="bst")
"""


@pytest.mark.slow
def test_a_users_script_has_types(tmp_path):
    api = pytest.importorskip("mypy.api")
    (tmp_path / "user.py").write_text(USER, encoding="utf-8")
    said, wrong, _ = api.run(["--strict", "--cache-dir", str(tmp_path), str(tmp_path / "user.py")])
    assert not wrong
    revealed = [line.split('"')[1] for line in said.splitlines() if "Revealed type" in line]
    assert revealed == [
        "cadfit.build123d.lines.FitSpline",
        "float",
        "build123d.topology.one_d.Edge",
        "cadfit.bspline.BSpline",
        "build123d.geometry.Vector",
        "tuple[cadfit.fitting.result.Fit, ...]",
        "float",
        "build123d.topology.one_d.Wire",
        "build123d.topology.two_d.Face",
        "cadfit.bspline.BSpline",
    ], said
    errors = [line for line in said.splitlines() if ": error:" in line]
    assert [line.rsplit("[", 1)[1] for line in errors] == ["call-arg]", "arg-type]", "arg-type]"], said


@pytest.mark.parametrize("ours", [FitSpline, CardinalSpline, LocalSpline, FitProfile, FitTube])
def test_help_reads_as_the_hosts_own(ours):
    page = pydoc.plain(pydoc.render_doc(ours))
    kind = {b3d.BaseSketchObject: "Sketch", b3d.BasePartObject: "Part"}.get(ours.__mro__[1], "Line")
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", ours.__name__)
    assert inspect.getdoc(ours).startswith(f"{kind} Object: {words}\n")
    assert re.search(r"\| +Args:\n.*\| +Attributes:\n.*\| +Raises:\n", page, re.DOTALL)
    given = inspect.signature(ours.__init__).parameters
    for name in (name for name in given if name != "self"):
        assert re.search(rf"^ +\| +{name} \(", page, re.MULTILINE), name
        optional = given[name].default is not inspect.Parameter.empty
        entry = page.split(f"{name} (", 1)[1].split(" (", 1)[0]
        assert ("Defaults to" in entry) == optional, name
    assert [*given][-1] == "mode"


def test_names_do_not_hide_the_hosts():
    ours = importlib.import_module("cadfit.build123d").__all__
    assert not [name for name in ours if hasattr(b3d, name)]


def test_without_the_host_the_error_names_the_extra(monkeypatch):
    for name in [name for name in sys.modules if name.startswith("cadfit.build123d")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "build123d", None)
    with pytest.raises(ImportError, match=r"pip install 'cadfit\[build123d\]'"):
        importlib.import_module("cadfit.build123d")


def test_the_readmes_lines_end_in_the_viewer(tmp_path, monkeypatch):
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    [code] = [block for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "cadfit.build123d" in block]
    assert len([line for line in code.splitlines() if line.strip()]) <= 14
    shown = []
    monkeypatch.setitem(sys.modules, "ocp_vscode", types.SimpleNamespace(show=shown.append))
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(code, names)
    assert shown == [names["wing"]]
    part = b3d.import_step(tmp_path / "wing.step")
    assert part.is_valid
    assert names["outline"].fit.poles <= 15
    section = names["outline"].fit.points
    x, y = section.T
    assert pytest.approx(300) == part.bounding_box().size.Y
    area = abs(0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))
    assert max(face.area for face in part.faces().filter_by(b3d.Axis.Y)) == pytest.approx(area, rel=1e-2)
