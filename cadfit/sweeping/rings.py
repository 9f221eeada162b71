"""The rings of a sweep: a profile's corners, scaled and turned, in the frames of a path's stations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cadfit.bezier import Array, Ints, distance_to_segment
from cadfit.bspline import BSpline
from cadfit.sweeping.chain import chain
from cadfit.sweeping.corners import clear_of, mitre, overtaken, pivoted
from cadfit.sweeping.course import Course
from cadfit.sweeping.frames import Frames
from cadfit.sweeping.laws import is_constant
from cadfit.sweeping.mesh import swelling
from cadfit.sweeping.section import Section
from cadfit.sweeping.stations import most_rings, station_parameters
from cadfit.sweeping.touching import askew
from cadfit.sweeping.triangles import loops_around, wall_meets_itself

_ROUNDS = 12  # of looking at the chords and cutting those that stray
_FEW = 24  # fibres that are looked at
_HALVINGS = 16


@dataclass(frozen=True, slots=True, eq=False)
class Rings:
    """The rings of a sweep in order: `points` (n, k, 3), and for each its place on the path.

    `parameters`, `lengths` (n,), `centres`, `tangents`, `normals` (n, 3). On a closed path the first ring is not
    repeated at the end.
    """

    points: Array
    parameters: Array
    lengths: Array
    centres: Array
    tangents: Array
    normals: Array

    def __len__(self) -> int:
        return len(self.parameters)

    def rows(self, low: int, high: int) -> Rings:
        """Return the rings from row `low` to before row `high`."""
        return Rings(*(getattr(self, name)[low:high] for name in self.__slots__))

    def with_points(self, row: int, points: Array) -> Rings:
        """Return the rings with other points (k, 3) in one row."""
        changed = self.points.copy()
        changed[row] = points
        return Rings(changed, *(getattr(self, name) for name in self.__slots__[1:]))

    @staticmethod
    def joined(parts: list[Rings]) -> Rings:
        """Return the rings of parts one after the other."""
        return Rings(*(np.concatenate([getattr(part, name) for part in parts]) for name in Rings.__slots__))


def placed(course: Course, section: Section, tolerance: float) -> tuple[Rings, list[Short]]:
    """Return the rings of a section along a course, and the legs too short for their mitres.

    Between two rings every fibre strays from its chord by at most `tolerance`.
    """
    parts = []
    for k, leg in enumerate(course.legs):
        u = _stations(leg, section, tolerance)
        if not (course.steady and section.constant):
            u = _refined(u, _ring_maker(course, k, section), tolerance, _most(section))
        f, turned = course.at(k, u)
        points = _ring_points(u, f, section, turned)
        larger = _swell(f, course.closed and not course.joints, section.reach, tolerance)
        points += (larger[:, None, None] - 1.0) * (points - f.origins[:, None])
        parts.append(Rings(points, u, f.lengths + course.started[k], f.origins, f.tangents, f.normals))
    return _met(parts, course, loops_around([len(loop) for loop in section.loops]), tolerance)


def _stations(leg: BSpline, section: Section, tolerance: float) -> Array:
    """Return the stations that the path's bends ask for, and the knots of what varies."""
    u = station_parameters(chain(leg), section.reach, tolerance, _most(section))
    laws = [law for law in (*section.scales, section.twist) if not is_constant(law)]
    if not laws:
        return u
    inner = np.concatenate([law.distinct_knots for law in laws])
    low, high = leg.domain
    near = 1e-9 * (high - low)
    inner = inner[(inner > low + near) & (inner < high - near)]
    u = np.sort(np.concatenate([u, inner]))
    return np.asarray(u[np.concatenate([[True], np.diff(u) > near])])


def _most(section: Section) -> int:
    return most_rings(sum(map(len, section.loops)))


