"""Arrays of Bézier pieces against de Casteljau, closed forms and brute force."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from cadfit import bezier

import reference
from corpus_data import rotation
from reference import EPS

seeds = st.integers(0, 2**32 - 1)
fractions = st.floats(0.0, 1.0)


def random_pieces(seed, m=5, d=3, on_grid=False):
    rng = np.random.default_rng(seed)
    return rng.integers(-2, 3, (m, 4, d)).astype(float) if on_grid else rng.normal(size=(m, 4, d))


def from_powers(*coefficients):
    """The piece of a_0 + a_1 t + a_2 t^2 + a_3 t^3, (1, 4, d)."""
    a, b, c, e = (np.asarray(x, dtype=float) for x in coefficients)
    return np.array([[a, a + b / 3, a + 2 * b / 3 + c / 3, a + b + c + e]])


# Evaluate, split, restrict


@given(seeds, fractions, st.integers(1, 5))
def test_evaluation_is_de_casteljaus(seed, t, d):
    pieces = random_pieces(seed, d=d)
    truth = [reference.de_casteljau(piece, t) for piece in pieces]
    np.testing.assert_allclose(bezier.evaluate(pieces, t), truth, rtol=0, atol=8 * EPS * np.abs(pieces).max())


@given(seeds)
def test_ends_are_the_end_poles_to_the_last_bit(seed):
    pieces = random_pieces(seed)
    np.testing.assert_array_equal(bezier.evaluate(pieces, 0), pieces[:, 0])
    np.testing.assert_array_equal(bezier.evaluate(pieces, 1), pieces[:, 3])


def test_every_piece_may_have_its_own_parameter():
    pieces, t = random_pieces(1), np.linspace(0, 1, 5)
    truth = [bezier.evaluate(pieces[k : k + 1], t[k])[0] for k in range(5)]
    np.testing.assert_array_equal(bezier.evaluate(pieces, t), truth)


@given(seeds, fractions, fractions)
def test_split_parts_run_along_the_piece(seed, t, s):
    pieces = random_pieces(seed)
    left, right = bezier.split(pieces, t)
    allowed = 16 * EPS * np.abs(pieces).max()
    np.testing.assert_array_equal(left[:, 3], right[:, 0])
    np.testing.assert_array_equal(left[:, 0], pieces[:, 0])
    np.testing.assert_array_equal(right[:, 3], pieces[:, 3])
    np.testing.assert_allclose(bezier.evaluate(left, s), bezier.evaluate(pieces, s * t), rtol=0, atol=allowed)
    further = bezier.evaluate(pieces, t + s * (1 - t))
    np.testing.assert_allclose(bezier.evaluate(right, s), further, rtol=0, atol=allowed)


@given(seeds, st.tuples(fractions, fractions).map(sorted), fractions)
def test_a_restricted_piece_runs_along_its_part(seed, ends, s):
    pieces = random_pieces(seed)
    part = bezier.evaluate(bezier.restrict(pieces, *ends), s)
    along = bezier.evaluate(pieces, ends[0] + s * (ends[1] - ends[0]))
    np.testing.assert_allclose(part, along, rtol=0, atol=32 * EPS * np.abs(pieces).max())


def test_parts_may_differ_from_piece_to_piece():
    pieces, t0, t1 = random_pieces(2, m=3), np.array([0.0, 0.2, 0.0]), np.array([0.0, 0.9, 1.0])
    together = bezier.restrict(pieces, t0, t1)
    alone = [bezier.restrict(pieces[k : k + 1], t0[k], t1[k])[0] for k in range(3)]
    np.testing.assert_array_equal(together, alone)


# Distances to segments, flatness


@given(seeds, st.integers(1, 4), st.booleans())
def test_distance_to_a_segment_is_the_exact_one(seed, d, on_grid):
    places = random_pieces(seed, m=20, d=d, on_grid=on_grid)
    found = bezier.distance_to_segment(places[:, 0], places[:, 1], places[:, 2])
    truth = [reference.segment_distance(*three) for three in places[:, :3]]
    np.testing.assert_allclose(found, truth, rtol=0, atol=16 * EPS * np.abs(places).max())


def test_distance_to_a_segments_ends_and_to_a_point_is_exact():
    start, end = np.array([0.1, 0.7]), np.array([0.3, 9.1])
    np.testing.assert_array_equal(bezier.distance_to_segment(np.array([start, end]), start, end), [0, 0])
    assert bezier.distance_to_segment(start + [3.0, 4.0], start, start) == pytest.approx(5.0, rel=1e-15)


@given(seeds, st.booleans())
def test_flatness_bounds_the_way_from_the_chord(seed, on_grid):
    pieces = random_pieces(seed, on_grid=on_grid)
    bound = bezier.flatness(pieces)
    for piece, flat in zip(pieces, bound, strict=True):
        away = bezier.distance_to_segment(reference.sampled(piece, 200), piece[0], piece[3])
        assert away.max() <= flat + 8 * EPS * np.abs(piece).max()


@given(seeds)
def test_flatness_falls_with_the_square_of_the_piece(seed):
    """A part's poles leave its chord by at most 2/9 of the second derivative times its square (de Casteljau)."""
    pieces = random_pieces(seed)
    bend = np.linalg.norm(6 * np.diff(pieces, n=2, axis=1), axis=2).max(axis=1)
    for width in (0.1, 0.01):
        flat = bezier.flatness(bezier.restrict(pieces, 0.5, 0.5 + width))
        assert np.all(flat <= 2 / 9 * bend * width**2 + 16 * EPS * np.abs(pieces).max())


