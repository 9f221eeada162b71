"""The curve type against the textbook, and the laws every spline obeys."""

import copy
import pickle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cadfit import BSpline, bezier, join

import reference
from corpus_data import rotation, splines
from reference import EPS, magnitude, parameters_between_knots, top_speed

LINE_KNOTS = [0, 0, 0, 0, 1, 1, 1, 1]
fractions = st.floats(0.01, 0.99)
SCALES = [1e-9, 1.0, 1e9]


def at(spline, fraction):
    low, high = spline.domain
    return low + fraction * (high - low)


def excess(spline, poles, knots, order=0):
    """How far the spline is from the textbook's curve of these poles and knots, in units of the allowed rounding."""
    u = parameters_between_knots(spline)
    apart = np.abs(spline.derivative(u, order) - reference.curve(poles, knots, u, order))
    allowed = reference.rounding(poles, knots, u, order)
    return np.max(apart / np.maximum(allowed, np.finfo(float).tiny))


def example(seed=5):
    rng = np.random.default_rng(seed)
    return BSpline(rng.normal(size=(12, 3)), [0, 0, 0, 0, 0.5, 1, 1, 2.5, 3, 3, 3, 4, 6, 6, 6, 6])


def same_curve(a, b, slack=64):
    """Whether two splines on one domain are one curve, to rounding."""
    u = parameters_between_knots(a)
    np.testing.assert_allclose(b(u), a(u), rtol=0, atol=slack * EPS * magnitude(a))


# Against the textbook


@pytest.mark.parametrize("order", [0, 1, 2, 3, 4])
@given(spline=splines())
def test_values_and_derivatives_are_the_textbooks(spline, order):
    assert excess(spline, spline.poles, spline.knots, order) <= 1


@given(splines(dimensions=(2,), spans=(1, 2, 5)), fractions)
def test_points_are_the_exact_ones_rounded(spline, fraction):
    u = at(spline, fraction)
    exact = reference.exact_curve(spline.poles, spline.knots, u)
    np.testing.assert_allclose(spline(u), exact, rtol=0, atol=8 * EPS * magnitude(spline))


@pytest.mark.parametrize("pole", range(12))
def test_the_judge_catches_a_broken_pole(pole):
    spline = example()
    poles = spline.poles.copy()
    poles[pole] += 1e-6 * spline.size * np.array([0.6, 0.0, 0.8])
    assert excess(spline, spline.poles, spline.knots) <= 1
    assert excess(spline, poles, spline.knots) > 1e6


@pytest.mark.parametrize("knot", range(4, 12))
def test_the_judge_catches_a_wrong_knot(knot):
    spline = example()
    knots = spline.knots.copy()
    knots[knot] += 1e-6 if knots[knot] < knots[knot + 1] else -1e-6
    assert excess(spline, spline.poles, np.sort(knots)) > 1e6


def test_the_basis_adds_up_to_one():
    knots = example().knots
    for u in np.linspace(0, 6, 41):
        assert abs(sum(reference.basis(i, 4, knots, u) for i in range(12)) - 1) <= 4 * EPS


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3), (2, 1, 2)])
def test_parameters_of_any_shape_give_points_of_that_shape(shape):
    spline = example()
    u = np.linspace(0, 6, int(np.prod(shape))).reshape(shape)
    for order in (0, 2, 4):
        assert spline.derivative(u, order).shape == (*shape, 3)
    np.testing.assert_array_equal(spline(u).reshape(-1, 3), spline(u.ravel()))


@given(splines())
def test_derivatives_agree_with_differences(spline):
    """On a cubic, central differences at two steps leave no error but rounding."""
    for a, b in pairwise(spline.distinct_knots):
        u, h = (a + b) / 2, (b - a) / 4
        coarse = (spline(u + h) - spline(u - h)) / (2 * h)
        fine = (spline(u + h / 2) - spline(u - h / 2)) / h
        noise = 64 * EPS * (magnitude(spline) / h + np.abs(spline.domain).max() * top_speed(spline) / h)
        np.testing.assert_allclose(spline.derivative(u), (4 * fine - coarse) / 3, rtol=0, atol=noise)


