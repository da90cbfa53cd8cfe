"""Results of one part of the reproduction: values by table and key, figures by number."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class ComputedValue:
    """Computed value.

    With `low` and `high`, the published value agrees if it is between them; `spread` names this
    range.
    """

    value: float | str
    low: float | None = None
    high: float | None = None
    spread: str = ""


@dataclass(frozen=True)
class DrawnFigure:
    """Figure: `<svg>` elements, one below the other, and a caption with computed values."""

    svgs: tuple[str, ...]
    caption: str


@dataclass
class Part:
    """Results of a part.

    values: table -> key -> value. figures: number in the thesis -> figure. notes: table -> lines
    without a published value.
    """

    values: dict[str, dict[str, ComputedValue]] = field(default_factory=dict)
    figures: dict[str, DrawnFigure] = field(default_factory=dict)
    notes: dict[str, list[str]] = field(default_factory=dict)

    def add(self, table: str, values: dict[str, float | str | ComputedValue]) -> None:
        """Add values to a table; a plain number or text has no spread."""
        mine = self.values.setdefault(table, {})
        for key, value in values.items():
            assert key not in mine, f"{table} {key} twice"
            mine[key] = value if isinstance(value, ComputedValue) else ComputedValue(value)

    def draw(self, number: str, caption: str, *svgs: str) -> None:
        """Add a figure."""
        assert number not in self.figures, f"figure {number} twice"
        self.figures[number] = DrawnFigure(svgs, caption)

    def say(self, table: str, line: str) -> None:
        """Add a line below a table."""
        self.notes.setdefault(table, []).append(line)
