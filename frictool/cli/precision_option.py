"""Type of options for a relative precision, of one parameter or of all parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click


class PrecisionParam(click.ParamType[tuple[str | None, float]]):
    """Type of a precision option, such as `5%`, `0.05` or `inertia=5%`.

    `named`: True if the value must contain the name of a parameter.
    """

    name = "precision"

    def __init__(self, parameters: Sequence[str], named: bool = False) -> None:
        self._parameters = parameters
        self._named = named

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str | None, float]:
        name, _, number = str(value).rpartition("=")
        allowed = ", ".join(self._parameters)
        if name and name not in self._parameters:
            self.fail(f"unknown parameter {name!r}; allowed: {allowed}.", param, ctx)
        if self._named and not name:
            self.fail(f"found {value!r}; allowed: NAME=2%, NAME one of {allowed}.", param, ctx)
        try:
            part = float(number.removesuffix("%")) / (100.0 if number.endswith("%") else 1.0)
        except ValueError:
            part = math.nan
        if not 0.0 < part < 1.0:
            self.fail(
                (
                    f"found {number!r}; allowed: a precision above 0 and below 100%, such as 5% "
                    "or 0.05."
                ),
                param,
                ctx,
            )
        return name or None, part