def test_a_derivative_that_jumps_is_the_right_ones_but_at_the_end():
    spline = BSpline([[0.0], [0], [0], [1], [3], [3], [4]], [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2])
    assert spline.derivative([0, np.nextafter(1, 0), 1, 2])[:, 0] == pytest.approx([0, 3, 6, 3])


# Laws


@given(splines(), st.integers(1, 4), st.integers(0, 99))
def test_affine_maps_commute_with_evaluation(spline, k, seed):
    rng = np.random.default_rng(seed)
    matrix, offset = rng.normal(size=(k, spline.poles.shape[1])), 10 * rng.normal(size=k)
    u = parameters_between_knots(spline)
    allowed = 64 * EPS * (np.abs(matrix).sum(axis=1) * magnitude(spline) + np.abs(offset))
    apart = np.abs(spline.transformed(matrix, offset)(u) - (spline(u) @ matrix.T + offset))
    assert np.all(apart <= allowed)


@pytest.mark.parametrize("short", [1e-20, 1e-300])
def test_reversed_keeps_end_spans_shorter_than_rounding(short):
    """1 - 1e-20 is 1 in floating point: the reversed curve's last span is one unit in the last place long."""
    poles = np.random.default_rng(0).normal(size=(6, 3))
    spline = BSpline(poles, [0, 0, 0, 0, short, 0.5, 1, 1, 1, 1])
    back = spline.reversed()
    np.testing.assert_array_equal(back.poles, poles[::-1])
    u = np.linspace(0, 1, 41)
    np.testing.assert_allclose(back(1 - u), spline(u), rtol=0, atol=1e-14)
    assert back.knots[-5] < 1


@given(splines())
def test_reversed_runs_backwards(spline):
    low, high = spline.domain
    u = parameters_between_knots(spline)
    back = spline.reversed()
    shift = 4 * EPS * max(abs(low), abs(high)) * top_speed(spline)
    np.testing.assert_allclose(
        back(np.clip(low + high - u, low, high)), spline(u), rtol=0, atol=64 * EPS * magnitude(spline) + shift
    )
    assert back.domain == spline.domain
    np.testing.assert_array_equal(back.multiplicities, spline.multiplicities[::-1])
    np.testing.assert_array_equal(back.reversed().poles, spline.poles)


@given(splines(), fractions, st.integers(0, 3))
def test_an_inserted_knot_keeps_the_curve(spline, fraction, times):
    u = at(spline, fraction)
    assume(u not in spline.knots)
    finer = spline.insert_knot(u, times)
    np.testing.assert_array_equal(finer.knots, np.sort(np.append(spline.knots, [u] * times)))
    same_curve(spline, finer)


@given(splines())
def test_every_knot_can_be_raised_to_three(spline):
    finer = spline
    for knot, count in zip(spline.distinct_knots[1:-1], spline.multiplicities[1:-1], strict=True):
        finer = finer.insert_knot(knot, 3 - count)
    assert set(finer.multiplicities[1:-1]) <= {3}
    same_curve(spline, finer)
    np.testing.assert_allclose(finer.poles[:-1].reshape(-1, 3, spline.poles.shape[1]), spline.pieces()[:, :3],
                               rtol=0, atol=64 * EPS * magnitude(spline))  # fmt: skip


