"""Programs of G-code read, refitted, and held to the original by a controller that shares no code."""

import re

import numpy as np
import pytest

import cadfit
from cadfit.cli import main
from cadfit.toolpaths import moves, refit

from controller import Fault, compare, farthest, run

HEAD = "%\nO0001 (part)\nG21 G90 G17 G40 G94\nT1 M6\nS12000 M3\nG0 X0 Y0 Z5\n"
FOOT = "M5\nM30\n%\n"


def flower(n=400, petals=5):
    angle = np.linspace(0, 2 * np.pi, n)
    radius = 25 + 6 * np.cos(petals * angle)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


def program(points, feed=800, letters="XY"):
    rows = [" ".join(f"{a}{v:.4f}" for a, v in zip(letters, row, strict=True)) for row in points]
    lines = [f"G0 {rows[0]}", "G1 Z-1.0000 F200" if "Z" not in letters else "M7"]
    return "\n".join([*lines, f"G1 {rows[1]} F{feed}", *rows[2:], "G0 Z5", ""])


def refitted(text, tmp_path, tolerance=0.05, **options):
    source, target = tmp_path / "in.nc", tmp_path / "out.nc"
    source.write_text(text)
    done = refit(source, target, tolerance, **options)
    out = target.read_text()
    step = tolerance / 3
    assert done.deviation <= tolerance
    assert compare(text, out, step) <= done.deviation + step**2 / (16 * tolerance) + 1e-6  # radii: 2 tolerances or more
    assert done.moves[1] <= done.moves[0]
    return out, done


def test_a_flower_takes_few_arcs(tmp_path):
    out, done = refitted(HEAD + program(flower()) + FOOT, tmp_path)
    assert done.moves[0] >= 7 * done.moves[1]
    assert done.arcs >= 10
    assert done.smallest_radius > 1
    assert out.startswith(HEAD)
    assert out.endswith("G0 Z5\n" + FOOT)


@pytest.mark.parametrize("tolerance", [0.2, 0.02, pytest.param(0.002, marks=pytest.mark.slow)])
def test_the_bound_holds_at_any_tolerance(tmp_path, tolerance):
    _, done = refitted(HEAD + program(flower(1000)) + FOOT, tmp_path, tolerance)
    assert done.moves[0] > 3 * done.moves[1]


def test_every_plane_has_its_arcs(tmp_path):
    for letters, code in (("XZ", "G18"), ("YZ", "G19")):
        out, done = refitted(HEAD + program(flower(), letters=letters) + FOOT, tmp_path)
        assert done.moves[0] >= 7 * done.moves[1]
        assert code in out
        assert re.search(r"^G17$", out, re.M), "the plane is as it was before the untouched line after the run"


def test_a_path_in_space_takes_lines(tmp_path):
    t = np.linspace(0, 3, 500)
    points = np.column_stack([20 * np.cos(t), 15 * np.sin(2 * t), 3 * np.sin(3 * t)])
    _, done = refitted(HEAD + program(points, letters="XYZ") + FOOT, tmp_path)
    assert done.arcs == 0
    assert done.moves[0] > 3 * done.moves[1]


def helix(n=400, turns=4, pitch=1.5):
    t = np.linspace(0, 2 * np.pi * turns, n)
    radius = 20 + np.sin(t / 3)
    return np.column_stack([radius * np.cos(t), radius * np.sin(t), -pitch * t / (2 * np.pi)])


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [0.05, 0.01])
def test_an_even_climb_takes_helices(tmp_path, tolerance):
    out, done = refitted(HEAD + program(helix(), letters="XYZ") + FOOT, tmp_path, tolerance)
    assert done.moves[0] > 10 * done.moves[1]
    assert re.search(r"^G3 X\S+ Y\S+ Z-\S+ I\S+ J\S+", out, re.M)
    ramp, level = helix(300, 1), flower(800, 2) - flower(800, 2)[0]
    steps = np.concatenate([ramp, ramp[-1] + np.column_stack([level, 0 * level[:, 0]])[1:]])
    _, done = refitted(HEAD + program(steps, letters="XYZ") + FOOT, tmp_path, tolerance)
    assert done.moves[0] > 8 * done.moves[1]


