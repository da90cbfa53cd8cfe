"""`frictool simulate --excitation`: a bench's log of what `excite` proposes, the chain that it
feeds, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from frictool.logs.canonical.mcap_format import read_mcap
from studies.command_line import CommandResult, run
from tests.support.command_line import refused

ROOT = Path(__file__).parents[2]
CLUTCH = ROOT / "configs" / "clutch"
GAINS = ("--position-gain", "30", "--speed-gain", "0.1")
STEP = 2.0 * np.pi / 56.0


@pytest.fixture(scope="module")
def tests(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with steps.mcap and ramps.mcap, of `excite`."""
    folder = tmp_path_factory.mktemp("excitation")
    for name, kind in (("steps", "steps"), ("ramps", "breakaway")):
        assert (
            run(
                "excite",
                "--bench",
                CLUTCH / "bench.yaml",
                "--kind",
                kind,
                "-o",
                folder / f"{name}.mcap",
            ).code
            == 0
        )
    return folder


def play(test: Path, output: Path, *more: str) -> CommandResult:
    return run("simulate", CLUTCH / "nonlinear.yaml", "--excitation", test, "-o", output, *more)


def test_a_reference_gives_what_the_bench_would_log_and_no_more(
    tests: Path, tmp_path: Path
) -> None:
    result = play(
        tests / "steps.mcap", tmp_path / "log.mcap", *GAINS, "--drive-noise", "0.1", "--seed", "7"
    )
    assert result.code == 0, result.stderr
    assert result.stdout.startswith(
        "steps: 4455 samples, 4.455 s; position, current, effort, reference"
    )
    log = read_mcap(tmp_path / "log.mcap")
    assert set(log.main.signals) == {"position", "current", "effort", "reference"}
    np.testing.assert_allclose(
        log.main.signals["position"] / STEP, np.rint(log.main.signals["position"] / STEP), atol=1e-9
    )
    assert "--seed 7" in log.metadata["provenance"]["command"]


def test_the_same_seed_gives_the_same_bytes_and_another_seed_another_log(
    tests: Path, tmp_path: Path
) -> None:
    for name, seed in (("a", "1"), ("b", "1"), ("c", "2")):
        play(tests / "steps.mcap", tmp_path / name, *GAINS, "--drive-noise", "0.1", "--seed", seed)
    logs = [(tmp_path / name).read_bytes() for name in "abc"]
    assert logs[0] == logs[1] != logs[2]


def test_ramps_give_the_breakaway_that_the_model_has(tests: Path, tmp_path: Path) -> None:
    assert play(tests / "ramps.mcap", tmp_path / "log.mcap", "--drive-noise", "0.1").code == 0
    ramp = read_mcap(tmp_path / "log.mcap").main.signals
    turned = int(np.argmax(ramp["position"]))
    assert ramp["current"][:turned].min() > -1.0
    assert ramp["current"][turned + 100 :].max() < 1.0
    assert ramp["position"].max() > 59.85
    assert ramp["position"][-1] < 3.15 + STEP


@pytest.mark.parametrize(
    ("test", "more", "words"),
    [
        ("steps", [], "--position-gain and --speed-gain"),
        ("steps", ["--position-gain", "30"], "--speed-gain"),
        ("ramps", [*GAINS], "leave out the gains"),
        (
            "steps",
            [*GAINS, "--scenario", str(CLUTCH / "scenarios" / "steps.yaml")],
            "does not work with --controller, --scenario",
        ),
    ],
)
def test_a_command_line_that_makes_no_sense_is_refused(
    tests: Path, tmp_path: Path, test: str, more: list[str], words: str
) -> None:
    result = play(tests / f"{test}.mcap", tmp_path / "log.mcap", *more)
    assert result.code == 2
    assert words in result.stderr
    assert not (tmp_path / "log.mcap").exists()


def test_a_log_that_is_no_test_is_refused(tests: Path, tmp_path: Path) -> None:
    play(tests / "steps.mcap", tmp_path / "log.mcap", *GAINS)
    for other in (tmp_path / "log.mcap", ROOT / "sample_logs" / "steps.csv"):
        refused(play(other, tmp_path / "again.mcap", *GAINS), 3, "is not a test of frictool excite")


def test_a_test_of_another_kind_of_axis_is_refused(tmp_path: Path) -> None:
    assert (
        run(
            "excite",
            "--bench",
            ROOT / "configs" / "emps" / "bench.yaml",
            "--kind",
            "steps",
            "-o",
            tmp_path / "emps.mcap",
        ).code
        == 0
    )
    refused(
        play(tmp_path / "emps.mcap", tmp_path / "log.mcap", *GAINS), 3, "reference in 'm'", "rotary"
    )


def test_a_test_of_another_period_is_refused(tests: Path, tmp_path: Path) -> None:
    text = (CLUTCH / "nonlinear.yaml").read_text()
    slow = tmp_path / "slow.yaml"
    slow.write_text(text.replace("sample_period_s: 0.001", "sample_period_s: 0.002"))
    refused(
        run(
            "simulate",
            slow,
            "--excitation",
            tests / "steps.mcap",
            *GAINS,
            "-o",
            tmp_path / "log.mcap",
        ),
        3,
        "0.001 s",
        "0.002 s",
    )


def test_a_loop_that_runs_into_the_end_of_the_travel_is_told(tests: Path, tmp_path: Path) -> None:
    result = play(tests / "steps.mcap", tmp_path / "log.mcap", *GAINS, "--integral-gain", "150")
    assert result.code == 0
    assert "within one encoder count of the end stop at 0 rad" in result.stderr


def test_a_load_acts_on_the_bench_too(tests: Path, tmp_path: Path) -> None:
    """A spring that the model has is in the effort that holds the axis."""
    text = (CLUTCH / "nonlinear.yaml").read_text()
    sprung = tmp_path / "sprung.yaml"
    spring = "laws:\n  load: {stiffness: {value: 0.002, unit: N m/rad, source: assumed}}\n"
    sprung.write_text(text.replace("laws:\n", spring, 1))
    efforts = []
    for model in (CLUTCH / "nonlinear.yaml", sprung):
        assert (
            run(
                "simulate",
                model,
                "--excitation",
                tests / "steps.mcap",
                *GAINS,
                "-o",
                tmp_path / "log.mcap",
            ).code
            == 0
        )
        log = read_mcap(tmp_path / "log.mcap").main.signals
        efforts.append(float(np.mean(log["effort"][log["position"] > 50.0])))
    assert efforts[1] > efforts[0] + 0.03


def test_neither_controller_nor_test_is_refused() -> None:
    result = run("simulate", CLUTCH / "nonlinear.yaml", "-o", "x.mcap")
    assert result.code == 2
    assert "--excitation" in result.stderr