@given(splines(), fractions)
def test_split_parts_are_the_curve_and_join_to_it(spline, fraction):
    u = at(spline, fraction)
    left, right = spline.split(u)
    assert left.domain == (spline.domain[0], u)
    assert right.domain == (u, spline.domain[1])
    np.testing.assert_array_equal(left.poles[-1], right.poles[0])
    np.testing.assert_array_equal(left.poles[0], spline.poles[0])
    np.testing.assert_array_equal(right.poles[-1], spline.poles[-1])
    for part in (left, right):
        v = parameters_between_knots(part)
        np.testing.assert_allclose(part(v), spline(v), rtol=0, atol=64 * EPS * magnitude(spline))
    joined = join([left, right])
    shift = 8 * EPS * np.abs(spline.domain).max() * top_speed(spline)
    v = np.clip(parameters_between_knots(spline), *joined.domain)
    np.testing.assert_allclose(joined(v), spline(v), rtol=0, atol=64 * EPS * magnitude(spline) + shift)


@given(splines())
def test_split_at_a_knot_keeps_the_curve(spline):
    for knot in spline.distinct_knots[1:-1]:
        for part in spline.split(knot):
            v = parameters_between_knots(part, 3)
            np.testing.assert_allclose(part(v[:-1]), spline(v[:-1]), rtol=0, atol=64 * EPS * magnitude(spline))


@given(splines(), st.integers(0, 99))
def test_each_span_lies_in_the_hull_of_its_poles(spline, seed):
    """Seen along any direction, points lie between the outermost of the span's four poles."""
    directions = np.random.default_rng(seed).normal(size=(20, spline.poles.shape[1]))
    slack = 16 * EPS * magnitude(spline) * np.linalg.norm(directions, axis=1)
    last = np.flatnonzero(np.diff(spline.knots) > 0)
    for i, piece in zip(last, spline.pieces(), strict=True):
        u = np.linspace(spline.knots[i], spline.knots[i + 1], 9)[:-1]  # the far end belongs to the next span
        for poles in (spline.poles[i - 3 : i + 1], piece):
            along, hull = spline(u) @ directions.T, poles @ directions.T
            assert np.all(along <= hull.max(axis=0) + slack)
            assert np.all(along >= hull.min(axis=0) - slack)


@given(splines())
def test_pieces_join_to_the_last_bit_and_are_the_curve(spline):
    pieces = spline.pieces()
    np.testing.assert_array_equal(pieces[1:, 0], pieces[:-1, 3])
    np.testing.assert_array_equal(pieces[[0, -1], [0, 3]], spline.poles[[0, -1]])
    spans = np.diff(spline.distinct_knots)
    assert len(pieces) == len(spans)
    for t in (0.0, 0.3, 0.5, 0.9):
        u = np.minimum(spline.distinct_knots[:-1] + t * spans, spline.domain[1])
        shift = 2 * EPS * np.abs(spline.domain).max() * top_speed(spline)
        apart = np.abs(bezier.evaluate(pieces, t) - spline(u))
        assert apart.max() <= 32 * EPS * magnitude(spline) + shift


@given(splines(dimensions=(3,)), st.integers(0, 99))
def test_pieces_of_a_moved_curve_are_the_moved_pieces(spline, seed):
    turn, offset = rotation(3, seed), np.array([3.0, -5.0, 7.0])
    moved = spline.transformed(turn, offset).pieces()
    allowed = 64 * EPS * (magnitude(spline) + 10)
    np.testing.assert_allclose(moved, spline.pieces() @ turn.T + offset, rtol=0, atol=allowed)


@given(splines())
def test_distinct_knots_and_multiplicities_are_the_knots(spline):
    np.testing.assert_array_equal(np.repeat(spline.distinct_knots, spline.multiplicities), spline.knots)
    assert np.all(np.diff(spline.distinct_knots) > 0)
    assert spline.multiplicities[0] == spline.multiplicities[-1] == 4


# Length


@given(splines(), fractions)
def test_lengths_of_parts_add_up(spline, fraction):
    left, right = spline.split(at(spline, fraction))
    assert left.length() + right.length() == pytest.approx(spline.length(), rel=2e-9, abs=1e-300)


