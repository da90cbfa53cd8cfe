"""Lookup of the function that implements a synthesis method."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import cast

from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def solver(method: str) -> Callable[[SynthesisProblem], ControllerCandidate]:
    """Return the function of a synthesis method; function and module have the method's name."""
    function = getattr(import_module(f"frictool.synth.{method}"), method)
    return cast(Callable[[SynthesisProblem], ControllerCandidate], function)
