"""Ctrl-C at any time: exit status 130, no traceback, old files whole and no half-written ones, no processes left."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import cadfit
from cadfit.cli import main
from cadfit.replacing import replacing

from batch_jobs import alive

T = np.linspace(0, 9, 40)
HELIX = np.column_stack([np.cos(T), np.sin(T), 0.2 * T])
PROGRAM = "G21 G90 G1 F100\n" + "".join(f"G1 X{x:.4f} Y{y:.4f}\n" for x, y in 30 * HELIX[:, :2])

COMMANDS = {  # what each reads, what it writes
    "fit": ("path.csv", ["-o", "old.json", "-o", "new.csv"]),
    "fit within a tolerance": ("path.csv", ["-t", "0.01", "-o", "new.json", "--report", "old.html"]),
    "fit into a folder": ("path.csv", ["-o", "out/", "--format", "csv"]),
    "compare": ("path.csv", ["fast", "-t", "0.01", "-o", "old.html"]),
    "tube": ("path.csv", ["--radius", "0.1", "-o", "old.stl", "-o", "new.3mf"]),
    "sweep": ("path.csv", ["--profile", "square.csv", "-o", "old.stl", "-o", "new.glb"]),
    "toolpath": ("part.nc", ["-t", "0.05", "-o", "old.nc"]),
    "info": ("path.csv", []),
}


def arguments(case):
    source, options = COMMANDS[case]
    return [case.split()[0], source, *options]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with what the commands read, and old files that they are to replace, as the current one."""
    monkeypatch.chdir(tmp_path)
    cadfit.write("path.csv", HELIX)
    cadfit.write("square.csv", 0.1 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))
    (tmp_path / "part.nc").write_text(PROGRAM)
    for suffix in ("json", "html", "stl", "nc"):
        (tmp_path / f"old.{suffix}").write_text("old")
    (tmp_path / "out").mkdir()
    return tmp_path


def held(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("case", [case for case in COMMANDS if case != "info"])
def test_interrupted_when_all_but_the_name_is_written(here, monkeypatch, capsys, case):
    before, written = held(here), []

    def interrupted(number):
        written.append(number)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", interrupted)
        assert main(arguments(case)) == 130
    assert written
    assert capsys.readouterr() == ("", "")
    assert held(here) == before
    assert main(arguments(case)) == 0  # the same, left alone, writes them
    assert all(held(here)[path] != b"old" for path in before if str(path) in arguments(case) and path.stem == "old")


def test_interrupted_when_the_new_file_is_just_made(here, monkeypatch):
    before, made = held(here), []

    def interrupted(path, mode):
        open(path, mode).close()
        made.append(path)
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(Path, "open", interrupted)
        with pytest.raises(KeyboardInterrupt), replacing(here / "old.nc"):
            pass
    assert made
    assert held(here) == before


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="needs signals")
def test_ended_by_sigterm_when_all_but_the_name_is_written(here):
    before = held(here)
    code = "import os, sys, cadfit.cli; os.fsync = lambda _: os.kill(os.getpid(), 15); sys.exit(cadfit.cli.main())"
    done = subprocess.run([sys.executable, "-c", code, *arguments("fit")], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr, done.returncode) == ("", "", 143)
    assert held(here) == before


def heeding_ctrl_c():
    """Undo in a child what tests started in the background inherit: they ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs a pipe with a name")
@pytest.mark.parametrize("case", COMMANDS)
def test_interrupted_while_it_reads(here, case):
    source = here / COMMANDS[case][0]
    source.unlink()
    os.mkfifo(source)
    before = held(here)
    child = subprocess.Popen(
        [sys.executable, "-m", "cadfit.cli", *arguments(case)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heeding_ctrl_c,
    )  # fmt: skip
    with open(source, "w") as pipe:  # opens once the child reads, which it does until the pipe is closed
        pipe.write(PROGRAM if source.suffix == ".nc" else "1,2\n3,4\n")
        pipe.flush()
        child.send_signal(signal.SIGINT)
    assert (*child.communicate(timeout=60), child.returncode) == ("", "", 130)
    assert held(here) == before


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="needs /proc")
def test_interrupted_while_another_method_is_at_work(here):
    t = np.linspace(0.0, 60.0, 200_000)
    cadfit.write("path.csv", np.column_stack([t, np.sin(t * t)]))
    before = held(here)
    child = subprocess.Popen(
        [sys.executable, "-m", "cadfit.cli", "compare", "path.csv", "fitpack", "-t", "1e-9", "-o", "old.html"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heeding_ctrl_c,
    )  # fmt: skip
    end = time.monotonic() + 60
    while time.monotonic() < end and len(workers := children(child.pid)) < 2:
        time.sleep(0.02)
    child.send_signal(signal.SIGINT)
    assert (*child.communicate(timeout=60), child.returncode) == ("", "", 130)
    end = time.monotonic() + 10
    while any(map(alive, workers)) and time.monotonic() < end:
        time.sleep(0.02)
    assert not any(map(alive, workers))
    assert held(here) == before


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="needs /proc")
@pytest.mark.parametrize("to_all", [False, True])
def test_interrupted_with_several_processes(here, to_all):
    t = np.linspace(0, 30, 300)
    for k in range(60):
        cadfit.write(f"{k}.csv", np.column_stack([t, np.sin((1 + 0.01 * k) * t)]))
    arguments = [sys.executable, "-m", "cadfit.cli", "fit", *(f"{k}.csv" for k in range(60)), "-o", "out"]
    child = subprocess.Popen(
        [*arguments, "--format", "json", "-t", "1e-4", "--effort", "fast", "--jobs", "2"],
        stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True, preexec_fn=heeding_ctrl_c,
    )  # fmt: skip
    end = time.monotonic() + 60
    while time.monotonic() < end and len(workers := children(child.pid)) < 2:
        time.sleep(0.02)
    assert len(workers) >= 2
    while not to_all and time.monotonic() < end and not any(name.endswith(".json") for name in os.listdir("out")):
        time.sleep(0.02)  # once while the workers start, once when they are at work
    (os.killpg if to_all else os.kill)(child.pid, signal.SIGINT)
    out, err = child.communicate(timeout=60)
    assert (child.returncode, out, err) == (130, "", "")
    end = time.monotonic() + 10
    while any(map(alive, workers)) and time.monotonic() < end:  # what watches over the processes ends after them
        time.sleep(0.02)
    assert not any(map(alive, workers))
    assert [name for name in os.listdir("out") if not name.endswith(".json") or name.startswith(".")] == []


def children(pid):
    """The processes that a process has started."""
    try:
        with open(f"/proc/{pid}/task/{pid}/children") as file:
            return [int(each) for each in file.read().split()]
    except FileNotFoundError:
        return []
