"""Page of a validation: errors, and figures of the measured and simulated motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from frictool.documents.provenance import Provenance
from frictool.identify.model_page.panel import FigurePanel
from frictool.identify.validate.validation import Validation
from frictool.presentation.page import render_page
from frictool.presentation.sections import TextTable

MEANINGS = {
    "position": "position, measured minus simulated",
    "velocity": "velocity of the low-passed position, measured minus simulated",
    "acceleration": "acceleration of the low-passed position, measured minus simulated",
    "effort": "effort of the bench's controller, measured minus simulated",
    "force": "measured effort minus the model's effort for the measured motion, at samples in slip",
}


def validation_page(
    validation: Validation,
    panels: Sequence[FigurePanel],
    title: str,
    warnings: Sequence[str],
    provenance: Provenance,
) -> str:
    """Return the HTML page of a validation."""
    return render_page(
        Path(__file__).parent,
        provenance,
        title=title,
        banner=f"Position error {validation.position_text()}",
        run=validation.lines()[0],
        warnings=warnings,
        errors=TextTable(
            "Errors",
            ("Signal", "Difference", "Relative to the measured signal"),
            tuple(
                (name, MEANINGS[name], "unknown" if error is None else f"{100.0 * error:.4g} %")
                for name, error in validation.errors.items()
            ),
            names=2,
        ),
        figures=[one.figure() for one in panels],
    )
