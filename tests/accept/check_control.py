"""What runs on the target is what is simulated: compiled C against the kernels over a million samples, every bit."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from frictool.control.cascade import LIMITED, MODE, control_step, initial_state
from frictool.control.packing import pack
from frictool.documents.controller import Controller
from frictool.kernels import kernel
from tests.control.example import BRAKE_LAW, CUT_LAW, clutch_controller
from tests.control.test_cascade import random_controller
from tests.export.test_c99 import STRICT, write

Matrix = NDArray[np.float64]
CONTROLLERS, SAMPLES, STEP = 20, 50_000, 2 * np.pi / 56
DRIVER = """
#include <stdio.h>
#include "speed.h"

int main(void)
{
    speed_state state;
    double row[2];
    double drive;

    if (fread(row, sizeof row[0], 2, stdin) != 2) {
        return 1;
    }
    speed_init(&state, row[1]);
    do {
        drive = speed_step(&state, row[0], row[1]);
        fwrite(&drive, sizeof drive, 1, stdout);
    } while (fread(row, sizeof row[0], 2, stdin) == 2);
    return 0;
}
"""


@kernel
def _simulated(parameters: Matrix, state: Matrix, inputs: Matrix, outputs: Matrix) -> None:
    """Fills outputs (n, 3): drive, mode, limit met."""
    for k in range(inputs.shape[0]):
        outputs[k, 0] = control_step(parameters, state, inputs[k, 0], inputs[k, 1])
        outputs[k, 1] = state[MODE]
        outputs[k, 2] = state[LIMITED]


def _inputs(random: np.random.Generator) -> Matrix:
    """References held for 500 samples; positions that go there in counts, wander, and stand still for the last third of each hold."""
    references = np.repeat(random.uniform(0.0, 63.0, SAMPLES // 500), 500)
    position, positions = references[0], np.empty(SAMPLES)
    for k, reference in enumerate(references):
        if k % 500 < 330:
            position += 0.03 * (reference - position) + STEP * random.normal()
        positions[k] = STEP * np.floor(position / STEP)
    return np.column_stack([references, positions])


def _controller(index: int) -> Controller:
    law = BRAKE_LAW if index % 2 else CUT_LAW
    controller = clutch_controller(law, prefilter=index % 4 < 2, limit=0.3 if index % 3 else 50.0)
    return controller if index < 4 else msgspec.structs.replace(controller, linear=random_controller(index % 8, index))


def exported_c_equals_the_simulation() -> dict[str, Any]:
    """Each controller's C, at -O0 and -O3, returns the kernels' drive on every sample."""
    if shutil.which("cc") is None:
        return {"passed": False, "reason": "no C compiler: there is no cc on the PATH"}
    random = np.random.default_rng(7)
    differing, modes, limited = 0, np.zeros(3, dtype=np.int64), 0
    for index in range(CONTROLLERS):
        controller, inputs, outputs = _controller(index), _inputs(random), np.empty((SAMPLES, 3))
        parameters = pack(controller)
        _simulated(parameters, initial_state(parameters, inputs[0, 1]), inputs, outputs)
        modes += np.bincount(outputs[:, 1].astype(np.int64), minlength=3)
        limited += int(np.count_nonzero(outputs[:, 2]))
        for optimisation in ("-O0", "-O3"):
            differing += int(np.count_nonzero(_on_target(controller, inputs, optimisation) != outputs[:, 0].view(np.uint64)))
    run, brake, rest = (int(count) for count in modes)
    visited = min(run, brake, rest, limited) > 1000
    samples = CONTROLLERS * SAMPLES
    return {
        "passed": differing == 0 and visited,
        "samples": samples,
        "differing": differing,
        "run": run,
        "brake": brake,
        "rest": rest,
        "limited": limited,
    }


def _on_target(controller: Controller, inputs: Matrix, optimisation: str) -> NDArray[np.uint64]:
    """The bits of the drives that the compiled code returns."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(controller, folder)
        (folder / "driver.c").write_text(DRIVER)
        command = ["cc", *STRICT, optimisation, "speed.c", "driver.c", "-lm", "-o", "driver"]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        result = subprocess.run([folder / "driver"], input=inputs.tobytes(), check=True, capture_output=True)
    return np.frombuffer(result.stdout, dtype=np.uint64)


CHECKS = {"exported C equals the simulation": exported_c_equals_the_simulation}
