"""Every command on every kind of bad input file: one line, exit 3, no traceback, no output."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from studies.command_line import run
from tests.support.command_line import also_called, refused
from tests.support.short_logs import first_part

ROOT = Path(__file__).parents[2]
RIG = ROOT / "configs/clutch"


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one good file of each kind, made by the commands themselves."""
    folder = tmp_path_factory.mktemp("chain")
    for name, source in {
        "bench.yaml": RIG / "bench.yaml",
        "spec.yaml": RIG / "spec.yaml",
        "design.yaml": RIG / "designs/speed.yaml",
        "scenario.yaml": RIG / "scenarios/steps.yaml",
    }.items():
        shutil.copy(source, folder / name)
    (folder / "log.csv").write_text(first_part("sines.csv"))
    for line in (
        "ingest log.csv --bench bench.yaml -o log.mcap",
        "identify log.mcap --bench bench.yaml -o model.yaml",
        "synth model.yaml --spec spec.yaml --design design.yaml --vertices-only --no-play "
        "-o controller.yaml",
        "simulate model.yaml --controller controller.yaml --scenario scenario.yaml -o run.mcap",
    ):
        result = run(*(folder / word if "." in word else word for word in line.split()))
        assert result.code == 0, f"{line}\n{result.stderr}"
    return folder


COMMANDS = {
    "ingest": "ingest log.csv --bench bench.yaml -o out.mcap",
    "info": "info log.mcap",
    "identify": "identify log.mcap --bench bench.yaml -o out.yaml",
    "synth": "synth model.yaml --spec spec.yaml --design design.yaml -o out.yaml",
    "simulate": "simulate model.yaml --controller controller.yaml --scenario scenario.yaml -o "
    "out.mcap",
    "report": "report run.mcap --spec spec.yaml --controller controller.yaml -o out.html",
    "export": "export controller.yaml --lang c -o out.d",
}


def _missing(path: Path) -> None:
    path.unlink()


def _empty(path: Path) -> None:
    path.write_bytes(b"")


def _binary(path: Path) -> None:
    path.write_bytes(bytes(range(256)) * 16)


def _truncated(path: Path) -> None:
    """Cut within a value: documents in their last map, where they have one, other files in the
    middle."""
    data = path.read_bytes()
    cut = data.rfind(b"{") + 4 if path.suffix == ".yaml" and b"{" in data else len(data) // 2
    path.write_bytes(data[:cut].rstrip(b"\n"))


def _directory(path: Path) -> None:
    path.unlink()
    path.mkdir()


def _misspelt(path: Path) -> None:
    path.write_text(path.read_text().replace("name:", "nmae:", 1))


CASES = [
    (command, word, damage)
    for command, line in COMMANDS.items()
    for word in line.split()
    if "." in word and not word.startswith("out.")
    for damage in (_missing, _empty, _binary, _truncated, _directory, _misspelt)
    if damage is not _misspelt or word.endswith(".yaml")
]


@pytest.mark.parametrize(
    ("command", "word", "damage"), CASES, ids=lambda item: getattr(item, "__name__", str(item))
)
def test_a_damaged_input_is_one_line_and_no_output(
    command: str, word: str, damage: Callable[[Path], None], chain: Path, tmp_path: Path
) -> None:
    words = COMMANDS[command].split()
    for name in words:
        if "." in name and not name.startswith("out."):
            shutil.copy(chain / name, tmp_path / name)
    damage(tmp_path / word)
    before = sorted(path.name for path in tmp_path.iterdir())
    result = run(*(tmp_path / name if "." in name else name for name in words))
    refused(result, 3, str(tmp_path / word))
    if damage is _misspelt:
        assert "did you mean 'name'?" in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == before


@pytest.mark.parametrize("lost", [1, 2])
@pytest.mark.parametrize(
    "line",
    [
        "ingest {log} --bench {bench}",
        "identify {log} --bench {bench}",
        "report {log} --bench {bench} --spec {spec}",
    ],
)
def test_a_raw_log_cut_in_its_last_number_is_refused(line: str, lost: int, tmp_path: Path) -> None:
    """The rest of the number parses; the missing line end shows the cut."""
    log = tmp_path / "log.csv"
    log.write_text(
        "time,encoder,current\n" + "".join(f"{k / 1000:.3f},{k},{k + 10}\n" for k in range(60))
    )
    log.write_bytes(log.read_bytes()[:-lost])
    words = line.format(log=log, bench=RIG / "bench.yaml", spec=RIG / "spec.yaml").split()
    result = run(*words, "-o", tmp_path / "out")
    refused(
        result,
        3,
        f"{log}:61: the last line has no line end: the file may be cut off; if it is complete, "
        "add a line end",
    )
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


@pytest.mark.parametrize("command", [name for name in COMMANDS if name not in ("info", "export")])
def test_an_input_is_never_overwritten(command: str, chain: Path, tmp_path: Path) -> None:
    words = COMMANDS[command].split()
    for name in words:
        if "." in name and not name.startswith("out."):
            shutil.copy(chain / name, tmp_path / name)
    target = tmp_path / words[1]
    before = target.read_bytes()
    result = run(
        *(tmp_path / name if "." in name else name for name in words[:-1]),
        also_called(target, Path(words[-1]).suffix),
    )
    refused(result, 3, "input")
    assert target.read_bytes() == before


@pytest.mark.parametrize("command", [*COMMANDS, "init", "schema"])
def test_help_opens_with_an_example(command: str) -> None:
    result = run(command, "--help")
    assert result.code == 0
    lines = [line.strip() for line in result.stdout.splitlines() if line.strip()]
    assert lines[0].startswith("Usage:")
    assert lines[1].startswith("Example")
    assert lines[2].startswith(f"frictool {command}")


def test_a_misspelt_command_is_suggested() -> None:
    result = run("identfy")
    assert result.code == 2
    assert "identify" in result.stderr
