"""`frictool synth`: synthesis of a verified controller from model, specification and design."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import NamedPath, existing, json_option, output_option
from frictool.cli.console_output import (
    note,
    note_temperature,
    print_json,
    say,
    use_colour,
)
from frictool.cli.output_files import STDOUT, check_targets, command_line, save_text
from frictool.cli.progress import note_step
from frictool.cli.synth_play import play, read_test
from frictool.cli.synth_search import SearchOutputs, design_path, search_design, unplayable
from frictool.documents.synthesis_methods import METHODS
from frictool.errors import EXIT_NO

if TYPE_CHECKING:
    from frictool.campaign.design_trial import DesignTest
    from frictool.campaign.doubts import Doubts
    from frictool.documents.controller import Controller
    from frictool.documents.design import Design
    from frictool.documents.model import Model

METHOD_ROWS = "\n".join(
    f"  {name:<10}{method.problem}\n{'':<12}{method.use}" for name, method in METHODS.items()
)
HELP = f"""\b
Example:
  frictool synth model.yaml --spec spec.yaml -o controller.yaml
  frictool synth model.yaml --spec spec.yaml --design designs/speed.yaml -o controller.yaml

Synthesise one controller for all plants within the intervals of model and bench, and verify the
controller as it will run.

Without --design, or with `method: auto`, the command searches the simplest controller that meets
the specification in simulation, with a reserve of 5 % (none for oscillations, drive and rest). It
writes the design of this controller with a comment on each value. That design can be changed and
passed with --design. If no design is found, the exit code is 4. The message then states the worst
values of the best candidate over all plants, and the step and plant of each missed requirement. It
suggests a limit to relax only if a candidate then meets all requirements in simulation; a smaller
change may suffice. Even if no design is found, a controller may exist. An interrupted search prints
the values of its best candidate.

\b
Methods (`method` of the design), and the use of each:
{METHOD_ROWS}

The loop is rebuilt from the stored coefficients and sampled at the bench's period. It must be
stable at every vertex with the bench's computational delay; on a bench without delay, it must also
be stable with a delay of 1 sample. With the bench's delay, it must have the specified modulus
margin, also with coefficients rounded to the target's number format. Then stability, a norm and a
modulus margin are proved for every constant plant of the intervals; `frictool verify` proves them
again. For a loop that feeds back a speed (method pid in a cascade, also if a search selects it),
the certificate contains no norm. The proof does not cover parameters that vary with time. If one of
these steps fails, nothing is written and the exit code is 4.

Finally, the controller is simulated with the nominal plant, every vertex (with the largest and the
smallest breakaway) and 40 drawn plants, in steps over the travel, a short step and a hold, or in
the steps of --scenario. The last lines are the worst value of each requirement. The exit code is 1
if a requirement is not met; the controller is written in either case. After the default steps are
passed, shorter steps are simulated; a line states whether they meet the specification.

