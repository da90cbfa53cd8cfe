"""Synthesis of a verified controller document from a model, a specification and a design."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.synth.design import SynthesisResult as SynthesisResult
    from frictool.synth.external_design import external_controller as external_controller
    from frictool.synth.synthesis import synthesise as synthesise
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "design": ["SynthesisResult"],
            "external_design": ["external_controller"],
            "synthesis": ["synthesise"],
        },
    )
