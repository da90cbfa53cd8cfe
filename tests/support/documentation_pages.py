"""The pages of the documentation as the tests read them: code blocks in order, headings, links."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
BESIDE = (
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "sample_logs/README.md",
    "configs/layouts/README.md",
)
PAGES = [*(ROOT / name for name in BESIDE), *sorted((ROOT / "docs").rglob("*.md"))]

_FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, the line of its fence."""

    language: str
    text: str
    line: int

    @property
    def lines(self) -> list[str]:
        return [line for line in self.text.splitlines() if line.strip()]


def name_of(page: Path) -> str:
    return str(page.relative_to(ROOT))


@cache
def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def blocks(page: Path, *languages: str) -> list[Block]:
    """The fenced blocks of a page, from top to bottom; only those of `languages`, where some are
    given."""
    text = text_of(page)
    found = [
        Block(match[1], match[2], text[: match.start()].count("\n") + 1)
        for match in _FENCE.finditer(text)
    ]
    return [block for block in found if not languages or block.language in languages]


def prose(page: Path) -> str:
    """A page without its fenced blocks."""
    return _FENCE.sub("", text_of(page))


@cache
def anchors(page: Path) -> set[str]:
    """Return the anchors of the page's headings as GitHub makes them: lower case, blanks as
    hyphens, no other signs."""
    made: list[str] = []
    for heading in re.findall(r"^#+ +(.*?)\s*$", prose(page), re.MULTILINE):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        made.append(name if name not in made else f"{name}-{made.count(name)}")
    return set(made)


def links(page: Path) -> list[tuple[str, str]]:
    """(path, anchor) of every link that stays in the repository; the path is empty where the link
    stays in the page."""
    targets = re.findall(r"\]\(([^)\s]+)\)", prose(page))
    return [
        (target.partition("#")[0], target.partition("#")[2])
        for target in targets
        if "://" not in target
    ]