def _ring_maker(course: Course, leg: int, section: Section) -> Callable[[Array], Array]:
    """Return the function from parameters (n,) to the points (n, k, 3) of some fibres of a leg."""
    far = [np.linalg.norm(loop, axis=1) for loop in section.loops]
    some = [np.unique(np.append(np.linspace(0, len(r) - 1, min(_FEW, len(r))).astype(int), r.argmax())) for r in far]
    fewer = replace(section, loops=[loop[rows] for loop, rows in zip(section.loops, some, strict=True)])

    def rings(u: Array) -> Array:
        f, turned = course.at(leg, u)
        return _ring_points(u, f, fewer, turned)

    return rings


def _ring_points(u: Array, f: Frames, section: Section, turned: Array) -> Array:
    axes = np.stack([f.normals, f.binormals], axis=1)
    return np.asarray(f.origins[:, None] + section.at(u, turned) @ axes)


def _refined(u: Array, rings: Callable[[Array], Array], tolerance: float, most: int) -> Array:
    """Return more stations where fibres stray from their chords by more than the tolerance, seen at the quarters."""
    quarters = np.array([0.25, 0.5, 0.75])
    todo = np.ones(len(u) - 1, dtype=bool)
    for _ in range(_ROUNDS):
        steps = np.diff(u)
        at = np.flatnonzero(todo)
        ends, inner = rings(u), rings((u[at, None] + quarters * steps[at, None]).ravel())
        inner = inner.reshape(len(at), 3, *ends.shape[1:])
        away = distance_to_segment(inner, ends[at, None], ends[at + 1, None]).max(axis=(1, 2))
        counts = np.ones(len(steps), dtype=int)
        counts[at] = np.clip(np.ceil(np.sqrt(away / tolerance) - 1e-6), 1, 64)
        if (counts == 1).all():
            break
        if counts.sum() > most:
            place = f"the parameter {u[np.argmin(steps / counts)]:g}"
            raise ValueError(
                f"the mesh would need more than {most:,} rings, which crowd at {place}: is the tolerance too small?"
            )
        owner = np.repeat(np.arange(len(steps)), counts)
        within = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
        todo = counts[owner] > 1
        u = np.append(u[owner] + within / counts[owner] * steps[owner], u[-1])
    return u


def _swell(f: Frames, closed: bool, reach: float, tolerance: float) -> Array:
    """Return the factor (n,) on each ring that makes up for the volume that chords along the path lose."""
    chords, lengths = np.diff(f.origins, axis=0), np.diff(f.lengths)
    spans = 0.5 * np.einsum("nd,nd->n", chords, f.tangents[1:] + f.tangents[:-1])
    usable = (spans > 0.5 * lengths) & (lengths > 0.0)
    spans = np.where(usable, spans, 1.0)
    return np.sqrt(swelling(np.where(usable, lengths, 1.0), spans, closed, (1.0 + tolerance / reach) ** 2))


def _met(parts: list[Rings], course: Course, following: Ints, tolerance: float) -> tuple[Rings, list[Short]]:
    """Return the rings of the legs as one, made to meet at the corners, and the legs too short for that.

    `following` (k,) is that of `loops_around`.
    """
    count = len(parts)
    mitres: list[list[Array | None]] = [[None, None] for _ in parts]
    turns: dict[int, Rings] = {}
    for k, joint in enumerate(course.joints):
        a, b = parts[k], parts[(k + 1) % count]
        before, after = a.tangents[-1], b.tangents[0]
        if joint.mitred:
            ring = mitre(a.points[-1], a.centres[-1], before, after)
            mitres[k][1] = mitres[(k + 1) % count][0] = ring
        else:
            points, ways = pivoted(a.points[-1], a.normals[-1], a.centres[-1], before, after, tolerance)
            here = a.rows(len(a) - 1, len(a))
            still = [np.repeat(getattr(here, name), len(ways), axis=0) for name in ("parameters", "lengths", "centres")]
            turns[k] = Rings(points, still[0], still[1], still[2], ways, np.repeat(here.normals, len(ways), axis=0))
    out, short = [], []
    for k, part in enumerate(parts):
        first, last = mitres[k]
        fitted, lacking = _fitted(part, first, last, following)
        if lacking is not None:
            short.append(lacking)
        shared = last is not None or (course.closed and k == count - 1 and not course.seam_is_corner)
        out.append(fitted.rows(0, len(fitted) - shared))
        if k in turns:
            out.append(turns[k])
    return Rings.joined(out), short


