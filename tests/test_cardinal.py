"""The paper's algorithm FC2: its matrices and knots taken literally, and the facts users decide by."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cadfit import c2_spline, cardinal_pieces, cardinal_spline, pieces_to_spline
from cadfit.fitting.cardinal import point_triples

import reference
from corpus_data import point_rows, rotation, shapes, turn
from reference import EPS, magnitude

tensions = st.floats(-1, 2)
SHARES = [0.0, 0.4, 1.0]


def at_points(n, closed):
    """The parameters of n points on the step-3 curve, as the paper counts them."""
    return 3.0 * np.arange(n) if closed else np.clip(3.0 * np.arange(n) - 1, 0, 3 * n - 5)


def neighbours(points, closed):
    """The points before and after each; an open curve's ends stand in for the missing ones."""
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    if not closed:
        before[0], after[-1] = points[0], points[-1]
    return before, after


def second_jumps(curve):
    """How far the second derivative jumps at each inner knot, and at the seam of a closed curve, times its span^2."""
    pieces, spans = curve.pieces(), np.diff(curve.distinct_knots)
    start = 6 * np.diff(pieces[:, :3], n=2, axis=1)[:, 0] / spans[:, None] ** 2
    end = 6 * np.diff(pieces[:, 1:], n=2, axis=1)[:, 0] / spans[:, None] ** 2
    left, right, least = end[:-1], start[1:], np.minimum(spans[:-1], spans[1:])
    if curve.closed:
        left, right = np.vstack([left, end[-1:]]), np.vstack([right, start[:1]])
        least = np.append(least, min(spans[0], spans[-1]))
    return np.abs(left - right).max(axis=1, initial=0) * least**2


def check_facts(points, closed, tension, share):
    """The facts of the step-3 curve at the points; to rounding of the poles."""
    curve = cardinal_spline(points, tension, share, closed)
    u = at_points(len(points), closed)
    before, after = neighbours(points, closed)
    inner = slice(None) if closed else slice(1, -1)
    unit = EPS * magnitude(curve)
    np.testing.assert_allclose(curve(u), points, rtol=0, atol=8 * unit)
    slopes = tension * (after - before) / 3
    bends = share * (after - 2 * points + before) / 9
    np.testing.assert_allclose(curve.derivative(u)[inner], slopes[inner], rtol=0, atol=16 * unit)
    np.testing.assert_allclose(curve.derivative(u, 2)[inner], bends[inner], rtol=0, atol=32 * unit)
    if not closed:
        np.testing.assert_allclose(curve.derivative(u[[0, -1]]), 3 * slopes[[0, -1]], rtol=0, atol=16 * unit)
    assert curve.closed == closed or np.array_equal(points[0], points[-1])
    assert set(curve.multiplicities[1:-1]) <= {1}
    assert second_jumps(curve).max(initial=0) <= 128 * unit


# Steps 1 and 2: the chain of Bézier pieces


@given(point_rows(), tensions, st.booleans())
def test_pieces_are_the_geometry_matrix(points, tension, closed):
    if closed and len(points) < 3:
        closed = False
    pieces = cardinal_pieces(points, tension, closed)
    allowed = 32 * EPS * (1 + abs(tension)) * np.abs(points).max()
    for u in (0.0, 0.25, 0.5, 0.7, 1.0):
        truth = reference.cardinal_segments(points, tension, u, closed)
        found = [reference.de_casteljau(piece, u) for piece in pieces]
        np.testing.assert_allclose(found, truth, rtol=0, atol=allowed)


@given(point_rows(), tensions)
def test_handles_are_the_papers(points, tension):
    allowed = 4 * EPS * (1 + abs(tension)) * np.abs(points).max()
    handles = reference.cardinal_handles(points, tension)
    np.testing.assert_allclose(cardinal_pieces(points, tension), handles, rtol=0, atol=allowed)


@pytest.mark.parametrize("shape", shapes())
def test_pieces_of_real_points_are_the_geometry_matrix_and_c1(shape):
    pieces = cardinal_pieces(shape.points, closed=shape.closed)
    middle = reference.cardinal_segments(shape.points, 0.5, 0.5, shape.closed)
    np.testing.assert_allclose(pieces.sum(axis=1) / 8 + pieces[:, 1:3].sum(axis=1) / 4, middle,
                               rtol=0, atol=32 * EPS * shape.reach)  # fmt: skip
    around = np.concatenate([pieces, pieces[:1]]) if shape.closed else pieces
    np.testing.assert_array_equal(around[1:, 0], around[:-1, 3])
    leave, arrive = around[1:, 1] - around[1:, 0], around[:-1, 3] - around[:-1, 2]
    np.testing.assert_allclose(leave, arrive, rtol=0, atol=4 * EPS * np.abs(pieces).max())
    assert len(pieces) == len(shape.points) - (not shape.closed)


