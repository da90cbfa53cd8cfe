"""Table of the synthesis methods by the name in a design."""

from __future__ import annotations

from collections.abc import Callable

from frictool.synth.lft import lft
from frictool.synth.lft_lpv import lft_lpv
from frictool.synth.lpv import lpv
from frictool.synth.lpv_grid import lpv_grid
from frictool.synth.minimax import minimax
from frictool.synth.pid import pid
from frictool.synth.rst import rst
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem

METHODS: dict[str, Callable[[SynthesisProblem], ControllerCandidate]] = {
    "lft": lft,
    "lft_lpv": lft_lpv,
    "lpv": lpv,
    "lpv_grid": lpv_grid,
    "minimax": minimax,
    "pid": pid,
    "rst": rst,
}
