"""Reduction of a mechanism to the one-inertia model, with the error of each step (thesis 2.1.5)."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.reduce.reduction import Reduction as Reduction
    from frictool.reduce.reduction import ReductionRequest as ReductionRequest
    from frictool.reduce.reduction import reduce as reduce
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"reduction": ["Reduction", "ReductionRequest", "reduce"]}
    )
