"""`frictool campaign`: verdicts of a controller on many plants."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.campaign_inputs import CampaignPaths
from frictool.cli.common_options import (
    FiniteRange,
    NamedPath,
    allow_undecided_option,
    existing,
    json_option,
    output_option,
)
from frictool.cli.console_output import note, print_json, say, use_colour
from frictool.cli.file_endings import is_page
from frictool.cli.output_files import STDOUT, check_output, check_targets, command_line, save_text
from frictool.cli.workers_options import refuse_both, workers_options
from frictool.errors import EXIT_DONE, EXIT_INTERRUPTED, EXIT_NO, OutputError

if TYPE_CHECKING:
    from frictool.campaign.campaign_run import CampaignRequest
    from frictool.campaign.draws.sampling import Method, UnitDraws
    from frictool.campaign.statistics.findings import Findings
    from frictool.campaign.trials.trial_player import TrialPlayer
    from frictool.campaign.trials.trial_store import TrialStore
    from frictool.campaign.trials.trials import Trials
    from frictool.campaign.trials.worst_case import WorstCase
    from frictool.documents.controller import ProgramNumber
    from frictool.documents.provenance import Provenance

TRIALS = 1000  # as in campaign/campaign_run.py, which --help does not import
EVALUATIONS = 300

HELP = """\b
Example:
  frictool campaign model.yaml controller.yaml --scenario steps.yaml --spec spec.yaml \\
    -n 10000 -o campaign.html
  frictool campaign model.yaml controller.yaml --scenario steps.yaml --spec spec.yaml \\
    --method vertices --worst worst/ -o campaign.yaml
  frictool campaign mechanism.yaml controller.yaml --scenario steps.yaml --spec spec.yaml \\
    --at-least 0.99 --keep trials.jsonl

Simulate a scenario with many plants and judge each run by the specification, as simulate and report
do. The result is the pass rate with its confidence interval, the distribution of each metric, and
the parameters that cause the failures.

The parameters of the plants are drawn from the ranges of the bench and the model, or from the
quantities of a mechanism that have low and high. `spread` of the scenario also varies wear,
temperature, start, sensor faults and disturbances, and can replace ranges. All draws are uniform
and independent, except that a breakaway is drawn above the Coulomb friction of the same plant. If
the bench has no range of the breakaway, the ratio of breakaway to Coulomb friction is drawn from
the model.

--method random: independent draws; a larger -n keeps all draws and adds more. --method latin:
a Latin hypercube of -n draws. --method vertices: every combination of range ends; if there are more
than 4096 or more than -n, a random part of them. The number of processes does not change the
results.

--worst searches the same ranges for the worst plant of each requirement, starting from the worst
draws. It writes DIR/worst_REQUIREMENT.yaml, a scenario that reproduces the value with `frictool
simulate`.

Completed trials are kept in OUTPUT.trials or in the file of --keep. After an interruption, the same
command continues from these trials.

The verdict is PASS, FAIL, UNDECIDED or NOT SHOWN. UNDECIDED: no trial fails, but a trial is
undecided, a requirement is undecided in every trial, the steps leave the side of a position on
which the model is valid (`valid_side`), or the logs show a lag (`late_position`) that the loop does
not tolerate. NOT SHOWN: there are too few draws to show the pass rate of --at-least.

