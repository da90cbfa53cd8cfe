"""`frictool identify` as a user meets it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from frictool.documents.model import Model
from frictool.documents.registry import load
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, EMPS, ROOT
from studies.rigs.sample_logs import LOGS, SEED, TRUTH, csv
from tests.support.command_line import refused
from tests.support.measured_data import data
from tests.support.short_logs import first_lines, first_part

SINES, RAMP = ROOT / "sample_logs" / "sines.csv", ROOT / "sample_logs" / "ramp.csv"


@pytest.mark.parametrize("name", list(LOGS))
def test_sample_logs_are_what_their_seed_makes(name: str) -> None:
    assert (ROOT / "sample_logs" / f"{name}.csv").read_bytes() == csv(LOGS[name](SEED)).encode()


def test_json_and_model_of_the_sample_logs(tmp_path: Path) -> None:
    target = tmp_path / "model.yaml"
    result = run("identify", SINES, RAMP, "--bench", CLUTCH, "-o", target, "--json")
    assert result.code == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["method"] == "sines"
    assert set(found["parameters"]) == {"inertia", "viscous", "coulomb", "offset", "breakaway"}
    for name, interval in found["parameters"].items():
        assert interval["low"] <= getattr(TRUTH, name) <= interval["high"], name
    assert found["parameters"]["viscous"]["unit"] == "N m s/rad"
    assert found["not_identified"] == {}
    assert 0.0 < found["force_error"] < 0.01
    assert 1.0 < found["condition"] < 20.0
    documented = (ROOT / "docs/formats.md").read_text().partition("### `identify --json`")[2]
    documented = documented.partition("\n## ")[0]
    ramp = found["ramp"]
    keys = [*found, *(f"ramp.{name}" for name in ramp)]
    keys += [f"ramp.fall.{name}" for name in ramp["fall"]]
    assert [key for key in keys if f"`{key}`" not in documented] == []
    assert found["logs"] == [
        {"name": "sines.csv", "kind": "sliding"},
        {"name": "ramp.csv", "kind": "ramp"},
    ]
    model = load(target, Model)
    assert model.parameters.inertia.source == "identified"
    assert model.parameters.coulomb.value == found["parameters"]["coulomb"]["value"]
    assert model.fit is not None
    assert model.fit.force_error == found["force_error"]
    assert [entry.name for entry in model.provenance.inputs] == [
        "sines.csv",
        "ramp.csv",
        "bench.yaml",
    ]


def test_help_opens_with_an_example_and_says_when_each_method_is_right() -> None:
    shown = run("identify", "--help").stdout
    assert shown.index("Example:") < shown.index("Options:")
    for words in (
        "least-squares",
        "inverse-dynamic",
        "any encoder, stick and backlash",
        "a fine encoder, no backlash",
    ):
        assert words in shown


def test_emps_by_the_published_pipeline(tmp_path: Path) -> None:
    log = data("emps", "DATA_EMPS.mat")
    result = run(
        "identify",
        log,
        "--bench",
        EMPS,
        "--method",
        "inverse-dynamic",
        "--json",
        "-o",
        tmp_path / "model.yaml",
    )
    assert result.code == 0, result.stderr
    found = json.loads(result.stdout)["parameters"]
    assert found["inertia"]["value"] == pytest.approx(95.1089, rel=2e-3)
    assert found["viscous"]["value"] == pytest.approx(203.5034, rel=1e-2)
    assert found["coulomb"]["value"] == pytest.approx(20.3935, rel=1e-2)
    assert found["offset"]["value"] == pytest.approx(-3.1648, rel=2e-2)
    assert load(tmp_path / "model.yaml", Model).parameters.inertia.source == "identified"


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first part of the sample log of strokes."""
    path = tmp_path_factory.mktemp("short") / "sines.csv"
    path.write_text(first_part("sines.csv"))
    return path


def changed(folder: Path, old: str, new: str) -> Path:
    """The clutch's bench with one text replaced."""
    text = CLUTCH.read_text()
    assert old in text
    path = folder / "bench.yaml"
    path.write_text(text.replace(old, new))
    return path


def test_a_canonical_log_is_compared_with_the_bench(tmp_path: Path, short: Path) -> None:
    log, target = tmp_path / "sines.mcap", tmp_path / "model.yaml"
    assert run("ingest", short, "--bench", CLUTCH, "-o", log).code == 0
    refused(
        run("identify", log, "--bench", EMPS, "-o", target),
        3,
        "/axis.position is in 'rad'",
        "linear",
    )
    slow = changed(tmp_path, "sample_period_s: 0.001", "sample_period_s: 0.1")
    refused(
        run("identify", log, "--bench", slow, "-o", target),
        3,
        "the period is 0.001 s",
        "a factor of at most 30",
    )
    assert not target.exists()


