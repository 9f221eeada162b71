"""The pictures of the guide and of how it works: an airfoil, a noisy scan, a plate, and a bound that closes in.

Writes out/guide_airfoil.png, guide_scan.png, guide_corners.png and how_bound.png (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit
from cadfit.bezier import split
from cadfit.plotting import COMB, CURVE, POINTS, POLES

DATA = Path(__file__).parent / "data"


def airfoil():
    fit = cadfit.fit(200 * cadfit.read(DATA / "rae2822.dat"), 0.02)
    figure, ax = plt.subplots(figsize=(8.0, 2.4), layout="constrained")
    fit.spline.plot(ax, points=fit.points)
    figure.legend(loc="outside lower center", fontsize="small", ncols=4)
    ax.set_title(f"{len(fit.points)} points, {fit.poles} poles, every point within 0.02", fontsize="medium")
    return figure, fit.poles


def scan():
    angle = np.linspace(0, 2 * np.pi, 501)[:-1]
    points = 50 * np.column_stack([np.cos(angle), np.sin(angle)])
    points += np.random.default_rng(7).normal(scale=0.05, size=points.shape)
    figure, row = plt.subplots(1, 2, figsize=(8.0, 3.4), layout="constrained", sharey=True)
    poles = []
    for ax, tolerance in zip(row, (0.05, 0.25), strict=True):
        fit = cadfit.fit(points, tolerance, closed=True)
        curve = fit.spline(np.linspace(*fit.spline.domain, 20_000))
        for places, style in ((points, {"marker": ".", "color": POINTS}), (curve, {"linestyle": "-", "color": CURVE})):
            around = np.degrees(np.arctan2(*places.T[::-1]))
            order = np.argsort(around)
            off = np.linalg.norm(places, axis=1) - 50
            ax.plot(around[order], off[order], **({"linestyle": "none", "markersize": 4.0} | style))
        ax.set_title(f"tolerance {tolerance}: {fit.poles} poles", fontsize="medium")
        ax.set(xlim=(20, 80), xlabel="angle, degrees")
        poles.append(fit.poles)
    row[0].set_ylabel("radius - 50")
    return figure, poles


def corners():
    arc = np.linspace(0, np.pi / 2, 40)
    rounded = 6 * np.column_stack([np.sin(arc), 1 - np.cos(arc)]) + [34, 0]
    plate = np.concatenate([[[0, 0]], rounded, [[40, 24], [22, 24], [20, 18], [18, 24], [0, 24]]])
    fit = cadfit.fit(plate, 0.02, closed=True, between="polyline")
    figure, ax = plt.subplots(figsize=(8.0, 4.6), layout="constrained")
    fit.plot(ax, poles=False)
    ax.set_title(f"{len(fit.curves)} curves between {len(fit.corners)} corners", fontsize="medium")
    ax.legend(loc="center", fontsize="small")
    return figure, len(fit.curves)


def bound():
    curve = np.array([[[0.0, 0.0], [1.0, 1.5], [2.2, 1.9], [3.0, 0.0]]])
    chord = np.array([[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]])
    t = np.linspace(0, 1, 2001)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    truth = np.linalg.norm(weights @ (curve - chord)[0], axis=1).max()
    figure, row = plt.subplots(1, 4, figsize=(8.0, 2.5), layout="constrained", sharey=True)
    found = []
    for halvings, ax in enumerate(row):
        bounds = np.linalg.norm(curve - chord, axis=2).max(axis=1)
        found.append(bounds.max() / truth)
        for k, piece in enumerate(curve):
            ax.plot(*piece.T, "s-", color=POLES, linewidth=0.7, markersize=2.5, label="poles" if k == 0 else None)
            ax.plot(*(weights @ piece).T, color=CURVE, label="curve" if k == 0 else None)
        ax.axhline(0.0, color=POINTS, linewidth=1.2, label="chord")
        ax.axhline(bounds.max(), color=COMB, linestyle="--", linewidth=1.0, label="bound")
        ax.set_title(f"{2**halvings} piece{'s'[: halvings > 0]}: {found[-1] - 1:.1%} above", fontsize="small")
        ax.set(xticks=[], yticks=[])
        curve = np.concatenate(split(curve, np.full(len(curve), 0.5)))
        chord = np.concatenate(split(chord, np.full(len(chord), 0.5)))
    row[0].legend(fontsize="x-small", loc="lower center")
    return figure, found


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for name, draw in {
        "guide_airfoil": airfoil, "guide_scan": scan, "guide_corners": corners, "how_bound": bound,
    }.items():  # fmt: skip
        figure, found[name] = draw()
        figure.savefig(folder / f"{name}.png", dpi=160)
        plt.close(figure)
    print(found)
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
