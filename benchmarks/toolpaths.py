"""Programs of the corpus' kinds refitted at 0.05 and 0.01 mm: moves before and after, and what a controller does.

Perimeters of sliced meshes, passes of a ball-end mill over meshes (in X and Z), a milled figure, letters engraved at a
height of 10 mm, sections of meshes in their own size, and two made curves. "off" is the largest distance between the
paths of both programs, run by the controller of the tests; the bound is what the program says.
"""

from __future__ import annotations

import sys
import tempfile
from itertools import groupby
from pathlib import Path
from time import process_time

import numpy as np
from rich.progress import track

from cadfit.toolpaths import refit

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from controller import compare
from corpus_data import ABSENT, PRESENT, _corpus

HEAD = "%\n(made)\nG21 G90 G17\nS12000 M3\nG0 Z5.\n"
FOOT = "M5\nM30\n%\n"
FLOW = 0.033  # millimetres of filament a millimetre


def run(points, feed=800, extruded=False):
    """The lines that cut along points (n, d)."""
    rows = [" ".join(f"{axis}{value:.4f}" for axis, value in zip("XYZ", row, strict=False)) for row in points]
    keep = [0, *[k for k in range(1, len(rows)) if rows[k] != rows[k - 1]]]
    rows, points = [rows[k] for k in keep], points[keep]
    if extruded:
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        rows[1:] = [f"{row} E{FLOW * length:.5f}" for row, length in zip(rows[1:], lengths, strict=True)]
    return [f"G0 {rows[0]}", f"G1 F{feed}", *(f"G1 {row}" for row in rows[1:])]


def program(paths, extruded=False):
    """A program that cuts along paths, one after the other."""
    lines = [line for path in paths for line in ["G0 Z5.", *run(path, extruded=extruded)]]
    return HEAD + ("M83\n" if extruded else "") + "\n".join(lines) + "\n" + FOOT


def _closed(curve, scale=1.0):
    points = curve.points * scale
    return np.concatenate([points, points[:1]]) if curve.closed else points


def made():
    """A flower and a spiral, as programs."""
    t = np.linspace(0, 2 * np.pi, 1500)
    flower = (25 + 6 * np.cos(5 * t))[:, None] * np.column_stack([np.cos(t), np.sin(t)])
    t = np.linspace(0, 10 * np.pi, 3000)
    spiral = (2 + 1.2 * t)[:, None] * np.column_stack([np.cos(t), np.sin(t)])
    yield "flower", program([flower])
    yield "spiral", program([spiral])


def real():
    """The corpus' curves as programs, those of one model or file together."""
    load = _corpus().load
    for name, group in groupby(load(family="toolpath_fdm"), key=lambda curve: curve.name.split("#")[0]):
        yield f"sliced: {name}", program([curve.points for curve in group], extruded=True)
    mill = load(family="toolpath_mill")
    for name, group in groupby(mill, key=lambda curve: curve.name.rsplit("_", 1)[0].split("#")[0]):
        yield f"milled: {name.split('/')[-1]}", program([curve.points for curve in group])
    letters = [_closed(curve, 10 / 1466) for curve in load(family="font_outline")]
    yield "engraved: letters", program(letters)
    units = {"in": 25.4, "inches": 25.4}
    sections = groupby(load(family="mesh_section"), key=lambda curve: curve.name.split("#")[0])
    for name, group in sections:
        yield f"section: {name}", program([_closed(curve, units.get(curve.units, 1.0)) for curve in group])


def row(name, text, tolerance):
    """A row of the table."""
    cells = []
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "in.nc"), Path(folder, "out.nc")
        source.write_text(text)
        for effort in ("fast", "best"):
            start = process_time()
            done = refit(source, target, tolerance, effort=effort)
            took = process_time() - start
            cells.append(f"{done.moves[1]:,} | {done.moves[0] / done.moves[1]:.1f} | {took:.1f} s")
        off = compare(text, target.read_text(), tolerance / 4)
    change = 100.0 * (done.length[1] / done.length[0] - 1.0)
    size = f"{done.bytes[0] / 1e3:.1f} to {done.bytes[1] / 1e3:.1f}"
    tail = f"{size} | {done.deviation:.4f} | {off:.4f} | {done.smallest_radius:.2f} | {change:+.3f} %"
    return f"| {name} | {done.moves[0]:,} | " + " | ".join(cells) + f" | {tail} |"


def table(tolerances=(0.05, 0.01)):
    """The tables, one a tolerance, in Markdown."""
    programs = [*made(), *(real() if PRESENT else [])]
    parts = [] if PRESENT else [ABSENT]
    for tolerance in tolerances:
        parts.append(
            f"\n| {tolerance} mm | moves | fast | fewer | takes | best | fewer | takes "
            "| kB | bound | off | least radius | length |\n| --- |" + " ---: |" * 12
        )
        for name, text in track(programs, f"at {tolerance} mm", disable=None):
            parts.append(row(name, text, tolerance))
            print(parts[-1], file=sys.stderr)
    return "\n".join(parts)


if __name__ == "__main__":
    print(table())
