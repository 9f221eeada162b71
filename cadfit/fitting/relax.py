"""Bring a spline with so many knots as near to its targets as it gets: poles, foot points and knots in turn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cadfit.bezier import Array, Ints
from cadfit.fitting.feet import Look, look, look_again, newton, slid, within, wrapped
from cadfit.fitting.spans import Curve, Spans, dot, shifted
from cadfit.fitting.squares import band, local, moments, pairs, solve, solve_alike
from cadfit.fitting.targets import Targets, sampled
from cadfit.fitting.turning import loops

_ALONG = 0.005  # weight of a residual's part along the curve: a foot point slides there
_DAMPING = 1e-6  # of the mean of the normal matrix' diagonal: keeps poles that no target sees where they are
_LOOKS = np.arange(1, 8) / 8.0
_KNOT_DAMPING = 1e-3
_SHORTEST = 3e-2  # of the spans' mean: none shrinks below, or knots all but meet and the curve is hardly C2
_NO_SPEED = 1e-200  # squared: where the curve stands still no residual is along it
_SHIFT = 0.5  # how strongly weight goes to large errors
_CALM = 0.3  # the same with moving knots, where there are many passes
_STEPS = 2
_PATIENCE = 6  # passes over which a rate is taken, at most: to wait for nine found next to nothing more
_FALLING = np.array([[1.0], [-3.0], [3.0], [-1.0]])  # (1 - x)^3 in powers of x


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """A curve for some targets, their parameters (n,) and weights (n,), and errors in parts of what is allowed.

    `worst` is the largest error. `met`: it is no more than 1, and the curve strays nowhere between the targets.
    """

    goal: Targets
    curve: Curve
    u: Array
    weights: Array
    seen: Look
    error: Array
    worst: float
    met: bool = False


def measured(goal: Targets, curve: Curve, u: Array, weights: Array, seen: Look | None = None) -> Trial:
    """Return the trial with the errors of the curve: of points the distance, between them how far it strays.

    `seen`: how the curve is seen at u, where that is known.
    """
    turned, u = wrapped(curve, u)
    if seen is None or turned is not curve:
        curve, seen = turned, look(turned, u)
    gap = goal.points - seen.places
    error = np.sqrt(dot(gap, gap)) / goal.allowed
    if len(goal.between):
        error[goal.between] = goal.straying(seen.places[:, goal.between], goal.row[goal.between])
    return Trial(goal, curve, u, weights, seen, error, float(error.max()))


def start(goal: Targets, knots: Array, u: Array) -> Trial:
    """Return the least-squares curve with these knots for targets at these parameters."""
    curve, u = wrapped(averaged(goal, knots, u), u)
    seen = look(curve, u)
    curve = with_poles(goal, curve, seen, goal.weights, 1.0) if held(goal) else nearest(goal, curve, seen)
    return measured(goal, curve, u, goal.weights, look_again(curve, seen))


def nearest(goal: Targets, curve: Curve, seen: Look) -> Curve:
    """Return the curve as `with_poles` where residuals count alike in all directions: each coordinate by itself."""
    spans, weight = curve.spans, goal.weights / goal.allowed**2
    squares, pulls = summed(spans, seen, weight[None], weight * (goal.points - seen.places))
    equations = local(squares, pulls, spans.matrices, None)
    found = solve_alike(*equations, band(spans.count, spans.closed, 1, False), _DAMPING)
    return Curve(spans, _plus(curve, found))


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


def relax(trial: Trial, passes: int, move_knots: bool) -> Trial:
    """Return the best trial of so many passes, stopping at the first that meets the targets, and strays nowhere.

    A pass shifts weight to the largest errors, solves for the poles (and knots), and lets the foot points slide. Where
    the targets are met but the curve strays between them, targets are added. It stops early where the passes left
    would not do at the rate of the last few: most trials fail, so that is where the time goes.
    """
    exponent = min(_CALM + 1.35 / passes, _SHIFT) if move_knots else _SHIFT  # bolder the fewer passes there are
    best = trial = checked(trial)
    worst, window = [best.worst], min(2 + passes // 8, _PATIENCE)
    for left in range(passes, 0, -1):
        gained = worst[-1 - window] - worst[-1] if len(worst) > window else np.inf
        if trial.met or (worst[-1] - 1.0) * window > left * gained:
            break
        trial = _shifted(trial, exponent, move_knots)
        if trial.worst < best.worst or len(trial.u) > len(best.u):
            best = trial
        worst.append(best.worst)
    return trial if trial.met else best


def settled(trial: Trial, passes: int) -> Trial:
    """Return the trial of the least largest error among so many passes on from one that meets its targets, knots moved.

    `relax` stops where the targets are met; with knots as good as they get, others can be taken away.
    """
    best = trial
    for _ in range(passes):
        trial = _shifted(trial, _CALM, True)
        if trial.met and trial.worst < best.worst:
            best = trial
    return best


def _shifted(trial: Trial, exponent: float, move_knots: bool) -> Trial:
    """Return the trial after a pass with weight shifted to the largest errors, as strongly as the exponent says."""
    count = len(trial.error)  # sums, since means take several times as long
    weights = trial.weights * (trial.error * (0.9 * count / np.add.reduce(trial.error)) + 0.1) ** exponent
    weights *= count / np.add.reduce(weights)
    return checked(_passed(trial, weights, move_knots))


def _passed(trial: Trial, weights: Array, move_knots: bool) -> Trial:
    """Return the trial after one pass: the knots moved, the poles solved for, the foot points slid along."""
    goal, curve, u, seen = trial.goal, trial.curve, trial.u, trial.seen
    if move_knots:
        curve, u = wrapped(with_knots(goal, curve, seen, weights), u)
        seen = look(curve, u)
    curve = with_poles(goal, curve, seen, weights, _ALONG)
    seen = look_again(curve, seen)
    period = goal.period if goal.closed else None
    for _ in range(_STEPS):
        u = slid(u, newton(curve, goal.points, seen), period)
        seen = look(curve, within(curve, u, period))
    return measured(goal, curve, u, weights, seen)


def checked(trial: Trial) -> Trial:
    """Return the trial as met, or where only the places between the targets keep it from that, with targets there."""
    if trial.worst > 1.0:
        return trial
    far, at = strays(trial)
    strayed = np.flatnonzero(far > 1.0)
    return watched(trial, strayed, at[strayed]) if len(strayed) else replace(trial, met=True)


def looping(trial: Trial) -> Ints:
    """Return the spans on which the curve loops or wiggles where the polyline that it is to follow does not."""
    goal, data = trial.goal, trial.goal.data
    if not goal.polyline:
        return np.zeros(0, dtype=np.intp)
    return loops(trial.curve, goal.points[:, data], trial.u[data], float(goal.allowed[0]), goal.tangents)


def watched(trial: Trial, chords: Ints, at: Array) -> Trial:
    """Return the trial with one more target on each of the chords (k,), at the places `at` (k,) in [0, 1]."""
    goal, u, order = sampled(trial.goal, trial.u, chords, at, at)
    weights = np.concatenate([trial.weights, np.full(len(chords), trial.weights.mean())])[order]
    return measured(goal, trial.curve, u, weights)


def with_poles(goal: Targets, curve: Curve, seen: Look, weights: Array, along: float) -> Curve:
    """Return the curve with the least-squares poles at its knots, seen at the targets' parameters."""
    spans, d = curve.spans, len(curve.poles)
    found = solve(
        *_equations(goal, curve, seen, weights, along, False),
        band(spans.count, spans.closed, d, False),
        d,
        np.full(d, _DAMPING),
        held(goal),
    )
    return Curve(spans, on_tangents(_plus(curve, found), goal))


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
    if not move_knots:
        return local(squares, pulls, curve.spans.matrices, None)
    moved, directions = _knot_functions(curve)
    return local(squares, pulls, np.concatenate([curve.spans.matrices, moved], axis=1), directions)


