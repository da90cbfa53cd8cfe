"""`frictool identify`: logs to parameters with intervals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.output import (
    FiniteRange,
    command_line,
    existing,
    json_option,
    note,
    output_option,
    print_json,
    refuse_inputs,
    save_text,
    say,
)
from frictool.identify.methods import DEFAULT, METHODS

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.documents.laws import Load
    from frictool.documents.model import Model
    from frictool.documents.quantity import Estimate
    from frictool.identify.identification import Identification
    from frictool.identify.inverse_dynamic import Pipeline
    from frictool.identify.record import Record

HELP = f"""\b
Example:
  frictool identify sines.mcap ramp.mcap --bench bench.yaml -o model.yaml

Find the friction model  effort = inertia a + viscous v + coulomb sign(v) + offset  and the breakaway at rest, each with an interval.

Logs are canonical (ingest) or raw CSV and MAT with the columns of the bench. Logs of motion give the sliding parameters. Breakaway ramps
(the effort grows until the axis moves, falls back, grows again; thesis 4.3) give the breakaway; they are recognised, or named with --ramp.
Slow loops of the effort below the breakaway, named with --loops, give presliding: z_max, stiffness, LuGre, elasto-plastic, Maxwell-slip
and Preisach contacts.

\b
Methods (--method), and when each is right:
{chr(10).join(f"  {name:<16} {method.what}{chr(10)}{'':<19}for {method.when}" for name, method in METHODS.items())}

A parameter that the logs cannot give is listed as not identified with the reason, and the model carries the bench's interval for it.
Intervals hold for the bench's nominal effort constant: an error of the constant scales inertia and every friction alike.

