"""How far a curve is from lines and arcs, both ways: bounds, not samples.

An arc starts at s with the unit tangent T, the left normal n and the signed curvature k (left turns positive, lines 0).
For a curve point g let q = (g - s).n - k |g - s|^2 / 2. Then g lies 2 q / (1 + sqrt(1 - 2 k q)) to the left of the
whole circle (or line), and, where (1 - 2 k q) > 0, moves forward about the centre where w = g'.T + k (g - s) x g' > 0.
On a cubic Bézier piece q and w are polynomials of degree 6 and 5, and lie within their Bernstein coefficients.

Where w > 0 all along, the angle about the centre rises from one end of the arc to the other (that it does not go round
once more is read off the length). So each curve point lies across from a point of the arc, and, the angle being
continuous, each point of the arc across from a curve point: the same bound holds both ways, and in order (it bounds the
Fréchet distance). No term is the difference of large numbers, so a radius of 1e9 is as good as a line.
"""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints, split

_EPS = float(np.finfo(np.float64).eps)
_CLOSE = 1.01  # a bound this near to a distance that occurs is not refined


def _product(a: int, b: int) -> Array:
    """Return the tensor (a + b + 1, a + 1, b + 1) that multiplies Bernstein polynomials of degrees a and b."""
    tensor = np.zeros((a + b + 1, a + 1, b + 1))
    for i in range(a + 1):
        for j in range(b + 1):
            tensor[i + j, i, j] = comb(a, i) * comb(b, j) / comb(a + b, i + j)
    return tensor


_SQUARE, _CROSS = _product(3, 3), _product(3, 2)
_RAISE_3_TO_6, _RAISE_2_TO_5 = _product(3, 3).sum(axis=2), _product(2, 3).sum(axis=2)


def frames_of(starts: Array, ends: Array, centres: Array, sweeps: Array) -> tuple[Array, Array]:
    """Return the unit tangents (m, 2) at the starts and the signed curvatures (m,) of lines (sweep 0) and arcs."""
    line = sweeps == 0.0
    toward = np.where(line[:, None], ends - starts, centres - starts)
    length = np.hypot(toward[:, 0], toward[:, 1])
    unit = toward / np.where(length > 0.0, length, 1.0)[:, None]
    side = np.sign(sweeps)
    right = np.column_stack([unit[:, 1], -unit[:, 0]]) * side[:, None]
    curvature = np.where(line, 0.0, side / np.where(length > 0.0, length, 1.0))
    return np.where(line[:, None], unit, right), curvature


def bounds(
    parts: Array, owner: Ints, starts: Array, ends: Array, centres: Array, sweeps: Array, least: float | None = None
) -> Array:
    """Return, for each of m lines and arcs, a bound (m,) on the distance between it and its parts of the curve.

    `parts` (p, 4, 2): Bézier pieces in order; `owner` (p,): the line or arc of each, rising, each with a part or more.
    Sweeps are between -pi and pi. A bound is within 1 % of a distance that occurs on its own arc, or at most `least`
    (None: the largest distance on any).
    """
    m = len(starts)
    first = np.searchsorted(owner, np.arange(m))
    last = np.searchsorted(owner, np.arange(m), side="right") - 1
    tangent, curvature = frames_of(starts, ends, centres, sweeps)
    noise = 64.0 * _EPS * max(float(np.abs(parts).max()), float(np.abs(starts).max()))
    local = parts - starts[owner][:, None]
    across, forward = _across(local, tangent[owner], curvature[owner], owner, m, least)
    tip, tip_tangent = _turned(tangent, sweeps), parts[last, 3] - ends
    gap = np.maximum(_gap(local[first, 0], tangent, curvature), _gap(tip_tangent, tip, curvature))
    bound = np.sqrt(across**2 + (1.0 + np.abs(curvature) * across) * gap**2)
    bound += _unround(starts, ends, centres, sweeps)
    polygon = np.bincount(owner, np.linalg.norm(np.diff(parts, axis=1), axis=2).sum(axis=1), m)
    once = np.abs(curvature) * polygon < (np.abs(sweeps) + 2.0 * np.pi) * (1.0 - np.abs(curvature) * across)
    # Where that shows nothing (a bend smaller than the tolerance), all of both may lie close together.
    far = np.linalg.norm(local, axis=2).max(axis=1)
    crude = np.maximum.reduceat(far, first) + np.linalg.norm(ends - starts, axis=1)
    return np.asarray(np.where(forward & once, np.minimum(bound, crude), crude) + noise)


