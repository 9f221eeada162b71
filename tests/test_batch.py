"""Many curves at once: each has one result in its place, whatever fails, dies or warns on the way."""

import copy
import csv
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

import cadfit
from cadfit.workers import outcomes, within

from batch_jobs import alive, job, log
from corpus_data import FOLDER, PRESENT, curves, turn

posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


def waves(count, n=60):
    t = np.linspace(0.0, 5.0, n)
    return [np.column_stack([t, np.sin((1.0 + 0.1 * k) * t)]) for k in range(count)]


def same(fit, other):
    return (
        len(fit.curves) == len(other.curves)
        and all(a.isclose(b, 0.0) for a, b in zip(fit.curves, other.curves, strict=True))
        and np.array_equal(fit.parameters, other.parameters)
        and (fit.deviation.points, fit.deviation.between) == (other.deviation.points, other.deviation.between)
    )


def test_results_are_those_of_fit_in_order():
    given = [*waves(3), turn(40, 10.0), np.zeros((4, 2)), [[0, 0], [1, "x"]]]
    seen = []
    batch = cadfit.fit_many(given, 1e-3, jobs=1, effort="fast", progress=seen.append)
    assert len(batch) == 6
    for k in range(4):
        assert same(batch[k], cadfit.fit(given[k], 1e-3, effort="fast"))
    assert [failure.name for failure in batch.failures] == ["4", "5"]
    assert batch[4:] == batch.failures
    assert "at least 2 distinct points" in batch[4].reason
    assert "row 1" in batch[5].reason
    assert batch.fits == batch.results[:4]
    assert seen == [1 / 6, 2 / 6, 3 / 6, 4 / 6, 5 / 6, 1.0]
    assert repr(batch) == "Batch(4 fits, 2 failures)"


def test_names_tolerances_and_choices():
    given = dict(zip("ab", waves(2, 24), strict=True))
    batch = cadfit.fit_many(given, [1e-2, 1e-4], jobs=1, closed=True, corners=None, between="polyline", effort="fast")
    assert batch.names == ("a", "b")
    assert [fit.tolerance for fit in batch] == [1e-2, 1e-4]
    assert all(fit.closed and not len(fit.corners) for fit in batch)
    assert cadfit.fit_many([], 1.0).results == ()
    for wrong, message in (
        ({"tolerance": [1.0]}, "one for each of the 2 curves"),
        ({"tolerance": -1.0}, "above zero, not -1"),
        ({"tolerance": [1.0, np.nan]}, "above zero, not nan"),
        ({"tolerance": 1.0, "effort": "worst"}, "effort must be one of"),
    ):
        with pytest.raises(ValueError, match=message):
            cadfit.fit_many(given, **wrong)


