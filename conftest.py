"""The kernel's room is collected only where its kernel is installed."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("OCP") else ["cadfit/occt/*", "cadfit/files/kernel.py"]