If the axis rings after stops or in motion (`ringing` of the model), the controller is also tested
on plants of two inertias. If the logs show a lag that the bench does not state (`late_position`),
it is also tested with a drive that has this lag. The verdict is UNDECIDED (exit code 1) if one of
these tests fails, or if the steps leave the side of a position on which the model is valid
(`valid_side`).
"""


@click.command("synth", help=HELP)
@click.argument("model", type=existing, help="Model of the axis (model.yaml).")
@click.option(
    "--spec", type=existing, required=True, help="Requirements on the closed loop (spec.yaml)."
)
@click.option(
    "--design",
    type=existing,
    help="Structure, method and weights (design.yaml). [default: found by a search]",
)
@click.option(
    "--save-design",
    type=NamedPath(writes=("YAML",)),
    help="Write the design that the search finds. [default: NAME.design.yaml for -o NAME.yaml]",
)
@click.option(
    "--vertices-only",
    is_flag=True,
    help=(
        "Check the vertices only: quicker, but without search inside the intervals and without "
        "certificate."
    ),
)
@click.option(
    "--varying",
    is_flag=True,
    help="Also compute a bound for parameters that vary at any rate (takes some seconds).",
)
@click.option(
    "--plot",
    type=NamedPath(writes=("SVG",)),
    help=(
        "Write a picture of the trade-off that `relax: auto` finds, or of the values that the "
        "search reached (SVG)."
    ),
)
@click.option(
    "--scenario",
    type=existing,
    help=(
        "Steps to simulate (scenario.yaml). "
        "[default: steps over the travel, a short step and a hold]"
    ),
)
@click.option("--no-play", is_flag=True, help="Only verify the controller; do not simulate it.")
@output_option(
    required=False,
    help="Controller (YAML); - is stdout. Without it nothing is written.",
    writes=("YAML",),
)
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    model: Path,
    spec: Path,
    design: Path | None,
    save_design: Path | None,
    vertices_only: bool,
    varying: bool,
    plot: Path | None,
    scenario: Path | None,
    no_play: bool,
    output: Path | None,
    as_json: bool,
) -> None:
    if varying and vertices_only:
        raise click.UsageError("--varying has no effect with --vertices-only.")
    from frictool.documents.design import Design
    from frictool.documents.key_lines import in_file
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load, same_axis
    from frictool.documents.spec import Spec
    from frictool.documents.writing import to_yaml
    from frictool.errors import FrictoolError

    model_document, spec_document = load(model, Model), load(spec, Spec)
    note_temperature(model, model_document, vertices=True)
    design_document = None if design is None else load(design, Design)
    named: dict[Path, Any] = {model: model_document, spec: spec_document}
    same_axis(named if design is None else {**named, design: design_document})
    searched = design_document is None or METHODS[design_document.method].searched
    _check_options(None if searched else design_document, plot, save_design, scenario, no_play)
    inputs = [model, spec, *(path for path in (design, scenario) if path is not None)]
    saved = save_design or design_path(output) if searched else None
    check_targets({"-o": output, "--plot": plot, "--save-design": saved}, inputs)
    test = None if no_play else read_test(model_document, spec_document, scenario)
    from frictool.synth.json_view import json_view
    from frictool.synth.load_disturbance import disturbance
    from frictool.synth.synthesis import synthesise
    from frictool.synth.text_view import text

    # if the design is provided, the scenario does not affect the bytes of the controller
    read = [path for path in inputs if searched or path != scenario]
    words = {
        "model": model,
        "--spec": spec,
        "--design": design,
        "--vertices-only": vertices_only,
        "--varying": varying,
    }
    words |= {"--scenario": scenario} if searched else {}
    provenance = provenance_of_command(command_line("synth", words), read)
    search = None
    try:
        load_disturbance = disturbance(model_document)
        if design_document is None or searched:
            outputs = SearchOutputs(saved, plot, output, as_json)
            if test is None:
                raise unplayable(model_document, spec_document)
            search = search_design(test, outputs, inputs, design_document)
            design_document = search.design
        result = synthesise(
            model_document,
            spec_document,
            design_document,
            vertices_only=vertices_only,
            varying=varying,
            provenance=provenance,
            progress=note_step,
        )
    except FrictoolError as error:
        files = {"model": model, "spec": spec}
        raise in_file(error, files if design is None else {**files, "design": design}) from None
    if output is not None:
        save_text(output, to_yaml(result.controller), inputs)
    if plot is not None and result.trade is not None:
        from frictool.synth.weight_trade_off_plot import picture

        save_text(plot, picture(result.trade, design_document.name) + "\n", inputs)
    if test is not None:
        from frictool.documents.logged_positions import extrapolated_words

        path = test.judge.reference_range(result.controller)
        if beyond := extrapolated_words(model_document.logged_positions, *path, "steps"):
            note(f"warning: {model}: {beyond}")
    played = None if test is None else play(test, result.controller)
    doubts = None
    if played is None or played.all_met:
        doubts = _doubts(model_document, result.controller, test)
        if played is not None and doubts is not None:
            played = replace(played, decided=not doubts.reasons)
    from frictool.verify.ringing_loop import unknown_resonance  # loads the engine

    untested = unknown_resonance(result.controller)
    if as_json:
        view = {
            **json_view(result, load_disturbance),
            "search": None if search is None else search.json(),
            "played": None if played is None else played.json(),
        }
        if played is not None and played.overspeed:
            view["notes"].append(played.overspeed)
        view["notes"] += untested
        if doubts is not None:
            view["undecided"] = list(doubts.reasons)
            view["notes"] += doubts.notes
        print_json("synth/1", view, output)
    else:
        if search is not None:
            say("\n".join(search.lines()), output)
        say(text(result, load_disturbance), output)
        for line in [*untested, *([] if doubts is None else doubts.lines())]:
            say(line, output)
        if played is not None:
            say("\n".join(played.lines(use_colour(output == STDOUT))), output)
    if (played is not None and not played.passed) or (doubts is not None and doubts.reasons):
        ctx.exit(EXIT_NO)


def _doubts(model: Model, controller: Controller, test: DesignTest | None) -> Doubts | None:
    if model.ringing is None and model.late_position is None and model.valid_side is None:
        return None
    from frictool.campaign.doubts import doubts_of  # loads the engine

    return doubts_of(model, controller, test)


def _check_options(
    design: Design | None,
    plot: Path | None,
    save_design: Path | None,
    scenario: Path | None,
    no_play: bool,
) -> None:
    if design is not None and plot is not None and design.relax == "no":
        raise click.UsageError(
            "--plot shows the trade-off of a search or of `relax: auto`, but the design "
            f"{design.name} has `relax: no`."
        )
    if design is not None and save_design is not None:
        raise click.UsageError(
            "--save-design saves the design that a search finds; with --design there is no search. "
            "Leave out one of the two."
        )
    if design is None and no_play:
        raise click.UsageError(
            "without --design, a search simulates its candidates; leave out --no-play, or give "
            "--design."
        )
    if no_play and scenario is not None:
        raise click.UsageError("--scenario has no effect with --no-play; leave out one of them.")
