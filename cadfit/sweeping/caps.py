"""The ends of a sweep: flat caps over profiles of any shape."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cadfit.bezier import Array, Ints


def flat_cap(loops: Sequence[Array]) -> Ints:
    """Return triangles (f, 3), counterclockwise, that fill an outline (k, 2) less its holes: every corner is used.

    Corners are numbered through the loops in order. By ear clipping (mapbox-earcut), which may leave out corners that
    lie in line with their neighbours: those are put back in, so that the cap meets the walls edge by edge.

    >>> flat_cap([np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])]).shape
    (2, 3)
    """
    from mapbox_earcut import triangulate_float64

    corners = np.concatenate(loops)
    ends = np.cumsum([len(loop) for loop in loops])
    triangles = np.asarray(triangulate_float64(corners, ends.astype(np.uint32)), dtype=np.intp).reshape(-1, 3)
    a, b, c = corners[triangles].transpose(1, 2, 0)
    turned = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    wanted = len(corners) + 2 * len(loops) - 4
    if len(triangles) != wanted:
        raise ValueError(
            f"the profile cannot be filled: {len(triangles)} triangles for {len(corners)} corners, not {wanted}"
        )
    return triangles
