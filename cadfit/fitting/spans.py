"""Cubic splines span by span, as the fit uses them: rows of coordinates, open or periodic, no checks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.bspline import BSpline, own
from cadfit.joining import periodic


def shifted(row: Array, k: int) -> Array:
    """Return the values (..., n) moved on by k places, those of the end to the start; quicker than `np.roll`."""
    return np.concatenate([row[..., -k:], row[..., :-k]], axis=-1)


def dot(a: Array, b: Array) -> Array:
    """Return the inner products (n,) of vectors (d, n); for a few rows quicker than `np.einsum`."""
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total += a[k] * b[k]
    return np.asarray(total)


# A span's `Spans.matrices` are sums of six products of two lengths over two others, each between two of the knots t0 to
# t7 around, the span running from t3 to t4: h h / (t42 t41), h h / (t63 t53), g g / (t42 t52), h g / (t42 t52),
# h h / (t42 t52) and h h / (t53 t52), with h = t43, g = t32 and t42 = t4 - t2.
_LATER = np.array([4, 4, 3, 4, 4, 4, 4, 4, 3, 3, 4, 4, 4, 6, 4, 4, 4, 5, 4, 5, 5, 5, 5, 5])
_EARLIER = np.array([3, 3, 2, 3, 3, 3, 3, 3, 2, 2, 3, 3, 2, 3, 2, 2, 2, 3, 1, 3, 2, 2, 2, 2])
_PARTS = np.zeros((6, 16))  # how much of each goes into the matrix (4 powers, 4 functions), row after row
_PARTS[0, [0, 4, 8, 12]], _PARTS[0, [1, 5, 9, 13]] = [1.0, -3.0, 3.0, -1.0], [-1.0, 3.0, -3.0, 1.0]
_PARTS[1, [14, 15]] = [-1.0, 1.0]
_PARTS[2, [1, 2]] = [-1.0, 1.0]
_PARTS[3, [5, 6]] = [-3.0, 3.0]
_PARTS[4, [9, 10, 13, 14]] = [-3.0, 3.0, 1.0, -1.0]
_PARTS[5, [13, 14]] = [1.0, -1.0]
_WHOLE = np.eye(16)[1]  # in all, the functions are 1


@dataclass(frozen=True, eq=False)
class Spans:
    """The space of C2 cubic splines with simple knots (m + 1,), the curve's start and end included.

    Open splines are clamped: m + 3 poles. Closed ones are periodic, knots[-1] - knots[0] being the period: m poles,
    span s depending on poles s to s + 3 (modulo m), its parameters those from knots[s] on.
    """

    knots: Array
    closed: bool

    @property
    def count(self) -> int:
        """The number of spans m."""
        return len(self.knots) - 1

    @property
    def poles(self) -> int:
        """The number of poles that are free to choose: m + 3, closed m."""
        return self.count if self.closed else self.count + 3

    @cached_property
    def extended(self) -> Array:
        """The knots with three more at each end (m + 7,): repeated, or those of the neighbouring periods."""
        knots, m = self.knots, self.count
        if not self.closed:
            return np.concatenate([knots[[0, 0, 0]], knots, knots[[-1, -1, -1]]])
        steps = np.arange(-3, m + 4)
        return np.asarray(knots[steps % m] + (knots[-1] - knots[0]) * (steps // m))

    @cached_property
    def steps(self) -> Array:
        """The lengths of the spans (m,)."""
        return self.knots[1:] - self.knots[:-1]

    @cached_property
    def matrices(self) -> Array:
        """The basis functions (m, 4 powers, 4 functions) of each span as polynomials of its local parameter in [0, 1].

        Source: Qin, General matrix representations for B-splines, The Visual Computer 16, 2000.
        """
        at = np.arange(self.count)[:, None]
        lengths = self.extended[at + _LATER] - self.extended[at + _EARLIER]
        one, other, below, beside = (lengths[:, k : k + 6] for k in range(0, 24, 6))
        return np.asarray((one * other / (below * beside)) @ _PARTS + _WHOLE).reshape(-1, 4, 4)

    def find(self, u: Array) -> Ints:
        """Return the span (n,) of each parameter u (n,); where closed, span m is span 0 of the next period."""
        found = self.knots.searchsorted(u, side="right") - 1
        return np.minimum(found, self.count if self.closed else self.count - 1, out=found)

    def local(self, u: Array, span: Ints) -> tuple[Array, Ints]:
        """Return the local parameters (n,) of u in its spans, and the spans modulo m."""
        wrapped = span % self.count if self.closed else span
        return (u - self.knots.take(span)) / self.steps.take(wrapped), wrapped

    def spline(self, poles: Array) -> BSpline:
        """Return the curve of the poles (d, number of poles)."""
        if not self.closed:
            return BSpline(own(np.ascontiguousarray(poles.T)), own(self.extended.copy()))
        return periodic(np.roll(poles.T, -1, axis=0), self.knots)


@dataclass(frozen=True, eq=False)
class Curve:
    """A spline of the space with its poles (d, number of poles), for many evaluations."""

    spans: Spans
    poles: Array

    @cached_property
    def around(self) -> Array:
        """The poles (m, 4, d) that each span depends on."""
        m = self.spans.count
        poles = np.concatenate([self.poles, self.poles[:, :3]], axis=1) if self.spans.closed else self.poles
        while poles.shape[1] < m + 3:  # fewer than three spans in a period
            poles = np.concatenate([poles, self.poles], axis=1)
        four = np.empty((m, 4, len(poles)))
        for k in range(4):
            four[:, k] = poles[:, k : k + m].T
        return four

    @cached_property
    def powers(self) -> Array:
        """The spans' polynomials (4 powers, d, m) of the local parameter."""
        return np.ascontiguousarray((self.spans.matrices @ self.around).transpose(1, 2, 0))

    @cached_property
    def third_jumps(self) -> Array:
        """The jumps of the third derivative at the inner knots (d, m - 1), closed at the starts of spans (d, m)."""
        third = 6.0 * self.powers[3] / self.spans.steps**3
        if self.spans.closed:
            return np.asarray(third - shifted(third, 1))
        return np.diff(third, axis=1)

    def backward(self) -> Curve:
        """Return the curve run through backward, its parameters negated."""
        m, k = self.spans.count, self.poles.shape[1]
        poles = self.poles[:, (m + 2 - np.arange(k)) % k]
        return Curve(Spans(-self.spans.knots[::-1], self.spans.closed), np.ascontiguousarray(poles))

    def from_span(self, k: int) -> Curve:
        """Return the closed curve with its span k as the first."""
        knots = self.spans.knots
        period = knots[-1] - knots[0]
        turned = np.concatenate([knots[k:-1], knots[:k] + period, knots[k : k + 1] + period])
        return Curve(Spans(turned, True), np.roll(self.poles, -k, axis=1))

    def with_knot(self, u: float) -> Curve:
        """Return the closed curve, of four spans or more, with one more knot, in its first span."""
        t, poles = self.spans.extended, self.poles
        share = (u - t[1:4]) / (t[4:7] - t[1:4])
        between = poles[:, :3] + share * (poles[:, 1:4] - poles[:, :3])
        knots = np.insert(self.spans.knots, 1, u)
        return Curve(Spans(knots, True), np.concatenate([poles[:, :1], between, poles[:, 3:]], axis=1))

    def points(self, u: Array, span: Ints) -> Array:
        """Return the points (d, n) at u (n,) in the given spans (n,)."""
        x, wrapped = self.spans.local(u, span)
        a, b, c, e = self.powers[:, :, wrapped]
        return np.asarray(((e * x + c) * x + b) * x + a)
