"""Dominant points: the paper's method taken literally, laws, and what the default is worth against the optimum."""

from array import array
from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cadfit import cardinal_pieces, cardinal_spline, dominant_points, fit_dominant, parametrize
from cadfit.bezier import distance_to_segment
from cadfit.fitting.dom import dom
from cadfit.fitting.dominant import initial_dominant_points, refine_dominant_points, square_error, turn_angles
from cadfit.fitting.dominant_optimum import optimal_dominant_points
from cadfit.fitting.dominant_pieces import piece_squares, points_inside, square_distances

import reference
from corpus_data import point_rows, rotation, shapes, turn


def thinned(shape, most=40):
    """Rows of a shape, evenly taken, so that the literal version is quick."""
    return shape.points[:: max(1, len(shape.points) // most)][:most]


def same_as_literal(points, count, closed):
    angles = turn_angles(points, closed).tolist()
    start = initial_dominant_points(points, count, closed)
    assert start.tolist() == reference.initial_dominant_points(angles, count, closed)
    found, history = refine_dominant_points(points, start, closed)
    indices, errors = reference.refined_dominant_points(points, angles, start.tolist(), closed)
    assert found.tolist() == indices
    reach = np.abs(points).max()
    np.testing.assert_allclose(history, errors, rtol=1e-9, atol=1e-14 * errors[0] + 1e-28 * reach**2)
    np.testing.assert_allclose(square_error(points, found, closed), errors[-1], rtol=1e-12, atol=1e-28 * reach**2)
    return len(history) - 1


def contour(points, closed):
    """The points; of a closed curve without the last ones that repeat the first."""
    while closed and np.array_equal(points[0], points[-1]):
        assume(len(points) > 4)
        points = points[:-1]
    return points


@st.composite
def rough_points(draw):
    """Points at random, or on a small grid: repeats, straight runs, cusps, points behind the ends of chords."""
    if draw(st.booleans()):
        return draw(point_rows(dimensions=(1, 2, 3, 4), least=4, most=26))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.integers(-2, 3, (draw(st.integers(4, 26)), draw(st.integers(1, 3)))).cumsum(axis=0).astype(float)


@given(rough_points(), st.floats(0, 1), st.booleans())
def test_the_search_is_the_literal_one(points, part, closed):
    points = contour(points, closed)
    count = 3 + int(part * (len(points) - 3))
    same_as_literal(points, count, closed)


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=600))
def test_the_search_is_the_literal_one_on_real_curves(shape):
    points = thinned(shape)
    swaps = [
        same_as_literal(points, min(len(points), 3 + round(part * len(points))), shape.closed)
        for part in (0.8, 0.6, 0.3)
    ]
    assert len(points) < 20 or sum(swaps) > 0


@pytest.mark.parametrize("closed", [False, True])
def test_the_search_is_the_literal_one_where_pieces_are_long(closed):
    t = np.linspace(0, 5, 240)
    points = np.column_stack([(1 + t) * np.cos(t), (1 + t) * np.sin(2 * t), t * t])
    assert sum(same_as_literal(points, count, closed) for count in (3, 4, 7)) > 0


@given(rough_points(), st.integers(0, 2**32 - 1))
def test_a_piece_in_plain_floats_is_the_same_to_the_last_bit(points, seed):
    rows = np.random.default_rng(seed).integers(0, len(points), 4)
    inside, columns = points_inside(len(points), rows[None]), np.ascontiguousarray(points.T[:3])
    if rows[1] != rows[2]:
        axes = [array("d", axis) for axis in [*columns, *np.zeros((3 - len(columns), len(points)))]]
        assert piece_squares(*axes, *rows.tolist()) == square_distances(columns, rows[None], inside)[1].tolist()


@given(point_rows(dimensions=(2,), least=3))
def test_turn_angles_are_the_papers(points):
    angles = [reference.turn_angle(*points[k - 1 : k + 2]) for k in range(1, len(points) - 1)]
    np.testing.assert_allclose(turn_angles(points), [0.0, *angles, 0.0], rtol=0, atol=1e-7)  # what acos keeps


def test_turn_angles_of_turns_anyone_knows():
    assert turn_angles(turn(12), closed=True) == pytest.approx(2 * np.pi / 12, abs=1e-15)
    assert turn_angles([(0, 0), (1, 0), (2, 1e-9)])[1] == pytest.approx(1e-9, rel=1e-6)  # acos would say 0
    assert turn_angles([(0, 0, 0), (1, 0, 0), (1, 0, 1), (1, 0, 0), (1, 0, 0)]).tolist() == [0, np.pi / 2, np.pi, 0, 0]


