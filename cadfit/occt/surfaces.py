"""The walls of a swept solid as B-spline surfaces within a tolerance of the exact ones.

A place (x, y) of the profile sweeps out C + x F + y G, where C is the path and F, G are the frame's normal and
binormal, scaled, and leaning toward the mitre near a corner. That is linear in (x, y), and rational basis functions sum
to one: so once C, F and G are splines on common knots, every pole of the profile has its row of poles by the same
formula, the surface is exact round the profile, and its error along the path is that of one spline in nine dimensions,
a rail.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from cadfit.bezier import Array, Ints
from cadfit.bspline import DEGREE, BSpline
from cadfit.joining import join
from cadfit.sweeping.chain import breaks, chain
from cadfit.sweeping.cubics import SLOW
from cadfit.sweeping.frames import SMOOTH, frames

_TURN = 0.02  # radians between stations, about
_FEWEST = 256  # stations on a stretch
_HALVINGS = 30  # rounds of finding bends between stations
_INNER = 6  # stations between two knots of a rail, where its error is seen
_AIM = 0.8  # of the tolerance: the error is the largest at the stations
_MORE = (1.02, 1.05, 1.1, 1.15, 1.25, 1.4)  # knots than needed if all were spread well, round by round
_ROUNDS = 16  # of cutting intervals
_LEAN = 4.0  # over how many times the mitre's depth the walls lean


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A smooth part of a path at n close stations: one row of faces.

    `path`: the part. `u`: the stations' parameters on it, `given`: on the caller's path. `lengths`: from the stretch's
    start, `speeds`: of the path there. `points`, `tangents`, `normals`, `binormals` (n, 3). `bends` (n, 2): the
    curvature's parts along normal and binormal. `turning` (n,): how fast the frame turns about the tangent. `slopes`
    (n, 2): how far a place leans along the tangent for each unit along normal and binormal; `leaning` (n, 2): its rate.
    """

    path: BSpline
    u: Array
    given: Array
    lengths: Array
    speeds: Array
    points: Array
    tangents: Array
    normals: Array
    binormals: Array
    bends: Array
    turning: Array
    slopes: Array
    leaning: Array

    def by_length(self, law: BSpline) -> Array:
        """Return the rate (n,) of a law of the caller's parameter by the length; zero where the path stands still."""
        u = self.given.copy()
        u[-1] = np.nextafter(u[-1], -np.inf)  # the rate from this side
        moving = self.speeds > SLOW * self.speeds.max()
        return np.where(moving, law.derivative(u)[:, 0] / np.where(moving, self.speeds, 1.0), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Spine:
    """A path's stretches in order, and whether the last one's end is the first one's start."""

    stretches: tuple[Stretch, ...]
    closed: bool


def spine(path: BSpline, reach: float, twist: BSpline, up: ArrayLike | None = None, density: int = 1) -> Spine:
    """Return the stretches of a path in 3D for profiles that reach so far from it, turned by the law `twist`.

    `density` multiplies the stations. Stretches end at corners, and where curvature or speed jumps, since there a
    wall's edge is. Frames run on over them: rotation-minimizing or with `up` as `cadfit.frames`, turned by the least
    angle at a corner; what a closed path lacks in the end is spread evenly.
    """
    pieces, wrap = _pieces(path, reach)
    stretches = [_stretch(piece, wrap, up, density) for piece in pieces]
    closed = path.closed
    # One frame for all: carried over each joint by the rotation that takes tangent to tangent.
    turns, total = [0.0], sum(s.lengths[-1] for s in stretches)
    for before, after in pairwise(stretches):
        turns.append(turns[-1] + _mismatch(before, after))
    lacking = 0.0
    if closed:
        lacking = -math.remainder(turns[-1] + _mismatch(stretches[-1], stretches[0]), 2.0 * math.pi)
    rate, done, out = lacking / total, 0.0, []
    for stretch, turn in zip(stretches, turns, strict=True):
        angles, turning = twist(stretch.given)[:, 0], stretch.by_length(twist)
        out.append(_turned(stretch, turn + rate * (done + stretch.lengths) + angles, rate + turning))
        done += stretch.lengths[-1]
    joints = [*pairwise(out)] + ([(out[-1], out[0])] if closed else [])
    mitres = [_mitre(a, b) for a, b in joints]
    none = np.zeros((2, 2))
    starts = [mitres[-1] if closed else none, *mitres[: len(out) - 1]]
    ends = mitres if closed else [*mitres, none]
    return Spine(tuple(_leant(s, a[1], b[0], reach) for s, a, b in zip(out, starts, ends, strict=True)), closed)


def rail(stretch: Stretch, law: BSpline, reach: float, tolerance: float) -> BSpline | None:
    """Return path, normal and binormal, these scaled by a law of the caller's parameter, as one spline (n, 9).

    `reach`: the farthest place of the profile, unscaled. A place of it is nowhere farther
    than `tolerance` from where it should be at the same parameter, seen at several stations between any two knots.
    Knots stand among the path's own, where it is exact, or spread by need, and once or twice each: whichever gives
    the fewest poles. None where the stations are too few for the tolerance.
    """
    values, rates = framed(stretch, law)
    s, n = stretch.lengths, len(stretch.u)
    turns = float((np.linalg.norm(stretch.bends[:-1], axis=1) * np.diff(s)).sum())
    own = np.searchsorted(stretch.u, stretch.path.distinct_knots).clip(max=n - 1)
    even = np.searchsorted(s, np.linspace(0.0, s[-1], 3 + math.ceil(turns))).clip(max=n - 1)
    whole = np.array([0, n - 1])
    clocks = [(s, np.ones(n))]
    if stretch.speeds.min() > 0.05 * stretch.speeds.max():
        clocks.insert(0, (stretch.u, stretch.speeds))
    best: BSpline | None = None
    for t, speeds in clocks:
        starts = [(own, False)] * (t is stretch.u) + [(whole, False), (even, True)]
        for through, poles in ((by_rates, 2), (smoothly, 1)):  # about so many for a row
            fit = _Fit(t, values, rates * speeds[:, None], reach, _AIM * tolerance, through)
            for at, spread in starts:
                most = len(best.poles) // poles if best else n
                made = fit.spread(at, most) if spread else fit.refined(at, most)
                best = made if made and (best is None or len(made.poles) < len(best.poles)) else best
    return best


def _pieces(path: BSpline, reach: float) -> tuple[list[BSpline], tuple[float, float]]:
    """Return the path cut where a row of faces ends, and the parameter beyond which they run on, less the period."""
    low, high = path.domain
    crowded = path.distinct_knots[1:-1][path.multiplicities[1:-1] > 1]
    corners = breaks(path, chain(path))[0]
    cuts = {float(u) for u in crowded if _jumps(path, float(u), float(u), reach)} | set(
        corners[corners < high].tolist()
    )
    rest, pieces = path, []
    for u in sorted(cuts):
        before, rest = rest.split(u)
        pieces.append(before)
    pieces.append(rest)
    if path.closed and cuts and not _jumps(path, low, high, reach):
        pieces = [*pieces[1:-1], join([pieces[-1], pieces[0]])]
    return pieces, (high, high - low)


def _jumps(path: BSpline, after: float, before: float, reach: float) -> bool:
    """Return whether velocity or curvature differ right after a parameter from what they are right before another."""
    before = np.nextafter(before, -np.inf)
    leaving, arriving = path.derivative(after), path.derivative(before)
    speed = np.linalg.norm(leaving) + np.linalg.norm(arriving)
    jump = np.linalg.norm(path.curvature(after) - path.curvature(before))
    return bool(np.linalg.norm(leaving - arriving) > 0.5 * SMOOTH * speed or reach * jump > SMOOTH)


def _stretch(path: BSpline, wrap: tuple[float, float], up: ArrayLike | None, density: int) -> Stretch:
    """Return a smooth part of a path with its own frames."""
    u = _stations(path, density)
    f = frames(path, u, up)
    moves = np.concatenate([[True], np.diff(f.lengths) > 1e-13 * f.lengths[-1]])
    curvature = path.curvature(u)
    bends = np.stack([(curvature * f.normals).sum(axis=1), (curvature * f.binormals).sum(axis=1)], axis=1)
    speeds = np.linalg.norm(path.derivative(u), axis=1)
    given = np.where(u > wrap[0], u - wrap[1], u)
    turning = np.full(len(u), -f.holonomy / f.lengths[-1])  # what frames have spread along a closed path
    if up is not None:
        axis = np.asarray(up, dtype=np.float64)
        turning = (np.cross(axis, curvature) * f.binormals).sum(axis=1) / (np.cross(axis, f.tangents) * f.normals).sum(
            axis=1
        )
    none = np.zeros_like(bends)
    whole = (u, given, f.lengths, speeds, f.origins, f.tangents, f.normals, f.binormals, bends, turning, none, none)
    return Stretch(path, *(np.ascontiguousarray(values[moves]) for values in whole))


def _stations(path: BSpline, density: int) -> Array:
    """Return parameters, every knot with them, between which a path turns by little."""
    spans = np.arange(len(path.distinct_knots))
    u = np.interp(
        np.linspace(0, spans[-1], spans[-1] * max(4, math.ceil(_FEWEST / spans[-1])) + 1), spans, path.distinct_knots
    )
    for _ in range(_HALVINGS):
        velocities = path.derivative(u)
        crossed = np.linalg.norm(np.cross(velocities[1:], velocities[:-1]), axis=1)
        turns = np.arctan2(crossed, np.einsum("nd,nd->n", velocities[1:], velocities[:-1]))
        parts = np.clip(np.ceil(turns / _TURN), 1, 8)
        if parts.max() == 1.0:
            break
        u = _between(u, parts.astype(np.intp))
    return _between(u, np.full(len(u) - 1, density)) if density > 1 else u


def _between(values: Array, parts: Ints) -> Array:
    """Return values with the steps from each to the next cut into so many equal parts.

    >>> _between(np.array([0.0, 4.0, 10.0]), np.array([2, 3]))
    array([ 0.,  2.,  4.,  6.,  8., 10.])
    """
    owner = np.repeat(np.arange(len(parts)), parts)
    within = (np.arange(len(owner)) - (np.cumsum(parts) - parts)[owner]) / parts[owner]
    return np.append(values[owner] + within * np.diff(values)[owner], values[-1])


def _mismatch(before: Stretch, after: Stretch) -> float:
    """Return the angle by which the second's first frame must turn to be the first's last one, carried over."""
    t0, t1 = before.tangents[-1], after.tangents[0]
    normal = before.normals[-1]
    across = t0 + t1  # the mitre plane's normal: the profile's image in that plane is the profile after the corner
    carried = normal - 2.0 * (normal @ across) / (across @ across) * across
    return math.atan2(carried @ after.binormals[0], carried @ after.normals[0])


def _turned(stretch: Stretch, angles: Array, rate: Array) -> Stretch:
    """Return the stretch with its frames turned about the tangents by angles (n,) that grow at this rate (n,)."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    n, b, (x, y) = stretch.normals, stretch.binormals, stretch.bends.T[:, :, None]
    bends = np.hstack([c * x + s * y, c * y - s * x])
    n, b, turning = c * n + s * b, c * b - s * n, stretch.turning + rate
    return replace(stretch, normals=n, binormals=b, bends=bends, turning=turning)


def _mitre(before: Stretch, after: Stretch) -> Array:
    """Return the slopes (2, 2) of the mitre plane against the last frame of one and the first of the other."""
    t0, t1 = before.tangents[-1], after.tangents[0]
    if np.linalg.norm(t1 - t0) <= SMOOTH:
        return np.zeros((2, 2))
    plane = t0 + t1
    last = [before.normals[-1] @ plane, before.binormals[-1] @ plane]
    first = [after.normals[0] @ plane, after.binormals[0] @ plane]
    return np.asarray(-np.array([last, first]) / (t0 @ plane))


def _leant(stretch: Stretch, start: Array, end: Array, reach: float) -> Stretch:
    """Return the stretch leaning from one mitre to the other: slopes (2,) at its start and its end.

    A straight stretch, and one too short for two ramps, leans evenly from end to end; others over a cubic ramp beside
    each mitre. A straight wall is the same however it leans.
    """
    s, whole = stretch.lengths, stretch.lengths[-1]
    if not (start.any() or end.any()):
        return stretch
    depths = _LEAN * reach * np.array([np.linalg.norm(start), np.linalg.norm(end)])
    if reach * np.abs(stretch.bends).max() <= 1e-12 * reach / whole or depths.sum() > whole:
        ramp = s / whole
        slopes = (1.0 - ramp)[:, None] * start + ramp[:, None] * end
        return replace(stretch, slopes=slopes, leaning=np.broadcast_to((end - start) / whole, slopes.shape))
    slopes, leaning = np.zeros((len(s), 2)), np.zeros((len(s), 2))
    for slope, depth, away, sign in [(start, depths[0], s, -1.0), (end, depths[1], whole - s, 1.0)]:
        if depth > 0.0:
            ramp = np.maximum(1.0 - away / depth, 0.0)[:, None]
            slopes += ramp**3 * slope
            leaning += sign * 3.0 / depth * ramp**2 * slope
    return replace(stretch, slopes=slopes, leaning=leaning)


def framed(stretch: Stretch, law: BSpline) -> tuple[Array, Array]:
    """Return path, normal and binormal scaled by a law (n, 9) at the stations, and their rates by arc length (n, 9)."""
    t, n, b = stretch.tangents, stretch.normals, stretch.binormals
    (k1, k2), (m1, m2), (r1, r2) = (v.T[:, :, None] for v in (stretch.bends, stretch.slopes, stretch.leaning))
    turning, bend = stretch.turning[:, None], k1 * n + k2 * b
    growth, scale = stretch.by_length(law)[:, None], law(stretch.given)
    f, g = n + m1 * t, b + m2 * t
    df = (r1 - k1) * t + turning * b + m1 * bend
    dg = (r2 - k2) * t - turning * n + m2 * bend
    values = np.hstack([stretch.points, scale * f, scale * g])
    return values, np.hstack([t, growth * f + scale * df, growth * g + scale * dg])


def smoothly(t: Array, values: Array, rates: Array) -> BSpline:
    """Return the C2 spline through values (k, d) at parameters (k,), its ends' rates as given (the first, the last)."""
    step = (t[-1] - t[0]) / (len(t) - 1)  # steps near 1: the system has rows of derivatives beside rows of values
    ends: Any = ([(1, step * rates[0])], [(1, step * rates[-1])])  # scipy's stubs know numbers only
    poles = make_interp_spline(t / step, values - values[0], k=DEGREE, bc_type=ends).c + values[0]
    poles[[0, -1]] = values[[0, -1]]
    return BSpline(poles, np.concatenate([t[[0, 0, 0]], t, t[[-1, -1, -1]]]))


def by_rates(t: Array, values: Array, rates: Array) -> BSpline:
    """Return the C1 spline with these values and rates (k, d) at parameters (k,), whose knots stand twice inside."""
    thirds = np.diff(t)[:, None] / 3.0
    inner = np.stack([values[:-1] + thirds * rates[:-1], values[1:] - thirds * rates[1:]], axis=1)
    poles = np.concatenate([values[:1], inner.reshape(-1, values.shape[1]), values[-1:]])
    return BSpline(poles, np.concatenate([t[[0, 0]], np.repeat(t, 2), t[[-1, -1]]]))


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """Splines through some of n stations: parameters `t` (n,), `values` and their `rates` by them (n, 9)."""

    t: Array
    values: Array
    rates: Array
    reach: float
    allowed: float
    through: Callable[[Array, Array, Array], BSpline]

    def at(self, rows: Ints) -> tuple[BSpline, Array]:
        """Return the spline through these stations, and its error in each interval, in what is allowed."""
        spline = self.through(self.t[rows], self.values[rows], self.rates[rows])
        off = (spline(self.t) - self.values) ** 2
        far = np.sqrt(off[:, :3].sum(axis=1)) + self.reach * np.sqrt(off[:, 3:].sum(axis=1))
        return spline, np.maximum.reduceat(far, rows[:-1]) / self.allowed

    def refined(self, rows: Ints, most: int) -> BSpline | None:
        """Return the spline whose intervals are parts of these, cut until it is near enough.

        None when that takes `most` rows or more, or intervals with too few stations in them to see the error.
        """
        for _ in range(_ROUNDS):
            if len(rows) >= most:
                break
            spline, far = self.at(rows)
            if far.max() <= 1.0:
                return spline
            parts = np.ceil(np.clip(far**0.25, 1.0, 8.0))
            widths = np.diff(rows)
            if (widths[parts > 1.0] <= _INNER).any():
                return None
            rows = np.rint(_between(rows.astype(float), np.minimum(parts, widths).astype(np.intp))).astype(np.intp)
        return None

    def spread(self, rows: Ints, most: int) -> BSpline | None:
        """Return the spline whose knots are spread by what it needs, or None as `refined`."""
        n = len(self.t)
        for more in _MORE:
            if len(rows) >= most:
                return None
            spline, far = self.at(rows)
            if far.max() <= 1.0:
                return spline
            need = np.concatenate([[0.0], np.cumsum(np.maximum(far, 1e-4) ** 0.25)])
            along = np.interp(np.arange(n), rows, need)
            wanted = np.linspace(0.0, need[-1], math.ceil(more * need[-1]) + 1)
            if len(wanted) * _INNER > n:
                return None
            rows = np.unique(np.append(np.searchsorted(along, wanted[:-1]), n - 1))
        return self.refined(rows, most)
