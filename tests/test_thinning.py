"""Knots taken away one by one: none that can go is left, and none goes that is needed."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import cadfit
from cadfit.fitting.checking import Stretch
from cadfit.fitting.knots import expected, importance, largest_errors, without
from cadfit.fitting.relax import relax, start
from cadfit.fitting.search import _APART, _far_apart, _moved, evenly_fewer, few, first_knots, grow, singly_fewer
from cadfit.fitting.thinning import in_order, thinned
from cadfit.stages import unheard

from corpus_data import curves


def grown(points, tolerance, closed=False):
    """Return a trial that meets the targets of the points (n, d)."""
    n = len(points)
    alone = np.zeros(n, dtype=bool)
    goal = Stretch(points, tolerance, closed, False, np.ones(n), alone, (None, None)).goal(np.arange(n))
    trial = grow(goal, first_knots(goal), goal.u)
    assert trial.met
    return trial


def wave(n=300):
    t = np.linspace(0.0, 1.0, n)
    return np.column_stack([t, 0.05 * np.sin(30.0 * t * (1.0 + t))])


def ring(n=240):
    t = np.linspace(0.0, 2.0 * np.pi, n, endpoint=False)
    radius = 0.4 + 0.05 * np.cos(9.0 * t)
    return radius[:, None] * np.column_stack([np.cos(t), np.sin(t)])


def test_a_jump_leaves_a_162nd_part_of_itself():
    """The best cubic for |x|^3 / 12, whose third derivative jumps by 1, by linear programming over many places."""
    x = np.linspace(-1.0, 1.0, 4001)
    basis = np.vander(x, 4)
    bound = -np.ones((len(x), 1))
    rows = np.vstack([np.hstack([basis, bound]), np.hstack([-basis, bound])])
    target = np.abs(x) ** 3 / 12.0
    found = linprog([0, 0, 0, 0, 1], rows, np.concatenate([target, -target]), bounds=[(None, None)] * 4 + [(0, None)])
    assert found.fun == pytest.approx(1.0 / 162.0, rel=1e-5)


@pytest.mark.parametrize(("points", "closed"), [(wave(), False), (ring(), True)])
def test_largest_errors_and_what_is_expected(points, closed):
    trial = grown(points, 2e-4, closed)
    spans, which = trial.curve.spans, trial.curve.spans.find(trial.u)
    worst, starts = largest_errors(trial)
    for k in range(spans.count):
        inside = trial.error[which % spans.count == k] if closed else trial.error[which == k]
        assert worst[k] == max(inside, default=0.0)
        assert starts[k] == np.sum(which < k)
    jumps = importance(trial) / (162.0 * trial.goal.allowed[0])
    for k, found in enumerate(expected(trial)):
        beside = (worst[k - 1], worst[k]) if closed else (worst[k], worst[k + 1])
        assert found == pytest.approx(max(beside) + jumps[k], rel=1e-12)


def test_on_a_smooth_curve_all_knots_move_for_some_to_be_spared():
    """A helix, equally bent everywhere: single knots do not go where fewer even ones do."""
    t = np.linspace(0.0, 8.0 * np.pi, 401)
    trial = few(grown(np.column_stack([np.cos(t), np.sin(t), t / 8.0]) / 4.0, 2.5e-4))
    even = evenly_fewer(trial)
    assert even.met
    assert even.curve.spans.count < singly_fewer(trial).curve.spans.count <= trial.curve.spans.count


@pytest.mark.parametrize(("points", "closed"), [(wave(), False), (ring(), True)])
def test_knots_that_say_nothing_all_go(points, closed):
    """Knots put into a curve that holds without them are found, some at once, and the curve is no worse for it."""
    trial = few(grown(points, 2e-4, closed))
    spans = trial.curve.spans
    middles = 0.5 * (spans.knots[:-1] + spans.knots[1:])
    more = np.sort(np.concatenate([spans.knots, middles[1 : 1 + spans.count // 2 : 3]]))
    stuffed = relax(start(trial.goal, more, trial.u), 24, move_knots=True)
    assert stuffed.met
    fewer = singly_fewer(stuffed)
    assert fewer.met
    assert fewer.worst <= 1.0
    assert fewer.curve.spans.count <= spans.count


@pytest.mark.parametrize(
    ("points", "closed", "tolerance", "left"),
    [
        (wave(), False, 5e-4, 0),
        pytest.param(wave(), False, 2e-5, 0.1, marks=pytest.mark.slow),
        pytest.param(ring(), True, 2e-5, 0.1, marks=pytest.mark.slow),
    ],
)
def test_next_to_none_is_left_that_can_go(points, closed, tolerance, left):
    """Until a round of tries finds none: then each knot is tried by itself, the slow way.

    Where all are tried by themselves none is left; where several are at once, one may be blamed for another.
    """
    trial = few(grown(points, tolerance, closed))
    before = trial.curve.spans.count
    while fewer := [*thinned(trial, _far_apart, _moved, 1000, range(3, 6), unheard)]:
        counts = [trial.curve.spans.count, *(each.curve.spans.count for each in fewer)]
        assert all(a > b for a, b in zip(counts[:-1], counts[1:], strict=True))
        assert all(each.met for each in fewer)
        trial = fewer[-1]
    inner = len(importance(trial))
    assert before >= trial.curve.spans.count
    assert (inner > 2 * _APART) == (left > 0)
    can_go = [_moved(trial, without(trial.curve.spans, np.arange(inner) == k)).met for k in range(inner)]
    assert sum(can_go) <= left * inner


def test_rows_of_a_closed_curve_do_not_hang_on_where_it_begins():
    trial = grown(ring(), 2e-4, True)
    turned = trial.curve.from_span(3)
    knots = trial.curve.spans.knots
    assert turned.spans.knots[0] != knots[0]
    other = replace(trial, curve=turned)
    period = trial.goal.period
    mine, theirs = (in_order(each, each.curve.spans.knots[:-1]) % period for each in (trial, other))
    np.testing.assert_allclose(mine, theirs, atol=1e-12)


def test_without():
    spans = grown(wave(), 2e-4).curve.spans
    gone = np.zeros(spans.count - 1, dtype=bool)
    gone[1] = True
    assert without(spans, gone).tolist() == np.delete(spans.knots, 2).tolist()


def test_what_samples_do_not_tell_of_is_mended():
    """A swing in a bend that is a hair too wide between samples was mended in vain, and all spans were given back."""
    found = [p.values[0] for p in curves(per_family=1000, families=("race_track",)) if p.id == "race_track-pt-2008"]
    if not found:
        pytest.skip("needs a curve of the corpus")
    (track,) = found
    fast, best = (
        cadfit.fit(track.points, 1e-3 * track.size, closed=True, effort=effort) for effort in ("fast", "best")
    )
    assert best.poles <= fast.poles < len(track.points) / 2
