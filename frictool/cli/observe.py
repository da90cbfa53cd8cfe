"""`frictool observe`: observers designed, and run along logs."""

from __future__ import annotations

import importlib

import click

# subcommand -> (module, one line for --help)
COMMANDS: dict[str, tuple[str, str]] = {
    "design": ("frictool.cli.observe_design", "Gains of an observer, verified (observer.yaml)."),
    "loop": ("frictool.cli.observe_loop", "A controller whose speed comes from an observer, verified with it."),
    "run": ("frictool.cli.observe_run", "Velocity, friction and wear along logs, with intervals, and a verdict."),
}

HELP = """\b
Example:
  frictool observe run model.yaml shift.mcap --wear-limit 1.25 -o estimates.mcap --plot wear.svg
  frictool observe run model.yaml fleet/ --wear-limit 1.25 -o fleet.csv --plot trend.svg
  frictool observe design model.yaml --kind tracking -o observer.yaml
  frictool observe loop controller.yaml --observer observer.yaml -o observed.yaml

Velocity, friction and wear of an actuator that runs, from its encoder and its drive.
"""


class LazyGroup(click.Group):
    """Knows its commands by name and imports one only when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command: click.Command = importlib.import_module(COMMANDS[cmd_name][0]).command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])


@click.group("observe", cls=LazyGroup, help=HELP)
def command() -> None:
    """Replaced by HELP."""
