"""The page: self-contained, escaped, the same bytes again."""

from __future__ import annotations

import functools
import re

import msgspec
import numpy as np
import pytest

from frictool.documents.certificate import Bound, Box, Certificate, CertifiedWeights, Filter
from frictool.documents.controller import Controller, Margins
from frictool.documents.metric_table import HOLD_METRICS
from frictool.logs.log import Log, Stream
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
from tests.support.html_page import MADE, SVG_NAMESPACES, Page, without_own_scripts


def made(*logs: Log, controlled: Controller | None = None) -> str:
    spec = clutch_spec()
    transfers = None if controlled is None else sensitivities(controlled)
    return page(judge(spec, list(logs), controlled), MADE, transfers)


@functools.cache
def plain_page() -> str:
    """The page of a log without variants."""
    return made(clutch_log())


@functools.cache
def controlled_page() -> str:
    """The page of this log with its controller."""
    return made(clutch_log(), controlled=controller())


@pytest.fixture(name="full", scope="module")
def _full() -> str:
    return made(clutch_log(2), controlled=controller((0.7, 0.45, 0.6)))


@pytest.mark.accept  # tests/report/test_cli.py has a page twice
def test_the_same_inputs_give_the_same_bytes(full: str) -> None:
    assert made(clutch_log(2), controlled=controller((0.7, 0.45, 0.6))) == full


def test_the_verdict_comes_first_then_why_then_the_plots(full: str) -> None:
    assert "FAIL: 6 of 7 requirements met, 1 broken, on 3 recorded streams" in Page(full).text
    banner = full.index('<p class="banner broken">FAIL')
    sections = re.findall(r"<h2>(.*?)</h2>", full)
    assert banner < full.index("<h2>")
    assert sections[:4] == ["Requirements", "Curves", "Each step", "Every hold of every stream"]
    assert sections[4:] == ["Each stream as a whole", "Controller", "Definitions", "Provenance"]


def test_every_plot_is_there(full: str) -> None:
    labels = re.findall(r'<svg role="img" aria-label="([^"]*)"', full)
    assert labels == [
        "position over time",
        "load over time",
        "current over time",
        "velocity over time",
        "velocity over position",
        *(f"step {k} enlarged" for k in (1, 2, 3, 4)),
        "modulus margin of each vertex",
        *(
            f"transfer of the {name} at every vertex"
            for name in ("error", "drive", "disturbance", "output")
        ),
    ]


def test_nothing_is_fetched_and_nothing_runs(full: str) -> None:
    full = without_own_scripts(full)
    read = Page(full)
    assert not {"script", "iframe", "object", "embed", "link", "base", "form"} & set(read.tags)
    for name, value in read.attributes:
        assert not name.startswith("on")
        if name in ("src", "href", "xlink:href", "srcset", "action", "poster"):
            assert value.startswith(("#", "data:"))
    assert "@import" not in full
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", full))
    assert set(re.findall(r"https?://[^\"'\s<]*", full)) <= set(SVG_NAMESPACES)
    assert "default-src 'none'" in full


def test_ids_do_not_clash(full: str) -> None:
    """Where an id stands twice, it stands for the same drawing."""
    seen: dict[str, str] = {}
    for name, body in re.findall(r'<(?:path|clipPath) id="([^"]*)"(.*?)>', full, flags=re.DOTALL):
        assert seen.setdefault(name, body) == body


def test_the_vertices_and_the_provenance_are_listed(full: str) -> None:
    text = Page(full).text
    for part in (
        "v00",
        "v01",
        "v02",
        "0.45",
        "ab" * 32,
        MADE.command,
        "frictool simulate model.yaml",
    ):
        assert part in text
    headings = re.search(r"<th[^>]*>no\.</th>.*?</tr>", full)
    assert headings is not None
    assert re.findall(r"\[[^]]*\]", headings[0]) == ["[kg m²]", "[N m s/rad]", "[N m]", "[N m/A]"]


def test_text_from_logs_is_escaped() -> None:
    html = made(hostile_log(), controlled=msgspec.structs.replace(controller(), name=HOSTILE))
    assert "<script" not in without_own_scripts(html)
    assert HOSTILE in Page(html).text


def test_dollars_in_a_name_are_no_formula() -> None:
    assert "/axis/$x^{$" in made(
        Log((stream(), stream("/axis/$x^{$", damping=0.5)), {}, "run.mcap")
    )


def test_a_log_without_steps_has_a_page_with_reasons() -> None:
    html = made(smooth_log())
    assert "<h2>Each step</h2>" not in html
    assert "no step" in html
    assert "position difference over" in html.lower()


