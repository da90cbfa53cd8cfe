"""The ending of a file's name selects its format in the same way in every command."""

from __future__ import annotations

from pathlib import Path

import pytest
from click import UsageError
from hypothesis import given
from hypothesis import strategies as st

from frictool.cli.file_endings import FORMATS, check_ending
from studies.command_line import run

CAMPAIGN = "campaign m.yaml c.yaml --scenario s.yaml --spec p.yaml"
OUTPUTS = [
    (
        f"{CAMPAIGN} -o",
        "c.pdf",
        "states no format; allowed endings: .html, .htm, .yaml or .yml",
    ),
    (f"{CAMPAIGN} -o", "page", "states no format"),
    (f"{CAMPAIGN} -o", "c.json", "states no format"),
    (f"{CAMPAIGN} --table", "t.xlsx", "has another ending; allowed endings: .csv"),
    (
        "report run.mcap --spec p.yaml -o",
        "r.pdf",
        "has another ending; allowed endings: .html or .htm",
    ),
    ("report run.mcap --spec p.yaml --junit", "r.json", "allowed endings: .xml"),
    ("report run.mcap --spec p.yaml --markdown", "r.html", "allowed endings: .md or .txt"),
    ("identify log.mcap --bench b.yaml -o", "m.mcap", "allowed endings: .yaml or .yml"),
    ("identify log.mcap --bench b.yaml --plot", "m.png", "allowed endings: .svg"),
    ("synth m.yaml --spec p.yaml --design d.yaml -o", "c.json", "allowed endings: .yaml or .yml"),
    (
        "simulate m.yaml --controller c.yaml --scenario s.yaml -o",
        "run.mat",
        "allowed endings: .mcap",
    ),
    ("ingest raw.csv --bench b.yaml -o", "log.csv", "allowed endings: .mcap"),
    ("ingest raw.csv --guess -o", "bench.mcap", "allowed endings: .yaml or .yml"),
    (
        "excite --bench b.yaml --kind sine -o",
        "t",
        "states no format; allowed endings: .csv or .mcap",
    ),
    ("observe run m.yaml a.mcap --plot", "wear.png", "allowed endings: .svg, .html or .htm"),
    ("observe design m.yaml --kind tracking -o", "o.html", "allowed endings: .yaml or .yml"),
    ("reduce mechanism.yaml -o", "m.pdf", "allowed endings: .yaml or .yml"),
    ("validate m.yaml log.mcap --plot", "v.html", "allowed endings: .svg"),
    ("schema model -o", "model.yaml", "allowed endings: .json"),
    ("info log.mcap -o", "i.json", "allowed endings: .txt or .md"),
    ("compare -o", "page.pdf", "has the ending of a file; name a folder, or a page (.html)"),
    ("export c.yaml -o", "c.zip", "has the ending of a file; name a folder"),
]


@pytest.mark.parametrize(
    ("command", "name", "words"),
    OUTPUTS,
    ids=[f"{command.split(' ')[0]} {name}" for command, name, _ in OUTPUTS],
)
def test_a_name_that_says_another_format_is_a_wrong_command_line(
    tmp_path: Path, command: str, name: str, words: str
) -> None:
    result = run(*command.split(" "), tmp_path / name)
    assert result.code == 2, result.stderr
    assert name in result.stderr
    assert words in " ".join(result.stderr.split())
    assert not list(tmp_path.iterdir())


@given(st.sampled_from(sorted(FORMATS)), st.text("abz", max_size=3))
def test_the_endings_of_a_format_are_its_own_and_those_that_say_none_are_free(
    form: str, free: str
) -> None:
    for name, endings in FORMATS.items():
        for target in (
            Path(f"{out}") for ending in endings for out in (f"out{ending}", f"OUT{ending.upper()}")
        ):
            if name == form:
                check_ending(target, (form,), chooses=True)
            else:
                with pytest.raises(UsageError, match="allowed endings"):
                    check_ending(target, (form,), chooses=False)
    for target in (Path("-"), Path("/dev/null")):
        check_ending(target, (form,), chooses=True)
    for target in (Path(f"out.new{free}"), Path("out")):
        check_ending(target, (form,), chooses=False)
        with pytest.raises(UsageError, match="states no format"):
            check_ending(target, (form,), chooses=True)
