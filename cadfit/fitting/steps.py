"""One step of least squares: the poles, or poles and knots, that bring a curve nearer to what it is held to."""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array
from cadfit.fitting.feet import Look, Place
from cadfit.fitting.spans import Curve, Spans, dot, shifted
from cadfit.fitting.squares import band, for_all, local, moments, solve, solve_alike
from cadfit.fitting.targets import Targets

_ALONG = 0.005  # weight of a residual's part along the curve: a foot point slides there
_DAMPING = 1e-6  # of the mean of the normal matrix' diagonal: keeps poles that no target sees where they are
_KNOT_DAMPING = 1e-3
_SHORTEST = 3e-2  # of the spans' mean: none shrinks below, or knots all but meet and the curve is hardly C2
_NO_SPEED = 1e-200  # squared: where the curve stands still no residual is along it
_FALLING = np.array([[1.0], [-3.0], [3.0], [-1.0]])  # (1 - x)^3 in powers of x
_FALLING_POWERS = np.array([[3.0], [2.0], [1.0], [0.0]])  # and those of y, if it is (y - x)^3


def averaged(goal: Targets, knots: Array, u: Array) -> Curve:
    """Return Schoenberg's curve: the poles are the polyline of the targets at the averages of three knots."""
    spans = Spans(knots, goal.closed)
    around, places = u, goal.points
    if goal.closed:
        around = np.concatenate([u - goal.period, u, u + goal.period])
        places = np.tile(places, 3)
    t = spans.extended
    averages = (t[1:-3] + t[2:-2] + t[3:-1])[: spans.poles] / 3.0
    return Curve(spans, on_tangents(np.stack([np.interp(averages, around, row) for row in places]), goal))


def nearest(goal: Targets, curve: Curve, at: Place) -> Curve:
    """Return the curve as `with_poles` where residuals count alike in all directions: each coordinate by itself."""
    spans, weight, d = curve.spans, goal.weights / goal.allowed**2, len(curve.poles)
    terms = np.concatenate([weight * goal.points, weight[None]])
    matrices, sides = local(*_summed(spans, at, terms, d), spans.matrices)
    sides -= matrices @ curve.around  # the residuals, without a look at the curve
    return Curve(spans, _plus(curve, solve_alike(matrices, sides, band(spans.count, spans.closed, 1, False), _DAMPING)))


def with_poles(goal: Targets, curve: Curve, seen: Look, weights: Array, along: float = _ALONG) -> Curve:
    """Return the curve with the least-squares poles at its knots, seen at the targets' parameters."""
    return solved(goal, curve, *_equations(goal, curve, seen, weights, along, False), _DAMPING)


def solved(goal: Targets, curve: Curve, matrices: Array, sides: Array, damping: float) -> Curve:
    """Return the curve with the poles moved by what solves normal equations, given as `squares.local`."""
    spans, d = curve.spans, len(curve.poles)
    layout = band(spans.count, spans.closed, d, False)
    return Curve(
        spans, on_tangents(_plus(curve, solve(matrices, sides, layout, d, np.full(d, damping), held(goal))), goal)
    )


def _plus(curve: Curve, moves: Array) -> Array:
    """Return the curve's poles (d, k) with the free ones moved by `moves` (free, d)."""
    poles = curve.poles.copy()
    poles[:, slice(None) if curve.spans.closed else slice(1, -1)] += moves.T
    return poles


def with_knots(goal: Targets, curve: Curve, seen: Look, weights: Array) -> Curve:
    """Return the curve with its knots moved by one damped Gauss-Newton step of poles and knots together."""
    spans, d = curve.spans, len(curve.poles)
    damping = np.full(d + 1, _DAMPING)
    damping[d] = _KNOT_DAMPING
    found = solve(
        *_equations(goal, curve, seen, weights, _ALONG, True),
        band(spans.count, spans.closed, d, True),
        d,
        damping,
        held(goal),
    )[:, d]
    h, knots = spans.steps, spans.knots.copy()
    mean = (knots[-1] - knots[0]) / len(h)
    room = np.maximum(h - _SHORTEST * mean, 0.0) * 0.4
    if spans.closed:
        move = np.minimum(np.maximum(shifted(found, -1) * h, -shifted(room, 1)), room)
        knots[:-1] += move
        knots[-1] += move[0]
    else:
        knots[1:-1] += np.minimum(np.maximum(found[1:-1] * h[1:], -room[:-1]), room[1:])
    return Curve(Spans(knots, spans.closed), curve.poles)


