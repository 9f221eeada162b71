"""Each example is run, and what it found and wrote is held to what it is there to show."""

import re
import runpy
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
import trimesh

import cadfit

matplotlib.use("agg")
HERE = Path(__file__).parent
BLUE, VERMILION = (0, 114, 178), (213, 94, 0)


def example(name):
    return runpy.run_path(str(HERE / f"{name}.py"))["main"]


def shows(path, colour, least):
    """Whether that many pixels of a picture, as wide as a page, have the very colour."""
    pixels = np.round(255.0 * matplotlib.image.imread(path)[:, :, :3]).astype(int)
    assert pixels.shape[1] >= 1000, pixels.shape
    return np.count_nonzero((pixels == colour).all(axis=2)) >= least


def test_data_are_as_published():
    contour = cadfit.read(HERE / "data" / "rae2822.dat")
    assert contour.shape == (129, 2)
    assert contour[0].tolist() == contour[-1].tolist() == [1.0, 0.0]
    assert contour[64].tolist() == [0.0, 0.0]
    trace = cadfit.read(HERE / "data" / "1a8o_ca.csv")
    assert trace.shape == (70, 3)
    assert trace[0].tolist() == [20.255, 33.101, 26.891]
    # Neighbouring alpha carbons are 3.8 ångström apart, in every protein.
    assert np.linalg.norm(np.diff(trace, axis=0), axis=1) == pytest.approx(3.8, abs=0.07)
    sources = (HERE / "data" / "SOURCES.md").read_text(encoding="utf-8")
    assert all(f"`{path.name}`" in sources for path in (HERE / "data").iterdir() if path.suffix != ".md")


def test_demo(tmp_path, capsys):
    pytest.importorskip("OCP")
    found = example("demo")(tmp_path)
    assert found["right"]
    counts = {name: (found[name]["points"], found[name]["poles"]) for name in ("airfoil", "protein")}
    assert counts == {"airfoil": (129, 385), "protein": (70, 208)}
    assert found["airfoil_light"]["poles"] <= 14
    assert found["airfoil_light"]["at points"] <= 0.02
    assert found["airfoil_light"]["between"] <= 0.02 + 1.5 * 0.0287  # the chords themselves are that far off
    assert max(found[name]["at points"] for name in counts) < 1e-11
    assert found["airfoil"]["between"] == pytest.approx(0.0287, rel=0.02)
    assert found["protein"]["between"] == pytest.approx(0.567, rel=0.02)
    printed = capsys.readouterr().out
    assert printed.count("ok    ") == 5
    written = [
        "airfoil.png",
        "airfoil.step",
        "airfoil_light.step",
        "protein.3mf",
        "protein.png",
        "protein.step",
        "protein.stl",
    ]
    assert sorted(path.name for path in tmp_path.iterdir()) == written
    assert all(name in printed for name in written)

    contour = 200.0 * cadfit.read(HERE / "data" / "rae2822.dat")
    curves = cadfit.read(tmp_path / "airfoil.step")
    assert curves.closed
    (around,) = curves.curves
    assert around.multiplicities.tolist() == [4, *[1] * 381, 4]  # C2 everywhere but at the trailing edge
    assert np.abs(around(cadfit.parametrize(contour, "chord"))[:, :2] - contour).max() < 1e-10
    assert _bends(around) == [1, -1], "the lower side turns hollow once, and nothing wiggles"

    (along,) = cadfit.read(tmp_path / "protein.step").curves
    for name in ("protein.stl", "protein.3mf"):
        mesh = trimesh.load_mesh(tmp_path / name)
        assert mesh.is_watertight
        assert mesh.euler_number == 2
        assert mesh.volume == pytest.approx(np.pi * 0.75**2 * along.length(), rel=1e-4)
        _, distance = along.nearest(mesh.vertices[::97])
        assert np.abs(distance[distance > 0.5] - 0.75).max() <= 0.03
    for name in ("airfoil.png", "protein.png"):
        assert shows(tmp_path / name, VERMILION, 500)


def _bends(spline):
    """Return the signs of the curvature in turn, as far as it is not small, up to 5 % of the chord from the end."""
    u = np.linspace(*spline.domain, 20_001)
    x, velocity, bend = spline(u)[:, 0], spline.derivative(u), spline.curvature(u)
    side = velocity[:, 0] * bend[:, 1] - velocity[:, 1] * bend[:, 0]
    signs = np.sign(side)[(x < 190.0) & (np.linalg.norm(bend, axis=1) > 1e-4)]
    return signs[np.concatenate([[True], np.diff(signs) != 0])].astype(int).tolist()


