"""Any drive, drawn by hypothesis, and a run that ended as it should."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from frictool.engine.drive import EffortFunction
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip_run import Trajectory

drives = st.builds(
    EffortFunction,
    offset=st.floats(-2.0, 2.0),
    slope=st.floats(-1.0, 1.0),
    amplitude=st.floats(0.0, 3.0),
    frequency=st.floats(0.1, 20.0),
    phase=st.floats(0.0, 6.0),
    proportional=st.floats(0.0, 20.0),
    derivative=st.floats(0.0, 3.0),
    integral=st.floats(0.0, 4.0),
    target=st.floats(-1.0, 1.0),
    target_speed=st.floats(-0.2, 0.2),
)


def ok(run: Trajectory) -> Trajectory:
    assert run.status == OK
    assert not np.any(np.isnan(run.samples))
    return run
