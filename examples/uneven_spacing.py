"""Points in close pairs, a thousand times nearer to each other than to the next: which parameters loop, which do not.

Uniform parameters give a short gap as much time as a long one, and the curve spends it in loops. Centripetal ones keep
the curve to its chords, chord-length ones make it the roundest. Each dot below is a pair.
Writes out/uneven_spacing.png (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import cadfit


def main(folder):
    x = np.arange(9.0)
    x = np.sort(np.concatenate([x, x[1:-1] + 1e-3]))
    points = np.column_stack([x, np.sin(1.3 * x)])
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)

    found = {}
    figure, column = plt.subplots(3, 1, figsize=(7.5, 6.2), layout="constrained", sharex=True)
    for ax, parameters in zip(column, ["uniform", "centripetal", "chord"], strict=True):
        spline = cadfit.local_spline(points, parametrization=parameters)
        velocity = spline.derivative(np.linspace(*spline.domain, 20001))
        backwards = float(np.mean(velocity[:, 0] < 0.0))  # the points never go back in x
        far = cadfit.deviation(spline, points)
        longer = spline.length() / gaps.sum() - 1.0
        found[parameters] = {"backwards": backwards, "between": far.between, "longer": longer}
        spline.plot(ax, points=points, poles=False, comb=False)
        ax.set(xlim=(-0.4, 8.4), ylim=(-1.2, 1.3))
        said = f"up to {far.between:.2g} off its chords, {longer:.0%} longer than they are"
        ax.set_title(f"{parameters}: {said}", fontsize="medium")

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "uneven_spacing.png", dpi=160)
    plt.close(figure)
    print(f"{len(points)} points, the longest gap {gaps.max() / gaps.min():.0f} times the shortest")
    for parameters, said in found.items():
        print(f"{parameters:12}", "  ".join(f"{name} {value:.3g}" for name, value in said.items()))
    return found | {"ratio": gaps.max() / gaps.min()}


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
