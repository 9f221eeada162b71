"""The least squares of a fit, done span by span, against the same with matrices of all points and poles."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline

from cadfit.fitting import steps
from cadfit.fitting.feet import found, look
from cadfit.fitting.spans import Curve, Spans
from cadfit.fitting.squares import for_all, local
from cadfit.fitting.steps import nearest, sums, with_knots, with_poles
from cadfit.fitting.targets import Targets

N, M = 60, 7
SHAPES = pytest.mark.parametrize(("closed", "d"), [(closed, d) for closed in (False, True) for d in (1, 2, 3)])


def basis(spans, u):
    """The values (n, poles) of the space's basis at u (n,): scipy's, the poles of neighbouring periods added up."""
    dense = BSpline.design_matrix(u, spans.extended, 3).toarray()
    if spans.closed:
        dense[:, :3] += dense[:, M : M + 3]
    return dense[:, : spans.poles]


def problem(closed, d, seed=5):
    """Targets about a curve, the curve, and the targets' parameters (N,) on it."""
    rng = np.random.default_rng(seed)
    spans = Spans(np.cumsum(rng.uniform(0.2, 2.0, M + 1)), closed)
    u = np.sort(rng.uniform(*spans.knots[[0, -1]], N))
    curve = Curve(spans, rng.normal(size=(d, spans.poles)))
    points = basis(spans, u) @ curve.poles.T + rng.normal(scale=0.3, size=(N, d))
    goal = Targets(
        points=points.T.copy(),
        allowed=rng.uniform(0.5, 1.0, N),
        weights=rng.uniform(0.5, 2.0, N),
        u=u,
        row=np.arange(N),
        data=np.ones(N, dtype=bool),
        chain=np.zeros((N - 1 + closed, 4, d)),
        room=np.ones(N - 1 + closed),
        closed=closed,
        polyline=False,
        period=float(spans.knots[-1] - spans.knots[0]),
        tangents=(None, None),
    )
    return goal, curve, u


def solved(functions, metric, gap, damping):
    """The unknowns (q,) that make functions (n, d, q) nearest to gap (n, d) in the metric (n, d, d), all damped."""
    matrix = np.einsum("ndq,nde,ner->qr", functions, metric, functions)
    side = np.einsum("ndq,nde,ne->q", functions, metric, gap)
    return np.linalg.solve(matrix + damping * matrix.diagonal().mean() * np.eye(len(side)), side)


def free(spans):
    return slice(None) if spans.closed else slice(1, -1)


@SHAPES
def test_spans_have_the_basis_of_scipy(closed, d):
    _, curve, u = problem(closed, d)
    assert_allclose(look(curve, u).places, curve.poles @ basis(curve.spans, u).T, atol=1e-13)
    ahead = 1e-6
    inside = u + ahead < curve.spans.knots[-1]
    later = curve.poles @ basis(curve.spans, u[inside] + ahead).T
    seen = look(curve, u)
    slopes = (seen.tangents / curve.spans.steps[seen.at.wrapped])[:, inside]
    assert_allclose((later - seen.places[:, inside]) / ahead, slopes, atol=1e-3)


@SHAPES
def test_nearest_is_least_squares_of_each_coordinate(closed, d):
    goal, curve, u = problem(closed, d)
    weight, dense = goal.weights / goal.allowed**2, basis(curve.spans, u)
    gap = goal.points.T - dense @ curve.poles.T
    each = [
        solved(dense[:, None, free(curve.spans)], weight[:, None, None], row[:, None], steps._DAMPING) for row in gap.T
    ]
    found_poles = nearest(goal, curve, found(curve.spans, u)).poles
    assert_allclose((found_poles - curve.poles)[:, free(curve.spans)], each, atol=1e-11)


