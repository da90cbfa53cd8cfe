"""Stages within a step: slope and powers of each, and guards that break within the step."""

from __future__ import annotations

from typing import Any

from numba import types

from frictool.engine.mechanism.articulated_body import field_within
from frictool.engine.mechanism.compiled_mechanism import CompiledMechanism
from frictool.engine.mechanism.dormand_prince8 import NODES
from frictool.engine.mechanism.law_kernels import by_address, call_by_address
from frictool.engine.mechanism.mode_guards import BROKEN
from frictool.engine.mechanism.state import (
    INPUTS,
    POINT,
    TRIAL,
    WATCHED,
    MechanismState,
    RateEvaluation,
)
from frictool.engine.mechanism.weighted_sums import stage_point
from frictool.runtime.kernels import inset_kernel, kernel
from frictool.typing import IntVector, Vector


@inset_kernel
def _stages(
    machine: CompiledMechanism,
    y: Vector,
    modes: IntVector,
    w: Vector,
    slopes: Vector,
    powers: Vector,
    lines: Vector,
    watched: IntVector,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    failed, seen, point, inputs, guard = 0, 1.0, lines[POINT], lines[INPUTS], lines[TRIAL]
    for stage in range(first, end):
        stage_point(stage, h, y, slopes, point)
        failed += field_within(
            machine,
            t + NODES[stage] * h,
            point,
            modes,
            inputs,
            RateEvaluation(slopes[stage], w, guard, powers[stage]),
        )
        if NODES[stage] < seen:
            for place in range(watching):
                if guard[watched[place]] < BROKEN:
                    seen = NODES[stage]
    return seen if failed == 0 else -1.0


@kernel
def stages_of_step(
    k: IntVector,
    p: Vector,
    laws: IntVector,
    y: Vector,
    modes: IntVector,
    w: Vector,
    slopes: Vector,
    powers: Vector,
    lines: Vector,
    places: IntVector,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    """Evaluate `stages`, with arguments one by one, as a call by address needs them."""
    return _stages(
        CompiledMechanism(k, p, laws),
        y,
        modes,
        w,
        slopes,
        powers,
        lines,
        places[WATCHED],
        t,
        h,
        first,
        end,
        watching,
    )


_a: Any = types.float64[::1]
_m: Any = types.float64[:, ::1]
_i: Any = types.int64[::1]
_j: Any = types.int64[:, ::1]
_f: Any = types.float64
_n: Any = types.int64
STAGES_OF_STEP: Any = types.FunctionType(
    _f(_i, _a, _j, _a, _i, _m, _m, _m, _m, _j, _f, _f, _n, _n, _n)
)


@by_address
def _by_address(
    _: Any,
    address: Any,
    k: Any,
    p: Any,
    laws: Any,
    y: Any,
    modes: Any,
    w: Any,
    slopes: Any,
    powers: Any,
    lines: Any,
    places: Any,
    t: Any,
    h: Any,
    first: Any,
    end: Any,
    watching: Any,
) -> Any:
    return call_by_address(STAGES_OF_STEP)


@inset_kernel
def stages(
    machine: CompiledMechanism,
    state: MechanismState,
    t: float,
    h: float,
    first: int,
    end: int,
    watching: int,
) -> float:
    """Compute slopes and powers of the stages first .. end - 1 of a step of length h.

    t [s]: time after the command. Returns the part of the step at which one of the first `watching`
    guards of the row WATCHED is first seen broken, 1 if none is, -1 if a law fails. Called by
    address, as `field` is.
    """
    k, p, laws = machine
    w, slopes, powers, lines, places = state.room
    address = laws[laws.shape[0] - 1, 2]
    seen: float = _by_address(
        address,
        k,
        p,
        laws,
        state.y,
        state.modes,
        w,
        slopes,
        powers,
        lines,
        places,
        t,
        h,
        first,
        end,
        watching,
    )
    return seen
