"""What a swept solid is held to before it is returned: volumes and areas, known apart from the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopoDS import TopoDS_Solid
from scipy.interpolate import CubicSpline

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.occt import breps
from cadfit.occt.kernel import KernelError
from cadfit.occt.profiles import Loop, moments, outline, quadrature
from cadfit.occt.surfaces import Spine, framed
from cadfit.sweeping.laws import largest
from cadfit.sweeping.sweep import Caps

_SECTIONS = 1000  # of a stretch, for its area
_KERNEL = 2e-5  # how far the kernel's volume may be from ours
_DOUBTED = 2e-3  # the same where its quick integral is not that near: its slow one is mostly better, at times not
_AREA = 2e-2  # how far the kernel's area may be from ours: it is less exact where a bend is almost too tight
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)  # exact for polynomials of degree 9


@dataclass(frozen=True, slots=True, eq=False)
class Wall:
    """A loop of the profile and the law by which it is scaled along the path."""

    loop: Loop
    law: BSpline

    @property
    def far(self) -> float:
        """How far the loop reaches, unscaled."""
        return float(np.linalg.norm(outline(self.loop), axis=1).max())

    @property
    def reach(self) -> float:
        """How far the wall reaches from the path."""
        return self.far * largest(self.law)


def forward(path: BSpline, whole: Spine, wall: Wall) -> None:
    """Raise KernelError where a wall runs backward: what the mesh of the same did not show."""
    places = outline(wall.loop)
    for stretch in whole.stretches:
        advance = _advance(*framed(stretch, wall.law))
        slowest = (advance[:, :1] + advance[:, 1:] @ places.T).min(axis=1)
        if slowest.min() <= 0.0:
            u = float(stretch.given[np.argmin(slowest)])
            near = ", ".join(f"{x:g}" for x in path(u))
            raise KernelError(
                f"at the parameter {u:g}, near ({near}), the walls run backward: a bend or a mitre is tight"
            )


def exact(whole: Spine, wall: Wall) -> tuple[float, float]:
    """Return the volume inside the exact wall (negative: a hole's), and the wall's area."""
    volume = area = 0.0
    places, velocities = quadrature(wall.loop)
    for stretch in whole.stretches:
        s = stretch.lengths
        values, rates = framed(stretch, wall.law)
        volume += float(CubicSpline(s, _advance(values, rates) @ moments(wall.loop)).integrate(0.0, s[-1]))
        rows = np.unique(np.linspace(0, len(s) - 1, _SECTIONS).astype(np.intp))
        along = breps.swept(rates[rows], places)
        around = breps.swept(np.hstack([np.zeros((len(rows), 3)), values[rows, 3:]]), velocities)
        sections = np.linalg.norm(np.cross(along, around), axis=2).sum(axis=1)
        area += float(np.trapezoid(sections, s[rows]))
    return volume, area


def held(loop: Loop, rails: Sequence[BSpline]) -> float:
    """Return the volume inside the wall of a loop along rails (negative: a hole's); the integrand is a polynomial."""
    total = 0.0
    for rail in rails:
        knots = rail.distinct_knots
        half = 0.5 * np.diff(knots)[:, None]
        t = (knots[:-1, None] + half * (1.0 + _NODES)).ravel()
        total += float((_advance(rail(t), rail.derivative(t)) @ moments(loop)) @ (half * _WEIGHTS).ravel())
    return total


def end(walls: Sequence[Wall], u: float, caps: Caps) -> tuple[float, float]:
    """Return the volume beyond the path's end at a parameter, and the area that closes it."""
    scales = [float(wall.law(u)[0]) for wall in walls]
    base = float(sum(moments(wall.loop)[0] * scale**2 for wall, scale in zip(walls, scales, strict=True)))
    if caps == "flat":
        return 0.0, base
    (x, y), (dx, dy) = (scales[0] * values.T for values in quadrature(walls[0].loop))
    rise = scales[0] * walls[0].far
    angle = 0.25 * np.pi * (1.0 + _NODES)[:, None]
    strips = np.cos(angle) * np.hypot(rise * np.cos(angle) * np.hypot(dx, dy), np.sin(angle) * (x * dy - y * dx))
    return 2.0 / 3.0 * rise * base, float(0.25 * np.pi * _WEIGHTS @ strips.sum(axis=1))


def enclosed(vertices: Array, faces: Ints) -> float:
    """Return the volume within triangles (f, 3) that face outward.

    >>> enclosed(np.concatenate([np.zeros((1, 3)), np.eye(3)]), np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    0.16666666666666666
    """
    a, b, c = (vertices - vertices.mean(axis=0))[faces].transpose(1, 2, 0)
    cross = np.stack([b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]])
    return float(np.einsum("dn,dn->", a, cross)) / 6.0


def check(solid: TopoDS_Solid, volumes: Sequence[float], area: float) -> None:
    """Raise KernelError unless the kernel finds the solid valid, and of these volumes' sum and this area."""
    if not BRepCheck_Analyzer(solid).IsValid():
        raise KernelError("the kernel finds it invalid")
    wanted, all_ = sum(volumes), sum(map(abs, volumes))
    found = kernel_volume(solid)
    if not abs(found - wanted) <= _KERNEL * all_:  # either the solid, or the quick integral
        precise = GProp_GProps()
        BRepGProp.VolumePropertiesGK_s(solid, precise, 1e-6)
        found = precise.Mass()
    if not abs(found - wanted) <= _DOUBTED * all_:
        raise KernelError(f"its volume is {found:.9g} to the kernel, not {wanted:.9g}")
    faces = GProp_GProps()
    BRepGProp.SurfaceProperties_s(solid, faces, 1e-4)
    if not abs(faces.Mass() - area) <= _AREA * area:
        raise KernelError(f"its area is {faces.Mass():.9g} to the kernel, not {area:.9g}")


def kernel_volume(solid: TopoDS_Solid) -> float:
    """Return a solid's volume by the kernel's quick adaptive integral."""
    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, found, 1e-6)
    return float(found.Mass())


def _advance(values: Array, rates: Array) -> Array:
    """Return the volume (n, 3) swept by unit area at the origin, and more for each unit of x and y, in unit time."""
    across = np.cross(values[:, 3:6], values[:, 6:])
    return np.asarray(np.einsum("nkd,nd->nk", rates.reshape(-1, 3, 3), across))
