"""Data losses of a log: readers collect them, and the metadata record `lost` stores them."""

from __future__ import annotations

import re
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import msgspec

from frictool.errors import LogError
from frictool.logs.raw_table import DataLoss

LOST = "lost"  # metadata record: number -> DataLoss as JSON
# maximum number of separate losses of the same channels for the same reason; a further loss is
# joined with the last of them
MOST_OF_A_KIND = 100
MOST = 1000
MOST_SHOWN = 3  # maximum number of losses of a kind that a text shows one by one
_LINE = re.compile(r"^line \d+: ")


class LossList(list[DataLoss]):
    """Bounded list of data losses, because every row of a long log may be damaged."""

    def __init__(self) -> None:
        super().__init__()
        self._kinds: dict[
            tuple[tuple[str, ...], str], tuple[int, int]
        ] = {}  # (channels, reason) -> count, index of the last loss

    def append(self, loss: DataLoss) -> None:
        """Append a loss.

        If the list already has MOST_OF_A_KIND losses of the same channels for the same reason,
        `loss` is merged with the last of these losses. If the list has MOST losses or more, losses
        of the same channels are merged even if their reasons differ.
        """
        kind = (loss.channels, loss.reason if len(self) < MOST else "")
        count, last = self._kinds.get(kind, (0, 0))
        if count >= MOST_OF_A_KIND or (count and len(self) >= MOST):
            self[last] = _joined(self[last], loss)
            return
        self._kinds[kind] = (count + 1, len(self))
        super().append(loss)


def _joined(one: DataLoss, other: DataLoss) -> DataLoss:
    samples = None if one.samples is None or other.samples is None else one.samples + other.samples
    return replace(one, end_s=other.end_s, samples=samples)


def record_of(losses: list[DataLoss]) -> dict[str, str]:
    """Return the entries of the metadata record `lost` for these losses."""
    return {
        str(number): msgspec.json.encode(asdict(loss)).decode()
        for number, loss in enumerate(losses, start=1)
    }


def losses_of(
    metadata: dict[str, dict[str, str]], source: Path | str = "the log"
) -> list[DataLoss]:
    """Return the losses that the metadata record `lost` of a log contains.

    Raises LogError with the name `source` if the record does not have the form that frictool
    writes.
    """
    try:
        return [
            msgspec.json.decode(text, type=DataLoss) for text in metadata.get(LOST, {}).values()
        ]
    except ValueError as error:
        raise LogError(
            source, f"metadata {LOST!r} is not a list of losses as frictool writes it: {error}"
        ) from None


def as_rows(losses: list[DataLoss]) -> list[dict[str, Any]]:
    """Return the losses as dictionaries for JSON output."""
    return [asdict(loss) for loss in losses]


def loss_count_text(losses: list[DataLoss]) -> str:
    """Return a text with the numbers of samples and losses, such as "3 samples in 2 places"."""
    samples = sum(loss.samples or 0 for loss in losses)
    known = f"{samples} sample{'s' * (samples != 1)}"
    number = f"in {len(losses)} place{'s' * (len(losses) != 1)}"
    if all(loss.samples is not None for loss in losses):
        return f"{known} {number}"
    return f"at least {known}, {number}" if samples else f"an unknown number of samples, {number}"


def loss_lines(losses: list[DataLoss]) -> list[str]:
    """Return lines of text about the losses; a line may summarise many losses of one kind.

    Losses are of one kind if they have the same channels and, apart from a line number, the same
    reason. The first MOST_SHOWN losses of a kind have a line each, and one line summarises the
    others of this kind.
    """
    kinds: dict[tuple[tuple[str, ...], str], list[DataLoss]] = {}
    for loss in losses:
        kinds.setdefault((loss.channels, _LINE.sub("", loss.reason)), []).append(loss)
    lines = []
    for kind in kinds.values():
        shown = kind if len(kind) <= MOST_SHOWN + 1 else kind[:MOST_SHOWN]
        lines += [loss_text(loss) for loss in shown]
        if more := kind[len(shown) :]:
            span = replace(more[0], end_s=more[-1].end_s)
            where = _span(span.start_s, span.end_s)
            lines.append(f"further losses: {loss_count_text(more)} {where}, for the same reason")
    return lines


def loss_text(loss: DataLoss) -> str:
    """Return one line of text with the samples, channels, times and reason of a loss."""
    samples = (
        "samples"
        if loss.samples is None
        else f"{loss.samples} sample{'s' if loss.samples != 1 else ''}"
    )
    channels = f" of {', '.join(loss.channels)}" if loss.channels else ""
    return f"{samples}{channels} {_span(loss.start_s, loss.end_s)}: {loss.reason}".replace(
        "  ", " "
    )


def _span(start: float | None, end: float | None) -> str:
    if start is None and end is None:
        return "at an unknown time"
    if start is None:
        return f"before {end:.6g} s"
    return f"after {start:.6g} s" if end is None else f"from {start:.6g} to {end:.6g} s"
