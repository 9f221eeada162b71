"""The global interpolant against its definition, the textbook's collocation matrix, and scipy's other routine."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from cadfit import BSpline, interpolate, parametrize

import reference
from corpus_data import OWN, point_rows, rotation, shapes, turn
from reference import EPS, magnitude, parameters_between_knots

ALL = ["uniform", "centripetal", "chord"]
each = pytest.mark.parametrize("parametrization", ALL)


def unevenness(u):
    """The longest step against the shortest, by which the system's rounding grows."""
    return np.diff(u).max() / np.diff(u).min()


def end_velocities(points, u, directions):
    """Directions at the speed of the first and of the last chord."""
    chords = points[[1, -1]] - points[[0, -2]]
    speeds = np.linalg.norm(chords, axis=1) / (u[[1, -1]] - u[[0, -2]])
    return [d / np.linalg.norm(d) * speed for d, speed in zip(np.asarray(directions, float), speeds, strict=True)]


def check_definition(points, curve, u, ends=None):
    """Through the points, a knot at each, C2, and what the kind says of its ends."""
    closed = ends == "periodic"
    unit = EPS * magnitude(curve) * unevenness(u)
    spans = np.diff(u)
    np.testing.assert_array_equal(curve.distinct_knots, u)
    assert set(curve.multiplicities[1:-1]) <= {1}
    np.testing.assert_allclose(curve(u[: len(points)]), points, rtol=0, atol=64 * unit)
    if closed:
        least = min(spans[0], spans[-1])
        for order in (0, 1, 2):
            jump = curve.derivative(u[0], order) - curve.derivative(u[-1], order)
            assert np.abs(jump).max() * least**order <= 256 * unit
    elif ends is None:
        bends = curve.derivative(u[[0, -1]], 2) * spans[[0, -1], None] ** 2
        np.testing.assert_allclose(bends, 0, atol=256 * unit)
    else:
        apart = curve.derivative(u[[0, -1]]) - ends
        np.testing.assert_allclose(apart * spans[[0, -1], None], 0, atol=128 * unit)


@each
@given(points=point_rows(least=3), kind=st.sampled_from(["natural", "clamped", "periodic"]), seed=st.integers(0, 99))
def test_random_points_are_interpolated_by_definition_and_as_scipy_does(parametrization, points, kind, seed):
    closed = kind == "periodic"
    u = parametrize(points, parametrization, closed)
    directions = np.random.default_rng(seed).normal(size=(2, points.shape[1])) if kind == "clamped" else None
    curve = interpolate(points, parametrization, closed, directions)
    ends = kind if closed else None
    other = kind
    if kind == "clamped":
        ends = end_velocities(points, u, directions)
        other = [(1, velocity) for velocity in ends]
    check_definition(points, curve, u, ends)
    rows = np.vstack([points, points[:1]]) if closed else points
    v = parameters_between_knots(curve)
    allowed = 64 * EPS * magnitude(curve) * unevenness(u) ** 2
    np.testing.assert_allclose(curve(v), CubicSpline(u, rows, bc_type=other)(v), rtol=0, atol=allowed)


@each
@given(points=point_rows(dimensions=(1, 3), least=3, most=8), clamped=st.booleans())
def test_poles_solve_the_textbooks_collocation_system(parametrization, points, clamped):
    u = parametrize(points, parametrization)
    directions = np.ones((2, points.shape[1]))
    start = end = (2, np.zeros(points.shape[1]))
    if clamped:
        start, end = ((1, velocity) for velocity in end_velocities(points, u, directions))
    poles, knots = reference.interpolant_poles(u, points, start, end)
    curve = interpolate(points, parametrization, end_tangents=directions if clamped else None)
    np.testing.assert_array_equal(curve.knots, knots)
    np.testing.assert_allclose(curve.poles, poles, rtol=0, atol=64 * EPS * magnitude(curve) * unevenness(u) ** 2)


@pytest.mark.parametrize("shape", shapes())
def test_real_points_are_interpolated_by_definition(shape):
    for parametrization in ALL:
        u = parametrize(shape.points, parametrization, shape.closed)
        curve = interpolate(shape.points, parametrization, shape.closed)
        check_definition(shape.points, curve, u, "periodic" if shape.closed else None)


@each
@pytest.mark.parametrize("length", [1e-300, 1e-9, 1.0, 1e9, 1e300])
def test_end_tangents_give_directions_of_any_length_at_the_chords_speed(parametrization, length):
    points = OWN["hook"].points
    u = parametrize(points, parametrization)
    directions = np.array([[3.0, -4.0], [-1.0, 0.0]])
    curve = interpolate(points, parametrization, end_tangents=length * directions)
    expected = end_velocities(points, u, directions)
    np.testing.assert_allclose(curve.derivative(u[[0, -1]]), expected, rtol=0, atol=1e-13)
    assert curve.isclose(interpolate(points, parametrization, end_tangents=directions), tolerance=1e-14)


