"""Stage: the equations of a mechanism, derived from its description: symbols, sums of products, their dimensions, what is eliminated."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.equations.derived import Equations as Equations
    from frictool.equations.derived import equations as equations
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Equations": "frictool.equations.derived",
            "equations": "frictool.equations.derived",
        },
    )

__all__ = ["Equations", "equations"]
