"""`frictool observe`: design of observers, and estimates of velocity, friction and wear."""

from __future__ import annotations

import click

from frictool.cli.lazy_group import LazyGroup

# subcommand -> (module, one line for --help)
COMMANDS: dict[str, tuple[str, str]] = {
    "design": ("frictool.cli.observe_design", "Design and verify an observer (observer.yaml)."),
    "loop": (
        "frictool.cli.observe_loop",
        "Replace a controller's speed signal by an observer, and verify the loop.",
    ),
    "run": (
        "frictool.cli.observe_run",
        "Estimate velocity, friction and wear along logs, with a verdict.",
    ),
}

HELP = """\b
Example:
  frictool observe run model.yaml shift.mcap --wear-limit 1.25 -o estimates.mcap --plot wear.svg
  frictool observe run model.yaml fleet/ --wear-limit 1.25 -o fleet.csv --plot trend.svg
  frictool observe design model.yaml --kind tracking -o observer.yaml
  frictool observe loop controller.yaml --observer observer.yaml -o observed.yaml

Estimate velocity, friction and wear of a running actuator from its encoder and its drive.
"""


@click.group("observe", cls=LazyGroup, table=COMMANDS, help=HELP)
def command() -> None:
    """Group of the subcommands of `frictool observe`."""
