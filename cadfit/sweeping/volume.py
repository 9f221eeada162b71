"""The volume of a sweep, from its path and its section alone: what a mesh of it, or a solid, is held to."""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.sweeping.course import Course
from cadfit.sweeping.section import Section

_NODES, _WEIGHTS = (0.5 * rule for rule in np.polynomial.legendre.leggauss(8))


def volume(course: Course, section: Section, stations: Array) -> float:
    """Return the volume of a section swept along a course, its corners mitred, its ends flat.

    With A the area of the section at a place, c the arm of its centroid, k the curvature vector there, it is the
    integral of A (1 - k . c) along the path: a twist takes nothing, and a profile about its own centroid has area
    times length. A mitre puts on (or takes off) A c . m / (t . m) before it and after it, m the sum of the tangents t.
    `stations` (n,) are parameters between which everything is smooth enough for Gauss's rule of 8 points; the knots
    are added. Right only where the sweep does not pass through itself.
    """
    total = 0.0
    ends = []
    for k, leg in enumerate(course.legs):
        inner = stations[(stations > leg.domain[0]) & (stations < leg.domain[1])]
        u = np.unique(np.concatenate([leg.distinct_knots, inner]))
        steps = np.diff(u)
        at = np.concatenate([leg.domain[:1], (u[:-1, None] + steps[:, None] * (0.5 + _NODES)).ravel(), leg.domain[1:]])
        f, turned = course.at(k, at)
        areas, arms = _moments(section, at, turned)
        moments = arms[:, :1] * f.normals + arms[:, 1:] * f.binormals
        held = areas - np.einsum("nd,nd->n", leg.curvature(at), moments)
        speeds = np.linalg.norm(leg.derivative(at), axis=1)
        total += float(((held * speeds)[1:-1].reshape(len(steps), -1) @ _WEIGHTS) @ steps)
        ends.append((f.tangents[[0, -1]], moments[[0, -1]]))
    for k, joint in enumerate(course.joints):
        (_, before), (_, moment) = ends[k]
        (after, _), (carried, _) = ends[(k + 1) % len(ends)]
        if joint.mitred:
            plane = before + after
            total += float(carried @ plane / (after @ plane) - moment @ plane / (before @ plane))
    return total


def _moments(section: Section, u: Array, turned: Array) -> tuple[Array, Array]:
    """Return the areas (n,) and first moments (n, 2) of a section at parameters u (n,), turned by angles (n,)."""
    areas, arms = np.zeros(len(u)), np.zeros(len(u), dtype=complex)
    for loop, scale in zip(section.loops, section.scales, strict=True):
        x, y = loop.T
        x_next, y_next = np.roll(loop, -1, axis=0).T
        cross = x * y_next - x_next * y
        size = scale(u)[:, 0]
        areas += 0.5 * cross.sum() * size**2
        arms += complex(cross @ (x + x_next), cross @ (y + y_next)) / 6.0 * size**3
    arms *= np.exp(1j * (section.twist(u)[:, 0] + turned))
    return areas, np.column_stack([arms.real, arms.imag])


def grown(points: Array, centres: Array, faces: Ints, wanted: float, most: float) -> Array:
    """Return rings (n, k, 3) grown about their centres (n, 3) by one factor, so that the mesh has the wanted volume.

    Chords, and the diagonals of twisted walls, cut in or bulge. `faces` are those of the walls and flat ends. The
    factor differs from one by `most` at the very most: what is farther off is not what this is for, and stays.
    """

    def missing(share: float) -> float:
        a, b, c = (centres[:, None] + (1.0 + share) * arms).reshape(-1, 3)[faces].transpose(1, 2, 0)
        cross = np.stack([b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]])
        return wanted - float(np.einsum("dn,dn->", a, cross)) / 6.0

    middle = centres.mean(axis=0)
    centres, arms = centres - middle, points - centres[:, None]
    # The volume is a cubic polynomial of the share, and all but straight so near to zero: the secant is enough.
    low, high = 0.0, 1e-3 * most
    at_low, at_high = missing(low), missing(high)
    for _ in range(3):
        if at_high == at_low:
            break
        low, high, at_low = high, high - at_high * (high - low) / (at_high - at_low), at_high
        if abs(high) > most:
            return points
        at_high = missing(high)
    return np.asarray(middle + centres[:, None] + (1.0 + high) * arms)
