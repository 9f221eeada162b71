"""Many tasks at once, in worker processes or by any executor: each has one outcome, whatever dies on the way.

The processes are started afresh ("spawn"), so that threads of the caller's cannot harm them; they leave Ctrl-C to the
process that started them, and end when it does. A task whose process ends before the task is done (killed, out of
memory) is tried again, alone, at most twice; the others go on.
"""

from __future__ import annotations

import multiprocessing
import os
import platform
import signal
import threading
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from itertools import chain, islice
from queue import SimpleQueue
from time import perf_counter
from typing import Any

Job = Callable[[Any], Any]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of a task: its value, or the kind of error and its reason; and how long it took, in seconds."""

    value: Any = None
    error: str | None = None
    reason: str = ""
    seconds: float = 0.0
    warned: tuple[tuple[type[Warning], str], ...] = ()


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def outcomes(
    job: Job, tasks: Mapping[Any, Any], executor: Executor | None = None, jobs: int | None = None
) -> Generator[tuple[Any, Outcome], None, None]:
    """Yield each key of the tasks with the outcome of job(task), as they come; begun in the order of the mapping.

    `executor`: any; None: `jobs` processes of our own (default: a process for each processor), or with one job this
    process. Closing the iterator, or an error in it, cancels what waits and ends our own processes. `job` and tasks are
    pickled; errors of the job are outcomes. Warns where a process ended unexpectedly, of what is tried again.

    Raises RuntimeError where no process can be started.
    """
    left = dict(tasks)
    if executor is not None:
        yield from _through(executor, job, left, len(left))
        if left:
            _warn_of_death(len(left))
    most = max(1, min(jobs or processors(), len(left)))
    if jobs == 1 or (executor is None and most == 1):
        for key, task in left.items():
            yield key, carried_out(job, task, "")
        return
    while left:
        with _processes(min(most, len(left))) as pool:
            suspects = yield from _through(pool, job, left, most + 1)
        if suspects:
            _warn_of_death(len(suspects))
        for key in suspects:
            yield key, _alone(job, left.pop(key))


def within(seconds: float, job: Job, task: Any, modules: Sequence[str] = ()) -> Outcome | None:
    """Return the outcome of a task in a process of its own, or None where it takes longer: then the process is ended.

    The clock starts when the process has imported the modules. For calls that nothing else can stop.
    """
    try:
        with _processes(1) as pool:
            with _ctrl_c_held():
                ready = [pool.submit(import_module, name) for name in [job.__module__, *modules]]
            for each in ready:
                each.exception()
            return pool.submit(carried_out, job, task, _here()).result(seconds)
    except TimeoutError:
        return None
    except BrokenExecutor:
        return Outcome(None, "BrokenProcessPool", "its process ended before it was done: killed, or out of memory?")


def carried_out(job: Job, task: Any, caller: str) -> Outcome:
    """Return the outcome of a task; its warnings are carried along unless this is the process of the caller.

    There it may be one of several threads, which catching warnings is not safe for.
    """
    start = perf_counter()
    with warnings.catch_warnings(record=True) if _here() != caller else _nothing() as caught:
        if caught is not None:
            warnings.simplefilter("always")
        try:
            value, error, reason = job(task), None, ""
        except Exception as failure:
            value, error, reason = None, type(failure).__name__, str(failure)
    warned = tuple((each.category, str(each.message)) for each in caught or ())
    return Outcome(value, error, reason, perf_counter() - start, warned)


def _through(
    executor: Executor, job: Job, left: dict[Any, Any], window: int
) -> Generator[tuple[Any, Outcome], None, list[Any]]:
    """Yield outcomes as they come, each taken out of `left`; return the keys that were under way if it broke.

    At most `window` tasks are under way at a time. One that the executor fails at, not the job, is handed to it once
    more: dask.distributed now and then loses a result that was there when the worker died that had it.
    """
    waiting, running = iter(list(left.items())), dict[Future[Outcome], Any]()
    done: SimpleQueue[Future[Outcome]] = SimpleQueue()
    suspects, again = list[Any](), set[Any]()
    broken = False
    try:
        while True:
            for key, task in islice(waiting, 0 if broken else window - len(running)):
                try:
                    with _ctrl_c_held():  # a new process is born with it held, and so never dies of it
                        future = executor.submit(carried_out, job, task, _here())
                except BrokenExecutor:
                    broken = True
                    break
                running[future] = key
                future.add_done_callback(done.put)
            if not running:
                return suspects
            future = done.get()
            key = running.pop(future)
            try:
                outcome = future.result()
            except BrokenExecutor:
                broken = True
                suspects.append(key)
                continue
            except Exception as failure:
                if key not in again and not isinstance(failure, CancelledError):
                    again.add(key)
                    waiting = chain([(key, left[key])], waiting)
                    continue
                outcome = Outcome(None, type(failure).__name__, str(failure) or "the executor gave it up")
            del left[key]
            yield key, outcome
    finally:
        for future in running:
            future.cancel()


def _alone(job: Job, task: Any) -> Outcome:
    """Return the outcome of a task in a process of its own, the second of which may not end before it is done."""
    for _ in range(2):  # in the pool it may have been waiting only
        with _processes(1) as pool:
            try:
                with _ctrl_c_held():
                    started = pool.submit(os.getpid)
                started.result()
            except BrokenExecutor:
                raise RuntimeError(
                    "worker processes end as they start: a script that starts them needs "
                    "`if __name__ == '__main__':` around what it does; jobs=1 starts none"
                ) from None
            for _, outcome in _through(pool, job, {0: task}, 1):
                return outcome
    reason = "its process ended each time before it was done: killed, or out of memory?"
    return Outcome(None, "BrokenProcessPool", reason)


def _warn_of_death(count: int) -> None:
    several = f"{count} that were under way or waiting are" if count > 1 else "what it was at is"
    warnings.warn(f"a worker process ended unexpectedly: {several} tried again", stacklevel=3)


@contextmanager
def _processes(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Give a pool of processes; they are ended at once where the block fails, is interrupted or closed."""
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _start_worker)
    try:
        yield pool
    except BaseException:
        for process in list((pool._processes or {}).values()):  # what terminate_workers of Python 3.14 does
            process.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    """Leave Ctrl-C to the process that started this one, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _ctrl_c_held() -> Iterator[None]:
    """Let Ctrl-C wait until the block is over."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _nothing() -> Iterator[None]:
    yield None


def _here() -> str:
    return f"{platform.node()}:{os.getpid()}"
