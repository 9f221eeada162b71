"""Cleaning and parametrization of points: what is kept, what is counted, what is refused."""

from math import fsum

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cadfit import cardinal_pieces, cardinal_spline, clean, fit_planes, interpolate, local_spline, parametrize
from cadfit.fitting.dominant import turn_angles
from cadfit.points.clean import as_contour
from cadfit.points.measures import chord_lengths, distances_from, extent, lengths_along, middle

from corpus_data import point_rows, rotation, shapes
from reference import EPS

FITS = [clean, parametrize, cardinal_pieces, cardinal_spline, local_spline, interpolate, fit_planes]
rows = st.lists(st.tuples(st.integers(0, 2), st.integers(0, 1)), min_size=1, max_size=12)

# measures

MANY = np.random.default_rng(3).normal(size=(20_000, 3)) * [1.0, 1e-9, 1e9]


@pytest.mark.parametrize("points", [MANY, MANY[:, :1], MANY[:9], MANY[:1]])
def test_lengths_are_those_of_numpy_to_the_last_bit(points):
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_array_equal(chord_lengths(points), chords)
    np.testing.assert_array_equal(lengths_along(points), np.cumsum(np.append(0.0, chords)))
    for places in (points[0], points[::-1]):
        np.testing.assert_array_equal(distances_from(points, places), np.linalg.norm(points - places, axis=1))
    assert extent(points) == np.ptp(points, axis=0).max()


@pytest.mark.parametrize("points", [MANY, MANY[:3], MANY * 1e-60, MANY * 1e50, MANY + 1e12, np.zeros((2, 3)) + 0.1])
def test_the_middle_is_rounded_but_once_and_has_no_order(points):
    found = middle(points)
    exact = np.array([fsum(column) for column in points.T]) / len(points)
    assert np.all(np.abs(found - exact) <= EPS * np.abs(exact) + 2.0**-60 * np.abs(points).max(axis=0))
    np.testing.assert_array_equal(middle(points[::-1]), found)
    np.testing.assert_array_equal(middle(np.random.default_rng(4).permutation(points)), found)


# clean


@given(rows, st.sampled_from([None, True, False]))
def test_cleaning_keeps_each_first_row_of_a_run(given_rows, closed):
    array = np.array(given_rows, dtype=float)
    runs = [k for k in range(len(array)) if k == 0 or given_rows[k] != given_rows[k - 1]]
    returns = len(runs) > 1 and given_rows[runs[-1]] == given_rows[0]
    will_close = closed if closed is not None else returns and len({*given_rows}) > 2
    expected = runs[:-1] if will_close and returns else runs
    assume(len({*given_rows}) >= (3 if will_close else 2))
    found = clean(given_rows, closed)
    np.testing.assert_array_equal(found.kept, expected)
    np.testing.assert_array_equal(found.points, array[expected])
    np.testing.assert_array_equal(found.dropped, sorted(set(range(len(array))) - set(runs)))
    np.testing.assert_array_equal(array[found.dropped], array[found.dropped - 1])
    assert found.closed == will_close
    assert np.all(np.any(found.points[1:] != found.points[:-1], axis=1))
    if will_close:
        assert np.any(found.points[0] != found.points[-1])


@given(rows)
def test_cleaning_twice_changes_nothing(given_rows):
    assume(len({*given_rows}) > 2)
    once = clean(given_rows)
    twice = clean(once.points, once.closed)
    np.testing.assert_array_equal(twice.points, once.points)
    assert len(twice.dropped) == 0


@pytest.mark.parametrize(
    ("points", "closed", "kept", "dropped", "closes"),
    [
        ([(0, 0), (0, 0), (1, 0), (1, 0), (1, 0), (2, 0)], None, [0, 2, 5], [1, 3, 4], False),
        ([(0, 0), (1, 0), (0, 1), (0, 0)], None, [0, 1, 2], [], True),
        ([(0, 0), (1, 0), (0, 1), (0, 0)], False, [0, 1, 2, 3], [], False),
        ([(0, 0), (1, 0), (0, 1), (0, 0), (0, 0)], None, [0, 1, 2], [4], True),
        ([(0, 0), (1, 0), (0, 1)], True, [0, 1, 2], [], True),
        ([(0, 0), (1, 0), (0, 0)], None, [0, 1, 2], [], False),
        ([(0.0, 1.0), (-0.0, 1.0), (1.0, 1.0)], None, [0, 2], [1], False),
        ([(0, 0), (5e-324, 0), (1, 0)], None, [0, 1, 2], [], False),
    ],
)
def test_what_cleaning_does_by_hand(points, closed, kept, dropped, closes):
    found = clean(points, closed)
    assert (found.kept.tolist(), found.dropped.tolist(), found.closed) == (kept, dropped, closes)