def test_the_summary_as_text_and_csv(tmp_path):
    batch = cadfit.fit_many({"wave": waves(1)[0], "dot, twice": [[1, 1], [1, 1]]}, 1e-3, jobs=1)
    head, wave, failed, reason = str(batch).splitlines()
    assert head.split() == ["name", "points", "curves", "poles", "at", "points", "between", "seconds"]
    assert wave.split()[:4] == ["wave", "60", "1", str(batch[0].poles)]
    assert failed == "1 of 2 failed:"
    assert reason == f"dot, twice: {batch[1].reason}"
    batch.write_csv(tmp_path / "summary.csv")
    with open(tmp_path / "summary.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["name"] for row in rows] == ["wave", "dot, twice"]
    assert float(rows[0]["at points"]) == batch[0].deviation.points
    assert rows[1]["failure"] == batch[1].reason
    assert (rows[0]["failure"], rows[1]["poles"]) == ("", "")


@pytest.mark.parametrize("again", [lambda fit: pickle.loads(pickle.dumps(fit)), copy.deepcopy])
def test_a_fit_survives_the_way_between_processes(again):
    points = np.array([[0, 0], [1, 0.1], [1, 0.1], [2, 0], [2.1, 1], [2, 2], [1, 1.9], [0, 2], [-0.1, 1]])
    fit = cadfit.fit(points, 0.02, closed=True)
    back = again(fit)
    assert same(fit, back)
    assert (back.closed, back.tolerance, repr(back)) == (fit.closed, fit.tolerance, repr(fit))
    for name in ("points", "parameters", "corners", "cleaned"):
        assert np.array_equal(getattr(fit, name), getattr(back, name))
        assert not getattr(back, name).flags.writeable, name
    assert not back.curves[0].poles.flags.writeable
    assert not back.curves[0].knots.flags.writeable
    with pytest.raises(AttributeError):
        back.tolerance = 1.0


def test_threads_will_do():
    with ThreadPoolExecutor(2) as threads:
        batch = cadfit.fit_many(waves(4), 1e-3, threads, effort="fast")
    assert all(same(fit, cadfit.fit(points, 1e-3, effort="fast")) for fit, points in zip(batch, waves(4), strict=True))


def test_stopping_in_progress_cancels():
    def stop(part):
        raise KeyboardInterrupt

    done = []
    with ThreadPoolExecutor(1) as threads, pytest.raises(KeyboardInterrupt):
        cadfit.fit_many(waves(30), 1e-3, threads, progress=stop)
    with pytest.raises(KeyboardInterrupt):
        cadfit.fit_many(waves(3), 1e-3, jobs=1, progress=lambda part: done.append(part) or stop(part))
    assert done == [pytest.approx(1 / 3)]


class Breaking(Executor):
    """Does some tasks, then breaks: what is under way and all that follow fail with it."""

    def __init__(self, good):
        self.left = good
        self.held = []

    def submit(self, function, *args, **kwargs):
        if self.left < -3:
            raise BrokenExecutor("broken")
        future = Future()
        self.left -= 1
        if self.left >= 0:
            future.set_result(function(*args, **kwargs))
        else:
            self.held.append(future)
            if self.left == -3:
                for each in self.held:
                    each.set_exception(BrokenExecutor("broken"))
                self.left -= 1
        return future


def test_what_a_broken_executor_leaves_is_done_here():
    with pytest.warns(UserWarning, match="ended unexpectedly: 5 that were under way or waiting are tried again"):
        found = dict(outcomes(job, dict.fromkeys(range(7), ("pid",)), Breaking(2), jobs=1))
    assert sorted(found) == list(range(7))
    assert all(outcome.value == os.getpid() for outcome in found.values())


class Cancelling(Breaking):
    """Cancels what it is given."""

    def submit(self, function, *args, **kwargs):
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_what_an_executor_gives_up_is_a_failure():
    batch = cadfit.fit_many(waves(2), 1e-3, Cancelling(0))
    assert [str(failure) for failure in batch] == ["CancelledError: the executor gave it up"] * 2


@pytest.mark.slow
@posix
def test_processes_warn_fail_and_die_and_every_task_has_one_outcome(tmp_path):
    once = tmp_path / "once"
    tasks = dict(
        enumerate([("pid",), ("die",), ("warn", "odd"), ("die once", str(once)), ("raise", "no"), *[("ok",)] * 6])
    )
    with pytest.warns(UserWarning, match="a worker process ended unexpectedly"):
        keys, found = zip(*outcomes(job, tasks, jobs=2), strict=True)
    assert sorted(keys) == list(tasks)
    found = dict(zip(keys, found, strict=True))
    assert found[0].value != os.getpid()
    assert (found[1].error, found[1].value) == ("BrokenProcessPool", None)
    assert "ended each time before it was done" in found[1].reason
    assert found[2].warned == ((UserWarning, "odd"),)
    assert found[3].value == "die once"
    assert (found[4].error, found[4].reason) == ("Unpicklable", "no")
    assert all(found[k].value == "ok" for k in range(5, 11))
    assert multiprocessing.active_children() == []


@pytest.mark.slow
@posix
def test_a_worker_killed_midway_loses_nothing():
    given = waves(8, 30)
    killed = []

    def kill(part):
        if not killed:
            killed.append(multiprocessing.active_children()[0])
            os.kill(killed[0].pid, signal.SIGKILL)

    with pytest.warns(UserWarning, match="ended unexpectedly"):
        batch = cadfit.fit_many(given, 1e-2, jobs=2, progress=kill, effort="fast")
    assert killed
    assert all(same(fit, cadfit.fit(points, 1e-2, effort="fast")) for fit, points in zip(batch, given, strict=True))


@pytest.mark.slow
@posix
def test_a_broken_pool_of_the_callers_is_carried_on():
    given = waves(6)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, spawn) as pool:
        os.kill(pool.submit(os.getpid).result(), signal.SIGKILL)
        with pytest.warns(UserWarning, match="6 that were under way or waiting are tried again"):
            batch = cadfit.fit_many(given, 1e-3, pool, jobs=1, effort="fast")
    assert [fit.tolerance for fit in batch] == [1e-3] * 6


@pytest.mark.slow
def test_closing_early_ends_the_processes():
    with closing(outcomes(job, {0: ("ok",), 1: ("sleep", 100), 2: ("sleep", 100)}, jobs=2)) as coming:
        assert next(coming)[1].value == "ok"
        start = time.perf_counter()
    assert time.perf_counter() - start < 20
    assert multiprocessing.active_children() == []


