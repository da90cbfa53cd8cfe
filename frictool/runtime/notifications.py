"""Hooks called before a long wait and for remarks to the user.

The command line replaces them; as a library frictool stays silent.
"""

from __future__ import annotations

from collections.abc import Callable


def _silently() -> None:
    """Ignore the notification."""


def _unsaid(text: str) -> None:
    """Ignore the remark."""


# called before a kernel is compiled, at its first use in an installation
compiling: Callable[[], None] = _silently
# called with a remark that changes no result, for example on a worker process that was replaced
remark: Callable[[str], None] = _unsaid