def test_demo_tells_by_its_exit_status(tmp_path, monkeypatch, capsys):
    pytest.importorskip("OCP")
    monkeypatch.setattr(sys, "argv", ["demo.py", str(tmp_path)])
    assert _exit_status("demo") == 0
    whole = cadfit.write

    def broken(path, result, **options):
        result = result.reversed() if isinstance(result, cadfit.BSpline) else result
        if hasattr(result, "faces"):
            result = trimesh.Trimesh(result.vertices, result.faces[:-1], process=False)
        whole(path, result, **options)

    monkeypatch.setattr(cadfit, "write", broken)
    capsys.readouterr()
    assert _exit_status("demo") == 1
    assert capsys.readouterr().out.count("WRONG") == 5


def _exit_status(name):
    with pytest.raises(SystemExit) as left:
        runpy.run_path(str(HERE / f"{name}.py"), run_name="__main__")
    return int(left.value.code)


def test_circle_curvature(tmp_path):
    found = example("circle_curvature")(tmp_path)
    flat, restored, local, solved = ((round(low, 2), round(high, 2)) for low, high, _ in found.values())
    assert flat == (0.00, 1.46)
    assert restored == (0.85, 1.10)
    assert local == (0.99, 1.00)
    assert solved == (0.99, 1.02)
    errors = [error for _, _, error in found.values()]
    assert errors == [pytest.approx(each, rel=0.02) for each in (7.3e-3, 1.7e-3, 7.63e-5, 2.1e-4)]
    assert shows(tmp_path / "circle_curvature.png", BLUE, 1000)


def test_uneven_spacing(tmp_path):
    found = example("uneven_spacing")(tmp_path)
    assert found["ratio"] > 1e3
    assert found["uniform"]["backwards"] > 0.2
    assert found["uniform"]["longer"] > 0.2
    assert found["centripetal"]["backwards"] < 0.005
    assert found["centripetal"]["between"] < 0.01
    assert found["chord"]["backwards"] == 0.0
    assert found["chord"]["longer"] < 0.03
    assert shows(tmp_path / "uneven_spacing.png", BLUE, 1000)


def test_tolerance(tmp_path):
    airfoil, circle, plate = example("tolerance")(tmp_path).values()
    for said in (airfoil, circle, plate):
        assert said["at points"] <= said["tolerance"]
    assert (airfoil["points"], airfoil["corners"], airfoil["curves"]) == (128, 1, 1)
    assert airfoil["poles"] <= 15
    assert circle["poles"] <= 12
    assert circle["length"] == pytest.approx(100 * np.pi, rel=0.003)
    assert (plate["corners"], plate["curves"]) == (5, 5)
    assert plate["between"] <= plate["tolerance"]
    assert plate["poles"] <= 30
    assert shows(tmp_path / "tolerance.png", VERMILION, 500)


def test_planes(tmp_path):
    found = example("planes")(tmp_path)
    assert max(found.values()) < 1e-13
    assert shows(tmp_path / "planes.png", VERMILION, 500)


def test_tube(tmp_path):
    ours, theirs = example("tube")(tmp_path).values()
    assert ours["turn"] < 0.01
    assert theirs["turn"] > 179.0
    assert ours["watertight"]
    assert ours["volume"] == pytest.approx(1.0, abs=1e-3)
    assert theirs["volume"] < 0.95
    mesh = trimesh.load_mesh(tmp_path / "tube.stl")
    assert mesh.is_watertight
    assert mesh.bounds[1] - mesh.bounds[0] == pytest.approx(
        [2 * (1.3 + 0.35), 2 * 0.35, 2 * np.pi + 2 * 0.35 * 0.8], rel=0.03
    )
    assert shows(tmp_path / "tube.png", VERMILION, 2000)


def test_sweeps(tmp_path):
    pytest.importorskip("manifold3d")
    found = example("sweeps")(tmp_path)
    assert list(found) == ["harness", "spring", "trefoil", "duct", "rail", "bend"]
    assert all(said["watertight"] for said in found.values())
    assert all(trimesh.load_mesh(path).is_watertight for path in tmp_path.glob("*.stl"))
    assert len(list(tmp_path.glob("harness*.stl"))) == 3
    assert 0 < found["bend"]["volume"] < 103.75  # what the bend would have twice is there once
    assert shows(tmp_path / "sweeps.png", (255, 255, 255), 1000)


def test_toolpath(tmp_path):
    found = example("toolpath")(tmp_path)
    assert found["moves"][0] >= 4 * found["moves"][1]
    assert found["deviation"] <= 0.02
    assert found["arcs"] > 50
    assert found["kink after"] < 0.02 < 4.0 < found["kink before"]
    assert found["speed after"] > 2 * found["speed before"]
    assert (tmp_path / "engraved.nc").is_file()
    assert shows(tmp_path / "toolpath.png", VERMILION, 1000)


