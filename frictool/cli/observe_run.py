"""`frictool observe run`."""

from __future__ import annotations

import click


@click.command("run")
def command() -> None:
    """Being built."""