def test_helices_of_the_program_are_merged(tmp_path):
    ends = 20 * np.array([[0, 1], [-1, 0], [0, -1], [1, 0]] * 3)
    rows = [f"G3 X{x} Y{y} Z{-0.25 * k:.4f} R20" for k, (x, y) in enumerate(ends, 1)]
    _, done = refitted(HEAD + "G0 X20 Y0\nG1 Z0 F200\nG1 F300\n" + "\n".join(rows) + "\nG0 Z5\n" + FOOT, tmp_path)
    assert done.moves == [13, 5]


BAD = {
    "G1 X1e9": "exponent",
    "G1 X1 0000000000": "beyond",
    "G1 X1 F" + 400 * "9": "beyond",
    "G1 X\n": "no number",
    "G2 X10 Y0 I4 J0": "do not match its centre",
    "G2 X10 Y0 R4": "no arc of radius",
    "G2 X10 Y0": "needs its centre",
    "G2 X10 Y0 I5 R5": "not both",
    "G3 X0 Y0 R5": "must end elsewhere",
    "G2 X10 Y0 I5 K1": "no offset",
    "G0 G1 X4": "two motions",
    "G1 X4 X5": "twice",
    "#1=5": "macro",
    "G1 X#1": "macro",
    "G1 X[1+2]": "macro",
    "o100 sub": "macro",
    "O7\nO8": "another program",
    "IF [#1 GT 2] GOTO 10": "macro",
    "M98 P1000": "not followed",
    "G65 P9810 X1": "macro",
    "G1 X3 (open": "not closed",
    "START_PRINT BED=60": "not G-code",
    "G1 X\x003": "0x00",
    "L X+10 Y+20 FMAX": "not G-code",
    "/G91": "skipped",
    "G1.23 X1": "no G1.23",
}


@pytest.mark.parametrize("line", BAD)
def test_a_bad_line_is_named_and_the_old_output_stays(tmp_path, line):
    source, target = tmp_path / "in.nc", tmp_path / "out.nc"
    source.write_text("G21\nG0 X0 Y0 Z0\n" + line + "\nG1 X5\n")
    target.write_text("old")
    with pytest.raises(ValueError, match=r"^line \d+: .*" + re.escape(BAD[line])):
        refit(source, target, 0.01)
    assert target.read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.nc", "out.nc"]


@pytest.mark.parametrize(
    "data", [b"\x7fELF\x02\x01\x01" + bytes(range(256)) * 9, b"X1 " * 9000, b"%\nG1 X1\n", b"G1 X1 (\xff", b""]
)
def test_what_is_no_program_is_refused(tmp_path, data):
    source, target = tmp_path / "in.nc", tmp_path / "out.nc"
    source.write_bytes(data)
    target.write_text("old")
    with pytest.raises(ValueError, match=r"^line \d+: "):
        refit(source, target, 0.01)
    assert target.read_text() == "old"


def test_on_the_command_line(tmp_path, capsys):
    source, target = tmp_path / "in.nc", tmp_path / "out.nc"
    source.write_text(HEAD + "G29\n" + program(flower()) + FOOT)
    assert main(["toolpath", str(source), "-t", "0.05", "-o", str(target)]) == 0
    out = capsys.readouterr().out
    for name in ("lines", "bytes", "cutting moves", "largest deviation", "arcs", "smallest radius", "length"):
        assert re.search(rf"^{name} +\d", out, re.M), name
    assert "G29 in line 7: left as they were" in out
    source.write_text("G1 X0 Y0\n#2=7\n")
    kept = target.read_text()
    assert main(["toolpath", str(source), "-t", "0.05", "-o", str(target)]) == 2
    assert capsys.readouterr().err.startswith(f"cadfit: {source}: line 2: ")
    assert main(["toolpath", str(target), "-t", "0.05", "-o", str(target)]) == 2
    assert target.read_text() == kept


