"""Many points: some of them are fitted, and others join those where the curve misses them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cadfit.bezier import Ints
from cadfit.fitting.checking import SURER, Check
from cadfit.fitting.targets import Targets

_ROWS_A_SPAN = 8
_OTHERS = 9


def spread(rows: Ints, count: int) -> Ints:
    """Return the rows, the first and the last of all among them, with about so many spread evenly between them."""
    gap = np.diff(rows)
    parts = np.maximum(np.round(gap * (count / rows[-1])), 1).astype(np.intp)
    place = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    return np.unique(
        np.append(np.repeat(rows[:-1], parts) + np.repeat(gap, parts) * place // np.repeat(parts, parts), rows[-1])
    )


def more_rows(check: Check, rows: Ints, least: int) -> Ints:
    """Return the rows fitted so far, with others of each quarter of a span where the curve misses points or chords.

    Those are the worst of the quarter, and some spread over it: alone, the worst draw spikes out of the curve. There
    are at least so many (`least`); or all, where that is half of them.
    """
    n, error = len(check.u), check.error
    missed = np.flatnonzero(error > SURER)
    if error.max() <= 1.0:
        missed = np.unique(np.concatenate([check.straying, (check.straying + 1) % n]))
    quarter, low, high = _quarters(check, missed)
    order = np.lexsort([-error[missed], quarter])
    _, first = np.unique(quarter[order], return_index=True)
    worst = order[first]
    others = np.linspace(low[worst], high[worst], _OTHERS).astype(np.intp).ravel()
    more = np.unique(np.concatenate([rows, missed[worst], others]))
    least = max(least, _ROWS_A_SPAN * check.trial.curve.spans.count)
    if len(more) < least:
        more = spread(more, least)
    return more if len(more) < 0.5 * n else np.arange(n)


def _quarters(check: Check, rows: Ints) -> tuple[Ints, Ints, Ints]:
    """Return for each of some rows (k,) which quarter of a span it lies in, and the first and last row there."""
    spans, u = check.trial.curve.spans, check.u
    span = spans.find(u[rows])
    local, wrapped = spans.local(u[rows], span)
    quarter = np.minimum((4.0 * local).astype(np.intp), 3)
    start = spans.knots[span] + 0.25 * quarter * spans.steps[wrapped]
    low = np.searchsorted(u, start)
    high = np.searchsorted(u, start + 0.25 * spans.steps[wrapped], side="right") - 1
    return 4 * span + quarter, np.minimum(low, rows), np.maximum(high, rows)


def carried(goal: Targets, check: Check, rows: Ints) -> Targets:
    """Return the targets of some rows with parameters on the curve that was checked."""
    period, u = check.trial.goal.period, check.u[rows]
    before = np.append(goal.u[goal.data], goal.u[0] + goal.period)
    return replace(goal, u=np.interp(goal.u, before, np.append(u, u[0] + period)), period=period)
