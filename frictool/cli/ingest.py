"""`frictool ingest`: bench files to the canonical log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import command_line, existing, json_option, note, output_option, print_json, replacing, say

if TYPE_CHECKING:
    from frictool.logs.log import Log

HELP = """\b
Example:
  frictool ingest sines.csv --bench bench.yaml -o sines.mcap

Turn bench files into the canonical log (MCAP), which Foxglove, PlotJuggler and ROS 2 tools open as it is.

RAW is CSV with a header `name [unit]`, a MATLAB file up to version 7, or a canonical log, which passes through. `columns` of the bench says
which column is which channel; everything is converted to SI. The first file becomes /axis, each further one of the same rig /axis/NAME.
"""


@click.command("ingest", help=HELP)
@click.argument("raw", type=existing, nargs=-1, required=True)
@click.option("--bench", type=existing, required=True, help="The rig, and its columns (bench.yaml).")
@output_option()
@json_option
def command(raw: tuple[Path, ...], bench: Path, output: Path, as_json: bool) -> None:
    from frictool.documents.bench import Bench
    from frictool.documents.provenance import record
    from frictool.documents.registry import load

    document = load(bench, Bench)
    from frictool.logs.mcap_format import write_mcap
    from frictool.logs.provenance import with_provenance
    from frictool.logs.reading import read_logs

    log = read_logs(list(raw), document)
    for warning in log.warnings:
        note(f"warning: {warning}")
    inputs = [*raw, bench]
    log = with_provenance(log, record(command_line("ingest", {"raw": raw, "--bench": bench}), inputs))
    with replacing(output, inputs) as stream:
        write_mcap(log, stream)
    if as_json:
        print_json(summary(log), output)
    else:
        say(table(log), output)


def summary(log: Log) -> dict[str, Any]:
    """The machine's view of what was ingested."""
    from frictool.logs.quality import time_base

    streams = []
    for stream in log.streams:
        base = time_base(stream.time)
        streams.append(
            {
                "topic": stream.topic,
                "channels": {name: stream.units[name] for name in stream.signals},
                "samples": base.samples,
                "rate_hz": base.rate_hz,
                "duration_s": base.duration_s,
                "gaps": base.gaps,
            }
        )
    return {"streams": streams, "warnings": list(log.warnings)}


def table(log: Log) -> str:
    """The same for people."""
    lines = []
    for stream in summary(log)["streams"]:
        channels = ", ".join(f"{name} [{unit}]" for name, unit in stream["channels"].items())
        lines.append(f"{stream['topic']}: {channels}")
        rate = f"{stream['rate_hz']:.6g} Hz" if stream["samples"] > 1 else "one sample"
        lines.append(f"  {stream['samples']} samples, {rate}, {stream['duration_s']:.6g} s, {stream['gaps']} gaps")
    return "\n".join(lines)