def test_a_changed_constant_is_applied_to_raw_and_canonical_logs_alike(
    tmp_path: Path, short: Path
) -> None:
    log = tmp_path / "sines.mcap"
    assert run("ingest", short, "--bench", CLUTCH, "-o", log).code == 0
    warm = changed(tmp_path, "{value: 13.4e-3, low", "{value: 12.9e-3, low")
    options = ("--bench", warm, "--method", "least-squares", "--json")
    raw, canonical = (run("identify", path, *options) for path in (short, log))
    assert json.loads(raw.stdout)["parameters"] == json.loads(canonical.stdout)["parameters"]
    assert json.loads(raw.stdout)["parameters"]["coulomb"]["value"] == pytest.approx(
        TRUTH.coulomb * 12.9 / 13.4, rel=2e-3
    )
    assert raw.stderr == ""
    assert canonical.stderr == (
        "warning: sines.mcap: effort is recomputed from current with "
        "actuator.constant of bench.yaml, "
        "0.0129 N m/A; "
        "the effort in the log was computed with 0.0134 N m/A\n"
    )


def test_a_still_log_is_the_answer_no(tmp_path: Path) -> None:
    log, target = tmp_path / "still.csv", tmp_path / "model.yaml"
    rows = "".join(f"{k / 1000:.3f},5,0.1\n" for k in range(2000))
    log.write_text("time [s],encoder [count],current [A]\n" + rows)
    refused(
        run("identify", log, "--bench", CLUTCH, "-o", target),
        1,
        "the axis never moves by more than one encoder count; record longer strokes\n",
    )
    assert not target.exists()


@pytest.mark.parametrize("rows", [20, 2000])
def test_json_of_the_answer_no_says_why(tmp_path: Path, rows: int) -> None:
    log, target = tmp_path / "still.csv", tmp_path / "model.yaml"
    log.write_text(
        "time [s],encoder [count],current [A]\n"
        + "".join(f"{k / 1000:.3f},5,0.1\n" for k in range(rows))
    )
    result = run("identify", log, "--bench", CLUTCH, "-o", target, "--json")
    assert result.code == 1
    assert result.stderr.startswith("error: ")
    assert result.stderr.count("\n") == 1
    found = json.loads(result.stdout)
    assert found["parameters"] == {}
    assert found["force_error"] is None
    assert set(found["not_identified"]) == {"inertia", "viscous", "coulomb", "offset", "breakaway"}
    assert all(found["not_identified"].values())
    assert not target.exists()


def test_the_same_log_twice_is_refused(tmp_path: Path, short: Path) -> None:
    log, target = tmp_path / "sines.mcap", tmp_path / "model.yaml"
    assert run("ingest", short, "--bench", CLUTCH, "-o", log).code == 0
    for twice in (
        (short, short),
        (short, log),
        (log, "--ramp", short),
        ("--loops", short, "--loops", log),
        (log, "--loops", short),
    ):
        refused(run("identify", *twice, "--bench", CLUTCH, "-o", target), 3, "is the same log as")
    assert not target.exists()


def test_one_absurd_position_is_named(tmp_path: Path) -> None:
    rows, log = SINES.read_text().splitlines(), tmp_path / "log.csv"
    time, _, current = rows[1000].split(",")
    rows[1000] = f"{time},1e30,{current}"
    log.write_text("\n".join(rows) + "\n")
    refused(run("identify", log, "--bench", CLUTCH), 3, "log.csv:1001:", "2^53 counts")


def test_a_counter_that_wraps_is_refused_until_the_bench_says_so(
    tmp_path: Path, short: Path
) -> None:
    header, *rows = short.read_text().splitlines()
    log = tmp_path / "log.csv"
    cells = [row.split(",") for row in rows]
    log.write_text(
        "\n".join(
            [header, *(f"{time},{int(count) % 256},{current}" for time, count, current in cells)]
        )
        + "\n"
    )
    refused(
        run("identify", log, "--bench", CLUTCH),
        3,
        "the position wraps",
        "under encoder in bench.yaml: wrap_bits: 8",
    )
    aware = changed(
        tmp_path, "counts_per_revolution: 56 ", "counts_per_revolution: 56\n  wrap_bits: 8 "
    )
    options = ("--method", "least-squares", "--json")
    result = run("identify", log, "--bench", aware, *options)
    assert result.stderr == ""
    plain = run("identify", short, "--bench", CLUTCH, *options)
    assert json.loads(result.stdout)["parameters"] == json.loads(plain.stdout)["parameters"]


