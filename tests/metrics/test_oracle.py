"""Response, rise and overshoot against the step figures of python-control."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.response_time import response_time_95
from frictool.metrics.rise_time import rise_time
from studies.rigs.step_responses import second_order

TIME = np.arange(8000) * 5e-4


@given(st.floats(0.15, 0.95), st.floats(12.0, 60.0))
def test_step_figures_are_those_of_another_program(damping: float, frequency: float) -> None:
    import control  # takes a second, which the collection of the tests does not need

    position = second_order(TIME, damping, frequency)
    theirs = control.step_info(position, TIME, final_output=1.0, SettlingTimeThreshold=0.05)
    assert response_time_95(TIME, position, 0.0, 1.0) == pytest.approx(
        theirs["SettlingTime"], abs=1.01e-3
    )
    assert rise_time(TIME, position, 0.0, 1.0) == pytest.approx(theirs["RiseTime"], abs=1.01e-3)
    assert overshoot_percent(position, 0.0, 1.0) == pytest.approx(theirs["Overshoot"], abs=1e-6)