def sums(curve: Curve, seen: Look, gap: Array, weight: Array, along: float) -> tuple[Array, Array]:
    """Return the `squares.moments` of residuals `gap` (d, n) at the places seen, for the curve's spans.

    A residual's part along the curve counts `along` as much as what is across: a foot point slides there.
    """
    spans, tangent = curve.spans, seen.tangents
    slid = ((along - 1.0) * weight / (dot(tangent, tangent) + _NO_SPEED)) * tangent
    i, j = pairs(len(tangent))
    metric = tangent[i] * slid[j]
    metric[i == j] += weight
    pull = weight * gap + dot(tangent, gap) * slid
    return summed(spans, seen, metric, pull)


def summed(spans: Spans, seen: Look, metric: Array, pull: Array) -> tuple[Array, Array]:
    """Return the `squares.moments` of targets seen, for the spans; closed, those of the next period with the first."""
    starts = np.searchsorted(seen.span, np.arange(spans.count + 1 + spans.closed))
    squares, pulls = moments(seen.local, metric, pull, starts)
    if spans.closed:
        squares[..., 0] += squares[..., -1]
        pulls[..., 0] += pulls[..., -1]
    return squares[..., : spans.count], pulls[..., : spans.count]


def _knot_functions(curve: Curve) -> tuple[Array, Array]:
    """Return how the curve changes when the three knots around each span move, up to a change of the poles.

    Those are the knot before the span's start, its start and its end, each moved by the length of the span after it.
    The change of each is a cubic of the span's local parameter, (4 powers, 3, m), along a direction, (d, 3, m). Moving
    knot t changes the curve by a piece of spline with a double knot at t, whose second derivative jumps there by the
    curve's jump of the third: it is supported on the span before t and the two after it.
    """
    spans = curve.spans
    h = spans.steps
    jumps = curve.third_jumps
    if spans.closed:
        before, after, next_after = shifted(h, 1), h, shifted(h, -1)
    else:  # knots 0 and m do not move; a knot stands a thousandth behind the end, for the last one that does
        jumps = np.concatenate([np.zeros((len(jumps), 1)), jumps], axis=1)
        before, after, next_after = shifted(h, 1), h, np.append(h[1:], 1e-3 * h[-1])
    r, p = after, after + next_after
    ratio = (p + before) / (r + before)
    a = 1.0 / (6.0 * (p - p * p * ratio / r - p * p * (p - r) / ((r + before) * before)))
    b = -a * p * p * ratio / (r * r)
    c = a * p * p * (p - r) / ((r + before) * before * before)
    toward = -jumps * after  # of knot s
    cube = h**3
    first, last = shifted(a, 1) * cube, shifted(c, -1) * cube
    if not spans.closed:
        first[0] = last[-1] = 0.0
    shapes = np.zeros((4, 3, spans.count))
    np.multiply(_FALLING, first, out=shapes[:, 0])
    p2, h2 = a * p * p, h * h
    shapes[:, 1] = np.array([p2 * p, -3.0 * p2 * h, 3.0 * a * p * h2, -a * cube]) + _FALLING * (b * cube)
    shapes[3, 2] = last
    around = np.concatenate([toward[:, -1:], toward, toward[:, :1]], axis=1)
    return shapes, np.stack([around[:, :-2], toward, around[:, 2:]], axis=1)


def strays(trial: Trial) -> tuple[Array, Array]:
    """Return how far the curve strays from each chord (chords,), in parts of its room, and where, of seven samples."""
    goal = trial.goal
    u = np.append(trial.u[goal.data], trial.u[0] + goal.period)[: len(goal.room) + 1]
    at = (u[:-1] + _LOOKS[:, None] * (u[1:] - u[:-1])).ravel()
    chords = np.tile(np.arange(len(goal.room)), len(_LOOKS))
    found = goal.straying(trial.curve.points(at, trial.curve.spans.find(at)), chords).reshape(len(_LOOKS), -1)
    return found.max(axis=0), _LOOKS[np.argmax(found, axis=0)]
