"""Well-known and real curves: poles, deviation and time of `cadfit.fit` and of what else fits points, judged alike.

cadfit "fast" and "best"; OCCT's `GeomAPI_PointsToBSpline`; FITPACK's `splprep`, its smoothing bisected (the time is of
all calls); and, because they take a number of poles and no tolerance, geomdl's `approximate_curve` and CadQuery's
experimental `nurbs.approximate` with as many as cadfit's best. Distances are those of `cadfit.deviation`, matched in
order, in tolerances; "rule": whether the curve keeps between the points what `cadfit.fit` keeps. One call each.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.progress import track

import cadfit
import cadfit.occt.approximating  # here, or OCCT's time is that of importing it

from limited import limited
from nurbs import approximate
from peers import contour, fitpack, judged, occt

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from corpus_data import PRESENT, Shape, curves

LIMIT = 120.0  # seconds
REAL = {  # kind: name and tolerance, in parts of the size
    "literature": ("fitpack_mnparc", 1e-2),
    "airfoil": ("naca2412", 1e-4),
    "font_outline": ("DejaVuSans/U+0053.0", 1e-3),
    "gps_track": ("Mojstrovka.0", 1e-3),
    "turbine_section": ("IEA-15-240-RWT_AF15_Coords", 1e-4),
    "tract": ("tracks300/126", 1e-3),
}


def own():
    """A trefoil knot and a noisy circle: {name: (points and whether they close, tolerance)}."""
    t = 2 * np.pi * np.arange(2000) / 2000
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    t = 2 * np.pi * np.arange(501) / 501
    noise = np.random.default_rng(7).normal(scale=0.05, size=(501, 2))
    noisy = 50 * np.column_stack([np.cos(t), np.sin(t)]) + noise
    return {"trefoil": (Shape(10 * knot, True), 1e-2), "noisy circle": (Shape(noisy, True), 0.25)}


def selected():
    """The curves: {name: (points and whether they close, tolerance)}."""
    found = own()
    for kind, (name, share) in REAL.items() if PRESENT else ():
        shape = named(kind, name)
        found[f"{kind} {name}"] = (shape, share * shape.size)
    return found


def named(kind, name):
    """A curve of the corpus."""
    return next(p.values[0] for p in curves(10_000, None, [kind]) if p.id == f"{kind}-{name}")


def ours(shape, tolerance, effort):
    """The joined curve, its seconds, and the poles of the parts, those at corners counted once."""
    start = perf_counter()
    fit = cadfit.fit(shape.points, tolerance, closed=shape.closed, effort=effort)
    seconds = perf_counter() - start
    return cadfit.join(fit.curves), seconds, fit.poles - len(fit.curves) + 1


def geomdl(points, closed, poles):
    """The approximation of The NURBS Book, 9.4.1, as geomdl has it; a closed curve only returns to its start."""
    from geomdl.fitting import approximate_curve

    curve = approximate_curve(contour(points, closed).tolist(), 3, ctrlpts_size=poles)
    return cadfit.BSpline(curve.ctrlpts, curve.knotvector)


def everyone(shape, tolerance):
    """Who, their curve and its seconds and poles."""
    for effort in ("fast", "best"):
        curve, seconds, poles = ours(shape, tolerance, effort)
        yield f"cadfit {effort}", curve, seconds, poles
    peers = [
        ("OCCT", limited(LIMIT, occt, shape.points, tolerance, shape.closed)),
        ("FITPACK", limited(LIMIT, fitpack, shape.points, tolerance, shape.closed)),
        ("geomdl", limited(LIMIT, geomdl, shape.points, shape.closed, poles)),
        ("CadQuery nurbs", approximate(shape.points, shape.closed, poles)),
    ]
    for who, (curve, seconds) in peers:
        yield who, curve, seconds, None if curve is None else len(curve.poles)


def table(names=None) -> str:
    rows = [
        "| curve | points | tolerance | who | poles | at the points | between | rule | time |",
        "| --- | ---: | ---: | --- | ---: | ---: | ---: | --- | ---: |",
    ]
    shapes = selected()
    for name in track(names or list(shapes), "literature", disable=None):
        shape, tolerance = shapes[name]
        first = f"{name} | {len(shape.points):,} | {tolerance:.3g}"
        for who, curve, seconds, poles in everyone(shape, tolerance):
            if curve is None:
                cells = f"– | – | – | – | {seconds:.3g} s"
            else:
                far = judged(curve, shape.points, tolerance, shape.closed)
                kept = "kept" if far.kept else "broken"
                at, between = far.points / tolerance, far.between / tolerance
                cells = f"{poles} | {at:.3g} | {between:.3g} | {kept} | {seconds:.3g} s"
            rows.append(f"| {first} | {who} | {cells} |")
            first = " | | "
    return "\n".join(rows)


if __name__ == "__main__":
    print(table(sys.argv[1:]))
