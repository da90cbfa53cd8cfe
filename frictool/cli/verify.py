"""`frictool verify`: repeated proof of a controller's certificate without a solver."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import existing, json_option
from frictool.cli.console_output import print_json, say

if TYPE_CHECKING:
    from frictool.documents.controller import Controller
    from frictool.verify.certificate_proof import ProvedBound
    from frictool.verify.model_check import ModelCheck
    from frictool.verify.recheck import Verification

HELP = """\b
Example:
  frictool verify controller.yaml
  frictool verify controller.yaml --model model.yaml

Prove the certificate of a controller again, for every constant plant of its intervals, and compute
all stored properties of its loop again.

The loop is built from the stored coefficients, sampled at the bench's period with its delay. The
matrix inequalities of the certificate are proved in integer arithmetic, without solver, rounding or
digest. The certificate's intervals must contain those of the bench. Norms, margins and rounded
forms at the vertices, and the norms inside the intervals, must agree with `verified`. Digests show
changed blocks that no stored property depends on (position law, prefilter). Results of a solver are
listed as not computed.

With --model, three more conditions are checked: the model lies within the verified intervals, its
bench has the controller's drive limit, winding and encoder, and the loop has the specified modulus
margin at every vertex of the model's intervals, also with the model's resonances. Properties of the
model that no margin covers are listed.

