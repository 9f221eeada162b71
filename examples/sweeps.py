"""Six sweeps: a cable harness, a spring, a trefoil, a duct, a rail, and a pipe with a bend that is tighter than it.

Writes out/sweeps.png and each mesh as .stl (or into the folder given).
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

import cadfit

LIGHT = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
COLOURS = {"harness": "#D55E00", "spring": "#999999", "trefoil": "#0072B2", "duct": "#56B4E9"}
COLOURS |= {"rail": "#CC79A7", "bend": "#009E73"}


def harness():
    """Three cables side by side through the same clips, each rounding them in its own way."""
    clips = np.array([[0, 0, 0], [30, 0, 5], [50, 15, 8], [55, 45, 8], [80, 60, 0], [110, 60, 0]], float)
    cables = []
    for k in range(3):
        angle = 2.0 * np.pi / 3.0 * k
        beside = clips + [0.0, 2.6 * np.cos(angle), 2.6 * np.sin(angle)]
        cables.append(cadfit.tube(cadfit.interpolate(beside), 2.0, 0.05, caps="round"))
    return cables


def spring():
    """Closed at both ends: the pitch runs out, and nothing twists."""
    t = np.linspace(0.0, 14.0 * np.pi, 400)
    height = np.interp(t / np.pi, [0, 2, 12, 14], [0, 4, 46, 50])
    path = cadfit.fit(np.column_stack([12 * np.cos(t), 12 * np.sin(t), height]), 0.02).spline
    return [cadfit.tube(path, 1.5, 0.05, on_self_intersection="raise")]


def trefoil():
    """A square bar that meets itself at the seam: what the frames miss by is spread along the path."""
    t = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    knot = np.column_stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)])
    bar = 0.3 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return [cadfit.sweep(cadfit.local_spline(knot, closed=True), bar, 0.01, on_self_intersection="raise")]


def duct():
    """A hollow rectangle that narrows along a path fitted to noisy points, upright all the way."""
    t = np.linspace(0.0, 1.0, 80)
    noise = np.random.default_rng(1).normal(scale=0.2, size=(80, 3))
    points = np.column_stack([100 * t, 30 * np.sin(2.5 * t) ** 2, 25 * t * t]) + noise
    path = cadfit.fit(points, 1.0)
    outer = np.array([[-12, -7], [12, -7], [12, 7], [-12, 7]], float)
    low, high = path.spline.domain
    narrow = [[low, 1.0], [0.4 * (low + high), 0.9], [high, 0.45]]
    return [cadfit.sweep(path, cadfit.Profile.of(outer, outer * [10 / 12, 5 / 7]), 0.1, scale=narrow, up=[0, 0, 1])]


def rail():
    """A rail's section, straight and round edges, along a curve in the plane with a corner: mitred there."""
    half = [[0, 0], [7, 0], [7, 1.2], [1.2, 2.6], [0.8, 4.5], [0.8, 8.5], [3.4, 9.6]]
    top = cadfit.BSpline([[3.4, 9.6], [3.4, 13.2], [-3.4, 13.2], [-3.4, 9.6]], [0, 0, 0, 0, 1, 1, 1, 1])
    down = np.array(half)[::-1] * [-1, 1]
    profile = cadfit.Profile.of([cadfit.polyline(half[1:]), top, cadfit.polyline([*down[:-1], half[1]])])
    curve = cadfit.BSpline([[0, 0], [40, 0], [80, 20], [90, 60]], [0, 0, 0, 0, 1, 1, 1, 1])
    path = [curve, cadfit.polyline([[90, 60], [40, 90]])]
    return [cadfit.sweep(path, profile, 0.05, on_self_intersection="raise")]


def bend():
    """A bend of radius 0.57 in a pipe of radius 1.5, repaired: the space it takes, and no face through another."""
    path = cadfit.BSpline([[-4, 4, 0], [0.5, -4, 0], [-0.5, -4, 0], [4, 4, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    return [cadfit.tube(path, 1.5, 0.02, on_self_intersection="repair")]


def draw(ax, meshes, colour):
    base = np.array(plt.matplotlib.colors.to_rgb(colour))
    size = max(mesh.scale for mesh in meshes)
    for mesh in meshes:
        mesh = mesh.copy().subdivide_to_size(size / 25)  # matplotlib sorts triangles by their middles: no long ones
        shade = 0.45 + 0.55 * np.clip(mesh.face_normals @ LIGHT, 0.0, 1.0)[:, None]
        ax.add_collection3d(Poly3DCollection(mesh.triangles, facecolors=np.clip(base * shade, 0, 1), linewidths=0))
    bounds = np.array([np.min([m.bounds[0] for m in meshes], axis=0), np.max([m.bounds[1] for m in meshes], axis=0)])
    for set_limits, (low, high) in zip((ax.set_xlim, ax.set_ylim, ax.set_zlim), bounds.T, strict=True):
        set_limits(low, high)
    ax.set_box_aspect(np.ptp(bounds, axis=0), zoom=1.0)
    ax.set_axis_off()


VIEWS = {"harness": (35, -70), "spring": (15, -60), "trefoil": (50, -60), "duct": (25, -110)}
VIEWS |= {"rail": (40, -100), "bend": (60, -80)}


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    figure = plt.figure(figsize=(7.2, 5.0), layout="constrained")
    found = {}
    for k, make in enumerate((harness, spring, trefoil, duct, rail, bend), 1):
        meshes, name = make(), make.__name__
        ax = figure.add_subplot(2, 3, k, projection="3d")
        draw(ax, meshes, COLOURS[name])
        ax.view_init(*VIEWS[name])
        ax.set_title(name, fontsize="medium")
        for number, mesh in enumerate(meshes):
            cadfit.write(folder / f"{name}{number if meshes[1:] else ''}.stl", mesh)
        found[name] = {
            "watertight": all(mesh.is_watertight for mesh in meshes),
            "volume": sum(float(mesh.volume) for mesh in meshes),
            "faces": sum(len(mesh.faces) for mesh in meshes),
        }
        print(f"{name:8} {found[name]['faces']:7,} faces, volume {found[name]['volume']:.2f}")
    figure.savefig(folder / "sweeps.png", dpi=150)
    plt.close(figure)
    return found


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
