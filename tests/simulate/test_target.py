"""`simulate --target`: the exported C in the loop gives the simulation's log, in every channel and
number format; and what is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.documents.conditions import SensorFault
from frictool.documents.controller import Controller, Number
from frictool.documents.provenance import Provenance, digest
from frictool.errors import FrictoolError
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.log import Log
from frictool.simulate import compiled_target as targets
from frictool.simulate.closed_loop import SimulationRequest, simulate_closed_loop
from frictool.simulate.compiled_target import COMPILERS, compiled_target
from studies.command_line import run
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_scenario import controller, scenario, write_rig
from tests.support.command_line import refused
from tests.support.compiled_c import NUMBERS, sources
from tests.support.export_cases import CASES

needs_compiler = pytest.mark.skipif(
    not any(map(shutil.which, COMPILERS)), reason="no C compiler on the PATH"
)
PROVENANCE = Provenance("frictool simulate", "0")
SHA256 = "0" * 64  # of the sources that tests.support.compiled_c writes


def logs(
    made: Controller, number: Number, folder: Path, faults: tuple[SensorFault, ...] = ()
) -> tuple[Log, Log]:
    """The log with the simulation's own controller, and the one with the compiled code."""
    for name, text in sources(made, number).items():
        (folder / name).write_text(text)
    code = compiled_target(
        folder, SHA256, "controller.yaml", tuple(controller_program(made).inputs)
    )
    assert code.number == number
    played = (
        clutch_model(),
        made,
        scenario(40.0, 25.0, seconds=0.25, drive_noise=0.05, sensor_faults=faults),
        PROVENANCE,
    )
    simulated, compiled = (
        simulate_closed_loop(*played, request=request)
        for request in (SimulationRequest(number=number), SimulationRequest(target=code))
    )
    return simulated, compiled


def same(one: Log, other: Log) -> bool:
    """Every channel of every stream, byte for byte."""
    pairs = list(zip(one.streams, other.streams, strict=True))
    return all(
        a.signals[name].tobytes() == b.signals[name].tobytes()
        for a, b in pairs
        for name in a.signals
    )


@needs_compiler
@pytest.mark.parametrize(
    ("case", "number"),
    [
        pytest.param(case, number, marks=() if (k + n) % 2 == 0 else pytest.mark.accept)
        for k, case in enumerate(("cut", "position"))
        for n, number in enumerate(NUMBERS)
    ],
)
def test_the_log_is_the_same_in_every_channel(case: str, number: Number, tmp_path: Path) -> None:
    made = controller() if case == "cut" else CASES[case]
    simulated, compiled = logs(made, number, tmp_path)
    assert same(simulated, compiled)
    assert simulated.main.signals["command"].any()
    assert simulated.main.signals["velocity"].any()


@needs_compiler
@pytest.mark.parametrize(
    ("case", "number"),
    [
        pytest.param(case, number, marks=() if (k + n) % 3 == 0 else pytest.mark.accept)
        for k, case in enumerate(("observed", "cut", "position"))
        for n, number in enumerate(NUMBERS)
    ],
)
def test_an_encoder_that_is_lost_is_the_same_in_every_channel_too(
    case: str, number: Number, tmp_path: Path
) -> None:
    """Three samples are bridged; of five more the last two set the fault, and the valid ones after
    them do not end it."""
    made = controller() if case == "cut" else CASES[case]
    lost = (SensorFault("encoder_invalid", 0.05, 0.053), SensorFault("encoder_invalid", 0.3, 0.305))
    simulated, compiled = logs(made, number, tmp_path, lost)
    assert same(simulated, compiled)
    signals = simulated.main.signals
    assert np.flatnonzero(signals["position_valid"] == 0.0).tolist() == [
        50,
        51,
        52,
        300,
        301,
        302,
        303,
        304,
    ]
    assert np.flatnonzero(signals["controller_fault"]).tolist() == list(range(303, 500))
    assert not signals["command"][303:].any()
    assert signals["command"][50:53].all()
    warned = [
        one for one in simulated.warnings if one.startswith("/axis: the controller")
    ]  # not of the model, which the example is not verified for
    assert warned == [
        "/axis: the controller reports a fault at 0.303 s, after more than 3 samples without a "
        "valid position; the drive is then 0"
    ]


