"""One smooth stretch of a curve to lines and arcs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np

from cadfit.arcing.chain import Layer, layers, more, trace
from cadfit.arcing.nodes import Samples, along_pieces
from cadfit.arcing.reach import Edges, Limits, Links, feasible, thinned
from cadfit.arcing.within import bounds
from cadfit.bezier import Array, Ints, restrict

Found = TypeVar("Found")

_MORE = 3  # numbers of arcs to try, to close a chain
_DENSER = (1.0, 2.0, 4.0)
_SEAMS = (0.0, 0.38, 0.76)  # of a closed stretch's pieces: where it is tried to begin
_TRIES = 50
_TRIES_AROUND = 12  # what they do not close from one seam, they may from another
_TURNED = 0.5  # tolerances: the last direction's error times the longest chord that is spread over a chain
_ENDS = 5  # directions at the end of a closed stretch to trace back from


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Lines and arcs through `joints` (k + 1, 2), the curve's places `at` (k + 1,); centres and sweeps as in `Arcs`."""

    joints: Array
    at: Array
    centres: Array
    sweeps: Array

    def bounds(self, pieces: Array, least: float | None) -> Array:
        """Return bounds (k,) on the distance of each from its part of the curve, both ways."""
        parts, owner = cut(pieces, self.at)
        return bounds(parts, owner, self.joints[:-1], self.joints[1:], self.centres, self.sweeps, least)


def fewest(pieces: Array, tolerance: float, max_radius: float, closed: bool) -> tuple[Chain, Array]:
    """Return as few lines and arcs within the tolerance of Bézier pieces (m, 4, 2) as are found, and the pieces.

    `closed`: the pieces end where they start, and the tangent is to be continuous there, too. Where the chain cannot be
    closed so at the place where they start, the seam being a joint of every chain, they are returned from another
    piece on. Raises LookupError with a place of the curve where no arcs within the tolerance go on, and the places
    where it turns within the tolerance.
    """
    limits = Limits(tolerance, max_radius)

    def made(edges: Edges, found: list[Layer]) -> tuple[Ints, Chain]:
        return _around(edges, found, limits) if closed else along(edges, found, max_radius)

    seams, tries = (_SEAMS, _TRIES_AROUND) if closed else (_SEAMS[:1], _TRIES)
    for density, part in product(_DENSER, seams):
        seam = round(part * len(pieces))
        try:
            return _fewest(np.roll(pieces, -seam, axis=0), limits, density, made, tries)
        except LookupError as error:
            at, hairpins = (error.args[0] + seam) % len(pieces), np.sort((error.args[1] + seam) % len(pieces))
            if len(hairpins):
                break
    raise LookupError(at, hairpins)


def _fewest(
    pieces: Array, limits: Limits, density: float, made: Callable[[Edges, list[Layer]], tuple[Ints, Chain]], tries: int
) -> tuple[Chain, Array]:
    """Return what `fewest` does, from the pieces' own start, or raise what it raises."""

    def judged(chain: Chain) -> tuple[Chain, Array]:
        return chain, chain.bounds(pieces, 0.9 * limits.tolerance)

    nodes = along_pieces(pieces, limits.tolerance, density)
    links = feasible(nodes, limits)
    while (fewer := thinned(nodes, links)) is not None:
        nodes, links = fewer, feasible(fewer, limits)
    try:
        return certified(Edges.of(nodes, links), limits.tolerance, made, judged, tries), pieces
    except LookupError as error:
        where = float(nodes.at[error.args[0]])
        raise LookupError(where, _hairpins(nodes.samples, limits.tolerance)) from None


def _hairpins(samples: Samples, tolerance: float) -> Array:
    """Return the places (k,) inside where the curve turns by a right angle or more within the tolerance."""
    step = np.linalg.norm(np.diff(samples.points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(step)])
    before = np.searchsorted(along, along - 0.5 * tolerance)
    after = np.minimum(np.searchsorted(along, along + 0.5 * tolerance), len(along) - 1)
    turn = np.abs(samples.angles[after] - samples.angles[before])
    places: list[float] = []
    sharp = np.flatnonzero(turn >= 0.5 * np.pi)
    for run in np.split(sharp, np.flatnonzero(np.diff(sharp) > 1) + 1):
        middle = run[np.argmax(turn[run])] if len(run) else 0
        if 0 < middle < len(along) - 1:
            places.append(float(samples.places[middle]))
    return np.array(places)


