"""How many spans, and where: knots are added until the targets are met, then taken away while they still are."""

from __future__ import annotations

import numpy as np

from cadfit.bezier import Array
from cadfit.fitting.knots import by_jumps, by_removal, exchanged, expected, largest_errors
from cadfit.fitting.relax import Trial, checked, looping, relax, settled, start
from cadfit.fitting.rounded import at_points
from cadfit.fitting.spans import dot
from cadfit.fitting.targets import Targets
from cadfit.fitting.thinning import Mask, in_order, thinned
from cadfit.stages import Progress, stage, unheard

_SHORTEST = 1e-12  # of the curve's parameters: no span is cut that is shorter
_ASIDE = 0.04  # of a part: knots stand beside where points of a symmetric shape lie, or rounding tells their spans
_FAR = 4.0  # a largest error that more spans will bring down sooner than passes
_NEAR = 1.75  # a largest error that better knots may yet bring down
_HOPELESS = 3.0  # a largest error that tells that so few spans will not do, whatever they are made from
_MET = 0.05  # of two targets' distance: parameters that near have slid together
_SHARE, _LARGE_SHARE = 0.25, 0.35  # of the spans: how many are taken away at once, at first
_SMALL_SHARE = 0.1  # of them: how many are, from what was found since more had failed
_MENDINGS = 3  # rounds of knots for what fails with fewer spans, as long as they stay fewer
_FEW_TRIALS, _FEW_PASSES = 12, 6
_MANY_TRIALS, _MANY_PASSES, _EXCHANGES, _SETTLING = 24, 60, 8, 10
_APART = 11  # spans between knots that are taken away at once: nearer ones are not missed alone
_EVENLY = (0.8, 0.9)  # of the spans, which on a smooth curve may do if they are even
_SINGLE_ROUNDS, _REACHES = 10, range(3, 6)  # spans around a failure whose knots are given back, first and in the end


def first_knots(goal: Targets) -> Array:
    """Return the knots of the fewest spans: one, closed four."""
    if not goal.closed:
        return np.array([0.0, goal.period])
    return goal.period * np.concatenate([[0.0], (np.arange(1, 4) + _ASIDE) / 4, [1.0]])


@stage("adding spans until it holds")
def grow(goal: Targets, knots: Array, u: Array, progress: Progress = unheard, most: float = np.inf) -> Trial:
    """Return a trial that meets the targets, with knots added where not; or the last, if `most` are too few."""
    dense, turn = False, 0
    while True:
        progress(turn / (turn + 4.0))  # how many turns there will be is not known
        turn += 1
        trial = _eased(_begun(goal, knots, u))
        if trial.met or trial.curve.spans.count > min(most, 2 * len(u) + 8):
            return trial
        knots, u, goal = _bisected(trial), _parted(trial), trial.goal
        if len(knots) == len(trial.curve.spans.knots):
            return trial
        if not dense and len(knots) > 0.75 * goal.data.sum():
            dense = True
            first, second = at_points(goal, 0.5)
            dense_trial = relax(start(goal, first, second), 12, move_knots=False)
            if dense_trial.met:
                return dense_trial
            if dense_trial.worst < trial.worst or len(knots) > len(first):
                knots, u, goal = _bisected(dense_trial), dense_trial.u, dense_trial.goal


def _begun(goal: Targets, knots: Array, u: Array) -> Trial:
    """Return the start with these knots; made again where it strayed so that targets had to be added."""
    trial = checked(start(goal, knots, u))
    return trial if len(trial.u) == len(u) else checked(start(trial.goal, knots, trial.u))


def _eased(trial: Trial) -> Trial:
    """Return what a few passes make of the trial, or the trial: in noise they may turn one miss into many."""
    if trial.met or trial.worst >= _FAR:
        return trial
    relaxed = relax(trial, 6, move_knots=False)
    return relaxed if relaxed.met else min(trial, relaxed, key=_promise)