@given(rough_points(), st.integers(0, 2**32 - 1), st.booleans())
def test_the_square_error_is_the_literal_one(points, seed, closed):
    points = contour(points, closed)
    rng, n = np.random.default_rng(seed), len(points)
    chosen = np.sort(rng.choice(n, rng.integers(3, n + 1), replace=False))
    if not closed:
        chosen = np.unique([0, *chosen, n - 1])
    error = square_error(points, chosen, closed)
    small = 1e-26 * np.abs(points).max() ** 2
    assert error == pytest.approx(reference.dominant_error(points, chosen.tolist(), closed), rel=1e-12, abs=small)
    moved = 3.0 * points @ rotation(points.shape[1], seed).T + 7.0
    assert square_error(moved, chosen, closed) == pytest.approx(9.0 * error, rel=1e-6, abs=1e4 * small)
    if closed and np.any(points[0] != points[1]):
        assert square_error(np.roll(points, -1, axis=0), np.sort((chosen - 1) % n), True) == pytest.approx(
            error, rel=1e-12, abs=small
        )
    elif not closed:
        assert square_error(points[::-1], n - 1 - chosen[::-1]) == pytest.approx(error, rel=1e-6, abs=small)


def check(points, found, count, closed):
    """What holds for any answer."""
    assert len(found.indices) == count
    assert np.all(np.diff(found.indices) > 0)
    assert closed or (found.indices[0], found.indices[-1]) == (0, len(points) - 1)
    assert found.square_error == square_error(points, found.indices, closed)
    assert np.all(np.diff(found.history) < 0)
    chosen = points[found.indices]
    if not closed or np.any(chosen[0] != chosen[-1]):  # there cardinal_pieces would take the last for a repeat
        np.testing.assert_allclose(found.pieces, cardinal_pieces(chosen, closed=closed), rtol=1e-12, atol=1e-12)
    assert not any(array.flags.writeable for array in (found.indices, found.pieces, found.history))


@given(rough_points(), st.floats(0, 1), st.booleans())
def test_any_points_and_count(points, part, closed):
    points = contour(points, closed)
    count = 3 + int(part * (len(points) - 3))
    best, paper = (dominant_points(points, count, closed=closed, method=method) for method in ("best", "paper"))
    check(points, best, count, closed)
    check(points, paper, count, closed)
    assert best.square_error <= paper.square_error


@given(point_rows(dimensions=(1, 2, 3), least=4, most=9), st.floats(0, 1))
def test_the_optimum_is_the_best_of_all_choices(points, part):
    n = len(points)
    count = 2 + int(part * (n - 2))
    found = optimal_dominant_points(points, count).tolist()
    choices = ([0, *inner, n - 1] for inner in combinations(range(1, n - 1), count - 2))
    least = min(reference.dominant_error(points, choice, False) for choice in choices)
    assert square_error(points, found) <= least * (1 + 1e-9) + 1e-24 * np.abs(points).max() ** 2


@given(rough_points(), st.floats(0, 1), st.booleans())
def test_the_default_of_few_points_is_the_best_of_all_choices(points, part, closed):
    points = contour(points, closed)[:10]
    n = len(points)
    count = 3 + int(part * (n - 3))
    choices = (
        combinations(range(n), count) if closed else ((0, *c, n - 1) for c in combinations(range(1, n - 1), count - 2))
    )
    least = min(reference.dominant_error(points, list(choice), closed) for choice in choices)
    best = dominant_points(points, count, closed=closed).square_error
    assert best <= least * (1 + 1e-9) + 1e-24 * np.abs(points).max() ** 2