# Step 3: the C2 curve


@given(point_rows(), tensions)
def test_poles_and_knots_of_step_three_are_the_papers(points, tension):
    curve = cardinal_spline(points, tension)
    np.testing.assert_array_equal(curve.knots, reference.uniform_knots(len(curve.poles) - 1))
    np.testing.assert_array_equal(curve.poles[:-1].reshape(-1, 3, points.shape[1]),
                                  cardinal_pieces(points, tension)[:, :3])  # fmt: skip
    np.testing.assert_array_equal(curve.poles[-1], points[-1])


@given(point_rows(least=3), tensions, st.floats(-1, 2), st.booleans())
def test_facts_at_random_points(points, tension, share, closed):
    check_facts(points, closed, tension, share)


@pytest.mark.parametrize("shape", shapes())
def test_facts_at_real_points(shape):
    for share in SHARES:
        check_facts(shape.points, shape.closed, 0.5, share)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e9])
@pytest.mark.parametrize("offset", [0.0, 6.4e6])
def test_facts_hold_at_any_scale_and_offset(scale, offset):
    points = scale * np.random.default_rng(2).normal(size=(20, 3)) + offset * max(scale, 1)
    for closed in (False, True):
        check_facts(points, closed, 0.5, 1.0)


def test_an_offset_costs_no_more_than_its_own_rounding():
    points = 1e-3 * np.random.default_rng(2).normal(size=(20, 2)) + 6.4e6 - 6.4e6
    for share in SHARES:
        near, far = cardinal_spline(points, curvature=share), cardinal_spline(points + 6.4e6, curvature=share)
        np.testing.assert_allclose(far.poles - 6.4e6, near.poles, rtol=0, atol=2 * EPS * 6.4e6)


@given(point_rows(dimensions=(2,), least=2, most=3), tensions, st.sampled_from(SHARES))
def test_two_and_three_points(points, tension, share):
    check_facts(points, False, tension, share)
    if len(points) == 2:
        thirds = points[0] + np.outer([0, tension, 3 - tension, 3], (points[1] - points[0]) / 3)
        found = cardinal_spline(points, tension, share).poles
        np.testing.assert_allclose(found, thirds, rtol=0, atol=8 * EPS * np.abs(found).max())


@pytest.mark.parametrize("share", SHARES)
@given(points=point_rows(least=3), seed=st.integers(0, 99), closed=st.booleans())
def test_affine_maps_of_the_points_are_those_of_the_curve(share, points, seed, closed):
    d = points.shape[1]
    rng = np.random.default_rng(seed)
    matrix, offset = rng.normal(size=(d, d)), rng.normal(size=d)
    mapped = cardinal_spline(points @ matrix.T + offset, 0.5, share, closed)
    moved = cardinal_spline(points, 0.5, share, closed).transformed(matrix, offset)
    size = np.abs(matrix).sum(axis=1).max() * np.abs(points).max() + np.abs(offset).max()
    np.testing.assert_allclose(mapped.poles, moved.poles, rtol=0, atol=32 * EPS * size)


@pytest.mark.parametrize("share", SHARES)
@given(points=point_rows(least=3), closed=st.booleans())
def test_reversed_points_give_the_reversed_curve(share, points, closed):
    curve = cardinal_spline(points, 0.5, share, closed)
    backwards = np.roll(points[::-1], 1, axis=0) if closed else points[::-1]
    other = cardinal_spline(backwards, 0.5, share, closed)
    np.testing.assert_array_equal(other.knots, curve.reversed().knots)
    np.testing.assert_allclose(other.poles, curve.reversed().poles, rtol=0, atol=16 * EPS * magnitude(curve))


@pytest.mark.parametrize("share", SHARES)
@given(data=st.data())
def test_a_moved_point_changes_the_curve_only_from_the_second_before_to_the_second_after(share, data):
    points = data.draw(point_rows(least=8))
    moved = data.draw(st.integers(0, len(points) - 1))
    other = points.copy()
    other[moved] += 1.0
    before, after = cardinal_spline(points, 0.5, share), cardinal_spline(other, 0.5, share)
    u = np.linspace(*before.domain, 40 * len(points) + 1)
    same = np.all(before(u) == after(u), axis=1)
    near = (u > 3 * moved - 7) & (u < 3 * moved + 5)
    assert same[~near].all()
    assert not same[near].all()