@pytest.mark.parametrize(
    ("unit", "factor", "period", "line"),
    [
        ("rad", 2.0 * math.pi / 56, 25.0, "wrap: {value: 25, unit: rad}"),
        pytest.param(
            *("rad", 2.0 * math.pi / 56, 8.0, "wrap: {value: 8, unit: rad}"),
            marks=pytest.mark.accept,
        ),
        ("deg", 360.0 / 56, 360.0, "wrap: {value: 360, unit: deg}"),
    ],
)
def test_the_advice_for_a_position_that_wraps_repairs_the_log(
    unit: str, factor: float, period: float, line: str, tmp_path: Path
) -> None:
    """The parameters of the wrapped log are those of the same numbers without the wraps."""
    header, *rows = first_lines("sines.csv")
    cells = [row.split(",") for row in rows]
    bench = changed(tmp_path, "column: encoder, unit: count", f"column: encoder, unit: {unit}")
    log, found = tmp_path / "log.csv", {}
    for name, position in (
        ("whole", lambda value: value),
        ("wrapped", lambda value: (value + period / 2) % period - period / 2),
    ):
        rows = [
            f"{time},{position(int(count) * factor)!r},{current}" for time, count, current in cells
        ]
        log.write_text("\n".join([header.replace("count", unit), *rows]) + "\n")
        if name == "wrapped":
            refused(
                run("identify", log, "--bench", bench),
                3,
                "the position wraps",
                f"under encoder in bench.yaml: {line}\n",
            )
            bench.write_text(
                bench.read_text().replace(
                    "counts_per_revolution: 56 ", f"counts_per_revolution: 56\n  {line} "
                )
            )
        result = run("identify", log, "--bench", bench, "--method", "least-squares", "--json")
        assert result.code == 0, result.stderr
        found[name] = json.loads(result.stdout)["parameters"]
    for name, one in found["whole"].items():
        assert found["wrapped"][name]["value"] == pytest.approx(one["value"], rel=1e-6)


def test_a_jump_is_told_once(tmp_path: Path) -> None:
    header, *rows = first_lines("sines.csv")
    log = tmp_path / "log.csv"
    cells = [row.split(",") for row in rows]
    jumped = (
        f"{time},{int(count) + 3000 * (k > 9000)},{current}"
        for k, (time, count, current) in enumerate(cells)
    )
    log.write_text("\n".join([header, *jumped]) + "\n")
    assert (
        run("identify", log, "--bench", CLUTCH).stderr.count("the position jumps once, at 9.001 s")
        == 1
    )
    assert (
        run("ingest", log, "--bench", CLUTCH, "-o", tmp_path / "log.mcap").stderr.count(
            "the position jumps once"
        )
        == 1
    )
    assert (
        run("identify", tmp_path / "log.mcap", "--bench", CLUTCH).stderr.count(
            "the position jumps once"
        )
        == 1
    )


def test_a_missing_channel_is_a_wrong_file(tmp_path: Path) -> None:
    log, target = tmp_path / "log.csv", tmp_path / "model.yaml"
    log.write_text(
        "time [s],encoder [count]\n" + "".join(f"{k / 1000:.3f},{k}\n" for k in range(2000))
    )
    refused(run("identify", log, "--bench", CLUTCH, "-o", target), 3, "current")
    assert not target.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--window", "20"), "even"),
        (("--method", "recursive", "--forgetting", "1.01"), "0.0<x<=1.0"),  # would grow
        (("--cutoff-hz", "50"), "inverse-dynamic"),
        (("--method", "inverse-dynamic", "--window", "21"), "least-squares"),
        (("--confidence", "1.5"), "confidence"),
    ],
)
def test_options_that_do_not_fit(options: tuple[str, ...], words: str) -> None:
    result = run("identify", SINES, "--bench", CLUTCH, *options)
    assert result.code == 2
    assert words in result.stderr


def test_without_logs() -> None:
    assert run("identify", "--bench", CLUTCH).code == 2


def test_options_change_the_result(short: Path) -> None:
    line = ("identify", short, "--bench", CLUTCH, "--method", "least-squares", "--json")
    plain, wide, narrow = (
        json.loads(run(*line, *options).stdout)
        for options in ((), ("--confidence", "0.99"), ("--window", "21"))
    )
    assert wide["parameters"]["coulomb"]["high"] > plain["parameters"]["coulomb"]["high"]
    assert narrow["details"]["window"] == 21


def test_options_of_the_pipeline_change_its_result() -> None:
    line = (
        "identify",
        data("emps", "DATA_EMPS.mat"),
        "--bench",
        EMPS,
        "--method",
        "inverse-dynamic",
        "--json",
    )
    plain, other = (
        json.loads(run(*line, *options).stdout)
        for options in ((), ("--cutoff-hz", "30", "--decimate", "5"))
    )
    assert plain["samples"] * 2 == pytest.approx(other["samples"], abs=2)
    assert plain["parameters"]["viscous"]["value"] != other["parameters"]["viscous"]["value"]


def test_the_pipeline_gives_nothing_where_there_is_a_backlash(tmp_path: Path) -> None:
    target = tmp_path / "model.yaml"
    result = run("identify", SINES, "--bench", CLUTCH, "--method", "inverse-dynamic", "-o", target)
    refused(result, 1, "backlash", "use least-squares")
    assert not target.exists()