Exit codes: 0 everything holds; 1 there is no certificate, a stored property differs from that of
the coefficients, a block was changed, or a condition of --model fails; 4 a bound is not proved, or
a loop is unstable or violates the specified margin.
"""

NAMES = ("inertia", "viscous", "coulomb", "constant")
MOST_LINES = 12  # differences that the text lists


@click.command("verify", help=HELP)
@click.argument("controller", type=existing, help="Controller to verify (controller.yaml).")
@click.option(
    "--model", type=existing, help="Model that the controller must be verified for (model.yaml)."
)
@json_option
@click.pass_context
def command(ctx: click.Context, controller: Path, model: Path | None, as_json: bool) -> None:
    from frictool.documents.controller import Controller
    from frictool.documents.registry import load
    from frictool.errors import EXIT_NO
    from frictool.verify.recheck import verify

    document = load(controller, Controller)
    checked = None if model is None else _checked(document, model)
    verification = verify(document)
    if as_json:
        print_json(
            "verify/1", {**json_view(document, verification), "model": model_json_view(checked)}
        )
    else:
        say("\n".join([*lines(document, verification), *model_lines(document, checked)]))
    if (
        not verification.proved
        or not verification.unaltered
        or (checked is not None and not checked.holds)
    ):
        ctx.exit(EXIT_NO)


def _checked(controller: Controller, path: Path) -> ModelCheck:
    from frictool.documents.model import Model
    from frictool.documents.registry import load
    from frictool.verify.model_check import check_model

    return check_model(controller, load(path, Model))


def model_json_view(checked: ModelCheck | None) -> dict[str, Any] | None:
    """Return the check of the model as JSON values; None without a model."""
    if checked is None:
        return None
    plant = {name: getattr(checked.plant, name) for name in NAMES}
    figures = {
        "modulus_margin": checked.margin,
        "modulus_margin_with_resonances": None
        if checked.resonant is None
        else checked.resonant.modulus_margin,
        "modulus_margin_specified": checked.specified,
    }
    view = {
        "holds": checked.holds,
        "outside": list(checked.beyond),
        **figures,
        "at": plant,
        "plants": checked.plants,
    }
    return {**view, "outside_margins": list(checked.outside_margins)}


def model_lines(controller: Controller, checked: ModelCheck | None) -> list[str]:
    """Return the check of the model as lines of text."""
    from frictool.verify.loop_wording import plant_words

    if checked is None:
        return []
    output = [
        f"model: not what the controller was verified for: {phrase}" for phrase in checked.beyond
    ]
    output += (
        []
        if checked.beyond
        else [
            "model: within the controller's intervals, with its timing, drive limit, "
            "winding and encoder"
        ]
    )
    at = f"at {plant_words(checked.plant, controller.bench)}"
    output.append(
        f"model: smallest modulus margin of {checked.plants} corners "
        f"{checked.margin:.4f}, specified {checked.specified:g}, {at}"
    )
    if (worst := checked.resonant) is not None:
        output.append(
            f"model: with its resonances {worst.modulus_margin:.4f}, specified "
            f"{checked.specified:g}, at {worst.where}"
        )
    output.append(
        "model: nonlinear, so that no margin covers it, but simulate does: "
        f"{', '.join(checked.outside_margins)}"
    )
    return output


def json_view(controller: Controller, verification: Verification) -> dict[str, Any]:
    """Return the verification as JSON values."""
    from dataclasses import asdict

    certificate = controller.certificate
    bounds = [
        {
            **asdict(one),
            "modulus_margin_above": 1.0 / one.below if one.of == "sensitivity" else None,
            "stable": True,
        }
        for one in verification.proved
    ]
    return {
        "name": controller.name,
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "certificate": bounds or None,
        "box": None
        if certificate is None
        else {name: list(getattr(certificate.box, name)) for name in NAMES},
        "not_proved": {} if certificate is None else certificate.not_proved,
        "vertices_rechecked": len(controller.verified.vertices),
        "differences": [asdict(one) for one in verification.differences],
        "changed": list(verification.changed),
        "not_computed": verification.not_computed,
    }


def lines(controller: Controller, verification: Verification) -> list[str]:
    """Return the verification as lines of text."""
    return [*_proved(controller, verification.proved), *_computed(controller, verification)]


def _proved(controller: Controller, proved: tuple[ProvedBound, ...]) -> list[str]:
    from frictool.documents.quantity import drive_dimension, si_unit

    certificate = controller.certificate
    if certificate is None or not proved:
        reasons = () if certificate is None else certificate.not_proved.values()
        why = "; ".join(reasons) or "frictool synth makes one"
        return [
            f"{controller.name}: no certificate, so that only the margins at its "
            f"vertices hold ({why})"
        ]
    delay = controller.delay_samples
    output = [f"{controller.name}: proved for every constant"]
    constant = drive_dimension(controller.drive, constant=True)
    for name, dimension in zip(NAMES, ("inertia", "viscous", "effort", constant), strict=True):
        low, high = getattr(certificate.box, name)
        output.append(f"  {name:<9} {low:.6g} to {high:.6g} {si_unit(dimension, controller.axis)}")
    output.append(
        f"the loop as it runs ({controller.sample_period_s * 1e3:g} ms, {delay} "
        f"sample{'s' if delay != 1 else ''} of delay) is stable, and"
    )
    for one in proved:
        what = (
            "norm from the weighted inputs to the weighted outputs"
            if one.of == "norm"
            else "largest sensitivity"
        )
        margin = (
            f", so that the modulus margin is above {1.0 / one.below:.3f}"
            if one.of == "sensitivity"
            else ""
        )
        output.append(
            f"  {what} < {one.below:.6g}{margin} ({one.cells} cell{'s' if one.cells != 1 else ''})"
        )
    return [*output, *(f"not proved: {reason}" for reason in certificate.not_proved.values())]


def _computed(controller: Controller, verification: Verification) -> list[str]:
    """Return the lines on the stored figures: all agree, or the list of those that do not."""
    output = []
    differences = verification.differences
    if not differences:
        inside = "" if controller.verified.robustness is None else " and inside the box"
        output.append(
            f"figures computed again at {len(controller.verified.vertices)} "
            f"vertices{inside}: all as stored"
        )
    shown = differences[:MOST_LINES]
    output += [
        f"{one.key}: found {_shown(one.stored)}, the coefficients give {_shown(one.computed)}"
        for one in shown
    ]
    if len(differences) > MOST_LINES:
        output.append(
            f"... and {len(differences) - MOST_LINES} more figures that differ from those "
            "of the coefficients (--json lists them)"
        )
    if not controller.verified.digests:
        output.append(
            "verified.digests: missing; a change of the position law or the prefilter "
            "cannot be detected; run synth again"
        )
    elif verification.changed:
        output.append(
            f"changed after verification: {', '.join(verification.changed)}; run synth again"
        )
    if verification.not_computed:
        names = ", ".join(name.removeprefix("verified.") for name in verification.not_computed)
        output.append(f"not computed again, as they come from the design or from a solver: {names}")
    return output


def _shown(value: Any) -> str:
    return (
        "nothing" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
    )
