"""Tubes against `trimesh.creation.sweep_polygon`: the same stations and sides, one run, warm, medians of repeats.

`from stations` starts, on both sides, from what the path is at the stations: its points, for cadfit the tangents too.
`tube` is the whole call, which finds the path's pieces, looks for corners and bends that are too tight, and chooses its
own stations, about as many. trimesh triangulates its polygon with what is installed (shapely, and mapbox-earcut or
manifold3d); where nothing is, it is handed the triangulation and the work is spared it.
"""

from contextlib import AbstractContextManager, nullcontext
from unittest.mock import patch

import numpy as np
import trimesh

import cadfit
from cadfit.bezier import Array
from cadfit.sweeping.chain import chain
from cadfit.sweeping.mesh import around, disc
from cadfit.sweeping.stations import stationed

from timing import interleaved

SIDES = 16
RADIUS = 1.0


def helix() -> cadfit.BSpline:
    t = np.linspace(0.0, 20.0 * np.pi, 60)
    return cadfit.cardinal_spline(np.column_stack([10 * np.cos(t), 10 * np.sin(t), t]), curvature=1.0)


def placed(path: cadfit.BSpline, stations: int) -> tuple[Array, Array]:
    """Return points and unit tangents (3, n) of the path at evenly spaced stations."""
    u = np.linspace(*path.domain, stations)
    tangents = path.derivative(u).T
    return np.ascontiguousarray(path(u).T), tangents / np.linalg.norm(tangents, axis=0)


def tolerance_for(path: cadfit.BSpline, stations: int) -> float:
    """Return the tolerance at which the path gets about so many stations."""
    low, high = 1e-12, 10.0
    for _ in range(40):
        middle = np.sqrt(low * high)
        points, _ = stationed(chain(path), RADIUS, 0.5 * middle)
        low, high = (middle, high) if points.shape[1] >= stations else (low, middle)
    return high


def polygon() -> tuple[object, str, AbstractContextManager[object]]:
    """Return trimesh's polygon, how it is triangulated, and the context in which that works."""
    corners = RADIUS * disc(SIDES)
    try:
        import shapely

        profile = shapely.Polygon(corners)
        trimesh.creation.triangulate_polygon(profile)
        return profile, "triangulating its polygon, as its users call it", nullcontext()
    except (ImportError, ValueError):  # no shapely, or no engine
        fan = np.arange(1, SIDES - 1)
        triangles = np.column_stack([0 * fan, fan, fan + 1])
        spared = patch("trimesh.creation.triangulate_polygon", lambda *_, **__: (corners, triangles))
        return None, "handed its triangulation", spared


def table() -> str:
    path = helix()
    profile, how, context = polygon()
    rows = [
        f"`sweep_polygon` is {how}.",
        "",
        "| stations | sweep_polygon | cadfit from stations | times faster | cadfit.tube | times faster |",
        "| ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for stations in (200, 2_000, 20_000):
        points, tangents = placed(path, stations)
        tolerance = tolerance_for(path, stations)
        rows_of_points = np.ascontiguousarray(points.T)
        calls = [
            lambda points=rows_of_points: trimesh.creation.sweep_polygon(profile, points),
            lambda points=points, tangents=tangents: around(points, tangents, False, RADIUS, SIDES, 0.01),
            lambda tolerance=tolerance: cadfit.tube(path, RADIUS, tolerance, sides=SIDES),
        ]
        with context:
            theirs, ours, whole = interleaved(calls, 21, max(1, 4_000 // stations))
        rows.append(
            f"| {stations:,} | {theirs * 1e3:.2f} ms | {ours * 1e3:.2f} ms | {theirs / ours:.1f} "
            f"| {whole * 1e3:.2f} ms | {theirs / whole:.1f} |"
        )
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
