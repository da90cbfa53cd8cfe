"""`frictool init`: documents that load, columns guessed from a log, a Makefile that chains, nothing
overwritten."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.bench import Bench
from frictool.documents.design import Design
from frictool.documents.registry import DOCUMENTS, load, same_axis
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.documents.starting_documents import FILES, StartingRig, quoted, starting_documents
from frictool.logs.log_reader import read_log
from studies.command_line import run
from tests.support.command_line import refused

ROOT = Path(__file__).parents[2]
LOG = ROOT / "sample_logs/sines.csv"
KINDS = {
    "bench.yaml": Bench,
    "spec.yaml": Spec,
    "designs/automatic.yaml": Design,
    "scenarios/steps.yaml": Scenario,
}


def loaded(folder: Path) -> dict[Path, object]:
    """Every document of the folder, read strictly."""
    return {folder / name: load(folder / name, kind) for name, kind in KINDS.items()}


def bench_of(folder: Path) -> Bench:
    return load(folder / "bench.yaml", Bench)


@pytest.mark.parametrize("axis", ["rotary", "linear"])
def test_documents_load_and_agree(axis: str, tmp_path: Path) -> None:
    folder = tmp_path / "deep/my rig"
    result = run("init", folder, "--axis", axis)
    assert result.code == 0
    assert sorted(
        str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()
    ) == sorted(FILES)
    documents = loaded(folder)
    same_axis(documents)
    assert bench_of(folder).axis == axis
    assert bench_of(folder).name == "my rig"
    assert {path.name for path in (tmp_path / "deep").iterdir()} == {"my rig"}
    assert "guessed" not in (folder / "bench.yaml").read_text()


def test_a_log_fills_in_what_it_tells(tmp_path: Path) -> None:
    folder = tmp_path / "rig"
    result = run("init", folder, "--from", LOG, "--axis", "rotary", "--json")
    assert result.code == 0
    said = json.loads(result.stdout)
    assert said["files"] == list(FILES)
    assert (said["axis"], said["sample_period_s"], said["log"]) == ("rotary", 0.001, "sines.csv")
    bench = bench_of(folder)
    assert {channel: (c.column, c.unit) for channel, c in bench.columns.items()} == {
        "time": ("time", "s"),
        "position": ("encoder", "count"),
        "current": ("current", "A"),
    }
    lines = (folder / "bench.yaml").read_text().splitlines()
    for key in ("sample_period_s:", "  drive:", "  time:", "  position:", "  current:"):
        (line,) = [line for line in lines if line.startswith(key)]
        assert "# guessed from sines.csv: check" in line
    assert read_log(LOG, bench).main.time.size == len(LOG.read_text().splitlines()) - 1


def test_a_matlab_file_gives_names_and_period_and_asks_for_units(tmp_path: Path) -> None:
    """A MATLAB file has no units: the time's follows from the interval, the others are asked, and
    the bench waits for them."""
    log, rig = tmp_path / "bench.mat", tmp_path / "rig"
    k = np.arange(400)
    position = 2e-6 * np.rint(1e4 * np.sin(k / 30))
    values = {
        "t": k * 2e-3,
        "qm": position,
        "qg": position + 1e-3,
        "vir": np.cos(k / 30),
        "spare": k % 7 + 0.5,
        "gain": 3.0,
    }
    scipy.io.savemat(log, values)
    made = run("init", rig, "--from", log, "--axis", "linear")
    assert made.code == 0
    assert (
        "  columns.position: fill in unit m, mm or count: the log states no unit of 'qm'; its "
        "steps are multiples of 2e-06\n" in made.stdout
    )
    document = rig / "bench.yaml"
    assert '  position: {column: qm, unit: "?"}' in document.read_text()
    refused(
        run("info", log, "--bench", document),
        3,
        "bench.yaml:",
        "columns.position: found unit '?'",
        "fill it in",
    )
    for name, unit in (("qm", "m"), ("qg", "m"), ("vir", "V")):
        document.write_text(
            document.read_text().replace(
                f'column: {name}, unit: "?"', f"column: {name}, unit: {unit}"
            )
        )
    bench = bench_of(rig)
    assert {channel: (c.column, c.unit) for channel, c in bench.columns.items()} == {
        "time": ("t", "s"),
        "position": ("qm", "m"),
        "reference": ("qg", "m"),
        "voltage": ("vir", "V"),
    }
    assert (bench.sample_period_s, bench.actuator.drive) == (0.002, "voltage")
    assert "# spare" in document.read_text()
    same_axis(loaded(rig))
    np.testing.assert_allclose(read_log(log, bench).main.signals["position"], position)


def test_an_ingested_log_is_as_good(tmp_path: Path) -> None:
    assert (
        run(
            "ingest",
            LOG,
            "--bench",
            ROOT / "configs/clutch/bench.yaml",
            "-o",
            tmp_path / "sines.mcap",
        ).code
        == 0
    )
    assert run("init", tmp_path / "rig", "--from", tmp_path / "sines.mcap").code == 0
    bench = bench_of(tmp_path / "rig")
    assert (bench.axis, bench.sample_period_s, bench.actuator.drive) == ("rotary", 0.001, "current")
    assert bench.encoder.resolution == pytest.approx(2 * np.pi / 56, rel=1e-5)
    assert "LOGS := ../sines.mcap\n" in (tmp_path / "rig/Makefile").read_text()


@pytest.mark.parametrize(
    ("header", "axis", "columns"),
    [
        (
            "t [ms],shaft angle [deg],I_q [mA]",
            "rotary",
            {"time": "ms", "position": "deg", "current": "mA"},
        ),
        (
            "Time [s];Position reference [mm];Position [mm];Speed [mm/s]",
            "linear",
            {"time": "s", "reference": "mm", "position": "mm", "velocity": "mm/s"},
        ),
        ("t,u,theta", "rotary", {"time": "?", "voltage": "?", "position": "?"}),
        ("t_us,volts,theta_count", "rotary", {"time": "us", "voltage": "V", "position": "count"}),
        ("when [s],what [rad],why [A]", "rotary", {"time": "s", "position": "rad", "current": "A"}),
        ("a,b,c [deg]", "rotary", {"position": "deg"}),
        ("t,displacement,i", "linear", {"time": "?", "position": "?", "current": "?"}),
        (
            "t [s],encoder,omega [rad/s]",
            "rotary",
            {"time": "s", "position": "count", "velocity": "rad/s"},
        ),
    ],
)
def test_units_are_believed_before_names_and_asked_where_nothing_tells(
    header: str, axis: str, columns: dict[str, str], tmp_path: Path
) -> None:
    log = tmp_path / "bench.csv"
    mark = ";" if ";" in header else ","
    rows = [
        mark.join(
            str(value) for value in (k, *(k % 5 + shift for shift in range(header.count(mark))))
        )
        for k in range(20)
    ]
    log.write_text("\n".join([header, *rows]) + "\n")
    made = run("init", tmp_path / "rig", "--from", log, "--json")
    assert made.code == 0
    facts = json.loads(made.stdout)
    assert facts["axis"] == axis
    assert {channel: unit for channel, (_, unit) in facts["columns"].items()} == columns
    assert set(facts["questions"]) == {channel for channel, unit in columns.items() if unit == "?"}


def test_a_period_that_no_bench_has_is_not_guessed(tmp_path: Path) -> None:
    """Time in microseconds under the unit of seconds: the document loads all the same, with the
    example's period."""
    log = tmp_path / "bench.csv"
    log.write_text(
        "t [s],theta [rad],u [V]\n" + "".join(f"{1000 * k},{k % 7},{k % 3}\n" for k in range(50))
    )
    assert run("init", tmp_path / "rig", "--from", log).code == 0
    assert bench_of(tmp_path / "rig").sample_period_s == 0.001