@pytest.mark.slow
@posix
def test_a_limit_of_time_and_what_dies_within_it():
    start = time.perf_counter()
    assert within(0.5, job, ("sleep", 100)) is None
    assert time.perf_counter() - start < 20
    assert within(60, job, ("ok",)).value == "ok"
    assert within(60, job, ("die",)).error == "BrokenProcessPool"
    assert within(60, job, ("raise", "no")).reason == "no"
    assert multiprocessing.active_children() == []


SCRIPT = """
import sys
sys.path.insert(0, {tests!r})
from batch_jobs import job
from cadfit.workers import outcomes
{guard}
    for key, outcome in outcomes(job, {tasks!r}, jobs=2):
        print(outcome.value, flush=True)
"""


def script(tmp_path, guard, tasks):
    path = tmp_path / "script.py"
    path.write_text(SCRIPT.format(tests=str(Path(__file__).parent), guard=guard, tasks=tasks))
    return subprocess.Popen([sys.executable, path], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.slow
def test_a_script_without_its_guard_is_told_so(tmp_path):
    child = script(tmp_path, "if True:", {0: ("ok",), 1: ("ok",)})
    out, err = child.communicate(timeout=60)
    assert child.returncode == 1
    assert "RuntimeError: worker processes end as they start" in err
    assert out == ""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="needs /proc")
def test_workers_end_with_the_process_that_started_them(tmp_path):
    child = script(tmp_path, 'if __name__ == "__main__":', {0: ("pid",), 1: ("sleep", 100), 2: ("sleep", 100)})
    worker = int(child.stdout.readline())
    assert alive(worker)
    child.kill()
    child.communicate(timeout=60)
    end = time.monotonic() + 30
    while alive(worker) and time.monotonic() < end:
        time.sleep(0.05)
    assert not alive(worker)


class Losing(Executor):
    """Loses the result of a task so many times."""

    def __init__(self, times):
        self.times, self.given = times, []

    def submit(self, function, *args, **kwargs):
        future = Future()
        lost = self.given.count(args) < self.times
        self.given.append(args)
        if lost:
            future.set_exception(TypeError("lost"))
        else:
            future.set_result(function(*args, **kwargs))
        return future


def test_what_an_executor_loses_is_handed_to_it_once_more():
    tasks = {k: ("raise" if k == 1 else "pid", str(k)) for k in range(3)}
    found = dict(outcomes(job, tasks, executor := Losing(1)))
    assert sorted(found) == [0, 1, 2]
    assert len(executor.given) == 6
    assert [found[k].value for k in range(3)] == [os.getpid(), None, os.getpid()]
    assert found[1].error == "Unpicklable"
    found = dict(outcomes(job, tasks, executor := Losing(2)))
    assert len(executor.given) == 6
    assert [(each.error, each.reason) for each in found.values()] == [("TypeError", "lost")] * 3


@pytest.mark.slow
@posix
def test_dask_with_a_worker_killed_midway(tmp_path):
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": ":0"}
    with (
        distributed.LocalCluster(**options, local_directory=tmp_path) as cluster,
        distributed.Client(cluster) as client,
    ):
        (tmp_path / "done").mkdir()
        executor = client.get_executor()
        pids = client.run(os.getpid)
        tasks = {k: (str(tmp_path / "done"), k, 0.02) for k in range(60)}
        found = []
        for key, outcome in outcomes(log, tasks, executor):
            found.append((key, (outcome.value, outcome.error, outcome.reason)))
            if len(found) == 5:
                os.kill(next(iter(pids.values())), signal.SIGKILL)
        assert sorted(found) == [(k, (k, None, "")) for k in range(60)]
        done = [path.name.split("-") for path in (tmp_path / "done").iterdir()]
        assert {int(k) for k, _ in done} == set(range(60))
        assert len({pid for _, pid in done}) >= 2

        given = waves(8, 30)
        killed = []

        def kill(part):
            if part > 0.2 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        batch = cadfit.fit_many(given, 1e-2, executor, progress=kill, effort="fast")
    assert killed
    assert batch.failures == ()
    assert all(same(fit, cadfit.fit(points, 1e-2, effort="fast")) for fit, points in zip(batch, given, strict=True))


@pytest.mark.slow
@pytest.mark.skipif(not PRESENT, reason=f"no corpus at {FOLDER}")
def test_real_curves_in_processes_as_one_by_one():
    shapes = [param.values[0] for param in curves(2, 200, ["airfoil", "font_outline", "tract", "toolpath_mill"])]
    given = [np.append(s.points, s.points[:1], axis=0) if s.closed else s.points for s in shapes]
    tolerances = [1e-3 * s.size for s in shapes]
    batch = cadfit.fit_many(given, tolerances, jobs=2, effort="fast")
    assert batch.failures == ()
    for fit, points, tolerance in zip(batch, given, tolerances, strict=True):
        assert same(fit, cadfit.fit(points, tolerance, effort="fast"))
