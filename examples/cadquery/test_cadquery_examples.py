"""Each of CadQuery's cases is run, and what it found is held to what it is there to show."""

import runpy
from pathlib import Path

import matplotlib
import numpy as np
import pytest

pytest.importorskip("cadquery")
matplotlib.use("agg")
HERE = Path(__file__).parent


@pytest.fixture
def example(tmp_path):
    """What an example's `main` found, its picture looked at."""

    def run(name):
        found = runpy.run_path(str(HERE / f"{name}.py"))["main"](tmp_path)
        pixels = matplotlib.image.imread(tmp_path / f"cq_{name}.png")
        assert pixels.shape[1] >= 1000
        blue = np.round(255.0 * pixels[:, :, :3]).astype(int) == (0, 114, 178)
        assert np.count_nonzero(blue.all(axis=2)) >= 200
        return found

    return run


def test_airfoil(example):
    rows = example("airfoil")
    assert rows["spline"]["changes of side"] > 20
    assert rows["splineApprox, smoothing"]["changes of side"] > 10
    ours = rows["fitSpline"]
    assert ours["changes of side"] == 1  # the lower side turns hollow once
    assert ours["at points"] <= 0.02
    assert ours["poles"] <= 0.5 * rows["splineApprox, none"]["poles"]
    assert rows["splineApprox, none"]["poles"] > 2 * ours["poles"]


def test_closed(example):
    found = example("closed")
    seven, cam = found["seven"], found["cam"]
    assert seven["spline, repeated"]["kink, degrees"] > 100
    assert seven["spline, periodic"]["sharpest"] > 10 * seven["localSpline"]["sharpest"]
    for row in (seven["localSpline"], seven["fitSpline, 0.05"], cam["fitSpline"]):
        assert row["kink, degrees"] < 1e-4
        assert row["jump of curvature"] < 1e-9
    assert cam["spline, periodic"]["jump of curvature"] > 1
    assert cam["spline, periodic"]["changes of side"] > 50
    assert cam["splineApprox"]["kink, degrees"] > 1
    assert cam["fitSpline"]["changes of side"] == 0
    assert cam["fitSpline"]["at points"] <= 0.25
    assert cam["fitSpline"]["poles"] <= cam["splineApprox"]["poles"]


def test_helix(example):
    rows = example("helix")
    assert rows["parametricCurve"]["length / exact"] < 0.5
    assert rows["fitSpline"]["length / exact"] == pytest.approx(1.0, abs=1e-4)
    assert rows["fitSpline"]["at points"] <= 1e-3
    assert rows["fitSpline"]["poles"] <= rows["parametricCurve, smoothing=None"]["poles"]


def test_dxf_kinks(example):
    host, ours = example("dxf_kinks").values()
    assert (host["faces"], host["edges"]) == (1, 1)  # the hole alone
    assert host["off"] > 40.0
    assert ours["off"] <= 1e-3
    assert ours["poles"] <= 6 * 4 + 12
    assert ours["valid"]
    assert ours["edges"] == 7
    assert ours["area"] == pytest.approx(467.6 - np.pi * 1.5**2, abs=0.02)


def test_tube(example):
    rows = example("tube")
    for name in ("ring", "trefoil"):
        assert not rows[f"{name}, sweep"]["mesh watertight"]
        assert rows[f"{name}, fit_tube"]["valid"]
        assert rows[f"{name}, fit_tube"]["mesh watertight"]
        assert rows[f"{name}, fit_tube"]["mesh / exact volume"] == pytest.approx(0.9, abs=0.05)
        assert rows[f"{name}, fit_tube"]["poles"] < rows[f"{name}, sweep"]["poles"]
    assert rows["ring, sweep"]["mesh / exact volume"] < 0.5
    assert rows["ring, fit_tube"]["off"] <= 2 * 0.025  # the path's tolerance, and the wall's
    assert rows["trefoil, fit_tube"]["off"] <= 2 * 0.02


def test_step_size(example):
    cylinders, swept, ours = example("step_size").values()
    assert ours["valid"]
    assert ours["solids"] == 4
    assert cylinders["kB"] > 20 * ours["kB"]
    assert swept["kB"] > ours["kB"]
    assert swept["poles"] > ours["poles"]
    assert ours["off"] <= 2 * 0.002


def test_every_example_is_tested():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in HERE.glob("*.py")} - {Path(__file__).stem, "beside"} <= tested
