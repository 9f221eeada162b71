"""A curve in space from two planar fits that share the x axis, each with a tension of its own, and merged.

The merge keeps each plane's directions and gives both the mean handle along x, so the result is the cardinal spline of
the mean tension, to the last digits. Writes out/planes.png (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit

TENSIONS = 0.3, 0.9  # of the plane x, y and of the plane x, z


def main(folder):
    t = np.linspace(0.0, 2.2 * np.pi, 10)
    points = np.column_stack([1.2 * t, 2.0 * np.cos(t), 2.0 * np.sin(t)])

    # Step by step: a chain of Bézier pieces in each plane, and one in space whose handles agree with both.
    flat = [cadfit.cardinal_pieces(points[:, [0, axis]], tau) for axis, tau in zip((1, 2), TENSIONS, strict=True)]
    merged = cadfit.c2_spline(cadfit.merge_planes(flat))
    # At once; this also holds where points turn back along x.
    spline = cadfit.fit_planes(points, TENSIONS)
    mean = cadfit.cardinal_spline(points, tension=np.mean(TENSIONS))

    figure = plt.figure(figsize=(8.5, 3.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.15, 1.0])
    space = figure.add_subplot(grid[:, 0], projection="3d")
    spline.plot(space, points=points, count=250, scale=1.0)
    space.set(xlabel="x", ylabel="y", zlabel="z", title="merged in space")
    space.view_init(28, -70)
    space.locator_params(nbins=4)
    for row, (axis, pieces) in enumerate(zip("yz", flat, strict=True)):
        ax = figure.add_subplot(grid[row, 1])
        cadfit.c2_spline(pieces).plot(ax, points=points[:, [0, row + 1]], comb=False)
        ax.set(ylabel=axis, title=f"plane x, {axis}: tension {TENSIONS[row]}")
    ax.set_xlabel("x")
    space.legend(fontsize="x-small", loc="upper right")

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "planes.png", dpi=160)
    plt.close(figure)
    found = {
        name: float(np.abs(spline.poles - each.poles).max()) for name, each in [("merged", merged), ("mean", mean)]
    }
    found["at points"] = cadfit.deviation(spline, points).points
    print(f"fit_planes against merge_planes step by step: poles within {found['merged']:.1e}")
    print(f"against the cardinal spline of tension {np.mean(TENSIONS)}: poles within {found['mean']:.1e}")
    print(f"off at points: {found['at points']:.1e}")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
