"""Summary of a simulation, as text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from frictool.cli.mechanism_summary import block_lines, blocks_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from frictool.logs.log import Log, Stream

    Vector = NDArray[np.float64]

STANDING = 1e-9  # speed below which an axis is at rest, relative to the highest speed of the run
MOST_LINES = 40  # largest number of streams in the text
MOST_MECHANISMS = 1  # largest number of mechanisms shown block by block


def summary(log: Log) -> dict[str, Any]:
    """Return the summary of a simulated scenario as JSON values, without a verdict."""
    from frictool.logs.log import MECHANISM_TOPIC

    plants = log.metadata.get("plants", {})
    streams = [
        _axis(stream) | ({"plant": plants[stream.topic]} if stream.topic in plants else {})
        for stream in log.axes
    ]
    mechanisms = [
        blocks_of(log, stream) for stream in log.streams if stream.topic.startswith(MECHANISM_TOPIC)
    ]
    view = {"scenario": log.source, "streams": streams, "warnings": list(log.warnings)}
    return view | ({"mechanisms": mechanisms} if mechanisms else {})


def _axis(stream: Stream) -> dict[str, Any]:
    position, command, reference = (
        stream.signals.get(name) for name in ("position", "command", "reference")
    )
    assert position is not None
    assert command is not None
    end = (
        {"final_position": float(position[-1])}
        if reference is None
        else {"final_error": float(reference[-1] - position[-1])}
    )
    return {
        "topic": stream.topic,
        "samples": int(stream.time.size),
        "duration_s": _duration(stream),
        **end,
        "command_peak": float(abs(command).max()),
        "at_rest": _rests(stream.signals["velocity"]),
        "units": stream.units,
    }


def _rests(velocity: Vector) -> bool:
    """Return True if nothing moves in the last tenth of the simulation, within rounding.

    The last sample alone is not sufficient: in a limit cycle, the axis stands still between jumps.
    """
    speed = abs(velocity)
    return bool(speed[-max(1, speed.size // 10) :].max() <= STANDING * speed.max())


def _duration(stream: Stream) -> float:
    if stream.time.size < 2:
        return 0.0
    return round(float(stream.time[-1] - stream.time[0]) + stream.period, 9)


def run_text(log: Log) -> str:
    """Return the summary of a simulated scenario as text."""
    view = summary(log)
    rows = view["streams"]
    mechanisms = view.get("mechanisms", [])
    first = (rows or mechanisms)[0]
    count = len(rows) or len(mechanisms)
    runs = f"{count} streams, each" if count > 1 else "1 stream"
    lines = [f"{log.source}: {runs} of {first['samples']} samples, {first['duration_s']:g} s"]
    if rows:
        unit = first["units"]["position"]
        drive = first["units"]["command"]
        key = "final_error" if "final_error" in first else "final_position"
        lines.append(
            f"{'stream':<14}{key.replace('_', ' ') + ' ' + unit:>20}"
            f"{'command peak ' + drive:>18}  end"
        )
    for row in rows[:MOST_LINES]:
        end = "at rest" if row["at_rest"] else "moving"
        lines.append(f"{row['topic']:<14}{row[key]:>20.4g}{row['command_peak']:>18.4g}  {end}")
    if len(rows) > MOST_LINES:
        resting = sum(row["at_rest"] for row in rows)
        lines.append(
            f"... and {len(rows) - MOST_LINES} more; {resting} of {len(rows)} end at "
            "rest; --json has them all"
        )
    for one in mechanisms[:MOST_MECHANISMS]:
        lines += block_lines(one)
    if len(mechanisms) > MOST_MECHANISMS:
        worst = max(abs(one["energy_J"]["residual"]) for one in mechanisms)
        lines.append(
            f"... and {len(mechanisms) - MOST_MECHANISMS} more mechanisms; energy "
            f"residual at most {worst:.2g} J; --json has them all"
        )
    return "\n".join(lines)


def bench_summary(log: Log) -> dict[str, Any]:
    """Return the summary of a simulated bench test as JSON values."""
    stream = log.main
    position = log.main.signals["position"]
    return {
        "test": log.source,
        "samples": int(stream.time.size),
        "duration_s": _duration(stream),
        "lowest": float(position.min()),
        "highest": float(position.max()),
        "units": stream.units,
    }


def bench_text(log: Log) -> str:
    """Return the summary of a simulated bench test as text."""
    view = bench_summary(log)
    where = (
        f"position from {view['lowest']:.4g} to {view['highest']:.4g} {view['units']['position']}"
    )
    return (
        f"{view['test']}: {view['samples']} samples, {view['duration_s']:g} s; "
        f"{', '.join(view['units'])}; {where}"
    )
