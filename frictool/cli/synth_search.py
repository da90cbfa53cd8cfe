"""Search for a controller design by `frictool synth` without `--design`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictool.cli.console_output import note, print_json
from frictool.cli.output_files import STDOUT, save_text
from frictool.cli.progress import search_progress

if TYPE_CHECKING:
    from frictool.campaign.automatic_design import AutomaticDesign
    from frictool.campaign.design_trial import DesignTest
    from frictool.documents.design import Design
    from frictool.documents.model import Model
    from frictool.documents.spec import Spec
    from frictool.errors import FrictoolError


@dataclass(frozen=True)
class SearchOutputs:
    """Outputs of a search: files of design, figure and controller, and JSON on stdout."""

    design: Path | None
    plot: Path | None
    controller: Path | None
    as_json: bool


@dataclass(frozen=True)
class SearchedDesign:
    """Design that a search has found; `path` is the file of the design."""

    found: AutomaticDesign
    path: Path | None

    @property
    def design(self) -> Design:
        """Return the design that met the requirements."""
        return self.found.design

    def lines(self) -> list[str]:
        """Return text lines on the design and its file."""
        from frictool.campaign.views.search_view import design_line

        written = [] if self.path is None else [f"design file: {self.path}"]
        return [design_line(self.found), *written]

    def json(self) -> dict[str, Any]:
        """Return the result of the search as JSON values."""
        from frictool.campaign.views.search_view import search_json

        return search_json(self.found)


def design_path(controller: Path | None) -> Path | None:
    """Return the path of the design, next to `controller`.

    Return None if `controller` is None or stdout.
    """
    if controller is None or controller == STDOUT:
        return None
    return controller.with_name(f"{controller.stem}.design.yaml")


def unplayable(model: Model, spec: Spec) -> FrictoolError:
    """Return an error that says why a search cannot simulate its candidate designs."""
    from frictool.campaign.design_trial import has_requirements, untested_reason
    from frictool.errors import FrictoolError, NoSolutionError

    if not has_requirements(spec):
        return FrictoolError(
            "found no requirement; a search needs at least one, such as response_time_95_s, "
            "overshoot_percent and static_error"
        ).at("spec", "name")
    return NoSolutionError(
        f"a search simulates its candidates, but {untested_reason(model, spec)}; or give --design"
    )


def search_design(
    test: DesignTest, outputs: SearchOutputs, inputs: list[Path], wishes: Design | None
) -> SearchedDesign:
    """Search for a design that meets the requirements; write the design and a figure of the search.

    `wishes`: design with method `auto`, if the user provides one. Raises NoSolutionError if no
    design meets the requirements. If the search is interrupted, the values of the best candidate
    are printed, and nothing is written.
    """
    from frictool.campaign.automatic_design import SearchInterruptedError, design_automatically
    from frictool.campaign.views.search_view import (
        design_line,
        interruption_lines,
        refusal,
        refusal_lines,
        search_json,
    )
    from frictool.errors import NoSolutionError
    from frictool.synth.search.design_text import design_text

    try:
        found = design_automatically(test, search_progress(), wishes)
    except SearchInterruptedError as stopped:
        note("\n".join(["", *interruption_lines(stopped.found, test)]))
        raise
    if outputs.plot is not None:
        from frictool.campaign.views.search_picture import search_picture  # loads matplotlib

        save_text(outputs.plot, search_picture(found, test.model.name) + "\n", inputs)
    if not found.passed:
        reason, details = refusal(found), refusal_lines(found, test)
        if outputs.as_json:
            view = {"reason": reason, "details": details, "search": search_json(found)}
            print_json("synth-refusal/1", view, outputs.controller)
        else:
            note("\n".join(details))
        raise NoSolutionError(reason)
    if outputs.design is not None:
        head = f"{design_line(found)}\nplayed: {test.about}\nThe search has fixed seeds."
        save_text(outputs.design, design_text(found.design, head), inputs)
    else:
        note("the design is not written; --save-design DESIGN.yaml writes it")
    return SearchedDesign(found, outputs.design)
