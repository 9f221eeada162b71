"""FC3 and its n-dimensional form: planar fits merged, against the paper's merge rule taken literally."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadfit import cardinal_pieces, cardinal_spline, fit_planes, merge_planes

import reference
from corpus_data import point_rows, shapes
from reference import EPS

SPACES = tuple(range(2, 9))


@st.composite
def planar_chains(draw, planes):
    """One chain of pieces a plane that agree on the common axis at their ends, with handles of any direction."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    m = draw(st.integers(1, 5))
    chains = rng.normal(size=(planes, m, 4, 2))
    chains[1:, :, [0, 3], 0] = chains[:1, :, [0, 3], 0]
    for handle in (chains[:, :, 1] - chains[:, :, 0], chains[:, :, 2] - chains[:, :, 3]):
        assert np.abs(handle[..., 0]).min() > 0
    return chains


@st.composite
def turning_points(draw, least=3):
    """Points on a small grid: they turn back, stand still along an axis, and repeat."""
    d = draw(st.sampled_from(SPACES))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return rng.integers(0, 3, (draw(st.integers(least, 12)), d)).astype(float)


def check_same(found, expected, slack=8):
    np.testing.assert_array_equal(found.knots, expected.knots)
    np.testing.assert_allclose(found.poles, expected.poles, rtol=0, atol=slack * EPS * np.abs(expected.poles).max())


# The merge rule


@given(planar_chains(planes=2), st.integers(0, 2))
def test_merging_two_planes_is_the_papers_rule_in_space(chains, axis):
    """Literally, p and q, then points on the lines of both planes, for the axes (x_k, x_j, x_l)."""
    found = np.moveaxis(merge_planes(chains, axis), 2, 0)
    others = [k for k in range(3) if k != axis]
    steepest = 1 + np.abs(np.diff(chains, axis=2)[:, :, [0, 2], 0] ** -1.0).max()
    for k in range(chains.shape[1]):
        literal = reference.merge_r3(chains[0, k], chains[1, k])
        ours = found[[axis, *others], k].T
        np.testing.assert_allclose(ours, literal, rtol=0, atol=64 * EPS * 5 * steepest * 5)


@given(st.data(), st.sampled_from(SPACES))
def test_merging_any_number_of_planes_is_the_papers_rule_about_any_axis(data, d):
    chains = data.draw(planar_chains(planes=d - 1))
    steepest = 1 + np.abs(np.diff(chains, axis=2)[:, :, [0, 2], 0] ** -1.0).max()
    for axis in range(d):
        found = merge_planes(list(chains), axis)
        literal = [reference.merge(chains[:, k], axis) for k in range(chains.shape[1])]
        np.testing.assert_allclose(found, literal, rtol=0, atol=64 * EPS * 5 * steepest * 5)


def test_the_rule_for_n_planes_is_the_rule_for_two_in_space():
    a, b = np.random.default_rng(8).normal(size=(2, 4, 2))
    b[[0, 3], 0] = a[[0, 3], 0]
    np.testing.assert_array_equal(reference.merge([a, b], 0), reference.merge_r3(a, b))


@given(planar_chains(planes=3))
def test_merged_handles_keep_each_planes_direction_and_share_one_length(chains):
    merged = merge_planes(chains, 0)
    for end, handle in ((0, 1), (3, 2)):
        ours = merged[:, handle] - merged[:, end]
        given_handles = chains[:, :, handle] - chains[:, :, end]
        mean = given_handles[:, :, 0].mean(axis=0)
        np.testing.assert_allclose(ours[:, 0], mean, rtol=0, atol=16 * EPS * 5)
        for plane in range(3):
            e, f = given_handles[plane].T
            across = ours[:, 0] * f - ours[:, 1 + plane] * e
            assert np.all(np.abs(across) <= 64 * EPS * 5 * (np.abs(e) + np.abs(f) + np.abs(mean * f / e)))


