"""Sweeps against the others': `trimesh.creation.sweep_polygon`, pyvista's tube filter, OCCT through build123d.

One circle along paths that are known to be hard, each at 200, 2,000 and 20,000 stations (the others are given that
many; cadfit the tolerance that asks for about as many), 16 sides, one run, medians of repeats, warm; and the first call
of a fresh process, its function imported. The columns: seconds; whether the mesh is watertight as emitted, vertices
taken as they are numbered; the largest turn of one ring against the next about the path beyond what
rotation-minimizing frames turn, in degrees, from the first corner of each ring; the turn across the seam of a closed
path; the volume against area times length (bent tighter than the radius or cusped, against that of a finely repaired
mesh); faces. An entry that is wrong is in bold: not watertight, a turn above a degree that the path does not explain, a
volume off by more than 1 % (at 200 stations 3 %), or no answer and no error that says why.

pyvista and build123d are taken where they are installed. OCCT sweeps with its default mode and tessellates at the same
tolerance; it is given a time limit for each case.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Sequence
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


NAMES = ("helix", "trefoil", "vertical S", "inflection", "corner", "cusp", "tight bend")


def path_of(name: str) -> tuple[cadfit.BSpline, float]:
    """Return one of the hard paths, and the radius that goes along it."""

    def through(
        curve: Callable[[Array], tuple[object, ...]], stop: float, count: int, closed: bool = False
    ) -> cadfit.BSpline:
        t = np.linspace(0.0, stop, count, endpoint=not closed)
        return cadfit.local_spline(np.column_stack(np.broadcast_arrays(*curve(t))), closed=closed)

    def one(*poles: list[float]) -> cadfit.BSpline:
        return cadfit.BSpline(poles, [0, 0, 0, 0, 1, 1, 1, 1])

    full = 2.0 * np.pi
    match name:
        case "helix":
            return through(lambda t: (10 * np.cos(t), 10 * np.sin(t), t), 10 * full, 240), 1.0
        case "trefoil":
            knot = lambda t: (np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t))  # noqa: E731
            return through(knot, full, 60, closed=True), 0.25
        case "vertical S":
            return through(lambda t: (1.3 * np.sin(t), 0.0 * t, t - np.pi), full, 17), 0.35
        case "inflection":
            bend = one([0, 0, 0], [2, 0, 0], [2, 2, 0], [4, 2, 1])
            return cadfit.join([cadfit.polyline([[-3, 0, 0], [0, 0, 0]]), bend]), 0.2
        case "corner":
            return cadfit.polyline([[0, 0, 0], [10, 0, 0], [10, 10, 0]]), 1.0
        case "cusp":
            return one([0, 0, 0], [3, 3, 0], [0, 3, 0], [3, 0, 0]), 0.1
        case "tight bend":
            return one([-4, 4, 0], [0.5, -4, 0], [-0.5, -4, 0], [4, 4, 0]), 1.5
    raise KeyError(name)


def case_of(name: str) -> Case:
    """Return a path with the volume to be met: area times length, or where there is no closed form a fine repair's."""
    path, radius = path_of(name)
    smooth = name not in ("cusp", "tight bend")
    volume = np.pi * radius**2 * path.length()
    if not smooth:
        volume = float(cadfit.tube(path, radius, 0.01 * radius, on_self_intersection="repair").volume)
    return Case(path, radius, volume, smooth, straight=name == "corner")


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


def occt_case(name: str, stations: int, tolerance: float, out: str) -> None:
    """Sweep one path by the plain sweep of build123d, which is what its users call, along the same points.

    Prints the seconds of the sweep and of its tessellation, and the solid's volume, and writes the mesh.
    """
    from build123d import Circle, Edge, Plane, Vector, sweep

    path, radius = path_of(name)
    points = path(np.linspace(*path.domain, stations))
    edge = Edge.make_spline([Vector(*point) for point in points[: len(points) - path.closed]], periodic=path.closed)
    disc = Plane(origin=edge @ 0, z_dir=edge % 0) * Circle(radius)
    print("ready", flush=True)
    start = perf_counter()
    solid = sweep(disc, path=edge)
    vertices, faces = solid.tessellate(tolerance)
    seconds = perf_counter() - start
    trimesh.Trimesh([tuple(v) for v in vertices], faces, process=False).export(out)
    print(seconds, float(solid.volume), flush=True)


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


