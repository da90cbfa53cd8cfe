"""Summary of a simulated mechanism: blocks, contacts, events and energies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from frictool.logs.log import Log, Stream

MOST_EVENTS = 12  # largest number of event kinds in the text
POSITION, VELOCITY, STUCK, CONTACT = "_position", "_velocity", "_stuck", "_contact"


def blocks_of(log: Log, stream: Stream) -> dict[str, Any]:
    """Summarise blocks, contacts, energies and events of a simulated mechanism as JSON values.

    `stream`: stream `/mechanism` or `/mechanism/NAME` of one variant.
    """
    names = [name.removesuffix(POSITION) for name in stream.signals if name.endswith(POSITION)]
    contacts = [name.removesuffix(CONTACT) for name in stream.signals if name.endswith(CONTACT)]
    records = {name: log.metadata.get(f"{name}{stream.topic}", {}) for name in ("energy", "events")}
    return {
        "topic": stream.topic,
        "samples": int(stream.time.size),
        "duration_s": round(stream.time.size * stream.period, 9) if stream.time.size > 1 else 0.0,
        "blocks": [_block(stream, name) for name in names if name + VELOCITY in stream.signals],
        "contacts": [_contact(stream, name) for name in contacts],
        "energy_J": {name: float(value) for name, value in records["energy"].items()},
        "events": {name: int(count) for name, count in records["events"].items()},
    }


def _block(stream: Stream, name: str) -> dict[str, Any]:
    position, velocity, stuck = (
        stream.signals.get(name + one) for one in (POSITION, VELOCITY, STUCK)
    )
    assert position is not None
    assert velocity is not None
    summary = {
        "block": name,
        "lowest": float(position.min()),
        "highest": float(position.max()),
        "unit": stream.units[name + POSITION],
        "top_speed": float(abs(velocity).max()),
    }
    return summary | ({} if stuck is None else {"stuck": float(stuck.mean())})


def _contact(stream: Stream, name: str) -> dict[str, Any]:
    side = stream.signals[name + CONTACT]
    return {
        "link": name,
        "low": float((side < 0.0).mean()),
        "free": float((side == 0.0).mean()),
        "high": float((side > 0.0).mean()),
    }


def block_lines(summary: dict[str, Any]) -> list[str]:
    """Return the summary of `blocks_of` as lines of text."""
    lines = [
        f"{summary['topic']:<14}{'lowest':>12}{'highest':>12}      {'top speed':>12}      "
        f"  {'stuck':>7}"
    ]
    for row in summary["blocks"]:
        stuck = f"{row['stuck']:>7.0%}" if "stuck" in row else f"{'-':>7}"
        unit = row["unit"]
        lines.append(
            f"  {row['block']:<12}{row['lowest']:>12.4g}{row['highest']:>12.4g} "
            f"{unit:<5}{row['top_speed']:>12.4g} {unit + '/s':<7}{stuck}"
        )
    lines += [_contact_line(row) for row in summary["contacts"]]
    lines += _event_lines(summary["events"])
    energy = summary["energy_J"]
    if energy:
        lost = {
            name.removeprefix("lost in "): value
            for name, value in energy.items()
            if name.startswith("lost in ")
        }
        losses = ", ".join(
            f"{name} {value:.4g}"
            for name, value in sorted(lost.items(), key=lambda one: -abs(one[1]))
        )
        lines.append(
            f"  energy in J: put in {energy['input']:.6g}; kinetic "
            f"{energy['kinetic']:.4g}, stored {energy['stored']:.4g}"
            f", lost {sum(lost.values()):.6g}{f' ({losses})' if losses else ''}; residual "
            f"{energy['residual']:.1e}"
        )
    return lines


def _contact_line(row: dict[str, Any]) -> str:
    return (
        f"  {row['link']}: at its low side {row['low']:.0%} of the time, free "
        f"{row['free']:.0%}, at its high side {row['high']:.0%}"
    )


def _event_lines(events: dict[str, int]) -> list[str]:
    if not events:
        return []
    often = sorted(events.items(), key=lambda one: -one[1])
    counts = ", ".join(f"{name} {count}" for name, count in often[:MOST_EVENTS])
    more = f", and {len(often) - MOST_EVENTS} more kinds" if len(often) > MOST_EVENTS else ""
    return [f"  events: {counts}{more}"]
