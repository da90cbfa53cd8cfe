"""`frictool report`: verdict on logs, which are judged by a specification."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.common_options import (
    NamedPath,
    allow_undecided_option,
    existing,
    json_option,
    output_option,
)
from frictool.cli.console_output import note, print_json, say, use_colour
from frictool.cli.output_files import STDOUT, check_targets, command_line, save_text
from frictool.errors import EXIT_NO

if TYPE_CHECKING:
    from frictool.documents.controller import Controller
    from frictool.documents.proof import Proof
    from frictool.documents.provenance import Provenance
    from frictool.logs.log import Log
    from frictool.report.requirement import ReportRequest, Verdict
    from frictool.verify.vertex_transfers import VertexTransfers

HELP = """\b
Example:
  frictool report run.mcap --spec spec.yaml --controller controller.yaml -o report.html

Measure the steps of simulated or measured logs and judge them by the specification. The outputs are
a page with plots (-o), JUnit for a build server, Markdown for a merge request, and JSON.

Each requirement is judged by its worst value over all steps of all streams (/axis and every variant
/axis/NAME). It is MET, NOT MET, or UNDECIDED with the reason, such as a smooth reference, which has
no step. The modulus margin needs --controller. It is the margin of the simulated plants, and is
undecided if the controller was not verified for the model or the rig of the log. The verdict is
FAIL if a requirement is not met, else UNDECIDED if one is undecided, else PASS.

The model of a simulated log may be valid only on one side of a position (`valid_side`). If the
positions leave this side, a requirement that is met becomes undecided, except the modulus margin.
The same holds if the logs of the model show a lag (`late_position`) that the loop of the simulated
log does not tolerate, or a ringing axis.

--bench, or else the controller's bench, describes the columns of raw CSV and MAT logs, and provides
the drive's limit and the backlash. Several logs are overlaid, aligned at their common steps.

