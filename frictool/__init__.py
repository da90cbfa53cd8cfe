"""From the bench logs of an actuator with dry friction to a verified robust controller."""

from __future__ import annotations

__version__: str


def __getattr__(name: str) -> str:
    """Return the installed version for `__version__`; it is looked up on first use."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version

    return version(__name__)
