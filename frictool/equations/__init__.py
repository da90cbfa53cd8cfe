"""Equations of motion of a mechanism, derived from its description, with a check of dimensions."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.equations.mechanism_equations import Equations as Equations
    from frictool.equations.mechanism_equations import equations as equations
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"mechanism_equations": ["Equations", "equations"]}
    )
