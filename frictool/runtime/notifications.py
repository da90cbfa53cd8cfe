"""Notifications to the user: compilation, remarks, and document values that were not measured.

A notification goes to the receiver in the current context (`contextvars`). Without a receiver, the
notification is dropped, so that frictool is silent as a library. A thread does not inherit the
context: code that starts a thread must run the thread's work in a copy of the context.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypedDict, Unpack


class Receivers(TypedDict, total=False):
    """Functions that receive notifications, one for each kind of notification.

    A receiver has the name and arguments of the function of this module that notifies it.
    """

    compiling: Callable[[], None]
    remark: Callable[[str], None]
    example_values: Callable[[str, tuple[str, ...]], None]
    bench_values: Callable[[str, str], None]
    missing_effect: Callable[[str, str], None]


_receivers: ContextVar[Receivers] = ContextVar("receivers")


@contextmanager
def receiving(**receivers: Unpack[Receivers]) -> Iterator[None]:
    """Send the notifications of the with-block to `receivers`."""
    token = _receivers.set(_current() | receivers)
    try:
        yield
    finally:
        _receivers.reset(token)


def compiling() -> None:
    """Notify that a kernel is being compiled for its first use in an installation."""
    if receiver := _current().get("compiling"):
        receiver()


def remark(text: str) -> None:
    """Notify of an event that changes no result, such as the replacement of a worker process."""
    if receiver := _current().get("remark"):
        receiver(text)


def example_values(path: str, keys: tuple[str, ...]) -> None:
    """Notify that the keys `keys` of the document at `path` still have the values of an example."""
    if receiver := _current().get("example_values"):
        receiver(path, keys)


def bench_values(path: str, reason: str) -> None:
    """Notify that all values of the model at `path` come from the bench; `reason` says why."""
    if receiver := _current().get("bench_values"):
        receiver(path, reason)


def missing_effect(path: str, text: str) -> None:
    """Notify that the model at `path` lacks an effect that its logs show; `text` names it."""
    if receiver := _current().get("missing_effect"):
        receiver(path, text)


def _current() -> Receivers:
    return _receivers.get(Receivers())
