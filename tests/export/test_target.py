"""Exported C on an emulated Cortex-M4: every bit, the counted instructions, and the budget."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import msgspec
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.documents.bench import Target
from frictool.documents.writing import to_yaml
from frictool.errors import FrictoolError
from frictool.export import target_figures as figures
from studies.command_line import run
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from studies.target.__main__ import main
from tests.support.command_line import refused
from tests.support.compiled_c import sources

TOOLS = [figures.COMPILER, figures.SIZE, figures.EMULATOR]
MISSING = [tool for tool in TOOLS if shutil.which(tool) is None]
needs_target = pytest.mark.skipif(bool(MISSING), reason=f"not on the PATH: {', '.join(MISSING)}")


def written(folder: Path, **target: int) -> Path:
    """A verified controller whose bench has a budget."""
    made = truthful(clutch_controller(CUT_LAW))
    bench = msgspec.structs.replace(made.bench, target=Target(**target) if target else None)
    path = folder / "controller.yaml"
    path.write_text(to_yaml(msgspec.structs.replace(made, bench=bench)))
    return path


@pytest.mark.accept
@needs_target
def test_every_build_reproduces_every_bit_and_the_loop_runs_in_an_interrupt(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["build/target"]) == 0  # a relative folder, as in the Makefile
    printed = capsys.readouterr().out
    assert "6 of 6 builds reproduce every bit\n" in printed
    assert re.search(r"after 2000 samples: position .* fault 0\n", printed)


@needs_target
def test_a_coefficient_that_differs_in_one_bit_fails_on_the_target(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    folder = Path("target")
    folder.mkdir()
    files = sources(clutch_controller(CUT_LAW), "q31")
    for name, text in files.items():
        (folder / name).write_text(text)
    code = folder / "speed.c"
    found = re.search(r"prefilter_q = (\d+);", code.read_text())
    assert found is not None
    image = folder / "selftest.elf"
    figures.build_image(image, sorted(folder.glob("*.c")), "cortex-m4")
    figures.run_image(image)
    code.write_text(code.read_text().replace(found[1], str(int(found[1]) + 1), 1))
    figures.build_image(image, sorted(folder.glob("*.c")), "cortex-m4")
    with pytest.raises(FrictoolError, match=r"exit code 1: speed: sample \d+: .* expected"):
        figures.run_image(image)


@needs_target
@pytest.mark.parametrize("nops", [0, 1, 100, 5000])
def test_instructions_are_those_of_the_step(nops: int) -> None:
    """A step of known length in place of the controller."""
    files = sources(clutch_controller(CUT_LAW), "float")
    files["speed.c"] = (
        '#include "speed.h"\n'
        "void speed_init(speed_state *state, float position)\n"
        "{ state->holds_left = position; }\n"
        '#pragma GCC diagnostic ignored "-Wunused-parameter"\n'
        "float __attribute__((naked)) speed_step(speed_state *state, float reference, float "
        f'position)\n{{ __asm volatile(".rept {nops}\\n nop\\n .endr\\n bx lr"); }}\n'
    )
    program = controller_program(clutch_controller(CUT_LAW))
    found = figures.target_figures("speed", files, program, "float", Target())
    assert (found.instructions, found.instructions_mean) == (nops, nops)


@needs_target
def test_a_report_states_what_the_code_costs(tmp_path: Path) -> None:
    path = written(tmp_path)
    result = run("export", path, "--number", "float", "--report", "-o", tmp_path / "c", "--json")
    assert result.code == 0
    target = json.loads(result.stdout)["target"]
    assert target["core"] == "cortex-m4f"
    assert target["missing"] is None
    fields = re.findall(
        r"^    (?:float|int) \w+(?:\[(\d+)\])?;", (tmp_path / "c/speed.h").read_text(), re.M
    )
    assert target["state_bytes"] == 4 * sum(int(size or 1) for size in fields)
    assert 0 < target["instructions_mean"] <= target["instructions"]
    text = run("export", path, "--number", "float", "--report", "-o", tmp_path / "c").stdout
    assert f"{target['instructions']} instructions per step at most" in text


@needs_target
def test_a_budget_refuses_what_does_not_fit(tmp_path: Path) -> None:
    path = written(tmp_path, instructions=500, code_bytes=100_000)
    refused(
        run("export", path, "--number", "double", "-o", tmp_path / "c"),
        4,
        "instructions per step, allowed: at most 500 (target.instructions)",
        "--number",
    )
    assert not (tmp_path / "c").exists()
    assert run("export", path, "--number", "float", "-o", tmp_path / "c").code == 0


def test_a_budget_that_nothing_can_check_is_undecided(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figures.shutil, "which", lambda tool: None)
    result = run("export", written(tmp_path, state_bytes=64), "-o", tmp_path / "c")
    assert result.code == 1
    assert "arm-none-eabi-gcc is not on the PATH" in result.stderr
    assert (tmp_path / "c/speed.c").exists()


def test_code_in_q15_is_refused_with_the_formats_that_exist(tmp_path: Path) -> None:
    result = run("export", written(tmp_path), "--number", "q15", "-o", tmp_path / "c")
    refused(result, 4, "no q15", "allowed: double, float, q31")
