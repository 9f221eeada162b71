"""Jobs for worker processes, which find them by this module's name."""

import os
import signal
import time
import warnings
from pathlib import Path


def job(task):
    """Do what the task says: ("die",), ("die once", file), ("warn", text), ("raise", text), ("sleep", s), ("pid",)."""
    what, *rest = task
    if what == "die" or (what == "die once" and not Path(rest[0]).exists()):
        if rest:
            Path(rest[0]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if what == "warn":
        warnings.warn(rest[0], stacklevel=1)
    if what == "raise":
        raise Unpicklable(rest[0], None)
    if what == "sleep":
        time.sleep(rest[0])
    return os.getpid() if what == "pid" else what


class Unpicklable(Exception):
    """Cannot be brought back from a pickle: it takes two arguments."""

    def __init__(self, message, other):
        super().__init__(message)
        self.other = lambda: other


def log(task):
    """Note that this task was done, and by which process."""
    folder, k, seconds = task
    time.sleep(seconds)
    (Path(folder) / f"{k}-{os.getpid()}").touch()
    return k


def alive(pid):
    """Whether there is such a process, and not what is left of one that nobody waits for."""
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except FileNotFoundError:
        return False
