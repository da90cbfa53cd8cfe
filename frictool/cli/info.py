"""`frictool info`: what is in a log."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import STDOUT, existing, json_option, note, output_option, print_json, save_text
from frictool.cli.window import window_of, window_options

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.logs.assembly import Assembly, Window
    from frictool.logs.quality.survey import Signal, Survey

HELP = """\b
Example:
  frictool info sines.mcap

Show what a log holds and what it is good for: channels, rate and jitter, gaps, the step of the encoder and of every other signal,
velocities, saturation (flat tops), signals that are held, the kind of test, whether effort and motion have one sign, what was lost on the
way, and which methods of identification it can feed. A raw bench file needs --bench; with it, samples at the actuator's limit are counted.
- is standard input.
"""


@click.command("info", help=HELP)
@click.argument("log", type=existing)
@click.option("--bench", type=existing, help="The rig, and its columns (bench.yaml), where LOG is a raw bench file.")
@window_options
@output_option(required=False)
@json_option
def command(log: Path, bench: Path | None, start: float | None, end: float | None, output: Path | None, as_json: bool) -> None:
    from frictool.cli.standard_input import kept
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load

    document = None if bench is None else load(bench, Bench)
    import numpy as np

    window = window_of(start, end)
    with kept([log]) as (path,), np.errstate(over="ignore", invalid="ignore"):  # numbers near the largest that there are
        made, surveys = _surveyed(path, document, window)
        facts = summary(made, surveys)
    for warning in made.warnings:
        if warning not in facts["odd"]:
            note(f"warning: {warning}")
    if as_json:
        print_json(facts, output)
    if output is not None or not as_json:
        save_text(output or STDOUT, table(made, surveys, facts) + "\n", [log] if bench is None else [log, bench])


def _surveyed(path: Path, bench: Bench | None, window: Window) -> tuple[Assembly, list[Survey]]:
    """A log of any length, and what its samples show, in bounded memory: it is read twice."""
    from frictool.logs.assembly import assemble, begun
    from frictool.logs.quality.survey import survey

    limits: dict[str, float] = {} if bench is None else {bench.actuator.drive: bench.actuator.limit.value}
    made = assemble([path], bench)
    places = range(len(begun(made, window)))

    def stream(place: int) -> Survey:
        return survey(begun(made, window)[place].head, lambda: begun(made, window)[place].samples, limits)

    return made, [stream(place) for place in places]


def summary(made: Assembly, surveys: list[Survey]) -> dict[str, Any]:
    """The machine's view of a log: one row per signal, and what is said of it as a whole."""
    from frictool.identify.feeds import feeds
    from frictool.logs.assembly import origins
    from frictool.logs.canonical.mcap_layout import COLUMNS, message_path
    from frictool.logs.clocks.alignment import CLOCK_OFFSET
    from frictool.logs.losses import as_rows
    from frictool.logs.quality.sign import sign_of
    from frictool.logs.quality.survey import row
    from frictool.logs.table import LAYOUT

    columns = origins(made, [one.topic for one in surveys]).get(COLUMNS, {})
    main = next((one for one in surveys if "position" in one.signals), surveys[0])
    test, given = _test(made, main)
    sign = sign_of(main.opening)
    velocity = main.velocity
    return {
        "channels": [row(seen, one, columns.get(message_path(seen.topic, one.name))) for seen in surveys for one in seen.signals.values()],
        "duration_s": max(one.base.duration_s for one in surveys),
        "encoder_step": main.signals["position"].step if "position" in main.signals else None,
        "lost": as_rows(made.told),
        "test": {"kind": test, "given": given},
        "velocity": None if velocity is None else {"low": velocity[0], "high": velocity[1], "samples": main.window},
        "work_share": sign.work,
        "reversed": list(sign.reversed),
        "odd": [text for text in (main.jumps.text(), sign.text, _apart(main, surveys)) if text],
        "clocks": _clocks(main, surveys),
        "dated_by": {flow.head.topic: flow.clock for flow in made.flows if flow.clock is not None},
        "clock_offset": made.notes.get(CLOCK_OFFSET, {}),
        "layout": made.notes.get(LAYOUT, {}),
        "methods": feeds(main, test),
    }


def _clocks(main: Survey, surveys: list[Survey]) -> list[dict[str, Any]]:
    """How the clocks of further streams run against that of the main one, by the first signal that both have."""
    from frictool.logs.clocks.drift import of_streams

    found = []
    for other in surveys:
        common = next((name for name in main.signals if other is not main and name in other.signals), None)
        clock = None if common is None else of_streams(main.opening, other.opening, common)
        if clock is not None:
            facts = {"offset_s": clock.offset, "drift": clock.drift, "spread_s": clock.spread}
            found.append({"source": other.topic, "against": main.topic, "signal": common, **facts})
    return found


def _test(made: Assembly, main: Survey) -> tuple[str | None, bool]:
    """The kind of test, and whether it was given to `ingest`."""
    from frictool.logs.canonical.mcap_layout import KIND
    from frictool.logs.quality.kind import kind_of
    from frictool.logs.quality.kinds import TEST

    given = made.notes.get(KIND, {}).get(TEST)
    return (given, True) if given else (kind_of(main.opening), False)


