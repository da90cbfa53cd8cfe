"""The documentation as a site with search: `python -m release.site`, run by `make docs`.

Pages and the files that they link to are collected below build/pages at their places in the
repository, so that every relative link holds. mkdocs.yml has the navigation and the checks.
"""

from __future__ import annotations

import logging
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
COLLECTED = ROOT / "build/pages"
BESIDE = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "sample_logs", "configs/layouts")
LINK = re.compile(r"\]\(([^)\s#]+)")


def anchor(heading: str, separator: str = "-") -> str:
    """Return the anchor of a heading as GitHub makes it, so that a link holds in both places."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", separator)


def collect(target: Path) -> None:
    """Copy the pages, and the files that they link to, into an empty folder."""
    shutil.rmtree(target, ignore_errors=True)
    for page in pages():
        for path in (page, *linked_files(page)):
            copy = target / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)


def pages() -> list[Path]:
    """Return the pages of the documentation."""
    roots = [ROOT / name for name in (*BESIDE, "docs")]
    return [
        page
        for root in roots
        for page in ([root] if root.suffix == ".md" else sorted(root.rglob("*.md")))
    ]


def linked_files(page: Path) -> list[Path]:
    """Return the files of the repository that a page links to, pages included."""
    targets = (page.parent / link for link in LINK.findall(page.read_text(encoding="utf-8")))
    return [path.resolve() for path in targets if path.is_file()]


def main() -> int:
    """Collect the pages and build the site; the exit code is 1 after a warning of MkDocs."""
    from mkdocs.commands.build import build
    from mkdocs.config import load_config
    from mkdocs.exceptions import Abort

    logging.basicConfig(level=logging.WARNING, format="%(message)s")
    collect(COLLECTED)
    try:
        build(load_config(str(ROOT / "mkdocs.yml")))
    except Abort as error:
        print(error, file=sys.stderr)
        return 1
    print(ROOT / "build/site/index.html")
    return 0


if __name__ == "__main__":
    sys.exit(main())
