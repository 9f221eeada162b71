"""Tubes and swept profiles as solids, each checked before it is returned."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS_Solid
from scipy.interpolate import CubicSpline

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.occt import breps
from cadfit.occt.kernel import CONFUSION, KernelError, building
from cadfit.occt.profiles import Loop, arcs, circle, moments, outline
from cadfit.occt.surfaces import Spine, framed, place, rail, spine
from cadfit.sweeping.profile import Profile
from cadfit.sweeping.stations import chain, tightest
from cadfit.sweeping.sweep import Caps, Law, path_of

_DENSER = (1, 2, 4, 8, 16)
_SECTIONS = 400  # of a stretch, for its area
_KERNEL = 2e-5  # how far the kernel's volume may be from ours; its quick integral is mostly better, at times not
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)  # exact for polynomials of degree 9


def sweep_solid(
    path: Any,
    profile: Any,
    tolerance: float | None = None,
    *,
    scale: Law = 1.0,
    twist: float = 0.0,
    caps: Caps = "flat",
) -> TopoDS_Solid:
    """Return the solid that a profile sweeps out along a path: faces, edges and vertices made outright, then checked.

    `path`: a `BSpline` in 2 or 3 dimensions (2D lies in z = 0), a `Fit`, or several curves end to end; `profile`: a
    `Profile`, a polygon (k, 2), a closed `BSpline` in 2D, a `Fit`. Sections stand square to the path in
    rotation-minimizing frames, turned by `twist` radians in all, and grow by `scale` (a number, a function of the
    path's parameter, or a 1D `BSpline`). Corners are mitred: exactly between straight parts, else the walls lean over
    four times the mitre's depth. Ends are flat; a closed path has none. A surface is nowhere farther than `tolerance`
    (default: a ten-thousandth of the profile's reach) from the exact one, seen at several places between knots.

    Before it is returned, its volume is that of the exact sweep within the tolerance times the walls' area, and the
    kernel has found it valid, of this volume and of the right area.

    Raises KernelError naming the cause and the place where no such solid exists: the path bends more tightly than the
    profile reaches, a stretch between corners is too short for their mitres, a cusp; ValueError for bad input.

    >>> from cadfit import polyline
    >>> bar = sweep_solid(polyline([[0, 0, 0], [9, 0, 0], [9, 5, 0]]), [[-1, -1], [1, -1], [1, 1], [-1, 1]])
    >>> round(volume(bar), 6)
    56.0
    """
    profile = Profile.of(profile)
    walls = [(arcs(loop), scale) for loop in profile.loops]
    return _solid(path_of(path), walls, tolerance, twist, caps)


def tube_solid(
    path: Any,
    radius: Law,
    tolerance: float | None = None,
    *,
    thickness: float | None = None,
    caps: Caps = "flat",
) -> TopoDS_Solid:
    """Return the solid tube round a path, hollow where a `thickness` of its wall is given.

    `path` and `tolerance` (default: a ten-thousandth of the radius) as in `sweep_solid`; `radius` is a number, a
    function of the path's parameter, or a 1D `BSpline`, and reaches to the outside. Two faces go round, so that none
    has a seam; each is exactly round. Checked, and raises, as `sweep_solid`.

    >>> path = BSpline([[0, 0, 0], [0, 0, 1], [0, 0, 2], [0, 0, 3]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> round(volume(tube_solid(path, 1.0)) / math.pi, 6)
    3.0
    """
    walls: list[tuple[Loop, Law]] = [(circle(), radius)]
    if thickness is not None:
        if not thickness > 0.0:
            raise ValueError(f"the thickness must be above zero, not {thickness:g}")
        walls.append((circle(clockwise=True), lambda u: values_of(radius, u, "radius") - thickness))
    return _solid(path_of(path), walls, tolerance, 0.0, caps)


def volume(solid: TopoDS_Solid) -> float:
    """Return a solid's volume as the kernel integrates it, asked for 1e-6 of each face's part, true to about 1e-5."""
    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, found, 1e-6)
    return float(found.Mass())


def values_of(law: Law, u: Array, name: str) -> Array:
    """Return a number, a function or a 1D spline at the parameters u (n,).

    Raises ValueError naming the first place where it is not finite and above zero.
    """
    if isinstance(law, BSpline):
        found = law(u)[:, 0]
    elif callable(law):
        found = np.broadcast_to(np.asarray(law(u), dtype=np.float64), u.shape)
    else:
        found = np.broadcast_to(float(law), u.shape)  # type: ignore[arg-type]
    bad = ~(np.isfinite(found) & (found > 0.0))
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(f"the {name} must be finite and above zero, not {found[row]:g} at the parameter {u[row]:g}")
    return found


def _solid(
    path: BSpline, walls: Sequence[tuple[Loop, Law]], tolerance: float | None, twist: float, caps: Caps
) -> TopoDS_Solid:
    """Return the solid between walls, the outer one first."""
    if caps not in ("flat", "round"):
        raise ValueError(f"a solid's caps are flat or round, not {caps!r}")
    if caps == "round" and len(walls) > 1 and not path.closed:
        raise ValueError("round caps are for what has no holes")
    outlines = [outline(loop) for loop, _ in walls]
    names = ["scale or radius", *["inner radius"] * (len(walls) - 1)]
    coarse = np.linspace(*path.domain, 257)
    scales = [values_of(law, coarse, name) for (_, law), name in zip(walls, names, strict=True)]
    reaches = [float(np.linalg.norm(places, axis=1).max()) for places in outlines]
    reach = max(float(scale.max()) * far for scale, far in zip(scales, reaches, strict=True))
    tolerance = 1e-4 * reach if tolerance is None else float(tolerance)
    if not tolerance > 0.0 or not math.isfinite(tolerance):
        raise ValueError(f"the tolerance must be finite and above zero, not {tolerance:g}")
    tolerance = max(tolerance, CONFUSION)
    for density in _DENSER:
        whole = spine(path, reach, twist, density)
        rows = [
            [values_of(law, s.given, name) for s in whole.stretches]
            for (_, law), name in zip(walls, names, strict=True)
        ]
        _look(path, whole, outlines[0], rows[0], reach)
        rails = [
            [rail(s, scale, far, tolerance) for s, scale in zip(whole.stretches, row, strict=True)]
            for row, far in zip(rows, reaches, strict=True)
        ]
        found = [[r for r in row if r is not None] for row in rails]
        if found == rails:
            break
    else:
        raise KernelError(f"no spline surface keeps the tolerance {tolerance:.3g}: try a larger one")
    loops = [loop for loop, _ in walls]
    wanted = [_exact(whole, loop, row) for loop, row in zip(loops, rows, strict=True)]
    held = [_held(loop, row) for loop, row in zip(loops, found, strict=True)]
    area = sum(size for _, size in wanted)
    if not abs(sum(held) - sum(size for size, _ in wanted)) <= tolerance * area:
        raise KernelError(f"the walls hold {sum(held):.9g}, not {sum(size for size, _ in wanted):.9g}")
    if not whole.closed:
        for end in ([row[0][0] for row in rows], [row[-1][-1] for row in rows]):
            more, size = _end(loops, end, caps)
            held, area = [*held, more], area + size
    with building(f"a solid of {sum(len(r.poles) for r in found[0])} sections"):
        made = _built(loops, found, whole.closed, caps)
        _check(made, held, area)
    return made


def _built(loops: Sequence[Loop], rails: Sequence[Sequence[BSpline]], closed: bool, caps: Caps) -> TopoDS_Solid:
    walls = [breps.wall(loop, _joined(row, closed), closed) for loop, row in zip(loops, rails, strict=True)]
    shells = [faces for faces, _, _ in walls]
    if closed:
        return breps.solid(shells)
    stands = rails[0][0].poles[0], rails[0][-1].poles[-1]
    faces = [face for shell in shells for face in shell]
    for stand, rings, outward in zip(
        stands, zip(*(ends for _, *ends in walls), strict=True), (False, True), strict=True
    ):
        if caps == "flat":
            faces.append(breps.cap(stand, rings, outward))
        else:
            faces += breps.dome(loops[0], stand, rings[0], outward)
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


def _look(path: BSpline, whole: Spine, places: Array, scales: Sequence[Array], reach: float) -> None:
    """Raise KernelError where a wall would run backward, naming the cause."""
    _, bend = tightest(chain(path), reach)
    for stretch, scale in zip(whole.stretches, scales, strict=True):
        values, rates = framed(stretch, scale)
        along = _advance(values, rates)
        forward = (along[:, :1] + along[:, 1:] @ places.T).min(axis=1)
        if (forward > 0.0).all():
            continue
        row = int(np.argmin(forward))
        where = place(path, float(stretch.given[row]))
        if stretch.slopes.any() and (1.0 - scale * (stretch.bends @ places.T).max(axis=1) > 0.0).all():
            raise KernelError(
                f"{where} the mitres of the corners meet: the path runs {stretch.lengths[-1]:.4g} between them, "
                f"too short for a profile that reaches {reach:.4g}"
            )
        remedy = f"a radius below {bend:.4g} would do" if bend > 0.0 and math.isfinite(bend) else "make it smaller"
        raise KernelError(f"{where} the path bends more tightly than the profile reaches ({reach:.4g}): {remedy}")


def _exact(whole: Spine, loop: Loop, scales: Sequence[Array]) -> tuple[float, float]:
    """Return the volume inside the exact wall of a loop (negative: a hole's), and the wall's area."""
    held = area = 0.0
    first = moments(loop)
    places, velocities = (np.concatenate(parts) for parts in zip(*(arc.quadrature() for arc in loop), strict=True))
    for stretch, scale in zip(whole.stretches, scales, strict=True):
        values, rates = framed(stretch, scale)
        held += float(CubicSpline(stretch.lengths, _advance(values, rates) @ first).integrate(0.0, stretch.lengths[-1]))
        rows = np.unique(np.linspace(0, len(scale) - 1, _SECTIONS).astype(np.intp))
        forward = breps.swept(rates[rows], places)
        around = breps.swept(np.hstack([np.zeros((len(rows), 3)), values[rows, 3:]]), velocities)
        sections = np.linalg.norm(np.cross(forward, around), axis=2).sum(axis=1)
        area += float(np.trapezoid(sections, stretch.lengths[rows]))
    return held, area


def _held(loop: Loop, rails: Sequence[BSpline]) -> float:
    """Return the volume inside the wall of a loop along rails (negative: a hole's); the integrand is a polynomial."""
    total = 0.0
    for rail_ in rails:
        knots = rail_.distinct_knots
        half = 0.5 * np.diff(knots)[:, None]
        t = (knots[:-1, None] + half * (1.0 + _NODES)).ravel()
        total += float((_advance(rail_(t), rail_.derivative(t)) @ moments(loop)) @ (half * _WEIGHTS).ravel())
    return total


def _advance(values: Array, rates: Array) -> Array:
    """Return the volume (n, 3) swept by unit area at the origin, and more for each unit of x and y, in unit time."""
    across = np.cross(values[:, 3:6], values[:, 6:])
    return np.asarray(np.einsum("nkd,nd->nk", rates.reshape(-1, 3, 3), across))


def _end(loops: Sequence[Loop], scales: Sequence[float], caps: Caps) -> tuple[float, float]:
    """Return the volume beyond an end, where loops stand scaled, and the area that closes it."""
    base = float(sum(moments(loop)[0] * scale**2 for loop, scale in zip(loops, scales, strict=True)))
    if caps == "flat":
        return 0.0, base
    places, velocities = (np.concatenate(parts) for parts in zip(*(arc.quadrature() for arc in loops[0]), strict=True))
    places, velocities = scales[0] * places, scales[0] * velocities
    rise = scales[0] * breps.height(loops[0])
    angle = 0.25 * np.pi * (1.0 + _NODES)[:, None]
    level, upright = (
        np.linalg.norm(velocities, axis=1),
        places[:, 0] * velocities[:, 1] - places[:, 1] * velocities[:, 0],
    )
    strips = np.cos(angle) * np.hypot(rise * np.cos(angle) * level, np.sin(angle) * upright)
    return 2.0 / 3.0 * rise * base, float(0.25 * np.pi * _WEIGHTS @ strips.sum(axis=1))


def _check(solid: TopoDS_Solid, held: Sequence[float], area: float) -> None:
    """Raise KernelError unless the kernel finds the solid valid, and of the volume within its walls and this area."""
    if not BRepCheck_Analyzer(solid).IsValid():
        raise KernelError("the kernel finds it invalid")
    allowed = _KERNEL * sum(map(abs, held))
    found = volume(solid)
    if not abs(found - sum(held)) <= allowed:  # either the solid, or the quick integral
        precise = GProp_GProps()
        BRepGProp.VolumePropertiesGK_s(solid, precise, 1e-6)
        found = precise.Mass()
    if not abs(found - sum(held)) <= allowed:
        raise KernelError(f"its volume is {found:.9g} to the kernel, not {sum(held):.9g}")
    faces = GProp_GProps()
    BRepGProp.SurfaceProperties_s(solid, faces, 1e-4)
    if not abs(faces.Mass() - area) <= 1e-3 * area:
        raise KernelError(f"its area is {faces.Mass():.9g} to the kernel, not {area:.9g}")
