"""What `frictool simulate` tells of a run: for people, and for machines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictool.logs.log import Log

MOST_LINES = 40  # of streams that are told to people


def summary(log: Log) -> dict[str, Any]:
    """The machine's view of a step test: what each stream holds and how it ends. The verdict is `frictool report`'s."""
    streams = []
    plants = log.metadata.get("plants", {})
    for stream in log.streams:
        position, command = stream.signals["position"], stream.signals["command"]
        streams.append(
            {
                "topic": stream.topic,
                "samples": int(stream.time.size),
                "duration_s": round(float(stream.time[-1] - stream.time[0]) + stream.period, 9),
                "final_error": float(stream.signals["reference"][-1] - position[-1]),
                "command_peak": float(abs(command).max()),
                "at_rest": not stream.signals["velocity"][-max(1, stream.time.size // 10) :].any(),  # a limit cycle stands still in between
                "units": stream.units,
                **({"plant": plants[stream.topic]} if stream.topic in plants else {}),
            }
        )
    return {"scenario": log.source, "streams": streams, "warnings": list(log.warnings)}


def table(log: Log) -> str:
    """The same for people."""
    found = summary(log)["streams"]
    unit, drive = found[0]["units"]["position"], found[0]["units"]["command"]
    lines = [f"{log.source}: {len(found)} stream(s), {found[0]['samples']} samples, {found[0]['duration_s']:g} s each"]
    lines.append(f"{'stream':<14}{'final error ' + unit:>18}{'command peak ' + drive:>18}  end")
    for row in found[:MOST_LINES]:
        end = "at rest" if row["at_rest"] else "moving"
        lines.append(f"{row['topic']:<14}{row['final_error']:>18.4g}{row['command_peak']:>18.4g}  {end}")
    if len(found) > MOST_LINES:
        resting = sum(row["at_rest"] for row in found)
        lines.append(f"... and {len(found) - MOST_LINES} more; {resting} of {len(found)} end at rest; --json has them all")
    return "\n".join(lines)


def bench_summary(log: Log) -> dict[str, Any]:
    """The machine's view of a bench test that was played."""
    stream, position = log.main, log.main.signals["position"]
    return {
        "test": log.source,
        "samples": int(stream.time.size),
        "duration_s": round(float(stream.time[-1] - stream.time[0]) + stream.period, 9),
        "lowest": float(position.min()),
        "highest": float(position.max()),
        "units": stream.units,
    }


def bench_table(log: Log) -> str:
    """The same for people."""
    found = bench_summary(log)
    where = f"position from {found['lowest']:.4g} to {found['highest']:.4g} {found['units']['position']}"
    return f"{found['test']}: {found['samples']} samples, {found['duration_s']:g} s; {', '.join(found['units'])}; {where}"