def _parted(trial: Trial) -> Array:
    """Return the parameters with missed targets that have all but met set apart by their distances.

    Noise that puts two of them side by side, or in the wrong order, lets them slide to one foot point, where no number
    of knots would tell one from the other.
    """
    u, steps = trial.u, np.diff(trial.goal.points)
    chords = np.sqrt(dot(steps, steps))
    apart = np.diff(u) >= _MET * chords
    if apart.all():
        return u
    run = np.concatenate([[0], np.cumsum(apart)])  # of targets that have met
    free = ((np.bincount(run) > 1) & (np.bincount(run, trial.error > 1.0) > 0))[run]
    free[1:-1] |= free[:-2] | free[2:]
    free[[0, -1]] = False
    along = np.concatenate([[0.0], np.cumsum(chords)])
    return np.where(free, np.interp(along, along[~free], u[~free]), u)


def _bisected(trial: Trial) -> Array:
    """Return the knots with each failing span cut in two or more, at quantiles of its parameters.

    Spans of next to no length are left: no curve passes points there that come in another order than along it.
    """
    spans, u = trial.curve.spans, trial.u
    worst, starts = largest_errors(trial)
    cut = np.flatnonzero((worst[:-1] > 1.0) & (spans.steps > _SHORTEST * (spans.knots[-1] - spans.knots[0])))
    parts = np.minimum(np.maximum(np.ceil(worst[cut] ** 0.25), 2), 8).astype(np.intp)
    last = np.cumsum(parts - 1)
    owner = np.repeat(np.arange(len(cut)), parts - 1)  # of each new knot
    k = np.arange(1, len(owner) + 1) - (last - parts + 1)[owner]  # which of its span's
    cut, parts = cut[owner], parts[owner]
    a, h, inside = spans.knots[cut], spans.steps[cut], starts[cut + 1] - starts[cut]
    at = np.minimum(starts[cut] + inside * k // parts, len(u) - 1)
    new = np.where(inside > parts, 0.5 * (u[at - 1] + u[at]), a + h * (k + _ASIDE) / parts)
    knots = np.sort(np.concatenate([spans.knots, np.minimum(np.maximum(new, a + 0.05 * h), a + 0.95 * h)]))
    return np.asarray(knots[np.append(True, knots[1:] > knots[:-1])])


@stage("taking spans away")
def few(trial: Trial, progress: Progress = unheard) -> Trial:
    """Return the trial with as few spans as a few trials find to meet the targets, knots being moved.

    Each takes away a share of the spans until one fails, and then half of those that lie between. One that fails is
    given knots where it does, as long as it has fewer than before. As few may do from what was found since, so smaller
    shares are taken from there in the end.
    """
    least, failed, looped = 4 if trial.goal.closed else 1, 0, _loops(trial)
    origin = None  # of the last one that failed
    for turn in range(_FEW_TRIALS):
        progress(turn / _FEW_TRIALS)
        m = trial.curve.spans.count
        cut = (m - failed) // 2 if failed else min(max(1, round(_LARGE_SHARE * m)), m - least)
        if cut < 1 and origin is not trial:
            failed, cut = 0, min(max(1, round(_SMALL_SHARE * m)), m - least)
        if cut < 1:
            break
        fewer = relax(start(trial.goal, by_removal(trial, m - cut), trial.u), _FEW_PASSES, move_knots=True)
        if not fewer.met:
            nearly, failed, origin = fewer.worst < _NEAR, m - cut, trial
            fewer = _mended(fewer, m, _FEW_PASSES)
            if nearly and fewer.met:  # from its knots so few may yet do
                failed = max(fewer.curve.spans.count - 2 * max(1, cut // 2), least - 1)
        if fewer.met and (looped or not _loops(fewer)):
            trial, looped = fewer, _loops(fewer)
        else:
            failed, origin = m - cut, trial
    return trial


@stage("taking spans away")
def fewest(trial: Trial, progress: Progress = unheard) -> Trial:
    """Return the trial with as few spans as many trials find to meet the targets, knots being moved and exchanged.

    Each takes away a share of the spans; one that fails is given knots where it does, and next time half as many are
    taken. Where it fails with one span less, it is tried from knots as dense as the curve asks for, and once more from
    where the largest error is least.
    """
    least, cut, fresh, looped = 4 if trial.goal.closed else 1, trial.curve.spans.count, True, _loops(trial)
    for turn in range(_MANY_TRIALS):
        progress(turn / _MANY_TRIALS)
        m = trial.curve.spans.count
        cut = min(cut, max(1, round(_SHARE * m)), m - least)
        if cut < 1:
            break
        fewer = _with_fewer(trial, m - cut)
        hopeless = fewer.worst > _HOPELESS
        if cut > 1:
            fewer = _mended(fewer, m, _MANY_PASSES)
        elif not hopeless:
            fewer = _with_exchanges(fewer) if m - 1 > least else fewer
            if not fewer.met:
                fewer = relax(start(trial.goal, by_jumps(trial, m - 1), trial.u), _MANY_PASSES, move_knots=True)
        if fewer.met and (looped or not _loops(fewer)):
            trial, looped, fresh = fewer, _loops(fewer), True
            if trial.curve.spans.count > m - cut:
                cut = max(1, cut // 2)
        elif hopeless:
            least, cut = m - cut + 1, cut // 2
        elif cut == 1 and fresh:
            better, fresh = settled(trial, _SETTLING), False
            trial = better if looped or not _loops(better) else trial
        else:
            cut //= 2
    return trial


@stage("taking spans away")
def evenly_fewer(trial: Trial) -> Trial:
    """Return the trial with as few of some shares of its spans as will do with knots as dense as the curve asks for.

    On a smooth curve all knots have to move for one to be spared.
    """
    for share in _EVENLY:
        fewer = _moved(trial, by_jumps(trial, round(share * trial.curve.spans.count)))
        if fewer.met and not _loops(fewer):
            return fewer
    return trial


@stage("taking spans away")
def singly_fewer(trial: Trial, progress: Progress = unheard) -> Trial:
    """Return the trial without the single knots that it can do without, the others being moved.

    Where there are many spans, those are found at many places at once.
    """
    return [trial, *thinned(trial, _far_apart, _moved, _SINGLE_ROUNDS, _REACHES, progress)][-1]


def _moved(trial: Trial, knots: Array) -> Trial:
    """Return what many passes make of the trial with these knots, all moving."""
    return relax(start(trial.goal, knots, trial.u), _MANY_PASSES, move_knots=True)


def _far_apart(trial: Trial, needed: Mask) -> Mask:
    """Return which of the knots to take away: of those not needed the least missed, each far from the others."""
    missed = in_order(trial, expected(trial))
    free, gone, n = ~needed, np.zeros(len(missed), dtype=bool), len(missed)
    for k in np.argsort(missed).tolist() if n > 4 or not trial.goal.closed else []:
        if free[k]:
            gone[k] = True
            around = np.arange(k - _APART, k + _APART + 1)
            free[around % n if trial.goal.closed else around[(around >= 0) & (around < n)]] = False
    return gone


def _loops(trial: Trial) -> bool:
    return len(looping(trial)) > 0


def _mended(trial: Trial, limit: int, passes: int) -> Trial:
    """Return the trial with knots added where it fails, until it meets its targets or would have too many spans."""
    for _ in range(_MENDINGS):
        knots = _bisected(trial)
        if trial.met or not trial.curve.spans.count < len(knots) - 1 < limit:
            break
        trial = relax(start(trial.goal, knots, trial.u), passes, move_knots=True)
    return trial


def _with_fewer(trial: Trial, m: int) -> Trial:
    """Return what many passes make of the better of two starts with m spans."""
    fewer = start(trial.goal, by_removal(trial, m), trial.u)
    if fewer.worst > 1.0:
        fewer = min(fewer, start(trial.goal, by_jumps(trial, m), trial.u), key=_promise)
    return relax(fewer, _MANY_PASSES, move_knots=True)


def _with_exchanges(trial: Trial) -> Trial:
    """Return the trial; where it misses its targets, with knots exchanged as long as the largest error falls."""
    for _ in range(_EXCHANGES):
        if trial.met:
            break
        other = relax(start(trial.goal, exchanged(trial), trial.u), _MANY_PASSES, move_knots=True)
        if not other.met and other.worst >= trial.worst:
            break
        trial = other
    return trial


def _promise(trial: Trial) -> float:
    """Return the mean fourth power of the errors: how far a start seems from meeting its targets."""
    return float(np.mean(trial.error**4))
