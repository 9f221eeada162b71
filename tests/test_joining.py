"""Curves joined end to end, and closed curves from one period, against the textbook on unrolled knots."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadfit import BSpline, join, periodic

import reference
from corpus_data import splines
from reference import EPS, magnitude, parameters_between_knots, top_speed

LINE = BSpline([[0.0, 0], [1, 0], [2, 0], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])


def moved_to(curve, place):
    return curve.transformed(np.eye(len(place)), place - curve.poles[0])


# join


@given(st.lists(splines(dimensions=(2,), spans=(1, 3), unevenness=(0, 1)), min_size=1, max_size=4))
def test_joined_curves_are_the_curves_one_after_the_other(curves):
    for k in range(1, len(curves)):
        curves[k] = moved_to(curves[k], curves[k - 1].poles[-1])
    whole = join(curves)
    lengths = [np.ptp(curve.domain) for curve in curves]
    starts = curves[0].domain[0] + np.concatenate([[0], np.cumsum(lengths)])
    assert whole.domain == pytest.approx((starts[0], starts[-1]), abs=8 * EPS * np.abs(starts).max())
    joints = whole.distinct_knots[np.cumsum([len(curve.distinct_knots) - 1 for curve in curves], dtype=int)[:-1]]
    np.testing.assert_array_equal(np.isin(whole.knots, joints).sum(), 3 * len(joints))
    rest = whole
    for curve, joint in zip(curves, [*joints, None], strict=True):
        part, rest = rest.split(joint) if joint is not None else (rest, None)
        u = parameters_between_knots(curve)
        v = np.clip(u - curve.domain[0] + part.domain[0], *part.domain)
        furthest = max(np.abs(whole.domain).max(), np.abs(curve.domain).max())
        shift = 8 * EPS * furthest * top_speed(curve)
        np.testing.assert_allclose(part(v), curve(u), rtol=0, atol=64 * EPS * magnitude(whole) + shift)
        np.testing.assert_allclose(part.poles, curve.poles, rtol=0, atol=1e-9 * max(c.size for c in curves))


def test_one_curve_stays_itself():
    assert join(LINE) is LINE
    assert join([LINE]) is LINE


def test_a_gap_within_tolerance_closes_on_the_later_pole():
    later = moved_to(LINE, np.array([3.0 + 2e-9, 0.0]))
    whole = join([LINE, later])
    np.testing.assert_array_equal(whole.poles[3], later.poles[0])
    np.testing.assert_array_equal(whole.poles[:3], LINE.poles[:3])
    np.testing.assert_array_equal(whole.knots, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2])


@pytest.mark.parametrize(
    ("curves", "tolerance", "says"),
    [
        ([], 1e-9, "at least one curve is needed"),
        ([LINE, LINE.transformed([[1, 0], [0, 1], [0, 0]])], 1e-9, r"different dimensions: \[2, 3\]"),
        ([LINE, LINE], 1e-9, "curve 1 starts 3 away from the end of curve 0"),
        ([LINE, LINE.reversed(), moved_to(LINE, np.array([0.0, 0.5]))], 0.1, "curve 2 starts 0.5 away .* curve 1"),
        ([LINE, moved_to(LINE, np.array([3 + 4e-9, 0.0]))], 1e-9, "curve 1 starts 4e-09 away"),
    ],
)
def test_curves_that_do_not_meet_are_named(curves, tolerance, says):
    with pytest.raises(ValueError, match=says):
        join(curves, tolerance)


# periodic


@st.composite
def periods(draw):
    """Periodic poles (n, d) and knots (n + 1,), even or with spans that differ by up to 1e4."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, d, spread = draw(st.integers(3, 12)), draw(st.integers(1, 4)), draw(st.sampled_from([0, 1, 2]))
    steps = 10.0 ** rng.uniform(-spread, spread, n)
    return rng.normal(size=(n, d)), draw(st.sampled_from([0.0, -3.0])) + np.concatenate([[0], steps.cumsum()])


