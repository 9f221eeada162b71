"""Many curves fitted at once: every curve has a result, and one that fails does not stop the rest."""

from __future__ import annotations

import csv
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from cadfit.fitting.approximate import Between, Corners, Effort, check_choices, fit
from cadfit.fitting.result import Fit
from cadfit.numbers import as_numbers
from cadfit.replacing import replacing
from cadfit.workers import Outcome, outcomes

COLUMNS = ("name", "points", "curves", "poles", "at points", "between", "seconds", "failure")


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a curve has no fit: the name of the curve, the reason in words, and the name of the error's class."""

    name: str
    reason: str
    error: str = "ValueError"

    def __str__(self) -> str:
        return self.reason if self.error == "ValueError" else f"{self.error}: {self.reason}"


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Batch(Sequence["Fit | Failure"]):
    """The results of `fit_many`, in the order of the curves: each a `Fit`, or the `Failure` that tells why not.

    `names` and `results` have an entry for each curve, `seconds` the time that each took in its process.
    """

    names: tuple[str, ...]
    results: tuple[Fit | Failure, ...]
    seconds: tuple[float, ...]

    def __len__(self) -> int:
        return len(self.results)

    @overload
    def __getitem__(self, at: int) -> Fit | Failure: ...
    @overload
    def __getitem__(self, at: slice) -> Sequence[Fit | Failure]: ...
    def __getitem__(self, at: int | slice) -> Fit | Failure | Sequence[Fit | Failure]:
        return self.results[at]

    def __repr__(self) -> str:
        return f"Batch({len(self.fits)} fits, {len(self.failures)} failures)"

    def __str__(self) -> str:
        return text_of(self.rows())

    @property
    def fits(self) -> tuple[Fit, ...]:
        """The fits alone, in order."""
        return tuple(each for each in self.results if isinstance(each, Fit))

    @property
    def failures(self) -> tuple[Failure, ...]:
        """The failures alone, in order."""
        return tuple(each for each in self.results if isinstance(each, Failure))

    def rows(self) -> list[dict[str, Any]]:
        """Return a row of the summary for each curve: its name, counts, deviations, time, and why it failed."""
        return [
            row(name, len(result.points) if isinstance(result, Fit) else None, result, seconds)
            for name, result, seconds in zip(self.names, self.results, self.seconds, strict=True)
        ]

    def write_csv(self, path: str | os.PathLike[str]) -> None:
        """Write the summary, a row for each curve, as CSV with a head; an old file stays whole until it is complete.

        Raises OSError naming a path that cannot be written.
        """
        write_rows(path, self.rows())


def fit_many(
    curves: Mapping[str, ArrayLike] | Iterable[ArrayLike],
    tolerance: float | ArrayLike,
    executor: Executor | None = None,
    *,
    jobs: int | None = None,
    closed: bool | None = None,
    corners: Corners = "auto",
    between: Between = "curve",
    effort: Effort = "best",
    progress: Callable[[float], None] | None = None,
) -> Batch:
    """Fit each of many curves within a tolerance, as `fit` does; return the results in order.

    `curves`: points (n, d) each, by name or in a row (then their names are their numbers, from 0). `tolerance`: one
    length for all, or one for each. The other arguments are those of `fit`, for all curves. `executor`: any
    `concurrent.futures.Executor`, such as `Client.get_executor()` of dask.distributed; None: `jobs` processes (default:
    one for each processor; 1: none, all is done here). The largest curves are begun first. `progress` is called with
    the part of the curves that are done, from 0 to 1; raising from it cancels.

    A curve that cannot be fitted becomes a `Failure` with the reason, and the rest go on. Where a worker process ends
    unexpectedly (killed, out of memory), what it had not finished is fitted again, with a warning: nothing is lost and
    nothing counts twice; a curve whose process ends each time is a `Failure`. If an executor breaks, processes of our
    own go on. Warnings of workers are given again here, with the curve's name in front. A script that starts processes
    needs `if __name__ == "__main__":` around what it does.

    Raises ValueError for tolerances that are not positive or not as many as the curves, and for choices `fit` does not
    know; RuntimeError where no process can be started.

    >>> t = np.linspace(0, 6, 50)
    >>> done = fit_many({"wave": np.column_stack([t, np.sin(t)]), "dot": [[1, 1], [1, 1]]}, 1e-3, jobs=1)
    >>> done
    Batch(1 fits, 1 failures)
    >>> done[0].deviation.points <= 1e-3, done[1].reason
    (True, 'a curve needs at least 2 distinct points; the 2 given have 1')
    """
    check_choices(between, effort)
    named = curves if isinstance(curves, Mapping) else {str(k): points for k, points in enumerate(curves)}
    names, given = tuple(map(str, named)), list(named.values())
    tolerances = _tolerances(tolerance, len(given))
    how = {"closed": closed, "corners": corners, "between": between, "effort": effort}
    order = sorted(range(len(given)), key=lambda k: -_length(given[k]))
    tasks = {k: (given[k], tolerances[k], how) for k in order}
    found: list[Outcome] = [Outcome()] * len(given)
    with closing(outcomes(_fitted, tasks, executor, jobs)) as coming:
        for count, (k, outcome) in enumerate(coming, 1):
            found[k] = outcome
            warn_again(names[k], outcome)
            if progress is not None:
                progress(count / len(given))
    results = tuple(result_of(name, outcome) for name, outcome in zip(names, found, strict=True))
    return Batch(names, results, tuple(outcome.seconds for outcome in found))


