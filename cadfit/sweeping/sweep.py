"""Profiles swept along a path, as watertight triangle meshes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bspline import BSpline
from cadfit.joining import join
from cadfit.sweeping.caps import flat_cap
from cadfit.sweeping.frames import frames, lifted
from cadfit.sweeping.profile import Profile, polygons
from cadfit.sweeping.stations import chain, stationed

if TYPE_CHECKING:
    from trimesh import Trimesh

Law = float | Callable[[Any], ArrayLike] | ArrayLike | BSpline
Caps = Literal["flat", "round", "none"]
OnSelfIntersection = Literal["raise", "warn", "repair"]


def sweep(
    path: Any,
    profile: Any,
    tolerance: float | None = None,
    *,
    scale: Law = 1.0,
    twist: Law = 0.0,
    up: ArrayLike | None = None,
    caps: Caps = "flat",
    on_self_intersection: OnSelfIntersection = "warn",
) -> Trimesh:
    """Return a profile swept along a path, as a watertight `trimesh.Trimesh` with outward normals.

    `path`: a `BSpline` in 2 or 3 dimensions (2D lies in z = 0), a `Fit`, or several curves end to end; `profile`: a
    `Profile`, a polygon (n, 2), a closed `BSpline` in two dimensions, a `Fit`. The path runs through the profile's
    origin; see `Profile` for its directions. Lengths are in one unit.
    """
    from trimesh import Trimesh

    if not (scale == 1.0 and twist == 0.0 and up is None and caps == "flat" and on_self_intersection == "warn"):
        raise NotImplementedError("so far profiles are swept as they are, with flat caps")
    path = path_of(path)
    profile = Profile.of(profile)
    tolerance = profile.reach / 100.0 if tolerance is None else tolerance
    loops = polygons(profile, 0.5 * tolerance)
    points, _ = stationed(chain(path), profile.reach, 0.5 * tolerance)
    u, _ = path.nearest(points.T)
    along = frames(path, u)
    corners = np.concatenate(loops)
    rings = along.origins[:, None] + np.einsum(
        "kd,ndx->nkx", corners, np.stack([along.normals, along.binormals], axis=1)
    )
    count = len(rings) - path.closed
    k = len(corners)
    starts = np.concatenate([[0], np.cumsum([len(loop) for loop in loops])])
    here = np.arange(k)
    there = np.concatenate([np.roll(here[a:b], -1) for a, b in zip(starts[:-1], starts[1:], strict=True)])
    wall = np.concatenate([np.column_stack([here, there, there + k]), np.column_stack([here, there + k, here + k])])
    faces = (wall + k * np.arange(len(rings) - 1)[:, None, None]).reshape(-1, 3)
    if path.closed:
        faces %= count * k
    else:
        cap = flat_cap(loops)
        faces = np.concatenate([faces, cap[:, ::-1], cap + k * (count - 1)])
    return Trimesh(rings[:count].reshape(-1, 3), faces, process=False)


def path_of(path: Any) -> BSpline:
    """Return the path of a spline, a fit or several curves as one B-spline in three dimensions."""
    if isinstance(path, Sequence):
        path = join(path)
    elif hasattr(path, "curves"):
        path = join(path.curves)
    return lifted(path)
