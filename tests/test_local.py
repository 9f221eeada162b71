"""The local C2 interpolant: exact derivative estimates, order on the circle, uneven spacing, locality."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadfit import BSpline, bezier, local_spline, parametrize
from cadfit.fitting.local import _BLOCK, neighbour_derivatives

import reference
from corpus_data import OWN, point_rows, rotation, shapes, turn
from reference import EPS, magnitude

ALL = ["uniform", "centripetal", "chord"]
each = pytest.mark.parametrize("parametrization", ALL)


def grown_rounding(curve):
    """Rounding of the poles, grown by the longest span against the shortest: slopes of short chords act over long."""
    spans = np.diff(curve.distinct_knots)
    return 64 * EPS * magnitude(curve) * spans.max() / spans.min()


def per_interval(curve, n, closed):
    """The curve's pieces, and which interval between points each belongs to: three each, an open end two."""
    intervals = np.repeat(np.arange(n), 3) if closed else np.repeat(np.arange(n - 1), [2, *[3] * (n - 3), 2])
    pieces = curve.pieces()
    assert len(pieces) == len(intervals)
    return pieces, intervals


def ring_error(n, parametrization, closed=True, spread=0.0):
    """The largest distance of the curve through n circle points from the circle; `spread` spaces them unevenly."""
    angle = 2 * np.pi * np.arange(n + (not closed)) / n
    angle = angle + spread * np.sin(angle)
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    curve = local_spline(points, closed, parametrization)
    return abs(np.linalg.norm(curve(np.linspace(*curve.domain, 200 * n + 1)), axis=1) - 1).max()


# The derivatives


@given(point_rows(least=2, most=9), st.integers(0, 2**32 - 1), st.sampled_from([0, 0.5, 1.5]))
def test_derivatives_are_those_of_the_polynomial_through_five_neighbours(points, seed, spread):
    steps = 10.0 ** np.random.default_rng(seed).uniform(-spread, spread, len(points) - 1)
    values, sizes = reference.neighbour_derivatives(points, steps)
    found = neighbour_derivatives(points.T, steps)
    assert np.all(np.abs(found - values) <= 512 * EPS * sizes)  # divided differences cancel


@given(point_rows(least=4), st.integers(0, 2**32 - 1), st.floats(0.01, 1))
def test_estimates_are_drawn_to_three_points_where_they_leave_them_by_more_than_the_trust(points, seed, trust):
    """Along the way between the two, as far as the trust goes, and not at all where it suffices."""
    steps = 10.0 ** np.random.default_rng(seed).uniform(-1, 1, len(points) - 1)
    found = neighbour_derivatives(points.T, steps, trust)
    (three, _), (five, sizes) = (reference.neighbour_derivatives(points, steps, width) for width in (3, 5))
    speeds = np.linalg.norm(np.diff(points, axis=0) / steps[:, None], axis=1)
    limit = trust * np.minimum(np.append(speeds, np.inf), np.insert(speeds, 0, np.inf))
    longer = np.maximum(np.append(steps, 0), np.insert(steps, 0, 0))
    away = np.linalg.norm(five - three, axis=1)
    change = np.maximum(away[0], longer * away[1])
    part = np.minimum(1, limit / np.maximum(change, np.finfo(float).tiny))
    allowed = 256 * EPS * sizes * (1 + (sizes.max(axis=1) * [np.ones_like(longer), longer]).max(axis=0)
                                  / np.maximum(change, limit))  # fmt: skip
    assert np.all(np.abs(found - (three + part * (five - three))) <= allowed)


@given(points=point_rows(least=5))
def test_even_parameters_of_a_closed_curve_give_the_five_point_formulas(points):
    """T/3 and c of the design, per unit knot, a third of an interval."""
    curve = local_spline(points, closed=True, parametrization="uniform")
    around = {k: np.roll(points, -k, axis=0) for k in (-2, -1, 1, 2)}
    slope = (8 * (around[1] - around[-1]) - (around[2] - around[-2])) / 36
    bend = (16 * (around[1] + around[-1]) - (around[2] + around[-2]) - 30 * points) / 108
    poles = np.stack([points + bend / 3 - slope, points - bend / 6, points + bend / 3 + slope], axis=1)
    pieces = curve.pieces().reshape(len(points), 3, 4, -1)
    unit = EPS * np.abs(poles).max()
    np.testing.assert_allclose(pieces[:, 0, 0], points, rtol=0, atol=32 * unit)
    np.testing.assert_allclose(3 * (pieces[:, 0, 1] - pieces[:, 0, 0]), slope, rtol=0, atol=64 * unit)
    np.testing.assert_allclose(6 * np.diff(pieces[:, 0], n=2, axis=1)[:, 0], bend, rtol=0, atol=128 * unit)
    following = np.roll(poles, -1, axis=0)
    np.testing.assert_allclose(pieces[:, 1, 1], (2 * poles[:, 2] + following[:, 0]) / 3, rtol=0, atol=32 * unit)
    np.testing.assert_allclose(pieces[:, 1, 2], (poles[:, 2] + 2 * following[:, 0]) / 3, rtol=0, atol=32 * unit)