@pytest.mark.parametrize(
    ("points", "closed", "says"),
    [
        ([(1, 2)] * 5, None, "a curve needs at least 2 distinct points; the 5 given have 1"),
        ([(1, 2), (1, 2), (3, 4)], True, "a closed curve needs at least 3 distinct points; the 3 given have 2"),
        ([(1, 2), (3, 4), (1, 2)], True, "a closed curve needs at least 3 distinct points; the 3 given have 2"),
    ],
)
def test_too_few_distinct_points_are_counted(points, closed, says):
    with pytest.raises(ValueError, match=says):
        clean(points, closed)


@pytest.mark.parametrize("shape", shapes())
def test_clean_shapes_stay_as_they_are(shape):
    again = clean(shape.points, shape.closed)
    np.testing.assert_array_equal(again.points, shape.points)
    np.testing.assert_array_equal(again.kept, np.arange(len(shape.points)))


# Every fit refuses the same points


@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize(
    ("points", "says"),
    [
        ([(0, 0), (1, np.nan), (2, 0)], r"row 1 of the points is not finite: \[1.0, nan\]"),
        ([(0, 0), (1, 1), (2, -np.inf)], r"row 2 of the points is not finite: \[2.0, -inf\]"),
        ([(0, 0), (1, 10**400), (2, 0)], "row 1 of the points is not a row of numbers"),
        (np.ma.masked_greater([[0.0, 0], [1, 1], [2, 9e9]], 1e9), "row 2 of the points is masked"),
        ([(0, 0), (1, None), (2, 0)], r"row 1 of the points is not finite: \[1.0, nan\]"),
        ([(0, 0), (1, 1), (2, 0, 3)], r"row 2 of the points has 3 numbers, the rows before it 2: \(2, 0, 3\)"),
        ([(0, 0), (1,), (2, 0)], r"row 1 of the points has 1 numbers, the rows before it 2: \(1,\)"),
        ([(0, 0), ("x", 1), (2, 0)], r"row 1 of the points is not a row of numbers: \('x', 1\)"),
        ([(0, 0), (1j, 1), (2, 0)], r"row 1 of the points is not a row of numbers: \(1j, 1\)"),
        ([0, 1, 2], r"shape \(n, d\): n rows of d coordinates, not \(3,\)"),
        ([[[0, 0], [1, 1]]], r"n rows of d coordinates, not \(1, 2, 2\)"),
        (np.zeros((3, 0)), r"n rows of d coordinates, not \(3, 0\)"),
        ([], r"n rows of d coordinates, not \(0,\)"),
        (7.0, r"n rows of d coordinates, not \(\)"),
        (None, r"n rows of d coordinates, not \(\)"),
        ("nothing", "row 0 of the points is not a row of numbers: 'n'"),
        ([(1, 2)], "at least 2 points are needed, not 1"),
    ],
)
def test_bad_points_are_refused_by_row(fit, points, says):
    with pytest.raises(ValueError, match=says):
        fit(points)


@pytest.mark.parametrize("fit", FITS[2:])
@pytest.mark.parametrize("points", [[(0, 0), (1, 0)], [(0, 0), (1, 0), (0, 0)]])
def test_a_closed_curve_needs_three_points(fit, points):
    with pytest.raises(ValueError, match="a closed curve needs at least 3 points, not 2"):
        fit(points, closed=True)


@pytest.mark.parametrize("fit", [parametrize, local_spline, interpolate])
@pytest.mark.parametrize(
    ("points", "closed", "says"),
    [
        ([(0, 0), (1, 0), (1, 0), (2, 0)], False, r"rows 1 and 2 of the points are equal: .* cadfit.clean"),
        ([(3, 3)] * 4, False, "rows 0 and 1 of the points are equal"),
        ([(0, 0), (1, 0), (2, 0), (2, 0)], True, "rows 2 and 3 of the points are equal"),
    ],
)
def test_equal_neighbours_are_named_where_spacing_counts(fit, points, closed, says):
    with pytest.raises(ValueError, match=says):
        fit(points, closed=closed)


@pytest.mark.parametrize("fit", [parametrize, local_spline, interpolate, turn_angles])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("scale", [1e-300, 1e-155, 1e153, 1e300, 4e307])
def test_points_too_small_or_large_to_square_are_told_so(fit, closed, scale):
    with pytest.raises(ValueError, match=r"size must be between 1e-150 and 1e\+150, and it is .*: scale them"):
        fit(scale * np.array([(0, 0), (1, 2), (3, 1), (4, 4)]), closed=closed)


@pytest.mark.parametrize("scale", [1e-149, 1e149])
def test_points_of_any_other_size_are_the_same(scale):
    points = np.random.default_rng(2).normal(size=(20, 2))
    for fit in (local_spline, interpolate):
        np.testing.assert_allclose(fit(scale * points).poles / scale, fit(points).poles, rtol=0, atol=1e-12)
    np.testing.assert_allclose(turn_angles(scale * points), turn_angles(points), rtol=0, atol=1e-12)


def test_neighbours_too_near_to_square_are_as_near_as_others_with_uniform_parameters():
    points = np.array([(2, 0), (0, 0), (1e-200, 0), (-1, 2)])
    assert parametrize(points, "uniform")[1:3] == pytest.approx(
        parametrize(points, "uniform")[-1] * np.array([1, 2]) / 3
    )
    with pytest.raises(ValueError, match=r"rows 1 and 2 of the points are .* apart, too near"):
        parametrize(points, "chord")


