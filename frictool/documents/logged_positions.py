"""`logged_positions` of `model.yaml`: positions of the logs from which a model was identified.

Elsewhere, load and friction of the model are extrapolated.
"""

from __future__ import annotations

import msgspec

from frictool.documents.quantity import Span

KEY = "logged_positions"  # key of the range, as JSON, in the record `log` of a simulated log
# largest distance of a motion from the logged positions without a warning, relative to their range:
# there, a cubic error of the load is T_3(1.2) = 3.3 times the largest error inside; tests of
# `excite` keep 5 % of the travel from its ends
MOST_BEYOND = 0.1


def leaves(logged: Span, low: float, high: float) -> bool:
    """Return True if the range `low` to `high` [rad | m] far exceeds the logged positions.

    Far means by more than MOST_BEYOND times the range of the logged positions.
    """
    return max(logged.low - low, high - logged.high) > MOST_BEYOND * (logged.high - logged.low)


def extrapolated_words(logged: Span | None, low: float, high: float, moving: str) -> str:
    """Return a warning if `low` to `high` [rad | m] far exceeds the logged positions, else "".

    moving: plural noun for the text, such as `steps`.
    """
    if logged is None or not leaves(logged, low, high):
        return ""
    return (
        f"the {moving} range from {low:.4g} to {high:.4g} {logged.unit}, but the model's logs only "
        f"from {logged.low:.4g} to {logged.high:.4g} {logged.unit}; outside, load and friction are "
        "extrapolated; validate the model on a log of these positions"
    )


def to_text(logged: Span) -> str:
    """Return the range as JSON."""
    return msgspec.json.encode(logged).decode()


def from_text(text: str) -> Span:
    """Return the range from JSON; raise msgspec.MsgspecError for any other text."""
    return msgspec.json.decode(text, type=Span)
