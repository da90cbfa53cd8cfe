"""`frictool assess`: parameters that a bench can identify, before any measurement."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import STDOUT, save_text

if TYPE_CHECKING:
    from frictool.adapters.drive_bound import DriveBound
    from frictool.documents.bench import Bench
    from frictool.identify.assess.assessment import Assessment, ParameterAssessment

PARAMETERS = ("inertia", "viscous", "coulomb", "breakaway", "presliding")
COUNTED = {
    "inertia",
    "viscous",
    "coulomb",
    "breakaway",
}  # these count for the exit code; presliding only if it is named
HELP = """\b
Example:
  frictool assess --bench bench.yaml --wanted 5% --wanted inertia=10%

State which parameters this bench can identify, by which method and test, how precisely, and why.
The report contains the bounds that quantisation sets, the filter that they require, the choice of
the method, the precision of the proposed test (Cramér-Rao bounds), and the gain of a finer encoder.
It also contains the shortest step response that the drive allows over the a-priori intervals.

A precision is half of a 95 % interval divided by the a-priori value. If the a-priori interval of a
parameter in bench.yaml is narrower than --wanted, the parameter must be identified more precisely
than that interval. Two errors are not included: an error of the effort constant, which scales every
parameter alike, and a friction that differs from the model.

Exit code 1 if a wanted precision cannot be reached; the message names an encoder that could.
"""
positive = FiniteRange(0.0, min_open=True)


class PrecisionParam(click.ParamType[tuple[str | None, float]]):
    """Precision option, such as `5%`, `0.05` or `inertia=5%`."""

    name = "precision"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str | None, float]:
        name, _, number = str(value).rpartition("=")
        if name and name not in PARAMETERS:
            self.fail(f"unknown parameter {name!r}; allowed: {', '.join(PARAMETERS)}.", param, ctx)
        try:
            part = float(number.removesuffix("%")) / (100.0 if number.endswith("%") else 1.0)
        except ValueError:
            part = math.nan
        if not 0.0 < part < 1.0:
            self.fail(
                (
                    f"found {number!r}; allowed: a precision above 0 and below 100%, such as 5% "
                    "or 0.05."
                ),
                param,
                ctx,
            )
        return name or None, part


@click.command("assess", help=HELP)
@click.option("--bench", type=existing, required=True, help="Rig (bench.yaml).")
@click.option(
    "--wanted",
    type=PrecisionParam(),
    multiple=True,
    metavar="[NAME=]5%",
    help="Wanted precision, of all parameters or of one.  [default: 5%]",
)
@click.option(
    "--duration", type=positive, default=30.0, show_default=True, help="Duration of the sines [s]."
)
@click.option(
    "--noise",
    type=positive,
    help=("Standard deviation of the measured drive [A | V].  [default: 0.2 % of its limit]"),
)
@click.option(
    "--effort",
    type=positive,
    help=("Largest effort of the test [N m | N].  [default: that of the drive's limit]"),
)
@click.option(
    "--presliding",
    type=positive,
    help="Expected presliding distance [rad | m].  [default: 1e-3 rad, 1e-5 m]",
)
@click.option(
    "--step",
    type=positive,
    help=("Length of the step whose shortest response is shown [rad | m].  [default: the travel]"),
)
@click.option(
    "-o", "--output", type=NamedPath(), help="Also write the text to this file; - is stdout."
)
@json_option
def command(
    bench: Path,
    wanted: tuple[tuple[str | None, float], ...],
    duration: float,
    noise: float | None,
    effort: float | None,
    presliding: float | None,
    step: float | None,
    output: Path | None,
    as_json: bool,
) -> None:
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load
    from frictool.identify.assess.assessment import assess, unreachable_parameters
    from frictool.identify.excite.bench_limits import unsaid_load

    document = load(bench, Bench)
    unsaid = unsaid_load(document)
    if unsaid is not None:
        note(f"warning: {unsaid}")
    named = {name: part for name, part in wanted if name is not None}
    everywhere = [part for name, part in wanted if name is None]
    requested = {**(dict.fromkeys(PARAMETERS, everywhere[-1]) if everywhere else {}), **named}
    assessment = assess(document, requested, duration, noise, effort, presliding, step)
    if output is not None:
        save_text(output, text(assessment, document) + "\n", [bench])
    if as_json:
        print_json("assess/1", summary(assessment, document), output)
    elif output != STDOUT:
        say(text(assessment, document))
    missing = unreachable_parameters(assessment, COUNTED | set(named))
    if missing:
        from frictool.identify.assess.assessment import NotIdentifiable

        raise NotIdentifiable("; ".join(_short(row, document) for row in missing))


def _short(row: ParameterAssessment, bench: Bench) -> str:
    """Return a line on a precision that cannot be reached, with the remedy."""
    wanted = f"{row.parameter}: {100.0 * row.target:.3g} % cannot be reached"
    if row.step is not None:
        return f"{wanted} with this encoder; {_encoder(row.step, bench)} could"
    precision = row.verdict.precision
    if precision is None or not math.isfinite(precision):
        return f"{wanted}: {row.verdict.why}"
    longer = (precision / row.target) ** 2
    return (
        f"{wanted} by a finer encoder, but by {longer:.3g} times as long a test, or less "
        "noise of the measured drive"
    )


def _encoder(step: float, bench: Bench) -> str:
    if bench.axis == "rotary":
        return f"{math.ceil(2.0 * math.pi / step)} counts per revolution (a step of {step:.3g} rad)"
    return f"a step of {step:.3g} m"


def summary(assessment: Assessment, bench: Bench) -> dict[str, Any]:
    """Return an assessment as JSON values."""
    from frictool.identify.assess.decision_text import scheme

    facts, entropy = assessment.facts, assessment.entropy
    return {
        "bench": bench.name,
        "step": facts.sensing.step,
        "period_s": facts.sensing.period,
        "top_speed": facts.speed,
        "effort": facts.effort,
        "effort_noise": facts.sensing.noise,
        "effort_constant_error": assessment.constant,
        "entropy": {
            "counts": entropy.counts,
            "nats": entropy.nats,
            "bits": entropy.bits,
            "gain_of_doubling": entropy.gain,
        }
        if entropy
        else None,
        "time_optimal": None if assessment.drive is None else _drive(assessment.drive),
        "parameters": [_row(row, bench) for row in assessment.rows],
        "scheme": scheme(assessment),
    }


def _drive(bound: DriveBound) -> dict[str, Any]:
    """Return the drive's shortest responses as JSON values; null for a drive that cannot move."""
    times = {"best_s": bound.best, "worst_s": bound.worst}
    return {
        "step": bound.length,
        **{name: time if math.isfinite(time) else None for name, time in times.items()},
    }


