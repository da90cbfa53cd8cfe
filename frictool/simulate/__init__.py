"""Step tests of a model under its controller, as a log."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.simulate.bench_play import play as play
    from frictool.simulate.simulation import simulate as simulate
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "play": "frictool.simulate.bench_play",
            "simulate": "frictool.simulate.simulation",
        },
    )

__all__ = ["play", "simulate"]