def test_the_default_is_the_optimum_of_sixty_points():
    rng = np.random.default_rng(4)
    for n, count in ((60, 48), (60, 52), (35, 21), (26, 16)):
        straight = np.cumsum(np.repeat(rng.normal(size=(n // 5 + 1, 2)), 5, axis=0), axis=0)[:n]  # runs, as tool paths
        for points in (rng.normal(size=(n, 3)).cumsum(axis=0), straight):
            optimum = square_error(points, optimal_dominant_points(points, count))
            assert dominant_points(points, count).square_error <= 1.0001 * optimum + 1e-24


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=600))
def test_the_default_is_near_the_optimum_and_never_above_the_paper(shape):
    for points, parts in ((thinned(shape), (0.9, 0.7, 0.6)), (shape.points, (0.8,))):
        rounding = len(points) * (1e-15 * np.abs(points).max()) ** 2
        for part in parts:
            best, paper = (
                dominant_points(points, fraction=min(max(part, 3 / len(points)), 1.0), closed=shape.closed, method=m)
                for m in ("best", "paper")
            )
            assert best.square_error <= paper.square_error
            if len(points) <= 40 and not shape.closed:
                optimum = square_error(points, optimal_dominant_points(points, len(best.indices)))
                assert best.square_error <= 1.05 * optimum + rounding


@pytest.mark.parametrize("method", ["best", "paper"])
@pytest.mark.parametrize("closed", [False, True])
def test_the_smallest_set_under_an_error(method, closed):
    t = np.linspace(0, 4, 60)
    points = np.column_stack([t + np.sin(2 * t), np.cos(3 * t) + 0.2 * np.sin(7 * t)])
    for bound in (0.0, 1e-4, 1e-2, 1.0, 1e9):
        found = dominant_points(points, square_error=bound, closed=closed, method=method)
        count = len(found.indices)
        assert found.square_error <= bound
        if count > 2 + closed:
            assert dominant_points(points, count - 1, closed=closed, method=method).square_error > bound
    assert count == 2 + closed
    assert len(dominant_points(points, square_error=0.0, closed=closed, method=method).indices) == 60


def test_straight_runs_and_repeats():
    line = np.column_stack([np.arange(50.0), np.zeros(50)])
    bent = np.concatenate([line, line[-1] + np.column_stack([np.zeros(50), np.arange(50.0)])])  # 49 twice
    for method in ("best", "paper"):
        for points in (line, bent, np.zeros((30, 2)), line[:, :1]):
            for fraction in (0.9, 0.5, 0.1):
                found = dominant_points(points, fraction=fraction, method=method)
                assert np.isfinite(found.square_error)
    assert dominant_points(bent, 20).square_error < 0.5 * dominant_points(bent, 20, method="paper").square_error


def test_a_dense_chain_takes_few_rounds():
    t = np.linspace(0, 16, 1200)
    points = np.column_stack([t + np.sin(1.3 * t), 2 * np.cos(t) + 0.3 * np.sin(5 * t)])
    best, paper = (dominant_points(points, fraction=0.7, method=m) for m in ("best", "paper"))
    assert best.square_error < 0.5 * paper.square_error
    assert np.bincount(np.diff(best.indices)).argmax() == 1


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({}, "one of count, fraction and square_error"),
        ({"count": 3, "fraction": 0.5}, "one of count"),
        ({"count": 1}, "from 2 to 5"),
        ({"count": 6}, "from 2 to 5"),
        ({"count": 2, "closed": True}, "from 3 to 5"),
        ({"count": 2.5}, "whole number"),
        ({"count": np.nan}, "whole number"),
        ({"count": np.inf}, "whole number"),
        ({"count": "many"}, "whole number"),
        ({"fraction": 0.0}, "above 0"),
        ({"fraction": np.nan}, "above 0"),
        ({"square_error": -1.0}, "at least 0"),
        ({"square_error": np.nan}, "at least 0"),
        ({"count": 3, "method": "worst"}, "method must be"),
    ],
)
def test_mistakes_are_named(how, message):
    with pytest.raises(ValueError, match=message):
        dominant_points([(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)], **how)


def test_a_whole_number_may_be_a_float():
    t = np.linspace(0, 3, 20)
    points = np.column_stack([t, np.sin(t * t)])
    assert initial_dominant_points(points, 8.0).tolist() == initial_dominant_points(points, 8).tolist()
    assert np.array_equal(dom(points, 8.0).poles, dom(points, 8).poles)


def test_bad_indices_are_named():
    points = [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)]
    for indices, message in (([0, 2, 2, 4], "rise"), ([0, 2, 5], "rise"), ([1, 4], "ends"), ([0.0, 4.0], "whole")):
        with pytest.raises(ValueError, match=message):
            square_error(points, indices)
    with pytest.raises(ValueError, match="rise"):
        square_error(points, np.array([0, 3, 1, 4], dtype=np.uint8))  # a fall of 2 would be a rise by 254
    with pytest.raises(ValueError, match="row 1 of the points"):
        dominant_points([(0, 0), (np.nan, 0), (1, 1)], 2)


