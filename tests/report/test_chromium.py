"""The page as a reader has it: in a headless Chromium, as wide as a phone and as a desktop, and on
paper."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.logs.log import Log
from frictool.report.page import page
from frictool.report.verdict import judge
from frictool.verify.vertex_transfers import sensitivities
from studies.rigs.step_logs import (
    HOSTILE,
    clutch_log,
    clutch_spec,
    controller,
    hostile_log,
    smooth_log,
    stream,
)
from tests.support.chromium import Browser, browser, find
from tests.support.html_page import MADE

pytestmark = pytest.mark.skipif(find() is None, reason="no chromium is on the PATH")
PHONE, DESKTOP = 390, 1280
WIDTHS = (PHONE, DESKTOP)
# elements that reach beyond the window; a phone's browser would widen its own measure to them
BEYOND = """[...document.querySelectorAll('body *')]
    .filter(e => !e.closest('svg g')
        && e.getBoundingClientRect().right > WIDTH + 0.5)
    .map(e => e.tagName + ' ' + e.className)"""
BOXES = """[...document.querySelectorAll('figure')].map(f => {
    const shown = f.querySelector('.chart') ?? f.querySelector('svg'),
        box = shown.getBoundingClientRect(), paths = f.querySelectorAll('svg path');
    return [box.width, box.height, paths.length, f.checkVisibility()] })"""


@pytest.fixture(name="chromium", scope="module")
def _chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with browser(tmp_path_factory.mktemp("profile")) as running:
        yield running


@pytest.fixture(name="pages", scope="module")
def _pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A page with everything, one of a log without a step, one of several logs, and one where every
    name is hostile."""
    weights = CertifiedWeights(Filter(31.5, 40.0, 0.63), 0.03, 0.5)
    verified = msgspec.structs.replace(controller(), weights=weights)
    late = Log(
        (stream(damping=0.6, references=((55.0, 2.0), (5.0, 1.1), (35.0, 1.5), (15.0, 20.0))),),
        {},
        "bench.mcap",
    )
    plans = {
        "full": ([clutch_log(3)], verified),
        "smooth": ([smooth_log()], None),
        "several": ([clutch_log(), late], None),
        "hostile": (
            [hostile_log()],
            msgspec.structs.replace(verified, name=HOSTILE, sign_convention=HOSTILE),
        ),
    }
    folder, spec, made = (
        tmp_path_factory.mktemp("pages"),
        msgspec.structs.replace(clutch_spec(), name=HOSTILE[:80]),
        {},
    )
    for name, (logs, controlled) in plans.items():
        transfers = None if controlled is None else sensitivities(controlled)
        made[name] = folder / f"{name}.html"
        made[name].write_text(
            page(judge(spec, logs, controlled), MADE, transfers),
            encoding="utf-8",
        )
    return made


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize(
    ("name", "plots"),
    [
        ("full", 4 + 1 + 4 + 1 + 4),
        pytest.param("smooth", 5, marks=pytest.mark.accept),
        pytest.param("several", 4 + 4, marks=pytest.mark.accept),
        ("hostile", 4 + 1 + 4 + 1 + 4),
    ],
)
def test_every_plot_is_shown_and_nothing_overflows_or_is_fetched(
    chromium: Browser, pages: dict[str, Path], name: str, plots: int, width: int
) -> None:
    seen = chromium.open(pages[name], width)
    boxes = chromium.evaluate(BOXES)
    assert len(boxes) == plots
    for shown_width, height, paths, visible in boxes:
        assert visible
        assert shown_width > 0.4 * min(width, 720)
        assert height > 100
        assert paths >= 3  # frame, grid and curves
    assert chromium.evaluate("document.documentElement.scrollWidth") <= width
    assert chromium.evaluate(BEYOND.replace("WIDTH", str(width))) == []
    assert seen.requests == [pages[name].as_uri()]
    assert (seen.dialogs, seen.console) == ([], [])


