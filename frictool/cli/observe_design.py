"""`frictool observe design`."""

from __future__ import annotations

import click


@click.command("design")
def command() -> None:
    """Being built."""