@pytest.mark.parametrize("shape", shapes(per_family=1, max_points=300))
def test_the_fit_is_certified_against_all_points(shape):
    points = shape.points
    fit = fit_dominant(points, fraction=min(max(0.5, 3 / len(points)), 1.0), closed=shape.closed)
    rows = dominant_points(points, fraction=min(max(0.5, 3 / len(points)), 1.0), closed=shape.closed).indices
    curve, u = fit.spline, fit.parameters
    gaps = np.linalg.norm(curve(u) - points, axis=1)
    rounding = 64 * reference.EPS * shape.reach
    assert gaps.max() - rounding <= fit.deviation.points <= 1.01 * gaps.max() + rounding
    assert fit.deviation.rms == pytest.approx(np.sqrt(np.mean(gaps**2)), rel=1e-6, abs=rounding)
    assert np.all(curve.multiplicities[1:-1] == 1)
    m = len(rows)
    at = 3.0 * np.arange(m) if shape.closed else np.clip(3.0 * np.arange(m) - 1, 0, max(3 * m - 5, 1))
    np.testing.assert_allclose(curve(at), points[rows], rtol=0, atol=rounding)
    rising = np.roll(u, -int(np.argmin(u))) if shape.closed else u
    assert np.all(np.diff(rising) >= 0)
    assert curve.closed == shape.closed
    assert np.array_equal(fit.points, points)
    k = np.flatnonzero(np.diff(u) >= 0)
    places = curve(np.linspace(u[k], u[k + 1], 9).ravel()).reshape(9, len(k), -1)
    assert distance_to_segment(places, points[k], points[k + 1]).max() <= fit.deviation.between + rounding


def test_the_fit_through_all_points_is_the_cardinal_spline():
    points = turn(30)
    for closed in (False, True):
        fit = fit_dominant(points, fraction=1.0, closed=closed, curvature=0.0)
        assert np.array_equal(fit.spline.poles, cardinal_spline(points, closed=closed).poles)
        assert fit.tolerance is None
        assert fit.deviation.points < 1e-14


def test_a_closed_fit_whose_first_and_last_dominant_points_are_equal():
    eight = np.concatenate([turn(12)[:, ::-1] - [0, 1], [1, -1] * turn(12)[:, ::-1] + [0, 1]])
    eight = np.roll(eight, -6, axis=0)
    for shift in range(len(eight)):
        points = np.roll(eight, shift, axis=0)
        if np.any(points[0] != points[-1]):
            fit = fit_dominant(points, fraction=0.5, closed=True)
            assert fit.deviation.points < 0.5
            assert len(fit.parameters) == len(fit.points)


@given(point_rows(dimensions=(1, 2, 3), least=5, most=40, rough=False), st.floats(0, 1))
def test_dom_is_a_least_squares_fit_with_its_ends_kept(points, part):
    n = len(points)
    curve = dom(points, 4 + int(part * (n - 4)))
    assert len(curve.poles) == 4 + int(part * (n - 4))
    assert np.array_equal(curve.poles[[0, -1]], points[[0, -1]])
    u = parametrize(points, "chord")
    basis = np.array([[reference.basis(i, 4, curve.knots.tolist(), x) for i in range(len(curve.poles))] for x in u])
    residual = points - basis @ curve.poles
    assert np.abs(basis[:, 1:-1].T @ residual).max(initial=0) <= 1e-7 * np.abs(points).max()


def test_dom_gathers_poles_where_the_curve_bends():
    t = np.linspace(0, 1, 400)
    hairpin = np.column_stack([np.abs(t - 0.5), 0.02 * np.tanh(60 * (t - 0.5))])
    spans = np.diff(dom(hairpin, 24).distinct_knots)
    assert spans[len(spans) // 2] < 0.2 * spans.max()
    errors = [np.linalg.norm(dom(hairpin, m)(parametrize(hairpin, "chord")) - hairpin) for m in (8, 16, 32, 64)]
    assert np.all(np.diff(errors) < 0)
    for poles in (3, 4.5, np.nan):
        with pytest.raises(ValueError, match="from 4 to 400"):
            dom(hairpin, poles)
