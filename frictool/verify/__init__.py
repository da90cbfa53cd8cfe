"""Verification of controllers from their stored coefficients, without an LMI solver."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.verify.observed_controller import with_observer as with_observer
    from frictool.verify.recheck import verify as verify
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"observed_controller": ["with_observer"], "recheck": ["verify"]}
    )
