"""`frictool reduce`: reduction of a mechanism to one inertia, with the error of each step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.progress import note_step

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.provenance import Provenance
    from frictool.reduce.chain import ReductionStopped
    from frictool.reduce.loop_comparison import LoopComparison
    from frictool.reduce.reduction import Reduction

HELP = """\b
Example:
  frictool reduce mechanism.yaml -o model.yaml
  frictool reduce mechanism.yaml --bandwidth 300 --reduced reduced.yaml -o model.yaml
  frictool reduce throttle.yaml --travel 0.2 1.5 -o opening.yaml

Reduce a mechanism to one inertia with friction. Rigid links are lumped, losses become friction,
springs and cams become the friction of each direction at the motor, backlash is moved between motor
and sensor, and resonances above a bandwidth are dropped.

Each step states what it neglects, its expected error and its measured error. To measure it, every
step and the final model are simulated under the same commands as the whole mechanism; with
--controller and --scenario also in the closed loop. If a measured error is above --tolerance, or an
expected one is not covered by an interval of the model, nothing is written and the exit code is 4.
If a step is impossible, --reduced writes the mechanism of the steps before it.
"""


@click.command("reduce", help=HELP)
@click.argument("mechanism", type=existing, help="Mechanism to reduce (mechanism.yaml).")
@click.option(
    "--bandwidth",
    type=FiniteRange(min=0.0, min_open=True),
    metavar="RAD/S",
    help="Keep resonances below this frequency, drop those above.",
)
@click.option(
    "--controller",
    type=existing,
    help=(
        "Without --bandwidth: use ten times the highest crossover frequency of this "
        "controller's loop."
    ),
)
@click.option(
    "--scenario",
    type=existing,
    help="With --controller: also compare mechanism and model in this scenario.",
)
@click.option(
    "--travel",
    type=(FiniteRange(), FiniteRange()),
    metavar="LOW HIGH",
    help=(
        "Reduce this part of the travel only, in coordinates of the sensor [rad | m], "
        "such as one side of a default position."
    ),
)
@click.option(
    "--bench",
    type=existing,
    help="Bench of the model, instead of the mechanism's source and sensor.",
)
@click.option(
    "--tolerance",
    type=FiniteRange(0.0, 1.0, min_open=True),
    default=0.05,
    show_default=True,
    help="Allowed error, relative to the travelled distance.",
)
@click.option(
    "--reduced",
    type=NamedPath(writes=("YAML",)),
    help="Also write the last mechanism, with the blocks of kept resonances.",
)
@click.option(
    "--plot",
    type=NamedPath(writes=("SVG",)),
    help="Write the curves of inertia and friction at the motor (SVG).",
)
@output_option(required=False, writes=("YAML",))
@json_option
def command(
    mechanism: Path,
    bandwidth: float | None,
    controller: Path | None,
    scenario: Path | None,
    travel: tuple[float, float] | None,
    bench: Path | None,
    tolerance: float,
    reduced: Path | None,
    plot: Path | None,
    output: Path | None,
    as_json: bool,
) -> None:
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.writing import to_yaml
    from frictool.errors import NoSolutionError
    from frictool.reduce.chain import ReductionStopped

    if scenario is not None and controller is None:
        raise click.UsageError("--scenario needs --controller.")
    if travel is not None and travel[0] >= travel[1]:
        raise click.UsageError(
            f"--travel: found {travel[0]:g} to {travel[1]:g}; allowed: LOW < HIGH."
        )
    inputs = [path for path in (mechanism, controller, scenario, bench) if path is not None]
    check_targets({"-o": output, "--reduced": reduced, "--plot": plot}, inputs)
    words: dict[str, Any] = {
        "mechanism": mechanism,
        "--bandwidth": bandwidth,
        "--controller": controller,
        "--scenario": scenario,
        "--bench": bench,
    }
    words |= {
        "--travel": None if travel is None else f"{travel[0]:.12g} {travel[1]:.12g}",
        "--tolerance": tolerance if tolerance != 0.05 else None,
    }
    try:
        result = _reduction(
            mechanism,
            bandwidth,
            controller,
            travel,
            bench,
            tolerance,
            lambda: provenance_of_command(command_line("reduce", words), inputs),
        )
    except ReductionStopped as stopped:
        _show_unfinished(stopped, mechanism, reduced, inputs, as_json)
        raise
    loop = _in_loop(mechanism, result, controller, scenario)
    _show(result, loop, output, as_json)
    refused = result.checked.refused or (loop.refused if loop is not None else None)
    if refused is not None:
        raise NoSolutionError(f"{result.chain.whole.name}: not reduced: {refused}")
    if output is not None:
        save_text(output, to_yaml(result.model), inputs)
    if reduced is not None:
        save_text(reduced, to_yaml(result.chain.last), inputs)
    if plot is not None:
        from frictool.reduce.resistance_plot import picture

        save_text(plot, picture(result.chain, result.model) + "\n", inputs)


def _show_unfinished(
    stopped: ReductionStopped, path: Path, reduced: Path | None, inputs: list[Path], as_json: bool
) -> None:
    """Print the completed steps, and save the mechanism of the last one for --reduced."""
    from frictool.documents.writing import to_yaml
    from frictool.reduce.text_view import unfinished

    if not stopped.steps:
        return
    last = stopped.steps[-1]
    if not as_json:
        say("\n".join(unfinished(str(path), stopped.steps)), None)
    if reduced is not None:
        save_text(reduced, to_yaml(last.mechanism), inputs)
        note(
            f"{reduced}: the mechanism after the step '{last.report.step}', not checked "
            "by simulation; no model is written"
        )


def _reduction(
    path: Path,
    bandwidth: float | None,
    controller: Path | None,
    travel: tuple[float, float] | None,
    bench: Path | None,
    tolerance: float,
    provenance: Callable[[], Provenance],
) -> Reduction:
    from frictool.cli.mechanism_file import load_mechanism, mechanism_error, print_notes
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.reduce.reduction import reduction

    document, assembled = load_mechanism(path)
    print_notes(path, assembled)
    try:
        document = document if travel is None else _part(document, travel)
        limit = _bandwidth(document, bandwidth, controller, tolerance)
        return reduction(document, limit, tolerance, _bench(bench), provenance(), note_step)
    except ElementError as wrong:
        raise mechanism_error(path, wrong) from None


def _part(document: Mechanism, travel: tuple[float, float]) -> Mechanism:
    from frictool.reduce.partial_travel import OutsideTravelError, restrict_travel

    try:
        return restrict_travel(document, travel)
    except OutsideTravelError as wrong:
        raise click.UsageError(f"--travel: {wrong}.") from None


def _in_loop(
    path: Path, result: Reduction, controller: Path | None, scenario: Path | None
) -> LoopComparison | None:
    """Compare mechanism and model in the closed loop.

    None if this is not requested, or if the reduction has failed its check.
    """
    if scenario is None or controller is None or result.checked.refused is not None:
        return None
    from frictool.cli.reduce_loop import compare_in_loop

    note_step("playing the scenario to both")
    return compare_in_loop(
        path,
        result.model,
        controller,
        scenario,
        result.chain.one.play.width,
        result.checked.tolerance,
    )


def _show(
    result: Reduction, loop: LoopComparison | None, output: Path | None, as_json: bool
) -> None:
    from frictool.reduce.json_view import json_view
    from frictool.reduce.text_view import lines

    if as_json:
        print_json("reduce/1", json_view(result.chain, result.checked, result.model, loop), output)
    else:
        say("\n".join(lines(result.chain, result.checked, result.model, loop)), output)


def _bandwidth(
    document: Mechanism, requested: float | None, controller: Path | None, tolerance: float
) -> float | None:
    """Return the bandwidth of the option or of the controller; required if a link is compliant."""
    from frictool.reduce.compliance import compliant_links

    if requested is not None:
        return requested
    if controller is not None:
        from frictool.documents.controller import Controller
        from frictool.documents.registry import load
        from frictool.reduce.loop_bandwidth import bandwidth_of

        return bandwidth_of(load(controller, Controller))
    names = [one.name for one in compliant_links(document)]
    if names:
        raise click.UsageError(
            f"{', '.join(names)} yield{('s' if len(names) == 1 else '')}; give the "
            "frequency up to which resonances count, by --bandwidth RAD/S or by "
            f"--controller{_passing(document, tolerance)}."
        )
    return None


def _passing(document: Mechanism, tolerance: float) -> str:
    """Return advice on the bandwidth up to which all links may be rigid."""
    from frictool.errors import NoSolutionError
    from frictool.reduce.advice import passing_bandwidth

    try:
        passing = passing_bandwidth(document, tolerance)
    except NoSolutionError:  # reported as soon as a bandwidth is specified
        return ""
    return (
        ""
        if passing is None
        else (
            f"; up to --bandwidth {passing:g}, rigid links change the gain by at most "
            f"{100 * tolerance:g} %"
        )
    )


def _bench(path: Path | None) -> Bench | None:
    from frictool.documents.bench import Bench
    from frictool.documents.registry import load

    return None if path is None else load(path, Bench)
