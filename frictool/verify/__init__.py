"""The closed loop rebuilt from coefficients: stability, norms, margins, sampled. Knows no solver."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.verify.again import verify as verify
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "verify": "frictool.verify.again",
        },
    )

__all__ = ["verify"]
