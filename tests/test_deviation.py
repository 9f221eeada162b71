"""Deviation against brute force: dense samples, and ordered matching by a min-max dynamic programme."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cadfit
from cadfit.bezier import distance_to_segment
from cadfit.fitting.chords import chord_bounds
from cadfit.fitting.deviation import largest_between
from cadfit.fitting.matching import best_order, distances, match
from cadfit.fitting.starting import _started_at


def least_largest_distance(spline, points, per_span=400):
    """The least largest distance of points to places of the curve in order, over dense samples; and their spacing."""
    knots = spline.distinct_knots
    u = np.unique(np.concatenate([np.linspace(a, b, per_span) for a, b in zip(knots[:-1], knots[1:], strict=True)]))
    samples = spline(u)
    best = np.zeros(len(samples))
    for point in points:
        best = np.maximum(np.linalg.norm(samples - point, axis=1), np.minimum.accumulate(best))
    return best.min(), np.linalg.norm(np.diff(samples, axis=0), axis=1).max()


def sampled_between(spline, points, u, per_chord=200):
    """The largest distance over samples from the curve between u[i] and u[i + 1] to the segment of points i, i + 1."""
    u = np.concatenate([[spline.domain[0]], u[1:-1], [spline.domain[1]]])
    chords = zip(u[:-1], u[1:], points[:-1], points[1:], strict=True)
    return max(distance_to_segment(spline(np.linspace(a, b, per_chord)), p, q).max() for a, b, p, q in chords)


def hairpin(gap):
    """A path out along y = 0 and back along y = gap."""
    out = np.column_stack([np.arange(11.0), np.zeros(11)])
    return np.concatenate([out, [[10.5, gap / 2]], out[::-1] + [0, gap]])


def shapes():
    rng = np.random.default_rng(5)
    turn = np.linspace(0, 2 * np.pi, 41)
    loops = np.column_stack([turn - 1.6 * np.sin(turn * 4), np.cos(turn * 4)])
    eight = np.column_stack([np.sin(turn), np.sin(2 * turn)])
    cusps = np.column_stack([np.abs(((turn * 2) % 2) - 1), turn])
    twice = np.column_stack([np.cos(2 * turn), np.sin(2 * turn), 0.002 * turn])
    return {
        "random walk": rng.normal(size=(40, 2)).cumsum(axis=0),
        "random points": rng.normal(size=(25, 3)),
        "loops": loops,
        "figure eight": eight,
        "cusps": cusps,
        "nearly touching turns": twice,
        "hairpin": hairpin(0.01),
        "uneven": rng.normal(size=(30, 2)).cumsum(axis=0) * np.geomspace(1, 1e-3, 30)[:, None],
        "one dimension": rng.normal(size=(20, 1)),
    }


@pytest.mark.parametrize("name", shapes())
@pytest.mark.parametrize("noise", [0.0, 1e-3, 0.03])
def test_bounds_hold_and_are_within_a_thousandth_of_brute_force(name, noise):
    points = shapes()[name]
    spline = cadfit.cardinal_spline(points)
    noisy = points + noise * np.random.default_rng(1).normal(size=points.shape)
    found = cadfit.deviation(spline, noisy)
    truth, spacing = least_largest_distance(spline, noisy)
    # A sample misses the foot by up to half the spacing, so the brute force is above the truth by up to this:
    over = truth - np.sqrt(max(truth**2 - (spacing / 2) ** 2, 0.0))
    assert truth - over <= found.points <= truth * 1.001 + 1e-14 * spline.size
    u, _ = match(spline, noisy)
    assert np.all(np.diff(u) >= 0)
    sampled = sampled_between(spline, noisy, u)
    assert sampled <= found.between <= sampled * 1.002 + 1e-12
    gaps = np.linalg.norm(spline(u) - noisy, axis=1)
    assert found.rms == pytest.approx(np.sqrt(np.mean(gaps**2)), rel=1e-9, abs=1e-12)
    assert gaps[found.worst] == pytest.approx(gaps.max(), rel=1e-9, abs=1e-12)


def test_a_fit_is_taken_for_its_curves():
    points = hairpin(2.0)
    fit = cadfit.fit(points, 0.05)
    assert repr(cadfit.deviation(fit, points)) == repr(cadfit.deviation(fit.curves, points))


def test_interpolants_are_matched_at_their_own_parameters():
    points = np.random.default_rng(2).normal(size=(50, 3)).cumsum(axis=0)
    for spline, u in [
        (cadfit.cardinal_spline(points), np.r_[0, 3 * np.arange(1, 49) - 1, 145]),
        (cadfit.local_spline(points), cadfit.parametrize(points)),
        (cadfit.interpolate(points), cadfit.parametrize(points)),
        (cadfit.pieces_to_spline(cadfit.cardinal_pieces(points)), np.arange(50.0)),
    ]:
        assert np.abs(match(spline, points)[0] - u).max() <= 1e-12 * u[-1]
        found = cadfit.deviation(spline, points)
        sampled = sampled_between(spline, points, u, 1000)
        assert found.points < 1e-13 * spline.size * 50
        assert sampled <= found.between <= sampled * 1.0006


def test_order_is_kept_where_the_nearest_place_would_lie():
    path = hairpin(0.01)
    spline = cadfit.local_spline(path)
    swapped = np.concatenate([path[-1:11:-1], [[10.5, 0.005]], path[10::-1]])  # the way back first
    nearest = spline.nearest(swapped)[1].max()
    found = cadfit.deviation(spline, swapped)
    assert nearest < 1e-12
    assert found.points <= least_largest_distance(spline, swapped)[0] * 1.001
    assert found.points > 0.0099  # across the gap, where the nearest place has 0
    spiral = np.column_stack([np.exp(np.arange(12.0) / 9) * np.cos(np.arange(12.0)), np.arange(12.0)])
    assert cadfit.deviation(cadfit.local_spline(spiral), spiral[::-1]).points > 1.0  # backwards


def test_a_detour_between_the_points_is_seen():
    line = np.column_stack([np.arange(9.0), np.zeros(9)])
    straight = cadfit.local_spline(line)
    middle = len(straight.poles) // 2
    poles = straight.poles.copy()
    poles[middle - 1 : middle + 2, 1] += [0.0, 0.3, 0.0]
    bumped = cadfit.BSpline(poles, straight.knots)
    assert cadfit.deviation(straight, line).between < 1e-12
    assert cadfit.deviation(bumped, line[[0, 8]]).points < 1e-12
    seen = cadfit.deviation(bumped, line[[0, 8]]).between
    top = np.abs(bumped(np.linspace(*bumped.domain, 200001))[:, 1]).max()
    assert top <= seen <= top * 1.001


def test_a_pole_moved_by_a_millionth_is_seen():
    points = np.random.default_rng(3).normal(size=(30, 2)).cumsum(axis=0)
    spline = cadfit.interpolate(points)
    poles = spline.poles.copy()
    poles[12] += 1e-6 * spline.size
    before = cadfit.deviation(spline, points).points
    after = cadfit.deviation(cadfit.BSpline(poles, spline.knots), points).points
    assert before < 1e-12 * spline.size < 1e-7 * spline.size < after < 1e-6 * spline.size


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(2, 40), st.integers(4, 30), st.floats(1e-6, 1.0))
def test_bounds_hold_for_any_curve_and_points(seed, d, n, n_poles, noise):
    """Unrelated point counts, multiple knots, uneven spans: never below what brute force finds with the same order."""
    rng = np.random.default_rng(seed)
    inner = np.sort(rng.choice(rng.uniform(0, 1, n_poles), n_poles - 4))
    while np.any(inner[3:] == inner[:-3]) or np.any(inner == 0):
        inner = np.sort(rng.uniform(0, 1, n_poles - 4))
    spline = cadfit.BSpline(rng.normal(size=(n_poles, d)).cumsum(axis=0), np.r_[[0.0] * 4, inner, [1.0] * 4])
    points = spline(np.sort(rng.uniform(0, 1, n))) + noise * rng.normal(size=(n, d))
    found = cadfit.deviation(spline, points)
    truth, spacing = least_largest_distance(spline, points, 100)
    assert found.points >= truth - spacing / 2
    assert found.points >= found.rms * (1 - 1e-12)
    u = np.concatenate([spline.domain[:1], match(spline, points)[0][1:-1], spline.domain[1:]])
    bound = largest_between(spline, points, u, distances(spline, points, u), 0.0)
    assert bound >= sampled_between(spline, points, u) - 1e-14 * spline.size


@given(st.integers(0, 2**32 - 1), st.floats(-6, 6), st.integers(2, 3))  # in 1D many orders are equally good
def test_bounds_scale_and_move_with_the_curve(seed, power, d):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, d)).cumsum(axis=0)
    spline = cadfit.local_spline(points)
    noisy = points + 0.01 * rng.normal(size=points.shape)
    scale, offset = 10.0**power, rng.normal(size=d)
    here = cadfit.deviation(spline, noisy)
    there = cadfit.deviation(spline.transformed(scale * np.eye(d), scale * offset), scale * (noisy + offset))
    # Two different refinements of the same truth, each within 0.05 % of it.
    assert there.points == pytest.approx(scale * here.points, rel=1.1e-3)
    assert there.between == pytest.approx(scale * here.between, rel=1.1e-3)


@pytest.mark.parametrize("shift", [0, 1, 7, 23])
@pytest.mark.parametrize("repeat", [False, True])
def test_a_closed_curve_may_start_anywhere_on_the_contour(shift, repeat):
    turn = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.column_stack([3 * np.cos(turn), np.sin(turn)])
    spline = cadfit.local_spline(ring, closed=True)
    points = np.roll(ring, -shift, axis=0) * (1 + 1e-3 * np.cos(5 * turn))[:, None]
    given_points = np.concatenate([points, points[:1]]) if repeat else points
    found = cadfit.deviation(spline, given_points, closed=True)
    own = spline.nearest(points)[1]
    assert own.max() <= found.points <= own.max() * 1.0001 + 1e-13
    assert found.rms == pytest.approx(np.sqrt(np.mean(own**2)), rel=1e-6)
    dense = spline(np.linspace(*spline.domain, 20001))
    loop = np.concatenate([points, points[:1]])
    nearest = np.min([distance_to_segment(dense, p, q) for p, q in zip(loop[:-1], loop[1:], strict=True)], axis=0)
    assert nearest.max() <= found.between <= nearest.max() * 1.02  # its own chord, not a neighbour's, counts


def crossing():
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    return np.column_stack([np.sin(turn), np.sin(2 * turn)])


def twice_round():
    turn = np.linspace(0, 4 * np.pi, 80, endpoint=False)
    return (1 + 0.02 * np.cos(turn / 2))[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])


@pytest.mark.parametrize(
    ("contour", "noise"),
    [(crossing(), 0.0), (crossing(), 1e-3), pytest.param(twice_round(), 5e-3, marks=pytest.mark.slow)],
)
def test_a_closed_curve_starts_on_the_branch_the_first_point_is_on(contour, noise):
    spline = cadfit.local_spline(contour, closed=True)
    points = contour + noise * np.random.default_rng(0).normal(size=contour.shape)
    found = [cadfit.deviation(spline, np.roll(points, -k, axis=0), closed=True) for k in range(0, len(points), 5)]
    own = np.linalg.norm(spline(cadfit.parametrize(contour, closed=True)[:-1]) - points, axis=1).max()
    assert max(each.points for each in found) <= own * 1.001 + 1e-13
    assert max(each.between for each in found) <= 1.001 * min(each.between for each in found)


@pytest.mark.parametrize("ulps", [-3, -1, 0, 1, 3])
def test_a_closed_curve_may_start_a_rounding_beside_a_knot(ulps):
    spline = cadfit.local_spline(crossing(), closed=True)
    knot = spline.distinct_knots[1]  # early: its roundings are lost a period later
    started = _started_at(spline, knot + ulps * np.spacing(knot), spline(knot))
    np.testing.assert_allclose(started(started.domain[0]), spline(knot), rtol=0, atol=1e-14)
    assert started.closed


def test_several_curves_joined_at_corners():
    sides = [
        np.column_stack([np.linspace(0, 4, 9), np.zeros(9)]),
        np.column_stack([np.full(9, 4.0), np.linspace(0, 2, 9)]),
    ]
    curves = [cadfit.local_spline(side) for side in sides]
    points = np.concatenate([sides[0], sides[1][1:]])
    found = cadfit.deviation(curves, points)
    assert found.points < 1e-13
    assert found.between < 1e-13
    cut = cadfit.deviation(curves, np.delete(points, 8, axis=0))  # without the corner the curve is far from its chord
    assert cut.between == pytest.approx(0.5 * 0.25 / np.hypot(0.5, 0.25), rel=1e-3)
    with pytest.raises(ValueError, match="curve 1 starts"):
        cadfit.deviation(curves[::-1], points)


def test_points_out_of_order_along_the_curve_share_the_error():
    line = cadfit.local_spline(np.column_stack([np.arange(11.0), np.zeros(11)]))
    points = np.array([[0, 0], [3.2, 0.1], [2.8, 0.1], [2.8, -0.1], [10, 0]])
    found = cadfit.deviation(line, points)
    assert found.points == pytest.approx(np.hypot(0.2, 0.1), rel=1e-3)  # all three at 3.0: what an order allows at best
    assert found.points >= np.hypot(0.2, 0.1)


@pytest.mark.slow
def test_noise_denser_than_its_size_is_bounded_as_brute_force_does():
    rng = np.random.default_rng(4)
    turn = np.linspace(0, 2 * np.pi, 800)
    spline = cadfit.local_spline(np.column_stack([np.cos(turn[::40]), np.sin(turn[::40])]))
    noisy = np.column_stack([np.cos(turn), np.sin(turn)]) + 0.02 * rng.normal(size=(800, 2))
    found = cadfit.deviation(spline, noisy)
    truth, _ = least_largest_distance(spline, noisy, 2000)
    assert truth * (1 - 1e-5) <= found.points <= truth * 1.001


@pytest.mark.slow
@pytest.mark.parametrize("n", [1500, 6000])
def test_more_points_than_the_dynamic_programme_takes_at_once(n):
    t = np.linspace(0, 12 * np.pi, n)
    points = np.column_stack([t * np.cos(t), t * np.sin(t)]) / 10
    spline = cadfit.interpolate(points[:: n // 300])
    kept = points[: (n - 1) // (n // 300) * (n // 300) + 1] + 1e-3 * np.random.default_rng(0).normal(size=(1, 2))
    found = cadfit.deviation(spline, kept)
    own = spline.nearest(kept)[1]  # the turns are far apart here, so the nearest place is the right one
    assert own.max() <= found.points <= own.max() * 1.001


def test_large_offsets_do_not_drown_small_deviations():
    rng = np.random.default_rng(6)
    points = rng.normal(size=(30, 3)).cumsum(axis=0) * 1e-3
    noisy = points + 1e-6 * rng.normal(size=points.shape)
    here = cadfit.deviation(cadfit.local_spline(points), noisy)
    far = cadfit.deviation(cadfit.local_spline(points + 6.4e6), noisy + 6.4e6)
    assert far.points == pytest.approx(here.points, abs=3e-9)  # an ulp at 6.4e6 is 9e-10


def test_two_points_and_a_segment():
    line = cadfit.interpolate([[0, 0], [4, 0]])
    found = cadfit.deviation(line, [[0, 1], [4, 1]])
    assert found.points == pytest.approx(1.0, rel=1e-12)
    assert found.between == pytest.approx(1.0, rel=1e-12)


def test_bad_input_is_named():
    line = cadfit.interpolate([[0, 0], [4, 0]])
    with pytest.raises(ValueError, match=r"row 1 .* not finite"):
        cadfit.deviation(line, [[0, 0], [np.nan, 0]])
    with pytest.raises(ValueError, match="3 coordinates, the curve 2"):
        cadfit.deviation(line, [[0, 0, 0], [1, 0, 0]])
    with pytest.raises(ValueError, match="ends where it starts"):
        cadfit.deviation(line, [[0, 0], [1, 0], [1, 1]], closed=True)


def test_a_straight_run_at_uneven_speed_costs_no_refinement_beyond_rounding():
    """A cubic that runs along its chord has a large second derivative and no deviation."""
    points = np.random.default_rng(0).normal(size=(200, 3))
    found = cadfit.deviation(cadfit.cardinal_spline(points, tension=0.0), points)
    assert found.between < 1e-12


def test_best_order_is_the_optimum_of_all_orders():
    rng = np.random.default_rng(7)
    for _ in range(20):
        points, samples = rng.normal(size=(4, 2)), rng.normal(size=(7, 2))
        found, place = best_order(points, samples)
        square = distance_to_segment(points[:, None], samples[:-1], samples[1:]) ** 2
        orders = np.array(np.meshgrid(*[range(6)] * 4, indexing="ij")).reshape(4, -1).T
        orders = orders[np.all(np.diff(orders, axis=1) >= 0, axis=1)]
        every = square[np.arange(4), orders]
        best = every[every.max(axis=1) <= every.max(axis=1).min() * (1 + 1e-9)].sum(axis=1).min()
        assert np.all(np.diff(found) >= 0)
        assert square[np.arange(4), found].sum() == pytest.approx(best, rel=1e-9)
        feet = samples[found] + place[:, None] * (samples[found + 1] - samples[found])
        assert np.linalg.norm(feet - points, axis=1) ** 2 == pytest.approx(square[np.arange(4), found], rel=1e-9)


def test_largest_between_is_exact_for_a_parabola():
    arc = cadfit.BSpline([[0, 0], [1, 1], [2, 1], [3, 0]], [0, 0, 0, 0, 1, 1, 1, 1])
    points, u = np.array([[0.0, 0.0], [3.0, 0.0]]), np.array([0.0, 1.0])
    assert largest_between(arc, points, u, np.zeros(2), 0.0) == pytest.approx(0.75)


def test_what_joining_moves_is_counted():
    """Joints may be open by 1e-9 of the size; the pole moved there must not make the bound too small."""
    gap = 5e-10
    before = cadfit.interpolate([[0, 0], [1, 0]])
    after = cadfit.interpolate([[1, gap], [2, gap]])
    found = cadfit.deviation([before, after], [[0, 0], [0.99, 1e-9], [2, gap]])
    assert 1e-9 <= found.points <= 1e-9 + 2 * gap  # from the curve as given, 1e-9


def test_the_same_where_a_closed_curve_is_started_elsewhere():
    turn = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ring = cadfit.local_spline(np.column_stack([np.cos(turn), np.sin(turn)]), closed=True)
    poles = ring.poles.copy()
    poles[-1] += [1e-9, 0]
    given = cadfit.BSpline(poles, ring.knots)
    points = np.roll(ring(ring.distinct_knots[:-1:3]), -4, axis=0)
    exact, moved = (cadfit.deviation(curve, points, closed=True) for curve in (ring, given))
    assert exact.points + 1e-9 <= moved.points + 1e-13
    assert moved.points <= 2.1e-9


def sampled_chords(spline, points, u, per_chord=200):
    """The largest distance over samples from the curve between u[i] and u[i + 1] to each chord (n - 1,)."""
    chords = zip(u[:-1], u[1:], points[:-1], points[1:], strict=True)
    return np.array([distance_to_segment(spline(np.linspace(a, b, per_chord)), p, q).max() for a, b, p, q in chords])


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.integers(2, 30), st.sampled_from([0.0, 1e-3, 1.0]))
def test_the_bound_of_no_chord_is_too_small(seed, d, n, noise):
    """Knots anywhere, double and triple ones too, chord ends on them or not, some chords of no width."""
    rng = np.random.default_rng(seed)
    distinct = np.sort(rng.uniform(0, 1, 6)) ** rng.choice([1, 4])
    inner = np.repeat(distinct, rng.integers(1, 4, 6))
    spline = cadfit.BSpline(rng.normal(size=(len(inner) + 4, d)), np.r_[[0.0] * 4, inner, [1.0] * 4])
    u = np.sort(rng.choice(np.r_[0.0, 1.0, distinct, distinct, rng.uniform(0, 1, n)], n))
    points = spline(u) + noise * rng.normal(size=(n, d))
    upper, sampled = chord_bounds(spline, u, distances(spline, points, u)), sampled_chords(spline, points, u)
    assert np.all(upper >= sampled - 1e-14 * spline.size)
    inside = np.searchsorted(spline.knots, u[1:]) - np.searchsorted(spline.knots, u[:-1], side="right")
    np.testing.assert_array_equal(np.isinf(upper), inside > 2)


@pytest.mark.parametrize("spans", [1, 2, 3])
def test_the_bound_of_a_chord_is_tight_on_an_arc(spans):
    turn = np.linspace(0, 2, 60 * spans + 1)
    spline = cadfit.interpolate(np.column_stack([np.cos(turn), np.sin(turn)]))
    u = spline.distinct_knots[::spans]
    upper, sampled = chord_bounds(spline, u, np.zeros(61)), sampled_chords(spline, spline(u), u)
    assert np.all(upper >= sampled - 1e-15)
    np.testing.assert_allclose(upper[2:-2], sampled[2:-2], rtol=1e-3)


def test_the_bound_of_a_chord_sees_a_pole_moved_by_a_thousandth():
    """The judge above fails for bounds of a curve that is not the one sampled."""
    turn = np.linspace(0, 2, 61)
    spline = cadfit.local_spline(np.column_stack([np.cos(turn), np.sin(turn)]))
    poles = spline.poles.copy()
    poles[90] *= 1.001
    bumped = cadfit.BSpline(poles, spline.knots)
    u = spline.distinct_knots[np.clip(3 * np.arange(61) - 1, 0, len(spline.distinct_knots) - 1)]
    upper = chord_bounds(spline, u, np.zeros(61))
    assert np.any(upper < sampled_chords(bumped, spline(u), u))