Exit code 1, and no model, where the logs are in order and give nothing at all.
"""


@click.command("identify", help=HELP)
@click.argument("logs", type=existing, nargs=-1, metavar="LOG...")
@click.option("--bench", type=existing, required=True, help="The rig (bench.yaml).")
@click.option("--ramp", type=existing, multiple=True, help="A log of breakaway ramps, whatever it looks like; may be given again.")
@click.option("--loops", type=existing, multiple=True, help="A log of slow loops below the breakaway, from a relaxed rest on.")
@click.option(
    "--measurement", is_flag=True, help="The bench too: backlash, delay between drive and position, current loop's time constant."
)
@click.option("--method", type=click.Choice(list(METHODS)), default=DEFAULT, show_default=True, help="For the sliding parameters.")
@click.option("--confidence", type=FiniteRange(0.5, 0.9999), default=0.95, show_default=True, help="Of every interval.")
@click.option("--window", type=click.IntRange(5, 100_001), help="Samples of the smoothing window, odd. [default: chosen]")
@click.option("--time-constant", type=FiniteRange(0.0), help="power-balance, ordinary, threshold: s, of the filter on differences.")
@click.option("--threshold", type=FiniteRange(0.0), help="threshold: rad/s | m/s. [default: a tenth of the top speed]")
@click.option(
    "--forgetting", type=FiniteRange(0.0, 1.0, min_open=True), help="recursive: weight of a square a stroke back. [default: 0.99]"
)
@click.option(
    "--cutoff-hz", type=FiniteRange(0.0, min_open=True), help="inverse-dynamic, friction-force: of the Butterworth filter. [default: 100]"
)
@click.option("--filter-order", type=click.IntRange(1, 12), help="inverse-dynamic, friction-force: of the Butterworth filter. [default: 4]")
@click.option("--padding", type=click.IntRange(0), help="inverse-dynamic: samples that pad either end. [default: 12]")
@click.option("--skip", type=click.IntRange(0), help="inverse-dynamic: samples left out at the start. [default: 49]")
@click.option("--decimate", type=click.IntRange(1, 1000), help="inverse-dynamic: one sample in so many. [default: 10]")
@click.option("--plot", type=click.Path(path_type=Path), help="Friction over speed and position, measured and found (SVG).")
@output_option(required=False, help="The model (YAML); - is stdout. Without it nothing is written.")
@json_option
def command(
    logs: tuple[Path, ...],
    bench: Path,
    ramp: tuple[Path, ...],
    loops: tuple[Path, ...],
    measurement: bool,
    method: str,
    confidence: float,
    window: int | None,
    time_constant: float | None,
    threshold: float | None,
    forgetting: float | None,
    plot: Path | None,
    output: Path | None,
    as_json: bool,
    **filters: Any,
) -> None:
    if not (logs or ramp or loops):
        raise click.UsageError("Missing argument 'LOG...'.")
    own: dict[str, Any] = {"window": window, "time_constant": time_constant, "threshold": threshold, "forgetting": forgetting}
    _check_options(method, own, filters)
    inputs = [*logs, *ramp, *loops, bench]
    if plot is not None:
        refuse_inputs(plot, inputs)
    from frictool.documents.bench import Bench
    from frictool.documents.provenance import record
    from frictool.documents.registry import load
    from frictool.documents.writing import to_yaml

    document = load(bench, Bench)
    from frictool.identify.identification import NothingIdentified, identify
    from frictool.identify.methods import Settings
    from frictool.identify.model import model_of

    settings = Settings(confidence, pipeline=_pipeline(filters), **own)
    try:
        records = _records(logs, document)
        result = identify(records, _records(ramp, document), document, method, settings)
    except NothingIdentified as error:
        if logs or ramp:
            _tell(error.result, document, as_json, output)
            raise
        result = error.result  # loops alone: all else is the bench's
    given = {f"--{name.replace('_', '-')}": value for name, value in {**own, **filters}.items()}
    shown = {
        "logs": logs,
        "--bench": bench,
        "--ramp": ramp,
        "--loops": loops,
        "--measurement": measurement,
        "--method": method,
        "--confidence": confidence,
        **given,
    }
    model = model_of(result, document, record(command_line("identify", shown), inputs))
    if loops:
        model = _presliding(model, _records(loops, document), alone=not (logs or ramp))
        result = replace(result, refused=model.not_identified)
    if measurement:
        model = _measured(model, result, (*logs, *ramp))
    if output is not None:
        save_text(output, to_yaml(model), inputs)
    if plot is not None:
        save_text(plot, _picture(model, result, records, document) + "\n", inputs)
    _tell(result, document, as_json, output, model)
    if not as_json:
        say(table(result, model), output)


def _records(paths: tuple[Path, ...], bench: Bench) -> list[Record]:
    from frictool.identify.record import record_of
    from frictool.logs.channels.matching import matched
    from frictool.logs.reading import read_log

    records = []
    for path in paths:
        log = matched(read_log(path, bench), bench)
        for warning in log.warnings:
            note(f"warning: {path.name}: {warning}")
        records.append(record_of(log, bench))
    return records


def _measured(model: Model, result: Identification, paths: tuple[Path, ...]) -> Model:
    """The model with what the logs tell of the bench."""
    from msgspec.structs import replace as with_fields

    from frictool.identify.identification import SLIDING_LOG
    from frictool.identify.measurement.document import measurement
    from frictool.identify.record import record_of
    from frictool.logs.channels.matching import matched
    from frictool.logs.reading import read_log

    logs = [matched(read_log(path, model.bench), model.bench) for path in paths]
    records = [record_of(log, model.bench) for log in logs]
    currents = [
        (signals["current_command"], signals["current"], record.period)
        for signals, record in ((log.main.signals, record) for log, record in zip(logs, records, strict=True))
        if {"current_command", "current"} <= signals.keys()
    ]
    sliding = [record for record in records if result.kinds.get(record.name) == SLIDING_LOG]
    return with_fields(model, measurement=measurement(sliding, currents, model.bench, model.confidence))


def _presliding(model: Model, records: list[Record], alone: bool) -> Model:
    """The model with what loops tell. Raises NothingUsable where they were all that was given, and tell nothing."""
    from frictool.identify.outcome import NothingUsable
    from frictool.identify.presliding.document import with_presliding

    found = with_presliding(model, records)
    if alone and found.presliding is None:
        raise NothingUsable(f"presliding: {found.not_identified['presliding']}")
    return found


def _picture(model: Model, result: Identification, records: list[Record], bench: Bench) -> str:
    """The strokes that can be averaged and the breakaways, with the laws that were found."""
    from frictool.identify.identification import without_load
    from frictool.identify.outcome import NothingUsable
    from frictool.identify.picture import picture
    from frictool.identify.sines import stroke_rows

    sliding = [record for record in records if result.kinds[record.name] != "ramp"]
    if result.laws is not None:
        sliding = [without_load(record, result.laws) for record in sliding]
    try:
        rows = stroke_rows(sliding, bench)
    except NothingUsable:
        rows = None  # no stroke is long enough: the law alone is drawn
    return picture(model, rows, result.ramp)


def _tell(result: Identification, bench: Bench, as_json: bool, output: Path | None, model: Model | None = None) -> None:
    """Warnings, and the machine's view, which holds the reasons where nothing is identified."""
    for warning in result.warnings:
        note(f"warning: {warning}")
    if as_json:
        print_json(summary(result, bench, model), output)