@pytest.mark.parametrize(
    "header",
    [
        "a,b,c",
        "t,qm,vir",
        "time [s],encoder [count],current [A]",
        "time [s],x,duty [%]",
        "t [s],x [mm],motor [rpm]",
        "t,angle,displacement",
    ],
)
def test_an_axis_that_the_log_does_not_tell_has_to_be_given(header: str, tmp_path: Path) -> None:
    """No unit, no name, only counts and per cents, or both kinds: a guess would carry the wrong
    examples to a verdict."""
    log = tmp_path / "bench.csv"
    log.write_text("\n".join([header, *(f"{k},{k % 5},{k % 3}" for k in range(20))]) + "\n")
    refused(
        run("init", tmp_path / "rig", "--from", log),
        3,
        f"{log}: ",
        "shows if the axis is rotary or linear; give --axis rotary (rad, N m) or --axis linear",
    )
    assert not (tmp_path / "rig").exists()
    for axis in ("rotary", "linear"):
        assert run("init", tmp_path / axis, "--from", log, "--axis", axis).code == 0
        assert bench_of(tmp_path / axis).axis == axis
        (line,) = [
            line
            for line in (tmp_path / axis / "bench.yaml").read_text().splitlines()
            if line.startswith("axis:")
        ]
        assert "guessed" not in line
        assert "example" not in line


