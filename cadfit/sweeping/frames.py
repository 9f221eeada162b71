"""Rotation-minimizing frames along a path, by double reflection.

Source: Wang, Jüttler, Zheng, Liu, Computation of rotation minimizing frames, ACM Transactions on Graphics 27(1), 2008.

Two reflections make a rotation, and a rotation acts on a spinor by one small product, which is what is computed here.
A tangent t is written as a spinor, two complex numbers psi with psi^H sigma psi along t; a phase e^(i a) on psi turns
the frame about t by -2 a, so a spinor is a tangent together with a normal. The paper's double reflection along the
chord v carries psi to a multiple of psi' with the phase of <psi', (v . sigma) psi>: its second reflection only brings
in (t' . sigma), which psi' absorbs. So a step's turn can be read off that number whatever phases the two spinors were
given, all steps are independent, and a cumulative product joins them. With psi = (a, c), normal + i binormal is along
(a^2 - c^2, i (a^2 + c^2), -2 a c), so a frame is turned by the square of its spinor's phase.

Arrays of vectors are (3, n) here, arrays of spinors (2, n): numpy is quickest along long rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cadfit.bezier import Array
from cadfit.bspline import BSpline

Complex = NDArray[np.complex128]

SMOOTH = 1e-6  # radians: a smaller break of the tangent is rounding, a larger one is a corner
SLOW = 1e-9  # of the largest handle: a shorter one is looked at closely, for it may have no direction
_LEVEL = 1e-6  # the sine of the least angle between a tangent and `up`
_NOISE = 64.0 * np.finfo(np.float64).eps  # of the largest coordinate: what rounding leaves of a difference


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Frames at n stations of a path: `origins`, `tangents`, `normals`, `binormals`, (n, 3) each, read-only.

    Tangent, normal and binormal are right-handed unit vectors. `lengths` (n,) is the arc length from the path's start
    (Simpson's rule from station to station). `holonomy` is the angle in radians by which the transported normal of a
    closed path missed its start, counted about the tangent; it has been spread over the frames, so that the seam
    closes. It is 0.0 on an open path. `error` estimates the angle in radians by which the last normal may be off: the
    difference that half steps make, times the square of each step's bend, which is what the extrapolation leaves.
    """

    origins: Array
    tangents: Array
    normals: Array
    binormals: Array
    lengths: Array
    holonomy: float = 0.0
    error: float = 0.0

    def __post_init__(self) -> None:
        for name in ("origins", "tangents", "normals", "binormals", "lengths"):
            values = getattr(self, name).view()
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return len(self.lengths)


