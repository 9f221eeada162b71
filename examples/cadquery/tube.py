"""A tube along a thousand points, whole in the file and on the screen.

CadQuery issue 1520. A ring of radius 1 m and 5 mm thick, its path a spline through 1,000 points: the sweep is one face
with a thousand knots, valid to the kernel, but what every viewer and STL file shows of it has gaps. Along a trefoil the
sweep is not even valid. Writes out/cq_tube.png.
"""

import sys

import cadquery as cq
import matplotlib.pyplot as plt
import numpy as np
import trimesh
from matplotlib.collections import PolyCollection

from cadfit.cadquery import fit_tube

from beside import HOST, OURS, round_about, save, show, timed

T = np.linspace(0.0, 2.0 * np.pi, 1000)
TREFOIL = np.column_stack([np.sin(T) + 2.0 * np.sin(2.0 * T), np.cos(T) - 2.0 * np.cos(2.0 * T), -np.sin(3.0 * T)])
PATHS = {
    "ring": (1000.0 * np.column_stack([np.cos(T), np.sin(T), 0.0 * T]), 2.5),
    "trefoil": (10.0 * TREFOIL, 2.0),
}


def swept(points, radius):
    path = cq.Workplane().spline([tuple(point) for point in points.tolist()])
    start = cq.Plane(origin=tuple(points[0]), normal=path.val().tangentAt(0).toTuple())
    return cq.Workplane(start).circle(radius).sweep(path).val()


def fitted(points, radius):
    return fit_tube(points, radius, 0.01 * radius)


def mesh_of(solid, radius):
    """Return the mesh a viewer shows, its vertices joined."""
    vertices, triangles = solid.tessellate(0.4 * radius, 0.5)
    return trimesh.Trimesh(np.array([vertex.toTuple() for vertex in vertices]), triangles)


def seen(mesh):
    """Return the triangles (n, 3, 2) of a mesh of the ring that look outward: degrees along the ring, and heights."""
    half = mesh.triangles[mesh.triangles_center[:, 0] > -500.0]
    places = np.stack([np.degrees(np.arctan2(half[..., 1], half[..., 0])), half[..., 2]], axis=-1)
    first, second = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    return places[first[:, 0] * second[:, 1] > first[:, 1] * second[:, 0]]


def main(folder):
    rows, meshes = {}, {}
    for name, (points, radius) in PATHS.items():
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        for way, make in {"sweep": swept, "fit_tube": fitted}.items():
            solid, seconds = timed(lambda make=make, points=points, radius=radius: make(points, radius))
            mesh = meshes[name, way] = mesh_of(solid, radius)
            rows[f"{name}, {way}"] = {
                "valid": solid.isValid(),
                "faces": len(solid.Faces()),
                **round_about([solid], points, radius),
                "seconds": seconds,
                "mesh watertight": bool(mesh.is_watertight),
                "mesh / exact volume": float(mesh.volume / (np.pi * radius**2 * length)),
            }
    show("tubes along 1,000 points (a mesh as coarse as this holds some 10 % less than the tube)", rows)

    figure, row = plt.subplots(2, 1, figsize=(9.0, 3.8), sharex=True, sharey=True, layout="constrained")
    for ax, way, colour in zip(row, ["sweep", "fit_tube"], [HOST, OURS], strict=True):
        ax.add_collection(PolyCollection(seen(meshes["ring", way]), facecolor=colour, edgecolor="white", linewidth=0.3))
        share = rows[f"ring, {way}"]["mesh / exact volume"]
        ax.set_title(f"{way}: the whole mesh holds {100 * share:.0f} % of the tube", fontsize="medium")
        ax.set(xlim=(-90, 90), ylim=(-3, 3), ylabel="height, mm")
    row[1].set(xlabel="half of the ring, seen from outside: degrees along it")
    save(figure, folder, "cq_tube.png")
    return rows


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
