"""`frictool observe design`: gains of an observer, which are verified before they are written."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from frictool.cli.common_options import FiniteRange, existing, json_option, output_option
from frictool.cli.console_output import print_json, say
from frictool.cli.output_files import command_line, save_text
from frictool.cli.quantity_option import positive_si

if TYPE_CHECKING:
    from frictool.documents.model import Model
    from frictool.documents.observer import Observer
    from frictool.documents.provenance import Provenance

Kind = Literal["multiplicative", "additive", "tracking"]
SWITCHED = ("switch_speed", "weights", "decay", "quiet", "transitions", "stuck_speed", "inertia")
OPTIONS: dict[Kind, tuple[str, ...]] = {  # options of each kind
    "multiplicative": ("intervals", *SWITCHED),
    "additive": SWITCHED,
    "tracking": ("bandwidth", "drive_noise", "inertia"),
}

HELP = """\b
Example:
  frictool observe design model.yaml --kind multiplicative --intervals 10 -o observer.yaml

Design an observer of velocity and friction from a model.

multiplicative and additive are switched observers. They also estimate alpha, the factor or the
effort by which the friction has grown. The gains bound the ratio of the estimation error to the
model error by gamma, and make the error decay for all allowed mode switches. Three checks follow:
the inequalities hold with the stored gains, the error of every mode decays, and simulated switching
sequences stay below gamma. If a check fails, nothing is written and the exit code is 4. These
observers need a fine encoder.

tracking is an observer for a coarse encoder: it predicts with the model, and corrects the
prediction when the predicted position leaves the measured count. The only setting is the bandwidth
of the error.
"""


def _weights(ctx: click.Context, param: click.Parameter, value: str) -> tuple[float, float, float]:
    try:
        numbers = tuple(float(word) for word in value.split(","))
    except ValueError:
        numbers = ()
    if (
        len(numbers) != 3
        or not all(0.0 <= number < 1e12 for number in numbers)
        or numbers[1] <= 0.0
    ):
        raise click.BadParameter(
            f"found {value!r}; allowed: three numbers of at least 0, the second (speed) above 0, "
            "such as 1,100,0.001."
        )
    return numbers[0], numbers[1], numbers[2]


@click.command("design", help=HELP)
@click.argument("model", type=existing, help="Model of the axis (model.yaml).")
@click.option(
    "--kind",
    type=click.Choice(["multiplicative", "additive", "tracking"]),
    required=True,
    help="Kind of observer.",
)
@click.option(
    "--intervals",
    type=click.IntRange(1, 50),
    default=10,
    show_default=True,
    help="multiplicative: number of position intervals in each direction.",
)
@click.option(
    "--switch-speed",
    help=(
        "Switched kinds: speed below which the axis sticks, such as 10rad/s. [default: "
        "1/40 of the bench's top speed]"
    ),
)
@click.option(
    "--weights",
    callback=_weights,
    default="1,100,0.001",
    show_default=True,
    help="Switched kinds: weights of position, speed and alpha in the error.",
)
@click.option(
    "--decay",
    type=FiniteRange(0.0, 1.0, min_open=True),
    help=(
        "Switched kinds: decay factor of the error per sample; 1 for no decay. [default: 0.997; "
        "closer to 1 for sample periods below 1 ms]"
    ),
)
@click.option(
    "--quiet",
    type=FiniteRange(1.0, min_open=True),
    help=(
        "Switched kinds: allowed gamma relative to the smallest gamma. Larger values pass"
        " less encoder noise; 4 is usual. [default: smallest gamma]"
    ),
)
@click.option(
    "--inertia", help="Inertia in place of the model's inertia, such as 1.1e-5 or '110 g cm^2'."
)
@click.option(
    "--transitions",
    type=click.Choice(["neighbours", "direction"]),
    default="neighbours",
    show_default=True,
    help=(
        "Switched kinds: allow switches between neighbouring intervals, or between any intervals "
        "of one direction."
    ),
)
@click.option(
    "--stuck-speed",
    type=click.Choice(["held", "zero"]),
    default="held",
    show_default=True,
    help="Switched kinds: while the axis is stuck, the estimated speed is held or set to zero.",
)
@click.option(
    "--bandwidth",
    type=FiniteRange(0.0, min_open=True),
    help=("tracking: bandwidth of the error [rad/s]. [default: from the model's intervals]"),
)
@click.option(
    "--drive-noise",
    help=("tracking: standard deviation of the measured drive, such as 0.5A. [default: 0]"),
)
@output_option(
    required=False,
    help="Observer (YAML); - is stdout. Without it nothing is written.",
    writes=("YAML",),
)
@json_option
def command(model: Path, kind: Kind, output: Path | None, as_json: bool, **options: Any) -> None:
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.documents.writing import to_yaml

    document = load(model, Model)
    ctx = click.get_current_context()
    provided = {
        name: value
        for name, value in options.items()
        if ctx.get_parameter_source(name) != click.core.ParameterSource.DEFAULT
    }
    words = {
        f"--{name.replace('_', '-')}": ",".join(f"{w:g}" for w in value)
        if name == "weights"
        else value
        for name, value in provided.items()
    }
    provenance = provenance_of_command(
        command_line("observe design", {"model": model, "--kind": kind, **words}), [model]
    )
    for name in provided:
        if name not in OPTIONS[kind]:
            shown = ", ".join(f"--{other.replace('_', '-')}" for other in OPTIONS[kind])
            raise click.UsageError(
                f"--{name.replace('_', '-')} is not for --kind {kind}; allowed: {shown}."
            )
    from frictool.observe.design.switched_settings import UnsuitableSetting
    from frictool.observe.design.text_view import json_view, text

    try:
        observer = _designed(document, kind, provenance, options)
    except UnsuitableSetting as wrong:
        raise click.UsageError(f"{wrong}.") from None
    if output is not None:
        save_text(output, to_yaml(observer), [model])
    if as_json:
        print_json("observe-design/1", json_view(observer, document), output)
    else:
        say(text(observer, document), output)


def _designed(
    model: Model, kind: Kind, provenance: Provenance, options: dict[str, Any]
) -> Observer:
    from frictool.observe.design.observer_design import design_observer
    from frictool.observe.design.switched_settings import SwitchedObserverSettings

    def quantity(name: str, dimension: str) -> float | None:
        value = options[name]
        return (
            None
            if value is None
            else positive_si(f"--{name.replace('_', '-')}", value, dimension, model.axis)
        )

    inertia = quantity("inertia", "inertia")
    if kind == "tracking":
        noise = quantity("drive_noise", model.bench.actuator.drive) or 0.0
        return design_observer(
            model,
            kind,
            bandwidth_rad_s=options["bandwidth"],
            drive_noise=noise,
            inertia=inertia,
            provenance=provenance,
        )
    settings = SwitchedObserverSettings(
        intervals=options["intervals"],
        switch_speed=quantity("switch_speed", "velocity"),
        weights=options["weights"],
        decay=options["decay"],
        inertia=inertia,
        transitions=options["transitions"],
        stuck_speed=1.0 if options["stuck_speed"] == "held" else 0.0,
        quiet=options["quiet"],
    )
    return design_observer(model, kind, settings=settings, provenance=provenance)
