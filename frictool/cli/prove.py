"""`frictool prove`: proof of a step test for all initial positions within an encoder count."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import FiniteRange, existing, json_option, output_option
from frictool.cli.console_output import print_json, say
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.progress import progress
from frictool.cli.workers_options import cores_option

if TYPE_CHECKING:
    from frictool.documents.controller import ProgramNumber

HELP = """\b
Example:
  frictool prove controller.yaml model.yaml --scenario step.yaml --spec spec.yaml -o proof.yaml
  frictool verify proof.yaml

Prove the requirements of a step test for each plant of the scenario (`variants`), from every start
position within one encoder count. The simulated loop contains encoder, delay, position law, band,
limiter, drive limit, anti-windup, prefilter and number format of the controller, and stick, slip,
breakaway, backlash and lag of the axis. Every rounding error is bounded.

The start positions are divided into intervals. All starts in one interval give the same encoder
readings at every sample. The controller runs on these readings; the motion of the axis is enclosed
in bounds. Each requirement is proved, refuted by a start that `frictool simulate` replays, or
undecided. For every plant with parameters between their limits, the certificate proves the modulus
margin, and the drive limit proves the drive peak. All other requirements are proved for the plants
of the scenario only; `frictool campaign` draws other plants.

--box-minutes searches for cells of the parameter box in which response time, overshoot, static
error and rest are proved for every plant. The proof then lists the cells; the requirements state
which share of the box's volume the cells fill.

The proof contains its documents. `frictool verify` proves it again from the file alone.

Exit codes: 0 every requirement is proved; 1 a requirement is refuted or undecided; 4 the model, the
controller or the scenario contains something that the proof does not cover.
"""


@click.command("prove", help=HELP)
@click.argument("controller", type=existing, help="Controller to prove (controller.yaml).")
@click.argument("model", type=existing, help="Model of the axis (model.yaml).")
@click.option(
    "--scenario", type=existing, required=True, help="Step test to prove (scenario.yaml)."
)
@click.option(
    "--spec", type=existing, required=True, help="Requirements on the closed loop (spec.yaml)."
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31"]),
    default="double",
    show_default=True,
    help="Number format of the controller.",
)
@click.option(
    "--box-minutes",
    type=FiniteRange(0.0),
    default=0.0,
    show_default=True,
    help="Time of the search for proved cells of the parameter box [min]; 0: no search.",
)
@output_option(required=False, help="Proof to write (proof.yaml).")
@cores_option
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    controller: Path,
    model: Path,
    scenario: Path,
    spec: Path,
    number: ProgramNumber,
    box_minutes: float,
    output: Path | None,
    cores: int | None,
    as_json: bool,
) -> None:
    inputs = [controller, model, scenario, spec]
    check_targets({"-o": output}, inputs)
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.documents.spec import Spec
    from frictool.documents.writing import to_yaml
    from frictool.errors import EXIT_NO
    from frictool.prove.proof_view import json_view, lines, verdict_of
    from frictool.prove.step_proof import ProofRequest, prove_box, prove_step
    from frictool.simulate.document_agreement import DocumentNames

    test = ProofRequest(
        load(model, Model),
        load(controller, Controller),
        load(scenario, Scenario),
        load(spec, Spec),
        number,
    )
    words = command_line(
        "prove",
        {
            "controller": controller,
            "model": model,
            "--scenario": scenario,
            "--spec": spec,
            "--number": None if number == "double" else number,
            "--box-minutes": box_minutes or None,
        },
    )
    names = DocumentNames(str(model), str(controller), str(scenario))
    with progress("plants") as show:
        proof = prove_step(test, provenance_of_command(words, inputs), names, show, cores)
    if box_minutes > 0.0:
        with progress("time for cells") as show:
            proof = prove_box(proof, 60.0 * box_minutes, show, cores)
    if output is not None:
        save_text(output, to_yaml(proof), inputs)
    if as_json:
        print_json("prove/1", json_view(proof, None), output)
    else:
        say("\n".join(lines(proof)), output)
    if verdict_of(proof) != "proved":
        ctx.exit(EXIT_NO)
