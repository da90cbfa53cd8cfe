"""The methods of synthesis by the name that a design gives them."""

from __future__ import annotations

from collections.abc import Callable

from frictool.synth.lpv import lpv
from frictool.synth.problem import Candidate, Problem

METHODS: dict[str, Callable[[Problem], Candidate]] = {"lpv": lpv}
