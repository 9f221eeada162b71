"""Tool paths: G-code read, its cutting moves refitted within a tolerance, the rest left as it is."""

from cadfit.toolpaths.machine import Arc as Arc
from cadfit.toolpaths.machine import Move as Move
from cadfit.toolpaths.reading import moves as moves
from cadfit.toolpaths.rewriting import Summary as Summary
from cadfit.toolpaths.rewriting import refit as refit
