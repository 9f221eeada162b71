"""Faces of a mesh that pass through each other, counted by signed volumes: independent of what cadfit does."""

import numpy as np


def _volumes(a, b, c, d):
    """Six times the signed volume of each tetrahedron."""
    return np.einsum("pi,pi->p", np.cross(b - a, c - a), d - a)


def _stabs(p, q, a, b, c, depth):
    """Whether each segment p q passes through the triangle a b c: five tetrahedra tell, each at least so deep."""
    base = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    above, below = _volumes(a, b, c, p) / base, _volumes(a, b, c, q) / base
    opposite = (above > depth) & (below < -depth) | (above < -depth) & (below > depth)
    around = np.stack([_volumes(p, q, a, b), _volumes(p, q, b, c), _volumes(p, q, c, a)])
    length = np.linalg.norm(q - p, axis=1)
    sides = np.stack([np.linalg.norm(y - x, axis=1) for x, y in ((a, b), (b, c), (c, a))])
    around /= length * sides
    return opposite & ((around > depth).all(axis=0) | (around < -depth).all(axis=0))


def _pairs(vertices, faces, chunk=2_000_000):
    """Pairs of faces with overlapping boxes, from faces sorted along the longest axis."""
    corners = vertices[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    order = np.argsort(low[:, axis])
    stop = np.searchsorted(low[order, axis], high[order, axis], side="right")
    counts = np.maximum(stop - np.arange(len(order)) - 1, 0)
    ends = np.cumsum(counts)
    start = 0
    while start < len(order):
        end = max(start + 1, int(np.searchsorted(ends, (ends[start - 1] if start else 0) + chunk)))
        here = counts[start:end]
        owner = np.repeat(np.arange(start, end), here)
        other = owner + 1 + np.arange(len(owner)) - np.repeat(np.cumsum(here) - here, here)
        i, j = order[owner], order[other]
        meet = np.all((low[i] <= high[j]) & (low[j] <= high[i]), axis=1)
        yield i[meet], j[meet]
        start = end


def crossing_faces(mesh, depth=1e-7):
    """The number of pairs of faces that pass through each other by more than `depth` of the mesh's size.

    Faces that share corners (by place) count as well, unless they share an edge.
    """
    places, inverse = np.unique(np.round(mesh.vertices / mesh.scale, 12), axis=0, return_inverse=True)
    vertices, faces = places * mesh.scale, inverse.reshape(-1)[mesh.faces]
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])]
    depth *= mesh.scale
    total = 0
    for i, j in _pairs(vertices, faces):
        shared = (faces[i][:, :, None] == faces[j][:, None, :]).sum(axis=(1, 2))
        i, j = i[shared < 2], j[shared < 2]
        hit = np.zeros(len(i), dtype=bool)
        for one, two in ((i, j), (j, i)):
            a, b, c = vertices[faces[two]].transpose(1, 0, 2)
            for k in range(3):
                p, q = vertices[faces[one, k]], vertices[faces[one, (k + 1) % 3]]
                with np.errstate(divide="ignore", invalid="ignore"):
                    hit |= _stabs(p, q, a, b, c, depth)
        total += int(hit.sum())
    return total