def apart(pieces: Array, at: Array) -> list[Array]:
    """Return the parts (each (k, 4, 2)) of Bézier pieces between places `at` (k,) inside, rising, and both ends."""
    at = np.concatenate([[0.0], at, [float(len(pieces))]])
    parts = [cut(pieces, np.array(ends))[0] for ends in zip(at[:-1], at[1:], strict=True)]
    for before, after in zip(parts[:-1], parts[1:], strict=True):
        before[-1, 3] = after[0, 0]
    return parts


def joined(chains: list[Chain], pieces: list[int], closed: bool) -> tuple[Chain, Ints]:
    """Return chains that follow each other, over so many `pieces` each, as one, and the row at which each begins.

    A joint of two chains is the start of the second, to the last bit; so is the end, where they are closed.
    """
    before = np.cumsum([0, *pieces])
    joints = np.concatenate([*(chain.joints[:-1] for chain in chains), chains[-1].joints[-1:]])
    joints[-1] = joints[0] if closed else joints[-1]
    at = np.concatenate([*(chain.at[:-1] + b for chain, b in zip(chains, before[:-1], strict=True)), before[-1:]])
    centres, sweeps = (np.concatenate([getattr(chain, name) for chain in chains]) for name in ("centres", "sweeps"))
    first = np.cumsum([0, *(len(chain.sweeps) for chain in chains[:-1])])
    return Chain(joints, at.astype(np.float64), centres, sweeps), first


def cut(pieces: Array, at: Array) -> tuple[Array, Ints]:
    """Return the parts (p, 4, d) of Bézier pieces between places `at` (k + 1,), and which of the k gaps each is in."""
    places = np.unique(np.concatenate([at, np.arange(np.ceil(at[0]), np.floor(at[-1]) + 1.0)]))
    low, high = places[:-1], places[1:]
    k = np.minimum(low.astype(np.intp), len(pieces) - 1)
    return restrict(pieces[k], low - k, high - k), np.searchsorted(at, low, side="right") - 1


def certified(
    edges: Edges,
    tolerance: float,
    made: Callable[[Edges, list[Layer]], tuple[Ints, Chain]],
    judged: Callable[[Chain], tuple[Found, Array]],
    tries: int = _TRIES,
) -> Found:
    """Narrow the choice where a chain turns out to be farther from the curve than it seemed, until one is within.

    A link is narrowed once; then it is left out. Raises LookupError with a node where no chain is left.
    """
    seen = np.zeros(len(edges.links.start), dtype=bool)
    for _ in range(tries):
        rows, chain = made(edges, layers(edges))
        found, far = judged(chain)
        if (far <= tolerance).all():
            return found
        bad = far > tolerance
        ratio = np.where(seen[rows[bad]], 0.0, tolerance / far[bad])
        seen[rows[bad]] = True
        edges = replace(edges, links=_narrowed(edges.links, rows[bad], ratio))
    raise LookupError(int(edges.links.start[rows[np.argmax(far)]]))


def _narrowed(links: Links, rows: Ints, ratio: Array) -> Links:
    """Return the links with rows (k,) narrowed by a ratio (k,), or to nothing if it is below a half."""
    middle, half = 0.5 * (links.low + links.high)[rows], 0.5 * (links.high - links.low)[rows]
    half = np.where((ratio > 0.5) & np.isnan(links.sweep[rows]), 0.98 * ratio * half, -1.0)
    low, high = links.low.copy(), links.high.copy()
    low[rows], high[rows] = middle - half, middle + half
    return replace(links, low=low, high=high)


def along(edges: Edges, found: list[Layer], max_radius: float) -> tuple[Ints, Chain]:
    """Return a chain with free directions at both ends: its links' rows first."""
    low, high = _ends_of(found)
    widest = int(np.argmax(high - low))
    middle = 0.5 * float(low[widest] + high[widest])
    rows, sweeps = trace(edges, found, middle, middle)
    path = _path(edges, rows)
    return rows, _chain(edges.nodes.at[path], edges.nodes.spots[path], sweeps, max_radius)