@needs_compiler
def test_number_formats_differ_in_the_loop_but_little(tmp_path: Path) -> None:
    double, q31 = (
        simulate_closed_loop(
            clutch_model(),
            controller(),
            scenario(40.0),
            PROVENANCE,
            request=SimulationRequest(number=number),
        )
        for number in ("double", "q31")
    )
    assert not same(double, q31)
    assert (
        abs(double.main.signals["position_true"] - q31.main.signals["position_true"]).max() < 0.05
    )


@needs_compiler
def test_command_plays_the_folder_and_names_its_sources(tmp_path: Path) -> None:
    rig = write_rig(tmp_path)
    made, sha256 = controller(), digest(rig["controller"])
    folder = tmp_path / "c"
    folder.mkdir()
    (folder / "main.c").write_text("not C")
    for name, text in sources(made).items():
        (folder / name).write_text(text.replace(SHA256, sha256))
    common = [
        "simulate",
        rig["model"],
        "--controller",
        rig["controller"],
        "--scenario",
        rig["scenario"],
        "-o",
    ]
    assert run(*common, tmp_path / "a.mcap").code == 0
    result = run(*common, tmp_path / "b.mcap", "--target", folder)
    assert result.code == 0, result.stderr
    one, other = read_mcap(tmp_path / "a.mcap"), read_mcap(tmp_path / "b.mcap")
    assert same(one, other)
    provenance = other.metadata["provenance"]
    assert provenance["command"].endswith("--scenario scenario.yaml --target c")
    assert f"speed.c sha256:{digest(folder / 'speed.c')}" in provenance.values()
    assert f"speed.h sha256:{digest(folder / 'speed.h')}" in provenance.values()
    both = run(*common, tmp_path / "c.mcap", "--target", folder, "--number", "float")
    assert (both.code, "leave out --number" in both.stderr) == (2, True)
    rig["controller"].write_text(rig["controller"].read_text() + "# another\n")
    refused(
        run(*common, tmp_path / "c.mcap", "--target", folder),
        3,
        "has no sources of",
        f"speed.h belongs to the controller {sha256[:12]}",
    )
    assert not (tmp_path / "c.mcap").exists()


@needs_compiler
def test_what_cannot_be_run_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        FrictoolError, match="is not a folder; allowed: the folder that `frictool export"
    ):
        compiled_target(tmp_path / "nothing", SHA256, "controller.yaml", ("reference", "position"))
    with pytest.raises(FrictoolError, match="there is no header of frictool export"):
        compiled_target(tmp_path, SHA256, "controller.yaml", ("reference", "position"))
    for name, text in sources(controller()).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "speed.c").write_text("int f(void) { return }\n")
    with pytest.raises(FrictoolError, match=r"speed.c: does not compile: .*error"):
        compiled_target(tmp_path, SHA256, "controller.yaml", ("reference", "position"))
    (tmp_path / "speed.c").unlink()
    with pytest.raises(FrictoolError, match=r"speed.c: is missing in the folder of speed.h"):
        compiled_target(tmp_path, SHA256, "controller.yaml", ("reference", "position"))
    (tmp_path / "speed.c").write_text("")
    monkeypatch.setattr(targets, "COMPILERS", ("no-such-compiler",))
    with pytest.raises(
        FrictoolError, match="needs a C compiler: none of no-such-compiler is on the PATH"
    ):
        compiled_target(tmp_path, SHA256, "controller.yaml", ("reference", "position"))


def test_a_format_that_cannot_be_scaled_is_no_solution() -> None:
    made = controller()
    endless = msgspec.structs.replace(
        made.bench, mechanics=msgspec.structs.replace(made.bench.mechanics, travel=None)
    )
    with pytest.raises(
        FrictoolError, match="cannot be scaled to q31: reference has no bounds"
    ) as raised:
        simulate_closed_loop(
            clutch_model(),
            msgspec.structs.replace(made, bench=endless),
            scenario(),
            PROVENANCE,
            request=SimulationRequest(number="q31"),
        )
    assert raised.value.exit_code == 4