def table(made: Assembly, surveys: list[Survey], facts: dict[str, Any]) -> str:
    """The same for people."""
    from frictool.logs.losses import shown
    from frictool.logs.provenance import PROVENANCE
    from frictool.logs.text.layout import PLAIN

    lines = [f"{Path(made.flows[0].source).name}: {facts['duration_s']:.6g} s", *_channels(facts)]
    lines += [line for seen in surveys for line in _signals(seen)]
    lines += _motion(facts, surveys)
    lines += [f"odd: {text}" for text in facts["odd"]]
    lines += [f"dated by: {topic} by {clock}" for topic, clock in facts["dated_by"].items()]
    lines += [f"clock offset: that of {topic} was ahead by {offset}" for topic, offset in facts["clock_offset"].items()]
    for one in facts["clocks"]:
        drift = "too short to tell a drift" if one["drift"] is None else f"drift {1e6 * one['drift']:.4g} us in a second"
        lines.append(f"clock: {one['source']} shows {one['signal']} {one['offset_s']:.4g} s after {one['against']}, {drift}")
    lines += [f"lost: {shown(loss)}" for loss in made.told]
    lines += _fed(facts["methods"])
    lines += [f"layout: {name}: {told}" for name, told in facts["layout"].items() if told != PLAIN]
    lines += [f"{key}: {text}" for key, text in made.notes.get(PROVENANCE, {}).items()]
    return "\n".join(lines)


def _fed(methods: dict[str, str | None]) -> list[str]:
    """The methods that the log can feed in one line, the others by the reason why not."""
    by_reason: dict[str | None, list[str]] = {}
    for name, why in methods.items():
        by_reason.setdefault(why, []).append(name)
    found = [f"does not feed {', '.join(names)}: {why}" for why, names in by_reason.items() if why is not None]
    return [f"feeds {', '.join(by_reason[None])}", *found] if None in by_reason else found


def _apart(main: Survey, surveys: list[Survey]) -> str | None:
    """What identification needs of one stream, where a further one has it."""
    from frictool.identify.feeds import DRIVES

    if "position" not in main.signals or any(name in main.signals for name in DRIVES):
        return None
    homes = [f"{other.topic} has the {name}" for other in surveys for name in other.signals if name in DRIVES]
    return f"{main.topic} has the position and {homes[0]}: `frictool ingest --resample` puts all on one grid" if homes else None


def _channels(facts: dict[str, Any]) -> list[str]:
    """One line for each signal."""
    lines = [f"{'channel':<24} {'unit':<8} {'samples':>9} {'rate [Hz]':>10} {'jitter [s]':>10} {'gaps':>5} {'step':>9}  range"]
    for row in facts["channels"]:
        channel = f"{row['source']}.{row['name']}"
        step = "none" if row["step"] is None else f"{row['step']:.4g}"
        numbers = f"{row['samples']:>9} {row['rate_hz']:>10.6g} {row['jitter_s']:>10.2g} {row['gaps']:>5} {step:>9}"
        lines.append(f"{channel:<24} {row['unit']:<8} {numbers}  {row['low']:.6g} to {row['high']:.6g}")
    return lines


def _signals(seen: Survey) -> list[str]:
    """What is remarkable about the signals of a stream."""
    lines = []
    for one in seen.signals.values():
        name, rate = f"{seen.topic}.{one.name}", seen.base.rate_hz
        if one.hold is not None:
            lines.append(f"held: {name} keeps its value for {one.hold} samples ({one.hold / rate:.4g} s) or more")
        for top in one.flat:
            at = f"{name} is flat at {top.at:.6g} {one.unit}"
            lines.append(f"saturated: {at} in {top.samples} samples, for up to {top.longest / rate:.4g} s")
        if one.at_limit:
            lines.append(f"saturated: {name} is at the bench's limit in {one.at_limit} samples")
    return lines


def _motion(facts: dict[str, Any], surveys: list[Survey]) -> list[str]:
    """The encoder step, or why none is seen; velocities; the kind of test. Nothing where the log has no position."""
    from frictool.logs.quality.kinds import KINDS

    seen = next((one for one in surveys if "position" in one.signals), None)
    if seen is None:
        return []
    position, velocity = seen.signals["position"], facts["velocity"]
    lines = [f"encoder step: {_step(position)}"]
    if velocity is not None:
        over = f"over {velocity['samples']} sample{'s' * (velocity['samples'] > 1)}"
        lines.append(f"velocity: {velocity['low']:.4g} to {velocity['high']:.4g} {position.unit}/s, {over}")
    test = facts["test"]
    meaning = f": {KINDS[test['kind']]}" if test["kind"] in KINDS else ""
    lines.append(f"test: {test['kind'] or 'too short to tell'} ({'given' if test['given'] else 'detected'}){meaning}")
    return lines


def _step(position: Signal) -> str:
    from frictool.logs.quality.quality import FEWEST_LEVELS

    if position.step is not None:
        return f"{position.step:.6g} {position.unit}"
    if position.levels == 1:
        return "none seen, the position does not change"
    if position.levels < FEWEST_LEVELS:
        return f"none seen, the position takes {position.levels} values; at least {FEWEST_LEVELS} are needed to tell"
    return "none seen, positions lie on no lattice"