@given(splines(), st.integers(0, 99), st.sampled_from(SCALES))
def test_length_does_not_change_under_motion_and_scales(spline, seed, scale):
    d = spline.poles.shape[1]
    moved = spline.transformed(scale * rotation(d, seed), scale * np.arange(d))
    assert moved.length() == pytest.approx(scale * spline.length(), rel=3e-9, abs=1e-300)
    assert spline.reversed().length() == pytest.approx(spline.length(), rel=2e-9, abs=1e-300)


@given(splines(dimensions=(1,)))
def test_length_in_one_dimension_is_the_way_gone(spline):
    truth = sum(reference.travel(piece) for piece in spline.pieces())
    assert spline.length() == pytest.approx(truth, rel=1e-9, abs=1e-300)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-6, 1e-9, 1e-12, 1e-30])
def test_length_keeps_the_asked_accuracy(accuracy):
    spline = example()
    truth = sum(reference.smooth_length(piece, 1024) for piece in spline.pieces())
    assert spline.length(accuracy) == pytest.approx(truth, rel=max(accuracy, 1e-12))


# Nearest


@given(splines(), st.integers(0, 99))
def test_nearest_is_no_farther_than_brute_force(spline, seed):
    pieces = spline.pieces()
    points = np.random.default_rng(seed).normal(size=(4, spline.poles.shape[1]))
    u, distance = spline.nearest(points)
    slack = 1e-12 * (magnitude(spline) + np.abs(points).max())
    shift = 4 * EPS * np.abs(spline.domain).max() * top_speed(spline)
    np.testing.assert_allclose(np.linalg.norm(spline(u) - points, axis=1), distance, rtol=0, atol=slack + shift)
    for point, found in zip(points, distance, strict=True):
        assert found <= reference.nearest_distance(pieces, point) + slack


@given(splines(), st.lists(fractions, min_size=1, max_size=5))
def test_a_point_of_the_curve_is_at_distance_zero(spline, places):
    _, distance = spline.nearest(spline([at(spline, place) for place in places]))
    assert distance.max() <= 1e-12 * magnitude(spline)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("offset", [0.0, 6.4e6])
def test_nearest_is_exact_at_any_scale_and_offset(scale, offset):
    base = example()
    spline = base.transformed(scale * np.eye(3), scale * offset)
    points = np.random.default_rng(1).normal(size=(50, 3))
    _, distance = spline.nearest(scale * points + scale * offset)
    truth = [reference.nearest_distance(base.pieces(), point) for point in points]
    np.testing.assert_allclose(distance / scale, truth, rtol=0, atol=16 * EPS * (10 + offset))


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 2)])
def test_nearest_takes_points_of_any_shape(shape):
    u, distance = example().nearest(np.ones((*shape, 3)))
    assert u.shape == distance.shape == shape


def test_the_nearest_of_a_circles_centre_is_at_the_radius():
    ring = circle_of_splines()
    _, distance = ring.nearest([[0.0, 0.0]])
    radii = np.linalg.norm(ring(np.linspace(*ring.domain, 4001)), axis=1)
    assert distance[0] == pytest.approx(radii.min(), abs=1e-12)


def circle_of_splines(parts=8):
    """A circle by cubic pieces, each symmetric: the handle 4/3 tan(angle/4)."""
    angle = 2 * np.pi / parts
    h = 4 / 3 * np.tan(angle / 4)
    arc = np.array([[1, 0], [1, h], [np.cos(angle) + h * np.sin(angle), np.sin(angle) - h * np.cos(angle)],
                    [np.cos(angle), np.sin(angle)]])  # fmt: skip
    c, s = np.cos(angle * np.arange(parts)), np.sin(angle * np.arange(parts))
    turns = np.stack([np.stack([c, -s], -1), np.stack([s, c], -1)], -2)
    return join([BSpline(arc @ turn.T, LINE_KNOTS) for turn in turns])


