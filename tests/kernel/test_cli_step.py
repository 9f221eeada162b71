"""Files and the command line where there is a kernel."""

import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

pytest.importorskip("OCP", reason="needs a CAD kernel: cadfit[build123d] or cadfit[cadquery]")

from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer

import cadfit
from cadfit import occt
from cadfit.cli import main
from cadfit.files import Curves, read, write

SUFFIXES = [".step", ".stp", ".brep"]
HELIX = np.stack([10 * np.cos(t := np.linspace(0, 6, 40)), 10 * np.sin(t), 2 * t], axis=1)
CLOSE = {".step": 1e-14, ".stp": 1e-14, ".brep": 1e-13}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write("helix.csv", HELIX)
    return tmp_path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("step")


def write_read(path, result, unit="mm"):
    write(path, result, unit)
    return read(path, unit)


@pytest.mark.parametrize("suffix", SUFFIXES)
@given(points=arrays(np.float64, (7, 3), elements=st.floats(-1e3, 1e3)))
@settings(max_examples=15, deadline=None)
def test_curves_come_back(folder, suffix, points):
    curve = cadfit.cardinal_spline(points + [[3e3, 0.0, 0.0]] * np.arange(7)[:, None])  # no two at one place
    back = write_read(folder / f"a{suffix}", curve)
    assert not back.closed
    assert back.curves[0].isclose(curve, CLOSE[suffix])


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_several_curves_that_follow_each_other_are_one_wire(here, suffix):
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 3, 1]], dtype=float)
    sides = [cadfit.cardinal_spline(np.stack([a, (a + b) / 2 + 0.1, b])) for a, b in pairwise([*corners, corners[0]])]
    back = write_read(here / f"a{suffix}", sides)
    assert back.closed
    assert len(back.curves) == 3
    assert all(b.isclose(s, CLOSE[suffix]) for b, s in zip(back.curves, sides, strict=True))
    if suffix == ".brep":  # STEP knows wires as bare curves only
        shape = occt.read_brep("a.brep")
        assert TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_WIRE).More()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_several_curves_apart_are_edges(here, suffix):
    curve = cadfit.cardinal_spline(HELIX)
    back = write_read(here / f"a{suffix}", Curves((curve, curve.transformed(np.eye(3), [0, 0, 50])), False))
    assert len(back.curves) == 2
    assert not back.closed


def test_a_plane_curve_lies_in_z_0_and_a_curve_in_5d_is_refused(here):
    flat = cadfit.local_spline(HELIX[:, :2])
    back = write_read("a.step", flat)
    assert np.array_equal(back.curves[0].poles[:, 2], np.zeros(len(flat.poles)))
    with pytest.raises(ValueError, match=r"b\.step: \.step holds curves of 2 to 3 coordinates, not 5; \.json does"):
        write("b.step", cadfit.local_spline(np.random.default_rng(0).normal(size=(5, 5))))
    assert not (here / "b.step").exists()


def test_units_are_kept(here):
    curve = cadfit.local_spline(HELIX)
    write("a.step", curve, "inch")
    assert read("a.step", "inch").curves[0].isclose(curve, 1e-14)
    assert read("a.step", "mm").curves[0].size == pytest.approx(25.4 * curve.size, rel=1e-12)