def _fitted(task: tuple[ArrayLike, float, dict[str, Any]]) -> Fit:
    points, tolerance, how = task
    return fit(points, tolerance, **how)


def _length(points: Any) -> int:
    return len(points) if hasattr(points, "__len__") else 0


def _tolerances(tolerance: float | ArrayLike, count: int) -> list[float]:
    given = as_numbers(tolerance, "tolerances")
    if given.ndim and given.shape != (count,):
        raise ValueError(f"tolerance must be one length, or one for each of the {count} curves, not {given.shape}")
    if not np.all(given > 0.0):
        raise ValueError(f"a tolerance must be above zero, not {given[~(given > 0.0)].ravel()[0]}")
    return np.broadcast_to(given, (count,)).tolist()  # type: ignore[no-any-return]


def result_of(name: str, outcome: Outcome) -> Any:
    """Return the value of an outcome, or the failure that it is."""
    return outcome.value if outcome.error is None else Failure(name, outcome.reason, outcome.error)


def warn_again(name: str, outcome: Outcome) -> None:
    """Give the warnings of another process again, with the name in front."""
    for category, message in outcome.warned:
        warnings.warn(f"{name}: {message}", category, stacklevel=3)


def row(name: str, points: int | None, result: Any, seconds: float) -> dict[str, Any]:
    """Return the row of the summary for curves (`Fit` or `Curves`), or for a failure."""
    if isinstance(result, Failure):
        return dict.fromkeys(COLUMNS, "") | {"name": name, "seconds": round(seconds, 4), "failure": str(result)}
    far = result.deviation
    poles = sum(len(curve.poles) for curve in result.curves)
    values = (name, points, len(result.curves), poles, far.points, far.between, round(seconds, 4), "")
    return dict(zip(COLUMNS, values, strict=True))


def write_rows(path: str | os.PathLike[str], rows: list[dict[str, Any]]) -> None:
    """Write rows of a summary as CSV."""
    with replacing(Path(path)) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def text_of(rows: list[dict[str, Any]]) -> str:
    """Return the summary as a table in plain text: fits first, then how many failed, and each of those with its reason.

    >>> print(text_of([row("dot", None, Failure("dot", "one point"), 0.0)]))
    1 of 1 failed:
    dot: one point
    """
    fitted = [each for each in rows if not each["failure"]]
    failed = [each for each in rows if each["failure"]]
    head = COLUMNS[:-1]
    cells = [head, *([_cell(each[column]) for column in head] for each in fitted)] if fitted else []
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) if k == 0 else cell.rjust(width) for k, (cell, width) in enumerate(pairs))
        for pairs in (list(zip(line, widths, strict=True)) for line in cells)
    ]
    if failed:
        lines.append(f"{len(failed)} of {len(rows)} failed:")
        lines += [f"{each['name']}: {' '.join(each['failure'].split())}" for each in failed]
    return "\n".join(lines)


def _cell(value: Any) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