@each
@pytest.mark.parametrize("closed", [False, True])
@given(points=point_rows(least=3))
def test_the_curve_takes_the_estimated_derivatives_at_the_points(parametrization, closed, points):
    curve = local_spline(points, closed, parametrization)
    u = parametrize(points, parametrization, closed)
    n = len(points)
    around = np.arange(-4, n + 5) % n if closed else np.arange(n)
    steps = np.diff(u)[around[:-1]] if closed else np.diff(u)
    trust = np.inf if parametrization == "uniform" else 0.1
    first, second = neighbour_derivatives(points[around].T, steps, trust)[..., 4 : 4 + n] if closed else (
        neighbour_derivatives(points.T, steps, trust)
    )  # fmt: skip
    spans = np.diff(curve.distinct_knots)
    unit = EPS * magnitude(curve) / spans.min()
    np.testing.assert_allclose(curve.derivative(u[:n]), first.T, rtol=0, atol=64 * unit)
    inner = slice(0, n) if closed else slice(1, n - 1)
    np.testing.assert_allclose(
        curve.derivative(u[:n], 2)[inner], second.T[inner], rtol=0, atol=256 * unit / spans.min()
    )


# Interpolation and smoothness


def check_interpolates_and_is_c2(points, closed, parametrization):
    curve = local_spline(points, closed, parametrization)
    u = parametrize(points, parametrization, closed)
    unit = EPS * magnitude(curve)
    np.testing.assert_allclose(curve(u[: len(points)]), points, rtol=0, atol=32 * unit)
    assert curve.domain == (u[0], u[-1])
    assert curve.closed == closed or np.array_equal(points[0], points[-1])
    assert set(curve.multiplicities[1:-1]) <= {1}
    knots = curve.distinct_knots[1:-1]
    pieces, spans = curve.pieces(), np.diff(curve.distinct_knots)
    left = 6 * np.diff(pieces[:-1, 1:], n=2, axis=1)[:, 0] / spans[:-1, None] ** 2
    np.testing.assert_allclose(curve.derivative(knots, 2) * np.minimum(spans[:-1], spans[1:])[:, None] ** 2,
                               left * np.minimum(spans[:-1], spans[1:])[:, None] ** 2,
                               rtol=0, atol=256 * unit)  # fmt: skip
    if closed:
        least = min(spans[0], spans[-1])
        for order in (1, 2):
            jump = curve.derivative(u[0], order) - curve.derivative(u[-1], order)
            assert np.abs(jump).max() * least**order <= 256 * unit


@each
@given(points=point_rows(), closed=st.booleans())
def test_the_curve_passes_through_random_points_and_is_c2(parametrization, points, closed):
    check_interpolates_and_is_c2(points, closed and len(points) > 2, parametrization)


@pytest.mark.parametrize("shape", shapes())
def test_the_curve_passes_through_real_points_and_is_c2(shape):
    for parametrization in ALL:
        check_interpolates_and_is_c2(shape.points, shape.closed, parametrization)


@each
@pytest.mark.parametrize("more", [-2, 0, 1, 4, _BLOCK + 3])
@pytest.mark.parametrize("closed", [False, True])
def test_blocks_of_many_points_leave_no_trace(parametrization, more, closed):
    """Points pass through in blocks: a window of the long curve is the curve of the window's points."""
    n = _BLOCK + more
    angle = np.linspace(0, 40, n)
    points = np.column_stack([angle * np.cos(angle), angle * np.sin(angle), np.sqrt(angle)])
    pieces, intervals = per_interval(local_spline(points, closed, parametrization), n, closed)
    for start in (min(_BLOCK - 30, n - 60), n - 60):
        part, inside = per_interval(local_spline(points[start : start + 60], False, parametrization), 60, False)
        long, short = pieces[(intervals >= start + 4) & (intervals < start + 54)], part[(inside >= 4) & (inside < 54)]
        np.testing.assert_allclose(short, long, rtol=0, atol=1e-12 * 40)


