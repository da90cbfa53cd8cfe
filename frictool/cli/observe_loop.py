"""`frictool observe loop`: a controller with an observer for its speed, verified together."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import (
    FiniteRange,
    command_line,
    existing,
    json_option,
    note_changes,
    output_option,
    print_json,
    save_text,
    say,
)

if TYPE_CHECKING:
    from frictool.verify.observed_controller import ObservedController

HELP = """\b
Example:
  frictool observe loop controller.yaml --observer observer.yaml -o observed.yaml
  frictool simulate model.yaml --controller observed.yaml --scenario scenarios/steps.yaml -o observed.mcap
  frictool export observed.yaml --lang c --number float -o c/

Give a controller its speed from an observer in place of the encoder's difference: in a speed error, a brake, the energy of a limiter,
virtual friction, friction compensation, the bound of a winding. Positions, and eta, which is an integral less the position, stay measured.

The loop with the observer is another loop: where the speed feeds the linear controller, its margins are found again at every vertex with
the observer inside, and what was certified of the old loop is taken out. Exit 4 where it is unstable at a vertex, or below the modulus
margin that was specified; --modulus-margin specifies another. What is written runs in simulate, export, verify and report.
"""


@click.command("loop", help=HELP)
@click.argument(
    "controller", help="Controller whose speed signal is replaced (controller.yaml).", type=existing
)
@click.option(
    "--observer",
    type=existing,
    required=True,
    help="What the controller takes for the speed (observer.yaml).",
)
@click.option(
    "--modulus-margin",
    type=FiniteRange(0.0, 1.0),
    help="Specified from now on.  [default: the controller's]",
)
@output_option(
    required=False,
    help="The controller with it (YAML); - is stdout. Without it nothing is written.",
    writes=("YAML",),
)
@json_option
def command(
    controller: Path,
    observer: Path,
    modulus_margin: float | None,
    output: Path | None,
    as_json: bool,
) -> None:
    import msgspec

    from frictool.documents.controller import Controller
    from frictool.documents.observer import Observer
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.writing import to_yaml
    from frictool.errors import NoSolutionError
    from frictool.verify.observed_controller import with_observer

    found = with_observer(load(controller, Controller), load(observer, Observer), modulus_margin)
    if found.after is not None and found.after < found.specified:
        raise NoSolutionError(
            f"{controller}: not verified with the observer: modulus margin "
            f"{found.after:.4f} at vertex {found.at}, specified "
            f"{found.specified:g}; try an observer of another bandwidth, a slower "
            f"controller, or --modulus-margin {found.after - 5e-3:.2f}"
        )
    words = {"controller": controller, "--observer": observer, "--modulus-margin": modulus_margin}
    merged = msgspec.structs.replace(
        found.controller,
        provenance=provenance_of_command(
            command_line("observe loop", words), [controller, observer]
        ),
    )
    if output is not None:
        save_text(output, to_yaml(merged), [controller, observer])
    note_changes(controller, merged)
    if as_json:
        print_json(machine_view(found), output)
    else:
        say("\n".join(found.told()), output)


def machine_view(found: ObservedController) -> dict[str, Any]:
    """Return the merged controller as JSON values.

    Margins are None if no linear loop uses the speed.
    """
    own = found.controller.velocity.observer
    assert own is not None
    return {
        "name": found.controller.name,
        "observer": own.kind,
        "modulus_margin": found.after,
        "modulus_margin_without": found.before,
        "modulus_margin_specified": found.specified,
        "at": found.at or None,
    }
