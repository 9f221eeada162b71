"""Watertight triangle meshes around a path."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.sweeping.spinors import Complex, carried, renamed, running, spinors, transported

if TYPE_CHECKING:
    from trimesh import Trimesh

_FEWEST_SIDES = 6
_FIRST_RINGS = 64
_TINY = 1e-150  # in place of zero under a fraction


def around(points: Array, tangents: Array, closed: bool, radius: float, sides: int, slack: float) -> Trimesh:
    """Return the tube with rings at points (3, n) with unit tangents, none larger or smaller by more than `slack`.

    With `closed` the last ring is the first. One double reflection a step, fourth order, is all that rings which lie
    within a chord tolerance can show.
    """
    import trimesh

    chords = points[:, 1:] - points[:, :-1]
    squares = np.einsum("dn,dn->n", chords, chords)
    spans = 0.5 * np.einsum("dn,dn->n", chords, tangents[:, 1:] + tangents[:, :-1])
    ratios = squares / np.maximum(spans, _TINY)
    astray = ratios >= 2.0 * spans
    if astray.any():  # no way from ring to ring: the path turns on the spot, or the step is lost in rounding
        chords[:, astray] = 0.0
        spans[astray] = ratios[astray] = np.sqrt(squares[astray]) + _TINY
    lengths = (spans + 2.0 * ratios) / 3.0  # of the arcs of circles that touch the tangents, to fourth order
    psi, sizes = spinors(tangents, 1.0)
    factors = transported(psi, carried(psi[:, :-1], chords, psi[:, 1:]))
    if closed:
        missed = factors[-1] / factors[0] * renamed(psi[:, -1], psi[:, 0])
        twist = -float(np.angle(missed)) / lengths.sum()
        factors *= np.exp(1j * twist * running(np.add, 0.0, lengths))
        # Twisted by an angle d a step, the diagonals of the walls cut in (or bulge), and the section halfway, and
        # with it the volume (the prismatoid formula), change by a part of -tan(pi / sides) d / 3.
        spans *= 1.0 + math.tan(math.pi / sides) / 3.0 * twist * lengths
    radii = radius * np.sqrt(swelling(lengths, spans, closed, (1.0 + slack / radius) ** 2))
    vertices = ring_points(points, psi, factors * (radii / sizes), _disc_weights(sides))
    rings = points.shape[1] - closed
    return trimesh.Trimesh(vertices[: rings * sides], tube_faces(rings, sides, closed), process=False)


def ring_points(points: Array, psi: Complex, scales: Complex, weights: Array) -> Array:
    """Return the points (n * k, 3) of a profile set into n frames, ring after ring, each in the order of the profile.

    The frames stand at `points` (3, n), with normal + i binormal, scaled, given by spinors (2, n) and the factors
    `scales` (n,) on their squares. `weights` (9, 3 k) are `profile_weights` of the profile.
    """
    n = len(scales)
    frames = np.empty((n, 9))
    frames[:, :3] = points.T
    products = frames[:, 3:].view(np.complex128).T
    scaled = scales * psi
    np.multiply(scaled, psi, out=products[:2])
    np.multiply(scaled[0], psi[1], out=products[2])
    out = np.empty((n, weights.shape[1]))
    # Matrix products, each small enough for the cache and to stay in one thread: threads that wait for each other
    # made this ten times slower on a busy machine.
    rows = max(1, (1 << 17) // weights.size)
    for start in range(0, n, rows):
        np.matmul(frames[start : start + rows], weights, out=out[start : start + rows])
    return out.reshape(-1, 3)


def profile_weights(profile: Array) -> Array:
    """Return the weights (9, 3 k) of a frame in the k points of a profile (k, 2), x along the normal, y the binormal.

    The frame is its origin, then a^2, c^2 and a c of its spinor (a, c), the real before the imaginary part: see
    `frames` for normal and binormal.

    >>> profile_weights(np.array([[2.0, 5.0]]))[:5]
    array([[ 1.,  0.,  0.],
           [ 0.,  1.,  0.],
           [ 0.,  0.,  1.],
           [ 2.,  5.,  0.],
           [ 5., -2.,  0.]])
    """
    x, y = profile.T
    zero = np.zeros_like(x)
    origin = [np.broadcast_to(axis, (len(profile), 3)).T for axis in np.eye(3)]
    spinor = [
        [x, y, zero],
        [y, -x, zero],
        [-x, y, zero],
        [-y, -x, zero],
        [zero, zero, -2.0 * x],
        [zero, zero, -2.0 * y],
    ]
    return np.array([*origin, *spinor]).transpose(0, 2, 1).reshape(9, -1)


def disc(sides: int) -> Array:
    """Return the corners (sides, 2) of the regular polygon with the area of the unit circle, counterclockwise.

    >>> x, y = disc(5).T
    >>> round(float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))), 12) == round(np.pi, 12)
    True
    """
    angles = 2.0 * np.pi / sides * np.arange(sides)
    return _circumradius(sides) * np.column_stack([np.cos(angles), np.sin(angles)])


@lru_cache(maxsize=64)
def _disc_weights(sides: int) -> Array:
    return profile_weights(disc(sides))


def tube_faces(rings: int, sides: int, closed: bool) -> Ints:
    """Return the triangles (f, 3), outward, between rings of `sides` points each, then those of the two flat caps.

    With `closed` the last ring is joined to the first and there are no caps.

    >>> tube_faces(2, 3, closed=False).tolist()
    [[0, 1, 4], [1, 2, 5], [2, 0, 3], [0, 4, 3], [1, 5, 4], [2, 3, 5], [0, 2, 1], [3, 4, 5]]
    """
    first, caps = _first_faces(sides)
    count = rings if closed else rings - 1
    walls = 2 * sides * count
    faces = np.empty((walls if closed else walls + len(caps), 3), dtype=np.int64)  # as trimesh keeps them
    done = min(walls, len(first))
    faces[:done] = first[:done]
    while done < walls:  # as many again, farther on: numpy is quickest at few long rows
        more = min(done, walls - done)
        np.add(faces[:more], done // 2, out=faces[done : done + more])
        done += more
    if closed:
        faces[walls - 2 * sides :] %= rings * sides
    else:
        faces[walls:] = caps
        faces[walls + sides - 2 :] += count * sides
    return faces


@lru_cache(maxsize=64)
def _first_faces(sides: int) -> tuple[Ints, Ints]:
    """Return the triangles between the first rings, and those of both caps on one: fans from the first point."""
    here = np.arange(sides)
    following = np.roll(here, -1)
    lower = np.column_stack([here, following, following + sides])
    upper = np.column_stack([here, following + sides, here + sides])
    step = np.concatenate([lower, upper])
    cap = np.column_stack([np.zeros(sides - 2, dtype=np.intp), here[1:-1], here[2:]])
    walls = np.concatenate([step + ring * sides for ring in range(_FIRST_RINGS)])
    caps = np.concatenate([cap[:, [0, 2, 1]], cap])
    walls.setflags(write=False)
    caps.setflags(write=False)
    return walls, caps


def swelling(lengths: Array, spans: Array, closed: bool, most: float) -> Array:
    """Return the factor (n,) on each ring's area that makes up for the volume lost to the chords, at most `most`.

    Between two rings perpendicular to the tangents t, t' lies the area times v . (t + t') / 2, v the chord. Weighting
    each ring's area by the path it stands for over the sum of these, on both its sides, gives area times length.
    """
    steps = np.zeros((2, len(lengths) + 2))  # one more at either end: the next one round, or nothing
    steps[0, 1:-1], steps[1, 1:-1] = lengths, spans
    if closed:
        steps[:, 0], steps[:, -1] = steps[:, -2], steps[:, 1]
    wanted, spanned = steps[:, :-1] + steps[:, 1:]
    return np.asarray(np.maximum(np.minimum(wanted / spanned, most), 1.0 / most))


def _circumradius(sides: int) -> float:
    """Return the circumradius of the regular polygon with the area of the unit circle."""
    angle = 2.0 * math.pi / sides
    return math.sqrt(angle / math.sin(angle))


def sides_for(radius: float, tolerance: float) -> int:
    """Return how many sides keep the polygon of equal area within the tolerance of the circle, inside and outside.

    A corner is outside by about (pi / n)^2 / 3 of the radius, the middle of an edge inside by half as much.
    """
    sides = max(_FEWEST_SIDES, math.floor(math.pi * math.sqrt(radius / (3.0 * tolerance))))
    while radius * (_circumradius(sides) - 1.0) > tolerance:
        sides += 1
    return sides