@each
def test_two_points_give_their_segment(parametrization):
    curve = interpolate([[1, 2], [4, 6]], parametrization)
    np.testing.assert_allclose(curve.poles, [[1, 2], [2, 10 / 3], [3, 14 / 3], [4, 6]], rtol=4 * EPS)
    assert curve.domain == pytest.approx((0, 5), rel=2 * EPS)


def test_two_points_with_tangents_give_hermites_cubic():
    curve = interpolate([[0, 0], [3, 0]], end_tangents=[[0, 5], [0, -5]])
    np.testing.assert_allclose(curve.poles, [[0, 0], [0, 1], [3, 1], [3, 0]], rtol=0, atol=16 * EPS)


def test_order_on_the_circle_is_four():
    errors = []
    for n in (24, 48, 96):
        ring = interpolate(turn(n), closed=True)
        errors.append(abs(np.linalg.norm(ring(np.linspace(*ring.domain, 40 * n + 1)), axis=1) - 1).max())
    np.testing.assert_allclose(-np.diff(np.log2(errors)), 4, atol=0.1)


def test_every_point_moves_the_whole_curve_though_ever_less():
    points = np.column_stack([np.arange(21.0), np.zeros(21)])
    moved = points.copy()
    moved[10, 1] = 1.0
    curve = interpolate(moved, "uniform")
    away = abs(curve((np.arange(20) + 0.5) / 20 * curve.domain[1])[:, 1])
    np.testing.assert_allclose(away[12:16] / away[11:15], 2 - np.sqrt(3), rtol=1e-3)
    assert away.min() > 0


@each
@pytest.mark.parametrize("closed", [False, True])
@given(points=point_rows(least=3), seed=st.integers(0, 99))
def test_moved_points_give_the_moved_curve(parametrization, closed, points, seed):
    d = points.shape[1]
    matrix, offset = 2.5 * rotation(d, seed), np.arange(d)
    moved = interpolate(points, parametrization, closed).transformed(matrix, offset)
    found = interpolate(points @ matrix.T + offset, parametrization, closed)
    size = magnitude(moved) * unevenness(moved.distinct_knots)
    np.testing.assert_allclose(found.poles, moved.poles, rtol=0, atol=1024 * EPS * size)


@each
@pytest.mark.parametrize("closed", [False, True])
@given(points=point_rows(least=3))
def test_reversed_points_give_the_reversed_curve(parametrization, closed, points):
    curve = interpolate(points, parametrization, closed).reversed()
    backwards = np.roll(points[::-1], 1, axis=0) if closed else points[::-1]
    size = magnitude(curve) * unevenness(curve.distinct_knots)
    other = interpolate(backwards, parametrization, closed)
    np.testing.assert_allclose(other.poles, curve.poles, rtol=0, atol=1024 * EPS * size)


@each
@given(points=point_rows(least=3))
def test_the_first_point_may_be_repeated_or_not(parametrization, points):
    once = interpolate(points, parametrization, closed=True)
    twice = interpolate(np.vstack([points, points[:1]]), parametrization, closed=True)
    np.testing.assert_array_equal(once.poles, twice.poles)


@each
@pytest.mark.parametrize("closed", [False, True])
def test_an_offset_costs_no_more_than_its_own_rounding(parametrization, closed):
    points = 1e-3 * turn(30) * [[1.0, 0.4]] + 6.4e6 - 6.4e6
    near, far = (interpolate(points + offset, parametrization, closed) for offset in (0, 6.4e6))
    np.testing.assert_allclose(far.poles - 6.4e6, near.poles, rtol=0, atol=16 * EPS * 6.4e6)


@each
@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_changes_nothing_but_size(parametrization, scale):
    points = OWN["hook"].points
    curve, other = (interpolate(s * points, parametrization) for s in (1, scale))
    assert other.isclose(BSpline(scale * curve.poles, scale * curve.knots), tolerance=64 * EPS)


@pytest.mark.parametrize(
    ("closed", "tangents", "says"),
    [
        (True, [[1, 0], [1, 0]], "a closed curve has no ends: leave end_tangents out"),
        (False, [1, 0], r"two finite directions, shape \(2, 2\)"),
        (False, [[1, 0, 0], [1, 0, 0]], r"two finite directions, shape \(2, 2\)"),
        (False, [[1, 0], [np.nan, 0]], "two finite directions"),
        (False, [[0, 0], [1, 0]], r"end_tangents must not be zero: \[\[0.0, 0.0\], \[1.0, 0.0\]\]"),
    ],
)
def test_bad_end_tangents_are_named(closed, tangents, says):
    with pytest.raises(ValueError, match=says):
        interpolate(turn(5), closed=closed, end_tangents=tangents)
