"""What a swept solid is held to before it is returned: volumes and areas, known apart from the kernel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.TopoDS import TopoDS_Solid
from scipy.interpolate import CubicSpline

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline
from cadfit.occt import breps
from cadfit.occt.kernel import KernelError
from cadfit.occt.measuring import volume_and_area
from cadfit.occt.profiles import Loop, moments, outline, quadrature
from cadfit.occt.surfaces import Spine, framed
from cadfit.sweeping.laws import largest

Caps = Literal["flat", "round"]
"""How an open solid ends."""

_VOLUME = 1e-5  # how far, of it, what the kernel's faces hold may be from what was wanted
_AREA = 1e-3  # the same of their area, where Gauss' rule does not see the tightest bends of a profile to 1e-4
_AT_ONCE = 1_000_000  # places whose areas are summed in one go
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


def exact(whole: Spine, wall: Wall) -> float:
    """Return the volume inside the exact wall (negative: a hole's)."""
    volumes = []
    for stretch in whole.stretches:
        s = stretch.lengths
        advance = _advance(*framed(stretch, wall.law)) @ moments(wall.loop)
        volumes.append(float(CubicSpline(s, advance).integrate(0.0, s[-1])))
    return math.fsum(volumes)


def held(loop: Loop, rails: Sequence[BSpline]) -> tuple[float, float]:
    """Return the volume inside the wall of a loop along rails (negative: a hole's), and the wall's area.

    The first is exact, its integrand being a polynomial in each span; of the second Gauss' rule is within 1e-6.
    """
    volume = area = 0.0
    places, velocities = quadrature(loop)
    for rail in rails:
        knots = rail.distinct_knots
        half = 0.5 * np.diff(knots)[:, None]
        t, weights = (knots[:-1, None] + half * (1.0 + _NODES)).ravel(), (half * _WEIGHTS).ravel()
        values, rates = rail(t), rail.derivative(t)
        volume += float((_advance(values, rates) @ moments(loop)) @ weights)
        for rows in np.array_split(np.arange(len(t)), math.ceil(len(t) * len(places) / _AT_ONCE)):
            along = breps.swept(rates[rows], places)
            around = breps.swept(np.hstack([np.zeros((len(rows), 3)), values[rows, 3:]]), velocities)
            area += float(np.linalg.norm(np.cross(along, around), axis=2).sum(axis=1) @ weights[rows])
    return volume, area


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
    """Raise KernelError unless the kernel finds the solid valid, its faces holding these volumes' sum, of this area."""
    if not BRepCheck_Analyzer(solid).IsValid():
        raise KernelError("the kernel finds it invalid")
    found, size = volume_and_area(solid)
    if not abs(found - sum(volumes)) <= _VOLUME * sum(map(abs, volumes)):
        raise KernelError(f"its volume is {found:.9g} to the kernel, not {sum(volumes):.9g}")
    if not abs(size - area) <= _AREA * area:
        raise KernelError(f"its area is {size:.9g} to the kernel, not {area:.9g}")


def _advance(values: Array, rates: Array) -> Array:
    """Return the volume (n, 3) swept by unit area at the origin, and more for each unit of x and y, in unit time."""
    across = np.cross(values[:, 3:6], values[:, 6:])
    return np.asarray(np.einsum("nkd,nd->nk", rates.reshape(-1, 3, 3), across))
