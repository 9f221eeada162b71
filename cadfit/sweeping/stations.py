"""Where along a path the rings of a tube stand: as few as one chord tolerance allows.

Everything is decided on the parts of a `Chain`, from bounds that hold over a whole part.
"""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.sweeping.chain import Chain, cut, end_bends, shared
from cadfit.sweeping.cubics import SLOW, horner, limits, norms, powers

STEEPEST = np.pi / 4  # the most a ring may turn against the next, radians
_FEW = 6  # a part that needs no more rings than this is given them at once
_SPARE = 0.1  # as are the last parts when they need no more than this share of the rings
_MANY = 8  # the most parts that a part is cut into before it is looked at again
_MOST_VERTICES = 20_000_000  # of a mesh: more is a mistake in the tolerance, and would not fit many machines


def most_rings(corners: int) -> int:
    """Return how many rings of so many corners a mesh may have.

    >>> most_rings(16)
    1250000
    """
    return _MOST_VERTICES // corners


def stationed(whole: Chain, radius: float, tolerance: float, most: int = _MOST_VERTICES) -> tuple[Array, Array]:
    """Return the points and the unit tangents (3, n) of a path where the rings of a tube are to stand, both ends too.

    Between two rings the centre line and the outermost fibre of a tube of that radius stray from their chords by at
    most `tolerance`: with l a part's length and k its largest curvature, both bounded from above, by
    (1 + k radius) k l^2 / 8. No ring turns more than 45 degrees against the next. A straight span is one step.
    Parts shorter than a thousandth of the tolerance, as next to a cusp, are not cut further. The number of rings grows
    as the square root of 1 / tolerance.

    Raises ValueError naming a place where the rings crowd for a path that needs more than `most`.

    >>> from cadfit import BSpline
    >>> from cadfit.sweeping.chain import chain
    >>> straight = BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> stationed(chain(straight), 1.0, 1e-6)[0]
    array([[0., 9.],
           [0., 0.],
           [0., 0.]])
    """
    return _placed(*_divided(whole, radius, tolerance, most))


def station_parameters(whole: Chain, radius: float, tolerance: float, most: int = _MOST_VERTICES) -> Array:
    """Return the parameters (n,) at which `stationed` places its rings, rising.

    >>> from cadfit import BSpline
    >>> from cadfit.sweeping.chain import chain
    >>> straight = BSpline([[0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 0, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> station_parameters(chain(straight), 1.0, 1e-6)
    array([0., 1.])
    """
    parts, counts = _divided(whole, radius, tolerance, most)
    owner, t = shared(counts)
    return np.append(parts.starts[owner] + t * parts.widths[owner], whole.starts[-1] + whole.widths[-1])


def _divided(whole: Chain, radius: float, tolerance: float, most: int) -> tuple[Chain, Ints]:
    """Return parts of a path, in order, and the number of steps that each of them needs: see `stationed`."""
    todo, done, total = whole, [], 0.0
    while True:
        turns = todo.lengths * todo.curvatures
        needed = np.maximum(np.sqrt((todo.lengths + radius * turns) * turns / (8.0 * tolerance)), turns / STEEPEST)
        needed[todo.lengths <= 1e-3 * tolerance] = 1.0
        counts = np.maximum(np.ceil(needed - 1e-9), 1.0)
        if total + len(todo) > most:  # a ring a part is the least
            raise _crowded(todo, counts, tolerance, most)
        # A part that does not bend evenly gets more rings than it needs: it is cut and looked at again, unless they are
        # few, its own or among all.
        uneven, enough = counts > _FEW, _SPARE * (total + counts.sum())
        if counts[uneven].sum() > enough or enough == np.inf:
            uneven &= todo.curvatures > 1.5 * end_bends(todo).min(axis=0)
        if counts[uneven].sum() <= enough < np.inf:
            done.append((todo, counts))
            break
        done.append((todo[~uneven], counts[~uneven]))
        total += counts[~uneven].sum()
        todo = cut(todo[uneven], np.clip(counts[uneven] / _FEW, 2, _MANY).astype(np.intp))
    if total + counts.sum() > most:
        raise _crowded(todo, counts, tolerance, most)
    if len(done) > 1:
        every = (np.concatenate([getattr(part, name) for part, _ in done], axis=-1) for name in Chain.__slots__)
        todo, counts = Chain(*every), np.concatenate([counts for _, counts in done])
        order = np.argsort(todo.starts, kind="stable")
        todo, counts = todo[order], counts[order]
    return todo, counts.astype(np.intp)


def _crowded(parts: Chain, counts: Array, tolerance: float, most: int) -> ValueError:
    """Return the error that a path needs too many rings, with the place where they are nearest each other."""
    k = int(np.argmin(parts.lengths / counts))
    place = ", ".join(f"{value:g}" for value in parts.origins[:, k])
    return ValueError(
        f"the mesh would need more than {most:,} rings, which crowd at the parameter {parts.starts[k]:g}, "
        f"near ({place}): is the tolerance, {tolerance:.3g} for this, too small?"
    )


def _placed(parts: Chain, counts: Ints) -> tuple[Array, Array]:
    """Return the points and the unit tangents where so many rings a part stand, and at the end."""
    owner, t = shared(counts, ends=1)
    points, velocities = horner(powers(parts.origins, parts.legs).take(owner, axis=2), t)
    speeds = norms(velocities)
    if speeds.min() <= SLOW * speeds.max():
        steps, ends = owner[:-1], t[1:] == 0.0
        ends[-1] = True
        share = 1.0 / counts[steps]
        leaving = share / 3.0 * velocities[:, :-1]
        arriving = share * np.where(ends, parts.legs[2][:, steps], velocities[:, 1:] / 3.0)
        velocities = limits(leaving, arriving, points[:, 1:] - points[:, :-1], points)
        speeds = norms(velocities)
    velocities /= speeds
    return points, velocities
