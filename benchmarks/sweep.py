"""Sweeps against the others': `trimesh.creation.sweep_polygon`, pyvista's tube filter, OCCT through build123d.

One circle along paths that are known to be hard, each at 200, 2,000 and 20,000 stations (the others are given that
many; cadfit the tolerance that asks for about as many), 16 sides, one run, medians of repeats, warm; and the first call
of a fresh process. The columns: seconds; whether the mesh is watertight as emitted, vertices taken as they are
numbered; the largest turn of one ring against the next about the path beyond what rotation-minimizing frames turn, in
degrees, from the first corner of each ring; the turn across the seam of a closed path; the volume against area times
length (bent tighter than the radius or cusped, against that of a finely
repaired mesh); faces. An entry that is wrong is in bold: not watertight, a turn above a degree that the path does not
explain, a volume off by more than 1 % (at 200 stations 3 %), or no answer and no error that says why.

pyvista and build123d are taken where they are installed. OCCT sweeps with its default mode and tessellates at the same
tolerance; it is given a time limit for each case.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from time import perf_counter
from unittest.mock import patch

import numpy as np
import trimesh

import cadfit
from cadfit.bezier import Array
from cadfit.sweeping.mesh import disc
from cadfit.sweeping.selfintersection import SelfIntersectionWarning

from timing import interleaved

SIDES = 16
STATIONS = (200, 2_000, 20_000)
HERE = Path(__file__).parent
REPEATS = 3
OCCT_LIMIT = 60  # seconds for a case
OCCT_MOST = 2_000  # stations: more takes OCCT minutes


@dataclass(frozen=True)
class Case:
    """A path, a radius, and the volume to be met."""

    path: cadfit.BSpline
    radius: float
    volume: float
    smooth: bool = True
    straight: bool = False


def cases() -> dict[str, Case]:
    """Return the hard paths by name."""

    def sampled(curve: Callable[[Array], tuple[object, ...]], stop: float, count: int, closed: bool = False) -> Array:
        t = np.linspace(0.0, stop, count, endpoint=not closed)
        return np.column_stack(np.broadcast_arrays(*curve(t)))

    full = 2.0 * np.pi
    spline = cadfit.local_spline
    knots = [0, 0, 0, 0, 1, 1, 1, 1]
    paths = {
        "helix": (spline(sampled(lambda t: (10 * np.cos(t), 10 * np.sin(t), t), 10 * full, 240)), 1.0),
        "trefoil": (
            spline(
                sampled(
                    lambda t: (np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)),
                    full,
                    60,
                    closed=True,
                ),
                closed=True,
            ),
            0.25,
        ),
        "vertical S": (spline(sampled(lambda t: (1.3 * np.sin(t), 0.0 * t, t - np.pi), full, 17)), 0.35),
        "inflection": (
            cadfit.join(
                [
                    cadfit.polyline([[-3, 0, 0], [0, 0, 0]]),
                    cadfit.BSpline([[0, 0, 0], [2, 0, 0], [2, 2, 0], [4, 2, 1]], knots),
                ]
            ),
            0.2,
        ),
        "corner": (cadfit.polyline([[0, 0, 0], [10, 0, 0], [10, 10, 0]]), 1.0),
        "cusp": (cadfit.BSpline([[0, 0, 0], [3, 3, 0], [0, 3, 0], [3, 0, 0]], knots), 0.1),
        "tight bend": (cadfit.BSpline([[-4, 4, 0], [0.5, -4, 0], [-0.5, -4, 0], [4, 4, 0]], knots), 1.5),
    }
    found = {}
    for name, (path, radius) in paths.items():
        smooth = name not in ("cusp", "tight bend")
        volume = np.pi * radius**2 * path.length()
        if not smooth:  # no closed form: a mesh repaired
            volume = float(cadfit.tube(path, radius, 0.01 * radius, on_self_intersection="repair").volume)
        found[name] = Case(path, radius, volume, smooth, straight=name == "corner")
    return found


def tolerance_for(case: Case, stations: int) -> float:
    """Return a tolerance at which cadfit gives about so many rings, at most a fifth of the radius.

    The number of rings goes by its square root.
    """
    tolerance = 0.02 * case.radius
    for _ in range(3):
        rings = len(ours(case, tolerance).vertices) // SIDES
        tolerance = min(tolerance * (rings / stations) ** 2, 0.2 * case.radius)
        if case.straight:
            break
    return tolerance


def ours(case: Case, tolerance: float, repair: bool = False) -> trimesh.Trimesh:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SelfIntersectionWarning)
        answer = "repair" if repair else "warn"
        return cadfit.tube(case.path, case.radius, tolerance, sides=SIDES, on_self_intersection=answer)


def sweep_polygon(case: Case, stations: int) -> Callable[[], trimesh.Trimesh]:
    corners = case.radius * disc(SIDES)
    points = case.path(np.linspace(*case.path.domain, stations))
    try:
        import shapely

        profile = shapely.Polygon(corners)
        trimesh.creation.triangulate_polygon(profile)
        return lambda: trimesh.creation.sweep_polygon(profile, points)
    except (ImportError, ValueError):  # handed its triangulation, which spares it that work
        fan = np.arange(1, SIDES - 1)
        triangles = np.column_stack([0 * fan, fan, fan + 1])

        def call() -> trimesh.Trimesh:
            with patch("trimesh.creation.triangulate_polygon", lambda *_, **__: (corners, triangles)):
                return trimesh.creation.sweep_polygon(None, points)

        return call


def pyvista_tube(case: Case, stations: int) -> Callable[[], trimesh.Trimesh] | None:
    try:
        import pyvista
    except ImportError:
        return None
    points = case.path(np.linspace(*case.path.domain, stations))

    def call() -> trimesh.Trimesh:
        line = pyvista.lines_from_points(points)
        mesh = line.tube(radius=case.radius, n_sides=SIDES, capping=True).triangulate()
        return trimesh.Trimesh(mesh.points, mesh.faces.reshape(-1, 4)[:, 1:], process=False)

    return call


def occt_sweep(case: Case, stations: int, tolerance: float) -> trimesh.Trimesh:
    """Return the plain sweep of build123d along the same points, tessellated: what its users call."""
    from build123d import Circle, Edge, Plane, Vector, sweep

    points = case.path(np.linspace(*case.path.domain, stations))
    edge = Edge.make_spline(
        [Vector(*point) for point in points[: len(points) - case.path.closed]], periodic=case.path.closed
    )
    start = Plane(origin=edge @ 0, z_dir=edge % 0)
    solid = sweep(start * Circle(case.radius), path=edge)
    vertices, faces = solid.tessellate(tolerance)
    mesh = trimesh.Trimesh([tuple(v) for v in vertices], faces, process=False)
    mesh.metadata["valid"] = bool(solid.is_valid)
    mesh.metadata["volume"] = float(solid.volume)
    return mesh


def turns(mesh: trimesh.Trimesh, case: Case, rings: Array) -> tuple[float, float]:
    """Return the largest turn of a ring to the next about the path beyond the frames', and that across the seam."""
    arms = rings[:, 0] - rings.mean(axis=1)
    u, _ = case.path.nearest(rings.mean(axis=1))
    order = np.maximum.accumulate(u)
    f = cadfit.frames(case.path, order)
    angle = np.arctan2(np.einsum("nd,nd->n", arms, f.binormals), np.einsum("nd,nd->n", arms, f.normals))
    steps = (np.diff(angle) + np.pi) % (2 * np.pi) - np.pi
    largest = float(np.degrees(np.abs(steps).max(initial=0.0)))
    seam = float(np.degrees(abs((angle[0] - angle[-1] + np.pi) % (2 * np.pi) - np.pi))) if case.path.closed else 0.0
    return largest, seam