@each
def test_two_points_give_their_segment_at_even_speed(parametrization):
    curve = local_spline([[1, 2], [4, 6]], parametrization=parametrization)
    np.testing.assert_allclose(curve([0.0, 2.5, 5.0]), [[1, 2], [2.5, 4], [4, 6]], rtol=0, atol=8 * EPS * 6)
    np.testing.assert_allclose(curve.derivative([0.0, 5.0]), [[0.6, 0.8]] * 2, rtol=8 * EPS)


@given(st.integers(3, 12), st.integers(0, 99))
def test_cubics_sampled_evenly_come_back_exactly(n, seed):
    """Three points give the parabola, four and more any cubic."""
    coefficients = np.random.default_rng(seed).normal(size=(3 if n == 3 else 4, 2))
    places = np.linspace(-1, 1, n)
    curve = local_spline(np.polynomial.polynomial.polyval(places, coefficients).T, parametrization="uniform")
    t = np.linspace(0, 1, 301)
    truth = np.polynomial.polynomial.polyval(2 * t - 1, coefficients).T
    np.testing.assert_allclose(curve(t * curve.domain[1]), truth, rtol=0, atol=16 * n * EPS * magnitude(curve))


@pytest.mark.parametrize("parametrization", ["centripetal", "chord"])
def test_points_on_a_line_stay_on_it_and_in_order(parametrization):
    along = np.array([0, 1, 1.001, 1.002, 2, 5, 5.003, 9])
    curve = local_spline(np.outer(along, [0.6, 0.8]), parametrization=parametrization)
    points = curve(np.linspace(*curve.domain, 2001))
    longer = 1e3  # a slope over a short chord, with that chord's rounding, carries on over long ones
    np.testing.assert_allclose(points @ [-0.8, 0.6], 0, atol=16 * EPS * 9 * longer)
    assert np.diff(points @ [0.6, 0.8]).min() >= -1e-3 * 0.001


# Order


@each
def test_errors_on_the_circle_are_the_stated_ones(parametrization):
    assert f"{ring_error(12, parametrization):.1e}" == "7.6e-05"
    assert f"{ring_error(24, parametrization):.1e}" == "2.2e-07"


@each
def test_order_on_the_circle_is_more_than_five_and_a_half_at_first(parametrization):
    assert np.log2(ring_error(12, parametrization) / ring_error(24, parametrization)) >= 5.5


@each
def test_order_on_the_circle_ends_as_four_as_it_must_for_cubics(parametrization):
    errors = np.array([ring_error(n, parametrization) for n in (48, 96, 192)])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), 4, atol=0.4)


@each
def test_an_arc_with_open_ends_is_met_to_fourth_order(parametrization):
    errors = np.array([ring_error(n, parametrization, closed=False) for n in (24, 48, 96)])
    assert np.log2(errors[:-1] / errors[1:]).min() >= 3.7


@pytest.mark.parametrize(("parametrization", "order"), [("centripetal", 1.9), ("chord", 3.7)])
def test_chord_length_is_the_most_exact_on_smooth_curves_sampled_unevenly(parametrization, order):
    errors = np.array([ring_error(n, parametrization, spread=0.5) for n in (96, 192, 384)])
    assert np.log2(errors[:-1] / errors[1:]).min() >= order


@pytest.mark.parametrize(("n", "least", "most"), [(12, 0.985, 1.005), (24, 0.999, 1.001)])
def test_curvature_on_the_circle_is_nearly_one(n, least, most):
    ring = local_spline(turn(n), closed=True)
    bends = np.linalg.norm(ring.curvature(np.linspace(*ring.domain, 200 * n + 1)), axis=1)
    assert least <= bends.min() <= bends.max() <= most


# Uneven spacing


def stairs():
    steps = np.array([[1, 0], [0, 1e-3], [1, 0], [0, 1], [1e-3, 0], [0, 1], [1e-3, 0], [1e-3, 0], [1, 0], [0, -1e-3]])
    return np.vstack([[0, 0], steps.cumsum(axis=0)])


def crowded_ring():
    """A circle with three points a thousandth of the others' spacing apart, here and there."""
    angle = np.sort(np.concatenate([np.arange(12.0), [1e-3, 2e-3, 5 - 1e-3, 5 + 1e-3, 8 + 1e-3]])) * np.pi / 6
    return np.column_stack([np.cos(angle), np.sin(angle)])


