"""Options that several commands share, and the types of the option values."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from frictool.cli.file_endings import check_ending

F = TypeVar("F", bound=Callable[..., Any])


class NamedPath(click.Path):
    """Type of a path option that rejects an empty name.

    pathlib turns an empty name, for example from an unset shell variable, into the current folder.
    """

    def __init__(
        self, allow_dash: bool = False, writes: Sequence[str] = (), chooses: bool = False
    ) -> None:
        """Store `writes`, the allowed formats (see `check_ending`); if empty, all are allowed."""
        self._writes, self._chooses = writes, chooses
        # existence and permission are checked on reading, so that the exit code is 3 and not
        # click's 2
        super().__init__(path_type=Path, readable=False, allow_dash=allow_dash)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("the name is empty.", param, ctx)
        path = super().convert(value, param, ctx)
        if self._writes:
            check_ending(Path(str(path)), self._writes, self._chooses)
        return path


def output_option(
    required: bool = True,
    help: str = "Where to write; - is stdout.",
    writes: Sequence[str] = (),
    chooses: bool = False,
) -> Callable[[F], F]:
    """Return the option `-o/--output PATH`; `check_ending` explains `writes` and `chooses`."""
    return click.option(
        "-o", "--output", type=NamedPath(True, writes, chooses), required=required, help=help
    )


allow_undecided_option = click.option(
    "--allow-undecided",
    is_flag=True,
    help=(
        "Exit code 0 also if requirements are undecided, provided that none is violated and at "
        "least one is met."
    ),
)


json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON object on stdout instead of text."
)


class FiniteRange(click.FloatRange):
    """Type of a number option that rejects NaN and implausible magnitudes.

    click's own range accepts NaN, because every comparison with NaN is false. A nonzero magnitude
    below LEAST or above LARGEST is probably a typing error.
    """

    LEAST, LARGEST = 1e-15, 1e12

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"found {number}; allowed: a finite number.", param, ctx)
        if number and not self.LEAST <= abs(number) <= self.LARGEST:
            self.fail(
                f"found {number:g}; allowed: 0, or {self.LEAST:g} to {self.LARGEST:g} in "
                "magnitude.",
                param,
                ctx,
            )
        return number

    def _describe_range(self) -> str:
        return "" if self.min is None and self.max is None else super()._describe_range()


existing = NamedPath()
