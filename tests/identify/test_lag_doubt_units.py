"""Unit of the parameter that an unknown lag of a voltage drive changes most."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from frictool.identify.fit_result import SLIDING, Interval
from frictool.identify.winding_delay import lag_doubts
from studies.rigs.identification_rigs import mass_bench

UNITS = {"inertia": "kg", "viscous": "N s/m", "coulomb": "N", "offset": "N"}


@pytest.mark.parametrize("name", SLIDING)
def test_each_parameter_has_the_unit_of_its_dimension(tmp_path: Path, name: str) -> None:
    """Coulomb friction and offset are efforts; a delay may change any parameter most."""
    late = SimpleNamespace(term="delay")
    without = SimpleNamespace(intervals=lambda _: {}, rates=lambda _: {name: -2.0})
    regression = SimpleNamespace(hypotheses=[late], used=(), noisy=False, without=lambda _: without)
    record = SimpleNamespace(lag=0.0, winding=None, period=1e-3, effort_measured=False)
    bench = SimpleNamespace(
        actuator=SimpleNamespace(winding_delays=True), axis=mass_bench(tmp_path).axis
    )
    wide = {name: Interval(1.0, 1.0 - 1e-6, 1.0 + 1e-6)}
    # the stand-ins have only what the function reads
    ((found, doubt),) = lag_doubts([record], bench, regression, wide)  # type: ignore[arg-type, list-item]
    assert found == name
    assert f"changes by about 0.002 {UNITS[name]} per ms" in doubt
    record.effort_measured = True  # the lag of a winding is before the sensor of the effort
    assert lag_doubts([record], bench, regression, wide) == []  # type: ignore[arg-type, list-item]