def test_drawing(tmp_path):
    pytest.importorskip("ezdxf")
    pytest.importorskip("svgelements")
    found = example("drawing")(tmp_path)
    assert set(found["names"]) == {("outline", "spar", "lightening", "cable")}
    assert found["deviation"] <= 0.05
    vertices, poles, arcs = found["counts"]
    assert vertices >= 20 * max(poles, arcs)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["drawing.png", "rib.dxf", "rib_arcs.dxf"]
    assert shows(tmp_path / "drawing.png", VERMILION, 300)
    assert shows(tmp_path / "drawing.png", BLUE, 1000)


def test_paper_experiments(tmp_path):
    found = example("paper_experiments")(tmp_path)
    for number in (1, 2, 3, 4):
        errors, claims = found[number]
        paper, best = np.transpose(list(errors.values()))
        assert np.all(best <= paper)
        assert np.all(np.diff(paper) > 0)
        for method, said in claims.items():
            knee = number == 3 and method == "best"
            assert (said["faster"], said["exponential"], said["knee"]) == (True, False, knee)
        assert claims["best"]["needed"] <= claims["paper"]["needed"]
        assert shows(tmp_path / f"paper_{number}.png", VERMILION, 400)
    assert [round(found[k][1]["best"]["needed"], 2) for k in (1, 2, 3, 4)] == [0.9, 0.82, 0.29, 0.43]
    rows = [row for number in (1, 2, 3, 4) for row in found[number][0].items()]
    page = (Path(__file__).parents[1] / "docs" / "paper.md").read_text(encoding="utf-8")
    table = re.findall(r"^\|[ 1-4]* \| (\d+) % \| [\d.]+ \| (\S+) \| (\S+) \|$", page, re.MULTILINE)
    assert table == [(f"{part * 100:.0f}", f"{paper:.3g}", f"{best:.3g}") for part, (paper, best) in rows]
    assert found[5] < 1e-13
    assert shows(tmp_path / "paper_5.png", BLUE, 1000)


def test_guide(tmp_path):
    found = example("guide")(tmp_path)
    assert found["guide_airfoil"] <= 15
    assert found["guide_scan"][0] > 20 * found["guide_scan"][1]
    assert found["guide_corners"] == 6
    above = np.array(found["how_bound"]) - 1.0
    assert np.all(above > 0.0)
    assert above[-1] < 0.01
    assert np.all(np.diff(above) < 0.0)
    for name, colour in {"guide_airfoil": BLUE, "guide_scan": VERMILION, "how_bound": BLUE}.items():
        assert shows(tmp_path / f"{name}.png", colour, 500)
    assert shows(tmp_path / "guide_corners.png", VERMILION, 100)


def test_build123d_cases(tmp_path):
    pytest.importorskip("build123d")
    found = example("build123d_cases")(tmp_path)
    host, smoothed, ours, lighter = found["circle"].values()
    assert host["between"] > 10_000 * 0.01, "the host's curve shoots off and says it is done"
    assert host["length"] > 10 * 2 * np.pi * 50
    assert smoothed["at points"] > 10 * 0.01
    assert ours["at points"] <= 0.01
    assert ours["between"] < 0.05
    assert ours["poles"] < host["poles"]
    assert lighter["poles"] <= 11
    assert lighter["length"] == pytest.approx(2 * np.pi * 50, rel=1e-3)
    host, local, _ = found["local"].values()
    assert host["overshoot"] > 10.0
    assert local["overshoot"] < 0.2
    assert local["felt far off"] < 1e-6
    through, approximated, fitted = found["airfoil"].values()
    assert through["inflections"] > 20
    assert fitted["inflections"] == 1, "the lower side turns hollow once, and nothing wiggles"
    assert fitted["poles"] < approximated["poles"] / 2
    assert fitted["at points"] <= 0.02
    host, ours = found["tube"].values()
    assert not host["valid read back"]
    assert host["volume read back"] < 0.0, "inside out"
    assert ours["poles"] < host["poles"]
    assert ours["off"] <= 2 * 0.01, "the path's tolerance, and the wall's"
    assert ours["valid"]
    assert ours["valid read back"]
    assert ours["volume"] == pytest.approx(1.0, abs=1e-3)
    assert ours["volume read back"] == pytest.approx(1.0, abs=1e-3)
    for name in ("circle", "local", "airfoil"):
        assert shows(tmp_path / f"case_{name}.png", BLUE, 200)
        assert shows(tmp_path / f"case_{name}.png", VERMILION, 200)
    assert shows(tmp_path / "case_tube.png", BLUE, 500)


def test_report(tmp_path):
    found = example("report")(tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert f"≤ {found['fit'].deviation.points:.4g} mm" in page
    assert len(page) < 500_000
    assert shows(tmp_path / "deviation.png", VERMILION, 300)
    if found["shown"]:
        assert shows(tmp_path / "report.png", VERMILION, 300)


def test_every_example_is_tested():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in HERE.glob("*.py")} - {Path(__file__).stem} <= tested