def _check_options(method: str, own: dict[str, Any], filters: dict[str, Any]) -> None:
    """Raises UsageError where an option belongs to another method."""
    for name, value in {**own, **filters}.items():
        needed = {name, "pipeline"} if name in filters else {name}
        if value is not None and needed.isdisjoint(METHODS[method].options):
            owners = ", ".join(other for other, row in METHODS.items() if not needed.isdisjoint(row.options))
            raise click.UsageError(f"--{name.replace('_', '-')} belongs to --method {owners}, not to {method}.")
    window = own["window"]
    if window is not None and window % 2 == 0:
        raise click.BadParameter(f"{window} is even; allowed: an odd number of samples.", param_hint="'--window'")


def _pipeline(filters: dict[str, Any]) -> Pipeline:
    from frictool.identify.inverse_dynamic import PUBLISHED

    return replace(PUBLISHED, **{name: value for name, value in filters.items() if value is not None})


def summary(result: Identification, bench: Bench, model: Model | None = None) -> dict[str, Any]:
    """The machine's view of an identification."""
    from msgspec import to_builtins

    from frictool.identify.model import unit_of

    fit, ramp = result.fit, result.ramp
    return {
        "method": result.method,
        "confidence": result.confidence,
        "logs": [{"name": Path(name).name, "kind": kind} for name, kind in result.kinds.items()],
        "parameters": {
            name: {"value": found.value, "low": found.low, "high": found.high, "unit": unit_of(name, bench)}
            for name, found in result.identified.items()
        },
        "force_error": fit.force_error if fit else None,
        "held_out_force_error": fit.held_out_force_error if fit else None,
        "condition": fit.condition if fit else None,
        "samples": fit.samples if fit else None,
        "details": fit.details if fit else {},
        "chosen_because": fit.why if fit else None,
        "dropped": list(fit.dropped) if fit else [],
        "not_identified": result.refused,
        "warnings": list(result.warnings),
        "laws": None if result.laws is None else to_builtins(result.laws),
        "measurement": None if model is None or model.measurement is None else to_builtins(model.measurement),
        "presliding": None if model is None or model.presliding is None else to_builtins(model.presliding),
        "ramp": {"forward": ramp.forward, "backward": ramp.backward, "onsets": ramp.onsets, "delay_corrected": ramp.delay}
        if ramp
        else None,
    }


def law_lines(model: Model) -> list[str]:
    """What friction does beyond the parameters."""
    if model.laws is None:
        return []
    lines, today, laws = [], model.parameters, model.laws
    for regime in laws.regimes:
        speed, viscous = regime.above, regime.viscous
        lines.append(
            f"from {speed.value:.4g} {speed.unit} [{speed.low:.4g}, {speed.high:.4g}] on, viscous is {viscous.value:.4g} {viscous.unit} "
            f"[{viscous.low:.4g}, {viscous.high:.4g}]"
        )
    if laws.position is not None:
        over, curve = laws.position.over, laws.position.coulomb
        orders = f"{len(curve.forward) - 1} forward, {len(curve.backward or curve.forward) - 1} backward"
        lines.append(f"friction over {over.low:.4g} to {over.high:.4g} {over.unit} as polynomials of order {orders} (4.44)")
        for side, powers in (("forward", curve.forward), ("backward", curve.backward or curve.forward)):
            lines.append(f"  breakaway {side}, b0 first: {', '.join(f'{power:.5g}' for power in powers)}")
    if laws.backward is not None:
        own = {name: getattr(laws.backward, name) for name in ("viscous", "coulomb", "breakaway")}
        own = {name: found for name, found in own.items() if found is not None}
        lines.append(f"backward: {', '.join(shown(name, found) for name, found in own.items())}; {', '.join(own)} above: forward")
    if laws.load is not None:
        lines.append(f"load beside friction: {load_line(laws.load)}")
    if laws.position is not None and today.coulomb.value > 0.0:
        lines.append(f"beta, breakaway over friction in slip (4.42): {today.breakaway.value / today.coulomb.value:.4g}")
    return lines


def shown(name: str, found: Estimate) -> str:
    """A parameter with its interval."""
    return f"{name} {found.value:.5g} {found.unit} [{found.low:.5g}, {found.high:.5g}]"


