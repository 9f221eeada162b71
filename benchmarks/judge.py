"""Whether a fit keeps what it promises, by brute force: many samples a chord, nothing of cadfit's own certificate.

The curve is evaluated by scipy; the centripetal cardinal curve that says how far it may stray between two points is
built by repeated interpolation (Barry and Goldman, A recursive evaluation algorithm for a class of Catmull-Rom
splines, SIGGRAPH 1988), its end pieces as `cadfit.fitting.targets.cardinal_chain` describes them.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import BSpline

PER_CHORD = 81  # samples, both ends with them
_BULGE = 1.5
_AT_ONCE = 1024  # chords
_BINOMIALS = np.array([1.0, 3.0, 3.0, 1.0])


def violations(fit, points, closed, between="curve"):
    """What the fit of points (n, d) without repeats does not keep, in words; an empty list where it keeps everything.

    `between` as `cadfit.fit` was told. Corners are those the fit names.
    """
    if not np.array_equal(fit.points, points):
        return ["other points than were given"]
    found = [*_broken(fit, points, closed), *_disordered(fit, closed)]
    rounding = 32 * np.finfo(float).eps * np.abs(points).max()  # of evaluating the curve here
    far, strays, allowed = measured(fit, points, closed, between)
    truth = far.max()
    if truth > fit.tolerance + rounding:
        found.append(f"point {np.argmax(far)} is {truth / fit.tolerance:.6g} tolerances away")
    if fit.deviation.points > fit.tolerance:
        found.append(f"reported deviation {fit.deviation.points / fit.tolerance:.6g} tolerances")
    if fit.deviation.points < truth - rounding:
        found.append(f"reported deviation {fit.deviation.points:.6g} below the truth {truth:.6g}")
    if fit.deviation.points > 1.01 * truth + rounding:
        found.append(f"reported deviation {fit.deviation.points:.6g} over 1 % above the truth {truth:.6g}")
    if fit.deviation.between < strays.max() - rounding:
        found.append(f"reported between {fit.deviation.between:.6g} below the truth {strays.max():.6g}")
    beyond = strays - allowed
    if beyond.max() > rounding:
        chord = np.argmax(beyond)
        found.append(f"chord {chord} is strayed from by {strays[chord]:.6g}, allowed {allowed[chord]:.6g}")
    return found


def measured(fit, points, closed, between="curve"):
    """How far points (n,) are from their places, the curve strays from each chord (chords,), and may stray there."""
    poles, knots = joined(fit.curves)
    origin = points.mean(axis=0)  # at large offsets rounding would drown the distances
    curve, u, centred = BSpline(knots, poles - origin, 3), fit.parameters, points - origin
    far = np.linalg.norm(curve(u) - centred, axis=1)
    around = np.vstack([centred, centred[:1]]) if closed else centred
    ends = np.append(u, u[0]) if closed else u
    low, high = knots[0], knots[-1]
    strays, allowed = np.zeros(len(ends) - 1), np.full(len(ends) - 1, float(fit.tolerance))
    for first in range(0, len(strays), _AT_ONCE):
        rows = slice(first, first + _AT_ONCE)
        a, b = ends[:-1][rows, None], ends[1:][rows, None]
        at = a + np.linspace(0.0, 1.0, PER_CHORD) * (np.where(b < a, b + high - low, b) - a)
        places = curve(np.where(at > high, at - (high - low), at) if closed else np.minimum(at, high))
        strays[rows] = to_segment(places, around[:-1][rows], around[1:][rows]).max(axis=1)
    if between == "curve":
        merged = not np.any(np.diff(centred, axis=0), axis=1).all()  # by rounding, about the middle
        shape = points if merged else centred
        for rows in stretches(len(points), fit.corners, closed):
            whole = closed and not len(fit.corners)
            allowed[rows if whole else rows[:-1]] += _BULGE * bulges(shape[rows], whole)
    return far, strays, allowed


def joined(curves):
    """The poles and knots of one B-spline, a triple knot at each joint."""
    poles = [curve.poles[:-1] for curve in curves[:-1]] + [curves[-1].poles]
    knots = [curve.knots[4 * (k > 0) : -1] for k, curve in enumerate(curves)] + [curves[-1].knots[-1:]]
    return np.concatenate(poles), np.concatenate(knots)


def stretches(n, corners, closed):
    """The rows between corners, both ends with them; of a closed curve without corners all rows, once."""
    if closed and not len(corners):
        return [np.arange(n)]
    edges = [*corners, corners[0] + n] if closed else [0, *corners, n - 1]
    return [np.arange(a, b + 1) % n for a, b in zip(edges[:-1], edges[1:], strict=True)]


def bulges(points, closed, count=201):
    """How far the centripetal cardinal curve through points (n, d) strays from each chord, by so many samples of it."""
    n = len(points)
    if closed:
        rows = np.arange(n)
        return _inner_bulges(*(points[(rows + k) % n] for k in (-1, 0, 1, 2)), count)
    if n == 2:
        return np.zeros(1)
    inner = _inner_bulges(points[:-3], points[1:-2], points[2:-1], points[3:], count)
    return np.concatenate([[_end_bulge(*points[2::-1], count)], inner, [_end_bulge(*points[-3:], count)]])


def _inner_bulges(a, b, c, d, count):
    """For chords b c (chords, dimensions) with the neighbours a and d."""
    found = np.zeros(len(b))
    for first in range(0, len(found), _AT_ONCE):
        rows = slice(first, first + _AT_ONCE)
        around = [p[rows, None] for p in (a, b, c, d)]
        step = [np.sqrt(np.linalg.norm(q - p, axis=2, keepdims=True)) for p, q in zip(around, around[1:], strict=False)]
        knot = np.cumsum([0.0 * step[0], *step], axis=0)
        t = knot[1] + np.linspace(0.0, 1.0, count)[:, None] * step[1]
        level = around
        for width in (1, 2):
            level = [
                ((knot[k + width] - t) * p + (t - knot[k]) * q) / (knot[k + width] - knot[k])
                for k, (p, q) in enumerate(zip(level[:-1], level[1:], strict=True))
            ]
        places = ((knot[2] - t) * level[0] + (t - knot[1]) * level[1]) / step[1]
        found[rows] = to_segment(places, b[rows], c[rows]).max(axis=1)
    return found


def _end_bulge(p, q, r, count):
    """For the last chord q r, p before it: a cubic from the parabola's direction in q to the chord's in r."""
    h, g = np.sqrt(np.linalg.norm(q - p)), np.sqrt(np.linalg.norm(r - q))
    tangent = ((q - p) / h * g + (r - q) / g * h) / (h + g)
    t, powers = np.linspace(0.0, 1.0, count)[:, None], np.arange(4)
    weights = _BINOMIALS * (1.0 - t) ** (3 - powers) * t**powers
    return to_segment((weights @ np.array([q, q + tangent * g / 3, r - (r - q) / 3, r]))[None], q[None], r[None]).max()


def to_segment(places, starts, ends):
    """Distances (chords, k) of places (chords, k, d) from the segments between starts and ends (chords, d)."""
    along = (ends - starts)[:, None]
    gap = places - starts[:, None]
    square = np.sum(along * along, axis=2)
    place = np.sum(gap * along, axis=2) / np.where(square > 0.0, square, 1.0)
    return np.linalg.norm(gap - np.clip(place, 0.0, 1.0)[..., None] * along, axis=2)


def _broken(fit, points, closed):
    """Where the curves are not joined to the last bit, smooth inside, and exactly at ends and corners."""
    curves = fit.curves
    if any(np.any(np.diff(curve.knots)[3:-3] <= 0) for curve in curves):
        yield "an inner knot is repeated"
    pairs = list(zip(curves[:-1], curves[1:], strict=True))
    if any(not np.array_equal(a.poles[-1], b.poles[0]) or a.knots[-1] != b.knots[0] for a, b in pairs):
        yield "two curves are not joined to the last bit"
    ends = curves[0].poles[0], curves[-1].poles[-1]
    if closed and not np.array_equal(*ends):
        yield "the closed curve does not end where it starts"
    if not closed and not np.array_equal(ends, points[[0, -1]]):
        yield "an open end is not the point"
    joints = {tuple(curve.poles[0]) for curve in curves}
    if any(tuple(points[row]) not in joints for row in fit.corners):
        yield "a corner is not at a joint"
    if closed and not len(fit.corners) and len(curves) == 1 and _seam_jump(curves[0]) > 1e-9:
        yield f"the seam is not C2: {_seam_jump(curves[0]):.3g}"


def _seam_jump(curve):
    """The larger jump of the first two derivatives at the seam, each in parts of its largest value at the knots."""
    a, b = curve.knots[0], curve.knots[-1]
    spline, jumps = BSpline(curve.knots, curve.poles - curve.poles[0], 3), []
    for order in (1, 2):
        at = spline.derivative(order)(np.concatenate([np.unique(curve.knots)[:-1], [a, np.nextafter(b, a)]]))
        jumps.append(np.linalg.norm(at[-1] - at[-2]) / max(np.linalg.norm(at, axis=1).max(), 1e-300))
    return max(jumps)


def _disordered(fit, closed):
    """Whether parameters fall (closed: but for one step), and open ends are not the ends of the domain."""
    u, low, high = fit.parameters, fit.curves[0].knots[0], fit.curves[-1].knots[-1]
    if u.min() < low or u.max() > high:
        yield "a parameter is outside of the domain"
    if np.sum(np.diff(u, append=u[:1] if closed else u[-1:]) < 0) > int(closed):
        yield "the parameters are not in order"
    if not closed and (u[0], u[-1]) != (low, high):
        yield "an open end's parameter is not the domain's"
