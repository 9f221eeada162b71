"""What a curve becomes: lines and arcs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadfit.bezier import Array, Ints

AXES = {"xy": (0, 1), "zx": (2, 0), "yz": (1, 2)}
"""The coordinates across and up of each plane, so that left turns (G3) are counterclockwise: G17, G18, G19."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Arcs:
    """Lines and arcs end to end, in 2D, or in 3D with the third coordinate rising evenly along each (helices).

    `starts`, `ends` (n, d), d 2 or 3. `centres` (n, 2): in the plane; not finite for lines. `sweeps` (n,): radians,
    left turns positive, 0 for lines. `plane`: "xy", "zx" or "yz"; in 2D always "xy". `corners`: rows, rising, of
    the arcs whose start is a corner; at all other joints the tangent is continuous, but for lines that stand for arcs
    above the largest radius. `deviation`: a certified bound, in the caller's unit, on how far curve and arcs are apart,
    both ways and in order. `tolerance`: what was asked for. `closed`: the last ends where the first starts.
    """

    starts: Array
    ends: Array
    centres: Array
    sweeps: Array
    plane: str
    corners: Ints
    deviation: float
    tolerance: float
    closed: bool

    def __len__(self) -> int:
        return len(self.starts)

    def __repr__(self) -> str:
        lines = int(np.count_nonzero(self.is_line))
        kind = "closed" if self.closed else "open"
        return f"Arcs({kind}, {len(self) - lines} arcs and {lines} lines, deviation {self.deviation:.3g})"

    @property
    def is_line(self) -> Array:
        """Whether each is a line (n,)."""
        return np.asarray(self.sweeps == 0.0)

    @property
    def axes(self) -> tuple[int, int]:
        """The coordinates of the plane, across and up."""
        return AXES[self.plane]

    @property
    def radii(self) -> Array:
        """The radii (n,), infinite for lines."""
        return np.asarray(np.where(self.is_line, np.inf, np.linalg.norm(self.flat(self.starts) - self.centres, axis=1)))

    @property
    def lengths(self) -> Array:
        """The lengths (n,) of lines, arcs and helices."""
        flat = self.flat(self.ends - self.starts)
        with np.errstate(invalid="ignore"):
            around = np.abs(self.sweeps) * self.radii
        run = np.where(self.is_line, np.linalg.norm(flat, axis=1), around)
        square = np.square(self.ends - self.starts).sum(axis=1) - np.square(flat).sum(axis=1)
        return np.asarray(np.sqrt(run * run + np.maximum(square, 0.0)))

    def flat(self, points: Array) -> Array:
        """Return the coordinates (..., 2) of points (..., d) in the plane."""
        return np.asarray(points[..., list(self.axes)], dtype=np.float64)

    def __call__(self, row: int, t: Array) -> Array:
        """Return points (k, d) of one line or arc at parts t (k,) of it, from 0 to 1."""
        t = np.asarray(t, dtype=np.float64)[:, None]
        points: Array = (1.0 - t) * self.starts[row] + t * self.ends[row]
        if sweep := float(self.sweeps[row]):
            arm = self.flat(self.starts[row]) - self.centres[row]
            cos, sin = np.cos(sweep * t), np.sin(sweep * t)
            points[:, list(self.axes)] = self.centres[row] + cos * arm + sin * np.array([-arm[1], arm[0]])
        return points
