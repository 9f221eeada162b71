"""Splines to the kernel and back, and the kernel as judge of the curve type."""

# ruff: noqa: E402  the kernel's modules can be imported only once it is known to be there

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
import pytest

OCP = pytest.importorskip("OCP", reason="needs OCP: install cadfit[build123d] or cadfit[cadquery]")

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.GCPnts import GCPnts_AbscissaPoint
from OCP.Geom import Geom_BezierCurve, Geom_BSplineCurve, Geom_Circle
from OCP.GeomAPI import GeomAPI_ProjectPointOnCurve
from OCP.gp import gp_Ax2, gp_Dir, gp_Lin, gp_Pnt, gp_Trsf, gp_Vec
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Edge, TopoDS_Shape

from cadfit import BSpline, cardinal_spline
from cadfit.occt import (
    UNITS,
    KernelError,
    edges,
    exchange,
    from_edge,
    kernel,
    read_brep,
    read_step,
    to_edge,
    to_wire,
    write_brep,
    write_step,
)

CORPUS = Path(os.environ.get("CADFIT_CORPUS", Path(__file__).parents[3] / "shared" / "corpus")) / "dev"


def random_spline(
    multiplicities: list[int], d: int = 3, seed: int = 0, size: float = 1.0, offset: float = 0.0
) -> BSpline:
    """Return a spline with the given interior multiplicities, uneven knots and poles in a box of about `size`."""
    rng = np.random.default_rng([seed, len(multiplicities), d])
    distinct = np.cumsum(rng.uniform(0.1, 3.0, len(multiplicities) + 2)) - 1.7
    knots = np.repeat(distinct, [4, *multiplicities, 4])
    return BSpline(offset + size * rng.normal(size=(len(knots) - 4, d)), knots)


def closed_spline(n: int = 9) -> BSpline:
    angle = np.arange(n) * 2 * np.pi / n
    poles = np.column_stack([3 * np.cos(angle), np.sin(angle), 0.2 * np.cos(2 * angle)])
    return cardinal_spline(poles, closed=True)


SPLINES = {
    "one span": random_spline([]),
    "two spans": random_spline([1]),
    "double knot": random_spline([2]),
    "triple knot": random_spline([3]),
    "mixed": random_spline([1, 3, 2, 1, 1, 3, 2]),
    "many spans": random_spline([1] * 500),
    "in the plane": random_spline([1, 2, 3, 1], d=2),
    "closed": closed_spline(),
    "closed with a corner": BSpline([[0, 0], [3, 1], [1, 3], [0, 0]], [0, 0, 0, 0, 1, 1, 1, 1]),
    "far away": random_spline([1] * 20, offset=6.4e6),
    "small": random_spline([1] * 20, size=1e-3),
    "small and far away": random_spline([1] * 20, size=1e-3, offset=6.4e6),
}


@pytest.fixture(params=SPLINES.values(), ids=SPLINES.keys())
def spline(request: pytest.FixtureRequest) -> BSpline:
    return request.param


def lifted(spline: BSpline) -> BSpline:
    return spline if spline.poles.shape[1] == 3 else spline.transformed(np.eye(3, 2))


def same(a: BSpline, b: BSpline) -> bool:
    """Whether two splines are equal to the last bit."""
    return np.array_equal(a.poles, b.poles) and np.array_equal(a.knots, b.knots)


def kernel_curve(edge) -> Geom_BSplineCurve:
    return BRepAdaptor_Curve(edge).BSpline()


def length(shape) -> float:
    return GCPnts_AbscissaPoint.Length_s(BRepAdaptor_Curve(shape), 1e-10)


# ---- in memory


def test_round_trip_is_exact(spline):
    edge = to_edge(spline)
    curve = kernel_curve(edge)
    assert same(from_edge(edge), lifted(spline))
    assert (curve.Degree(), curve.IsRational(), curve.IsPeriodic()) == (3, False, False)
    assert [*curve.Knots()] == spline.distinct_knots.tolist()
    assert [*curve.Multiplicities()] == spline.multiplicities.tolist()
    assert BRepCheck_Analyzer(edge).IsValid()


