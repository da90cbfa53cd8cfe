"""Commissioning: choice of the next test on a bench, until a controller meets the specification."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.plan.commissioning import PlanStep as PlanStep
    from frictool.plan.commissioning import next_step as next_step
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"commissioning": ["PlanStep", "next_step"]}
    )