@given(data=st.data())
def test_a_moved_point_of_a_closed_curve_changes_only_the_pieces_near_it(data):
    points = data.draw(point_rows(least=8))
    moved = data.draw(st.integers(0, len(points) - 1))
    other = points.copy()
    other[moved] += 1.0
    before, after = (cardinal_spline(p, 0.5, 1.0, closed=True) for p in (points, other))
    far = (np.arange(3 * len(points)) - 3 * moved + 6) % (3 * len(points)) >= 12
    apart = np.abs(before.pieces() - after.pieces()).max(axis=(1, 2))
    assert apart[far].max() <= 16 * EPS * magnitude(after)
    assert apart[~far].min() > 1e-3


# Closed curves


@pytest.mark.parametrize("share", SHARES)
@given(points=point_rows(least=3))
def test_the_first_point_may_be_repeated_or_not(share, points):
    once = cardinal_spline(points, 0.5, share, closed=True)
    twice = cardinal_spline(np.vstack([points, points[:1]]), 0.5, share, closed=True)
    np.testing.assert_array_equal(once.poles, twice.poles)
    np.testing.assert_array_equal(once.knots, twice.knots)


@pytest.mark.parametrize("share", SHARES)
@given(points=point_rows(least=3), by=st.integers(1, 5))
def test_a_closed_curve_does_not_care_where_it_begins(share, points, by):
    by %= len(points)
    here = cardinal_spline(points, 0.5, share, closed=True).pieces()
    there = cardinal_spline(np.roll(points, -by, axis=0), 0.5, share, closed=True).pieces()
    np.testing.assert_allclose(there, np.roll(here, -3 * by, axis=0), rtol=0, atol=32 * EPS * np.abs(here).max())


# What the docs say about the circle


@pytest.mark.parametrize(("share", "least", "most"), [(0.0, "0.00", "1.46"), (1.0, "0.85", "1.10")])
def test_curvature_on_twelve_points_of_a_circle(share, least, most):
    ring = cardinal_spline(turn(12), curvature=share, closed=True)
    bends = np.linalg.norm(ring.curvature(np.linspace(*ring.domain, 36 * 100 + 1)), axis=1)
    assert (f"{bends.min():.2f}", f"{bends.max():.2f}") == (least, most)


@pytest.mark.parametrize(("share", "order"), [(0.0, 2), (1.0, 4)])
def test_order_of_convergence_on_the_circle(share, order):
    errors = []
    for n in (24, 48, 96):
        ring = cardinal_spline(turn(n), curvature=share, closed=True)
        errors.append(abs(np.linalg.norm(ring(np.linspace(0, 9, 2001)), axis=1) - 1).max())
    found = -np.diff(np.log2(errors))
    np.testing.assert_allclose(found, order, atol=0.1)


# point_triples


@given(point_rows(least=3, most=3), st.floats(-2, 2), st.floats(-2, 2))
def test_a_triple_gives_value_first_and_second_derivative(rows, left, right):
    """Two spans a on the left, two spans b on the right; other poles do not matter at the knot."""
    a, b = 10.0**left, 10.0**right
    triple = point_triples(*rows[:, :, None], np.array([a]), np.array([b]))[0]
    knots = np.array([-9 * a - 3, -3 * a, -2 * a, -a, 0, b, 2 * b, 3 * b, 9 * b + 3])
    poles = np.vstack([np.full_like(triple[:1], 7.0), triple, np.full_like(triple[:1], -5.0)])
    for order in range(3):
        found = sum(reference.basis_derivative(i, 4, knots, 0.0, order) * poles[i] for i in range(5))
        unit = EPS * np.abs(triple).max() / min(a, b) ** order
        np.testing.assert_allclose(found, rows[order], rtol=0, atol=32 * unit)


# Chains as splines