def frames(spline: BSpline, parameters: ArrayLike, up: ArrayLike | None = None) -> Frames:
    """Return the rotation-minimizing frames of a path at the given parameters (n,), in any order.

    `spline` has 2 or 3 dimensions (2D lies in z = 0). The frames turn about the tangent as little as the path's bending
    allows, from a first normal that is horizontal (its binormal points up, toward +z; where the path starts near the
    vertical, toward +y). They are transported through every knot of the path as well as the parameters, each step
    also as two half steps, whose difference takes the error from fourth to sixth order. On a closed path with
    one tangent at the seam the angle left over, `Frames.holonomy`, is spread evenly along the arc length.

    With `up` (3,) there is no transport: every binormal is `up` made square to the tangent, every normal level, as on
    a road without banking. Frenet's frames are `cadfit.frenet`.

    Where the path stands still (a cusp, repeated poles) the tangent is the direction in which it leaves, at the very
    end that in which it arrives. At a corner it is the tangent after the corner. Where the tangent turns straight
    back, every normal is as good as another, and the one given depends on rounding.

    Raises ValueError for a path of another dimension, for one that never moves, for a parameter outside its domain, and
    where the path runs along `up`.
    Source: Wang, Jüttler, Zheng, Liu 2008, sections 4 and 6.1; Richardson's extrapolation of the step angles is ours.

    >>> path = BSpline([[0, 0, 0], [2, 0, 0], [3, 1, 0], [3, 3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> f = frames(path, [0.0, 0.5, 1.0])
    >>> np.stack([f.tangents[-1], f.normals[-1], f.binormals[-1]]).round(12) + 0.0
    array([[ 0.,  1.,  0.], [-1.,  0.,  0.], [ 0.,  0.,  1.]])
    """
    path = lifted(spline)
    wanted = np.asarray(parameters, dtype=np.float64).reshape(-1)
    if np.isnan(wanted).any():
        raise ValueError("parameters must be numbers, not NaN")
    u = np.concatenate([path.distinct_knots, wanted])
    u.sort(kind="stable")
    u = u[np.concatenate([[True], u[1:] > u[:-1]])]
    # Between two of these stations the path is one cubic, given by its ends and its Bézier handles there.
    points, velocities = np.ascontiguousarray(path(u).T), np.ascontiguousarray(path.derivative(u).T)
    thirds = (u[1:] - u[:-1]) / 3.0
    leaving, arriving = thirds * velocities[:, :-1], thirds * velocities[:, 1:]
    chords = points[:, 1:] - points[:, :-1]
    tops = 0.5 * chords - 0.25 * (leaving + arriving)  # a third of the velocity halfway, as the handles are at the ends
    lengths = running(np.add, 0.0, 0.5 * (norms(leaving) + norms(arriving)) + 2.0 * norms(tops))

    directions = np.concatenate([leaving, arriving[:, -1:]], axis=1)
    bulge = 0.375 * (leaving - arriving)  # of the halfway point over the middle of the chord
    halves = 0.5 * chords + bulge, 0.5 * chords - bulge
    speeds = norms(directions)
    if speeds.min() <= SLOW * speeds.max():
        directions = limits(leaving, arriving, chords, points)
        speeds = norms(directions)
        # A chord hardly longer than its rounding has no direction to reflect in, nor a way through the middle.
        short = norms(chords) <= 1e3 * _NOISE * np.abs(points).max()
        chords[:, short] = tops[:, short] = 0.0
    psi, squares = spinors(directions, speeds)
    middle, _ = spinors(tops, norms(tops))
    start, end = psi[:, :-1], psi[:, 1:]
    whole = carried(start, chords, end)
    twice = _reflected(start, halves[0], middle) * _reflected(middle, halves[1], end)
    twice = np.where(twice == 0.0, whole, twice)
    # One step's phase is off by c h^5, that of two half steps by c h^5 / 16: Richardson gives 16 / 15 of the one less
    # 1 / 15 of the other, which for phases as near as these is the direction of this sum.
    twice /= np.abs(twice)
    whole /= np.abs(whole)
    tangents = directions / speeds
    bends = tangents[:, 1:] - tangents[:, :-1]
    error = 2.0 / 15.0 * float(np.einsum("n,dn,dn->", np.abs(twice - whole), bends, bends))
    phases = transported(psi, 16.0 * twice - whole)
    angle = 0.0
    if path.closed and norms(tangents[:, :1] - tangents[:, -1:]) <= SMOOTH:
        angle = holonomy(psi, phases)
        phases *= np.exp(1j * angle / lengths[-1] * lengths)
    a, c = psi
    across = np.stack([a * a - c * c, 1j * (a * a + c * c), -2.0 * a * c]) * (phases / squares)
    at = np.searchsorted(u, wanted)
    origins, along, normals, binormals = (rows.T[at] for rows in (points, tangents, across.real, across.imag))
    found = Frames(origins, along, normals, binormals, lengths[at], angle, error)
    return found if up is None else upright(found, up, wanted)


def upright(along: Frames, up: ArrayLike, parameters: Array) -> Frames:
    """Return frames turned about their tangents so that every binormal lies in a plane with `up`, on its side.

    Raises ValueError where a tangent is along `up`, with its parameter (`parameters` (n,) are those of the frames).

    >>> path = BSpline([[0, 0, 0], [0, 1, 0], [0, 2, 0], [0, 3, 3]], [0, 0, 0, 0, 1, 1, 1, 1])
    >>> upright(frames(path, [0.0]), [1, 0, 9], np.zeros(1)).binormals.round(3) + 0.0
    array([[0.11 , 0.   , 0.994]])
    """
    axis = np.asarray(up, dtype=np.float64)
    if axis.shape != (3,) or not np.isfinite(axis).all() or not axis.any():
        raise ValueError(
            f"`up` must be a vector of three finite numbers, not all zero, and not {np.asarray(up).tolist()}"
        )
    axis = axis / np.linalg.norm(axis)
    normals = np.cross(axis, along.tangents)
    sizes = np.linalg.norm(normals, axis=1)
    if sizes.size and sizes.min() < _LEVEL:
        worst = int(np.argmin(sizes))
        x, y, z = along.origins[worst]
        raise ValueError(
            f"the path runs along `up` at the parameter {parameters[worst]:g}, near ({x:g}, {y:g}, {z:g}): "
            "no side of it is up there"
        )
    normals /= sizes[:, None]
    binormals = np.cross(along.tangents, normals)
    return Frames(along.origins, along.tangents, normals, binormals, along.lengths)


def lifted(spline: BSpline) -> BSpline:
    """Return the path in three dimensions: a 2D spline is laid in z = 0.

    Raises TypeError for anything but a BSpline, ValueError for another dimension.

    >>> lifted(BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])).poles[1]
    array([1., 1., 0.])
    """
    if not isinstance(spline, BSpline):
        raise TypeError(f"the path must be a cadfit.BSpline, not {type(spline).__name__}")
    d = spline.poles.shape[1]
    if d not in (2, 3):
        raise ValueError(f"the path must have 2 or 3 dimensions, not {d}")
    return spline if d == 3 else spline.transformed(np.eye(3, 2))


def norms(vectors: Array) -> Array:
    """Return the lengths (n,) of vectors (3, n)."""
    return np.asarray(np.sqrt(np.einsum("dn,dn->n", vectors, vectors)))


