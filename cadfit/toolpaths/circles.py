"""The circles of G2 and G3, from their centre or their radius, held to a controller's rules."""

from __future__ import annotations

from math import atan2, copysign, hypot, pi, sqrt

from cadfit.toolpaths.words import refuse

Point = tuple[float, float]

RADII_DIFFER = 0.00127  # LinuxCNC's CENTER_ARC_RADIUS_TOLERANCE_MM: more is an error where it is also 0.1 % ...
RADII_RELATIVE = 0.001
RADII_NEVER = 0.127  # ... and this always is


def by_centre(
    line: int, start: Point, end: Point, centre: Point, left: bool, unit: float
) -> tuple[Point, float, float]:
    """Return centre, radius and sweep of the arc about a centre; `unit`: a millimetre in the program's unit.

    Raises ValueError naming the line where the ends are not equally far from the centre, by LinuxCNC's rule.

    >>> by_centre(1, (0.0, 0.0), (10.0, 0.0), (5.0, 0.0), False, 1.0)
    ((5.0, 0.0), 5.0, -3.141592653589793)
    """
    first, last = hypot(start[0] - centre[0], start[1] - centre[1]), hypot(end[0] - centre[0], end[1] - centre[1])
    if first == 0.0:
        refuse(line, "the arc's centre is its start")
    if not radii_agree(first, last, unit):
        refuse(line, f"the arc's ends do not match its centre: they are {first:.6g} and {last:.6g} from it")
    return centre, first, _sweep(start, end, centre, left)


def by_radius(
    line: int, start: Point, end: Point, radius: float, left: bool, unit: float
) -> tuple[Point, float, float]:
    """Return centre, radius and sweep of the arc of a radius: the shorter one, or with a negative radius the longer.

    >>> by_radius(1, (0.0, 0.0), (10.0, 0.0), 5.0, True, 1.0)[0]
    (5.0, 0.0)
    """
    across, up = end[0] - start[0], end[1] - start[1]
    chord, size = hypot(across, up), abs(radius)
    if chord == 0.0:
        refuse(line, "an arc given by its radius must end elsewhere than it starts")
    if chord / 2 - size > RADII_DIFFER * unit:
        refuse(line, f"no arc of radius {size:g} reaches over {chord:.6g}")
    side = sqrt(max(size * size - chord * chord / 4, 0.0)) / chord * copysign(1.0, radius) * (1.0 if left else -1.0)
    centre = (start[0] + across / 2 - up * side, start[1] + up / 2 + across * side)
    return centre, max(size, chord / 2), _sweep(start, end, centre, left)


def radii_agree(first: float, last: float, unit: float) -> bool:
    """Return whether the distances of an arc's ends from its centre agree, by LinuxCNC's rule."""
    apart = abs(first - last)
    return apart <= RADII_DIFFER * unit or (apart <= RADII_NEVER * unit and apart <= RADII_RELATIVE * max(first, last))


def _sweep(start: Point, end: Point, centre: Point, left: bool) -> float:
    """Return the angle from start to end about the centre, positive to the left; a whole turn where they are one."""
    if start == end:
        return 2 * pi if left else -2 * pi
    u, v = (start[0] - centre[0], start[1] - centre[1]), (end[0] - centre[0], end[1] - centre[1])
    turn = atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    if left:
        return turn if turn > 0 else turn + 2 * pi
    return turn if turn < 0 else turn - 2 * pi
