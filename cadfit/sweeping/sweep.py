"""Profiles swept along a path, as watertight triangle meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.points.clean import LARGEST
from cadfit.stages import Progress, portion
from cadfit.sweeping.caps import dome, dome_walls, flat_cap, walls
from cadfit.sweeping.chain import breaks, chain
from cadfit.sweeping.corners import SHARPEST
from cadfit.sweeping.course import Course, Joint, course_of
from cadfit.sweeping.frames import vector
from cadfit.sweeping.judging import tight_places, touching_parts
from cadfit.sweeping.laws import Law, is_constant, is_number, largest, law_of, smallest
from cadfit.sweeping.profile import Profile, polygons
from cadfit.sweeping.repair import united
from cadfit.sweeping.rings import Rings, Short, mitres_have_room, placed
from cadfit.sweeping.section import Section
from cadfit.sweeping.texture import ATTRIBUTE, dome_texture, wall_texture
from cadfit.sweeping.triangles import loops_around
from cadfit.sweeping.volume import grown, volume
from cadfit.sweeping.wanted import Caps, OnSelfIntersection, Wanted, path_of, positive

if TYPE_CHECKING:
    from trimesh import Trimesh

_SHARE = 0.35  # of the tolerance for the profile's chords, and as much for those along the path
_TWISTED = 0.15  # for twisted walls
_GROWTH = 0.3  # for what makes the volume right; it takes back what chords cut off, or what they bulge


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
    texture: bool = False,
    progress: Progress | None = None,
) -> Trimesh:
    """Return a profile swept along a path, as a watertight `trimesh.Trimesh` with outward normals.

    `path`: a `BSpline` in 2 or 3 dimensions (2D lies in z = 0), a `Fit`, or several curves end to end. `profile`: a
    `Profile`, a polygon (n, 2), a closed `BSpline` in two dimensions, a `Fit`. The path runs through the profile's
    origin; see `Profile` for its directions. Lengths are in one unit.

    The mesh stays within `tolerance` (default: a hundredth of the profile's reach) of the exact surface, both ways.
    The profile follows rotation-minimizing frames, or with `up` (3,) those whose binormals are up. `scale` and `twist`
    (radians, from the normal toward the binormal) vary along the path: a number, a function of its parameters (n,), a
    `BSpline` of one coordinate over its domain, parameters and values (n, 2), or, for a path that is a `Fit`, values
    (n,) at its points; a single number for the twist is the turn over the whole path, spread evenly by its parameter.

    Open paths get `caps`: "flat", "round" (no holes), or "none", which leaves the ends open. A path whose last pole is
    its first becomes a closed ring. At corners the profile is mitred, exactly between straight legs; where a leg is
    curved, its fibres run straight to the mitre from the last ring before it.

    A sweep that would pass through itself (a bend tighter than the profile reaches, a cusp, a leg too short for its
    mitres, distant parts that touch) is said to, with the place and the largest reach that would do:
    `on_self_intersection` "warn" (`SelfIntersectionWarning`) returns it all the same, closed but wrong there, "raise"
    (`SelfIntersectionError`, a ValueError) does not, and "repair" returns the space that the profile passes through,
    as a mesh that does not pass through itself (needs manifold3d: the extra `repair`).

    With `texture` the mesh has `face_attributes["uv"]` (f, 3, 2), lengths along the path and around the profile;
    `cadfit.sweeping.texture.textured` makes of it what programs draw, and .glb and .obj files are written so. Repaired
    meshes have none. `progress` is called with the part that is done, from 0 to 1, a few times; raising from it stops.

    Raises TypeError for what is no path or profile, ValueError for a scale or tolerance that is not above zero, a
    twist or scale that does not close with the path, a mesh of more than 20 million vertices, and as
    `frames`, `Profile` and `laws.law_of` do.

    >>> from cadfit.joining import polyline
    >>> mesh = sweep(polyline([[0, 0, 0], [5, 0, 0], [5, 5, 0]]), [[-1, -1], [1, -1], [1, 1], [-1, 1]])
    >>> mesh.is_watertight, round(float(mesh.volume), 9)
    (True, 40.0)
    """
    along, at = path_of(path), getattr(path, "parameters", None)
    shape = Profile.of(profile)
    if caps == "round" and shape.holes:
        raise ValueError("round caps are for profiles without holes")
    tolerance = positive(shape.reach / 100.0 if tolerance is None else tolerance, "tolerance")
    relative = tolerance / shape.reach
    sizes = law_of(scale, along.domain, "scale", 0.1 * relative, at, along.closed)
    _refuse_vanishing(sizes)
    if is_number(twist):
        whole = law_of(twist, along.domain, "twist", np.inf).poles[0, 0]  # named where it is no number
        twist = np.array([[along.domain[0], 0.0], [along.domain[1], whole]])
    turns = law_of(twist, along.domain, "twist", 0.1 * relative, at, along.closed)
    wanted = Wanted(tolerance, caps, on_self_intersection, texture, progress=portion(progress, 0.0, 1.0))
    wanted.check(along, shape.reach * largest(sizes))  # before a profile is cut into no end of sides
    loops = polygons(shape, _SHARE * tolerance / largest(sizes))
    if shape.holes:
        flat_cap(loops)  # refuses holes that are not inside, on closed paths too
    section = Section(loops, [sizes] * len(loops), turns)
    return swept(along, section, up, wanted)


def swept(path: BSpline, section: Section, up: ArrayLike | None, wanted: Wanted) -> Trimesh:
    """Return the mesh of a section swept along a path in three dimensions: see `sweep`."""
    from trimesh import Trimesh

    _check_section(path, section)
    wanted.check(path, section.reach)
    share = _SHARE * wanted.tolerance
    whole = chain(path)
    corners, angles = breaks(path, whole)
    joints = [Joint(float(u), bool(angle <= SHARPEST)) for u, angle in zip(corners, angles, strict=True)]
    axis = None if up is None else vector(up)
    course = course_of(path, joints, axis)
    section, rings, short = _untwisted(course, section, wanted.tolerance)
    wanted.progress(0.4)
    varies = not (section.constant and (course.steady or section.outside > 1.0))  # a circle may turn
    cusps = corners[angles > SHARPEST]
    repairs = wanted.on_self_intersection == "repair"
    found = tight_places(path, whole, cusps, rings, section, short)
    if not found:  # what touches is looked for in the mesh as it will be
        rings = _grown(rings, section, course, wanted.tolerance)
    lids = [] if path.closed else _lids(rings, section, wanted.caps, share)
    ends = [np.concatenate([rings.points[k], over])[faces] for k, (over, faces) in zip((0, -1), lids, strict=False)]
    ends = ends or [np.empty((0, 3, 3))] * 2
    if not (found and repairs):  # beside what is too tight nothing needs to be said twice
        found += touching_parts(path, rings, ends, section, varies and not found)
    wanted.tell(found)
    wanted.progress(0.6)
    if short:  # where a mitre has no room, the profile turns on the spot
        course = course_of(path, _without(joints, short, path), axis)
        rings, _ = placed(course, section, share)
    if found and repairs:
        if wanted.caps == "none" and not path.closed:
            raise ValueError("a sweep without caps encloses nothing that could be repaired")
        loops = section.parted(section.at(np.array(path.domain[:1]))[0])
        parts = rings.points, rings.centres, rings.tangents
        mesh = Trimesh(*united(*parts, loops, path.closed, wanted.caps == "round", share, varies), process=False)
        wanted.progress(1.0)
        return mesh
    wanted.progress(0.8)
    lids = [] if path.closed else _lids(rings, section, wanted.caps, share)
    mesh = Trimesh(*_surface(rings, section, path.closed, lids), process=False)
    if wanted.texture:
        mesh.face_attributes[ATTRIBUTE] = _texture(rings, section, course, wanted.caps, [len(over) for over, _ in lids])
    wanted.progress(1.0)
    return mesh


def _without(joints: list[Joint], short: list[Short], path: BSpline) -> list[Joint]:
    """Return the joints with those at the ends of short legs not mitred."""
    ends = {leg.start for leg in short} | {leg.end for leg in short}
    ends |= {path.domain[1]} if path.domain[0] in ends else set()
    return [Joint(joint.parameter, joint.mitred and joint.parameter not in ends) for joint in joints]


def _grown(rings: Rings, section: Section, course: Course, tolerance: float) -> Rings:
    """Return the rings a little larger or smaller, so that the volume is exact, where mitres have room for it."""
    _, faces = _surface(
        rings, section, course.closed, [] if course.closed else _lids(rings, section, "flat", tolerance)
    )
    most = _GROWTH * tolerance / (section.outside * section.reach)
    exact = volume(course, section, rings.parameters)
    larger = replace(rings, points=grown(rings.points, rings.centres, faces, exact, most))
    if np.abs(larger.points - rings.points).max() <= 1e-9 * section.reach:
        return larger
    fits = mitres_have_room(larger, loops_around([len(loop) for loop in section.loops]), course.closed)
    return larger if fits else rings


def _untwisted(course: Course, section: Section, tolerance: float) -> tuple[Section, Rings, list[Short]]:
    """Return the section with its edges cut so that no wall is twisted by more than the tolerance, and its rings.

    A circle's need none: turned about its centre it is itself.
    """
    rings, short = placed(course, section, _SHARE * tolerance)
    if section.outside > 1.0 or (course.steady and is_constant(section.twist)):
        return section, rings, short
    cuts = _cuts(rings, section.loops, course.closed, _TWISTED * tolerance)
    if max(int(cut.max()) for cut in cuts) > 1:
        loops = [_cut_edges(loop, cut) for loop, cut in zip(section.loops, cuts, strict=True)]
        section = replace(section, loops=loops)
        rings, short = placed(course, section, _SHARE * tolerance)
    return section, rings, short


def _cuts(rings: Rings, loops: Sequence[Array], closed: bool, spare: float) -> list[Ints]:
    """Return into how many parts each edge is to be cut: a wall of four points strays from the surface between them.

    The two triangles and the doubly ruled surface through the points differ most in the middle, by a quarter of the
    edges' difference; only what is across the wall counts.
    """
    points = np.concatenate([rings.points, rings.points[:1]]) if closed else rings.points
    found, start = [], 0
    for n in map(len, loops):
        edges = np.roll(points[:, start : start + n], -1, axis=1) - points[:, start : start + n]
        steps = points[1:, start : start + n] - points[:-1, start : start + n]
        across = np.cross(steps, edges[:-1])
        advances = np.einsum("nkd,nd->nk", steps, rings.tangents[: len(steps)]) > 0.0
        sizes = np.where(advances & np.roll(advances, -1, axis=1), np.linalg.norm(across, axis=2), np.inf)
        astray = np.abs(np.einsum("nkd,nkd->nk", edges[1:] - edges[:-1], across)) / np.where(sizes > 0, sizes, 1.0)
        found.append(np.maximum(np.ceil(0.25 * astray.max(axis=0) / spare - 1e-9), 1).astype(np.intp))
        start += n
    return found


def _cut_edges(loop: Array, counts: Ints) -> Array:
    """Return a polygon (k, 2) with each edge cut into so many equal parts."""
    owner = np.repeat(np.arange(len(loop)), counts)
    t = (np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]) / counts[owner]
    return np.asarray(loop[owner] + t[:, None] * (np.roll(loop, -1, axis=0) - loop)[owner])


def _lids(rings: Rings, section: Section, caps: Caps, tolerance: float) -> list[tuple[Array, Ints]]:
    """Return the caps at the start and the end, if any: points (m, 3) beyond the ring's k, and triangles over all."""
    lids, k = [], rings.points.shape[1]
    for end, way in ((0, -1), (-1, 1)):
        if caps == "round":
            over = dome(rings.points[end], rings.centres[end], way * rings.tangents[end], tolerance)
            lids.append((over, dome_walls(0, k, k, len(over))[:, ::way]))
        elif caps == "flat":
            (corners,) = section.at(rings.parameters[[end]])
            lids.append((np.empty((0, 3)), flat_cap(section.parted(corners))[:, ::way]))
    return lids


def _surface(rings: Rings, section: Section, closed: bool, lids: list[tuple[Array, Ints]]) -> tuple[Array, Ints]:
    """Return the vertices and the triangles of the walls and the caps."""
    n, k = rings.points.shape[:2]
    vertices, faces = [rings.points.reshape(-1, 3)], [walls(n, [len(loop) for loop in section.loops], closed)]
    for first, (over, lid) in zip((0, (n - 1) * k), lids, strict=False):
        faces.append(lid + np.where(lid < k, first, sum(map(len, vertices)) - k))
        vertices.append(over)
    return np.concatenate(vertices), np.concatenate(faces)


def _texture(rings: Rings, section: Section, course: Course, caps: Caps, lids: list[int]) -> Array:
    """Return the texture coordinates of the faces of `_surface`, whose round caps have so many vertices."""
    total = float(course.started[-1])
    loops = section.parted(section.at(rings.parameters[:1])[0])
    parts = [wall_texture(np.append(rings.lengths, [total] * course.closed), loops)]
    if not course.closed and caps == "flat":
        for k, way in ((0, -1), (-1, 1)):
            flat = section.at(rings.parameters[[k]])[0]
            parts.append(flat[flat_cap(section.parted(flat))[:, ::way]])
    for points, length, way in zip(lids, (0.0, total), (-1, 1), strict=False) if caps == "round" else ():
        parts.append(dome_texture(length, way, section.reach, loops[0], points)[:, ::way])
    return np.concatenate(parts)


def _check_section(path: BSpline, section: Section) -> None:
    for law in section.scales:
        _refuse_vanishing(law)
    if path.closed:
        first, last = section.at(np.array(path.domain))
        if np.abs(last - first).max() > 1e-9 * section.reach:
            raise ValueError("the path is closed, but the profile does not end as it starts: see its scale and twist")


def _refuse_vanishing(law: BSpline) -> None:
    if not (low := smallest(law)) > 1.0 / LARGEST:
        raise ValueError(f"the profile must not vanish: its scale or radius comes down to {low:.6g}")