@st.composite
def chains(draw):
    """Random chains (m, 4, d), some joints smooth, some corners; says which are corners."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    pieces = rng.normal(size=(draw(st.integers(1, 9)), 4, draw(st.integers(1, 4))))
    pieces[1:, 0] = pieces[:-1, 3]
    corner = rng.random(len(pieces) - 1) < 0.4
    for k in np.flatnonzero(~corner):
        pieces[k + 1, 1] = pieces[k + 1, 0] + (pieces[k, 3] - pieces[k, 2])
    return pieces, corner


@given(chains())
def test_a_chain_as_a_spline_is_the_same_curve(chain):
    pieces, corner = chain
    spline = pieces_to_spline(pieces)
    assert spline.distinct_knots.tolist() == list(range(len(pieces) + 1))
    assert spline.multiplicities[1:-1].tolist() == np.where(corner, 3, 2).tolist()
    assert len(spline.poles) == 2 * len(pieces) + 2 + corner.sum()
    np.testing.assert_allclose(spline.pieces(), pieces, rtol=0, atol=4 * EPS * np.abs(pieces).max())


@pytest.mark.parametrize("shape", shapes())
def test_a_cardinal_chain_has_double_knots_alone(shape):
    pieces = cardinal_pieces(shape.points, closed=shape.closed)
    spline = pieces_to_spline(pieces)
    assert set(spline.multiplicities[1:-1]) <= {2}
    np.testing.assert_allclose(spline.pieces(), pieces, rtol=0, atol=4 * EPS * np.abs(pieces).max())


@given(point_rows(least=3), tensions, st.booleans())
def test_c2_of_the_cardinal_chain_is_the_cardinal_spline(points, tension, closed):
    once = c2_spline(cardinal_pieces(points, tension, closed), closed)
    whole = cardinal_spline(points, tension, closed=closed)
    np.testing.assert_array_equal(once.poles, whole.poles)
    np.testing.assert_array_equal(once.knots, whole.knots)


@given(chains())
def test_c2_of_a_smooth_chain_passes_its_joints_straight(chain):
    pieces, corner = chain
    spline = c2_spline(pieces)
    k = np.flatnonzero(~corner) + 1
    unit = EPS * np.abs(pieces).max()
    np.testing.assert_allclose(spline(3.0 * k - 1), pieces[k, 0], rtol=0, atol=8 * unit)
    np.testing.assert_allclose(spline.derivative(3.0 * k - 1), pieces[k, 1] - pieces[k, 0], rtol=0, atol=16 * unit)
    np.testing.assert_allclose(spline.derivative(3.0 * k - 1, 2), 0, rtol=0, atol=32 * unit)


@pytest.mark.parametrize("use", [c2_spline, pieces_to_spline])
@pytest.mark.parametrize(
    ("pieces", "says"),
    [
        (np.zeros((0, 4, 2)), r"pieces must have the shape \(m, 4, d\), not \(0, 4, 2\)"),
        (np.zeros((4, 2)), r"pieces must have the shape \(m, 4, d\), not \(4, 2\)"),
        (np.zeros((1, 3, 2)), r"pieces must have the shape \(m, 4, d\), not \(1, 3, 2\)"),
        (np.zeros((1, 4, 0)), r"pieces must have the shape \(m, 4, d\), not \(1, 4, 0\)"),
        (np.full((2, 4, 2), np.nan), "poles must be finite"),
    ],
)
def test_bad_chains_are_named(use, pieces, says):
    with pytest.raises(ValueError, match=says):
        use(pieces)


def test_a_broken_chain_names_the_piece_and_the_gap():
    pieces = cardinal_pieces(turn(5), closed=True).copy()
    pieces[3:] += [0.0, 0.25]
    with pytest.raises(ValueError, match=r"piece 3 starts 0\.25 away from the end of piece 2: the chain is broken"):
        pieces_to_spline(pieces)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_joined_and_smooth_mean_to_a_millionth_of_a_millionth(scale):
    pieces = cardinal_pieces([[0, 0], [1, 1], [0, 1], [1, 0]])  # no coordinate is larger than 1
    for by, multiplicity in ((0.5e-12, 2), (2e-12, 3)):
        kinked = pieces.copy()
        kinked[1, 1, 0] += by
        assert pieces_to_spline(scale * kinked).multiplicities.tolist() == [4, multiplicity, 2, 4]
    apart = pieces + 0.5e-12 * np.arange(3)[:, None, None]
    assert pieces_to_spline(scale * apart).multiplicities.tolist() == [4, 2, 2, 4]
    with pytest.raises(ValueError, match=r"piece 1 starts .* away from the end of piece 0"):
        pieces_to_spline(scale * (pieces + 2e-12 * np.arange(3)[:, None, None]))


@given(st.integers(0, 99))
def test_turned_points_give_the_turned_pieces(seed):
    points, matrix = turn(7) + 3, rotation(2, seed)
    found = cardinal_pieces(points @ matrix.T, closed=True)
    np.testing.assert_allclose(found, cardinal_pieces(points, closed=True) @ matrix.T, rtol=0, atol=32 * EPS * 5)
