"""The ends of a sweep: flat caps over profiles of any shape, and round ones over those without holes."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints


def flat_cap(loops: Sequence[Array]) -> Ints:
    """Return triangles (f, 3), counterclockwise, that fill an outline (k, 2) less its holes; every corner is used.

    Corners are numbered through the loops in order. By ear clipping (mapbox-earcut), which is given no corners in line
    with their neighbours; those are put back in, so that the cap meets the walls edge by edge.

    Raises ValueError where the profile cannot be filled: a hole outside, edges that cross.

    >>> flat_cap([np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]])]).tolist()
    [[0, 1, 3], [1, 2, 3]]
    """
    from mapbox_earcut import triangulate_float64

    corners = np.concatenate(loops)
    turning = [np.flatnonzero(_turns(loop)) for loop in loops]
    starts = np.cumsum([0, *map(len, loops)])
    numbers = np.concatenate([start + rows for start, rows in zip(starts[:-1], turning, strict=True)])
    ends = np.cumsum([len(rows) for rows in turning])
    found = np.asarray(triangulate_float64(corners[numbers], ends.astype(np.uint32)), dtype=np.intp).reshape(-1, 3)
    a, b, c = corners[numbers][found].transpose(1, 2, 0)
    turned = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0.0
    found[turned] = found[turned][:, ::-1]
    wanted = len(numbers) + 2 * len(loops) - 4
    if len(found) != wanted or len(np.unique(found)) != len(numbers):
        why = "its holes must lie inside its outline and apart from each other" if loops[1:] else "it meets itself"
        raise ValueError(f"the profile cannot be filled: {why}")
    triangles = numbers[found]
    if len(numbers) == len(corners):
        return triangles
    rows = [start + np.arange(len(loop)) for start, loop in zip(starts[:-1], loops, strict=True)]
    return _with_corners(triangles, rows, set(numbers.tolist()))


def _turns(loop: Array) -> NDArray[np.bool_]:
    """Return whether each corner (k,) is not in line with its neighbours."""
    before, after = loop - np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0) - loop
    sine = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    sizes = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.asarray((np.abs(sine) > 1e-9 * sizes) | (np.einsum("kd,kd->k", before, after) < 0.0))


def _with_corners(triangles: Ints, rows: list[Ints], used: set[int]) -> Ints:
    """Return the triangles, each with a boundary edge on which corners were left out cut into a fan over these."""
    faces = dict(enumerate(map(tuple, triangles.tolist())))
    owners = {edge: k for k, (a, b, c) in faces.items() for edge in ((a, b), (b, c), (c, a))}
    for loop in rows:
        first = next(k for k, corner in enumerate(loop.tolist()) if corner in used)
        left_out: list[int] = []
        start = int(loop[first])
        for corner in [*loop[first + 1 :].tolist(), *loop[: first + 1].tolist()]:
            if corner not in used:
                left_out.append(corner)
                continue
            if left_out:
                k = owners[start, corner]
                (apex,) = {*faces[k]} - {start, corner}
                chain = [start, *left_out, corner]
                faces[k] = (start, chain[1], apex)
                for a, b in zip(chain[1:-1], chain[2:], strict=True):
                    new = len(faces)
                    faces[new] = (a, b, apex)
                owners[corner, apex] = len(faces) - 1
                left_out = []
            start = corner
    return np.array(list(faces.values()), dtype=np.intp)


def dome(ring: Array, centre: Array, outward: Array, tolerance: float) -> Array:
    """Return the points (m k + 1, 3) of a round end over a ring (k, 3): m more rings, then the apex.

    Each point of the ring runs in a quarter of an ellipse to the apex, which is as far beyond `centre` along the unit
    vector `outward` as the ring's farthest point is beside it: over a circle, half a ball. The rings keep to
    `tolerance`.

    >>> square = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    >>> dome(square, np.zeros(3), np.array([0.0, 0, 1]), 10.0)[-1]
    array([0., 0., 1.])
    """
    arms = ring - centre
    reach = float(np.linalg.norm(arms, axis=1).max())
    steps = max(2, math.ceil(0.25 * math.pi / math.acos(max(1.0 - tolerance / reach, 0.5))))
    angles = 0.5 * math.pi / steps * np.arange(1, steps)
    rise, shrink = reach * np.sin(angles), np.cos(angles)
    rings = centre + rise[:, None, None] * outward + shrink[:, None, None] * arms
    return np.concatenate([rings.reshape(-1, 3), (centre + reach * outward)[None]])


def walls(rings: int, loops: Sequence[int], closed: bool) -> Ints:
    """Return the triangles (f, 3) between rings of the corners of several loops, outward where these run outward.

    `loops` are the numbers of their corners; with `closed` the last ring is joined to the first.

    >>> walls(2, [3], closed=False)[:2].tolist()
    [[0, 1, 4], [1, 2, 5]]
    """
    k = sum(loops)
    here = np.arange(k)
    starts = np.cumsum(loops) - loops
    there = np.concatenate([start + np.roll(np.arange(n), -1) for start, n in zip(starts, loops, strict=True)])
    step = np.concatenate([np.column_stack([here, there, there + k]), np.column_stack([here, there + k, here + k])])
    count = rings if closed else rings - 1
    faces = (step + k * np.arange(count)[:, None, None]).reshape(-1, 3)
    if closed:
        faces %= rings * k
    return faces


def dome_walls(first: int, k: int, start: int, points: int) -> Ints:
    """Return the triangles (f, 3) of a dome of so many `points` from `start` on, over the ring of k from `first` on.

    They face outward where the ring, seen from outside, runs counterclockwise.

    >>> dome_walls(0, 3, 3, 1).tolist()
    [[0, 1, 3], [1, 2, 3], [2, 0, 3]]
    """
    m = (points - 1) // k
    rows = np.concatenate([np.arange(first, first + k)[None], start + np.arange(m * k).reshape(m, k)])
    here, there = rows, np.roll(rows, -1, axis=1)
    lower = np.stack([here[:-1], there[:-1], there[1:]], axis=2)
    upper = np.stack([here[:-1], there[1:], here[1:]], axis=2)
    tip = np.column_stack([here[-1], there[-1], np.full(k, start + m * k)])
    return np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3), tip])