def _across(
    local: Array, tangent: Array, curvature: Array, owner: Ints, m: int, least: float | None
) -> tuple[Array, NDArray[np.bool_]]:
    """Return bounds (m,) on the distance from the circles, and whether (m,) the angle about the centre rises."""
    across, forward = np.zeros(m), np.ones(m, dtype=bool)
    for _ in range(24):
        q = _q(local, tangent, curvature)
        away = np.maximum(_left(q.max(axis=1), curvature), -_left(q.min(axis=1), curvature))
        seen = np.maximum(np.abs(_left(q[:, 0], curvature)), np.abs(_left(q[:, 6], curvature)))
        w = _w(local, tangent, curvature)
        np.maximum.at(across, owner, seen)
        backward = (w[:, 0] < 0.0) | (w[:, 5] < 0.0)
        forward[owner[backward]] = False
        enough = np.maximum(across[owner], across.max() if least is None else least)
        done = (away <= _CLOSE * enough) & ((w.min(axis=1) >= 0.0) | ~forward[owner])
        np.maximum.at(across, owner[done], away[done])
        if done.all():
            return across, forward
        left, right = split(local[~done])
        # Parts stay in the order of the curve only within an arc; nothing here asks for more.
        local, owner = np.concatenate([left, right]), np.tile(owner[~done], 2)
        tangent, curvature = np.tile(tangent[~done], (2, 1)), np.tile(curvature[~done], 2)
    q, w = _q(local, tangent, curvature), _w(local, tangent, curvature)
    np.maximum.at(across, owner, np.maximum(_left(q.max(axis=1), curvature), -_left(q.min(axis=1), curvature)))
    forward[owner[w.min(axis=1) < 0.0]] = False
    return across, forward


def _q(local: Array, tangent: Array, curvature: Array) -> Array:
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    straight = np.einsum("pid,pd->pi", local, normal) @ _RAISE_3_TO_6.T
    square = np.einsum("kij,pid,pjd->pk", _SQUARE, local, local, optimize=True)
    return np.asarray(straight - 0.5 * curvature[:, None] * square)


def _w(local: Array, tangent: Array, curvature: Array) -> Array:
    legs = 3.0 * np.diff(local, axis=1)
    along = np.einsum("pid,pd->pi", legs, tangent) @ _RAISE_2_TO_5.T
    turned = np.stack([legs[..., 1], -legs[..., 0]], axis=-1)
    cross = np.einsum("kij,pid,pjd->pk", _CROSS, local, turned, optimize=True)
    return np.asarray(along + curvature[:, None] * cross)


def _left(q: Array, curvature: Array) -> Array:
    """Return how far to the left of the circle a point of that q lies; rises with q."""
    return np.asarray(2.0 * q / (1.0 + np.sqrt(np.maximum(1.0 - 2.0 * curvature * q, 0.0))))


def _turned(tangent: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([c * tangent[:, 0] - s * tangent[:, 1], s * tangent[:, 0] + c * tangent[:, 1]])


def _gap(offset: Array, tangent: Array, curvature: Array) -> Array:
    """Return how far along the arc an end of the curve is from the arc's own."""
    along = np.abs(np.einsum("md,md->m", offset, tangent))
    return np.asarray(along / np.maximum(1.0 - np.abs(curvature) * np.linalg.norm(offset, axis=1), 1e-3))


def _unround(starts: Array, ends: Array, centres: Array, sweeps: Array) -> Array:
    """Return how much the radii at both ends of each arc differ (rounded coordinates)."""
    radii = [np.linalg.norm(end - centres, axis=1) for end in (starts, ends)]
    return np.where(sweeps == 0.0, 0.0, np.abs(radii[1] - radii[0]))
