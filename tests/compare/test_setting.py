"""Where the parameters come from: the documents of configs/mass, the built-in table, a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from frictool.compare import input_protocol
from frictool.compare.comparison_setting import from_friction, scales_of, table_3_1
from frictool.documents.friction import Friction
from frictool.documents.registry import load
from frictool.engine.drive import effort
from frictool.errors import DocumentError

MASS = Path(__file__).parents[2] / "configs/mass"


def test_the_built_in_table_is_the_document() -> None:
    document = from_friction(load(MASS / "friction.yaml", Friction))
    assert replace(document, name="table 3.1") == table_3_1()
    assert (document.stiffness, document.damping) == pytest.approx((1.5e5, 2.0 * 1.5e5**0.5))
    printed = from_friction(load(MASS / "table_3_1.yaml", Friction))
    assert replace(printed, step=4e-5, switch_velocity=4e-3) == document
    assert printed.step == printed.switch_velocity == 1e-4


def test_a_breakaway_below_the_coulomb_friction_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "friction.yaml"
    path.write_text(
        (MASS / "friction.yaml")
        .read_text()
        .replace("breakaway: {value: 1.5,", "breakaway: {value: 0.9,")
    )
    with pytest.raises(DocumentError, match=r"breakaway 0\.9 is below coulomb 1"):
        load(path, Friction)


def test_the_drift_input_is_continuous_and_stays_below_the_coulomb_friction() -> None:
    scales = scales_of(2.0, 3.0, 4.5, 0.1)
    begin, last = 0.0, 0.0
    for end, drive in input_protocol.drift(scales):
        array = drive.as_array()
        assert effort(begin, 0.0, 0.0, 0.0, array) == pytest.approx(last, abs=1e-9)
        last = effort(end, 0.0, 0.0, 0.0, array)
        begin = end
    assert begin == pytest.approx(102.0 * scales.time)
    _, wave = input_protocol.drift(scales)[-1]
    forces = [
        effort(2.0 * scales.time + 0.01 * k * scales.time, 0.0, 0.0, 0.0, wave.as_array())
        for k in range(100)
    ]
    assert max(forces) == pytest.approx(0.9 * scales.force, rel=1e-2)
    assert min(forces) == pytest.approx(0.1 * scales.force, rel=1e-1)


def test_the_presliding_path_passes_its_turning_points() -> None:
    path, turning = input_protocol.presliding_path(1e-5, 7)
    assert path[turning.astype(int)] == pytest.approx(
        [1e-5 * z for z in input_protocol.TURNING_POINTS]
    )
    assert path.size == 71
