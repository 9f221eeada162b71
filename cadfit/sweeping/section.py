"""What a path carries: the polygons that stand for a profile, with what varies along the path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.sweeping.laws import is_constant, largest


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """What a path carries: `loops`, polygons (k, 2) of an outline and its holes, each with its law in `scales`.

    `twist` is the law of the angle, in radians, by which the profile is turned from the normal toward the binormal.
    `outside`: how many times farther the polygons' corners reach than what they stand for.
    """

    loops: list[Array]
    scales: list[BSpline]
    twist: BSpline
    outside: float = 1.0

    @property
    def constant(self) -> bool:
        """Whether the section stays the same."""
        return is_constant(self.twist) and all(map(is_constant, self.scales))

    @property
    def reach(self) -> float:
        """How far what the polygons stand for reaches from the path."""
        far = [float(np.linalg.norm(loop, axis=1).max()) for loop in self.loops]
        return max(r * largest(scale) for r, scale in zip(far, self.scales, strict=True)) / self.outside

    def parted(self, corners: Array) -> list[Array]:
        """Return the corners (k, 2) of all loops apart."""
        return np.split(corners, np.cumsum([len(loop) for loop in self.loops])[:-1])

    def at(self, u: Array, turned: Array | float = 0.0) -> Array:
        """Return the corners (n, k, 2) at parameters u (n,), turned by more angles (n,)."""
        angle = self.twist(u)[:, 0] + turned
        cos, sin = np.cos(angle)[:, None], np.sin(angle)[:, None]
        x, y = (
            np.concatenate([scale(u) * loop[:, axis] for scale, loop in zip(self.scales, self.loops, strict=True)], 1)
            for axis in (0, 1)
        )
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=2)
