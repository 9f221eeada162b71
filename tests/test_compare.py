"""`cadfit compare`: several ways to a curve of the same points, judged alike."""

import json
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from test_report import Words

import cadfit
from cadfit.cli import main
from cadfit.report.compare import by_method, fitpack, of_curves

X = np.linspace(0, 9, 80)
WAVE = np.column_stack([X, np.sin(X)])
T = np.linspace(0, 2 * np.pi, 60, endpoint=False)
RING = np.column_stack([3 * np.cos(T), 2 * np.sin(T)])


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Run `cadfit compare` in a folder with wave.csv and other.csv; return the status, what it printed and said."""
    monkeypatch.chdir(tmp_path)
    cadfit.write("wave.csv", WAVE)
    cadfit.write("other.csv", 2.0 * WAVE)

    def run(*arguments):
        return (main(["compare", *map(str, arguments)]), *capsys.readouterr())

    return run


def entries(path):
    return json.loads(Words(Path(path).read_text(encoding="utf-8")).scripts[0])["entries"]


@pytest.mark.slow
def test_methods_on_one_page_and_in_the_terminal(run):
    status, out, err = run("wave.csv", "fast", "fitpack", "-t", "0.01", "-o", "page.html")
    assert (status, err) == (0, "")
    ours, theirs = entries("page.html")
    assert [ours["name"], theirs["name"]] == ["fast", "fitpack"]
    fit = cadfit.fit(WAVE, 0.01, effort="fast")
    assert ours["figures"]["poles"] == fit.poles
    spline = fitpack(WAVE, 0.01, False)
    assert theirs["figures"]["poles"] == len(spline.poles)
    assert theirs["figures"]["deviation at points"] == cadfit.deviation(spline, WAVE).points
    assert ours["set"] == theirs["set"]
    assert ours["colour"] != theirs["colour"]
    assert ours["figures"]["seconds"] > 0
    lines = {line.split()[0]: line.split() for line in out.splitlines() if line.startswith(("fast", "fitpack"))}
    assert lines["fast"][1:4] == ["80", str(fit.poles), f"{fit.deviation.points:.4g}"]
    assert lines["fitpack"][2] == str(len(spline.poles))
    assert out.splitlines()[-1] == "wrote page.html"


@pytest.mark.slow
def test_the_usual_methods(run):
    status, out, _ = run("wave.csv", "-t", "0.05")
    assert status == 0
    assert ("occt" in out) == (find_spec("OCP") is not None)
    assert "fitpack" in out


def test_curves_are_held_against_the_points(run):
    cadfit.write("curve.json", cadfit.fit(WAVE, 0.02))
    cadfit.write("coarse.json", cadfit.fit(WAVE, 0.2))
    status, out, _ = run("wave.csv", "fast", "curve.json", "coarse.json", "-t", "0.05", "-o", "page.html")
    assert status == 0
    named = {entry["name"]: entry["figures"] for entry in entries("page.html")}
    assert named["curve.json"]["deviation at points"] <= 0.02
    assert named["coarse.json"]["deviation at points"] > 0.05
    assert named["curve.json"]["strays"] == 0
    assert named["curve.json"]["seconds"] is None
    assert "coarse.json" in out


@pytest.mark.slow
def test_a_method_without_an_answer_has_its_row(run):
    t = np.linspace(0, 60, 20_000)
    cadfit.write("long.csv", np.column_stack([t, np.sin(t * t)]))
    status, out, err = run("long.csv", "fast", "fitpack", "-t", "2.5", "-o", "page.html", "--limit", "0.001")
    assert (status, err) == (0, "")
    (row,) = [line for line in out.splitlines() if line.startswith("fitpack")]
    assert row.split() == ["fitpack", "20000", *"–––––", "no", "answer", "within", "0.001", "s"]
    words = Words(Path("page.html").read_text(encoding="utf-8")).words
    assert "fitpack: no answer within 0.001 s" in words
    assert [entry["name"] for entry in entries("page.html")] == ["fast"]
    status, out, err = run("long.csv", "fitpack", "-t", "2.5", "--limit", "0.001")
    assert (status, out) == (2, "")
    assert err == "cadfit: long.csv: no curve to compare: fitpack: no answer within 0.001 s\n"


@pytest.mark.slow
def test_what_fails_says_why():
    found = by_method("fitpack", np.random.default_rng(0).normal(size=(30, 12)), 1e-3)  # FITPACK takes ten coordinates
    assert str(found) == "fitpack: makes no curve of it"


@pytest.mark.slow
def test_stages_and_progress(run):
    _, _, err = run("wave.csv", "fast", "fitpack", "-t", "0.01", "-o", "page.html", "-v", "-q")
    stages = {line[13:]: float(line[:9]) for line in err.splitlines()}
    assert {"reading", "taking spans away", "fitpack", "writing the page"} < set(stages)
    assert sum(stages.values()) == pytest.approx(2 * stages["all"], abs=0.01)
    seen = []
    by_method("fast", WAVE, 0.01, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_several_files_of_points(run):
    assert run("wave.csv", "other.csv", "fast", "-t", "0.02", "-o", "page.html")[0] == 0
    assert [entry["name"] for entry in entries("page.html")] == ["wave: fast", "other: fast"]
    assert [entry["set"] for entry in entries("page.html")] == [0, 1]


@pytest.mark.slow
def test_a_closed_contour_by_every_method():
    for method in ("cadfit", "fast", "fitpack"):
        entry = by_method(method, RING, 0.01, closed=True)
        assert entry.fit.closed
        assert entry.fit.deviation.points <= 0.0101
        assert entry.strays == 0


def test_curves_of_the_plane_in_space():
    spline = cadfit.interpolate(WAVE)
    lifted = spline.transformed(np.eye(3, 2))
    assert of_curves([lifted], WAVE, 0.01, None, "a").fit.deviation.points < 1e-12
    with pytest.raises(ValueError, match="coordinates"):
        of_curves([spline.transformed(np.eye(3, 2), [0, 0, 1])], WAVE, 0.01, None, "a")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["curve.json", "-t", "1"], "curve.json: at least one file of points is needed"),
        (["wave.csv", "other.csv", "curve.json", "-t", "1"], "curve.json: curves are held against one file of points"),
        (["none.csv", "-t", "1"], "none.csv: No such file or directory"),
        (["fastest", "wave.csv", "-t", "1"], "fastest: unknown suffix"),
        (["wave.csv", "-t", "1", "-o", "a.pdf"], "a.pdf: a report is a .html"),
        (["wave.csv", "-t", "-1"], "wave.csv: the tolerance must be at least"),
        (["wave.csv"], "Missing option"),
    ],
)
def test_mistakes(run, arguments, message):
    cadfit.write("curve.json", cadfit.interpolate(WAVE))
    status, out, err = run(*arguments)
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
