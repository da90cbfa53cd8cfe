"""`frictool simulate`: step tests of a model under its controller, as a log."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import command_line, existing, json_option, note, output_option, print_json, refuse_inputs, replacing, say

if TYPE_CHECKING:
    from frictool.logs.log import Log

HELP = """\b
Example:
  frictool simulate model.yaml --controller controller.yaml --scenario scenarios/steps.yaml -o run.mcap

Play a scenario to the model under its controller and write what a bench would have logged.

The engine moves from event to event (stop, breakaway, backlash contact, knee, end stop), in closed form where there is one: an axis at
rest below its breakaway stays where it is, exactly. The controller is sampled, sees the position through the encoder, and acts after
the bench's computational delay.
With `variants: vertices` the scenario is played once more at each vertex at which the controller was verified (streams /axis/NAME).
"""


@click.command("simulate", help=HELP)
@click.argument("model", type=existing)
@click.option("--controller", type=existing, required=True, help="The controller (controller.yaml).")
@click.option("--scenario", type=existing, required=True, help="References, durations, variants, noise (scenario.yaml).")
@output_option()
@json_option
def command(model: Path, controller: Path, scenario: Path, output: Path, as_json: bool) -> None:
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.provenance import record
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario

    inputs = [model, controller, scenario]
    documents = (load(model, Model), load(controller, Controller), load(scenario, Scenario))
    refuse_inputs(output, inputs)
    from frictool.logs.canonical.mcap_format import write_mcap
    from frictool.simulate.agreement import Names
    from frictool.simulate.step_test import step_test

    provenance = record(command_line("simulate", {"model": model, "--controller": controller, "--scenario": scenario}), inputs)
    log = step_test(*documents, provenance, Names(*map(str, inputs)), _progress)
    for warning in log.warnings:
        note(f"warning: {warning}")
    with replacing(output, inputs) as stream:
        write_mcap(log, stream)
    if as_json:
        print_json(summary(log), output)
    else:
        say(table(log), output)


def _progress(done: int, total: int) -> None:
    """`simulated 3 of 17` on a terminal, one line that is written over."""
    if done > 0 and total > 1 and sys.stderr.isatty():
        click.echo(f"\rsimulated {done} of {total}" + ("\n" if done == total else ""), err=True, nl=False)


def summary(log: Log) -> dict[str, Any]:
    """The machine's view of a step test: what each stream holds and how it ends. The verdict is `frictool report`'s."""
    streams = []
    for stream in log.streams:
        position, command = stream.signals["position"], stream.signals["command"]
        streams.append(
            {
                "topic": stream.topic,
                "samples": int(stream.time.size),
                "duration_s": round(float(stream.time[-1] - stream.time[0]) + stream.period, 9),
                "final_error": float(stream.signals["reference"][-1] - position[-1]),
                "command_peak": float(abs(command).max()),
                "at_rest": bool(stream.signals["velocity"][-1] == 0.0),
                "units": stream.units,
            }
        )
    return {"scenario": log.source, "streams": streams, "warnings": list(log.warnings)}


def table(log: Log) -> str:
    """The same for people."""
    found = summary(log)["streams"]
    unit, drive = found[0]["units"]["position"], found[0]["units"]["command"]
    lines = [f"{log.source}: {len(found)} stream(s), {found[0]['samples']} samples, {found[0]['duration_s']:g} s each"]
    lines.append(f"{'stream':<14}{'final error ' + unit:>18}{'command peak ' + drive:>18}  end")
    for row in found:
        end = "at rest" if row["at_rest"] else "moving"
        lines.append(f"{row['topic']:<14}{row['final_error']:>18.4g}{row['command_peak']:>18.4g}  {end}")
    return "\n".join(lines)
