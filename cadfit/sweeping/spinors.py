"""Frames as spinors, and double reflection by them.

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

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cadfit.bezier import Array

Complex = NDArray[np.complex128]


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
    out = reflected(start, along, end)
    if not out.all():
        direct = np.einsum("kn,kn->n", end.conj(), start)
        direct[direct == 0.0] = 1.0
        out = np.where(out == 0.0, direct, out)
    return out


def reflected(start: Complex, along: Array, end: Complex) -> Complex:
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

    `steps` (n - 1,) are numbers with the phases of the steps. The first normal is horizontal: see `level`.
    """
    return running(np.multiply, level(psi[:, 0]), steps / steps.conj())


def level(psi: Complex) -> complex:
    """Return the factor of length 1 that makes the normal of a spinor (2,) horizontal, and its binormal point upward.

    Upward is toward +z; where the tangent is near the vertical, toward +y.
    """
    a, c = complex(psi[0]), complex(psi[1])
    up = -2.0 * a * c  # normal + i binormal, upward
    if abs(up) < 0.4 * (abs(a) ** 2 + abs(c) ** 2):
        up = 1j * (a * a + c * c)
    return 1j * abs(up) / up


def renamed(old: Complex, new: Complex) -> complex:
    """Return what a spinor's factor is to be multiplied by when a new spinor (2,) for the same tangent takes its place.

    >>> renamed(np.array([1j, 0.0]), np.array([1.0 + 0j, 0.0]))
    (-1+0j)
    """
    phase = complex(np.vdot(new, old))
    return phase / phase.conjugate()


def across(psi: Complex, scales: Complex) -> tuple[Array, Array]:
    """Return the normals and the binormals (3, n) given by spinors (2, n) and factors (n,) on their squares.

    >>> across(np.array([[1.0 + 0j], [0.0]]), np.array([1.0 + 0j]))[0].ravel() + 0.0
    array([1., 0., 0.])
    """
    a, c = psi
    scaled = scales * psi
    first, second = scaled[0] * a, scaled[1] * c
    sums, both = first + second, scaled[0] * c
    first -= second
    both *= -2.0
    return np.stack([first.real, -sums.imag, both.real]), np.stack([first.imag, sums.real, both.imag])


def turned(normals: Array, binormals: Array, angles: Array) -> tuple[Array, Array]:
    """Return normals and binormals (3, n) with the phases of normal + i binormal moved on by angles (n,)."""
    cos, sin = np.cos(angles), np.sin(angles)
    return cos * normals - sin * binormals, cos * binormals + sin * normals
