"""Refitted programs run by LinuxCNC's own interpreter, `rs274` (Debian's package linuxcnc-uspace), where it is there.

It prints what it tells the machine, in absolute places of four decimals; that is held to what it prints before.
"""

import re
import shutil
import subprocess

import numpy as np
import pytest
from test_toolpaths import FOOT, HEAD, flower, helix, program

from cadfit.toolpaths import refit

from controller import compare

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC's rs274 is not installed"),
]
PLANES = {"XY": ("G17", "XYZIJ"), "XZ": ("G18", "ZXYKI"), "YZ": ("G19", "YZXJK")}


def told(path):
    """What rs274 tells the machine, as a program of absolute places and centres."""
    done = subprocess.run(["rs274", "-g", str(path)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
    lines = ["G90.1"]
    letters = PLANES["XY"][1]
    for name, inside in re.findall(r"N\.\.\.\.\. ([A-Z0-9_]+)\((.*)\)", done.stdout):
        values = inside.split(", ")
        if name in ("STRAIGHT_FEED", "STRAIGHT_TRAVERSE"):
            places = " ".join(axis + value for axis, value in zip("XYZ", values, strict=False))
            lines.append(f"G{int(name == 'STRAIGHT_FEED')} {places}")
        elif name == "ARC_FEED":
            a, b, c, i, j = letters
            x, y, cx, cy, turn, z = values[:6]
            lines.append(f"G{3 if int(turn) > 0 else 2} {a}{x} {b}{y} {c}{z} {i}{cx} {j}{cy}")
        elif name == "SELECT_PLANE":
            code, letters = PLANES[inside.removeprefix("CANON_PLANE_")]
            lines.append(code)
        elif name == "USE_LENGTH_UNITS":
            lines.append("G21" if inside.endswith("MM") else "G20")
        elif name == "SET_FEED_RATE":
            lines.append(f"F{inside}")
        else:
            lines.append(f"({name} {inside.replace('(', '[').replace(')', ']')})")
    assert len(lines) > 10
    return "\n".join(lines)


def held(text, tmp_path, tolerance, **options):
    source, target = tmp_path / "in.ngc", tmp_path / "out.ngc"
    source.write_text(text)
    done = refit(source, target, tolerance, **options)
    step = tolerance / 8
    apart = compare(told(source), told(target), step)
    assert apart <= done.deviation + step**2 / (16 * tolerance) + 2e-4 * (
        25.4 if "G20" in text else 1.0
    )  # what it prints is rounded
    return done


HEAD = HEAD.replace("O0001 (part)\n", "").replace("T1 M6\n", "")


@pytest.mark.parametrize("letters", ["XY", "XZ", "YZ"])
@pytest.mark.parametrize("decimals", [3, 5])
def test_arcs_in_each_plane(tmp_path, letters, decimals):
    done = held(HEAD + program(flower(), letters=letters) + FOOT, tmp_path, 0.05, decimals=decimals)
    assert done.arcs > 10


def test_helices(tmp_path):
    done = held(HEAD + program(helix(), letters="XYZ") + FOOT, tmp_path, 0.05)
    assert 0 < done.arcs < 16


def test_small_tolerances_and_features(tmp_path):
    for size in (1.0, 0.1, 0.02):
        held(HEAD + program(flower() * size) + FOOT, tmp_path, 0.02 * size + 0.001, decimals=3)


def test_places_from_the_last_one_and_inches(tmp_path):
    steps = np.diff(np.round(flower(), 4), axis=0)
    body = "G91\n" + "\n".join(f"G1 X{x:.4f} Y{y:.4f}" for x, y in steps) + "\nG90\n"
    held("G21 G17\nF500\nG0 X31 Y0 Z5\nG1 Z-1\n" + body + "G0 Z5\nM2\n", tmp_path, 0.05)
    held("G20 G17\nF50\nG0 X1 Y0 Z1\nG1 Z-0.1\n" + program(flower() / 25.4) + "M2\n", tmp_path, 0.05)