@pytest.mark.parametrize("width", WIDTHS)
def test_names_that_are_scripts_do_nothing_and_are_shown_as_they_are(
    chromium: Browser, pages: dict[str, Path], width: int
) -> None:
    seen = chromium.open(pages["hostile"], width)
    assert chromium.evaluate("[document.scripts.length, document.images.length]") == [2, 0]
    assert chromium.evaluate("document.title") != "run"
    assert seen.dialogs == []
    shown = chromium.evaluate("document.body.textContent")
    assert shown.count(HOSTILE) > 5
    attributes = (
        "[...document.querySelectorAll('*')].flatMap(e => [...e.attributes].map(a => "
        "a.name)).filter(n => n.startsWith('on'))"
    )
    assert chromium.evaluate(attributes) == []


def test_verdict_comes_first_on_a_phone(chromium: Browser, pages: dict[str, Path]) -> None:
    chromium.open(pages["full"], PHONE, 844)
    assert (
        chromium.evaluate("document.querySelector('.banner').getBoundingClientRect().bottom") < 844
    )
    tops = (
        "['.banner', 'table', 'figure', 'dl'].map(s => "
        "document.querySelector(s).getBoundingClientRect().top)"
    )
    found = chromium.evaluate(tops)
    assert found == sorted(found)


def test_text_is_large_enough_to_be_read_on_a_phone(
    chromium: Browser, pages: dict[str, Path]
) -> None:
    """At least 12 px beside the plots, and 7 in them as they are scaled."""
    chromium.open(pages["full"], PHONE)
    sizes = """[...document.querySelectorAll('main *')].filter(e => !e.closest('svg')
        && [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim())
        && e.checkVisibility()).map(e => parseFloat(getComputedStyle(e).fontSize))"""
    assert min(chromium.evaluate(sizes)) >= 12.0
    chromium.call("Emulation.setEmulatedMedia", media="print")
    heights = (
        "[...document.querySelectorAll('figure svg text')].map(e => "
        "e.getBoundingClientRect()).map(b => Math.min(b.width, b.height))"
    )
    assert min(height for height in chromium.evaluate(heights) if height > 0) >= 3.0
    drawn = (
        "[...document.querySelectorAll('figure svg')].map(s => "
        "s.getBoundingClientRect().width / s.viewBox.baseVal.width)"
    )
    assert min(9.5 * 0.8 * scale for scale in chromium.evaluate(drawn)) >= 7.0
    chromium.call("Emulation.setEmulatedMedia", media="")


def test_it_prints(chromium: Browser, pages: dict[str, Path]) -> None:
    """Parts that are folded on the screen are open on paper, and no table is wider than it."""
    chromium.open(pages["several"], DESKTOP)
    printed = base64.b64decode(
        chromium.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"]
    )
    assert printed.startswith(b"%PDF")
    chromium.call("Emulation.setEmulatedMedia", media="print")
    chromium.call(
        "Emulation.setDeviceMetricsOverride",
        width=688,
        height=1000,
        deviceScaleFactor=1,
        mobile=False,
    )  # A4 less its margins
    folded = (
        "[...document.querySelectorAll('details.paper table, details.paper dl')].map(e => "
        "e.getBoundingClientRect().height)"
    )
    assert min(chromium.evaluate(folded)) > 0
    assert chromium.evaluate("document.documentElement.scrollWidth") <= 688


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("<img src='http://127.0.0.1:9/x.png'>", "requests"),
        ("<script>alert(1)</script>", "dialogs"),
        ("<script>console.log(1)</script>", "console"),
        ("<div style='width: 2000px'>wide</div>", "beyond"),
    ],
)
def test_what_a_page_must_not_do_would_be_seen(
    chromium: Browser, tmp_path: Path, body: str, told: str
) -> None:
    path = tmp_path / "bad.html"
    path.write_text(f"<!DOCTYPE html><title>bad</title><body>{body}", encoding="utf-8")
    seen = chromium.open(path, DESKTOP)
    if told == "beyond":
        assert chromium.evaluate(BEYOND.replace("WIDTH", str(DESKTOP))) == ["DIV "]
        chromium.open(path, PHONE)
        assert chromium.evaluate(BEYOND.replace("WIDTH", str(PHONE))) == ["DIV "]
    elif told == "requests":
        assert len(seen.requests) == 2
    else:
        assert getattr(seen, told)
