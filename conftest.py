"""The rooms of the kernel and of a host are collected only where these are installed."""

from importlib.util import find_spec

collect_ignore_glob = [] if find_spec("OCP") else ["cadfit/occt/*", "cadfit/files/kernel.py"]
collect_ignore_glob += [] if find_spec("cadquery") else ["cadfit/cadquery/*", "examples/cadquery/*"]
collect_ignore_glob += [] if find_spec("build123d") else ["cadfit/build123d/*", "examples/build123d_cases.py"]