def test_one_plane_stays_as_it_is():
    chain = cardinal_pieces([[0, 0], [1, 2], [3, 3]])
    np.testing.assert_allclose(merge_planes([chain], 0), chain, rtol=0, atol=4 * EPS * 3)
    np.testing.assert_allclose(merge_planes([chain], 1), chain[:, :, ::-1], rtol=0, atol=4 * EPS * 3)


def test_handles_that_all_stand_still_along_the_common_axis_are_kept():
    up = np.array([[[0, 0], [0, 2], [1, 3], [2, 4]]], float)
    deep = np.array([[[0, 5], [0, 9], [1, 7], [2, 6]]], float)
    np.testing.assert_array_equal(merge_planes([up, deep])[0], [[0, 0, 5], [0, 2, 9], [1, 3, 7], [2, 4, 6]])


GOOD = np.array([[[0, 0], [1, 1], [2, 1], [3, 0]], [[3, 0], [4, 0], [5, 0], [6, 0]]], float)


def changed(piece, pole, axis, by):
    other = GOOD.copy()
    other[piece, pole, axis] += by
    return other


@pytest.mark.parametrize(
    ("planes", "axis", "says"),
    [
        ([], 0, "at least one plane is needed"),
        ([GOOD, GOOD[:1]], 0, r"plane 1 must have the shape \(m, 4, 2\) like plane 0, not \(1, 4, 2\)"),
        ([GOOD[:, :3]], 0, r"plane 0 must have the shape \(m, 4, 2\) like plane 0, not \(2, 3, 2\)"),
        ([GOOD, np.zeros((2, 4, 3))], 0, r"plane 1 must have the shape .* not \(2, 4, 3\)"),
        ([GOOD, changed(1, 3, 0, 1e-9)], 0, "piece 1 of plane 1 ends elsewhere on the common axis than in plane 0"),
        ([GOOD, changed(1, 2, 1, np.nan)], 0, r"piece 1 of plane 1 is not finite: \[\[.*nan"),
        ([changed(0, 0, 0, np.inf), GOOD], 0, "piece 0 of plane 0 is not finite"),
        ([GOOD, GOOD], 0.5, "common_axis must be from 0 to 2, not 0.5"),
        ([GOOD, GOOD], "x", "common_axis must be from 0 to 2, not x"),
        ([GOOD, GOOD], 3, "common_axis must be from 0 to 2, not 3"),
        ([GOOD, GOOD], -1, "common_axis must be from 0 to 2, not -1"),
        ([GOOD, changed(1, 1, 0, -1)], 0, "plane 1, piece 1: the handle of pole 0 stands still .* all planes is 0.5"),
        ([changed(0, 2, 0, 1), GOOD], 0, "plane 0, piece 0: the handle of pole 3 stands still .* all planes is -0.5"),
    ],
)
def test_planes_that_do_not_merge_are_named(planes, axis, says):
    with pytest.raises(ValueError, match=says):
        merge_planes(planes, axis)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_ends_agree_to_rounding_at_any_scale(scale):
    planes = [scale * GOOD, scale * changed(1, 3, 0, 4 * EPS)]
    np.testing.assert_allclose(merge_planes(planes)[:, :, 0], scale * GOOD[:, :, 0], rtol=0, atol=scale * 1e-14)


# fit_planes


@given(turning_points(), st.floats(-1, 2), st.booleans())
def test_equal_tensions_give_the_cardinal_spline_about_every_axis(points, tension, closed):
    """Also where the points turn back or stand still along the common axis."""
    closed &= len(points) > 3
    expected = cardinal_spline(points, tension, closed=closed)
    for axis in range(points.shape[1]):
        check_same(fit_planes(points, tension, axis, closed), expected)
        check_same(fit_planes(points, [tension] * (points.shape[1] - 1), axis, closed), expected)