def marked(text: str) -> set[str]:
    """The last name of each key that is marked as an example."""
    return {
        line.split(":")[0].strip() for line in text.splitlines() if "# example: replace" in line
    }


@pytest.mark.parametrize(
    ("axis", "log"),
    [(None, None), ("rotary", None), ("linear", None), ("rotary", LOG), ("linear", LOG)],
)
def test_every_value_that_nobody_gave_is_marked_and_told(
    axis: str | None, log: Path | None, tmp_path: Path
) -> None:
    folder = tmp_path / "rig"
    words = [*([] if axis is None else ["--axis", axis]), *([] if log is None else ["--from", log])]
    told = run("init", folder, *words).stdout
    view = json.loads(run("init", tmp_path / "again/rig", *words, "--json").stdout)["examples"]
    assert set(view) == {"bench.yaml", "spec.yaml", "scenarios/steps.yaml"}
    for name, keys in view.items():
        assert {key.rpartition(".")[2] for key in keys} == marked((folder / name).read_text())
        assert f"{name}: {', '.join(keys)} " in " ".join([*told.split(), ""])
        for key in keys:
            assert _at(yaml.safe_load((folder / name).read_text()), key) is not None
    ours = {
        "actuator.constant",
        "actuator.limit",
        "mechanics.inertia",
        "mechanics.travel",
        "delay_samples",
    }
    assert ours <= set(view["bench.yaml"])
    assert ("axis" in view["bench.yaml"]) == (axis is None)
    assert (
        ("sample_period_s" in view["bench.yaml"])
        == ("columns.time" in view["bench.yaml"])
        == (log is None)
    )
    assert set(view["spec.yaml"]) == {
        "response_time_95_s",
        "overshoot_percent",
        "static_error",
        "oscillations",
        "modulus_margin",
        "drive_peak",
    }


def _at(document: dict[str, object], key: str) -> object:
    """The value at a dotted key; KeyError where there is none."""
    value: object = document
    for name in key.split("."):
        assert isinstance(value, dict)
        value = value[name]
    return value


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "designs").mkdir()
    (tmp_path / "designs/automatic.yaml").write_text("mine")
    (tmp_path / "spec.yaml").write_text("mine")
    words = ("spec.yaml", "designs/automatic.yaml", "nothing is overwritten")
    refused(run("init", tmp_path), 3, *words)
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")) == [
        "designs",
        "designs/automatic.yaml",
        "spec.yaml",
    ]
    assert (tmp_path / "spec.yaml").read_text() == "mine"


def test_same_inputs_same_bytes(tmp_path: Path) -> None:
    for name in ("one/rig", "two/rig"):
        assert run("init", tmp_path / name, "--axis", "linear").code == 0
    for name in FILES:
        assert (tmp_path / "one/rig" / name).read_bytes() == (
            tmp_path / "two/rig" / name
        ).read_bytes()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty"),
        (b"\x00\x01\x02" * 50, "binary"),
        (b"\x89MCAP0\r\n" + bytes(100), "log.csv"),
        (b"time [s],x [m]\n0,1\n1,\n", "an empty cell"),
    ],
)
def test_a_bad_log_leaves_no_folder(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_bytes(content)
    refused(run("init", tmp_path / "rig", "--from", tmp_path / "log.csv"), 3, "log.csv", words)
    refused(run("init", tmp_path / "rig", "--from", tmp_path / "missing.csv"), 3, "no such file")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.csv"]


@settings(max_examples=settings.default.max_examples // 3)
@given(
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=30),
    st.text(min_size=1, max_size=10),
)
def test_any_name_and_column_survives(
    tmp_path_factory: pytest.TempPathFactory, name: str, column: str
) -> None:
    name, column = (text.encode("utf-8", "replace").decode() for text in (name, column))
    start = StartingRig(
        name, "linear", log=column, columns={"position": (column, "m")}, left=(column, name)
    )
    folder = tmp_path_factory.mktemp("rig")
    (folder / "bench.yaml").write_text(starting_documents(start)["bench.yaml"], newline="\n")
    bench = bench_of(folder)
    assert (bench.name, bench.columns["position"].column) == (name, column)


@given(st.text(st.characters(exclude_categories=["Cs"])))
def test_quoted_text_is_one_line(text: str) -> None:
    assert "\n" not in quoted(text)


def test_every_kind_of_document_that_a_rig_writes_by_hand_is_there() -> None:
    assert set(KINDS.values()) == {
        DOCUMENTS[name] for name in ("bench", "spec", "design", "scenario")
    }
