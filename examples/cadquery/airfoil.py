"""An airfoil that turns wavy: the coordinates have four decimals, and a spline through them follows their rounding.

CadQuery issue 1448. A published airfoil (RAE 2822), rounded to four decimals of its chord as most files have them, at a
chord of 200 mm: steps of 0.02 mm. `spline` goes through every rounded point, and bends to and fro; `splineApprox`
smooths, at the cost of the tolerance, or approximates with three times the poles. Writes out/cq_airfoil.png.
"""

import sys

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np

import cadfit
from cadfit.cadquery import Workplane

from beside import DATA, HOST, OURS, bend, draw, measured, save, show, timed, turns

CHORD, TOLERANCE = 200.0, 0.02


def main(folder):
    points = CHORD * np.round(cadfit.read(DATA / "rae2822.dat"), 4)
    listed = [tuple(point) for point in points.tolist()]
    ways = {
        "spline": lambda: cq.Workplane().spline(listed),
        "splineApprox, smoothing": lambda: cq.Workplane().splineApprox(listed, TOLERANCE),
        "splineApprox, none": lambda: cq.Workplane().splineApprox(listed, TOLERANCE, 3, 3, smoothing=None),
        "fitSpline": lambda: Workplane().fitSpline(points, TOLERANCE),
    }
    rows, curvatures, edges = {}, {}, {}
    for name, way in ways.items():
        made, seconds = timed(way)
        edges[name] = made.val()
        places, curvature = bend(edges[name])
        inner = places[:, 0] < 0.98 * CHORD  # the trailing edge itself is sharp
        rows[name] = measured(made.vals(), points, seconds) | {"changes of side": turns(curvature[inner], 1e-5)}
        curvatures[name] = places, curvature
    show(f"airfoil of {len(points)} points, tolerance {TOLERANCE}", rows)

    figure, (above, below) = plt.subplots(2, 1, figsize=(8.5, 5.0), height_ratios=[1, 2.2], layout="constrained")
    above.plot(*points.T, ".", color="black", markersize=2.5)
    draw(edges["fitSpline"], above, linewidth=1.0)
    above.set(aspect="equal", title=f"RAE 2822, its coordinates rounded to four decimals: {len(points)} points")
    for name, colour in [("spline", HOST), ("splineApprox, smoothing", "#E69F00"), ("fitSpline", OURS)]:
        places, curvature = curvatures[name]
        upper = slice(int(0.03 * len(places)), int(0.46 * len(places)))
        label = f"{name}: {rows[name]['poles']} poles, {rows[name]['changes of side']} changes of side"
        below.plot(places[upper, 0], curvature[upper], color=colour, linewidth=1.2, label=label)
    below.set(ylim=(-0.011, 0.019), xlabel="mm along the chord", ylabel="curvature, 1/mm", title="upper side")
    below.legend(loc="upper right", fontsize="small")
    save(figure, folder, "cq_airfoil.png")
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
