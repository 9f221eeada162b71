"""What may take long tells how far it is, from 0 to 1 and never back, and stops where it is told to."""

import io
import os
import sys

import numpy as np
import pytest

import cadfit
import cadfit.toolpaths
from cadfit.commands import terminal
from cadfit.files import text
from cadfit.fitting.judging import judged

N = 3000
T = np.linspace(0.0, 9.0, N)
NOISY = np.column_stack([T, np.sin(T * T)]) + np.random.default_rng(3).normal(scale=1e-3, size=(N, 2))
SPLINE = cadfit.local_spline(NOISY[::30])
PATH = cadfit.polyline([[0, 0, 0], [20, 0, 0], [20, 20, 0]])


@pytest.fixture
def big(tmp_path, monkeypatch):
    monkeypatch.setattr(text, "_BLOCK", 500)
    path = tmp_path / "big.csv"
    cadfit.write(path, NOISY)
    return path


def program(big):
    path = big.with_name("part.nc")
    path.write_text("G21 G90 G1 F100\n" + "".join(f"G1 X{x:.4f} Y{y:.4f}\n" for x, y in NOISY[:60]))
    return path


def works(big):
    some = NOISY[:400]
    return {
        "fit": lambda told: cadfit.fit(NOISY[:900], 0.01, effort="fast", progress=told),
        "fit of little": lambda told: cadfit.fit(NOISY[:2], 0.01, progress=told),
        "fit_many": lambda told: cadfit.fit_many([some, some], 0.01, jobs=1, effort="fast", progress=told),
        "fit_planes": lambda told: cadfit.fit_planes(np.column_stack([NOISY, T]), progress=told),
        "dominant_points": lambda told: cadfit.dominant_points(NOISY, fraction=0.2, progress=told),
        "dominant_points, paper": lambda told: cadfit.dominant_points(
            NOISY, fraction=0.5, method="paper", progress=told
        ),
        "dominant_points, error": lambda told: cadfit.dominant_points(some, square_error=1e-3, progress=told),
        "fit_dominant": lambda told: cadfit.fit_dominant(some, fraction=0.2, progress=told),
        "deviation": lambda told: cadfit.deviation(SPLINE, NOISY, progress=told),
        "deviation, closed": lambda told: cadfit.deviation(
            cadfit.local_spline(NOISY[::30], closed=True), NOISY, closed=True, progress=told
        ),
        "arcs": lambda told: cadfit.arcs(NOISY[:100], 0.1, progress=told),
        "arcs of a curve": lambda told: cadfit.arcs(SPLINE, 0.01, progress=told),
        "tube": lambda told: cadfit.tube(SPLINE, 1e-4, progress=told),
        "pipe": lambda told: cadfit.tube(SPLINE, 1e-4, 2e-5, thickness=1e-5, progress=told),
        "sweep": lambda told: cadfit.sweep(PATH, [[-1, -1], [1, -1], [1, 1], [-1, 1]], progress=told),
        "length": lambda told: SPLINE.length(progress=told),
        "nearest": lambda told: SPLINE.nearest(NOISY[:50], told),
        "report": lambda told: judged(SPLINE, NOISY[::30]).report(big.with_name("page.html"), progress=told),
        "refit": lambda told: cadfit.toolpaths.refit(program(big), big.with_suffix(".nc"), 0.01, progress=told),
        "read": lambda told: cadfit.read(big, progress=told),
        "write": lambda told: cadfit.write(big, NOISY, progress=told),
        "write json": lambda told: cadfit.write(big.with_suffix(".json"), NOISY, progress=told),
    }


@pytest.mark.parametrize("name", works(None))
def test_progress_rises_from_0_to_1_and_stops_the_work(name, big):
    work = works(big)[name]
    seen = []
    work(seen.append)
    assert seen == sorted(seen)
    assert seen[0] >= 0.0
    assert seen[-1] == 1.0

    class Enough(Exception):
        pass

    def stop(part):
        raise Enough

    whole, names = big.read_bytes(), sorted(os.listdir(big.parent))
    with pytest.raises(Enough):
        work(stop)
    assert big.read_bytes() == whole
    assert sorted(os.listdir(big.parent)) == names


def test_text_in_blocks_is_the_text(big):
    assert np.array_equal(cadfit.read(big), NOISY)
    seen = []
    cadfit.read(big, progress=seen.append)
    assert seen == [*np.arange(6) * 500 / 3000, 1.0]
    with open(big, "a", encoding="utf-8") as file:
        file.write("1,2,3\n")
    with pytest.raises(ValueError, match=r"line 3002: 3 numbers, not 2 as in the first row, in '1,2,3'"):
        cadfit.read(big)


class Terminal(io.StringIO):
    """A terminal of a certain width, as rich asks for it."""

    def isatty(self):
        return True


@pytest.mark.parametrize(("quiet", "shown"), [(False, True), (True, False)])
def test_a_bar_on_a_terminal_alone(monkeypatch, quiet, shown):
    for stream in (Terminal(), io.StringIO()):
        monkeypatch.setattr(sys, "stderr", stream)
        with terminal.busy("fitting", quiet, 8) as progress:
            if progress is not None:
                progress(0.5)
        wanted = shown and stream.isatty()
        assert (progress is not None) == wanted
        assert ("fitting" in stream.getvalue()) == wanted
        assert ("4/8" in stream.getvalue()) == wanted
