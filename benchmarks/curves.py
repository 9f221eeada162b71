"""Points to a C2 spline: cadfit against scipy's `make_interp_spline` and OCCT's `GeomAPI_Interpolate`.

Each call starts from the points and ends with a curve; all choose parameters from the points (centripetal for
scipy and `local_spline`, OCCT's own for OCCT, uniform for the paper's curve). One run, medians; ours and scipy's in
turn, at least five calls in a row, so that every size finds its memory at hand (a first call after others have handed
theirs back waits for fresh pages: twice the time at 100,000 points); OCCT's after them.
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
    ours = {n: in_turn(helix(n), [cadfit.cardinal_spline, cadfit.local_spline, scipy_spline]) for n in SIZES}
    # By itself and last: the gigabytes it takes at 1e6 points would slow down whoever comes after it.
    kernel = {n: in_turn(helix(n), [occt_spline], 3, 1)[0] for n in SIZES}
    before = None
    for n, (cardinal, local, scipy) in ours.items():
        occt = kernel[n]
        growth = "" if before is None else f"{cardinal / before[0]:.1f}, {local / before[1]:.1f}"
        rows.append(
            f"| {n:,} | {cardinal * 1e3:.2f} ms | {local * 1e3:.2f} ms | {scipy * 1e3:.2f} ms | {occt * 1e3:.2f} ms "
            f"| {scipy / cardinal:.1f}, {scipy / local:.1f} | {occt / cardinal:.0f}, {occt / local:.0f} | {growth} |"
        )
        before = (cardinal, local)
    return "\n".join(rows)


def in_turn(points, functions, repeats=9, calls_in_a_row=5):
    calls = [lambda function=function: function(points) for function in functions]
    return interleaved(calls, repeats, max(calls_in_a_row, 50_000 // len(points)))


if __name__ == "__main__":
    print(table())
