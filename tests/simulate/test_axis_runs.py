"""Many runs of an axis at once: each as it is alone, by machine code and by the interpreter."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program
from frictool.control.machine_code import machine_code
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.plant.position_load import PositionLoad
from frictool.simulate.axis_runs import play
from frictool.simulate.axis_variants import AxisVariant
from frictool.simulate.simulated_plant import SimulatedLoop
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_scenario import controller, scenario

PLANTS, SAMPLES = 12, 300


@pytest.mark.parametrize("coded", [True, False])
def test_many_runs_are_each_the_run_alone(coded: bool) -> None:
    program = controller_program(controller())
    running = compile_program(program)
    loop = SimulatedLoop(
        controller(),
        scenario(),
        program,
        running,
        machine_code(running) if coded else None,
        None,
        0.0,
        np.full(SAMPLES, 20.0),
        NO_CONDITIONS,
        (),
        lambda done, total: None,
    )
    axis = axis_of(clutch_model())
    variants = [
        AxisVariant(f"r{i}", axis._replace(coulomb=axis.coulomb * factor))
        for i, factor in enumerate(np.random.default_rng(4).uniform(0.7, 1.0, PLANTS))
    ]
    together = [record for _, record in play(variants, loop, PositionLoad())]
    alone = [next(play([variant], loop, PositionLoad()))[1] for variant in variants]
    assert all(np.array_equal(*pair) for pair in zip(together, alone, strict=True))
    assert np.ptp([record[-1, 1] for record in alone]) > 0.0