def test_the_judge_sees_one_broken_pole(spline):
    poles = spline.poles.copy()
    poles[len(poles) // 2, 0] += 1e-6 * spline.size
    broken = lifted(BSpline(poles, spline.knots))
    back = from_edge(to_edge(spline))
    assert not same(back, broken)
    assert not back.isclose(broken, 1e-7)
    assert back.isclose(lifted(spline), 1e-7)


def test_closed_curve_is_a_closed_edge(spline):
    edge = to_edge(spline)
    ends = TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge)
    assert BRep_Tool.IsClosed_s(edge) is ends[0].IsSame(ends[1]) is spline.closed


@pytest.mark.parametrize("d", [1, 4])
def test_other_dimensions_are_refused(d):
    spline = random_spline([1, 1], d=d)
    for refused in (to_edge, lambda s: to_wire([s]), lambda s: write_step("never.step", s)):
        with pytest.raises(ValueError, match=f"not in {d}D"):
            refused(spline)


def test_one_point_is_refused():
    with pytest.raises(ValueError, match="an edge of 4 poles: the poles all lie within 1e-07"):
        to_edge(BSpline(np.full((4, 3), 2.0), [0, 0, 0, 0, 1, 1, 1, 1]))


def test_kernel_failure_says_what_was_built():
    near = np.nextafter(1.0, 2.0)
    with pytest.raises(KernelError, match=r"an edge of 6 poles: .*[Kk]nots") as caught:
        to_edge(BSpline(np.random.default_rng(0).normal(size=(6, 3)), [0, 0, 0, 0, 1, near, 2, 2, 2, 2]))
    assert isinstance(caught.value, RuntimeError)
    with pytest.raises(ValueError, match=r"an edge of 4 poles \(curve 1\): the poles"):
        to_wire([SPLINES["closed"], BSpline(np.tile(SPLINES["closed"](0.0), (4, 1)), [0, 0, 0, 0, 1, 1, 1, 1])])


# ---- other edges than our own


def agrees(spline: BSpline, edge, reverse: bool = False) -> bool:
    """Whether a spline runs through the same points as an edge's curve, at the edge's parameters."""
    curve = BRepAdaptor_Curve(edge)
    low, high = spline.domain
    assert (low, high) == pytest.approx((curve.FirstParameter(), curve.LastParameter()), abs=1e-12)
    u = np.linspace(low, high, 50)
    place = np.clip(low + high - u if reverse else u, curve.FirstParameter(), curve.LastParameter())
    kernel = np.array([curve.Value(x).Coord() for x in place])
    return bool(np.allclose(spline(u), kernel, rtol=0, atol=1e-12 * (1 + np.abs(kernel).max())))


@pytest.mark.parametrize("name", ["one span", "mixed", "closed"])
def test_trimmed_moved_and_reversed_edges(name):
    spline = SPLINES[name]
    low, high = spline.domain
    part = low + 0.31 * (high - low), low + 0.77 * (high - low)
    trimmed = BRepBuilderAPI_MakeEdge(kernel_curve(to_edge(spline)), *part).Edge()
    turn = gp_Trsf()
    turn.SetRotation(gp_Lin(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 0)).Position(), 0.7)
    turn.SetTranslationPart(gp_Vec(5, -7, 11))
    moved = BRepBuilderAPI_Transform(trimmed, turn).Shape()
    assert from_edge(trimmed).domain == pytest.approx(part, abs=1e-12)
    assert agrees(from_edge(trimmed), trimmed)
    assert agrees(from_edge(moved), edges(moved)[0])
    assert agrees(from_edge(trimmed.Reversed()), trimmed, reverse=True)
    assert same(from_edge(to_edge(spline).Reversed()), spline.reversed())
    assert same(from_edge(to_edge(spline)), spline)  # the edge's own curve was not cut


