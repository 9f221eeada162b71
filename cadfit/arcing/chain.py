"""The fewest arcs from one end of a stretch to the other, each beginning in the direction in which the last one ends.

An arc from node i to node j is known by the angle d of its start against the curve's tangent at i; it ends at the angle
total - d against that at j. So the angles that can be reached at a node with k arcs are intervals, found exactly by
intersecting, reflecting and uniting those of the nodes before: breadth first, one layer for each arc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cadfit.arcing.reach import Edges
from cadfit.bezier import Array, Ints

_WIDEST = 1.2  # radians, between a curve and the arcs at its open end
_ANY = 4.5  # more than any angle at a corner
_BEHIND = 64  # rows of nodes behind the farthest from which it is tried to go on
_APART = 10.0  # more than angles differ


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """What so many arcs reach: `node` (c,), not falling, with `low` and `high` (c,) of the angles there."""

    node: Ints
    low: Array
    high: Array


def layers(edges: Edges) -> list[Layer]:
    """Return the layers from the first node (any direction) up to the first that has the last node.

    Raises LookupError with the farthest node where none has it.
    """
    last = len(edges.place) - 1
    found = [Layer(np.zeros(1, dtype=np.intp), np.array([-_WIDEST]), np.array([_WIDEST]))]
    while found[-1].node[-1] != last:
        following = more(edges, found[-1])
        if following is None:
            raise LookupError(int(found[-1].node[-1]))
        found.append(following)
    return found


def more(edges: Edges, layer: Layer) -> Layer | None:
    """Return what one arc more reaches; None where that is nothing."""
    rows, of = _onward(edges, layer.node)
    low, high = np.maximum(layer.low[of], edges.links.low[rows]), np.minimum(layer.high[of], edges.links.high[rows])
    good = low <= high
    if not good.any():
        return None
    links, low, high = edges.links.of(rows[good]), low[good], high[good]
    near = edges.place[links.end] > edges.place[links.end.max()] - _BEHIND
    links, low, high = links.of(near), low[near], high[near]
    node, free = links.end, edges.nodes.corners[links.end]
    one = ~np.isnan(links.sweep)
    low, high = np.where(one, links.exit_low, links.total - high), np.where(one, links.exit_high, links.total - low)
    low, high = np.where(free, -_ANY, low), np.where(free, _ANY, high)
    order = np.lexsort((low, node))
    node, low, high = node[order], low[order], high[order]
    shift = _APART * (node - node[0])
    above = np.maximum.accumulate(high + shift)
    start = np.flatnonzero(np.concatenate([[True], low[1:] + shift[1:] > above[:-1]]))
    return Layer(node[start], low[start], np.maximum.reduceat(high, start))


def trace(edges: Edges, found: list[Layer], low: float, high: float) -> tuple[Ints, Array]:
    """Return the rows of the edges of a chain to the last node, arriving between two angles, and their sweeps (k,).

    Of the nodes it can come from, each arc takes the one that leaves it most room in the tolerance.
    """
    count, node = len(found) - 1, len(edges.place) - 1
    chain, sweeps = np.empty(count, dtype=np.intp), np.empty(count)
    angles = edges.nodes.angles
    for k in range(count - 1, -1, -1):
        layer, rows = found[k], edges.back[edges.into[node] : edges.into[node + 1]]
        begin = np.searchsorted(layer.node, edges.links.start[rows])
        times = np.searchsorted(layer.node, edges.links.start[rows], side="right") - begin
        rows = np.repeat(rows, times)
        of = np.arange(len(rows)) + np.repeat(begin - (np.cumsum(times) - times), times)
        links = edges.links.of(rows)
        one = ~np.isnan(links.sweep)
        least = np.maximum(np.maximum(layer.low[of], links.low), np.where(one, -np.inf, links.total - high))
        most = np.minimum(np.minimum(layer.high[of], links.high), np.where(one, np.inf, links.total - low))
        meets = np.where(one, np.minimum(links.exit_high - low, high - links.exit_low), 0.0)
        inside = np.minimum(most - least, meets)
        start = np.clip(0.5 * (links.low + links.high), least, np.maximum(most, least))
        width = np.maximum(links.high - links.low, 1e-300)
        room = np.minimum(start - links.low, links.high - start) / width
        best = int(np.argmax(np.where(inside >= 0.0, np.where(one, links.rank, room), np.minimum(inside, 0.0) - 10.0)))
        chain[k], node = rows[best], int(links.start[best])
        if one[best]:
            sweeps[k], low, high = links.sweep[best], float(least[best]), float(most[best])
        else:
            low = high = float(start[best])
            turned = float(angles[links.end[best]] - angles[node])
            sweeps[k] = turned + float(links.total[best]) - 2.0 * low
        if edges.nodes.corners[node]:
            low, high = -_ANY, _ANY
    return chain, sweeps


def _onward(edges: Edges, node: Ints) -> tuple[Ints, Ints]:
    """Return the rows of the edges that start at each of the nodes, and which of the nodes that is."""
    count = edges.first[node + 1] - edges.first[node]
    of = np.repeat(np.arange(len(node)), count)
    rows = np.arange(len(of)) + np.repeat(edges.first[node] - (np.cumsum(count) - count), count)
    return rows, of
