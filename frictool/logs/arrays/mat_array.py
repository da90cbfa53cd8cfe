"""Array of a MATLAB file of any version, and its division into the columns of a table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from frictool.logs.arrays.array_table import ArrayColumn

ADVICE = (
    "an object; save its times and values as vectors in MATLAB; a table or timetable is read with "
    "mat-io (pip install 'frictool[matlab]')"
)
MOST_COLUMNS = 1000  # longest shorter side of a matrix; a larger one is an image or damaged


class MatrixLine(NamedTuple):
    """Column or row of a matrix, used as a column of a table.

    name: name such as `x(:,1)`.
    first: index of the line's first value among the numbers of the matrix, which are counted column
        by column.
    stride: increase of the index from one value of the line to the next.
    """

    name: str
    first: int
    rows: int
    stride: int


@dataclass(frozen=True)
class MatArray:
    """Array of a MATLAB file.

    name: path of the array in the file, such as `data.signals.values`.
    shape: size along each axis.
    column: location of the numbers in the file, where they are stored column by column; None if the
        array does not consist of real numbers.
    text: content of a char array; None for other arrays.
    """

    name: str
    shape: tuple[int, ...]
    kind: str
    column: ArrayColumn | None = None
    text: str | None = None

    def __str__(self) -> str:
        return f"{'x'.join(map(str, self.shape))} {self.kind}".strip()

    def columns(self) -> Iterator[tuple[str, ArrayColumn]]:
        """Yield the name and the location of each vector in the array."""
        if self.column is None:
            return
        for line in lines(self.name, self.shape):
            size = self.column.dtype.itemsize
            yield (
                line.name,
                replace(
                    self.column,
                    offset=self.column.offset + line.first * size,
                    rows=line.rows,
                    step=line.stride * size,
                ),
            )


def lines(name: str, shape: tuple[int, ...]) -> Iterator[MatrixLine]:
    """Yield the array itself if it is a vector, else the columns of a matrix, named `name(:,1)`.

    A matrix with more columns than rows (as from Simulink's To File block) is divided into its
    rows.

    >>> [line.name for line in lines("x", (9, 2))], [line.name for line in lines("x", (1, 1, 9))]
    (['x(:,1)', 'x(:,2)'], ['x'])
    """
    sides = [n for n in shape if n != 1]
    size = math.prod(shape)
    if len(sides) == 1 and size > 1:
        yield MatrixLine(name, 0, size, 1)
    elif len(sides) == 2 and len(shape) == 2 and 1 < min(shape) <= MOST_COLUMNS:
        high, wide = shape
        if high >= wide:
            for k in range(wide):
                yield MatrixLine(f"{name}(:,{k + 1})", k * high, high, 1)
        else:
            for k in range(high):
                yield MatrixLine(f"{name}({k + 1},:)", k, wide, high)


def described(arrays: list[MatArray]) -> dict[str, str]:
    """Return the name and a description of each array that is not a real vector."""
    return {array.name: str(array) for array in arrays if array.name not in dict(array.columns())}
