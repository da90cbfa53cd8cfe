"""Logs whose position or drive is negated: the command refuses them, whatever the method."""

from __future__ import annotations

import csv as table
import functools
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.identify.fit_result import PARAMETERS
from frictool.identify.identification import NothingIdentified, identify_records
from frictool.identify.methods import DEFAULT, METHODS, IdentificationSettings
from frictool.identify.orientation import reversed_sign
from frictool.plant.axis import AxisParameters
from frictool.presentation.line_breaking import LONGEST
from studies.command_line import CommandResult, run
from studies.rigs.identification_rigs import CLUTCH, ROOT, clutch, record
from studies.rigs.sample_logs import ramp, sines
from tests.support.driven_axes import driven, plain_axis
from tests.support.linear_axis import linear_axis, linear_bench
from tests.support.loaded_axis import loaded_axis
from tests.support.short_logs import first_lines, first_part

SAMPLES = ROOT / "sample_logs"
CONFIG = ROOT / "configs" / "clutch"
ENCODER, CURRENT = 1, 2  # columns of the sample logs


def good_sines(folder: Path) -> Path:
    """The first part of the sample log of strokes."""
    path = folder / "good_sines.csv"
    path.write_text(first_part("sines.csv"))
    return path


def negated(folder: Path, log: str, column: int) -> Path:
    """The first part of a sample log with one column negated."""
    path = folder / f"negated_{log}"
    path.write_text(negated_text(log, column))
    return path


@functools.cache
def negated_text(log: str, column: int) -> str:
    head, *rows = table.reader(first_lines(log))
    text = io.StringIO()
    writer = table.writer(text)
    writer.writerow(head)
    writer.writerows(
        [*row[:column], f"{-float(row[column]):g}", *row[column + 1 :]] for row in rows
    )
    return text.getvalue()


def unmade(result: CommandResult, target: Path) -> None:
    """Asserts exit code 4 with one error line that names the signs, and that nothing was
    written."""
    assert result.code == 4, result.stderr
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1
    assert "position and drive have opposite signs" in errors[0]
    assert "set encoder.direction: -1 in the bench (found: 1)" in errors[0]
    assert not target.exists()


@pytest.mark.parametrize(
    ("method", "column"),
    [
        ("auto", ENCODER),
        ("least-squares", ENCODER),
        pytest.param("auto", CURRENT, marks=pytest.mark.accept),
        *(
            pytest.param(method, ENCODER, marks=pytest.mark.accept)
            for method in ("sines", "weak", "ordinary")
        ),
    ],
)
def test_a_negated_log_is_no_solution(tmp_path: Path, column: int, method: str) -> None:
    target = tmp_path / "model.yaml"
    log = negated(tmp_path, "sines.csv", column)
    unmade(run("identify", log, "--bench", CLUTCH, "--method", method, "-o", target), target)


@pytest.mark.parametrize("options", [("--method", "least-squares"), ("--ramp",)])
def test_a_negated_ramp_is_no_solution(tmp_path: Path, options: tuple[str, ...]) -> None:
    target = tmp_path / "model.yaml"
    unmade(
        run(
            "identify",
            *options,
            negated(tmp_path, "ramp.csv", ENCODER),
            "--bench",
            CLUTCH,
            "-o",
            target,
        ),
        target,
    )


def test_one_negated_log_of_two_is_named(tmp_path: Path) -> None:
    target = tmp_path / "model.yaml"
    wrong = negated(tmp_path, "sines.csv", ENCODER)
    ramps = tmp_path / "ramp.csv"
    ramps.write_text(first_part("ramp.csv"))
    method = ("--method", "least-squares")
    result = run("identify", wrong, ramps, "--bench", CLUTCH, *method, "-o", target)
    unmade(result, target)
    assert "negated_sines.csv: position and drive" in result.stderr


@pytest.mark.parametrize(
    ("back_emf", "reason"),
    [
        (0.0, "the drive was off"),
        (-5e-4, "another force moves the axis"),
        (-2e-3, "another force moves the axis"),
    ],
)
def test_a_drive_that_cannot_overcome_friction_is_no_reversed_sign(
    tmp_path: Path, back_emf: float, reason: str
) -> None:
    """A hand moves the axis; the motor is off, or it brakes by its back-EMF through a resistor."""
    target, log = tmp_path / "model.yaml", tmp_path / "hand.csv"
    head, *rows = table.reader(first_lines("sines.csv"))
    position = np.array([float(row[ENCODER]) for row in rows])
    velocity = np.gradient(position, 1e-3) * 2.0 * np.pi / 56.0
    smooth = np.convolve(velocity, np.full(101, 1.0 / 101.0), "same")
    noise = 0.05 * np.random.default_rng(4).standard_normal(position.size)
    for row, current in zip(rows, noise + back_emf * smooth, strict=True):
        row[CURRENT] = f"{current:.4f}"
    with log.open("w", newline="") as file:
        table.writer(file).writerows([head, *rows])
    method = ("--method", "least-squares")
    result = run("identify", log, "--bench", CLUTCH, *method, "-o", target)
    assert result.code in (1, 4)
    assert reason in result.stderr.splitlines()[-1]
    assert "encoder.direction" not in result.stderr.splitlines()[-1]
    assert not target.exists()


