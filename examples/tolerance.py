"""Fits within a tolerance: few poles on smooth points, noise smoothed, corners kept.

A published airfoil within 1e-4 of its chord; a circle of radius 50 measured with noise of 0.05, within 0.25; a plate
with rounded and sharp corners, within 0.02 of its outline everywhere. Writes out/tolerance.png (or into the folder
given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit

DATA = Path(__file__).parent / "data"


def noisy_circle():
    angle = 2.0 * np.pi * np.arange(501) / 501
    circle = 50.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    return circle + np.random.default_rng(7).normal(scale=0.05, size=circle.shape)


def plate():
    """A plate of 40 by 24 with two corners rounded, two sharp, and a notch, by vertices a tenth apart on its arcs."""
    quarter = np.linspace(0.0, np.pi / 2.0, 64)
    arc = 6.0 * np.column_stack([np.sin(quarter), 1.0 - np.cos(quarter)])
    turned = 6.0 * np.column_stack([np.cos(quarter), np.sin(quarter)])
    notch = [[22.0, 24.0], [20.0, 18.0], [18.0, 24.0]]
    return np.concatenate([[[0.0, 0.0]], arc + [34.0, 0.0], turned + [34.0, 18.0], notch, [[0.0, 24.0]]])


def main(folder):
    airfoil = 200.0 * cadfit.read(DATA / "rae2822.dat")
    fits = {
        "RAE 2822": cadfit.fit(airfoil, 0.02),
        "noisy circle": cadfit.fit(noisy_circle(), 0.25, closed=True),
        "plate": cadfit.fit(plate(), 0.02, closed=True, between="polyline"),
    }
    figure, rows = plt.subplot_mosaic(
        [["RAE 2822", "RAE 2822"], ["noisy circle", "plate"]], figsize=(8.0, 4.8), height_ratios=[1, 2],
        width_ratios=[1, 1.6], layout="constrained",
    )  # fmt: skip
    found = {}
    for name, fit in fits.items():
        ax = rows[name]
        fit.plot(ax, poles=name != "noisy circle", comb=name == "noisy circle", unit="mm")
        curves = f", {len(fit.curves)} curves" if len(fit.curves) > 1 else ""
        ax.set_title(f"{name}: {len(fit.points)} points, {fit.poles} poles{curves}", fontsize="medium")
        found[name] = {
            "points": len(fit.points),
            "poles": fit.poles,
            "curves": len(fit.curves),
            "corners": len(fit.corners),
            "tolerance": fit.tolerance,
            "at points": fit.deviation.points,
            "between": fit.deviation.between,
            "length": sum(curve.length() for curve in fit.curves),
        }
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "tolerance.png", dpi=130, pil_kwargs={"optimize": True})
    plt.close(figure)
    for name, said in found.items():
        print(f"{name:13}", "  ".join(f"{key} {value:.4g}" for key, value in said.items()))
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
