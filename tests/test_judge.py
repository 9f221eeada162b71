"""The benchmarks' brute-force judge of a fit: it agrees with the slow one, and catches what is a little wrong."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import cadfit

from corpus_data import OWN, Shape, shapes, turn
from judge import bulges, measured, stretches, violations
from test_fit import bulge, promise

SHARE = 1e-3


@cache
def fitted(name):
    """A fit and what it was made of."""
    t = np.linspace(0.0, np.pi, 40)
    arch = np.concatenate([np.column_stack([np.cos(t), np.sin(t)]), [[-0.5, 0], [0, 0], [0.5, 0]]])
    shape = {"arch": Shape(arch, True), "circle": Shape(turn(60, 10.0), True)}.get(name) or OWN[name]
    return cadfit.fit(shape.points, SHARE * shape.size, closed=shape.closed, effort="fast"), shape


def moved(fit, by, pole=2, curve=-1):
    """The fit with one pole of one curve moved by so many tolerances in every coordinate."""
    curves, poles = list(fit.curves), fit.curves[curve].poles.copy()
    poles[pole] += by * fit.tolerance
    curves[curve] = cadfit.BSpline(poles, curves[curve].knots)
    return replace(fit, curves=tuple(curves))


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=100))
def test_it_measures_what_the_slow_one_does(shape):
    fit = cadfit.fit(shape.points, SHARE * shape.size, closed=shape.closed, effort="fast")
    far, beyond = promise(fit, shape.points, shape.closed, fit.corners, per_chord=81)
    gaps, strays, allowed = measured(fit, shape.points, shape.closed)
    assert gaps.max() == pytest.approx(far, rel=1e-9, abs=1e-12 * shape.reach)
    assert np.max(strays - allowed) == pytest.approx(beyond, abs=2e-3 * fit.tolerance)
    assert violations(fit, shape.points, shape.closed) == []


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=80))
def test_its_bulges_are_those_of_the_slow_one(shape):
    for closed in {False, shape.closed}:
        found = bulges(shape.points, closed, count=200)
        slow = [bulge(shape.points, closed, row) for row in range(len(shape.points) - (not closed))]
        assert found == pytest.approx(slow, rel=1e-9, abs=1e-12 * shape.reach)


@pytest.mark.parametrize("name", ["arch", "circle", "hook", "bent wire", "crowded"])
def test_it_catches_a_pole_that_moved_a_little(name):
    fit, shape = fitted(name)
    assert violations(fit, shape.points, shape.closed) == []
    for by in (-2.0, 2.0):
        assert violations(moved(fit, by), shape.points, shape.closed), by


def test_it_catches_each_broken_promise():
    fit, shape = fitted("arch")
    assert len(fit.curves) == 2
    far = fit.deviation

    def wrong(**change):
        return "; ".join(violations(replace(fit, **change), shape.points, shape.closed))

    assert "below the truth" in wrong(deviation=replace(far, points=0.999 * far.points))
    assert "over 1 % above" in wrong(deviation=replace(far, points=1.02 * far.points))
    assert "between 0 below the truth" in wrong(deviation=replace(far, between=0.0))
    assert "tolerances away" in wrong(tolerance=0.9 * far.points)
    swapped = fit.parameters.copy()
    swapped[[3, 4]] = swapped[[4, 3]]
    assert "not in order" in wrong(parameters=swapped)
    assert "outside of the domain" in wrong(parameters=fit.parameters + 1e-3)
    assert "a corner is not at a joint" in wrong(corners=np.array([0, 38]))
    assert "other points" in wrong(points=shape.points + 1e-12)
    assert "does not end where it starts" in "; ".join(violations(moved(fit, 1e-9, -1), shape.points, True))
    assert "not joined to the last bit" in "; ".join(violations(moved(fit, 1e-9, 0), shape.points, True))
    twice = fit.curves[0].insert_knot(fit.curves[0].knots[4], 1)
    assert "inner knot is repeated" in wrong(curves=(twice, fit.curves[1]))
    circle, round_shape = fitted("circle")
    assert "the seam is not C2" in "; ".join(violations(moved(circle, 0.01, 1), round_shape.points, True))
    hook, open_shape = fitted("hook")
    assert "an open end is not the point" in "; ".join(violations(moved(hook, 1e-9, 0), open_shape.points, False))


def test_stretches_run_from_corner_to_corner():
    assert [rows.tolist() for rows in stretches(5, [1, 3], True)] == [[1, 2, 3], [3, 4, 0, 1]]
    assert [rows.tolist() for rows in stretches(5, [2], False)] == [[0, 1, 2], [2, 3, 4]]
    assert [rows.tolist() for rows in stretches(3, [], True)] == [[0, 1, 2]]