COUNTED = "{column: encoder, unit: count}"
POSITIONS = {  # text of columns.position, with the encoder's direction
    "counts": (COUNTED, 1),
    "counts with a direction": (COUNTED, -1),
    "degrees": ("{column: encoder, unit: deg, scale: 6.428571428571429}", 1),
    "degrees with an idle direction": (
        "{column: encoder, unit: deg, scale: 6.428571428571429}",
        -1,
    ),
    "negative degrees": ("{column: encoder, unit: deg, scale: -6.428571428571429}", 1),
}


@pytest.fixture(scope="module")
def requested(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, float]]:
    """The parameters of the log whose signs are right, by name."""
    log = good_sines(tmp_path_factory.mktemp("good"))
    good = run("identify", log, "--bench", CLUTCH, "--method", "least-squares", "--json")
    parameters: dict[str, dict[str, float]] = json.loads(good.stdout)["parameters"]
    return parameters


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(kind, marks=pytest.mark.accept) if kind == "degrees" else kind
        for kind in POSITIONS
    ],
)
def test_the_bench_that_the_message_asks_for_mends_it(
    tmp_path: Path, kind: str, requested: dict[str, dict[str, float]]
) -> None:
    """The advice is followed once, whatever the unit of the position."""
    column, direction = POSITIONS[kind]
    text = CLUTCH.read_text().replace(COUNTED, column)
    text = text.replace("counts_per_rev", f"direction: {direction}\n  counts_per_rev")
    bench = tmp_path / "bench.yaml"
    bench.write_text(text)
    sign = direction if column == COUNTED else -1 if "-6" in column else 1
    good, bad = good_sines(tmp_path), negated(tmp_path, "sines.csv", ENCODER)
    options = ("--bench", bench, "--method", "least-squares", "--json")
    result = run("identify", bad if sign == 1 else good, *options)
    assert result.code == 4
    idle = column != COUNTED and direction == -1
    assert ("encoder.direction: -1 has no effect" in result.stderr) == idle
    advice = re.search(
        r"set (encoder|columns.position).(\w+): (\S+) in the bench",
        result.stderr.rpartition("error: ")[2],
    )
    assert advice is not None, result.stderr
    _, key, wanted = advice.groups()
    written = f"{key}: {wanted.removeprefix('-') if wanted.startswith('-') else '-' + wanted}"
    if written not in text:
        text = text.replace("unit: deg", f"unit: deg, {written}")
    bench.write_text(text.replace(written, f"{key}: {wanted}"))
    mended = run("identify", bad if sign == 1 else good, *options)
    assert mended.code == 0, mended.stderr
    if (column, direction) == (COUNTED, 1):
        assert json.loads(mended.stdout)["parameters"] == requested
    for name, one in requested.items():
        found = json.loads(mended.stdout)["parameters"][name]
        # the sign of the offset depends on the positive direction
        assert abs(found["value"]) == pytest.approx(abs(one["value"]), rel=1e-6)


@pytest.mark.parametrize(("follows", "column"), [(1.0, "current"), (-1.0, "position")])
def test_the_reference_decides_which_column_is_reversed(follows: float, column: str) -> None:
    _, log = linear_axis(3)
    record = replace(log, reference=follows * log.position, effort=-log.effort)
    message = reversed_sign([record], linear_bench(), IdentificationSettings())
    assert f"set columns.{column}.scale: -1 in the bench" in str(message)


def test_a_model_of_the_benchs_values_says_so_and_is_refused_by_synth(tmp_path: Path) -> None:
    target, controller = tmp_path / "model.yaml", tmp_path / "controller.yaml"
    log = negated(tmp_path, "sines.csv", CURRENT)
    options = ("--bench", CLUTCH, "--method", "least-squares", "--keep-bench-values")
    kept = run("identify", log, *options, "-o", target)
    assert kept.code == 0, kept.stderr
    assert "warning: the model contains only the bench's values" in kept.stderr
    model = load(target, Model)
    assert model.bench_values_only is not None
    assert "opposite signs" in model.bench_values_only
    assert {name: getattr(model.parameters, name).source for name in PARAMETERS} == {
        **dict.fromkeys(("inertia", "viscous", "coulomb"), "bench"),
        **dict.fromkeys(("offset", "breakaway"), "assumed"),
    }
    design = CONFIG / "designs" / "speed.yaml"
    refused = run(
        "synth", target, "--spec", CONFIG / "spec.yaml", "--design", design, "-o", controller
    )
    assert refused.code == 4
    assert f"error: {target}:" in refused.stderr
    assert ": bench_values_only: " in refused.stderr
    lines = (kept.stderr + refused.stderr).replace(str(tmp_path), "").splitlines()
    assert max(map(len, lines)) <= LONGEST
    assert not controller.exists()