def running(combine: np.ufunc, first: complex, steps: NDArray[Any]) -> NDArray[Any]:
    """Return the running sum or product of the steps, with its first value before them.

    >>> running(np.add, 1.0, np.array([2.0, 3.0]))
    array([1., 3., 6.])
    """
    out = np.empty(len(steps) + 1, dtype=steps.dtype)
    out[0] = first
    out[1:] = steps
    combine.accumulate(out, out=out)
    return out


def spinors(directions: Array, sizes: Array | float) -> tuple[Complex, Array]:
    """Return a spinor (2, n) along each direction (3, n) of the given size, and the squares (n,) of their lengths.

    A spinor's own length and phase are arbitrary. Of the two usual forms the one that does not vanish near its own
    pole is taken.
    """
    tall: Array = sizes + np.abs(directions[2])
    psi = np.empty((2, directions.shape[1]), dtype=np.complex128)
    psi[0] = tall
    psi.real[1], psi.imag[1] = directions[:2]
    down = directions[2] < 0.0
    if down.any():
        np.copyto(psi, psi[::-1].conj(), where=down)
    return psi, 2.0 * sizes * tall


def carried(start: Complex, along: Array, end: Complex) -> Complex:
    """Return numbers (m,), never zero, whose phases are those of the steps from spinors to the next, along chords.

    Where there is nothing to reflect in (a chord of no length, a tangent that turns straight back) the spinor is
    carried along the great circle.
    """
    out = _reflected(start, along, end)
    if not out.all():
        direct = np.einsum("kn,kn->n", end.conj(), start)
        direct[direct == 0.0] = 1.0
        out = np.where(out == 0.0, direct, out)
    return out


def _reflected(start: Complex, along: Array, end: Complex) -> Complex:
    """Return <end, (along . sigma) start> (m,): double reflection along a chord."""
    flat = np.empty(along.shape[1], dtype=np.complex128)
    flat.real, flat.imag = along[:2]
    back = end.conj()
    out: Complex = back[0] * start[0]
    out -= back[1] * start[1]
    out *= along[2]
    back *= start[::-1]
    back[1] *= flat
    back[0] *= flat.conj()
    out += back[0]
    out += back[1]
    return out


def transported(psi: Complex, steps: Complex) -> Complex:
    """Return the factors (n,) of length 1 that turn the frame of each spinor into the transported one.

    `steps` (n - 1,) are numbers with the phases of the steps. The first normal is horizontal (see `frames`).
    """
    a, c = psi[:, 0].tolist()
    up = -2.0 * a * c  # normal + i binormal, upward
    if abs(up) < 0.4 * (abs(a) ** 2 + abs(c) ** 2):
        up = 1j * (a * a + c * c)
    return running(np.multiply, 1j * abs(up) / up, steps / steps.conj())


def holonomy(psi: Complex, factors: Complex) -> float:
    """Return the angle, about the tangent, by which the last frame is short of the first; their tangents are one."""
    seam = complex(np.vdot(psi[:, 0], psi[:, -1]))
    return -float(np.angle(factors[-1] / factors[0] * seam * seam))


def limits(leaving: Array, arriving: Array, chords: Array, points: Array) -> Array:
    """Return the directions (3, m + 1) of the ends of Bézier pieces, the limit where the path stands still.

    `leaving` and `arriving` (3, m) are the handles, P1 - P0 and P3 - P2 of each piece, `chords` P3 - P0, `points`
    (3, m + 1) the ends. The direction in which a piece leaves its start is that of the first pole that is not there,
    the second, the third or the last. An end whose next piece is one point has the direction in which the path
    arrives, and where that is a point as well, that of the end before it, or of the first to have one.
    """
    noise = _NOISE * np.abs(points).max()
    out = np.zeros_like(points)
    out[:, 1:] = first_moving(arriving, chords - leaving, chords, noise)
    ahead = first_moving(leaving, chords - arriving, chords, noise)
    np.copyto(out[:, :-1], ahead, where=ahead.any(axis=0))
    known = out.any(axis=0)
    if not known.any():
        raise ValueError("the path never moves: all its poles are one point")
    last = np.maximum.accumulate(np.where(known, np.arange(len(out.T)), np.argmax(known)))
    return np.asarray(out[:, last])


def first_moving(first: Array, second: Array, third: Array, noise: float = 0.0) -> Array:
    """Return the first of three vectors that is not zero up to rounding, of each n of them; zero when all are noise.

    >>> first_moving(np.zeros((3, 1)), np.array([[1e-20], [0], [0]]), np.array([[0], [2.0], [0]])).ravel()
    array([0., 2., 0.])
    """
    vectors = np.stack([first, second, third])
    sizes = np.sqrt(np.einsum("kdn,kdn->kn", vectors, vectors))
    longest = sizes.max(axis=0)
    moving = (sizes > 1e-12 * longest) & (longest > noise)
    chosen = vectors[moving.argmax(axis=0), :, np.arange(first.shape[1])].T
    return np.where(moving.any(axis=0), chosen, 0.0)