@pytest.mark.parametrize("curves", ["g5", "poly"])
def test_cubic_pieces(tmp_path, curves):
    out, done = refitted(HEAD + program(flower()) + program(flower(300, 3)) + FOOT, tmp_path, curves=curves)
    assert done.arcs == 0
    assert done.moves[0] > 12 * done.moves[1]
    assert ("G5 X" in out) == (curves == "g5")
    assert ("POLY PO[X]=(" in out) == (curves == "poly")
    for code in re.findall(r"G0 Z5\nM5|^G1\n", out, re.M):
        assert code.startswith("G0")


def test_a_path_in_space_takes_polynomials(tmp_path):
    t = np.linspace(0, 3, 500)
    points = np.column_stack([20 * np.cos(t), 15 * np.sin(2 * t), 3 * np.sin(3 * t)])
    _, done = refitted(HEAD + program(points, letters="XYZ") + FOOT, tmp_path, curves="poly")
    assert done.moves[0] > 12 * done.moves[1]


def klartext(text, step):
    """The cutting path (n, 3) of a program in Heidenhain's plain language, and its blocks' first words."""
    at, path, heads, cutting = np.zeros(3), [], [], None
    for row, block in enumerate(text.replace("~\n", "").splitlines()):
        number, head, *words = block.split()
        assert int(number) == row
        heads.append(head)
        if head not in ("L", "SPL"):
            continue
        ends = {word[0]: float(word[1:]) for word in words if word[0] in "XYZ"}
        to = np.array([ends.get(axis, value) for axis, value in zip("XYZ", at, strict=True)])
        feed = next((word for word in words if word.startswith("F")), None)
        cutting = cutting if feed is None else feed
        if feed == "FMAX":
            at = to
            continue
        powers = np.zeros((4, 3))
        powers[0] = to
        if head == "SPL":
            for word in words:
                if word[0] == "K":
                    powers[int(word[1]), "XYZ".index(word[2])] = float(word[3:])
            assert np.abs(powers.sum(axis=0) - at).max() < 1e-6, "the end of the block before is the spline's start"
        else:
            powers[1] = at - to
        n = int(10 + 2 * np.abs(powers[1:]).sum() / step)
        t = np.linspace(1, 0, n)[:, None]
        path.append(((powers[3] * t + powers[2]) * t + powers[1]) * t + powers[0])
        at = to
    return np.concatenate(path), heads


def test_splines_in_plain_language(tmp_path):
    text = HEAD.replace(" G94", "") + program(flower()) + FOOT
    source, target = tmp_path / "in.nc", tmp_path / "out.h"
    source.write_text(text)
    done = refit(source, target, 0.05, curves="spl")
    assert done.moves[0] > 12 * done.moves[1]
    path, heads = klartext(target.read_text(), 0.01)
    assert heads[0] == "BEGIN"
    assert heads[-4:] == ["L", "M5", "M30", "END"]
    assert heads.count("SPL") == done.splines
    before = np.concatenate([event[2] for event in run(text, 0.01) if event[0] == "move"])
    assert farthest(before, path) <= done.deviation + 1e-4
    source.write_text(text.replace("G40", "G40 G54"))
    with pytest.raises(ValueError, match=r"line 3: G54 has no counterpart"):
        refit(source, target, 0.05, curves="spl")
    assert klartext(target.read_text(), 0.01)[1] == heads


