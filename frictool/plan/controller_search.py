"""Search for a controller that meets the specification of a commissioning."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from frictool.campaign.automatic_design import design_automatically
from frictool.campaign.design_trial import design_test, untested_reason
from frictool.campaign.doubts import doubts_of
from frictool.campaign.shorter_steps import play_shorter_steps
from frictool.campaign.views.played_view import shorter_text
from frictool.campaign.views.search_view import narrower_words, refusal
from frictool.documents.logged_positions import extrapolated_words
from frictool.documents.model import Model
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.synth.search.candidate_controller import CandidateControllers


class SearchAnswer(NamedTuple):
    """Result of a search for a controller.

    - refusal: reason why no controller meets the specification; "" if a controller does
    - steps: position steps in which the controller meets the specification, as text; "" without a
      controller
    - narrower: narrower range of one parameter, for which a controller meets the specification, as
      text; "" if none is known
    - doubt: reason why the controller may fail on the axis, although it meets the specification on
      the model; "" if there is none
    - extrapolated: warning that the steps leave the positions of the model's logs by far, or ""
    """

    refusal: str
    steps: str = ""
    narrower: str = ""
    doubt: str = ""
    extrapolated: str = ""


def search_answer(model: Model, spec: Spec, progress: Callable[[str], None]) -> SearchAnswer:
    """Search for a controller of `model` that meets the specification, and return the result."""
    unjudged = untested_reason(model, spec)
    if unjudged:
        return SearchAnswer(unjudged)
    try:
        test = design_test(model, spec)
        found = design_automatically(test, progress)
    except FrictoolError as error:
        return SearchAnswer(str(error))
    if not found.passed:
        return SearchAnswer(refusal(found), narrower=narrower_words(found))
    controller = CandidateControllers(model, spec)(found.design)
    shorter = play_shorter_steps(test, controller)
    steps = test.steps + ("" if shorter is None else f"; {shorter_text(shorter)}")
    doubt = next(iter(doubts_of(model, controller, test).reasons), "")
    path = test.judge.reference_range(controller)
    extrapolated = extrapolated_words(model.logged_positions, *path, "steps")
    return SearchAnswer("", steps, doubt=doubt, extrapolated=extrapolated)
