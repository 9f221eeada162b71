"""DXF and SVG: read back with another library than the one that wrote them, and what is not understood is named."""

import ezdxf
import numpy as np
import pytest
import svgpathtools
import trimesh
from ezdxf.bbox import extents
from hypothesis import given, settings
from hypothesis import strategies as st

import cadfit
from cadfit.arcing.result import Arcs
from cadfit.cli import main
from cadfit.files import Curves, read, write

T = np.linspace(0, 2 * np.pi, 60, endpoint=False)
BLOB = cadfit.fit(np.column_stack([30 * np.cos(T), 20 * np.sin(T) + 3 * np.cos(3 * T)]), 1e-3, closed=True).spline
WAVE = cadfit.local_spline(np.column_stack([np.linspace(0, 50, 20), 5 * np.sin(np.linspace(0, 6, 20))]))
SPACE = cadfit.local_spline(np.column_stack([10 * np.cos(T), 10 * np.sin(T), T]))


def theirs(path):
    """What trimesh's own reader makes of a DXF file."""
    with path.open("rb") as file:
        return trimesh.load_path(file, file_type="dxf")


def write_read(path, result, unit="mm"):
    write(path, result, unit)
    return read(path, unit)


@pytest.fixture
def drawing(tmp_path):
    """A function that draws with ezdxf into a new DXF file and gives its path."""

    def made(draw, units=4):
        document = ezdxf.new("R2010", units=units)
        draw(document.modelspace(), document)
        document.saveas(tmp_path / "a.dxf")
        return tmp_path / "a.dxf"

    return made


@pytest.mark.parametrize("curve", [BLOB, WAVE, SPACE], ids=["blob", "wave", "space"])
def test_dxf_splines_come_back_exactly(tmp_path, curve):
    back = write_read(tmp_path / "a.dxf", curve)
    assert back.curves[0].isclose(curve, 1e-15)
    assert back.closed == curve.closed
    assert np.array_equal(back.curves[0].knots, curve.knots)


def test_dxf_read_by_another_library(tmp_path):
    write(tmp_path / "a.dxf", BLOB)
    path = theirs(tmp_path / "a.dxf")
    (entity,) = path.entities
    _, away = BLOB.nearest(np.asarray(path.vertices)[:, :2][entity.points[[0, -1]]])
    assert away.max() < 1e-6
    arcs = cadfit.arcs(WAVE, 0.01, max_radius=100)  # their reader refuses arcs that turn by a hundredth
    write(tmp_path / "b.dxf", arcs)
    length = theirs(tmp_path / "b.dxf").length
    assert length == pytest.approx(arcs.lengths.sum(), rel=1e-3)


def test_arcs_as_bulges_come_back(tmp_path):
    for curve in (BLOB, WAVE):
        arcs = cadfit.arcs(curve, 0.01)
        back = write_read(tmp_path / "a.dxf", arcs)
        (spline,) = back.curves
        assert back.closed == arcs.closed
        assert spline.length() == pytest.approx(arcs.lengths.sum(), rel=1e-8)
        points = np.concatenate([arcs(k, np.linspace(0, 1, 9)) for k in range(len(arcs))])
        assert spline.nearest(points)[1].max() < 1e-6
        again = write_read(tmp_path / "a.svg", arcs)
        assert again.curves[0].nearest(points)[1].max() < 1e-6


def test_an_arc_of_more_than_half_a_turn_comes_back(tmp_path):
    """As rounding to few decimals may leave a small one."""
    start, end, centre = np.array([[2.0, 1.0]]), np.array([[1.0, 0.0]]), np.array([[1.0, 1.0]])
    for sweep in (1.5 * np.pi, -0.5 * np.pi):
        few = Arcs(start, end, centre, np.array([sweep]), "xy", np.zeros(0, dtype=np.intp), 0.0, 1.0, False)
        for name in ("a.svg", "a.dxf"):
            (spline,) = write_read(tmp_path / name, few).curves
            assert spline.length() == pytest.approx(abs(sweep), rel=1e-6)


def test_units_and_layers(tmp_path):
    named = Curves((WAVE, BLOB), False, names=("rail", "cam"))
    back = write_read(tmp_path / "a.dxf", named, "inch")
    assert back.names == ("rail", "cam")
    assert back.curves[1].isclose(BLOB, 1e-14)
    assert read(tmp_path / "a.dxf").curves[0].size == pytest.approx(25.4 * WAVE.size)
    assert [e.dxf.layer for e in ezdxf.readfile(tmp_path / "a.dxf").modelspace()] == ["rail", "cam"]
    back = write_read(tmp_path / "a.svg", named, "m")
    assert back.names == ("rail", "cam")
    assert back.curves[1].length() == pytest.approx(BLOB.length())
    with pytest.raises(ValueError, match="2 curves need as many names or none, not 1"):
        Curves((WAVE, BLOB), False, names=("rail",))