# Lengths

CUSP_TRUTH = 2 * (13**1.5 - 8) / 27  # y^2 = x^3 from -1 to 1
# The first was found by hypothesis: a piece of 1D whose speed all but vanishes inside, where a fixed rule misses it.
TURNING = [
    [-1.6312442644462433, -1.6310906893483395, -1.6735543312616559, -1.6947056899319577],
    [0.0, 1.0, -1.0, 0.0],
    [0.0, 1.0, 0.0, 1e-9],
    [0.0, 1.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
    [0.0, 1 / 3, 0.0, 1.0],
    [0.0, 1 / 3 + 1e-7, -1e-7, 1.0],
    [1e9, 1e9 + 1, 1e9 - 1, 1e9],
]


def test_straight_pieces_have_the_length_of_their_chord():
    ends = np.random.default_rng(1).normal(size=(100, 2, 3))
    places = np.array([0.0, 0.1, 0.3, 1.0])[None, :, None]
    pieces = ends[:, :1] * (1 - places) + ends[:, 1:] * places
    np.testing.assert_allclose(bezier.lengths(pieces), np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), rtol=8 * EPS)


@pytest.mark.parametrize("poles", TURNING)
def test_pieces_that_turn_back_in_one_dimension_have_the_way_gone(poles):
    rounded = 4 * EPS * np.abs(poles).max()
    found = bezier.lengths(np.reshape(poles, (1, 4, 1)))[0]
    assert found == pytest.approx(reference.travel(poles), rel=1e-9, abs=rounded)


@pytest.mark.parametrize("poles", TURNING[:-1])
def test_straight_pieces_that_turn_back_in_space_have_the_way_gone(poles):
    pieces = np.array(poles)[None, :, None] * rotation(3, 4)[0]
    assert bezier.lengths(pieces)[0] == pytest.approx(reference.travel(poles), rel=1e-9)


@given(seeds, st.floats(0, 1), st.floats(-12, 0), st.sampled_from([-1, 1]))
def test_pieces_that_nearly_stand_still_in_one_dimension(seed, place, exponent, sign):
    """The speed is (t - place)^2 plus or minus something small."""
    slow = sign * 10.0**exponent
    scale, start = np.random.default_rng(seed).normal(size=2)
    piece = from_powers([start], [scale * (place**2 + slow)], [-scale * place], [scale / 3])
    allowed = 1e-9 * reference.travel(piece[0]) + 16 * EPS * np.abs(piece).max()
    assert abs(bezier.lengths(piece)[0] - reference.travel(piece[0])) <= allowed


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("offset", [0.0, 6.4e6])
def test_a_cusp_has_its_exact_length(scale, offset):
    """(t^2, t^3) over [-1, 1], whose length is elementary."""
    piece = scale * (from_powers([1, -1], [-4, 6], [4, -12], [0, 8]) + offset)
    rounded = 8 * EPS * offset
    assert bezier.lengths(piece)[0] == pytest.approx(scale * CUSP_TRUTH, rel=1e-9, abs=scale * rounded)


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-6, 1e-9, 0.0])
def test_near_cusps_agree_with_adaptive_quadrature(gap):
    """(t^2, t^3 - gap t) over [-1, 1] has a small loop; its speed is least near 0."""
    piece = from_powers([1, -1 + gap], [-4, 6 - 2 * gap], [4, -12], [0, 8])
    breaks = [0.0, *(max(gap, 1e-9) ** np.linspace(1, 0, 12))]
    truth = 2 * sum(
        quad(lambda t: np.hypot(2 * t, 3 * t * t - gap), a, b, epsabs=0, epsrel=1e-12)[0] for a, b in pairwise(breaks)
    )
    assert bezier.lengths(piece)[0] == pytest.approx(truth, rel=1e-9)


