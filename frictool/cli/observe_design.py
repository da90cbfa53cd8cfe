"""`frictool observe design`: gains of an observer, verified before they are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import click

from frictool.cli.output import FiniteRange, command_line, existing, json_option, output_option, print_json, save_text, say
from frictool.cli.quantity_option import positive_si

Kind = Literal["multiplicative", "additive", "tracking"]

HELP = """\b
Example:
  frictool observe design model.yaml --kind multiplicative --intervals 10 -o observer.yaml

Design an observer of velocity and friction from a model.

multiplicative and additive are the switched observers of thesis chapter 6: friction has grown by a factor alpha (6.13), or by an effort
alpha (6.22). Their gains bound the gain from the model's error to the estimate's by gamma (6.6) and let the error fall by a decay,
whatever the allowed switches. They are accepted only if the inequalities hold when they are evaluated with the gains as stored, every
mode's error dies out, and simulated switching sequences show no more than gamma; else nothing is written and the exit code is 4. They
need a fine encoder.

tracking is the one for a coarse encoder: it moves by the model and is put right by what the encoder excludes.
"""


def _weights(ctx: click.Context, param: click.Parameter, value: str) -> tuple[float, float, float]:
    """Three numbers with commas."""
    try:
        numbers = tuple(float(word) for word in value.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(0.0 <= number < 1e12 for number in numbers) or numbers[1] <= 0.0:
        raise click.BadParameter(f"found {value!r}; allowed: three numbers from 0 on, that of the speed above 0, such as 1,100,0.001")
    return numbers[0], numbers[1], numbers[2]


@click.command("design", help=HELP)
@click.argument("model", type=existing)
@click.option("--kind", type=click.Choice(["multiplicative", "additive", "tracking"]), required=True, help="Which observer.")
@click.option("--intervals", type=click.IntRange(1, 100), help="Of the position for each direction; multiplicative.  [default: 10]")
@click.option("--switch-speed", help="Stuck below it, such as 10rad/s; switched kinds.  [default: a fortieth of the bench's top speed]")
@click.option("--weights", callback=_weights, default="1,100,0.001", show_default=True, help="Of position, speed, alpha (6.19).")
@click.option(
    "--decay",
    type=FiniteRange(0.0, 1.0, min_open=True),
    help="Of the error, a sample; 1 for none.  [default: 0.997 at 1 ms, likewise at others]",
)
@click.option("--inertia", help="In place of the model's, such as 1.1e-5 or '110 g cm^2'.")
@click.option(
    "--transitions",
    type=click.Choice(["neighbours", "direction"]),
    default="neighbours",
    show_default=True,
    help="Of the intervals: figure 6.3, or any in a direction.",
)
@click.option(
    "--stuck-speed",
    type=click.Choice(["held", "zero"]),
    default="held",
    show_default=True,
    help="What mode 0 does with the estimated speed.",
)
@output_option(required=False)
@json_option
def command(model: Path, kind: Kind, output: Path | None, as_json: bool, **options: Any) -> None:
    from frictool.documents.model import Model
    from frictool.documents.provenance import record
    from frictool.documents.registry import load
    from frictool.documents.writing import to_yaml

    document = load(model, Model)
    ctx = click.get_current_context()
    given = {name: value for name, value in options.items() if ctx.get_parameter_source(name) != click.core.ParameterSource.DEFAULT}
    words = {
        f"--{name.replace('_', '-')}": ",".join(f"{w:g}" for w in value) if name == "weights" else value for name, value in given.items()
    }
    provenance = record(command_line("observe design", {"model": model, "--kind": kind, **words}), [model])
    if kind == "tracking":
        _refuse_options(given, kind, ("inertia",))
        raise click.UsageError("--kind tracking is not there yet")
    if kind == "additive":
        _refuse_options(given, kind, ("switch_speed", "weights", "decay", "inertia", "transitions", "stuck_speed"))
    from frictool.observe.design import additive, multiplicative
    from frictool.observe.design.text import machine, text

    design = multiplicative.design if kind == "multiplicative" else additive.design
    observer = design(document, _settings(document.axis, options), provenance)
    if output is not None:
        save_text(output, to_yaml(observer), [model])
    if as_json:
        print_json(machine(observer, document), output)
    else:
        say(text(observer, document), output)


def _refuse_options(given: dict[str, Any], kind: Kind, allowed: tuple[str, ...]) -> None:
    """Raises click.UsageError for an option that the kind does not have."""
    for name in given:
        if name not in allowed:
            shown = ", ".join(f"--{other.replace('_', '-')}" for other in allowed)
            raise click.UsageError(f"--{name.replace('_', '-')} is not for --kind {kind}; allowed: {shown}")


def _settings(axis: Any, options: dict[str, Any]) -> Any:
    from frictool.observe.design.settings import Settings

    speed, inertia = options["switch_speed"], options["inertia"]
    return Settings(
        intervals=options["intervals"] or Settings.intervals,
        switch_speed=None if speed is None else positive_si("--switch-speed", speed, "velocity", axis),
        weights=options["weights"],
        decay=options["decay"],
        inertia=None if inertia is None else positive_si("--inertia", inertia, "inertia", axis),
        transitions=options["transitions"],
        stuck_speed=1.0 if options["stuck_speed"] == "held" else 0.0,
    )
