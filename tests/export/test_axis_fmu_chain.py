"""`export --lang fmu` of a model: its command, beside `simulate`, and back through `identify`."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.presliding import Presliding
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import run
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from studies.rigs.step_scenario import scenario
from studies.rigs.verified_controller import truthful
from tests.support.command_line import refused
from tests.support.documentation_pages import ROOT
from tests.support.export_models import BENCH, known_effort, known_model
from tests.support.fmi_units import Unit, extracted

NONLINEAR = ROOT / "configs/clutch/nonlinear.yaml"
PERIOD = 1e-3
KNOWN = {"inertia": 2.5e-3, "viscous": 0.008, "coulomb": 0.25, "breakaway": 0.25, "offset": 0.05}


def exported(document: Path, folder: Path, *more: str) -> Path:
    """The extracted unit of a document."""
    result = run("export", document, "--lang", "fmu", *more, "-o", folder)
    assert result.code == 0, result.stderr
    (file,) = folder.glob("*.fmu")
    return extracted(file.read_bytes(), folder / "unit")


def test_the_command_writes_the_same_bytes_each_time(tmp_path: Path) -> None:
    call: list[Any] = ["export", NONLINEAR, "--lang", "fmu", "-o"]
    result = run(*call, tmp_path / "a")
    assert result.code == 0, result.stderr
    assert result.stdout.startswith("clutch_non_linear.fmu: fmu\n21 parameters: inertia, ")
    assert run(*call, tmp_path / "b").code == 0
    (file,) = (tmp_path / "a").iterdir()
    assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()
    with zipfile.ZipFile(file) as archive:
        assert archive.namelist() == [
            "modelDescription.xml",
            "sources/buildDescription.xml",
            "sources/fmi3_clutch_non_linear.c",
        ]
        text = archive.read("modelDescription.xml").decode()
    assert "frictool export nonlinear.yaml --lang fmu; model SHA-256 " in text


def test_what_the_unit_lacks_is_refused_with_its_name(tmp_path: Path) -> None:
    model = load(NONLINEAR, Model)
    presliding = Presliding(
        "lugre",
        Estimate(1e-3, unit="rad", source="identified"),
        Estimate(300.0, unit="N m/rad", source="identified"),
        Estimate(0.1, unit="N m", source="identified"),
    )
    path = tmp_path / "model.yaml"
    path.write_text(to_yaml(replace(model, presliding=presliding)))
    refused(
        run("export", path, "--lang", "fmu", "-o", tmp_path / "out"),
        4,
        "the FMU cannot represent presliding (hysteresis before breakaway)",
        "--without presliding",
    )
    result = run("export", path, "--lang", "fmu", "--without", "presliding", "-o", tmp_path / "out")
    assert result.code == 0, result.stderr
    assert "left out: presliding (hysteresis before breakaway)" in result.stdout


def test_options_of_the_other_document_are_a_wrong_command_line(tmp_path: Path) -> None:
    controller = tmp_path / "controller.yaml"
    controller.write_text(to_yaml(truthful(clutch_controller())))
    for document, option, value, words in (
        (NONLINEAR, "--number", "float", "--number does not work with --lang fmu (from a model)"),
        (controller, "--without", "backlash", "with --lang fmu (from a controller); allowed:"),
        (NONLINEAR, "--joint", "elbow", "--joint does not work with --lang fmu (from a model)"),
    ):
        result = run("export", document, "--lang", "fmu", option, value, "-o", tmp_path / "out")
        assert result.code == 2
        assert words in result.stderr
    refused(run("export", ROOT / "configs/clutch/bench.yaml", "--lang", "fmu", "-o", tmp_path), 3)


def test_controller_and_axis_together_are_the_loop_of_simulate(tmp_path: Path) -> None:
    """Both units in lockstep, and the axis alone under the logged commands, give the same log."""
    paths = {name: tmp_path / f"{name}.yaml" for name in ("controller", "scenario")}
    paths["controller"].write_text(to_yaml(truthful(clutch_controller(BRAKE_LAW))))
    paths["scenario"].write_text(to_yaml(scenario(40.0, 10.0, 25.0, seconds=0.8)))
    log = tmp_path / "run.mcap"
    documents: list[Any] = ["--controller", paths["controller"], "--scenario", paths["scenario"]]
    result = run("simulate", NONLINEAR, *documents, "-o", log)
    assert result.code == 0, result.stderr
    signals = read_mcap(log).main.signals
    axis_folder = exported(NONLINEAR, tmp_path / "axis")
    start = float(signals["position_true"][0])
    alone, plant = (Unit(axis_folder, start_position=start) for _ in range(2))
    (measured,) = plant.get("measured_position")
    controller = Unit(exported(paths["controller"], tmp_path / "law"), position=measured)
    before = 0.0
    for k, position in enumerate(signals["position_true"]):
        for unit in (alone, plant):
            assert unit.get("position")[0] == pytest.approx(position, abs=1e-9, rel=0.0)
        assert plant.get("measured_position")[0] == signals["position"][k]
        alone.set(command=before)
        before = float(signals["command"][k])
        plant.set(command=controller.get("drive")[0])
        controller.set(
            reference=float(signals["reference"][k]), position=plant.get("measured_position")[0]
        )
        for unit in (alone, plant, controller):
            unit.step(PERIOD)
    assert np.ptp(signals["position_true"]) > 20.0
    assert plant.get("events")[0] > 10


def played(unit: Unit, current: Any) -> Any:
    """Measured positions of a unit before each command."""
    positions = np.empty(current.size)
    for k, drive in enumerate(current):
        positions[k] = unit.get("measured_position")[0]
        unit.set(command=float(drive))
        unit.step(PERIOD)
    return positions


def test_round_trip_through_a_log_of_the_unit(tmp_path: Path) -> None:
    """Identified from a log of the unit and exported again: the known parameters are within the
    intervals, so that the torque of every motion is, too, and the unit moves as the first one."""
    bench = tmp_path / "bench.yaml"
    bench.write_text(BENCH)
    known = tmp_path / "known.yaml"
    known.write_text(to_yaml(known_model(load(bench, Bench))))
    unit = Unit(exported(known, tmp_path / "first"))
    time = np.arange(8000) * PERIOD
    current = known_effort(time) / 0.1
    positions = played(unit, current)
    log = tmp_path / "log.csv"
    rows = [f"{a:.3f},{b:.5f},{c:.9f}" for a, b, c in zip(time, positions, current, strict=True)]
    log.write_text("\n".join(["time,position,current", *rows]) + "\n")
    model = tmp_path / "model.yaml"
    done = run("identify", log, "--bench", bench, "--method", "least-squares", "-o", model)
    assert done.code in (0, 1), done.stderr
    folder = exported(model, tmp_path / "second")
    again = Unit(folder)
    for name in ("inertia", "viscous_forward", "coulomb_forward", "offset"):
        value = KNOWN[name.removesuffix("_forward")]
        found = re.search(r"interval (\S+) to ([^,\s]+)", again.variables[name].description)
        assert found is not None, again.variables[name].description
        low, high = map(float, found.groups())
        assert low <= value <= high, name
        assert float(again.variables[name].start) == pytest.approx(value, rel=0.05)
    difference = played(again, current) - positions
    assert np.sqrt(np.mean(difference**2)) < 0.02 * np.ptp(positions)


def test_fmpy_plays_the_unit(tmp_path: Path) -> None:
    """The names of the outputs and of the enumerations are those that an importing tool shows."""
    folder = exported(NONLINEAR, tmp_path / "axis")
    from fmpy import simulate_fmu

    time = np.arange(0.0, 0.3, PERIOD)
    inputs = np.array(
        [(t, 20.0 if t < 0.2 else 0.0) for t in time], [("time", float), ("command", float)]
    )
    names = ["position", "measured_position", "load_position", "mode", "events", "last_event"]
    result = simulate_fmu(
        str(folder),
        fmi_type="CoSimulation",
        stop_time=0.299,
        step_size=PERIOD,
        output_interval=PERIOD,
        input=inputs,
        output=names,
        start_values={"start_position": 5.0, "inertia": 1.5e-5},
    )
    unit = Unit(folder, start_position=5.0, inertia=1.5e-5)
    for k, (_, command) in enumerate(inputs[:-1]):
        unit.set(command=float(command))
        unit.step(PERIOD)
        assert result["position"][k + 1] == pytest.approx(unit.get("position")[0], abs=1e-9)
        assert result["mode"][k + 1] == unit.get("mode")[0]
    assert result["events"][-1] > 2
    assert np.ptp(result["position"]) > 5.0
