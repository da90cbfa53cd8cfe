"""`frictool reduce`: reduction of a mechanism to a single inertia, with the error of each step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import FiniteRange, NamedPath, existing, json_option, output_option
from frictool.cli.console_output import note, print_json, say
from frictool.cli.output_files import check_targets, command_line, save_text
from frictool.cli.progress import note_step

if TYPE_CHECKING:
    from frictool.documents.mechanism import Mechanism
    from frictool.reduce.loop_comparison import LoopComparison
    from frictool.reduce.reduction import Reduction, ReductionRequest
    from frictool.reduce.reduction_chain import ReductionStopped

HELP = """\b
Example:
  frictool reduce mechanism.yaml -o model.yaml
  frictool reduce mechanism.yaml --bandwidth 300 --reduced reduced.yaml -o model.yaml
  frictool reduce throttle.yaml --travel 0.2 1.5 -o opening.yaml

Reduce a mechanism to one inertia with friction. Rigid links are lumped, losses become friction,
springs and cams become friction at the motor with one level for each direction, the backlashes of
a chain are added, and resonances above a bandwidth are dropped.

Each step states what it neglects, its expected error and its measured error. For the measured
error, every step and the final model are simulated under the same commands as the whole mechanism;
with --controller and --scenario also in the closed loop. If a measured error is above --tolerance,
or an expected error is not covered by an interval of the model, nothing is written and the exit
code is 4. If a step is impossible, --reduced writes the mechanism after the last possible step.
"""


@click.command("reduce", help=HELP)
@click.argument("mechanism", type=existing, help="Mechanism to reduce (mechanism.yaml).")
@click.option(
    "--bandwidth",
    type=FiniteRange(min=0.0, min_open=True),
    metavar="RAD/S",
    help="Keep resonances below this frequency, and drop higher resonances.",
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
    help="Also write the reduced mechanism, with the blocks of kept resonances.",
)
@click.option(
    "--plot",
    type=NamedPath(writes=("SVG",)),
    help="Write the curves of inertia and friction at the motor (SVG).",
)
@output_option(required=False, writes=("YAML",))
@json_option
def command(**values: Any) -> None:
    from frictool.documents.writing import to_yaml
    from frictool.errors import NoSolutionError
    from frictool.reduce.reduction_chain import ReductionStopped

    line = ReduceCommand(**values)
    if line.scenario is not None and line.controller is None:
        raise click.UsageError("--scenario needs --controller.")
    inputs = line.inputs
    check_targets({"-o": line.output, "--reduced": line.reduced, "--plot": line.plot}, inputs)
    try:
        result = _reduction(line)
    except ReductionStopped as stopped:
        _show_unfinished(stopped, line)
        raise
    loop = _in_loop(line, result)
    _show(result, loop, line.output, line.as_json)
    refused = result.checked.refused or (loop.refused if loop is not None else None)
    if refused is not None:
        raise NoSolutionError(f"{result.chain.whole.name}: not reduced: {refused}")
    if line.output is not None:
        save_text(line.output, to_yaml(result.model), inputs)
    if line.reduced is not None:
        save_text(line.reduced, to_yaml(result.chain.last), inputs)
    if line.plot is not None:
        from frictool.reduce.resistance_plot import picture

        save_text(line.plot, picture(result.chain, result.model) + "\n", inputs)


@dataclass(frozen=True)
class ReduceCommand:
    """Arguments and options of `frictool reduce`."""

    mechanism: Path
    bandwidth: float | None
    controller: Path | None
    scenario: Path | None
    travel: tuple[float, float] | None
    bench: Path | None
    tolerance: float
    reduced: Path | None
    plot: Path | None
    output: Path | None
    as_json: bool

    @property
    def inputs(self) -> list[Path]:
        """Return all input files."""
        paths = (self.mechanism, self.controller, self.scenario, self.bench)
        return [path for path in paths if path is not None]

    @property
    def words(self) -> str:
        """Return the text of the command for the provenance."""
        travel = self.travel
        arguments = {
            "mechanism": self.mechanism,
            "--bandwidth": self.bandwidth,
            "--controller": self.controller,
            "--scenario": self.scenario,
            "--bench": self.bench,
            "--travel": None if travel is None else f"{travel[0]:.12g} {travel[1]:.12g}",
            "--tolerance": self.tolerance if self.tolerance != 0.05 else None,
        }
        return command_line("reduce", arguments)


def _show_unfinished(stopped: ReductionStopped, line: ReduceCommand) -> None:
    from frictool.documents.writing import to_yaml
    from frictool.reduce.text_view import unfinished

    if not stopped.steps:
        return
    last = stopped.steps[-1]
    if not line.as_json:
        say("\n".join(unfinished(str(line.mechanism), stopped.steps)), None)
    if line.reduced is not None:
        save_text(line.reduced, to_yaml(last.mechanism), line.inputs)
        note(
            f"{line.reduced}: the mechanism after the step '{last.report.step}', not checked "
            "by simulation; no model is written"
        )


def _reduction(line: ReduceCommand) -> Reduction:
    from frictool.cli.mechanism_file import load_mechanism, mechanism_error, print_notes
    from frictool.documents.bench import Bench
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.reduce.partial_travel import OutsideTravelError
    from frictool.reduce.reduction import ReductionRequest, reduction

    document, assembled = load_mechanism(line.mechanism)
    print_notes(line.mechanism, assembled)
    try:
        request = ReductionRequest(line.bandwidth, line.travel, line.tolerance)
        if line.bandwidth is None:
            request = replace(request, bandwidth=_bandwidth(document, request, line.controller))
        if line.bench is not None:
            request = replace(request, bench=load(line.bench, Bench))
        provenance = provenance_of_command(line.words, line.inputs)
        return reduction(document, request, provenance, note_step)
    except ElementError as wrong:
        raise mechanism_error(line.mechanism, wrong) from None
    except OutsideTravelError as wrong:
        raise click.UsageError(f"--travel: {wrong}.") from None


def _in_loop(line: ReduceCommand, result: Reduction) -> LoopComparison | None:
    controller = line.controller
    if line.scenario is None or controller is None or result.checked.refused is not None:
        return None
    from frictool.cli.reduce_loop import compare_in_loop

    note_step("simulating the scenario with mechanism and model")
    return compare_in_loop(
        line.mechanism,
        result.model,
        controller,
        line.scenario,
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
    document: Mechanism, request: ReductionRequest, controller: Path | None
) -> float | None:
    if controller is not None:
        from frictool.documents.controller import Controller
        from frictool.documents.registry import load
        from frictool.reduce.loop_bandwidth import bandwidth_of

        return bandwidth_of(load(controller, Controller))
    from frictool.reduce.compliance import compliant_links

    part = request.part_of(document)
    names = [one.name for one in compliant_links(part)]
    if names:
        raise click.UsageError(
            f"the mechanism has compliant links ({', '.join(names)}); give the frequency up to "
            "which their resonances matter, with --bandwidth RAD/S or "
            f"--controller{_passing(part, request.tolerance)}."
        )
    return None


def _passing(document: Mechanism, tolerance: float) -> str:
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