def test_circles_and_arcs_within_a_billionth(drawing):
    def draw(space, _):
        space.add_circle((5, 6), 100)
        space.add_arc((0, 0), 50, 20, 250)
        space.add_lwpolyline([(300, 0, 0.7), (310, 0, 0), (310, 20, -0.2)], format="xyb", close=True)
        space.add_ellipse((900, 0), (20, 0), 0.4)

    circle, arc, bulged, ellipse = read(drawing(draw)).curves
    radii = np.linalg.norm(circle(np.linspace(*circle.domain, 5000)) - [5, 6], axis=1)
    assert radii.min() >= 100 * (1 - 1e-14)
    assert radii.max() <= 100 * (1 + 1.1e-9)
    assert circle.closed
    points = arc(np.linspace(*arc.domain, 5000))
    assert np.abs(np.linalg.norm(points, axis=1) - 50).max() <= 50 * 1.1e-9
    assert arc.length() == pytest.approx(50 * np.radians(230), rel=1e-8)
    assert bulged.closed
    unit = (ellipse(np.linspace(*ellipse.domain, 999)) - [900, 0]) / [20, 8]
    assert np.abs(np.linalg.norm(unit, axis=1) - 1).max() <= 1.1e-9


def test_loose_lines_and_arcs_become_one_closed_contour(drawing):
    def draw(space, _):
        space.add_line((0, 0), (10, 0))
        space.add_line((0, 5), (0, 0))  # turned round
        space.add_arc((10, 5), 5, -90, 0)
        space.add_line((10, 10), (0, 5))
        space.add_arc((10, 5), 5, 0, 90)

    found = read(drawing(draw))
    assert found.closed
    (contour,) = found.curves
    assert contour.closed
    assert contour.length() == pytest.approx(10 + 5 + 5 * np.pi + np.hypot(10, 5))


def test_a_single_polyline_is_points(drawing, capfd, tmp_path):
    corners = [(0, 0), (10, 0), (10, 8), (3, 9)]
    points = read(drawing(lambda space, _: space.add_lwpolyline(corners, close=True)))
    assert points.tolist() == [*map(list, corners), [0, 0]]
    assert main(["fit", str(tmp_path / "a.dxf"), "-t", "0.01", "-o", str(tmp_path / "b.svg"), "-q"]) == 0
    assert main(["info", str(tmp_path / "b.svg")]) == 0
    assert "closed" in capfd.readouterr().out


def test_a_single_polyline_keeps_its_name_and_its_size(drawing, capfd, tmp_path):
    def draw(space, document):
        document.layers.add("rim")
        space.add_lwpolyline([(0, 0), (10, 0), (10, 8), (3, 9)], close=True, dxfattribs={"layer": "rim"})

    source = drawing(draw, units=1)  # inches
    for options, kind in (
        ([], "SPLINE"),
        (["--arcs"], "LWPOLYLINE"),
        (["-o", f"{tmp_path}/all/", "--format", "dxf"], ""),
    ):
        target = [] if "-o" in options else ["-o", str(tmp_path / "b.dxf")]
        assert main(["fit", str(source), "-t", "0.01", "-q", "--unit", "inch", *target, *options]) == 0
        drawn = ezdxf.readfile(tmp_path / ("b.dxf" if target else "all/a.dxf"))
        assert {each.dxf.layer for each in drawn.modelspace()} == {"rim"}
        assert {each.dxftype() for each in drawn.modelspace()} == {kind or "SPLINE"}
        assert drawn.units == 1
        assert extents(drawn.modelspace()).size.xyz[:2] == pytest.approx((10, 9), abs=0.02)


def test_blocks_are_taken_apart_and_units_honoured(drawing):
    def draw(space, document):
        block = document.blocks.new("part")
        block.add_line((0, 0), (1, 0))
        block.add_arc((0, 0), 1, 0, 90)
        space.add_blockref("part", (10, 20), dxfattribs={"xscale": 2, "yscale": 2, "rotation": 90})

    (curve,) = read(drawing(draw, units=6)).curves  # metres
    assert sorted(map(tuple, np.round(curve.poles[[0, -1]], 6))) == [(8000, 20000), (10000, 20000)]


