"""`frictool synth`: model, specification and design to a verified controller."""

from __future__ import annotations

from pathlib import Path

import click

from frictool.cli.output import command_line, existing, json_option, output_option, print_json, save_text, say

HELP = """\b
Example:
  frictool synth model.yaml --spec spec.yaml --design designs/speed.yaml -o controller.yaml

Synthesise a controller at the vertices of the polytope that the model's and the bench's intervals span, and verify it.

The controller is accepted only if the loop rebuilt from the stored coefficients, sampled at the bench's period, is stable at every vertex
with 0 and with 1 sample of computational delay and holds the specified modulus margin at the bench's delay. Otherwise nothing
is written and the exit code is 4.
"""


@click.command("synth", help=HELP)
@click.argument("model", type=existing)
@click.option("--spec", type=existing, required=True, help="What the closed loop has to do (spec.yaml).")
@click.option("--design", type=existing, required=True, help="Structure, method and weights (design.yaml).")
@output_option(required=False)
@json_option
def command(model: Path, spec: Path, design: Path, output: Path | None, as_json: bool) -> None:
    from frictool.documents.design import Design
    from frictool.documents.model import Model
    from frictool.documents.provenance import record
    from frictool.documents.registry import load, same_axis
    from frictool.documents.spec import Spec
    from frictool.documents.writing import to_yaml

    model_document, spec_document, design_document = load(model, Model), load(spec, Spec), load(design, Design)
    same_axis({model: model_document, spec: spec_document, design: design_document})
    from frictool.synth.design import design_controller
    from frictool.synth.disturbance import disturbance
    from frictool.synth.machine import machine
    from frictool.synth.text import text

    found = disturbance(model_document)
    inputs = [model, spec, design]
    provenance = record(command_line("synth", {"model": model, "--spec": spec, "--design": design}), inputs)
    controller = design_controller(model_document, spec_document, design_document, provenance)
    if output is not None:
        save_text(output, to_yaml(controller), inputs)
    if as_json:
        print_json(machine(controller, found), output)
    else:
        say(text(controller, found), output)