def test_logs_laid_over_each_other_have_their_own_colours() -> None:
    html = made(clutch_log(), Log((stream(damping=0.6),), {}, "bench.mcap"))
    table = html[html.index("The logs side by side") :]
    cell = r"<td class=\"n\"[^>]*>"
    assert re.search(
        rf"<td>streams that meet all requirements</td>{cell}1 of 1</td>{cell}0 of 1</td>",
        table,
    )
    assert re.search(rf"<td>overshoot \[%\]</td>{cell}[12]\.\d+</td>{cell}9\.\d+</td>", table)
    legend = re.findall(r'stroke="(#[0-9a-f]{6})" stroke-width="2.4"/></svg>([^<]*)<', html)
    assert [name for _, name in legend] == ["run.mcap", "bench.mcap"]
    colours = {colour for colour, _ in legend}
    assert len(colours) == 2
    assert all(html.count(f'stroke="{colour}"') >= 4 for colour in colours)


def test_a_log_with_next_to_nothing_still_has_a_page() -> None:
    bare = stream(without=("position", "reference", "velocity", "current", "command"))
    assert "neither a position nor a drive" in made(Log((bare,), {}, "run.mcap"))


def test_a_pass_with_something_undecided_is_not_shown_as_a_plain_pass() -> None:
    assert '<p class="banner open">UNDECIDED: 6 of 7' in plain_page()
    assert '<p class="banner met">PASS: 7 of 7' in controlled_page()


@pytest.mark.parametrize("samples", [1, 2, 30])
def test_the_shortest_logs_have_a_page(samples: int) -> None:
    whole = stream()
    cut = Stream(
        "/axis",
        whole.time[:samples],
        {n: v[:samples] for n, v in whole.signals.items() if n != "velocity"},
        whole.units,
    )
    assert made(Log((cut,), {}, "short.mcap")).count('<svg role="img"') >= 2


@pytest.mark.parametrize("value", [np.nan, np.inf, -1e300])
def test_broken_samples_do_not_break_the_page(value: float) -> None:
    broken = stream(without=("velocity",))
    for signal in ("position", "current", "reference"):
        broken.signals[signal][1000:1010] = value
    assert "<h2>Curves</h2>" in made(Log((broken,), {}, "broken.mcap"))


def test_a_broken_requirement_is_said_under_the_verdict_with_its_place() -> None:
    text = " ".join(Page(made(Log((stream(damping=0.5),), {}, "run.mcap"))).text.split())
    assert re.search(
        r"overshoot 16\.\d+ % where ≤ 5 % is required: run\.mcap /axis, step \d at [\d.]+ s", text
    )
    assert "Undecided: modulus margin; the table says why" in text


def test_the_templates_of_a_controller_with_weights_are_drawn_and_their_shares_said() -> None:
    weights = CertifiedWeights(Filter(31.5, 40.0, 0.63), 0.03, 0.5)
    html = made(clutch_log(), controlled=msgspec.structs.replace(controller(), weights=weights))
    assert html.count("Dashed: the template γ/") == 3
    assert html.count("no template") == 0
    assert "ω<sub>c</sub>" in html
    assert controlled_page().count("no template") == 3


def test_every_metric_that_is_shown_is_defined() -> None:
    text = Page(controlled_page()).text
    for metric in HOLD_METRICS.values():
        assert (metric.title in text) == (metric.definition in text)
    assert text.count("of a sustained oscillation over its last period") == 1
    assert (
        "energy in 0.22 s [A²]" in text
    )  # t_int: the response time allowed, where the specification has no energy


def test_what_one_count_asks_for_and_what_the_certificate_states_are_shown() -> None:
    box = Box(inertia=(1e-5, 2e-5), viscous=(0.0, 1e-3), coulomb=(0.1, 0.1), constant=(0.01, 0.02))
    bounds = tuple(Bound(of, below) for of, below in (("norm", 1.98), ("sensitivity", 1.6)))
    certificate = Certificate(2, box, CertifiedWeights(Filter(1.0), 0.0, 0.0), bounds)
    verified = msgspec.structs.replace(
        controller().verified, count_drive=17.5, margins=Margins(small_gain=100.0, phase_deg=50.0)
    )
    html = made(
        clutch_log(),
        controlled=msgspec.structs.replace(
            controller(), verified=verified, certificate=certificate
        ),
    )
    assert "one count changes the drive by up to 17.5 A, 35 % of the limit" in html
    assert "gain × 0 to any, phase 50°" in html
    assert "states norm &lt; 1.98, modulus margin &gt; 0.6250, for every constant plant" in html
