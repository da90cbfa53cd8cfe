"""The field benchmark: its scores on made records, and its published machine where its data is."""

from __future__ import annotations

import math
import os
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench, LoadTerms
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import MotionRecord, make_record
from studies.field.__main__ import divided, row, score_machine, table
from studies.field.manifest import HERE, bench_path, read_manifest
from studies.field.methods import MUJOCO, installed_methods, mujoco, plain
from studies.field.scores import FieldFit, Method, scored
from studies.rigs.identification_rigs import MASS, mass_bench, mass_sine

DATA = Path(os.environ.get("FRICTOOL_DATA", HERE.parents[2] / "shared" / "data")) / "field"


def fit(low: float, high: float) -> FieldFit:
    values = {"inertia": 1e-3, "viscous": 0.4, "coulomb": 1.0, "offset": 0.0}
    return FieldFit(values, {"coulomb": Interval(0.5 * (low + high), low, high)})


def test_scores_count_overlaps_published_values_and_refusals(tmp_path: Path) -> None:
    bench = mass_bench(tmp_path)
    units = [[mass_sine(1)], [mass_sine(2)], [mass_sine(3)]]
    answers = iter([fit(0.9, 1.1), fit(1.05, 1.2), "no motion", "saturated"])
    score = scored("m", lambda *_: next(answers), units, [[mass_sine(4)]], bench, {"coulomb": 1.0})
    assert score.across == 1.0
    assert score.published == (1, 2)
    assert score.refused == (1, 3)
    assert score.refused_rightly == (1, 1)
    assert score.reasons == ("no motion",)
    assert score.held_out is not None
    assert score.held_out < 0.2
    assert row("machine", score).startswith("| machine | m | ")


def test_plain_least_squares_gives_values_near_the_truth(tmp_path: Path) -> None:
    result = plain([mass_sine(1)], mass_bench(tmp_path))
    assert isinstance(result, FieldFit)
    assert result.values["viscous"] == pytest.approx(MASS.viscous, rel=0.1)


ARM = {"inertia": 0.02, "viscous": 0.1, "coulomb": 0.4, "sine": 3.0}


def arm_record() -> MotionRecord:
    """Return 6 s of an unbalanced arm that follows two sines, by Euler steps of 0.1 ms."""
    time = np.arange(6000) * 1e-3
    goal = 1.5 * np.sin(5.0 * time) + 0.5 * np.sin(2.1 * time)
    position, velocity, rows = 0.0, 0.0, []
    for reference in goal.tolist():
        effort = 40.0 * (reference - position) - 1.5 * velocity
        rows.append((position, effort))
        for _ in range(10):
            drive = effort - ARM["sine"] * math.sin(position)
            if velocity == 0.0 and abs(drive) <= ARM["coulomb"]:
                continue
            side = math.copysign(1.0, velocity or drive)
            force = drive - ARM["viscous"] * velocity - ARM["coulomb"] * side
            after = velocity + 1e-4 * force / ARM["inertia"]
            velocity = 0.0 if after * velocity < 0.0 else after
            position += 1e-4 * velocity
    positions, efforts = np.array(rows).T
    return make_record("arm", time, positions, efforts, 1e-5, 0.0)


def arm_bench(folder: Path) -> Bench:
    bench = mass_bench(folder)
    mechanics = msgspec.structs.replace(
        bench.mechanics, inertia=Quantity(0.02, 0.005, 0.1, unit="kg m^2")
    )
    load = LoadTerms(("offset", "gravity"))
    return msgspec.structs.replace(bench, axis="rotary", mechanics=mechanics, load=load)


@pytest.mark.parametrize(
    "method",
    [
        plain,
        pytest.param(
            mujoco,
            marks=[
                pytest.mark.accept,
                pytest.mark.skipif(
                    MUJOCO not in installed_methods(), reason="mujoco[sysid] is not installed"
                ),
            ],
        ),
    ],
)
def test_peers_include_declared_gravity(tmp_path: Path, method: Method) -> None:
    found = method([arm_record()], arm_bench(tmp_path))
    assert isinstance(found, FieldFit)
    assert found.laws is not None
    assert found.laws.load is not None
    assert found.laws.load.gravity is not None
    assert found.laws.load.gravity.sine.value == pytest.approx(ARM["sine"], rel=0.05)
    for name in ("inertia", "viscous", "coulomb"):
        assert found.values[name] == pytest.approx(ARM[name], rel=0.15), name


def test_a_record_is_divided_in_time() -> None:
    record: MotionRecord = mass_sine(1)
    first, second = divided([record], 2)
    assert first[0].time[-1] < second[0].time[0]
    assert first[0].time.size + second[0].time.size == record.time.size
    assert np.all(second[0].piece >= 0)


def test_every_machine_has_a_bench() -> None:
    manifest, home = read_manifest(HERE)
    for machine in manifest.machines:
        assert load(bench_path(machine, home), Bench).axis == "rotary"


def test_a_folder_without_records_gives_no_table(tmp_path: Path) -> None:
    assert table(tmp_path) == []


def test_a_joint_of_the_ur10e_is_identified_as_published() -> None:
    if not (DATA / "ur10e").is_dir():
        pytest.skip("the records are not here; set FRICTOOL_DATA to the folder that holds field/")
    manifest, home = read_manifest(DATA)
    (machine,) = (one for one in manifest.machines if one.name == "UR10e joint 6")
    scores = score_machine(machine, DATA, home)
    assert not isinstance(scores, str)
    assert scores[0].method == "frictool"
    assert scores[0].published[0] == scores[0].published[1] > 0
    assert scores[0].across == 1.0