def hairpin():
    return np.array([[0, 0], [1, 0], [2, 0], [2.001, 0.001], [2, 0.002], [1, 0.002], [0, 0.002]], float)


def saw_in_space():
    steps = np.tile([[1, 1, 0], [1e-3, -1e-3, 0], [1, -1, 0.5], [0, 0, 1e-3]], (4, 1))
    return steps.cumsum(axis=0)


UNEVEN = {
    "stairs": (stairs(), False),
    "crowded ring": (crowded_ring(), True),
    "hairpin": (hairpin(), False),
    "saw": (saw_in_space(), False),
    "crowded": (OWN["crowded"].points, False),
}
uneven = pytest.mark.parametrize(("points", "closed"), UNEVEN.values(), ids=UNEVEN.keys())


def bulge_and_run_back(points, closed, parametrization, count=200):
    """How far the curve leaves each chord, and how far it runs back along it, at most; in parts of the chord."""
    curve = local_spline(points, closed, parametrization)
    u = parametrize(points, parametrization, closed)
    ends = np.vstack([points, points[:1]]) if closed else points
    t = np.clip(np.linspace(u[:-1], u[1:], count + 1), *curve.domain)
    places, chords = curve(t), np.diff(ends, axis=0)
    long = np.linalg.norm(chords, axis=1)
    away = bezier.distance_to_segment(places, ends[:-1], ends[1:]) / long
    along = np.einsum("knd,nd->kn", places - ends[:-1], chords) / long**2
    return away.max(), (np.maximum.accumulate(along, axis=0) - along).max()


def test_the_shapes_are_as_uneven_as_they_say():
    for points, closed in UNEVEN.values():
        chords = np.linalg.norm(np.diff(np.vstack([points, points[:1]]) if closed else points, axis=0), axis=1)
        assert chords.max() / chords.min() > 500


@uneven
def test_centripetal_curves_bulge_by_less_than_a_quarter_of_a_chord_and_do_not_run_back(points, closed):
    bulge, back = bulge_and_run_back(points, closed, "centripetal")
    assert bulge < 0.25
    assert back < 1e-3


@uneven
def test_chord_length_curves_bulge_by_hardly_more_than_a_quarter_of_a_chord(points, closed):
    assert bulge_and_run_back(points, closed, "chord")[0] < 0.26


@uneven
def test_uniform_curves_bulge_and_run_back(points, closed):
    bulge, back = bulge_and_run_back(points, closed, "uniform")
    assert bulge > 10
    assert back > 0.1