@pytest.mark.parametrize("parts", [8, 32])
def test_the_length_of_a_near_circle_is_nearly_its_circumference(parts):
    """The handle's error is of sixth order: 4/27 sin^6(a/4)/cos^2(a/4) of the radius at most (Goldapp, 1991)."""
    error = 4 / 27 * np.sin(np.pi / 2 / parts) ** 6 / np.cos(np.pi / 2 / parts) ** 2
    length = circle_of_splines(parts).length()
    assert 2 * np.pi * (1 - 1e-9) <= length <= 2 * np.pi * (1 + error + 1e-9)


# Curvature


@given(splines(dimensions=(2,), unevenness=(0, 1)), fractions)
def test_curvature_in_the_plane_is_the_textbooks(spline, fraction):
    u = at(spline, fraction)
    (x1, y1), (x2, y2) = spline.derivative(u), spline.derivative(u, 2)
    speed = np.hypot(x1, y1)
    assume(speed > 1e-3 * top_speed(spline))
    normal = np.array([-y1, x1]) / speed
    expected = (x1 * y2 - y1 * x2) / speed**3 * normal
    allowed = 64 * EPS * np.hypot(x2, y2) / speed**2
    np.testing.assert_allclose(spline.curvature(u), expected, rtol=0, atol=allowed)


def test_curvature_of_a_near_circle_points_to_the_centre_and_is_one():
    ring = circle_of_splines(64)
    u = np.linspace(*ring.domain, 1000)
    np.testing.assert_allclose(ring.curvature(u), -ring(u), atol=2e-6)


def test_curvature_is_zero_at_a_cusp():
    cusp = BSpline([[0, 0], [0, 0], [1, 1], [2, 0]], LINE_KNOTS)
    np.testing.assert_array_equal(cusp.curvature([0.0, 0.0]), np.zeros((2, 2)))


# Comparing, copying, changing


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize(("part", "expected"), [(0.5, True), (2.0, False)])
def test_isclose_compares_poles_by_size_and_knots_by_domain(scale, part, expected):
    spline = example().transformed(scale * np.eye(3))
    poles, knots = spline.poles.copy(), spline.knots.copy()
    poles[3, 1] += part * 1e-9 * spline.size
    assert spline.isclose(BSpline(poles, knots)) is expected
    knots[6] += part * 1e-9 * 6.0
    assert spline.isclose(BSpline(spline.poles, np.sort(knots))) is expected
    assert spline.isclose(BSpline(poles, knots), tolerance=3e-9)


def test_isclose_of_curves_of_other_shapes_is_false():
    spline = example()
    assert not spline.isclose(spline.insert_knot(2.0))
    assert not spline.isclose(spline.transformed(np.eye(3)[:2]))


def test_what_a_spline_was_made_from_may_change_afterwards():
    poles, knots = np.arange(8.0).reshape(4, 2), np.array(LINE_KNOTS, dtype=float)
    spline = BSpline(poles, knots)
    poles[:], knots[:] = 7, 7
    np.testing.assert_array_equal(spline.poles, np.arange(8.0).reshape(4, 2))
    np.testing.assert_array_equal(spline.knots, LINE_KNOTS)


def test_a_read_only_view_of_changing_numbers_is_copied():
    poles = np.arange(8.0).reshape(4, 2)
    view = poles[:]
    view.setflags(write=False)
    spline = BSpline(view, LINE_KNOTS)
    poles[:] = 7
    np.testing.assert_array_equal(spline.poles, np.arange(8.0).reshape(4, 2))


@pytest.mark.parametrize(
    "made", [example, lambda: example().reversed(), lambda: example().split(2.0)[1], lambda: example().insert_knot(2.0)]
)
def test_arrays_are_read_only(made):
    spline = made()
    for array in (spline.poles, spline.knots):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize("name", ["poles", "knots", "closed", "anything"])