def load_line(load: Load) -> str:
    """What acts beside friction."""
    parts = [] if load.stiffness is None else [shown("spring", load.stiffness)]
    if load.gravity is not None:
        parts += [shown("gravity sine", load.gravity.sine), shown("gravity cosine", load.gravity.cosine)]
    if load.ripple is not None:
        cycles, per = load.ripple.cycles, load.ripple.per
        parts += [
            shown(f"ripple of {cycles:g} cycles per {per.value:.5g} {per.unit} sine", load.ripple.sine),
            shown("cosine", load.ripple.cosine),
        ]
    return ", ".join(parts)


def measurement_lines(model: Model) -> list[str]:
    """The bench itself."""
    found = model.measurement
    if found is None:
        return []
    lines = []
    for name in ("backlash", "delay", "loop_time_constant"):
        one: Estimate | None = getattr(found, name)
        if one is not None:
            lines.append(f"measured: {name} {one.value:.4g} {one.unit} [{one.interval[0]:.4g}, {one.interval[1]:.4g}]")
    return lines + [f"not measured: {name}: {reason}" for name, reason in found.refused.items()]


def presliding_lines(model: Model) -> list[str]:
    """What comes before the breakaway."""
    found = model.presliding
    if found is None:
        return []

    def shown(name: str, one: Estimate) -> str:
        return f"{name} {one.value:.4g} {one.unit} [{one.interval[0]:.4g}, {one.interval[1]:.4g}]"

    lines = [f"presliding, by {found.law} which predicts best: {shown('z_max', found.limit)}, {shown('stiffness', found.stiffness)}"]
    for name in ("lugre", "elasto_plastic", "maxwell_slip"):
        law = getattr(found, name)
        if law is not None:
            elastic = "" if name != "elasto_plastic" else f", {shown('elastic limit', law.elastic_limit)}"
            unseen = f"off by {100.0 * law.held_out:.3g} % of the breakaway on branches not seen"
            lines.append(f"  {name}: {shown('stiffness', law.stiffness)}{elastic}; {unseen}")
    if found.preisach is not None:
        size = found.preisach
        lines.append(f"  preisach: {len(size.table) // 2} amplitudes, {shown('up to', size.limit)}, {shown('saturation', size.saturation)}")
    return lines + [f"  {name}: not told: {reason}" for name, reason in found.refused.items()]


def table(result: Identification, model: Model) -> str:
    """The same for people."""
    from frictool.identify.outcome import CURVE, PARAMETERS

    lines = [f"{Path(name).name}: {kind}" for name, kind in result.kinds.items()]
    lines.append(f"{result.method}: {METHODS[result.method].what}")
    chosen = result.fit is not None and result.fit.why
    lines.append(f"  chosen: {chosen}" if chosen else f"  right for {METHODS[result.method].when}")
    rows = [name for name in (*PARAMETERS, *CURVE) if getattr(model.parameters, name) is not None]
    width = max(map(len, rows)) + 2
    lines.append(f"{'parameter':<{width}}{'value':>12}  {f'interval at {100 * result.confidence:g} %':<28}{'unit':<12}source")
    for name in rows:
        estimate = getattr(model.parameters, name)
        known = estimate.low is not None and estimate.high is not None
        interval = f"[{estimate.low:.5g}, {estimate.high:.5g}]" if known else "unknown"
        lines.append(f"{name:<{width}}{estimate.value:>12.5g}  {interval:<28}{estimate.unit:<12}{estimate.source}")
    if result.fit is not None:
        held_out = result.fit.held_out_force_error
        unseen = "" if held_out is None else f", {100 * held_out:.3g} % on strokes it did not see"
        lines.append(
            f"force error {100 * result.fit.force_error:.3g} %{unseen}; condition {result.fit.condition:.3g}; {result.fit.samples} samples"
        )
    if result.ramp is not None:
        unit = model.parameters.breakaway.unit
        lines.append(f"breakaway from {result.ramp.onsets} onsets, each seen {result.ramp.delay:.3g} {unit} late (corrected)")
    if result.fit is not None and result.fit.dropped:
        lines.append(f"taken to be 0, unseen strokes are predicted no worse without: {', '.join(result.fit.dropped)}")
    lines += law_lines(model) + presliding_lines(model) + measurement_lines(model)
    ordered = dict.fromkeys((*PARAMETERS, *result.refused))
    lines += [f"not identified: {name}: {result.refused[name]}" for name in ordered if name in result.refused]
    return "\n".join(lines)