def row(name: str, stations: int, who: str, seconds: float | None, mesh: trimesh.Trimesh | str, case: Case) -> str:
    """Return a row of the table; `mesh` may be what went wrong instead."""
    if isinstance(mesh, str):
        return f"| {name} | {stations:,} | {who} | **{mesh}** | | | | | |"
    limit = 0.03 if stations <= 200 else 0.01
    off = float(mesh.metadata.get("volume", mesh.volume)) / case.volume - 1.0
    turn = seam = np.nan
    if who in ("cadfit", "sweep_polygon") and case.smooth and name not in ("corner", "inflection"):
        count = len(mesh.vertices) // SIDES
        turn, seam = turns(mesh, case, np.asarray(mesh.vertices[: count * SIDES]).reshape(count, SIDES, 3))
    cells = [
        "" if seconds is None else f"{seconds * 1e3:.1f} ms",
        "yes" if mesh.is_watertight else "**no**",
        "" if np.isnan(turn) else f"{turn:.2f}" if turn < 1.0 else f"**{turn:.0f}**",
        "" if np.isnan(seam) or not case.path.closed else f"{seam:.2f}" if seam < 5.0 else f"**{seam:.0f}**",
        f"{100 * off:+.3f} %" if abs(off) <= limit else f"**{100 * off:+.1f} %**",
        f"{len(mesh.faces):,}",
    ]
    return f"| {name} | {stations:,} | {who} | " + " | ".join(cells) + " |"


