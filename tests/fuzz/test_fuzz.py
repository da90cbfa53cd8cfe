"""A seeded part of `make fuzz`, and that what it looks for would be found."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.formats import FORMATS, format_of
from studies.command_line import CommandResult
from tests.fuzz import child
from tests.fuzz.harness import SEED, fuzz
from tests.support import sample_files

INPUTS = (1, 9)  # of each format, in `make test` and in `make accept`
LOGGER_INPUTS = (1, 3)  # of each logger: they are all text


@pytest.fixture(scope="module", params=sample_files.names())
def sample(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Path]:
    return request.param, sample_files.write(request.param, tmp_path_factory.mktemp("sample"))


@pytest.mark.parametrize("part", [0, pytest.param(1, marks=pytest.mark.accept)])
def test_mutated_inputs_are_read_or_refused_in_one_line(
    sample: tuple[str, Path], part: int, tmp_path: Path
):
    """Inputs of every format, the unchanged sample first; in this process, so without a limit of
    memory."""
    name, made = sample
    bench, data, path = tmp_path / "bench.yaml", made.read_bytes(), child.place_for(made, tmp_path)
    sample_files.write_other(name, made, bench)
    assert child.attempt(name, 0, data, path, bench) is None
    ends = LOGGER_INPUTS if name.startswith(sample_files.LOGGER) else INPUTS
    for index in range((0, *ends)[part], ends[part]):
        found = child.attempt(name, index, child.input_of(name, data, SEED, index), path, bench)
        assert found is None, f"python -m tests.fuzz {name} {index}: {found}"
    assert [one.name for one in tmp_path.iterdir() if one.name != "input"] == ["bench.yaml"]


def test_a_process_with_limits_runs_the_same():
    result = fuzz(6, names=["csv"])
    assert result["findings"] == []
    assert result["passed"]


def test_every_format_has_a_sample(tmp_path: Path):
    seen = set()
    for name in sample_files.names():
        folder = tmp_path / name
        folder.mkdir(parents=True)
        path = sample_files.write(name, folder)
        if name != sample_files.DOCUMENT and not is_canonical(path):
            seen.add(format_of(path))
    # an installation without an extra has no sample of its format
    assert seen == {one for one in FORMATS if one.library is None or find_spec(one.library[0])}


def test_inputs_are_the_same_again_and_not_the_sample():
    data = bytes(range(256)) * 4
    made = [child.input_of("csv", data, SEED, index) for index in range(50)]
    assert made == [child.input_of("csv", data, SEED, index) for index in range(50)]
    assert len(set(made)) > 45


@pytest.mark.parametrize(
    ("result", "files", "found"),
    [
        (CommandResult(0, b"", ""), [], None),
        (CommandResult(3, b"", "error: x: is damaged\n"), [], None),
        (CommandResult(0, b"", "warning: x\n"), [], None),
        (CommandResult(1, b"", "error: no\n"), [], "exit code 1"),
        (CommandResult(3, b"", "error: x\nTraceback (most recent call last):\n"), [], "one line"),
        (CommandResult(3, b"", "error: " + "x" * 2000 + "\n"), [], "one line"),
        (CommandResult(3, b"", "error: x\nerror: y\n"), [], "one line that says why"),
        (CommandResult(3, b"", ""), [], "one line that says why"),
        (CommandResult(3, b"", "error: x\n"), [".out.mcap.1.part"], "left behind"),
        (CommandResult(3, b"", "error: x\n"), ["out.mcap"], "output beside an error"),
        (CommandResult(0, b"", ""), ["out.mcap"], "wrote what cannot be read"),
    ],
)
def test_what_is_complained_of(
    tmp_path: Path, result: CommandResult, files: list[str], found: str | None
):
    for name in files:
        (tmp_path / name).write_bytes(b"half")
    said = child.complaint(result, tmp_path / "out.mcap", set(), salvage=False)
    assert (said is None) if found is None else (found in str(said))


def test_memory_beyond_the_limit_is_refused():
    """In a process of its own: the limit stays."""
    code = (
        f"from tests.fuzz import child; child.limit_memory(); bytearray({child.MOST_BYTES} + "
        "(64 << 20))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode != 0
    assert "MemoryError" in done.stderr


def test_an_input_that_hangs_ends_the_process(tmp_path: Path):
    code = (
        "import sys, time; from pathlib import Path; from tests.fuzz import child; "
        "child.run = lambda *words: time.sleep(20); folder = Path(sys.argv[1]); "
        "child.attempt('csv', 0, b'', folder / 'input', folder / 'bench.yaml', 0.2)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True
    )
    assert done.returncode == 1
    assert "Timeout" in done.stderr
