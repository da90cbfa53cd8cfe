"""`frictool validate`: figures, the plot, the closed loop, and what is refused."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.quantity import Axis
from frictool.engine.bench_position_loop import PositionServo, follow_reference
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.identify.validate.figures import effort_label
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_friction_laws import AxisLaws
from frictool.plant.position_load import PositionLoad
from studies.command_line import run
from studies.rigs.identification_rigs import EMPS
from tests.support.chromium import browser, find
from tests.support.command_line import also_called, refused
from tests.support.example_logs import as_bytes, golden_log
from tests.support.measured_data import data

AXIS = AxisParameters(inertia=2.0, viscous=10.0, coulomb=4.0, breakaway=5.0, offset=0.5)
PERIOD, CONSTANT = 1e-3, 20.0
KP, KV = 40.0, 8.0  # 1/s, A s/m

BENCH = """\
  format: bench/1
  name: carriage
  axis: linear
  sample_period_s: 0.001
  encoder: {step: {value: 1.0e-6, unit: m}}
  actuator: {drive: current, constant: {value: 20, unit: N/A}, limit: {value: 10, unit: A}}
  mechanics:
    inertia: {value: 2, low: 1, high: 3, unit: kg}
    viscous: {value: 10, low: 5, high: 15, unit: N s/m}
    coulomb: {value: 4, low: 2, high: 6, unit: N}
  columns:
    time: {column: time, unit: s}
    position: {column: x, unit: m}
    reference: {column: wanted, unit: m}
    current: {column: i, unit: A}
"""

MODEL = """\
format: model/1
name: carriage
axis: linear
law: coulomb
method: by hand
confidence: 0.95
bench:
{bench}
parameters:
  inertia: {{value: {inertia}, unit: kg, source: identified}}
  viscous: {{value: 10, unit: N s/m, source: identified}}
  coulomb: {{value: 4, unit: N, source: identified}}
  breakaway: {{value: 5, unit: N, source: identified}}
  offset: {{value: 0.5, unit: N, source: identified}}