def first_calls(stations: int) -> tuple[float, float]:
    """Return the seconds of the first call in a fresh process that has imported both functions: tube, sweep_polygon.

    trimesh's engine for polygons is imported by its call.
    """
    setup = (
        "import time, numpy as np, shapely, sweep\n"
        "from cadfit import tube\n"
        "from trimesh.creation import sweep_polygon\n"
        "path, radius = sweep.path_of('trefoil')\n"
        "profile = shapely.Polygon(radius * sweep.disc(sweep.SIDES))\n"
        f"points = path(np.linspace(*path.domain, {stations}))\n"
        "s = time.perf_counter()\n"
    )
    tolerance = tolerance_for(case_of("trefoil"), stations)
    found = []
    for call in (f"tube(path, radius, {tolerance}, sides=sweep.SIDES)", "sweep_polygon(profile, points)"):
        code = f"{setup}{call}\nprint(time.perf_counter() - s)"
        runs = [
            subprocess.run([sys.executable, "-c", code], cwd=HERE, capture_output=True, text=True, check=True)
            for _ in range(7)
        ]
        found.append(median(float(run.stdout) for run in runs))
    return found[0], found[1]


def occt_timed(name: str, stations: int, tolerance: float) -> tuple[float | None, trimesh.Trimesh | str]:
    """Run one case of OCCT in a process of its own, so that a time limit holds once its imports are done."""
    with tempfile.TemporaryDirectory() as folder:
        out = f"{folder}/mesh.ply"
        code = f"import sweep; sweep.occt_case({name!r}, {stations}, {tolerance!r}, {out!r})"
        process = subprocess.Popen(
            [sys.executable, "-c", code], cwd=HERE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert process.stdout is not None
        process.stdout.readline()
        try:
            answer, complaint = process.communicate(timeout=OCCT_LIMIT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return None, f"over {OCCT_LIMIT} s"
        if process.returncode < 0:
            return None, f"crashed (signal {-process.returncode})"
        if process.returncode:
            return None, "failed: " + (complaint.strip().splitlines() or ["no message"])[-1][:60]
        seconds, volume = map(float, answer.split())
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


def rows_of(name: str, stations: int) -> list[str]:
    """Return the rows of one path at so many stations."""
    case = case_of(name)
    tolerance = tolerance_for(case, stations)
    repair = not case.smooth
    (seconds,) = interleaved([lambda: ours(case, tolerance, repair)], REPEATS, max(1, 400 // stations))
    mine = row(name, stations, "cadfit", seconds, ours(case, tolerance, repair), case)
    return [mine, *others(name, case, stations, tolerance)]


def table(names: Sequence[str] = NAMES) -> str:
    rows = []
    for stations in STATIONS if find_spec("shapely") else ():
        mine, theirs = (f"{seconds * 1e3:.1f} ms" for seconds in first_calls(stations))
        rows += [f"First call along the trefoil at {stations:,} stations: cadfit {mine}, sweep_polygon {theirs}.", ""]
    rows += [
        "| path | stations | | time | watertight | turn | seam | volume off | faces |",
        "| --- | ---: | --- | ---: | --- | ---: | ---: | ---: | ---: |",
    ]
    for name in names:
        for stations in STATIONS if name not in ("cusp", "tight bend") else STATIONS[:2]:
            rows += rows_of(name, stations)
            print(name, stations, file=sys.stderr, flush=True)
    return "\n".join(rows)


if __name__ == "__main__":
    print(table(sys.argv[1:] or NAMES))
