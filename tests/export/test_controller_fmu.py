"""`export --lang fmu`: the unit is valid, compiles strictly, and equals the simulated controller to
the last bit."""

from __future__ import annotations

import io
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.documents.controller import Controller, Number
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.export.controller_fmu import controller_fmu
from studies.command_line import run
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.command_line import refused
from tests.support.compiled_c import (
    KINDS,
    ORIGIN,
    held,
    needs_compiler,
    simulated,
    sources,
)
from tests.support.export_controllers import scheduled
from tests.support.fmi_units import extracted

CONTROLLERS = {"clutch": clutch_controller(CUT_LAW), "scheduled": scheduled(clutch_controller())}
SAMPLES = 400
GOLDEN = Path(__file__).parent / "golden"


def unit(controller: Controller, number: Number = "double") -> bytes:
    files = controller_fmu(
        controller, controller_program(controller), number, sources(controller, number), ORIGIN
    )
    (content,) = files.values()
    return content


def rows_of(controller: Controller) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Inputs and scheduled parameters of each sample, with a gap of the sensor."""
    program = controller_program(controller)
    rng = np.random.default_rng(28)
    count, more = len(program.inputs), held(program)
    rows = 0.3 * np.cumsum(rng.normal(size=(SAMPLES, count + len(more))), axis=0)
    for k, name in enumerate(more):
        first = program.states[name].value
        rows[:, count + k] = first * (1.0 + 0.02 * np.tanh(rows[:, count + k]))
    rows[100:102, 1] = np.nan
    rows[350:360, 1] = np.nan  # longer than the hold: the fault
    return rows


@pytest.fixture(scope="module", params=[(c, n) for c in CONTROLLERS for n in ("double", "float")])
def built(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Controller, Number, Path]:
    """A unit with its binary, compiled strictly from the files of its build description."""
    name, number = request.param
    controller = CONTROLLERS[name]
    folder = tmp_path_factory.mktemp(f"{name}-{number}")
    return controller, number, extracted(unit(controller, number), folder)


def test_fmpy_finds_no_fault_in_the_description(tmp_path: Path) -> None:
    validation = pytest.importorskip("fmpy.validation", reason="fmpy is not installed")
    for name, controller in CONTROLLERS.items():
        path = tmp_path / f"{name}.fmu"
        path.write_bytes(unit(controller))
        assert validation.validate_fmu(str(path)) == []


def test_each_sample_is_that_of_the_simulated_controller(
    built: tuple[Controller, Number, Path],
) -> None:
    from fmpy import read_model_description, simulate_fmu

    controller, number, folder = built
    program = controller_program(controller)
    rows = rows_of(controller).astype(KINDS[number]).astype(np.float64)
    period = controller.sample_period_s
    description = read_model_description(str(folder), validate=True)
    names = [one.name for one in description.modelVariables if one.causality == "input"]
    assert names == [*program.inputs, *held(program)]
    time = np.arange(SAMPLES) * period
    signals = np.array(
        list(zip(time, *rows.T, strict=True)), dtype=[("time", float)] + [(n, float) for n in names]
    )
    result = simulate_fmu(
        str(folder),
        fmi_type="CoSimulation",
        stop_time=(SAMPLES - 1) * period,
        step_size=period,
        output_interval=period,
        input=signals,
        output=["drive", "fault"],
        start_values={name: rows[0, k] for k, name in enumerate(names)},
    )
    wanted = simulated(program, number, rows.astype(KINDS[number]))
    assert result["drive"][0] == 0.0
    np.testing.assert_array_equal(result["drive"][1:], wanted[: SAMPLES - 1].astype(np.float64))
    assert np.any(wanted != 0.0)
    assert not result["fault"][300]
    assert result["fault"][-1]


def test_a_stored_state_continues_with_the_same_bits(
    built: tuple[Controller, Number, Path],
) -> None:
    from fmpy import read_model_description
    from fmpy.fmi3 import FMU3Slave

    controller, _, folder = built
    description = read_model_description(str(folder))
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=str(folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    slave.instantiate()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    period = controller.sample_period_s
    drive = next(v.valueReference for v in description.modelVariables if v.name == "drive")

    def played(first: int, last: int) -> list[float]:
        out = []
        for k in range(first, last):
            slave.setFloat64([1, 2], [0.5, 0.001 * k])
            slave.doStep(k * period, period)
            out += slave.getFloat64([drive])
        return out

    played(0, 20)
    state = slave.getFMUState()
    stored = slave.serializeFMUState(state)
    once = played(20, 60)
    slave.setFMUState(slave.deserializeFMUState(stored))
    assert played(20, 60) == once
    assert len(set(once)) > 1
    with pytest.raises(Exception, match="fmi3DoStep failed"):
        slave.doStep(0.0, 0.3 * period)
    slave.reset()
    assert slave.getFloat64([drive]) == [0.0]
    slave.freeInstance()


@pytest.mark.accept  # tests/export/test_axis_fmu.py builds a unit
@needs_compiler
def test_fmpy_builds_the_unit(tmp_path: Path) -> None:
    build = pytest.importorskip("fmpy.build", reason="fmpy is not installed")
    if shutil.which("cmake") is None:
        pytest.skip("cmake is not on the PATH")
    zipfile.ZipFile(io.BytesIO(unit(CONTROLLERS["clutch"]))).extractall(tmp_path)
    (tmp_path / "build").mkdir()
    build.build_platform_binary(tmp_path, tmp_path / "build")
    assert len(list((tmp_path / "binaries").rglob("*.so"))) == 1


def test_the_command_writes_the_same_bytes_each_time(tmp_path: Path) -> None:
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(truthful(CONTROLLERS["clutch"])))
    call = ["export", path, "--lang", "fmu", "-o"]
    result = run(*call, tmp_path / "a")
    assert result.code == 0, result.stderr
    assert "one sample every 0.001 s" in result.stdout
    assert run(*call, tmp_path / "b").code == 0
    (file,) = (tmp_path / "a").iterdir()
    assert file.name == "speed.fmu"
    assert file.read_bytes() == (tmp_path / "b/speed.fmu").read_bytes()
    with zipfile.ZipFile(file) as archive:
        assert archive.namelist() == [
            "modelDescription.xml",
            "sources/buildDescription.xml",
            "sources/speed.h",
            "sources/speed.c",
            "sources/fmi3_speed.c",
        ]
    refused(run(*call, tmp_path / "c", "--number", "q15"), 4, "allowed: double, float")


def test_fixed_point_is_refused() -> None:
    controller = CONTROLLERS["clutch"]
    with pytest.raises(NoSolutionError, match="the variables of an FMU are doubles"):
        controller_fmu(controller, controller_program(controller), "q31", {}, ORIGIN)


@pytest.mark.parametrize("number", ["double", "float"])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_description_is_that_of_the_folder(name: str, number: Number) -> None:
    """The inputs, the outputs and the scheduled parameters, with their units and starts."""
    with zipfile.ZipFile(io.BytesIO(unit(CONTROLLERS[name], number))) as archive:
        text = archive.read("modelDescription.xml").decode()
    assert text == (GOLDEN / f"controller_{name}.xml").read_text()
