"""`frictool synth`: model, specification and design to a verified controller."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import command_line, existing, json_option, output_option, print_json, save_text, say

if TYPE_CHECKING:
    from frictool.documents.controller import Controller
    from frictool.synth.disturbance import Disturbance

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
    from frictool.synth.disturbance import disturbance
    from frictool.synth.speed_cascade import design_controller

    found = disturbance(model_document)
    inputs = [model, spec, design]
    provenance = record(command_line("synth", {"model": model, "--spec": spec, "--design": design}), inputs)
    controller = design_controller(model_document, spec_document, design_document, provenance)
    if output is not None:
        save_text(output, to_yaml(controller), inputs)
    if as_json:
        print_json({**summary(controller), "disturbance": asdict(found) if found.total else None}, output)
    else:
        say("\n".join([table(controller), *disturbance_lines(found, model_document.parameters.offset.unit)]), output)


def disturbance_lines(found: Disturbance, unit: str) -> list[str]:
    """What the loop was not designed for and has to bear."""
    if found.total == 0.0:
        return []
    parts = [f"{name} {value:.4g}" for name in ("offset", "gravity", "ripple") if (value := getattr(found, name))]
    share = f"{100.0 * found.total / found.available:.2g} % of the {found.available:.4g} {unit} at the drive's limit"
    lines = [f"disturbance: up to {' + '.join(parts)} {unit}, {share}; the plants of the polytope are without it, simulate plays it"]
    if found.total >= found.breakaway:
        lines.append(f"  the least breakaway, {found.breakaway:.4g} {unit}, does not hold it: with the drive off the axis may move")
    return lines


def summary(controller: Controller) -> dict[str, Any]:
    """The machine's view of a controller."""
    verified = controller.verified
    return {
        "name": controller.name,
        "gamma": verified.gamma_asked,
        "gamma_verified": verified.gamma_verified,
        "domain": controller.domain,
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "order": len(controller.linear.discrete.a),
        "modulus_margin": min(vertex.modulus_margin for vertex in verified.vertices),
        "position_law": {"gain": controller.position_law.gain, "formula": controller.position_law.formula},
        "vertices": [
            {
                "name": vertex.name,
                "inertia": vertex.inertia,
                "viscous": vertex.viscous,
                "coulomb": vertex.coulomb,
                "constant": vertex.constant,
                "norm": vertex.norm,
                "modulus_margin": vertex.modulus_margin,
                "stable": vertex.stable,
                "by_delay": [
                    {"delay_samples": c.delay_samples, "modulus_margin": c.modulus_margin, "spectral_radius": c.spectral_radius}
                    for c in vertex.checks
                ],
            }
            for vertex in verified.vertices
        ],
    }


def table(controller: Controller) -> str:
    """The same for people."""
    verified, law = controller.verified, controller.position_law
    delays = [check.delay_samples for check in verified.vertices[0].checks]
    lines = [
        f"{controller.name}: order {len(controller.linear.discrete.a)}, {controller.sample_period_s * 1e3:g} ms, "
        f"{controller.delay_samples} sample(s) of delay; gamma asked {verified.gamma_asked:.4g}, verified {verified.gamma_verified:.4g}",
        f"position law: gain {law.gain:.4g} by {law.formula}, band {law.band:.4g}, {law.action}",
        "vertex  inertia    viscous    coulomb    constant   norm    " + "  ".join(f"margin (delay {d})" for d in delays),
    ]
    for v in verified.vertices:
        margins = "  ".join(f"{check.modulus_margin:16.3f}" for check in v.checks)
        lines.append(f"{v.name:<7} {v.inertia:<10.4g} {v.viscous:<10.4g} {v.coulomb:<10.4g} {v.constant:<10.4g} {v.norm:<7.4g} {margins}")
    worst = min(vertex.modulus_margin for vertex in verified.vertices)
    lines.append(
        f"verified: stable at all {len(verified.vertices)} vertices, modulus margin {worst:.3f} >= {verified.modulus_margin_specified:g}"
    )
    return "\n".join(lines)