def test_nothing_can_be_assigned(name):
    spline = example()
    with pytest.raises((AttributeError, TypeError)):
        setattr(spline, name, np.zeros((4, 2)))
    assert spline.isclose(example(), tolerance=0)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
def test_copies_keep_every_bit_and_stay_read_only(copied):
    spline = example()
    twin = copied(spline)
    np.testing.assert_array_equal(twin.poles, spline.poles)
    np.testing.assert_array_equal(twin.knots, spline.knots)
    assert not twin.poles.flags.writeable
    assert not twin.knots.flags.writeable


def test_splines_are_compared_by_identity():
    assert example() != example()
    assert len({example(), example()}) == 2


@pytest.mark.parametrize(
    ("knots", "d", "text"),
    [
        (LINE_KNOTS, 2, "BSpline(4 poles in 2D, 1 span, u in [0.0, 1.0])"),
        ([2, 2, 2, 2, 3, 3, 5, 5, 5, 5], 3, "BSpline(6 poles in 3D, 2 spans, u in [2.0, 5.0])"),
    ],
)
def test_repr_says_what_matters(knots, d, text):
    assert repr(BSpline(np.arange((len(knots) - 4) * d).reshape(-1, d), knots)) == text


def test_size_is_the_diagonal_of_the_poles_box():
    assert BSpline([[0, 0], [3, 1], [1, 4], [2, 2]], LINE_KNOTS).size == 5.0


def test_closed_means_to_the_last_bit():
    poles = np.array([[0.0, 0.0], [1, 0], [1, 1], [0, 0]])
    assert BSpline(poles, LINE_KNOTS).closed
    poles[-1, 0] = np.nextafter(0.0, 1.0)
    assert not BSpline(poles, LINE_KNOTS).closed


# What is refused

FLAT = [[0, 0], [1, 0], [2, 0], [3, 0]]


