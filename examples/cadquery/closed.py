"""A closed spline smooth at its seam, through a few points and within a tolerance of measured ones.

CadQuery issue 1818. Left, the seven points of CadQuery's own example of a spline, closed: `spline` with the first point
repeated has a kink there; with periodic=True it is smooth, but next to a cusp at the last point. Right, a cam measured
with noise: `spline` follows the noise, and `splineApprox` knows no closed curves. Writes out/cq_closed.png.
"""

import sys

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np

from cadfit.cadquery import Workplane

from beside import HOST, OURS, bend, draw, kernel_spline, measured, save, show, timed, turns

FEW = np.array([(2.75, 1.5), (2.5, 1.75), (2.0, 1.5), (1.5, 1.0), (1.0, 1.25), (0.5, 1.0), (0.0, 1.0)])
TOLERANCE = 0.25


def cam():
    angle = 2.0 * np.pi * np.arange(150) / 150
    radius = 20.0 + 6.0 * np.exp(-((np.abs(angle - np.pi) / 0.6) ** 2)) + 1.5 * np.cos(angle)
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return points + np.random.default_rng(3).normal(scale=0.06, size=points.shape)


def kink(edge):
    """Return the angle at the seam in degrees, and by how much the curvature jumps there."""
    spline, (_, curvature) = kernel_spline(edge), bend(edge)
    first, last = spline(spline.t[spline.k], 1), spline(spline.t[-spline.k - 1], 1)
    angle = np.degrees(np.arccos(np.clip(first @ last / np.linalg.norm(first) / np.linalg.norm(last), -1.0, 1.0)))
    return {"kink, degrees": float(angle), "jump of curvature": float(abs(curvature[0] - curvature[-1]))}


def compared(title, points, ways, straight):
    rows, edges = {}, {}
    for name, way in ways.items():
        made, seconds = timed(way)
        edge = made.val()
        changes = {"changes of side": turns(bend(edge)[1], straight), "sharpest": float(np.abs(bend(edge)[1]).max())}
        rows[name] = measured([edge], np.vstack([points, points[:1]]), seconds) | kink(edge) | changes
        edges[name] = edge
    show(title, rows)
    return rows, edges


def main(folder):
    few, scan = [tuple(p) for p in FEW.tolist()], [tuple(p) for p in cam().tolist()]
    seven, first = compared(
        "seven points",
        FEW,
        {
            "spline, repeated": lambda: cq.Workplane().spline([*few, few[0]]),
            "spline, periodic": lambda: cq.Workplane().spline(few, periodic=True),
            "localSpline": lambda: Workplane().localSpline(FEW, closed=True),
            "fitSpline, 0.05": lambda: Workplane().fitSpline(FEW, 0.05, closed=True),
        },
        1e-3,
    )
    measured_cam, second = compared(
        f"a measured cam, 150 points, tolerance {TOLERANCE}",
        cam(),
        {
            "spline, periodic": lambda: cq.Workplane().spline(scan, periodic=True),
            "splineApprox": lambda: cq.Workplane().splineApprox([*scan, scan[0]], TOLERANCE, 3, 3, smoothing=None),
            "fitSpline": lambda: Workplane().fitSpline(cam(), TOLERANCE, closed=True, corners=None),
        },
        1e-4,
    )
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.9), width_ratios=[1.15, 1], layout="constrained")
    for name, style in [("spline, repeated", ":"), ("spline, periodic", "--"), ("localSpline", "-")]:
        label = f"{name}: sharpest {seven[name]['sharpest']:.0f}"
        if name == "localSpline":
            draw(first[name], left, label=label)
        else:
            left.plot(*bend(first[name])[0].T, style, color=HOST, linewidth=1.4, label=label)
    left.plot(*FEW.T, "o", color="black", markersize=4)
    left.set(aspect="equal", ylim=(-0.6, 1.9), title="seven points, closed; the sharpest curvature")
    left.legend(loc="lower center", fontsize="small")
    for name, width in [("spline, periodic", 0.6), ("fitSpline", 1.8)]:
        places, curvature = bend(second[name])
        along = np.concatenate([[0.0], np.hypot(*np.diff(places, axis=0).T).cumsum()])
        label = f"{name}: {measured_cam[name]['poles']} poles"
        right.plot(along, curvature, color=OURS if name == "fitSpline" else HOST, linewidth=width, label=label)
    right.set(ylim=(-0.6, 1.0), title="the cam's curvature along it", xlabel="mm", ylabel="1/mm")
    right.legend(loc="upper right", fontsize="small")
    save(figure, folder, "cq_closed.png")
    return {"seven": seven, "cam": measured_cam}


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
