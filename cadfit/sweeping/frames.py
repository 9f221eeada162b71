"""Rotation-minimizing frames along a path, by double reflection.

Source: Wang, Jüttler, Zheng, Liu, Computation of rotation minimizing frames, ACM Transactions on Graphics 27(1), 2008.

Two reflections make a rotation, and a rotation acts on a spinor by one small product, which is what is computed here.
A tangent t is written as a spinor, two complex numbers psi with psi^H sigma psi along t; a phase e^(i a) on psi turns
the frame about t by -2 a, so a spinor is a tangent together with a normal. The paper's double reflection along the
chord v carries psi to a multiple of psi' with the phase of <psi', (v . sigma) psi>: its second reflection only brings
in (t' . sigma), which psi' absorbs. So a step's turn can be read off that number whatever phases the two spinors were
given, all steps are independent, and a cumulative product joins them.
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
_SLOW = 1e-9  # of the largest handle: a shorter one is looked at closely, for it may have no direction


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Frames at n stations of a path: `origins`, `tangents`, `normals`, `binormals`, (n, 3) each, read-only.

    Tangent, normal and binormal are right-handed unit vectors. `lengths` (n,) is the arc length from the path's start
    (Simpson's rule from station to station). `holonomy` is the angle in radians by which the transported normal of a
    closed path missed its start, counted about the tangent; it has been spread over the frames, so that the seam
    closes. It is 0.0 on an open path.
    """

    origins: Array
    tangents: Array
    normals: Array
    binormals: Array
    lengths: Array
    holonomy: float = 0.0

    def __post_init__(self) -> None:
        for name in ("origins", "tangents", "normals", "binormals", "lengths"):
            values = getattr(self, name).view()
            values.flags.writeable = False
            object.__setattr__(self, name, values)

    def __len__(self) -> int:
        return len(self.lengths)


def frames(spline: BSpline, parameters: ArrayLike) -> Frames:
    """Return the rotation-minimizing frames of a path at the given parameters (n,), in any order.

    `spline` has 2 or 3 dimensions (2D lies in z = 0). The frames turn about the tangent as little as the path's bending
    allows, from a first normal that is horizontal (its binormal points up, toward +z; where the path starts near the
    vertical, toward +y). They are transported through every knot of the path as well as the parameters, each step
    also as two half steps, whose difference takes the error from fourth to sixth order. On a closed path with
    one tangent at the seam the angle left over, `Frames.holonomy`, is spread evenly along the arc length.

    Where the path stands still (a cusp, repeated poles) the tangent is the direction in which it leaves, at the very
    end that in which it arrives. At a corner it is the tangent after the corner. Where the tangent turns straight
    back, every normal is as good as another, and the one given depends on rounding.

    Raises ValueError for a path of another dimension, for one that never moves, and for a parameter outside its domain.
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
    handles = path.derivative(u)
    thirds = np.diff(u)[:, None] / 3.0
    every = transport(path(u), thirds * handles[:-1], thirds * handles[1:], path.closed)
    at = np.searchsorted(u, wanted)
    axes = (every.tangents[at], every.normals[at], every.binormals[at])
    return Frames(every.origins[at], *axes, every.lengths[at], every.holonomy)


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


def transport(origins: Array, leaving: Array, arriving: Array, closed: bool) -> Frames:
    """Return the rotation-minimizing frames of a chain of Bézier pieces at the m + 1 ends of its pieces.

    `origins` (m + 1, 3) are the ends, `leaving` and `arriving` (m, 3) the handles, P1 - P0 and P3 - P2 of each piece;
    `closed` when the chain returns to its start. See `frames` for the rest.

    >>> ends, handle = np.array([[0.0, 0, 0], [3, 0, 0]]), np.array([[1.0, 0, 0]])
    >>> transport(ends, handle, handle, closed=False).lengths
    array([0., 3.])
    """
    m = len(leaving)
    chords = origins[1:] - origins[:-1]
    tops = 0.5 * chords - 0.25 * (leaving + arriving)  # a third of the velocity halfway, as the handles are at the ends
    directions = np.concatenate([leaving, arriving[-1:], tops, arriving])
    speeds = np.sqrt(np.einsum("nd,nd->n", directions, directions))
    lengths = _running(np.add, 0.0, 0.5 * (speeds[:m] + speeds[2 * m + 1 :]) + 2.0 * speeds[m + 1 : 2 * m + 1])
    directions, speeds = directions[: 2 * m + 1], speeds[: 2 * m + 1]
    if speeds[: m + 1].min() <= _SLOW * speeds.max():
        noise = 64.0 * np.finfo(np.float64).eps * np.abs(origins).max()
        directions[: m + 1] = _limits(leaving, arriving, chords, noise)
        # A chord hardly longer than its rounding has no direction to reflect in: no way through the middle there.
        directions[m + 1 :][np.linalg.norm(chords, axis=1) <= 1e3 * noise] = 0.0
        speeds = np.sqrt(np.einsum("nd,nd->n", directions, directions))

    psi = _spinors(directions, speeds)
    starts, middles, ends = psi[:, :m], psi[:, m + 1 :], psi[:, 1 : m + 1]
    bulge = 0.375 * (leaving - arriving)  # of the halfway point over the middle of the chord
    carried = _carried(
        np.concatenate([starts, middles, starts], axis=1),
        np.concatenate([0.5 * chords + bulge, 0.5 * chords - bulge, chords]),
        np.concatenate([middles, ends, ends], axis=1),
    ).reshape(3, m)
    phases = _running(np.multiply, 1.0, _extrapolated(carried, starts, ends))

    tangents = directions[: m + 1] / speeds[: m + 1, None]
    normals = _normals(psi[:, : m + 1], phases)
    up = 2 if abs(tangents[0, 2]) < 0.9 else 1
    normals *= 1j * normals[0, up].conj() / abs(normals[0, up])
    holonomy = 0.0
    if closed and np.linalg.norm(tangents[0] - tangents[-1]) <= SMOOTH:
        holonomy = -float(np.angle(np.vdot(normals[0], normals[-1])))
        normals *= np.exp(1j * holonomy / lengths[-1] * lengths)[:, None]
    return Frames(origins, tangents, normals.real, normals.imag, lengths, holonomy)


def _running(combine: np.ufunc, first: float, steps: NDArray[Any]) -> NDArray[Any]:
    """Return the running sum or product of the steps, with its first value before them."""
    out = np.empty(len(steps) + 1, dtype=steps.dtype)
    out[0] = first
    combine.accumulate(steps, out=out[1:])
    return out


def _spinors(directions: Array, speeds: Array) -> Complex:
    """Return a spinor (2, n) along each direction (n, 3) of the given length; its own length and phase are arbitrary.

    Of the two usual forms the one that does not vanish near its own pole is taken.
    """
    flat = directions[:, 0] + 1j * directions[:, 1]
    tall = speeds + np.abs(directions[:, 2])
    up = directions[:, 2] >= 0.0
    psi = np.empty((2, len(speeds)), dtype=np.complex128)
    psi[0] = np.where(up, tall, flat.conj())
    psi[1] = np.where(up, flat, tall)
    return psi


def _carried(start: Complex, along: Array, end: Complex) -> Complex:
    """Return <end, (along . sigma) start> (n,): double reflection along a chord, its turn the number's phase."""
    flat, rise = along[:, 0] + 1j * along[:, 1], along[:, 2]
    upper = rise * start[0] + flat.conj() * start[1]
    lower = flat * start[0] - rise * start[1]
    return np.asarray(end[0].conj() * upper + end[1].conj() * lower)


