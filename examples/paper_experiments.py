"""The paper's five experiments again, on shapes that stand in for its own, which it does not give.

Figures 1 to 4: two sparse and two dense planar shapes, (a) cardinal spline, (b) Bézier pieces with polygon, (c) C2
B-spline, (d) to (f) approximations through falling parts of the points, by the paper's search; the captions give its
square error and that of cadfit's default. Figure 5: a curve in space by way of two coordinate planes. Writes
out/paper_1.png to paper_5.png (or into the folder given), and says which of the paper's claims hold.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit
from cadfit.plotting import COMB, CURVE, POINTS, POLES

DATA = Path(__file__).parent / "data"
FALLING = np.arange(0.95, 0.49, -0.05)
TENSIONS = 0.35, 0.65  # of the planes Y, X and Y, Z: equal ones would leave nothing to merge


def heart():
    """30 points on the heart curve 16 sin^3 t, 13 cos t - 5 cos 2t - 2 cos 3t - cos 4t, open at its cusp."""
    t = np.linspace(0.0, 2.0 * np.pi, 30)
    return np.column_stack(
        [16 * np.sin(t) ** 3, 13 * np.cos(t) - 5 * np.cos(2 * t) - 2 * np.cos(3 * t) - np.cos(4 * t)]
    )


def wave():
    """40 points on a swinging path, 10 t + 4 sin 2t, 12 exp(-t / 6) sin 3t."""
    t = np.linspace(0.0, 8.0, 40)
    return np.column_stack([10 * t + 4 * np.sin(2 * t), 12 * np.exp(-t / 6) * np.sin(3 * t)])


def airfoil():
    """RAE 2822 as published, 129 points, a chord of 200."""
    return 200.0 * cadfit.read(DATA / "rae2822.dat")


def digitised():
    """180 points on a five-lobed outline of radius 60 to 100, rounded to whole units as digitised outlines are."""
    t = np.linspace(0.0, 2.0 * np.pi, 180)
    radius = 80 + 20 * np.cos(5 * t)
    return np.round(np.column_stack([radius * np.cos(t), radius * np.sin(t)]))


SHAPES = {  # and the parts of the points that the paper used
    "1: heart, 30 points": (heart, (0.90, 0.85, 0.78)),
    "2: wave, 40 points": (wave, (0.90, 0.85, 0.80)),
    "3: RAE 2822, 129 points": (airfoil, (0.82, 0.70, 0.63)),
    "4: digitised outline, 180 points": (digitised, (0.81, 0.71, 0.67)),
}


def planar(name, points, fractions):
    width, height = np.ptp(points, axis=0)
    stretch = 4.0 if height < 0.2 * width else 1.0
    figure, axes = plt.subplots(2, 3, figsize=(10.0, 1.2 + 6.0 * stretch * height / width), layout="constrained")
    figure.suptitle(f"Experiment {name}" + f", {stretch:.0f} times as tall" * (stretch > 1.0), fontsize="medium")
    (a, b, c), approximations = axes
    pieces = cadfit.cardinal_pieces(points)
    cadfit.pieces_to_spline(pieces).plot(a, points=points, poles=False, comb=False)
    cadfit.pieces_to_spline(pieces).plot(b, comb=False, poles=False)
    polygon = np.concatenate([pieces[:, :3].reshape(-1, 2), pieces[-1:, 3]])
    b.plot(*polygon.T, color=POLES, linewidth=0.5, marker="s", markersize=min(3.0, 100.0 / len(points)), zorder=1)
    if len(points) > 100:  # a part of it, large: there the polygon is next to the curve
        part = pieces[len(pieces) // 3 : len(pieces) // 3 + 6]
        inset = b.inset_axes((0.25, 0.36, 0.38, 0.3))
        inset.plot(*cadfit.pieces_to_spline(part)(np.linspace(0.0, len(part), 200)).T, color=CURVE, linewidth=0.9)
        inset.plot(*part.reshape(-1, 2).T, color=POLES, linewidth=0.5, marker="s", markersize=3.0)
        inset.set(xticks=[], yticks=[])
    cadfit.cardinal_spline(points).plot(c, points=points, poles=False, comb=False)
    for ax, title in ((a, "(a) cardinal spline"), (b, "(b) Bézier pieces, polygon"), (c, "(c) C2 B-spline")):
        ax.set_title(title, fontsize="small")
    found = {}
    for ax, letter, fraction in zip(approximations, "def", fractions, strict=True):
        paper, best = (cadfit.dominant_points(points, fraction=fraction, method=each) for each in ("paper", "best"))
        found[fraction] = paper.square_error, best.square_error
        cadfit.cardinal_spline(points[paper.indices]).plot(ax, points=points[paper.indices], poles=False, comb=False)
        rest = np.delete(points, paper.indices, axis=0)
        ax.plot(*rest.T, linestyle="none", marker="x", markersize=4.0, color=COMB)
        errors = f"error {paper.square_error:.3g} (default: {best.square_error:.3g})"
        ax.set_title(f"({letter}) {fraction:.0%} of the points: {errors}", fontsize="small")
    for ax in axes.flat:
        ax.set(xticks=[], yticks=[], aspect=stretch)
        for line in ax.lines:  # many marks would hide the curve
            line.set(
                markersize=min(line.get_markersize(), 330.0 / len(points)), linewidth=min(line.get_linewidth(), 0.9)
            )
    return figure, found


def space(points):
    """Two planes with the axis Y in common, drawn side by side in each panel."""
    figure, axes = plt.subplots(2, 3, figsize=(10.0, 3.4), layout="constrained")
    figure.suptitle("Experiment 5: 24 alpha carbons of 1A8O; planes Y, X (left) and Y, Z (right)", fontsize="medium")
    flats = [points[:, [1, axis]] for axis in (0, 2)]
    chains = [cadfit.cardinal_pieces(flat, tension) for flat, tension in zip(flats, TENSIONS, strict=True)]
    merged = cadfit.merge_planes(chains)  # columns Y, X, Z
    curve = cadfit.c2_spline(merged)
    aside = np.array([np.ptp(points[:, 1]) + 4.0, 0.0])
    titles = [
        "points",
        "cardinal splines",
        "control polygons",
        "Bézier fits",
        "merged polygons",
        "the space curve, projected",
    ]
    for ax, letter, title in zip(axes.flat, "abcdef", titles, strict=True):
        for k, (flat, chain) in enumerate(zip(flats, chains, strict=True)):
            shift = k * aside - [0.0, flat[:, 1].mean()]
            both = merged[:, :, [0, k + 1]]
            polygon = (both if title.startswith("merged") else chain) + shift
            if "polygon" in title:
                ax.plot(*polygon.reshape(-1, 2).T, color=POLES, linewidth=0.6, marker="s", markersize=2.0)
            if title in ("cardinal splines", "Bézier fits"):
                cadfit.pieces_to_spline(chain).transformed(np.eye(2), shift).plot(ax, poles=False, comb=False)
            if title == "Bézier fits":
                ax.plot(*polygon[:, [0, 3]].reshape(-1, 2).T, linestyle="none", marker="|", color=POLES)
            if "space" in title:
                curve.transformed(np.eye(3)[[0, k + 1]], shift).plot(ax, poles=False, comb=False)
            ax.plot(*(flat + shift).T, color=POINTS, linestyle="none", marker="o", markersize=2.5)
        ax.set_aspect("equal")
        ax.set(xticks=[], yticks=[])
        ax.set_title(f"({letter}) {title}", fontsize="small")
    through = np.abs(
        curve(np.clip(3 * np.arange(len(points)) - 1, 0, 3 * len(points) - 5)) - points[:, [1, 0, 2]]
    ).max()
    return figure, float(through)


def claims(points):
    """For each method the errors at falling parts of the points, what the two claims say of them, and the part needed.

    Faster: each 15 % of the points less adds more to the error than the 15 % before. Exponential: it even multiplies it
    by more. Knee: below 70 % the error grows by a factor of five within 10 % of the points, as the paper's did. The
    part needed: of the smallest set whose error is that of all points 0.1 % of the size off.
    """
    bound = len(points) * (1e-3 * np.linalg.norm(np.ptp(points, axis=0))) ** 2
    found = {}
    for method in METHODS:
        errors = [cadfit.dominant_points(points, fraction=part, method=method).square_error for part in FALLING]
        thirds, at = np.array(errors[::3]), dict(zip(FALLING.round(2).tolist(), errors, strict=True))
        least = cadfit.dominant_points(points, square_error=bound, method=method)
        found[method] = {
            "errors": errors,
            "faster": bool(np.all(np.diff(thirds, n=2) > 0)),
            "exponential": bool(np.all(np.diff(np.log(thirds), n=2) > 0)),
            "knee": at[0.6] > 5.0 * at[0.7],
            "needed": len(least.indices) / len(points),
        }
    return found


METHODS = "paper", "best"


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    found = {}
    for number, (name, (shape, fractions)) in enumerate(SHAPES.items(), start=1):
        figure, errors = planar(name, shape(), fractions)
        figure.savefig(folder / f"paper_{number}.png", dpi=120)
        plt.close(figure)
        found[number] = errors, claims(shape())
        print(f"\nExperiment {name}")
        for fraction, (paper, best) in errors.items():
            print(f"  {fraction:.0%}: square error {paper:.4g} by the paper's search, {best:.4g} by the default")
        for method, said in found[number][1].items():
            print(f"  {method:5} at 95, 90 ... 50 %:", *(f"{error:.2g}" for error in said["errors"]))
            print(
                "        "
                + ", ".join(f"{name}: {'yes' if said[name] else 'no'}" for name in ("faster", "exponential", "knee"))
            )
            print(f"        0.1 % of the size takes {said['needed']:.0%} of the points")
    figure, found[5] = space(cadfit.read(DATA / "1a8o_ca.csv")[:24])
    figure.savefig(folder / "paper_5.png", dpi=120)
    plt.close(figure)
    print(f"\nExperiment 5: the merged curve passes the points within {found[5]:.1e}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