provenance: {{command: none, frictool: "0", inputs: []}}
"""


def model(folder: Path, inertia: float = 2.0) -> Path:
    path = folder / f"model_{inertia:g}.yaml"
    path.write_text(MODEL.format(bench=BENCH, inertia=inertia))
    return path


def log(
    folder: Path,
    closed: bool = False,
    columns: str = "time,x,wanted,i",
    axis: AxisParameters = AXIS,
) -> Path:
    """Write the log of an axis as a bench would: in open loop under a current, or along a
    reference."""
    time = np.arange(4000) * PERIOD
    wanted = 0.05 * (1.0 - np.cos(2.0 * np.pi * time))
    current = 0.5 * np.sin(2.0 * np.pi * 1.3 * time) + 0.3 * np.sin(2.0 * np.pi * 0.4 * time)
    p = replay_parameters(axis)
    x, v, u = np.empty((3, time.size))
    if closed:
        servo = np.array(PositionServo(CONSTANT * KP * KV, derivative=CONSTANT * KV, limit=200.0))
        assert follow_reference(p, np.empty(0), rest(), servo, wanted, 0.0, PERIOD, x, v, u) == 0
        current = u / CONSTANT
    else:
        assert replay(p, np.empty(0), rest(), CONSTANT * current, x, FREE, PERIOD, x, v) == 0
    table = dict(zip(("time", "x", "wanted", "i"), (time, x, wanted, current), strict=True))
    path = folder / "log.csv"
    rows = np.column_stack([table[name] for name in columns.split(",")])
    np.savetxt(path, rows, delimiter=",", header=columns, comments="", fmt="%.12g")
    return path


def figures(*arguments: str | Path) -> dict[str, float]:
    result = run("validate", *arguments, "--json")
    assert result.code == 0, result.stderr
    found: dict[str, float] = json.loads(result.stdout)
    return found


def test_the_true_model_does_what_was_measured(tmp_path: Path) -> None:
    found = figures(model(tmp_path), log(tmp_path))
    assert found["loop"] == "open"
    assert (found["skip_samples"], found["samples"]) == (20, 3980)
    assert found["position_rmse_m"] < 2e-6
    assert found["position_error_rel"] < 1e-4
    assert found["force_error_rel"] < 0.02


def test_a_wrong_model_does_not_and_each_error_says_so(tmp_path: Path) -> None:
    measured = log(tmp_path)
    right, wrong = figures(model(tmp_path), measured), figures(model(tmp_path, 2.5), measured)
    for name in (
        "position_rmse_m",
        "position_error_rel",
        "velocity_error_rel",
        "acceleration_error_rel",
        "force_error_rel",
    ):
        assert wrong[name] > 3.0 * right[name]


def judged(model: Path, measured: Path) -> tuple[bool | None, float, str]:
    """Return the answer of `validate`, the limit of the error, and the warnings."""
    result = run("validate", model, measured, "--json")
    found = json.loads(result.stdout)
    assert result.code == (0 if found["reproduces"] else 1)
    assert bool(found["warnings"]) == (not found["reproduces"])
    assert all(one in result.stderr for one in found["warnings"])
    return found["reproduces"], found["judged_error_limit_rel"], " ".join(found["warnings"])


SLOW = ((0.5, 0.08), (1.3, 0.02))
STROKES = ((0.7, 0.1), (1.6, 0.03), (21.0, 3e-4))  # sines of a motion: Hz, m


def two_bodies(
    folder: Path,
    seed: int,
    resonance: float = np.inf,
    motion: tuple[tuple[float, float], ...] = STROKES,
    step: float = 1e-6,
) -> Path:
    """Write the log of two bodies of 1 kg and a spring with a free resonance [Hz]; inf is rigid.

    The encoder with a `step` [m] is at the load, the friction at the motor.
    """
    draw = np.random.default_rng(seed)
    time = np.arange(6000) * PERIOD
    load = np.zeros((5, time.size))  # position of the load and its derivatives
    for hertz, size in motion:
        rate, phase = 2.0 * np.pi * hertz, draw.uniform(0.0, 2.0 * np.pi)
        for order in range(5):
            load[order] += size * rate**order * np.sin(rate * time + phase + order * np.pi / 2.0)
    motor = load[:3] + 2.0 * load[2:] / (2.0 * np.pi * resonance) ** 2
    effort = AXIS.inertia * (load[2] + motor[2]) / 2.0 + AXIS.offset
    effort += AXIS.viscous * motor[1] + AXIS.coulomb * np.sign(motor[1])
    effort += 0.1 * draw.standard_normal(time.size)
    counts = np.floor(load[0] / step + draw.random()) * step
    rows = np.column_stack([time, counts, np.zeros(time.size), effort / CONSTANT])
    path = folder / f"bodies_{seed}.csv"
    np.savetxt(path, rows, delimiter=",", header="time,x,wanted,i", comments="", fmt="%.12g")
    return path


def test_a_resonance_contradicts_a_rigid_model(tmp_path: Path) -> None:
    for seed in range(5):
        assert judged(model(tmp_path), two_bodies(tmp_path, seed))[0] is True
        holds, limit, words = judged(model(tmp_path), two_bodies(tmp_path, seed, resonance=28.0))
        assert (holds, limit) == (False, pytest.approx(0.2, abs=0.02))
        assert "contradicts the model" in words


def test_noise_of_the_encoder_is_no_error_of_the_model(tmp_path: Path) -> None:
    """Strokes of 31 samples and 16 counts are too short to smooth the acceleration."""
    for seed in range(5):
        measured = two_bodies(tmp_path, seed, motion=((16.0, 8e-4),), step=1e-4)
        found = figures(model(tmp_path), measured)
        assert found["force_error_rel"] > 0.2
        assert found["judged_error_limit_rel"] > 0.3


def test_wide_intervals_alone_leave_the_answer_open(tmp_path: Path) -> None:
    """An inertia of 4 instead of 2 kg is wrong, but may be 2 kg if its interval contains 2 kg."""
    wrong, measured = model(tmp_path, 4.0), two_bodies(tmp_path, 1)
    holds, limit, _ = judged(wrong, measured)
    assert holds is False
    text = wrong.read_text().replace("{value: 4.0,", "{value: 4.0, low: 1.5, high: 5.0,")
    wrong.write_text(text)
    holds, wide, words = judged(wrong, measured)
    assert (holds, wide) == (None, limit)
    assert "wide intervals explain the error; identify again with this log added" in words


def test_a_weight_hides_no_wrong_friction(tmp_path: Path) -> None:
    """On a vertical axis, 60 % more Coulomb friction is an error of 4 % of the effort."""
    measured = log(tmp_path, closed=True, axis=AXIS._replace(offset=60.0))
    right = model(tmp_path).read_text().replace("{value: 0.5,", "{value: 60,")
    for coulomb, holds in ((4.0, True), (6.4, False)):
        path = tmp_path / f"vertical_{coulomb}.yaml"
        path.write_text(
            right.replace("{value: 4, unit: N, s", f"{{value: {coulomb}, unit: N, s").replace(
                "{value: 5, unit: N, s", "{value: 7, unit: N, s"
            )
        )
        answer, limit, _ = judged(path, measured)
        assert answer is holds
        assert 0.01 < limit < 0.04


def test_intervals_that_allow_any_effort_are_reported(tmp_path: Path) -> None:
    path = model(tmp_path)
    path.write_text(path.read_text().replace("{value: 0.5,", "{value: 0.5, low: -60, high: 60,"))
    result = run("validate", path, two_bodies(tmp_path, 1))
    assert result.code == 0
    assert "they allow a force error of" in result.stderr


def pressed(folder: Path, spring: float) -> Path:
    """Write the log of an axis with a `spring` [N/m] that is then pressed against a stop."""
    time = np.arange(8000) * PERIOD
    effort = 30.0 * np.sin(2.0 * np.pi * 0.9 * time) + 5.0 * np.sin(2.0 * np.pi * 0.23 * time)
    effort[6000:] = -45.0
    axis = AXIS._replace(laws=AxisLaws(stops=(-0.2, 0.2)))
    load = PositionLoad(spring).as_array()
    x, v = np.empty((2, time.size))
    p = replay_parameters(axis)
    assert replay(p, load, rest(), effort, x, FREE, PERIOD, x, v) == 0
    rows = np.column_stack([time, np.round(x, 6), 0.0 * x, effort / CONSTANT])
    path = folder / f"pressed_{spring:g}.csv"
    np.savetxt(path, rows, delimiter=",", header="time,x,wanted,i", comments="", fmt="%.12g")
    return path


def sprung(folder: Path, spring: float) -> Path:
    """Write the model of the axis with a `spring` [N/m] and a travel of 0.4 m."""
    path = model(folder)
    travel = "coulomb: {value: 4, low: 2, high: 6, unit: N}\n"
    text = path.read_text().replace(
        travel, f"{travel}    travel: {{low: -0.2, high: 0.2, unit: m}}\n"
    )
    value = f"{{value: {spring}, unit: N/m, source: identified}}"
    path.write_text(text + (f"laws: {{load: {{stiffness: {value}}}}}\n" if spring else ""))
    return path


def test_a_simulation_that_leaves_the_travel_is_no_yes(tmp_path: Path) -> None:
    """Without the stop, 45 N extend the spring of 80 N/m by more than 0.5 m."""
    holds, _, words = judged(sprung(tmp_path, 80.0), pressed(tmp_path, 80.0))
    assert holds is None
    assert "the simulated position leaves the travel, to -0." in words


def test_drift_without_a_spring_is_normal(tmp_path: Path) -> None:
    """Without a load, no effort brings the axis back, so that it may leave the travel."""
    paths = sprung(tmp_path, 0.0), pressed(tmp_path, 0.0)
    assert figures(*paths)["position_error_largest_m"] > 1.0
    text = run("validate", *paths).stdout
    assert "m at most: the simulation leaves the measured range of 0.4 m by far" in text


def test_a_rest_that_friction_cannot_hold_is_no_yes(tmp_path: Path) -> None:
    """Only an end of the travel explains why an effort of 45 N does not move the axis."""
    log = pressed(tmp_path, 0.0)
    holds, _, words = judged(model(tmp_path), log)
    assert holds is None
    assert "; the axis rests at -0.2 m under 4" in words
    assert judged(sprung(tmp_path, 0.0), log)[0]


def test_an_unstable_model_is_no_yes(tmp_path: Path) -> None:
    """A spring of -20 N/m instead of 0 hardly changes the effort, but 8 s amplify its error."""
    for travel in (True, False):
        unstable = sprung(tmp_path, -20.0)
        if not travel:
            lines = unstable.read_text().splitlines()
            unstable.write_text("\n".join(one for one in lines if "travel" not in one) + "\n")
        holds, _, words = judged(unstable, two_bodies(tmp_path, 1, motion=SLOW))
        assert holds is None
        assert ("leaves the travel" if travel else "diverges") in words


def test_ramps_decide_nothing(tmp_path: Path) -> None:
    """Ramps of a current up to the breakaway move the axis for a moment only."""
    pulse = np.concatenate([np.linspace(0.0, 0.3, 1500), np.zeros(700)])
    current = np.concatenate([side * pulse for side in (1, -1) * 5])
    x, v = np.empty((2, current.size))
    p = replay_parameters(AXIS)
    assert replay(p, np.empty(0), rest(), CONSTANT * current, x, FREE, PERIOD, x, v) == 0
    rows = np.column_stack([np.arange(x.size) * PERIOD, x, 0.0 * x, current])
    path = tmp_path / "ramps.csv"
    np.savetxt(path, rows, delimiter=",", header="time,x,wanted,i", comments="", fmt="%.12g")
    holds, _, words = judged(model(tmp_path, 20.0), path)
    assert holds is None
    assert "ramps show too little sliding; validate on strokes or steps" in words


def test_with_the_gains_the_reference_drives_the_model(tmp_path: Path) -> None:
    found = figures(
        model(tmp_path),
        log(tmp_path, closed=True),
        "--position-gain",
        str(KP),
        "--speed-gain",
        str(KV),
    )
    assert found["loop"] == "closed"
    assert found["position_rmse_m"] < 1e-6
    assert found["force_error_rel"] < 1e-3


def test_a_log_that_begins_in_motion_is_replayed_from_its_speed(tmp_path: Path) -> None:
    """A constant effort keeps 0.3 m/s; from rest the axis lags by v J / f = 0.06 m."""
    time = np.arange(2000) * PERIOD
    current = (AXIS.viscous * 0.3 + AXIS.coulomb + AXIS.offset) / CONSTANT
    rows = np.column_stack([time, 0.3 * time, np.zeros(time.size), np.full(time.size, current)])
    path = tmp_path / "moving.csv"
    np.savetxt(path, rows, delimiter=",", header="time,x,wanted,i", comments="", fmt="%.12g")
    assert figures(model(tmp_path), path, "--moving")["position_error_largest_m"] < 1e-4
    from_rest = figures(model(tmp_path), path)["position_error_largest_m"]
    assert from_rest == pytest.approx(0.3 * AXIS.inertia / AXIS.viscous, rel=0.01)


@pytest.mark.parametrize(("axis", "label"), [("rotary", "torque [N m]"), ("linear", "force [N]")])
def test_the_plot_calls_the_effort_what_it_is(axis: Axis, label: str) -> None:
    assert effort_label(axis) == label


def test_the_plot_is_the_same_each_time_and_text_tells_the_errors(tmp_path: Path) -> None:
    measured, plots = log(tmp_path), [tmp_path / "a.svg", tmp_path / "b.svg"]
    results = [run("validate", model(tmp_path), measured, "--plot", plot) for plot in plots]
    assert [result.code for result in results] == [0, 0]
    assert plots[0].read_bytes() == plots[1].read_bytes()
    assert plots[0].read_text().startswith("<svg")
    assert "open loop" in results[0].stdout
    assert "position error" in results[0].stdout


def test_the_page_shows_the_loop_and_its_signals(tmp_path: Path) -> None:
    pages = [tmp_path / "a.html", tmp_path / "b.html"]
    gains = ["--position-gain", str(KP), "--speed-gain", str(KV)]
    for loop, options, signals in (
        ("open", [], ["Position", "Position error", "Velocity"]),
        ("closed", gains, ["Position", "Position error", "Velocity", "Effort"]),
    ):
        measured = log(tmp_path, closed=loop == "closed")
        for page in pages[: 2 if loop == "closed" else 1]:
            assert run("validate", model(tmp_path), measured, *options, "--page", page).code == 0
        text = pages[0].read_text()
        assert loop == "open" or pages[0].read_bytes() == pages[1].read_bytes()
        assert re.findall("<h3>(.*?)</h3>", text) == [*signals, "Effort that the model lacks"]
        assert f"{loop} loop" in text
        assert ("reference" in text) == (loop == "closed")


@pytest.mark.skipif(find() is None, reason="no chromium is on the PATH")
def test_the_page_fits_a_phone_and_a_desktop_and_fetches_nothing(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert run("validate", model(tmp_path), log(tmp_path), "--page", page).code == 0
    with browser(tmp_path / "profile") as chromium:
        for width in (390, 1280):
            seen = chromium.open(page, width)
            assert chromium.evaluate("document.querySelectorAll('.chart').length") == 4
            assert chromium.evaluate("document.documentElement.scrollWidth") <= width
            assert [one for one in seen.requests if not one.startswith("data:")] == [page.as_uri()]
            assert (seen.dialogs, seen.console) == ([], [])


@pytest.mark.parametrize(
    ("columns", "options", "code", "words"),
    [
        ("time,x,wanted,i", ["--position-gain", "3"], 2, "--speed-gain"),
        ("time,x,wanted,i", ["--skip", "5000"], 3, "skip fewer"),
        (
            "time,x,wanted,i",
            ["--cutoff-hz", "1e-10"],
            3,
            "lasts 4 s; needed: at least one period of the cut-off, 1e+10 s; raise --cutoff-hz",
        ),
        ("time,x,wanted,i", ["--speed-gain", "-1", "--position-gain", "1"], 2, "--speed-gain"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    tmp_path: Path, columns: str, options: list[str], code: int, words: str
) -> None:
    result = run("validate", model(tmp_path), log(tmp_path, columns=columns), *options)
    assert result.code == code
    assert words in result.stderr
    assert result.stdout == ""


def test_the_log_is_not_overwritten(tmp_path: Path) -> None:
    measured = log(tmp_path)
    before = measured.read_bytes()
    result = run("validate", model(tmp_path), measured, "--plot", also_called(measured, ".svg"))
    assert result.code == 3
    assert "input" in result.stderr
    assert measured.read_bytes() == before


def test_emps_in_closed_loop_is_within_the_published_errors(tmp_path: Path) -> None:
    record, path = data("emps", "DATA_EMPS.mat"), tmp_path / "model.yaml"
    assert (
        run("identify", record, "--bench", EMPS, "--method", "inverse-dynamic", "-o", path).code
        == 0
    )
    found = figures(path, record, "--position-gain", "160.18", "--speed-gain", "243.45")
    published = {"position": 0.01375, "velocity": 0.229, "acceleration": 8.60, "force": 5.85}
    for name, percent in published.items():
        assert 100.0 * found[f"{name}_error_rel"] <= percent
    assert figures(path, record)["position_rmse_m"] == pytest.approx(6.65e-3, rel=0.02)


def test_a_log_in_the_place_of_the_model(tmp_path: Path):
    log, model = tmp_path / "log.mcap", tmp_path / "model.yaml"
    log.write_bytes(as_bytes(golden_log()))
    model.write_text("format: model/2\n")
    refused(
        run("validate", log, model),
        3,
        "model.yaml: is a document (model/2), but log.mcap is not; write the document first",
    )
