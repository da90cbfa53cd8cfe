"""Figures as `<svg>` elements: XML whatever their label says, the same bytes whatever the user's
own settings say."""

from __future__ import annotations

from xml.etree import ElementTree

import matplotlib as mpl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.presentation.plot import FigureMargins
from frictool.presentation.svg import drawing, panels, render

MARGINS = FigureMargins(left=0.8, right=0.1, bottom=0.5, top=0.2, label=0.1)


def drawn(label: str) -> str:
    with drawing("test"):
        figure, (upper, lower) = panels((3.0, 2.0), MARGINS, 2, ratios=[2.0, 1.0])
        upper.plot([0.0, 1.0], [2.0, 3.0])
        lower.set_xlabel("time, s")
        return render(figure, label)


@settings(max_examples=10, deadline=None)
@given(st.text(max_size=20))
def test_a_label_is_told_as_it_is(label: str) -> None:
    said = ElementTree.fromstring(drawn(f"{label} \"<&>'")).attrib["aria-label"]
    assert said == "".join(c for c in label if c.isprintable()) + " \"<&>'"


def test_settings_of_the_user_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    before = drawn("a")
    for name, value in (
        ("font.size", 20.0),
        ("axes.grid", False),
        ("svg.fonttype", "path"),
        ("lines.linewidth", 9.0),
    ):
        monkeypatch.setitem(mpl.rcParams, name, value)
    assert drawn("a") == before
