"""`frictool verify`: the proof of a controller's certificate, again, without a solver."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import existing, json_option, print_json, say

if TYPE_CHECKING:
    from frictool.documents.controller import Controller
    from frictool.verify.certificate import Proved

HELP = """\b
Example:
  frictool verify controller.yaml

Prove again what a controller's certificate states, for every constant plant of its intervals and not only at their corners.

The loop is built from the stored coefficients, sampled at the bench's period with its delay. The matrix inequalities of the certificate are
proved with whole numbers: no solver, no rounding and no digest takes part. The margins that the document states are found again too, and
that the other stored forms (second-order sections, continuous form) are of the same controller, with a stable anti-windup.

Exit codes: 0 proved; 1 the controller has no certificate; 4 an inequality does not hold, or a margin is not what the document says.
"""


@click.command("verify", help=HELP)
@click.argument("controller", type=existing)
@json_option
@click.pass_context
def command(ctx: click.Context, controller: Path, as_json: bool) -> None:
    from frictool.documents.controller import Controller
    from frictool.documents.registry import load
    from frictool.errors import EXIT_NO
    from frictool.verify.again import verify

    document = load(controller, Controller)
    proved = verify(document)
    if document.certificate is None or not document.certificate.bounds:
        reasons = {} if document.certificate is None else document.certificate.not_proved
        if as_json:
            print_json({"name": document.name, "certificate": None, "not_proved": reasons})
        else:
            why = "; ".join(reasons.values()) or "frictool synth makes one"
            say(f"{document.name}: no certificate, so that only the margins at its vertices hold ({why})")
        ctx.exit(EXIT_NO)
    if as_json:
        print_json(machine_view(document, proved))
    else:
        say("\n".join(lines(document, proved)))


def machine_view(controller: Controller, proved: tuple[Proved, ...]) -> dict[str, Any]:
    """The machine's view of what is proved."""
    from dataclasses import asdict

    certificate = controller.certificate
    assert certificate is not None
    box = certificate.box
    return {
        "name": controller.name,
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "certificate": [
            {**asdict(one), "modulus_margin_above": 1.0 / one.below if one.of == "sensitivity" else None, "stable": True} for one in proved
        ],
        "box": {name: list(getattr(box, name)) for name in ("inertia", "viscous", "coulomb", "constant")},
        "not_proved": certificate.not_proved,
        "vertices_rechecked": len(controller.verified.vertices),
    }


def lines(controller: Controller, proved: tuple[Proved, ...]) -> list[str]:
    """The same for people."""
    from frictool.documents.quantity import drive_dimension, si_unit

    certificate = controller.certificate
    assert certificate is not None
    delay = controller.delay_samples
    found = [f"{controller.name}: proved for every constant"]
    dimensions = {
        "inertia": "inertia",
        "viscous": "viscous",
        "coulomb": "effort",
        "constant": drive_dimension(controller.drive, constant=True),
    }
    for name, dimension in dimensions.items():
        low, high = getattr(certificate.box, name)
        found.append(f"  {name:<9} {low:.6g} to {high:.6g} {si_unit(dimension, controller.axis)}")
    found.append(
        f"the loop as it runs ({controller.sample_period_s * 1e3:g} ms, {delay} sample{'s' if delay != 1 else ''} of delay) is stable, and"
    )
    for one in proved:
        what = "norm from the weighted inputs to the weighted outputs" if one.of == "norm" else "largest sensitivity"
        margin = f", so that the modulus margin is above {1.0 / one.below:.3f}" if one.of == "sensitivity" else ""
        found.append(f"  {what} < {one.below:.6g}{margin} ({one.cells} cell{'s' if one.cells != 1 else ''})")
    found += [f"not proved: {reason}" for reason in certificate.not_proved.values()]
    found.append(f"margins found again at {len(controller.verified.vertices)} vertices")
    return found