Exit codes: 0 pass; 1 fail or undecided, or the lower confidence bound of the pass rate is below
--at-least.
"""


@dataclass(frozen=True)
class CampaignOptions:
    """Options of `frictool campaign`: plants to simulate, and files to write."""

    request: CampaignRequest
    worst: Path | None
    output: Path | None
    table: Path | None
    keep: Path | None
    allow_undecided: bool
    as_json: bool

    @property
    def kept(self) -> Path | None:
        """Return the file that stores completed trials; None if trials are not stored."""
        if self.keep is not None or self.output in (None, STDOUT):
            return self.keep
        assert self.output is not None
        if not self.output.name or (
            self.output.exists() and not self.output.is_file()
        ):  # nothing is stored next to a device
            return None
        return self.output.with_name(f"{self.output.name}.trials")


@click.command("campaign", help=HELP)
@click.argument(
    "model", help="Model of the axis (model.yaml), or mechanism (mechanism.yaml).", type=existing
)
@click.argument("controller", type=existing, help="Controller to test (controller.yaml).")
@click.option(
    "--scenario", type=existing, required=True, help="Scenario to simulate (scenario.yaml)."
)
@click.option(
    "--spec", type=existing, required=True, help="Requirements on the closed loop (spec.yaml)."
)
@click.option(
    "-n",
    "--trials",
    type=click.IntRange(1, 1_000_000),
    help=f"Number of draws. [default: {TRIALS}; with --method vertices all, at most 4096]",
)
@click.option(
    "--method",
    type=click.Choice(["random", "latin", "vertices"]),
    default="random",
    show_default=True,
    help="Method that draws the plants.",
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    help="Seed of the draws and of the noise. [default: the scenario's seed]",
)
@click.option(
    "--at-least",
    type=FiniteRange(0.0, 1.0, min_open=True),
    help="Pass rate that must be shown, 0 to 1. [default: all draws pass]",
)
@click.option(
    "--confidence",
    type=FiniteRange(0.0, 1.0, True, True),
    default=0.95,
    show_default=True,
    help="Confidence level of intervals and bounds.",
)
@click.option(
    "--worst",
    type=existing,
    metavar="DIR",
    help="Search for the worst plants, and write their scenarios to this folder.",
)
@click.option(
    "--evaluations",
    type=click.IntRange(1),
    help=f"Largest number of plants in each search. [default: {EVALUATIONS}]",
)
@click.option(
    "--observer",
    type=existing,
    help="Observer that provides the speed to the controller (observer.yaml).",
)
@click.option(
    "--number",
    type=click.Choice(["double", "float", "q31"]),
    help="Number format in which the controller runs. [default: double]",
)
@click.option(
    "--keep",
    type=existing,
    help=("File that keeps the trials. [default: OUTPUT.trials, removed after the last trial]"),
)
@click.option(
    "--table",
    type=NamedPath(writes=("CSV",)),
    help="Write all trials to this file, one row each (CSV).",
)
@workers_options
@output_option(
    required=False,
    help="Page (.html) or its content (.yaml); - is YAML on stdout.",
    writes=("HTML", "YAML"),
    chooses=True,
)
@allow_undecided_option
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    /,
    model: Path,
    controller: Path,
    scenario: Path,
    spec: Path,
    trials: int | None,
    method: Method,
    observer: Path | None,
    number: ProgramNumber | None,
    evaluations: int | None,
    **rest: Any,
) -> None:
    refuse_both(rest["cores"], rest["cluster"])
    if evaluations is not None and rest["worst"] is None:
        raise click.UsageError(
            "--evaluations belongs to --worst; add --worst FOLDER, or leave it out."
        )
    from frictool.campaign.campaign_run import CampaignRequest

    chosen = {
        name: rest.pop(name) for name in ("seed", "at_least", "confidence", "cores", "cluster")
    }
    searched = 0 if rest["worst"] is None else evaluations or EVALUATIONS
    request = CampaignRequest(
        trials, method, evaluations=searched, number=number or "double", **chosen
    )
    paths = CampaignPaths(model, controller, scenario, spec, observer)
    ctx.exit(_campaign(paths, CampaignOptions(request, **rest)))


def _campaign(paths: CampaignPaths, options: CampaignOptions) -> int:
    from frictool.campaign.campaign_run import findings_of
    from frictool.campaign.draws.sampling import draws_of
    from frictool.campaign.trials.trial_player import TrialPlayer
    from frictool.campaign.trials.trial_store import TrialStore
    from frictool.campaign.trials.varied_space import space_of_setting
    from frictool.cli.campaign_inputs import header_of, mechanism_errors_with_line, setting_of

    setting, paths = setting_of(paths, options.request.number)
    _check_targets(paths, options)
    with mechanism_errors_with_line(paths.model):
        space = space_of_setting(setting)
    request = options.request
    seed = setting.scenario.seed if request.seed is None else request.seed
    trial = TrialPlayer(setting, space, seed)
    draws = draws_of(request.method, request.count, space.size, trial.seed)
    with TrialStore(
        options.kept, header_of(trial, paths, request.method, draws.units.shape[0])
    ) as store:
        trials, worst = _play(trial, draws, store, paths, options)
        findings = findings_of(trial, trials, worst, request)
        _save(findings, worst, _provenance(paths, options), paths, options)
        if options.keep is None:
            store.remove()
    _show(findings, options)
    return EXIT_DONE if findings.acceptable(options.allow_undecided) else EXIT_NO


def _check_targets(paths: CampaignPaths, options: CampaignOptions) -> None:
    if options.keep == STDOUT:
        raise click.UsageError("--keep needs a regular file, not a stream.")
    check_targets(
        {"-o": options.output, "--table": options.table, "--keep": options.kept},
        list(paths.inputs.values()),
    )
    if options.worst is not None and options.worst.exists() and not options.worst.is_dir():
        raise OutputError(f"{options.worst}: is not a folder; --worst needs a folder")
    if options.worst is not None:
        check_output(options.worst / "worst.yaml" if options.worst.exists() else options.worst, [])


def _play(
    trial: TrialPlayer,
    draws: UnitDraws,
    store: TrialStore,
    paths: CampaignPaths,
    options: CampaignOptions,
) -> tuple[Trials, list[WorstCase]]:
    from frictool.campaign.campaign_run import conduct, sharing
    from frictool.cli.campaign_inputs import commands_of
    from frictool.cli.progress import progress

    count = draws.units.shape[0]
    already = len(store.trials)
    if already:
        others = "; the remaining trials are simulated" if already < count else ""
        note(f"{store.path}: {min(already, count)} of {count} trials are stored{others}")
    request = options.request
    commands = commands_of(paths, options.worst or Path(), request.number)
    try:
        return conduct(
            trial,
            draws,
            store,
            request.evaluations,
            sharing(request.cores, request.cluster),
            commands,
            progress,
        )
    except KeyboardInterrupt:
        if not store.trials:
            raise
        left = (
            f"; the same command continues from {store.path}"
            if store.path is not None
            else "; they are lost; use --keep FILE next time"
        )
        note(f"\ninterrupted: {min(len(store.trials), count)} of {count} trials are done{left}")
        sys.exit(EXIT_INTERRUPTED)


def _provenance(paths: CampaignPaths, options: CampaignOptions) -> Provenance:
    from frictool.documents.provenance import provenance_of_command

    request = options.request
    words = {
        "model": paths.model,
        "controller": paths.controller,
        "--scenario": paths.scenario,
        "--spec": paths.spec,
        "--observer": paths.observer,
        "--trials": request.count,
        "--method": request.method,
        "--seed": request.seed,
        "--at-least": request.at_least,
        "--confidence": request.confidence,
        "--number": None if request.number == "double" else request.number,
        "--worst": options.worst,
        "--evaluations": request.evaluations or None,
    }
    return provenance_of_command(command_line("campaign", words), list(paths.inputs.values()))


def _save(
    findings: Findings,
    worst: list[WorstCase],
    provenance: Provenance,
    paths: CampaignPaths,
    options: CampaignOptions,
) -> None:
    inputs = list(paths.inputs.values())
    contents = dict[Path, str]()
    if options.worst is not None:
        from frictool.campaign.trials.worst_case import text_of

        contents |= {
            options.worst / case.scenario: text_of(case, options.worst, paths.scenario)
            for case in worst
        }
    if options.table is not None:
        from frictool.campaign.views.trials_csv import as_csv

        contents[options.table] = as_csv(findings.trials)
    if options.output is not None and is_page(options.output):
        from frictool.campaign.views.page import page

        contents[options.output] = page(findings, provenance)
    elif options.output is not None:
        from frictool.campaign.views.yaml_view import as_document

        contents[options.output] = as_document(findings, provenance)
    if options.worst is not None:
        options.worst.mkdir(exist_ok=True)
    for target, text in contents.items():
        save_text(target, text, inputs)


def _show(findings: Findings, options: CampaignOptions) -> None:
    from frictool.campaign.views.json_view import FORMAT, as_json
    from frictool.campaign.views.text_view import lines

    if options.as_json:
        print_json(FORMAT, as_json(findings), options.output)
        return
    to_stdout = STDOUT in (options.output, options.table)
    for line in lines(findings, use_colour(to_stdout)):
        say(line, STDOUT if to_stdout else None)