def test_results_do_not_change_with_the_callers_array():
    points = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 3.0]])
    cleaned, pieces = clean(points).points, cardinal_pieces(points)
    curves = [fit(points) for fit in FITS[3:]]
    for result in (cleaned, pieces, *(array for curve in curves for array in (curve.poles, curve.knots))):
        assert not np.shares_memory(result, points)


@pytest.mark.parametrize("fit", FITS[2:])
@given(points=point_rows(dimensions=(2, 3), least=3), closed=st.booleans())
def test_fits_leave_the_points_alone(fit, points, closed):
    before = points.copy()
    fit(points, closed=closed)
    np.testing.assert_array_equal(points, before)


def test_a_contour_may_repeat_its_first_point():
    points = [(0, 0), (1, 0), (0, 1)]
    np.testing.assert_array_equal(as_contour([*points, (0, 0)], closed=True), points)
    np.testing.assert_array_equal(as_contour(points, closed=True), points)
    np.testing.assert_array_equal(as_contour([*points, (0, 0)], closed=False), [*points, (0, 0)])


# parametrize


@pytest.mark.parametrize(("parametrization", "power"), [("uniform", 0.0), ("centripetal", 0.5), ("chord", 1.0)])
@given(points=point_rows(), closed=st.booleans())
def test_parameters_step_by_a_power_of_the_chord_over_its_length(parametrization, power, points, closed):
    u = parametrize(points, parametrization, closed)
    around = np.vstack([points, points[:1]]) if closed else points
    chords = np.array([np.linalg.norm(b - a) for a, b in zip(around[:-1], around[1:], strict=True)])
    expected = np.concatenate([[0], np.cumsum(chords**power)])
    expected *= chords.sum() / expected[-1]
    assert u[0] == 0
    np.testing.assert_allclose(u, expected, rtol=0, atol=8 * len(u) * EPS * chords.sum())
    assert u[-1] == pytest.approx(chords.sum(), rel=8 * EPS)


@pytest.mark.parametrize("parametrization", ["uniform", "centripetal", "chord"])
@pytest.mark.parametrize("scale", [1e-9, 1e9])
@given(points=point_rows(dimensions=(3,)), seed=st.integers(0, 99))
def test_parameters_turn_with_nothing_and_grow_with_size(parametrization, scale, points, seed):
    u = parametrize(points, parametrization)
    moved = parametrize(scale * (points @ rotation(3, seed).T), parametrization)
    np.testing.assert_allclose(moved, scale * u, rtol=0, atol=1e-12 * scale * u[-1])


@pytest.mark.parametrize("parametrization", ["", "Chord", None, 0.5])
def test_unknown_parametrizations_are_named(parametrization):
    for use in (parametrize, local_spline, interpolate):
        with pytest.raises(ValueError, match=r"must be one of \('uniform', 'centripetal', 'chord'\), not "):
            use([(0, 0), (1, 1)], parametrization=parametrization)


@pytest.mark.parametrize("fit", [parametrize, local_spline, interpolate])
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize(("gap", "parametrization"), [(6e-17, "chord"), (1e-40, "chord"), (1e-40, "centripetal")])
def test_neighbours_too_near_for_parameters_are_named(fit, closed, gap, parametrization):
    points = [(2, 0), (1, 1), (0, 0), (gap, 0), (-1, 2), (0, 3)]  # cos(pi / 2) is 6e-17
    with pytest.raises(ValueError, match=f"rows 2 and 3 of the points are {gap} apart, too near"):
        fit(points, parametrization=parametrization, closed=closed)
    fit(points, parametrization="uniform", closed=closed)


@pytest.mark.parametrize("gap", [1e-15, 3e-15, 1e-14, 1e-13])
def test_neighbours_barely_apart_are_fitted_or_named(gap):
    points = [(2, 0), (1, 1), (0, 0), (gap, 0), (-1, 2), (0, 3)]
    for closed in (False, True):
        try:
            u = parametrize(points, "chord", closed)
        except ValueError:
            assert gap < 1e-13
            continue
        for fit in (local_spline, interpolate):
            curve = fit(points, parametrization="chord", closed=closed)
            np.testing.assert_allclose(curve(u[:6]), points, rtol=0, atol=1e-14)


@pytest.mark.parametrize("rows", ["ABABA", "ABA", "AABBAABBA"])
def test_back_and_forth_between_two_points_is_no_contour(rows):
    points = [{"A": (0.0, 1.0), "B": (2.0, 1.0)}[row] for row in rows]
    found = clean(points)
    assert not found.closed
    assert len(found.points) == len(found.kept)
    np.testing.assert_array_equal(found.points[[0, -1]], [points[0]] * 2)
    with pytest.raises(ValueError, match="at least 3 distinct points"):
        clean(points, closed=True)
    once_elsewhere = [*points[:-1], (5.0, 5.0), points[-1]]
    assert clean(once_elsewhere).closed
