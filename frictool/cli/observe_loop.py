"""`frictool observe loop`: a controller with an observer for the speed, verified as one loop."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, existing, json_option, output_option
from frictool.cli.console_output import note_changes, print_json, say
from frictool.cli.output_files import command_line, save_text

if TYPE_CHECKING:
    from frictool.verify.observed_controller import ObservedController

HELP = """\b
Example:
  frictool observe loop controller.yaml --observer observer.yaml -o observed.yaml
  frictool simulate model.yaml --controller observed.yaml --scenario steps.yaml -o observed.mcap
  frictool export observed.yaml --lang c --number float -o c/

Replace the speed signal of a controller by the speed estimate of an observer, wherever the
controller uses a speed. The controller still uses the measured position.

If the speed feeds the linear controller, the loop changes: its margins are computed again at every
vertex with the observer inside, and the certificate of the former loop is removed. Exit code 4 if
the loop is unstable at a vertex or violates the specified modulus margin. The new controller runs
in simulate, export, verify and report.
"""


@click.command("loop", help=HELP)
@click.argument(
    "controller", help="Controller whose speed signal is replaced (controller.yaml).", type=existing
)
@click.option(
    "--observer",
    type=existing,
    required=True,
    help="Observer that provides the speed (observer.yaml).",
)
@click.option(
    "--modulus-margin",
    type=FiniteRange(0.0, 1.0),
    help="New specified modulus margin. [default: the controller's value]",
)
@output_option(
    required=False,
    help="New controller (YAML); - is stdout. Without it nothing is written.",
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

    observed = with_observer(load(controller, Controller), load(observer, Observer), modulus_margin)
    if observed.after is not None and observed.after < observed.specified:
        raise NoSolutionError(
            f"{controller}: not verified with the observer: modulus margin "
            f"{observed.after:.4f} at {observed.at}, specified {observed.specified:g}; try another "
            f"observer, a slower controller, or --modulus-margin {observed.after - 5e-3:.2f}"
        )
    words = {"controller": controller, "--observer": observer, "--modulus-margin": modulus_margin}
    merged = msgspec.structs.replace(
        observed.controller,
        provenance=provenance_of_command(
            command_line("observe loop", words), [controller, observer]
        ),
    )
    if output is not None:
        save_text(output, to_yaml(merged), [controller, observer])
    note_changes(controller, merged)
    if as_json:
        print_json("observe-loop/1", machine_view(observed), output)
    else:
        say("\n".join(observed.lines()), output)


def machine_view(observed: ObservedController) -> dict[str, Any]:
    """Return the controller with its observer as JSON values.

    Margins are None if no linear loop uses the speed.
    """
    velocity_observer = observed.controller.velocity.observer
    assert velocity_observer is not None
    return {
        "name": observed.controller.name,
        "observer": velocity_observer.kind,
        "modulus_margin": observed.after,
        "modulus_margin_without": observed.before,
        "modulus_margin_specified": observed.specified,
        "at": observed.at or None,
    }