def points(rows) -> kernel.Points:
    array = kernel.Points(1, len(rows))
    for k, row in enumerate(rows):
        array.SetValue(k + 1, gp_Pnt(*map(float, row)))
    return array


def kernel_spline(poles, knots, multiplicities, degree, periodic=False) -> Geom_BSplineCurve:
    reals, integers = kernel.Reals(1, len(knots)), kernel.Integers(1, len(knots))
    for k, (knot, times) in enumerate(zip(knots, multiplicities, strict=True)):
        reals.SetValue(k + 1, float(knot))
        integers.SetValue(k + 1, times)
    return Geom_BSplineCurve(points(poles), reals, integers, degree, periodic)


ROWS = np.random.default_rng(3).normal(size=(7, 3))


@pytest.mark.parametrize(
    "curve",
    [
        kernel_spline(ROWS, range(7), [2, 1, 1, 1, 1, 1, 2], 1),
        kernel_spline(ROWS, [0, 1, 3, 4, 5, 9], [3, 1, 1, 1, 1, 3], 2),
        kernel_spline(ROWS[:6], range(10), [1] * 10, 3),
        Geom_BezierCurve(points(ROWS[:2])),
        Geom_BezierCurve(points(ROWS[:3])),
        Geom_BezierCurve(points(ROWS[:4])),
    ],
    ids=["degree 1", "degree 2", "not clamped", "Bézier 1", "Bézier 2", "Bézier 3"],
)
def test_lower_degrees_are_taken_exactly(curve):
    whole = BRepBuilderAPI_MakeEdge(curve).Edge()
    low, high = curve.FirstParameter(), curve.LastParameter()
    part = BRepBuilderAPI_MakeEdge(curve, 0.7 * low + 0.3 * high, 0.1 * low + 0.9 * high).Edge()
    for edge in (whole, part):
        assert agrees(from_edge(edge), edge)


@pytest.mark.parametrize("part", [(0.0, 7.0), (1.5, 4.25), (5.5, 9.5), (3.0, 10.0)])
def test_periodic_curves_are_cut_open(part):
    curve = kernel_spline(ROWS, range(8), [1] * 8, 3, periodic=True)
    edge = BRepBuilderAPI_MakeEdge(curve, *part).Edge()
    assert agrees(from_edge(edge), edge)
    assert same(from_edge(to_edge(from_edge(edge))), from_edge(edge))


def test_a_line_is_a_spline():
    edge = BRepBuilderAPI_MakeEdge(gp_Pnt(1, 2, 3), gp_Pnt(4, 2, -1)).Edge()
    assert agrees(from_edge(edge), edge)
    assert from_edge(edge).length() == pytest.approx(5)


@pytest.mark.skipif(not kernel.PASSES_BACKSLASHES, reason="OCP 7.8 doubles backslashes")
def test_names_are_ascii_in_step(tmp_path):
    """ISO 10303-21, 6.4.3: readers that go by it take bytes above 127 for nothing, or for other letters."""
    names = ["Flügel O'B", "\u7ffc\U0001f600", "plain"]
    curves = [random_spline([1], seed=seed) for seed in range(3)]
    write_step(tmp_path / "named.step", curves, names=names)
    text = (tmp_path / "named.step").read_bytes().decode("ascii")
    for escaped in (r"'Fl\X2\00FC\X0\gel O''B'", r"'\X4\00007FFC0001F600\X0\'", "'plain'"):
        assert re.search(rf"B_SPLINE_CURVE_WITH_KNOTS\(\s*{re.escape(escaped)}", text)
    assert len(edges(read_step(tmp_path / "named.step"))) == 3


def test_what_is_no_edge_is_refused():
    for shape, expected in ((TopoDS_Edge(), "nothing"), (to_wire(random_spline([1])), "wire")):
        with pytest.raises(ValueError, match=f"an edge is needed, not {expected}"):
            from_edge(shape)


