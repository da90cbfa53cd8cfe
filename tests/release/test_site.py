"""The documentation as a site: anchors as on GitHub, every page in the navigation, and no warning
of MkDocs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from release.site import anchor, collect, pages
from tests.support.documentation_pages import PAGES, ROOT, anchors, name_of, prose


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_heading_has_one_anchor_in_both_places(page: Path) -> None:
    headings = re.findall(r"^#+ +(.*?)\s*$", prose(page), re.MULTILINE)
    plain = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading) for heading in headings]
    assert {anchor(heading) for heading in plain} == anchors(page)


def test_the_site_has_every_page_of_the_documentation() -> None:
    assert set(pages()) == set(PAGES)
    navigation = (ROOT / "mkdocs.yml").read_text()
    assert [page for page in PAGES if name_of(page) not in navigation] == []


def test_the_links_of_a_page_are_collected_with_it(tmp_path: Path) -> None:
    collect(tmp_path)
    assert (tmp_path / "docs/schemas/bench.schema.json").is_file()
    assert (tmp_path / "docs/first_page.svg").is_file()


def test_mkdocs_builds_it_without_a_warning() -> None:
    pytest.importorskip("mkdocs")
    done = subprocess.run(
        [sys.executable, "-m", "release.site"], cwd=ROOT, capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert (ROOT / "build/site/search/search_index.json").is_file()