def held(goal: Targets) -> list[tuple[int, Array]]:
    """Return the free poles next to the ends that may move along given tangents only."""
    return [(k, tangent) for k, tangent in zip((0, -1), goal.tangents, strict=True) if tangent is not None]


def on_tangents(poles: Array, goal: Targets) -> Array:
    """Return the poles (d, k) with those next to the ends on the given tangents, if any, and in front of the ends."""
    for tangent, end, near, sign in zip(goal.tangents, (0, -1), (1, -2), (1.0, -1.0), strict=True):
        if tangent is not None:
            along = sign * tangent
            length = max(float((poles[:, near] - poles[:, end]) @ along), 1e-4 * goal.period / poles.shape[1])
            poles[:, near] = poles[:, end] + length * along
    return poles


def _equations(
    goal: Targets, curve: Curve, seen: Look, weights: Array, along: float, move_knots: bool
) -> tuple[Array, Array]:
    """Return the normal equations of the targets' residuals, linearised, span by span, as `squares.local`."""
    squares, pulls = sums(curve, seen, goal.points - seen.places, weights / goal.allowed**2, along)
    return local(squares, pulls, _with_knots(curve) if move_knots else for_all(curve.spans.matrices, len(curve.poles)))


def sums(curve: Curve, seen: Look, gap: Array, weight: Array, along: float) -> tuple[Array, Array]:
    """Return the `squares.moments` of residuals `gap` (d, n) at the places seen, for the curve's spans.

    A residual's part along the curve counts `along` as much as what is across: a foot point slides there.
    """
    tangent, d = seen.tangents, len(seen.tangents)
    slid = ((along - 1.0) * weight / (dot(tangent, tangent) + _NO_SPEED)) * tangent
    terms = np.empty((d + d * (d + 1) // 2, len(weight)))
    np.multiply(dot(tangent, gap), slid, out=terms[:d])
    terms[:d] += weight * gap
    row = d
    for i in range(d):
        for j in range(i + 1):
            np.multiply(tangent[i], slid[j], out=terms[row])
            row += 1
        terms[row - 1] += weight
    return _summed(curve.spans, seen.at, terms, d)


def _summed(spans: Spans, at: Place, terms: Array, d: int) -> tuple[Array, Array]:
    """Return the `squares.moments` of targets at a place; closed, those of the next period with the first."""
    starts = at.span.searchsorted(np.arange(spans.count + 1 + spans.closed))
    return moments(at.local, terms, d, starts, spans.closed)


def _with_knots(curve: Curve) -> Array:
    """Return the functions (m, 4 d, 4 d + 3) of each span's four poles and of the three knots around it.

    Those are the knot before the span's start, its start and its end, each moved by the length of the span after it;
    what they change is told up to a change of the poles. Moving knot t changes the curve by a piece of spline with a
    double knot at t, whose second derivative jumps there by the curve's jump of the third, along that jump. It is a
    cubic on each of the span before t and the two after it, of lengths f, r and n: c times the cube of the distance
    from its start before t, a times that to its end in the last, and b times that to the next knot more in between.
    """
    spans, d = curve.spans, len(curve.poles)
    h, jumps = spans.steps, curve.third_jumps
    if spans.closed:
        f, r, n = shifted(h, 1), h, shifted(h, -1)
    else:  # knots 0 and m do not move; a knot stands a thousandth behind the end, for the last one that does
        jumps = np.concatenate([np.zeros((d, 1)), jumps], axis=1)
        f, r, n = shifted(h, 1), h, np.append(h[1:], 1e-3 * h[-1])
    ahead, behind, around = r + n, r + f, 6.0 * (f + r + n)
    a, b, c = r * f / (-n * ahead * around), f * ahead / (6.0 * n * r * behind), r * ahead / (-f * behind * around)
    shapes = np.zeros((4, 3, spans.count))
    shapes[:, 0] = _FALLING * shifted(a, 1)
    shapes[:, 1] = _FALLING * (a * (ahead / r) ** _FALLING_POWERS + b)
    shapes[3, 2] = shifted(c, -1)
    if not spans.closed:
        shapes[:, 0, 0] = shapes[3, 2, -1] = 0.0
    shapes *= h**3
    toward = -jumps * h  # of each span's start
    directions = np.array([shifted(toward, 1), toward, shifted(toward, -1)])  # (3, d, m)
    out = for_all(spans.matrices, d, 3)
    out[:, :, 4 * d :] = (shapes[:, None] * directions.swapaxes(0, 1)).transpose(3, 0, 1, 2).reshape(-1, 4 * d, 3)
    return out
