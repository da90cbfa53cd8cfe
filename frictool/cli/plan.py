"""`frictool plan`: design of the next test for the commissioning of a rig."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import NamedPath, existing, json_option
from frictool.cli.console_output import (
    note,
    note_missing_effects,
    note_temperature,
    note_travel,
    print_json,
    say,
)
from frictool.cli.excite_test import bench_of, note_returning_ramps, save_test, summary, text
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.progress import note_step

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.plan.commissioning import PlanStep

HELP = """\b
Example:
  frictool plan bench.yaml --spec spec.yaml -o next.mcap
  frictool plan bench.yaml --spec spec.yaml ramps.mcap strokes.mcap -o next.mcap

Design the next test of a bench, and write it. Without logs, the test consists of ramps of the
drive: they show the breakaway, and the sign of the encoder relative to the drive. The second test
consists of strokes, for friction and inertia. With the logs of these two tests, the command
searches for a controller that meets the specification on every plant within the intervals. If it
finds a controller, the last test is for `frictool validate`. If a controller exists for the
identified values only, the next test is designed to halve the intervals. A parameter that the logs
do not show keeps its range.

Each test respects the limits of travel, speed and drive for all parameter values within the bench's
ranges. Add the column feedforward of the test to the effort of the position loop.
`frictool simulate --as-bench` plays a test without hardware.

Exit code 1 if the direction of the encoder is wrong, if two tests show neither inertia nor
friction, if the last strokes narrowed no interval, or if only the ranges of the bench prevent a
controller; 4 if no controller meets the specification.
"""


@click.command("plan", help=HELP)
@click.argument("bench", help="Rig (bench.yaml).", type=existing)
@click.argument("logs", metavar="[LOG]...", nargs=-1, help="Logs of played tests.", type=existing)
@click.option("--spec", type=existing, required=True, help="Specification (spec.yaml).")
@click.option(
    "--narrow",
    is_flag=True,
    help="Design for the intervals of the logs only, and not for the ranges of the bench.",
)
@click.option(
    "--promise", type=NamedPath(writes=("YAML",)), help="Write the promise of the next test (YAML)."
)
@click.option(
    "--model",
    type=NamedPath(writes=("YAML",)),
    help="Write the identified model (YAML); with --narrow, it has the intervals of the logs only.",
)
@click.option(
    "-o",
    "--output",
    type=NamedPath(True, ("CSV", "MCAP"), True),
    help="Next test (.csv or .mcap).",
)
@json_option
def command(
    bench: Path,
    logs: tuple[Path, ...],
    spec: Path,
    narrow: bool,
    promise: Path | None,
    model: Path | None,
    output: Path | None,
    as_json: bool,
) -> None:
    inputs = [bench, spec, *logs]
    check_targets({"-o": output, "--promise": promise, "--model": model}, inputs)
    from msgspec.structs import replace

    from frictool.documents.missing_effects import missing_effects
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.spec import Spec
    from frictool.documents.writing import to_yaml
    from frictool.identify.excite.promise_document import promise_of
    from frictool.logs.log_reader import read_log
    from frictool.plan.commissioning import next_step
    from frictool.plan.controller_search import search_answer

    document = bench_of(bench)
    specification = load(spec, Spec)
    step = next_step(
        document,
        [read_log(path, document) for path in logs],
        lambda model: search_answer(model, specification, note_step),
        narrow,
    )
    also_noted = () if step.model is None else tuple(missing_effects(step.model))
    for warning in step.warnings:
        if warning not in also_noted:
            note(f"warning: {warning}")
    if step.model is not None:
        note_temperature(bench, step.model, vertices=True)
        note_missing_effects(bench, step.model)
    words = command_line("plan", {"bench": bench, "logs": logs, "--spec": spec, "--narrow": narrow})
    provenance = provenance_of_command(words, inputs)
    if step.test is not None:
        note_travel(bench, document)
        note_returning_ramps(step.test.sequence, document)
    if step.test is not None and output is not None:
        save_test(step.test.sequence, output, words, inputs)
    if step.test is not None and promise is not None and step.test.half_widths:
        promised = promise_of([step.test], document, None, provenance)
        save_text(promise, to_yaml(promised), inputs)
    if step.model is not None and model is not None:
        save_text(model, to_yaml(replace(step.model, provenance=provenance)), inputs)
    if as_json:
        print_json("plan/1", view(step), output)
    else:
        say(shown(step, output, document), output)
    if step.exit_code:
        click.get_current_context().exit(step.exit_code)


def view(step: PlanStep) -> dict[str, Any]:
    """Return a step of the commissioning plan as JSON values."""
    return {
        "step": step.name,
        "why": step.why,
        "enough": step.enough,
        "warnings": list(step.warnings),
        "doubts": list(step.doubts),
        "reached": [
            {
                "parameter": one.parameter,
                "unit": one.unit,
                "value": one.value,
                "half_width": one.half_width,
                "share": one.share,
            }
            for one in step.reached
        ],
        "test": None if step.test is None else summary(step.test.sequence),
    }


def shown(step: PlanStep, output: Path | None, bench: Bench) -> str:
    """Return a step of the commissioning plan as text.

    `output`: file to which the signals of the next test are written.
    """
    lines = [
        f"{one.parameter:<18}{one.value:.5g} +-{one.half_width:.2g} {one.unit}"
        + ("" if one.share is None else f" ({100.0 * one.share:.2g} %)")
        for one in step.reached
    ]
    lines += [
        f"{name:<18}not used: its interval is in doubt (see warnings)" for name in step.doubts
    ]
    test = "" if step.test is None else "last test, " if step.enough else "next test, "
    lines.append(f"{test}{step.name}: {step.why}")
    if step.test is not None:
        lines.append(text(step.test.sequence, output or Path("the test"), bench))
        if output is None:
            lines.append("-o FILE writes the test")
    return "\n".join(lines)