def printed(points, absolute, start=0.0, flow=0.0333):
    """A printer's perimeter with its extrusion."""
    rows, total = [], start
    for (x, y), length in zip(points[1:], np.linalg.norm(np.diff(points, axis=0), axis=1), strict=True):
        total += flow * length
        rows.append(f"G1 X{x:.3f} Y{y:.3f} E{total if absolute else flow * length:.5f}\n")
    return f"G0 X{points[0, 0]:.3f} Y{points[0, 1]:.3f} F9000\nG1 F1800\n" + "".join(rows)


@pytest.mark.parametrize("absolute", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_print_extrudes_what_it_did(tmp_path, absolute):
    path = np.round(flower(), 3)
    head = f"; sliced\nG21\nG90\n{'M82' if absolute else 'M83'}\nM104 S210 ; heat\nG92 E0\n;LAYER:0\nG0 Z0.2\n"
    text = head + printed(path, absolute) + ";TYPE:fill\nG92 E0\n" + printed(path * 0.6, absolute, flow=0.05)
    out, done = refitted(text + "M117 Done, 1 of 1\nG1 E-1.5 F2400\nM107\n", tmp_path)
    assert done.moves[0] > 6 * done.moves[1]
    ends = re.findall(r"E([0-9.]+)", text)
    assert ("E" + ends[399]) in out or not absolute, "where E is absolute a run ends at the very number"


def test_a_run_ends_where_the_flow_changes(tmp_path):
    path = np.round(flower(), 3)
    text = "G21 G90\nM83\nG0 Z0.2\n" + printed(path[:200], False) + printed(path[200:], False, flow=0.06)
    _, done = refitted(text.replace("G1 F1800\n", "").replace("F9000", ""), tmp_path)
    assert done.runs[0] >= 2


def test_a_program_keeps_its_manner(tmp_path):
    rows = [f"N{10 * k} G01 X{x:.4f} Y{y:.4f} (rough)\r\n" for k, (x, y) in enumerate(flower(), 1)]
    text = "G21 G90 G17\r\nF300\r\nG0 X0 Y0\r\n" + "".join(rows) + "/M8\r\nG0 X0\r\n"
    source, target = tmp_path / "in.nc", tmp_path / "out.nc"
    source.write_bytes(text.encode())
    done = refit(source, target, 0.05)
    *lines, last = target.read_bytes().decode().split("\r\n")[3:-3]
    assert last == "G1", "the block that may be skipped finds the motion that it found before"
    assert len(lines) == done.moves[1]
    assert all(re.fullmatch(r"N\d+0 G[123]( [XYIJ]\S+)+ \(rough\)", line) for line in lines)
    numbers = [int(line.split()[0][1:]) for line in lines]
    assert numbers == sorted(set(numbers))
    assert numbers[-1] == 4000
    compact = "G21G90\nG0X0Y0Z0\n" + "".join(f"G1X{x:.3f}Y{y:.3f}F300\n" for x, y in flower())
    assert re.search(r"^G3X\S+Y\S+I\S+J\S+$", refitted(compact, tmp_path)[0], re.M)


def test_long_numbers_are_written_in_full(tmp_path):
    rows = [f"N{1234560 + 10 * k} G1 X{k}. F1234.56789\n" for k in range(4)]
    out, _ = refitted("G21 G90\nG0 X0 Y1 Z0\n" + "".join(rows), tmp_path)
    assert out.endswith("\nN1234590 G1 X3. F1234.56789\n")


def test_what_must_not_change_is_left(tmp_path):
    flat = "".join(f"X{x:.4f} Y{y:.4f}\n" for x, y in flower(80))
    for around in ("G41 D1", "G68 R30", "G93", "G51 P2", "G16"):
        out, done = refitted(f"G21 G90\nG0 X0 Y0 Z0\n{around}\nG1 F100\n{flat}", tmp_path, 0.2)
        assert done.runs == [0, 0], around
        assert out.endswith(flat)


def test_numbers_with_no_centre_nearby_are_kept(tmp_path):
    """A tolerance that the decimals cannot hold changes nothing."""
    text = HEAD + program(flower()) + FOOT
    out, done = refitted(text, tmp_path, 0.01, decimals=2)
    assert out == text
    assert done.moves[0] == done.moves[1]


def test_the_test_sees_a_path_that_strays(tmp_path):
    out, done = refitted(HEAD + program(flower()) + FOOT, tmp_path)
    text = (tmp_path / "in.nc").read_text()
    x = re.search(r"^G3 X(\S+) ", out, re.M).group(1)
    moved = out.replace(f"X{x} ", f"X{float(x) + 0.1:.4f} ", 1)
    with pytest.raises((AssertionError, Fault)):
        assert compare(text, moved, 0.01) <= done.deviation + 0.001
    for what, other in (("M5\n", ""), ("F800", "F801"), ("S12000", "S1200"), ("(part)", ""), ("G0 Z5", "G0 Z6")):
        with pytest.raises(AssertionError):
            compare(text, out.replace(what, other, 1), 0.05)


@pytest.mark.slow
def test_as_few_arcs_as_of_the_curve_itself(tmp_path):
    """The chords take part of the tolerance from one side and give it on the other: no more arcs than of the curve."""
    text = HEAD + program(flower()) + FOOT
    fast, best = (refitted(text, tmp_path, effort=effort)[1] for effort in ("fast", "best"))
    curve = cadfit.fit(flower()[:-1], 1e-4, closed=True, effort="fast")
    assert best.moves[1] <= fast.moves[1] <= 1.1 * len(cadfit.arcs(curve, 0.05)) + 1


def around(n, radius=20.0):
    """A circle in n arcs, the first from the right."""
    rows = [
        f"G3 X{radius * np.cos(a):.4f} Y{radius * np.sin(a):.4f} R{radius}" for a in 2 * np.pi * np.arange(n + 1) / n
    ]
    return f"G0 X{radius:.4f} Y0\nG1 Z-1 F200\nF300\n" + "\n".join(rows[1:]) + "\nG0 Z5\n"


def test_arcs_of_the_program_are_merged(tmp_path):
    _, done = refitted(HEAD + around(12) + FOOT, tmp_path)
    assert done.moves == [13, 3]
    assert done.arcs == 2
    chords = "\n".join(f"X{20 * np.cos(a):.4f} Y{20 * np.sin(a):.4f}" for a in np.linspace(0, np.pi / 2, 30)[1:])
    mixed = "G0 X20 Y0\nG1 Z-1 F200\nG1 F300\n" + chords + "\nG3 X-20 Y0 R20\nG0 Z5\n"
    _, done = refitted(HEAD + mixed + FOOT, tmp_path)
    assert done.moves == [31, 2]


def test_arcs_that_cannot_be_fewer_are_as_they_were(tmp_path):
    slot = "G0 X0 Y0\nG1 Z-1 F200\nG1 X40 F300\nG3 Y20 J10\nG1 X0\nG3 Y0 J-10\nG0 Z5\n"
    out, _ = refitted(HEAD + slot + FOOT, tmp_path)
    assert out == HEAD + slot + FOOT


def test_the_program_as_it_is_read(tmp_path):
    source = tmp_path / "in.nc"
    source.write_text("G21 G90 G17\nG0 X0 Y0 Z0\nG2 X10 Y0 I5 J0 F90\nG3 X10 Y0 Z-2 I-5\nG18 G2 X14 Z0 R4\nG1 X15\n")
    half, helix, up, line = moves(source)
    assert (half.arc.centre, half.arc.radius, half.feed) == ((5.0, 0.0), 5.0, 90.0)
    assert half.arc.sweep == pytest.approx(-np.pi)
    assert helix.arc.sweep == pytest.approx(2 * np.pi)
    assert helix.length == pytest.approx(np.hypot(10 * np.pi, 2))
    assert up.arc.plane == 18
    assert line.arc is None
    assert line.length == 1.0
