"""What is called before a wait that the user should know of, or of a remark on the way: the command
line puts its own in place, a library is silent.
"""

from __future__ import annotations

from collections.abc import Callable


def _silently() -> None:
    """Nobody asked to be told."""


def _unsaid(text: str) -> None:
    """Nobody asked to be told."""


compiling: Callable[[], None] = (
    _silently  # before a kernel is compiled, which its first use in an installation does
)
remark: Callable[[str], None] = (
    # of what changes no result: a process that was ended and replaced, a machine that compiles
    _unsaid
)
