"""What a sweep's rings say of bends, corners and parts that come near each other: the crossings to report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cadfit.bezier import Array
from cadfit.bspline import BSpline
from cadfit.sweeping.chain import Chain, tightest
from cadfit.sweeping.selfintersection import Crossing
from cadfit.sweeping.touching import APART, askew, tight_steps, touching

if TYPE_CHECKING:
    from cadfit.sweeping.rings import Rings, Short
    from cadfit.sweeping.section import Section

_WINDOW = 200  # samples to either side when the nearest places of two parts are looked for
_BESIDE = 4  # rings to either side of each, between which these are


def tight_places(
    path: BSpline, whole: Chain, cusps: Array, rings: Rings, section: Section, short: list[Short]
) -> list[Crossing]:
    """Return where a sweep has no room in the path's bends and corners: each kind, the worst place of each first.

    `cusps` (k,) are the parameters where the path turns back, `short` the legs without room for their mitres.
    """
    reach = section.reach
    _, arms = _outline(rings, section)
    found = [Crossing("cusp", float(u), path(u), reach, 0.0) for u in cusps]
    found += _bends(path, whole, rings.parameters, arms, reach, section.outside > 1.0)
    found += [
        Crossing("corner", leg.start, leg.place, reach, leg.factor * reach, leg.end)
        for leg in sorted(short, key=lambda leg: leg.factor)
    ]
    return found


def _outline(rings: Rings, section: Section) -> tuple[Array, Array]:
    """Return the points (n, k, 3) of the outline, and as they are seen from the rings' centres, on the exact curve."""
    outline = rings.points[:, : len(section.loops[0])]
    return outline, (outline - rings.centres[:, None]) / section.outside


def touching_parts(
    path: BSpline, rings: Rings, lids: Sequence[Array], section: Section, varies: bool
) -> list[Crossing]:
    """Return the crossing, if any, of parts of a sweep that touch.

    `lids` are the triangles (t, 3, 3) of the caps at the start and the end. `varies`: the outline grows or turns along
    the path, so that parts beside each other are looked at, too.
    """
    walls, arms = _outline(rings, section)
    centres, tangents = rings.centres, rings.tangents
    if path.closed:
        walls, centres, tangents = (np.concatenate([rows, rows[:1]]) for rows in (walls, centres, tangents))
    if varies:
        both = _touching_beside(walls, lids, centres, tangents, path.closed)
    else:
        both = touching(walls, lids, centres.T, tangents.T, path.closed)
    if both is None:
        return []
    i, j = both
    size = max(float(np.linalg.norm(arms[k % len(arms)], axis=1).max()) for k in both)
    turns = np.linalg.norm(np.diff(tangents, axis=0), axis=1)
    turned = float(turns[i:j].sum())
    if min(turned, float(turns.sum()) - turned if path.closed else turned) >= APART and j - i > 2 * _BESIDE:
        return [nearest_parts(path, centres, size, i, j)]
    u, other = (float(rings.parameters[k % len(arms)]) for k in both)
    return [Crossing("near", u, path(u), size, min(_parted(centres, tangents, i, j), size), other)]


def _touching_beside(
    walls: Array, lids: Sequence[Array], centres: Array, tangents: Array, closed: bool
) -> tuple[int, int] | None:
    """Return the rings at which parts touch, also those on both sides of a bend or a mitre without a right angle.

    Walls that share a ring are not compared: those at mitres are halved, so that the two of a mitre are.
    """
    mitres = askew(walls, centres, tangents)
    cut = np.flatnonzero(mitres[1:] | mitres[:-1])
    walls, centres = (np.insert(rows, cut + 1, 0.5 * (rows[cut] + rows[cut + 1]), axis=0) for rows in (walls, centres))
    numbers = np.insert(np.arange(len(tangents)), cut + 1, cut)
    tangents = tangents[numbers]
    both = touching(walls, lids, centres.T, tangents.T, closed, tight_steps(walls, centres, tangents))
    return (int(numbers[both[0]]), int(numbers[both[1]])) if both else None


def _parted(centres: Array, tangents: Array, i: int, j: int) -> float:
    """Return how far the rings of walls i and j may reach before they meet, where their planes do."""
    last = len(centres) - 1
    a, b = np.array([(p, q) for p in (i, min(i + 1, last)) for q in (j, min(j + 1, last)) if p != q]).T
    sines = np.linalg.norm(np.cross(tangents[a], tangents[b]), axis=1)
    heights = np.stack([np.einsum("nd,nd->n", centres[b] - centres[a], tangents[k]) for k in (a, b)])
    return float((np.abs(heights).max(axis=0) / np.maximum(sines, 1e-300)).min())


def _bends(path: BSpline, whole: Chain, u: Array, arms: Array, reach: float, circle: bool) -> list[Crossing]:
    """Return the worst bend in which a point of the outline moves backward, if there is one.

    `u` (n,) are the parameters of the rings, `arms` (n, k, 3) the outline's points seen from their centres. With the
    curvature vector k of the path (toward the centre, 1 / radius) and the arm d of a point, the point moves
    backward where k . d is above 1. A path bounded to bend less than 1 / reach is not looked at more closely. `circle`:
    the outline is one about the path, for which every tightest bend counts.
    """
    at, tight = tightest(whole, reach)
    at = min(at, path.domain[1])  # a bend at the very end may be rounded beyond it
    if tight > reach:
        return []
    if tight == 0.0:
        return [Crossing("cusp", at, path(at), reach, 0.0)]
    worst, where, size = 0.0, at, reach
    # At every ring, and on the way to the next, with the arms of both ends.
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        here = u[:-1] + share * np.diff(u)
        here = np.where(np.diff(u) > 0.0, here, u[:-1])
        bend = path.curvature(here)
        for mine in (arms[:-1], arms[1:]):
            pull = np.einsum("nd,nkd->nk", bend, mine).max(axis=1)
            k = int(pull.argmax())
            if pull[k] > worst:
                worst, where = float(pull[k]), float(here[k])
                size = float(np.linalg.norm(mine[k], axis=1).max())
    round_one = circle and np.ptp(np.linalg.norm(arms, axis=2)) <= 0.02 * reach  # of one radius
    if round_one and worst < reach / tight:  # the tightest bend itself lies between those looked at
        worst, where, size = reach / tight, at, reach
    return [Crossing("bend", where, path(where), size, size / worst)] if worst >= 1.0 else []


def nearest_parts(path: BSpline, centres: Array, reach: float, i: int, j: int) -> Crossing:
    """Return the crossing of the walls after two rings, with the distance of the path's parts there.

    `centres` (n, 3) are those of all rings, `reach` is how far the profile reaches at these.
    """
    around = []
    for k in (i, j):
        near = centres[max(k + 1 - _BESIDE, 0) : k + 1 + _BESIDE]
        u, _ = path.nearest(near)
        around.append(np.linspace(u.min(), u.max(), 2 * _WINDOW + 1))
    places = [path(u) for u in around]
    apart = np.linalg.norm(places[0][:, None] - places[1], axis=2)
    a, b = np.unravel_index(apart.argmin(), apart.shape)
    largest = min(0.5 * float(apart[a, b]), reach)
    return Crossing("near", float(around[0][a]), places[0][a], reach, largest, float(around[1][b]))
