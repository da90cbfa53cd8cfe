"""Model, specification and design to a controller that was verified."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.synth.design import Designed as Designed
    from frictool.synth.own import own_controller as own_controller
    from frictool.synth.synthesis import synthesise as synthesise
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Designed": "frictool.synth.design",
            "own_controller": "frictool.synth.own",
            "synthesise": "frictool.synth.synthesis",
        },
    )

__all__ = ["Designed", "own_controller", "synthesise"]