@pytest.mark.parametrize(
    ("poles", "knots", "says"),
    [
        ([0, 1, 2, 3], LINE_KNOTS, r"poles must have the shape \(n >= 4, d >= 1\), not \(4,\)"),
        (FLAT[:3], LINE_KNOTS[1:], r"poles must have the shape .* not \(3, 2\)"),
        (np.zeros((4, 0)), LINE_KNOTS, r"poles must have the shape .* not \(4, 0\)"),
        (np.zeros((4, 2, 2)), LINE_KNOTS, r"poles must have the shape .* not \(4, 2, 2\)"),
        ([[0, 0], [1], [2, 0], [3, 0]], LINE_KNOTS, r"row 1 of the poles has 1 numbers, the rows before it 2: \[1\]"),
        ([[0, "x"], [1, 0], [2, 0], [3, 0]], LINE_KNOTS, r"row 0 of the poles is not a row of numbers: \[0, 'x'\]"),
        ([[0, 10**400], [1, 0], [2, 0], [3, 0]], LINE_KNOTS, "row 0 of the poles is not a row of numbers"),
        (np.array(FLAT) + 1j, LINE_KNOTS, "poles must be real numbers, not complex ones"),
        (FLAT, np.array(LINE_KNOTS) + 0j, "knots must be real numbers, not complex ones"),
        (np.ma.masked_equal(FLAT, 3), LINE_KNOTS, "row 3 of the poles is masked"),
        ([[0, 0], [1, np.nan], [2, 0], [3, 0]], LINE_KNOTS, r"poles must be finite: entry \(1, 1\) is nan"),
        (FLAT, [0, 0, 0, 0, 1, 1, 1, np.inf], r"knots must be finite: entry \(7,\) is inf"),
        (FLAT, LINE_KNOTS[1:], r"4 poles need 8 knots \(full vector\), not \(7,\)"),
        (FLAT, [LINE_KNOTS], r"4 poles need 8 knots \(full vector\), not \(1, 8\)"),
        ([*FLAT, [4, 0], [5, 0]], [0, 0, 0, 0, 2, 1, 3, 3, 3, 3], "knot 4 is 2.0, knot 5 is 1.0"),
        (FLAT, [0, 0, 0, 1, 2, 2, 2, 2], "first and the last knot must stand exactly four times"),
        (FLAT, [0, 0, 0, 0, 1, 1, 1, 2], "first and the last knot must stand exactly four times"),
        (FLAT, [0] * 8, "first and the last knot must stand exactly four times"),
        ([*FLAT, [4, 0]], [0, 0, 0, 0, 0, 1, 1, 1, 1], "first and the last knot must stand exactly four times"),
        ([*FLAT] * 2, [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2], "interior knot 1.0 stands more than three times"),
    ],
)
def test_bad_poles_and_knots_are_named(poles, knots, says):
    with pytest.raises(ValueError, match=says):
        BSpline(poles, knots)


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")
@pytest.mark.parametrize("kind", [np.matrix, np.ma.array])
def test_other_kinds_of_arrays_become_plain_ones(kind):
    poles = [[0.0, 0.0], [1.0, 2.0], [2.0, -1.0], [3.0, 0.0]]
    spline = BSpline(kind(np.array(poles)), LINE_KNOTS)
    assert type(spline.poles) is np.ndarray
    assert spline.isclose(BSpline(poles, LINE_KNOTS), 0.0)
    assert spline.split(0.5)[1].length() > 0.0


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda s: s(-0.1), r"the parameter -0.1 is outside \[0.0, 6.0\]"),
        (lambda s: s([1.0, 6.5, 7.0]), "the parameter 6.5 is outside"),
        (lambda s: s([[1.0], [np.nan]]), "the parameter nan is outside"),
        (lambda s: s.derivative(1.0, -1), "order of a derivative must be 0 or more, not -1"),
        (lambda s: s.curvature(9.0), "the parameter 9.0 is outside"),
        (lambda s: s.insert_knot(0.0), r"strictly inside \[0.0, 6.0\], not at 0.0"),
        (lambda s: s.insert_knot(np.nan), "strictly inside .* not at nan"),
        (lambda s: s.insert_knot(1.0, 2), r"knot 1.0 stands 2 times; 2 more is not possible"),
        (lambda s: s.insert_knot(0.7, 4), r"knot 0.7 stands 0 times; 4 more is not possible"),
        (lambda s: s.insert_knot(0.7, -1), "-1 more is not possible"),
        (lambda s: s.length(0.0), "accuracy must be above 0, not 0.0"),
        (lambda s: s.length(np.nan), "accuracy must be above 0, not nan"),
        (lambda s: s.split(6.0), "strictly inside .* not at 6.0"),
        (lambda s: s.transformed(np.eye(2)), r"matrix must have the shape \(k, 3\), not \(2, 2\)"),
        (lambda s: s.transformed([1.0, 2.0, 3.0]), r"matrix must have the shape \(k, 3\), not \(3,\)"),
        (lambda s: s.transformed(np.full((3, 3), np.nan)), "poles must be finite"),
        (lambda s: s.transformed(np.eye(3)[:1], [1, 2, 3]), r"offset must be a number or have .* \(1,\), not \(3,\)"),
        (lambda s: s.transformed(np.eye(3), [1, 2]), r"offset must be a number or have .* \(3,\), not \(2,\)"),
        (lambda s: s.transformed(np.eye(3), np.ones(s.poles.shape)), r"offset must be a number or have the shape"),
        (lambda s: s.nearest([1.0, 2.0]), r"points must have the shape \(..., 3\), not \(2,\)"),
        (lambda s: s.nearest(1.0), r"points must have the shape \(..., 3\), not \(\)"),
        (lambda s: s.nearest([1.0, 2.0, np.inf]), "points must be finite"),
    ],
)
def test_bad_arguments_are_named(call, says):
    with pytest.raises(ValueError, match=says):
        call(example())
