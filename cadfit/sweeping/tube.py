"""Tubes: circles swept along a path."""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.stages import Progress, rising
from cadfit.sweeping.chain import breaks, chain, tightest
from cadfit.sweeping.judging import nearest_parts
from cadfit.sweeping.laws import Law, is_number, largest, law_of, smallest
from cadfit.sweeping.mesh import around, disc, sides_for
from cadfit.sweeping.section import Section
from cadfit.sweeping.selfintersection import Crossing
from cadfit.sweeping.stations import most_rings, stationed
from cadfit.sweeping.touching import near_parts, touching
from cadfit.sweeping.wanted import Caps, OnSelfIntersection, Wanted, path_of, positive

if TYPE_CHECKING:
    from trimesh import Trimesh


def tube(
    path: Any,
    radius: Law,
    tolerance: float | None = None,
    sides: int | None = None,
    *,
    thickness: float | None = None,
    up: ArrayLike | None = None,
    caps: Caps = "flat",
    on_self_intersection: OnSelfIntersection = "warn",
    texture: bool = False,
    progress: Progress | None = None,
) -> Trimesh:
    """Return the tube of a radius around a path, as a watertight `trimesh.Trimesh` with outward normals.

    `path`: a `BSpline` in 2 or 3 dimensions (2D lies in z = 0), a `Fit`, or several curves end to end; all lengths are
    in its unit. `radius`: a number, or what varies along the path, as `sweep` takes it. `thickness` makes a pipe of
    it, with walls inward. `up`, `caps`, corners, `on_self_intersection`, `texture` and `progress` are
    as in `sweep`.

    The mesh stays within `tolerance` (default: a hundredth of the radius) of the exact tube, both ways. `sides`
    (default: as many as the tolerance needs, at least 6) overrides its share for the polygon that stands for the
    circle. The rings are perpendicular to the exact tangents and follow rotation-minimizing frames (`cadfit.frames`).
    Their polygon has the area of the circle, or as much more as makes up for the chords along the path, so the volume
    is right on average and not always low: it differs from pi radius^2 length by less than `tolerance` times 2 pi
    radius length.

    Raises TypeError for what is no path; ValueError for another dimension, a radius, thickness or tolerance that is
    not above zero, a thickness that is not below the radius, fewer than 3 sides, and as `sweep` does.

    >>> path = BSpline([[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 3]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> mesh = tube(path, radius=1.0, sides=8)
    >>> mesh.is_watertight, len(mesh.faces), round(float(mesh.volume) / np.pi, 12)
    (True, 28, 3.0)
    """
    told = rising(progress)
    along, at = path_of(path), getattr(path, "parameters", None)
    if is_number(radius):
        radius = positive(radius, "radius")
        tolerance = positive(radius / 100.0 if tolerance is None else tolerance, "tolerance")
        wanted = Wanted(tolerance, caps, on_self_intersection, texture, "radius", told)
        wanted.check(along, radius)  # before a circle is cut into no end of sides
        sides = _sides(sides, radius, 0.5 * tolerance)
        if thickness is None and up is None and caps == "flat" and not texture:
            mesh = _plain(along, radius, sides, wanted)
            if mesh is not None:
                return mesh
    from cadfit.sweeping.sweep import swept  # and a dozen modules more, which most tubes do without

    size = positive(largest(law_of(radius, along.domain, "radius", np.inf, at, along.closed)), "radius")
    tolerance = positive(size / 100.0 if tolerance is None else tolerance, "tolerance")
    wanted = Wanted(tolerance, caps, on_self_intersection, texture, "radius", told)
    wanted.check(along, size)
    outer = law_of(radius, along.domain, "radius", 0.1 * tolerance, at, along.closed)
    polygon = disc(_sides(sides, size, 0.35 * tolerance))
    loops, scales = [polygon], [outer]
    if thickness is not None:
        thickness = positive(thickness, "thickness")
        if thickness >= smallest(outer):
            raise ValueError(f"the thickness {thickness:g} is not below the radius, {smallest(outer):g} at its least")
        loops.append(polygon[::-1])
        scales.append(BSpline(outer.poles - thickness, outer.knots))
    twist = law_of(0.0, along.domain, "twist", 1.0)
    section = Section(loops, scales, twist, float(polygon[0, 0]))
    return swept(along, section, up, wanted)


def _plain(path: BSpline, radius: float, sides: int, wanted: Wanted) -> Trimesh | None:
    """Return the tube of one radius around a path without corners, with flat caps; None where that is not all of it.

    The quick way for what most tubes are.
    """
    whole = chain(path)
    if len(breaks(path, whole)[0]):
        return None
    u, bend = tightest(whole, radius)
    u = min(u, path.domain[1])  # a bend at the very end may be rounded beyond it
    found = [Crossing("bend" if bend > 0.0 else "cusp", u, path(u), radius, bend)] if bend <= radius else []
    repairs = wanted.on_self_intersection == "repair"
    if found and repairs:
        return None
    points, tangents = stationed(whole, radius, 0.5 * wanted.tolerance, most_rings(sides))
    wanted.progress(0.3)
    mesh = around(points, tangents, path.closed, radius, sides, 0.5 * wanted.tolerance)
    wanted.progress(0.6)
    # Near is what is nearer than the corners of the rings reach, which are within the tolerance of the radius.
    if len(near_parts(points, tangents, path.closed, radius + wanted.tolerance)):
        found += _touching(path, mesh, points, tangents, radius, sides)
    if found and repairs:
        return None
    wanted.tell(found)
    wanted.progress(1.0)
    return mesh


def _touching(
    path: BSpline, mesh: Trimesh, points: Array, tangents: Array, radius: float, sides: int
) -> list[Crossing]:
    """Return the crossing, if any, of distant parts of a plain tube with rings at points (3, n) on the path."""
    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    rings = vertices.reshape(-1, sides, 3)
    caps = vertices[faces[2 * sides * (len(rings) - 1) :]]
    if path.closed:
        rings, caps = np.concatenate([rings, rings[:1]]), caps[:0]
    both = touching(rings, np.split(caps, 2), points, tangents, path.closed)
    return [nearest_parts(path, points.T, radius, *both)] if both else []


def _sides(sides: int | None, radius: float, tolerance: float) -> int:
    if sides is None:
        return sides_for(radius, tolerance)
    try:
        count = operator.index(sides)
    except TypeError:
        raise TypeError(f"the number of sides must be a whole number, not {sides!r}") from None
    if count < 3:
        raise ValueError(f"a tube needs at least 3 sides, not {count}")
    return count
