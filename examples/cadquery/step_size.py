"""A STEP file of 50 MB from fibres given as many points: before and after.

CadQuery issue 1410. Fibres, each of 200 points. A cylinder from each point to the next makes a file that grows with the
points, and has a gap at every bend; a tube along a fit has four faces. Writes out/cq_step_size.png and the
files.
"""

import sys
from pathlib import Path

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np

from cadfit.cadquery import fit_tube

from beside import HOST, OURS, round_about, save, show, timed

FIBRES, POINTS, RADIUS, TOLERANCE = 4, 200, 0.235, 0.002


def fibres():
    rng = np.random.default_rng(5)
    along = np.linspace(0.0, 60.0, POINTS)
    for k in range(FIBRES):
        phase, wave = rng.uniform(0.0, 6.0, 2), rng.uniform(14.0, 22.0, 2)
        yield np.column_stack([along, 2.5 * k + np.sin(along * 6.28 / wave[0] + phase[0]), np.zeros(POINTS)])


def cylinders(points):
    """Return a cylinder for each pair of points."""
    return [
        cq.Solid.makeCylinder(RADIUS, float(np.linalg.norm(b - a)), cq.Vector(*a), cq.Vector(*(b - a)))
        for a, b in zip(points[:-1], points[1:], strict=True)
    ]


def swept(points):
    path = cq.Workplane().spline([tuple(point) for point in points.tolist()])
    start = cq.Plane(origin=tuple(points[0]), normal=path.val().tangentAt(0).toTuple())
    return [cq.Workplane(start).circle(RADIUS).sweep(path).val()]


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rows = {}
    for name, make in {
        "cylinders": cylinders,
        "sweep along spline": swept,
        "fit_tube": lambda points: [fit_tube(points, RADIUS, TOLERANCE)],
    }.items():
        path = str(folder / f"fibres_{name.split()[0]}.step")
        each, seconds = timed(lambda make=make: [make(points) for points in fibres()])
        solids = [solid for fibre in each for solid in fibre]
        shapes = [round_about(made, points, RADIUS) for made, points in zip(each, fibres(), strict=True)]
        whole = cq.Workplane(obj=cq.Compound.makeCompound(solids))
        _, writing = timed(lambda whole=whole, path=path: cq.exporters.export(whole, path))
        back, reading = timed(lambda path=path: cq.importers.importStep(path))
        kilobytes = Path(path).stat().st_size / 1e3
        rows[name] = {
            "solids": len(solids),
            "faces": sum(len(solid.Faces()) for solid in solids),
            "poles": sum(shape["poles"] for shape in shapes),
            "off": max(shape["off"] for shape in shapes),
            "valid": all(solid.isValid() for solid in back.solids().vals()),
            "kB": kilobytes,
            "kB a fibre": kilobytes / FIBRES,
            "make, s": seconds,
            "write, s": writing,
            "read, s": reading,
        }
    show(f"{FIBRES} fibres of {POINTS} points, radius {RADIUS}, tolerance {TOLERANCE}", rows)

    figure, ax = plt.subplots(figsize=(8.0, 2.6), layout="constrained")
    sizes = [row["kB a fibre"] for row in rows.values()]
    bars = ax.barh([*rows], sizes, color=[HOST, "#E69F00", OURS])
    ax.bar_label(bars, [f"{size:.0f} kB" for size in sizes], padding=4)
    ax.set(xlabel="kB of STEP for one fibre of 200 points", xlim=(0, 1.15 * max(sizes)))
    ax.invert_yaxis()
    save(figure, folder, "cq_step_size.png")
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