@pytest.mark.parametrize("shape", shapes())
def test_equal_tensions_give_the_cardinal_spline_of_real_points(shape):
    d = shape.points.shape[1]
    if d == 1:
        with pytest.raises(ValueError, match="at least 2 dimensions"):
            fit_planes(shape.points)
        return
    for axis in range(d):
        check_same(
            fit_planes(shape.points, 0.5, axis, shape.closed), cardinal_spline(shape.points, closed=shape.closed)
        )


@given(turning_points(), st.integers(0, 99), st.booleans())
def test_unequal_tensions_give_the_cardinal_spline_of_their_mean(points, seed, closed):
    closed &= len(points) > 3
    d = points.shape[1]
    tensions = np.random.default_rng(seed).uniform(0.1, 1.0, d - 1)
    for axis in range(d):
        found = fit_planes(points, tensions, axis, closed)
        check_same(found, cardinal_spline(points, tensions.mean(), closed=closed), slack=32)


@given(point_rows(dimensions=SPACES[1:], least=3), st.integers(0, 99))
def test_fit_planes_is_the_papers_algorithm_step_by_step(points, seed):
    d = points.shape[1]
    axis = seed % d
    tensions = np.random.default_rng(seed).uniform(0.1, 1.0, d - 1)
    others = [k for k in range(d) if k != axis]
    chains = [reference.cardinal_handles(points[:, [axis, k]], t) for k, t in zip(others, tensions, strict=True)]
    literal = [reference.merge([chain[k] for chain in chains], axis) for k in range(len(points) - 1)]
    along = np.abs(np.stack([chain[:, [1, 2], 0] - chain[:, [0, 3], 0] for chain in chains])).min()
    curve = fit_planes(points, tensions, axis)
    allowed = 64 * EPS * np.abs(points).max() * (1 + np.abs(points).max() / along)
    np.testing.assert_allclose(curve.poles[:-1].reshape(-1, 3, d), np.array(literal)[:, :3], rtol=0, atol=allowed)
    np.testing.assert_array_equal(curve.knots, reference.uniform_knots(len(curve.poles) - 1))


@pytest.mark.parametrize("tensions", [[0.5, -0.5], [0.0, 0.0], 0.0])
def test_tensions_that_cancel_give_handles_of_no_length(tensions):
    points = [[0, 0, 0], [1, 2, 3], [2, 0, 1]]
    check_same(fit_planes(points, tensions), cardinal_spline(points, 0.0))


@pytest.mark.parametrize(
    ("points", "tensions", "axis", "says"),
    [
        ([[0.0], [1.0]], 0.5, 0, "planar fits need points in at least 2 dimensions"),
        (np.eye(3), [0.5], 0, "2 planes need one finite tension, or 2, not"),
        (np.eye(3), [0.5, 0.5, 0.5], 0, "2 planes need one finite tension, or 2, not"),
        (np.eye(3), [0.5, np.nan], 0, "2 planes need one finite tension"),
        (np.eye(3), np.inf, 0, "2 planes need one finite tension"),
        (np.eye(3), [0.0, 0.5], 0, r"a plane of tension 0 has no direction .* \[0.0, 0.5\]"),
        (np.eye(3), 0.5, 3, "common_axis must be from 0 to 2, not 3"),
        (np.eye(3), 0.5, 0.5, "common_axis must be from 0 to 2, not 0.5"),
        (np.eye(3), 0.5, -1, "common_axis must be from 0 to 2, not -1"),
    ],
)
def test_bad_planes_are_named(points, tensions, axis, says):
    with pytest.raises(ValueError, match=says):
        fit_planes(points, tensions, axis)


@pytest.mark.parametrize("axis", [1.0, True, np.int8(1)])
def test_an_axis_is_a_number_whatever_its_type(axis):
    points = np.random.default_rng(0).normal(size=(5, 3))
    assert fit_planes(points, [0.2, 0.6], axis).isclose(fit_planes(points, [0.2, 0.6], 1), 0.0)
