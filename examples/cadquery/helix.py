"""A helix that collapses: `parametricCurve` smooths by default, and at four turns what is left is no helix.

CadQuery issue 2084. Writes out/cq_helix.png.
"""

import sys

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np

from cadfit.cadquery import Workplane

from beside import HOST, draw, measured, places, save, show, timed

TURNS, TOLERANCE = 4, 1e-3


def helix(t):
    return np.cos(2.0 * np.pi * t), np.sin(2.0 * np.pi * t), t


def main(folder):
    points = np.column_stack(helix(np.linspace(0.0, TURNS, 401)))
    exact = TURNS * np.hypot(2.0 * np.pi, 1.0)
    ways = {
        "parametricCurve": lambda: cq.Workplane().parametricCurve(helix, stop=TURNS, makeWire=False),
        "parametricCurve, smoothing=None": lambda: cq.Workplane().parametricCurve(
            helix, stop=TURNS, tol=TOLERANCE, smoothing=None, makeWire=False
        ),
        "fitSpline": lambda: Workplane().fitSpline(points, TOLERANCE),
    }
    rows, edges = {}, {}
    for name, way in ways.items():
        made, seconds = timed(way)
        edges[name] = made.vals()
        radius = np.linalg.norm(places(edges[name])[:, :2], axis=1)
        rows[name] = measured(edges[name], points, seconds)
        rows[name] |= {"length / exact": rows[name]["length"] / exact, "radius": float(np.abs(radius - 1.0).max())}
    show(f"helix of {TURNS} turns, 401 points, tolerance {TOLERANCE}; radius: farthest from 1", rows)

    figure, row = plt.subplots(1, 2, figsize=(8.0, 4.2), subplot_kw={"projection": "3d"}, layout="constrained")
    row[0].plot(*places(edges["parametricCurve"]).T, color=HOST, linewidth=1.5)
    for edge in edges["fitSpline"]:
        draw(edge, row[1])
    for ax, name in zip(row, ["parametricCurve", "fitSpline"], strict=True):
        ax.plot(*points.T, ".", color="black", markersize=1.5)
        ax.set_title(f"{name}: {rows[name]['poles']} poles\nlength {rows[name]['length / exact']:.4f} of the exact one")
        ax.set_box_aspect((2, 2, 3.2), zoom=1.25)
        ax.set_axis_off()
    save(figure, folder, "cq_helix.png")
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