@st.composite
def wild_walks(draw):
    """Steps a thousand times longer than others, in any direction, back on themselves too."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, d = draw(st.integers(3, 20)), draw(st.integers(2, 3))
    steps = rng.normal(size=(n, d)) if draw(st.booleans()) else rng.choice([-1.0, 0.0, 1.0, 1.0], (n, d)) + 1e-2
    steps *= (10.0 ** rng.uniform(-3, 0, (n, 1))) / np.linalg.norm(steps, axis=1)[:, None]
    return steps.cumsum(axis=0)


@given(wild_walks(), st.booleans())
def test_wild_points_bulge_by_less_than_a_quarter_of_a_chord(points, closed):
    bulge, back = bulge_and_run_back(points, closed, "centripetal")
    assert bulge < 0.25
    assert back < 4e-3
    assert bulge_and_run_back(points, closed, "chord")[0] < 0.26


# Locality


@each
@pytest.mark.parametrize("closed", [False, True])
@given(data=st.data())
def test_a_moved_point_changes_the_shape_only_up_to_its_third_neighbour(parametrization, closed, data):
    """Near an open end, up to the fourth: the five points nearest the end share their quartic."""
    points = data.draw(point_rows(least=12, rough=False))
    n = len(points)
    moved = data.draw(st.integers(0, n - 1))
    other = points.copy()
    other[moved] += 0.5
    before, intervals = per_interval(local_spline(points, closed, parametrization), n, closed)
    after, _ = per_interval(local_spline(other, closed, parametrization), n, closed)
    near = (intervals - moved + 3) % n < 6 if closed else (intervals >= moved - 3) & (intervals < moved + 3)
    if not closed:
        near |= ((intervals == 0) & (moved == 4)) | ((intervals == n - 2) & (moved == n - 5))
    apart = np.abs(before - after).max(axis=(1, 2))
    assert apart[~near].max() <= 1e-12 * np.abs(points).max()
    assert apart[near].max() > 0.1
    if parametrization == "uniform":  # elsewhere the trust may take a far neighbour's say
        assert all(apart[near & (intervals == k)].max() > 1e-6 for k in set(intervals[near]))


# Laws


@each
@pytest.mark.parametrize("closed", [False, True])
@given(points=point_rows(least=3), seed=st.integers(0, 99))
def test_moved_points_give_the_moved_curve(parametrization, closed, points, seed):
    d = points.shape[1]
    matrix, offset = 2.5 * rotation(d, seed), np.arange(d)
    moved = local_spline(points, closed, parametrization).transformed(matrix, offset)
    found = local_spline(points @ matrix.T + offset, closed, parametrization)
    np.testing.assert_allclose(found.poles, moved.poles, rtol=0, atol=grown_rounding(moved))
    np.testing.assert_allclose(found.knots, 2.5 * moved.knots, rtol=0, atol=1e-12 * found.knots[-1])


@given(points=point_rows(least=3), seed=st.integers(0, 99), closed=st.booleans())
def test_uniform_curves_follow_any_affine_map(points, seed, closed):
    d = points.shape[1]
    rng = np.random.default_rng(seed)
    matrix, offset = rng.normal(size=(d, d)) + 2 * np.eye(d), rng.normal(size=d)
    moved = local_spline(points, closed, "uniform").transformed(matrix, offset)
    found = local_spline(points @ matrix.T + offset, closed, "uniform")
    allowed = 1e-13 * (np.abs(matrix).sum(axis=1).max() * np.abs(moved.poles).max() + np.abs(offset).max())
    np.testing.assert_allclose(found.poles, moved.poles, rtol=0, atol=allowed)


@each
@given(points=point_rows(least=3), closed=st.booleans())
def test_reversed_points_give_the_reversed_curve(parametrization, points, closed):
    curve = local_spline(points, closed, parametrization).reversed()
    backwards = np.roll(points[::-1], 1, axis=0) if closed else points[::-1]
    other = local_spline(backwards, closed, parametrization)
    np.testing.assert_allclose(other.poles, curve.poles, rtol=0, atol=grown_rounding(curve))
    np.testing.assert_allclose(other.knots, curve.knots, rtol=0, atol=1e-12 * curve.knots[-1])


@each
@given(points=point_rows(least=3))
def test_the_first_point_may_be_repeated_or_not(parametrization, points):
    once = local_spline(points, True, parametrization)
    twice = local_spline(np.vstack([points, points[:1]]), True, parametrization)
    np.testing.assert_array_equal(once.poles, twice.poles)
    np.testing.assert_array_equal(once.knots, twice.knots)


@each
@given(points=point_rows(least=3), by=st.integers(1, 5))
def test_a_closed_curve_does_not_care_where_it_begins(parametrization, points, by):
    by %= len(points)
    here = local_spline(points, True, parametrization)
    there = local_spline(np.roll(points, -by, axis=0), True, parametrization)
    moved = np.roll(here.pieces(), -3 * by, axis=0)
    # Five-point estimates take differences of differences: on spans 1e5 apart four times the rounding was seen.
    np.testing.assert_allclose(there.pieces(), moved, rtol=0, atol=8 * grown_rounding(here))


@each
@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_scale_changes_nothing_but_size(parametrization, scale):
    points = OWN["hook"].points
    curve, other = (local_spline(s * points, parametrization=parametrization) for s in (1, scale))
    assert other.isclose(BSpline(scale * curve.poles, scale * curve.knots), tolerance=64 * EPS)


@each
@pytest.mark.parametrize("closed", [False, True])
def test_an_offset_costs_no_more_than_its_own_rounding(parametrization, closed):
    points = 1e-3 * turn(30) * [[1.0, 0.4]] + 6.4e6 - 6.4e6
    near, far = (local_spline(points + offset, closed, parametrization) for offset in (0, 6.4e6))
    np.testing.assert_allclose(far.poles - 6.4e6, near.poles, rtol=0, atol=4 * EPS * 6.4e6)
    np.testing.assert_allclose(far.knots, near.knots, rtol=0, atol=64 * EPS * near.knots[-1])


@pytest.mark.parametrize("scale", [2.0**-490, 2.0**-300, 2.0**300, 2.0**490])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("parametrization", ["chord", "uniform"])
def test_any_scale_gives_the_same_poles(scale, closed, parametrization):
    points = np.random.default_rng(3).normal(size=(30, 3)).cumsum(axis=0)
    here, there = (local_spline(factor * points, closed, parametrization) for factor in (1.0, scale))
    assert np.array_equal(there.poles, scale * here.poles)
    assert np.array_equal(there.knots, scale * here.knots)
