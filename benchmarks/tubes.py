"""Tubes against `trimesh.creation.sweep_polygon`: the same stations and sides, one run, warm, medians of repeats.

`from stations` starts, on both sides, from what the path is at the stations: points for trimesh, Bézier pieces for
cadfit, which moreover carries frames to sixth order and balances the volume. trimesh is handed the triangulation of
its polygon, for which it would need one more package. `tube` is the whole call, choosing its own stations.
"""

from unittest.mock import patch

import numpy as np
import trimesh

import cadfit
from cadfit.sweeping.mesh import around, disc
from cadfit.sweeping.stations import Chain, chain, stationed

from timing import interleaved

SIDES = 16
RADIUS = 1.0


def helix() -> cadfit.BSpline:
    t = np.linspace(0.0, 20.0 * np.pi, 100)
    return cadfit.cardinal_spline(np.column_stack([10 * np.cos(t), 10 * np.sin(t), t]), curvature=1.0)


def cut(path: cadfit.BSpline, stations: int) -> Chain:
    """Return the path as Bézier pieces between evenly spaced stations."""
    u = np.linspace(*path.domain, stations)
    points, widths = path(u), np.diff(u)
    handles = path.derivative(u) / 3.0
    leaving, arriving = widths[:, None] * handles[:-1], widths[:, None] * handles[1:]
    pieces = np.stack([points[:-1], points[:-1] + leaving, points[1:] - arriving, points[1:]], axis=1)
    return Chain(pieces, u[:-1], widths)


def tolerance_for(path: cadfit.BSpline, stations: int) -> float:
    """Return the tolerance at which the path gets about so many stations."""
    low, high = 1e-12, 10.0
    for _ in range(40):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if len(stationed(chain(path), RADIUS, 0.5 * middle)) >= stations else (low, middle)
    return high


def table() -> str:
    path = helix()
    fan = np.arange(1, SIDES - 1)
    triangulation = disc(SIDES) * RADIUS, np.column_stack([0 * fan, fan, fan + 1])
    rows = [
        "| stations | sweep_polygon | cadfit from stations | times faster | cadfit.tube | times faster |",
        "| ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for stations in (200, 2_000, 20_000):
        pieces, points = cut(path, stations), path(np.linspace(*path.domain, stations))
        tolerance = tolerance_for(path, stations)
        calls = [
            lambda points=points: trimesh.creation.sweep_polygon(None, points),
            lambda pieces=pieces: around(pieces, False, RADIUS, SIDES, 0.01),
            lambda tolerance=tolerance: cadfit.tube(path, RADIUS, tolerance, sides=SIDES),
        ]
        with patch("trimesh.creation.triangulate_polygon", lambda *_, **__: triangulation):
            theirs, ours, whole = interleaved(calls, 11, max(1, 4_000 // stations))
        rows.append(
            f"| {stations:,} | {theirs * 1e3:.2f} ms | {ours * 1e3:.2f} ms | {theirs / ours:.1f} "
            f"| {whole * 1e3:.2f} ms | {theirs / whole:.1f} |"
        )
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
