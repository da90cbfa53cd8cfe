"""Results of one part of the reproduction: values by table and key, figures by number."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Found:
    """One value of ours. With `low` and `high` the published one agrees if it lies between;
    `spread` says what they are."""

    value: float | str
    low: float | None = None
    high: float | None = None
    spread: str = ""


@dataclass(frozen=True)
class Drawn:
    """One figure of ours: `<svg>` elements one below the other, and what is seen in them, in our
    own figures."""

    svgs: tuple[str, ...]
    caption: str


@dataclass
class Part:
    """values: table -> key; figures: the thesis's number -> what is drawn; beside: table -> lines
    that no published value goes with."""

    values: dict[str, dict[str, Found]] = field(default_factory=dict)
    figures: dict[str, Drawn] = field(default_factory=dict)
    beside: dict[str, list[str]] = field(default_factory=dict)

    def add(self, table: str, values: dict[str, float | str | Found]) -> None:
        """Puts values into a table; a bare one has no spread."""
        mine = self.values.setdefault(table, {})
        for key, value in values.items():
            assert key not in mine, f"{table} {key} twice"
            mine[key] = value if isinstance(value, Found) else Found(value)

    def draw(self, number: str, caption: str, *svgs: str) -> None:
        """Puts a figure in."""
        assert number not in self.figures, f"figure {number} twice"
        self.figures[number] = Drawn(svgs, caption)

    def say(self, table: str, line: str) -> None:
        """A line below a table."""
        self.beside.setdefault(table, []).append(line)