@dataclass(frozen=True, slots=True, eq=False)
class Short:
    """A leg too short for the mitres at its ends, the parameters of these, and the factor on the profile that does."""

    start: float
    end: float
    place: Array
    factor: float


def _fitted(part: Rings, first: Array | None, last: Array | None, following: Ints) -> tuple[Rings, Short | None]:
    """Return a leg between mitred ends (k, 3), without the rings these overtake, and what it lacks in length."""
    if first is None and last is None:
        return part, None
    low, high, fits = _kept(part, first, last, following)
    start = part.points[0] if first is None else first
    end = part.points[-1] if last is None else last
    ends = [part.rows(0, 1).with_points(0, start), part.rows(len(part) - 1, len(part)).with_points(0, end)]
    fitted = Rings.joined([ends[0], *([part.rows(low, high)] if low < high else []), ends[1]])
    if fits:
        return fitted, None
    factor = _largest_factor(part, first, last, following)
    return fitted, Short(float(part.parameters[0]), float(part.parameters[-1]), part.centres[0], factor)


def _kept(part: Rings, first: Array | None, last: Array | None, following: Ints) -> tuple[int, int, bool]:
    """Return the first of the rings between mitred ends that these leave, the one after them, and whether it fits."""
    backward = part.points[::-1], -part.tangents[::-1]
    low = 0 if first is None else overtaken(part.points, first, part.tangents, following)
    high = len(part) if last is None else len(part) - overtaken(backward[0], last, backward[1], following)
    low, high = max(low, 1), min(high, len(part) - 1)
    if low > high:
        return low, high, False
    start = part.points[0] if first is None else first
    end = part.points[-1] if last is None else last
    walls = [(start, part.points[low])] * (first is not None) + [(part.points[high - 1], end)] * (last is not None)
    if low == high:  # no ring between: the ends must be clear of each other
        walls, there, back = [(start, end)], part.tangents[-1:], -part.tangents[:1]
        if not (clear_of(start, end[None], there, following) & clear_of(end, start[None], back, following)).all():
            return low, high, False
    return low, high, not any(wall_meets_itself(here, there, following) for here, there in walls)


def mitres_have_room(rings: Rings, following: Ints, closed: bool) -> bool:
    """Return whether the walls beside all mitres advance and do not pass through themselves."""
    mitred = askew(rings.points, rings.centres, rings.tangents)
    after = np.roll(mitred, -1) if closed else np.append(mitred[1:], False)
    for k in np.flatnonzero(mitred | after if closed else (mitred | after)[:-1]).tolist():
        j = (k + 1) % len(rings)
        way = rings.tangents[[j if mitred[k] and not mitred[j] else k]]  # a mitre has that of the leg after it
        here, there = rings.points[k], rings.points[j]
        free = clear_of(here, there[None], way, following) & clear_of(there, here[None], -way, following)
        if not free.all() or wall_meets_itself(here, there, following):
            return False
    return True


def _largest_factor(part: Rings, first: Array | None, last: Array | None, following: Ints) -> float:
    """Return the largest factor on the profile, found by halving, with which a leg has room for its mitres."""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (low + high)
        points = part.centres[:, None] + share * (part.points - part.centres[:, None])
        start, end = (
            None if ring is None else part.centres[k] + share * (ring - part.centres[k])
            for k, ring in ((0, first), (-1, last))
        )
        *_, fits = _kept(replace(part, points=points), start, end, following)
        low, high = (share, high) if fits else (low, share)
    return low
