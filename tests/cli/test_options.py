"""The options of all commands: what click lets pass by itself."""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path

import click
import pytest

from frictool.cli.common_options import FiniteRange, NamedPath
from frictool.cli.main import COMMANDS
from frictool.logs.fleet import members
from studies.command_line import run
from tests.support.command_line import refused

ROOT = Path(__file__).parents[2]
IDENTIFY = [
    "identify",
    ROOT / "sample_logs/sines.csv",
    "--bench",
    ROOT / "configs/clutch/bench.yaml",
    "--method",
    "inverse-dynamic",
]
NUMBERS = [
    (name, option)
    for name, (module, _) in COMMANDS.items()
    for option in importlib.import_module(module).command.params
    if isinstance(option.type, click.types.FloatParamType)
]


def test_every_number_of_every_command_has_the_type_that_refuses_nan() -> None:
    assert {option.name for _, option in NUMBERS} >= {"confidence", "cutoff_hz"}
    assert [
        (name, option.name) for name, option in NUMBERS if not isinstance(option.type, FiniteRange)
    ] == []


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "NaN"])
@pytest.mark.parametrize("option", ["--cutoff-hz", "--confidence"])
def test_a_number_that_is_not_finite_is_a_wrong_command_line(
    option: str, value: str, tmp_path: Path
) -> None:
    result = run(*IDENTIFY, option, value, "-o", tmp_path / "model.yaml")
    assert result.code == 2
    assert f"Invalid value for '{option}'" in result.stderr
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ("assess", "--bench", ROOT / "configs/clutch/bench.yaml", "--duration", "1e308"),
        ("assess", "--bench", ROOT / "configs/clutch/bench.yaml", "--noise", "1e300"),
        (*IDENTIFY[:-1], "power-balance", "--time-constant", "1e308"),
    ],
    ids=lambda words: " ".join(words[-2:]),
)
def test_a_number_that_no_bench_has_is_a_wrong_command_line(words: tuple[str | Path, ...]) -> None:
    result = run(*words)
    assert (result.code, result.stdout) == (2, "")
    assert (
        f"Invalid value for '{words[-2]}': found {float(words[-1]):g}; allowed: 0, or 1e-15 to "
        "1e+12" in result.stderr
    )


def test_a_filter_slower_than_any_log_is_a_wrong_command_line() -> None:
    result = run(*IDENTIFY[:-1], "friction-force", "--cutoff-hz", "1e-10")
    assert (result.code, result.stdout) == (2, "")
    assert "1e-10 is not in the range x>=0.001" in result.stderr


def test_a_finite_number_passes_as_it_is() -> None:
    assert FiniteRange(0.0, min_open=True).convert("1e9", None, None) == 1e9
    with pytest.raises(click.BadParameter, match="found nan; allowed: a finite number"):
        FiniteRange().convert("nan", None, None)


def test_a_cut_off_above_half_the_rate_is_one_line(tmp_path: Path) -> None:
    text = (ROOT / "configs/clutch/bench.yaml").read_text()
    bench = tmp_path / "bench.yaml"
    bench.write_text(
        "".join(line for line in text.splitlines(keepends=True) if "backlash" not in line)
    )
    result = run("identify", IDENTIFY[1], "--bench", bench, *IDENTIFY[4:], "--cutoff-hz", "1e9")
    refused(
        result,
        1,
        "a cut-off of 1e+09 Hz is too high; allowed: below half of the sampling rate of 1000 Hz",
    )


