"""Compiled C against the simulation over a million samples in each number format, every bit.

Twenty controllers of every composition on inputs that wander; each is compiled by gcc and by clang,
at -O0 and at -O3, without a warning.
"""

from __future__ import annotations

import functools
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from numpy.typing import NDArray

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, control_step, read, start_at
from frictool.control.program import Program
from frictool.documents.controller import Controller, Number
from frictool.export.mode_coverage import visit_conditions
from frictool.runtime.kernels import kernel
from tests.support.compiled_c import (
    COMPILERS,
    NUMBERS,
    OPTIMISATIONS,
    Values,
    fits,
    in_format,
    library,
    simulated,
    write,
)
from tests.support.export_cases import CASES
from tests.support.export_controllers import controllers
from tests.support.export_inputs import rows_for, with_losses

CONTROLLERS, SAMPLES = 20, 50_000
DRAWN = 400  # controllers that are drawn, of which the first that the format can hold are played
NEEDED = (
    "run",
    "brake",
    "rest",
    "released",
    "braking",
    "held",
    "limited",
    "voltage",
    "invalid",
    "fault",
)
SEEN = 100  # samples, at least, of each of them in all of the runs


@functools.cache
def drawn() -> tuple[Controller, ...]:
    """The cases, then controllers of every composition, the same ones every time."""
    found: list[Controller] = list(CASES.values())

    @seed(7)
    @settings(
        max_examples=DRAWN,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(controllers())
    def collect(controller: Controller) -> None:
        found.append(controller)

    collect()
    return tuple(found)


def exported_c_equals_the_simulation(number: Number) -> dict[str, Any]:
    """Each controller's C returns the machine's drive on every sample, in the bits of the
    format."""
    missing = [name for name in ("gcc", "clang") if shutil.which(name) is None]
    if missing:
        return {"passed": False, "reason": f"no {' and no '.join(missing)} on the PATH"}
    differing = played = 0
    visits: dict[str, int] = dict.fromkeys(NEEDED, 0)
    for index, controller in enumerate(drawn()):
        program = controller_program(controller)
        if not fits(program, number):
            continue
        rows = in_format(program, number, _rows(controller, program, index))
        expected = simulated(program, number, rows)
        with tempfile.TemporaryDirectory() as name:
            write(controller, Path(name), number)
            for compiler in COMPILERS:
                for optimisation in OPTIMISATIONS:
                    drives = library(controller, number, Path(name), compiler, optimisation)(rows)
                    differing += int(np.count_nonzero(_bits(drives) != _bits(expected)))
        for visit, count in visited(controller, program, index).items():
            visits[visit] += count
        played += 1
        if played == CONTROLLERS:
            break
    return {
        "passed": differing == 0 and played == CONTROLLERS and min(visits.values()) >= SEEN,
        "samples": played * SAMPLES,
        "builds": len(COMPILERS) * len(OPTIMISATIONS),
        "differing": differing,
        "visits": visits,
    }


def _rows(controller: Controller, program: Program, index: int) -> Values:
    return with_losses(rows_for(controller, program, SAMPLES, index), program, index)


def _bits(drives: Values) -> NDArray[np.uint32] | NDArray[np.uint64]:
    return drives.view(np.uint64 if drives.itemsize == 8 else np.uint32)


def visited(controller: Controller, program: Program, index: int) -> dict[str, int]:
    """Samples in each mode and at each limit on the inputs, by the program in double."""
    running, rows = compile_program(program), _rows(controller, program, index)
    visits = visit_conditions(program)
    start_at(running, rows[0, list(program.inputs).index("position")])
    watched = np.array(
        [[visit.index, -1 if visit.where is None else visit.where] for visit in visits.values()]
    )
    inputs = len(program.inputs)
    values = np.array([[visit.value, float(visit.differs)] for visit in visits.values()])
    counts = np.zeros(len(visits), dtype=np.int64)
    _count(running, inputs, rows, watched, values, counts)
    return {name: int(count) for name, count in zip(visits, counts, strict=True)}


@kernel
def _count(
    running: Any, inputs: int, rows: Values, watched: Values, values: Values, counts: Values
) -> None:
    for k in range(rows.shape[0]):
        control_step(running, rows[k, 0], rows[k, 1], rows[k, 2] if inputs > 2 else 0.0)
        for j in range(watched.shape[0]):
            if watched[j, 1] < 0 or read(running, watched[j, 1]) != 0.0:
                counts[j] += (read(running, watched[j, 0]) == values[j, 0]) != (values[j, 1] != 0.0)


CHECKS = {
    f"exported C equals the simulation, {number}": functools.partial(
        exported_c_equals_the_simulation, number
    )
    for number in NUMBERS
}
