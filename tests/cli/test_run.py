"""The test helper itself, on the one command that needs no input file."""

import json
from pathlib import Path

from studies.command_line import run
from tests.support.command_line import refused


def test_stdout_and_exit_code_are_captured():
    result = run("schema", "bench")
    assert result.code == 0
    assert result.stderr == ""
    assert json.loads(result.stdout)["title"] == "bench.yaml"


def test_a_schema_takes_json_as_every_command_does(tmp_path: Path):
    assert run("schema", "bench", "--json").out == run("schema", "bench").out
    assert run("schema", "bench", "--json", "-o", tmp_path / "bench.json").code == 0
    assert (tmp_path / "bench.json").read_bytes() == run("schema", "bench").out


def test_a_wrong_command_line_is_exit_2():
    result = run("schema", "brench")
    assert result.code == 2
    assert "brench" in result.stderr


def test_an_input_error_is_one_line(tmp_path):
    missing = tmp_path / "model.yaml"
    refused(
        run("synth", missing, "--spec", missing, "--design", missing),
        3,
        "model.yaml",
        "no such file",
    )
