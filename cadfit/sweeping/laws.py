"""What varies along a path (a radius, a scale, a twist), as a cubic spline of the path's parameter.

Numbers, splines, functions, and values at points all become one `BSpline` with one coordinate over the path's domain.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cadfit.bezier import Array
from cadfit.bspline import BSpline

Law = float | BSpline | ArrayLike | Callable[[Array], ArrayLike]

_DEEPEST = 24  # halvings of the domain: a function that needs more jumps
_FIRST = 16  # pieces that a function is given from the start, so that none of its bumps is stepped over


def law_of(
    value: Any, domain: tuple[float, float], name: str, accuracy: float, at: Array | None = None, closed: bool = False
) -> BSpline:
    """Return what varies along a path as a spline of its parameter, with one coordinate.

    `value`: a number; a `BSpline` with one coordinate over the same domain; a function from parameters (n,) to values
    (n,); values (n,) at the parameters `at`; or parameters and values in rows (n, 2). Values are joined by monotone
    cubics (no overshoot), and held beyond the first and the last, or with `closed` joined across the seam. A function
    is followed to `accuracy`.

    Raises TypeError or ValueError saying what is wrong with which value.

    >>> law_of([[0.0, 1.0], [2.0, 3.0]], (0.0, 2.0), "radius", 1e-6)(1.0)
    array([2.])
    """
    if isinstance(value, BSpline):
        law = _same_domain(value, domain, name)
    elif callable(value):
        law = _followed(value, domain, name, accuracy)
    else:
        values = _numbers(value, name)
        law = _constant(float(values), domain) if values.ndim == 0 else _through(values, domain, name, at, closed)
    return law


def is_number(value: Any) -> bool:
    """Return whether a law is given as one number, or as what was meant for one."""
    return not callable(value) and not isinstance(value, BSpline) and np.ndim(value) == 0


def largest(law: BSpline) -> float:
    """Return the largest value of a law.

    >>> largest(BSpline([[0.0], [1.0], [1.0], [0.0]], [0, 0, 0, 0, 1, 1, 1, 1]))
    0.75
    """
    return float(_turning_values(law).max())


def smallest(law: BSpline) -> float:
    """Return the smallest value of a law."""
    return float(_turning_values(law).min())


def _turning_values(law: BSpline) -> Array:
    """Return the values of a law where it may be the largest or the smallest: at its knots and where its slope is zero.

    The poles of its pieces would be bounds, but refuse a radius whose values are well above zero.
    """
    pieces = law.pieces()[:, :, 0]
    first, second, third = np.diff(pieces, axis=1).T  # the slope's poles
    half, square = second - first, first - 2.0 * second + third
    root = np.sqrt(np.maximum(half * half - square * first, 0.0))
    far = -(half + np.where(half < 0.0, -root, root))  # no digits are lost by this sum, nor by either root from it
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.stack([far / square, first / far])
    which, rows = np.nonzero((t > 0.0) & (t < 1.0))
    t = t[which, rows][:, None]
    powers = np.hstack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t * t, t**3])
    return np.concatenate([pieces[:, 0], pieces[-1:, 3], np.einsum("nk,nk->n", powers, pieces[rows])])


def is_constant(law: BSpline) -> bool:
    """Return whether a law has one value."""
    return bool(np.ptp(law.poles) == 0.0)


def _numbers(value: Any, name: str) -> Array:
    try:
        values = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise TypeError(f"the {name} must be a number, not {value!r}") from None
    if not np.isfinite(values).all():
        where = np.argwhere(~np.isfinite(values))[0].tolist() if values.ndim else []
        raise ValueError(f"the {name} must be finite, not {values[tuple(where)]:g}" + (f" at {where}" if where else ""))
    return values


def _constant(value: float, domain: tuple[float, float]) -> BSpline:
    return BSpline(np.full((4, 1), value), np.repeat(domain, 4))


def _same_domain(law: BSpline, domain: tuple[float, float], name: str) -> BSpline:
    if law.poles.shape[1] != 1:
        raise ValueError(f"the {name}'s spline must have 1 coordinate, not {law.poles.shape[1]}")
    if not np.allclose(law.domain, domain, rtol=1e-12, atol=1e-12 * (domain[1] - domain[0])):
        raise ValueError(f"the {name}'s spline runs over {law.domain}, the path over {domain}")
    return law


def _through(values: Array, domain: tuple[float, float], name: str, at: Array | None, closed: bool) -> BSpline:
    """Return the monotone cubics through values at parameters."""
    from scipy.interpolate import PchipInterpolator

    if values.ndim == 2 and values.shape[1] == 2:
        at, values = values.T
    elif values.ndim != 1:
        raise ValueError(
            f"the {name} must be a number, (n,) values or (n, 2) parameters and values, not {values.shape}"
        )
    elif at is None:
        raise ValueError(
            f"at which parameters are these {len(values)} values of the {name}? Give rows (parameter, value)"
        )
    if len(at) != len(values):
        raise ValueError(f"{len(values)} values of the {name} for {len(at)} points")
    if not len(values):
        raise ValueError(f"no values of the {name} are given")
    low, high = domain
    order = np.argsort(at, kind="stable")
    at, values = at[order], values[order]
    keep = np.concatenate([[True], np.diff(at) > 0.0])
    at, values = at[keep], values[keep]
    if at[0] < low or at[-1] > high:
        raise ValueError(f"the {name} is given from {at[0]:g} to {at[-1]:g}, the path runs from {low:g} to {high:g}")
    if closed and (at[0] > low or at[-1] < high):
        seam = np.interp(high, [at[-1], at[0] + high - low], [values[-1], values[0]])
        inner = (at > low) & (at < high)
        at, values = np.array([low, *at[inner], high]), np.array([seam, *values[inner], seam])
    if at[0] > low:
        at, values = np.append(low, at), np.append(values[0], values)
    if at[-1] < high:
        at, values = np.append(at, high), np.append(values, values[-1])
    slopes = PchipInterpolator(at, values)(at, 1)
    steps = np.diff(at)
    pieces = np.stack(
        [values[:-1], values[:-1] + slopes[:-1] * steps / 3, values[1:] - slopes[1:] * steps / 3, values[1:]], axis=1
    )
    return _of_pieces(pieces, at)


def _followed(
    function: Callable[[Array], ArrayLike], domain: tuple[float, float], name: str, accuracy: float
) -> BSpline:
    """Return cubics that meet a function at thirds of ever smaller pieces, until it is met between as well."""

    def values(u: Array) -> Array:
        found = _numbers(function(u), f"{name} that the function gives")
        if found.shape not in ((), u.shape):
            raise ValueError(f"the {name}'s function gives {found.shape} for parameters {u.shape}")
        return np.broadcast_to(found, u.shape)

    todo = np.linspace(*domain, _FIRST + 1)
    starts, widths = todo[:-1], np.diff(todo)
    done: list[tuple[Array, Array]] = []
    for _ in range(_DEEPEST):
        sixths = values((starts[:, None] + widths[:, None] * np.arange(7) / 6).ravel()).reshape(-1, 7)
        a, b, c, d = sixths[:, ::2].T
        pieces = np.stack([a, (-5 * a + 18 * b - 9 * c + 2 * d) / 6, (2 * a - 9 * b + 18 * c - 5 * d) / 6, d], axis=1)
        t = np.array([1, 3, 5])[:, None] / 6
        between = pieces @ np.hstack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t * t, t**3]).T
        met = np.abs(between - sixths[:, 1::2]).max(axis=1) <= accuracy
        done.append((starts[met], pieces[met]))
        if met.all():
            break
        widths = np.tile(0.5 * widths[~met], 2)
        starts = np.concatenate([starts[~met], starts[~met] + widths[: len(widths) // 2]])
    else:
        raise ValueError(f"the {name} jumps at the parameter {starts[~met][0]:.9g}")
    at, pieces = (np.concatenate(each) for each in zip(*done, strict=True))
    order = np.argsort(at)
    at, pieces = at[order], pieces[order]
    pieces[1:, 0] = pieces[:-1, 3]
    return _of_pieces(pieces, np.append(at, domain[1]))


def _of_pieces(pieces: Array, at: Array) -> BSpline:
    """Return cubic pieces (m, 4) between parameters (m + 1,) as one spline with triple knots."""
    poles = np.append(pieces[:, :3], pieces[-1, 3])
    return BSpline(poles[:, None], np.concatenate([at[:1], np.repeat(at, 3), at[-1:]]))
