"""Options `--cores` and `--cluster`: distribution of independent jobs."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import click

F = TypeVar("F", bound=Callable[..., object])

cores_option = click.option(
    "--cores",
    type=click.IntRange(1),
    help="Number of processes that share the work. [default: number of cores]",
)


def workers_options(function: F) -> F:
    """Add the options `--cores` and `--cluster` to a command.

    The command receives them as parameters `cores` (int or None) and `cluster` (address or None).
    """
    cluster = click.option(
        "--cluster",
        metavar="ADDRESS",
        help=(
            "Address of a Dask scheduler whose workers share the work, tcp://HOST:PORT or "
            "tls://HOST:PORT."
        ),
    )
    return cores_option(cluster(function))


def refuse_both(cores: int | None, cluster: str | None) -> None:
    """Raise UsageError if --cores and --cluster are used together."""
    if cores is not None and cluster is not None:
        raise click.UsageError(
            "--cores applies to this machine only; the cluster has its own number of workers: "
            "leave out --cores or --cluster."
        )
