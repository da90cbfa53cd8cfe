"""The charts of a page as a reader has them, in a headless Chromium."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from frictool.documents.provenance import Input, Provenance
from frictool.logs.log import Log
from frictool.presentation.page import page_scripts
from frictool.report.page import page
from frictool.report.verdict import judge
from studies.rigs.step_logs import clutch_log, clutch_spec, controller
from tests.support.chromium import Browser, browser, find

pytestmark = pytest.mark.skipif(find() is None, reason="no chromium is on the PATH")
MADE = Provenance("frictool report run.mcap", "0.1.0", (Input("run.mcap", "ab" * 32),))
LARGEST_PAGE = 2_000_000  # bytes
MOUSE = """(() => {{ const u = document.querySelector('#{key}').charts[0], box = u.rect;
    const at = (type, x, y) => u.over.dispatchEvent(new MouseEvent(type, {{bubbles: true,
        clientX: box.left + x * box.width, clientY: box.top + y * box.height}}));
    at('mouseenter', 0.5, 0.5); at('mousemove', 0.5, 0.5); }})()"""
SCALES = (
    "[...document.querySelector('#{key}').charts].map(u => [u.scales.x.min, u.scales.x.max, "
    "u.scales.y.min, u.scales.y.max])"
)


@pytest.fixture(name="chromium", scope="module")
def _chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as running:
        yield running


@pytest.fixture(name="report", scope="module")
def _report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(page(judge(clutch_spec(), [clutch_log(7)], controller()), MADE))
    return path


def test_seventeen_plants_of_23_s_fit_into_two_megabytes() -> None:
    log: Log = clutch_log(16)
    assert (len(log.streams), round(float(log.streams[0].time[-1]))) == (17, 23)
    text = page(judge(clutch_spec(), [log], controller()), MADE)
    assert len(text.encode()) <= LARGEST_PAGE


def test_a_page_permits_its_two_scripts_and_no_other(report: Path) -> None:
    text = report.read_text()
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert policy.count("'sha256-") == 2
    assert "script-src 'unsafe" not in policy
    assert text.count("<script>") == len(page_scripts())
    assert "The MIT License" in text


def test_an_injected_script_does_not_run(chromium: Browser, report: Path, tmp_path: Path) -> None:
    changed = tmp_path / "changed.html"
    changed.write_text(report.read_text().replace("</main>", "<script>alert(1)</script></main>"))
    assert chromium.open(changed, 1280).dialogs == []


def test_every_figure_is_a_chart_and_its_svg_is_for_paper(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    counts = "['figure', '.chart', 'svg.static'].map(s => document.querySelectorAll(s).length)"
    figures, charts, static = chromium.evaluate(counts)
    assert figures == charts == static > 8
    assert not chromium.evaluate("document.querySelector('svg.static').checkVisibility()")
    chromium.call("Emulation.setEmulatedMedia", media="print")
    assert chromium.evaluate("document.querySelector('svg.static').checkVisibility()")
    assert not chromium.evaluate("document.querySelector('.chart').checkVisibility()")
    chromium.call("Emulation.setEmulatedMedia", media="")


def test_the_mouse_shows_values_with_units(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    chromium.evaluate(MOUSE.format(key="position"))
    shown = chromium.evaluate("document.querySelector('#position .readout').textContent")
    assert re.search(r"time [\d.]+ s", shown)
    assert re.search(r"run\.mcap[^:]*: [\d.]+ rad", shown)


def test_a_legend_entry_hides_its_curves(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    button = (
        "[...document.querySelectorAll('#position .toggles button')]"
        ".find(b => /variants/.test(b.textContent))"
    )
    hidden = (
        "document.querySelector('#position').charts[0].series.filter((s, i) => i && !s.show).length"
    )
    assert chromium.evaluate(hidden) == 0
    chromium.evaluate(f"{button}.click()")
    count = chromium.evaluate(
        "document.querySelector('#position').charts[0].parts"
        ".filter(p => p && /variants/.test(p.group)).length"
    )
    assert chromium.evaluate(hidden) == count > 1
    chromium.evaluate(f"{button}.click()")
    assert chromium.evaluate(hidden) == 0


def test_time_axes_are_linked(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    chromium.evaluate(
        "document.querySelector('#position').charts[0].setScale('x', {min: 1, max: 2})"
    )
    for key in ("position", "current", "velocity"):
        found = chromium.evaluate(SCALES.format(key=key if key != "current" else "drive"))
        assert found[0][:2] == [1, 2], key


def test_a_requirement_leads_to_its_place(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    key = chromium.evaluate(
        "[...document.querySelectorAll('a[data-view]')].find(a => "
        "/response/.test(a.textContent)).hash.slice(1)"
    )
    assert re.fullmatch(r"step-\d", key)
    assert chromium.evaluate(f"document.getElementById('{key}').charts.length") == 4


def test_the_band_of_the_static_error_is_enlarged(chromium: Browser, report: Path) -> None:
    chromium.open(report, 1280)
    before = chromium.evaluate(SCALES.format(key="step-1"))
    chromium.evaluate(
        "[...document.querySelectorAll('#step-1 .tools button')].find(b => "
        "b.textContent === 'static-error band').click()"
    )
    after = chromium.evaluate(SCALES.format(key="step-1"))
    assert after[0][3] - after[0][2] < 0.5 * (before[0][3] - before[0][2])
    assert after[0][2] < 55.0 < after[0][3]
    chromium.evaluate(
        "[...document.querySelectorAll('#step-1 .tools button')].find(b => "
        "b.textContent === 'whole figure').click()"
    )
    assert chromium.evaluate(SCALES.format(key="step-1")) == before


def test_every_folded_part_is_open_on_paper_and_no_table_is_cut(
    chromium: Browser, report: Path
) -> None:
    chromium.open(report, 688)  # A4 less its margins
    assert chromium.evaluate("[...document.querySelectorAll('details')].some(d => !d.open)")
    chromium.call("Emulation.setEmulatedMedia", media="print")
    heights = (
        "[...document.querySelectorAll('details table, details dl')]"
        ".map(e => e.getBoundingClientRect().height)"
    )
    assert min(chromium.evaluate(heights)) > 0
    cut = (
        "[...document.querySelectorAll('table')]"
        ".filter(t => t.getBoundingClientRect().right > 688.5).length"
    )
    assert chromium.evaluate(cut) == 0
    chromium.call("Emulation.setEmulatedMedia", media="")


def test_the_worst_plant_is_red_and_on_top(report: Path, chromium: Browser) -> None:
    chromium.open(report, 1280)
    parts = chromium.evaluate(
        "document.querySelector('#position').charts[0].parts.slice(1)"
        ".filter(p => p.kind === 'line' && /axis\\/v|mcap$/.test(p.label)).map(p => p.colour)"
    )
    assert parts[-1] == "#b3261e"
    assert parts.count("#b3261e") == 1
