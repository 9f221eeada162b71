"""Texture coordinates of sweeps: lengths along the path and around the profile, for every corner of every triangle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cadfit.bezier import Array

if TYPE_CHECKING:
    from trimesh import Trimesh

ATTRIBUTE = "uv"


def textured(mesh: Trimesh) -> Trimesh:
    """Return a mesh as programs that draw textures want it: `visual.uv` (v, 2), a vertex for each pair of coordinates.

    `mesh` is a sweep made with `texture=True`, whose `face_attributes["uv"]` (f, 3, 2) it goes by. Vertices on seams,
    where the coordinates start anew, are doubled, so the result is no longer watertight by its numbering.

    Raises ValueError for a mesh without texture coordinates.
    """
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals

    if ATTRIBUTE not in mesh.face_attributes:
        raise ValueError("the mesh has no texture coordinates: sweep it with texture=True")
    uv = np.asarray(mesh.face_attributes[ATTRIBUTE]).reshape(-1, 2)
    corners = np.column_stack([mesh.faces.reshape(-1), uv])
    _, first, number = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    vertices = mesh.vertices[mesh.faces.reshape(-1)[first]]
    out = Trimesh(vertices, number.reshape(-1, 3), process=False)
    out.visual = TextureVisuals(uv=uv[first])  # type: ignore[no-untyped-call]
    return out


def wall_texture(lengths: Array, loops: Sequence[Array]) -> Array:
    """Return coordinates (f, 3, 2) for the triangles of `caps.walls`, in their order.

    `lengths` (n,) are those of the rings along the path, on a closed one with the whole length at the end.

    >>> wall_texture(np.array([0.0, 5.0]), [np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]])])[0].tolist()
    [[0.0, 0.0], [0.0, 3.0], [5.0, 3.0]]
    """
    edges = [np.linalg.norm(np.roll(loop, -1, axis=0) - loop, axis=1) for loop in loops]
    there = np.concatenate([np.cumsum(edge) for edge in edges])
    here = there - np.concatenate(edges)
    low, high = (row[:, None] + 0.0 * here for row in (lengths[:-1], lengths[1:]))
    here, there = (np.broadcast_to(column, low.shape) for column in (here, there))
    lower = np.stack([low, here, low, there, high, there], axis=2)
    upper = np.stack([low, here, high, there, high, here], axis=2)
    return np.stack([lower, upper], axis=1).reshape(-1, 3, 2)


def dome_texture(length: float, way: float, reach: float, loop: Array, points: int) -> Array:
    """Return coordinates (f, 3, 2) for the triangles of `caps.dome_walls`, going on from `length` by arcs of `reach`.

    `way` is 1.0 at the end of a path and -1.0 at its start.
    """
    rings = (points - 1) // len(loop) + 2
    arcs = length + way * reach * 0.5 * np.pi * np.linspace(0.0, 1.0, rings)
    body = wall_texture(arcs, [loop])
    steps = body.reshape(rings - 1, 2, len(loop), 3, 2)
    tip = steps[-1, 0].copy()
    tip[:, 2] = np.column_stack([np.full(len(loop), arcs[-1]), tip[:, :2, 1].mean(axis=1)])
    return np.concatenate([steps[:-1, 0].reshape(-1, 3, 2), steps[:-1, 1].reshape(-1, 3, 2), tip])
