"""A tube along an upright S, where a sweep that steers by the vertical spins by 180 degrees.

The line on each tube joins the same corner of all its rings. Writes out/tube.stl and out/tube.png (or into the folder
given).
"""

import sys
from pathlib import Path
from unittest.mock import patch

import matplotlib.pyplot as plt
import numpy as np
import trimesh

import cadfit
from cadfit.plotting import POINTS

RADIUS, SIDES = 0.35, 12


def swept_by_trimesh(path):
    """Return trimesh's own sweep, its triangulated disc handed to it (to make that it needs one more package)."""
    angles = 2.0 * np.pi / SIDES * np.arange(SIDES)
    disc = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    fan = np.array([[0, k, k + 1] for k in range(1, SIDES - 1)])
    with patch.object(trimesh.creation, "triangulate_polygon", lambda *_, **__: (disc, fan)):
        return trimesh.creation.sweep_polygon(None, path)


def largest_turn(mesh):
    """Return by how many degrees a ring turns against the next at most, about the path and with it."""
    rings = mesh.vertices.reshape(-1, SIDES, 3)
    arms = rings[:, 0] - rings.mean(axis=1)
    arms /= np.linalg.norm(arms, axis=1)[:, None]
    return np.degrees(np.arccos(np.clip(np.einsum("nd,nd->n", arms[1:], arms[:-1]), -1.0, 1.0)).max())


def main(folder):
    z = np.linspace(-np.pi, np.pi, 17)
    path = cadfit.local_spline(np.column_stack([1.3 * np.sin(z), 0.0 * z, z]))
    ours = cadfit.tube(path, RADIUS, tolerance=0.02, sides=SIDES)
    theirs = swept_by_trimesh(path(np.linspace(*path.domain, 50)))
    exact = np.pi * RADIUS**2 * path.length()

    found = {}
    figure, row = plt.subplots(1, 2, figsize=(7.0, 4.8), subplot_kw={"projection": "3d"}, layout="constrained")
    for ax, (name, mesh) in zip(
        row, {"cadfit.tube": ours, "trimesh.creation.sweep_polygon": theirs}.items(), strict=True
    ):
        found[name] = {"turn": largest_turn(mesh), "volume": mesh.volume / exact, "watertight": mesh.is_watertight}
        ax.plot_trisurf(*mesh.vertices.T, triangles=mesh.faces, color="#56B4E9", edgecolor="white", linewidth=0.15)
        ax.plot(*mesh.vertices[::SIDES].T, color=POINTS, linewidth=2.5, zorder=10)
        ax.set_title(f"{name}\na ring turns by up to {found[name]['turn']:.0f}°", fontsize="medium")
        ax.view_init(12, -70)
        # One unit as long on every axis, and less margin.
        ax.set_box_aspect(np.ptp(np.reshape(ax.get_w_lims(), (3, 2)), axis=1), zoom=1.1)
        ax.set_axis_off()

    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    cadfit.write(folder / "tube.stl", ours)
    figure.savefig(folder / "tube.png", dpi=160, bbox_inches="tight")
    plt.close(figure)
    for name, said in found.items():
        print(f"{name:32} turn {said['turn']:5.1f} degrees, volume {said['volume']:.4f} of area times length")
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