def test_whether_an_input_may_be_read_is_found_on_reading(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file without permission is exit 3 as any other that cannot be read, and not click's 2."""
    checked = {
        (name, option.name)
        for name, (module, _) in COMMANDS.items()
        for option in importlib.import_module(module).command.params
        if isinstance(option.type, click.Path)
        and option.type.readable
        and option.name not in ("output", "plot")
    }
    assert checked == set()
    log = tmp_path / "log.mcap"
    log.write_bytes(bytes(100))

    def forbidden(self: Path, *_: object) -> None:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr("os.access", lambda *_, **__: False)
    monkeypatch.setattr(Path, "open", forbidden)
    refused(run("info", log), 3, "log.mcap: cannot be read: Permission denied")


def test_help_shows_no_range_where_there_is_none() -> None:
    assert "None" not in run("info", "--help").stdout


@pytest.mark.parametrize(
    "command",
    [
        ("synth", "model.yaml", "--spec", "", "--design", "d.yaml"),
        ("export", "controller.yaml", "-o", ""),
    ],
)
def test_an_empty_name_is_no_folder(
    command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As of a shell's variable that is not set: of it pathlib makes the present folder."""
    monkeypatch.chdir(tmp_path)
    result = run(*command)
    assert result.code == 2
    assert "the name is empty" in result.stderr
    paths = [
        (name, option.name)
        for name, (module, _) in COMMANDS.items()
        for option in importlib.import_module(module).command.params
        if isinstance(option.type, click.Path) and not isinstance(option.type, NamedPath)
    ]
    assert paths == []


def test_an_output_that_cannot_be_written_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = ROOT / "configs/clutch"

    def never(*_: object, **__: object) -> None:
        raise AssertionError("it has begun")

    monkeypatch.setattr("frictool.synth.synthesis.synthesise", never)
    synth = (
        "synth",
        rig / "nonlinear.yaml",
        "--spec",
        rig / "spec.yaml",
        "--design",
        rig / "designs/speed.yaml",
        "-o",
    )
    refused(run(*synth, tmp_path), 3, "is a directory; name a file")
    refused(
        run(*synth, "/dev/null/controller.yaml"), 3, "/dev/null/controller.yaml: cannot be written"
    )
    monkeypatch.setattr("frictool.compare.comparison.compare", never)
    refused(
        run("compare", "-o", "/dev/null/laws.html"), 3, "/dev/null/laws.html: cannot be written"
    )
    assert list(tmp_path.iterdir()) == []


CLUTCH = ROOT / "configs/clutch"
TWO_OUTPUTS = {
    "identify": [
        "identify",
        ROOT / "sample_logs/sines.csv",
        "--bench",
        CLUTCH / "bench.yaml",
        "-o",
        "OUT",
        "--plot",
        "OUT",
    ],
    "reduce": ["reduce", ROOT / "configs/throttle/mechanism.yaml", "-o", "OUT", "--reduced", "OUT"],
    "simulate": [
        "simulate",
        CLUTCH / "mechanism.yaml",
        "--scenario",
        CLUTCH / "spec.yaml",
        "-o",
        "OUT",
        "--events",
        "OUT",
    ],
}


@pytest.mark.parametrize("command", TWO_OUTPUTS)
@pytest.mark.parametrize("there", ["", "file", "link"])
def test_two_outputs_with_one_name_are_refused_before_the_first_replaces_the_second(
    command: str, there: str, tmp_path: Path
) -> None:
    first = second = tmp_path / "out"
    if there:
        first.write_text("kept")
    if there == "link":
        second = tmp_path / "link"
        second.symlink_to(first)
    names = iter((first, second))
    result = run(*(next(names) if word == "OUT" else word for word in TWO_OUTPUTS[command]))
    assert result.code == 2
    assert "have the same name" in result.stderr
    assert [path.read_text() for path in (first, second) if path.exists()] == ["kept"] * 2 * bool(
        there
    )


def test_stdout_holds_one_output() -> None:
    """The model and the picture one after the other would be neither."""
    result = run(*("-" if word == "OUT" else word for word in TWO_OUTPUTS["identify"]))
    assert (result.code, result.stdout) == (2, "")
    assert "-o and --plot have the same name, -; give two names" in result.stderr


@pytest.mark.skipif(sys.platform == "darwin", reason="names of files are text there")
def test_a_name_that_is_no_text_is_read_and_written_all_the_same(tmp_path: Path) -> None:
    """A name from a machine with another encoding, whose bytes are not UTF-8: what no format can
    hold of it is escaped."""
    name = os.fsdecode(b"gr\xf6sse")
    log = tmp_path / f"{name}.csv"
    log.write_text(
        "time;encoder;current\n" + "".join(f"{k / 1000:.3f};{k};{k % 7}\n" for k in range(100))
    )
    bench = ["--bench", CLUTCH / "bench.yaml"]
    for target in (".mcap", ".mat", ".npz", ".txt"):
        words = ["ingest" if target == ".mcap" else "info" if target == ".txt" else "convert", log]
        result = run(*words, *bench, "-o", tmp_path / f"{name}{target}")
        assert result.code == 0, result.stderr
    assert (
        "gr\\udcf6sse.csv: UTF-8, semicolon between cells"
        in run("info", tmp_path / f"{name}.mcap").stdout
    )
    assert members([tmp_path])[0].name.file == "gr\\udcf6sse.csv"