def _around(edges: Edges, found: list[Layer], limits: Limits) -> tuple[Ints, Chain]:
    """Return a chain that ends in the direction it starts in: its links' rows first.

    An odd number of arcs through given joints closes for one direction at the start, an even number for all or for
    none. So the joints move a little across the curve, by turns; the chain that turns least by that is taken, of those
    with one or two arcs more where it would matter.
    """
    best = (np.inf, np.zeros(0, dtype=np.intp), 0.0)
    for _ in range(_MORE):
        low, high = _ends_of(found)
        angle = 0.5 * float(low.min() + high.max())
        for _ in range(_ENDS):
            ends = np.clip(angle, low, high)
            angle = float(ends[np.argmin(np.abs(ends - angle))])
            rows, _ = trace(edges, found, angle, angle)
            start, off = _start(edges.links, rows)
            best = min(best, (abs(off), rows, start), key=lambda each: each[0])
            angle -= off
        following = more(edges, found[-1])
        if best[0] * _longest(edges, best[1]) <= _TURNED * limits.tolerance or following is None:
            break
        found = [*found, following]
    _, rows, start = best
    path = _path(edges, rows)
    joints, begins = _closing(edges.nodes.spots[path], edges.nodes.angles[path], start)
    chord = np.diff(joints, axis=0)
    turn = np.arctan2(chord[:, 1], chord[:, 0]) - begins
    sweeps = 2.0 * (turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi)))
    return rows, _chain(edges.nodes.at[path], joints, sweeps, limits.max_radius)


def _path(edges: Edges, rows: Ints) -> Ints:
    """Return the nodes of a chain of links."""
    return np.append(edges.links.start[rows], edges.links.end[rows[-1:]])


def _longest(edges: Edges, rows: Ints) -> float:
    return float(np.linalg.norm(np.diff(edges.nodes.spots[_path(edges, rows)], axis=0), axis=1).max())


def _start(links: Links, rows: Ints) -> tuple[float, float]:
    """Return the angle at the first node that the last comes nearest to, of those the chain can have, and how near."""
    low, high, sign, offset = -np.inf, np.inf, 1.0, 0.0
    for row in rows:
        ends = sign * (np.array([links.low[row], links.high[row]]) - offset)
        low, high = max(low, float(ends.min())), min(high, float(ends.max()))
        sign, offset = -sign, float(links.total[row]) - offset
    if sign > 0.0:
        return 0.5 * (low + high), offset
    start = min(max(0.5 * offset, low), high)
    return start, offset - 2.0 * start


def _closing(joints: Array, angles: Array, start: float) -> tuple[Array, Array]:
    """Return joints (k + 1, 2), moved so that the chain that starts at this angle ends so, and its directions (k,)."""
    across = np.column_stack([-np.sin(angles), np.cos(angles)]) * ((-1.0) ** np.arange(len(angles)))[:, None]
    across[[0, -1]] = 0.0

    def mismatch(by: float) -> float:
        turned = _directions(joints + by * across, angles[0] + start)
        return float((turned[-1] - turned[0] + np.pi) % (2.0 * np.pi) - np.pi)

    by, step = 0.0, 1e-6 * float(np.linalg.norm(np.diff(joints, axis=0), axis=1).min())
    for _ in range(8):
        off = mismatch(by)
        rate = (mismatch(by + step) - mismatch(by - step)) / (2.0 * step)
        if abs(off) < 1e-13 or rate == 0.0:
            break
        by -= off / rate
    moved = joints + by * across
    return moved, _directions(moved, angles[0] + start)[:-1]


def _ends_of(found: list[Layer]) -> tuple[Array, Array]:
    """Return the intervals of the angle at the last node."""
    last = found[-1].node == found[-1].node[-1]
    return found[-1].low[last], found[-1].high[last]


def _directions(joints: Array, start: float) -> Array:
    """Return the directions (k + 1,) at joints of arcs that continue each other's: mirrored at each chord."""
    chord = np.diff(joints, axis=0)
    sign = (-1.0) ** np.arange(len(joints))
    turned = np.cumsum(2.0 * sign[:-1] * np.arctan2(chord[:, 1], chord[:, 0]))
    return np.asarray(sign * (start - np.concatenate([[0.0], turned])))


def _chain(at: Array, joints: Array, sweeps: Array, max_radius: float) -> Chain:
    """Return the arcs of sweeps (k,) through joints (k + 1, 2); lines where a radius would be too large."""
    chord = np.diff(joints, axis=0)
    half = 0.5 * np.linalg.norm(chord, axis=1)
    line = half >= max_radius * np.abs(np.sin(0.5 * sweeps))
    height = 1.0 / np.where(line, 1.0, 2.0 * np.tan(0.5 * sweeps))
    centres = 0.5 * (joints[:-1] + joints[1:]) + height[:, None] * np.column_stack([-chord[:, 1], chord[:, 0]])
    centres[line] = np.nan
    return Chain(joints, at, centres, np.where(line, 0.0, sweeps))
