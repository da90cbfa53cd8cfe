"""The page: self-contained, escaped, small, the same bytes again; every trial's fate on it."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from frictool.campaign.statistics.findings import find
from frictool.campaign.views.campaign_figures import failing_plane, metric
from frictool.campaign.views.page import page
from frictool.documents.provenance import Input, Provenance
from tests.campaign.example_findings import CORNERS, HOSTILE, findings, stopped, trials
from tests.support.campaign_trials import factors, trials_of
from tests.support.chromium import browser
from tests.support.chromium import find as find_chromium
from tests.support.html_page import SVG_NAMESPACES, Page, without_own_scripts

MADE = Provenance(
    "frictool campaign model.yaml controller.yaml", "0.1.0", (Input("model.yaml", "ab" * 32),)
)


@pytest.fixture(name="full", scope="module")
def _full() -> str:
    return page(findings(stopped(trials(), (5, 9))), MADE)


def test_the_answer_comes_first_then_what_passes_where_failures_come_from_and_the_pictures(
    full: str,
) -> None:
    text = Page(full).text
    parts = [
        "FAIL: ",
        "Requirements",
        "Pass rates",
        "Where failures come from",
        "Where the variance",
        "Each metric",
        "Worst cases",
        "What was varied",
    ]
    places = [text.index(part, text.index("Campaign\n")) for part in parts]
    assert places == sorted(places)


def test_the_fate_of_every_trial_and_the_command_that_replays_the_worst_are_on_it(
    full: str,
) -> None:
    text = Page(full).text
    assert "the position is beyond 1e3 rad" in text
    assert (
        "frictool simulate model.yaml --controller controller.yaml --scenario "
        "worst_response_time_95.yaml" in text
    )
    assert "Causes of failed simulations (2 trials compared with 398)" in text
    assert "The same in every trial that has it: rest 0 A." in text
    assert "limit cycle" in text
    assert "each uniformly over its range" in text


def test_it_asks_nobody_for_anything(full: str) -> None:
    found = Page(full)
    assert "script" not in found.tags
    addresses = [
        value
        for name, value in found.attributes
        if re.match(r"(src|href|xlink:href|action|xmlns.*)$", name)
    ]
    assert all(value.startswith("#") or value in SVG_NAMESPACES for value in addresses)
    assert "@import" not in full
    assert "url(http" not in full


def test_the_same_trials_give_the_same_bytes(full: str) -> None:
    assert page(findings(stopped(trials(), (5, 9))), MADE) == full


def test_names_from_files_are_text_and_nothing_else() -> None:
    html = page(findings(stopped(trials(label=HOSTILE), (1,), reason=HOSTILE)), MADE)
    assert HOSTILE not in html
    assert "<b>" not in html
    assert "script" not in Page(html).tags
    assert Page(html).text.count("</script><b>") >= 5


def test_pictures_count_what_is_many() -> None:
    assert len(without_own_scripts(page(findings(trials(20_000)), MADE))) < 200_000


def test_every_trial_is_a_point_of_the_plane_as_long_as_they_are_few_then_cells_are() -> None:
    for n, dots in ((300, 300), (2000, 0)):
        found = find(trials_of(factors(2), [lambda v: v[:, 0] * v[:, 1]], [0.6], n), "random")
        picture = failing_plane(found)
        assert picture is not None
        drawn = re.findall(r'<path d="([^"]*)"[^>]*stroke-linecap: round', picture.svg)
        assert (
            sum(len(re.findall(r"M \S+ [-\d.]+L\S+ \S+", path)) for path in drawn) == dots
        )  # a lone M draws nothing
        assert ("grey: trials that pass" in picture.caption) == (dots > 0)


def test_a_bar_beyond_the_limit_is_red_and_no_other() -> None:
    for slow, red in ((0.3, True), (np.inf, False)):
        found = findings(trials(slow=slow))
        picture = metric(found, found.distributions[0])
        assert picture is not None
        assert ("fill: #b3261e" in picture.svg) == red


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("vertices", lambda: findings(trials(units=CORNERS), "vertices")),
        ("one draw", lambda: findings(trials(1), "latin", 0.5)),
        ("none is simulated", lambda: findings(stopped(trials(30), tuple(range(30))))),
    ],
)
def test_it_is_made_of_whatever_has_happened(name: str, made) -> None:
    found = made()
    text = Page(page(found, MADE)).text
    assert ("of plants keep" in text) == (not found.rate.whole)
    assert "Pass rates" in text


@pytest.mark.skipif(find_chromium() is None, reason="no chromium is on the PATH")
def test_a_browser_shows_it_on_a_phone_and_on_a_desk(full: str, tmp_path: Path) -> None:
    target = tmp_path / "campaign.html"
    target.write_text(full, encoding="utf-8")
    with browser(tmp_path / "profile") as chromium:
        for width in (390, 1280):
            seen = chromium.open(target, width)
            assert not seen.console
            assert not seen.dialogs
            assert [
                address for address in seen.requests if not address.startswith(("file:", "data:"))
            ] == []
            assert chromium.evaluate("document.documentElement.scrollWidth") <= width
            rows = chromium.evaluate(
                "[...document.querySelectorAll('tbody tr')].map(r => "
                "r.getBoundingClientRect().height)"
            )
            if width == 1280:  # on a phone the cells of a row stand one under the other
                assert max(rows) < 100, "a column is so narrow that its words do"
            cut = chromium.evaluate(
                "[...document.querySelectorAll('.wide')].filter(t => t.scrollWidth > "
                "t.clientWidth).length"
            )
            assert cut == 0, "a table is cut at the right edge"
            sizes = chromium.evaluate(
                "[...document.querySelectorAll('figure')].map(f => (f.querySelector('.chart') "
                "?? f.querySelector('svg')).getBoundingClientRect().width)"
            )
            assert len(sizes) >= 5
            assert min(sizes) > 0.4 * min(width, 1160)