def unrolled(poles, knots):
    """Poles and knots enough on both sides for the textbook to evaluate one whole period."""
    n, period = len(poles), knots[-1] - knots[0]
    index = np.arange(-4, n + 5)
    more = np.arange(-6, n + 7)
    return poles[index % n], knots[more % n] + period * (more // n)


@given(periods())
def test_a_period_is_the_textbooks_on_unrolled_knots(period):
    curve, (poles, knots) = periodic(*period), unrolled(*period)
    u = parameters_between_knots(curve)[1:-1]
    for order in (0, 1, 2):
        wrapped = 1 + np.ptp(period[1]) / np.diff(period[1]).min()  # unrolled knots are rounded at the period's size
        allowed = wrapped * reference.rounding(poles, knots, u, order)
        allowed += reference.rounding(curve.poles, curve.knots, u, order)
        assert np.all(np.abs(curve.derivative(u, order) - reference.curve(poles, knots, u, order)) <= allowed)


@given(periods())
def test_a_period_is_closed_and_c2_across_its_seam(period):
    curve = periodic(*period)
    assert curve.closed
    np.testing.assert_array_equal(curve.knots[3:-3], period[1])
    pieces = curve.pieces()
    spans = np.diff(period[1])[[0, -1]]
    for order, factor in ((1, 3), (2, 6)):
        start = factor * np.diff(pieces[0], n=order, axis=0)[0] / spans[0] ** order
        end = factor * np.diff(pieces[-1], n=order, axis=0)[-1] / spans[1] ** order
        wrapped = np.ptp(period[1]) / spans.min()  # the knots beyond the seam are rounded at the period's size
        allowed = 16 * EPS * magnitude(curve) * wrapped / spans.min() ** order
        np.testing.assert_allclose(end, start, rtol=0, atol=allowed)


def exact_second(poles, knots):
    """The second derivative at the start of a clamped spline whose poles and knots are taken as they are, unrounded."""
    rows, (a, b, c) = [[Fraction(x) for x in row] for row in poles[:3]], [Fraction(x) for x in knots[3:6]]
    return [6 / (b - a) * ((z - y) / (c - a) - (y - x) / (b - a)) for x, y, z in zip(*rows, strict=True)]


@pytest.mark.parametrize("seed", range(5))
def test_a_short_span_at_the_seam_does_not_round_the_second_derivative_away(seed):
    steps = np.array([0.02, 1.0, 1.2, 0.9, 1.1, 0.03]) * np.random.default_rng(seed).uniform(0.9, 1.1, 6)
    turn = 2 * np.pi * np.append(0.0, steps.cumsum()) / steps.sum()
    curve = periodic(10 * np.stack([np.cos(turn[:-1]), np.sin(turn[:-1])], axis=1) + 7, turn)
    start, end = exact_second(curve.poles, curve.knots), exact_second(curve.poles[::-1], -curve.knots[::-1])
    bound = 4 * EPS * curve.size / np.diff(turn).min()  # the second pole's last bit would count by its square
    assert max(abs(a - b) for a, b in zip(start, end, strict=True)) < bound


def test_even_periods_do_not_care_where_they_begin():
    poles = np.random.default_rng(3).normal(size=(7, 2))
    here, there = periodic(poles, np.arange(8.0)), periodic(np.roll(poles, -2, axis=0), np.arange(8.0))
    u = np.linspace(0, 5, 51)
    np.testing.assert_allclose(there(u), here(u + 2), rtol=0, atol=16 * EPS * magnitude(here))


@pytest.mark.parametrize(
    ("poles", "knots", "says"),
    [
        ([[0, 0], [1, 0]], [0, 1, 2], r"2 periodic poles \(3 or more\) need 3 knots"),
        ([[0, 0], [1, 0], [1, 1]], [0, 1, 2], "3 periodic poles .* need 4 knots"),
        ([[0, 0], [1, 0], [1, 1]], [0, 1, 1, 2], "knots that rise"),
        ([[0, 0], [1, np.nan], [1, 1]], [0, 1, 2, 3], "finite"),
        ([[0, 0], [1, 0], [1, 1]], [0, 1, np.nan, 3], "finite"),
    ],
)
def test_bad_periods_are_named(poles, knots, says):
    with pytest.raises(ValueError, match=says):
        periodic(poles, knots)