def test_what_no_cubic_equals_is_refused():
    weights = kernel.Reals(1, 4)
    weights.Init(1.0)
    weights.SetValue(2, 0.5)
    for curve, reason in [
        (Geom_Circle(gp_Ax2(), 2.0), r"Circle \(not polynomial\)"),
        (Geom_BezierCurve(points(ROWS[:4]), weights), r"BezierCurve \(not polynomial\)"),
        (Geom_BezierCurve(points(ROWS[:6])), "BezierCurve of degree 5"),
        (kernel_spline(ROWS, range(4), [5, 1, 1, 5], 4), "BSplineCurve of degree 4"),
    ]:
        with pytest.raises(ValueError, match=rf"^no non-rational cubic spline equals the edge's curve, a {reason}$"):
            from_edge(BRepBuilderAPI_MakeEdge(curve).Edge())
    with pytest.raises(ValueError, match="a Line, has no end"):
        from_edge(BRepBuilderAPI_MakeEdge(gp_Lin()).Edge())


# ---- the kernel as judge of the curve type


def test_values_and_derivatives_agree_with_the_kernel(spline):
    curve, spline = kernel_curve(to_edge(spline)), lifted(spline)
    low, high = spline.domain
    u = np.random.default_rng(1).uniform(low, high, 200)
    point, vectors = gp_Pnt(), [gp_Vec(), gp_Vec(), gp_Vec()]
    rows = []
    for x in u:
        curve.D3(float(x), point, *vectors)
        rows.append([point.Coord(), *(v.Coord() for v in vectors)])
    kernel = np.array(rows)
    # Rounding of the poles' coordinates is carried into a derivative by the knot spacing it is divided by.
    magnitude = np.abs(spline.poles).max()
    spacing = np.diff(spline.distinct_knots).min()
    for order in range(4):
        gap = np.abs(spline.derivative(u, order) - kernel[:, order]).max()
        assert gap <= 1e-12 * max(np.abs(kernel[:, order]).max(), magnitude * (3 / spacing) ** order)


@pytest.mark.parametrize("name", ["one span", "mixed", "many spans", "closed"])
def test_knot_insertion_and_split_agree_with_the_kernel(name):
    spline = SPLINES[name]
    low, high = spline.domain
    u = low + 0.37 * (high - low)
    curve = kernel_curve(to_edge(spline)).Copy()
    curve.InsertKnot(u, 2, 0.0)
    assert from_edge(BRepBuilderAPI_MakeEdge(curve).Edge()).isclose(spline.insert_knot(u, 2), 1e-14)
    for ours, part in zip(spline.split(u), [(low, u), (u, high)], strict=True):
        curve = kernel_curve(to_edge(spline)).Copy()
        curve.Segment(*part)
        assert from_edge(BRepBuilderAPI_MakeEdge(curve).Edge()).isclose(ours, 1e-14)


@pytest.mark.parametrize("name", ["one span", "mixed", "many spans", "in the plane", "closed"])
def test_length_agrees_with_the_kernel(name):
    assert SPLINES[name].length(1e-12) == pytest.approx(length(to_edge(SPLINES[name])), rel=1e-8)


@pytest.mark.parametrize("name", ["one span", "mixed", "closed"])
def test_nearest_agrees_with_the_kernel(name):
    spline = SPLINES[name]
    curve = kernel_curve(to_edge(spline))
    targets = np.random.default_rng(2).normal(scale=2.0, size=(40, 3))
    for target, distance in zip(targets, spline.nearest(targets)[1], strict=True):
        place = gp_Pnt(*target.tolist())
        search = GeomAPI_ProjectPointOnCurve(place, curve)
        feet = [search.LowerDistance()] if search.NbPoints() else []
        ends = [curve.Value(u).Distance(place) for u in spline.domain]  # the kernel's feet are inner ones
        assert distance <= min(feet + ends) + 1e-9
        assert distance == pytest.approx(min(feet + ends), abs=1e-6)


