"""Limits of a mechanism's numbers, so that no product of them overflows."""

from __future__ import annotations

from typing import Any

import msgspec

from frictool.documents.quantity import Quantity, Series, Span
from frictool.plant.mechanism.element_error import ElementError

SMALLEST, LARGEST = 1e-30, 1e30  # SI, magnitudes that a document may contain


def check_sizes(value: Any, key: str = "") -> None:
    """Raise ElementError for the first number in `value` whose magnitude is outside the limits.

    Nested values are checked, too. `key` is the key of `value` in the document.
    """
    if isinstance(value, Quantity | Span):
        for name in ("value", "low", "high"):
            _check(f"{key}.{name}", getattr(value, name, None), value.unit)
    elif isinstance(value, Series):
        for index, number in enumerate(value.values):
            _check(f"{key}.values[{index}]", number, value.unit)
    elif isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            check_sizes(getattr(value, name), f"{key}.{name}" if key else name)
    elif isinstance(value, dict):
        for name, item in value.items():
            check_sizes(item, f"{key}.{name}")
    elif isinstance(value, tuple):
        for index, item in enumerate(value):
            check_sizes(item, f"{key}[{index}]")
    elif isinstance(value, float):
        _check(key, value, "")


def _check(key: str, number: float | None, unit: str) -> None:
    if number is None or number == 0.0 or SMALLEST <= abs(number) <= LARGEST:
        return
    raise ElementError(
        key,
        f"found {number:g}{' ' + unit if unit else ''}; allowed: 0, or {SMALLEST:g} to "
        f"{LARGEST:g} in magnitude",
    )
