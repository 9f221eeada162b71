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
_BEHIND = 64  # nodes behind the farthest from which it is tried to go on
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
    last = len(edges.first) - 2
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
    low, high = np.maximum(layer.low[of], edges.low[rows]), np.minimum(layer.high[of], edges.high[rows])
    good = low <= high
    if not good.any():
        return None
    rows = rows[good]
    node, low, high = edges.end[rows], edges.total[rows] - high[good], edges.total[rows] - low[good]
    near = node > node.max() - _BEHIND
    node, low, high = node[near], low[near], high[near]
    order = np.lexsort((low, node))
    node, low, high = node[order], low[order], high[order]
    shift = _APART * (node - node[0])
    above = np.maximum.accumulate(high + shift)
    start = np.flatnonzero(np.concatenate([[True], low[1:] + shift[1:] > above[:-1]]))
    return Layer(node[start], low[start], np.maximum.reduceat(high, start))


def trace(edges: Edges, found: list[Layer], node: int, angle: float) -> tuple[Ints, float]:
    """Return the rows of the edges, and the angle at the first node, of a chain to a node of the last layer at `angle`.

    Of the nodes it can come from, each arc takes the one that leaves it most room in the tolerance.
    """
    chain = np.empty(len(found) - 1, dtype=np.intp)
    for k in range(len(found) - 2, -1, -1):
        layer, rows = found[k], edges.back[edges.into[node] : edges.into[node + 1]]
        begin = np.searchsorted(layer.node, edges.start[rows])
        count = np.searchsorted(layer.node, edges.start[rows], side="right") - begin
        rows = np.repeat(rows, count)
        of = np.arange(len(rows)) + np.repeat(begin - (np.cumsum(count) - count), count)
        before = edges.total[rows] - angle
        inside = np.minimum(before - layer.low[of], layer.high[of] - before)
        width = np.maximum(edges.high[rows] - edges.low[rows], 1e-300)
        room = np.minimum(before - edges.low[rows], edges.high[rows] - before) / width
        best = int(np.argmax(np.where(inside >= 0.0, room, inside - 1.0)))
        chain[k], node, angle = rows[best], edges.start[rows[best]], float(before[best])
    return chain, angle


def _onward(edges: Edges, node: Ints) -> tuple[Ints, Ints]:
    """Return the rows of the edges that start at each of the nodes, and which of the nodes that is."""
    count = edges.first[node + 1] - edges.first[node]
    of = np.repeat(np.arange(len(node)), count)
    rows = np.arange(len(of)) + np.repeat(edges.first[node] - (np.cumsum(count) - count), count)
    return rows, of
