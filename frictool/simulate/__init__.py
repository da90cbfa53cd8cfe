"""Simulation of a model or a mechanism, usually with a controller; the result is a log."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.simulate.bench_experiment_api import play as play
    from frictool.simulate.closed_loop import SimulationRequest as SimulationRequest
    from frictool.simulate.simulation import simulate as simulate
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "bench_experiment_api": ["play"],
            "closed_loop": ["SimulationRequest"],
            "simulation": ["simulate"],
        },
    )
