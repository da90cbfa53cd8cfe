"""`frictool verify`: check of a controller's certificate, or of the proof of a step test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.common_options import existing, json_option
from frictool.cli.console_output import print_json, say
from frictool.cli.progress import progress

if TYPE_CHECKING:
    from frictool.documents.proof import Proof

HELP = """\b
Example:
  frictool verify controller.yaml
  frictool verify controller.yaml --model model.yaml
  frictool verify proof.yaml

Prove the certificate of a controller again, for every plant with constant parameters within its
intervals, and compute all stored properties of its loop again.

The loop is built from the stored coefficients, sampled at the bench's period with its delay. The
bounds of the certificate are proved for every frequency and plant, without solver, grid or digest,
and with every rounding error bounded. Parameters that vary with time are not covered. The
certificate's intervals must contain the bench's intervals. Norms and margins at the vertices, also
computed with rounded coefficients, and norms inside the intervals must agree with `verified`.
Digests reveal changes of blocks on which no stored property depends (position law, prefilter).
Results of a solver are listed as not computed.

With --model, three more conditions are checked: the model lies within the verified intervals, its
bench has the controller's drive limit, winding and encoder, and the loop has the specified modulus
margin at every vertex of the model's intervals, also with the model's resonances and spring.
Properties of the model that no margin covers are listed.

If the axis rings, the loop must also be stable and have the margin on plants of two
inertias with this oscillation; otherwise the result is undecided.

A proof.yaml of `frictool prove` is proved again from the documents in it; every stored value must
follow from them.

Exit codes: 0 everything holds; 1 there is no certificate, a stored property differs from the value
that the coefficients give, a block was changed, a condition of --model fails, or the result is
undecided; 4 a bound is not proved, or a loop is unstable or violates the specified margin. For a
proof: 0 the proof is confirmed; 1 a value differs, or a requirement is not proved.
"""


@click.command("verify", help=HELP)
@click.argument(
    "document", type=existing, help="Controller or proof to verify (controller.yaml, proof.yaml)."
)
@click.option(
    "--model", type=existing, help="Model that the controller must be verified for (model.yaml)."
)
@json_option
@click.pass_context
def command(ctx: click.Context, document: Path, model: Path | None, as_json: bool) -> None:
    from frictool.documents.controller import Controller
    from frictool.documents.document_text import is_format
    from frictool.documents.model import Model
    from frictool.documents.proof import Proof
    from frictool.documents.registry import load
    from frictool.errors import EXIT_NO

    if is_format(document, "proof"):
        if model is not None:
            raise click.UsageError(
                "--model works with a controller only; a proof contains the model."
            )
        _verify_proof(ctx, load(document, Proof), as_json)
        return
    from frictool.verify.recheck import verify
    from frictool.verify.verification_view import json_view, lines

    verification = verify(load(document, Controller), None if model is None else load(model, Model))
    if as_json:
        print_json("verify/1", json_view(verification))
    else:
        say("\n".join(lines(verification)))
    if not verification.holds:
        ctx.exit(EXIT_NO)


def _verify_proof(ctx: click.Context, proof: Proof, as_json: bool) -> None:
    from frictool.errors import EXIT_NO
    from frictool.prove.proof_view import confirmation, json_view, verdict_of
    from frictool.prove.step_proof import differences, prove_again
    from frictool.verify.recheck import recheck

    recheck(proof.controller)
    with progress("plants") as show:
        again = prove_again(proof, show)
    differing = differences(proof, again)
    if as_json:
        print_json("prove/1", json_view(again, differing))
    else:
        say("\n".join(confirmation(again, differing)))
    if differing or verdict_of(again) != "proved":
        ctx.exit(EXIT_NO)
