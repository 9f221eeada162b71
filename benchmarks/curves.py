"""Points to a C2 spline: cadfit against scipy's `make_interp_spline` and OCCT's `GeomAPI_Interpolate`.

Each call starts from the points and ends with a curve; parameters are chosen from the points by all (centripetal for
scipy and `local_spline`, OCCT's own for OCCT, uniform for the paper's curve). One run, calls in turn, medians.
"""

from __future__ import annotations

import numpy as np
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Pnt
from scipy.interpolate import make_interp_spline

import cadfit

from timing import interleaved

try:
    from OCP.collections import HArray1_gp_Pnt as Points
except ImportError:
    from OCP.TColgp import TColgp_HArray1OfPnt as Points

SIZES = (1_000, 10_000, 100_000, 1_000_000)


def helix(n: int) -> cadfit.bezier.Array:
    t = np.linspace(0.0, 60.0, n)
    return np.column_stack([np.cos(t), np.sin(t), t / 9.0])


def scipy_spline(points):
    steps = np.sqrt(np.linalg.norm(np.diff(points, axis=0), axis=1))
    return make_interp_spline(np.concatenate([[0.0], np.cumsum(steps)]), points)


def occt_spline(points):
    """Fill the kernel's array the quickest way Python has (one reused point) and interpolate."""
    array, point = Points(1, len(points)), gp_Pnt()
    for k, row in enumerate(points.tolist(), 1):
        point.SetCoord(*row)
        array.SetValue(k, point)
    make = GeomAPI_Interpolate(array, False, 1e-9)
    make.Perform()
    return make.Curve()


def table() -> str:
    rows = [
        "| points | `cardinal_spline` | `local_spline` | scipy | OCCT | scipy / ours | OCCT / ours | growth |",
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    before = None
    for n in SIZES:
        points = helix(n)
        calls = [
            lambda points=points: cadfit.cardinal_spline(points),
            lambda points=points: cadfit.local_spline(points),
            lambda points=points: scipy_spline(points),
            lambda points=points: occt_spline(points),
        ]
        cardinal, local, scipy, occt = times = interleaved(calls, 9, max(1, 20_000 // n))
        growth = "" if before is None else f"{times[0] / before[0]:.1f}, {times[1] / before[1]:.1f}"
        rows.append(
            f"| {n:,} | {cardinal * 1e3:.2f} ms | {local * 1e3:.2f} ms | {scipy * 1e3:.2f} ms | {occt * 1e3:.2f} ms "
            f"| {scipy / cardinal:.1f}, {scipy / local:.1f} | {occt / cardinal:.1f}, {occt / local:.1f} | {growth} |"
        )
        before = times
    return "\n".join(rows)


if __name__ == "__main__":
    print(table())
