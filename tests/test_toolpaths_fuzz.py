"""Programs at random, and real ones damaged: each is refitted within its tolerance or refused by line, never else."""

import re
import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_toolpaths import FOOT, HEAD, flower, program

from cadfit.toolpaths import refit

from controller import Fault, compare, run

MODES = ["G90", "G91", "G17", "G18", "G19", "G90.1", "G91.1", "G21", "G20", "M82", "M83", "G92 E0", "G92 X1 Y2", "G80"]
ASIDE = ["M5", "M3 S900", "S1200", "G4 P1", "T2 M6", "G40", "(note)", "; note", "", "G54", "G28 X0", "G64 P0.01", "G29"]
ASIDE += ["G81 X1 Y1 Z-2 R1", "G41", "G53 G0 Z0", "M117 Layer 3", "/G1 X5", "G10 L2 P1 X0", "G5 X1 Y1 I1 J1 P1 Q0"]
NUMBERS = st.floats(-9, 9).map(lambda value: f"{value:.3f}")
WORDS = st.sampled_from(["F100", "F250", "(note)", "E1", "R5", "I1 J2", "I0.5", "K1"])


@st.composite
def curves(draw):
    """Cutting moves along an arc or a wave, as a run has them."""
    n, size = draw(st.integers(3, 60)), draw(st.sampled_from([0.3, 2.0, 20.0]))
    a, b = draw(st.sampled_from(["XY", "YX", "XZ", "YZ"]))
    t = np.linspace(0, draw(st.floats(0.2, 6.2)), n)
    rough = draw(st.sampled_from([0.0, 0.0, 0.01])) * np.random.default_rng(n).normal(size=(2, n))
    first, second = size * np.cos(t) + rough[0], size * np.sin(t * draw(st.sampled_from([1, 2]))) + rough[1]
    word = draw(st.sampled_from(["G1 ", ""]))
    extruded = draw(st.sampled_from(["", "", " E0.05"]))
    digits = draw(st.integers(2, 5))
    lines = [f"{word}{a}{x:.{digits}f} {b}{y:.{digits}f}{extruded}" for x, y in zip(first, second, strict=True)]
    return "\n".join(["G1", *lines])


@st.composite
def moves(draw):
    axes = draw(st.lists(st.sampled_from("XYZ"), min_size=1, max_size=3, unique=True))
    words = [draw(st.sampled_from(["G0", "G1", "G1", "G2", "G3", ""])), *(axis + draw(NUMBERS) for axis in axes)]
    return " ".join([*words, *draw(st.lists(WORDS, max_size=1))])


PROGRAMS = st.lists(
    st.one_of(st.sampled_from(MODES), st.sampled_from(ASIDE), moves(), curves(), curves()), max_size=12
).map(lambda lines: "G1 F90\nG0 X0 Y0 Z0\n" + "\n".join(lines) + "\n")


def judged(text, tolerance):
    """Refit a program; if it is not refused, hold the result to the original."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.nc"), Path(folder, "out.nc")
        source.write_bytes(text.encode())
        target.write_text("old")
        try:
            done = refit(source, target, tolerance)
        except ValueError as error:
            refused = str(error)
        else:
            refused = ""
        if refused:
            assert re.match(r"line \d+: ", refused)
            assert target.read_text() == "old"
            return
        out = target.read_bytes().decode("utf-8", "surrogateescape")
        text = source.read_bytes().decode("utf-8", "surrogateescape")
    assert done.moves[1] <= done.moves[0]
    step = max(tolerance / 4, 0.002)
    try:
        run(text, step)
    except Fault:  # of the program's own, where nothing is refitted: after a tool change, say, no place is known
        with pytest.raises(Fault):
            run(out, step)
        return
    unit = 25.4 if "G20" in text else 1.0
    assert compare(text, out, step) <= done.deviation + step**2 / (16 * tolerance) + 1e-5 * unit
    assert done.deviation <= tolerance


@pytest.mark.slow
@given(PROGRAMS, st.sampled_from([0.2, 0.05, 0.01]))
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_programs_at_random(text, tolerance):
    judged(text, tolerance)


@pytest.mark.slow
@given(PROGRAMS, st.sampled_from([0.2, 0.05, 0.01]))
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_many_programs_at_random(text, tolerance):
    judged(text, tolerance)


WHOLE = HEAD + program(flower(120)) + "(second)\n" + program(flower(90, 3) / 2) + FOOT
LETTERS = "GXYZIJKRFSMNTEO0123456789.-+ ();%/#[]\n\x00é"


@pytest.mark.slow
@given(st.data())
@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_damaged_programs(data):
    damaged(data)


@pytest.mark.slow
@given(st.data())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_many_damaged_programs(data):
    damaged(data)


def damaged(data):
    """Change, cut and add letters here and there, and judge what becomes of it."""
    text = WHOLE
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        cut = data.draw(st.integers(0, 6))
        text = text[:at] + data.draw(st.text(LETTERS, max_size=3)) + text[at + cut :]
    if data.draw(st.booleans()):
        text = text[: data.draw(st.integers(1, len(text)))]
    with suppress(Fault):  # the test's controller stops, at the original, too
        judged(text, 0.05)
