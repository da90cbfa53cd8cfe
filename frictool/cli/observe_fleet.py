"""`frictool observe run` on several logs: a table with a row for each log, verdicts and trend."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.console_output import note, print_json, say
from frictool.cli.file_endings import is_page
from frictool.cli.observe_request import ObserveRequest, commissioning_of
from frictool.cli.output_files import STDOUT, check_targets, replacing, save_text
from frictool.cli.progress import progress
from frictool.errors import EXIT_DONE, EXIT_INPUT, EXIT_NO

if TYPE_CHECKING:
    from frictool.documents.provenance import Provenance
    from frictool.observe.fleet_table import FleetRow


def observe_fleet(request: ObserveRequest, logs: Sequence[Path]) -> int:
    """Estimate the wear in all logs, and return the exit code.

    The exit code is the first that applies:

    - EXIT_NO if the wear in a log exceeds its limit, or is undecided without --allow-undecided
    - EXIT_INPUT if a log could not be read completely
    - EXIT_DONE
    """
    from frictool.cli.standard_input import stdin_as_file
    from frictool.documents.provenance import provenance_of_command
    from frictool.logs.fleet import members
    from frictool.logs.formats import format_for, require
    from frictool.logs.origin import unmatched_patterns
    from frictool.observe.fleet import observe_logs
    from frictool.observe.fleet_table import counts, rows

    if request.output is not None and request.output != STDOUT:
        require(format_for(request.output), request.output)
    reference = commissioning_of(request)
    with stdin_as_file(logs) as paths:
        fleet = members(paths)
        inputs = [*request.inputs, *(member.path for member in fleet if member.path.is_file())]
        check_targets({"-o": request.output, "--plot": request.plot}, inputs)
        for message in unmatched_patterns(
            request.settings.patterns, [member.name for member in fleet]
        ):
            note(f"warning: {message}")
        with progress("observe") as tick:
            results = observe_logs(
                fleet,
                request.document,
                request.settings,
                cores=request.cores,
                cluster=request.cluster,
                tick=tick,
            )
        provenance = provenance_of_command(request.words, inputs)
    table = rows(results, request.wear_limit, reference)
    _save(request, table, inputs, provenance)
    if request.as_json:
        print_json(
            "observe-fleet/1",
            {
                "logs": [row.as_json() for row in table],
                "wear_limit": request.wear_limit,
                **counts(table),
            },
            request.stdout,
        )
    else:
        _show(table, request)
    if any(row.verdict is not None and request.answer_is_no(row.verdict.exceeded) for row in table):
        return EXIT_NO
    return EXIT_INPUT if any(one.lost for one in results) else EXIT_DONE


def _show(table: list[FleetRow], request: ObserveRequest) -> None:
    from frictool.observe.fleet_table import headline, text_table

    odd = [row for row in table if row.alarm or row.outcome is None]
    if request.output is None or request.stdout is not None:
        note(headline(table, request.wear_limit))
        return
    say(headline(table, request.wear_limit))
    if odd:
        say("\n".join(text_table(odd).lines()))


def _save(
    request: ObserveRequest, table: list[FleetRow], inputs: list[Path], provenance: Provenance
) -> None:
    from frictool.logs.formats import WRITTEN, format_for
    from frictool.logs.provenance import provenance_record
    from frictool.observe.fleet_table import as_csv, write_parquet
    from frictool.observe.page import page_of_fleet
    from frictool.observe.wear_trend import trend

    if request.output is not None and format_for(request.output) is WRITTEN["parquet"]:
        made = io.BytesIO()
        write_parquet(table, made, provenance_record(provenance))
        with replacing(request.output, inputs) as stream:
            stream.write(made.getvalue())
    elif request.output is not None or not request.as_json:
        save_text(request.output or STDOUT, as_csv(table), inputs)
    if request.plot is not None:
        drawn = trend(table, request.wear_limit)
        save_text(
            request.plot,
            page_of_fleet(table, request.wear_limit, drawn, provenance)
            if is_page(request.plot)
            else drawn + "\n",
            inputs,
        )