def _row(row: ParameterAssessment, bench: Bench) -> dict[str, Any]:
    verdict = row.verdict
    return {
        "parameter": row.parameter,
        "identifiable": verdict.identifiable,
        "method": verdict.method,
        "test": verdict.test,
        "precision": verdict.precision,
        "bound": verdict.bound,
        "cramer_rao": row.least,
        "wanted": row.wanted,
        "known": row.known,
        "filter_s": verdict.filter,
        "precision_at_half_the_step": row.doubled,
        "step_needed": row.step,
        "counts_needed": 2.0 * math.pi / row.step
        if row.step is not None and bench.axis == "rotary"
        else None,
        "why": verdict.why,
    }


def text(assessment: Assessment, bench: Bench) -> str:
    """Return an assessment as text."""
    from frictool.identify.assess.decision_text import scheme

    facts = assessment.facts
    unit = "rad" if bench.axis == "rotary" else "m"
    lines = [
        f"{bench.name}: step {facts.sensing.step:.4g} {unit}, period "
        f"{facts.sensing.period:g} s, top speed {facts.speed:.4g} {unit}/s, "
        f"effort {facts.effort:.4g} {'N m' if unit == 'rad' else 'N'}",
        *scheme(assessment),
        f"{'parameter':<11}{'method':<15}{'precision':>11}{'half step':>11}"
        f"{'least (CR)':>12}{'worst case':>12}{'known':>9}  test",
    ]
    for row in assessment.rows:
        verdict = row.verdict
        figures = (verdict.precision, row.doubled, row.least, verdict.bound, row.known)
        shown = "".join(
            f"{_percent(figure):>{width}}"
            for figure, width in zip(figures, (11, 11, 12, 12, 9), strict=True)
        )
        lines.append(
            f"{row.parameter:<11}{verdict.method or '-':<15}{shown}  {verdict.test or '-'}"
        )
    lines += [f"{row.parameter}: {row.verdict.why}" for row in assessment.rows]
    if assessment.entropy is not None:
        lines.append(
            f"the sensor gives {assessment.entropy.bits:.3g} bits over the travel (metric "
            f"entropy {assessment.entropy.nats:.3g} nats, "
            f"{assessment.entropy.counts:.0f} counts); twice the resolution adds 1 bit, "
            f"{100.0 * assessment.entropy.gain:.3g} %"
        )
    if assessment.drive is not None:
        lines.append(
            f"{assessment.drive.words(bench)}, {1e3 * assessment.drive.best:.4g} ms on the best "
            "(time-optimal control, with lag and delay)"
        )
    if assessment.constant > 0.0:
        lines.append(
            f"the error of the effort constant, up to +-{100.0 * assessment.constant:.3g} %, "
            "scales every parameter alike and is not included"
        )
    return "\n".join(lines)


def _percent(part: float | None) -> str:
    return "-" if part is None or not math.isfinite(part) else f"{100.0 * part:.3g} %"
