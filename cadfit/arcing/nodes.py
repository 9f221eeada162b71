"""Places along a curve where arcs may meet: dense where its curvature changes, or where single arcs reach less far."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints

PER_ARC = 20.0  # nodes in the length of an arc, where the curvature changes evenly
_PER_TURN = 36.0  # nodes in a full turn, at least
_LEAST = 24.0  # nodes in a stretch, at least
_SAMPLES = 16  # of a piece's density


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Points of a curve in order: `places` (s,) (piece and part of it as one number), `points` (s, 2), `angles` (s,).

    The angles are those of the tangent, unwrapped.
    """

    places: Array
    points: Array
    angles: Array


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Where arcs may meet: at the samples `rows` (n,), not falling, or beside them: `spots` (n, 2).

    Nodes of one row are beside each other; the first and the last row have one. `corners` (n,): what arrives there says
    nothing of the direction in which to leave.
    """

    samples: Samples
    rows: Ints
    spots: Array
    corners: NDArray[np.bool_]

    @property
    def at(self) -> Array:
        """The places of the curve that the nodes stand for (n,)."""
        return self.samples.places[self.rows]

    @property
    def angles(self) -> Array:
        """The curve's angles there (n,)."""
        return self.samples.angles[self.rows]

    @property
    def table(self) -> Ints:
        """The nodes of each row that has any (p, lanes): their numbers, -1 where there are fewer."""
        first = np.flatnonzero(np.diff(self.rows, prepend=-1))
        count = np.diff(first, append=len(self.rows))
        lane = np.arange(int(count.max()))
        return np.where(lane < count[:, None], first[:, None] + lane, -1)

    def only(self, some: NDArray[np.bool_]) -> Nodes:
        """Return some of the nodes (n,), with all samples."""
        return Nodes(self.samples, self.rows[some], self.spots[some], self.corners[some])


def along_pieces(pieces: Array, tolerance: float, density: float) -> Nodes:
    """Choose nodes along Bézier pieces (m, 4, 2) that follow each other without corners; a sample between any two.

    Where the curvature changes by c in a unit of length, an arc within the tolerance e is (124.7 e / c)^(1/3) long: of
    all quadratic splines with even knots the one nearest to a cubic misses it by a Bernoulli polynomial.
    """
    m = len(pieces)
    t = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
    first, second, third = _derivatives(pieces, t)
    speed = np.maximum(np.hypot(first[..., 0], first[..., 1]), 1e-300)
    bend = _cross(first, second) / speed**3
    change = _cross(first, third) / speed**3 - 3.0 * bend * np.einsum("mtd,mtd->mt", first, second) / speed**2
    with np.errstate(over="ignore", invalid="ignore"):
        wanted = np.cbrt(np.abs(change / speed) / (124.7 * tolerance))
        wanted = PER_ARC * np.nan_to_num(np.minimum(wanted, 1.0 / tolerance), nan=0.0)
    steps = speed / _SAMPLES
    turned = np.minimum(np.abs(bend) * steps, np.pi)
    mass = density * (wanted * steps + _PER_TURN / (2.0 * np.pi) * turned + _LEAST * steps / max(steps.sum(), 1e-300))
    total = np.concatenate([[0.0], np.cumsum(mass.ravel())])
    count = max(int(np.ceil(total[-1])), 2)
    level = np.linspace(0.0, total[-1], 2 * count + 1)
    at = np.interp(level, total, np.arange(m * _SAMPLES + 1) / _SAMPLES)
    at[0], at[-1] = 0.0, m
    at = at[np.concatenate([[True], np.diff(at) > 0.0])]
    at = at if len(at) % 2 else np.delete(at, -2)
    points, tangent = points_at(pieces, at)
    rows = np.arange(0, len(at), 2)
    samples = Samples(at, points, np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0])))
    return Nodes(samples, rows, points[rows], np.zeros(len(rows), dtype=bool))


def points_at(pieces: Array, at: Array) -> tuple[Array, Array]:
    """Return points (n, 2) and derivatives (n, 2) at piece and parameter as one number (n,)."""
    k = np.minimum(at.astype(np.intp), len(pieces) - 1)
    t = (at - k)[:, None]
    p, s = pieces[k], 1.0 - t
    points = s**3 * p[:, 0] + 3.0 * s * s * t * p[:, 1] + 3.0 * s * t * t * p[:, 2] + t**3 * p[:, 3]
    legs = np.diff(p, axis=1)
    tangent = s * s * legs[:, 0] + 2.0 * s * t * legs[:, 1] + t * t * legs[:, 2]
    # Where a curve stands still at an end of a piece, it leaves along the next leg.
    still = np.hypot(tangent[:, 0], tangent[:, 1]) <= 1e-12 * np.abs(legs).max(axis=(1, 2))
    around = np.where(t < 0.5, p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    return points, np.where(still[:, None], around, tangent)


def _derivatives(pieces: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return the first three derivatives (m, len(t), 2) by the pieces' own parameters."""
    first, second, third = (np.diff(pieces, n=k, axis=1) for k in (1, 2, 3))
    t, s = t[:, None], 1.0 - t[:, None]
    velocity = 3.0 * (s * s * first[:, None, 0] + 2.0 * s * t * first[:, None, 1] + t * t * first[:, None, 2])
    bend = 6.0 * (s * second[:, None, 0] + t * second[:, None, 1])
    return velocity, bend, np.broadcast_to(6.0 * third, bend.shape)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
