"""Sweeps that pass through themselves, made into solids that do not: the union of their parts, through manifold3d."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array, Ints
from cadfit.sweeping.caps import dome, dome_walls, flat_cap, walls
from cadfit.sweeping.touching import tight_steps

_LEAST_TURN = 0.5 * np.pi  # a part of a path that turns less does not meet itself, unless a bend is too tight
_SIMPLER = 0.1  # of the tolerance: how far vertices may move for edges that can be done without
_SPECK = 1e-7  # of the volume: parts that rounding leaves where walls coincide
_THIN = 1e-9  # of a reach: what advances less does not advance


def united(
    points: Array,
    centres: Array,
    tangents: Array,
    loops: Sequence[Array],
    closed: bool,
    round_ends: bool,
    tolerance: float,
    varies: bool,
) -> tuple[Array, Ints]:
    """Return the vertices (v, 3) and triangles (f, 3) of the space that a profile passes through, ring after ring.

    `points` (n, k, 3) are the rings of `loops`, polygons (k, 2) of an outline and its holes; `centres` and `tangents`
    (n, 3) their places. Edges that can be done without within the tolerance are. Where every point of the profile
    advances from ring to ring, the steps make parts with walls, each turning less than a right angle, and where the
    profile `varies` without a tight step (see `tight_steps`) but in parts of its own; where one does not, the hull of
    two rings takes their place, or for a profile that is not convex the hulls of its triangles. The parts are united.

    Raises ImportError naming the extra where manifold3d is missing, ValueError where it fails.
    """
    try:
        import manifold3d
    except ImportError as error:
        raise ImportError("on_self_intersection='repair' needs manifold3d: pip install cadfit[repair]") from error

    order = [*range(len(points)), *([0] if closed else [])]
    cap = flat_cap(loops)
    pieces = [np.arange(points.shape[1])] if _is_convex(loops) else list(cap)
    clean, turns = _advances(points[order], tangents[order]), _turns(tangents[order])
    if varies:
        turns[tight_steps(points[order], centres[order], tangents[order])] = np.pi
    solids: list[Any] = []
    for low, high in _runs(clean, turns):
        rows = order[low : high + 1]
        if clean[low]:
            solids.append(_solid(manifold3d, *_part(points[rows], [len(loop) for loop in loops], cap)))
        else:
            both = points[rows]
            solids += [manifold3d.Manifold.hull_points(both[:, piece].reshape(-1, 3)) for piece in pieces]
    if round_ends and not closed:
        solids += [_solid(manifold3d, *_round_end(points, centres, tangents, end, tolerance, cap)) for end in (0, -1)]
    solids = [solid for solid in solids if not solid.is_empty()]
    whole = manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Add)
    if whole.status() != manifold3d.Error.NoError or whole.is_empty():
        raise ValueError(f"the sweep could not be repaired: {whole.status()}")
    whole = whole.simplify(_SIMPLER * tolerance)
    parts = [part for part in whole.decompose() if abs(part.volume()) > _SPECK * whole.volume()]
    mesh = manifold3d.Manifold.compose(parts).to_mesh64()
    return np.array(mesh.vert_properties)[:, :3], np.array(mesh.tri_verts, dtype=np.int64)


def _is_convex(loops: Sequence[Array]) -> bool:
    edges = np.roll(loops[0], -1, axis=0) - loops[0]
    following = np.roll(edges, -1, axis=0)
    return len(loops) == 1 and bool((edges[:, 0] * following[:, 1] >= edges[:, 1] * following[:, 0]).all())


def _advances(points: Array, tangents: Array) -> NDArray[np.bool_]:
    """Return for each step (n - 1,) whether every point moves forward, seen from both rings."""
    steps = points[1:] - points[:-1]
    least = np.minimum(*(np.einsum("nkd,nd->nk", steps, ways).min(axis=1) for ways in (tangents[:-1], tangents[1:])))
    return np.asarray(least > _THIN * np.ptp(points[0], axis=0).max())


def _turns(tangents: Array) -> Array:
    cosines = np.einsum("nd,nd->n", tangents[1:], tangents[:-1])
    return np.asarray(np.arccos(np.clip(cosines, -1.0, 1.0)))


def _runs(clean: NDArray[np.bool_], turns: Array) -> list[tuple[int, int]]:
    """Return first and last rings of parts: steps that advance while they turn by less than a right angle, or one."""
    runs, low, turned = [], 0, 0.0
    for k, (advances, turn) in enumerate(zip(clean.tolist(), turns.tolist(), strict=True)):
        if k > low and not (advances and clean[k - 1] and turned + turn < _LEAST_TURN):
            runs.append((low, k))
            low, turned = k, 0.0
        turned += turn
    return [*runs, (low, len(clean))]


def _part(points: Array, loops: list[int], cap: Ints) -> tuple[Array, Ints]:
    n, k = points.shape[:2]
    faces = np.concatenate([walls(n, loops, closed=False), cap[:, ::-1], cap + k * (n - 1)])
    return points.reshape(-1, 3), faces


def _round_end(
    points: Array, centres: Array, tangents: Array, end: int, tolerance: float, cap: Ints
) -> tuple[Array, Ints]:
    outward = tangents[end] if end else -tangents[end]
    over = dome(points[end], centres[end], outward, tolerance)
    k = points.shape[1]
    faces = np.concatenate([dome_walls(0, k, k, len(over)), cap[:, ::-1]])
    return np.concatenate([points[end], over]), faces if end else faces[:, ::-1]


def _solid(manifold3d: Any, vertices: Array, faces: Ints) -> Any:
    return manifold3d.Manifold(manifold3d.Mesh64(np.ascontiguousarray(vertices), faces.astype(np.uint64)))
