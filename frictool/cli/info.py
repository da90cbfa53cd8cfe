"""`frictool info`: what is in a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import STDOUT, existing, json_option, note, output_option, print_json, save_text

if TYPE_CHECKING:
    from frictool.logs.log import Log

HELP = """\b
Example:
  frictool info sines.mcap

Show a log's channels, rate, jitter, gaps and the encoder step that its positions show. A raw bench file needs --bench.
"""


@click.command("info", help=HELP)
@click.argument("log", type=existing)
@click.option("--bench", type=existing, help="The rig, and its columns (bench.yaml), where LOG is a raw bench file.")
@output_option(required=False)
@json_option
def command(log: Path, bench: Path | None, output: Path | None, as_json: bool) -> None:
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load

    document = None if bench is None else load(bench, Bench)
    from frictool.logs.reading import read_log

    found = read_log(log, document)
    for warning in found.warnings:
        note(f"warning: {warning}")
    facts = summary(found)
    if as_json:
        print_json(facts, output)
    if output is not None or not as_json:
        save_text(output or STDOUT, table(found, facts) + "\n", [log] if bench is None else [log, bench])


def summary(log: Log) -> dict[str, Any]:
    """The machine's view of a log: one row per signal."""
    from frictool.logs.mcap_layout import COLUMNS, message_path
    from frictool.logs.quality import encoder_step, time_base

    columns = log.metadata.get(COLUMNS, {})
    rows = []
    for stream in log.streams:
        base = time_base(stream.time)
        for name, values in stream.signals.items():
            rows.append(
                {
                    "name": name,
                    "source": stream.topic,
                    "column": columns.get(message_path(stream.topic, name)),
                    "unit": stream.units[name],
                    "samples": base.samples,
                    "rate_hz": base.rate_hz,
                    "jitter_s": base.jitter_s,
                    "gaps": base.gaps,
                    "low": float(values.min()),
                    "high": float(values.max()),
                }
            )
    position = next((stream.signals["position"] for stream in log.streams if "position" in stream.signals), None)
    return {
        "channels": rows,
        "duration_s": max(float(stream.time[-1] - stream.time[0]) for stream in log.streams),
        "encoder_step": None if position is None else encoder_step(position),
        "lost": [],  # a log that lost samples is not read at all
    }


def table(log: Log, facts: dict[str, Any]) -> str:
    """The same for people."""
    lines = [f"{Path(log.source).name}: {facts['duration_s']:.6g} s"]
    lines.append(f"{'channel':<24} {'unit':<8} {'samples':>9} {'rate [Hz]':>10} {'jitter [s]':>10} {'gaps':>5}  range")
    for row in facts["channels"]:
        channel = f"{row['source']}.{row['name']}"
        numbers = f"{row['samples']:>9} {row['rate_hz']:>10.6g} {row['jitter_s']:>10.2g} {row['gaps']:>5}"
        lines.append(f"{channel:<24} {row['unit']:<8} {numbers}  {row['low']:.6g} to {row['high']:.6g}")
    lines += _encoder_step(log, facts["encoder_step"])
    lines += [f"{key}: {text}" for key, text in log.metadata.get("provenance", {}).items()]
    return "\n".join(lines)


def _encoder_step(log: Log, step: float | None) -> list[str]:
    """The line on the encoder step, or why none is seen; no line where the log has no position."""
    from frictool.logs.quality import FEWEST_LEVELS, levels

    stream = next((stream for stream in log.streams if "position" in stream.signals), None)
    if stream is None:
        return []
    if step is not None:
        return [f"encoder step: {step:.6g} {stream.units['position']}"]
    seen = levels(stream.signals["position"])
    if seen == 1:
        return ["encoder step: none seen, the position does not change"]
    if seen < FEWEST_LEVELS:
        return [f"encoder step: none seen, the position takes {seen} values; at least {FEWEST_LEVELS} are needed to tell"]
    return ["encoder step: none seen, positions lie on no lattice"]