@SHAPES
@pytest.mark.parametrize("along", [1.0, 0.3])
def test_poles_are_least_squares_with_less_weight_along_the_curve(closed, d, along):
    if d == 1 and along < 1.0:
        pytest.skip("on a line everything is along the curve")
    goal, curve, u = problem(closed, d)
    seen = look(curve, u)
    tangent = (seen.tangents / np.linalg.norm(seen.tangents, axis=0)).T
    metric = np.eye(d) - (1.0 - along) * tangent[:, :, None] * tangent[:, None]
    metric *= (goal.weights / goal.allowed**2)[:, None, None]
    functions = np.einsum("np,de->ndpe", basis(curve.spans, u)[:, free(curve.spans)], np.eye(d)).reshape(N, d, -1)
    expected = solved(functions, metric, (goal.points - seen.places).T, steps._DAMPING).reshape(-1, d).T
    moved = with_poles(goal, curve, seen, goal.weights, along).poles - curve.poles
    assert_allclose(moved[:, free(curve.spans)], expected, atol=1e-10)


@SHAPES
def test_functions_of_knots_are_how_the_curve_changes_but_for_poles(closed, d):
    """What is left of the change, once the best change of the poles is taken off, is nothing."""
    _, curve, _ = problem(closed, d)
    spans, ahead = curve.spans, 1e-6
    u = np.linspace(*spans.knots[[0, -1]], 600, endpoint=False)
    at = found(spans, u)
    shapes = steps._with_knots(curve).reshape(M, 4, d, -1)[..., 4 * d :]  # (m, powers, d, the knot before, at, after)
    values = np.einsum("pn,npdk->ndk", at.local ** np.arange(4)[:, None], shapes[at.wrapped])
    space = basis(spans, u)
    for j in range(0 if closed else 1, M):
        knots = spans.knots.copy()
        step = ahead * spans.steps[j]  # a knot moves by the length of the span after it
        knots[j] += step
        if closed and j == 0:
            knots[-1] += step
        safe = np.abs((u - spans.knots[j] + 0.5) % (spans.knots[-1] - spans.knots[0]) - 0.5) > 2 * step
        moved = Curve(Spans(knots, closed), curve.poles)
        later = look(moved, np.where(u < knots[0], u + knots[-1] - knots[0], u)).places
        change = (later - look(curve, u).places).T / ahead
        ours = np.zeros_like(change)
        for k, offset in enumerate((1, 0, -1)):  # this knot is the one before, at and after these spans' starts
            here = at.wrapped == (j + offset) % M if closed else at.wrapped == j + offset
            ours[here] += values[here, :, k]
        left = (change - ours)[safe]
        left -= space[safe] @ np.linalg.lstsq(space[safe], left, rcond=None)[0]
        assert np.abs(left).max() < 1e-4 * np.abs(change).max()
        assert np.abs(ours).max() > 1e-3 * np.abs(change).max()


def test_sums_of_a_span_without_points_are_nothing():
    _, curve, u = problem(False, 2)
    u = u[(u < curve.spans.knots[2]) | (u > curve.spans.knots[3])]
    seen = look(curve, u)
    squares, pulls = sums(curve, seen, seen.places, np.ones(len(u)), 0.5)
    assert not squares[2].any()
    assert not pulls[2].any()
    assert squares[[1, 3]].any(axis=(1, 2)).all()
    matrices, _ = local(squares, pulls, for_all(curve.spans.matrices, 2))
    assert_allclose(matrices, matrices.swapaxes(1, 2), atol=1e-12)


def test_knots_move_toward_better_places():
    """Points of splines whose knots are known: from knots beside, some steps take most of the error away."""
    left = []
    for seed in range(30):
        goal, curve, u = problem(False, 2, seed)
        exact = (basis(curve.spans, u) @ curve.poles.T).T
        goal = Targets(**{**vars(goal), "points": exact, "weights": np.ones(N), "allowed": np.ones(N)})
        beside = curve.spans.knots.copy()
        beside[1:-1] += 0.05 * np.random.default_rng(seed).uniform(-1.0, 1.0, M - 1)
        moved, errors = Curve(Spans(beside, False), curve.poles), []
        for _ in range(9):
            moved = with_poles(goal, moved, look(moved, u), goal.weights, 1.0)
            errors.append(np.linalg.norm(look(moved, u).places - exact))
            moved = with_knots(goal, moved, look(moved, u), goal.weights)
        left.append(errors[-1] / errors[0])
    assert max(left) < 0.9
    assert np.median(left) < 0.15
