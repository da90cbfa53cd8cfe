"""Search for a controller that meets the specification of a commissioning."""

from __future__ import annotations

from collections.abc import Callable

from frictool.campaign.automatic_design import design_automatically
from frictool.campaign.played_design import design_test, untested_reason
from frictool.campaign.views.search_view import refusal
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError


def search_refusal(model: Model, spec: Spec, progress: Callable[[str], None]) -> str | None:
    """Return None if a controller for the specification is found, else the reason why not."""
    unjudged = untested_reason(model, spec)
    if unjudged:
        return unjudged
    try:
        test = design_test(model, spec)
        found = design_automatically(test, progress)
    except FrictoolError as error:
        return str(error)
    return None if found.passed else refusal(found)
