"""`frictool completion`: the script that a shell evaluates, and what frictool answers when the
shell asks."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from frictool.cli.completion import INSTALL, VARIABLE
from frictool.cli.main import COMMANDS
from frictool.identify.methods import METHODS
from studies.command_line import run

HEAVY = {"numpy", "numba", "scipy", "clarabel", "matplotlib", "yaml"}
ASKING = """
import os, sys
from frictool.cli.main import main
try:
    main()
finally:
    print(*sorted({HEAVY} & set(sys.modules)), file=sys.stderr)
"""


def answered(words: str, incomplete: str = "") -> tuple[list[str], str]:
    """Return frictool's completions of a line that ends in `incomplete`, without their kinds, and
    the heavy libraries that it loaded."""
    line = f"frictool {words} {incomplete}".split()
    place = len(line) if not incomplete else len(line) - 1
    environment = os.environ | {
        VARIABLE: "bash_complete",
        "COMP_WORDS": " ".join(line),
        "COMP_CWORD": str(place),
    }
    code = ASKING.replace("{HEAVY}", repr(HEAVY))
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout.split(), done.stderr.strip()


def test_commands_are_completed_without_loading_any() -> None:
    found, heavy = answered("")
    assert found == [f"plain,{name}" for name in COMMANDS]
    assert heavy == ""


@pytest.mark.parametrize(
    ("words", "incomplete", "expected"),
    [
        ("", "exc", ["plain,excite"]),
        ("export", "--la", ["plain,--lang"]),
        (
            "export --lang",
            "",
            [
                "plain,c",
                "plain,json",
                "plain,cmsis",
                "plain,matlab",
                "plain,fmu",
                "plain,urdf",
                "plain,table",
                "plain,mjcf",
            ],
        ),
        ("identify --method", "le", [f"plain,{name}" for name in METHODS if name.startswith("le")]),
        ("observe", "", ["plain,design", "plain,loop", "plain,run"]),
        ("observe design --kind", "add", ["plain,additive"]),
        ("synth model.yaml --design", "designs/s", ["file,designs/s"]),
        ("completion", "", [f"plain,{shell}" for shell in INSTALL]),
    ],
)
def test_options_choices_and_files_are_completed(
    words: str, incomplete: str, expected: list[str]
) -> None:
    found, heavy = answered(words, incomplete)
    assert found == expected
    assert "numba" not in heavy


@pytest.mark.parametrize("shell", INSTALL)
def test_the_script_asks_frictool(shell: str) -> None:
    result = run("completion", shell)
    assert result.code == 0
    assert result.stdout.startswith(f"# Completion of frictool for {shell}.")
    assert INSTALL[shell] in result.stdout
    assert f"{VARIABLE}={shell}_complete" in result.stdout


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
def test_bash_completes_with_it(tmp_path: Path) -> None:
    """The script's own function, with a program of that name on the PATH."""
    program = tmp_path / "frictool"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m frictool "$@"\n')
    program.chmod(0o755)
    script = run("completion", "bash").stdout
    asks = (
        "COMP_WORDS=(frictool export --lang cm); COMP_CWORD=3; _frictool_completion frictool; "
        'echo "${COMPREPLY[@]}"'
    )
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-c", f"{script}\n{asks}"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert (done.stdout, done.stderr) == ("cmsis\n", "")


def test_the_shell_is_the_variable_s(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("SHELL", "/usr/bin/fish")
    assert run("completion", "-o", tmp_path / "frictool.fish").code == 0
    assert "fish_complete" in (tmp_path / "frictool.fish").read_text()
    monkeypatch.setenv("SHELL", "/bin/tcsh")
    result = run("completion")
    assert result.code == 2
    assert "bash, zsh, fish" in result.stderr


def test_the_module_is_the_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "frictool", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout == run("--version").stdout
    assert done.stdout.startswith("frictool ")
    assert done.stdout.endswith(f"Python {sys.version.split()[0]}\n")
