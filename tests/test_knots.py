"""Moving knots: the fit's Gauss-Newton steps reach the best knots there are for the titanium heat data.

49 values of y(x) on a grid (de Boor and Rice 1968), five knots inside, parameters held at u = x, d = 1: a least-squares
problem with free knots, of the kind of Jupp 1978, whose optimum is found here by brute force.
"""

from functools import cache

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

from cadfit.fitting.feet import look
from cadfit.fitting.relax import start
from cadfit.fitting.spans import Curve
from cadfit.fitting.steps import with_knots, with_poles
from cadfit.fitting.targets import Targets

X = 595.0 + 10.0 * np.arange(49)
Y = np.array(
    [0.644, 0.622, 0.638, 0.649, 0.652, 0.639, 0.646, 0.657, 0.652, 0.655, 0.644, 0.663, 0.663, 0.668, 0.676, 0.676]
    + [0.686, 0.679, 0.678, 0.683, 0.694, 0.699, 0.710, 0.730, 0.763, 0.812, 0.907, 1.044, 1.336, 1.881, 2.169, 2.075]
    + [1.598, 1.211, 0.916, 0.746, 0.672, 0.627, 0.615, 0.607, 0.606, 0.609, 0.603, 0.601, 0.603, 0.601, 0.611, 0.601]
    + [0.608]
)
STARTS = {"around the peak": [780.0, 850.0, 890.0, 920.0, 980.0], "crowded": [825.0, 850.0, 900.0, 910.0, 975.0]}


def best_for(knots, ends=None):
    """The residuals (49,) of the least-squares spline with these inner knots, its ends held at two values if given."""
    full = np.concatenate([[X[0]] * 4, np.sort(knots), [X[-1]] * 4])
    if np.any(np.diff(full)[3:-3] <= 0):
        return np.full(len(X), 10.0)
    basis = BSpline.design_matrix(X, full, 3).toarray()
    if ends is None:
        return basis @ np.linalg.lstsq(basis, Y, rcond=None)[0] - Y
    rest = Y - basis[:, [0, -1]] @ ends
    return basis[:, 1:-1] @ np.linalg.lstsq(basis[:, 1:-1], rest, rcond=None)[0] - rest


@cache
def optimum(held):
    """The smallest sum of squares over many starts, and its knots; with the ends held at the first and last value."""
    rng, ends = np.random.default_rng(0), Y[[0, -1]] if held else None
    found = [
        least_squares(best_for, np.sort(rng.uniform(780.0, 1000.0, 5)), x_scale=10.0, args=(ends,)) for _ in range(12)
    ]
    best = min(found, key=lambda one: one.cost)
    return 2.0 * best.cost, np.sort(best.x)


def moved(knots, ends, steps):
    """The sum of squares and the inner knots after so many of the fit's steps, the curve's ends held at two values."""
    n = len(X)
    goal = Targets(
        points=Y[None],
        allowed=np.ones(n),
        weights=np.ones(n),
        u=X,
        row=np.arange(n),
        data=np.ones(n, dtype=bool),
        chain=np.zeros((n - 1, 4, 1)),
        room=np.ones(n - 1),
        closed=False,
        polyline=False,
        period=X[-1] - X[0],
        tangents=(None, None),
    )
    curve = start(goal, np.concatenate([X[:1], knots, X[-1:]]), X).curve
    curve = Curve(curve.spans, np.concatenate([ends[:1, None], curve.poles[:, 1:-1], ends[1:, None]], axis=1))
    for _ in range(steps):
        curve = with_poles(goal, curve, look(curve, X), goal.weights, 1.0)
        curve = with_knots(goal, curve, look(curve, X), goal.weights)
    curve = with_poles(goal, curve, look(curve, X), goal.weights, 1.0)
    return float(np.sum((look(curve, X).places - Y) ** 2)), curve.spans.knots[1:-1]


@pytest.mark.slow
def test_the_optimum_by_brute_force():
    square, knots = optimum(held=False)
    assert square == pytest.approx(0.00765276, abs=1e-7)
    assert knots == pytest.approx([835.46, 876.51, 898.17, 916.28, 974.02], abs=0.05)
    assert optimum(held=True)[0] == pytest.approx(0.00831156, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("name", STARTS)
def test_steps_of_knots_and_poles_reach_the_optimum(name):
    """A fit's ends are points, and held. Held where the best curve has them, they leave the best curve to be found."""
    knots = np.array(STARTS[name])
    best = Y + best_for(optimum(held=False)[1])
    for ends, held in ((best[[0, -1]], False), (Y[[0, -1]], True)):
        square, where = optimum(held)
        assert np.sum(best_for(knots) ** 2) > 20 * square
        found, at = moved(knots, ends, 60)
        assert found == pytest.approx(square, rel=1e-5)
        assert at == pytest.approx(where, abs=0.3)
