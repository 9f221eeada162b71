"""A smooth stretch of a path as the fewest arcs of the curve fitted to it, held to the path itself."""

from __future__ import annotations

from cadfit.arcing.approximate import arcs
from cadfit.bezier import Array
from cadfit.fitting.approximate import fit, smallest_tolerance
from cadfit.toolpaths.biarcs import Piece, Rules, written_arc
from cadfit.toolpaths.cover import Step, cut_at

_FITTED = 0.1  # of the tolerance: the curve passes the vertices within that
_MOST_POLES = 60  # of the curve: with more, or on a rough path, the search for arcs takes minutes
_USED = 0.97  # of what the curve leaves of the tolerance: rounding takes some


def fewest(points: Array, tolerance: float, rules: Rules, exact: tuple[bool, bool]) -> Step | None:
    """Return arcs from the first to the last vertex of a smooth path (n, 2), as they are written; None if they stray.

    The vertices count as places of a curve, which is fitted first; what is returned is within `tolerance` of the path.
    """
    if len(points) < 5 or _FITTED * tolerance < smallest_tolerance(points):
        return None
    try:
        curve = fit(points, _FITTED * tolerance, closed=False, corners=None, effort="fast")
        off = max(curve.deviation.points, curve.deviation.between)
        if off >= 0.8 * tolerance or curve.poles > min(len(points) // 2, _MOST_POLES):
            return None
        found = arcs(curve, _USED * (tolerance - off), decimals=rules.decimals, max_radius=rules.largest_radius)
    except ValueError:
        return None
    joints = [rules.rounded((float(x), float(y))) for x, y in [*found.starts, found.ends[-1]]]
    for row, kept in zip((0, -1), exact, strict=True):
        if kept:
            joints[row] = (float(points[row, 0]), float(points[row, 1]))
    pieces, far, rest = [], 0.0, points
    for k, (centre, sweep) in enumerate(zip(found.centres, found.sweeps, strict=True)):
        start, end = joints[k], joints[k + 1]
        turn = float(sweep)
        piece = Piece(start, end)
        if turn:
            bent = written_arc(start, end, (float(centre[0]), float(centre[1])), turn, rules)
            if bent is None or bent.radius < rules.least_radius:
                return None
            piece = bent
        part = rest
        if k < len(found.sweeps) - 1:
            parts = cut_at(rest, piece)
            if parts is None:
                return None
            part, rest = parts
        far = max(far, piece.deviation(part))
        if far > tolerance:
            return None
        pieces.append(piece)
    return Step(0, len(points) - 1, tuple(pieces), far)
