"""`frictool validate`: comparison of a model with a measured log."""

from __future__ import annotations

from pathlib import Path

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import STDOUT, check_targets, command_line, save_text
from frictool.cli.position_loop_options import LAW, ServoGains, servo_options

HELP = f"""\b
Example:
  frictool validate model.yaml sines.mcap --page validation.html

Simulate a model along a measured log and compare the two. The simulation starts at rest at the
measured position. The measured effort drives the model; between samples the effort is constant, or
follows with the lag of the bench's drive. The errors of position, velocity, acceleration and force
exclude the first samples (--skip).

With the gains of the bench's controller, the measured reference drives the model in closed loop:
{LAW}.

The force error is defined as in identify: the effort that the model lacks along the measured
motion, at samples in slip and in the frequency band of the motion. The effort error of a closed
loop is the measured minus the simulated effort. A relative error is the norm of the error divided
by the norm of the measured signal.

The last line says whether the model reproduces the log. The answer is yes if the force error is at
most 20 % plus the part that encoder noise explains, the simulated position neither diverges nor
leaves the travel, and the model's friction can hold the axis wherever it rests. If only the model's
wide intervals explain the error, the answer is undecided. A servo is judged by its position error,
relative to the distance between goal and position. A model that is valid on one side of a position
only (`valid_side`) is judged on this side; with less than half of the log there, the answer is
undecided. The exit code is 1 if the answer is no or undecided.
"""
positive = FiniteRange(0.0, min_open=True)


@click.command("validate", help=HELP)
@click.argument("model", type=existing, help="Model to check (model.yaml).")
@click.argument("log", type=existing, help="Measured log of the axis.")
@servo_options
@click.option(
    "--skip",
    type=click.IntRange(0),
    default=20,
    show_default=True,
    help="Number of samples left out at the start.",
)
@click.option("--moving", is_flag=True, help="Start with the measured speed instead of at rest.")
@click.option(
    "--cutoff-hz",
    type=positive,
    default=100.0,
    show_default=True,
    help="Cut-off frequency of the filter on velocity and acceleration [Hz].",
)
@click.option(
    "--plot",
    type=NamedPath(True, writes=("SVG",)),
    help="Write only the figures of the page, one below the other (SVG); - is stdout.",
)
@click.option(
    "--page",
    type=NamedPath(True, writes=("HTML",)),
    help="Write a page with errors, measured and simulated signals (HTML); - is stdout.",
)
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    model: Path,
    log: Path,
    position_gain: float | None,
    speed_gain: float | None,
    integral_gain: float | None,
    skip: int,
    moving: bool,
    cutoff_hz: float,
    plot: Path | None,
    page: Path | None,
    as_json: bool,
) -> None:
    gains = ServoGains(position_gain, speed_gain, integral_gain)
    closed = gains.closed
    check_targets({"--plot": plot, "--page": page}, [model, log])
    from frictool.documents.model import Model
    from frictool.documents.registry import load
    from frictool.errors import EXIT_NO
    from frictool.identify.validate.validation import ValidationRequest, validate
    from frictool.logs.channels.bench_match import match_bench
    from frictool.logs.formats import refuse_swapped
    from frictool.logs.log_reader import read_log

    refuse_swapped(model, log)
    document = load(model, Model)
    measured = match_bench(read_log(log, document.bench), document.bench)
    for warning in measured.warnings:
        note(f"warning: {log.name}: {warning}")
    servo = gains.servo(document.bench) if closed else None
    request = ValidationRequest(skip, cutoff_hz, servo, moving)
    validation = validate(document, measured, request)
    doubt = validation.judgement.warning
    if doubt is not None:
        note(f"warning: {log.name}: {doubt}")
    if plot is not None or page is not None:
        from frictool.identify.validate.figures import picture, validation_panels

        panels = validation_panels(validation)
        if plot is not None:
            save_text(plot, picture(validation, panels, document.name) + "\n", [model, log])
        if page is not None:
            from frictool.documents.provenance import provenance_of_command
            from frictool.identify.validate.page import validation_page

            shown = {
                "model": model,
                "log": log,
                "--position-gain": position_gain,
                "--speed-gain": speed_gain,
                "--integral-gain": integral_gain,
                "--skip": skip,
                "--moving": moving,
                "--cutoff-hz": cutoff_hz,
            }
            provenance = provenance_of_command(command_line("validate", shown), [model, log])
            title = f"{document.name}: model and {log.name}"
            warnings = (*measured.warnings, *([doubt] if doubt else []))
            text = validation_page(validation, panels, title, warnings, provenance)
            save_text(page, text, [model, log])
    written = next((one for one in (plot, page) if one == STDOUT), None)
    if as_json:
        print_json("validate/1", validation.as_json(), written)
    else:
        say("\n".join(validation.lines()), written)
    if not validation.judgement.holds:
        ctx.exit(EXIT_NO)