def _extrapolated(carried: Complex, start: Complex, end: Complex) -> Complex:
    """Return each step's phase (m,), as a number of length 1, from `carried` (3, m): two half steps and a whole one.

    One step's phase is off by c h^5, that of two half steps by c h^5 / 16: Richardson gives 16 / 15 of the one less
    1 / 15 of the other, which for phases as near as these is the direction of this sum. Where there is nothing to
    reflect in (a step of no length, a tangent that turns straight back) the spinor is carried along the great circle.
    """
    sizes = np.abs(carried)
    if sizes.min() == 0.0:
        flat = sizes.min(axis=0) == 0.0
        direct = np.einsum("kn,kn->n", end.conj(), start)
        direct[direct == 0.0] = 1.0
        carried = np.where(flat, np.stack([direct, np.ones_like(direct), direct]), carried)
        sizes = np.abs(carried)
    first, second, whole = carried / sizes
    phases: Complex = 16.0 * first * second - whole
    phases /= np.abs(phases)
    return phases


def _normals(psi: Complex, phases: Complex) -> Complex:
    """Return normal + i binormal (n, 3), unit vectors, of spinors (2, n) turned by the phases."""
    sizes = psi.real**2 + psi.imag**2
    turned = psi * (phases * phases / (sizes[0] + sizes[1]))
    out = np.empty((len(phases), 3), dtype=np.complex128)
    a2, c2 = turned * psi
    out[:, 0] = a2 - c2
    out[:, 1] = 1j * (a2 + c2)
    out[:, 2] = -2.0 * turned[0] * psi[1]
    return out


def _limits(leaving: Array, arriving: Array, chords: Array, noise: float) -> Array:
    """Return the directions (m + 1, 3) of the ends of pieces, the limit where the path stands still.

    The direction in which a Bézier piece leaves its start is that of the first pole that is not there, the second, the
    third or the last. An end whose next piece is one point has the direction in which the path arrives, and where
    that is a point as well, that of the end before it, or of the first to have one.
    """
    out = np.concatenate([np.zeros((1, 3)), _first_moving(arriving, chords - leaving, chords, noise)])
    ahead = _first_moving(leaving, chords - arriving, chords, noise)
    moves = ahead.any(axis=1)
    out[:-1][moves] = ahead[moves]
    known = out.any(axis=1)
    if not known.any():
        raise ValueError("the path never moves: all its poles are one point")
    last = np.maximum.accumulate(np.where(known, np.arange(len(out)), np.argmax(known)))
    return np.asarray(out[last])


def _first_moving(first: Array, second: Array, third: Array, noise: float) -> Array:
    """Return for each row the first of the three vectors that is not zero, up to rounding; zero when all are noise."""
    vectors = np.stack([first, second, third])
    sizes = np.linalg.norm(vectors, axis=2)
    longest = sizes.max(axis=0)
    moving = (sizes > 1e-12 * longest) & (longest > noise)
    return np.where(moving.any(axis=0)[:, None], vectors[moving.argmax(axis=0), np.arange(len(first))], 0.0)