# ---- wires


def chain(spline: BSpline, parts: int) -> list[BSpline]:
    """Return a spline cut into parts."""
    cuts, rest = [], spline
    low, high = spline.domain
    for k in range(1, parts):
        before, rest = rest.split(low + (high - low) * k / parts)
        cuts.append(before)
    return [*cuts, rest]


@pytest.mark.parametrize("parts", [1, 2, 5])
@pytest.mark.parametrize("name", ["mixed", "in the plane", "closed"])
def test_wire_shares_vertices(name, parts):
    curves = chain(SPLINES[name], parts)
    wire = to_wire(curves)
    found = edges(wire)
    assert all(same(from_edge(e), lifted(c)) for e, c in zip(found, curves, strict=True))
    vertices = kernel.Shapes()
    TopExp.MapShapes_s(wire, TopAbs_ShapeEnum.TopAbs_VERTEX, vertices)
    closed = SPLINES[name].closed
    assert vertices.Extent() == parts + (not closed)
    assert wire.Closed() is BRep_Tool.IsClosed_s(wire) is closed
    assert BRepCheck_Analyzer(wire).IsValid()


def line(start, end) -> BSpline:
    return BSpline(np.linspace(start, end, 4), [0, 0, 0, 0, 1, 1, 1, 1])


def test_wire_through_its_own_start():
    loop = SPLINES["closed with a corner"]
    out, back = line([0, 0], [-1, -1]), line([-1, -1], [0, 0])
    for curves, vertices, closed in [
        ([loop, loop.transformed(-np.eye(2))], 1, True),
        ([loop, out], 2, False),
        ([out, back, loop], 2, True),
        ([back, loop, out], 2, True),
    ]:
        wire = to_wire(curves)
        found = kernel.Shapes()
        TopExp.MapShapes_s(wire, TopAbs_ShapeEnum.TopAbs_VERTEX, found)
        assert (found.Extent(), wire.Closed()) == (vertices, closed)
        assert BRepCheck_Analyzer(wire).IsValid()


def test_open_joint_is_named():
    first, second, third = chain(SPLINES["mixed"], 3)
    apart = third.transformed(np.eye(3), [0, 0, 2e-7])
    with pytest.raises(ValueError, match="curve 1 ends 2e-07 away from the start of curve 2"):
        to_wire([first, second, apart])
    near = third.transformed(np.eye(3), [0, 0, 5e-8])
    assert BRepCheck_Analyzer(to_wire([first, second, near])).IsValid()
    with pytest.raises(ValueError, match="at least one"):
        to_wire([])


# ---- STEP


def test_step_round_trip(spline, tmp_path):
    path = tmp_path / "curve.step"
    write_step(path, spline)
    text = path.read_text()
    assert text.count("B_SPLINE_CURVE_WITH_KNOTS('',3,") == 1
    assert text.count("RATIONAL") == 0
    (edge,) = edges(read_step(path))
    back = from_edge(edge)
    assert np.abs(back.poles - lifted(spline).poles).max() <= 1e-9 * spline.size
    assert same(back, lifted(spline))  # better than promised: to the last bit
    assert BRep_Tool.IsClosed_s(edge) is spline.closed


SI_UNITS = {"um": ".MICRO.", "mm": ".MILLI.", "cm": ".CENTI.", "m": "$", "km": ".KILO."}


