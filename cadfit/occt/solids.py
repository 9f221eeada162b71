"""Tubes and swept profiles as solids, each checked before it is returned."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from OCP.TopoDS import TopoDS_Solid

from cadfit.bspline import BSpline
from cadfit.occt import breps, checks
from cadfit.occt.checks import Caps, Wall
from cadfit.occt.kernel import CONFUSION, KernelError, building
from cadfit.occt.profiles import arcs, circle
from cadfit.occt.surfaces import Spine, rail, spine
from cadfit.stages import Progress, portion
from cadfit.sweeping.chain import chain, tightest
from cadfit.sweeping.laws import Law, is_constant, is_number, largest, law_of, smallest
from cadfit.sweeping.profile import Profile
from cadfit.sweeping.selfintersection import Crossing, SelfIntersectionError
from cadfit.sweeping.sweep import sweep
from cadfit.sweeping.tube import tube
from cadfit.sweeping.wanted import path_of, positive

if TYPE_CHECKING:
    from trimesh import Trimesh

_FINE = 1e-4  # of the reach: the tolerance where none is given
_CUSP = 0.1  # of the reach: a path that bends more tightly is refused whatever the profile
_MESHED, _RAILED, _BUILT = 0.3, 0.5, 0.7  # of the work, about: the rest is checks
_DENSER = (1, 2, 4, 8, 16)  # times as many stations, until the tolerance can be seen to be kept


def sweep_solid(
    path: Any,
    profile: Any,
    tolerance: float | None = None,
    *,
    scale: Law = 1.0,
    twist: Law = 0.0,
    up: ArrayLike | None = None,
    caps: Caps = "flat",
    progress: Progress | None = None,
) -> TopoDS_Solid:
    """Return the solid that a profile sweeps out along a path: faces, edges and vertices made outright, then checked.

    `path`, `profile`, `scale`, `twist`, `up` as in `cadfit.sweep`; `caps` are "flat" or "round". A wall is nowhere
    farther than `tolerance` (default: a ten-thousandth of the profile's reach, at least `CONFUSION`) from the exact
    one, seen at several places between any two of its knots; round the profile it is exact. There is a face for each
    smooth part of the profile (two where that is all of it) and each part of the path between corners and jumps of
    curvature. Corners are mitred, exactly between straight parts; else the walls lean toward the mitre over four times
    its depth. `progress` is called with the part that is done, from 0 to 1, a few times; raising from
    it stops.

    Before it is returned a mesh of the sweep has been found not to pass through itself; the volume between the walls,
    integrated exactly, is that of the exact sweep within the tolerance times the walls' area, and the mesh's within the
    mesh's tolerance; and the kernel has found the solid valid, and of this volume and area but for its own errors.

    Raises KernelError naming the cause and the place where no such solid exists: the path bends more tightly than the
    profile reaches, a part between corners is too short for their mitres, a cusp, distant parts that touch; ValueError
    for bad input, as `cadfit.sweep`.

    >>> from cadfit import polyline
    >>> from cadfit.occt import volume
    >>> bar = sweep_solid(polyline([[0, 0, 0], [9, 0, 0], [9, 5, 0]]), [[-1, -1], [1, -1], [1, 1], [-1, 1]])
    >>> round(volume(bar), 6)
    56.0
    """
    along, at = path_of(path), getattr(path, "parameters", None)
    closed = along.closed
    shape = Profile.of(profile)
    if tolerance is not None:
        tolerance = positive(tolerance, "tolerance")
    relative = 0.1 * (_FINE if tolerance is None else tolerance / shape.reach)
    sizes = law_of(scale, along.domain, "scale", relative, at, closed)
    angle = np.array([[along.domain[0], 0.0], [along.domain[1], twist]]) if is_number(twist) else twist
    turns = law_of(angle, along.domain, "twist", relative, at, closed)
    walls = [Wall(arcs(loop), sizes) for loop in shape.loops]

    def mesh() -> Trimesh:
        like: dict[str, Any] = {"scale": sizes, "twist": turns, "up": up, "caps": caps}
        return sweep(along, shape, on_self_intersection="raise", progress=portion(progress, 0.0, _MESHED), **like)

    return _solid(along, walls, turns, up, tolerance, caps, mesh, "reach", portion(progress, 0.0, 1.0))


def tube_solid(
    path: Any,
    radius: Law,
    tolerance: float | None = None,
    *,
    thickness: float | None = None,
    up: ArrayLike | None = None,
    caps: Caps = "flat",
    progress: Progress | None = None,
) -> TopoDS_Solid:
    """Return the solid tube round a path, hollow where a `thickness` of its wall is given.

    `path`, `radius`, `thickness`, `up` as in `cadfit.tube`; `tolerance` (default: a ten-thousandth of the radius),
    `caps` and `progress` as in `sweep_solid`. Two faces go round, so that none has a seam; each is exactly round.
    Checked, and raises, as `sweep_solid`.

    >>> path = BSpline([[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 3]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> from cadfit.occt import volume
    >>> round(volume(tube_solid(path, 1.0)) / math.pi, 6)
    3.0
    """
    along, at = path_of(path), getattr(path, "parameters", None)
    closed = along.closed
    if tolerance is not None:
        tolerance = positive(tolerance, "tolerance")
    if is_number(radius):
        radius = positive(radius, "radius")
    size = positive(largest(law_of(radius, along.domain, "radius", np.inf, at, closed)), "radius")
    accuracy = 0.1 * (_FINE * size if tolerance is None else tolerance)
    outer = law_of(radius, along.domain, "radius", accuracy, at, closed)
    walls = [Wall(circle(), outer)]
    if thickness is not None:
        thickness = positive(thickness, "thickness")
        if thickness >= smallest(outer):
            raise ValueError(f"the thickness {thickness:g} is not below the radius, {smallest(outer):g} at its least")
        walls.append(Wall(circle(clockwise=True), BSpline(outer.poles - thickness, outer.knots)))

    def mesh() -> Trimesh:
        law = radius if is_number(radius) else outer
        like: dict[str, Any] = {"thickness": thickness, "up": up, "caps": caps}
        return tube(along, law, on_self_intersection="raise", progress=portion(progress, 0.0, _MESHED), **like)

    still = law_of(0.0, along.domain, "twist", 1.0)
    return _solid(along, walls, still, up, tolerance, caps, mesh, "radius", portion(progress, 0.0, 1.0))


def _solid(
    path: BSpline,
    walls: Sequence[Wall],
    twist: BSpline,
    up: ArrayLike | None,
    tolerance: float | None,
    caps: Caps,
    mesh: Callable[[], Trimesh],
    what: Literal["radius", "reach"],
    progress: Progress,
) -> TopoDS_Solid:
    """Return the solid between walls, the outer one first; `mesh` makes a mesh of the same, `what` names the reach."""
    if caps not in ("flat", "round"):
        raise ValueError(f"a solid's caps must be flat or round, not {caps!r}")
    if caps == "round" and len(walls) > 1:
        raise ValueError("round caps are for what has no holes")
    reach = max(wall.reach for wall in walls)
    tolerance = max(_FINE * reach if tolerance is None else tolerance, CONFUSION)
    _refuse_bends(path, reach, what, reach if what == "radius" and is_constant(walls[0].law) else _CUSP * reach)
    try:
        example = mesh()
    except SelfIntersectionError as error:
        raise KernelError(f"no solid: {error}") from error
    whole, rails = _rails(path, walls, twist, up, reach, tolerance)
    progress(_RAILED)
    exact = math.fsum(checks.exact(whole, wall) for wall in walls)
    each = [checks.held(wall.loop, row) for wall, row in zip(walls, rails, strict=True)]
    held, area = [volume for volume, _ in each], math.fsum(area for _, area in each)
    if not abs(math.fsum(held) - exact) <= tolerance * area:
        raise KernelError(f"the walls hold {math.fsum(held):.9g}, not {exact:.9g}")
    if not whole.closed:
        for end in path.domain:
            more, size = checks.end(walls, end, caps)
            held, area = [*held, more], area + size
    meshed = checks.enclosed(example.vertices, example.faces)
    if not abs(meshed - math.fsum(held)) <= 0.01 * reach * area:  # a hundredth is the mesh's tolerance
        raise KernelError(f"the walls hold {math.fsum(held):.9g}, a mesh of the same {meshed:.9g}")
    with building(f"a solid of {sum(len(row.poles) for row in rails[0])} sections"):
        made = _built(walls, rails, whole.closed, caps)
        progress(_BUILT)
        checks.check(made, held, area)
    progress(1.0)
    return made


def _refuse_bends(path: BSpline, reach: float, what: str, tight: float) -> None:
    """Raise KernelError for a bend that is surely too tight at once: a mesh of it may be finer than any use."""
    u, bend = tightest(chain(path), reach)
    if bend <= tight:
        u = min(u, path.domain[1])
        found = Crossing("bend" if bend > 0.0 else "cusp", u, path(u), reach, bend)
        raise KernelError(f"no solid: {found.said(what)}")


def _rails(
    path: BSpline, walls: Sequence[Wall], twist: BSpline, up: ArrayLike | None, reach: float, tolerance: float
) -> tuple[Spine, list[list[BSpline]]]:
    """Return the path's stretches, and for each wall a rail along each."""
    for density in _DENSER:
        whole = spine(path, reach, twist, up, density)
        checks.forward(path, whole, walls[0])
        rails = [[rail(stretch, wall.law, wall.far, tolerance) for stretch in whole.stretches] for wall in walls]
        found = [[made for made in row if made is not None] for row in rails]
        if found == rails:
            return whole, found
    raise KernelError(f"no spline surface keeps the tolerance {tolerance:.3g}: try a larger one")


def _built(walls: Sequence[Wall], rails: Sequence[Sequence[BSpline]], closed: bool, caps: Caps) -> TopoDS_Solid:
    flat = closed or caps == "flat"
    made = [breps.wall(wall.loop, _joined(row, closed), closed, flat) for wall, row in zip(walls, rails, strict=True)]
    shells = [faces for faces, _, _ in made]
    if closed:
        return breps.solid(shells)
    stands = rails[0][0].poles[0], rails[0][-1].poles[-1]
    faces = [face for shell in shells for face in shell]
    ends = [first for _, first, _ in made], [last for _, _, last in made]
    for stand, rings, outward in zip(stands, ends, (False, True), strict=True):
        if caps == "flat":
            faces.append(breps.cap(stand, rings, outward))
        else:
            faces += breps.dome(walls[0].loop, stand, rings[0], outward)
    return breps.solid([faces])


def _joined(rails: Sequence[BSpline], closed: bool) -> list[BSpline]:
    """Return the rails, each starting with the very pole its forerunner ends with; a closed one alone cut in two."""
    rails = list(rails)
    if closed and len(rails) == 1:
        inner = rails[0].distinct_knots
        rails = [*rails[0].split(float(inner[len(inner) // 2]))]
    for k in range(0 if closed else 1, len(rails)):
        poles = rails[k].poles.copy()
        poles[0] = rails[k - 1].poles[-1]
        rails[k] = BSpline(poles, rails[k].knots)
    return rails