def test_quadratic_splines_and_what_no_cubic_equals(drawing):
    def quadratic(space, _):
        space.add_open_spline([(0, 0), (1, 2), (3, 2), (4, 0)], degree=2)

    path = drawing(quadratic)
    (curve,) = read(path).curves
    tool = ezdxf.readfile(path).modelspace()[0].construction_tool()
    theirs = np.array([[p.x, p.y] for p in tool.points(np.linspace(0, tool.max_t, 50))])
    assert curve.nearest(theirs)[1].max() < 1e-12
    path = drawing(lambda space, _: space.add_rational_spline([(0, 0), (1, 2), (3, 2), (4, 0)], [1, 2, 2, 1]))
    with pytest.raises(ValueError, match=r"a\.dxf: SPLINE \(handle \w+\): a rational spline, which no cubic equals"):
        read(path)
    path = drawing(lambda space, _: space.add_open_spline([(k, k % 3) for k in range(8)], degree=5))
    with pytest.raises(ValueError, match=r"SPLINE \(handle \w+\): a spline of degree 5"):
        read(path)


def test_what_is_not_a_curve_is_named(drawing, tmp_path):
    def draw(space, _):
        space.add_text("hello")
        space.add_line((0, 0), (1, 1))

    with pytest.warns(UserWarning, match=r"left out: TEXT \(handle \w+\)"):
        assert len(read(drawing(draw))) == 2
    with pytest.raises(ValueError, match="no curves in its model space"), pytest.warns(UserWarning, match="TEXT"):
        read(drawing(lambda space, _: space.add_text("hello")))
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg">\n<text>a</text><path d="M0 0L1 1"/></svg>'
    )
    with pytest.warns(UserWarning, match=r"left out: text \(line 2\)"):
        read(tmp_path / "a.svg")


@pytest.mark.parametrize("curve", [BLOB, WAVE], ids=["blob", "wave"])
def test_svg_read_by_another_library(tmp_path, curve):
    write(tmp_path / "a.svg", curve)
    (path,), _, attributes = svgpathtools.svg2paths(str(tmp_path / "a.svg"), return_svg_attributes=True)
    theirs = np.array([segment.bpoints() for segment in path if isinstance(segment, svgpathtools.CubicBezier)])
    assert np.array_equal(np.stack([theirs.real, -theirs.imag], axis=-1), curve.pieces())
    left, top, wide, tall = map(float, attributes["viewBox"].split())
    dense = curve(np.linspace(*curve.domain, 20_001))
    assert [left, -top] == pytest.approx([dense[:, 0].min(), dense[:, 1].max()], abs=1e-4)
    assert [wide, tall] == pytest.approx(np.ptp(dense, axis=0), abs=1e-4)
    assert attributes["width"] == f"{wide!r}mm"
    back = read(tmp_path / "a.svg")
    assert np.abs(back.curves[0].pieces() - curve.pieces()).max() < 1e-12
    assert back.closed == curve.closed


def test_svg_transforms_units_and_shapes(tmp_path):
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="10cm" height="10cm" viewBox="0 0 200 200">'
        '<g transform="translate(100 50) scale(2)"><circle id="hole" r="10"/></g>'
        '<path id="arc" d="M0,0 q10 10 20 0 a10 5 30 0 1 9 9z" transform="rotate(90)"/></svg>'
    )
    found = read(tmp_path / "a.svg")
    assert found.names == ("hole", "arc")
    around = found.curves[0](np.linspace(*found.curves[0].domain, 999))
    assert np.linalg.norm(around - [50, -25], axis=1) == pytest.approx(10, rel=2e-9)
    assert found.curves[1].closed


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "not an SVG file"),
        ("<svg><path", "not an SVG file"),
        ("<html/>", "its outermost element is html"),
        (
            '<svg xmlns="http://www.w3.org/2000/svg">\n<path d="M0 0 L1 x"/></svg>',
            "line 2: path data: 'x' is no command",
        ),
        ('<svg xmlns="http://www.w3.org/2000/svg">\n\n<path d="M0 0 C1 1 2 2"/></svg>', "line 3: path data: C with 4"),
        ('<svg xmlns="http://www.w3.org/2000/svg"><path d="L1 1"/></svg>', "must begin with M"),
        ('<svg xmlns="http://www.w3.org/2000/svg"/>', "no paths or shapes in it"),
    ],
)
def test_broken_svg(tmp_path, capfd, content, expected):
    (tmp_path / "a.svg").write_text(content)
    with pytest.raises(ValueError, match=r"a\.svg: ") as caught:
        read(tmp_path / "a.svg")
    assert expected in str(caught.value)
    (tmp_path / "out.json").write_text("old")
    assert main(["fit", str(tmp_path / "a.svg"), "-t", "1", "-o", str(tmp_path / "out.json")]) == 2
    assert capfd.readouterr().err.count("\n") == 1
    assert (tmp_path / "out.json").read_text() == "old"


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawings")
    write(folder / "whole.dxf", Curves((WAVE, BLOB), False))
    write(folder / "whole.svg", Curves((WAVE, BLOB), False))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [".dxf", ".svg"])