Exit codes: 0 pass; 1 fail or undecided. The outputs are written in either case.
"""


@click.command("report", help=HELP)
@click.argument(
    "logs",
    type=existing,
    nargs=-1,
    required=True,
    metavar="LOG...",
    help="Logs to judge, simulated or measured.",
)
@click.option(
    "--spec", type=existing, required=True, help="Requirements on the closed loop (spec.yaml)."
)
@click.option(
    "--controller",
    type=existing,
    help=(
        "Controller of the loop, for the modulus margin and transfer functions (controller.yaml)."
    ),
)
@click.option(
    "--bench", type=existing, help="Rig: columns of raw logs, drive limit, backlash (bench.yaml)."
)
@click.option(
    "--proof",
    type=existing,
    help="Proof of a step test of the controller (proof.yaml); the outputs list what it proves.",
)
@output_option(required=False, help="Page (HTML); - is stdout.", writes=("HTML",))
@click.option(
    "--junit",
    type=NamedPath(writes=("XML",)),
    help="Write JUnit XML, one test case per requirement.",
)
@click.option(
    "--markdown", type=NamedPath(writes=("Markdown", "text")), help="Write a Markdown table."
)
@allow_undecided_option
@json_option
@click.pass_context
def command(
    ctx: click.Context,
    logs: tuple[Path, ...],
    spec: Path,
    controller: Path | None,
    bench: Path | None,
    proof: Path | None,
    output: Path | None,
    junit: Path | None,
    markdown: Path | None,
    allow_undecided: bool,
    as_json: bool,
) -> None:
    if proof is not None and controller is None:
        raise click.UsageError("--proof needs --controller, the controller of the proof.")
    inputs = [*logs, spec, *(path for path in (controller, bench, proof) if path is not None)]
    targets = {"-o": output, "--junit": junit, "--markdown": markdown}
    check_targets(targets, inputs)
    request = _load(logs, spec, controller, bench)
    if proof is not None:
        request = replace(request, proof=_proof(proof, request.controller))

    for log in request.logs:
        for warning in log.warnings:
            note(f"warning: {log.source}: {warning}")

    from frictool.documents.provenance import provenance_of_command
    from frictool.report.verdict import verdict_of

    verdict = verdict_of(request)
    arguments = {
        "logs": logs,
        "--spec": spec,
        "--controller": controller,
        "--bench": bench,
        "--proof": proof,
    }
    provenance = provenance_of_command(command_line("report", arguments), inputs)
    transfers = _transfers(request.controller)
    for target, text in _contents(verdict, transfers, provenance, targets, allow_undecided).items():
        save_text(target, text, inputs)
    _show(verdict, transfers, STDOUT if STDOUT in targets.values() else None, as_json)
    if not verdict.acceptable(allow_undecided):
        ctx.exit(EXIT_NO)


def _load(
    logs: tuple[Path, ...], spec: Path, controller: Path | None, bench: Path | None
) -> ReportRequest:
    from frictool.documents.bench import Bench
    from frictool.documents.controller import Controller
    from frictool.documents.metric_table import REQUIREMENTS
    from frictool.documents.registry import load, same_axis
    from frictool.documents.spec import Spec
    from frictool.errors import DocumentError
    from frictool.logs.log_reader import read_log
    from frictool.report.requirement import ReportRequest

    spec_document = load(spec, Spec)
    if all(getattr(spec_document, name) is None for name in REQUIREMENTS):
        raise DocumentError(
            spec,
            f"has no requirement; write at least one of {', '.join(REQUIREMENTS)}",
            line=None,
            key="",
        )
    documents: dict[Path, Any] = {spec: spec_document}
    if controller is not None:
        documents[controller] = load(controller, Controller)
    columns = None if controller is None else documents[controller].bench
    if bench is not None:
        documents[bench] = columns = load(bench, Bench)
    same_axis(documents)
    read = tuple(read_log(path, columns) for path in logs)
    if controller is None:
        return ReportRequest(spec_document, read, None, columns)
    from frictool.verify.recheck import recheck

    recheck(documents[controller])
    for log in read:
        _of_this_controller(log, controller, documents[controller])
    return ReportRequest(spec_document, read, documents[controller], columns)


def _proof(path: Path, controller: Controller | None) -> Proof:
    from frictool.documents.proof import Proof, proof_digest
    from frictool.documents.registry import load
    from frictool.errors import DocumentError

    proof = load(path, Proof)
    if proof.digest != proof_digest(proof):
        words = "does not match the content of the file, which was edited; run frictool prove again"
        raise DocumentError(path, words, line=None, key="digest")
    if proof.controller != controller:
        words = "is not the controller of --controller; run frictool prove with this controller"
        raise DocumentError(path, words, line=None, key="controller")
    return proof


def _of_this_controller(log: Log, controller: Path, document: Controller) -> None:
    from frictool.documents.provenance import digest
    from frictool.errors import LogError

    observed = log.metadata.get("log", {}).get("speed_from")
    if observed is not None and document.velocity.observer is None:
        raise LogError(
            log.source,
            (
                f"was simulated with a {observed}, but {controller} contains no observer, so that "
                "the controller's margins do not apply to this log; simulate the controller of "
                "`frictool observe loop`"
            ),
        )
    inputs = [
        text for key, text in log.metadata.get("provenance", {}).items() if key.startswith("input")
    ]
    if log.metadata.get("log", {}).get("kind") == "simulated" and not any(
        text.endswith(digest(controller)) for text in inputs
    ):
        raise LogError(
            log.source,
            f"was simulated with another controller than {controller}; the inputs of the "
            f"simulation are {', '.join(inputs)}",
        )


def _transfers(controller: Controller | None) -> VertexTransfers | str | None:
    if controller is None:
        return None
    from frictool.verify.vertex_transfers import sensitivities

    return sensitivities(controller)


def _contents(
    verdict: Verdict,
    transfers: VertexTransfers | str | None,
    provenance: Provenance,
    targets: dict[str, Path | None],
    allow_undecided: bool,
) -> dict[Path, str]:
    contents: dict[Path, str] = {}
    if (target := targets["-o"]) is not None:
        from frictool.report.page import page

        contents[target] = page(verdict, provenance, transfers)
    if (target := targets["--markdown"]) is not None:
        from frictool.report.markdown_view import markdown

        contents[target] = markdown(verdict)
    if (target := targets["--junit"]) is not None:
        from frictool.report.junit_view import junit

        contents[target] = junit(verdict, allow_undecided)
    return contents


def _show(
    verdict: Verdict,
    transfers: VertexTransfers | str | None,
    stdout: Path | None,
    as_json: bool,
) -> None:
    from frictool.report.json_view import FORMAT
    from frictool.report.json_view import as_json as machine_view
    from frictool.report.text_view import lines

    if as_json:
        print_json(FORMAT, machine_view(verdict, transfers), stdout)
        return
    for line in lines(verdict, use_colour(stdout is not None)):
        say(line, stdout)