@given(seeds)
def test_lengths_of_smooth_pieces_agree_with_polygons(seed):
    legs = np.array([1.0, 0, 0]) + 0.5 * np.tanh(random_pieces(seed)[:, :3])
    pieces = np.concatenate([np.zeros((5, 1, 3)), legs.cumsum(axis=1)], axis=1)
    truth = [reference.smooth_length(piece) for piece in pieces]
    np.testing.assert_allclose(bezier.lengths(pieces), truth, rtol=1e-9)


@pytest.mark.slow
def test_lengths_of_many_pieces_are_those_of_each():
    """More pieces than are handled at a time, easy and hard ones mixed."""
    few = np.concatenate([random_pieces(3, m=60, d=2), random_pieces(4, m=40, d=2, on_grid=True)])
    alone = np.array([bezier.lengths(piece[None])[0] for piece in few])
    many = bezier.lengths(np.tile(few, (700, 1, 1)))
    np.testing.assert_allclose(many.reshape(700, 100), np.tile(alone, (700, 1)), rtol=0, atol=1e-9 * alone.mean())


def test_a_piece_that_stands_still_has_no_length():
    np.testing.assert_array_equal(bezier.lengths(np.ones((2, 4, 3))), [0, 0])


# Nearest


@given(seeds, st.integers(1, 4), st.booleans())
def test_nearest_is_the_exact_nearest_and_no_sample_is_nearer(seed, d, on_grid):
    pieces, points = random_pieces(seed, d=d, on_grid=on_grid), random_pieces(seed + 1, m=1, d=d, on_grid=on_grid)[0]
    piece, t, distance = bezier.nearest(pieces, points)
    slack = 1e-12 * (np.abs(pieces).max() + np.abs(points).max())
    there = np.array([reference.de_casteljau(pieces[k], s) for k, s in zip(piece, t, strict=True)])
    np.testing.assert_allclose(np.linalg.norm(there - points, axis=1), distance, rtol=0, atol=slack)
    samples = np.concatenate([reference.sampled(one, 500) for one in pieces])
    for point, found in zip(points, distance, strict=True):
        assert found <= np.linalg.norm(samples - point, axis=1).min() + slack
        assert found <= reference.nearest_distance(pieces, point) + slack


def test_nearest_to_points_of_the_pieces_is_the_place_itself():
    pieces = random_pieces(6, m=40)
    t = np.linspace(0.05, 0.95, 40)
    piece, found, distance = bezier.nearest(pieces, bezier.evaluate(pieces, t))
    np.testing.assert_array_equal(piece, np.arange(40))
    np.testing.assert_allclose(found, t, atol=1e-9)
    assert distance.max() <= 8 * EPS * np.abs(pieces).max()


def test_nearest_tells_two_branches_that_nearly_touch():
    """A hairpin with legs 1e-6 apart: the branch found is the near one."""
    out = [[0, 0], [1, 0], [2, 0], [3, 0]]
    back = [[3, 1e-6], [2, 1e-6], [1, 1e-6], [0, 1e-6]]
    points = np.array([[1.4, 0.4e-6], [1.4, 0.6e-6], [2.9, -5.0], [0.1, 5.0]])
    piece, _, distance = bezier.nearest(np.array([out, back]), points)
    np.testing.assert_array_equal(piece, [0, 1, 0, 1])
    np.testing.assert_allclose(distance, [0.4e-6, 0.4e-6, 5.0, 5.0 - 1e-6], rtol=1e-9)


def test_nearest_of_no_points_is_nothing():
    assert [len(part) for part in bezier.nearest(random_pieces(1), np.empty((0, 3)))] == [0, 0, 0]
