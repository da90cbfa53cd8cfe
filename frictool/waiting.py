"""What is called before a wait that the user should know of: the command line puts its own in place, a library waits in silence."""

from __future__ import annotations

from collections.abc import Callable


def _silently() -> None:
    """Nobody asked to be told."""


compiling: Callable[[], None] = _silently  # before a kernel is compiled, which its first use in an installation does