def test_the_option_changes_no_model_that_is_identified(tmp_path: Path) -> None:
    log, target = good_sines(tmp_path), tmp_path / "model.yaml"
    options = ("--bench", CLUTCH, "--method", "least-squares", "--keep-bench-values")
    assert run("identify", log, *options, "-o", target).code == 0
    assert load(target, Model).bench_values_only is None


def test_each_ends_with_the_same_code_and_a_row_with_the_reason(tmp_path: Path) -> None:
    negated(tmp_path, "sines.csv", ENCODER)
    still = tmp_path / "still.csv"
    still.write_text(
        "time [s],encoder [count],current [A]\n"
        + "".join(f"{k / 1000:.3f},5,0.1\n" for k in range(2000))
    )
    target = tmp_path / "models"
    result = run("identify", "--each", "log", tmp_path, "--bench", CLUTCH, "-o", target)
    assert result.code == 4, result.stderr
    with (target / "parameters.csv").open() as stream:
        rows = {row["file"]: row for row in table.DictReader(stream)}
    assert rows["negated_sines.csv"]["model"] == ""
    assert "opposite signs" in rows["negated_sines.csv"]["reason"]
    alone = run(
        "identify",
        "--each",
        "log",
        tmp_path,
        "--bench",
        CLUTCH,
        "--keep-bench-values",
        "-o",
        target,
    )
    assert alone.code == 2
    assert "--keep-bench-values does not work with --each" in alone.stderr


def test_a_fit_that_gives_an_offset_alone_is_no_solution() -> None:
    """Every friction is known better by the bench than the log tells it."""
    known = {
        "inertia": Quantity(1.32e-5, 1.3199e-5, 1.3201e-5, "kg m^2"),
        "viscous": Quantity(3.81e-4, 3.80999e-4, 3.81001e-4, "N m s/rad"),
        "coulomb": Quantity(0.099, 0.098999, 0.099001, "N m"),
    }
    bench = clutch()
    bench = msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **known)
    )
    with pytest.raises(NothingIdentified) as raised:
        identify_records([record(sines(1))], [], bench, "least-squares", IdentificationSettings())
    assert "neither inertia nor friction" in raised.value.result.refused["offset"]
    assert raised.value.exit_code == 4
    assert raised.value.result.identified == {}


def test_a_breakaway_alone_is_friction() -> None:
    assert list(
        identify_records(
            [], [record(ramp(1))], clutch(), DEFAULT, IdentificationSettings()
        ).identified
    ) == ["breakaway"]


SLOW = {
    "output-error",
    "inverse-dynamic",
    "stribeck-curve",
    "friction-force",
    "instrumental",
}  # of their own kinds of log, or slow


QUICK = ("auto", "least-squares", "weak", "sines")


@pytest.mark.parametrize(
    "method",
    [
        name if name in QUICK else pytest.param(name, marks=pytest.mark.accept)
        for name in METHODS
        if name not in SLOW
    ],
)
def test_a_fine_encoder_is_judged_as_a_coarse_one(method: str) -> None:
    _, log = linear_axis(3)
    with pytest.raises(NothingIdentified, match="opposite signs") as raised:
        identify_records(
            [replace(log, effort=-log.effort)], [], linear_bench(), method, IdentificationSettings()
        )
    assert raised.value.exit_code == 4


AXES = {
    "weight": plain_axis(offset=6.0),
    "light": plain_axis(viscous=0.5, coulomb=0.1, breakaway=0.1, offset=0.0),
    "dry": plain_axis(inertia=0.2),
}


@pytest.mark.parametrize("axis", AXES.values(), ids=list(AXES))
def test_a_weight_a_light_axis_and_a_dry_one(axis: AxisParameters) -> None:
    log = driven(axis)
    assert reversed_sign([log], linear_bench(), IdentificationSettings()) is None
    assert (
        reversed_sign(
            [replace(log, position=-log.position)], linear_bench(), IdentificationSettings()
        )
        is not None
    )


@pytest.mark.parametrize("late", [-3, 3])
def test_a_drive_logged_early_or_late_is_not_a_reversed_one(late: int) -> None:
    """On a light axis three samples of delay change the sign of the small friction, and not that of
    the inertia."""
    log = driven(AXES["light"])
    assert (
        reversed_sign(
            [replace(log, effort=np.roll(log.effort, late))],
            linear_bench(),
            IdentificationSettings(),
        )
        is None
    )


@pytest.mark.parametrize("kind", ["spring", "gravity"])
def test_a_load_that_the_bench_names_does_not_hide_the_sign(kind: str) -> None:
    axis = loaded_axis(2, kind)
    assert reversed_sign([axis.record], axis.bench, IdentificationSettings()) is None
    assert (
        reversed_sign(
            [replace(axis.record, effort=-axis.record.effort)], axis.bench, IdentificationSettings()
        )
        is not None
    )