@given(data=st.data())
@settings(max_examples=40)
def test_mutated_files_are_read_or_refused(real, suffix, data):
    content = bytearray((real / f"whole{suffix}").read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(content) - 1))
        content[at : at + data.draw(st.integers(0, 30))] = data.draw(st.binary(max_size=8))
    path = real / f"mutated{suffix}"
    path.write_bytes(content)
    said, curves = "", ()
    try:
        curves = getattr(read(path), "curves", ())
    except ValueError as error:
        said = str(error)
    assert said == "" or said.startswith(f"{path}: ")
    assert all(np.isfinite(curve.poles).all() for curve in curves)


def test_broken_dxf(tmp_path):
    for content in (b"", b"garbage", bytes(range(256)), b"0\nSECTION\n2\nENTITIES\n0\nLINE\n"):
        (tmp_path / "a.dxf").write_bytes(content)
        with pytest.raises(ValueError, match=r"a\.dxf: "):
            read(tmp_path / "a.dxf")
    (tmp_path / "a.dxf").write_bytes(b"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1024\n")
    with pytest.raises(ValueError, match=r"a\.dxf: not a readable DXF file: it is cut short"):
        read(tmp_path / "a.dxf")


DENSE = np.linspace(0, 2 * np.pi, 200, endpoint=False)
OVAL = np.column_stack([50 * np.cos(DENSE), 30 * np.sin(DENSE)])
FRAME = np.array([(-70.0, -50), (70, -50), (70, 50), (-70, 50)])


def several(space, document):
    """An oval and a frame of chords, a hole that is a circle, and a wave whose SPLINE is smooth."""
    for layer in ("outline", "holes", "rail"):
        document.layers.add(layer)
    space.add_lwpolyline(OVAL.tolist(), close=True, dxfattribs={"layer": "outline"})
    space.add_circle((10, 0), 5, dxfattribs={"layer": "holes"})
    rail = space.add_spline(degree=3, dxfattribs={"layer": "rail"})
    rail.control_points, rail.knots = np.column_stack([WAVE.poles, 0 * WAVE.poles[:, 0]]).tolist(), WAVE.knots.tolist()
    space.add_lwpolyline(FRAME.tolist(), close=True, dxfattribs={"layer": "outline"})


def test_each_contour_of_a_drawing_is_fitted_or_taken_over(drawing, capfd, tmp_path):
    source = drawing(several)
    before = read(source)
    command = ["fit", str(source), "-t", "0.01", "--between", "polyline"]
    assert main([*command, "-o", str(tmp_path / "b.dxf"), "-o", str(tmp_path / "b.svg")]) == 0
    said = capfd.readouterr().out
    assert "2 fitted, 2 taken over" in said
    assert "contour 0 (outline)" in said
    after = read(tmp_path / "b.dxf")
    assert after.names == before.names == ("outline", "holes", "rail", "outline")
    oval, hole, rail, frame = after.curves
    assert hole.isclose(before.curves[1], 1e-15)
    assert rail.isclose(WAVE, 1e-15)
    assert len(oval.poles) < 30
    assert oval.closed
    for curve, points in ((oval, OVAL), (frame, FRAME)):
        around = np.concatenate([points, points[:1]])
        far = cadfit.deviation(curve, around, True)
        assert max(far.points, far.between) <= 0.01
        assert cadfit.deviation(curve, around + [0.02, 0.0], True).points > 0.01, "the judge sees what is off"
    assert len(frame.poles) == 13, "four lines"
    assert read(tmp_path / "b.svg").names == ("outline", "holes", "rail", "outline-2")


@pytest.mark.slow
def test_several_drawings_and_what_cannot_be_fitted(drawing, capfd, tmp_path):
    source = drawing(several)
    table = ["--summary", str(tmp_path / "all.csv")]
    both = [str(source), str(source.with_name("x.dxf")), "-o", f"{tmp_path}/o/", "--format", "dxf"]
    assert main(["fit", *both, "-t", "0.01", *table]) == 1
    assert read(tmp_path / "o" / "a.dxf").names == read(source).names
    assert ",206," in (tmp_path / "all.csv").read_text()
    capfd.readouterr()
    out = str(tmp_path / "c.dxf")
    for options, expected in (
        (["-t", "0.01", "--corners", "3,17"], "rows are for one contour, and it holds 4"),
        (["-t", "1e-30"], "contour 0 (outline): "),
        (["-t", "0.01", "--report", str(tmp_path / "c.html")], "--report is for points, and it holds 4 contours"),
    ):
        assert main(["fit", str(source), "-o", out, *options]) == 2
        assert expected in capfd.readouterr().err
    assert not (tmp_path / "c.dxf").exists()