def first_calls() -> tuple[float, float]:
    """Return the seconds of the first call in a fresh process that has imported both libraries: cadfit, trimesh."""
    setup = (
        "import numpy as np, trimesh, cadfit, time, sweep, tubes\n"
        "case = sweep.Case(tubes.helix(), 1.0, 0.0)\n"
        "theirs = sweep.sweep_polygon(case, 200)\n"
        "s = time.perf_counter()\n"
    )
    found = []
    for call in ("cadfit.tube(case.path, case.radius, 0.05, sides=16)", "theirs()"):
        code = f"{setup}{call}\nprint(time.perf_counter() - s)"
        runs = [
            subprocess.run([sys.executable, "-c", code], cwd=HERE, capture_output=True, text=True, check=True)
            for _ in range(5)
        ]
        found.append(median(float(run.stdout) for run in runs))
    return found[0], found[1]


def occt_case(name: str, stations: int, tolerance: float, out: str) -> None:
    """Sweep one case with OCCT, print the seconds and the solid's volume, and write its mesh."""
    case = cases()[name]
    start = perf_counter()
    mesh = occt_sweep(case, stations, tolerance)
    print(perf_counter() - start, mesh.metadata["volume"])
    mesh.export(out)


def occt_timed(name: str, stations: int, tolerance: float) -> tuple[float | None, trimesh.Trimesh | str]:
    """Run one case of OCCT in a process of its own, so that a time limit holds."""
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/mesh.ply"
        code = f"import sweep; sweep.occt_case({name!r}, {stations}, {tolerance!r}, {out!r})"
        try:
            run = subprocess.run(
                [sys.executable, "-c", code], cwd=HERE, capture_output=True, text=True, timeout=OCCT_LIMIT
            )
        except subprocess.TimeoutExpired:
            return None, f"over {OCCT_LIMIT} s"
        if run.returncode:
            return None, "failed"
        seconds, volume = map(float, run.stdout.split())
        mesh = trimesh.load_mesh(out, process=False)
    mesh.metadata["volume"] = volume
    return seconds, mesh


def others(name: str, case: Case, stations: int, tolerance: float) -> list[str]:
    """Return the rows of those that are installed."""
    rows = []
    for who, call in (("sweep_polygon", sweep_polygon(case, stations)), ("pyvista", pyvista_tube(case, stations))):
        if call is not None:
            (seconds,) = interleaved([call], REPEATS, 1)
            rows.append(row(name, stations, who, seconds, call(), case))
    if find_spec("build123d") and stations <= OCCT_MOST:
        rows.append(row(name, stations, "OCCT", *occt_timed(name, stations, tolerance), case))
    return rows


def table() -> str:
    mine, theirs = first_calls()
    rows = [
        f"First call at 200 stations: cadfit {mine * 1e3:.1f} ms, sweep_polygon {theirs * 1e3:.1f} ms.",
        "",
        "| path | stations | | time | watertight | turn | seam | volume off | faces |",
        "| --- | ---: | --- | ---: | --- | ---: | ---: | ---: | ---: |",
    ]
    for name, case in cases().items():
        for stations in STATIONS if case.smooth else STATIONS[:2]:
            tolerance = tolerance_for(case, stations)
            repair = not case.smooth
            (seconds,) = interleaved([lambda: ours(case, tolerance, repair)], REPEATS, max(1, 400 // stations))  # noqa: B023
            rows.append(row(name, stations, "cadfit", seconds, ours(case, tolerance, repair), case))
            rows += others(name, case, stations, tolerance)
            print(name, stations, file=sys.stderr, flush=True)
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