@pytest.mark.parametrize("unit", UNITS)
def test_step_units(unit, tmp_path):
    spline, path = random_spline([1, 2, 1]), tmp_path / "curve.step"
    write_step(path, spline, unit)
    text = re.sub(r"\s+", "", path.read_text())
    # The file itself, read without the kernel: the caller's numbers, and the unit they are in.
    number = r"([-+.\dE]+)"
    written = np.array(re.findall(rf"CARTESIAN_POINT\('',\({number},{number},{number}\)\)", text), dtype=float)
    assert all((written == pole).all(axis=1).any() for pole in spline.poles)
    context = re.search(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\(\((#\d+),", text)[1]
    definition = re.search(rf"{context}=\((.*?)\);", text)[1]
    if unit in SI_UNITS:
        assert definition == f"LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT({SI_UNITS[unit]},.METRE.)"
    else:
        name = {"inch": "INCH", "ft": "FOOT"}[unit]
        assert re.match(rf"CONVERSION_BASED_UNIT\('{name}',#\d+\)LENGTH_UNIT\(\)", definition)
        factor, base = re.search(r"=LENGTH_MEASURE_WITH_UNIT\(([^,]+),(#\d+)\)", text).groups()
        assert float(factor) == pytest.approx(UNITS[unit], rel=1e-15)
        assert f"{base}=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))" in text
    # The kernel's reading: the same numbers in the same unit, scaled ones in another.
    assert same(from_edge(edges(read_step(path, unit))[0]), spline)
    scaled = spline.transformed(UNITS[unit] * np.eye(3))
    assert from_edge(edges(read_step(path))[0]).isclose(scaled, 1e-14)


def test_step_unit_must_be_known(tmp_path):
    path = tmp_path / "curve.step"
    for call in (lambda: write_step(path, SPLINES["closed"], "furlong"), lambda: read_step(__file__, "furlong")):
        with pytest.raises(ValueError, match="one of um, mm, cm, m, km, inch, ft, not 'furlong'"):
            call()
    assert not path.exists()


def test_step_keeps_several_shapes_apart(tmp_path):
    path = tmp_path / "curves.step"
    write_step(path, [SPLINES["mixed"], to_wire(chain(SPLINES["closed"], 3)), to_edge(SPLINES["one span"])])
    shapes = read_step(path)
    assert [len(edges(shape)) for shape in shapes] == [1, 3, 1]
    mixed, *ring, last = map(from_edge, edges(shapes))
    assert same(mixed, SPLINES["mixed"])
    assert all(same(a, b) for a, b in zip(ring, chain(SPLINES["closed"], 3), strict=True))
    assert same(last, SPLINES["one span"])


def test_step_leaves_the_kernel_as_it_was(tmp_path, capfd):
    def state():
        printers = [*Message.DefaultMessenger_s().Printers()]
        return Interface_Static.CVal_s("write.step.unit"), [p.GetTraceLevel() for p in printers], len(printers)

    write_step(tmp_path / "first.step", SPLINES["closed"])
    before = state()
    assert before[2] > 0
    write_step(tmp_path / "second.step", SPLINES["closed"], "m")
    read_step(tmp_path / "second.step", "inch")
    with pytest.raises(ValueError, match="not a STEP file"):
        read_step(__file__)
    assert state() == before
    assert capfd.readouterr() == ("", "")


# ---- failures


WRITERS = pytest.mark.parametrize("write", [write_step, write_brep])


@WRITERS
def test_failure_leaves_the_old_file(write, tmp_path, monkeypatch):
    path = tmp_path / "part.step"
    path.write_text("old")

    def full(self, content):
        with open(self, "wb") as file:
            file.write(content[: len(content) // 2])
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        with pytest.raises(OSError, match=r"No space left on device: .*part\.step"):
            write(path, SPLINES["closed"])
    with pytest.raises(KernelError):
        write(path, [SPLINES["closed"], BSpline(np.eye(6, 3), [0, 0, 0, 0, 1, np.nextafter(1.0, 2.0), 2, 2, 2, 2])])
    for nothing in ([], [TopoDS_Shape()], ["a string"]):
        with pytest.raises(ValueError, match=r"written|to write"):
            write(path, nothing)
    assert [f.name for f in tmp_path.iterdir()] == ["part.step"]
    assert path.read_text() == "old"
    write(path, SPLINES["closed"])
    assert [f.name for f in tmp_path.iterdir()] == ["part.step"]
    assert path.read_text() != "old"


def test_writer_failing_midway_is_a_kernel_error(tmp_path, monkeypatch):
    path = tmp_path / "part.step"
    path.write_text("old")

    class Failing:
        def __init__(self, model):
            raise OCP.Standard.Standard_Failure("broken pipe")

    monkeypatch.setattr(exchange, "StepData_StepWriter", Failing)
    with pytest.raises(KernelError, match=r"a STEP file of 1 shape\(s\): broken pipe"):
        write_step(path, SPLINES["closed"])
    assert path.read_text() == "old"
    assert Interface_Static.CVal_s("write.step.unit") == "MM"


@WRITERS
def test_folder_that_cannot_be_written(write, tmp_path):
    (tmp_path / "file").touch()
    for path in (tmp_path / "none" / "part.step", tmp_path / "file" / "part.step", tmp_path):
        with pytest.raises(OSError, match=re.escape(str(path))):
            write(path, SPLINES["closed"])
    assert [f.name for f in tmp_path.iterdir()] == ["file"]


@WRITERS
def test_a_link_stays_a_link(write, tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write(tmp_path / "link", SPLINES["closed"])
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() != "old"


@pytest.mark.parametrize("read", [read_step, read_brep])
def test_files_that_cannot_be_read(read, tmp_path, capfd):
    path = tmp_path / "part.step"
    with pytest.raises(FileNotFoundError, match=r"part\.step"):
        read(path)
    whole = tmp_path / "whole"
    (write_step if read is read_step else write_brep)(whole, SPLINES["many spans"])
    for content in (b"", b"hello\n", bytes(range(256))):
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"part\.step: not a"):
            read(path)
    assert capfd.readouterr() == ("", "")
    path.write_bytes(whole.read_bytes()[:2000])
    with pytest.raises((ValueError, KernelError), match=r"part\.step"):
        read(path)


def test_step_without_shapes(tmp_path):
    path = tmp_path / "curve.step"
    write_step(path, SPLINES["closed"])
    text = path.read_text()
    path.write_text(text[: text.index("DATA;")] + "DATA;\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises(ValueError, match=r"curve\.step: no shape"):
        read_step(path)


# ---- BREP


def test_brep_round_trip(spline, tmp_path):
    path = tmp_path / "curve.brep"
    write_brep(path, spline)
    (edge,) = edges(read_brep(path))
    back = from_edge(edge)
    size = np.abs(spline.poles).max()
    assert np.abs(back.poles - lifted(spline).poles).max() <= 1e-14 * size
    assert np.allclose(back.knots, spline.knots, rtol=1e-14, atol=0)


def test_brep_of_several_shapes(tmp_path):
    path = tmp_path / "curves.brep"
    write_brep(path, [SPLINES["one span"], to_wire(chain(SPLINES["closed"], 3))])
    assert len(edges(read_brep(path))) == 4


# ---- real data


@pytest.mark.skipif(not CORPUS.is_dir(), reason="needs the corpus: set CADFIT_CORPUS to its folder")
@pytest.mark.parametrize("family", ["airfoil", "neuron", "gps_track_ecef", "mesh_section", "font_outline"])
def test_real_curves_survive(family, tmp_path):
    data = np.load(CORPUS / f"{family}.npz")
    splines = []
    for k in range(min(3, len(data["closed"]))):
        found = data["points"][data["starts"][k] : data["starts"][k + 1]]
        moves = np.linalg.norm(np.diff(found, axis=0), axis=1) > 0
        splines.append(cardinal_spline(found[np.concatenate([[True], moves])], closed=bool(data["closed"][k])))
    write_step(tmp_path / "real.step", splines)
    back = [from_edge(edge) for edge in edges(read_step(tmp_path / "real.step"))]
    for spline, returned in zip(splines, back, strict=True):
        assert same(returned, lifted(spline))
        assert length(to_edge(spline)) == pytest.approx(spline.length(), rel=1e-6)
