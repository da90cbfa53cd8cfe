"""`frictool assess`: prediction, before any measurement, of which parameters can be identified."""

from __future__ import annotations

from pathlib import Path

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import STDOUT, save_text
from frictool.cli.precision_option import PrecisionParam

PARAMETERS = ("inertia", "viscous", "coulomb", "breakaway", "presliding")
COUNTED = {
    "inertia",
    "viscous",
    "coulomb",
    "breakaway",
}  # parameters that affect the exit code; presliding affects it only if --wanted names it
HELP = """\b
Example:
  frictool assess --bench bench.yaml --wanted 5% --wanted inertia=10%

State which parameters this bench can identify, how precisely, and by which method and test. The
report contains the errors due to quantisation, the filter against these errors, the choice of the
method, the precision of the proposed test (Cramér-Rao bounds), and the gain by a finer encoder. It
also contains the shortest step response that the drive allows over the a-priori intervals.

A precision is the half width of a 95 % interval, divided by the a-priori value. If the a-priori
interval of a parameter in bench.yaml is narrower than --wanted, the parameter must be identified
more precisely than that interval. The precision excludes the error of the effort constant, which
scales all parameters alike, and the error of the friction model.

Exit code 1 if a wanted precision cannot be reached; the message names an encoder that reaches it.
"""
positive = FiniteRange(0.0, min_open=True)


@click.command("assess", help=HELP)
@click.option("--bench", type=existing, required=True, help="Rig (bench.yaml).")
@click.option(
    "--wanted",
    type=PrecisionParam(PARAMETERS),
    multiple=True,
    metavar="[NAME=]5%",
    help="Wanted precision of all parameters, or of one parameter.  [default: 5%]",
)
@click.option(
    "--duration", type=positive, default=30.0, show_default=True, help="Duration of the sines [s]."
)
@click.option(
    "--noise",
    type=positive,
    help=("Standard deviation of the measured drive [A | V].  [default: 0.2 % of the drive limit]"),
)
@click.option(
    "--effort",
    type=positive,
    help=("Largest effort of the test [N m | N].  [default: effort at the drive's limit]"),
)
@click.option(
    "--presliding",
    type=positive,
    help="Expected presliding distance [rad | m].  [default: 1e-3 rad, 1e-5 m]",
)
@click.option(
    "--step",
    type=positive,
    help=("Length of the step for the shortest response [rad | m].  [default: the travel]"),
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
    from frictool.identify.assess.assessment_inputs import AssessmentRequest
    from frictool.identify.assess.assessment_view import json_view, lines, unreachable
    from frictool.identify.excite.bench_limits import missing_load_limit

    document = load(bench, Bench)
    no_limit = missing_load_limit(document)
    if no_limit is not None:
        note(f"warning: {no_limit}")
    named = {name: part for name, part in wanted if name is not None}
    everywhere = [part for name, part in wanted if name is None]
    requested = {**(dict.fromkeys(PARAMETERS, everywhere[-1]) if everywhere else {}), **named}
    request = AssessmentRequest(requested, duration, noise, effort, presliding, step)
    assessment = assess(document, request)
    text = "\n".join(lines(assessment))
    if output is not None:
        save_text(output, text + "\n", [bench])
    if as_json:
        print_json("assess/1", json_view(assessment), output)
    elif output != STDOUT:
        say(text)
    missing = unreachable_parameters(assessment, COUNTED | set(named))
    if missing:
        from frictool.identify.assess.assessment import NotIdentifiable

        raise NotIdentifiable(unreachable(missing))
