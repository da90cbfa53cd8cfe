"""Figure of a model document: friction over speed and, if position matters, over position."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictool.documents.model import Model
from frictool.identify.model_page.friction_panels import friction_panels
from frictool.identify.model_page.panel import panel_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def model_figure(model: Model) -> Figure:
    """Draw the friction panels that need no logs."""
    return panel_figure(friction_panels(model, None, None))
