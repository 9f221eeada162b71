"""Twelve points on a unit circle, four ways through them: what the curvature comb shows and the eye does not.

All four pass through every point and are C2. The paper's curve goes flat at each; `curvature=1.0` repairs most of that,
`local_spline` all but 1 %, still without a linear system. Writes out/circle_curvature.png (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit

WAYS = {
    "cardinal_spline\n(the paper's curve)": lambda points: cadfit.cardinal_spline(points, closed=True),
    "cardinal_spline\ncurvature=1.0": lambda points: cadfit.cardinal_spline(points, curvature=1.0, closed=True),
    "local_spline": lambda points: cadfit.local_spline(points, closed=True),
    "interpolate\n(one linear system)": lambda points: cadfit.interpolate(points, closed=True),
}


def main(folder):
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    points = np.column_stack([np.cos(angles), np.sin(angles)])

    found = {}
    figure, row = plt.subplots(1, len(WAYS), figsize=(8.0, 2.8), layout="constrained")
    for ax, (name, way) in zip(row, WAYS.items(), strict=True):
        spline = way(points)
        u = np.linspace(*spline.domain, 12 * 6000 + 1)
        bend = np.linalg.norm(spline.curvature(u), axis=1)
        error = np.abs(np.linalg.norm(spline(u), axis=1) - 1.0).max()
        found[name.replace("\n", " ")] = (bend.min(), bend.max(), error)
        spline.plot(ax, points=points, poles=False, count=97, scale=0.35)
        ax.set_title(name, fontsize="medium")
        ax.set_xlabel(f"curvature {bend.min():.2f} to {bend.max():.2f}\nerror {error:.1e}", fontsize="small")
        ax.set(xlim=(-1.6, 1.6), ylim=(-1.6, 1.6), xticks=[], yticks=[])

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "circle_curvature.png", dpi=160)
    plt.close(figure)
    for name, (low, high, error) in found.items():
        print(f"{name:38}  curvature {low:.2f} to {high:.2f}  error {error:.1e}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