def test_what_is_no_cubic_is_named(here):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    occt.write_step("a.step", [BRepPrimAPI_MakeCylinder(1.0, 2.0).Shape()])
    with pytest.raises(ValueError, match=r"^a\.step: edge \d: .*Circle"):
        read("a.step")


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"garbage", bytes(range(256)), b"ISO-10303-21;\nHEADER;\n"])
def test_broken_files_are_a_mistake(here, capfd, suffix, content):
    (here / f"a{suffix}").write_bytes(content)
    assert main(["info", f"a{suffix}"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith(f"cadfit: a{suffix}: ")
    assert err.count("\n") == 1


def test_fit_info_and_tube_through_step(here, capfd):
    assert main(["fit", "helix.csv", "-o", "a.step", "-o", "a.brep", "-o", "a.json", "--unit", "m", "-q"]) == 0
    fitted = read("a.json").curves[0]
    for name in ("a.step", "a.brep"):
        assert read(name, "m").curves[0].isclose(fitted, 1e-13)
    assert main(["info", "a.step", "--unit", "m"]) == 0
    out, err = capfd.readouterr()
    assert (out.splitlines()[0], err) == ("a.step", "")
    assert dict(line.split(None, 1) for line in out.splitlines()[1:])["poles"] == str(len(fitted.poles))
    assert main(["tube", "a.step", "--unit", "m", "--radius", "0.5", "-o", "a.stl", "-q"]) == 0
    assert main(["tube", "a.json", "--radius", "0.5", "-o", "b.stl", "-q"]) == 0
    assert read("a.stl").volume == pytest.approx(read("b.stl").volume, rel=1e-5)
    assert capfd.readouterr() == ("", "")


def test_a_failure_of_the_kernel_is_one_line(here, capfd):
    write("tiny.csv", 1e-9 * HELIX)
    (here / "a.step").write_text("old")
    assert main(["fit", "tiny.csv", "-o", "a.step"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.startswith("cadfit: a.step: ")
    assert err.count("\n") == 1
    assert (here / "a.step").read_text() == "old"


def test_too_many_coordinates_are_refused_before_anything_is_written(here, capfd):
    write("five.csv", np.random.default_rng(0).normal(size=(10, 5)))
    assert main(["fit", "five.csv", "-o", "a.json", "-o", "a.step"]) == 2
    assert capfd.readouterr().err.startswith("cadfit: a.step: .step holds curves of 2 to 3 coordinates, not 5")
    assert not (here / "a.json").exists()


def test_tubes_and_sweeps_as_solids(here, capsys):
    write("profile.csv", np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]))
    length = cadfit.local_spline(HELIX).length()
    assert main(["tube", "helix.csv", "--radius", "1.5", "-o", "tube.step", "-o", "tube.stl", "--unit", "m"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"solid +4 faces, volume \d", said)
    assert "watertight" in said
    assert main(["sweep", "helix.csv", "--profile", "profile.csv", "-o", "bar.brep", "-q"]) == 0
    [tube] = occt.read_step("tube.step", "m")
    bar = occt.read_brep("bar.brep")
    assert occt.volume(tube) == pytest.approx(np.pi * 2.25 * length, rel=1e-4)
    assert occt.volume(bar) == pytest.approx(4 * length, rel=1e-4)


@pytest.mark.parametrize("suffix", [".step", ".brep", ".igs"])
def test_info_of_solids(here, capfd, suffix):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Pnt

    both = [BRepPrimAPI_MakeCylinder(2.0, 3.0).Solid(), BRepPrimAPI_MakeBox(gp_Pnt(5, 0, 0), 1.0, 2.0, 3.0).Solid()]
    {".step": occt.write_step, ".brep": occt.write_brep, ".igs": occt.write_iges}[suffix](f"a{suffix}", both)
    assert main(["info", f"a{suffix}"]) == 0
    said = dict(line.split(None, 1) for line in capfd.readouterr().out.splitlines()[1:])
    assert (said["faces"], said["valid"]) == ("9", "yes")
    assert [float(x) for x in said["from"].split()] == pytest.approx([-2, -2, 0], abs=1e-6)
    assert [float(x) for x in said["to"].split()] == pytest.approx([6, 2, 3], abs=1e-6)
    if suffix == ".igs":  # it knows faces alone
        assert (said["kind"], said["volume"]) == ("faces", "none: faces alone")
        assert main(["info", "a.igs", "--unit", "inch"]) == 0
        assert float(capfd.readouterr().out.splitlines()[-1].split()[1]) == pytest.approx(6 / 25.4)
    else:
        assert (said["kind"], said["solids"], said["edges"]) == ("solids", "2", "15")
        assert float(said["volume"]) == pytest.approx(12 * np.pi + 6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--radius", "50"], "helix.csv: no solid: it passes through itself"),
        (["--radius", "1", "--caps", "none"], "--caps none leaves the ends open"),
        (["--radius", "1", "--on-self-intersection", "repair"], "repair is for meshes"),
    ],
)
def test_what_is_no_solid_is_one_line(here, options, said, capsys):
    assert main(["tube", "helix.csv", "-o", "tube.step", *options]) == 2
    assert said in capsys.readouterr().err
    assert not (here / "tube.step").exists()