def off(points, path):
    """How far the farthest of points (n, 2) is from a chain of points (m, 2), by projecting on every segment."""
    start, step = path[:-1], np.diff(path, axis=0)
    away = points[:, None] - start
    t = np.clip(np.einsum("nmd,md->nm", away, step) / np.maximum((step**2).sum(axis=1), 1e-300), 0.0, 1.0)
    return np.linalg.norm(away - t[..., None] * step, axis=2).min(axis=1).max()


@pytest.mark.slow
def test_arcs_and_lines_of_a_drawing_within_the_tolerance(drawing, capfd, tmp_path):
    source = drawing(several)
    command = ["fit", str(source), "-t", "0.01", "--arcs", "-o", str(tmp_path / "b.dxf")]
    assert main([*command, "-o", str(tmp_path / "b.svg")]) == 0
    said = dict(line.split("  ", 1) for line in capfd.readouterr().out.splitlines() if "  " in line)
    drawn = list(ezdxf.readfile(tmp_path / "b.dxf").modelspace())
    assert [(each.dxftype(), each.dxf.layer, each.closed) for each in drawn] == [
        ("LWPOLYLINE", "outline", True),
        ("LWPOLYLINE", "holes", True),
        ("LWPOLYLINE", "rail", False),
        ("LWPOLYLINE", "outline", True),
    ]
    parts = [part for each in drawn for part in each.virtual_entities()]
    kinds = [part.dxftype() for part in parts]
    assert (kinds.count("ARC"), kinds.count("LINE")) == (int(said["arcs"]), int(said["lines"]))
    assert len(parts) < 50 < len(OVAL)
    bounds = [float(value) for name, value in said.items() if name.startswith("deviation")]
    assert len(bounds) == 3
    assert max(bounds) <= 0.01
    shapes = [np.concatenate([OVAL, OVAL[:1]]), None, WAVE(np.linspace(*WAVE.domain, 4000)), None]
    shapes[3] = np.concatenate([FRAME, FRAME[:1]])
    for each, shape in zip(drawn, shapes, strict=True):
        if shape is not None:
            path = np.array([p.xyz for p in ezdxf.path.make_path(each).flattening(1e-5)])[:, :2]
            far = max(off(shape[:: max(1, len(shape) // 300)], path), off(path[:: max(1, len(path) // 300)], shape))
            assert far <= max(bounds) + 2e-5
            assert off(shape[:1] + [0.03, 0.03], path) > 0.01, "the judge sees what is off"
    assert read(tmp_path / "b.svg").names == ("outline", "holes", "rail", "outline-2")
    assert len(svgpathtools.svg2paths(tmp_path / "b.svg")[0]) == 4


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["-o", "c.dxf"], "--arcs needs --tolerance"),
        (["-t", "0.01", "-o", "c.step"], ".step does not hold arcs; these do: .dxf .svg"),
        (["-t", "0.01", "-o", "c.dxf", "--report", "c.html"], "--arcs is for one file, and goes without --report"),
        (["-t", "1e-14", "-o", "c.dxf"], "contour 0 (outline): "),
    ],
)
def test_arcs_that_cannot_be(drawing, capfd, monkeypatch, tmp_path, options, expected):
    source = drawing(several)
    monkeypatch.chdir(tmp_path)
    assert main(["fit", str(source), "--arcs", *options]) == 2
    assert expected in capfd.readouterr().err
    assert not (tmp_path / "c.dxf").exists()


@pytest.mark.slow
def test_coarse_chords_become_no_more_lines_and_arcs_than_they_are(drawing, capfd, tmp_path):
    x = np.linspace(-20, -14, 25)
    coarse = np.column_stack([x, 3 * np.sin(x)])
    assert main(["fit", str(drawing(lambda space, _: space.add_lwpolyline(coarse))), "-t", "1e-3", "--arcs", "-o",
                 str(tmp_path / "b.dxf")]) == 0  # fmt: skip
    (path,) = ezdxf.readfile(tmp_path / "b.dxf").modelspace()
    assert len(path) <= len(coarse)
    assert cadfit.read(tmp_path / "b.dxf").shape == (len(path), 2), "lines"
