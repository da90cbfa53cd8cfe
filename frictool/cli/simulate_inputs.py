"""Inputs of a simulation besides its documents: observer, log to replay and exported C code."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.console_output import note

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.documents.controller import Controller
    from frictool.logs.log import Log
    from frictool.simulate.compiled_target import CompiledTarget


def with_observer_option(document: Controller, observer: Path | None) -> Controller:
    """Return the controller, which uses the speed of `observer` if `observer` is not None."""
    if observer is None:
        return document
    from frictool.documents.observer import Observer
    from frictool.documents.registry import load
    from frictool.verify.observed_controller import with_observer

    observed = with_observer(document, load(observer, Observer))
    for line in observed.lines():
        note(line)
    return observed.controller


def compile_target(folder: Path, controller: Path, document: Controller) -> CompiledTarget:
    """Compile the exported C code of the controller in `folder`; return the compiled code."""
    from frictool.adapters.controller_composition import controller_program
    from frictool.documents.provenance import digest
    from frictool.simulate.closed_loop import scheduled
    from frictool.simulate.compiled_target import compiled_target

    program = controller_program(document)
    return compiled_target(
        folder,
        digest(controller),
        str(controller),
        tuple(program.inputs),
        tuple(scheduled(document, program)),
    )


def recorded_log(path: Path, scenario: Path, bench: Bench) -> Log:
    """Load the log that the scenario replays; raise DocumentError if `path` is not a file."""
    from frictool.documents.key_lines import document_error
    from frictool.logs.log_reader import read_log

    if not path.is_file():
        message = (
            f"found {path}, which is not a file; allowed: path of a log, relative to the folder "
            f"of {scenario.name}"
        )
        raise document_error(scenario, "reference.log", message)
    return read_log(path, bench)
